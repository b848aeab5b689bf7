/* Adds an operation's losses to the error bound of its result: account.h. */
#include "array/truncate/account.h"

#include <float.h>
#include <math.h>

#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/elementary.h"
#include "transform/lap.h"

/* The loss of a sample by float32 underflow, times the square root of the number of samples: the
 * smallest numbers are multiples of 2^-149, and transforms add up the losses. */
#define UNDERFLOW 0x1p-143

/* Bounds for both backends of transforms (src/transform/fft_backend.h). CVOL_ROUNDING holds for
 * fast transforms of short factors. FFTW sums a larger prime p term by term up to 172, cvol's own
 * backend up to 61. The error of such a sum grows with its length, by a quarter of 2^-24 p in the
 * worst case that tests found. Larger primes are convolutions, of length p - 1 in FFTW (Rader), of
 * at least 2 p - 1 in cvol (Bluestein), whose error is smaller. */
enum { KERNEL_LENGTHS = 16, RADER = 173 };

/* The sum of the lengths of all sums in a transform of length n. */
static double summed_lengths(size_t n)
{
    double sum = 0;
    for (size_t p = 2; n > 1; p++) {
        p = p * p > n ? n : p;
        for (; n % p == 0; n /= p)
            if (p >= RADER)
                sum += KERNEL_LENGTHS + 2 * summed_lengths(p - 1);
            else if (p > KERNEL_LENGTHS)
                sum += (double)p;
    }
    return sum;
}

double cvol_array_rounding(const cvol_array *array)
{
    double sum = 0;
    for (int axis = 0; axis < array->rank && !array->block; axis++)
        sum += summed_lengths(array->grid.dims[axis]);
    return CVOL_ROUNDING + 0x1p-24 * sum;
}

double cvol_array_sample_rounding(const cvol_array *array)
{
    const double constant = fmax(fabs(array->offset), fabs(cvol_array_background(array)));
    const double peak = array->error_bound.max_abs + constant;
    return CVOL_SAMPLE_ROUNDING * peak * (array->lapped ? CVOL_LAP_POST_PEAK_3 : 1);
}

void cvol_array_account(cvol_array *array, const cvol_build_result *result, double factors)
{
    const double constant = fmax(fabs(array->offset), fabs(cvol_array_background(array))) *
                            sqrt((double)cvol_grid_samples(&array->grid));
    double sample = (double)INFINITY, dropped = result->dropped, norm = result->norm;
    double underflow = 0;
    if (norm > 0 || array->error_bound.max_abs > 0 ||
        cvol_error_bound_largest(&array->error_bound) > 0)
        underflow = UNDERFLOW * (double)cvol_grid_samples(&array->grid) * fmax(result->gain, 1);
    if (array->block)
        sample = result->sample * (array->lapped ? CVOL_LAP_POST_PEAK_3 : 1) +
                 cvol_array_sample_rounding(array) + CVOL_SAMPLE_ROUNDING * result->factors;
    if (array->lapped) { /* the filter's norm, and its rounding, which the L2 norm includes */
        dropped *= CVOL_LAP_POST_NORM_3;
        norm *= 1 + (CVOL_LAP_POST_NORM_3 - 1) / CVOL_ROUNDING;
    }
    norm = (norm + factors + constant) * cvol_array_rounding(array) / CVOL_ROUNDING +
           underflow / CVOL_ROUNDING;
    array->error_bound.default_loss += result->is_default ? dropped : 0;
    cvol_error_bound_drop(&array->error_bound, dropped, norm, sample + underflow);
}

double cvol_array_allowed(const cvol_array *array, const cvol_keep *keep)
{
    const double range = array->error_bound.value_max - array->error_bound.value_min;
    if (keep->rule == CVOL_KEEP_L2)
        return keep->value;
    if (keep->rule == CVOL_KEEP_PSNR && range > 0)
        return range * sqrt((double)cvol_grid_samples(&array->grid)) *
               cvol_pow(10, -keep->value / 20);
    return (double)INFINITY;
}

int cvol_array_check_error_bound(cvol_context *context, const cvol_array *array,
                                 const cvol_error_bound *error_bound, const char *operation)
{
    const double largest = fmax(cvol_error_bound_largest(error_bound), error_bound->max_abs);
    /* The factor by which coefficients, and the sums that give them, may be larger. */
    const double room = array->block
                            ? (array->lapped ? 16 : 4) * sqrt((double)cvol_array_block_terms(array))
                            : 8 * (double)cvol_grid_samples(&array->grid);
    if (!(largest > (double)FLT_MAX / room))
        return cvol_error_bound_check(context, error_bound, operation);
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "%s: values may reach %g, beyond what transforms in float32 can hold (%g); "
                     "scale the operands down first",
                     operation, largest, (double)FLT_MAX / room);
}
