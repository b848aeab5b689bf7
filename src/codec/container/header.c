/* Sections HEAD, GEOM, ERRS and MODE: fields in order, and their checks. */
#include "codec/container/header.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "array/block/exact.h"
#include "array/core/summary.h"
#include "base/context.h"
#include "base/grid.h"
#include "codec/brick/brick_shape.h"
#include "codec/brick/subbands.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/true_length.h"
#include "codec/residual/residual_labels.h"

cvol_header cvol_header_of(const cvol_array *array)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    cvol_header header = {.grid = array->grid,
                          .transform = (uint32_t)array->transform,
                          .rank = (uint32_t)array->rank,
                          .block = (uint32_t)array->block,
                          .lapped = (uint32_t)array->lapped,
                          .trellis = (uint32_t)coding->trellis,
                          .brick = coding->brick,
                          .true_length = (uint32_t)coding->true_length,
                          .neural = (uint32_t)coding->neural,
                          .step = ldexp(array->step, coding->true_length),
                          .offset = array->offset,
                          .coefficients = array->coefficients,
                          .error_bound = array->error_bound,
                          .psnr_db = array->psnr_db,
                          .max_error = array->max_error,
                          .threshold = array->threshold,
                          .measured = (uint32_t)array->measured,
                          .summary = *cvol_array_summary(array)};
    if (!array->block)
        header.coefficients = array->whole.low_count + array->whole.sparse_count;
    if (cvol_array_is_volume(array))
        cvol_subband_norms(header.subband_norm, array);
    const cvol_residual_data *residual = cvol_residual_of(array);
    if (residual) {
        header.residual = residual->kind;
        header.fraction = residual->fraction;
        header.rule = residual->rule;
    }
    if (array->mask)
        header.fills = *cvol_mask_fills(array->mask);
    return header;
}

unsigned cvol_header_streams(const cvol_header *header)
{
    unsigned streams = CVOL_STREAMS_SUBBANDS;
    if (header->fills.count)
        streams |= 1u << CVOL_STREAM_MASK;
    if (cvol_residual_has_bricks(header->residual))
        streams |= 1u << CVOL_STREAM_RESIDUAL;
    return streams;
}

int cvol_header_is_volume(const cvol_header *header)
{
    return header->rank == 3 && header->transform == CVOL_DCT && header->block != 0;
}

uint64_t cvol_header_bricks(const cvol_header *header)
{
    uint64_t bricks = 1; /* at most the number of samples */
    for (int a = 0; a < 3; a++)
        bricks *= (header->grid.dims[a] - 1) / header->brick.side[a] + 1;
    return bricks;
}

static int bad(cvol_context *context, const char *name, const char *tag, const char *field,
               double value, const char *must)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section %s: %s is %g, must be %s", name, tag,
                     field, value, must);
}

static int fail_length(cvol_context *context, const char *name, const char *tag,
                       const cvol_cursor *content)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section %s is too short, %zu bytes", name,
                     tag, content->size);
}

/* ---- HEAD ------------------------------------------------------------------------------- */

void cvol_head_put(cvol_bytes *out, const cvol_header *header)
{
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_u64(out, header->grid.dims[a]);
    cvol_bytes_put_u32(out, (uint32_t)header->grid.type);
    cvol_bytes_put_u32(out, header->transform);
    cvol_bytes_put_u32(out, header->rank);
    cvol_bytes_put_u32(out, header->block);
    cvol_bytes_put_u32(out, header->lapped);
    cvol_bytes_put_u32(out, header->trellis);
    cvol_bytes_put_f64(out, header->step);
    cvol_bytes_put_f64(out, header->offset);
    cvol_bytes_put_f64(out, header->error_bound.value_min);
    cvol_bytes_put_f64(out, header->error_bound.value_max);
    cvol_bytes_put_u64(out, header->coefficients);
}

