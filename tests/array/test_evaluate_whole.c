/* Arrays between their samples: on grids, at chirp points and at scattered points, against the sum
 * over the spectrum written out in double precision. */
#include "test.h"

#include "array/core/array.h"
#include "base/context.h"
#include "random.h"
#include "support_context.h"
#include "transform/fft.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846
#define SQRT_2 1.41421356237309504880
#define TOLERANCE 1e-5

static const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};

static const size_t shapes[][3] = {{1, 1, 1},   {2, 1, 1}, {24, 1, 1}, {31, 1, 1},
                                   {200, 1, 1}, {8, 6, 1}, {7, 10, 1}, {1, 9, 1},
                                   {6, 4, 8},   {5, 7, 3}, {8, 5, 6},  {4, 1, 6}};
#define SHAPES (sizeof shapes / sizeof shapes[0])

static int rank_of(const size_t dims[3])
{
    return dims[2] > 1 ? 3 : dims[1] > 1 ? 2 : 1;
}

/* ---- arrays and their sums ---------------------------------------------------------------- */

/* A low box of k (0: none) and about `share` of the other places, random values. */
static cvol_array *make_array(const size_t dims[3], cvol_transform transform, size_t k,
                              double share, random_state *r)
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const size_t low[3] = {k, k, k}, count = dims[0] * dims[1] * dims[2];
    cvol_array *array;
    assert_int_equal(cvol_array_create_as(context, &array, &grid, rank_of(dims), transform, 0),
                     CVOL_OK);
    cvol_spectrum *whole = &array->whole;
    assert_int_equal(cvol_spectrum_start(context, whole, transform, dims, low), CVOL_OK);
    assert_int_equal(cvol_spectrum_reserve(context, whole, count), CVOL_OK);
    for (size_t i = 0; i < whole->low_count; i++)
        whole->low_values[i] = (float)random_signed(r);
    for (size_t i = 0; i < count; i++) {
        const size_t place[3] = {i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]};
        int inside = whole->low_count > 0;
        for (int a = 0; a < 3 && inside; a++)
            inside = cvol_box_index(place[a], whole->low[a], whole->box[a], dims[a]) != SIZE_MAX;
        if (inside || fabs(random_signed(r)) > share)
            continue;
        whole->places[whole->sparse_count] = (uint32_t)i;
        whole->values[whole->sparse_count++] = (float)random_signed(r);
    }
    return array;
}

/* phi of one axis; see array/evaluate/interpolant.h. */
static void wave(double phi[2], cvol_transform transform, size_t u, double x, size_t n)
{
    const double frequency = 2 * u < n ? (double)u : (double)u - (double)n;
    if (transform == CVOL_DCT) {
        phi[0] = sqrt((u ? 2 : 1) / (double)n) * cos(PI * (double)u * (x + 0.5) / (double)n);
        phi[1] = 0;
    } else {
        phi[0] = cos(2 * PI * frequency * x / (double)n);
        phi[1] = 2 * u == n ? 0 : sin(2 * PI * frequency * x / (double)n);
    }
}

/* sum_p F[p] phi phi phi / sqrt N with F as transform/whole.h gives it; DCT: sum A D D D. */
static double direct_sum(const float *slots, cvol_transform transform, const size_t dims[3],
                         const double x[3])
{
    const size_t count = dims[0] * dims[1] * dims[2];
    double sum = 0;
    for (size_t p = 0; p < count; p++) {
        const size_t place[3] = {p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]};
        size_t m = 0, stride = 1;
        double product[2] = {1, 0};
        for (int a = 0; a < 3; a++) {
            double phi[2], re;
            m += stride * cvol_mirror_index(place[a], dims[a]);
            stride *= dims[a];
            wave(phi, transform, place[a], x[a], dims[a]);
            re = product[0] * phi[0] - product[1] * phi[1];
            product[1] = product[0] * phi[1] + product[1] * phi[0];
            product[0] = re;
        }
        const double here = (double)slots[p], there = (double)slots[m];
        const int order = cvol_place_order(place, dims);
        double f[2] = {here, 0};
        if (transform == CVOL_DHT) {
            f[0] = (here + there) / 2;
            f[1] = (there - here) / 2;
        } else if (transform == CVOL_DFT && order) {
            f[0] = (order > 0 ? here : there) / SQRT_2;
            f[1] = (order > 0 ? there : -here) / SQRT_2;
        }
        sum += f[0] * product[0] - f[1] * product[1];
    }
    return transform == CVOL_DCT ? sum : sum / sqrt((double)count);
}

