/* DCTs of split cells: the fast ones against the direct sums, inverses, Parseval, the order of
 * frequencies, pruning, octants' independence, and the same bits from every instruction set. */
#include "test.h"

#include "base/cpu.h"
#include "random.h"
#include "support_kernels.h"
#include "transform/block.h"
#include "transform/cell.h"
#include "transform/cell_bases.h"

#define N CVOL_CELL
#define COUNT CVOL_CELL_SAMPLES

typedef float cell[COUNT] __attribute__((aligned(64)));

static cell in, fast, slow, other;
static const int whole_box[3] = {N, N, N};

/* Random splits for every case; the first ten are extremes: whole, all octants, all fours, one
 * octant of fours, all but one. */
static uint16_t split_of(int attempt, random_state *r)
{
    static const uint16_t extremes[] = {0,     1,     0x1ff, 0x003, 0x101,
                                        0x011, 0x1fd, 0x0ff, 0x0ab, 0x155};
    if (attempt < (int)(sizeof extremes / sizeof *extremes))
        return extremes[attempt];
    return (uint16_t)(1 | random_below(r, 256) << 1);
}

static void fill_random(float *data, random_state *r)
{
    for (int i = 0; i < COUNT; i++)
        data[i] = (float)(100 * random_signed(r));
}

static double largest_difference(const float *a, const float *b)
{
    double largest = 0;
    for (int i = 0; i < COUNT; i++)
        largest = fmax(largest, fabs((double)a[i] - (double)b[i]));
    return largest;
}

static double inner_product(const float *a, const float *b)
{
    double sum = 0;
    for (int i = 0; i < COUNT; i++)
        sum += (double)a[i] * (double)b[i];
    return sum;
}

static void check(int holds, const char *what, uint16_t split, int attempt)
{
    if (!holds)
        fail_msg("%s: split 0x%03x, seed %d", what, split, attempt);
}

static void test_valid_splits(void **state)
{
    (void)state;
    int valid = 0;
    for (int split = 0; split <= UINT16_MAX; split++)
        valid += cvol_cell_valid_split((uint16_t)split);
    assert_int_equal(valid, 257);
    assert_true(cvol_cell_valid_split(0) && cvol_cell_valid_split(1));
    assert_true(cvol_cell_valid_split(0x1ff) && cvol_cell_valid_split(0x101));
    assert_false(cvol_cell_valid_split(2) || cvol_cell_valid_split(0x201));
}

/* The sub-blocks of a split tile the samples, and the places, each once. */
static void test_parts_tile(void **state)
{
    (void)state;
    random_state r = {.state = 1};
    for (int attempt = 0; attempt < 20; attempt++) {
        uint16_t split = split_of(attempt, &r);
        cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
        unsigned char samples[COUNT] = {0}, places[COUNT] = {0};
        int count = cvol_cell_list_sub_blocks(parts, split);
        for (int p = 0; p < count; p++) {
            const int M = parts[p].side, *b = parts[p].begin, *f = parts[p].first;
            for (int i = 0; i < M * M * M; i++) {
                int x = i % M, y = i / M % M, z = i / M / M;
                samples[b[0] + x + N * (b[1] + y + N * (b[2] + z))]++;
                places[f[0] + x * N / M + N * (f[1] + y * N / M + N * (f[2] + z * N / M))]++;
            }
        }
        for (int i = 0; i < COUNT; i++)
            check(samples[i] == 1 && places[i] == 1, "parts", split, attempt);
    }
}

/* Whole cells are blocks of 16; the sub-blocks of a uniform split are blocks of 8. */
static void test_parts_are_blocks(void **state)
{
    (void)state;
    random_state r = {.state = 2};
    fill_random(in, &r);
    cvol_cell_forward_reference(slow, in, 0);
    cvol_block_forward_reference(fast, in, N);
    assert_true(largest_difference(fast, slow) < 1e-4);
    cvol_cell_forward_reference(slow, in, 1);
    for (int octant = 0; octant < 8; octant++) {
        const int c[3] = {octant & 1, octant >> 1 & 1, octant >> 2};
        for (int i = 0; i < 512; i++)
            other[i] = in[8 * c[0] + i % 8 + N * (8 * c[1] + i / 8 % 8 + N * (8 * c[2] + i / 64))];
        cvol_block_forward_reference(fast, other, 8);
        for (int i = 0; i < 512; i++) {
            float found =
                slow[2 * (i % 8) + c[0] + N * (2 * (i / 8 % 8) + c[1] + N * (2 * (i / 64) + c[2]))];
            assert_true(fabs((double)found - (double)fast[i]) < 1e-4);
        }
    }
}

