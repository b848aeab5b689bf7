/* Halves of operations that are not written yet: weak, so that the ones that are take their place.
 * Its name sorts behind blocks_*.c, which a linker therefore looks at first. */
#include "array/operations.h"
#include "base/context.h"

#define PENDING(name, ...)                                                               \
    __attribute__((weak)) int name(cvol_context *context, __VA_ARGS__)                   \
    {                                                                                    \
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s is not there yet", #name); \
    }

#pragma GCC diagnostic ignored "-Wunused-parameter"

PENDING(cvol_blocks_add, cvol_array *out, cvol_build_result *result, double alpha,
        const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep)
PENDING(cvol_blocks_scale, cvol_array *out, cvol_build_result *result, double alpha,
        const cvol_array *a, double beta)
PENDING(cvol_blocks_truncate, cvol_array *out, cvol_build_result *result, const cvol_array *a,
        const cvol_keep *keep)
PENDING(cvol_blocks_sums, double *sum, double *squares, const cvol_array *a)
PENDING(cvol_blocks_inner, double *inner, const cvol_array *a, const cvol_array *b)
PENDING(cvol_blocks_convolve_kernel, cvol_array *out, cvol_build_result *result,
        const cvol_array *a, const cvol_kernel *kernel, const cvol_keep *keep)
PENDING(cvol_blocks_gradient, cvol_array *out, cvol_build_result *result, const cvol_array *a,
        const double weight[3], const cvol_keep *keep)
PENDING(cvol_blocks_resample, cvol_array *out, cvol_build_result *result, const cvol_array *a,
        const cvol_keep *keep)
