/* Fast transforms of any length in single precision, unnormalised: one interface to the backend of
 * a build, our own (fft_own.h) or, with -DCVOL_FFT=fftw, FFTW 3.
 *
 * Plans are made once and cached (the last 256 of them) behind a lock; executing them needs no
 * lock. Results have the same bits in every run, and with our own backend also on every processor.
 * The transforms run on the calling thread.
 *
 *     FORWARD  H[u] = sum_x a[x] exp(-2 pi i u x / n)        real to half complex
 *     INVERSE  a[x] = sum_u H[u] exp(+2 pi i u x / n)        half complex to real
 *     DCT      A[u] = 2 sum_x a[x] cos(pi u (x + 1/2) / n)                        (REDFT10)
 *     IDCT     a[x] = A[0] + 2 sum_{u > 0} A[u] cos(pi u (x + 1/2) / n)           (REDFT01)
 *     IDST     a[x] = (-1)^x A[n-1] + 2 sum_{u < n-1} A[u] sin(pi (u+1) (x + 1/2) / n)  (RODFT01)
 *     COMPLEX_FORWARD, COMPLEX_BACKWARD   the sums above, complex to complex
 *
 * of rank 1 to 3: dims[0] fastest, axes of length 1 are skipped (a DCT has no factor 2 there). Half
 * complex arrays are halved along x: dims[0] / 2 + 1 complex numbers a row, as pairs of floats.
 */
#ifndef CVOL_TRANSFORM_FFT_H
#define CVOL_TRANSFORM_FFT_H

#include "cvol/base.h"

typedef enum cvol_fft_kind {
    CVOL_FFT_FORWARD,
    CVOL_FFT_INVERSE, /* destroys its input */
    CVOL_FFT_DCT,
    CVOL_FFT_IDCT,
    CVOL_FFT_IDST,
    CVOL_FFT_COMPLEX_FORWARD,
    CVOL_FFT_COMPLEX_BACKWARD
} cvol_fft_kind;

/* `out` may be `in` for the real and the complex to complex kinds; FORWARD and INVERSE need two
 * buffers. Both as cvol_fft_allocate gives them (64-byte aligned). Errors: MEMORY, LIMIT. */
int cvol_fft(cvol_context *context, cvol_fft_kind kind, const size_t dims[3], float *out,
             float *in);

/* `count` transforms of length n. Their elements lie `stride` elements apart, and they begin
 * `distance` elements apart; an element is a float, or a pair of floats for complex sides. Each
 * side has its own strides. Pruned transforms along one axis consist of these. */
typedef struct cvol_fft_lines {
    size_t n, count;
    size_t in_stride, in_distance, out_stride, out_distance;
} cvol_fft_lines;
int cvol_fft_along(cvol_context *context, cvol_fft_kind kind, const cvol_fft_lines *lines,
                   float *out, float *in);

/* The smallest length >= n whose only factors are 2, 3 and 5 (and 7 at most once); even if
 * `even`. */
size_t cvol_fft_good_length(size_t n, int even);

/* Floats; NULL without memory. Freed by free(). */
float *cvol_fft_allocate(size_t count);

#endif
