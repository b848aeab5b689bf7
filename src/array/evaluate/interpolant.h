/* The function of real coordinates that a whole spectrum defines: the array between its samples.
 *
 *     a(x) = Re sum_p slot[p] g_p phi_u(x) phi_v(y) phi_w(z)
 *     DFT, DHT  phi_u(x) = exp(2 pi i u x / n) with u signed, |u| < n / 2; cos(pi x) if u = n / 2
 *     DCT       phi_u(x) = cos(pi u (x + 1/2) / n)
 *
 * g_p turns phi into the slot's basis function (transform/whole.h): N^-1/2 (1 - i) under DHT; under
 * DFT (2 / N)^1/2 for the first of a pair, -i times that for the second, N^-1/2 for a place that is
 * its own mirror; the product of the axes' c(u) under DCT. */
#ifndef CVOL_ARRAY_EVALUATE_INTERPOLANT_H
#define CVOL_ARRAY_EVALUATE_INTERPOLANT_H

#include <math.h>

#include "base/elementary.h"
#include "transform/whole.h"

#define CVOL_PI 3.14159265358979323846

/* g_p */
static inline void cvol_slot_factor(double g[2], cvol_transform transform, const size_t place[3],
                                    const size_t dims[3])
{
    const double samples = (double)dims[0] * (double)dims[1] * (double)dims[2];
    g[1] = 0;
    if (transform == CVOL_DCT) {
        g[0] = sqrt(1 / samples);
        for (int a = 0; a < 3; a++)
            if (place[a])
                g[0] *= 1.41421356237309504880;
        return;
    }
    const int order = transform == CVOL_DHT ? 0 : cvol_place_order(place, dims);
    g[0] = order < 0 ? 0 : sqrt((order ? 2 : 1) / samples);
    if (transform == CVOL_DHT)
        g[1] = -g[0];
    else if (order < 0)
        g[1] = -sqrt(2 / samples);
}

/* phi_u(x) of an axis of length n, u a place. */
static inline void cvol_axis_value(double phi[2], cvol_transform transform, size_t u, double x,
                                   size_t n)
{
    if (transform == CVOL_DCT) {
        const double turns = (double)u * ((x + 0.5) / (2 * (double)n));
        cvol_sincos(phi, 2 * CVOL_PI * (turns - rint(turns)));
        phi[1] = 0;
        return;
    }
    const double turns = (double)cvol_frequency(u, n) * (x / (double)n);
    cvol_sincos(phi, 2 * CVOL_PI * (turns - rint(turns)));
    phi[1] = 2 * u == n ? 0 : 2 * u < n ? phi[1] : -phi[1];
}

static inline void cvol_place_split(size_t place[3], size_t index, const size_t dims[3])
{
    place[0] = index % dims[0];
    place[1] = index / dims[0] % dims[1];
    place[2] = index / dims[0] / dims[1];
}

#endif
