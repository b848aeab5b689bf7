/* cvol/array.h - compressed transform-domain arrays: what they are, making and evaluating them.
 * What is computed on them is in cvol/algebra.h.
 *
 * An array of rank 1, 2 or 3 stands for dims[0] x dims[1] x dims[2] real samples a[x, y, z], x
 * fastest; dims beyond the rank are 1. It keeps some coefficients of an orthonormal transform of
 * the samples, so that Parseval holds and an L2 error of coefficients is one of samples:
 *
 *     DCT   A[u, v, w] = sum a[x, y, z] D_u(x) D_v(y) D_w(z),
 *           D_u(x) = c(u) cos(pi u (x + 1/2) / n),   c(0) = sqrt(1/n), c(u) = sqrt(2/n)
 *     DHT   A[u, v, w] = N^-1/2 sum a[x, y, z] cas(t),       cas t = cos t + sin t
 *     DFT   A[u, v, w] = N^-1/2 sum a[x, y, z] exp(-i t),    t = 2 pi (ux/nx + vy/ny + wz/nz)
 *
 * with N = nx ny nz. Samples are real, so a DFT keeps each conjugate pair once, as two real terms.
 * In a DFT or DHT frequencies are signed: u and u - n are the same one.
 *
 * The transform is of the whole array (block 0), or of cells of B samples along each of its axes
 * (block 8, 16 or 32): cell (i, j, l) covers samples B i .. B i + B - 1 and so on, the last one of
 * an axis reaching beyond the array, where the last sample is repeated.
 *
 * A term is one kept real number: a coefficient, or the real or the imaginary part of one. A whole
 * array keeps a low box, k per axis (DCT: frequency < k; DFT and DHT: |frequency| < k), and s
 * others with their places. rho = (k^rank + 2 s) / N counts a place like a number.
 */
#ifndef CVOL_ARRAY_H
#define CVOL_ARRAY_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A compressed array. Nothing changes it but the functions that say so, so that threads may share
 * it. */
typedef struct cvol_array cvol_array;

/* The transforms. Their numbers are part of the file format. */
typedef enum cvol_transform { CVOL_DCT = 1, CVOL_DHT = 2, CVOL_DFT = 3 } cvol_transform;

/* "dct", "dht", "dft"; NULL for a number that is none. */
CVOL_API const char *cvol_transform_name(cvol_transform transform);
/* The transform of this name, or 0. */
CVOL_API cvol_transform cvol_transform_from_name(const char *name);

/* ---- what is kept ------------------------------------------------------------------------- */

/* How the terms that are kept are chosen. */
typedef enum cvol_keep_rule {
    CVOL_KEEP_LIKE_INPUTS = 0, /* operations only: as coarse as the coarsest input */
    CVOL_KEEP_ALL,             /* every term that is not zero */
    CVOL_KEEP_TERMS,           /* the low box `low` and the `sparse` largest others */
    CVOL_KEEP_RHO,             /* (low box + 2 s) / N at most `value` */
    CVOL_KEEP_RATIO,           /* 4 N / resident bytes at least `value` */
    CVOL_KEEP_PSNR,            /* what is dropped costs no more than `value` dB allow */
    CVOL_KEEP_L2,              /* the L2 norm of what is dropped is at most `value` */
    CVOL_KEEP_THRESHOLD,       /* terms of at least this magnitude */
    CVOL_KEEP_STEP             /* blocks only: multiples of `value`, as the codec keeps them */
} cvol_keep_rule;

/* Which terms are kept. In all rules but ALL and LIKE_INPUTS the low box `low` is kept in any case
 * (whole arrays: stored without places; blocks: of every block), and the rest by magnitude. */
typedef struct cvol_keep {
    cvol_keep_rule rule;
    size_t low[3]; /* k per axis; all 0: none with TERMS, THRESHOLD and STEP; with the other rules
                    * a whole array chooses the k that drops least */
    uint64_t sparse;
    double value;
} cvol_keep;

/* One of these rules, with its number; the low box is left to it. */
CVOL_API cvol_keep cvol_keep_like_inputs(void);
CVOL_API cvol_keep cvol_keep_all(void);
CVOL_API cvol_keep cvol_keep_terms(size_t k, uint64_t s);
CVOL_API cvol_keep cvol_keep_rho(double rho);
CVOL_API cvol_keep cvol_keep_ratio(double ratio);
CVOL_API cvol_keep cvol_keep_psnr(double psnr_db);
CVOL_API cvol_keep cvol_keep_l2(double l2_error);
CVOL_API cvol_keep cvol_keep_threshold(double magnitude);
CVOL_API cvol_keep cvol_keep_step(double step);

/* ---- making -------------------------------------------------------------------------------- */

