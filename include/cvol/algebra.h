/* cvol/algebra.h - computing on compressed arrays, never on their samples.
 *
 * Operands of one operation must have the same rank, dims, transform and block, and spacings that
 * differ by at most 1e-5 of their value; otherwise ARGUMENT names the difference. Results are new
 * arrays with the geometry of the first operand and sample type float32; the caller frees them.
 * Every result has a certified bound (cvol/array.h). `keep` truncates the result; NULL means
 * cvol_keep_like_inputs(): arrays in blocks lose at most a fifth of the bound that the operands
 * carry, and less where earlier results in a chain of operations have lost some: a whole chain adds
 * no more to the bound than its first operands carry.
 *
 * Samples without a value in an operand have none in the result. Resampling gives samples a value
 * if all samples that they are made of have one. Samples of the separate background (cvol/codec.h)
 * of both operands, or of an operand that is scaled or truncated, are background of the result; so
 * is a background of 0 of one factor of a product. The gradient, and a kernel, make background of
 * samples for which they read only background; a kernel only if the edge of the background stays
 * sharper than a step of quantization. Other results have no separate background.
 *
 * Whole arrays under DFT and DHT are periodic, under DCT mirrored at their ends (a[-1 - x] = a[x]).
 * Arrays in blocks are mirrored under every transform.
 *
 * Errors of all operations: ARGUMENT, DATA (a result beyond the range of float32), MEMORY,
 * CANCELLED. */
#ifndef CVOL_ALGEBRA_H
#define CVOL_ALGEBRA_H

#include "cvol/array.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Checks that two arrays can be operands of one operation; ARGUMENT, with the difference, if not.
 * Every operation does this itself. */
CVOL_API int cvol_array_compatible(cvol_context *context, const cvol_array *a, const cvol_array *b);

/* Makes an array of the same samples without a separately stored background (cvol/codec.h): plain
 * blocks, with so many terms that the bound grows by half. The caller frees *out.
 * Memory: all samples as floats. Cost: evaluating and transforming them. Errors: ARGUMENT (no
 * separate background), MEMORY, CANCELLED. */
CVOL_API int cvol_array_flatten(cvol_context *context, cvol_array **out, const cvol_array *array);

/* What results mean: their value_scale and value_offset are such that their values are those of the
 * same operation on the values of the operands. Operations work on stored samples, except products
 * and convolutions of two arrays of which one has an offset, and sums of arrays with different
 * scales: these work on values, and their results have scale 1 and offset 0. A constant that is
 * added counts in stored samples. */

/* ---- linear --------------------------------------------------------------------------------- */

/* alpha a + beta b. Cost: O(terms). By default a whole array keeps the union of the terms. */
CVOL_API int cvol_array_add(cvol_context *context, cvol_array **out, double alpha,
                            const cvol_array *a, double beta, const cvol_array *b,
                            const cvol_keep *keep);
/* alpha a + beta, sample by sample. Exact: keeps the terms of a, and the constant. Cost: O(terms).
 */
CVOL_API int cvol_array_scale(cvol_context *context, cvol_array **out, double alpha,
                              const cvol_array *a, double beta);
/* -a. Exact. Cost: O(terms). */
CVOL_API int cvol_array_negate(cvol_context *context, cvol_array **out, const cvol_array *a);
/* 1 - a, sample by sample. Exact. Cost: O(terms). */
CVOL_API int cvol_array_one_minus(cvol_context *context, cvol_array **out, const cvol_array *a);
/* Keeps fewer terms of an array; the bound grows by the norm of the dropped ones. Cost: O(terms).
 */
CVOL_API int cvol_array_truncate(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_keep *keep);
/* Shifts an array: the result at x is a at x - offset (in samples, per axis; any real number), by a
 * phase ramp. Whole arrays under DFT and DHT; others: UNSUPPORTED. The Nyquist frequency of an even
 * axis, which has no phase, is multiplied by cos(pi offset). Cost: O(terms). */
CVOL_API int cvol_array_shift(cvol_context *context, cvol_array **out, const cvol_array *a,
                              const double offset[3]);
