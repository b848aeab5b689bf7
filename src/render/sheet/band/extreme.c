/* Maxima and minima: the values of pixels, and blocks that cannot change them. */
#include "render/sheet/band/extreme.h"

#include <math.h>

/* The largest difference between evaluated and interpolated samples and the ones that gave the
 * ranges: of the range, and of the largest value. */
#define ROUNDING_OF_RANGE 1e-4
#define ROUNDING_OF_VALUE 1e-5

/* The same for int16 samples, which are rounded and then weighted by integers. */
#define ROUNDING_OF_INT16 2

int cvol_extremes_have_bounds(const cvol_sheet_plan *plan)
{
    return plan->level ||
           (plan->points_lane == plan->block_lane && plan->points_row == plan->block_row &&
            plan->points_sheet == plan->block_sheet);
}

cvol_extremes cvol_extremes_of(cvol_mode mode, const cvol_sheet_plan *plan, const cvol_array *array)
{
    const int sign = mode == CVOL_MODE_MIP   ? 1
                     : mode == CVOL_MODE_MIN ? -1
                                             : 0,
              is_looked_at = !plan->wide && plan->masked != CVOL_SHEET_SOME_VOID;
    const double largest = fmax(fabs(array->range_min - array->offset),
                                fabs(array->range_max - array->offset)),
                 slack = ROUNDING_OF_RANGE * (array->range_max - array->range_min) +
                         ROUNDING_OF_VALUE * largest;
    cvol_extremes out = {.sign = isfinite(slack) && is_looked_at ? sign : 0,
                         .slack = cvol_extremes_have_bounds(plan) ? slack : INFINITY,
                         .int16 = {1, 0}};
    if (plan->int16.scale > 0) {
        out.int16 = plan->int16;
        out.slack += ROUNDING_OF_INT16 / (double)plan->int16.scale;
    }
    return out;
}

static int are_floats(const cvol_extremes *extremes)
{
    return extremes->int16.scale == 1 && extremes->int16.offset == 0;
}

/* The int16 of a value, rounded outwards: the writers of int16 may round ties either way. */
static float round_outwards(const cvol_int16_scale *int16, float value, int sign)
{
    const float up = cvol_int16_scale_of(int16, value),
                even = rintf(value * int16->scale + int16->offset);
    return sign > 0 ? fmaxf(up, even) : fminf(up, even);
}

/* A constant block in int16 is one number, which kernels do not change. */
float cvol_extremes_bound(const cvol_extremes *extremes, double lo, double hi, int constant)
{
    const cvol_int16_scale *int16 = &extremes->int16;
    const int sign = extremes->sign;
    const double slack = constant ? 0 : extremes->slack, end = sign > 0 ? hi + slack : lo - slack;
    if (are_floats(extremes))
        return (float)end;
    if (constant)
        return round_outwards(int16, (float)end, sign);
    const double scaled = end * (double)int16->scale + (double)int16->offset;
    return (float)fmin(fmax(scaled, -CVOL_INT16_MAX), 2 * CVOL_INT16_MAX);
}

void cvol_extremes_clear(const cvol_extremes *extremes, const cvol_tiles *tiles, int begin, int end)
{
    const int across = tiles->across, first = begin / CVOL_TILE,
              last = (end + CVOL_TILE - 1) / CVOL_TILE;
    for (int i = first * across; i < last * across && extremes->sign; i++)
        extremes->held[i] = -INFINITY;
}

void cvol_extremes_update(const cvol_extremes *extremes, const cvol_tiles *tiles,
                          const cvol_intermediate *image, int begin, int end)
{
    if (extremes->sign)
        CVOL_SIMD_CHOOSE(cvol_extremes_accumulate)
    (extremes->held + (ptrdiff_t)(begin / CVOL_TILE) * tiles->across,
     cvol_band_line(image, begin).values, image->width, end - begin, extremes->sign);
}

/* With floats, weights sum to 1 only up to rounding and change every value but 0. */
int cvol_extremes_is_constant(double *value, const cvol_extremes_seen *seen,
                              const cvol_sheet_plan *plan, size_t index)
{
    const int state = seen->masked ? seen->masked[index] : CVOL_MASK_NONE;
    *value = state == CVOL_MASK_ALL ? (double)seen->background : 0;
    return !plan->lapped && !plan->level &&
           (state == CVOL_MASK_ALL ||
            (state == CVOL_MASK_NONE && seen->array->block_table[index].words == 0)) &&
           (*value == 0 || !are_floats(seen->extremes));
}

int cvol_extremes_change(const cvol_extremes_seen *seen, const cvol_sheet_plan *plan, size_t lane,
                         size_t row, size_t layer)
{
    const cvol_extremes *extremes = seen->extremes;
    const cvol_array *array = seen->array;
    const size_t index = cvol_sheet_block_index(plan, array, lane, row, layer);
    size_t z_begin, z_end;
    double lo, hi, value;
    cvol_tile_span span;
    cvol_layer_sheets(&z_begin, &z_end, plan, layer);
    cvol_array_range(array, index, &lo, &hi);
    if (!cvol_block_tiles(&span, seen->tiles, plan, lane, row, z_begin, z_end))
        return 0;
    const int constant = cvol_extremes_is_constant(&value, seen, plan, index);
    const float most = (float)extremes->sign *
                       cvol_extremes_bound(extremes, constant ? value : lo - array->offset,
                                           constant ? value : hi - array->offset, constant);
    const int top = span.top < seen->tile_begin ? seen->tile_begin : span.top,
              bottom = span.bottom >= seen->tile_end ? seen->tile_end - 1 : span.bottom;
    for (int y = top; y <= bottom; y++)
        for (int x = span.left; x <= span.right; x++)
            if (extremes->held[(ptrdiff_t)y * seen->tiles->across + x] < most)
                return 1;
    return 0;
}
