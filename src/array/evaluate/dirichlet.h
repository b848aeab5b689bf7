/* The range that band-limited interpolation may reach beyond the samples. */
#ifndef CVOL_ARRAY_EVALUATE_DIRICHLET_H
#define CVOL_ARRAY_EVALUATE_DIRICHLET_H

#include <stddef.h>

/* Bounds sum_j |h(j + offset)|, 0 <= j < n, of the n-periodic
 *     h(t) = 1/n (sum of exp(2 pi i u t / n) over the `count` (odd) lowest frequencies
 *                 + weight cos(2 pi edge t / n)),
 * the kernel that interpolates (and low-passes) samples of period n at places `offset` between
 * them. weight and edge belong to a Nyquist frequency. */
double cvol_dirichlet_sum(size_t n, size_t count, double offset, double weight, double edge);

#endif
