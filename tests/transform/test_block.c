/* Block transforms: the basis, the fast kernels against the scalar reference, Parseval, pruning,
 * and the same bits from every instruction set. */
#include "test.h"

#include "array/block/block_inverse.h"
#include "array/core/array.h"
#include "base/cpu.h"
#include "base/memory.h"
#include "random.h"
#include "support_kernels.h"
#include "transform/block.h"

#define MAX_SAMPLES (32 * 32 * 32)

static float in[MAX_SAMPLES] __attribute__((aligned(64)));
static float fast[MAX_SAMPLES] __attribute__((aligned(64)));
static float slow[MAX_SAMPLES] __attribute__((aligned(64)));

static const int sides[] = {8, 16, 32};

static void fill_random(float *data, int count, random_state *r)
{
    for (int i = 0; i < count; i++)
        data[i] = (float)(100 * random_signed(r));
}

static double largest_difference(const float *a, const float *b, int count)
{
    double largest = 0;
    for (int i = 0; i < count; i++)
        largest = fmax(largest, fabs((double)a[i] - (double)b[i]));
    return largest;
}

static void test_forward_equals_reference(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        int B = sides[s], count = B * B * B;
        random_state r = {.state = 1u + (unsigned)s};
        fill_random(in, count, &r);
        cvol_block_forward(fast, in, B);
        cvol_block_forward_reference(slow, in, B);
        assert_true(largest_difference(fast, slow, count) < 2e-3);
    }
}

static void test_reference_inverts_and_keeps_energy(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        int B = sides[s], count = B * B * B;
        random_state r = {.state = 10u + (unsigned)s};
        fill_random(in, count, &r);
        cvol_block_forward_reference(slow, in, B);
        double energy_in = 0, energy_out = 0;
        for (int i = 0; i < count; i++) {
            energy_in += (double)in[i] * (double)in[i];
            energy_out += (double)slow[i] * (double)slow[i];
        }
        assert_true(fabs(energy_in / energy_out - 1) < 1e-6);
        cvol_block_inverse_reference(fast, slow, B);
        assert_true(largest_difference(fast, in, count) < 1e-3);
    }
}

/* An impulse at (x, y, z) has the coefficients D[u][x] D[v][y] D[w][z]. */
static void test_impulse(void **state)
{
    (void)state;
    int B = 16, x = 3, y = 14, z = 7;
    const float *D = cvol_block_basis(B);
    memset(in, 0, sizeof in);
    in[x + B * (y + B * z)] = 1;
    cvol_block_forward(fast, in, B);
    for (int w = 0; w < B; w++)
        for (int v = 0; v < B; v++)
            for (int u = 0; u < B; u++) {
                double expected = (double)D[u * B + x] * (double)D[v * B + y] *
                                  (double)D[w * B + z];
                assert_true(fabs((double)fast[u + B * (v + B * w)] - expected) < 1e-6);
            }
}

/* A block of random terms within a random low box, and its dense coefficients in `in`. */
static cvol_block random_block(uint32_t *words, int block_log2, float step, random_state *r)
{
    int B = 1 << block_log2, count = B * B * B, place_bits = cvol_place_bits(block_log2);
    int low[3];
    for (int a = 0; a < 3; a++)
        low[a] = 1 + (int)random_below(r, (uint32_t)B);
    const uint32_t one_of = random_below(r, 2) ? 4 : 1; /* many terms use another algorithm */
    memset(in, 0, sizeof in);
    cvol_block block = {.terms = words};
    for (int i = 0; i < count; i++) {
        int u = i % B, v = i / B % B, w = i / B / B;
        if (u >= low[0] || v >= low[1] || w >= low[2] || random_below(r, one_of))
            continue;
        int32_t value = (int32_t)(random_signed(r) * 50);
        if (random_below(r, 50) == 0)
            value *= 1000000;
        if (value == 0)
            continue;
        block.words += cvol_term_pack(words + block.words, (uint32_t)i, value, place_bits);
        in[i] = step * (float)value;
    }
    cvol_block_find_low(&block, block_log2);
    return block;
}

