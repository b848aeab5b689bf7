/* The builder: the terms of blocks that every rule keeps, against exact truncation, for every rank,
 * transform and block size; the reported dropped energy; the same bits for any number of
 * threads. */
#include "test.h"

#include <float.h>

#include "array/block/block_transform.h"
#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "array/truncate/account.h"
#include "array/truncate/build.h"
#include "array/truncate/compress_array.h"
#include "array/truncate/producer.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "transform/whole.h"

#define CHECK(condition, seed)                                                             \
    do {                                                                                   \
        if (!(condition)) {                                                                \
            print_error("seed %u, line %d: %s\n", (unsigned)(seed), __LINE__, #condition); \
            fail();                                                                        \
        }                                                                                  \
    } while (0)

typedef struct sample_case {
    int rank, block;
    cvol_transform transform;
    cvol_grid grid;
    float *samples;
    size_t terms;  /* of all blocks */
    double *slots; /* exact coefficients */
    size_t padded[3];
} sample_case;

static cvol_keep keep_of(cvol_keep_rule rule, double value)
{
    return (cvol_keep){.rule = rule, .value = value};
}

static void make_case(sample_case *c, unsigned seed, int largest_block)
{
    random_state r = {.state = seed};
    memset(c, 0, sizeof *c);
    c->rank = 1 + (int)random_below(&r, 3);
    c->transform = (cvol_transform)(1 + random_below(&r, 3));
    c->block = 8 << random_below(&r, 3);
    if (c->block > largest_block)
        c->block = largest_block;
    const uint32_t most = c->rank == 1 ? 300 : c->rank == 2 ? 50 : 20;
    size_t dims[3] = {1, 1, 1};
    for (int a = 0; a < c->rank; a++)
        dims[a] = 1 + random_below(&r, most);
    c->grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&c->grid);
    c->samples = malloc(count * sizeof *c->samples);
    const double f = 0.3 * random_signed(&r), g = 0.2 * random_signed(&r);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0]);
        c->samples[i] = (float)(50 + 40 * sin(f * x + 1) * cos(g * y) + 5 * random_signed(&r));
    }
}

/* The coefficients of block `index`, in double precision. */
static void exact_block(double *slots, const cvol_array *shape, const float *samples, size_t index)
{
    const size_t count = cvol_array_block_terms(shape);
    float *gathered = malloc(count * sizeof *gathered);
    double *in = malloc(count * sizeof *in);
    const size_t dims[3] = {cvol_block_side(shape, 0), cvol_block_side(shape, 1),
                            cvol_block_side(shape, 2)};
    cvol_array_gather(gathered, samples, shape, index);
    for (size_t i = 0; i < count; i++)
        in[i] = (double)gathered[i];
    if (count <= 1024) {
        cvol_whole_forward_reference(shape->transform, slots, in, dims);
    } else {
        float *fast = malloc((count + 16) * sizeof *fast + 64);
        float *aligned = (float *)(((uintptr_t)fast + 63) & ~(uintptr_t)63);
        cvol_block_to_slots(aligned, gathered, shape);
        for (size_t i = 0; i < count; i++)
            slots[i] = (double)aligned[i];
        free(fast);
    }
    free(gathered);
    free(in);
}

static cvol_array *make_shape(const sample_case *c)
{
    cvol_array *array;
    assert_int_equal(
        cvol_array_create_as(context, &array, &c->grid, c->rank, c->transform, c->block), CVOL_OK);
    return array;
}

static int scan_and_compress(cvol_array *array, cvol_build_result *result, const void *samples,
                             const cvol_keep *keep)
{
    cvol_error_bound *error_bound = &array->error_bound;
    int code = cvol_scan_samples(context, &error_bound->value_min, &error_bound->value_max, samples,
                                 &array->grid);
    error_bound->max_abs = cvol_error_bound_largest(error_bound);
    return code ? code : cvol_blocks_compress(context, array, result, samples, keep);
}

