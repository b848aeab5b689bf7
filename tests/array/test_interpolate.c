/* Interpolation of values by terms: on grids, at chirp points with known places, from a few samples
 * with unknown places; and the dense linear algebra for these. */
#include "test.h"

#include <complex.h>

#include "array/core/array.h"
#include "array/evaluate/fold.h"
#include "array/evaluate/small_matrix.h"
#include "base/context.h"
#include "random.h"
#include "support_context.h"
#include "transform/fft.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846

static const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};

/* ---- dense -------------------------------------------------------------------------------- */

static void test_least_squares(void **state)
{
    (void)state;
    random_state r = {.state = 1};
    enum { ROWS = 20, COLS = 7 };
    double a[ROWS * COLS], kept[ROWS * COLS], b[2 * ROWS], right[2 * ROWS];
    for (size_t i = 0; i < ROWS * COLS; i++)
        kept[i] = a[i] = random_signed(&r);
    for (size_t i = 0; i < 2 * ROWS; i++)
        right[i] = b[i] = random_signed(&r);
    cvol_dense_least_squares(a, b, ROWS, COLS, 2);
    /* the residual is orthogonal to every column */
    for (size_t j = 0; j < 2; j++)
        for (size_t c = 0; c < COLS; c++) {
            double sum = 0;
            for (size_t i = 0; i < ROWS; i++) {
                double fit = 0;
                for (size_t k = 0; k < COLS; k++)
                    fit += kept[ROWS * k + i] * b[ROWS * j + k];
                sum += kept[ROWS * c + i] * (right[ROWS * j + i] - fit);
            }
            assert_true(fabs(sum) < 1e-12);
        }
}

static void test_orthogonal_columns(void **state)
{
    (void)state;
    random_state r = {.state = 2};
    double a[12 * 9], lengths[9], energy = 0, sum = 0;
    for (size_t i = 0; i < 12 * 9; i++) {
        a[i] = random_signed(&r);
        energy += a[i] * a[i];
    }
    cvol_dense_orthogonalise(a, lengths, 12, 9);
    for (size_t i = 0; i < 9; i++) {
        sum += lengths[i] * lengths[i];
        assert_true(!i || lengths[i] <= lengths[i - 1]);
        for (size_t j = 0; j < i; j++) {
            double product = 0;
            for (size_t k = 0; k < 12; k++)
                product += a[12 * i + k] * a[12 * j + k];
            assert_true(fabs(product) < 1e-12);
        }
    }
    assert_true(fabs(sum - energy) < 1e-10);
}

/* S D S^-1 with D known: compares its characteristic functions, the traces of powers. */
static void test_eigenvalues(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        random_state r = {.state = seed};
        const size_t n = 1 + random_below(&r, 30);
        double complex *a = malloc(n * n * sizeof *a), *power = malloc(n * n * sizeof *a);
        double complex *next = malloc(n * n * sizeof *a), *values = malloc(n * sizeof *a);
        double complex traces[4] = {0};
        for (size_t i = 0; i < n * n; i++)
            power[i] = a[i] = (random_signed(&r) + (seed % 2 ? 0 : I * random_signed(&r))) /
                              sqrt((double)n);
        for (int p = 0; p < 4; p++) {
            for (size_t i = 0; i < n; i++)
                traces[p] += power[n * i + i];
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < n; j++) {
                    next[n * j + i] = 0;
                    for (size_t k = 0; k < n; k++)
                        next[n * j + i] += a[n * k + i] * power[n * j + k];
                }
            memcpy(power, next, n * n * sizeof *a);
        }
        assert_true(cvol_dense_eigenvalues(values, a, n));
        for (int p = 0; p < 4; p++) {
            double complex sum = 0;
            for (size_t i = 0; i < n; i++)
                sum += cpow(values[i], p + 1);
            if (cabs(sum - traces[p]) > 1e-10)
                fail_msg("seed %d, n %zu: trace of power %d is off by %g", (int)seed, n, p + 1,
                         cabs(sum - traces[p]));
        }
        free(a);
        free(power);
        free(next);
        free(values);
    }
}

