/* Intervals by the integrals of a transfer function (render/sheet/kernels/integrate.h) against the
 * function itself, composited in thousands of steps in double precision. */
#include "test.h"

#include "random.h"
#include "render/sheet/frame/table.h"
#include "render/sheet/kernels/integrate.h"
#include "render/transfer/transfer.h"
#include "support.h"

enum { FUNCTIONS = 300, STEPS = 4000 };

static cvol_sheet_table table;
static cvol_array array;

static double random_uniform(random_state *r)
{
    return 0.5 + 0.5 * random_signed(r);
}

/* Up to six points, two of which may make a jump, with one colour or several. */
static cvol_transfer *random_function(random_state *r, double most, int grey)
{
    cvol_transfer_point points[6];
    cvol_transfer *transfer;
    const int count = 2 + (int)(random_uniform(r) * 4.99);
    double at = 20 + 40 * random_uniform(r);
    for (int i = 0; i < count; i++) {
        points[i] = (cvol_transfer_point){
            at, grey ? 0.5 : random_uniform(r), grey ? 0.5 : random_uniform(r),
            grey ? 0.5 : random_uniform(r), random_uniform(r) < 0.3 ? 0 : most * random_uniform(r)};
        at += random_uniform(r) < 0.2 ? 0 : 5 + 60 * random_uniform(r);
    }
    assert_int_equal(cvol_transfer_create(NULL, &transfer, points, (size_t)count), CVOL_OK);
    return transfer;
}

/* Composites the interval through three values, whose quarters lie on a parabola through these,
 * with straight lines in between; out: colour and transmittance. */
static void composite(double out[4], const cvol_transfer *transfer, const double through[3],
                      double length, double distance)
{
    const double a = through[0], m = through[1], b = through[2], bow = (2 * m - a - b) / 8;
    const double nodes[5] = {a, (a + m) / 2 + bow, m, (m + b) / 2 + bow, b};
    out[0] = out[1] = out[2] = 0;
    out[3] = 1;
    for (int i = 0; i < STEPS; i++) {
        const double place = 4 * (i + 0.5) / STEPS;
        const int part = (int)place;
        const cvol_transfer_point p = cvol_transfer_at(
            transfer, nodes[part] + (place - part) * (nodes[part + 1] - nodes[part]));
        const double opacity = cvol_opacity_over(p.opacity, distance * length / STEPS);
        const double colour[3] = {p.r, p.g, p.b};
        for (int k = 0; k < 3; k++)
            out[k] += out[3] * opacity * colour[k];
        out[3] *= 1 - opacity;
    }
}

static double value_at_coordinate(double t)
{
    return t / (double)table.scale + (double)table.from + array.offset;
}

/* Returns the largest error of CVOL_LANES random intervals. */
static double check_intervals(const cvol_transfer *transfer, double distance, random_state *r)
{
    cvol_vf through[3], length;
    for (int i = 0; i < CVOL_LANES; i++) {
        const double start = 3000 * random_signed(r) + 1000, rise = 2500 * random_signed(r);
        through[0][i] = (float)start;
        through[1][i] = (float)(start + 0.5 * rise + (i % 2 ? 0.25 * rise * random_signed(r) : 0));
        through[2][i] = (float)(start + rise);
        length[i] = i % 3 ? 1 : (float)random_uniform(r);
    }
    integrated sum;
    integrate_interval(&sum, &table, through, length, cvol_splat(0));
    double worst = 0;
    for (int i = 0; i < CVOL_LANES; i++) {
        double values[3], expected[4];
        for (int k = 0; k < 3; k++)
            values[k] = value_at_coordinate((double)through[k][i]);
        composite(expected, transfer, values, (double)length[i], distance);
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs((double)sum.colour[k][i] - expected[k]));
        worst = fmax(worst, fabs((double)sum.transmittance[i] - expected[3]));
    }
    return worst;
}

/* Of one colour, an interval's result depends on its extinction alone, which the integrals give.
 * Otherwise, where the order of colours within one part matters, the error grows with opacity. */
static void expect_intervals(double most, int grey, double limit)
{
    random_state r = {17};
    double worst = 0;
    for (int f = 0; f < FUNCTIONS; f += SUPPORT_STRIDE) {
        const double distance = 0.5 + 1.2 * random_uniform(&r);
        cvol_transfer *transfer = random_function(&r, most, grey);
        array = (cvol_array){.range_min = 0, .range_max = 400, .offset = 100};
        cvol_sheet_table_fill(&table, &array, transfer, distance, 0);
        worst = fmax(worst, check_intervals(transfer, distance, &r));
        cvol_transfer_free(transfer);
    }
    print_message("seed 17, opacity up to %g, %s: errors up to %.4f\n", most,
                  grey ? "one colour" : "several colours", worst);
    assert_true(worst < limit);
}

static void test_extinction(void **state)
{
    (void)state;
    expect_intervals(0.1, 1, 0.0005);
    expect_intervals(0.95, 1, 0.003);
}

static void test_colours(void **state)
{
    (void)state;
    expect_intervals(0.1, 0, 0.001);
    expect_intervals(0.95, 0, 0.03);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_extinction),
                                       cmocka_unit_test(test_colours)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
