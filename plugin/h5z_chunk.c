/* A chunk of a dataset as a compressed volume: parameters, and conversion of samples to bytes and
 * back. Independent of HDF5. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/transfer.h"
#include "h5z_cvol.h"

__attribute__((format(printf, 3, 4))) static int set_message(char *message, size_t message_bytes,
                                                             const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, message_bytes, format, arguments);
    va_end(arguments);
    return 0;
}

/* ---- parameters ------------------------------------------------------------------------ */

void cvol_h5z_put_value(unsigned words[CVOL_H5Z_WORDS], double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    words[CVOL_H5Z_LOW] = (unsigned)(bits & 0xffffffff);
    words[CVOL_H5Z_HIGH] = (unsigned)(bits >> 32);
}

static double value_of(const unsigned *words, size_t count)
{
    if (count <= CVOL_H5Z_LOW)
        return 0;
    if (count == CVOL_H5Z_HIGH)
        return words[CVOL_H5Z_LOW];
    const uint64_t bits = words[CVOL_H5Z_LOW] | (uint64_t)words[CVOL_H5Z_HIGH] << 32;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

int cvol_h5z_read_options(cvol_compress_options *options, const unsigned *words, size_t count,
                          char *message, size_t message_bytes)
{
    *options = cvol_compress_options_defaults();
    options->no_histogram = 1; /* chunks are never drawn by themselves */
    options->background = CVOL_BACKGROUND_FIND;
    if (count == 0)
        return 1;
    const unsigned mode = words[CVOL_H5Z_MODE];
    const double value = value_of(words, count);
    if (mode == CVOL_H5Z_LOSSLESS) {
        options->lossless = 1;
        return 1;
    }
    if (mode < CVOL_TARGET_RATIO || mode > CVOL_TARGET_BITS)
        return set_message(
            message, message_bytes,
            "cvol: mode is %u, must be 1 (ratio), 2 (PSNR), 3 (largest error), 4 (bits per "
            "sample) or 5 (lossless)",
            mode);
    if (!isfinite(value) || value < 0 || (value <= 0 && mode != CVOL_TARGET_MAX_ERROR))
        return set_message(message, message_bytes, "cvol: value is %g, must be a number above 0",
                           value);
    options->target = (cvol_target)mode;
    options->target_value = value;
    return 1;
}

static int machine_is_big_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 0;
}

int cvol_h5z_read_plan(cvol_h5z_plan *plan, const unsigned *words, size_t count, char *message,
                       size_t message_bytes)
{
    if (count < CVOL_H5Z_WORDS || words[CVOL_H5Z_LAYOUT] != CVOL_H5Z_LAYOUT_1)
        return set_message(message, message_bytes,
                           "cvol: the filter has %zu parameters, which do not match layout %d",
                           count, CVOL_H5Z_LAYOUT_1);
    const unsigned type = words[CVOL_H5Z_TYPE], order = words[CVOL_H5Z_ORDER];
    if (type > CVOL_FLOAT64 || !cvol_type_size((cvol_type)type) || order > 1)
        return set_message(message, message_bytes,
                           "cvol: the filter has invalid type %u or byte order %u", type, order);
    plan->grid = cvol_grid_make(words[CVOL_H5Z_NX], words[CVOL_H5Z_NY], words[CVOL_H5Z_NZ],
                                (cvol_type)type);
    plan->bytes = cvol_type_size((cvol_type)type);
    for (int a = 0; a < 3; a++) /* HDF5 chunks are smaller than this */
        if (!plan->grid.dims[a] || plan->grid.dims[a] > UINT32_MAX / plan->bytes)
            return set_message(message, message_bytes,
                               "cvol: the filter has an invalid chunk of %u x %u x %u samples",
                               words[CVOL_H5Z_NX], words[CVOL_H5Z_NY], words[CVOL_H5Z_NZ]);
        else
            plan->bytes *= plan->grid.dims[a];
    plan->swaps = (int)order != machine_is_big_endian();
    return cvol_h5z_read_options(&plan->options, words, CVOL_H5Z_LAYOUT, message, message_bytes);
}

/* ---- samples --------------------------------------------------------------------------- */

static void swap(uint8_t *bytes, size_t size, size_t each)
{
    for (size_t at = 0; at + each <= size; at += each)
        for (size_t i = 0; i < each / 2; i++) {
            const uint8_t low = bytes[at + i];
            bytes[at + i] = bytes[at + each - 1 - i];
            bytes[at + each - 1 - i] = low;
        }
}