typedef struct attempt {
    cvol_array *array;
    float *slots;
    double norm;
    uint64_t seed;
    random_state r;
} attempt;

static attempt start_case(size_t shape, size_t t, uint64_t seed)
{
    attempt out = {.seed = seed, .r = {.state = seed}};
    const size_t *dims = shapes[shape];
    const size_t k = random_below(&out.r, 5);
    const double share = random_below(&out.r, 3) ? fabs(random_signed(&out.r)) : 0;
    out.array = make_array(dims, transforms[t], k, share, &out.r);
    out.slots = cvol_fft_allocate(dims[0] * dims[1] * dims[2]);
    cvol_spectrum_scatter(out.slots, &out.array->whole, dims);
    out.norm = sqrt(cvol_spectrum_energy(&out.array->whole)) + 1e-30;
    return out;
}

static void end_case(attempt *of)
{
    cvol_array_free(of->array);
    free(of->slots);
}

static double worst;

static void check_value(const attempt *of, const char *what, float value, const double x[3])
{
    const size_t *dims = of->array->grid.dims;
    const double truth = direct_sum(of->slots, of->array->transform, dims, x);
    const double error = fabs((double)value - truth) / of->norm;
    worst = fmax(worst, error);
    if (error > TOLERANCE)
        fail_msg("%s, %s, %zux%zux%zu, seed %d: %g at (%g, %g, %g) where the sum is %g", what,
                 cvol_transform_name(of->array->transform), dims[0], dims[1], dims[2],
                 (int)of->seed, (double)value, x[0], x[1], x[2], truth);
}

#define EACH_CASE(seed, s, t)                  \
    for (uint64_t seed = 1; seed <= 4; seed++) \
        for (size_t s = 0; s < SHAPES; s++)    \
            for (size_t t = 0; t < 3; t++)

/* ---- grids -------------------------------------------------------------------------------- */

static void check_grid(const attempt *of, const size_t points[3])
{
    const size_t *dims = of->array->grid.dims, count = points[0] * points[1] * points[2];
    float *out = malloc(count * sizeof *out);
    assert_int_equal(cvol_array_evaluate_grid(context, out, of->array, points), CVOL_OK);
    for (size_t i = 0; i < count; i++) {
        const size_t at[3] = {i % points[0], i / points[0] % points[1], i / points[0] / points[1]};
        double x[3];
        for (int a = 0; a < 3; a++) {
            const double ratio = (double)dims[a] / (double)points[a];
            x[a] = of->array->transform == CVOL_DCT ? ((double)at[a] + 0.5) * ratio - 0.5
                                                    : (double)at[a] * ratio;
        }
        check_value(of, "grid", out[i], x);
    }
    free(out);
}

/* More points, fewer (which alias), the same. */
static void test_grid(void **state)
{
    (void)state;
    worst = 0;
    EACH_CASE(seed, s, t)
    {
        attempt of = start_case(s, t, 100 * seed + 3 * s + t);
        size_t points[3];
        check_grid(&of, shapes[s]);
        for (int round = 0; round < 2; round++) {
            for (int a = 0; a < 3; a++)
                points[a] = shapes[s][a] == 1 ? 1 + (size_t)round
                                              : 1 + random_below(&of.r, 2 * (uint32_t)shapes[s][a]);
            if (shapes[s][0] >= 31)
                points[0] = 1 + points[0] % 40;
            check_grid(&of, points);
        }
        end_case(&of);
    }
    print_message("grid: largest error %.2g of the norm\n", worst);
}

/* On the samples' own grid: the inverse transform. */
static void test_grid_of_samples(void **state)
{
    (void)state;
    for (size_t s = 0; s < SHAPES; s++)
        for (size_t t = 0; t < 3; t++) {
            attempt of = start_case(s, t, 9000 + 3 * s + t);
            const size_t count = shapes[s][0] * shapes[s][1] * shapes[s][2];
            float *out = malloc(count * sizeof *out);
            cvol_array_evaluate_grid(context, out, of.array, shapes[s]);
            assert_int_equal(
                cvol_whole_inverse(context, transforms[t], of.slots, of.slots, shapes[s]), CVOL_OK);
            for (size_t i = 0; i < count; i++)
                assert_true(fabs((double)out[i] - (double)of.slots[i]) < TOLERANCE * of.norm);
            free(out);
            end_case(&of);
        }
}

