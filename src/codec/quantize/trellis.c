/* Finds the best path. */
#include "codec/quantize/trellis.h"

#include <math.h>
#include <stdlib.h>

#include "base/cpu.h"
#include "base/memory.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/trellis_kernel.h"

/* Coefficients after the last one that reaches this fraction of twice the step become zero. */
#define LAST_SHARE 0.45f
/* The search tries ends from the last coefficient back, until they cost this much more than the
 * best. */
#define END_MARGIN 1.5

CVOL_SIMD_DECLARE(void, cvol_trellis_walk,
                  (cvol_trellis *, const float *, int, const cvol_scan *, const cvol_token_costs *,
                   uint16_t *));

cvol_trellis *cvol_trellis_create(void)
{
    return cvol_allocate(1, sizeof(cvol_trellis));
}

void cvol_trellis_free(cvol_trellis *trellis)
{
    free(trellis);
}

/* A possible end of a sub-block. */
typedef struct ending {
    double cost;
    int last, state; /* index of the last coefficient, and the state before it */
    uint32_t magnitude;
} ending;

/* Tries the cheapest nonzero last value at this coefficient; `more`: the fixed costs. */
static void try_ending(ending *best, const cvol_trellis *t, const cvol_token_costs *costs,
                       int size_class, int i, float size, double more)
{
    for (int odd = 0; odd < 2; odd++) {
        const float shift = 0.5f * (float)odd;
        const uint32_t low = (uint32_t)(size + shift);
        const cvol_place_code code = cvol_last_code(size_class, t->near[i], 1, odd);
        float least = INFINITY;
        int state = odd;
        for (int s = odd; s < CVOL_STATES; s += 2)
            if (t->sums[i][s] < least) {
                least = t->sums[i][s];
                state = s;
            }
        for (uint32_t k = low ? low : 1; k <= low + 1; k++) {
            const float error = size - ((float)k - shift);
            const double cost = more + (double)least +
                                (double)(error * error +
                                         CVOL_LAMBDA_TRELLIS *
                                             cvol_bits_of_last_value(costs, code, k));
            if (cost < best->cost)
                *best = (ending){cost, i, state, k};
        }
    }
}

/* Finds the best end; all: the squares of all coefficients except the DC, length_row: the costs of
 * L. */
static ending find_end(const cvol_trellis *t, const float *scaled, int extent,
                       const cvol_scan *scan, const cvol_token_costs *costs,
                       const float *length_row)
{
    const int size_class = scan->size_class;
    const double all = cvol_sub_block_squares(scaled, 1, extent);
    double tail = cvol_sub_block_squares(scaled, extent, scan->count), found = 0;
    const double none = all + tail + (double)(CVOL_LAMBDA_TRELLIS * length_row[0]);
    ending best = {INFINITY, 0, 0, 0};
    for (int i = extent - 1; i >= 1 && found < best.cost + END_MARGIN; i--) {
        const float size = fabsf(scaled[i]);
        if (size > LAST_SHARE) {
            const float bits = length_row[cvol_bit_length(scan->index[i])] +
                               cvol_bits_of_last(costs, size_class, scan->index[i]);
            ending this = {INFINITY, 0, 0, 0};
            try_ending(&this, t, costs, size_class, i, size,
                       tail + (double)(CVOL_LAMBDA_TRELLIS * bits));
            found = this.cost;
            if (found < best.cost)
                best = this;
        }
        tail += (double)size * (double)size;
    }
    return none <= best.cost ? (ending){none, 0, 0, 0} : best;
}

static double error_of(float scaled, int state, uint32_t k)
{
    const float error = fabsf(scaled) - 0.5f * (float)cvol_trellis_magnitude(state, k);
    return (double)(error * error);
}

/* Writes the indices on the best path; choice->error excludes the DC. */
static cvol_sub_block_choice follow_path(const cvol_trellis *t, int32_t *indices, const ending *end,
                                         const float *scaled, int count)
{
    double error = cvol_sub_block_squares(scaled, end->last + 1, count);
    int state = end->state;
    uint32_t k = end->magnitude;
    for (int i = end->last; i >= 1; i--) {
        if (i < end->last)
            k = cvol_trellis_back(t, i, &state);
        indices[i] = scaled[i] < 0 ? -(int32_t)k : (int32_t)k;
        error += error_of(scaled[i], state, k);
    }
    return (cvol_sub_block_choice){end->last + 1, (float)error, (float)end->cost};
}

cvol_sub_block_choice cvol_trellis_choose(cvol_trellis *t, int32_t *indices, const float *scaled,
                                          const cvol_scan *scan, const cvol_token_costs *costs,
                                          const cvol_sub_block_context *context, uint16_t *scatter)
{
    const int extent = cvol_quantise_extent(scaled, scan->count, LAST_SHARE);
    float dc_cost, dc_error;
    indices[0] = 0; /* later sub-blocks may use it as context even if this one does not fit */
    if (!cvol_quantise_fits(scaled, extent, 0.5))
        return (cvol_sub_block_choice){0, 0, INFINITY};
    indices[0] = cvol_sub_block_choose_dc(&dc_cost, &dc_error, scaled[0], costs, context, 0);
    const int64_t difference = indices[0] - context->prediction;
    const float *length_row = costs->of[cvol_length_row(
        context, scan->size_class, (uint64_t)(difference < 0 ? -difference : difference))];
    if (extent > 1) {
        int side = 1;
        while (side * side * side <= scan->index[extent - 1])
            side *= 2;
        cvol_scatter_dc(scatter, scan->row, scan->sheet, indices[0]);
        CVOL_SIMD_CHOOSE(cvol_trellis_walk)(t, scaled, extent, scan, costs, scatter);
        cvol_scatter_clear(scatter, scan->row, scan->sheet, side);
    }
    const ending end = find_end(t, scaled, extent, scan, costs, length_row);
    cvol_sub_block_choice choice = follow_path(t, indices, &end, scaled, scan->count);
    choice.error += dc_error;
    choice.cost += dc_cost;
    return choice;
}
