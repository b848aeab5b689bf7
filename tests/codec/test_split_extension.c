/* Cells that reach beyond the volume: their samples inside stay unchanged, the extension makes them
 * cheaper, and sub-blocks beyond the volume take no bits. */
#include "test.h"

#include "array/block/cell_weight.h"
#include "codec/quantize/split_extension.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"

enum { SIDE = CVOL_CELL };

static float samples[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
static float repeated[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
static float extended[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
static float decoded[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
static cvol_cell_edge scratch;

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Waves across the cell's faces, the last sample inside repeated. */
static void make_samples(random_state *r, const int inside[3])
{
    double wave[4][4];
    for (int i = 0; i < 16; i++)
        wave[i / 4][i % 4] = (i % 4 < 3 ? 0.6 : 3.0) * random_signed(r);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++) {
        const int x = least(i % SIDE, inside[0] - 1), y = least(i / SIDE % SIDE, inside[1] - 1),
                  z = least(i / SIDE / SIDE, inside[2] - 1);
        samples[i] = 0;
        for (int k = 0; k < 4; k++)
            samples[i] += 100 *
                          (float)sin(wave[k][0] * x + wave[k][1] * y + wave[k][2] * z + wave[k][3]);
    }
}

static float weight_of(const float *coefficients, float step, int dcs)
{
    float weights[8], sum = 0;
    cvol_cell_weigh(weights, coefficients, 1 / step, dcs);
    for (int i = 0; i < 8; i++)
        sum += weights[i];
    return sum;
}

static void test_samples_inside_stay_unchanged(void **state)
{
    static const uint16_t splits[3] = {CVOL_CELL_WHOLE, CVOL_CELL_OCTANTS, CVOL_CELL_FOURS};
    static const int box[3] = {SIDE, SIDE, SIDE};
    random_state r = {7};
    float before[3] = {0}, after[3] = {0};
    (void)state;
    for (int turn = 0; turn < 60; turn++) {
        const int split = turn % 3;
        const float step = turn % 2 ? 4 : 12;
        int inside[3] = {SIDE, SIDE, SIDE};
        for (int a = 0; a <= turn % 4 && a < 3; a++)
            inside[a] = 3 + (int)random_below(&r, 11);
        make_samples(&r, inside);
        cvol_cell_forward(repeated, samples, splits[split]);
        cvol_cell_forward_edge(extended, &scratch, samples, inside, splits[split], step);
        cvol_cell_inverse(decoded, extended, splits[split], box);
        for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
            if (i % SIDE < inside[0] && i / SIDE % SIDE < inside[1] && i / SIDE / SIDE < inside[2])
                assert_true(fabsf(decoded[i] - samples[i]) < 1e-3f);
        before[split] += weight_of(repeated, step, 1 << split);
        after[split] += weight_of(extended, step, 1 << split);
    }
    for (int split = 0; split < 3; split++)
        assert_true(after[split] < 0.95f * before[split]);
}

static void test_sub_blocks_beyond_the_end(void **state)
{
    int inside[3];
    (void)state;
    cvol_cell_find_inside(inside, (const size_t[3]){64, 25, 8}, (const size_t[3]){3, 1, 0});
    assert_int_equal(inside[0], 16);
    assert_int_equal(inside[1], 9);
    assert_int_equal(inside[2], 8);
    assert_int_equal(cvol_cell_reaches_beyond(inside, (const int[3]){0, 0, 0}, 16), 1);
    assert_int_equal(cvol_cell_reaches_beyond(inside, (const int[3]){8, 0, 0}, 8), 0);
    assert_int_equal(cvol_cell_reaches_beyond(inside, (const int[3]){0, 8, 0}, 8), 1);
    assert_int_equal(cvol_cell_reaches_beyond(inside, (const int[3]){0, 12, 0}, 4), 2);
    assert_int_equal(cvol_cell_reaches_beyond(inside, (const int[3]){0, 0, 8}, 8), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_samples_inside_stay_unchanged),
        cmocka_unit_test(test_sub_blocks_beyond_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