/* Checks transform, rank, block, and the fields that depend on blocks. */
static int check_method(cvol_context *context, const cvol_header *h, const char *name)
{
    if (h->transform < CVOL_DCT || h->transform > CVOL_DFT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: transform is %u, this library reads 1 (dct), 2 (dht) and 3 (dft)",
                         name, h->transform);
    if (h->block != 0 && h->block != 8 && h->block != 16 && h->block != 32)
        return bad(context, name, "HEAD", "block", h->block, "0, 8, 16 or 32");
    if (h->rank < 1 || h->rank > 3)
        return bad(context, name, "HEAD", "rank", h->rank, "1, 2 or 3");
    for (uint32_t a = h->rank; a < 3; a++)
        if (h->grid.dims[a] != 1)
            return bad(context, name, "HEAD", "rank", h->rank, "that of the dims");
    if (h->lapped > 1 || (h->lapped && !(cvol_header_is_volume(h) && h->block == 16)))
        return bad(context, name, "HEAD", "lapped", h->lapped,
                   "0, or 1 of volumes in dct blocks of 16");
    if (h->trellis > 1 || (h->trellis && !(cvol_header_is_volume(h) && h->block == 16)))
        return bad(context, name, "HEAD", "dependent", h->trellis,
                   "0, or 1 of volumes in dct blocks of 16");
    if (h->block ? !(h->step > 0) || !isfinite(h->step) : h->step != 0)
        return bad(context, name, "HEAD", "step", h->step,
                   h->block ? "positive" : "0 without blocks");
    if (h->block ? !isfinite(h->offset) : h->offset != 0)
        return bad(context, name, "HEAD", "offset", h->offset,
                   h->block ? "finite" : "0 without blocks");
    return CVOL_OK;
}

static int check_values(cvol_context *context, const cvol_header *h, const char *name)
{
    const cvol_error_bound *error_bound = &h->error_bound;
    double lo, hi;
    cvol_type_get_range(&lo, &hi, h->grid.type);
    int whole = !cvol_type_is_integer(h->grid.type) ||
                (floor(error_bound->value_min) == error_bound->value_min &&
                 floor(error_bound->value_max) == error_bound->value_max);
    /* A NaN must fail. */
    if (!(error_bound->value_min >= lo && error_bound->value_min <= error_bound->value_max &&
          whole))
        return bad(context, name, "HEAD", "value_min", error_bound->value_min,
                   "a value of the type, <= value_max");
    if (!(error_bound->value_max <= hi))
        return bad(context, name, "HEAD", "value_max", error_bound->value_max,
                   "a value of the type");
    return CVOL_OK;
}

int cvol_head_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                   const char *name)
{
    uint64_t dims[3];
    memset(header, 0, sizeof *header);
    for (int a = 0; a < 3; a++)
        dims[a] = cvol_cursor_u64(content);
    header->brick = cvol_brick_shape_make((const int[3]){0, 0, 0});
    const uint32_t type = cvol_cursor_u32(content);
    header->grid = cvol_grid_make((size_t)dims[0], (size_t)dims[1], (size_t)dims[2],
                                  (cvol_type)type);
    header->transform = cvol_cursor_u32(content);
    header->rank = cvol_cursor_u32(content);
    header->block = cvol_cursor_u32(content);
    header->lapped = cvol_cursor_u32(content);
    header->trellis = cvol_cursor_u32(content);
    header->step = cvol_cursor_f64(content);
    header->offset = cvol_cursor_f64(content);
    header->error_bound.value_min = cvol_cursor_f64(content);
    header->error_bound.value_max = cvol_cursor_f64(content);
    header->coefficients = cvol_cursor_u64(content);
    if (content->failed)
        return fail_length(context, name, "HEAD", content);
    for (int a = 0; a < 3; a++) {
        const int code = cvol_check_size(context, name, "the length of an axis", dims[a]);
        if (code)
            return code;
    }
    int code = cvol_grid_check_file(context, &header->grid, name);
    if (!code)
        code = check_method(context, header, name);
    return code ? code : check_values(context, header, name);
}

/* ---- MODE ------------------------------------------------------------------------------- */

