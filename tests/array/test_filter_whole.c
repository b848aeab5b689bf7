/* Filters of whole arrays, against the same computed on all samples in double precision: the
 * result's samples, and that every bound holds for the exact samples. */
#include "test.h"

#include "array/convolve/kernel.h"
#include "cvol/algebra.h"
#include "support_operations.h"
#include "transform/whole.h"

/* ---- kernels --------------------------------------------------------------------------------- */

static cvol_kernel random_kernel(random_state *r, int rank)
{
    cvol_kernel kernel;
    memset(&kernel, 0, sizeof kernel);
    kernel.parts = 1 + (int)random_below(r, CVOL_KERNEL_PARTS);
    for (int t = 0; t < kernel.parts; t++) {
        kernel.weight[t] = random_signed(r);
        for (int a = 0; a < 3; a++) {
            cvol_kernel_line *line = &kernel.line[t][a];
            line->taps[0] = 1;
            if (a >= rank)
                continue;
            line->radius = (int)random_below(r, 4);
            line->antisymmetric = line->radius && random_below(r, 2) == 0;
            for (int i = 0; i <= line->radius; i++)
                line->taps[i] = line->antisymmetric && !i ? 0 : random_signed(r);
        }
    }
    return kernel;
}

static cvol_kernel some_kernel(cvol_context *context, random_state *r, int rank, int which)
{
    static const char *const names[] = {"gaussian:2",    "box:3",        "laplacian",
                                        "unsharp:1,0.7", "derivative:x", "gaussian:7.5"};
    cvol_kernel kernel;
    if (which < 6)
        assert_int_equal(cvol_kernel_parse(context, &kernel, rank, names[which]), CVOL_OK);
    else if (which == 6)
        assert_int_equal(cvol_kernel_derivative(context, &kernel, rank, rank - 1), CVOL_OK);
    else
        kernel = random_kernel(r, rank);
    return kernel;
}

static void check_filter(cvol_context *context, random_state *r, const whole_case *w)
{
    const cvol_kernel k = some_kernel(context, r, w->shape->rank,
                                      (w->round + (int)(w->shape - whole_shapes)) % 10);
    double *dense = whole_filtered(w->samples, w->shape->dims, &k, w->transform == CVOL_DCT);
    double *exact = whole_filtered(w->a.exact, w->shape->dims, &k, w->transform == CVOL_DCT);
    cvol_array *result;
    const cvol_keep all = cvol_keep_all();
    assert_int_equal(cvol_array_convolve_kernel(context, &result, w->a.array, &k, &all), CVOL_OK);
    double norm, sum;
    cvol_kernel_bounds(&k, &norm, &sum);
    whole_check("kernel", w->seed, result, dense, exact, norm * support_norm(w->samples, w->count));
    cvol_array_free(result);
    /* like its inputs: no more terms than these, except partners; all losses counted */
    assert_int_equal(cvol_array_convolve_kernel(context, &result, w->a.array, &k, NULL), CVOL_OK);
    whole_check("kernel, like its input", w->seed, result, NULL, exact, 0);
    assert_true(result->whole.sparse_count <= 2 * w->a.array->whole.sparse_count);
    cvol_array_free(result);
    free(dense);
    free(exact);
}

static void filtering_equals_that_of_samples(void **state)
{
    random_state r = {1};
    whole_each(*state, &r, CVOL_DCT, 12, check_filter);
}

/* A mirrored ramp's derivative: 1 inside, 1/2 at both ends, where the last sample is repeated. */
static void derivative_of_mirrored_ramp(void **state)
{
    cvol_context *context = *state;
    const size_t dims[3] = {9, 1, 1}, low[3] = {9, 1, 1};
    random_state r = {5};
    support_whole a = support_whole_make(context, &r, CVOL_DCT, 1, dims, low, 0, 0);
    double ramp[9], slots[9];
    for (int i = 0; i < 9; i++)
        ramp[i] = i;
    cvol_whole_forward_reference(CVOL_DCT, slots, ramp, dims);
    for (int i = 0; i < 9; i++)
        a.array->whole.low_values[i] = (float)slots[i];
    a.array->error_bound = (cvol_error_bound){
        .l2_error = 1e-5, .max_abs = 8, .value_min = 0, .value_max = 8};
    cvol_kernel k;
    cvol_array *result;
    assert_int_equal(cvol_kernel_derivative(context, &k, 1, 0), CVOL_OK);
    assert_int_equal(cvol_array_convolve_kernel(context, &result, a.array, &k, NULL), CVOL_OK);
    double *d = support_whole_samples(result);
    for (int i = 0; i < 9; i++)
        assert_true(fabs(d[i] - (i == 0 || i == 8 ? 0.5 : 1)) < 1e-5);
    free(d);
    cvol_array_free(result);
    support_whole_free(&a);
}

