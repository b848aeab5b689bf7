/* Section HEAD: fields in order, and what must hold of them. */
#include "codec/header.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/context.h"

static void put_grid(cvol_bytes *out, const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_u64(out, grid->dims[a]);
    cvol_bytes_put_u32(out, (uint32_t)grid->type);
    cvol_bytes_put_u32(out, (uint32_t)grid->space);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, grid->spacing[a]);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, grid->origin[a]);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            cvol_bytes_put_f64(out, grid->direction[a][i]);
    char unit[sizeof grid->unit] = {0}; /* zeros behind the end, so that bytes are deterministic */
    for (size_t i = 0; i < sizeof unit - 1 && grid->unit[i]; i++)
        unit[i] = grid->unit[i];
    cvol_bytes_append(out, unit, sizeof unit);
    cvol_bytes_put_f64(out, grid->value_scale);
    cvol_bytes_put_f64(out, grid->value_offset);
}

void cvol_header_put(cvol_bytes *out, const cvol_array *array)
{
    put_grid(out, &array->grid);
    cvol_bytes_put_u32(out, (uint32_t)array->transform);
    cvol_bytes_put_u32(out, (uint32_t)array->block);
    cvol_bytes_put_f64(out, array->step);
    cvol_bytes_put_f64(out, array->offset);
    cvol_bytes_put_f64(out, array->ledger.value_min);
    cvol_bytes_put_f64(out, array->ledger.value_max);
    cvol_bytes_put_f64(out, array->range_min);
    cvol_bytes_put_f64(out, array->range_max);
    cvol_bytes_put_f64(out, array->psnr_db);
    cvol_bytes_put_f64(out, array->max_error);
    cvol_bytes_put_f64(out, array->ledger.l2_error);
    cvol_bytes_put_u64(out, array->block ? array->coefficients
                                         : array->whole.low_count + array->whole.sparse_count);
    cvol_bytes_put_f64(out, array->ledger.max_abs);
    cvol_bytes_put_f64(out, array->threshold);
    cvol_bytes_put_u32(out, (uint32_t)array->measured);
    cvol_bytes_put_u32(out, (uint32_t)array->rank);
}

static void take_grid(cvol_grid *grid, uint64_t dims[3], cvol_cursor *content)
{
    memset(grid, 0, sizeof *grid);
    for (int a = 0; a < 3; a++) {
        dims[a] = cvol_cursor_u64(content);
        grid->dims[a] = (size_t)dims[a];
    }
    grid->type = (cvol_type)cvol_cursor_u32(content);
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
}

static int bad(cvol_context *context, const char *name, const char *field, double value,
               const char *must)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section HEAD: %s is %g, must be %s", name,
                     field, value, must);
}

static int check_values(cvol_context *context, const cvol_header *h, const char *name)
{
    const cvol_ledger *ledger = &h->ledger;
    double lo, hi;
    cvol_type_range(h->grid.type, &lo, &hi);
    int whole = !cvol_type_is_integer(h->grid.type) ||
                (floor(ledger->value_min) == ledger->value_min &&
                 floor(ledger->value_max) == ledger->value_max);
    /* Written so that a NaN fails. */
    if (!(ledger->value_min >= lo && ledger->value_min <= ledger->value_max && whole))
        return bad(context, name, "value_min", ledger->value_min,
                   "a value of the type, <= value_max");
    if (!(ledger->value_max <= hi))
        return bad(context, name, "value_max", ledger->value_max, "a value of the type");
    if (!isfinite(h->range_min) || !(h->range_min <= h->range_max))
        return bad(context, name, "range_min", h->range_min, "finite and <= range_max");
    if (!isfinite(h->range_max) || !isfinite(h->range_max - h->range_min))
        return bad(context, name, "range_max", h->range_max, "finite");
    if (isnan(h->psnr_db))
        return bad(context, name, "psnr", h->psnr_db, "a number");
    if (!isfinite(h->max_error) || h->max_error < 0)
        return bad(context, name, "max_error", h->max_error, "finite and not negative");
    if (!isfinite(ledger->l2_error) || ledger->l2_error < 0)
        return bad(context, name, "l2_error", ledger->l2_error, "finite and not negative");
    if (!isfinite(ledger->max_abs) || ledger->max_abs < 0)
        return bad(context, name, "max_abs", ledger->max_abs, "finite and not negative");
    if (!isfinite(h->threshold) || h->threshold < 0)
        return bad(context, name, "threshold", h->threshold, "finite and not negative");
    if (h->measured > 1)
        return bad(context, name, "measured", h->measured, "0 or 1");
    return CVOL_OK;
}

