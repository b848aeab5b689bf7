/* Trials of some of a volume's bricks, or cells: which step to try with all of them, and how. */
#include <math.h>

#include "codec/quantize/coding.h"
#include "codec/quantize/trellis.h"
#include "codec/rate/encode_attempt.h"

/* Bricks that are sampled, and those of them that are decoded and measured. */
enum { SAMPLED_BRICKS = 32, MEASURED_BRICKS = 12, HASTY_BRICKS = 16, HASTY_MEASURED = 8 };
/* Bricks by which the small coder is compared with the usual one. */
enum { SMALL_SAMPLED = 8 };
/* What the usual coder finds alike, lapped and not, is asked of the small one, which foretells from
 * cell to cell what lapping saves. */
#define NEAR 0.05
/* Cells that are quantised to guess errors. */
enum { GUESSED_CELLS = 1024 };

/* What a share of all bricks gave, as if it had been all; counts too, so that the tables are worth
 * what they will be. */
static void take_sample(cvol_trial *trial, double share)
{
    trial->bytes = trial->front_bytes + (uint64_t)((double)trial->result.bytes / share);
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            trial->counts->of[r][t] = (uint64_t)((double)trial->counts->of[r][t] / share);
}

/* In haste, fewer bricks are enough. */
static int make_sampler(cvol_context *context, cvol_trial *trial)
{
    if (trial->sampler)
        return CVOL_OK;
    return cvol_sampler_make(context, &trial->sampler, trial->shape, &trial->source,
                             trial->hasty && trial->samples ? HASTY_BRICKS : SAMPLED_BRICKS,
                             trial->shape->lapped && !trial->lap_known);
}

int cvol_trial_find_share(cvol_context *context, cvol_trial *trial, double step)
{
    cvol_trial_set_step(trial, step);
    const cvol_chooser_options options = {step, trial->split, trial->plain,
                                          cvol_coding_of(trial->shape)->dependent, trial->coarse};
    int code = make_sampler(context, trial);
    if (!code)
        code = cvol_sampler_measure(context, &trial->error_share, trial->sampler, trial->shape,
                                    trial->tables, &options, trial->hasty ? trial->counts : NULL,
                                    trial->hasty ? HASTY_MEASURED : MEASURED_BRICKS);
    return code;
}

int cvol_trial_guess_error(cvol_context *context, cvol_trial *trial, double step, size_t every)
{
    const cvol_array *shape = trial->shape;
    const cvol_slab all = {trial->samples, 0, shape->grid.dims[2]};
    double error = 0;
    int code = trial->cells
                   ? CVOL_OK
                   : cvol_cell_sample_make(context, &trial->cells, shape, &all, GUESSED_CELLS);
    if (!code)
        code = cvol_cell_sample_error(context, &error, trial->cells, step, trial->plain, every);
    trial->step = step;
    trial->result.error = error * (double)shape->block_count;
    trial->inside = cvol_grid_samples(&shape->grid);
    return code;
}

/* Encodes sampled bricks, or about `most` of them, by the small coder or as usual. */
static int run_sampler(cvol_context *context, cvol_encode_result *out, cvol_token_counts *counts,
                       cvol_trial *trial, double step, int small, size_t most)
{
    cvol_trial_set_step(trial, step);
    const cvol_chooser_options options = {step, trial->split, trial->plain,
                                          cvol_coding_of(trial->shape)->dependent, trial->coarse};
    cvol_array shape = *trial->shape;
    cvol_file_coding coding = *cvol_coding_of(trial->shape);
    coding.small = small;
    shape.coding = &coding.base;
    const int code = make_sampler(context, trial);
    return code ? code
                : cvol_sampler_run(context, out, counts, trial->sampler, &shape, trial->tables,
                                   &options, most);
}

int cvol_trial_sample(cvol_context *context, cvol_trial *trial, double step)
{
    const int code = run_sampler(context, &trial->result, trial->counts, trial, step, 0, 0);
    if (code)
        return code;
    trial->inside = cvol_sampler_inside(trial->sampler, trial->shape);
    take_sample(trial, cvol_sampler_share(trial->sampler, trial->shape));
    if (cvol_coding_of(trial->shape)->small) {
        trial->result.error *= trial->small_error;
        trial->bytes = trial->front_bytes +
                       (uint64_t)(trial->small_bytes * (double)(trial->bytes - trial->front_bytes));
    }
    return CVOL_OK;
}