void cvol_modes_put(cvol_bytes *out, const cvol_header *header)
{
    cvol_bytes_put_u32(out, (uint32_t)header->residual);
    cvol_bytes_put_u32(out, (uint32_t)header->fraction);
    cvol_bytes_put_f64(out, header->rule.quantum);
    cvol_bytes_put_u32(out, (uint32_t)header->rule.unit);
    cvol_bytes_put_u32(out, (uint32_t)header->rule.grain);
    cvol_bytes_put_u32(out, (uint32_t)header->fills.count);
    cvol_bytes_put_u32(out, (uint32_t)header->fills.background);
    for (int i = 0; i < header->fills.count; i++)
        cvol_bytes_put_u64(out, header->fills.bits[i]);
}

static int take_fills(cvol_context *context, cvol_header *header, cvol_cursor *content,
                      const char *name)
{
    const uint32_t count = cvol_cursor_u32(content), background = cvol_cursor_u32(content);
    const size_t size = cvol_type_size(header->grid.type);
    if (count > CVOL_FILLS_MAX)
        return bad(context, name, "MODE", "the number of fills", count, "at most 7");
    if (background > (count == 1))
        return bad(context, name, "MODE", "background", background, "0, or 1 if there is one fill");
    header->fills.background = (int)background;
    for (uint32_t i = 0; i < count && !content->failed; i++) {
        const uint64_t bits = cvol_cursor_u64(content);
        if ((size < 8 && bits >> 8 * size) || !cvol_fills_add(&header->fills, bits) ||
            header->fills.count != (int)i + 1)
            return bad(context, name, "MODE", "fill", i, "a bit pattern of the type, and no other");
    }
    if (content->failed)
        return fail_length(context, name, "MODE", content);
    const double value = background ? cvol_fills_value(&header->fills, 0, header->grid.type) : 0;
    const cvol_error_bound *error_bound = &header->error_bound;
    if (background && !(value >= error_bound->value_min && value <= error_bound->value_max))
        return bad(context, name, "MODE", "the background's fill", value,
                   "within value_min .. value_max");
    return CVOL_OK;
}

int cvol_modes_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                    const char *name)
{
    const uint32_t kind = cvol_cursor_u32(content), fraction = cvol_cursor_u32(content);
    cvol_residual_rule *rule = &header->rule;
    *rule = (cvol_residual_rule){.type = header->grid.type,
                                 .exact = kind == CVOL_RESIDUAL_EXACT,
                                 .value_min = header->error_bound.value_min,
                                 .value_max = header->error_bound.value_max};
    rule->quantum = cvol_cursor_f64(content);
    rule->unit = (int)(int32_t)cvol_cursor_u32(content);
    rule->grain = (int)(int32_t)cvol_cursor_u32(content);
    int code = take_fills(context, header, content, name);
    if (code)
        return code;
    if (kind > CVOL_RESIDUAL_LABELS)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: residual kind is %u, this library reads 0 to 4", name, kind);
    header->residual = (cvol_residual_kind)kind;
    header->fraction = (int)fraction;
    if ((kind || header->fills.count) && !cvol_header_is_volume(header))
        return bad(context, name, "MODE", "residual", kind, "0 for arrays that are not volumes");
    if (fraction > CVOL_EXACT_FRACTION_MAX)
        return bad(context, name, "MODE", "fraction", fraction, "at most 10");
    if (kind == CVOL_RESIDUAL_LABELS && header->fills.count)
        return bad(context, name, "MODE", "the number of fills", header->fills.count,
                   "0 for labels");
    if (kind == CVOL_RESIDUAL_LABELS && !cvol_labels_rule_valid(rule))
        return bad(context, name, "MODE", "quantum", rule->quantum,
                   "a label of an integer type, within value_min .. value_max");
    if ((kind == CVOL_RESIDUAL_BOUNDED || kind == CVOL_RESIDUAL_EXACT) &&
        !cvol_residual_rule_valid(rule))
        return bad(context, name, "MODE", "quantum", rule->quantum,
                   "a quantum that the sample type allows");
    return CVOL_OK;
}

/* ---- BRKS ------------------------------------------------------------------------------- */

