/* The kernel of tiles against its formula, term by term in double precision: few terms and many,
 * escapes, all sides of tiles, rows cut off above and below. */
#include "test.h"

#include "array/core/array.h"
#include "random.h"
#include "render/spectral/tile.h"

enum { STRIDE = 96, ROWS = 90 };

typedef struct tile_case {
    uint32_t terms[2 * 32 * 32];
    double values[32][32]; /* [v][u] */
    float across[32 * CVOL_TILE_PLACES + CVOL_TILE_SPARE];
    float down[32 * CVOL_TILE_PLACES + CVOL_TILE_SPARE];
    float out[ROWS * STRIDE], before[ROWS * STRIDE];
    cvol_tile_task task;
} tile_case;

/* A share of the places within a low box has terms, one in 50 of them an escape. */
static void make_case(tile_case *t, random_state *random, int log2, int places, double share)
{
    const int B = 1 << log2, bits = cvol_place_bits(log2);
    const int columns = 1 + (int)random_below(random, (uint32_t)B);
    const int rows = 1 + (int)random_below(random, (uint32_t)B);
    uint32_t words = 0;
    memset(t->values, 0, sizeof t->values);
    for (int v = 0; v < rows; v++)
        for (int u = 0; u < columns; u++) {
            if (fabs(random_signed(random)) > share)
                continue;
            int32_t value = 1 + (int32_t)random_below(random, 1000);
            if (random_below(random, 50) == 0)
                value = -2 * cvol_term_escape(bits) + value;
            value = random_below(random, 2) ? value : -value;
            words += cvol_term_pack(t->terms + words, (uint32_t)(v * B + u), value, bits);
            t->values[v][u] = (double)value / 1024;
        }
    for (size_t i = 0; i < sizeof t->across / sizeof *t->across; i++) {
        t->across[i] = (float)random_signed(random);
        t->down[i] = (float)random_signed(random);
    }
    for (size_t i = 0; i < ROWS * STRIDE; i++)
        t->out[i] = t->before[i] = (float)random_signed(random);
    const int from = (int)random_below(random, (uint32_t)places);
    t->task = (cvol_tile_task){
        .terms = t->terms,
        .end = t->terms + words,
        .step = 1.0f / 1024,
        .block_log2 = log2,
        .columns = columns,
        .rows = rows,
        .across = t->across,
        .down = t->down,
        .width = (places + CVOL_TILE_LANES - 1) / CVOL_TILE_LANES * CVOL_TILE_LANES,
        .from = from,
        .to = from + 1 + (int)random_below(random, (uint32_t)(places - from)),
        .out = t->out,
        .stride = STRIDE};
}

/* The largest difference from the formula, relative to the sum of the added magnitudes. */
static double worst_of(const tile_case *t)
{
    const cvol_tile_task *task = &t->task;
    double worst = 0;
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < STRIDE; x++) {
            const int inside = y >= task->from && y < task->to && x < task->width;
            double sum = (double)t->before[y * STRIDE + x], size = 1;
            for (int v = 0; inside && v < task->rows; v++)
                for (int u = 0; u < task->columns; u++) {
                    const double part = t->values[v][u] *
                                        (double)task->across[u * task->width + x] *
                                        (double)task->down[v * task->width + y];
                    sum += part;
                    size += fabs(part);
                }
            worst = fmax(worst, fabs((double)t->out[y * STRIDE + x] - sum) / size);
        }
    return worst;
}

static void test_formula(void **state)
{
    static const double shares[] = {0.02, 0.2, 0.6, 1};
    (void)state;
    random_state random = {2024};
    tile_case *t = calloc(1, sizeof *t);
    assert_non_null(t);
    for (int n = 0; n < 300; n++) {
        const uint64_t seed = random.state;
        const int log2 = 3 + n % 3, places = 8 + (int)random_below(&random, 55);
        make_case(t, &random, log2, places, shares[n % 4]);
        CVOL_SIMD_CHOOSE(cvol_tile_add)(&t->task);
        const double worst = worst_of(t);
        if (!(worst < 2e-6))
            fail_msg("seed %llu, tile of %d, %d places, share %g: off by %g",
                     (unsigned long long)seed, 1 << log2, places, shares[n % 4], worst);
    }
    free(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_formula)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
