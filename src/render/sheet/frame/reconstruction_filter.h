/* Reconstruction filters wider than linear, for the sheet engine: a slice's samples f_k are
 * reconstructed, along lanes and then along rows, as
 *
 *     f(k + t) = sum over i of w_i(t) f_(k - reach + i),   0 <= t <= 1,  i < 2 + 2 reach,
 *
 * with polynomials w_i that sum to 1 for every t.
 *
 * Catmull-Rom (Catmull and Rom, "A class of local interpolating splines", 1974): cubic, through the
 * samples, exact on parabolas.
 *
 * B-spline: the cubic one (Unser, Aldroubi, Eden, "B-spline signal processing", 1993), over samples
 * that are prefiltered so that it passes through them. The exact prefilter needs whole rows of the
 * volume, which a layer does not have. With s = 1 - cos(omega) the spline leaves 1 - s / 3 of a
 * frequency at the samples, so the prefilter is 1 / (1 - s / 3) = 1 + s / 3 + s^2 / 9 + .... Here
 * it is
 *
 *     1 + s / 3 + s^2 / 6,   five taps: 1/24, -1/3, 19/12, -1/3, 1/24,
 *
 * which is exact on cubic polynomials, preserves frequencies up to half of the highest one to 0.9
 * %, and attenuates the highest by 22 %. Spline and prefilter together span 8 samples.
 *
 * Gaussian: exp(-q^2 / 2 sigma^2) over 6 samples, divided by its sum; it blurs. Its w_i are not
 * polynomials, but within CVOL_FILTER_ERROR of some. */
#ifndef CVOL_RENDER_SHEET_FRAME_RECONSTRUCTION_FILTER_H
#define CVOL_RENDER_SHEET_FRAME_RECONSTRUCTION_FILTER_H

#include "cvol/engines.h"

#define CVOL_FILTER_TAPS 8
#define CVOL_FILTER_DEGREE 7
#define CVOL_FILTER_REACH (CVOL_FILTER_TAPS / 2 - 1)
#define CVOL_FILTER_ERROR 5e-5
/* The default of a Gaussian. */
#define CVOL_FILTER_SIGMA (5 / 6.0)
#define CVOL_FILTER_SIGMA_MIN 0.5
#define CVOL_FILTER_SIGMA_MAX 1.0

typedef struct cvol_reconstruction_filter {
    int reach;     /* 0: linear, and the rest is ignored */
    int overshoot; /* some weights are below 0: results are clamped to the range of the 4 x 4
                      samples */
    int degree;
    float factors[CVOL_FILTER_TAPS][CVOL_FILTER_DEGREE + 1]; /* w_i(t) = sum of factors[i][d] t^d */
} cvol_reconstruction_filter;

void cvol_reconstruction_filter_make(cvol_reconstruction_filter *out,
                                     const cvol_sheet_options *options);

#endif
