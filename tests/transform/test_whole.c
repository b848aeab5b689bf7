/* Transforms of whole arrays against their direct sums, and their defining properties; the
 * interface to fast transforms against itself, along lines, and from several threads. */
#include "test.h"

#include "base/context.h"
#include "random.h"
#include "support_context.h"
#include "transform/fft.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846
#define SQRT_2 1.41421356237309504880
#define TOLERANCE 1e-5

static const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};
#define EACH_TRANSFORM(t) for (size_t t = 0; t < 3; t++)

static const size_t shapes[][3] = {
    {1, 1, 1},  {2, 1, 1},  {3, 1, 1},   {16, 1, 1}, {97, 1, 1}, {360, 1, 1}, {1, 7, 1}, {2, 2, 1},
    {9, 16, 1}, {16, 9, 1}, {13, 17, 1}, {1, 1, 6},  {1, 2, 5},  {2, 1, 4},   {2, 2, 2}, {4, 4, 4},
    {5, 3, 7},  {6, 5, 4},  {4, 6, 2},   {7, 1, 8},  {12, 2, 9}, {257, 1, 1}};
#define SHAPES (sizeof shapes / sizeof shapes[0])
#define LARGEST 400

static size_t count_of(const size_t dims[3])
{
    return dims[0] * dims[1] * dims[2];
}

static float *buffer(size_t count)
{
    float *out = cvol_fft_allocate(count);
    assert_non_null(out);
    return out;
}

static float *random_buffer(size_t count, uint64_t seed)
{
    random_state r = {.state = seed};
    float *out = buffer(count);
    for (size_t i = 0; i < count; i++)
        out[i] = (float)(10 * random_signed(&r));
    return out;
}

static double norm(const float *a, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)a[i] * (double)a[i];
    return sqrt(sum);
}

/* |a - b| / |b| */
static double distance(const float *a, const double *b, size_t count)
{
    double sum = 0, of = 0;
    for (size_t i = 0; i < count; i++) {
        sum += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
        of += b[i] * b[i];
    }
    return sqrt(sum / (of > 0 ? of : 1));
}

static double float_distance(const float *a, const float *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
    double of = norm(b, count);
    return sqrt(sum) / (of > 0 ? of : 1);
}

static double worst;

static void check_close(double error, const char *what, const char *name, const size_t dims[3])
{
    worst = fmax(worst, error);
    if (error > TOLERANCE)
        fail_msg("%s, %s, %zux%zux%zu: off by %g", what, name, dims[0], dims[1], dims[2], error);
}

/* ---- against the direct sums ----------------------------------------------------------------- */

static void test_equals_direct_sums(void **state)
{
    (void)state;
    EACH_TRANSFORM(t)
    for (size_t s = 0; s < SHAPES; s++) {
        const size_t *dims = shapes[s], count = count_of(dims);
        const char *name = cvol_transform_name(transforms[t]);
        double truth[LARGEST], from[LARGEST];
        assert_true(count <= LARGEST);
        float *in = random_buffer(count, 1 + s), *out = buffer(count), *kept = buffer(count);
        memcpy(kept, in, count * sizeof *in);
        for (size_t i = 0; i < count; i++)
            from[i] = (double)in[i];

        cvol_whole_forward_reference(transforms[t], truth, from, dims);
        assert_int_equal(cvol_whole_forward(context, transforms[t], out, in, dims), CVOL_OK);
        check_close(distance(out, truth, count), "forward", name, dims);
        check_close(fabs(norm(out, count) / norm(in, count) - 1), "Parseval", name, dims);
        cvol_whole_inverse_reference(transforms[t], truth, from, dims);
        assert_int_equal(cvol_whole_inverse(context, transforms[t], out, in, dims), CVOL_OK);
        check_close(distance(out, truth, count), "inverse", name, dims);
        assert_memory_equal(in, kept, count * sizeof *in);

        /* in place, forward and back */
        assert_int_equal(cvol_whole_inverse(context, transforms[t], in, in, dims), CVOL_OK);
        check_close(float_distance(in, out, count), "in place", name, dims);
        assert_int_equal(cvol_whole_forward(context, transforms[t], in, in, dims), CVOL_OK);
        check_close(float_distance(in, kept, count), "round trip", name, dims);
        free(in);
        free(out);
        free(kept);
    }
    print_message("direct sums: largest relative error %.2g\n", worst);
}

