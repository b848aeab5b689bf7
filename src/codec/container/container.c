/* The container: signature, version, sections in order, and the array that they make.
 *
 * The reader first follows the sections' headers through the file, to find which sections exist and
 * if the file is whole. Then it reads contents, each after its checksum, and only the subbands that
 * the caller asks for. */
#include "codec/container/container.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "codec/brick/subbands.h"
#include "codec/container/header.h"
#include "codec/container/plane_file.h"
#include "codec/container/ranges.h"
#include "codec/container/section_pack.h"
#include "codec/container/series.h"
#include "codec/container/summary_section.h"
#include "codec/container/terms.h"
#include "codec/mask/mask_section.h"
#include "codec/quantize/coding.h"
#include "codec/section/signature.h"

/* ---- the file's sections ---------------------------------------------------------------- */

/* One reading of a file. */
typedef struct reading {
    cvol_context *context;
    const char *name;
    cvol_file_part part;
    cvol_section sections[CVOL_SECTION_KINDS];
    uint32_t present; /* bit `kind` */
    int subbands;     /* number of whole subbands */
    int used;         /* number of requested subbands that exist */
    int cut;          /* the file ends early */
    int is_dry_run;   /* only test: the array is discarded */
    cvol_header header;
    cvol_array *array;
    cvol_unpacked unpacked; /* of a packed file: the places of its sections */
} reading;

static int has(const reading *r, cvol_section_kind kind)
{
    return (int)(r->present >> kind & 1);
}

static int is_partial(const reading *r)
{
    return r->part.begin || r->part.level || r->part.brick_levels;
}

/* True if the file has a residual, but the array is without it: the file ends before it, or the
 * part is a coarse level. The kind of residual is first in MODE. */
static int lacks_residual(const reading *r)
{
    const cvol_section *mode = &r->sections[CVOL_MODE];
    return (r->cut || r->used < CVOL_SUBBANDS || r->part.brick_levels) && !has(r, CVOL_CORR) &&
           has(r, CVOL_MODE) && mode->length > 0 && mode->content[0] > 0;
}

/* Adds to the message about a cut file the level that is still whole. */
static int append_level(const reading *r, int code)
{
    char what[CVOL_MESSAGE_BYTES];
    if (!r->subbands)
        return code;
    strcpy(what, cvol_context_message(r->context));
    return cvol_fail(r->context, code, "%s; it is whole up to level %d%s", what,
                     CVOL_SUBBANDS - r->subbands,
                     lacks_residual(r) && r->subbands == CVOL_SUBBANDS
                         ? ", without the residual that makes it exact or keeps its bound"
                         : "");
}

/* Labels have no coarse levels: their samples stand behind the terms, which are a rough preview. */
static int has_labels(const reading *r)
{
    const cvol_section *mode = &r->sections[CVOL_MODE];
    return has(r, CVOL_MODE) && mode->length > 0 && mode->content[0] == CVOL_RESIDUAL_LABELS;
}

/* True if nothing behind the last requested subband matters. */
static int ends_with_subbands(const reading *r)
{
    return r->part.level || r->part.brick_levels;
}

/* Follows the sections as far as needed: to the end, or to the last subband of a level. */
static int follow(reading *r, cvol_cursor file)
{
    cvol_section_walk walk = cvol_section_walk_make(file);
    walk.places = r->unpacked.plain.data ? &r->unpacked.places : NULL;
    while (!cvol_section_walk_ended(&walk) && !(ends_with_subbands(r) && r->subbands == r->used)) {
        cvol_section section;
        int code = cvol_section_next(r->context, &section, &walk, r->name);
        if (code && walk.cut) {
            r->cut = 1;
            if (has_labels(r)) /* no level of them is whole */
                return code;
            return r->part.cut && r->subbands ? CVOL_OK : append_level(r, code);
        }
        if (!code && section.kind == CVOL_SECTION_UNKNOWN && !is_partial(r))
            code = cvol_section_check(r->context, &section, r->name);
        if (code)
            return code;
        if (section.kind == CVOL_SECTION_UNKNOWN)
            continue;
        r->sections[section.kind] = section;
        r->present |= UINT32_C(1) << section.kind;
        if (section.kind >= CVOL_SHL0 && section.kind <= CVOL_SHL3)
            r->subbands++;
        if (section.kind == CVOL_MODE && has_labels(r)) {
            if (r->part.brick_levels)
                return cvol_fail(r->context, CVOL_ERROR_UNSUPPORTED,
                                 "%s: its samples are labels, whose bricks have no levels",
                                 r->name);
            r->part.level = 0;
            r->used = CVOL_SUBBANDS;
        }
    }
    return CVOL_OK;
}

