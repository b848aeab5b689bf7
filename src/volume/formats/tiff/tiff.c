/* TIFF and BigTIFF by libtiff (libtiff.gitlab.io; Adobe's TIFF 6.0): the pages of one file, or a
 * folder of files of one page each, in natural order of their names, are the slices of a volume.
 *
 * Samples of 8, 16, 32 and 64 bits, as libtiff decodes them; one channel of several, whether they
 * are pages (ImageJ, OME: stack.c) or samples of a pixel. Reduced images and masks are skipped.
 * Beyond 4 GiB ImageJ describes only the first page; the others follow it raw. */
#define _GNU_SOURCE
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/memory.h"
#include "volume/formats/tiff/page.h"
#include "volume/formats/tiff/signature.h"
#include "volume/formats/tiff/stack.h"
#include "volume/io/folder.h"
#include "volume/io/format.h"
#include "volume/io/text.h"
#include "volume/io/unit.h"

/* ---- pages --------------------------------------------------------------------------- */

/* The place of a slice: an image of a file, or raw samples. */
typedef struct place {
    size_t file;
    uint64_t offset;
    int is_raw;
} place;

typedef struct stack {
    cvol_folder files;
    place *places;
    size_t count, room;
    cvol_tiff_page first; /* the properties that all pages must have */
    size_t sample;        /* of a pixel's */
    cvol_tiff_file *open;
    size_t open_file;
    cvol_input raw;
    int swaps; /* raw samples are in the other byte order */
} stack;

static void close_stack(void *state)
{
    stack *s = state;
    if (!s)
        return;
    cvol_tiff_close(s->open);
    cvol_input_close(&s->raw);
    cvol_folder_close(&s->files);
    free(s->places);
    free(s);
}

static int add_place(cvol_context *context, stack *s, place where)
{
    if (s->count == s->room) {
        size_t room = s->room ? 2 * s->room : 64;
        place *places = realloc(s->places, room * sizeof *places);
        if (!places)
            return cvol_fail_memory(context, room * sizeof *places, s->files.paths[where.file]);
        s->places = places;
        s->room = room;
    }
    s->places[s->count++] = where;
    return CVOL_OK;
}

static int open_file(cvol_context *context, stack *s, size_t file)
{
    if (s->open && s->open_file == file)
        return CVOL_OK;
    cvol_tiff_close(s->open);
    s->open = NULL;
    s->open_file = file;
    return cvol_tiff_open(context, &s->open, s->files.paths[file]);
}

/* Adds all pages of a file; the first page of all sets the properties that the others must have. */
static int list_pages(cvol_context *context, stack *s, size_t file)
{
    const char *path = s->files.paths[file];
    int code = open_file(context, s, file);
    for (int more = 1; !code && more;) {
        cvol_tiff_page page;
        code = cvol_tiff_read_page(context, s->open, &page);
        if (!code && !page.is_extra) {
            if (s->count == 0)
                s->first = page;
            else
                code = cvol_tiff_check_same(context, &s->first, &page, path);
            if (!code)
                code = add_place(context, s, (place){file, page.offset, 0});
        }
        if (!code)
            code = cvol_tiff_next(context, s->open, &more);
    }
    if (!code && s->count == 0)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no page but reduced ones", path);
    return code;
}

/* The folder's TIFF files, or the one file. */
static int list_files(cvol_context *context, stack *s, const char *path)
{
    int is_folder, code = cvol_folder_check(context, &is_folder, path);
    if (code)
        return code;
    if (!is_folder) {
        s->files.paths = malloc(sizeof *s->files.paths);
        char *name = s->files.paths ? strdup(path) : NULL;
        if (!name)
            return cvol_fail_memory(context, strlen(path), path);
        s->files.paths[s->files.count++] = name;
        return CVOL_OK;
    }
    code = cvol_folder_open(context, &s->files, path);
    size_t kept = 0;
    for (size_t i = 0; !code && i < s->files.count; i++) {
        cvol_input input;
        uint8_t head[8];
        size_t got = 0;
        char *file = s->files.paths[i];
        if (!cvol_input_open(context, &input, file) &&
            !cvol_input_read(context, &input, 0, head, sizeof head, &got) &&
            cvol_tiff_recognise(head, got)) {
            s->files.paths[i] = s->files.paths[kept];
            s->files.paths[kept++] = file;
        } else if (cvol_folder_name_ends(file, ".tif") || cvol_folder_name_ends(file, ".tiff"))
            code = cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: is not a TIFF file, although its name ends like one: the volume "
                             "would lack slices without it",
                             file);
        cvol_input_close(&input);
    }
    while (!code && s->files.count > kept)
        free(s->files.paths[--s->files.count]);
    return code;
}

