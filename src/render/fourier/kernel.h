/* The interpolation kernel of the fourier engine, in frequency and in space. */
#ifndef CVOL_RENDER_FOURIER_KERNEL_H
#define CVOL_RENDER_FOURIER_KERNEL_H

/* Neighbours along each axis, and the degree of the kernel's polynomials. */
#define CVOL_FOURIER_TAPS 6
#define CVOL_FOURIER_DEGREE 8

/* Weight j (of the place floor(g) - 2 + j) at z = 2 (g - floor(g)) - 1 is sum_d taps[d][j] z^d. */
typedef struct cvol_fourier_kernel {
    float taps[CVOL_FOURIER_DEGREE + 1][CVOL_FOURIER_TAPS];
} cvol_fourier_kernel;

void cvol_fourier_kernel_make(cvol_fourier_kernel *out);
/* The kernel's Fourier transform at x: the factor in space at x periods if frequencies 1 apart are
 * interpolated. Positive for |x| <= 0.4. */
double cvol_fourier_kernel_gain(double x);
/* The weights themselves, for single points. */
void cvol_fourier_kernel_weigh(float weights[CVOL_FOURIER_TAPS], const cvol_fourier_kernel *kernel,
                               double fraction);

#endif
