/* Operations on arrays in blocks against the same on dense samples: every rank, transform and size
 * of block, arrays smaller than a block and no multiple of it; measured errors within the reported
 * bounds; the same bits for any number of threads. */
#include "test.h"

#include "array/algebra/operations.h"
#include "array/block/block_transform.h"
#include "array/convolve/convolve.h"
#include "array/convolve/kernel.h"
#include "array/evaluate/box.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "random.h"
#include "support_context.h"

enum { CASES = 60 };

#define CHECK(condition, seed)                                                             \
    do {                                                                                   \
        if (!(condition)) {                                                                \
            print_error("seed %u, line %d: %s\n", (unsigned)(seed), __LINE__, #condition); \
            fail();                                                                        \
        }                                                                                  \
    } while (0)

typedef struct dense {
    size_t dims[3], count;
    double *v;
} dense;

static dense dense_make(const size_t dims[3])
{
    dense d = {.count = dims[0] * dims[1] * dims[2]};
    memcpy(d.dims, dims, sizeof d.dims);
    d.v = calloc(d.count, sizeof *d.v);
    return d;
}

/* The decoded samples of an array. */
static dense dense_of(const cvol_array *array)
{
    static const size_t zero[3] = {0, 0, 0};
    dense d = dense_make(array->grid.dims);
    float *out = malloc(d.count * sizeof *out);
    assert_int_equal(cvol_blocks_evaluate(context, out, array, zero, d.dims), CVOL_OK);
    for (size_t i = 0; i < d.count; i++)
        d.v[i] = (double)out[i];
    free(out);
    return d;
}

static double norm_of(const dense *d)
{
    double sum = 0;
    for (size_t i = 0; i < d->count; i++)
        sum += d->v[i] * d->v[i];
    return sqrt(sum);
}

static double distance(const dense *a, const dense *b)
{
    double sum = 0;
    for (size_t i = 0; i < a->count; i++)
        sum += pow(a->v[i] - b->v[i], 2);
    return sqrt(sum);
}

/* The sample at (x, y, z), mirrored beyond the ends. */
static double at(const dense *d, long x, long y, long z)
{
    long p[3] = {x, y, z};
    for (int a = 0; a < 3; a++) {
        const long n = (long)d->dims[a];
        while (p[a] < 0 || p[a] >= n)
            p[a] = p[a] < 0 ? -1 - p[a] : 2 * n - 1 - p[a];
    }
    return d->v[(size_t)p[0] + d->dims[0] * ((size_t)p[1] + d->dims[1] * (size_t)p[2])];
}

#define EACH(d, x, y, z)                              \
    for (long z = 0; z < (long)(d)->dims[2]; z++)     \
        for (long y = 0; y < (long)(d)->dims[1]; y++) \
            for (long x = 0; x < (long)(d)->dims[0]; x++)

typedef struct pair {
    cvol_array *a, *b;
    dense da, db; /* their decoded samples */
    int rank;
} pair;

static cvol_array *random_array(random_state *r, const cvol_grid *grid, int rank,
                                cvol_transform transform, int block, cvol_keep keep)
{
    const size_t count = cvol_grid_samples(grid);
    float *samples = malloc(count * sizeof *samples);
    const double f = 0.4 * random_signed(r), g = 0.3 * random_signed(r);
    const double level = 20 * random_signed(r);
    for (size_t i = 0; i < count; i++)
        samples[i] = (float)(level +
                             10 * sin(f * (double)(i % grid->dims[0]) + 1) *
                                 cos(g * (double)(i / grid->dims[0])) +
                             random_signed(r));
    cvol_array *array;
    const int code = cvol_array_compress(context, &array, samples, grid, rank, transform, block,
                                         &keep);
    if (code)
        print_error("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    free(samples);
    return array;
}

static pair make_pair(unsigned seed)
{
    random_state r = {.state = seed};
    pair p = {.rank = 1 + (int)random_below(&r, 3)};
    const cvol_transform transform = (cvol_transform)(1 + random_below(&r, 3));
    const int block = 8 << random_below(&r, p.rank == 3 && seed % 5 ? 2 : 3);
    const uint32_t most = p.rank == 1 ? 200 : p.rank == 2 ? 45 : 22;
    size_t dims[3] = {1, 1, 1};
    for (int a = 0; a < p.rank; a++)
        dims[a] = 1 + random_below(&r, seed % 7 ? most : 3);
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const cvol_keep keeps[] = {cvol_keep_all(), cvol_keep_step(0.5), cvol_keep_threshold(0.4),
                               cvol_keep_l2(3)};
    p.a = random_array(&r, &grid, p.rank, transform, block, keeps[random_below(&r, 4)]);
    p.b = random_array(&r, &grid, p.rank, transform, block, keeps[random_below(&r, 4)]);
    p.a->offset = 5 * random_signed(&r);
    p.b->offset = seed % 2 ? 3 : 0;
    p.a->error_bound.max_abs += 5;
    p.b->error_bound.max_abs += 5;
    p.da = dense_of(p.a);
    p.db = dense_of(p.b);
    return p;
}

static void free_pair(pair *p)
{
    cvol_array_free(p->a);
    cvol_array_free(p->b);
    free(p->da.v);
    free(p->db.v);
}

static cvol_array *like(const cvol_array *a, const size_t dims[3])
{
    cvol_grid grid = a->grid;
    cvol_array *out;
    memcpy(grid.dims, dims, sizeof grid.dims);
    assert_int_equal(cvol_array_create_as(context, &out, &grid, a->rank, a->transform, a->block),
                     CVOL_OK);
    return out;
}

/* Compares `out` with the expected samples, within the dropped norm and rounding. */
static void check_result(const cvol_array *out, const cvol_build_result *result,
                         const dense *expected, double scale, unsigned seed)
{
    dense got = dense_of(out);
    const double slack = 1e-5 * (scale + norm_of(expected));
    CHECK(distance(&got, expected) <= result->dropped + slack, seed);
    free(got.v);
}

/* The rules for testing operations; `all` drops nothing significant. */
static const cvol_keep *some_keep(unsigned seed)
{
    static cvol_keep keeps[5];
    keeps[0] = cvol_keep_all();
    keeps[1] = cvol_keep_like_inputs();
    keeps[2] = cvol_keep_l2(1);
    keeps[3] = cvol_keep_threshold(0.3);
    keeps[4] = cvol_keep_terms(1, 20);
    return &keeps[seed % 5];
}

static void test_add(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= CASES; seed++) {
        pair p = make_pair(seed);
        random_state r = {.state = seed};
        const double alpha = 2 * random_signed(&r), beta = seed % 6 ? 3 * random_signed(&r) : 0;
        cvol_build_result result;
        cvol_array *out = like(p.a, p.a->grid.dims);
        assert_int_equal(
            cvol_blocks_add(context, out, &result, alpha, p.a, beta, p.b, some_keep(seed)),
            CVOL_OK);
        dense expected = dense_make(p.da.dims);
        for (size_t i = 0; i < expected.count; i++)
            expected.v[i] = alpha * p.da.v[i] + beta * p.db.v[i];
        check_result(out, &result, &expected, norm_of(&p.da) + norm_of(&p.db), seed);
        if (seed % 5 == 0)
            CHECK(result.dropped <= 1e-4 * result.norm, seed);
        cvol_array_free(out);
        free(expected.v);
        free_pair(&p);
    }
}

static void test_scale_and_truncate(void **state)
{
    (void)state;
    for (unsigned seed = 100; seed < 100 + CASES; seed++) {
        pair p = make_pair(seed);
        random_state r = {.state = seed};
        const double alpha = seed % 9 ? 3 * random_signed(&r) : 0, beta = 10 * random_signed(&r);
        cvol_build_result result;
        cvol_array *out = like(p.a, p.a->grid.dims);
        assert_int_equal(cvol_blocks_scale(context, out, &result, alpha, p.a, beta), CVOL_OK);
        CHECK(result.dropped == 0, seed);
        dense expected = dense_make(p.da.dims);
        for (size_t i = 0; i < expected.count; i++)
            expected.v[i] = alpha * p.da.v[i] + beta;
        check_result(out, &result, &expected, norm_of(&p.da), seed);
        CHECK(alpha == 0 || out->coefficients == p.a->coefficients, seed);
        cvol_array_free(out);

        out = like(p.a, p.a->grid.dims);
        assert_int_equal(cvol_blocks_truncate(context, out, &result, p.a, some_keep(seed)),
                         CVOL_OK);
        check_result(out, &result, &p.da, norm_of(&p.da), seed);
        CHECK(out->coefficients <= p.a->coefficients, seed);
        cvol_array_free(out);
        free(expected.v);
        free_pair(&p);
    }
}

static void test_sums(void **state)
{
    (void)state;
    for (unsigned seed = 200; seed < 200 + CASES; seed++) {
        pair p = make_pair(seed);
        double sum, squares, variation, inner, apart, s = 0, q = 0, i = 0, d = 0;
        assert_int_equal(cvol_blocks_sums(context, &sum, &squares, &variation, p.a), CVOL_OK);
        assert_int_equal(cvol_blocks_inner(context, &inner, p.a, p.b), CVOL_OK);
        for (size_t n = 0; n < p.da.count; n++) {
            s += p.da.v[n];
            q += p.da.v[n] * p.da.v[n];
            i += p.da.v[n] * p.db.v[n];
            d += (p.da.v[n] - p.db.v[n]) * (p.da.v[n] - p.db.v[n]);
        }
        const double na = norm_of(&p.da), nb = norm_of(&p.db);
        CHECK(fabs(sum - s) <= 1e-5 * (na * sqrt((double)p.da.count)), seed);
        CHECK(fabs(squares - q) <= 1e-5 * na * na, seed);
        CHECK(fabs(variation - (q - s * s / (double)p.da.count)) <= 1e-5 * na * na, seed);
        CHECK(fabs(inner - i) <= 1e-5 * na * nb, seed);
        assert_int_equal(cvol_blocks_inner(context, &inner, p.a, p.a), CVOL_OK);
        CHECK(fabs(inner - q) <= 1e-5 * na * na, seed);
        assert_int_equal(cvol_blocks_distance(context, &apart, p.a, p.b), CVOL_OK);
        CHECK(fabs(apart - d) <= 1e-5 * (na + nb) * (na + nb), seed);
        assert_int_equal(cvol_blocks_distance(context, &apart, p.a, p.a), CVOL_OK);
        CHECK(apart == 0, seed);
        /* Nearly the same: a step that is 1e-5 longer. */
        cvol_array near = *p.a;
        near.step *= 1 + 1e-5;
        assert_int_equal(cvol_blocks_distance(context, &apart, p.a, &near), CVOL_OK);
        const double moved = (double)(float)near.step / (double)(float)p.a->step - 1;
        const double without = q + p.a->offset * (p.a->offset * (double)p.da.count - 2 * s);
        CHECK(fabs(sqrt(apart) - moved * sqrt(fmax(0, without))) <= 0.03 * moved * na, seed);
        free_pair(&p);
    }
}

static void test_gradient(void **state)
{
    (void)state;
    for (unsigned seed = 300; seed < 300 + CASES; seed++) {
        pair p = make_pair(seed);
        const double weight[3] = {1, 0.5, 2};
        cvol_build_result result;
        cvol_array *out = like(p.a, p.a->grid.dims);
        assert_int_equal(cvol_blocks_gradient(context, out, &result, p.a, weight, some_keep(seed)),
                         CVOL_OK);
        dense expected = dense_make(p.da.dims);
        size_t n = 0;
        EACH(&expected, x, y, z)
        {
            const double dx = weight[0] * (at(&p.da, x + 1, y, z) - at(&p.da, x - 1, y, z)) / 2;
            const double dy = weight[1] * (at(&p.da, x, y + 1, z) - at(&p.da, x, y - 1, z)) / 2;
            const double dz = weight[2] * (at(&p.da, x, y, z + 1) - at(&p.da, x, y, z - 1)) / 2;
            expected.v[n++] = sqrt(dx * dx + dy * dy + dz * dz);
        }
        check_result(out, &result, &expected, norm_of(&p.da), seed);
        cvol_array_free(out);
        free(expected.v);
        free_pair(&p);
    }
}

static double half_of(const dense *d, const long x[3])
{
    double sum = 0;
    for (int c = 0; c < 8; c++)
        sum += at(d, 2 * x[0] + (d->dims[0] > 1 ? c & 1 : 0),
                  2 * x[1] + (d->dims[1] > 1 ? c >> 1 & 1 : 0),
                  2 * x[2] + (d->dims[2] > 1 ? c >> 2 : 0));
    return sum / 8;
}

static double twice_of(const dense *d, const long x[3], int rank)
{
    double sum = 0;
    for (int c = 0; c < 8; c++) {
        double w = 1;
        long q[3] = {x[0], x[1], x[2]};
        for (int a = 0; a < 3; a++) {
            const int far = c >> a & 1;
            if (a >= rank)
                w *= far ? 0 : 1;
            else {
                w *= far ? 0.25 : 0.75;
                q[a] = x[a] / 2 + (far ? x[a] % 2 ? 1 : -1 : 0);
            }
        }
        sum += w * at(d, q[0], q[1], q[2]);
    }
    return sum;
}

static void test_resample(void **state)
{
    (void)state;
    for (unsigned seed = 400; seed < 400 + CASES; seed++) {
        pair p = make_pair(seed);
        const int twice = seed % 2;
        size_t dims[3] = {1, 1, 1};
        for (int a = 0; a < p.rank; a++)
            dims[a] = twice ? 2 * p.da.dims[a] : (p.da.dims[a] + 1) / 2;
        cvol_build_result result;
        cvol_array *out = like(p.a, dims);
        assert_int_equal(cvol_blocks_resample(context, out, &result, p.a, some_keep(seed / 2)),
                         CVOL_OK);
        dense expected = dense_make(dims);
        size_t n = 0;
        EACH(&expected, x, y, z)
        {
            const long q[3] = {x, y, z};
            expected.v[n++] = twice ? twice_of(&p.da, q, p.rank) : half_of(&p.da, q);
        }
        check_result(out, &result, &expected, norm_of(&p.da), seed);
        cvol_array_free(out);
        free(expected.v);
        free_pair(&p);
    }
}

static cvol_kernel random_kernel(random_state *r, int rank, int most)
{
    cvol_kernel kernel = {.parts = 1 + (int)random_below(r, 3)};
    for (int t = 0; t < kernel.parts; t++) {
        kernel.weight[t] = random_signed(r);
        for (int a = 0; a < 3; a++) {
            cvol_kernel_line *line = &kernel.line[t][a];
            line->taps[0] = 1;
            if (a >= rank)
                continue;
            line->radius = (int)random_below(r, (uint32_t)most + 1);
            line->antisymmetric = line->radius > 0 && random_below(r, 3) == 0;
            line->taps[0] = line->antisymmetric ? 0 : random_signed(r);
            for (int i = 1; i <= line->radius; i++)
                line->taps[i] = random_signed(r) / i;
        }
    }
    return kernel;
}

static double tap(const cvol_kernel_line *line, int i)
{
    if (abs(i) > line->radius)
        return 0;
    return i < 0 && line->antisymmetric ? -line->taps[-i] : line->taps[abs(i)];
}

/* One axis after the other, in double precision. */
static dense filter_axis(const dense *in, const cvol_kernel_line *line, int axis)
{
    dense out = dense_make(in->dims);
    size_t n = 0;
    EACH(&out, x, y, z)
    {
        double sum = 0;
        for (int i = -line->radius; i <= line->radius; i++)
            sum += tap(line, i) * at(in, x - (axis == 0 ? i : 0), y - (axis == 1 ? i : 0),
                                     z - (axis == 2 ? i : 0));
        out.v[n++] = sum;
    }
    return out;
}

/* (h * a) by lines; mirrored beyond the ends, which along one axis does not depend on the
 * others. */
static dense filtered(const dense *in, const cvol_kernel *kernel)
{
    dense out = dense_make(in->dims);
    for (int t = 0; t < kernel->parts; t++) {
        dense x = filter_axis(in, &kernel->line[t][0], 0);
        dense y = filter_axis(&x, &kernel->line[t][1], 1);
        dense z = filter_axis(&y, &kernel->line[t][2], 2);
        for (size_t i = 0; i < out.count; i++)
            out.v[i] += kernel->weight[t] * z.v[i];
        free(x.v);
        free(y.v);
        free(z.v);
    }
    return out;
}

static void test_convolve(void **state)
{
    (void)state;
    for (unsigned seed = 500; seed < 500 + CASES; seed++) {
        pair p = make_pair(seed);
        random_state r = {.state = seed};
        const int farthest = p.a->block < CVOL_KERNEL_RADIUS ? p.a->block : CVOL_KERNEL_RADIUS;
        const cvol_kernel kernel = random_kernel(&r, p.rank, seed % 4 ? farthest / 4 : farthest);
        cvol_build_result result;
        cvol_array *out = like(p.a, p.a->grid.dims);
        assert_int_equal(
            cvol_blocks_convolve_kernel(context, out, &result, p.a, &kernel, some_keep(seed)),
            CVOL_OK);
        dense expected = filtered(&p.da, &kernel);
        double norm, sum;
        cvol_kernel_bounds(&kernel, &norm, &sum);
        check_result(out, &result, &expected, norm * norm_of(&p.da), seed);
        cvol_array_free(out);
        free(expected.v);
        free_pair(&p);
    }
}

/* Boxes agree with the whole. */
static void test_boxes(void **state)
{
    (void)state;
    for (unsigned seed = 600; seed < 600 + CASES; seed++) {
        pair p = make_pair(seed);
        random_state r = {.state = seed};
        size_t begin[3], end[3];
        for (int a = 0; a < 3; a++) {
            begin[a] = random_below(&r, (uint32_t)p.da.dims[a]);
            end[a] = begin[a] + 1 + random_below(&r, (uint32_t)(p.da.dims[a] - begin[a]));
        }
        const size_t size[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]};
        dense box = dense_make(size);
        float *out = malloc(box.count * sizeof *out);
        assert_int_equal(cvol_blocks_evaluate(context, out, p.a, begin, end), CVOL_OK);
        size_t n = 0;
        EACH(&box, x, y, z)
        {
            const double expected = at(&p.da, x + (long)begin[0], y + (long)begin[1],
                                       z + (long)begin[2]);
            CHECK((double)out[n++] == expected, seed);
        }
        free(out);
        free(box.v);
        free_pair(&p);
    }
}

