/* Classification in integers (render/sheet/frame/int16_format.h) equals the table's segments for
 * every sample, with steps at the right samples. */
#include "test.h"

#include "random.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/frame/table.h"
#include "render/transfer/transfer.h"
#include "support.h"

static cvol_sheet_table table;

static double random_uniform(random_state *r)
{
    return 0.5 + 0.5 * random_signed(r);
}

/* The result of kernels for one sample. */
static void classify(double out[4], const cvol_int16_table *w, int q)
{
    q = q < w->from ? w->from : q > w->to ? w->to : q;
    const int bin = (int)((unsigned)(q - w->from) * w->bins >> 16);
    int piece = w->segment_of[bin];
    assert_in_range(bin, 0, CVOL_INT16_BINS - 1);
    for (int step = 0; step < w->steps; step++)
        piece += q >= w->end[piece];
    assert_true(q < w->end[piece] && (piece == 0 || q >= w->end[piece - 1]));
    const int part = (q - w->begin[piece]) << w->up[piece];
    assert_in_range(part, 0, CVOL_INT16_MAX);
    for (int k = 0; k < 4; k++) {
        const int value = w->start[k][piece] + ((part * w->rise[k][piece] + 16384) >> 15);
        assert_in_range(value, 0, 16383);
        out[k] = value / (16384.0 * (1 << (w->shift + w->fine)));
    }
}

/* The same by the table: the first segment that ends beyond a coordinate. */
static void look_up(double out[4], double t)
{
    int piece = 0;
    while ((double)table.segment_end[piece] <= t)
        piece++;
    for (int k = 0; k < 4; k++)
        out[k] = fmax(
            (double)table.segment_start[k][piece] + t * (double)table.segment_rise[k][piece], 0);
}

static cvol_transfer *random_function(random_state *r, double most)
{
    cvol_transfer_point points[6];
    cvol_transfer *transfer;
    const int count = 2 + (int)(random_uniform(r) * 4.99);
    double at = 20 + 40 * random_uniform(r);
    for (int i = 0; i < count; i++) {
        points[i] = (cvol_transfer_point){at, random_uniform(r), random_uniform(r),
                                          random_uniform(r),
                                          random_uniform(r) < 0.3 ? 0 : most * random_uniform(r)};
        at += random_uniform(r) < 0.2 ? 0 : 5 + 60 * random_uniform(r);
    }
    assert_int_equal(cvol_transfer_create(NULL, &transfer, points, (size_t)count), CVOL_OK);
    return transfer;
}

static void int16_table_equals_segments(void **state)
{
    (void)state;
    int usable = 0;
    for (uint64_t seed = 1; seed <= 120; seed++) {
        random_state r = {seed};
        const double most = seed % 3 == 0 ? 1 : seed % 3 == 1 ? 0.2 : 0.002;
        const cvol_array array = {.range_min = -50, .range_max = 300, .offset = 40};
        cvol_transfer *transfer = random_function(&r, most);
        const float scale = 32000.0f / (seed % 2 ? 350 : 1000), offset = seed % 2 ? 9000 : 14000;
        cvol_sheet_table_fill(&table, &array, transfer, 0.7 + random_uniform(&r), 0);
        cvol_int16_table_fill(&table.int16, &table, scale, offset);
        const cvol_int16_table *w = &table.int16;
        usable += w->usable;
        for (int q = 0; q <= CVOL_INT16_MAX && w->usable; q++) {
            double got[4], wanted[4], near[4];
            const double value = (q - (double)offset) / (double)scale,
                         t = (value - (double)table.from) * (double)table.scale,
                         apart = 1.5 * (double)table.scale / (double)scale;
            classify(got, w, q);
            for (int k = 0; k < 4; k++)
                wanted[k] = INFINITY, near[k] = -INFINITY;
            for (int side = -1; side <= 1; side++) { /* a step may lie within a sample */
                double at[4];
                look_up(at, fmin(fmax(t, 0.5), CVOL_TABLE_SIZE - 0.5) + side * apart);
                for (int k = 0; k < 4; k++) {
                    wanted[k] = fmin(wanted[k], at[k]);
                    near[k] = fmax(near[k], at[k]);
                }
            }
            /* Four steps, and the amount by which segments may fall below 0 (table.c). */
            const double least = 4 / (16384.0 * (1 << (w->shift + w->fine))) + 2e-6;
            for (int k = 0; k < 4; k++)
                if (got[k] < wanted[k] - least || got[k] > near[k] + least) {
                    print_message("seed %llu, sample %d, %d: %g, not %g to %g\n",
                                  (unsigned long long)seed, q, k, got[k], wanted[k], near[k]);
                    fail();
                }
        }
        cvol_transfer_free(transfer);
    }
    print_message("%d of 120 functions fit\n", usable);
    assert_true(usable > 60);
}

/* Close points in one part of a table have no effect on other parts, for any bins. */
static void dense_control_points_keep_their_values(void **state)
{
    (void)state;
    static const cvol_transfer_point points[] = {
        {0, 0, 0, 0, 0},          {874, .8, .5, .4, 0},     {974, .85, .55, .45, .01},
        {1104, .85, .5, .4, .02}, {1174, .9, .75, .6, .02}, {1324, 1, .95, .85, .15},
        {2024, 1, 1, .95, .35},   {4095, 1, 1, 1, .5}};
    cvol_transfer *transfer;
    double worst = 0, sum = 0;
    assert_int_equal(cvol_transfer_create(NULL, &transfer, points, sizeof points / sizeof *points),
                     CVOL_OK);
    for (double most = 3900; most < 4100; most += 7) {
        const cvol_array array = {.range_min = -10, .range_max = most};
        cvol_sheet_table_fill(&table, &array, transfer, 1, 0);
        assert_true(table.segments > 0);
        sum = 0;
        for (double value = 1000; value < most; value++) {
            double got[4];
            look_up(got, (value - (double)table.from) * (double)table.scale);
            sum += fabs(got[3] / cvol_transfer_at(transfer, value).opacity - 1);
        }
        worst = fmax(worst, sum / (most - 1000));
    }
    if (test_verbose())
        print_message("%g off in the mean at most\n", worst);
    assert_true(worst < 0.0004);
    cvol_transfer_free(transfer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(int16_table_equals_segments),
                                       cmocka_unit_test(dense_control_points_keep_their_values)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