/* Frequency (1, 0, 2) of the sub-block of quarters (1, 0, 1) in octant (0, 1, 1). */
static void test_place_of_one_frequency(void **state)
{
    (void)state;
    memset(in, 0, sizeof in);
    for (int z = 0; z < 4; z++)
        for (int x = 0; x < 4; x++)
            for (int y = 0; y < 4; y++)
                in[4 + x + N * (8 + y + N * (12 + z))] =
                    (float)(cos(3.14159265358979323846 * (x + 0.5) / 4) *
                            cos(3.14159265358979323846 * 2 * (z + 0.5) / 4));
    cvol_cell_forward(fast, in, 1 | 1 << (1 + 0 + 2 + 4));
    int place = (4 * 1 + 2 * 1 + 0) + N * ((4 * 0 + 2 * 0 + 1) + N * (4 * 2 + 2 * 1 + 1));
    assert_true(fabs((double)fast[place] - sqrt(2.0) * 2 * sqrt(2.0)) < 1e-5);
    fast[place] = 0;
    for (int i = 0; i < COUNT; i++)
        assert_true(fabs((double)fast[i]) < 1e-5);
}

static void test_forward_equals_reference(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 30; attempt++) {
        random_state r = {.state = 100u + (unsigned)attempt};
        uint16_t split = split_of(attempt, &r);
        fill_random(in, &r);
        cvol_cell_forward(fast, in, split);
        cvol_cell_forward_reference(slow, in, split);
        check(largest_difference(fast, slow) < 1e-3, "forward", split, attempt);
        check(fabs(inner_product(fast, fast) / inner_product(in, in) - 1) < 1e-5, "Parseval", split,
              attempt);
        check(fabs(inner_product(slow, slow) / inner_product(in, in) - 1) < 1e-6,
              "Parseval of the reference", split, attempt);
    }
}

static void test_inverse_equals_reference(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 30; attempt++) {
        random_state r = {.state = 200u + (unsigned)attempt};
        uint16_t split = split_of(attempt, &r);
        fill_random(in, &r);
        cvol_cell_inverse(fast, in, split, whole_box);
        cvol_cell_inverse_reference(slow, in, split);
        check(largest_difference(fast, slow) < 1e-3, "inverse", split, attempt);
        cvol_cell_forward(other, fast, split);
        check(largest_difference(other, in) < 1e-3, "forward of inverse", split, attempt);
        cvol_cell_forward_reference(other, slow, split);
        check(largest_difference(other, in) < 1e-3, "the references' forward of inverse", split,
              attempt);
    }
}

/* <forward a, b> = <a, inverse b>, for every one of the splits. */
static void test_inverse_is_adjoint(void **state)
{
    (void)state;
    random_state r = {.state = 3};
    for (int bits = -1; bits < 256; bits++) {
        uint16_t split = (uint16_t)(bits < 0 ? 0 : 1 | bits << 1);
        fill_random(in, &r);
        fill_random(other, &r);
        cvol_cell_forward(fast, in, split);
        cvol_cell_inverse(slow, other, split, whole_box);
        double scale = sqrt(inner_product(in, in) * inner_product(other, other));
        double gap = inner_product(fast, other) - inner_product(in, slow);
        check(fabs(gap) < 1e-5 * scale, "adjoint", split, bits);
        cvol_cell_inverse(slow, fast, split, whole_box);
        check(largest_difference(slow, in) < 1e-3, "inverse of forward", split, bits);
    }
}

/* Values beyond the box are not read; within it the sums are those of zeros beyond. */
static void test_pruned_inverse(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 300; attempt++) {
        random_state r = {.state = 300u + (unsigned)attempt};
        uint16_t split = split_of(attempt % 20, &r);
        int box[3];
        for (int a = 0; a < 3; a++)
            box[a] = attempt < 20 ? 1 : (int)random_below(&r, N + 1);
        fill_random(in, &r);
        memcpy(other, in, sizeof in);
        for (int i = 0; i < COUNT; i++)
            if (i % N >= box[0] || i / N % N >= box[1] || i / N / N >= box[2]) {
                in[i] = NAN;
                other[i] = 0;
            }
        cvol_cell_inverse(fast, in, split, box);
        cvol_cell_inverse(slow, other, split, whole_box);
        for (int i = 0; i < COUNT; i++)
            check(fast[i] == slow[i], "pruned", split, attempt);
    }
}

