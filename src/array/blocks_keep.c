/* What operations on blocks keep when nothing is said. */
#include "array/blocks_keep.h"

#include <math.h>

static cvol_keep resolve(const cvol_array *out, const cvol_keep *keep, double weight_a,
                         const cvol_array *a, double weight_b, const cvol_array *b)
{
    if (keep->rule != CVOL_KEEP_LIKE_INPUTS)
        return *keep;
    const cvol_array *inputs[2] = {a, b};
    const double weights[2] = {fabs(weight_a), fabs(weight_b)};
    double step = 0, threshold = 0;
    int quantised = 1;
    for (int i = 0; i < 2; i++) {
        if (!inputs[i] || !inputs[i]->coefficients || !(weights[i] > 0))
            continue;
        /* Of a quantised array the smallest term is one step. */
        const int steps = inputs[i]->threshold == 0;
        quantised = quantised && steps;
        step = fmax(step, weights[i] * inputs[i]->step);
        threshold = fmax(threshold, weights[i] * (steps ? inputs[i]->step : inputs[i]->threshold));
    }
    if (!(step > 0))
        return (cvol_keep){.rule = CVOL_KEEP_ALL};
    const double bound = (out->ledger.max_abs + fabs(out->offset)) *
                         sqrt((double)cvol_array_block_terms(out));
    const double finest = ldexp(bound, -28);
    if (quantised)
        return (cvol_keep){.rule = CVOL_KEEP_STEP, .value = fmax(step, finest)};
    return (cvol_keep){.rule = CVOL_KEEP_THRESHOLD, .value = threshold};
}

cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b)
{
    return resolve(out, keep, alpha, a, beta, b);
}

cvol_keep cvol_blocks_keep_for_multiply(const cvol_array *out, const cvol_keep *keep,
                                        const cvol_array *a, const cvol_array *b)
{
    return resolve(out, keep, cvol_ledger_tighten(&b->ledger), a, cvol_ledger_tighten(&a->ledger),
                   b);
}

cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a)
{
    return resolve(out, keep, gain, a, 0, NULL);
}

void cvol_blocks_expect(cvol_array *out, cvol_ledger ledger)
{
    if (!(out->ledger.max_abs > 0))
        out->ledger = ledger;
}