/* Kept terms and counted losses under every rule: no error beyond the bound, no better choice. */
static void truncated_results(void **state)
{
    cvol_context *context = *state;
    random_state r = {11};
    const struct whole_shape shape = {3, {8, 6, 5}};
    const size_t N = 240, low[3] = {8, 6, 5};
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
        const cvol_keep keeps[] = {
            cvol_keep_terms(2, 20),   cvol_keep_terms(0, 31), cvol_keep_rho(0.3),  cvol_keep_l2(2),
            cvol_keep_threshold(0.2), cvol_keep_psnr(12),     cvol_keep_ratio(1.5)};
        for (size_t i = 0; i < sizeof keeps / sizeof keeps[0]; i++) {
            const uint64_t seed = r.state;
            support_whole a = support_whole_make(context, &r, (cvol_transform)t, shape.rank,
                                                 shape.dims, low, 0, 1);
            const cvol_kernel k = some_kernel(context, &r, 3, 6 + (int)(i % 2));
            double *samples = support_whole_samples(a.array);
            double *dense = whole_filtered(samples, shape.dims, &k, t == CVOL_DCT);
            double *exact = whole_filtered(a.exact, shape.dims, &k, t == CVOL_DCT);
            cvol_array *result;
            const int code = cvol_array_convolve_kernel(context, &result, a.array, &k, &keeps[i]);
            if (code)
                fail_msg("keep %d, seed %llu: %s", (int)keeps[i].rule, (unsigned long long)seed,
                         cvol_context_message(context));
            whole_check("kernel, truncated", seed, result, NULL, exact, 0);
            /* energy is conserved: |dense|^2 = |kept|^2 + |dropped|^2 */
            double *kept = support_whole_samples(result);
            const double all = support_norm(dense, N), one = support_norm(kept, N);
            const double other = support_distance(dense, kept, N);
            assert_true(fabs(all - hypot(one, other)) <= 1e-5 * all);
            if (keeps[i].rule == CVOL_KEEP_L2)
                assert_true(other <= 2 * (1 + 1e-5));
            free(kept);
            free(samples);
            free(dense);
            free(exact);
            cvol_array_free(result);
            support_whole_free(&a);
        }
    }
}

static void same_bits_for_any_threads(void **state)
{
    cvol_context *context = *state;
    random_state r = {9};
    const struct whole_shape shape = {3, {8, 6, 4}};
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
        support_whole a = whole_make(context, &r, (cvol_transform)t, &shape, 2);
        const cvol_kernel k = random_kernel(&r, 3);
        cvol_array *one, *many;
        cvol_context_set_threads(context, 1);
        assert_int_equal(cvol_array_convolve_kernel(context, &one, a.array, &k, NULL), CVOL_OK);
        cvol_context_set_threads(context, 3);
        assert_int_equal(cvol_array_convolve_kernel(context, &many, a.array, &k, NULL), CVOL_OK);
        cvol_context_set_threads(context, 0);
        const cvol_spectrum *x = &one->whole, *y = &many->whole;
        assert_true(x->sparse_count == y->sparse_count);
        assert_memory_equal(x->low_values, y->low_values, x->low_count * sizeof(float));
        assert_memory_equal(x->values, y->values, x->sparse_count * sizeof(float));
        cvol_array_free(one);
        cvol_array_free(many);
        support_whole_free(&a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(filtering_equals_that_of_samples),
        cmocka_unit_test(derivative_of_mirrored_ramp),
        cmocka_unit_test(truncated_results),
        cmocka_unit_test(same_bits_for_any_threads),
    };
    return cmocka_run_group_tests(tests, whole_set_up, whole_tear_down);
}