void cvol_bricks_put(cvol_bytes *out, const cvol_header *header)
{
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_u32(out, (uint32_t)header->brick.side[a]);
    cvol_bytes_put_u32(out, (uint32_t)header->brick.run);
}

int cvol_bricks_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name)
{
    static const char *const names[3] = {"side x", "side y", "side z"};
    uint32_t side[3];
    for (int a = 0; a < 3; a++)
        side[a] = cvol_cursor_u32(content);
    const uint32_t run = cvol_cursor_u32(content);
    if (content->failed)
        return fail_length(context, name, "BRKS", content);
    if (!cvol_header_is_volume(header))
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section BRKS is for volumes in dct blocks, this array is not one",
                         name);
    for (int a = 0; a < 3; a++) {
        if (!cvol_brick_side_is_valid(side[a], (int)header->block))
            return bad(context, name, "BRKS", names[a], side[a],
                       "16, 32, 48 or 64, a multiple of the block");
        header->brick.side[a] = side[a];
    }
    if (run < 1 || run > CVOL_RUN_BRICKS || (run & (run - 1)))
        return bad(context, name, "BRKS", "bricks in a run", run, "1, 2, 4, 8 or 16");
    header->brick.run = run;
    return CVOL_OK;
}

/* ---- TRUE ------------------------------------------------------------------------------- */

void cvol_true_length_section_put(cvol_bytes *out, const cvol_header *header)
{
    cvol_bytes_put_u32(out, header->true_length);
}

int cvol_true_length_section_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                                  const char *name)
{
    header->true_length = cvol_cursor_u32(content);
    if (content->failed)
        return fail_length(context, name, "TRUE", content);
    if (!cvol_header_is_volume(header) || header->block != CVOL_CELL)
        return cvol_fail(
            context, CVOL_ERROR_CORRUPT,
            "%s: section TRUE is for volumes in dct blocks of 16, this array is not one", name);
    if (header->true_length < 1 || header->true_length > CVOL_TRUE_LENGTH_BITS_MAX)
        return bad(context, name, "TRUE", "bits", header->true_length, "1 to 8");
    if (header->residual)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section TRUE is for volumes without a residual, this one has one",
                         name);
    return CVOL_OK;
}

/* ---- SMAL ------------------------------------------------------------------------------- */

void cvol_neural_put(cvol_bytes *out, const cvol_header *header)
{
    cvol_bytes_put_u32(out, header->neural);
}

int cvol_neural_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name)
{
    header->neural = cvol_cursor_u32(content);
    if (content->failed)
        return fail_length(context, name, "SMAL", content);
    if (!cvol_header_is_volume(header) || !header->trellis)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section SMAL is for volumes with trellis quantization, this array "
                         "has none",
                         name);
    if (header->neural != 1)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: section SMAL names networks %u, only 1 is known", name,
                         header->neural);
    return CVOL_OK;
}

/* ---- GEOM ------------------------------------------------------------------------------- */

void cvol_geometry_put(cvol_bytes *out, const cvol_header *header)
{
    const cvol_grid *grid = &header->grid;
    cvol_bytes_put_u32(out, (uint32_t)grid->space);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, grid->spacing[a]);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, grid->origin[a]);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            cvol_bytes_put_f64(out, grid->direction[a][i]);
    char unit[sizeof grid->unit] = {0}; /* zeros after the end make the bytes deterministic */
    for (size_t i = 0; i < sizeof unit - 1 && grid->unit[i]; i++)
        unit[i] = grid->unit[i];
    cvol_bytes_append(out, unit, sizeof unit);
    cvol_bytes_put_f64(out, grid->value_scale);
    cvol_bytes_put_f64(out, grid->value_offset);
}

