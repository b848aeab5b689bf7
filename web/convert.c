/* Makes a .cvol file from a file of another format, or from the DICOM files of a folder: like cvol
 * compress --fast, with effort fast and ratio 30, or 35 dB if that leaves less than 25. JavaScript
 * calls it in a worker of its own, whose memory ends with it. */
#define _POSIX_C_SOURCE 200809L
#include <emscripten.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "cvol/cvol.h"
#include "volume/formats/dicom/series.h"
#include "volume/formats/zarr/labels.h"
#include "volume/io/format.h"
#include "volume/io/module.h"

static struct {
    char message[1024];
    char *list;         /* of series */
    const char *series; /* that is read, or NULL: the only one */
    int done, count;    /* volumes of the file */
} state = {.count = 1};

/* A page gets files, and folders of DICOM files. */
const cvol_format cvol_format_zarr = {
    .name = "Zarr", .endings = {".zarr"}, .lacks = "a reader of it"};
static int is_no_folder(const char *path)
{
    (void)path;
    return 0;
}

const cvol_format cvol_format_pictures = {
    .name = "folder of pictures", .lacks = "a reader of it", .recognise_folder = is_no_folder};

int cvol_zarr_find_label_mark(cvol_context *context, int *out, const char *path)
{
    (void)context, (void)path;
    *out = 0;
    return CVOL_OK;
}

/* There are no modules in a page. */
void *cvol_module_find(const char *module, const char *symbol)
{
    (void)module, (void)symbol;
    return NULL;
}

EM_JS(void, report, (const char *what, double fraction), {
    if (Module.onProgress)
        Module.onProgress(UTF8ToString(what), fraction);
});

static int on_progress(void *user, const char *what, double fraction)
{
    (void)user;
    report(what ? what : "", (state.done + fraction) / state.count);
    return 0;
}

static cvol_read_options read_options(void)
{
    cvol_read_options read = cvol_read_options_defaults();
    read.series = state.series;
    return read;
}

/* As tools/base/cli.h has them. */
#define LEAST_PSNR_DB 25
#define PSNR_INSTEAD_DB 35

/* Labels stay exact; samples of a value far from all others count as missing. */
static int compress(cvol_context *context, cvol_array **out, cvol_volume *volume, const char *path)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_histogram histogram;
    int code = cvol_volume_compute_histogram(context, &histogram, volume);
    if (code)
        return code;
    options.background = CVOL_BACKGROUND_FIND;
    options.effort = CVOL_EFFORT_FAST;
    options.has_fill = histogram.mark_count > 0;
    options.fill = histogram.mark;
    if (!options.has_fill)
        code = cvol_volume_compute_is_labels(context, &options.lossless, volume, path);
    if (code)
        return code;
    options.least_psnr = LEAST_PSNR_DB;
    code = cvol_compress(context, out, NULL, volume->data, &volume->grid, &options);
    if (code != CVOL_ERROR_TARGET)
        return code;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = PSNR_INSTEAD_DB;
    return cvol_compress(context, out, NULL, volume->data, &volume->grid, &options);
}

/* Reads and compresses a volume. */
static int make(cvol_context *context, cvol_array **out, const char *path,
                const cvol_read_options *read)
{
    cvol_volume *volume = NULL;
    int code = cvol_volume_read(context, &volume, path, read);
    if (!code)
        code = compress(context, out, volume, path);
    cvol_volume_free(volume);
    return code;
}

/* ---- series -----------------------------------------------------------------------------------
 */

/* What a file says about its times and channels. */
typedef struct series_labels {
    cvol_series_options options;
    char (*names)[CVOL_CHANNEL_NAME_BYTES];
    const char **name_list;
    double *colours, *values;
    char unit[CVOL_TIME_UNIT_BYTES];
} series_labels;

static void free_labels(series_labels *l)
{
    free(l->names);
    free(l->name_list);
    free(l->colours);
    free(l->values);
}

static void fill_labels(series_labels *l, const cvol_volume_stream *stream, int times, int channels)
{
    const char *unit;
    const double step = cvol_volume_stream_time_step(stream, &unit);
    snprintf(l->unit, sizeof l->unit, "%s", unit);
    for (int t = 0; t < times; t++)
        l->values[t] = t * step;
    for (int c = 0; c < channels; c++) {
        const char *name = cvol_volume_stream_channel_name(stream, c);
        snprintf(l->names[c], sizeof l->names[c], "%s", name);
        l->name_list[c] = l->names[c];
        cvol_series_get_default_colour(l->colours + 3 * c, c, channels);
        cvol_volume_stream_get_channel_colour(l->colours + 3 * c, stream, c);
    }
    l->options.times = times;
    l->options.channels = channels;
    l->options.time_values = step > 0 ? l->values : NULL;
    l->options.time_unit = l->unit;
    l->options.channel_names = l->name_list;
    l->options.channel_colours = l->colours;
    l->options.colours = channels > 1 && cvol_volume_stream_has_colours(stream);
}

