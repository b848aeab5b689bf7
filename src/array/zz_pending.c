/* Operations that are not written yet: weak, so that the ones that are take their place. Its name
 * sorts behind all others, at which a linker therefore looks first. */
#include "array/operations.h"
#include "base/context.h"

#define PENDING(name, ...)                                                               \
    __attribute__((weak)) int name(cvol_context *context, cvol_array **out, __VA_ARGS__) \
    {                                                                                    \
        *out = NULL;                                                                     \
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s is not there yet", #name); \
    }

#pragma GCC diagnostic ignored "-Wunused-parameter"

PENDING(cvol_array_convolve_kernel, const cvol_array *a, const cvol_kernel *kernel,
        const cvol_keep *keep)
PENDING(cvol_array_gradient, const cvol_array *a, const cvol_keep *keep)
PENDING(cvol_array_multiply, const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
        cvol_plan plan, cvol_multiply_report *report)

__attribute__((weak)) const char *cvol_plan_name(cvol_plan plan)
{
    static const char *const names[] = {"auto", "direct", "grid", "full", "sparse", "blocks"};
    return (unsigned)plan < 6 ? names[plan] : NULL;
}