/* The reference against the definitions in cvol/array.h, by direct formulas. */
static void test_reference_is_the_definition(void **state)
{
    (void)state;
    const size_t dims[3] = {4, 3, 2}, count = 24;
    double samples[24], dht[24], dft[24];
    random_state r = {.state = 5};
    for (size_t i = 0; i < count; i++)
        samples[i] = random_signed(&r);
    cvol_whole_forward_reference(CVOL_DHT, dht, samples, dims);
    cvol_whole_forward_reference(CVOL_DFT, dft, samples, dims);
    for (size_t p = 0; p < count; p++) {
        const size_t place[3] = {p % 4, p / 4 % 3, p / 12};
        size_t mirror = (4 - place[0]) % 4 + 4 * ((3 - place[1]) % 3 + 3 * ((2 - place[2]) % 2));
        double re = 0, im = 0;
        for (size_t i = 0; i < count; i++) {
            double t = 2 * PI *
                       ((double)(place[0] * (i % 4)) / 4 + (double)(place[1] * (i / 4 % 3)) / 3 +
                        (double)(place[2] * (i / 12)) / 2);
            re += samples[i] * cos(t) / sqrt(24.0);
            im -= samples[i] * sin(t) / sqrt(24.0);
        }
        assert_true(fabs(dht[p] - (re - im)) < 1e-12);
        int order = cvol_place_order(place, dims);
        if (order == 0)
            assert_true(p == mirror && fabs(dft[p] - re) < 1e-12);
        if (order > 0) {
            assert_true(fabs(dft[p] - SQRT_2 * re) < 1e-12);
            assert_true(fabs(dft[mirror] - SQRT_2 * im) < 1e-12);
            /* the pair's relation in both, see whole.h */
            assert_true(fabs(dht[p] - (dft[p] - dft[mirror]) / SQRT_2) < 1e-12);
            assert_true(fabs(dht[mirror] - (dft[p] + dft[mirror]) / SQRT_2) < 1e-12);
        }
    }
}

/* ---- properties ------------------------------------------------------------------------- */

static void test_linear(void **state)
{
    (void)state;
    EACH_TRANSFORM(t)
    for (size_t s = 0; s < SHAPES; s++) {
        const size_t *dims = shapes[s], count = count_of(dims);
        float *a = random_buffer(count, 20 + s), *b = random_buffer(count, 60 + s);
        float *sum = buffer(count);
        for (size_t i = 0; i < count; i++)
            sum[i] = 2 * a[i] - 3 * b[i];
        cvol_whole_forward(context, transforms[t], a, a, dims);
        cvol_whole_forward(context, transforms[t], b, b, dims);
        cvol_whole_forward(context, transforms[t], sum, sum, dims);
        for (size_t i = 0; i < count; i++)
            a[i] = 2 * a[i] - 3 * b[i];
        check_close(float_distance(sum, a, count), "linearity", cvol_transform_name(transforms[t]),
                    dims);
        free(a);
        free(b);
        free(sum);
    }
}

/* A constant is one term; an impulse at 0 is a flat spectrum under the DHT. */
static void test_constant_and_impulse(void **state)
{
    (void)state;
    for (size_t s = 0; s < SHAPES; s++) {
        const size_t *dims = shapes[s], count = count_of(dims);
        float *a = buffer(count);
        EACH_TRANSFORM(t)
        {
            for (size_t i = 0; i < count; i++)
                a[i] = 1;
            cvol_whole_forward(context, transforms[t], a, a, dims);
            assert_true(fabs((double)a[0] / sqrt((double)count) - 1) < TOLERANCE);
            assert_true(norm(a + 1, count - 1) < TOLERANCE * sqrt((double)count));
        }
        memset(a, 0, count * sizeof *a);
        a[0] = 1;
        cvol_whole_forward(context, CVOL_DHT, a, a, dims);
        for (size_t i = 0; i < count; i++)
            assert_true(fabs((double)a[i] * sqrt((double)count) - 1) < TOLERANCE);
        free(a);
    }
}

/* A circular shift by s multiplies F[u] by exp(-2 pi i u s / n). */
static void test_circular_shift(void **state)
{
    (void)state;
    static const size_t lengths[] = {2, 9, 16, 101};
    for (size_t l = 0; l < 4; l++) {
        const size_t n = lengths[l], dims[3] = {n, 1, 1}, shift = n / 2 + n % 2;
        float *a = random_buffer(n, 100 + l), *b = buffer(n);
        float *fa = buffer(2 * (n / 2 + 1)), *fb = buffer(2 * (n / 2 + 1));
        for (size_t x = 0; x < n; x++)
            b[(x + shift) % n] = a[x];
        assert_int_equal(cvol_fft(context, CVOL_FFT_FORWARD, dims, fa, a), CVOL_OK);
        assert_int_equal(cvol_fft(context, CVOL_FFT_FORWARD, dims, fb, b), CVOL_OK);
        for (size_t u = 0; u <= n / 2; u++) {
            const double t = -2 * PI * (double)(u * shift % n) / (double)n;
            const double re = (double)fa[2 * u], im = (double)fa[2 * u + 1];
            assert_true(fabs(re * cos(t) - im * sin(t) - (double)fb[2 * u]) < 1e-5 * norm(a, n));
            assert_true(fabs(re * sin(t) + im * cos(t) - (double)fb[2 * u + 1]) <
                        1e-5 * norm(a, n));
        }
        free(a);
        free(b);
        free(fa);
        free(fb);
    }
}

