/* Sums over the samples of arrays with masks. A background counts with its value; samples without a
 * value in one of the arrays do not count. */
#ifndef CVOL_ARRAY_ALGEBRA_MASKED_SUMS_H
#define CVOL_ARRAY_ALGEBRA_MASKED_SUMS_H

#include "array/core/array.h"

typedef struct cvol_masked_sums {
    double samples;              /* how many count */
    double sum[2], variation[2]; /* of each array: sum a, sum (a - its mean)^2 */
    double squares[2];           /* sum a^2 */
    double inner, apart;         /* sum a b, sum (a - b)^2 */
    double error[2];             /* bound of the L2 norm of each array's error */
    double rounding[2];          /* bound of the rounding of each variation */
    double exact[2];             /* samples of a background that have no error */
} cvol_masked_sums;

/* Of a, and of b unless it is NULL; both have the same dims. Evaluates the samples, piece by piece.
 * Errors: MEMORY, CANCELLED. */
int cvol_masked_sums_compute(cvol_context *context, cvol_masked_sums *out, const cvol_array *a,
                             const cvol_array *b);
#endif