int cvol_trial_estimate(cvol_context *context, cvol_trial *trial, double step, size_t every)
{
    cvol_trial_set_step(trial, step);
    const cvol_encode_pass pass = {.shape = trial->shape,
                                   .source = &trial->source,
                                   .tables = trial->tables,
                                   .options = {step, trial->split, trial->plain,
                                               cvol_coding_of(trial->shape)->dependent,
                                               trial->coarse},
                                   .counts = trial->counts,
                                   .every = every};
    const int code = cvol_encode_pass_run(context, &trial->result, &pass);
    if (code)
        return code;
    const double share = (double)trial->result.samples /
                         ((double)trial->shape->block_count *
                          (double)cvol_array_block_terms(trial->shape));
    trial->inside = (uint64_t)(share * (double)cvol_grid_samples(&trial->shape->grid));
    take_sample(trial, share);
    return CVOL_OK;
}

/* Error and lambda bits together, in squared steps; `share` of the error is seen. */
static double cost_of(const cvol_trial *trial, const cvol_encode_result *result, double step,
                      double share)
{
    const float lambda = cvol_coding_of(trial->shape)->dependent ? 4 * CVOL_LAMBDA_DEPENDENT
                                                                 : CVOL_LAMBDA;
    return result->error / (step * step) * share + 8 * (double)(lambda * (float)result->bytes);
}

int cvol_trial_choose_share(cvol_context *context, cvol_trial *trial, double step)
{
    static const cvol_coarse_shares shares[] = {{1, 1}, {0.95f, 1}, {0.95f, 0.95f}};
    cvol_encode_result small = {0}, usual;
    double least = INFINITY;
    cvol_coarse_shares best = shares[0];
    int code = CVOL_OK;
    for (size_t i = 0; i < sizeof shares / sizeof *shares && !code; i++) {
        cvol_encode_result result = {0};
        trial->coarse = shares[i];
        code = run_sampler(context, &result, NULL, trial, step, 1, SMALL_SAMPLED);
        const double cost = cost_of(trial, &result, step, 1);
        if (!code && cost < least) {
            least = cost;
            best = shares[i];
            small = result;
        }
    }
    trial->coarse = best;
    if (!code)
        code = run_sampler(context, &usual, NULL, trial, step, 0, SMALL_SAMPLED);
    if (!code && usual.bytes && usual.error > 0) {
        trial->small_bytes = (double)small.bytes / (double)usual.bytes;
        trial->small_error = small.error / usual.error;
    }
    return code;
}

/* What the volume would cost not lapped and lapped, by samples that are coded in either way;
 * `shares` of the errors are known if this is not the first time. */
static int compare_laps(cvol_context *context, cvol_trial *trial, double step, int small,
                        double costs[2], double shares[2])
{
    int code = CVOL_OK;
    for (int lapped = 0; lapped < 2 && !code; lapped++) {
        cvol_encode_result result = {0};
        trial->shape->lapped = lapped;
        if (small) {
            code = run_sampler(context, &result, NULL, trial, step, 1, SMALL_SAMPLED);
        } else {
            code = cvol_trial_sample(context, trial, step);
            if (!code)
                code = cvol_trial_find_share(context, trial, step);
            result = trial->result;
            shares[lapped] = trial->error_share;
        }
        costs[lapped] = cost_of(trial, &result, step, shares[lapped]);
    }
    return code;
}

int cvol_trial_choose_lap(cvol_context *context, cvol_trial *trial, double step)
{
    double costs[2], shares[2];
    int code = compare_laps(context, trial, step, 0, costs, shares);
    if (!code && cvol_coding_of(trial->shape)->small && fabs(costs[1] - costs[0]) < NEAR * costs[0])
        code = compare_laps(context, trial, step, 1, costs, shares);
    if (code)
        return code;
    trial->shape->lapped = costs[1] < costs[0];
    trial->error_share = shares[trial->shape->lapped];
    return CVOL_OK;
}