/* Requires a section that the header asks for, and checks it. */
static int need(reading *r, cvol_section_kind kind)
{
    if (!has(r, kind))
        return cvol_fail(r->context, CVOL_ERROR_CORRUPT,
                         "%s: section %s is missing, which the shape in section HEAD needs",
                         r->name, cvol_section_tag(kind));
    return cvol_section_check(r->context, &r->sections[kind], r->name);
}

/* ---- all arrays ------------------------------------------------------------------------- */

/* Checks that a box of samples is not empty and lies within the array. */
static int check_box(const reading *r)
{
    if (!r->part.begin != !r->part.end)
        return cvol_fail(r->context, CVOL_ERROR_ARGUMENT,
                         "%s: a box needs begin and end, and has only its %s", r->name,
                         r->part.begin ? "begin" : "end");
    for (int a = 0; r->part.begin && a < 3; a++) {
        const size_t begin = r->part.begin[a], end = r->part.end[a];
        const char *wrong = begin == end                   ? "is empty"
                            : begin > end                  ? "is reversed"
                            : end > r->header.grid.dims[a] ? "reaches beyond the volume"
                                                           : NULL;
        if (wrong)
            return cvol_fail(r->context, CVOL_ERROR_ARGUMENT,
                             "%s: the box %s along %c: it is %zu:%zu there, the volume 0:%zu",
                             r->name, wrong, "xyz"[a], begin, end, r -> header.grid.dims[a]);
    }
    return CVOL_OK;
}

/* Checks the levels of bricks. */
static int check_brick_levels(const reading *r)
{
    const cvol_file_part *part = &r->part;
    if (!part->brick_levels)
        return CVOL_OK;
    if (part->begin || r->unpacked.plain.data || !cvol_header_is_volume(&r->header))
        return cvol_fail(r->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: levels of bricks exist for volumes in dct blocks of files that are "
                         "not packed, and without a box",
                         r->name);
    const uint64_t bricks = cvol_header_bricks(&r->header);
    if (part->brick_count != bricks)
        return cvol_fail(r->context, CVOL_ERROR_ARGUMENT,
                         "%s: there are levels of %zu bricks, the volume has %llu", r->name,
                         part->brick_count, (unsigned long long)bricks);
    for (size_t b = 0; b < bricks; b++)
        if (part->brick_levels[b] < part->level || part->brick_levels[b] >= CVOL_SUBBANDS)
            return cvol_fail(r->context, CVOL_ERROR_ARGUMENT,
                             "%s: the level of brick %zu is %d, must be %d to %d", r->name, b,
                             part->brick_levels[b], part->level, CVOL_SUBBANDS - 1);
    return CVOL_OK;
}

/* The coarsest level of the array's bricks. */
static int coarsest_level(const reading *r)
{
    int level = CVOL_SUBBANDS - r->used;
    for (size_t b = 0; r->part.brick_levels && b < r->part.brick_count; b++)
        if (level < r->part.brick_levels[b])
            level = r->part.brick_levels[b];
    return level;
}

/* Reads HEAD, GEOM, ERRS and, if they exist, MODE, BRKS, TRUE, SMAL and SUMM. */
static int read_header(reading *r)
{
    typedef struct record {
        cvol_section_kind kind;
        int (*take)(cvol_context *, cvol_header *, cvol_cursor *, const char *);
    } record;
    static const record parts[] = {{CVOL_HEAD, cvol_head_take},
                                   {CVOL_GEOM, cvol_geometry_take},
                                   {CVOL_ERRS, cvol_errors_take}};
    static const record others[] = {{CVOL_MODE, cvol_modes_take},
                                    {CVOL_BRKS, cvol_bricks_take},
                                    {CVOL_TRUE, cvol_true_length_section_take},
                                    {CVOL_SMAL, cvol_neural_take},
                                    {CVOL_SUMM, cvol_summary_take}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        int code = need(r, parts[i].kind);
        cvol_cursor content = cvol_section_cursor(&r->sections[parts[i].kind]);
        if (!code)
            code = parts[i].take(r->context, &r->header, &content, r->name);
        if (code)
            return code;
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (!has(r, others[i].kind))
            continue;
        cvol_cursor content = cvol_section_cursor(&r->sections[others[i].kind]);
        int code = need(r, others[i].kind);
        if (!code)
            code = others[i].take(r->context, &r->header, &content, r->name);
        if (code)
            return code;
    }
    int code = check_box(r);
    return code ? code : check_brick_levels(r);
}

