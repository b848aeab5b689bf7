/* Maximum effort: a sample decides how strongly splits are preferred to whole cells. */
#include "test.h"

#include "codec/quantize/trellis.h"
#include "codec/rate/encode_attempt.h"
#include "random.h"

enum { SIDE = 48, COUNT = SIDE * SIDE * SIDE };

/* Waves that extend over a few samples, on slow ones. */
static float *make_samples(void)
{
    float *samples = malloc(COUNT * sizeof *samples);
    random_state r = {11};
    assert_non_null(samples);
    for (int i = 0; i < COUNT; i++) {
        const double x = i % SIDE, y = i / SIDE % SIDE, z = i / SIDE / SIDE;
        const double here = sin(x / 6) * sin(y / 7 + 1) * sin(z / 5 + 2);
        samples[i] = (float)(cos(x / 19 + y / 23) + cos(z / 17) +
                             (here > 0.4 ? 0.1 * sin((x + y - z) / 1.7) : 0) +
                             0.02 * random_signed(&r));
    }
    return samples;
}

/* Error plus lambda times bits, in squared steps, for a bias of splits. */
static double cost_with(cvol_context *context, cvol_attempt *attempt, double step,
                        cvol_split_bias shares)
{
    attempt->split_bias = shares;
    assert_int_equal(cvol_attempt_encode(context, attempt, step), 0);
    return attempt->result.error / (step * step) +
           32 * (double)CVOL_LAMBDA_TRELLIS * (double)attempt->result.bytes;
}

/* The chosen bias of splits for a step; *gain: the saving of 0.95 for cells compared with 1. */
static cvol_split_bias choose(double step, double *gain)
{
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(SIDE, SIDE, SIDE, CVOL_FLOAT32);
    cvol_compress_options options = cvol_compress_options_defaults();
    float *samples = make_samples();
    cvol_attempt attempt;
    assert_non_null(context);
    options.effort = CVOL_EFFORT_MAX;
    assert_int_equal(cvol_attempt_start(context, &attempt, samples, &grid, &options), 0);
    cvol_attempt_set_options(&attempt, &options);
    assert_int_equal(cvol_attempt_sample(context, &attempt, step), 0);
    assert_int_equal(cvol_attempt_fit(context, &attempt), 0);
    *gain = 1 - cost_with(context, &attempt, step, (cvol_split_bias){0.95f, 1}) /
                    cost_with(context, &attempt, step, (cvol_split_bias){1, 1});
    assert_int_equal(cvol_attempt_choose_split_bias(context, &attempt, step), 0);
    const cvol_split_bias chosen = attempt.split_bias;
    cvol_attempt_free(&attempt);
    cvol_context_free(context);
    free(samples);
    return chosen;
}

static void splits_are_preferred_if_they_save_bytes(void **state)
{
    (void)state;
    double gain;
    assert_float_equal(choose(0.02, &gain).cell, 0.95f, 1e-6f);
    assert_true(gain > 0.02); /* measured: 0.03 */
    assert_float_equal(choose(0.08, &gain).cell, 1, 1e-6f);
    assert_true(gain < 0); /* measured: -0.002 */
}

/* The sample's estimates for both coders lead to the step: within a few hundredths of those of all
 * bricks. */
static void sample_predicts_neural_coder_bytes(void **state)
{
    (void)state;
    const double step = 0.02;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(SIDE, SIDE, SIDE, CVOL_FLOAT32);
    cvol_compress_options options = cvol_compress_options_defaults();
    float *samples = make_samples();
    cvol_attempt attempt;
    options.effort = CVOL_EFFORT_MAX;
    assert_int_equal(cvol_attempt_start(context, &attempt, samples, &grid, &options), 0);
    cvol_attempt_set_options(&attempt, &options);
    assert_int_equal(cvol_attempt_choose_split_bias(context, &attempt, step), 0);
    assert_int_equal(cvol_attempt_sample(context, &attempt, step), 0);
    const double told = (double)attempt.bytes, error = attempt.result.error;
    assert_int_equal(cvol_attempt_encode(context, &attempt, step), 0);
    assert_true(fabs(told / (double)attempt.bytes - 1) < 0.005);
    assert_true(fabs(error / attempt.result.error - 1) < 0.01);
    cvol_attempt_free(&attempt);
    cvol_context_free(context);
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(splits_are_preferred_if_they_save_bytes),
        cmocka_unit_test(sample_predicts_neural_coder_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
