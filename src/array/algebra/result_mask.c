/* Masks of results: result_mask.h. */
#include "array/algebra/result_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/mask_cells.h"
#include "base/context.h"

enum { CELL = CVOL_MASK_CELL };

/* The background is a value of the result. In exact arithmetic it is `value`: rounding to float32
 * may move it out of the range, and is an error of all its samples. */
static void include_background(cvol_array *out, double value)
{
    if (!cvol_mask_is_background(out->mask))
        return;
    const double stored = cvol_array_background(out), apart = fabs(stored - value);
    cvol_error_bound *bound = &out->error_bound;
    bound->value_min = fmin(bound->value_min, fmin(stored, value));
    bound->value_max = fmax(bound->value_max, fmax(stored, value));
    cvol_error_bound_widen(bound, apart * sqrt((double)cvol_mask_samples(out->mask)), apart);
}

static void drop_if_empty(cvol_mask **mask)
{
    if (!*mask || cvol_mask_samples(*mask))
        return;
    cvol_mask_free(*mask);
    *mask = NULL;
}

/* ---- one operand ----------------------------------------------------------------------------- */

/* Copies a mask, with other fills, as many. */
static int copy_mask(cvol_context *context, cvol_array *out, const cvol_mask *mask,
                     const cvol_fills *fills)
{
    const size_t *dims = out->grid.dims;
    int code = cvol_mask_create(context, &out->mask, dims, fills);
    for (size_t i = 0; i < cvol_mask_place_count(dims) && !code; i++) {
        const cvol_mask_place cell = cvol_mask_place_at(dims, i);
        const cvol_mask_rows *rows;
        const uint8_t state = cvol_mask_cell_get(mask, cell.at, &rows);
        if (state && !cvol_mask_cell_put(out->mask, cell.at, state, rows))
            code = cvol_mask_fail_memory(context);
    }
    return code ? code : cvol_mask_set_fills(context, &out->mask, fills);
}

int cvol_result_mask_scale(cvol_context *context, cvol_array *out, const cvol_array *a,
                           double alpha, double beta)
{
    if (!a->mask)
        return CVOL_OK;
    cvol_fills fills = cvol_mask_result_fills(a);
    const double value = fills.background ? alpha * cvol_array_background(a) + beta : 0;
    if (fills.background)
        fills.bits[0] = cvol_mask_result_bits(value);
    const int code = copy_mask(context, out, a->mask, &fills);
    if (!code)
        include_background(out, value);
    return code;
}

/* The box of samples around a cell that a filter reads, within the volume: mirrored samples lie in
 * it, too. */
static cvol_mask_place widen(const cvol_mask_place *cell, const size_t radius[3],
                             const size_t dims[3])
{
    cvol_mask_place box = *cell;
    for (int a = 0; a < 3; a++) {
        box.begin[a] = cell->begin[a] > radius[a] ? cell->begin[a] - radius[a] : 0;
        box.end[a] = cell->end[a] + radius[a] < dims[a] ? cell->end[a] + radius[a] : dims[a];
    }
    return box;
}

/* Along one axis: a sample stays masked if all samples within the radius are. From `box` to the
 * part of it that the cell has along this axis. */
static void erode_axis(uint8_t *out, const uint8_t *in, cvol_mask_place *box,
                       const cvol_mask_place *cell, int axis, size_t radius)
{
    const size_t size[3] = {box->end[0] - box->begin[0], box->end[1] - box->begin[1],
                            box->end[2] - box->begin[2]};
    const size_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
    const size_t outer = size[0] * size[1] * size[2] / (stride * size[axis]);
    const size_t side = cell->end[axis] - cell->begin[axis];
    const size_t first = cell->begin[axis] - box->begin[axis];
    for (size_t o = 0; o < outer; o++)
        for (size_t x = 0; x < side; x++) {
            const size_t here = first + x, from = here > radius ? here - radius : 0;
            const size_t to = here + radius < size[axis] ? here + radius + 1 : size[axis];
            uint8_t *line = out + (o * side + x) * stride;
            memset(line, 1, stride);
            for (size_t f = from; f < to; f++)
                for (size_t i = 0; i < stride; i++)
                    line[i] &= in[(o * size[axis] + f) * stride + i];
        }
    box->begin[axis] = cell->begin[axis];
    box->end[axis] = cell->end[axis];
}

