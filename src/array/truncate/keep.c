/* Construction and checks of a cvol_keep. */
#include <math.h>

#include "array/truncate/truncate.h"
#include "base/context.h"

cvol_keep cvol_keep_like_inputs(void)
{
    return (cvol_keep){.rule = CVOL_KEEP_LIKE_INPUTS};
}

cvol_keep cvol_keep_all(void)
{
    return (cvol_keep){.rule = CVOL_KEEP_ALL};
}

cvol_keep cvol_keep_terms(size_t k, uint64_t s)
{
    return (cvol_keep){.rule = CVOL_KEEP_TERMS, .low = {k, k, k}, .sparse = s};
}

cvol_keep cvol_keep_rho(double rho)
{
    return (cvol_keep){.rule = CVOL_KEEP_RHO, .value = rho};
}

cvol_keep cvol_keep_ratio(double ratio)
{
    return (cvol_keep){.rule = CVOL_KEEP_RATIO, .value = ratio};
}

cvol_keep cvol_keep_psnr(double psnr_db)
{
    return (cvol_keep){.rule = CVOL_KEEP_PSNR, .value = psnr_db};
}

cvol_keep cvol_keep_l2(double l2_error)
{
    return (cvol_keep){.rule = CVOL_KEEP_L2, .value = l2_error};
}

cvol_keep cvol_keep_threshold(double magnitude)
{
    return (cvol_keep){.rule = CVOL_KEEP_THRESHOLD, .value = magnitude};
}

cvol_keep cvol_keep_step(double step)
{
    return (cvol_keep){.rule = CVOL_KEEP_STEP, .value = step};
}

cvol_keep cvol_keep_loss(double l2_error)
{
    return (cvol_keep){.rule = CVOL_KEEP_LOSS, .value = l2_error};
}

/* ---- checking ------------------------------------------------------------------------------ */

/* A rule's value: its name, and 1 if it may be 0. */
static const struct {
    const char *name;
    int zero;
} values[] = {
    [CVOL_KEEP_RHO] = {"rho", 0},
    [CVOL_KEEP_RATIO] = {"ratio", 0},
    [CVOL_KEEP_PSNR] = {"PSNR", 0},
    [CVOL_KEEP_L2] = {"L2 error", 1},
    [CVOL_KEEP_THRESHOLD] = {"threshold", 1},
    [CVOL_KEEP_STEP] = {"step", 0},
    [CVOL_KEEP_LOSS] = {"loss", 0},
};

static int check_low(cvol_context *context, const cvol_keep *keep, const cvol_array *shape)
{
    for (int a = 0; a < shape->rank; a++) {
        const size_t most = shape->block ? (size_t)shape->block : shape->grid.dims[a];
        if (keep->low[a] > most)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "k is %zu along %c, where the %s has %zu samples", keep->low[a],
                             "xyz"[a], shape -> block ? "block" : "array", most);
    }
    return CVOL_OK;
}

int cvol_keep_check(cvol_context *context, const cvol_keep *keep, const cvol_array *shape)
{
    const double terms = shape->block
                             ? (double)shape->block_count * (double)cvol_array_block_terms(shape)
                             : (double)cvol_grid_samples(&shape->grid);
    switch (keep->rule) {
    case CVOL_KEEP_LIKE_INPUTS:
    case CVOL_KEEP_ALL:
        return CVOL_OK;
    case CVOL_KEEP_TERMS:
        if ((double)keep->sparse > terms)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "s is %llu, the array has %.0f coefficients",
                             (unsigned long long)keep->sparse, terms);
        break;
    case CVOL_KEEP_STEP:
    case CVOL_KEEP_LOSS:
        if (!shape->block)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "a step quantizes blocks; whole arrays (block 0) keep terms, rho, "
                             "ratio, PSNR, L2 error or a threshold");
        break;
    case CVOL_KEEP_RHO:
    case CVOL_KEEP_RATIO:
    case CVOL_KEEP_PSNR:
    case CVOL_KEEP_L2:
    case CVOL_KEEP_THRESHOLD:
        break;
    default:
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a cvol_keep_rule",
                         (int)keep->rule);
    }
    if (keep->rule != CVOL_KEEP_TERMS &&
        (!isfinite(keep->value) || !(values[keep->rule].zero ? keep->value >= 0 : keep->value > 0)))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s is %g, must be finite and %s",
                         values[keep->rule].name, keep->value,
                         values[keep->rule].zero ? "0 or more" : "above 0");
    return check_low(context, keep, shape);
}