/* Compresses samples (described by `grid`, x fastest) by truncation: transform, keep. For volume
 * files see cvol_compress in cvol/codec.h, which also searches the step by coded size.
 * rank 1, 2 or 3; dims beyond it must be 1. block 0, 8, 16 or 32. The caller frees *out.
 * Cost: O(N log N) time, 8 N bytes besides the samples.
 * Errors: ARGUMENT (also k larger than an axis, s larger than N), DATA (NaN, infinity, or so large
 * that squares overflow), LIMIT (a whole array of 2^32 samples or more), TARGET (a PSNR that single
 * precision cannot hold), MEMORY, CANCELLED. */
CVOL_API int cvol_array_compress(cvol_context *context, cvol_array **out, const void *samples,
                                 const cvol_grid *grid, int rank, cvol_transform transform,
                                 int block, const cvol_keep *keep);

/* Frees an array; NULL is allowed. */
CVOL_API void cvol_array_free(cvol_array *array);

/* ---- describing ---------------------------------------------------------------------------- */

/* Shape, sample type and geometry of what the array stands for. Owned by the array. */
CVOL_API const cvol_grid *cvol_array_grid(const cvol_array *array);

/* What is kept, and what is known of it. */
typedef struct cvol_array_info {
    int rank;
    cvol_transform transform;
    int block;                   /* B; 0: whole */
    size_t blocks[3];            /* blocks along each axis; 1 each for a whole array */
    size_t low[3];               /* k of a whole array's low box; 0 if there is none */
    double step;                 /* quantizer step, in units of the samples; 0: not quantized */
    uint64_t coefficients;       /* terms kept */
    double rho;                  /* whole: (k^rank + 2 s) / N; blocks: terms / N */
    uint64_t resident_bytes;     /* memory this array holds */
    double value_min, value_max; /* bounds of the samples of the exact result */
    double l2_error;             /* bounds the L2 norm of (exact - evaluated) samples; see below */
    double max_abs;              /* bounds |evaluated sample|, before any clamping */
    int measured;                /* 1: the next two were measured when compressing; else they */
                                 /* follow from l2_error: at least, at most */
    double psnr_db;              /* infinity: exact */
    double max_error;            /* largest |original - decoded| */
    uint64_t background_samples; /* samples of the background that is kept apart (cvol/codec.h), if
                                    one is */
    double background;           /* their value */
    size_t brick[3];             /* samples along each axis of the bricks that its file is read in
                                    (cvol/codec.h); 0 of what is no volume in DCT blocks */
} cvol_array_info;
/* Fills in all of it. Cost: none; nothing is evaluated. */
CVOL_API void cvol_array_get_info(const cvol_array *array, cvol_array_info *out);

/* Makes the samples that the array evaluates to ones of another type: those of an operation's
 * result, say, which are float32. Terms and bound stay; psnr_db and max_error, if not measured,
 * count rounding to integers. Errors: ARGUMENT (no type), DATA (value_min .. value_max do not fit:
 * which type they would). */
CVOL_API int cvol_array_set_type(cvol_context *context, cvol_array *array, cvol_type type);

/* Attributes: a JSON text (UTF-8, at most 16 MiB) about the volume, which files keep byte for byte.
 * Results of operations have none. The array keeps a copy; NULL: none. Errors: ARGUMENT (no JSON:
 * line and column), LIMIT, MEMORY. */
CVOL_API int cvol_array_set_attributes(cvol_context *context, cvol_array *array, const char *json);
/* Owned by the array; NULL if there are none. */
CVOL_API const char *cvol_array_attributes(const cvol_array *array);

/* ---- the certified bound --------------------------------------------------------------------
 *
 * l2_error is carried through every operation: it bounds the L2 distance, over all samples, between
 * what the array stands for and the exact result of the same operations on the original samples.
 *
 *     compress    the energy dropped (Parseval), and quantization
 *     add         |alpha| e_a + |beta| e_b                 + dropped
 *     convolve    max|H| e_a                               + dropped
 *     multiply    min(max|a| e_b + max|b~| e_a, max|a~| e_b + max|b| e_a)   + dropped
 *
 * a is exact, a~ what the array evaluates to. Rounding of single precision is included.
 * value_min .. value_max likewise bounds the exact samples (by interval arithmetic). */

/* ---- evaluating ------------------------------------------------------------------------------ */

/* Evaluates the box of samples [begin, end) (x, y, z) into `out`, which holds the box x
 * fastest in the grid's own type: integers rounded to nearest and clamped to value_min ..
 * value_max. Bit-identical for any thread count and processor (blocks of rank 3 under DCT).
 * Cost: the inverse transform of the blocks that the box touches; for a whole array whichever is
 * less of one transform of all N samples and axis by axis sums over the box. Errors: ARGUMENT,
 * MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_box(cvol_context *context, void *out, const cvol_array *array,
                                     const size_t begin[3], const size_t end[3]);

/* Which samples of the box have no value (those that evaluate to a fill, cvol/codec.h): out[i] = 1
 * + the number of the fill, 0 for samples that have one. Returns how many are not 0. */