/* ---- grids -------------------------------------------------------------------------------- */

static void fill_slots(float *slots, const cvol_array *array)
{
    cvol_spectrum_scatter(slots, &array->whole, array->grid.dims);
}

/* The array's own bounds against its samples and those of the exact array. */
static void check_error_bound(const cvol_array *array, const float *exact_slots, int seed)
{
    const size_t *dims = array->grid.dims, count = dims[0] * dims[1] * dims[2];
    float *exact = cvol_fft_allocate(count), *kept = cvol_fft_allocate(count);
    memcpy(exact, exact_slots, count * sizeof *exact);
    fill_slots(kept, array);
    assert_int_equal(cvol_whole_inverse(context, array->transform, exact, exact, dims), CVOL_OK);
    assert_int_equal(cvol_whole_inverse(context, array->transform, kept, kept, dims), CVOL_OK);
    double sum = 0;
    const cvol_error_bound *error_bound = &array->error_bound;
    for (size_t i = 0; i < count; i++) {
        const double a = (double)exact[i], b = (double)kept[i];
        sum += (a - b) * (a - b);
        if (a < error_bound->value_min || a > error_bound->value_max ||
            fabs(b) > error_bound->max_abs)
            fail_msg("seed %d: %g and %g are beyond %g .. %g, %g", seed, a, b,
                     error_bound->value_min, error_bound->value_max, error_bound->max_abs);
    }
    if (sqrt(sum) > error_bound->l2_error)
        fail_msg("seed %d: off by %g, bound %g", seed, sqrt(sum), error_bound->l2_error);
    free(exact);
    free(kept);
}

static double worst;

static void test_grid_passes_through(void **state)
{
    (void)state;
    worst = 0;
    for (int seed = 1; seed <= 150; seed++) {
        random_state r = {.state = (uint64_t)seed};
        const int rank = 1 + (int)random_below(&r, 3);
        const cvol_transform transform = transforms[random_below(&r, 3)];
        size_t dims[3] = {1, 1, 1}, points[3] = {1, 1, 1};
        for (int a = 0; a < rank; a++) {
            dims[a] = 1 + random_below(&r, rank == 1 ? 200 : rank == 2 ? 24 : 10);
            points[a] = random_below(&r, 4) ? 1 + random_below(&r, (uint32_t)dims[a]) : dims[a];
        }
        const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
        const size_t count = points[0] * points[1] * points[2];
        const size_t samples = dims[0] * dims[1] * dims[2];
        float *values = malloc(count * sizeof *values), *back = malloc(count * sizeof *back);
        double off = 0, norm = 0;
        for (size_t i = 0; i < count; i++)
            values[i] = (float)(3 + random_signed(&r));
        cvol_array *array, *few;
        assert_int_equal(cvol_array_interpolate_grid(context, &array, values, points, &grid, rank,
                                                     transform, NULL),
                         CVOL_OK);
        assert_int_equal(cvol_array_evaluate_grid(context, back, array, points), CVOL_OK);
        for (size_t i = 0; i < count; i++) {
            off += pow((double)values[i] - (double)back[i], 2);
            norm += pow((double)values[i], 2);
        }
        worst = fmax(worst, sqrt(off / norm));
        if (sqrt(off / norm) > 1e-5)
            fail_msg("seed %d: off by %g", seed, sqrt(off / norm));

        /* truncated: the dropped terms are in the error bound */
        float *slots = cvol_fft_allocate(samples);
        fill_slots(slots, array);
        check_error_bound(array, slots, seed);
        const cvol_keep keep = cvol_keep_terms(1, count / 3);
        assert_int_equal(cvol_array_interpolate_grid(context, &few, values, points, &grid, rank,
                                                     transform, &keep),
                         CVOL_OK);
        check_error_bound(few, slots, seed);
        cvol_array_free(array);
        cvol_array_free(few);
        free(values);
        free(back);
        free(slots);
    }
    print_message("interpolate grid: largest relative error %.2g\n", worst);
}