/* Resamples an array to half (factor -2) or twice (factor 2) as many samples along each axis; the
 * spacing changes accordingly. Whole arrays: the band-limited function on the new grid (half:
 * frequencies beyond it are dropped, not aliased; dims must be even or 1). Blocks: half: means of
 * 2^rank neighbours (a last odd sample stays as it is); twice: linear interpolation at -1/4 and
 * +1/4. Cost: O(terms) for whole arrays, O(N) for blocks. */
CVOL_API int cvol_array_resample(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 int factor, const cvol_keep *keep);

/* ---- kernels -------------------------------------------------------------------------------- */

/* A small filter h: a sum of at most four products of one line of taps per axis,
 *
 *     h[i, j, l] = sum_t weight[t] g[t][0][i] g[t][1][j] g[t][2][l],  |i|, |j|, |l| <= radius.
 *
 * Each line is symmetric (g[-i] = g[i]) or antisymmetric (g[-i] = -g[i]), so only g[0 .. radius] is
 * stored. (h * a)[x] = sum_i h[i] a[x - i]. */
#define CVOL_KERNEL_RADIUS 31
#define CVOL_KERNEL_PARTS 4
/* One line of taps; the radius is at most 31. */
typedef struct cvol_kernel_line {
    int radius;        /* 0: only taps[0] */
    int antisymmetric; /* then taps[0] is 0 */
    double taps[CVOL_KERNEL_RADIUS + 1];
} cvol_kernel_line;
/* A filter: a sum of at most four products. */
typedef struct cvol_kernel {
    int parts;
    double weight[CVOL_KERNEL_PARTS];
    cvol_kernel_line line[CVOL_KERNEL_PARTS][3];
} cvol_kernel;

/* A sampled Gaussian with sum 1 and radius ceil(4 sigma). Errors: ARGUMENT (a radius above
 * CVOL_KERNEL_RADIUS). */
CVOL_API int cvol_kernel_gaussian(cvol_context *context, cvol_kernel *out, int rank, double sigma);
/* Mean over `width` samples along each axis; width must be odd. Errors: ARGUMENT. */
CVOL_API int cvol_kernel_box(cvol_context *context, cvol_kernel *out, int rank, int width);
/* Sum over the axes of a[x - 1] - 2 a[x] + a[x + 1], per sample, not per spacing. Errors: ARGUMENT
 * (rank). */
CVOL_API int cvol_kernel_laplacian(cvol_context *context, cvol_kernel *out, int rank);
/* a + amount (a - gaussian(sigma) * a). Errors: ARGUMENT (a radius above CVOL_KERNEL_RADIUS). */
CVOL_API int cvol_kernel_unsharp(cvol_context *context, cvol_kernel *out, int rank, double sigma,
                                 double amount);
/* (a[x + 1] - a[x - 1]) / 2 along one axis, per sample. Errors: ARGUMENT (no such axis). */
CVOL_API int cvol_kernel_derivative(cvol_context *context, cvol_kernel *out, int rank, int axis);
/* One line of 2 radius + 1 taps along every axis. Errors: ARGUMENT (neither symmetric nor
 * antisymmetric). */
CVOL_API int cvol_kernel_taps(cvol_context *context, cvol_kernel *out, int rank, const double *taps,
                              int radius);
/* "gaussian:2", "box:3", "laplacian", "unsharp:SIGMA[,AMOUNT]" (amount 1), "derivative:x".
 * Errors: ARGUMENT. */
CVOL_API int cvol_kernel_parse(cvol_context *context, cvol_kernel *out, int rank, const char *text);

/* h * a. Whole arrays: one factor H(u) per term; an antisymmetric line under DCT is computed
 * through all samples of its axis, because the result has another symmetry. Blocks: exact across
 * the faces of blocks; the radius must be at most one block, else ARGUMENT. Cost: O(terms); blocks
 * O(N). */
CVOL_API int cvol_array_convolve_kernel(cvol_context *context, cvol_array **out,
                                        const cvol_array *a, const cvol_kernel *kernel,
                                        const cvol_keep *keep);

