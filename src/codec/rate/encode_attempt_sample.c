/* Encode attempts on some bricks or cells of a volume: they give the next step for all bricks, and
 * the coding options. */
#include <math.h>

#include "codec/quantize/coding.h"
#include "codec/quantize/trellis.h"
#include "codec/rate/encode_attempt.h"

/* Numbers of bricks that are sampled, and that are decoded and measured; FAST: for effort fast. */
enum { SAMPLED_BRICKS = 32, MEASURED_BRICKS = 12, FAST_BRICKS = 16, FAST_MEASURED = 8 };
/* Number of bricks for the comparison of the neural coder with the usual one. */
enum { NEURAL_SAMPLED = 8 };
/* If the usual coder finds lapped and not lapped closer than this, the neural coder decides: it
 * predicts from cell to cell, and so saves part of the bits that lapping saves. */
#define NEAR 0.05
/* Number of quantized cells for an error estimate. */
enum { GUESSED_CELLS = 1024 };

/* Scales a sample's result from its share to all bricks; the counts too, so that the cost of tables
 * has its true weight. */
static void take_sample(cvol_attempt *attempt, double share)
{
    attempt->bytes = attempt->front_bytes + (uint64_t)((double)attempt->result.bytes / share);
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            attempt->counts->of[r][t] = (uint64_t)((double)attempt->counts->of[r][t] / share);
}

/* In effort fast, fewer bricks suffice. */
static int make_sampler(cvol_context *context, cvol_attempt *attempt)
{
    if (attempt->sampler)
        return CVOL_OK;
    return cvol_sampler_make(context, &attempt->sampler, attempt->shape, &attempt->source,
                             attempt->fast && attempt->samples ? FAST_BRICKS : SAMPLED_BRICKS,
                             attempt->shape->lapped && !attempt->lap_known);
}

int cvol_attempt_measure_error_share(cvol_context *context, cvol_attempt *attempt, double step)
{
    cvol_attempt_set_step(attempt, step);
    const cvol_chooser_options options = {step, attempt->split, attempt->plain,
                                          cvol_coding_of(attempt->shape)->trellis,
                                          attempt->split_bias};
    int code = make_sampler(context, attempt);
    if (!code)
        code = cvol_sampler_measure(context, &attempt->error_share, attempt->sampler,
                                    attempt->shape, attempt->tables, &options,
                                    attempt->fast ? attempt->counts : NULL,
                                    attempt->fast ? FAST_MEASURED : MEASURED_BRICKS);
    return code;
}

int cvol_attempt_estimate_error(cvol_context *context, cvol_attempt *attempt, double step,
                                size_t every)
{
    const cvol_array *shape = attempt->shape;
    const cvol_slab all = cvol_slab_of(attempt->samples, &shape->grid);
    double error = 0;
    int code = attempt->cells
                   ? CVOL_OK
                   : cvol_cell_sample_make(context, &attempt->cells, shape, &all, GUESSED_CELLS);
    if (!code)
        code = cvol_cell_sample_error(context, &error, attempt->cells, step, attempt->plain, every);
    attempt->step = step;
    attempt->result.error = error * (double)shape->block_count;
    attempt->inside = cvol_grid_samples(&shape->grid);
    return code;
}

/* Encodes sampled bricks, or about `most` of them, by the neural coder or the usual one. */
static int run_sampler(cvol_context *context, cvol_encode_result *out, cvol_token_counts *counts,
                       cvol_attempt *attempt, double step, int small, size_t most)
{
    cvol_attempt_set_step(attempt, step);
    const cvol_chooser_options options = {step, attempt->split, attempt->plain,
                                          cvol_coding_of(attempt->shape)->trellis,
                                          attempt->split_bias};
    cvol_array shape = *attempt->shape;
    cvol_file_coding coding = *cvol_coding_of(attempt->shape);
    coding.neural = small;
    shape.coding = &coding.base;
    const int code = make_sampler(context, attempt);
    return code ? code
                : cvol_sampler_run(context, out, counts, attempt->sampler, &shape, attempt->tables,
                                   &options, most);
}

int cvol_attempt_sample(cvol_context *context, cvol_attempt *attempt, double step)
{
    const int code = run_sampler(context, &attempt->result, attempt->counts, attempt, step, 0, 0);
    if (code)
        return code;
    attempt->inside = cvol_sampler_inside(attempt->sampler, attempt->shape);
    take_sample(attempt, cvol_sampler_share(attempt->sampler, attempt->shape));
    if (cvol_coding_of(attempt->shape)->neural) {
        attempt->result.error *= attempt->neural_error;
        attempt->bytes = attempt->front_bytes +
                         (uint64_t)(attempt->neural_bytes *
                                    (double)(attempt->bytes - attempt->front_bytes));
    }
    return CVOL_OK;
}