/* NONE or ALL if all cells that meet the box agree, else SOME. */
static cvol_mask_state state_in(const cvol_mask *mask, const cvol_mask_place *box)
{
    size_t at[3];
    int none = 1, all = 1;
    for (at[2] = box->begin[2] / CELL; at[2] * CELL < box->end[2]; at[2]++)
        for (at[1] = box->begin[1] / CELL; at[1] * CELL < box->end[1]; at[1]++)
            for (at[0] = box->begin[0] / CELL; at[0] * CELL < box->end[0]; at[0]++) {
                const cvol_mask_state state = cvol_mask_cell(mask, at);
                none = none && state == CVOL_MASK_NONE;
                all = all && state == CVOL_MASK_ALL;
            }
    return none ? CVOL_MASK_NONE : all ? CVOL_MASK_ALL : CVOL_MASK_SOME;
}

/* room: two boxes. */
static int erode_cell(cvol_mask *out, const cvol_mask *mask, const cvol_mask_place *cell,
                      const size_t radius[3], const size_t dims[3], uint8_t *room, size_t half)
{
    cvol_mask_place box = widen(cell, radius, dims);
    uint8_t *in = room, *to = room + half;
    if (cvol_mask_cell(mask, cell->at) == CVOL_MASK_NONE)
        return 1;
    if (state_in(mask, &box) == CVOL_MASK_ALL)
        return cvol_mask_cell_put(out, cell->at, 1, NULL);
    cvol_mask_get(in, mask, box.begin, box.end);
    for (int a = 0; a < 3; a++) {
        erode_axis(to, in, &box, cell, a, radius[a]);
        uint8_t *const other = in;
        in = to;
        to = other;
    }
    return !memchr(in, 1, cvol_mask_place_samples(cell)) ||
           cvol_mask_set(out, in, cell->begin, cell->end);
}

/* The background of a filter's result: where the filter reads nothing else. */
static int erode(cvol_context *context, cvol_array *out, const cvol_mask *mask,
                 const size_t radius[3], double value)
{
    const cvol_fills fills = {.count = 1, .background = 1, .bits = {cvol_mask_result_bits(value)}};
    const size_t *dims = out->grid.dims;
    size_t half = 1;
    for (int a = 0; a < 3; a++)
        half *= CELL + 2 * radius[a];
    int code = cvol_mask_create(context, &out->mask, dims, &fills);
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context)) if (!code)
    {
        uint8_t *room = code ? NULL : malloc(2 * half);
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < cvol_mask_place_count(dims); i++) {
            const cvol_mask_place cell = cvol_mask_place_at(dims, i);
            if (!room || !erode_cell(out->mask, mask, &cell, radius, dims, room, half)) {
#pragma omp atomic write
                failed = 1;
            }
        }
        free(room);
    }
    return !code && failed ? cvol_mask_fail_memory(context) : code;
}

int cvol_result_mask_filter(cvol_context *context, cvol_array *out, const cvol_array *a,
                            const size_t radius[3], double factor)
{
    if (!a->mask)
        return CVOL_OK;
    if (!cvol_mask_is_background(a->mask)) {
        const cvol_fills fills = cvol_mask_result_fills(a);
        return copy_mask(context, out, a->mask, &fills);
    }
    const double value = factor * cvol_array_background(a);
    const int code = erode(context, out, a->mask, radius, value);
    if (code)
        return code;
    drop_if_empty(&out->mask);
    include_background(out, value);
    return CVOL_OK;
}

/* ---- two operands ---------------------------------------------------------------------------- */

typedef struct combination {
    const cvol_array *operands[2];
    int is_void[2], is_background[2];
    int absorbs[2];                        /* a background of zero in a product */
    uint8_t number[2][CVOL_FILLS_MAX + 1]; /* of the fills of samples without a value, in `fills` */
    cvol_fills fills;
} combination;

static combination combination_of(const cvol_array *a, const cvol_array *b, int is_product,
                                  double value)
{
    combination c = {.operands = {a, b}};
    for (int i = 0; i < 2; i++) {
        const cvol_array *operand = c.operands[i];
        c.is_void[i] = cvol_mask_is_void(operand->mask);
        c.is_background[i] = cvol_mask_is_background(operand->mask);
        c.absorbs[i] = is_product && c.is_background[i] && cvol_array_background(operand) == 0;
    }
    if (!c.is_void[0] && !c.is_void[1]) {
        c.fills = (cvol_fills){.count = 1, .background = 1, .bits = {cvol_mask_result_bits(value)}};
        return c;
    }
    for (int i = 0; i < 2; i++) {
        if (!c.is_void[i])
            continue;
        const cvol_fills own = cvol_mask_result_fills(c.operands[i]);
        cvol_fills_unite(c.number[i], &c.fills, &own);
    }
    return c;
}

