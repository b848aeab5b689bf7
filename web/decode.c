/* Samples of a .cvol file, for the package of npm: web/npm/index.mjs calls these functions. One
 * file is open at a time. */
#include <emscripten.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "cvol/cvol.h"

static struct {
    cvol_context *context;
    cvol_array *array;
    cvol_file_report report;
    char *described;
    void *samples; /* of the last box */
} open_file;

EMSCRIPTEN_KEEPALIVE void decode_close(void)
{
    cvol_array_free(open_file.array);
    free(open_file.described);
    free(open_file.samples);
    open_file.array = NULL;
    open_file.described = NULL;
    open_file.samples = NULL;
}

/* Opens one volume of a file at a level; "", or the sentence of a failure. */
EMSCRIPTEN_KEEPALIVE const char *decode_open(const char *path, int time, int channel, int level)
{
    const cvol_file_part part = {
        .size = sizeof part, .level = level, .cut = level > 0, .time = time, .channel = channel};
    decode_close();
    if (!open_file.context && !(open_file.context = cvol_context_create()))
        return "not enough memory";
    cvol_context_set_threads(open_file.context, 1);
    return cvol_array_read_part(open_file.context, &open_file.array, &open_file.report, path, &part)
               ? cvol_context_message(open_file.context)
               : "";
}

static json_t *numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_real(values[i]));
    return list;
}

/* The volume as JSON; NULL without memory. The text stays until the file is closed. */
EMSCRIPTEN_KEEPALIVE const char *decode_describe(void)
{
    const cvol_grid *grid = cvol_array_grid(open_file.array);
    cvol_array_info info;
    cvol_array_get_info(&info, open_file.array);
    json_t *dims = json_array(), *object = json_object();
    for (int a = 0; a < 3; a++)
        json_array_append_new(dims, json_integer((json_int_t)grid->dims[a]));
    json_object_set_new(object, "shape", dims);
    json_object_set_new(object, "type", json_string(cvol_type_name(grid->type)));
    json_object_set_new(object, "spacing", numbers(grid->spacing, 3));
    json_object_set_new(object, "origin", numbers(grid->origin, 3));
    json_object_set_new(object, "directions", numbers(&grid->direction[0][0], 9));
    json_object_set_new(object, "unit", json_string(grid->unit));
    json_object_set_new(object, "level", json_integer(open_file.report.level));
    json_object_set_new(object, "psnr",
                        isfinite(info.psnr_db) ? json_real(info.psnr_db) : json_null());
    json_object_set_new(object, "maxError", json_real(info.max_error));
    json_object_set_new(object, "l2Error", json_real(info.l2_error));
    free(open_file.described);
    open_file.described = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(object);
    return open_file.described;
}

/* A sample of the level: the mean of the samples of its cell that have a value. Without one it is
 * the first sample, a fill. is_void: 1 for samples without a value. */
static double mean_of(const float *samples, const uint8_t *is_void, const size_t size[3],
                      const size_t begin[3], size_t factor)
{
    double sum = 0;
    size_t end[3], count = 0;
    for (int a = 0; a < 3; a++)
        end[a] = begin[a] + factor < size[a] ? begin[a] + factor : size[a];
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            for (size_t x = begin[0]; x < end[0]; x++) {
                const size_t i = x + size[0] * (y + size[1] * z);
                sum += is_void[i] ? 0 : (double)samples[i];
                count += !is_void[i];
            }
    return count ? sum / (double)count
                 : (double)samples[begin[0] + size[0] * (begin[1] + size[1] * begin[2])];
}

static void store(void *out, cvol_type type, size_t i, double value)
{
    static const double limits[][2] = {{0, 255},          {-128, 127},
                                       {0, 65535},        {-32768, 32767},
                                       {0, 4294967295.0}, {-2147483648.0, 2147483647}};
    if (type < CVOL_FLOAT32) {
        value = fmin(fmax(rint(value), limits[type - 1][0]), limits[type - 1][1]);
        const int64_t whole = (int64_t)value;
        memcpy((char *)out + i * cvol_type_size(type), &whole, cvol_type_size(type));
    } else if (type == CVOL_FLOAT32) {
        ((float *)out)[i] = (float)value;
    } else {
        ((double *)out)[i] = value;
    }
}