/* (a * b)[x] = sum_i a[i] b[x - i], circular, of whole arrays under DFT and DHT. Under DCT the
 * result has another symmetry: UNSUPPORTED names the transforms to use. For a linear convolution,
 * compress both with zeros up to twice the length (cvol_array_compress_padded). Cost: O(terms). */
CVOL_API int cvol_array_convolve(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_array *b, const cvol_keep *keep);
/* Like cvol_array_compress, for the samples followed by as many zeros along each axis of the rank:
 * the dims of the result are 2 dims. Whole arrays. */
CVOL_API int cvol_array_compress_padded(cvol_context *context, cvol_array **out,
                                        const void *samples, const cvol_grid *grid, int rank,
                                        cvol_transform transform, const cvol_keep *keep);

/* Length of the gradient by central differences, per unit of spacing: sqrt(sum_a (da/dx_a)^2).
 * Blocks; whole arrays through all samples. Cost: O(N), whole arrays O(N log N). */
CVOL_API int cvol_array_gradient(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_keep *keep);

/* ---- multiply ---------------------------------------------------------------------------------
 */

/* Methods of multiplication. */
typedef enum cvol_plan {
    CVOL_PLAN_AUTO = 0, /* the cheapest by a cost model */
    CVOL_PLAN_DIRECT,   /* term by term: O(n_a n_b) */
    CVOL_PLAN_GRID,     /* evaluate on the smallest grid without aliases: O(M log M) */
    CVOL_PLAN_FULL,     /* evaluate all N samples: O(N log N) */
    CVOL_PLAN_SPARSE,   /* output-sensitive, DFT and DHT: O(n' log n'), verified */
    CVOL_PLAN_BLOCKS,   /* arrays in blocks: block by block */
    CVOL_PLAN_LOW       /* leaves out high frequencies of the operands, within the bound that `keep`
                           allows (LIKE_INPUTS, L2, PSNR), and evaluates the grid of the others */
} cvol_plan;
/* "direct", ...; static storage. */
CVOL_API const char *cvol_plan_name(cvol_plan plan);

/* Report on a multiplication. Costs are those of the model, in milliseconds on one thread of the
 * machine that it was calibrated on; infinity: the plan does not apply. */
typedef struct cvol_multiply_report {
    cvol_plan plan;                    /* the plan of the result */
    double cost_ms[CVOL_PLAN_LOW + 1]; /* by plan */
    size_t points[3];                  /* points per axis of plans grid, full, low */
    uint64_t terms_a, terms_b, terms_out;
    int sparse_failed; /* 1: the sparse plan was tried; its result failed verification, or was not
                          cheaper */
    char reason[160];  /* the reason for this plan */
    double left_out; /* plan low: bounds the L2 norm of the product of the terms left out; l2_error
                        includes it */
} cvol_multiply_report;

/* a b, sample by sample. UNSUPPORTED refuses a plan that does not apply; SPARSE falls back to an
 * exact plan if its result fails verification. report may be NULL. By default a whole array keeps
 * as many terms as the larger operand, in the larger low box, and AUTO may leave out high
 * frequencies of the operands for a fifth of the bound that they carry, and half of each one's
 * error.
 * Cost: by plan, see cvol_plan. */
CVOL_API int cvol_array_multiply(cvol_context *context, cvol_array **out, const cvol_array *a,
                                 const cvol_array *b, const cvol_keep *keep, cvol_plan plan,
                                 cvol_multiply_report *report);

/* ---- statistics --------------------------------------------------------------------------- */

/* Statistics of the samples of the array; *_error bounds the difference from the exact samples. */
typedef struct cvol_array_statistics {
    double sum, mean, variance, standard_deviation, l2_norm;
    double sum_error, mean_error, standard_deviation_error, l2_norm_error;
} cvol_array_statistics;
/* Computes the statistics from coefficients, by Parseval. Samples without a value do not count; a
 * separate background does. Cost: O(terms); lapped volumes, and those with a background or samples
 * without a value, O(N). */