/* A cosine wave lies in the first slot of its pair, a sine wave in the second, under the DFT. */
static void test_mirrored_pairs(void **state)
{
    (void)state;
    static const size_t dims[3] = {6, 5, 4}, count = 120;
    float *a = buffer(count);
    for (size_t p = 0; p < count; p++) {
        const size_t place[3] = {p % 6, p / 6 % 5, p / 30};
        const int order = cvol_place_order(place, dims);
        if (order <= 0)
            continue;
        size_t mirror = 0, stride = 1;
        for (int i = 0; i < 3; i++) {
            mirror += stride * cvol_mirror_index(place[i], dims[i]);
            stride *= dims[i];
        }
        for (int sine = 0; sine < 2; sine++) {
            for (size_t i = 0; i < count; i++) {
                double t = 2 * PI *
                           ((double)(place[0] * (i % 6)) / 6 +
                            (double)(place[1] * (i / 6 % 5)) / 5 +
                            (double)(place[2] * (i / 30)) / 4);
                a[i] = (float)(sine ? sin(t) : cos(t));
            }
            cvol_whole_forward(context, CVOL_DFT, a, a, dims);
            const size_t at = sine ? mirror : p;
            assert_true(fabs(fabs((double)a[at]) - sqrt(60)) < 1e-4);
            a[at] = 0;
            assert_true(norm(a, count) < 1e-4);
        }
    }
    free(a);
}

/* half -> slots -> half, where the half complex spectrum is one of real samples. */
static void test_slots_and_half(void **state)
{
    (void)state;
    for (size_t s = 0; s < SHAPES; s++)
        for (size_t t = 1; t < 3; t++) {
            const size_t *dims = shapes[s], count = count_of(dims);
            const size_t floats = 2 * (dims[0] / 2 + 1) * dims[1] * dims[2];
            float *a = random_buffer(count, 300 + s), *slots = buffer(count);
            float *half = buffer(floats), *back = buffer(floats);
            assert_int_equal(cvol_fft(context, CVOL_FFT_FORWARD, dims, half, a), CVOL_OK);
            cvol_slots_from_half(transforms[t], slots, half, dims, 0.25F);
            cvol_half_from_slots(transforms[t], back, slots, dims, 4.0F);
            check_close(float_distance(back, half, floats), "slots",
                        cvol_transform_name(transforms[t]), dims);
            free(a);
            free(slots);
            free(half);
            free(back);
        }
}

/* ---- the interface ----------------------------------------------------------------------- */

/* Each real kind against its formula in fft.h. */
static void test_kinds_are_their_formulas(void **state)
{
    (void)state;
    for (size_t n = 2; n < 40; n += 5) {
        const size_t dims[3] = {n, 1, 1};
        float *a = random_buffer(n, n), *b = buffer(n);
        double dct[40], idct[40], idst[40];
        for (size_t i = 0; i < n; i++) {
            dct[i] = 0;
            idct[i] = (double)a[0];
            idst[i] = (i % 2 ? -1 : 1) * (double)a[n - 1];
            for (size_t j = 0; j < n; j++) {
                double up = PI * (double)i * ((double)j + 0.5) / (double)n;
                double down = PI * (double)j * ((double)i + 0.5) / (double)n;
                double sine = PI * (double)(j + 1) * ((double)i + 0.5) / (double)n;
                dct[i] += 2 * (double)a[j] * cos(up);
                idct[i] += j ? 2 * (double)a[j] * cos(down) : 0;
                idst[i] += j < n - 1 ? 2 * (double)a[j] * sin(sine) : 0;
            }
        }
        assert_int_equal(cvol_fft(context, CVOL_FFT_DCT, dims, b, a), CVOL_OK);
        check_close(distance(b, dct, n), "formula", "DCT", dims);
        assert_int_equal(cvol_fft(context, CVOL_FFT_IDCT, dims, b, a), CVOL_OK);
        check_close(distance(b, idct, n), "formula", "IDCT", dims);
        assert_int_equal(cvol_fft(context, CVOL_FFT_IDST, dims, b, a), CVOL_OK);
        check_close(distance(b, idst, n), "formula", "IDST", dims);
        free(a);
        free(b);
    }
}

