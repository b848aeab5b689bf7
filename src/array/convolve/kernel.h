/* Small filters: their response, their norms, and checks. */
#ifndef CVOL_ARRAY_CONVOLVE_KERNEL_H
#define CVOL_ARRAY_CONVOLVE_KERNEL_H

#include "array/core/array.h"

/* H(omega) = sum_i g[i] exp(-i omega i): the real value of a symmetric line, or the imaginary part
 * of an antisymmetric one (whose real part is 0). */
double cvol_kernel_response(const cvol_kernel_line *line, double omega);
/* Bounds of max |H| over all frequencies (*norm) and of sum |h| (*sum); certified, by interval
 * arithmetic over the parts and axes. */
void cvol_kernel_bounds(const cvol_kernel *kernel, double *norm, double *sum);
/* The sum of all taps: the response to a constant 1. */
double cvol_kernel_total(const cvol_kernel *kernel);
/* The L2 norm of all taps: the response to white noise of deviation 1. */
double cvol_kernel_noise_gain(const cvol_kernel *kernel);
/* The largest change of a sample at one end of the kernel's reach along an axis, for values that
 * change by 1 there. */
double cvol_kernel_outermost(const cvol_kernel *kernel);
/* Checks radii, parts, finite taps, antisymmetric taps[0] = 0. ARGUMENT. */
int cvol_kernel_check(cvol_context *context, const cvol_kernel *kernel);
/* The largest radius along an axis. */
int cvol_kernel_radius(const cvol_kernel *kernel, int axis);

#endif