int cvol_attempt_estimate(cvol_context *context, cvol_attempt *attempt, double step, size_t every)
{
    cvol_attempt_set_step(attempt, step);
    const cvol_encode_pass pass = {.shape = attempt->shape,
                                   .source = &attempt->source,
                                   .tables = attempt->tables,
                                   .options = {step, attempt->split, attempt->plain,
                                               cvol_coding_of(attempt->shape)->trellis,
                                               attempt->split_bias},
                                   .counts = attempt->counts,
                                   .every = every};
    const int code = cvol_encode_pass_run(context, &attempt->result, &pass);
    if (code)
        return code;
    const double share = (double)attempt->result.samples /
                         ((double)attempt->shape->block_count *
                          (double)cvol_array_block_terms(attempt->shape));
    attempt->inside = (uint64_t)(share * (double)cvol_grid_samples(&attempt->shape->grid));
    take_sample(attempt, share);
    return CVOL_OK;
}

/* Error plus lambda times bits, in squared steps; samples show `share` of the error. */
static double cost_of(const cvol_attempt *attempt, const cvol_encode_result *result, double step,
                      double share)
{
    const float lambda = cvol_coding_of(attempt->shape)->trellis ? 4 * CVOL_LAMBDA_TRELLIS
                                                                 : CVOL_LAMBDA;
    return result->error / (step * step) * share + 8 * (double)(lambda * (float)result->bytes);
}

int cvol_attempt_choose_split_bias(cvol_context *context, cvol_attempt *attempt, double step)
{
    static const cvol_split_bias shares[] = {{1, 1}, {0.95f, 1}, {0.95f, 0.95f}};
    cvol_encode_result small = {0}, usual;
    double least = INFINITY;
    cvol_split_bias best = shares[0];
    int code = CVOL_OK;
    for (size_t i = 0; i < sizeof shares / sizeof *shares && !code; i++) {
        cvol_encode_result result = {0};
        attempt->split_bias = shares[i];
        code = run_sampler(context, &result, NULL, attempt, step, 1, NEURAL_SAMPLED);
        const double cost = cost_of(attempt, &result, step, 1);
        if (!code && cost < least) {
            least = cost;
            best = shares[i];
            small = result;
        }
    }
    attempt->split_bias = best;
    if (!code)
        code = run_sampler(context, &usual, NULL, attempt, step, 0, NEURAL_SAMPLED);
    if (!code && usual.bytes && usual.error > 0) {
        attempt->neural_bytes = (double)small.bytes / (double)usual.bytes;
        attempt->neural_error = small.error / usual.error;
    }
    return code;
}

/* Costs of the volume not lapped and lapped, on samples coded both ways; `shares` of the errors are
 * known from the second call on. */
static int compare_laps(cvol_context *context, cvol_attempt *attempt, double step, int small,
                        double costs[2], double shares[2])
{
    int code = CVOL_OK;
    for (int lapped = 0; lapped < 2 && !code; lapped++) {
        cvol_encode_result result = {0};
        attempt->shape->lapped = lapped;
        if (small) {
            code = run_sampler(context, &result, NULL, attempt, step, 1, NEURAL_SAMPLED);
        } else {
            code = cvol_attempt_sample(context, attempt, step);
            if (!code)
                code = cvol_attempt_measure_error_share(context, attempt, step);
            result = attempt->result;
            shares[lapped] = attempt->error_share;
        }
        costs[lapped] = cost_of(attempt, &result, step, shares[lapped]);
    }
    return code;
}

int cvol_attempt_choose_lap(cvol_context *context, cvol_attempt *attempt, double step)
{
    double costs[2], shares[2];
    int code = compare_laps(context, attempt, step, 0, costs, shares);
    if (!code && cvol_coding_of(attempt->shape)->neural &&
        fabs(costs[1] - costs[0]) < NEAR * costs[0])
        code = compare_laps(context, attempt, step, 1, costs, shares);
    if (code)
        return code;
    attempt->shape->lapped = costs[1] < costs[0];
    attempt->error_share = shares[attempt->shape->lapped];
    return CVOL_OK;
}
