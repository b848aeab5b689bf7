/* The table of formats; reading and writing volumes with it, by slab or whole. */
#define _GNU_SOURCE
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/c_locale.h"
#include "base/context.h"
#include "base/file.h"
#include "base/grid.h"
#include "base/options.h"
#include "volume/formats/analyze.h"
#include "volume/io/dense.h"
#include "volume/io/folder.h"
#include "volume/io/input.h"
#include "volume/io/stream.h"
#include "volume/io/text.h"

/* Bytes between two reports of progress. */
#define READ_STEP_BYTES ((size_t)8 << 20)
#define WRITE_STEP_BYTES ((size_t)1 << 20)

static const cvol_format *const formats[] = {
    &cvol_format_nrrd,    &cvol_format_nifti, &cvol_format_metaimage, &cvol_format_tiff,
    &cvol_format_dicom,   &cvol_format_npy,   &cvol_format_mrc,       &cvol_format_vtk,
    &cvol_format_vti,     &cvol_format_hdf5,  &cvol_format_zarr,      &cvol_format_mgh,
    &cvol_format_analyze, &cvol_format_vdb,   &cvol_format_matlab,    &cvol_format_pictures,
    &cvol_format_raw,
};

#define FORMATS (sizeof formats / sizeof formats[0])

const char *cvol_volume_formats(void)
{
    return ".nrrd .nhdr .nii .nii.gz .mha .mhd .raw .tif .tiff .npy .vti .zarr .mrc .mgz .mgh .h5";
}

const char *cvol_volume_readers(void)
{
    return ".nrrd .nhdr .nii .nii.gz .mha .mhd .raw"
#ifdef CVOL_HAVE_TIFF
           " .tif"
#endif
           " .dcm .npy .mrc .mgz .vtk .vti .vdb .mat .zarr"
#ifdef CVOL_HAVE_HDF5
           " .h5 .mnc"
#endif
        ;
}

/* `options` may be NULL. */
static int complete(cvol_context *context, cvol_read_options *out, const cvol_read_options *options)
{
    cvol_read_options_set_defaults(out, sizeof *out);
    return options ? cvol_options_copy(context, out, sizeof *out,
                                       CVOL_SIZE_TO(cvol_read_options, series), "cvol_read_options",
                                       options)
                   : CVOL_OK;
}

static const cvol_format *format_of_name(const char *path)
{
    for (size_t f = 0; f < FORMATS; f++)
        for (int e = 0; e < 4 && formats[f]->endings[e]; e++)
            if (cvol_text_ends(path, formats[f]->endings[e]))
                return formats[f];
    return NULL;
}

/* 1 if path[0 .. length) ends in `ending`, but is more than that. */
static int part_ends(const char *path, size_t length, const char *ending)
{
    const size_t size = strlen(ending);
    return length > size && !strncasecmp(path + length - size, ending, size);
}

/* The format of FILE in FILE:NAME, if such names are written; *length: that of FILE. NULL: the path
 * is none of these. */
static const cvol_format *format_of_named(size_t *length, const char *path)
{
    for (const char *colon = strchr(path, ':'); colon; colon = strchr(colon + 1, ':'))
        for (size_t f = 0; f < FORMATS; f++)
            for (int e = 0; e < 4 && formats[f]->endings[e] && formats[f]->writes_name; e++)
                if (part_ends(path, (size_t)(colon - path), formats[f]->endings[e])) {
                    *length = (size_t)(colon - path);
                    return formats[f];
                }
    return NULL;
}

size_t cvol_volume_writer_file_length(const char *path)
{
    size_t length = strlen(path);
    if (!format_of_name(path))
        format_of_named(&length, path);
    return length;
}

static int find_format(cvol_context *context, const cvol_format **out, const char *path);

/* A folder that is no format by itself has the format of its first file whose format can be in a
 * folder. Pictures are slices only in a folder without other volumes: beside one, a picture is
 * probably its preview. If no file has a format, an unreadable one may be the reason. */
