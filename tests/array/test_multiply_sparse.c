/* The output-sensitive product: right or not verified, never wrong, and within its bound. */
#include "test.h"

#include "array/multiply/multiply.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "base/memory.h"
#include "cvol/cvol.h"
#include "random.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846
#define SQRT_2 1.41421356237309504880

static const cvol_transform transforms[2] = {CVOL_DFT, CVOL_DHT};

/* ---- arrays with given terms ----------------------------------------------------------------- */

static size_t mirror_of(size_t place, const size_t dims[3])
{
    const size_t x = place % dims[0], y = place / dims[0] % dims[1], z = place / dims[0] / dims[1];
    return cvol_mirror_index(x, dims[0]) +
           dims[0] * (cvol_mirror_index(y, dims[1]) + dims[1] * cvol_mirror_index(z, dims[2]));
}

/* The value of a place within the low box, or NULL. */
static float *in_box(const cvol_spectrum *whole, size_t place, const size_t dims[3])
{
    const size_t i = cvol_box_index(place % dims[0], whole->low[0], whole->box[0], dims[0]);
    const size_t v = cvol_box_index(place / dims[0] % dims[1], whole->low[1], whole->box[1],
                                    dims[1]);
    const size_t w = cvol_box_index(place / dims[0] / dims[1], whole->low[2], whole->box[2],
                                    dims[2]);
    if (!whole->low_count || i == SIZE_MAX || v == SIZE_MAX || w == SIZE_MAX)
        return NULL;
    return &whole->low_values[i + whole->box[0] * (v + whole->box[1] * w)];
}

/* An array with these slots, in a low box of k per axis (0: none) and sparse; zeros are no
 * terms. */
static cvol_array *array_of(cvol_context *context, const float *slots, const size_t dims[3],
                            int rank, cvol_transform transform, size_t k)
{
    cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    cvol_array *array;
    const size_t N = dims[0] * dims[1] * dims[2];
    assert_int_equal(cvol_array_create_as(context, &array, &grid, rank, transform, 0), CVOL_OK);
    const size_t low[3] = {k, k, k};
    assert_int_equal(cvol_spectrum_start(context, &array->whole, transform, dims, low), CVOL_OK);
    assert_int_equal(cvol_spectrum_reserve(context, &array->whole, N), CVOL_OK);
    double energy = 0;
    for (size_t p = 0; p < N; p++)
        if (slots[p] != 0) {
            energy += (double)slots[p] * (double)slots[p];
            float *inside = in_box(&array->whole, p, dims);
            if (inside) {
                *inside = slots[p];
                continue;
            }
            array->whole.places[array->whole.sparse_count] = (uint32_t)p;
            array->whole.values[array->whole.sparse_count++] = slots[p];
        }
    array->error_bound.max_abs = sqrt(energy);
    array->error_bound.value_min = -sqrt(energy);
    array->error_bound.value_max = sqrt(energy);
    return array;
}

/* Random values at the marked places, and at their mirrors. */
static float *fill(random_state *random, const uint8_t *marks, const size_t dims[3])
{
    const size_t N = dims[0] * dims[1] * dims[2];
    float *slots = cvol_allocate_zero(N, sizeof *slots);
    for (size_t p = 0; p < N; p++)
        if (marks[p] || marks[mirror_of(p, dims)])
            slots[p] = (float)(random_signed(random) + 1.5) *
                       (random_below(random, 2) ? 1.0F : -1.0F);
    return slots;
}

/* ---- the direct sums, in double precision ---------------------------------------------------- */

/* Slots to F, both places of a pair. */
static void spectrum_of(double *re, double *im, const float *slots, const size_t dims[3],
                        cvol_transform transform)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    for (size_t p = 0; p < N; p++) {
        const size_t at[3] = {p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]};
        const int order = cvol_place_order(at, dims);
        const double own = slots[p], other = slots[mirror_of(p, dims)];
        const double first = order < 0 ? other : own, second = order < 0 ? own : other;
        re[p] = order == 0 ? own : transform == CVOL_DFT ? first / SQRT_2 : (first + second) / 2;
        im[p] = transform == CVOL_DFT ? second / SQRT_2 : (second - first) / 2;
        im[p] = order == 0 ? 0 : order < 0 ? -im[p] : im[p];
    }
}

