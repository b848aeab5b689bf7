/* Half and twice the samples of volumes in which samples have no value: a sample of the result has
 * a value if all samples that it is made of have one. The decoded samples, in double precision, are
 * the reference; a result may be off by what its truncation dropped. */
#include "test.h"

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support_context.h"
#include "support_render.h"

static const size_t zero[3] = {0, 0, 0};

typedef struct shape {
    size_t dims[3];
    int lapped, block, fills;
} shape;

static size_t count_of(const size_t dims[3])
{
    return dims[0] * dims[1] * dims[2];
}

/* Waves around a ball, and some single samples, without a value. */
static cvol_array *make_operand(const shape *s, random_state *r)
{
    static const float fills[3] = {1e35f, NAN, INFINITY};
    cvol_volume volume = support_volume(s->dims[0], s->dims[1], s->dims[2], CVOL_FLOAT32);
    float *samples = volume.data;
    for (size_t i = 0; i < count_of(s->dims); i++) {
        const double x = (double)(i % s->dims[0]), y = (double)(i / s->dims[0] % s->dims[1]),
                     z = (double)(i / s->dims[0] / s->dims[1]);
        samples[i] = (float)(70 + 15 * sin(x / 5) * cos(y / 6) + 9 * sin(z / 4) + random_signed(r));
        const double from[3] = {x - 0.6 * (double)s->dims[0], y - 0.4 * (double)s->dims[1],
                                z - 0.3 * (double)s->dims[2]};
        if (from[0] * from[0] + from[1] * from[1] + from[2] * from[2] < 100 ||
            random_below(r, 400) == 0)
            samples[i] = fills[random_below(r, (uint32_t)s->fills)];
    }
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 40;
    options.effort = CVOL_EFFORT_FAST;
    options.lapped = s->lapped;
    options.block = s->block;
    options.has_fill = 1;
    options.fill = 1e35;
    cvol_array *array;
    check_ok(cvol_compress(context, &array, NULL, samples, &volume.grid, &options));
    assert_true(cvol_mask_is_void(array->mask));
    free(samples);
    return array;
}

/* The samples, and 1 for those without a value. */
static double *decode(uint8_t *is_void, const cvol_array *array)
{
    const size_t count = count_of(array->grid.dims);
    float *real = malloc(count * sizeof *real);
    double *out = malloc(count * sizeof *out);
    assert_true(real && out);
    check_ok(cvol_array_evaluate_unmasked(context, real, array, zero, array->grid.dims));
    memset(is_void, 0, count);
    if (array->mask)
        cvol_mask_get(is_void, array->mask, zero, array->grid.dims);
    for (size_t i = 0; i < count; i++) {
        out[i] = (double)real[i];
        is_void[i] = is_void[i] != 0;
    }
    free(real);
    return out;
}

/* One axis of the definition in cvol/algebra.h: the two samples and the first one's weight. */
static double sources(size_t out[2], size_t x, size_t n, int factor)
{
    if (factor == -2) {
        out[0] = 2 * x;
        out[1] = 2 * x + 1 < n ? 2 * x + 1 : n - 1;
        return 0.5;
    }
    out[0] = x / 2;
    out[1] = x % 2 ? (x / 2 + 1 < n ? x / 2 + 1 : n - 1) : x / 2 ? x / 2 - 1 : 0;
    return 0.75;
}

static double reference_at(int *is_void, const double *in, const uint8_t *voids,
                           const cvol_array *a, const size_t at[3], int factor)
{
    const size_t *dims = a->grid.dims;
    size_t from[3][2] = {{0}};
    double weight[3] = {1, 1, 1}, sum = 0;
    for (int axis = 0; axis < a->rank; axis++)
        weight[axis] = sources(from[axis], at[axis], dims[axis], factor);
    *is_void = 0;
    for (int k = 0; k < 8; k++) {
        const int bit[3] = {k & 1, k >> 1 & 1, k >> 2};
        const size_t i = from[0][bit[0]] + dims[0] * (from[1][bit[1]] + dims[1] * from[2][bit[2]]);
        double w = 1;
        for (int axis = 0; axis < 3; axis++)
            w *= bit[axis] ? 1 - weight[axis] : weight[axis];
        sum += w * in[i];
        *is_void |= w > 0 && voids[i];
    }
    return sum;
}

static void check(const cvol_array *a, int factor)
{
    cvol_array *result;
    check_ok(cvol_array_resample(context, &result, a, factor, NULL));
    const size_t *dims = result->grid.dims;
    uint8_t *voids_in = malloc(count_of(a->grid.dims)), *voids = malloc(count_of(dims));
    assert_true(voids_in && voids);
    double *in = decode(voids_in, a), *out = decode(voids, result), squares = 0, norm = 0;
    size_t missing = 0;
    for (size_t i = 0; i < count_of(dims); i++) {
        const size_t at[3] = {i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]};
        int is_void;
        const double expected = reference_at(&is_void, in, voids_in, a, at, factor);
        if (is_void != voids[i])
            fail_msg("factor %d: sample %zu %zu %zu has %s value", factor, at[0], at[1], at[2],
                     voids[i] ? "no" : "a");
        missing += is_void != 0;
        squares += is_void ? 0 : (out[i] - expected) * (out[i] - expected);
        norm += is_void ? 0 : expected * expected;
    }
    double carried = a->error_bound.l2_error;
    for (int axis = 0; axis < a->rank; axis++)
        carried *= factor == 2 ? sqrt(2) : a->grid.dims[axis] % 2 ? 1 : sqrt(0.5);
    const double dropped = result->error_bound.l2_error - carried;
    if (!(sqrt(squares) <= dropped + 1e-6 * sqrt(norm)))
        fail_msg("factor %d: off by %g, the bound allows %g", factor, sqrt(squares), dropped);
    cvol_array_info info;
    cvol_array_get_info(&info, result);
    assert_true(missing > 0 && info.missing_samples == missing);
    /* Samples are read with their marks. */
    float *read = malloc(count_of(dims) * sizeof *read);
    assert_non_null(read);
    check_ok(cvol_array_evaluate_box(context, read, result, zero, dims));
    for (size_t i = 0; i < count_of(dims); i++)
        if (voids[i] != !(fabsf(read[i]) < 1e34f))
            fail_msg("factor %d: sample %zu is %g", factor, i, (double)read[i]);
    free(read);
    free(in);
    free(out);
    free(voids_in);
    free(voids);
    cvol_array_free(result);
}

static void test_missing_samples_stay_missing(void **state)
{
    (void)state;
    static const shape shapes[] = {{{53, 42, 38}, 1, 16, 1}, {{40, 37, 33}, 0, 16, 2},
                                   {{32, 48, 16}, 0, 8, 3},  {{45, 50, 21}, 0, 32, 1},
                                   {{90, 71, 1}, 1, 16, 2},  {{200, 1, 1}, 0, 16, 3}};
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++) {
        random_state r = {k + 1};
        cvol_array *a = make_operand(&shapes[k], &r);
        check(a, -2);
        check(a, 2);
        cvol_array_free(a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_setup_teardown(
        test_missing_samples_stay_missing, context_setup, context_teardown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