static int find_format_of_folder(cvol_context *context, const cvol_format **out, const char *path)
{
    cvol_folder folder;
    int has_volumes = 0;
    char unreadable[CVOL_MESSAGE_BYTES] = ""; /* the first message */
    *out = NULL;
    for (size_t f = 0; f < FORMATS && !*out; f++)
        if (formats[f] != &cvol_format_pictures && formats[f]->recognise_folder &&
            formats[f]->recognise_folder(path))
            *out = formats[f];
    if (*out)
        return CVOL_OK;
    int code = cvol_folder_open(context, &folder, path);
    for (size_t i = 0; !code && !*out && i < folder.count; i++) {
        const int failed = find_format(context, out, folder.paths[i]);
        if (failed == CVOL_ERROR_IO && !unreadable[0])
            memcpy(unreadable, context->message, sizeof unreadable);
        if (failed || (*out && !(*out)->takes_folder)) {
            has_volumes = has_volumes || (*out && !(*out)->needs_options);
            *out = NULL;
        }
    }
    cvol_folder_close(&folder);
    if (!code && !*out && !has_volumes && cvol_format_pictures.recognise_folder(path))
        *out = &cvol_format_pictures;
    if (!code && !*out)
        code = unreadable[0]
                   ? cvol_fail(context, CVOL_ERROR_IO, "%s", unreadable)
                   : cvol_fail(context, CVOL_ERROR_IO,
                               "%s: is a directory without slices (TIFF, DICOM, PNG, JPEG)", path);
    return code;
}

/* The file's first bytes decide; only if they do not, its name does. */
static int find_format(cvol_context *context, const cvol_format **out, const char *path)
{
    uint8_t head[CVOL_FORMAT_HEAD_BYTES];
    size_t size;
    int is_folder, code = cvol_folder_check(context, &is_folder, path);
    *out = NULL;
    if (code)
        return code;
    if (is_folder)
        return find_format_of_folder(context, out, path);
    const size_t length = cvol_input_file_length(path);
    char *file = path[length] ? strndup(path, length) : NULL;
    code = cvol_file_peek(context, head, &size, sizeof head, file ? file : path);
    free(file);
    if (code)
        return code;
    for (size_t f = 0; f < FORMATS && !*out; f++)
        if (formats[f]->recognise && formats[f]->recognise(head, size))
            *out = formats[f];
    if (path[length] && !(*out && (*out)->takes_name)) {
        *out = NULL;
        return cvol_fail(context, CVOL_ERROR_IO,
                         "%s: no such file, and the part before the colon is no file of HDF5, "
                         "OpenVDB or MATLAB",
                         path);
    }
    if (!*out)
        *out = cvol_analyze_has_header(path) ? &cvol_format_analyze : format_of_name(path);
    return CVOL_OK;
}

int cvol_file_read_is_volume(cvol_context *context, int *out, const char *path)
{
    const cvol_format *format;
    const int code = find_format(context, &format, path);
    *out = !code && format && !format->needs_options;
    return code;
}

int cvol_file_is_volume(const char *path)
{
    cvol_context context = {.limit_bytes = 0}; /* for discarded messages */
    int is;
    (void)cvol_file_read_is_volume(&context, &is, path);
    return is;
}

static int any_spacing(const cvol_read_options *o)
{
    return o->spacing[0] != 0 || o->spacing[1] != 0 || o->spacing[2] != 0;
}

static int any_raw_option(const cvol_read_options *o)
{
    return o->dims[0] || o->dims[1] || o->dims[2] || o->type || o->big_endian;
}

