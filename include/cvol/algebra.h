/* cvol/algebra.h - computing on compressed arrays, never on their samples.
 *
 * Operands of one operation agree in rank, dims, transform and block, or ARGUMENT says which does
 * not; spacing by 1e-5 of it at most. Results are new arrays with the first operand's
 * geometry and sample type float32; the caller frees them. Every result carries its certified bound
 * (cvol/array.h). `keep` says what of the result is kept; NULL means cvol_keep_like_inputs().
 *
 * Whole arrays under DFT and DHT are periodic, under DCT mirrored about their ends (a[-1 - x] =
 * a[x]); arrays in blocks are mirrored under every transform.
 *
 * All of them: Errors ARGUMENT, DATA (a result beyond the range of float32), MEMORY, CANCELLED.
 */
#ifndef CVOL_ALGEBRA_H
#define CVOL_ALGEBRA_H

#include "cvol/array.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether two arrays can be operands of one operation; else ARGUMENT and what differs. Every
 * operation asks for itself. */
CVOL_API int cvol_array_compatible(cvol_context *context, const cvol_array *a, const cvol_array *b);

/* The same samples without a background that is kept apart (cvol/codec.h), for operations, which
 * are on terms: plain blocks, with as many terms as make the bound grow by half. The caller frees
 * *out. Memory: the samples as floats. Cost: evaluating and transforming all of them. Errors:
 * ARGUMENT (no such background), MEMORY, CANCELLED. */
CVOL_API int cvol_array_flatten(cvol_context *context, cvol_array **out, const cvol_array *array);

/* ---- linear --------------------------------------------------------------------------------- */

/* alpha a + beta b. Cost: O(terms). Whole arrays like their inputs keep the union of the terms. */
CVOL_API int cvol_array_add(cvol_context *context, cvol_array **out, double alpha,
                            const cvol_array *a, double beta, const cvol_array *b,
                            const cvol_keep *keep);
/* alpha a + beta, samplewise. Exact: keeps the terms of a (and the constant). O(terms). */
CVOL_API int cvol_array_scale(cvol_context *context, cvol_array **out, double alpha,
                              const cvol_array *a, double beta);
/* -a. Exact. O(terms). */
CVOL_API int cvol_array_negate(cvol_context *context, cvol_array **out, const cvol_array *a);
/* 1 - a, samplewise. Exact. O(terms). */
CVOL_API int cvol_array_one_minus(cvol_context *context, cvol_array **out, const cvol_array *a);
/* Fewer terms of the same array; the bound grows by what is dropped. O(terms). */
CVOL_API int cvol_array_truncate(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_keep *keep);
/* The same array read at x - offset (offset in samples, per axis; any real number): a phase ramp.
 * Whole arrays under DFT and DHT; others UNSUPPORTED. The Nyquist frequency of an even axis, which
 * has no phase, is multiplied by cos(pi offset). O(terms). */
CVOL_API int cvol_array_shift(cvol_context *context, cvol_array **out, const cvol_array *a,
                              const double offset[3]);
/* Half (factor -2) or twice (factor 2) as many samples along each axis, spacing to match.
 * Whole arrays: the band-limited function on the new grid (half: frequencies that it cannot hold
 * are dropped, not folded; dims must be even or 1). Blocks: half: means of 2^rank neighbours (a
 * last odd sample stands for itself); twice: linear interpolation at -1/4 and +1/4. */
CVOL_API int cvol_array_resample(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 int factor, const cvol_keep *keep);

/* ---- kernels -------------------------------------------------------------------------------- */

/* A small filter h: a sum of at most four products of one line of taps per axis,
 *     h[i, j, l] = sum_t weight[t] g[t][0][i] g[t][1][j] g[t][2][l],  |i|, |j|, |l| <= radius,
 * each line symmetric (g[-i] = g[i]) or antisymmetric (g[-i] = -g[i]), so that only g[0 .. radius]
 * is stored. (h * a)[x] = sum_i h[i] a[x - i]. */
#define CVOL_KERNEL_RADIUS 31
#define CVOL_KERNEL_PARTS 4
/* One line of taps, of radius 31 at most. */
typedef struct cvol_kernel_line {
    int radius;        /* 0: only taps[0] */
    int antisymmetric; /* then taps[0] is 0 */
    double taps[CVOL_KERNEL_RADIUS + 1];
} cvol_kernel_line;
/* A filter of at most four products. */
typedef struct cvol_kernel {
    int parts;
    double weight[CVOL_KERNEL_PARTS];
    cvol_kernel_line line[CVOL_KERNEL_PARTS][3];
} cvol_kernel;

/* Sampled Gaussian, sum 1, radius ceil(4 sigma) (at most CVOL_KERNEL_RADIUS; more: ARGUMENT). */
CVOL_API int cvol_kernel_gaussian(cvol_context *context, cvol_kernel *out, int rank, double sigma);
/* Mean over `width` samples along each axis; width odd. Errors: ARGUMENT. */
CVOL_API int cvol_kernel_box(cvol_context *context, cvol_kernel *out, int rank, int width);
/* Sum over the axes of a[x - 1] - 2 a[x] + a[x + 1]; per sample, not per
 * spacing. Errors: ARGUMENT (rank). */
CVOL_API int cvol_kernel_laplacian(cvol_context *context, cvol_kernel *out, int rank);
/* a + amount (a - gaussian(sigma) * a). Errors: ARGUMENT (a radius beyond CVOL_KERNEL_RADIUS). */
CVOL_API int cvol_kernel_unsharp(cvol_context *context, cvol_kernel *out, int rank, double sigma,
                                 double amount);