/* Lines along y of a plane against one transform each. */
static void test_along_equals_single(void **state)
{
    (void)state;
    static const cvol_fft_kind kinds[] = {CVOL_FFT_FORWARD,
                                          CVOL_FFT_INVERSE,
                                          CVOL_FFT_DCT,
                                          CVOL_FFT_IDCT,
                                          CVOL_FFT_IDST,
                                          CVOL_FFT_COMPLEX_FORWARD,
                                          CVOL_FFT_COMPLEX_BACKWARD};
    static const size_t lengths[] = {2, 5, 12, 31};
    for (size_t k = 0; k < 7; k++)
        for (size_t l = 0; l < 4; l++) {
            const cvol_fft_kind kind = kinds[k];
            const size_t n = lengths[l], count = 6, dims[3] = {n, 1, 1}, half = n / 2 + 1;
            const size_t in_n = kind == CVOL_FFT_INVERSE ? half : n;
            const size_t out_n = kind == CVOL_FFT_FORWARD ? half : n;
            const size_t in_parts = kind == CVOL_FFT_INVERSE || kind >= CVOL_FFT_COMPLEX_FORWARD;
            const size_t out_parts = kind == CVOL_FFT_FORWARD || kind >= CVOL_FFT_COMPLEX_FORWARD;
            const size_t pi = 1 + in_parts, po = 1 + out_parts;
            float *in = random_buffer(pi * in_n * count, 7 * k + l);
            float *out = buffer(po * out_n * count), *line = buffer(pi * in_n);
            float *one = buffer(po * out_n), *kept = buffer(pi * in_n * count);
            if (kind == CVOL_FFT_INVERSE) /* spectra of real samples only */
                for (size_t i = 0; i < count; i++) {
                    in[pi * i + 1] = 0;
                    if (n % 2 == 0)
                        in[pi * (i + count * (half - 1)) + 1] = 0;
                }
            memcpy(kept, in, pi * in_n * count * sizeof *in);
            const cvol_fft_lines lines = {n, count, count, 1, count, 1};
            assert_int_equal(cvol_fft_along(context, kind, &lines, out, in), CVOL_OK);
            for (size_t i = 0; i < count; i++) {
                for (size_t x = 0; x < in_n; x++)
                    for (size_t p = 0; p < pi; p++)
                        line[pi * x + p] = kept[pi * (i + count * x) + p];
                assert_int_equal(cvol_fft(context, kind, dims, one, line), CVOL_OK);
                for (size_t x = 0; x < out_n; x++)
                    for (size_t p = 0; p < po; p++)
                        assert_true(fabsf(out[po * (i + count * x) + p] - one[po * x + p]) <
                                    1e-5F * 20 * (float)n);
            }
            free(in);
            free(out);
            free(line);
            free(one);
            free(kept);
        }
}

/* More shapes than the cache holds, twice, from all threads at once. */
static void test_many_plans_from_threads(void **state)
{
    (void)state;
    int failures = 0;
#pragma omp parallel for num_threads(4) schedule(dynamic) reduction(+ : failures)
    for (int i = 0; i < 1200; i++) {
        cvol_context *own = cvol_context_create();
        const size_t n = (size_t)(i % 400) + 2, dims[3] = {n, 1, 1};
        float *a = cvol_fft_allocate(n);
        for (size_t x = 0; x < n; x++)
            a[x] = (float)x;
        failures += cvol_fft(own, CVOL_FFT_DCT, dims, a, a) != CVOL_OK;
        failures += fabs((double)a[0] / (double)(n * (n - 1)) - 1) > TOLERANCE;
        free(a);
        cvol_context_free(own);
    }
    assert_int_equal(failures, 0);
}

static void test_good_lengths(void **state)
{
    (void)state;
    assert_int_equal(cvol_fft_good_length(0, 0), 1);
    assert_int_equal(cvol_fft_good_length(7, 0), 7);
    assert_int_equal(cvol_fft_good_length(7, 1), 8);
    assert_int_equal(cvol_fft_good_length(13, 1), 14);
    assert_int_equal(cvol_fft_good_length(49, 0), 50);
    assert_int_equal(cvol_fft_good_length(121, 0), 125);
    assert_int_equal(cvol_fft_good_length(121, 1), 126);
}

static void test_too_large(void **state)
{
    (void)state;
    const size_t dims[3] = {SIZE_MAX / 2, 3, 1};
    float dummy[2] = {0};
    assert_int_equal(cvol_fft(context, CVOL_FFT_DCT, dims, dummy, dummy), CVOL_ERROR_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equals_direct_sums),
        cmocka_unit_test(test_reference_is_the_definition),
        cmocka_unit_test(test_linear),
        cmocka_unit_test(test_constant_and_impulse),
        cmocka_unit_test(test_circular_shift),
        cmocka_unit_test(test_mirrored_pairs),
        cmocka_unit_test(test_slots_and_half),
        cmocka_unit_test(test_kinds_are_their_formulas),
        cmocka_unit_test(test_along_equals_single),
        cmocka_unit_test(test_many_plans_from_threads),
        cmocka_unit_test(test_good_lengths),
        cmocka_unit_test(test_too_large),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