static int list_folder(cvol_context *context, stack *s)
{
    int code = CVOL_OK;
    for (size_t i = 0; !code && i < s->files.count; i++) {
        code = list_pages(context, s, i);
        if (!code && s->files.count > 1 && s->count != i + 1)
            code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: has %zu pages; files of a folder are slices, with one page each",
                             s->files.paths[i], s->count - i);
        if (!code)
            code = cvol_report_progress(context, "reading pages' headers",
                                        (double)(i + 1) / (double)s->files.count);
    }
    return code;
}

/* ---- interpretation of pages ---------------------------------------------------------- */

/* ImageJ's pages without a directory, which lie behind the first one's samples. */
static int find_raw_pages(cvol_context *context, stack *s, const cvol_tiff_stack *described)
{
    const char *path = s->files.paths[0];
    if (s->files.count > 1 || s->count > 1 || !described->is_imagej || described->images < 2 ||
        !s->first.raw_offset)
        return CVOL_OK;
    int code = cvol_input_open(context, &s->raw, path);
    uint64_t page = s->first.bytes, bytes = 0;
    if (!code && (__builtin_mul_overflow(page, (uint64_t)described->images, &bytes) ||
                  s->raw.size < s->first.raw_offset || s->raw.size - s->first.raw_offset < bytes))
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: has 1 page, and not the bytes of the %zu images that its "
                         "description announces",
                         path, described->images);
    s->swaps = s->first.big_endian != cvol_machine_is_big_endian();
    s->count = 0;
    for (size_t i = 0; !code && i < described->images; i++)
        code = add_place(context, s, (place){0, s->first.raw_offset + i * page, 1});
    return code;
}

/* Keeps the places of the requested slices. */
static int choose_slices(cvol_context *context, stack *s, cvol_tiff_stack *described,
                         const char *path, const cvol_read_options *options)
{
    const size_t samples = s->first.samples;
    if (!described->known || s->files.count > 1) {
        described->slices = s->count;
        described->channels = described->times = described->slice_step = 1;
        described->channel_step = described->time_step = 0;
    }
    if (described->slices > s->count || described->channels > s->count ||
        described->times > s->count ||
        described->slices * described->channels * described->times != s->count)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: holds %zu pages, but its description announces %zu slices, %zu "
                         "channels and %zu times",
                         path, s->count, described->slices, described->channels, described->times);
    size_t channel, time;
    int code = cvol_format_choose(context, &channel, path, "channel", "--channel",
                                  described->channels * samples, options->has_channel,
                                  options->channel);
    if (!code)
        code = cvol_format_choose(context, &time, path, "volume", "--time", described->times,
                                  options->has_index, options->index);
    if (code)
        return code;
    s->sample = channel % samples;
    place *kept = malloc(described->slices * sizeof *kept);
    if (!kept)
        return cvol_fail_memory(context, described->slices * sizeof *kept, path);
    for (size_t z = 0; z < described->slices; z++)
        kept[z] =
            s->places[time * described->time_step + channel / samples * described->channel_step +
                      z * described->slice_step];
    free(s->places);
    s->places = kept;
    s->count = s->room = described->slices;
    return CVOL_OK;
}

/* Resolutions of plain files are those of printers: only ImageJ's describe samples. Lengths are
 * converted to the unit of x. Pixels, for example, are no unit. */
