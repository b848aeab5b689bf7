/* Sections: headers, their order, checksums, and messages about errors in them. */
#include "codec/section/section.h"

#include <stdio.h>
#include <string.h>

#include "base/context.h"

#define BIT(kind) (UINT32_C(1) << (kind))
/* The predecessor of a file's first section. */
#define START BIT(CVOL_SECTION_UNKNOWN)

/* Tags of sections, their possible predecessors, and their content in words. */
static const struct section_row {
    const char *tag;
    uint32_t after;
    int optional;
    const char *content;
} rows[CVOL_SECTION_KINDS] = {
    [CVOL_HEAD] = {"HEAD", START, 0, "shape, type, transform, step"},
    [CVOL_GEOM] = {"GEOM", BIT(CVOL_HEAD), 0, "geometry and meaning of the samples"},
    [CVOL_ATTR] = {"ATTR", BIT(CVOL_GEOM), 1, "attributes, as JSON"},
    [CVOL_ERRS] = {"ERRS", BIT(CVOL_GEOM) | BIT(CVOL_ATTR), 0, "error bounds"},
    [CVOL_MODE] = {"MODE", BIT(CVOL_ERRS), 0, "kinds of residual and mask"},
    [CVOL_BRKS] = {"BRKS", BIT(CVOL_ERRS) | BIT(CVOL_MODE), 0, "the shape of bricks and of runs"},
    [CVOL_TRUE] = {"TRUE", BIT(CVOL_ERRS) | BIT(CVOL_MODE) | BIT(CVOL_BRKS), 0,
                   "DCTs of true length at the end of the volume"},
    [CVOL_SMAL] = {"SMAL", BIT(CVOL_ERRS) | BIT(CVOL_MODE) | BIT(CVOL_BRKS) | BIT(CVOL_TRUE), 0,
                   "coefficients are coded by neural networks"},
    [CVOL_SUMM] = {"SUMM",
                   BIT(CVOL_ERRS) | BIT(CVOL_MODE) | BIT(CVOL_BRKS) | BIT(CVOL_TRUE) |
                       BIT(CVOL_SMAL),
                   1, "distribution of the original samples"},
    [CVOL_RNGE] = {"RNGE",
                   BIT(CVOL_ERRS) | BIT(CVOL_MODE) | BIT(CVOL_BRKS) | BIT(CVOL_TRUE) |
                       BIT(CVOL_SMAL) | BIT(CVOL_SUMM),
                   1, "bounds of the decoded samples, for skipping"},
    [CVOL_TABL] = {"TABL",
                   BIT(CVOL_ERRS) | BIT(CVOL_MODE) | BIT(CVOL_BRKS) | BIT(CVOL_TRUE) |
                       BIT(CVOL_SMAL) | BIT(CVOL_SUMM) | BIT(CVOL_RNGE),
                   0, "the coder's probabilities"},
    [CVOL_INDX] = {"INDX", BIT(CVOL_TABL), 0, "length of each brick, checksums of runs of them"},
    [CVOL_MASK] = {"MASK", BIT(CVOL_INDX), 0, "mask of samples without a value, brick by brick"},
    [CVOL_SHL0] = {"SHL0", BIT(CVOL_INDX) | BIT(CVOL_MASK), 0,
                   "the coarsest coefficients, brick by brick"},
    [CVOL_SHL1] = {"SHL1", BIT(CVOL_SHL0), 0, "coefficients of level 2, brick by brick"},
    [CVOL_SHL2] = {"SHL2", BIT(CVOL_SHL1), 0, "coefficients of level 1, brick by brick"},
    [CVOL_SHL3] = {"SHL3", BIT(CVOL_SHL2), 0, "the finest coefficients, brick by brick"},
    [CVOL_CORR] = {"CORR", BIT(CVOL_SHL3), 0, "residual for exact or bounded samples, or labels"},
    [CVOL_TERM] = {"TERM", BIT(CVOL_ERRS), 0, "the terms of all blocks"},
    [CVOL_SPEC] = {"SPEC", BIT(CVOL_ERRS), 0, "the terms of the whole array"},
    [CVOL_PICT] = {"PICT", START, 0, "size, lattice and steps of a compressed picture"},
    [CVOL_BAKE] = {"BAKE", START, 0, "source and settings of the bake"},
    [CVOL_PLNS] = {"PLNS", BIT(CVOL_PICT) | BIT(CVOL_BAKE), 0, "the coefficients of all planes"},
    [CVOL_LIST] = {"LIST", START, 0, "times and channels, positions of their volumes"},
    [CVOL_VOLM] = {"VOLM", BIT(CVOL_LIST) | BIT(CVOL_VOLM), 0,
                   "a volume, which is a complete file"},
    [CVOL_PACK] = {"PACK", START, 0, "all sections of a small file"},
    [CVOL_ENDS] = {"ENDS",
                   BIT(CVOL_SHL3) | BIT(CVOL_CORR) | BIT(CVOL_TERM) | BIT(CVOL_SPEC) |
                       BIT(CVOL_PLNS) | BIT(CVOL_VOLM),
                   0, "the end"},
};