/* first: chooses the first volume. The caller frees *out, after a failure too. */
static int read_labels(cvol_context *context, series_labels *out, const char *path,
                       const cvol_read_options *first, int times, int channels)
{
    cvol_volume_stream *stream = NULL;
    *out = (series_labels){.options = cvol_series_options_defaults()};
    out->names = calloc((size_t)channels, sizeof *out->names);
    out->name_list = calloc((size_t)channels, sizeof *out->name_list);
    out->colours = calloc((size_t)channels, 3 * sizeof *out->colours);
    out->values = calloc((size_t)times, sizeof *out->values);
    if (!out->names || !out->name_list || !out->colours || !out->values)
        return cvol_fail_memory(context, (size_t)channels + (size_t)times, path);
    const int code = cvol_volume_stream_open(context, &stream, path, first);
    if (!code)
        fill_labels(out, stream, times, channels);
    cvol_volume_stream_free(stream);
    return code;
}

static int convert_series(cvol_context *context, const char *path, const char *out, int times,
                          int channels)
{
    cvol_read_options read = read_options();
    cvol_series_writer *writer = NULL;
    series_labels labels;
    read.has_index = times > 1;
    read.has_channel = channels > 1;
    state.count = times * channels;
    int code = read_labels(context, &labels, path, &read, times, channels);
    if (!code)
        code = cvol_series_writer_open(context, &writer, out, &labels.options);
    for (int i = 0; !code && i < state.count; i++) {
        cvol_array *array = NULL;
        state.done = i;
        read.index = i / channels;
        read.channel = i % channels;
        code = make(context, &array, path, &read);
        if (!code)
            code = cvol_series_add(context, writer, array, NULL);
        cvol_array_free(array);
    }
    free_labels(&labels);
    if (code) {
        cvol_series_writer_abandon(writer);
        return code;
    }
    return cvol_series_writer_commit(context, writer, NULL);
}

/* ---- files ------------------------------------------------------------------------------------
 */

static int convert_one(cvol_context *context, const char *path, const char *out)
{
    const cvol_read_options read = read_options();
    cvol_array *array = NULL;
    int code = make(context, &array, path, &read);
    if (!code)
        code = cvol_array_write(context, array, out, NULL);
    cvol_array_free(array);
    return code;
}

static int is_hdf5(const char *path)
{
    static const char signature[8] = "\211HDF\r\n\032\n";
    char head[8] = {0};
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(head, 1, sizeof head, file) : 0;
    if (file)
        fclose(file);
    return got == sizeof head && !memcmp(head, signature, sizeof head);
}

static int convert(cvol_context *context, const char *path, const char *out)
{
    const cvol_read_options read = read_options();
    int times, channels;
    if (is_hdf5(path))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is an HDF5 file, which a page does not read: run cvol compress %s, "
                         "and open the .cvol file here",
                         path, path);
    if (!cvol_file_is_volume(path))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: is not a volume in a format that this page reads", path);
    const int code = cvol_file_count_volumes(context, &times, &channels, path, &read);
    if (code)
        return code;
    return times > 1 || channels > 1 ? convert_series(context, path, out, times, channels)
                                     : convert_one(context, path, out);
}

/* The series of a folder of DICOM files: key, description and number of slices, separated by the
 * ASCII characters for units and records. "": they cannot be read; convert_file says why. */
EMSCRIPTEN_KEEPALIVE const char *convert_list_series(const char *path)
{
    cvol_context *context = cvol_context_create();
    cvol_dicom_series series = {.count = 0};
    size_t first, size, at = 0;
    FILE *out = open_memstream(&state.list, &size);
    if (context && out && !cvol_dicom_series_list(context, &series, path, &first)) {
        cvol_dicom_summary one;
        while (cvol_dicom_series_next(&series, &at, &one))
            fprintf(out, "%s\037%s\037%llu\036", one.key, one.description,
                    (unsigned long long)one.frames);
    }
    if (out)
        fclose(out);
    cvol_dicom_series_close(&series);
    cvol_context_free(context);
    return state.list ? state.list : "";
}

/* Converts a file, or a folder of DICOM files, to the file `out`. series: the key of one of them;
 * "": there is only one. The sentence of a failure; "": it is there. */
EMSCRIPTEN_KEEPALIVE const char *convert_file(const char *path, const char *series, const char *out)
{
    cvol_context *context = cvol_context_create();
    if (!context)
        return "not enough memory";
    state.series = series[0] ? series : NULL;
    cvol_context_set_threads(context, 1);
    cvol_context_set_progress(context, on_progress, NULL);
    const int code = convert(context, path, out);
    const char *message = cvol_context_message(context);
    /* The command has more libraries, and one names a grid to it. */
    if (code && (strstr(message, "built without") || strstr(message, "name one behind a colon")))
        snprintf(state.message, sizeof state.message,
                 "%s; try cvol compress %s, and open the .cvol file here", message, path);
    else if (code)
        snprintf(state.message, sizeof state.message, "%s", message);
    cvol_context_free(context);
    return state.message;
}