/* ---- chirp points --------------------------------------------------------------------------- */

static void test_chirp(void **state)
{
    (void)state;
    worst = 0;
    EACH_CASE(seed, s, t)
    {
        attempt of = start_case(s, t, 50000 + 100 * seed + 3 * s + t);
        double start[3], step[3];
        size_t count[3];
        for (int a = 0; a < 3; a++) {
            start[a] = 1.5 * (double)shapes[s][a] * random_signed(&of.r);
            step[a] = 2 * random_signed(&of.r);
            count[a] = 1 + random_below(&of.r, a ? 5 : 9);
        }
        const size_t total = count[0] * count[1] * count[2];
        float *out = malloc(total * sizeof *out), *again = malloc(total * sizeof *out);
        cvol_context_set_threads(context, 1);
        assert_int_equal(cvol_array_evaluate_chirp(context, out, of.array, start, step, count),
                         CVOL_OK);
        for (size_t i = 0; i < total; i++) {
            const double x[3] = {start[0] + step[0] * (double)(i % count[0]),
                                 start[1] + step[1] * (double)(i / count[0] % count[1]),
                                 start[2] + step[2] * (double)(i / count[0] / count[1])};
            check_value(&of, "chirp", out[i], x);
        }
        cvol_context_set_threads(context, 3);
        assert_int_equal(cvol_array_evaluate_chirp(context, again, of.array, start, step, count),
                         CVOL_OK);
        assert_memory_equal(out, again, total * sizeof *out);
        free(out);
        free(again);
        end_case(&of);
    }
    cvol_context_set_threads(context, 0);
    print_message("chirp: largest error %.2g of the norm\n", worst);
}

/* ---- scattered points ------------------------------------------------------------------------ */

static void test_points(void **state)
{
    (void)state;
    worst = 0;
    EACH_CASE(seed, s, t)
    {
        attempt of = start_case(s, t, 70000 + 100 * seed + 3 * s + t);
        const size_t rank = (size_t)of.array->rank, count = 25;
        double points[75];
        float out[25];
        for (size_t i = 0; i < rank * count; i++)
            points[i] = 2 * (double)shapes[s][i % rank] * random_signed(&of.r);
        assert_int_equal(cvol_array_evaluate_points(context, out, of.array, points, count),
                         CVOL_OK);
        for (size_t i = 0; i < count; i++) {
            double x[3] = {0};
            memcpy(x, points + rank * i, rank * sizeof *x);
            check_value(&of, "points", out[i], x);
        }
        end_case(&of);
    }
    print_message("points: largest error %.2g of the norm\n", worst);
}