static int read_attributes(reading *r)
{
    if (!has(r, CVOL_ATTR))
        return CVOL_OK;
    const cvol_section *section = &r->sections[CVOL_ATTR];
    int code = need(r, CVOL_ATTR);
    if (code)
        return code;
    if (section->length > CVOL_ATTRIBUTES_MAX)
        return cvol_fail(r->context, CVOL_ERROR_LIMIT,
                         "%s: section ATTR has %llu bytes, more than %d", r->name,
                         (unsigned long long)section->length, (int)CVOL_ATTRIBUTES_MAX);
    if (!cvol_attributes_are_text((const char *)section->content, (size_t)section->length))
        return cvol_fail(r->context, CVOL_ERROR_CORRUPT, "%s: section ATTR is not UTF-8 text",
                         r->name);
    return cvol_array_keep_attributes(r->context, r->array, (const char *)section->content,
                                      (size_t)section->length);
}

static int make_array(reading *r)
{
    const cvol_header *header = &r->header;
    int code = cvol_array_create_as(r->context, &r->array, &header->grid, (int)header->rank,
                                    (cvol_transform)header->transform, (int)header->block);
    if (!code)
        code = cvol_coding_need(r->context, r->array);
    if (code)
        return code;
    cvol_array *array = r->array;
    cvol_file_coding *coding = cvol_coding_own(array);
    coding->true_length = (int)header->true_length;
    coding->trellis = (int)header->trellis;
    coding->neural = (int)header->neural;
    coding->brick = header->brick;
    array->step = ldexp(header->step, -coding->true_length);
    array->offset = header->offset;
    array->lapped = (int)header->lapped;
    array->error_bound = header->error_bound;
    array->threshold = header->threshold;
    array->measured = (int)header->measured;
    array->psnr_db = header->psnr_db;
    array->max_error = header->max_error;
    code = cvol_array_set_summary(r->context, array, &header->summary);
    return code ? code : read_attributes(r);
}

/* ---- volumes ---------------------------------------------------------------------------- */

/* Requires a section whose checksums are in the index. */
static int need_stream(const reading *r, cvol_section_kind kind)
{
    if (has(r, kind))
        return CVOL_OK;
    return cvol_fail(r->context, CVOL_ERROR_CORRUPT,
                     "%s: section %s is missing, but section MODE needs it", r->name,
                     cvol_section_tag(kind));
}

/* Reads MASK and CORR; CORR only with the complete base. */
static int read_modes(reading *r, const cvol_brick_index *index, const cvol_token_tables *tables,
                      const cvol_box *box)
{
    const cvol_header *header = &r->header;
    int code = CVOL_OK;
    if (header->fills.count) {
        code = need_stream(r, CVOL_MASK);
        if (!code)
            code = cvol_mask_take(r->context, r->array, &header->fills, index,
                                  &r->sections[CVOL_MASK], box, r->name);
    }
    if (code || !header->residual || r->used < CVOL_SUBBANDS || r->part.brick_levels ||
        (r->cut && !has(r, CVOL_CORR)))
        return code;
    const cvol_residual_file file = {.kind = header->residual,
                                     .fraction = header->fraction,
                                     .rule = &header->rule,
                                     .tables = tables,
                                     .index = index,
                                     .section = &r->sections[CVOL_CORR],
                                     .box = box};
    code = need_stream(r, CVOL_CORR);
    return code ? code : cvol_residual_take(r->context, r->array, &file, r->name);
}

/* The samples whose terms a box needs: exact residuals of float types are coded by the exponents of
 * the base, so that those of a brick need all of its base. */
static cvol_box box_of_terms(const reading *r, const cvol_box *box)
{
    const cvol_header *header = &r->header;
    const size_t *side = cvol_coding_of(r->array)->brick.side, *dims = r->array->grid.dims;
    cvol_box out = *box;
    if (header->residual && cvol_residual_rule_needs_base(&header->rule))
        for (int a = 0; a < 3; a++) {
            out.begin[a] -= out.begin[a] % side[a];
            const size_t over = (side[a] - out.end[a] % side[a]) % side[a];
            out.end[a] = over < dims[a] - out.end[a] ? out.end[a] + over : dims[a];
        }
    return out;
}