static cvol_array *compress(const sample_case *c, cvol_build_result *result, const cvol_keep *keep)
{
    cvol_array *array = make_shape(c);
    const int code = scan_and_compress(array, result, c->samples, keep);
    if (code)
        print_error("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    return array;
}

static void fill_exact(sample_case *c)
{
    cvol_array *shape = make_shape(c);
    const size_t per_block = cvol_array_block_terms(shape);
    c->terms = per_block * shape->block_count;
    c->slots = malloc(c->terms * sizeof *c->slots);
    for (size_t i = 0; i < shape->block_count; i++)
        exact_block(c->slots + i * per_block, shape, c->samples, i);
    cvol_array_free(shape);
}

static void free_case(sample_case *c)
{
    free(c->samples);
    free(c->slots);
}

static double largest_of(const float *v, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs((double)v[i]));
    return most;
}

/* Norm of (samples - evaluated) within the array. */
static double measured_error(const sample_case *c, const cvol_array *array)
{
    const size_t count = cvol_grid_samples(&c->grid), zero[3] = {0, 0, 0};
    float *out = malloc(count * sizeof *out);
    assert_int_equal(cvol_blocks_evaluate(context, out, array, zero, c->grid.dims), CVOL_OK);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += pow((double)out[i] - (double)c->samples[i], 2);
    free(out);
    return sqrt(sum);
}

/* Energy of exact - kept over all blocks' coefficients. */
static double coefficient_error(const sample_case *c, const cvol_array *array)
{
    const size_t per_block = cvol_array_block_terms(array);
    float *slots = malloc(per_block * sizeof *slots);
    double sum = 0;
    for (size_t b = 0; b < array->block_count; b++) {
        cvol_block_unpack(slots, array, b);
        for (size_t i = 0; i < per_block; i++)
            sum += pow((double)slots[i] - c->slots[b * per_block + i], 2);
    }
    free(slots);
    return sqrt(sum);
}

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x > y ? -1 : x < y;
}

/* Keys of all terms in falling order; under DFT the pair's. */
static double *sorted_keys(const sample_case *c)
{
    double *keys = malloc(c->terms * sizeof *keys);
    const size_t B = (size_t)c->block, side[3] = {B, c->rank > 1 ? B : 1, c->rank > 2 ? B : 1};
    const size_t per_block = side[0] * side[1] * side[2];
    for (size_t i = 0; i < c->terms; i++) {
        keys[i] = fabs(c->slots[i]);
        if (c->transform != CVOL_DFT)
            continue;
        const size_t p = i % per_block, x = p % B, y = p / B % B, z = p / B / B;
        const size_t m = cvol_mirror_index(x, side[0]) +
                         B * (cvol_mirror_index(y, side[1]) + B * cvol_mirror_index(z, side[2]));
        keys[i] = sqrt((pow(c->slots[i], 2) + pow(c->slots[i - p + m], 2)) / 2);
    }
    qsort(keys, c->terms, sizeof *keys, falling);
    return keys;
}

static double norm_of(const double *keys, size_t from, size_t to)
{
    double sum = 0;
    for (size_t i = from; i < to; i++)
        sum += keys[i] * keys[i];
    return sqrt(sum);
}

/* The transform of a block and its inverse, of every kind, against the direct sums. */
static void test_block_transforms(void **state)
{
    (void)state;
    static float in[32768] __attribute__((aligned(64))), out[32768] __attribute__((aligned(64)));
    static double exact[4096], reals[4096];
    for (int rank = 1; rank <= 3; rank++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
            for (int block = 8; block <= 32; block *= 2) {
                random_state r = {.state = (unsigned)(rank + 10 * t + 100 * block)};
                cvol_array shape = {.rank = rank,
                                    .transform = (cvol_transform)t,
                                    .block = block,
                                    .block_log2 = block == 8    ? 3
                                                  : block == 16 ? 4
                                                                : 5};
                const size_t count = cvol_array_block_terms(&shape);
                const size_t dims[3] = {cvol_block_side(&shape, 0), cvol_block_side(&shape, 1),
                                        cvol_block_side(&shape, 2)};
                for (size_t i = 0; i < count; i++)
                    in[i] = (float)random_signed(&r);
                cvol_block_to_slots(out, in, &shape);
                if (count <= 4096) {
                    for (size_t i = 0; i < count; i++)
                        reals[i] = (double)in[i];
                    cvol_whole_forward_reference(shape.transform, exact, reals, dims);
                    for (size_t i = 0; i < count; i++)
                        assert_true(fabs((double)out[i] - exact[i]) < 5e-6);
                }
                static float back[32768] __attribute__((aligned(64)));
                memcpy(back, out, count * sizeof *back);
                cvol_block_from_slots(back, &shape);
                for (size_t i = 0; i < count; i++)
                    assert_true(fabsf(back[i] - in[i]) < 5e-6f);
            }
}

static void test_all_and_transforms(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 60; seed += SUPPORT_STRIDE) {
        sample_case c;
        make_case(&c, seed, 32);
        fill_exact(&c);
        cvol_keep keep = keep_of(CVOL_KEEP_ALL, 0);
        cvol_build_result result;
        cvol_array *array = compress(&c, &result, &keep);
        const double norm = norm_of(c.slots, 0, c.terms);
        CHECK(fabs(result.norm / norm - 1) < 1e-6, seed);
        CHECK(coefficient_error(&c, array) < 5e-6 * norm, seed);
        CHECK(measured_error(&c, array) <= result.dropped + 1e-6 * norm, seed);
        CHECK(fabs(result.max_abs - largest_of(c.samples, cvol_grid_samples(&c.grid))) < 1e-3,
              seed);
        cvol_array_free(array);
        free_case(&c);
    }
}

