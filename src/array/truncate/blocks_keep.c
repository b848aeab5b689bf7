/* The default truncation of operations on blocks. */
#include "array/truncate/blocks_keep.h"

#include <math.h>

#include "array/block/block_sums.h"

static cvol_keep resolve(const cvol_array *out, const cvol_keep *keep, double weight_a,
                         const cvol_array *a, double weight_b, const cvol_array *b)
{
    if (keep->rule != CVOL_KEEP_LIKE_INPUTS)
        return *keep;
    const cvol_array *inputs[2] = {a, b};
    const double weights[2] = {fabs(weight_a), fabs(weight_b)};
    double step = 0, threshold = 0, error = 0;
    int quantised = 1;
    for (int i = 0; i < 2; i++) {
        if (!inputs[i] || !inputs[i]->coefficients || !(weights[i] > 0))
            continue;
        /* The smallest term of a quantized array is one step. */
        const int steps = inputs[i]->threshold == 0;
        const double own = cvol_array_quantised_step(inputs[i]);
        const double smallest = weights[i] * (steps ? own : inputs[i]->threshold);
        const double lost = weights[i] * inputs[i]->error_bound.l2_error;
        if (step > 0 && (lost < error || (lost == error && smallest >= threshold)))
            continue;
        error = lost;
        quantised = steps;
        step = weights[i] * own;
        threshold = smallest;
    }
    if (!(step > 0))
        return (cvol_keep){.rule = CVOL_KEEP_ALL};
    const double finest = ldexp(cvol_array_coefficient_bound(out), -28);
    if (quantised)
        return (cvol_keep){.rule = CVOL_KEEP_STEP, .value = fmax(step, finest)};
    return (cvol_keep){.rule = CVOL_KEEP_THRESHOLD, .value = threshold};
}

cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b)
{
    return resolve(out, keep, alpha, a, beta, b);
}

/* The root mean square of a block, averaged over blocks with their energy as weight: the amplitude
 * where the array is not small. (About 1 for a mask, however small. The filter of lapped volumes
 * hardly changes it.) */
static double loudness(const cvol_array *a)
{
    const int place_bits = cvol_place_bits(a->block_log2);
    const double count = (double)cvol_array_block_terms(a), step = a->step, offset = a->offset;
    double energies = 0, squares = 0;
    for (size_t i = 0; i < a->block_count; i++) {
        const cvol_block *block = &a->block_table[i];
        double energy = offset * offset * count;
        if (block->words) {
            uint32_t place;
            const uint32_t *words = block->terms;
            const double first = step * (double)cvol_term_unpack(&words, &place, place_bits);
            energy += step * step * cvol_block_squares(block, place_bits);
            energy += place ? 0 : 2 * offset * first * sqrt(count);
        }
        energies += energy;
        squares += energy * energy;
    }
    return energies > 0 ? sqrt(squares / energies / count) : 0;
}

cvol_keep cvol_blocks_keep_for_multiply(const cvol_array *out, const cvol_keep *keep,
                                        const cvol_array *a, const cvol_array *b)
{
    if (keep->rule != CVOL_KEEP_LIKE_INPUTS)
        return *keep;
    return resolve(out, keep, loudness(b), a, loudness(a), b);
}

cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a)
{
    return resolve(out, keep, gain, a, 0, NULL);
}

void cvol_blocks_set_expected_bound(cvol_array *out, cvol_error_bound error_bound)
{
    const cvol_error_bound *own =
        &out->error_bound; /* an array that evaluates to zero may have an error */
    if (!(own->max_abs > 0 || own->l2_error > 0 || cvol_error_bound_largest(own) > 0))
        out->error_bound = error_bound;
}