/* Rank, transform, block, and the two numbers that belong to blocks. */
static int check_method(cvol_context *context, const cvol_header *h, const char *name)
{
    if (h->transform < CVOL_DCT || h->transform > CVOL_DFT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: transform is %u, this library reads 1 (dct), 2 (dht) and 3 (dft)",
                         name, h->transform);
    if (h->block != 0 && h->block != 8 && h->block != 16 && h->block != 32)
        return bad(context, name, "block", h->block, "0, 8, 16 or 32");
    if (h->rank < 1 || h->rank > 3)
        return bad(context, name, "rank", h->rank, "1, 2 or 3");
    for (uint32_t a = h->rank; a < 3; a++)
        if (h->grid.dims[a] != 1)
            return bad(context, name, "rank", h->rank, "that of the dims");
    if (h->block ? !(h->step > 0) || !isfinite(h->step) : h->step != 0)
        return bad(context, name, "step", h->step, h->block ? "positive" : "0 without blocks");
    if (h->block ? !isfinite(h->offset) : h->offset != 0)
        return bad(context, name, "offset", h->offset, h->block ? "finite" : "0 without blocks");
    return CVOL_OK;
}

static int check(cvol_context *context, const cvol_header *h, const uint64_t dims[3],
                 const char *name)
{
    for (int a = 0; a < 3; a++)
        if (dims[a] != h->grid.dims[a])
            return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: axis %c has %llu samples", name,
                             "xyz"[a], (unsigned long long)dims[a]);
    int code = cvol_grid_check(context, &h->grid, name);
    if (code)
        return code;
    if ((unsigned)h->grid.space > CVOL_SPACE_RAS)
        return bad(context, name, "space", (double)h->grid.space, "0, 1 or 2");
    if (h->grid.unit[sizeof h->grid.unit - 1])
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section HEAD: unit has no end", name);
    code = check_method(context, h, name);
    return code ? code : check_values(context, h, name);
}

int cvol_header_is_volume(const cvol_header *header)
{
    return header->rank == 3 && header->transform == CVOL_DCT && header->block != 0;
}

int cvol_header_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name)
{
    uint64_t dims[3];
    take_grid(&header->grid, dims, content);
    header->transform = cvol_cursor_u32(content);
    header->block = cvol_cursor_u32(content);
    header->step = cvol_cursor_f64(content);
    header->offset = cvol_cursor_f64(content);
    header->ledger.value_min = cvol_cursor_f64(content);
    header->ledger.value_max = cvol_cursor_f64(content);
    header->range_min = cvol_cursor_f64(content);
    header->range_max = cvol_cursor_f64(content);
    header->psnr_db = cvol_cursor_f64(content);
    header->max_error = cvol_cursor_f64(content);
    header->ledger.l2_error = cvol_cursor_f64(content);
    header->coefficients = cvol_cursor_u64(content);
    header->ledger.max_abs = cvol_cursor_f64(content);
    header->threshold = cvol_cursor_f64(content);
    header->measured = cvol_cursor_u32(content);
    header->rank = cvol_cursor_u32(content);
    if (content->failed || cvol_cursor_left(content) > 0)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section HEAD has a wrong length, %zu",
                         name, content->size);
    return check(context, header, dims, name);
}
