/* Trellis quantization: a coefficient takes its value from one of two sets, and the coefficients
 * before it in its sub-block select the set (trellis-coded quantization: Marcellin and Fischer
 * 1990; with transitions by parity: Schwarz, Nguyen, Marpe and Wiegand 2019).
 *
 * A state, 0 at a sub-block's second coefficient, selects the value of index k, in steps:
 *     even states: 2 k;     odd states: 2 k - sign(k);
 * and the parity of k leads to the next state. Together the sets contain every multiple of the
 * step, each set only every second one: indices are as coarse as with twice the step, but an
 * encoder that looks ahead finds nearer values. The DC is 2 k. */
#ifndef CVOL_CODEC_QUANTIZE_TRELLIS_STATES_H
#define CVOL_CODEC_QUANTIZE_TRELLIS_STATES_H

#include <stdint.h>

#include "base/vector.h"

enum { CVOL_STATES = 8 };

/* The state after an index of this parity. */
extern const uint8_t cvol_state_after[CVOL_STATES][2];
/* The state from which an even, or an odd, index leads to a state. Both predecessors are even for
 * states 0 .. 3, and odd for 4 .. 7. */
extern const uint8_t cvol_state_before[2][CVOL_STATES];

/* 1 if a state's values are odd, else 0. */
CVOL_INLINE int cvol_state_is_odd(int state)
{
    return state & 1;
}

/* The magnitude of index magnitude k, and the inverse, -1 if there is none. */
CVOL_INLINE uint32_t cvol_trellis_magnitude(int state, uint32_t k)
{
    return k ? 2 * k - (uint32_t)cvol_state_is_odd(state) : 0;
}
CVOL_INLINE int64_t cvol_trellis_index(int state, uint32_t magnitude)
{
    const uint32_t odd = (uint32_t)cvol_state_is_odd(state);
    return !magnitude ? 0 : (magnitude & 1) == odd ? (int64_t)(magnitude + odd) / 2 : -1;
}

#endif