/* The fill of a sample of the result, from those of the operands; 0: none. */
static uint8_t combine(const combination *c, uint8_t a, uint8_t b)
{
    const uint8_t of[2] = {a, b};
    if (!c->is_void[0] && !c->is_void[1])
        return (a && b) || (a && c->absorbs[0]) || (b && c->absorbs[1]);
    for (int i = 0; i < 2; i++)
        if (c->is_void[i] && of[i])
            return c->number[i][of[i]];
    return 0;
}

static void read_cell(uint8_t *which, const cvol_array *a, const cvol_mask_place *cell)
{
    if (a->mask)
        cvol_mask_get(which, a->mask, cell->begin, cell->end);
    else
        memset(which, 0, cvol_mask_place_samples(cell));
}

/* Sets one cell of the result's mask and of those of the operands. */
static int combine_cell(const combination *c, cvol_mask *out, cvol_mask *const less[2],
                        const cvol_mask_place *cell)
{
    uint8_t of[2][CVOL_MASK_CELL_SAMPLES], result[CVOL_MASK_CELL_SAMPLES];
    const size_t count = cvol_mask_place_samples(cell);
    int is_masked = 0, done = 1;
    for (int i = 0; i < 2; i++)
        read_cell(of[i], c->operands[i], cell);
    for (size_t s = 0; s < count; s++) {
        result[s] = combine(c, of[0][s], of[1][s]);
        is_masked |= result[s];
    }
    if (is_masked)
        done = cvol_mask_set(out, result, cell->begin, cell->end);
    for (int i = 0; i < 2 && done; i++) {
        int differs = 0;
        for (size_t s = 0; s < count; s++) {
            of[i][s] = of[i][s] && c->is_background[i] && !result[s];
            differs |= of[i][s];
        }
        if (differs)
            done = cvol_mask_set(less[i], of[i], cell->begin, cell->end);
    }
    return done;
}

/* ---- two operands, by rows of bits ----------------------------------------------------------- */

/* True if the masks of the operands and of the result have one fill each. */
static int has_single_fills(const combination *c)
{
    for (int i = 0; i < 2; i++)
        if (c->operands[i]->mask && cvol_mask_fills(c->operands[i]->mask)->count != 1)
            return 0;
    return c->fills.count == 1;
}

static void read_rows(cvol_mask_rows *rows, const cvol_array *a, const cvol_mask_place *cell,
                      const cvol_mask_rows *inside)
{
    const cvol_mask_rows *mixed;
    const uint8_t state = a->mask ? cvol_mask_cell_get(a->mask, cell->at, &mixed) : 0;
    if (state == CVOL_MASK_MIXED)
        *rows = *mixed;
    else if (state)
        *rows = *inside;
    else
        memset(rows, 0, sizeof *rows);
}

static int write_rows(cvol_mask *mask, const cvol_mask_place *cell, const cvol_mask_rows *rows,
                      const cvol_mask_rows *inside)
{
    unsigned any = 0;
    for (int k = 0; k < CVOL_MASK_ROWS; k++)
        any |= rows->of[k];
    if (!any)
        return 1;
    const int all = memcmp(rows, inside, sizeof *rows) == 0;
    return cvol_mask_cell_put(mask, cell->at, all ? 1 : CVOL_MASK_MIXED, rows);
}

/* The samples of a cell that lie in the volume. */
static void fill_inside(cvol_mask_rows *inside, const cvol_mask_place *cell)
{
    const uint16_t row = (uint16_t)((1u << (cell->end[0] - cell->begin[0])) - 1);
    memset(inside, 0, sizeof *inside);
    for (size_t z = 0; z < cell->end[2] - cell->begin[2]; z++)
        for (size_t y = 0; y < cell->end[1] - cell->begin[1]; y++)
            inside->of[y + CELL * z] = row;
}