static int set_spacing(cvol_context *context, cvol_grid *grid, const stack *s,
                       const cvol_tiff_stack *described, const char *path,
                       const cvol_read_options *options)
{
    double spacing[3] = {described->spacing[0], described->spacing[1], described->spacing[2]};
    double factor[3] = {1, 1, 1};
    const char *unit[3] = {described->unit[0], described->unit[1], described->unit[2]};
    char common[16] = "";
    if (grid->dims[2] == 1 && !(cvol_unit_metres(unit[2]) > 0))
        unit[2] = "";
    const int fits = cvol_unit_factors(factor, common, unit);
    if (!fits && !(options->spacing[0] > 0))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: the units of its axes are '%s', '%s' and '%s', which do not convert "
                         "into each other: give --spacing SX,SY,SZ",
                         path, unit[0], unit[1], unit[2]);
    for (int a = 0; a < 2 && described->is_imagej; a++)
        spacing[a] = s->first.resolution[a] > 0 ? 1 / s->first.resolution[a] : 0;
    for (int a = 0; a < 3; a++)
        if (spacing[a] > 0)
            grid->spacing[a] = spacing[a] * (fits ? factor[a] : 1);
    if (fits && cvol_unit_metres(common) > 0 && (described->is_imagej || spacing[0] > 0))
        memcpy(grid->unit, common, sizeof grid->unit);
    return CVOL_OK;
}

/* ---- reading ------------------------------------------------------------------------- */

static int read_raw_page(cvol_context *context, stack *s, const place *where, void *out)
{
    size_t got, size = s->first.bytes;
    int code = cvol_input_read(context, &s->raw, where->offset, out, size, &got);
    if (!code && got != size)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off", s->raw.path);
    size_t sample = cvol_type_size(s->first.type);
    if (!code && s->swaps)
        cvol_swap_bytes(out, size / sample, sample);
    return code;
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    stack *s = state;
    size_t bytes = s->first.width * s->first.height * cvol_type_size(s->first.type);
    int code = CVOL_OK;
    for (size_t z = 0; !code && z < count; z++) {
        const place *where = &s->places[first + z];
        uint8_t *slice = (uint8_t *)out + z * bytes;
        if (where->is_raw) {
            code = read_raw_page(context, s, where, slice);
            continue;
        }
        code = open_file(context, s, where->file);
        if (!code)
            code = cvol_tiff_decode(context, s->open, where->offset, &s->first, s->sample, slice);
    }
    return code;
}

static int find_tiff(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    stack *s = calloc(1, sizeof *s);
    if (!s)
        return cvol_fail_memory(context, sizeof *s, path);
    s->raw.fd = -1;
    stored->slices = (cvol_slices){.state = s, .read = read_slices, .close = close_stack};
    int code = list_files(context, s, path);
    if (!code)
        code = list_folder(context, s);
    cvol_tiff_stack described = {.known = 0};
    char *description = NULL;
    if (!code)
        code = open_file(context, s, 0);
    if (!code)
        code = cvol_tiff_description(context, s->open, &description);
    if (!code) {
        cvol_tiff_read_description(&described, description, s->first.samples);
        code = find_raw_pages(context, s, &described);
    }
    if (!code)
        code = choose_slices(context, s, &described, path, options);
    const int was_asked = code == CVOL_ERROR_ARGUMENT; /* and the counts are those of pages */
    if ((!code || was_asked) && described.known &&
        !cvol_tiff_read_labels(&stored->labels, description, described.channels, s->first.samples))
        code = cvol_fail_memory(context, described.channels * sizeof(cvol_channel_label), path);
    if ((!code || was_asked) && s->first.are_colours && described.channels == 1 &&
        !cvol_labels_set_colours(&stored->labels, s->first.samples))
        code = cvol_fail_memory(context, s->first.samples * sizeof(cvol_channel_label), path);
    if (code == CVOL_ERROR_ARGUMENT && !options->has_channel)
        code = cvol_labels_append_names(context, &stored->labels, code);
    free(description);
    if (code)
        return code;
    *grid = cvol_grid_make(s->first.width, s->first.height, s->count, s->first.type);
    return set_spacing(context, grid, s, &described, path, options);
}

const cvol_format cvol_format_tiff = {
    .name = "TIFF",
    .endings = {".tif", ".tiff"},
    .recognise = cvol_tiff_recognise,
    .find = find_tiff,
    .plan = cvol_tiff_plan,
    .holds_series = cvol_tiff_is_ome,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
    .takes_folder = 1,
};