const char *cvol_section_tag(cvol_section_kind kind)
{
    return kind < CVOL_SECTION_KINDS ? rows[kind].tag : "????";
}

const char *cvol_section_content(cvol_section_kind kind)
{
    return kind < CVOL_SECTION_KINDS ? rows[kind].content : "unknown";
}

/* ---- writing ---------------------------------------------------------------------------- */

void cvol_section_put_header(cvol_bytes *out, cvol_section_kind kind, uint64_t length,
                             uint32_t checksum)
{
    const size_t start = out->size;
    cvol_bytes_append(out, rows[kind].tag, 4);
    cvol_bytes_put_u32(out, rows[kind].optional ? 0 : CVOL_SECTION_REQUIRED);
    cvol_bytes_put_u64(out, length);
    cvol_bytes_put_u32(out, checksum);
    if (!out->failed)
        cvol_bytes_put_u32(out, cvol_crc32c(out->data + start, out->size - start));
}

void cvol_section_put(cvol_bytes *out, cvol_section_kind kind, const cvol_bytes *content)
{
    cvol_section_put_header(out, kind, content->size, cvol_crc32c(content->data, content->size));
    cvol_bytes_append(out, content->data, content->size);
    out->failed |= content->failed;
}

/* ---- reading ---------------------------------------------------------------------------- */

cvol_section_walk cvol_section_walk_make(cvol_cursor file)
{
    return (cvol_section_walk){.file = file, .last = CVOL_SECTION_UNKNOWN};
}

static cvol_section_kind kind_of(const uint8_t *tag)
{
    int kind = 0;
    while (kind < CVOL_SECTION_KINDS && memcmp(rows[kind].tag, tag, 4))
        kind++;
    return (cvol_section_kind)kind;
}

/* Lists the tags that may come next: "ATTR or ERRS". */
static void list_followers(char out[96], cvol_section_kind last)
{
    int used = 0;
    out[0] = '\0';
    for (int kind = 0; kind < CVOL_SECTION_KINDS; kind++)
        if (rows[kind].after & BIT(last))
            used += snprintf(out + used, (size_t)(96 - used), "%s%s", used ? " or " : "",
                             rows[kind].tag);
}

static int check_flags(cvol_context *context, const cvol_section *section, const char *name)
{
    if (section->flags & CVOL_SECTION_REQUIRED) {
        if (section->kind == CVOL_SECTION_UNKNOWN)
            return cvol_fail(
                context, CVOL_ERROR_UNSUPPORTED,
                "%s: section %s at byte %llu is needed to decode the file, and unknown "
                "to this library: a newer one may read it",
                name, section->tag, (unsigned long long)section->offset);
        if (section->flags & ~(uint32_t)CVOL_SECTION_REQUIRED)
            return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: section %s at byte %llu has the flags %08x, unknown to this "
                             "library: a newer one may read it",
                             name, section->tag, (unsigned long long)section->offset,
                             section->flags);
    } else if (section->kind != CVOL_SECTION_UNKNOWN && !rows[section->kind].optional) {
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section %s at byte %llu is not flagged as required", name,
                         section->tag, (unsigned long long)section->offset);
    }
    return CVOL_OK;
}