/* Spectra that the points resolve are reproduced. */
static void test_grid_is_exact_within(void **state)
{
    (void)state;
    for (size_t t = 0; t < 3; t++) {
        random_state r = {.state = 77 + t};
        const size_t dims[3] = {20, 15, 9}, points[3] = {12, 9, 5};
        const size_t low[3] = {5, 4, 2}, count = points[0] * points[1] * points[2];
        const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
        cvol_array *array, *back;
        assert_int_equal(cvol_array_create_as(context, &array, &grid, 3, transforms[t], 0),
                         CVOL_OK);
        assert_int_equal(cvol_spectrum_start(context, &array->whole, transforms[t], dims, low),
                         CVOL_OK);
        for (size_t i = 0; i < array->whole.low_count; i++)
            array->whole.low_values[i] = (float)random_signed(&r);
        float *values = malloc(count * sizeof *values);
        float *a = cvol_fft_allocate(2700), *b = cvol_fft_allocate(2700);
        assert_int_equal(cvol_array_evaluate_grid(context, values, array, points), CVOL_OK);
        assert_int_equal(cvol_array_interpolate_grid(context, &back, values, points, &grid, 3,
                                                     transforms[t], NULL),
                         CVOL_OK);
        fill_slots(a, array);
        fill_slots(b, back);
        for (size_t i = 0; i < 2700; i++)
            assert_true(fabs((double)a[i] - (double)b[i]) < 1e-5);
        cvol_array_free(array);
        cvol_array_free(back);
        free(values);
        free(a);
        free(b);
    }
}

/* ---- chirp points ---------------------------------------------------------------------------- */

/* Distinct places in rising order, closed under mirroring; returns their number. */
static size_t choose_places(uint32_t *places, size_t n, size_t pairs, size_t below, random_state *r)
{
    uint8_t *chosen = calloc(n, 1);
    for (size_t i = 0; i < pairs; i++) {
        const size_t u = random_below(r, (uint32_t)below);
        chosen[u] = chosen[cvol_mirror_index(u, n)] = 1;
    }
    size_t count = 0;
    for (size_t u = 0; u < n; u++)
        if (chosen[u])
            places[count++] = (uint32_t)u;
    free(chosen);
    return count;
}

/* An array of random terms at these places. */
static cvol_array *make_sparse(size_t n, cvol_transform transform, const uint32_t *places,
                               size_t terms, random_state *r)
{
    const cvol_grid grid = cvol_grid_make(n, 1, 1, CVOL_FLOAT32);
    cvol_array *array;
    assert_int_equal(cvol_array_create_as(context, &array, &grid, 1, transform, 0), CVOL_OK);
    assert_int_equal(cvol_spectrum_reserve(context, &array->whole, terms), CVOL_OK);
    for (size_t i = 0; i < terms; i++) {
        array->whole.places[i] = places[i];
        array->whole.values[i] = (float)(random_signed(r) + (random_below(r, 2) ? 2 : -2));
    }
    array->whole.sparse_count = terms;
    return array;
}

/* |difference of the terms| / |terms| */
static double term_distance(const cvol_array *a, const cvol_array *b)
{
    const size_t n = a->grid.dims[0];
    float *x = cvol_fft_allocate(n), *y = cvol_fft_allocate(n);
    double off = 0, norm = 0;
    fill_slots(x, a);
    fill_slots(y, b);
    for (size_t i = 0; i < n; i++) {
        off += pow((double)x[i] - (double)y[i], 2);
        norm += pow((double)x[i], 2);
    }
    free(x);
    free(y);
    return sqrt(off / norm);
}