int cvol_format_choose(cvol_context *context, size_t *out, const char *path, const char *what,
                       const char *option, size_t count, int has_choice, int choice)
{
    *out = has_choice && choice >= 0 ? (size_t)choice : 0;
    if (!strcmp(option, "--time"))
        context->found_times = count;
    if (!strcmp(option, "--channel"))
        context->found_channels = count;
    if (has_choice && (choice < 0 || *out >= count))
        return count == 1 ? cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                      "%s: has one %s, number 0; number %d was requested", path,
                                      what, choice)
                          : cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                      "%s: has %zu %ss, 0 to %zu; number %d was requested", path,
                                      count, what, count - 1, choice);
    if (!has_choice && count > 1)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: has %zu %ss; choose one with %s 0 to %zu", path, count, what, option,
                         count - 1);
    return CVOL_OK;
}

/* Options that the file's format does not use. */
static int check_options(cvol_context *context, const cvol_format *format, const char *path,
                         const cvol_read_options *o)
{
    const int takes = format->takes;
    if (!format->needs_options &&
        (any_raw_option(o) || (any_spacing(o) && !(takes & CVOL_TAKES_SPACING))))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: is %s %s file, which has a header: dims, type and byte order are "
                         "for raw samples%s",
                         path, strchr("AEIO", format->name[0]) ? "an" : "a", format->name,
                         takes & CVOL_TAKES_SPACING ? "" : ", spacing also for formats without it");
    const char *one = o->has_channel && !(takes & CVOL_TAKES_CHANNEL) ? "one channel"
                      : o->has_index && !(takes & CVOL_TAKES_INDEX)   ? "one volume"
                      : o->series && !(takes & CVOL_TAKES_SERIES)     ? "no series"
                                                                      : NULL;
    if (one)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: is a %s file; cvol reads %s from such files: leave out the option",
                         path, format->name, one);
    return CVOL_OK;
}

/* ---- by slab ------------------------------------------------------------------------- */

static int is_picture(const char *path)
{
    static const char *const endings[] = {".png", ".jpg", ".jpeg", ".gif", ".webp"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (cvol_folder_name_ends(path, endings[i]))
            return 1;
    return 0;
}

static int open_any(cvol_context *context, cvol_volume_stream **out, const char *path,
                    const cvol_read_options *options, uint64_t limit_bytes)
{
    const cvol_format *format;
    int code = find_format(context, &format, path);
    if (code)
        return code;
    if (!format && !any_raw_option(options) && is_picture(path))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is a picture, not a volume; a folder of PNG or JPEG slices is one",
                         path);
    if (!format && !any_raw_option(options))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: no volume that is known by content or name (%s); raw samples need "
                         "--dims NXxNYxNZ and --type",
                         path, cvol_volume_readers());
    if (!format)
        format = &cvol_format_raw;
    if (format->lacks)
        return cvol_fail(
            context, CVOL_ERROR_UNSUPPORTED,
            "%s: is a %s file, which this build of cvol does not read (built without %s)", path,
            format->name, format->lacks);
    code = check_options(context, format, path, options);
    if (code)
        return code;
    return cvol_stream_begin(context, out, format, path, options, limit_bytes);
}

/* `given` NULL: one volume. */
static int complete_series(cvol_context *context, cvol_series_options *out, const char *path,
                           const cvol_series_options *given)
{
    *out = (cvol_series_options){.size = sizeof *out, .times = 1, .channels = 1};
    if (!given)
        return CVOL_OK;
    int code = cvol_options_copy(context, out, sizeof *out,
                                 CVOL_SIZE_TO(cvol_series_options, colours), "cvol_series_options",
                                 given);
    if (!code && (out->times < 1 || out->channels < 1 ||
                  (int64_t)out->times * out->channels > CVOL_SERIES_MOST))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %d times and %d channels were given: there must be 1 to %d volumes",
                         path, out->times, out->channels, (int)CVOL_SERIES_MOST);
    if (!code && out->zarr_format && out->zarr_format != 2 && out->zarr_format != 3)
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: zarr_format is %d, must be 2 or 3",
                         path, out->zarr_format);
    return code;
}