/* Checks the fields of a header whose checksum holds. */
static int check_header(cvol_context *context, const cvol_section *section,
                        const cvol_section_walk *walk, const char *name)
{
    const unsigned long long at = section->offset;
    int code = check_flags(context, section, name);
    if (!code && section->kind != CVOL_SECTION_UNKNOWN &&
        !(rows[section->kind].after & BIT(walk->last))) {
        char wanted[96];
        list_followers(wanted, walk->last);
        code = cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section %s at byte %llu stands where %s must be", name, section->tag,
                         at, wanted);
    }
    return code;
}

/* The place in the file of the section whose header is at byte `at` of the walk's data. */
static uint64_t place_of(const cvol_section_walk *walk, uint64_t at)
{
    const cvol_section_places *places = walk->places;
    if (!places)
        return at;
    uint64_t place = places->front_at;
    for (int i = 0; i < places->count; i++)
        if (at >= places->streams[i].header)
            place = places->streams[i].at;
    return place;
}

int cvol_section_next(cvol_context *context, cvol_section *section, cvol_section_walk *walk,
                      const char *name)
{
    const size_t left = cvol_cursor_left(&walk->file);
    const unsigned long long at = place_of(walk, walk->file.size - left);
    *section = (cvol_section){.kind = CVOL_SECTION_UNKNOWN,
                              .offset = at,
                              .content_offset = walk->places ? at : at + CVOL_SECTION_HEADER_BYTES};
    const uint8_t *header = cvol_cursor_take(&walk->file, CVOL_SECTION_HEADER_BYTES);
    if (!header) {
        char wanted[96];
        list_followers(wanted, walk->last);
        walk->cut = 1;
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated: section %s at byte %llu has only %zu of the %d bytes of "
                         "its header",
                         name, wanted, at, left, (int)CVOL_SECTION_HEADER_BYTES);
    }
    cvol_cursor fields = cvol_cursor_make(header + 4, CVOL_SECTION_HEADER_BYTES - 4);
    section->kind = kind_of(header);
    for (int i = 0; i < 4; i++)
        section->tag[i] = (char)(header[i] > ' ' && header[i] <= '~' ? header[i] : '?');
    section->flags = cvol_cursor_u32(&fields);
    section->length = cvol_cursor_u64(&fields);
    section->checksum = cvol_cursor_u32(&fields);
    const uint32_t stored = cvol_cursor_u32(&fields), found = cvol_crc32c(header, 20);
    if (stored != found)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section %s at byte %llu: its header's checksum is %08x, its fields "
                         "give %08x",
                         name, section->tag, at, stored, found);
    int code = check_header(context, section, walk, name);
    if (code)
        return code;
    if (section->length > cvol_cursor_left(&walk->file)) {
        walk->cut = 1;
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated: section %s at byte %llu has %zu of %llu bytes", name,
                         section->tag, at, cvol_cursor_left(&walk->file),
                         (unsigned long long)section->length);
    }
    section->content = cvol_cursor_take(&walk->file, (size_t)section->length);
    if (section->kind != CVOL_SECTION_UNKNOWN)
        walk->last = section->kind;
    if (cvol_section_walk_ended(walk) && cvol_cursor_left(&walk->file))
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: %zu bytes follow the end, at byte %zu",
                         name, cvol_cursor_left(&walk->file),
                         walk->file.size - cvol_cursor_left(&walk->file));
    return CVOL_OK;
}

int cvol_section_check(cvol_context *context, const cvol_section *section, const char *name)
{
    const uint32_t found = cvol_crc32c(section->content, (size_t)section->length);
    return found == section->checksum ? CVOL_OK
                                      : cvol_section_fail_sum(context, section, found, name);
}

int cvol_section_fail_sum(cvol_context *context, const cvol_section *section, uint32_t found,
                          const char *name)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT,
                     "%s: section %s at byte %llu: checksum is %08x, its content gives %08x", name,
                     section->tag, (unsigned long long)section->offset, section->checksum, found);
}
