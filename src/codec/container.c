/* The container: signature, version, section HEAD, and RNGE, INDX, DATA; or TERM; or SPEC. */
#include "codec/container.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/header.h"
#include "codec/ranges.h"
#include "codec/section.h"
#include "codec/terms.h"

/* A byte with the high bit (7-bit lines), the name, CR LF (translations), ^Z (TYPE), LF. */
static const uint8_t signature[CVOL_SIGNATURE_BYTES] = {0x8B, 'C',  'V',  'L',
                                                        0x0D, 0x0A, 0x1A, 0x0A};

enum { INDEX_ENTRY_BYTES = 12 };

size_t cvol_container_matches(const uint8_t *data, size_t size)
{
    size_t same = 0;
    while (same < sizeof signature && same < size && data[same] == signature[same])
        same++;
    return same;
}

uint8_t cvol_container_signature(size_t i)
{
    return signature[i];
}

int cvol_container_is(const uint8_t *data, size_t size)
{
    return cvol_container_matches(data, size) == sizeof signature;
}

/* ---- writing ---------------------------------------------------------------------------- */

static void put_index(cvol_bytes *out, const cvol_groups *groups)
{
    cvol_bytes content = {0}, checksums = {0};
    for (size_t g = 0; g < groups->count; g++) {
        const cvol_bytes *bytes = &groups->bytes[g];
        uint32_t checksum = cvol_crc32c(bytes->data, bytes->size);
        cvol_bytes_put_u64(&content, bytes->size);
        cvol_bytes_put_u32(&content, checksum);
        cvol_bytes_put_u32(&checksums, checksum);
    }
    cvol_section_put(out, "INDX", &content);
    /* The groups' checksums cover DATA: its own is theirs. */
    cvol_section_put_header(out, "DATA", cvol_groups_size(groups),
                            cvol_crc32c(checksums.data, checksums.size));
    out->failed |= checksums.failed;
    cvol_bytes_free(&content);
    cvol_bytes_free(&checksums);
}

static int put_ranges(cvol_context *context, cvol_bytes *out, const cvol_array *array)
{
    cvol_bytes ranges = {0};
    int code = cvol_ranges_put(context, &ranges, array);
    cvol_section_put(out, "RNGE", &ranges);
    cvol_bytes_free(&ranges);
    return code;
}

static int put_terms(cvol_context *context, cvol_bytes *out, const cvol_array *array)
{
    cvol_bytes terms = {0};
    int code = array->block ? cvol_terms_put(context, &terms, array)
                            : cvol_spectrum_put(context, &terms, array);
    cvol_section_put(out, array->block ? "TERM" : "SPEC", &terms);
    cvol_bytes_free(&terms);
    return code;
}

int cvol_container_begin(cvol_context *context, cvol_bytes *out, const cvol_array *array,
                         const cvol_groups *groups)
{
    cvol_bytes header = {0};
    int code = array->block ? cvol_terms_check(context, array) : CVOL_OK;
    if (!code && cvol_array_has_splits(array))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "cells that are split cannot be written in version %d of the format",
                         CVOL_FORMAT_VERSION);
    if (!code && array->lapped)
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "lapped volumes cannot be written in version %d of the format",
                         CVOL_FORMAT_VERSION);
    if (code)
        return code;
    cvol_bytes_append(out, signature, sizeof signature);
    cvol_bytes_put_u32(out, CVOL_FORMAT_VERSION);
    cvol_header_put(&header, array);
    cvol_section_put(out, "HEAD", &header);
    cvol_bytes_free(&header);
    if (cvol_array_is_volume(array)) {
        code = put_ranges(context, out, array);
        put_index(out, groups);
    } else {
        code = put_terms(context, out, array);
    }
    if (!code && out->failed)
        code = cvol_fail_memory(context, out->size, "the file's header");
    return code;
}

/* ---- reading ---------------------------------------------------------------------------- */

/* Takes a section whose content its header's checksum covers. */
static int take_checked(cvol_context *context, cvol_cursor *content, cvol_cursor *file,
                        const char *tag, const char *name)
{
    uint32_t checksum;
    int code = cvol_section_take(context, content, &checksum, file, tag, name);
    if (code)
        return code;
    return cvol_section_check(context, checksum, cvol_crc32c(content->data, content->size), tag,
                              name);
}

/* The groups' bytes and checksums, from INDX and DATA. */
typedef struct group_table {
    cvol_span *spans;
    uint32_t *checksums;
} group_table;