static void test_chirp_finds_terms(void **state)
{
    (void)state;
    worst = 0;
    for (int seed = 1; seed <= 60; seed++) {
        random_state r = {.state = (uint64_t)seed};
        const cvol_transform transform = transforms[seed % 3];
        const size_t n = 20 + random_below(&r, 300);
        uint32_t places[400];
        const size_t terms = choose_places(places, n, 1 + random_below(&r, 8), n, &r);
        cvol_array *array = make_sparse(n, transform, places, terms, &r), *back;
        /* about the period, a little denser than the samples; for a DCT, half of its period */
        const size_t count = n + 10;
        const double step[3] = {(double)n / (double)count, 1, 1}, start[3] = {0.3, 0, 0};
        const size_t counts[3] = {count, 1, 1};
        float *values = malloc(count * sizeof *values);
        assert_int_equal(cvol_array_evaluate_chirp(context, values, array, start, step, counts),
                         CVOL_OK);
        for (size_t i = terms; i-- > 1;) { /* any order is valid */
            const size_t j = random_below(&r, (uint32_t)i + 1);
            const uint32_t place = places[i];
            places[i] = places[j];
            places[j] = place;
        }
        double residual, norm = 0;
        int code = cvol_array_interpolate_chirp(context, &back, &residual, values, count, start[0],
                                                step[0], places, terms, &array->grid, transform);
        if (code)
            fail_msg("seed %d: %s", seed, cvol_context_message(context));
        for (size_t i = 0; i < count; i++)
            norm += pow((double)values[i], 2);
        const double distance = term_distance(array, back);
        worst = fmax(worst, distance);
        if (distance > 1e-5 || residual > 1e-5 * sqrt(norm))
            fail_msg("seed %d: terms off by %g, residual %g of %g", seed, distance, residual,
                     sqrt(norm));
        float *slots = cvol_fft_allocate(n);
        fill_slots(slots, back);
        check_error_bound(back, slots, seed);
        free(slots);
        free(values);
        cvol_array_free(array);
        cvol_array_free(back);
    }
    print_message("interpolate chirp: terms off by %.2g at most\n", worst);
}

/* So many terms that the equations are not stored: chirp transforms. */
static void test_chirp_large(void **state)
{
    (void)state;
    for (size_t t = 0; t < 3; t++) {
        random_state r = {.state = 11 + t};
        const size_t n = 6000, count = 5000;
        static uint32_t places[6000];
        const size_t terms = choose_places(places, n, 900, 2000, &r);
        assert_true(terms * count > (size_t)1 << 22 && terms < count);
        cvol_array *array = make_sparse(n, transforms[t], places, terms, &r), *back;
        const double step[3] = {(double)n / (double)count, 1, 1}, start[3] = {-0.2, 0, 0};
        const size_t counts[3] = {count, 1, 1};
        float *values = malloc(count * sizeof *values);
        assert_int_equal(cvol_array_evaluate_chirp(context, values, array, start, step, counts),
                         CVOL_OK);
        double residual;
        int code = cvol_array_interpolate_chirp(context, &back, &residual, values, count, start[0],
                                                step[0], places, terms, &array->grid,
                                                transforms[t]);
        if (t == 0) { /* the mirrored places of a DCT are high cosines, which alias */
            assert_true(code == CVOL_OK || code == CVOL_ERROR_TARGET);
            cvol_array_free(code ? NULL : back);
        } else {
            if (code)
                fail_msg("%s", cvol_context_message(context));
            const double distance = term_distance(array, back);
            if (distance > 1e-5)
                fail_msg("transform %zu: terms off by %g", t, distance);
            cvol_array_free(back);
        }
        free(values);
        cvol_array_free(array);
    }
}