static void test_linearity(void **state)
{
    (void)state;
    static cell sum, image;
    for (int attempt = 0; attempt < 20; attempt++) {
        random_state r = {.state = 400u + (unsigned)attempt};
        uint16_t split = split_of(attempt, &r);
        fill_random(in, &r);
        fill_random(other, &r);
        for (int i = 0; i < COUNT; i++)
            sum[i] = 3 * in[i] - 2 * other[i];
        cvol_cell_forward(fast, in, split);
        cvol_cell_forward(slow, other, split);
        cvol_cell_forward(image, sum, split);
        for (int i = 0; i < COUNT; i++)
            fast[i] = 3 * fast[i] - 2 * slow[i];
        check(largest_difference(image, fast) < 5e-3, "linear", split, attempt);
    }
}

/* An octant's coefficients and samples equal those of the uniform split, to the bit. */
static void test_octants_do_not_touch(void **state)
{
    (void)state;
    static cell uniform[2];
    for (int attempt = 0; attempt < 30; attempt++) {
        random_state r = {.state = 500u + (unsigned)attempt};
        uint16_t split = (uint16_t)(split_of(attempt, &r) | 1);
        fill_random(in, &r);
        cvol_cell_forward(uniform[0], in, CVOL_CELL_OCTANTS);
        cvol_cell_forward(uniform[1], in, CVOL_CELL_FOURS);
        cvol_cell_forward(fast, in, split);
        for (int i = 0; i < COUNT; i++) {
            int fours = split >> (1 + (i & 1) + 2 * (i >> 4 & 1) + 4 * (i >> 8 & 1)) & 1;
            check(fast[i] == uniform[fours][i], "octant's coefficients", split, attempt);
        }
        cvol_cell_inverse(uniform[0], in, CVOL_CELL_OCTANTS, whole_box);
        cvol_cell_inverse(uniform[1], in, CVOL_CELL_FOURS, whole_box);
        cvol_cell_inverse(fast, in, split, whole_box);
        for (int i = 0; i < COUNT; i++) {
            int fours = split >> (1 + (i >> 3 & 1) + 2 * (i >> 7 & 1) + 4 * (i >> 11 & 1)) & 1;
            check(fast[i] == uniform[fours][i], "octant's samples", split, attempt);
        }
    }
}

#if defined(__x86_64__)
typedef void forward_function(float *, const float *, int, const cvol_cell_bases *);
typedef void inverse_function(float *, const float *, uint16_t, const int *,
                              const cvol_cell_bases *);
CVOL_SIMD_DECLARE(void, cvol_cell_forward_by,
                  (float *out, const float *in, int way, const cvol_cell_bases *with));
CVOL_SIMD_DECLARE(void, cvol_cell_inverse_box,
                  (float *out, const float *in, uint16_t split, const int box[3],
                   const cvol_cell_bases *with));

static void test_same_bits_on_every_set(void **state)
{
    (void)state;
    forward_function *forwards[] = CVOL_SIMD_SETS(cvol_cell_forward_by);
    inverse_function *inverses[] = CVOL_SIMD_SETS(cvol_cell_inverse_box);
    /* Any numbers are valid: the sets must agree on them. */
    static cvol_cell_bases bases __attribute__((aligned(64)));
    float *numbers = (float *)&bases;
    random_state r = {.state = 7};
    for (size_t i = 0; i < sizeof bases / sizeof *numbers; i++)
        numbers[i] = (float)random_signed(&r);
    for (int set = 1; set <= (int)cvol_cpu_best(); set++)
        for (int attempt = 0; attempt < 40; attempt++) {
            uint16_t split = split_of(attempt, &r);
            fill_random(in, &r);
            forwards[0](slow, in, attempt % 3, &bases);
            forwards[set](fast, in, attempt % 3, &bases);
            assert_memory_equal(slow, fast, sizeof fast);
            int box[3];
            for (int a = 0; a < 3; a++)
                box[a] = attempt < 10 ? N : 1 + (int)random_below(&r, N);
            inverses[0](slow, in, split, box, &bases);
            inverses[set](fast, in, split, box, &bases);
            assert_memory_equal(slow, fast, sizeof fast);
        }
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_valid_splits),
        cmocka_unit_test(test_parts_tile),
        cmocka_unit_test(test_parts_are_blocks),
        cmocka_unit_test(test_place_of_one_frequency),
        cmocka_unit_test(test_forward_equals_reference),
        cmocka_unit_test(test_inverse_equals_reference),
        cmocka_unit_test(test_inverse_is_adjoint),
        cmocka_unit_test(test_pruned_inverse),
        cmocka_unit_test(test_linearity),
        cmocka_unit_test(test_octants_do_not_touch),
#if defined(__x86_64__)
        cmocka_unit_test(test_same_bits_on_every_set),
#endif
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