static int take_spans(cvol_context *context, group_table *table, cvol_cursor *index,
                      cvol_cursor *data, size_t count, const char *name)
{
    table->spans = cvol_allocate(count, sizeof *table->spans);
    table->checksums = cvol_allocate(count, sizeof *table->checksums);
    if (!table->spans || !table->checksums)
        return cvol_fail_memory(context, count * sizeof *table->spans, "the index");
    for (size_t g = 0; g < count; g++) {
        uint64_t size = cvol_cursor_u64(index);
        table->checksums[g] = cvol_cursor_u32(index);
        if (size == 0 || size > cvol_cursor_left(data))
            return cvol_fail(
                context, CVOL_ERROR_CORRUPT,
                "%s: section INDX: group %zu has %llu bytes, section DATA has %zu left", name, g,
                (unsigned long long)size, cvol_cursor_left(data));
        table->spans[g] = (cvol_span){cvol_cursor_take(data, (size_t)size), (size_t)size};
    }
    if (cvol_cursor_left(data))
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section DATA has %zu bytes that belong to no group", name,
                         cvol_cursor_left(data));
    return CVOL_OK;
}

/* The checksum of DATA: of the groups' checksums. */
static int check_data(cvol_context *context, const uint32_t *checksums, size_t count,
                      uint32_t stored, const char *name)
{
    cvol_bytes bytes = {0};
    for (size_t g = 0; g < count; g++)
        cvol_bytes_put_u32(&bytes, checksums[g]);
    int code = bytes.failed ? cvol_fail_memory(context, 4 * count, "the index")
                            : cvol_section_check(context, stored,
                                                 cvol_crc32c(bytes.data, bytes.size), "DATA", name);
    cvol_bytes_free(&bytes);
    return code;
}

static int fail_left(cvol_context *context, const cvol_cursor *file, const char *name)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: %zu bytes follow the end", name,
                     cvol_cursor_left(file));
}

/* Leaves only the groups that the box touches. */
static void choose_groups(cvol_span *spans, const cvol_array *array, const cvol_box *box)
{
    for (size_t g = cvol_group_count(array); g-- > 0;)
        if (!cvol_group_touches(array, g, box->begin, box->end))
            spans[g].data = NULL;
}

static int take_groups(cvol_context *context, cvol_array *array, cvol_cursor *file,
                       const cvol_box *box, const char *name)
{
    const size_t count = cvol_group_count(array);
    group_table table = {0};
    cvol_cursor index, data;
    uint32_t checksum;
    int code = take_checked(context, &index, file, "INDX", name);
    if (code)
        return code;
    if (index.size / INDEX_ENTRY_BYTES != count || index.size % INDEX_ENTRY_BYTES)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section INDX has %zu bytes, must have %d for each of %zu groups",
                         name, index.size, (int)INDEX_ENTRY_BYTES, count);
    code = cvol_section_take(context, &data, &checksum, file, "DATA", name);
    if (code)
        return code;
    if (cvol_cursor_left(file))
        return fail_left(context, file, name);
    code = take_spans(context, &table, &index, &data, count, name);
    if (!code)
        code = check_data(context, table.checksums, count, checksum, name);
    if (!code && box)
        choose_groups(table.spans, array, box);
    if (!code)
        code = cvol_array_decode(context, array, table.spans, table.checksums, name);
    free(table.spans);
    free(table.checksums);
    return code;
}

/* Every group takes 12 bytes in INDX and one in DATA at least, and has 4096 blocks at most: what a
 * file claims is refused before memory is spent on it. */
static int check_claims(cvol_context *context, const cvol_header *header, size_t file_left,
                        const char *name)
{
    uint64_t groups = 1;
    for (int a = 0; a < 3; a++)
        groups *= (header->grid.dims[a] - 1) / CVOL_GROUP_SIDE + 1; /* at most the samples */
    if (groups > file_left / (INDEX_ENTRY_BYTES + 1))
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: %zu x %zu x %zu samples are %llu groups, more than a file of "
                         "this size can hold",
                         name, header->grid.dims[0], header->grid.dims[1], header->grid.dims[2],
                         (unsigned long long)groups);
    return CVOL_OK;
}