/* The slots of the product: O(terms^2). */
static double *product_of(const float *a, const float *b, const size_t dims[3],
                          cvol_transform transform)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    double *spectra = cvol_allocate_zero(6 * N, sizeof *spectra);
    double *out = cvol_allocate(N, sizeof *out);
    double *re[3], *im[3];
    for (size_t k = 0; k < 3; k++) {
        re[k] = spectra + 2 * k * N;
        im[k] = re[k] + N;
    }
    spectrum_of(re[0], im[0], a, dims, transform);
    spectrum_of(re[1], im[1], b, dims, transform);
    size_t *lists = cvol_allocate(2 * N, sizeof *lists), counts[2] = {0, 0};
    for (size_t k = 0; k < 2; k++)
        for (size_t p = 0; p < N; p++)
            if (re[k][p] != 0 || im[k][p] != 0)
                lists[k * N + counts[k]++] = p;
    for (size_t i = 0; i < counts[0]; i++)
        for (size_t j = 0; j < counts[1]; j++) {
            const size_t p = lists[i], q = lists[N + j];
            const size_t x = (p % dims[0] + q % dims[0]) % dims[0];
            const size_t y = (p / dims[0] % dims[1] + q / dims[0] % dims[1]) % dims[1];
            const size_t z = (p / dims[0] / dims[1] + q / dims[0] / dims[1]) % dims[2];
            const size_t to = x + dims[0] * (y + dims[1] * z);
            re[2][to] += re[0][p] * re[1][q] - im[0][p] * im[1][q];
            im[2][to] += re[0][p] * im[1][q] + im[0][p] * re[1][q];
        }
    free(lists);
    const double scale = 1 / sqrt((double)N);
    for (size_t p = 0; p < N; p++) {
        const size_t at[3] = {p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]};
        const int order = cvol_place_order(at, dims);
        const double x = scale * re[2][p], y = scale * (order < 0 ? -im[2][p] : im[2][p]);
        if (order == 0)
            out[p] = x;
        else if (transform == CVOL_DFT)
            out[p] = SQRT_2 * (order > 0 ? x : y);
        else
            out[p] = order > 0 ? x - y : x + y;
    }
    free(spectra);
    return out;
}

/* ---- one product ----------------------------------------------------------------------------- */

/* Multiplies and checks all that can be checked in any case. Returns 1 if the plan was verified. */
static int check(cvol_context *context, const float *a, const float *b, const size_t dims[3],
                 int rank, cvol_transform transform, const cvol_keep *keep, uint64_t seed)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    cvol_array *arrays[3];
    arrays[0] = array_of(context, a, dims, rank, transform, seed % 3);
    arrays[1] = a == b ? arrays[0] : array_of(context, b, dims, rank, transform, seed % 2 * 4);
    assert_int_equal(cvol_array_create_like(context, &arrays[2], arrays[0]), CVOL_OK);
    cvol_build_result result = {0};
    int verified = -1;
    const int rc = cvol_multiply_sparse(context, arrays[2], &result, arrays[0], arrays[1], keep,
                                        (double)INFINITY, &verified);
    if (rc)
        fail_msg("seed %llu: %s", (unsigned long long)seed, cvol_context_message(context));
    if (!verified) {
        assert_null(arrays[2]->whole.values);
        assert_null(arrays[2]->whole.low_values);
    } else {
        float *kept = cvol_allocate(N, sizeof *kept);
        double *exact = product_of(a, b, dims, transform);
        double error = 0, norm = 0;
        cvol_spectrum_scatter(kept, &arrays[2]->whole, dims);
        for (size_t p = 0; p < N; p++) {
            error += ((double)kept[p] - exact[p]) * ((double)kept[p] - exact[p]);
            norm += exact[p] * exact[p];
        }
        error = sqrt(error);
        norm = sqrt(norm);
        const double bound = result.dropped + CVOL_ROUNDING * result.norm;
        if (error > bound || (keep->rule == CVOL_KEEP_L2 && bound > keep->value * (1 + 1e-9)) ||
            fabs(result.norm - norm) > 1e-3 * norm + 1e-30 ||
            (keep->rule == CVOL_KEEP_ALL && error > 1e-4 * norm))
            fail_msg("seed %llu, %zu x %zu x %zu %s: error %g, bound %g, norm %g, said %g",
                     (unsigned long long)seed, dims[0], dims[1], dims[2],
                     cvol_transform_name(transform), error, bound, norm, result.norm);
        free(kept);
        free(exact);
    }
    cvol_array_free(arrays[2]);
    if (arrays[1] != arrays[0])
        cvol_array_free(arrays[1]);
    cvol_array_free(arrays[0]);
    return verified;
}

