/* The Kaiser-Bessel kernel of gridding (Jackson et al., "Selection of a convolution function for
 * Fourier inversion using gridding", 1991; Beatty et al. 2005),
 *
 *     phi(t) = I0(beta sqrt(1 - (2 t / W)^2)) / I0(beta)       |t| <= W / 2
 *     its transform at x: W / I0(beta) sinh(r) / r,  r = sqrt(beta^2 - (pi W x)^2)
 *
 * W = 6; beta = pi sqrt((W / s)^2 (s - 1/2)^2 - 0.8) for s = 3/2, the smallest padding of volumes.
 * (With W = 4 ghosts are 40 times stronger, and visible on short rays.) Within a tap phi is smooth,
 * and a polynomial through Chebyshev's points replaces it. */
#include "render/fourier/kernel.h"

#include <math.h>

#define WIDTH ((double)CVOL_FOURIER_TAPS)
#define BETA 12.248
#define TAPS_BELOW (CVOL_FOURIER_TAPS / 2 - 1)
#define POINTS (CVOL_FOURIER_DEGREE + 1)
#define PI 3.14159265358979323846

static double bessel_i0(double x)
{
    double sum = 1, term = 1;
    for (int k = 1; k < 60; k++) {
        term *= x * x / (4.0 * k * k);
        sum += term;
    }
    return sum;
}

static double kernel_at(double t)
{
    const double u = 2 * t / WIDTH, square = 1 - u * u;
    return square >= 0 ? bessel_i0(BETA * sqrt(square)) / bessel_i0(BETA) : 0;
}

double cvol_fourier_kernel_gain(double x)
{
    const double square = BETA * BETA - PI * WIDTH * x * PI * WIDTH * x, r = sqrt(fabs(square));
    const double ratio = r < 1e-6 ? 1 : (square > 0 ? sinh(r) : sin(r)) / r;
    return WIDTH / bessel_i0(BETA) * ratio;
}

/* Fits the polynomial through values[i] at nodes[i], by Newton's divided differences. */
static void fit(double coefficients[POINTS], const double nodes[POINTS],
                const double values[POINTS])
{
    double table[POINTS];
    for (int i = 0; i < POINTS; i++) {
        table[i] = values[i];
        coefficients[i] = 0;
    }
    for (int order = 1; order < POINTS; order++)
        for (int i = POINTS - 1; i >= order; i--)
            table[i] = (table[i] - table[i - 1]) / (nodes[i] - nodes[i - order]);
    for (int i = POINTS - 1; i >= 0; i--) {
        /* coefficients = coefficients (z - nodes[i]) + table[i] */
        for (int d = POINTS - 1; d > 0; d--)
            coefficients[d] = coefficients[d - 1] - nodes[i] * coefficients[d];
        coefficients[0] = table[i] - nodes[i] * coefficients[0];
    }
}

void cvol_fourier_kernel_make(cvol_fourier_kernel *out)
{
    double nodes[POINTS], values[POINTS], coefficients[POINTS];
    for (int i = 0; i < POINTS; i++)
        nodes[i] = cos(PI * (i + 0.5) / POINTS);
    for (int j = 0; j < CVOL_FOURIER_TAPS; j++) {
        for (int i = 0; i < POINTS; i++)
            values[i] = kernel_at((nodes[i] + 1) / 2 + TAPS_BELOW - j);
        fit(coefficients, nodes, values);
        for (int d = 0; d < POINTS; d++)
            out->taps[d][j] = (float)coefficients[d];
    }
}

void cvol_fourier_kernel_weigh(float weights[CVOL_FOURIER_TAPS], const cvol_fourier_kernel *kernel,
                               double fraction)
{
    const float z = (float)(2 * fraction - 1);
    for (int j = 0; j < CVOL_FOURIER_TAPS; j++) {
        float sum = kernel->taps[CVOL_FOURIER_DEGREE][j];
        for (int d = CVOL_FOURIER_DEGREE - 1; d >= 0; d--)
            sum = sum * z + kernel->taps[d][j];
        weights[j] = sum;
    }
}