static void test_rules(void **state)
{
    (void)state;
    for (unsigned seed = 100; seed < 180; seed += SUPPORT_STRIDE) {
        sample_case c;
        make_case(&c, seed, seed % 4 ? 16 : 32);
        fill_exact(&c);
        double *keys = sorted_keys(&c);
        random_state r = {.state = seed};
        const double norm = norm_of(keys, 0, c.terms);
        const double samples = (double)cvol_grid_samples(&c.grid);
        cvol_build_result result;
        for (int rule = CVOL_KEEP_TERMS; rule <= CVOL_KEEP_STEP; rule++) {
            const size_t some = 1 + random_below(&r, (uint32_t)(c.terms / 3 + 1));
            cvol_keep keep = {.rule = (cvol_keep_rule)rule};
            size_t expected = some;
            double share = 0.02 + 0.1 * fabs(random_signed(&r));
            if (rule == CVOL_KEEP_TERMS)
                keep.sparse = some;
            else if (rule == CVOL_KEEP_RHO) {
                keep.value = (double)some / samples;
                expected = (size_t)floor(keep.value * samples);
            } else if (rule == CVOL_KEEP_RATIO) {
                keep.value = 4 * samples / (2000 + 200 * samples / 8 + 4 * (double)some);
            } else if (rule == CVOL_KEEP_L2)
                keep.value = share * norm;
            else if (rule == CVOL_KEEP_PSNR)
                keep.value = 20 + 20 * fabs(random_signed(&r));
            else if (rule == CVOL_KEEP_THRESHOLD)
                keep.value = keys[some] * 1.0001 + 1e-6;
            else
                keep.value = 0.5 + keys[some];
            if (rule == CVOL_KEEP_PSNR && samples < 20)
                continue;
            cvol_array *array = compress(&c, &result, &keep);
            const double slack = 3e-6 * norm;
            CHECK(fabs(coefficient_error(&c, array) - result.dropped) <= slack, seed);
            CHECK(measured_error(&c, array) <= result.dropped + slack, seed);
            cvol_array_info info;
            cvol_array_get_info(&info, array);
            if (rule == CVOL_KEEP_TERMS || rule == CVOL_KEEP_RHO) {
                CHECK(info.coefficients <= expected, seed);
                const size_t pair = c.transform == CVOL_DFT;
                CHECK(result.dropped <= norm_of(keys, expected - pair, c.terms) + slack, seed);
                /* halves of pairs that are zero cost nothing and leave room for others */
                CHECK(pair || result.dropped >= norm_of(keys, expected, c.terms) - slack, seed);
            }
            if (rule == CVOL_KEEP_RATIO)
                CHECK(4 * samples / (double)info.resident_bytes >= keep.value, seed);
            if (rule == CVOL_KEEP_L2 || rule == CVOL_KEEP_PSNR) {
                double allowed = keep.value;
                if (rule == CVOL_KEEP_PSNR)
                    allowed = (array->error_bound.value_max - array->error_bound.value_min) *
                              sqrt(samples) * pow(10, -keep.value / 20);
                CHECK(result.dropped <= allowed * (1 + 1e-9), seed);
                /* One term fewer would exceed the loss: two for a pair, and rounding. */
                size_t kept = (size_t)info.coefficients;
                kept = kept > 3 ? kept - 3 : 0;
                CHECK(norm_of(keys, kept, c.terms) >= allowed - slack - allowed * 1e-3, seed);
            }
            if (rule == CVOL_KEEP_THRESHOLD && keep.value > 1e-3)
                for (size_t i = 0; i < c.terms; i++)
                    if (fabs(keys[i] - keep.value) > 1e-4) {
                        /* keys fall: the kept are the first */
                        CHECK((keys[i] >= keep.value) == (i < info.coefficients) ||
                                  c.transform == CVOL_DFT,
                              seed);
                    }
            cvol_array_free(array);
        }
        free(keys);
        free_case(&c);
    }
}