/* Both transforms, all terms and few of them, a b and a a; returns how many of the 8 were
 * verified. */
static int check_all(const uint8_t *marks_a, const uint8_t *marks_b, const size_t dims[3], int rank,
                     uint64_t seed)
{
    cvol_context *context = cvol_context_create();
    random_state random = {seed};
    int verified = 0;
    for (int t = 0; t < 2; t++) {
        float *a = fill(&random, marks_a, dims), *b = fill(&random, marks_b, dims);
        const cvol_keep keeps[2] = {cvol_keep_all(), cvol_keep_terms(0, 40)};
        for (int k = 0; k < 2; k++) {
            cvol_context_set_threads(context, 1 + k);
            verified += check(context, a, b, dims, rank, transforms[t], &keeps[k], seed);
            verified += check(context, a, a, dims, rank, transforms[t], &keeps[k], seed);
        }
        free(a);
        free(b);
    }
    cvol_context_free(context);
    return verified;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* doc/method.md: n = 16, a = b = cos(2 pi x / 16) + cos(2 pi 5 x / 16): n' = 4 places, so 8 roots
 * of unity, that is the even samples. The terms of a^2 at 2 and 10 meet there: 2 = 10 modulo 8. */
static void test_counter_example(void **state)
{
    (void)state;
    const size_t dims[3] = {16, 1, 1};
    float slots[16] = {0};
    slots[1] = slots[5] = (float)sqrt(8.0); /* cos: F = 2 = sqrt(16) / 2; slot = sqrt 2 F */
    double even[8], sums[8];
    for (int j = 0; j < 8; j++) {
        const double x = 2.0 * j, v = cos(2 * PI * x / 16) + cos(2 * PI * 5 * x / 16);
        even[j] = v * v;
        /* Another array has the same eight values, and another square. */
        const double other = cos(2 * PI * x / 16) + cos(2 * PI * 3 * x / 16);
        assert_true(fabs(v - other) < 1e-12);
    }
    for (int r = 0; r < 8; r++) {
        sums[r] = 0;
        for (int j = 0; j < 8; j++)
            sums[r] += even[j] * cos(2 * PI * r * j / 8) / 8;
    }
    /* a^2 = 1 + cos(4 t) + cos(6 t) + (cos(2 t) + cos(10 t)) / 2: coefficients of e(u t) at
     * 0: 1, +-4: 1/2, +-6: 1/2, +-2: 1/4, +-10 = -+6: 1/4. */
    const size_t N = 16;
    double *exact = product_of(slots, slots, dims, CVOL_DFT);
    const double true_coefficient[9] = {1, 0, 0.25, 0, 0.5, 0, 0.75, 0, 0};
    for (size_t u = 0; u <= 8; u++) {
        const double f = exact[u] / (u == 0 || u == 8 ? 1 : SQRT_2) / sqrt((double)N);
        assert_true(fabs(f - true_coefficient[u]) < 1e-6);
    }
    /* The 8 evaluations give 1 at bin 0, 1 at bin 4, and at bin 2 the sum of places 2 and 10. */
    assert_true(fabs(sums[0] - 1) < 1e-12);
    assert_true(fabs(sums[2] - 1) < 1e-12); /* 1/4 (place 2) + 3/4 (place 10 = -6) */
    assert_true(fabs(sums[4] - 1) < 1e-12); /* 1/2 (place 4) + 1/2 (place 12 = -4) */
    free(exact);
    cvol_context *context = cvol_context_create();
    const cvol_keep all = cvol_keep_all();
    (void)check(context, slots, slots, dims, 1, CVOL_DFT, &all, 0);
    (void)check(context, slots, slots, dims, 1, CVOL_DHT, &all, 0);
    cvol_context_free(context);
}

/* Harmonics of a fundamental with side bands: h f + j. */
static void harmonics(uint8_t *marks, size_t n, size_t f, size_t count, size_t width,
                      uint32_t holes, random_state *random)
{
    memset(marks, 0, n);
    for (size_t h = 0; h < count; h++)
        for (size_t j = 0; j < width; j++)
            if (random_below(random, 100) >= holes)
                marks[(h * f + j) % n] = 1;
}

static void test_harmonics(void **state)
{
    (void)state;
    const size_t lengths[] = {32768, 65536, 5 << 13, 45001, 40961, 45002};
    int verified = 0, total = 0;
    for (size_t i = 0; i < 6; i++) {
        const uint64_t seed = 100 + i;
        random_state random = {seed};
        const size_t n = lengths[i % 6], dims[3] = {n, 1, 1};
        uint8_t *a = malloc(n), *b = malloc(n);
        const size_t f = n / 14 + random_below(&random, (uint32_t)n / 14);
        harmonics(a, n, f, 6, 2 + random_below(&random, 8), 30, &random);
        harmonics(b, n, f, 5, 2 + random_below(&random, 8), i % 2 ? 0 : 50, &random);
        verified += check_all(a, b, dims, 1, seed);
        total += 8;
        free(a);
        free(b);
    }
    print_message("harmonics: %d of %d verified\n", verified, total);
    assert_true(verified > total / 2);
}

/* sigma j modulo n: scattered everywhere, gathered by dilation. */
static void test_dilated(void **state)
{
    (void)state;
    const size_t lengths[] = {32768, 16384, 30375, 40961};
    int verified = 0, total = 0;
    for (size_t i = 0; i < 4; i++) {
        const uint64_t seed = 200 + i;
        random_state random = {seed};
        const size_t n = lengths[i % 4], dims[3] = {n, 1, 1},
                     sigma = 2 * random_below(&random, (uint32_t)n / 2) + 1;
        uint8_t *a = calloc(n, 1), *b = calloc(n, 1);
        for (size_t j = 0; j < 60; j++) {
            a[sigma * j % n] = random_below(&random, 3) > 0;
            b[sigma * j % n] = random_below(&random, 3) > 0;
        }
        verified += check_all(a, b, dims, 1, seed);
        total += 8;
        free(a);
        free(b);
    }
    print_message("dilated: %d of %d verified\n", verified, total);
    assert_true(verified > total / 2);
}

static void test_random_few(void **state)
{
    (void)state;
    int verified = 0, total = 0;
    for (size_t i = 0; i < 12; i++) {
        const uint64_t seed = 300 + i;
        random_state random = {seed};
        const size_t n = i % 3 == 2 ? 40961 : 65536, dims[3] = {n, 1, 1};
        uint8_t *a = calloc(n, 1), *b = calloc(n, 1);
        for (size_t j = 0; j < 1 + i; j++) {
            a[random_below(&random, (uint32_t)n)] = 1;
            b[random_below(&random, (uint32_t)n)] = 1;
        }
        verified += check_all(a, b, dims, 1, seed);
        total += 8;
        free(a);
        free(b);
    }
    print_message("random few: %d of %d verified\n", verified, total);
}

/* All terms in one residue class of every power of two: every fold puts them into one bin. */
static void test_one_bin(void **state)
{
    (void)state;
    int verified = 0, total = 0;
    for (size_t i = 0; i < 6; i++) {
        const size_t n = 32768, dims[3] = {n, 1, 1}, step = (size_t)256 << (i % 3);
        uint8_t *a = calloc(n, 1), *b = calloc(n, 1);
        for (size_t p = 0; p < n; p += step)
            a[p] = b[p] = 1;
        for (size_t p = 3; i >= 3 && p < n; p += step)
            b[p] = 1;
        verified += check_all(a, b, dims, 1, 400 + i);
        total += 8;
        free(a);
        free(b);
    }
    print_message("one bin: %d of %d verified\n", verified, total);
}

/* Magnitudes that decrease away from a few bands, the rest scattered: within an L2 bound only the
 * bands count. */
static void test_decaying(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    int verified = 0;
    for (uint64_t seed = 450; seed < 458; seed++) {
        random_state random = {seed};
        const size_t n = seed % 2 ? 65536 : 60000, dims[3] = {n, 1, 1};
        float *a = cvol_allocate_zero(n, sizeof *a);
        for (size_t h = 0; h < 5; h++)
            for (size_t j = 0; j < 40; j++)
                a[(h * 3001 + j) % n] = (float)random_signed(&random);
        for (size_t j = 0; j < 800; j++)
            a[random_below(&random, (uint32_t)n)] += (float)(1e-5 * random_signed(&random));
        const cvol_keep all = cvol_keep_all(), l2 = cvol_keep_l2(0.3);
        const cvol_transform transform = transforms[seed / 2 % 2];
        (void)check(context, a, a, dims, 1, transform, &all, seed);
        verified += check(context, a, a, dims, 1, transform, &l2, seed);
        free(a);
    }
    cvol_context_free(context);
    print_message("decaying: %d of 8 verified\n", verified);
    assert_int_equal(verified, 8);
}

/* All places occupied: no structure, and never verified by chance. */
static void test_dense(void **state)
{
    (void)state;
    const size_t n = 1024, dims[3] = {n, 1, 1};
    uint8_t *a = calloc(n, 1);
    random_state random = {7};
    for (size_t p = 0; p < n; p++)
        a[p] = random_below(&random, 8) == 0;
    assert_int_equal(check_all(a, a, dims, 1, 500), 0);
    free(a);
}

/* Ranks 2 and 3: narrow bands around points of a lattice. */
static void test_ranks(void **state)
{
    (void)state;
    const size_t shapes[][3] = {{512, 256, 1}, {320, 192, 1}, {64, 32, 64},
                                {251, 256, 1}, {36, 60, 48},  {245, 267, 1}};
    int verified = 0, total = 0;
    for (size_t i = 0; i < 6; i++) {
        const uint64_t seed = 600 + i;
        random_state random = {seed};
        const size_t *dims = shapes[i % 6], N = dims[0] * dims[1] * dims[2];
        uint8_t *a = calloc(N, 1), *b = calloc(N, 1);
        for (size_t k = 0; k < 3; k++) {
            const size_t x = k * (dims[0] / 5), y = k * (dims[1] / 3), z = k * (dims[2] / 4);
            for (size_t j = 0; j < 8; j++) {
                const size_t at = (x + j % 2) % dims[0] +
                                  dims[0] * ((y + j / 2 % 2) % dims[1] +
                                             dims[1] * ((z + j / 4) % dims[2]));
                a[at] = 1;
                b[at] = random_below(&random, 2) == 0;
            }
        }
        verified += check_all(a, b, dims, dims[2] > 1 ? 3 : 2, seed);
        total += 8;
        free(a);
        free(b);
    }
    print_message("ranks: %d of %d verified\n", verified, total);
    assert_true(verified > total / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counter_example), cmocka_unit_test(test_harmonics),
        cmocka_unit_test(test_dilated),         cmocka_unit_test(test_random_few),
        cmocka_unit_test(test_one_bin),         cmocka_unit_test(test_dense),
        cmocka_unit_test(test_ranks),           cmocka_unit_test(test_decaying),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