/* (a[x + 1] - a[x - 1]) / 2 along one axis; per sample. Errors: ARGUMENT (no such axis). */
CVOL_API int cvol_kernel_derivative(cvol_context *context, cvol_kernel *out, int rank, int axis);
/* One line of 2 radius + 1 taps along every axis; neither symmetric nor antisymmetric: ARGUMENT. */
CVOL_API int cvol_kernel_taps(cvol_context *context, cvol_kernel *out, int rank, const double *taps,
                              int radius);
/* "gaussian:2", "box:3", "laplacian", "unsharp:SIGMA[,AMOUNT]" (amount 1), "derivative:x".
 * Errors: ARGUMENT. */
CVOL_API int cvol_kernel_parse(cvol_context *context, cvol_kernel *out, int rank, const char *text);

/* h * a. Whole arrays: one factor H(u) a term, and an antisymmetric line under DCT by way of all
 * samples of its axis (the result's symmetry is another). Blocks: exact across block faces; the
 * kernel must reach no further than one block to each side (radius <= block), or ARGUMENT.
 * O(terms); blocks O(N). */
CVOL_API int cvol_array_convolve_kernel(cvol_context *context, cvol_array **out,
                                        const cvol_array *a, const cvol_kernel *kernel,
                                        const cvol_keep *keep);

/* (a * b)[x] = sum_i a[i] b[x - i], circular. Whole arrays under DFT and DHT; under DCT the result
 * has another symmetry: UNSUPPORTED names the transforms to use. For a linear convolution both are
 * compressed with zeros up to twice the length (cvol_array_compress_padded). O(terms). */
CVOL_API int cvol_array_convolve(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_array *b, const cvol_keep *keep);
/* As cvol_array_compress, of the samples followed by as many zeros along each axis of the rank: the
 * result's dims are 2 dims. Whole arrays. */
CVOL_API int cvol_array_compress_padded(cvol_context *context, cvol_array **out,
                                        const void *samples, const cvol_grid *grid, int rank,
                                        cvol_transform transform, const cvol_keep *keep);

/* Length of the gradient by central differences, per unit of spacing: sqrt(sum_a (da/dx_a)^2).
 * Blocks, and whole arrays by way of all samples. */
CVOL_API int cvol_array_gradient(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_keep *keep);

/* ---- multiply ---------------------------------------------------------------------------------
 */

/* How a product is computed. */
typedef enum cvol_plan {
    CVOL_PLAN_AUTO = 0, /* the cheapest by the cost model */
    CVOL_PLAN_DIRECT,   /* term by term: O(n_a n_b) */
    CVOL_PLAN_GRID,     /* evaluate on the smallest grid without aliases: O(M log M) */
    CVOL_PLAN_FULL,     /* evaluate all N samples: O(N log N) */
    CVOL_PLAN_SPARSE,   /* output-sensitive, DFT and DHT: O(n' log n'), verified */
    CVOL_PLAN_BLOCKS    /* arrays in blocks: block by block */
} cvol_plan;
/* "direct", ...; static storage. */
CVOL_API const char *cvol_plan_name(cvol_plan plan);

/* What was considered and done. Costs are the model's, in milliseconds on one thread of the machine
 * that it was calibrated on; infinity where a plan does not apply. */
typedef struct cvol_multiply_report {
    cvol_plan plan;                       /* that gave the result */
    double cost_ms[CVOL_PLAN_BLOCKS + 1]; /* by plan */
    size_t points[3];                     /* evaluated per axis: grid and full */
    uint64_t terms_a, terms_b, terms_out;
    int sparse_failed; /* the sparse plan was tried, and not verified or not cheaper */
    char reason[160];  /* one sentence: why this plan */
} cvol_multiply_report;

/* a b, samplewise. A plan asked for that does not apply: UNSUPPORTED, except SPARSE, which falls
 * back to an exact plan when its result is not verified. report may be NULL. Like its inputs a
 * whole array keeps as many terms as the larger operand, in the larger low box. */
CVOL_API int cvol_array_multiply(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_array *b, const cvol_keep *keep, cvol_plan plan,
                                 cvol_multiply_report *report);

/* ---- statistics, without evaluation (but of lapped volumes) ------------------------------------
 */

/* Of the samples as the array stands for them; *_error bounds how far that is from the exact. */
typedef struct cvol_array_statistics {
    double sum, mean, variance, standard_deviation, l2_norm;
    double sum_error, mean_error, standard_deviation_error, l2_norm_error;
} cvol_array_statistics;
/* Statistics of all N samples, from coefficients by Parseval: O(terms); of lapped volumes O(N). */
CVOL_API int cvol_array_statistics_of(cvol_context *context, cvol_array_statistics *out,
                                      const cvol_array *a);

/* Two arrays beside each other; *_error as above. */
typedef struct cvol_array_comparison {
    double inner_product;     /* sum a b */
    double cosine_similarity; /* that / (|a| |b|) */
    double distance;          /* |a - b| */
    double inner_product_error, distance_error;
} cvol_array_comparison;
/* Compares two arrays that agree. Cost: O(terms); of lapped volumes O(N). */
CVOL_API int cvol_array_compare(cvol_context *context, cvol_array_comparison *out,
                                const cvol_array *a, const cvol_array *b);
/* sum a b alone, for algorithms that want nothing else: no norms, no bound. Same errors. */
CVOL_API int cvol_array_inner_product(cvol_context *context, double *out, const cvol_array *a,
                                      const cvol_array *b);

#ifdef __cplusplus
}
#endif
#endif