/* 1 if a sample is NaN or infinite. */
static int has_holes(const void *samples, const cvol_grid *grid)
{
    const size_t count = cvol_grid_samples(grid);
    const float *single = samples;
    const double *twice = samples;
    for (size_t i = 0; i < count; i++)
        if (grid->type == CVOL_FLOAT32   ? !isfinite(single[i])
            : grid->type == CVOL_FLOAT64 ? !isfinite(twice[i])
                                         : 0)
            return 1;
    return 0;
}

/* Samples of a value far from all others, such as the fill value of netCDF, have no value, nor have
 * NaN and infinite ones. Lossless chunks need no fill. */
static int choose_fill(cvol_context *context, cvol_compress_options *options,
                       const cvol_volume *chunk)
{
    cvol_histogram histogram;
    if (options->lossless)
        return CVOL_OK;
    const int code = cvol_volume_compute_histogram(context, &histogram, chunk);
    if (!code && (histogram.mark_count || has_holes(chunk->data, &chunk->grid))) {
        options->has_fill = 1;
        options->fill = histogram.mark_count ? histogram.mark : (double)NAN;
    }
    return code;
}

/* One thread: after a fork, as in workers of Python, there are no others. */
static cvol_context *context_of_one_thread(void)
{
    cvol_context *context = cvol_context_create();
    if (context)
        cvol_context_set_threads(context, 1);
    return context;
}

static int end_chunk(cvol_context *context, int code, char *message, size_t message_bytes)
{
    if (code)
        set_message(message, message_bytes, "%s",
                    context ? cvol_context_message(context) : "cvol: not enough memory");
    cvol_context_free(context);
    return !code;
}

int cvol_h5z_encode(void **out, size_t *size, const cvol_h5z_plan *plan, const void *samples,
                    char *message, size_t message_bytes)
{
    cvol_context *context = context_of_one_thread();
    cvol_compress_options options = plan->options;
    cvol_array *array = NULL;
    void *copy = NULL;
    int code = context ? CVOL_OK : CVOL_ERROR_MEMORY;
    *out = NULL;
    if (!code) { /* aligned, and in the byte order of the machine */
        copy = malloc(plan->bytes);
        if (!copy) {
            cvol_context_free(context);
            return set_message(message, message_bytes,
                               "cvol: not enough memory for a chunk of %zu bytes", plan->bytes);
        }
        memcpy(copy, samples, plan->bytes);
        if (plan->swaps)
            swap(copy, plan->bytes, cvol_type_size(plan->grid.type));
        code = choose_fill(context, &options, &(cvol_volume){plan->grid, copy});
        if (!code)
            code = cvol_compress(context, &array, NULL, copy, &plan->grid, &options);
    }
    if (!code)
        code = cvol_array_write_memory(context, array, out, size);
    cvol_array_free(array);
    free(copy);
    return end_chunk(context, code, message, message_bytes);
}

static int check_grid(const cvol_array *array, const cvol_grid *wanted, char *message,
                      size_t message_bytes)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t *is = grid->dims, *must = wanted->dims;
    if (!memcmp(is, must, sizeof grid->dims) && grid->type == wanted->type)
        return 1;
    return set_message(
        message, message_bytes,
        "cvol: a chunk is %zu x %zu x %zu samples of %s, must be %zu x %zu x %zu of %s", is[0],
        is[1], is[2], cvol_type_name(grid->type), must[0], must[1], must[2],
        cvol_type_name(wanted->type));
}

int cvol_h5z_decode(void **out, const cvol_h5z_plan *plan, const void *data, size_t size,
                    char *message, size_t message_bytes)
{
    cvol_context *context = context_of_one_thread();
    cvol_array *array = NULL;
    const size_t begin[3] = {0, 0, 0};
    *out = NULL;
    if (context)
        cvol_context_set_limit_bytes(context, plan->bytes);
    int code = context ? cvol_array_read_memory(context, &array, data, size, "cvol: a chunk")
                       : CVOL_ERROR_MEMORY;
    if (!code && !check_grid(array, &plan->grid, message, message_bytes)) {
        cvol_array_free(array);
        cvol_context_free(context);
        return 0;
    }
    void *samples = code ? NULL : malloc(plan->bytes);
    if (!code && !samples) {
        cvol_array_free(array);
        cvol_context_free(context);
        return set_message(message, message_bytes,
                           "cvol: not enough memory for a chunk of %zu bytes", plan->bytes);
    }
    if (!code)
        code = cvol_array_evaluate_box(context, samples, array, begin, plan->grid.dims);
    if (!code && plan->swaps)
        swap(samples, plan->bytes, cvol_type_size(plan->grid.type));
    if (code)
        free(samples);
    else
        *out = samples;
    cvol_array_free(array);
    return end_chunk(context, code, message, message_bytes);
}