/* The low box is kept for any threshold. */
static void test_low_box(void **state)
{
    (void)state;
    for (unsigned seed = 300; seed < 330; seed += SUPPORT_STRIDE) {
        sample_case c;
        make_case(&c, seed, 16);
        cvol_keep keep = {.rule = CVOL_KEEP_TERMS, .low = {2, 2, 2}};
        cvol_build_result result;
        cvol_array *array = compress(&c, &result, &keep);
        fill_exact(&c);
        const size_t per_block = cvol_array_block_terms(array), B = (size_t)c.block;
        float *slots = malloc(per_block * sizeof *slots);
        for (size_t b = 0; b < array->block_count; b++) {
            cvol_block_unpack(slots, array, b);
            for (size_t p = 0; p < per_block; p++) {
                int inside = 1;
                for (int a = 0; a < c.rank; a++) {
                    size_t u = p >> a * array->block_log2 & (B - 1);
                    inside = inside && (c.transform == CVOL_DCT ? u : cvol_frequency(u, B)) < 2;
                }
                const double expected = inside ? c.slots[b * per_block + p] : 0;
                CHECK(fabs((double)slots[p] - expected) < 1e-2, seed);
            }
        }
        free(slots);
        cvol_array_free(array);
        free_case(&c);
    }
}

/* Values on the grid of a step are reproduced exactly, and many equal magnitudes are cut at the
 * exact term. */
typedef struct on_grid {
    const cvol_array *shape;
    double step;
} on_grid;

static int produce_on_grid(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    (void)scratch;
    const on_grid *g = user;
    random_state r = {.state = index};
    for (size_t i = 0; i < cvol_array_block_terms(g->shape); i++) {
        int value = (int)random_below(&r, 9) - 4;
        if (random_below(&r, 30) == 0)
            value *= 200000;
        block->coefficients[i] = (float)(g->step * value);
    }
    return CVOL_OK;
}

static void test_step_grid_and_ties(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(40, 40, 20, CVOL_FLOAT32);
    cvol_array *first, *again;
    cvol_build_result result;
    assert_int_equal(cvol_array_create_as(context, &first, &grid, 3, CVOL_DCT, 16), CVOL_OK);
    assert_int_equal(cvol_array_create_as(context, &again, &grid, 3, CVOL_DCT, 16), CVOL_OK);
    on_grid g = {.shape = first, .step = 0.3};
    cvol_producer producer = {.produce = produce_on_grid, .user = &g, .what = "testing"};
    cvol_keep keep = keep_of(CVOL_KEEP_STEP, 0.3);
    assert_int_equal(cvol_build_blocks(context, first, &result, &producer, &keep), CVOL_OK);
    assert_true(result.dropped <= 1e-6 * result.norm);
    float slots[4096], expected[4096];
    for (size_t b = 0; b < first->block_count; b++) {
        cvol_dense_block block = {.coefficients = expected};
        produce_on_grid(&g, &block, b, NULL);
        cvol_block_unpack(slots, first, b);
        for (int i = 0; i < 4096; i++)
            assert_true(fabsf(slots[i] - expected[i]) <= 1e-6f * fabsf(expected[i]));
    }
    keep = (cvol_keep){.rule = CVOL_KEEP_TERMS, .sparse = 1001};
    again->error_bound.max_abs = 10000;
    assert_int_equal(cvol_build_blocks(context, again, &result, &producer, &keep), CVOL_OK);
    assert_int_equal(again->coefficients, 1001);
    cvol_array_free(again);
    assert_int_equal(cvol_array_create_as(context, &again, &grid, 3, CVOL_DCT, 16), CVOL_OK);
    keep = keep_of(CVOL_KEEP_STEP, 1e-7);
    assert_int_equal(cvol_build_blocks(context, again, &result, &producer, &keep), CVOL_ERROR_DATA);
    cvol_array_free(again);
    cvol_array_free(first);
}