int cvol_geometry_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                       const char *name)
{
    cvol_grid *grid = &header->grid;
    grid->space = (cvol_space)cvol_cursor_u32(content);
    for (int a = 0; a < 3; a++)
        grid->spacing[a] = cvol_cursor_f64(content);
    for (int a = 0; a < 3; a++)
        grid->origin[a] = cvol_cursor_f64(content);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            grid->direction[a][i] = cvol_cursor_f64(content);
    const uint8_t *unit = cvol_cursor_take(content, sizeof grid->unit);
    if (unit)
        memcpy(grid->unit, unit, sizeof grid->unit);
    grid->value_scale = cvol_cursor_f64(content);
    grid->value_offset = cvol_cursor_f64(content);
    if (content->failed)
        return fail_length(context, name, "GEOM", content);
    if ((unsigned)grid->space > CVOL_SPACE_RAS)
        return bad(context, name, "GEOM", "space", (double)grid->space, "0, 1 or 2");
    if (grid->unit[sizeof grid->unit - 1])
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section GEOM: unit has no end", name);
    return cvol_grid_check_file(context, grid, name);
}

/* ---- ERRS ------------------------------------------------------------------------------- */

enum { POINT_BITS = 13 };

/* The next number with POINT_BITS significant bits: its five low bytes are zero, which packed files
 * code in a few bits. A bound may grow by 1/4096. */
static double round_up(double bound)
{
    int exponent;
    const double share = frexp(bound, &exponent);
    return ldexp(ceil(ldexp(share, POINT_BITS)), exponent - POINT_BITS);
}

void cvol_errors_put(cvol_bytes *out, const cvol_header *header)
{
    cvol_bytes_put_f64(out, header->psnr_db);
    cvol_bytes_put_f64(out, header->max_error);
    cvol_bytes_put_f64(out, header->error_bound.l2_error);
    cvol_bytes_put_f64(out, header->error_bound.max_abs);
    cvol_bytes_put_f64(out, header->threshold);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_put_f64(out, header->subband_norm[s]);
    cvol_bytes_put_u32(out, header->measured);
    const double point = round_up(header->error_bound.point_error);
    const int is_useful = point > 0 && point < header->error_bound.l2_error;
    if (header->error_bound.default_loss > 0 || is_useful)
        cvol_bytes_put_f64(out, header->error_bound.default_loss);
    if (is_useful)
        cvol_bytes_put_f64(out, point);
}

/* An optional field: the part of l2_error that default truncation added, or point_error. Any value
 * beyond 0 .. l2_error counts as 0, not known. */
static double take_part(cvol_cursor *content, double l2_error)
{
    if (cvol_cursor_left(content) < 8)
        return 0;
    const double part = cvol_cursor_f64(content);
    return part > 0 && part <= l2_error ? part : 0;
}

int cvol_errors_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name)
{
    header->psnr_db = cvol_cursor_f64(content);
    if (header->psnr_db >= CVOL_PSNR_EXACT)
        header->psnr_db = (double)INFINITY;
    header->max_error = cvol_cursor_f64(content);
    header->error_bound.l2_error = cvol_cursor_f64(content);
    header->error_bound.max_abs = cvol_cursor_f64(content);
    header->threshold = cvol_cursor_f64(content);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        header->subband_norm[s] = cvol_cursor_f64(content);
    header->measured = cvol_cursor_u32(content);
    if (content->failed)
        return fail_length(context, name, "ERRS", content);
    header->error_bound.default_loss = take_part(content, header->error_bound.l2_error);
    header->error_bound.point_error = take_part(content, header->error_bound.l2_error);
    const struct {
        const char *name;
        double value;
    } fields[] = {
        {"max_error", header->max_error},          {"l2_error", header->error_bound.l2_error},
        {"max_abs", header->error_bound.max_abs},  {"threshold", header->threshold},
        {"shell_norm 0", header->subband_norm[0]}, {"shell_norm 1", header->subband_norm[1]},
        {"shell_norm 2", header->subband_norm[2]}, {"shell_norm 3", header->subband_norm[3]}};
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (!isfinite(fields[i].value) || fields[i].value < 0)
            return bad(context, name, "ERRS", fields[i].name, fields[i].value,
                       "finite and not negative");
    if (isnan(header->psnr_db))
        return bad(context, name, "ERRS", "psnr", header->psnr_db, "a number");
    if (header->measured > 1)
        return bad(context, name, "ERRS", "measured", header->measured, "0 or 1");
    return CVOL_OK;
}