static void test_chirp_refuses(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(256, 1, 1, CVOL_FLOAT32);
    float values[40] = {1, 2, 3};
    uint32_t places[40];
    double residual;
    cvol_array *array;
    for (uint32_t i = 0; i < 40; i++)
        places[i] = i;
    /* 40 neighbouring frequencies from 40 samples of 256, and from one repeated point */
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, &residual, values, 40, 0, 1,
                                                  places, 40, &grid, CVOL_DCT),
                     CVOL_ERROR_TARGET);
    assert_null(array);
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 40, 3, 0, places,
                                                  2, &grid, CVOL_DHT),
                     CVOL_ERROR_TARGET);
    /* half a pair, a place twice, a place beyond, too few values */
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 40, 0, 6, places,
                                                  2, &grid, CVOL_DFT),
                     CVOL_ERROR_ARGUMENT);
    places[1] = 0;
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 40, 0, 6, places,
                                                  2, &grid, CVOL_DHT),
                     CVOL_ERROR_ARGUMENT);
    places[1] = 256;
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 40, 0, 6, places,
                                                  2, &grid, CVOL_DHT),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 1, 0, 6, places, 2,
                                                  &grid, CVOL_DHT),
                     CVOL_ERROR_ARGUMENT);
    values[5] = NAN;
    assert_int_equal(cvol_array_interpolate_chirp(context, &array, NULL, values, 40, 0, 6, places,
                                                  1, &grid, CVOL_DHT),
                     CVOL_ERROR_DATA);
}

/* ---- unknown places -------------------------------------------------------------------------- */

static void test_pencil_finds_places(void **state)
{
    (void)state;
    worst = 0;
    for (int seed = 1; seed <= 80; seed++) {
        random_state r = {.state = (uint64_t)seed};
        const cvol_transform transform = transforms[1 + seed % 2];
        /* places at least n / 40 apart, so that few samples distinguish them */
        const size_t n = 80 + random_below(&r, 4000), wanted = 1 + random_below(&r, 6);
        uint32_t places[64];
        uint8_t *chosen = calloc(n, 1);
        for (size_t i = 0; i < wanted; i++) {
            const size_t cell = random_below(&r, 20), u = cell * n / 40 + (n & 1);
            chosen[u] = chosen[cvol_mirror_index(u, n)] = 1;
        }
        size_t terms = 0;
        for (size_t u = 0; u < n; u++)
            if (chosen[u])
                places[terms++] = (uint32_t)u;
        free(chosen);
        const size_t most = 40 < n ? 40 : n;
        cvol_array *array = make_sparse(n, transform, places, terms, &r), *back;
        float values[80];
        const double start[3] = {0, 0, 0}, step[3] = {1, 1, 1};
        const size_t counts[3] = {2 * most, 1, 1};
        assert_int_equal(cvol_array_evaluate_chirp(context, values, array, start, step, counts),
                         CVOL_OK);
        double residual;
        int code = cvol_array_interpolate_pencil(context, &back, &residual, values, most,
                                                 &array->grid, transform);
        if (code)
            fail_msg("seed %d: %s", seed, cvol_context_message(context));
        const double distance = term_distance(array, back);
        worst = fmax(worst, distance);
        if (distance > 1e-4)
            fail_msg("seed %d, n %zu, %zu terms: off by %g, residual %g", seed, n, terms, distance,
                     residual);
        cvol_array_free(array);
        cvol_array_free(back);
    }
    print_message("interpolate pencil: terms off by %.2g at most\n", worst);
}

