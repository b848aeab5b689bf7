/* Reads files of many volumes: the list, one volume, or all volumes. */
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container/container.h"
#include "codec/container/plane_file.h"
#include "codec/container/series.h"
#include "codec/section/signature.h"

/* ---- the list --------------------------------------------------------------------------- */

/* Makes the list of a file of one volume. */
static int make_single(cvol_context *context, cvol_series **out, size_t size)
{
    const int code = cvol_series_make(context, out, 1, 1);
    if (code)
        return code;
    cvol_series_get_default_colour((*out)->channel[0].colour, 0, 1);
    (*out)->volumes[0] = (cvol_extent){0, size};
    return CVOL_OK;
}

static int refuse_other_kinds(cvol_context *context, cvol_file_kind kind, const char *name)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is a %s, not a volume", name,
                     kind == CVOL_FILE_PICTURE ? "compressed picture" : "baked volume");
}

int cvol_series_take(cvol_context *context, cvol_series **out, const uint8_t *data, size_t size,
                     const char *name)
{
    cvol_cursor file = cvol_cursor_make(data, size);
    const cvol_file_kind kind = cvol_plane_file_kind(data, size);
    *out = NULL;
    int code = cvol_container_take_start(context, &file, name);
    if (!code && kind == CVOL_FILE_ARRAY)
        return make_single(context, out, size);
    if (!code && kind != CVOL_FILE_SERIES)
        code = refuse_other_kinds(context, kind, name);
    if (code)
        return code;
    cvol_section section;
    cvol_section_walk walk = cvol_section_walk_make(file);
    code = cvol_section_next(context, &section, &walk, name);
    if (!code)
        code = cvol_section_check(context, &section, name);
    if (code)
        return code;
    cvol_cursor content = cvol_section_cursor(&section);
    return cvol_series_take_list(context, out, &content, name);
}

int cvol_series_read(cvol_context *context, cvol_series **out, const char *path)
{
    cvol_map file;
    *out = NULL;
    int code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    code = cvol_series_take(context, out, file.data, file.size, path);
    cvol_file_unmap(&file);
    return code;
}

/* ---- a volume --------------------------------------------------------------------------- */

static int check_choice(cvol_context *context, int chosen, int count, const char *what,
                        const char *name)
{
    if (chosen >= 0 && chosen < count)
        return CVOL_OK;
    if (count == 1)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: has one %s, number 0; number %d was requested", name, what, chosen);
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: has %d %ss, 0 to %d; number %d was requested", name, count, what,
                     count - 1, chosen);
}

/* Checks the header in front of a volume: its kind and its length. */
static int check_section(cvol_context *context, const cvol_extent *extent, const uint8_t *data,
                         size_t size, const char *name)
{
    const uint64_t at = extent->offset - CVOL_SECTION_HEADER_BYTES;
    if (extent->offset > size)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated: the file has %zu bytes and ends before it", name, size);
    cvol_cursor header = cvol_cursor_make(data + at, CVOL_SECTION_HEADER_BYTES);
    const uint8_t *tag = cvol_cursor_take(&header, 4);
    const uint32_t flags = cvol_cursor_u32(&header);
    const uint64_t length = cvol_cursor_u64(&header);
    (void)cvol_cursor_u32(&header);
    const uint32_t stored = cvol_cursor_u32(&header);
    if (memcmp(tag, cvol_section_tag(CVOL_VOLM), 4) || flags != CVOL_SECTION_REQUIRED ||
        length != extent->length || stored != cvol_crc32c(data + at, 20))
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: there is no section VOLM of %llu bytes at byte %llu, where section "
                         "LIST has one",
                         name, (unsigned long long)extent->length, (unsigned long long)at);
    return CVOL_OK;
}