static void test_terms_decode_to_reference(void **state)
{
    (void)state;
    static uint32_t words[2 * MAX_SAMPLES];
    for (int s = 0; s < 3; s++)
        for (int attempt = 0; attempt < 8; attempt++) {
            int block_log2 = 3 + s, B = 1 << block_log2, count = B * B * B;
            random_state r = {.state = 100u + (unsigned)(8 * s + attempt)};
            cvol_array array = {.rank = 3,
                                .transform = CVOL_DCT,
                                .block = B,
                                .block_log2 = block_log2,
                                .step = 0.5};
            cvol_block block = random_block(words, block_log2, 0.5f, &r);
            array.block_table = &block;
            cvol_block_evaluate(fast, &array, 0);
            cvol_block_inverse_reference(slow, in, B);
            double scale = 0;
            for (int i = 0; i < count; i++)
                scale = fmax(scale, fabs((double)slow[i]));
            assert_true(largest_difference(fast, slow, count) <= 1e-5 * scale);
        }
}

typedef void decode_function(float *, const cvol_block *, const cvol_block_axes *, int, float,
                             cvol_block_work *);
typedef void forward_function(float *, const float *, const float *, int);
CVOL_SIMD_DECLARE(void, cvol_block_decode,
                  (float *out, const cvol_block *block, const cvol_block_axes *axes, int block_log2,
                   float step, cvol_block_work *work));
CVOL_SIMD_DECLARE(void, cvol_block_forward,
                  (float *out, const float *in, const float *basis, int block));

#if defined(__x86_64__)
static void test_same_bits_on_every_set(void **state)
{
    (void)state;
    decode_function *decoders[] = CVOL_SIMD_SETS(cvol_block_decode);
    forward_function *forwards[] = CVOL_SIMD_SETS(cvol_block_forward);
    static uint32_t words[2 * MAX_SAMPLES];
    static cvol_block_work work;
    random_state r = {.state = 7};
    for (int set = 1; set <= (int)cvol_cpu_best(); set++) {
        cvol_block block = random_block(words, 4, 0.3f, &r);
        const float *basis = cvol_block_basis(16);
        cvol_block_axes axes = {.lane = 0,
                                .row = 1,
                                .sheet = 2,
                                .lane_points = 16,
                                .row_points = 16,
                                .sheet_points = 16,
                                .lane_basis = basis,
                                .row_basis = basis,
                                .sheet_basis = basis};
        decoders[0](slow, &block, &axes, 4, 0.3f, &work);
        decoders[set](fast, &block, &axes, 4, 0.3f, &work);
        assert_memory_equal(slow, fast, sizeof(float) * 4096);
        for (int s = 0; s < 3; s++) {
            int count = sides[s] * sides[s] * sides[s];
            fill_random(in, count, &r);
            forwards[0](slow, in, cvol_block_basis(sides[s]), sides[s]);
            forwards[set](fast, in, cvol_block_basis(sides[s]), sides[s]);
            assert_memory_equal(slow, fast, sizeof(float) * (size_t)count);
        }
    }
}
#endif

/* Terms survive packing, escapes included, at every size of block. */
static void test_terms_round_trip(void **state)
{
    (void)state;
    static const int32_t values[] = {1,       -1,      7,          -131071,   131072,    524287,
                                     -524288, 1 << 30, -(1 << 30), INT32_MAX, -INT32_MAX};
    for (int block_log2 = 3; block_log2 <= 5; block_log2++)
        for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
            uint32_t words[2], place;
            uint32_t last = (UINT32_C(1) << cvol_place_bits(block_log2)) - 1;
            uint32_t count = cvol_term_pack(words, last, values[i], cvol_place_bits(block_log2));
            const uint32_t *next = words;
            assert_int_equal(cvol_term_unpack(&next, &place, cvol_place_bits(block_log2)),
                             values[i]);
            assert_int_equal(place, last);
            assert_int_equal(next - words, count);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forward_equals_reference),
        cmocka_unit_test(test_reference_inverts_and_keeps_energy),
        cmocka_unit_test(test_impulse),
        cmocka_unit_test(test_terms_decode_to_reference),
#if defined(__x86_64__)
        cmocka_unit_test(test_same_bits_on_every_set),
#endif
        cmocka_unit_test(test_terms_round_trip),
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
