/* The default truncation of operations on blocks. */
#include "array/truncate/blocks_keep.h"

#include <math.h>
#include <stdlib.h>

#include "array/block/block_sums.h"
#include "array/core/share.h"
#include "array/truncate/result_block.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"

/* A result is quantized so that it loses at most this share of the bound that the inputs carry,
 * less twice what such losses have added to it. So a chain of operations, however long, adds no
 * more than it carried at first: after n of them (1 - 0.8^n) of that. */
#define SHARE_OF_BOUND 0.2
/* And at most this share of the loss that is expected: with 0.5 the result is 1 dB worse than
 * without any loss. */
#define SHARE_OF_EXPECTED 0.5

/* Blocks whose sums are added first, so that totals do not depend on the number of processes. */
enum { RUN_BLOCKS = 64 };

static double loss_of(const cvol_array *a)
{
    return a && a->coefficients ? a->error_bound.l2_error : 0;
}

static cvol_keep resolve(const cvol_array *out, const cvol_keep *keep, double weight_a,
                         const cvol_array *a, double weight_b, const cvol_array *b)
{
    if (keep->rule != CVOL_KEEP_LIKE_INPUTS)
        return *keep;
    const double expected = cvol_hypot(weight_a * loss_of(a), weight_b * loss_of(b));
    const cvol_error_bound *bound = &out->error_bound;
    const double allowed = fmin(SHARE_OF_BOUND * (bound->l2_error - 2 * bound->default_loss),
                                SHARE_OF_EXPECTED * expected);
    if (!(allowed > 0) || !isfinite(allowed))
        return (cvol_keep){.rule = CVOL_KEEP_ALL};
    return (cvol_keep){.rule = CVOL_KEEP_LOSS, .value = allowed};
}

/* The step of which the terms are multiples, down to 1; 0: they are finer, or there are none. */
static double step_of(const cvol_array *a)
{
    return a->coefficients && a->threshold == 0 && cvol_array_quantised_step(a) == a->step ? a->step
                                                                                           : 0;
}

/* 1 if all terms of a sum are multiples of one step. */
static int share_step(double *step, double alpha, const cvol_array *a, double beta,
                      const cvol_array *b)
{
    const double x = fabs(alpha) * step_of(a), y = fabs(beta) * step_of(b);
    *step = fmax(x, y);
    return (a->coefficients == 0 || x > 0) && (b->coefficients == 0 || y > 0) &&
           a->lapped == b->lapped && *step > 0 &&
           (!(x > 0) || !(y > 0) || fabs(x - y) <= 1e-9 * *step);
}

cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b)
{
    double step;
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS && !a->mask && !b->mask &&
        share_step(&step, alpha, a, beta, b))
        return (cvol_keep){.rule = CVOL_KEEP_STEP, .value = step}; /* nothing is lost */
    return resolve(out, keep, alpha, a, beta, b);
}

/* Sums over a run of blocks: of their energies, and of the squares of these. */
typedef struct energy_sums {
    double energies, squares;
} energy_sums;

static void add_energy(energy_sums *to, const cvol_array *a, const cvol_block *block, double count)
{
    const int place_bits = cvol_place_bits(a->block_log2);
    const double step = a->step, offset = a->offset;
    double energy = offset * offset * count;
    if (block->words) {
        uint32_t place;
        const uint32_t *words = block->terms;
        const double first = step * (double)cvol_term_unpack(&words, &place, place_bits);
        energy += step * step * cvol_block_squares(block, place_bits);
        energy += place ? 0 : 2 * offset * first * sqrt(count);
    }
    to->energies += energy;
    to->squares += energy * energy;
}

/* The root mean square of a block, averaged over blocks with their energy as weight: the amplitude
 * where the array is not small. (About 1 for a mask, however small. The filter of lapped volumes
 * hardly changes it.) */
static int find_loudness(cvol_context *context, double *out, const cvol_array *a)
{
    const cvol_share share = cvol_share_of(context, a);
    const double count = (double)cvol_array_block_terms(a);
    const size_t run_count = (a->block_count - 1) / RUN_BLOCKS + 1;
    const size_t begin = cvol_share_group(&share, 0, RUN_BLOCKS),
                 end = cvol_share_group(&share, 1, RUN_BLOCKS);
    energy_sums total = {0, 0}, *runs = cvol_allocate_zero(run_count, sizeof *runs);
    int code = runs ? CVOL_OK : cvol_fail_memory(context, run_count * sizeof *runs, "sums");
    for (size_t r = begin; r < end && !code; r++)
        for (size_t i = r * RUN_BLOCKS; i < (r + 1) * RUN_BLOCKS && i < a->block_count; i++)
            add_energy(&runs[r], a, &a->block_table[i], count);
    code = cvol_team_complete(context, share.team, code, runs, sizeof *runs, begin, end);
    for (size_t r = 0; r < run_count && !code; r++) {
        total.energies += runs[r].energies;
        total.squares += runs[r].squares;
    }
    free(runs);
    *out = total.energies > 0 ? sqrt(total.squares / total.energies / count) : 0;
    return code;
}

int cvol_blocks_keep_for_multiply(cvol_context *context, cvol_keep *resolved, const cvol_array *out,
                                  const cvol_keep *keep, const cvol_array *a, const cvol_array *b)
{
    double of_a, of_b;
    *resolved = *keep;
    if (keep->rule != CVOL_KEEP_LIKE_INPUTS)
        return CVOL_OK;
    int code = find_loudness(context, &of_a, a);
    if (!code)
        code = find_loudness(context, &of_b, b);
    if (!code)
        *resolved = resolve(out, keep, of_b, a, of_a, b);
    return code;
}

cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a)
{
    return resolve(out, keep, fmax(gain, 1), a, 0, NULL);
}

double cvol_blocks_filter_step(const cvol_array *out)
{
    return cvol_result_expected_step(out, SHARE_OF_BOUND * out->error_bound.l2_error);
}

void cvol_blocks_set_expected_bound(cvol_array *out, cvol_error_bound error_bound)
{
    const cvol_error_bound *own =
        &out->error_bound; /* an array that evaluates to zero may have an error */
    if (!(own->max_abs > 0 || own->l2_error > 0 || cvol_error_bound_largest(own) > 0))
        out->error_bound = error_bound;
}