/* A file with a named volume may have others, which would be lost. */
static int check_new(cvol_context *context, const char *path, size_t length)
{
    char *file = strndup(path, length);
    if (!file)
        return cvol_fail_memory(context, length, path);
    const int is_new = access(file, F_OK) != 0;
    free(file);
    return is_new
               ? CVOL_OK
               : cvol_fail(context, CVOL_ERROR_ARGUMENT,
                           "%.*s: exists, and cvol adds no volume to a file: remove it first, or "
                           "write another file",
                           (int)length, path);
}

static int create_any(cvol_context *context, cvol_volume_writer **out, const char *path,
                      const cvol_grid *grid, const cvol_series_options *given, int are_labels,
                      const cvol_label *labels, size_t label_count)
{
    cvol_series_options series;
    size_t length;
    const cvol_format *format = format_of_name(path), *named = NULL;
    if (!format)
        format = named = format_of_named(&length, path);
    if (!format || (!format->plan && !format->open_sink))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: the name's ending is not one that can be written (%s)", path,
                         cvol_volume_formats());
    int code = named ? check_new(context, path, length) : CVOL_OK;
    if (code)
        return code;
    code = cvol_grid_check_within(context, grid, path, UINT64_MAX);
    if (code) /* the grid comes from the caller, not from a file */
        return code == CVOL_ERROR_FORMAT ? CVOL_ERROR_ARGUMENT : code;
    code = complete_series(context, &series, path, given);
    if (!code && (series.times > 1 || series.channels > 1) &&
        !(format->holds_series && format->holds_series(path)))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: a %s file gets one volume; only .zarr and .ome.tif get several", path,
                         format->name);
    if (labels) {
        series.labels = labels;
        series.label_count = label_count;
    }
    return code ? code
                : cvol_volume_writer_begin(context, out, format, path, grid, &series, are_labels);
}

static int open_within(cvol_context *context, cvol_volume_stream **out, const char *path,
                       const cvol_read_options *options, uint64_t limit_bytes)
{
    cvol_read_options full;
    *out = NULL;
    cvol_c_locale locale;
    int code = complete(context, &full, options);
    if (!code)
        code = cvol_c_locale_enter(context, &locale);
    if (code)
        return code;
    code = open_any(context, out, path, &full, limit_bytes);
    cvol_c_locale_leave(&locale);
    return code;
}

int cvol_volume_stream_open(cvol_context *context, cvol_volume_stream **out, const char *path,
                            const cvol_read_options *options)
{
    return open_within(context, out, path, options, UINT64_MAX);
}

static int create_in_c_locale(cvol_context *context, cvol_volume_writer **out, const char *path,
                              const cvol_grid *grid, const cvol_series_options *series,
                              int are_labels, const cvol_label *labels, size_t label_count)
{
    *out = NULL;
    cvol_c_locale locale;
    int code = cvol_c_locale_enter(context, &locale);
    if (code)
        return code;
    code = create_any(context, out, path, grid, series, are_labels, labels, label_count);
    cvol_c_locale_leave(&locale);
    return code;
}

int cvol_volume_writer_open_series(cvol_context *context, cvol_volume_writer **out,
                                   const char *path, const cvol_grid *grid,
                                   const cvol_series_options *series, int labels)
{
    return create_in_c_locale(context, out, path, grid, series, labels, NULL, 0);
}

int cvol_volume_writer_open(cvol_context *context, cvol_volume_writer **out, const char *path,
                            const cvol_grid *grid)
{
    return create_in_c_locale(context, out, path, grid, NULL, 0, NULL, 0);
}

int cvol_volume_writer_open_labels(cvol_context *context, cvol_volume_writer **out,
                                   const char *path, const cvol_grid *grid,
                                   const cvol_label *labels, size_t count)
{
    return create_in_c_locale(context, out, path, grid, NULL, 1, labels, count);
}

