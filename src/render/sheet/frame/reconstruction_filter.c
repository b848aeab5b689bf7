/* The weights of reconstruction filters (reconstruction_filter.h). */
#include "render/sheet/frame/reconstruction_filter.h"

#include <math.h>
#include <string.h>

/* Four taps: w_i(t) = sum of factors[i][d] t^d. */
static const double catmull_rom[4][4] = {
    {0, -0.5, 1, -0.5}, {1, 0, -2.5, 1.5}, {0, 0.5, 2, -1.5}, {0, 0, -0.5, 0.5}};
static const double b_spline[4][4] = {{1 / 6.0, -0.5, 0.5, -1 / 6.0},
                                      {4 / 6.0, 0, -1, 0.5},
                                      {1 / 6.0, 0.5, 0.5, -0.5},
                                      {0, 0, 0, 1 / 6.0}};
static const double prefilter[5] = {1 / 24.0, -1 / 3.0, 19 / 12.0, -1 / 3.0, 1 / 24.0};

/* The cubic filter, each of whose taps sees samples through `filter`. */
static void set_cubic(cvol_reconstruction_filter *out, const double cubic[4][4],
                      const double *filter, int length)
{
    out->reach = 1 + length / 2;
    out->degree = 3;
    out->overshoot = 1;
    for (int i = 0; i < 3 + length; i++)
        for (int d = 0; d < 4; d++) {
            double sum = 0;
            for (int k = 0; k < length; k++)
                if (i - k >= 0 && i - k < 4)
                    sum += filter[k] * cubic[i - k][d];
            out->factors[i][d] = (float)sum;
        }
}

/* Fits polynomials through weights[i][n] at t = places[n], by Newton's differences. */
static void fit_weights(cvol_reconstruction_filter *out, double weights[][CVOL_FILTER_DEGREE + 1],
                        const double *places, int taps)
{
    enum { COUNT = CVOL_FILTER_DEGREE + 1 };
    for (int i = 0; i < taps; i++) {
        double *w = weights[i], sum[COUNT] = {0};
        for (int order = 1; order < COUNT; order++)
            for (int n = COUNT - 1; n >= order; n--)
                w[n] = (w[n] - w[n - 1]) / (places[n] - places[n - order]);
        for (int n = COUNT - 1; n >= 0; n--) { /* sum = sum (t - places[n]) + w[n] */
            for (int d = COUNT - 1; d >= 0; d--)
                sum[d] = (d ? sum[d - 1] : w[n]) - places[n] * sum[d];
        }
        for (int d = 0; d < COUNT; d++)
            out->factors[i][d] = (float)sum[d];
    }
}

static void set_gaussian(cvol_reconstruction_filter *out, double sigma)
{
    enum { TAPS = 6, COUNT = CVOL_FILTER_DEGREE + 1 };
    const double pi = 3.14159265358979323846;
    double places[COUNT], weights[TAPS][COUNT];
    out->reach = TAPS / 2 - 1;
    out->degree = CVOL_FILTER_DEGREE;
    for (int n = 0; n < COUNT; n++) {
        double sum = 0;
        places[n] = 0.5 - 0.5 * cos(pi * (n + 0.5) / COUNT);
        for (int i = 0; i < TAPS; i++) {
            const double q = (i - out->reach - places[n]) / sigma;
            sum += weights[i][n] = exp(-0.5 * q * q);
        }
        for (int i = 0; i < TAPS; i++)
            weights[i][n] /= sum;
    }
    fit_weights(out, weights, places, TAPS);
}

void cvol_reconstruction_filter_make(cvol_reconstruction_filter *out,
                                     const cvol_sheet_options *options)
{
    static const double none[1] = {1};
    memset(out, 0, sizeof *out);
    if (options->footprint == CVOL_SHEET_CATMULL_ROM)
        set_cubic(out, catmull_rom, none, 1);
    else if (options->footprint == CVOL_SHEET_B_SPLINE)
        set_cubic(out, b_spline, prefilter, 5);
    else if (options->footprint == CVOL_SHEET_GAUSSIAN)
        set_gaussian(out, options->sigma > 0 ? options->sigma : CVOL_FILTER_SIGMA);
}
