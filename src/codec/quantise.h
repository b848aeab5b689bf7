/* Uniform quantiser with a dead zone:  |q| = floor(|c| / step + rounding),  c' = q step.
 *
 * Rounding below 1/2 widens the zone that becomes zero and moves every value towards zero. Zeros
 * are cheap, and coefficients are Laplacian, more often near the lower end of an interval than
 * the upper: at equal bytes the result is better (Sullivan 1996).
 */
#ifndef CVOL_CODEC_QUANTISE_H
#define CVOL_CODEC_QUANTISE_H

#include <stdint.h>

/* The largest magnitude that is coded. */
#define CVOL_VALUE_LIMIT (INT32_C(1) << 30)

/* How far a coefficient moves up before it is cut to an integer: the DC (coefficient 0), values
 * that become 0 or 1, and larger ones. */
typedef struct cvol_rounding {
    float dc, low, high;
} cvol_rounding;

/* Quantises coefficients in scan order. values[0 .. used) are set, used >= 1; all later ones are
 * zero. The result is `used`, or 0 when a value would exceed CVOL_VALUE_LIMIT. */
int cvol_quantise(int32_t *values, const float *coefficients, int count, double step,
                  const cvol_rounding *rounding);

#endif