/* The means of cells of `factor` samples of a box, from the lowest frequencies. A code. */
static int evaluate_means(void *out, const size_t begin[3], const size_t end[3], size_t factor)
{
    const size_t *dims = cvol_array_grid(open_file.array)->dims;
    size_t size[3], cells[3], from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = begin[a] * factor;
        to[a] = end[a] * factor < dims[a] ? end[a] * factor : dims[a];
        size[a] = to[a] - from[a];
        cells[a] = end[a] - begin[a];
    }
    size_t count;
    const int fits = cvol_size_multiply(&count, size[0], size[1] * factor);
    float *samples = fits ? cvol_allocate(count, sizeof *samples) : NULL;
    uint8_t *is_void = fits ? cvol_allocate(count, 1) : NULL;
    int code = samples && is_void ? CVOL_OK
                                  : cvol_fail(open_file.context, CVOL_ERROR_MEMORY,
                                              "not enough memory for a layer of samples");
    for (size_t z = 0; z < cells[2] && !code; z++) {
        const size_t first[3] = {from[0], from[1], from[2] + z * factor};
        const size_t last[3] = {to[0], to[1],
                                first[2] + factor < to[2] ? first[2] + factor : to[2]};
        const size_t layer[3] = {size[0], size[1], last[2] - first[2]};
        code = cvol_array_evaluate_real(open_file.context, samples, open_file.array, first, last);
        if (!code)
            cvol_array_evaluate_mask(is_void, open_file.array, first, last);
        for (size_t i = 0; i < cells[0] * cells[1] && !code; i++) {
            const size_t at[3] = {i % cells[0] * factor, i / cells[0] * factor, 0};
            store(out, cvol_array_grid(open_file.array)->type, i + cells[0] * cells[1] * z,
                  mean_of(samples, is_void, layer, at, factor));
        }
    }
    free(samples);
    free(is_void);
    return code;
}

/* Decodes a box of the level, x fastest; "", or the sentence of a failure. */
EMSCRIPTEN_KEEPALIVE const char *decode_box(int x0, int y0, int z0, int x1, int y1, int z1)
{
    const cvol_grid *grid = cvol_array_grid(open_file.array);
    const size_t factor = (size_t)1 << open_file.report.level;
    const int from[3] = {x0, y0, z0}, to[3] = {x1, y1, z1};
    size_t begin[3], end[3], count = 1;
    for (int a = 0; a < 3; a++) {
        const int most = (int)((grid->dims[a] + factor - 1) / factor);
        if (from[a] < 0 || from[a] >= to[a] || to[a] > most) {
            cvol_fail(open_file.context, CVOL_ERROR_ARGUMENT,
                      "box %d .. %d on axis %c does not lie within 0 .. %d", from[a], to[a],
                      "xyz"[a], most);
            return cvol_context_message(open_file.context);
        }
        begin[a] = (size_t)from[a];
        end[a] = (size_t)to[a];
        count *= end[a] - begin[a];
    }
    free(open_file.samples);
    open_file.samples = cvol_allocate(count, cvol_type_size(grid->type));
    int code = open_file.samples ? CVOL_OK
                                 : cvol_fail(open_file.context, CVOL_ERROR_MEMORY,
                                             "not enough memory for %zu samples", count);
    if (!code)
        code = factor > 1 ? evaluate_means(open_file.samples, begin, end, factor)
                          : cvol_array_evaluate_box(open_file.context, open_file.samples,
                                                    open_file.array, begin, end);
    return code ? cvol_context_message(open_file.context) : "";
}

EMSCRIPTEN_KEEPALIVE const void *decode_samples(void)
{
    return open_file.samples;
}
