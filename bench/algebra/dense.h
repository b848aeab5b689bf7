/* The classical way: kept terms to dense samples by FFTW, the operation on samples, and back.
 *
 * Single precision, one thread, plans made beforehand, buffers touched. DFT: real to half complex
 * (x halved) and back, out of place. DCT: REDFT01 and REDFT10 in place. A DHT's terms are a DFT's,
 * rotated: what that costs is O(terms), so DHT is timed as DFT. Coefficients are orthonormal; the
 * scale is applied where terms are scattered and kept, or with the samples' product.
 */
#ifndef BENCH_ALGEBRA_DENSE_H
#define BENCH_ALGEBRA_DENSE_H

#include <fftw3.h>
#include <stdint.h>

#include "cvol/array.h"

/* Adjacent coefficients of the spectrum: `length` of them from `start`. */
typedef struct dense_run {
    uint32_t start, length;
} dense_run;

/* Terms kept: their values in the order of the runs (pairs of floats under DFT). */
typedef struct dense_terms {
    dense_run *runs;
    size_t run_count;
    float *values;
    size_t value_count; /* floats */
} dense_terms;

typedef struct dense {
    cvol_transform transform;
    size_t dims[3], samples, coefficients; /* coefficients: N, or half complex ones */
    int complex;                           /* floats a coefficient - 1 */
    float *spectrum, *spectrum_b, *a, *b;  /* DCT: the spectrum is `a` itself, in place */
    fftwf_plan inverse_a, inverse_b, forward, forward_b;
    double scale; /* orthonormal inverse: samples = scale FFTW(coefficients) */
} dense;

typedef enum dense_operation { DENSE_ADD, DENSE_MULTIPLY, DENSE_CONVOLVE } dense_operation;

/* planner: FFTW_ESTIMATE, ... */
void dense_start(dense *out, cvol_transform transform, const size_t dims[3], unsigned planner);
void dense_stop(dense *d);

/* The runs of a low box k, values of zero. */
void dense_low_box(dense_terms *out, const dense *d, const size_t low[3]);
/* Any runs; takes ownership of `runs`. */
void dense_terms_make(dense_terms *out, const dense *d, dense_run *runs, size_t count);
void dense_terms_free(dense_terms *terms);

/* Samples in d->a to the values of `terms` (orthonormal), and back to samples in d->a. */
void dense_analyse(dense *d, dense_terms *terms);
void dense_synthesise(dense *d, const dense_terms *terms);

/* Adds, multiplies or convolves. Keeps out's own set (runs) or, with `largest` > 0, the `largest`
 * floats of largest magnitude, pairs together: their values, and the coefficients' indices in
 * `places`. Without `largest`, places may be NULL. */
void dense_operate(dense *d, dense_terms *out, dense_operation operation, const dense_terms *a,
                   const dense_terms *b, size_t largest, uint32_t *places);

#endif