/* combine_cell for masks with one fill each. */
static int combine_rows(const combination *c, cvol_mask *out, cvol_mask *const less[2],
                        const cvol_mask_place *cell)
{
    cvol_mask_rows inside, of[2], result;
    fill_inside(&inside, cell);
    for (int i = 0; i < 2; i++)
        read_rows(&of[i], c->operands[i], cell, &inside);
    const int one_is_void = c->is_void[0] || c->is_void[1];
    const uint16_t both = one_is_void ? 0 : 0xffff;
    const uint16_t alone[2] = {(one_is_void ? c->is_void[0] : c->absorbs[0]) ? 0xffff : 0,
                               (one_is_void ? c->is_void[1] : c->absorbs[1]) ? 0xffff : 0};
    for (int k = 0; k < CVOL_MASK_ROWS; k++)
        result.of[k] = (uint16_t)((of[0].of[k] & of[1].of[k] & both) | (of[0].of[k] & alone[0]) |
                                  (of[1].of[k] & alone[1]));
    int done = write_rows(out, cell, &result, &inside);
    for (int i = 0; i < 2 && done; i++) {
        if (!c->is_background[i])
            continue;
        for (int k = 0; k < CVOL_MASK_ROWS; k++)
            of[i].of[k] &= (uint16_t)~result.of[k];
        done = write_rows(less[i], cell, &of[i], &inside);
    }
    return done;
}

static int is_clear(const cvol_array *a, const cvol_mask_place *cell)
{
    return !a->mask || cvol_mask_cell(a->mask, cell->at) == CVOL_MASK_NONE;
}

int cvol_result_mask_combine(cvol_context *context, cvol_array *out, cvol_masked_operands *operands,
                             const cvol_array *a, const cvol_array *b, int is_product, double value)
{
    *operands = (cvol_masked_operands){.a = *a, .b = *b};
    operands->a.mask = operands->b.mask = NULL;
    if (!a->mask && !b->mask)
        return CVOL_OK;
    const combination c = combination_of(a, b, is_product, value);
    const size_t *dims = out->grid.dims;
    int code = cvol_mask_create(context, &out->mask, dims, &c.fills);
    for (int i = 0; i < 2 && !code; i++)
        if (c.is_background[i])
            code = cvol_mask_create(context, &operands->masks[i], dims,
                                    cvol_mask_fills(c.operands[i]->mask));
    const int single = has_single_fills(&c);
    for (size_t i = 0; i < cvol_mask_place_count(dims) && !code; i++) {
        const cvol_mask_place cell = cvol_mask_place_at(dims, i);
        if (is_clear(a, &cell) && is_clear(b, &cell))
            continue;
        if (!(single ? combine_rows : combine_cell)(&c, out->mask, operands->masks, &cell))
            code = cvol_mask_fail_memory(context);
    }
    if (code)
        return code;
    drop_if_empty(&out->mask);
    include_background(out, value);
    drop_if_empty(&operands->masks[0]);
    drop_if_empty(&operands->masks[1]);
    operands->a.mask = operands->masks[0];
    operands->b.mask = operands->masks[1];
    return CVOL_OK;
}

void cvol_masked_operands_free(cvol_masked_operands *operands)
{
    cvol_mask_free(operands->masks[0]);
    cvol_mask_free(operands->masks[1]);
}

/* Returns 1 if the mask has a sample in a cell that meets the box. */
static int meets(const cvol_mask *mask, const size_t begin[3], const size_t end[3])
{
    size_t at[3];
    for (at[2] = begin[2] / CELL; at[2] * CELL < end[2]; at[2]++)
        for (at[1] = begin[1] / CELL; at[1] * CELL < end[1]; at[1]++)
            for (at[0] = begin[0] / CELL; at[0] * CELL < end[0]; at[0]++)
                if (cvol_mask_cell(mask, at) != CVOL_MASK_NONE)
                    return 1;
    return 0;
}

int cvol_masked_operands_differ(const cvol_masked_operands *operands, size_t index, size_t margin)
{
    size_t begin[3], end[3];
    if (!operands->masks[0] && !operands->masks[1])
        return 0;
    cvol_block_origin(begin, &operands->a, index);
    for (int a = 0; a < 3; a++) {
        const size_t dim = operands->a.grid.dims[a];
        end[a] = begin[a] + cvol_block_side(&operands->a, a) + margin;
        end[a] = end[a] < dim ? end[a] : dim;
        begin[a] = begin[a] > margin ? begin[a] - margin : 0;
    }
    return (operands->masks[0] && meets(operands->masks[0], begin, end)) ||
           (operands->masks[1] && meets(operands->masks[1], begin, end));
}