/* Places that are close to each other, and few values: the right terms, or a refusal. */
static void test_pencil_is_right_or_refuses(void **state)
{
    (void)state;
    int refused = 0;
    for (int seed = 1180; seed <= 1240; seed++) {
        random_state r = {.state = (uint64_t)seed};
        const cvol_transform transform = transforms[1 + seed % 2];
        const size_t n = 20 + random_below(&r, 800), wanted = 1 + random_below(&r, 5);
        uint32_t places[10];
        size_t terms = 0;
        uint8_t *chosen = calloc(n, 1);
        assert_non_null(chosen);
        for (size_t i = 0; i < wanted; i++) {
            const size_t u = random_below(&r, (uint32_t)n);
            chosen[u] = chosen[cvol_mirror_index(u, n)] = 1;
        }
        for (size_t u = 0; u < n; u++)
            if (chosen[u])
                places[terms++] = (uint32_t)u;
        free(chosen);
        size_t most = terms + random_below(&r, 12);
        most = most < n ? terms + random_below(&r, 12) : terms;
        cvol_array *array = make_sparse(n, transform, places, terms, &r), *back;
        float values[80];
        double residual;
        const double start[3] = {0, 0, 0}, step[3] = {1, 1, 1};
        const size_t counts[3] = {2 * most, 1, 1};
        assert_int_equal(cvol_array_evaluate_chirp(context, values, array, start, step, counts),
                         CVOL_OK);
        const int code = cvol_array_interpolate_pencil(context, &back, &residual, values, most,
                                                       &array->grid, transform);
        if (code) {
            assert_int_equal(code, CVOL_ERROR_TARGET);
            refused++;
        } else if (term_distance(array, back) > 1e-4) {
            fail_msg("seed %d, n %zu, %zu terms: off by %g, residual %g", seed, n, terms,
                     term_distance(array, back), residual);
        }
        cvol_array_free(array);
        cvol_array_free(back);
    }
    assert_true(refused <= 6);
}

/* The fewest values: 2 most for exactly `most` places. */
static void test_pencil_tight(void **state)
{
    (void)state;
    const uint32_t places[] = {0, 7, 25, 39, 57};
    random_state r = {.state = 4};
    const double start[3] = {0, 0, 0}, step[3] = {1, 1, 1};
    const size_t counts[3] = {10, 1, 1};
    float values[10];
    cvol_array *array = make_sparse(64, CVOL_DHT, places, 5, &r), *back;
    assert_int_equal(cvol_array_evaluate_chirp(context, values, array, start, step, counts),
                     CVOL_OK);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &back, NULL, values, 5, &array->grid, CVOL_DHT),
        CVOL_OK);
    assert_true(term_distance(array, back) < 1e-4);
    assert_int_equal(back->whole.sparse_count, 5);
    cvol_array_free(array);
    cvol_array_free(back);
}

static void test_pencil_refuses(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(512, 1, 1, CVOL_FLOAT32);
    random_state r = {.state = 8};
    float values[128], zeros[8] = {0};
    double residual;
    cvol_array *array;
    for (size_t i = 0; i < 128; i++)
        values[i] = (float)random_signed(&r);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, &residual, values, 20, &grid, CVOL_DFT),
        CVOL_ERROR_TARGET);
    assert_null(array);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, NULL, values, 64, &grid, CVOL_DHT),
        CVOL_ERROR_TARGET);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, NULL, values, 4, &grid, CVOL_DCT),
        CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, NULL, values, 65, &grid, CVOL_DHT),
        CVOL_ERROR_ARGUMENT);
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, NULL, values, 0, &grid, CVOL_DHT),
        CVOL_ERROR_ARGUMENT);
    /* zeros give no terms */
    assert_int_equal(
        cvol_array_interpolate_pencil(context, &array, &residual, zeros, 4, &grid, CVOL_DHT),
        CVOL_OK);
    assert_true(residual == 0 && array->whole.sparse_count == 0);
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_least_squares),
        cmocka_unit_test(test_orthogonal_columns),
        cmocka_unit_test(test_eigenvalues),
        cmocka_unit_test(test_grid_passes_through),
        cmocka_unit_test(test_grid_is_exact_within),
        cmocka_unit_test(test_chirp_finds_terms),
        cmocka_unit_test(test_chirp_large),
        cmocka_unit_test(test_chirp_refuses),
        cmocka_unit_test(test_pencil_finds_places),
        cmocka_unit_test(test_pencil_tight),
        cmocka_unit_test(test_pencil_refuses),
        cmocka_unit_test(test_pencil_is_right_or_refuses),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