static int same(const cvol_array *a, const cvol_array *b)
{
    if (a->coefficients != b->coefficients || a->step != b->step || a->threshold != b->threshold ||
        a->pool_words != b->pool_words)
        return 0;
    for (size_t i = 0; i < a->block_count; i++) {
        const cvol_block *x = &a->block_table[i], *y = &b->block_table[i];
        if (x->words != y->words || memcmp(x->low, y->low, 3) ||
            (x->words && memcmp(x->terms, y->terms, 4 * (size_t)x->words)))
            return 0;
    }
    return 1;
}

static void test_threads(void **state)
{
    (void)state;
    for (unsigned seed = 400; seed < 412; seed += SUPPORT_STRIDE) {
        sample_case c;
        make_case(&c, seed, 8);
        random_state r = {.state = seed};
        /* long enough for several runs */
        free(c.samples);
        c.grid = c.rank == 1   ? cvol_grid_make(500001, 1, 1, CVOL_FLOAT32)
                 : c.rank == 2 ? cvol_grid_make(701, 600, 1, CVOL_FLOAT32)
                               : cvol_grid_make(80, 70, 75, CVOL_FLOAT32);
        const size_t count = cvol_grid_samples(&c.grid);
        c.samples = malloc(count * sizeof *c.samples);
        for (size_t i = 0; i < count; i++)
            c.samples[i] = (float)random_signed(&r);
        cvol_keep keeps[] = {keep_of(CVOL_KEEP_RHO, 0.1), keep_of(CVOL_KEEP_L2, 100),
                             keep_of(CVOL_KEEP_STEP, 0.5), keep_of(CVOL_KEEP_RATIO, 4)};
        cvol_keep keep = keeps[seed % 4];
        cvol_build_result one, other;
        cvol_context_set_threads(context, 1);
        cvol_array *first = compress(&c, &one, &keep);
        for (int threads = 2; threads <= 3; threads++) {
            cvol_context_set_threads(context, threads);
            cvol_array *array = compress(&c, &other, &keep);
            CHECK(same(first, array), seed);
            CHECK(!memcmp(&one, &other, sizeof one), seed);
            cvol_array_free(array);
        }
        cvol_context_set_threads(context, 2);
        cvol_array_free(first);
        free_case(&c);
    }
}

static void test_refuses(void **state)
{
    (void)state;
    float samples[20] = {0};
    cvol_grid grid = cvol_grid_make(20, 1, 1, CVOL_FLOAT32);
    cvol_array *array;
    cvol_build_result result;
    cvol_keep keep = keep_of(CVOL_KEEP_ALL, 0);
    assert_int_equal(cvol_array_create_as(context, &array, &grid, 1, CVOL_DCT, 8), CVOL_OK);
    samples[7] = NAN;
    assert_int_equal(scan_and_compress(array, &result, samples, &keep), CVOL_ERROR_DATA);
    samples[7] = INFINITY;
    assert_int_equal(scan_and_compress(array, &result, samples, &keep), CVOL_ERROR_DATA);
    samples[7] = 3;
    keep = keep_of(CVOL_KEEP_RATIO, 100);
    assert_int_equal(scan_and_compress(array, &result, samples, &keep), CVOL_ERROR_TARGET);
    keep = keep_of(CVOL_KEEP_L2, 1e-12);
    assert_int_equal(scan_and_compress(array, &result, samples, &keep), CVOL_ERROR_TARGET);
    cvol_array_free(array);
    /* nothing but zeros */
    samples[7] = 0;
    for (int rule = CVOL_KEEP_ALL; rule <= CVOL_KEEP_STEP; rule++) {
        keep = (cvol_keep){.rule = (cvol_keep_rule)rule, .value = 0.01, .sparse = 4};
        if (rule == CVOL_KEEP_PSNR)
            continue;
        assert_int_equal(cvol_array_create_as(context, &array, &grid, 1, CVOL_DFT, 8), CVOL_OK);
        assert_int_equal(scan_and_compress(array, &result, samples, &keep), CVOL_OK);
        assert_int_equal(array->coefficients, 0);
        assert_true(result.dropped == 0);
        cvol_array_free(array);
    }
}

