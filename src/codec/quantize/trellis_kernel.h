/* The forward pass through a sub-block's trellis (trellis.h). */
#ifndef CVOL_CODEC_QUANTIZE_TRELLIS_KERNEL_H
#define CVOL_CODEC_QUANTIZE_TRELLIS_KERNEL_H

#include "codec/quantize/rd_cost.h"
#include "codec/quantize/trellis_states.h"
#include "transform/cell.h"

/* Branches of each coefficient: an even and an odd index of even values, an even and an odd one of
 * odd values. */
enum { CVOL_BRANCHES = 4 };

typedef struct cvol_trellis cvol_trellis;
struct cvol_trellis {
    float sums[CVOL_CELL_SAMPLES + 1][CVOL_STATES];  /* cost of the best path to a state before
                                                        it */
    int32_t index[CVOL_CELL_SAMPLES][CVOL_BRANCHES]; /* magnitudes */
    uint16_t near[CVOL_CELL_SAMPLES];                /* scattered sums on the best paths so far */
    uint8_t odd[CVOL_CELL_SAMPLES]; /* bit s: the best path to state s after it has an odd index */
};

/* Finds the best paths through coefficients 1 .. extent - 1, divided by twice the step, in scan
 * order. Contexts come from the best path when a coefficient's run (scan.h) begins. scatter: the
 * DC's on entry, all coefficients' on return. */
void cvol_trellis_walk(cvol_trellis *trellis, const float *scaled, int extent,
                       const cvol_scan *scan, const cvol_token_costs *costs, uint16_t *scatter);

/* One step back: returns the index's magnitude, and sets the previous state. */
CVOL_INLINE uint32_t cvol_trellis_back(const cvol_trellis *trellis, int i, int *state)
{
    const int odd = trellis->odd[i] >> *state & 1;
    *state = cvol_state_before[odd][*state];
    return (uint32_t)trellis->index[i][2 * cvol_state_is_odd(*state) + odd];
}

#endif