CVOL_API int cvol_array_compute_statistics(cvol_context *context, cvol_array_statistics *out,
                                           const cvol_array *a);

/* Comparison of two arrays; *_error as above. */
typedef struct cvol_array_comparison {
    double inner_product;     /* sum a b */
    double cosine_similarity; /* that / (|a| |b|) */
    double distance;          /* |a - b| */
    double inner_product_error, distance_error;
} cvol_array_comparison;
/* Compares two compatible arrays, where both have a value. Cost: as above. */
CVOL_API int cvol_array_compare(cvol_context *context, cvol_array_comparison *out,
                                const cvol_array *a, const cvol_array *b);
/* Computes only sum a b, without norms and bounds. Same errors as cvol_array_compare. */
CVOL_API int cvol_array_compute_inner_product(cvol_context *context, double *out,
                                              const cvol_array *a, const cvol_array *b);

/* What is known about the original samples of a box, from the decoded ones and the array's bounds.
 * Samples without a value do not count. */
typedef struct cvol_region {
    uint64_t samples;                   /* of the box */
    uint64_t inside;                    /* decoded samples within least .. largest */
    uint64_t inside_least, inside_most; /* the number of original samples within lies between */
    double sum, mean;                   /* of the decoded samples of the box */
    double sum_error, mean_error;       /* bounds of their difference from the original ones */
} cvol_region;
/* Counts the samples of the box begin .. end - 1 that lie within least .. largest (both included;
 * infinite: no limit), and bounds the count of the original samples.
 *
 * A decoded sample at the distance d from the nearest limit is on the wrong side only if its error
 * is at least d. The squares of all errors add up to at most e^2 (the L2 bound), and no error is
 * above the measured largest one. So at most k samples inside can be outside, where k is the
 * largest number whose smallest distances have squares that add up to at most e^2; the same for
 * samples outside. Originals of an integer type have integer values, which widens the distances.
 * Sums: by Cauchy and Schwarz, sqrt(samples) e, and samples times the largest error. Cost: decodes
 * the box, piece by piece. Errors: ARGUMENT (box, least above largest, NaN), MEMORY, CANCELLED. */
CVOL_API int cvol_array_compute_region(cvol_context *context, cvol_region *out,
                                       const cvol_array *array, const size_t begin[3],
                                       const size_t end[3], double least, double largest);

/* The shape of a region: the samples of a box, or those of them in the ellipsoid that touches its
 * faces. */
typedef enum cvol_region_shape {
    CVOL_REGION_BOX = 0,      /* all samples of the box */
    CVOL_REGION_ELLIPSOID = 1 /* those in the ellipsoid */
} cvol_region_shape;

/* Statistics of the decoded samples of a region. Samples without a value do not count. */
typedef struct cvol_region_statistics {
    uint64_t samples;                /* of the region; 0: all other figures are 0 */
    double mean, standard_deviation; /* sqrt(sum (a - mean)^2 / samples) */
    double least, largest;           /* of the samples in their type */
    double mean_error,
        standard_deviation_error;      /* bounds of the difference from the figure of the */
    double least_error, largest_error; /* original samples */
} cvol_region_statistics;
/* Computes the statistics of the samples of the box begin .. end - 1, or of those of them that lie
 * in its ellipsoid: with c = (begin + end - 1) / 2 and r = (end - begin) / 2 on each axis, those
 * with the sum of ((x - c) / r)^2 at most 1. On an axis of one sample that is an ellipse.
 *
 * With n samples, an L2 bound of e and a largest error of m, mean and standard deviation are off by
 * at most E / sqrt(n), E = min(e, sqrt(n) m), and the extremes by at most m. Exact samples of a
 * separate background make the bounds smaller. Cost: decodes the box, piece by piece. Errors:
 * ARGUMENT (box, shape), MEMORY, CANCELLED. */
CVOL_API int cvol_array_compute_region_statistics(cvol_context *context,
                                                  cvol_region_statistics *out,
                                                  const cvol_array *array, const size_t begin[3],
                                                  const size_t end[3], cvol_region_shape shape);

#ifdef __cplusplus
}
#endif
#endif