/* Steps that single precision cannot represent would lose energy that is not counted. */
static void test_tiny_values(void **state)
{
    (void)state;
    enum { N = 64 };
    const size_t begin[3] = {0, 0, 0}, end[3] = {N, 1, 1};
    const cvol_keep all = cvol_keep_all();
    for (int exponent = -30; exponent >= -37; exponent--) {
        random_state r = {.state = (uint64_t)-exponent};
        const cvol_grid grid = cvol_grid_make(N, 1, 1, CVOL_FLOAT32);
        float samples[N], found[N];
        for (int i = 0; i < N; i++)
            samples[i] = (float)(random_signed(&r) * pow(10, exponent));
        cvol_array *array;
        assert_int_equal(
            cvol_array_compress(context, &array, samples, &grid, 1, CVOL_DCT, 16, &all), CVOL_OK);
        assert_int_equal(cvol_array_evaluate_real(context, found, array, begin, end), CVOL_OK);
        double squares = 0;
        for (int i = 0; i < N; i++)
            squares += pow((double)samples[i] - (double)found[i], 2);
        CHECK(sqrt(squares) <= array->error_bound.l2_error, -exponent);
        /* The same for values about 1, scaled down, so that the step is even smaller. */
        float about_one[N];
        cvol_array *large, *small;
        for (int i = 0; i < N; i++)
            about_one[i] = (float)((double)samples[i] * pow(10, -exponent));
        assert_int_equal(
            cvol_array_compress(context, &large, about_one, &grid, 1, CVOL_DCT, 16, &all), CVOL_OK);
        assert_int_equal(cvol_array_scale(context, &small, pow(10, exponent), large, 0), CVOL_OK);
        assert_int_equal(cvol_array_evaluate_real(context, found, small, begin, end), CVOL_OK);
        squares = 0;
        for (int i = 0; i < N; i++)
            squares += pow((double)samples[i] - (double)found[i], 2);
        CHECK(sqrt(squares) <= small->error_bound.l2_error, -exponent);
        /* Twice half of the smallest step, for each of N terms, and rounding. */
        CHECK(small->error_bound.l2_error <
                  1.1 * sqrt((double)N) * (double)FLT_MIN + 1e-4 * pow(10, exponent),
              -exponent);
        cvol_array_free(large);
        cvol_array_free(small);
        cvol_array_free(array);
    }
}

/* A PSNR of constant samples has a range of 0: all terms are kept. */
static void test_constant_samples(void **state)
{
    (void)state;
    enum { NX = 40, NY = 24 };
    const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};
    const cvol_keep keep = cvol_keep_psnr(40);
    float samples[NX * NY], found[NX * NY];
    for (int c = 0; c < 12; c++) {
        const int rank = 1 + c % 2;
        const float value = c % 4 < 2 ? 7 : -0.1F;
        const size_t begin[3] = {0, 0, 0}, end[3] = {NX, rank == 1 ? 1 : NY, 1};
        const cvol_grid grid = cvol_grid_make(end[0], end[1], 1, CVOL_FLOAT32);
        for (int i = 0; i < NX * NY; i++)
            samples[i] = value;
        cvol_array *array;
        assert_int_equal(cvol_array_compress(context, &array, samples, &grid, rank,
                                             transforms[c / 4], 16, &keep),
                         CVOL_OK);
        assert_int_equal(cvol_array_evaluate_real(context, found, array, begin, end), CVOL_OK);
        for (size_t i = 0; i < end[0] * end[1]; i++)
            CHECK(fabsf(found[i] - value) <= 1e-5F * fabsf(value), c);
        cvol_array_free(array);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_block_transforms),
        cmocka_unit_test(test_all_and_transforms),
        cmocka_unit_test(test_rules),
        cmocka_unit_test(test_low_box),
        cmocka_unit_test(test_step_grid_and_ties),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_refuses),
        cmocka_unit_test(test_tiny_values),
        cmocka_unit_test(test_constant_samples),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