int cvol_series_find(cvol_context *context, cvol_series_place *out, const cvol_series *series,
                     int time, int channel, const uint8_t *data, size_t size, const char *name)
{
    int code = check_choice(context, time, series->times, "time", name);
    if (!code)
        code = check_choice(context, channel, series->channels, "channel", name);
    if (code)
        return code;
    const cvol_extent *extent =
        &series->volumes[(size_t)time * (size_t)series->channels + (size_t)channel];
    snprintf(out->name, sizeof out->name, "%s", name);
    out->data = data;
    out->size = size;
    if (!series->is_list)
        return CVOL_OK;
    snprintf(out->name, sizeof out->name, "%.400s, time %d, channel %d (from byte %llu)", name,
             time, channel, (unsigned long long)extent->offset);
    code = check_section(context, extent, data, size, out->name);
    if (code)
        return code;
    const uint64_t left = size - extent->offset;
    out->data = data + extent->offset;
    out->size = (size_t)(left < extent->length ? left : extent->length);
    if (out->size < CVOL_SECTIONS_AT)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: truncated: %zu of %llu bytes are there",
                         out->name, out->size, (unsigned long long)extent->length);
    if (!cvol_container_is(out->data, out->size))
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: is not a .cvol file", out->name);
    switch (cvol_plane_file_kind(out->data, out->size)) {
    case CVOL_FILE_SERIES:
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is itself a file of many volumes",
                         out->name);
    case CVOL_FILE_PICTURE:
    case CVOL_FILE_BAKED:
        return refuse_other_kinds(context, cvol_plane_file_kind(out->data, out->size), out->name);
    case CVOL_FILE_OTHER:
    case CVOL_FILE_ARRAY:
        break;
    }
    return CVOL_OK;
}

int cvol_series_extract(cvol_context *context, const char *path, int time, int channel,
                        const char *out_path, uint64_t *file_bytes)
{
    cvol_map file;
    cvol_series *series;
    cvol_series_place place;
    int code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    code = cvol_series_take(context, &series, file.data, file.size, path);
    if (!code)
        code = cvol_series_find(context, &place, series, time, channel, file.data, file.size, path);
    if (!code && place.size < cvol_series_volume_bytes(series, time, channel))
        code = cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: truncated: %zu of %llu bytes are there",
                         place.name, place.size,
                         (unsigned long long)cvol_series_volume_bytes(series, time, channel));
    if (!code)
        code = cvol_file_write(context, place.data, place.size, out_path);
    if (!code && file_bytes)
        *file_bytes = place.size;
    cvol_series_free(series);
    cvol_file_unmap(&file);
    return code;
}

/* ---- all -------------------------------------------------------------------------------- */

/* Checks that the sections VOLM match the list in number and order. */
static int check_sections(cvol_context *context, const cvol_series *series, const uint8_t *data,
                          size_t size, const char *name)
{
    const size_t count = (size_t)series->times * (size_t)series->channels;
    cvol_cursor file = cvol_cursor_make(data, size);
    cvol_cursor_take(&file, CVOL_SECTIONS_AT);
    cvol_section_walk walk = cvol_section_walk_make(file);
    size_t found = 0;
    while (!cvol_section_walk_ended(&walk)) {
        cvol_section section;
        const int code = cvol_section_next(context, &section, &walk, name);
        if (code)
            return code;
        if (section.kind != CVOL_VOLM)
            continue;
        if (found < count &&
            section.offset + CVOL_SECTION_HEADER_BYTES != series->volumes[found].offset)
            return cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section VOLM at byte %llu: section LIST has volume %zu at byte "
                             "%llu",
                             name, (unsigned long long)section.offset, found,
                             (unsigned long long)series->volumes[found].offset);
        found++;
    }
    return found == count ? CVOL_OK
                          : cvol_fail(context, CVOL_ERROR_CORRUPT,
                                      "%s: there are %zu sections VOLM, section LIST has %zu", name,
                                      found, count);
}

static int try_volume(cvol_context *context, cvol_grid *first, const cvol_series_place *place)
{
    cvol_grid grid;
    int code = cvol_container_try(context, place->data, place->size, place->name);
    if (!code)
        code = cvol_container_read_grid(context, &grid, place->data, place->size, NULL,
                                        place->name);
    if (code)
        return code;
    if (!first->dims[0])
        *first = grid;
    if (memcmp(grid.dims, first->dims, sizeof grid.dims) || grid.type != first->type)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: has %zu x %zu x %zu samples of %s, the first volume %zu x %zu x %zu "
                         "of %s",
                         place->name, grid.dims[0], grid.dims[1], grid.dims[2],
                         cvol_type_name(grid.type), first->dims[0], first->dims[1], first->dims[2],
                         cvol_type_name(first->type));
    return CVOL_OK;
}

int cvol_series_try(cvol_context *context, const uint8_t *data, size_t size, const char *name)
{
    cvol_series *series;
    cvol_grid first = {.dims = {0}};
    int code = cvol_series_take(context, &series, data, size, name);
    if (!code)
        code = check_sections(context, series, data, size, name);
    for (int t = 0; !code && t < series->times; t++)
        for (int c = 0; !code && c < series->channels; c++) {
            cvol_series_place place;
            code = cvol_series_find(context, &place, series, t, c, data, size, name);
            if (!code)
                code = try_volume(context, &first, &place);
        }
    cvol_series_free(series);
    return code;
}