/* A format with one volume per file need not be opened. */
static int takes_of(cvol_context *context, int *takes, const char *path)
{
    const cvol_format *format;
    const int code = find_format(context, &format, path);
    *takes = !code && format ? format->takes & (CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX) : 0;
    return code;
}

int cvol_file_count_volumes(cvol_context *context, int *times, int *channels, const char *path,
                            const cvol_read_options *options)
{
    cvol_read_options first;
    cvol_volume_stream *stream;
    int takes = 0;
    *times = *channels = 1;
    int code = complete(context, &first, options);
    if (!code)
        code = takes_of(context, &takes, path);
    if (code || !takes)
        return code;
    const int any_time = takes & CVOL_TAKES_INDEX && !first.has_index;
    const int any_channel = takes & CVOL_TAKES_CHANNEL && !first.has_channel;
    if (any_time)
        first.has_index = 1, first.index = 0;
    if (any_channel)
        first.has_channel = 1, first.channel = 0;
    context->found_times = context->found_channels = 1;
    code = open_within(context, &stream, path, &first, UINT64_MAX);
    cvol_volume_stream_free(stream);
    if (!code && (context->found_times > INT_MAX || context->found_channels > INT_MAX))
        code = cvol_fail(context, CVOL_ERROR_LIMIT, "%s: has %zu volumes of %zu channels", path,
                         context->found_times, context->found_channels);
    if (!code && any_time)
        *times = (int)context->found_times;
    if (!code && any_channel)
        *channels = (int)context->found_channels;
    return code;
}

/* ---- whole --------------------------------------------------------------------------- */

static int read_samples(cvol_context *context, cvol_volume *volume, cvol_volume_stream *stream)
{
    size_t bytes = cvol_grid_bytes(&volume->grid);
    int code = CVOL_OK;
    for (size_t done = 0; !code && done < bytes;) {
        size_t step = bytes - done < READ_STEP_BYTES ? bytes - done : READ_STEP_BYTES;
        code = cvol_stream_read_bytes(context, stream, (uint8_t *)volume->data + done, done, step);
        done += step;
        if (!code)
            code = cvol_report_progress(context, "reading", (double)done / (double)bytes);
    }
    return code;
}

int cvol_volume_read(cvol_context *context, cvol_volume **out, const char *path,
                     const cvol_read_options *options)
{
    *out = NULL;
    cvol_volume_stream *stream;
    int code = open_within(context, &stream, path, options, context->limit_bytes);
    if (code)
        return code;
    *out = cvol_stream_take_whole(stream);
    if (!*out) {
        code = cvol_dense_create(context, out, cvol_volume_stream_grid(stream), 0);
        if (!code)
            code = read_samples(context, *out, stream);
    }
    cvol_volume_stream_free(stream);
    if (code) {
        cvol_volume_free(*out);
        *out = NULL;
    }
    return code;
}

static int write_samples(cvol_context *context, const cvol_volume *volume,
                         cvol_volume_writer *writer)
{
    size_t bytes = cvol_grid_bytes(&volume->grid);
    int code = CVOL_OK;
    for (size_t done = 0; !code && done < bytes;) {
        size_t step = bytes - done < WRITE_STEP_BYTES ? bytes - done : WRITE_STEP_BYTES;
        code = cvol_volume_writer_write_bytes(context, writer, (const uint8_t *)volume->data + done,
                                              step);
        done += step;
        if (!code)
            code = cvol_report_progress(context, "writing", (double)done / (double)bytes);
    }
    return code;
}

int cvol_volume_write(cvol_context *context, const cvol_volume *volume, const char *path)
{
    cvol_volume_writer *writer = NULL;
    int code = cvol_dense_check(context, volume, path);
    if (!code)
        code = cvol_volume_writer_open(context, &writer, path, &volume->grid);
    if (!code)
        code = write_samples(context, volume, writer);
    if (!code)
        return cvol_volume_writer_commit(context, writer);
    cvol_volume_writer_abandon(writer);
    return code;
}
