/* The states of trellis quantization. */
#include "codec/quantize/trellis_states.h"

/* Two paths that separate stay separate for long; for uniform noise the error is 1.07 dB below
 * rounding to every second multiple. State 0 stays at even values while they are 0. */
const uint8_t cvol_state_after[CVOL_STATES][2] = {{0, 2}, {5, 7}, {1, 3}, {6, 4},
                                                  {2, 0}, {4, 6}, {3, 1}, {7, 5}};
const uint8_t cvol_state_before[2][CVOL_STATES] = {{0, 2, 4, 6, 5, 1, 3, 7},
                                                   {4, 6, 0, 2, 3, 7, 5, 1}};