CVOL_API uint64_t cvol_array_evaluate_mask(uint8_t *out, const cvol_array *array,
                                           const size_t begin[3], const size_t end[3]);

/* The same as floats, neither rounded nor clamped: what l2_error and max_abs are about. The
 * same errors. */
CVOL_API int cvol_array_evaluate_real(cvol_context *context, float *out, const cvol_array *array,
                                      const size_t begin[3], const size_t end[3]);

/* Evaluates the array's interpolant on points[a] places per axis that share the samples' span: DFT
 * and DHT at x = i n / points, DCT at x = (i + 1/2) n / points - 1/2. out: x fastest. Whole arrays
 * only (blocks: UNSUPPORTED). With points = dims these are the samples. The interpolant is the sum
 * over the kept terms at real x; in a DFT or DHT frequency n/2 stands for cos(pi x).
 * Cost: O(M log M) for M points; frequencies that the grid cannot hold fold (alias) onto it,
 * exactly as sampling does. Errors: ARGUMENT, UNSUPPORTED, LIMIT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_grid(cvol_context *context, float *out, const cvol_array *array,
                                      const size_t points[3]);

/* Evaluates at chirp points x_a = start[a] + i step[a], i < count[a], any real start and step, by
 * the chirp z-transform (Rabiner, Schafer and Rader 1969). Whole arrays only.
 * Cost: O((k + count) log (k + count)) a line; sparse terms count as lines of their axis.
 * Errors: ARGUMENT, UNSUPPORTED (blocks), LIMIT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_chirp(cvol_context *context, float *out, const cvol_array *array,
                                       const double start[3], const double step[3],
                                       const size_t count[3]);

/* Evaluates at scattered points: points[rank i + a] is coordinate a of point i, in samples; whole
 * arrays anywhere, blocks by the interpolant of the block that holds the nearest sample.
 * Cost: O(terms) a point. Errors: ARGUMENT (a coordinate is NaN or infinite), MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_points(cvol_context *context, float *out, const cvol_array *array,
                                        const double *points, size_t count);

/* ---- interpolating: the way back --------------------------------------------------------------
 *
 * From values to a whole array whose samples would be `grid`'s. */

/* From values on points[a] <= dims[a] places per axis as cvol_array_evaluate_grid gives them: the
 * array with the frequencies that the points resolve (DFT, DHT: |u| <= points/2, at points/2 the
 * cosine alone; DCT: u < points), which passes through them, then truncated by `keep` (NULL: ALL).
 * Exact for spectra within. The bound says nothing about frequencies that were never there to see:
 * l2_error counts what `keep` drops. value_min and value_max are from the samples of the result.
 * Errors: ARGUMENT, DATA, LIMIT, TARGET, MEMORY, CANCELLED. */
CVOL_API int cvol_array_interpolate_grid(cvol_context *context, cvol_array **out,
                                         const float *values, const size_t points[3],
                                         const cvol_grid *grid, int rank, cvol_transform transform,
                                         const cvol_keep *keep);

/* Rank 1, the support known: the terms at the `terms` places (0 <= place < n, in any order; DFT:
 * both places of a pair) that fit values at `count` >= terms chirp points start + i step best in
 * least squares, by conjugate gradients on the normal equations; the residual's norm goes to
 * *residual (may be NULL). l2_error is that of rounding alone. Errors: ARGUMENT, DATA, TARGET when
 * the points do not determine the terms (condition beyond single precision), LIMIT, MEMORY,
 * CANCELLED. */
CVOL_API int cvol_array_interpolate_chirp(cvol_context *context, cvol_array **out, double *residual,
                                          const float *values, size_t count, double start,
                                          double step, const uint32_t *places, size_t terms,
                                          const cvol_grid *grid, cvol_transform transform);

/* Rank 1, the support unknown: at most `most` terms (most <= 64) from 2 most values at samples
 * x = 0, 1, ..., by the matrix pencil (Hua and Sarkar 1990), in double precision. DFT and DHT (DCT:
 * UNSUPPORTED). Both places of a pair count, even if one of them has no term. *residual as above.
 * TARGET when no `most` terms pass through the values within 1e-4 of their norm. */
CVOL_API int cvol_array_interpolate_pencil(cvol_context *context, cvol_array **out,
                                           double *residual, const float *values, size_t most,
                                           const cvol_grid *grid, cvol_transform transform);

#ifdef __cplusplus
}
#endif
#endif