static int read_bricks(reading *r, const cvol_brick_index *index)
{
    /* A residual needs the terms for its check. */
    cvol_brick_source source = {.index = index,
                                .count = r->used,
                                .levels = r->part.brick_levels,
                                .is_checked = r->is_dry_run && !r->header.residual};
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_cursor content = cvol_section_cursor(&r->sections[CVOL_TABL]);
    int code = tables ? cvol_token_tables_take(r->context, tables, &content, r->name)
                      : cvol_fail_memory(r->context, 1 << 16, "the coder's tables");
    for (int s = 0; s < r->used && !code; s++) {
        const cvol_section *section = &r->sections[CVOL_SHL0 + s];
        source.subbands[s] = section->content;
        code = cvol_brick_index_check(r->context, index, s, section, r->name);
    }
    cvol_box box, of_terms;
    if (r->part.begin) {
        memcpy(box.begin, r->part.begin, sizeof box.begin);
        memcpy(box.end, r->part.end, sizeof box.end);
        of_terms = box_of_terms(r, &box);
    }
    if (!code)
        code = cvol_bricks_decode(r->context, r->array, tables, &source,
                                  r->part.begin ? &of_terms : NULL, r->name);
    if (!code)
        code = read_modes(r, index, tables, r->part.begin ? &box : NULL);
    free(tables);
    return code;
}

static int read_volume(reading *r)
{
    cvol_brick_index index = {0};
    int code = need(r, CVOL_TABL);
    if (!code)
        code = need(r, CVOL_INDX);
    if (!code)
        code = cvol_brick_index_take_streams(r->context, &index, &r->sections[CVOL_INDX],
                                             cvol_header_bricks(&r->header), r->header.brick.run,
                                             cvol_header_streams(&r->header), r->name);
    if (!code)
        code = make_array(r);
    const int coarsest = coarsest_level(r);
    const int has_ranges = has(r, CVOL_RNGE) && !coarsest &&
                           (!r->part.begin || r->part.with_ranges);
    if (!code && has_ranges)
        code = need(r, CVOL_RNGE);
    if (!code && has_ranges)
        code = cvol_ranges_take(r->context, r->array, &r->sections[CVOL_RNGE], r->name);
    if (!code)
        code = read_bricks(r, &index);
    if (!code && coarsest)
        cvol_subbands_bound_level(r->array, r->header.subband_norm, coarsest);
    else if (!code && lacks_residual(r)) /* measured figures are of samples with the residual */
        cvol_array_derive_figures(r->array);
    cvol_brick_index_free(&index);
    return code;
}

/* ---- other arrays ----------------------------------------------------------------------- */

static int read_terms(reading *r)
{
    const cvol_section_kind kind = r->header.block ? CVOL_TERM : CVOL_SPEC;
    int code = need(r, kind);
    cvol_cursor content = cvol_section_cursor(&r->sections[kind]);
    if (!code && r->header.block)
        code = cvol_terms_check_length(r->context, &r->header, &content, r->name);
    if (!code)
        code = make_array(r);
    if (code)
        return code;
    return r->header.block ? cvol_terms_take(r->context, r->array, &r->header, &content, r->name)
                           : cvol_spectrum_take(r->context, r->array, &content, r->name);
}

/* ---- the whole -------------------------------------------------------------------------- */

/* Compares the number of terms with the header. */
static int check_count(const reading *r)
{
    cvol_array_info info;
    if (cvol_header_is_volume(&r->header) &&
        (r->part.begin || r->part.brick_levels || r->used < CVOL_SUBBANDS))
        return CVOL_OK;
    cvol_array_get_info(&info, r->array);
    if (info.coefficients == r->header.coefficients)
        return CVOL_OK;
    return cvol_fail(
        r->context, CVOL_ERROR_CORRUPT, "%s: there are %llu coefficients, section HEAD says %llu",
        r->name, (unsigned long long)info.coefficients, (unsigned long long)r->header.coefficients);
}