static int make_array(cvol_context *context, cvol_array **out, const cvol_header *header)
{
    int code = cvol_array_create_as(context, out, &header->grid, (int)header->rank,
                                    (cvol_transform)header->transform, (int)header->block);
    if (code)
        return code;
    cvol_array *array = *out;
    array->step = header->step;
    array->offset = header->offset;
    array->ledger = header->ledger;
    array->threshold = header->threshold;
    array->measured = (int)header->measured;
    array->range_min = header->range_min;
    array->range_max = header->range_max;
    array->psnr_db = header->psnr_db;
    array->max_error = header->max_error;
    return CVOL_OK;
}

/* Sections RNGE, INDX and DATA. */
static int read_volume(cvol_context *context, cvol_array **array, const cvol_header *header,
                       cvol_cursor *file, const cvol_box *box, const char *name)
{
    cvol_cursor ranges;
    int code = take_checked(context, &ranges, file, "RNGE", name);
    if (!code)
        code = check_claims(context, header, cvol_cursor_left(file), name);
    if (!code)
        code = make_array(context, array, header);
    if (!code)
        code = cvol_ranges_take(context, *array, &ranges, name);
    if (!code)
        code = take_groups(context, *array, file, box, name);
    return code;
}

/* Section TERM or SPEC. */
static int read_terms(cvol_context *context, cvol_array **array, const cvol_header *header,
                      cvol_cursor *file, const char *name)
{
    cvol_cursor content;
    int code = take_checked(context, &content, file, header->block ? "TERM" : "SPEC", name);
    if (!code && cvol_cursor_left(file))
        code = fail_left(context, file, name);
    if (!code && header->block)
        code = cvol_terms_check_claims(context, header, &content, name);
    if (!code)
        code = make_array(context, array, header);
    if (code)
        return code;
    return header->block ? cvol_terms_take(context, *array, header, &content, name)
                         : cvol_spectrum_take(context, *array, &content, name);
}

/* A box of samples must not be empty, and must lie within the array. */
static int check_box(cvol_context *context, const cvol_box *box, const size_t dims[3],
                     const char *name)
{
    for (int a = 0; a < 3; a++) {
        const size_t begin = box->begin[a], end = box->end[a];
        const char *wrong = begin == end    ? "is empty"
                            : begin > end   ? "is reversed"
                            : end > dims[a] ? "reaches beyond the volume"
                                            : NULL;
        if (wrong)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "%s: the box %s along %c: it is %zu:%zu there, the volume 0:%zu", name,
                             wrong, "xyz"[a], begin, end, dims[a]);
    }
    return CVOL_OK;
}

static int read_sections(cvol_context *context, cvol_array **array, cvol_cursor *file,
                         const cvol_box *box, const char *name)
{
    cvol_cursor content;
    cvol_header header;
    int code = take_checked(context, &content, file, "HEAD", name);
    if (!code)
        code = cvol_header_take(context, &header, &content, name);
    if (!code && box)
        code = check_box(context, box, header.grid.dims, name);
    if (!code)
        code = cvol_header_is_volume(&header)
                   ? read_volume(context, array, &header, file, box, name)
                   : read_terms(context, array, &header, file, name);
    if (code || (box && cvol_header_is_volume(&header))) /* not all coefficients are there */
        return code;
    cvol_array_info info;
    cvol_array_get_info(*array, &info);
    if (info.coefficients != header.coefficients)
        return cvol_fail(
            context, CVOL_ERROR_CORRUPT, "%s: there are %llu coefficients, section HEAD says %llu",
            name, (unsigned long long)info.coefficients, (unsigned long long)header.coefficients);
    return CVOL_OK;
}

int cvol_container_read(cvol_context *context, cvol_array **out, const uint8_t *data, size_t size,
                        const char *name)
{
    return cvol_container_read_box(context, out, data, size, NULL, name);
}

int cvol_container_read_box(cvol_context *context, cvol_array **out, const uint8_t *data,
                            size_t size, const cvol_box *box, const char *name)
{
    *out = NULL;
    cvol_cursor file = cvol_cursor_make(data, size);
    if (!cvol_container_is(data, size))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is not a .cvol file", name);
    cvol_cursor_take(&file, sizeof signature);
    uint32_t version = cvol_cursor_u32(&file);
    if (file.failed)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: truncated in its version", name);
    if (version > CVOL_FORMAT_VERSION)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is a .cvol of version %u, this library reads version %d", name,
                         version, (int)CVOL_FORMAT_VERSION);
    cvol_array *array = NULL;
    int code = read_sections(context, &array, &file, box, name);
    if (code) {
        cvol_array_free(array);
        return code;
    }
    *out = array;
    return CVOL_OK;
}
