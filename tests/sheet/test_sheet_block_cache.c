/* Blocks that bands exchange are complete or absent. */
#include "test.h"

#include "base/thread.h"
#include "render/sheet/band/block_exchange.h"

enum { LANE = 10, ROW = 7, SHEET = 5, ROW_STRIDE = 24, SHEET_STRIDE = 200, ALL = 1100 };

static cvol_sheet_plan make_plan(int int16)
{
    return (cvol_sheet_plan){.blocks_lane = 4,
                             .blocks_row = 9,
                             .layers = 8,
                             .points_lane = LANE,
                             .points_row = ROW,
                             .points_sheet = SHEET,
                             .int16 = {(float)int16, 0}};
}

/* Samples that identify their block and place; between them, values that no block has. */
static void fill(int16_t *out, long size, int16_t of)
{
    for (int i = 0; i < ALL * size; i++)
        out[i] = -1;
    for (int z = 0; z < SHEET; z++)
        for (int y = 0; y < ROW; y++)
            for (int i = 0; i < LANE * size; i++)
                out[z * SHEET_STRIDE * size + y * ROW_STRIDE * size + i] = (int16_t)(of + 100 * z +
                                                                                     10 * y + i);
}

static void test_blocks_round_trip(void **state)
{
    (void)state;
    for (int int16 = 0; int16 < 2; int16++) {
        const cvol_sheet_plan plan = make_plan(int16);
        const long size = int16 ? 1 : 2; /* of a sample, in halves of a float */
        cvol_block_exchange all = {0},
                            *exchange = cvol_block_exchange_open(&all, &plan, 2, 1000000);
        assert_non_null(exchange);
        int16_t given[2 * ALL], got[2 * ALL];
        fill(given, size, 3);
        const size_t place = cvol_block_exchange_place(exchange, 2, 5, 1);
        assert_int_equal(
            cvol_block_exchange_take(exchange, place, 77, got, ROW_STRIDE, SHEET_STRIDE), 0);
        cvol_block_exchange_put(exchange, place, 77, given, ROW_STRIDE, SHEET_STRIDE);
        assert_int_equal(
            cvol_block_exchange_take(exchange, place, 78, got, ROW_STRIDE, SHEET_STRIDE), 0);
        for (int i = 0; i < ALL * size; i++)
            got[i] = -1;
        assert_int_equal(
            cvol_block_exchange_take(exchange, place, 77, got, ROW_STRIDE, SHEET_STRIDE), 1);
        assert_memory_equal(got, given, sizeof *got * ALL * (size_t)size);
        /* The next frame has none of this frame's blocks. */
        exchange = cvol_block_exchange_open(&all, &plan, 2, 1000000);
        assert_int_equal(
            cvol_block_exchange_take(exchange, place, 77, got, ROW_STRIDE, SHEET_STRIDE), 0);
        cvol_block_exchange_free(&all);
    }
}

static void test_no_two_rows_of_a_layer_share_a_place(void **state)
{
    (void)state;
    const cvol_sheet_plan plan = make_plan(1);
    for (int threads = 2; threads < 5; threads++) {
        cvol_block_exchange all = {0},
                            *exchange = cvol_block_exchange_open(&all, &plan, threads, 1000000);
        assert_non_null(exchange);
        uint8_t taken[4 * 9 * 8] = {0};
        const size_t rows = threads == 2 ? 6 : 9;
        for (size_t row = 3; row < 3 + rows && row < 9; row++)
            for (size_t lane = 0; lane < 4; lane++) {
                const size_t place = cvol_block_exchange_place(exchange, lane, row, 7);
                assert_true(place < exchange->lanes * exchange->rows * exchange->layers);
                assert_int_equal(taken[place]++, 0);
            }
        cvol_block_exchange_free(&all);
    }
}

static void test_no_exchange_without_shared_blocks(void **state)
{
    (void)state;
    cvol_sheet_plan plan = make_plan(1);
    cvol_block_exchange all = {0};
    assert_null(cvol_block_exchange_open(&all, &plan, 1, 1000000));
    assert_null(cvol_block_exchange_open(&all, &plan, 2, 1000)); /* no room */
    plan.level = 1;
    assert_null(cvol_block_exchange_open(&all, &plan, 2, 1000000));
    assert_int_equal(cvol_block_exchange_take(NULL, 0, 0, NULL, 0, 0), 0);
    cvol_block_exchange_put(NULL, 0, 0, NULL, 0, 0);
    cvol_block_exchange_free(&all);
}

/* Many threads put two blocks into one place and take them from it at the same time. */
static void test_many_threads(void **state)
{
    (void)state;
    const cvol_sheet_plan plan = make_plan(1);
    cvol_block_exchange all = {0}, *exchange = cvol_block_exchange_open(&all, &plan, 4, 1000000);
    assert_non_null(exchange);
    int torn = 0, taken = 0;
#pragma omp parallel num_threads(4) reduction(+ : torn, taken)
    {
        int16_t given[2][ALL], got[ALL];
        fill(given[0], 1, 0);
        fill(given[1], 1, 5000);
        fill(got, 1, 0);
        unsigned next = 1 + (unsigned)cvol_thread_index();
        for (int i = 0; i < 20000; i++) {
            next = next * 1664525u + 1013904223u;
            const size_t index = next >> 30 & 1;
            if (next >> 31) {
                cvol_block_exchange_put(exchange, 3, index, given[index], ROW_STRIDE, SHEET_STRIDE);
            } else if (cvol_block_exchange_take(exchange, 3, index, got, ROW_STRIDE,
                                                SHEET_STRIDE)) {
                taken++;
                for (int at = 0; at < ALL; at++)
                    torn += got[at] != given[index][at];
            }
        }
    }
    assert_int_equal(torn, 0);
    assert_true(taken > 0);
    cvol_block_exchange_free(&all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks_round_trip),
        cmocka_unit_test(test_no_two_rows_of_a_layer_share_a_place),
        cmocka_unit_test(test_no_exchange_without_shared_blocks),
        cmocka_unit_test(test_many_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