/* Reads the file's sections, as far as needed, and its header. */
static int read_front(reading *r, const uint8_t *data, size_t size)
{
    cvol_cursor file = cvol_cursor_make(data, size);
    int code = cvol_container_take_start(r->context, &file, r->name);
    if (code)
        return code;
    const cvol_file_kind kind = cvol_plane_file_kind(data, size);
    if (kind != CVOL_FILE_ARRAY)
        return cvol_fail(
            r->context, CVOL_ERROR_FORMAT,
            kind == CVOL_FILE_PICTURE
                ? "%s: is a compressed picture, not a volume: cvol decompress makes a PNG "
                  "of it"
            : kind == CVOL_FILE_SERIES
                ? "%s: is a file of many volumes, where one must be"
                : "%s: is a baked volume, which has no samples any more: cvol render "
                  "--engine transform makes pictures of it",
            r->name);
    if (r->part.level < 0 || r->part.level >= CVOL_SUBBANDS)
        return cvol_fail(r->context, CVOL_ERROR_ARGUMENT, "level is %d, must be 0 to %d",
                         r->part.level, CVOL_SUBBANDS - 1);
    r->used = CVOL_SUBBANDS - r->part.level;
    if (cvol_pack_detect(data, size)) {
        code = cvol_unpack(r->context, &r->unpacked, data, size, r->name);
        file = cvol_cursor_make(r->unpacked.plain.data, r->unpacked.plain.size);
        cvol_cursor_take(&file, CVOL_SECTIONS_AT);
    }
    if (!code)
        code = follow(r, file);
    return code ? code : read_header(r);
}

static int read_all(reading *r, const uint8_t *data, size_t size)
{
    int code = read_front(r, data, size);
    if (code)
        return code;
    if (r->used > r->subbands)
        r->used = r->subbands;
    code = cvol_header_is_volume(&r->header) ? read_volume(r) : read_terms(r);
    return code ? code : check_count(r);
}

/* In a file of many volumes: goes to the requested volume and writes its name into `place`; in
 * other files it keeps the file itself. */
static int find_volume(reading *r, cvol_series_place *place, const uint8_t **data, size_t *size)
{
    const cvol_file_part *part = &r->part;
    cvol_series *series;
    if (cvol_plane_file_kind(*data, *size) != CVOL_FILE_SERIES && !part->time && !part->channel)
        return CVOL_OK;
    int code = cvol_series_take(r->context, &series, *data, *size, r->name);
    if (!code)
        code = cvol_series_find(r->context, place, series, part->time, part->channel, *data, *size,
                                r->name);
    cvol_series_free(series);
    if (code)
        return code;
    r->name = place->name;
    *data = place->data;
    *size = place->size;
    return CVOL_OK;
}

int cvol_container_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                             const uint8_t *data, size_t size, const cvol_file_part *part,
                             const char *name)
{
    reading r = {.context = context, .name = name};
    cvol_series_place place;
    if (part)
        r.part = *part;
    *out = NULL;
    int code = find_volume(&r, &place, &data, &size);
    if (!code)
        code = read_all(&r, data, size);
    const int residual_missing = !code && (r.used == CVOL_SUBBANDS || !r.cut) && lacks_residual(&r);
    cvol_unpacked_free(&r.unpacked);
    if (code) {
        cvol_array_free(r.array);
        return code;
    }
    *out = r.array;
    if (report)
        *report = (cvol_file_report){
            .file_bytes = size,
            .level = cvol_header_is_volume(&r.header) ? CVOL_SUBBANDS - r.used : 0,
            .cut = r.cut,
            .residual_missing = residual_missing};
    return CVOL_OK;
}

int cvol_container_read_grid(cvol_context *context, cvol_grid *out, const uint8_t *data,
                             size_t size, const cvol_file_part *part, const char *name)
{
    reading r = {.context = context, .name = name};
    cvol_series_place place;
    /* The coarsest subband is first: later sections are not read. */
    r.part = (cvol_file_part){.size = sizeof(cvol_file_part), .level = CVOL_SUBBANDS - 1, .cut = 1};
    r.part.time = part ? part->time : 0;
    r.part.channel = part ? part->channel : 0;
    int code = find_volume(&r, &place, &data, &size);
    if (!code)
        code = read_front(&r, data, size);
    cvol_unpacked_free(&r.unpacked);
    if (!code)
        *out = r.header.grid;
    return code;
}

int cvol_container_read(cvol_context *context, cvol_array **out, const uint8_t *data, size_t size,
                        const char *name)
{
    return cvol_container_read_part(context, out, NULL, data, size, NULL, name);
}

int cvol_container_try(cvol_context *context, const uint8_t *data, size_t size, const char *name)
{
    reading r = {.context = context, .name = name, .is_dry_run = 1};
    const int code = read_all(&r, data, size);
    cvol_unpacked_free(&r.unpacked);
    cvol_array_free(r.array);
    return code;
}