/* One block of random terms; the coordinates are the block's own. */
static void test_points_of_blocks(void **state)
{
    (void)state;
    static const size_t sizes[][3] = {{21, 1, 1}, {16, 10, 1}, {9, 17, 12}};
    for (uint64_t seed = 1; seed <= 3; seed++)
        for (int rank = 1; rank <= 3; rank++)
            for (size_t t = 0; t < 3; t++) {
                const size_t *n = sizes[rank - 1], B = 8;
                const cvol_grid grid = cvol_grid_make(n[0], n[1], n[2], CVOL_FLOAT32);
                random_state r = {.state = 31 * seed + 3 * (uint64_t)rank + t};
                const size_t dims[3] = {B, rank > 1 ? B : 1, rank > 2 ? B : 1};
                const size_t terms = dims[0] * dims[1] * dims[2];
                cvol_array *array;
                assert_int_equal(
                    cvol_array_create_as(context, &array, &grid, rank, transforms[t], (int)B),
                    CVOL_OK);
                array->step = 0.25;
                array->offset = 3;
                float slots[512] = {0};
                uint32_t *words = malloc(terms * 2 * sizeof *words), used = 0;
                double norm = 1;
                for (uint32_t p = 0; p < terms; p++)
                    if (random_below(&r, 3) == 0) {
                        const int32_t value = (int32_t)random_below(&r, 2000) - 1000;
                        if (value)
                            used += cvol_term_pack(words + used, p, value,
                                                   cvol_place_bits(array->block_log2));
                        slots[p] = (float)value * 0.25F;
                        norm += fabs((double)slots[p]);
                    }
                assert_int_equal(cvol_array_adopt_pool(context, array, words, used), CVOL_OK);
                const size_t block = random_below(&r, (uint32_t)array->block_count);
                array->block_table[block].terms = words;
                array->block_table[block].words = used;
                for (int i = 0; i < 40; i++) {
                    double x[3] = {0}, local[3] = {0};
                    size_t index = 0, stride = 1;
                    float out;
                    for (int a = 0; a < rank; a++) {
                        x[a] = ((double)n[a] + 2) * fabs(random_signed(&r)) - 1;
                        const double nearest = fmin(fmax(floor(x[a] + 0.5), 0), (double)(n[a] - 1));
                        const size_t of = (size_t)nearest / B;
                        local[a] = x[a] - (double)(of * B);
                        index += stride * of;
                        stride *= array->blocks[a];
                    }
                    assert_int_equal(cvol_array_evaluate_points(context, &out, array, x, 1),
                                     CVOL_OK);
                    const double truth = index == block
                                             ? direct_sum(slots, transforms[t], dims, local)
                                             : 0;
                    assert_true(fabs((double)out - truth - 3) < TOLERANCE * norm);
                }
                cvol_array_free(array);
            }
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void test_refusals(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(16, 16, 16, CVOL_FLOAT32);
    const size_t none[3] = {4, 0, 4}, some[3] = {4, 4, 4};
    const double start[3] = {0, 0, 0}, step[3] = {1, NAN, 1}, fine[3] = {1, 1, 1};
    float out[64];
    cvol_array *whole, *blocks;
    assert_int_equal(cvol_array_create_as(context, &whole, &grid, 3, CVOL_DHT, 0), CVOL_OK);
    assert_int_equal(cvol_array_create_as(context, &blocks, &grid, 3, CVOL_DCT, 8), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_grid(context, out, whole, none), CVOL_ERROR_ARGUMENT);
    const size_t many[3] = {(size_t)1 << (sizeof(size_t) * 8 - 2), 1, 1},
                 more[3] = {SIZE_MAX, 2, 2};
    assert_int_equal(cvol_array_evaluate_grid(context, out, whole, many), CVOL_ERROR_LIMIT);
    assert_int_equal(cvol_array_evaluate_grid(context, out, whole, more), CVOL_ERROR_LIMIT);
    assert_int_equal(cvol_array_evaluate_grid(context, out, blocks, some), CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(cvol_array_evaluate_chirp(context, out, whole, start, fine, none),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_evaluate_chirp(context, out, whole, start, step, some),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_evaluate_chirp(context, out, blocks, start, fine, some),
                     CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(cvol_array_evaluate_points(context, out, whole, step, 1), CVOL_ERROR_ARGUMENT);
    /* no terms at all: zero everywhere */
    assert_int_equal(cvol_array_evaluate_chirp(context, out, whole, start, fine, some), CVOL_OK);
    for (int i = 0; i < 64; i++)
        assert_true(out[i] == 0);
    cvol_array_free(whole);
    cvol_array_free(blocks);
}

static int stop(void *user, const char *what, double fraction)
{
    (void)user;
    (void)what;
    (void)fraction;
    return 1;
}

static void test_cancel(void **state)
{
    (void)state;
    attempt of = start_case(8, 1, 5);
    const size_t some[3] = {4, 4, 4};
    const double start[3] = {0, 0, 0}, step[3] = {1, 1, 1};
    float out[64];
    cvol_context_set_progress(context, stop, NULL);
    assert_int_equal(cvol_array_evaluate_grid(context, out, of.array, some), CVOL_ERROR_CANCELLED);
    assert_int_equal(cvol_array_evaluate_chirp(context, out, of.array, start, step, some),
                     CVOL_ERROR_CANCELLED);
    assert_int_equal(cvol_array_evaluate_points(context, out, of.array, start, 1),
                     CVOL_ERROR_CANCELLED);
    cvol_context_set_progress(context, NULL, NULL);
    end_case(&of);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_grid),
        cmocka_unit_test(test_grid_of_samples),
        cmocka_unit_test(test_chirp),
        cmocka_unit_test(test_points),
        cmocka_unit_test(test_points_of_blocks),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancel),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
