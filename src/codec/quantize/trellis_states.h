/* Trellis quantization: a coefficient may take one of two sets of values, and those coded before
 * it in its part say which (trellis-coded quantization: Marcellin and Fischer 1990; with
 * transitions by parity: Schwarz, Nguyen, Marpe and Wiegand 2019).
 *
 * A state, 0 at a part's second coefficient, chooses the set of what index k stands for, in steps:
 *
 *     even states: 2 k;     odd states: 2 k - sign(k);
 *
 * and the parity of k leads to the next state. Together the sets have every multiple of the step,
 * each of them only every second one: what is told apart is as coarse as with twice the step, but
 * an encoder that looks ahead finds values on the way that are nearer. The DC is 2 k.
 */
#ifndef CVOL_CODEC_QUANTIZE_TRELLIS_STATES_H
#define CVOL_CODEC_QUANTIZE_TRELLIS_STATES_H

#include <stdint.h>

#include "base/vector.h"

enum { CVOL_STATES = 8 };

/* The state after an index of this parity. */
extern const uint8_t cvol_state_after[CVOL_STATES][2];
/* The one state that an even index, or an odd one, leads from to a state. Of states 0 .. 3 both are
 * even, of 4 .. 7 both are odd. */
extern const uint8_t cvol_state_before[2][CVOL_STATES];

/* 1 where a state's values are odd, or 0. */
CVOL_INLINE int cvol_state_is_odd(int state)
{
    return state & 1;
}

/* The magnitude that index magnitude k stands for, and the other way, -1 where none does. */
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