static uint64_t bits_of(const cvol_array *array, const cvol_build_result *result)
{
    uint64_t hash = 1469598103934665603u;
    const uint64_t *words = (const uint64_t *)(const void *)result;
    for (size_t i = 0; i < sizeof *result / 8; i++)
        hash = (hash ^ words[i]) * 1099511628211u;
    for (size_t b = 0; b < array->block_count; b++)
        for (uint32_t i = 0; i < array->block_table[b].words; i++)
            hash = (hash ^ array->block_table[b].terms[i]) * 1099511628211u;
    return hash;
}

static void test_threads(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(75, 70, 66, CVOL_FLOAT32);
    random_state r = {.state = 9};
    cvol_array *a = random_array(&r, &grid, 3, CVOL_DCT, 8, cvol_keep_rho(0.1));
    cvol_array *b = random_array(&r, &grid, 3, CVOL_DCT, 8, cvol_keep_rho(0.05));
    const cvol_kernel kernel = random_kernel(&r, 3, 2);
    const double weight[3] = {1, 1, 1};
    uint64_t bits[4] = {0};
    double sums[3] = {0};
    for (int threads = 1; threads <= 3; threads++) {
        cvol_context_set_threads(context, threads);
        for (int op = 0; op < 4; op++) {
            size_t dims[3] = {75, 70, 66};
            for (int i = 0; i < 3 && op == 3; i++)
                dims[i] = (dims[i] + 1) / 2;
            cvol_array *out = like(a, dims);
            cvol_build_result result;
            const cvol_keep keep = op == 1 ? cvol_keep_rho(0.03) : cvol_keep_like_inputs();
            int code = op == 0   ? cvol_blocks_add(context, out, &result, 1, a, -2, b, &keep)
                       : op == 1 ? cvol_blocks_gradient(context, out, &result, a, weight, &keep)
                       : op == 2
                           ? cvol_blocks_convolve_kernel(context, out, &result, a, &kernel, &keep)
                           : cvol_blocks_resample(context, out, &result, a, &keep);
            assert_int_equal(code, CVOL_OK);
            const uint64_t now = bits_of(out, &result);
            assert_true(threads == 1 || now == bits[op]);
            bits[op] = now;
            cvol_array_free(out);
        }
        double now[3], variation;
        assert_int_equal(cvol_blocks_sums(context, &now[0], &now[1], &variation, a), CVOL_OK);
        assert_int_equal(cvol_blocks_inner(context, &now[2], a, b), CVOL_OK);
        assert_true(threads == 1 || !memcmp(now, sums, sizeof now));
        memcpy(sums, now, sizeof now);
    }
    cvol_context_set_threads(context, 2);
    cvol_array_free(a);
    cvol_array_free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_add),      cmocka_unit_test(test_scale_and_truncate),
        cmocka_unit_test(test_sums),     cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_resample), cmocka_unit_test(test_convolve),
        cmocka_unit_test(test_boxes),    cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
