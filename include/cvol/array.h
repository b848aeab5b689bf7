/* cvol/array.h - compressed arrays: coefficients of a transform; making and evaluating them.
 * cvol/algebra.h computes on them.
 *
 * An array of rank 1, 2 or 3 stands for dims[0] x dims[1] x dims[2] real samples a[x, y, z], x
 * fastest; dims beyond the rank are 1. It keeps some coefficients of an orthonormal transform of
 * the samples. By Parseval's theorem, an L2 error of coefficients equals the L2 error of samples.
 * With N = nx ny nz:
 *
 *     DCT   A[u, v, w] = sum a[x, y, z] D_u(x) D_v(y) D_w(z),
 *           D_u(x) = c(u) cos(pi u (x + 1/2) / n),   c(0) = sqrt(1/n), c(u) = sqrt(2/n)
 *     DHT   A[u, v, w] = N^-1/2 sum a[x, y, z] cas(t),       cas t = cos t + sin t
 *     DFT   A[u, v, w] = N^-1/2 sum a[x, y, z] exp(-i t),    t = 2 pi (ux/nx + vy/ny + wz/nz)
 *
 * Samples are real, so the DFT keeps each conjugate pair once, as two real terms. Frequencies of
 * DFT and DHT are signed: u and u - n are the same.
 *
 * The transform is over the whole array (block 0), or over blocks of B samples along each axis
 * (block 8, 16 or 32). Block (i, j, l) has samples B i .. B i + B - 1, and so on. The last block of
 * an axis may reach beyond the array, where the last sample is repeated.
 *
 * A term is one stored real number: a coefficient, or the real or imaginary part of one. A whole
 * array stores a low box, k per axis (DCT: frequency < k; DFT and DHT: |frequency| < k), and s
 * other terms with their positions. rho = (k^rank + 2 s) / N counts a position like a number. */
#ifndef CVOL_ARRAY_H
#define CVOL_ARRAY_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A compressed array. Only functions that say so change it; otherwise threads may share it. */
typedef struct cvol_array cvol_array;

/* Transforms. Their numbers are part of the file format. */
typedef enum cvol_transform { CVOL_DCT = 1, CVOL_DHT = 2, CVOL_DFT = 3 } cvol_transform;

/* "dct", "dht", "dft"; NULL for an invalid transform. */
CVOL_API const char *cvol_transform_name(cvol_transform transform);
/* The transform with this name, or 0. */
CVOL_API cvol_transform cvol_transform_from_name(const char *name);

/* ---- truncation --------------------------------------------------------------------------- */

/* Rules that choose the terms to keep. */
typedef enum cvol_keep_rule {
    CVOL_KEEP_LIKE_INPUTS = 0, /* operations only: as coarse as the operands allow */
    CVOL_KEEP_ALL,             /* all nonzero terms */
    CVOL_KEEP_TERMS,           /* the low box `low` and the `sparse` largest others */
    CVOL_KEEP_RHO,             /* (low box + 2 s) / N at most `value` */
    CVOL_KEEP_RATIO,           /* 4 N / resident bytes at least `value` */
    CVOL_KEEP_PSNR,            /* the dropped terms lower the PSNR to no less than `value` dB */
    CVOL_KEEP_L2,              /* the L2 norm of the dropped terms is at most `value` */
    CVOL_KEEP_THRESHOLD,       /* terms with a magnitude of at least `value` */
    CVOL_KEEP_STEP, /* blocks only: terms quantized to multiples of `value`, like the codec */
    CVOL_KEEP_LOSS  /* blocks only: the same, with the coarsest step whose loss (of all samples, L2)
                       is at most `value`, up to 28 bits below the largest possible term */
} cvol_keep_rule;

/* Terms to keep. All rules but ALL and LIKE_INPUTS keep the low box `low` (whole arrays store it
 * without positions; in blocks it is the low box of every block) and choose the others by
 * magnitude. */
typedef struct cvol_keep {
    cvol_keep_rule rule;
    size_t low[3]; /* k per axis. All 0: no low box with TERMS, THRESHOLD, STEP and LOSS; with the
                      other rules a whole array chooses the k that drops least */
    uint64_t sparse;
    double value;
} cvol_keep;

/* Make a rule with its parameter, and no low box of their own. */
CVOL_API cvol_keep cvol_keep_like_inputs(void);
CVOL_API cvol_keep cvol_keep_all(void);
CVOL_API cvol_keep cvol_keep_terms(size_t k, uint64_t s);
CVOL_API cvol_keep cvol_keep_rho(double rho);
CVOL_API cvol_keep cvol_keep_ratio(double ratio);
CVOL_API cvol_keep cvol_keep_psnr(double psnr_db);
CVOL_API cvol_keep cvol_keep_l2(double l2_error);
CVOL_API cvol_keep cvol_keep_threshold(double magnitude);
CVOL_API cvol_keep cvol_keep_step(double step);
CVOL_API cvol_keep cvol_keep_loss(double l2_error);

/* ---- making -------------------------------------------------------------------------------- */

/* Compresses samples (described by `grid`, x fastest) by truncation: transforms them and keeps some
 * terms. For files of volumes see cvol_compress in cvol/codec.h, which searches the step by coded
 * size. rank: 1, 2 or 3; dims beyond it must be 1. block: 0, 8, 16 or 32. The caller frees *out.
 * Cost: O(N log N) time; 8 N bytes besides the samples. Errors: ARGUMENT (also k larger than an
 * axis or the block, s larger than the number of coefficients), DATA (NaN, infinity, or squares
 * overflow), LIMIT (a whole array of 2^32 samples or more), TARGET (a PSNR beyond single
 * precision), MEMORY, CANCELLED. */
CVOL_API int cvol_array_compress(cvol_context *context, cvol_array **out, const void *samples,
                                 const cvol_grid *grid, int rank, cvol_transform transform,
                                 int block, const cvol_keep *keep);

/* Frees an array; NULL is allowed. */
CVOL_API void cvol_array_free(cvol_array *array);

/* ---- describing ---------------------------------------------------------------------------- */

/* Shape, sample type and geometry of the samples. The array owns it. */
CVOL_API const cvol_grid *cvol_array_grid(const cvol_array *array);

/* Properties of an array. */
typedef struct cvol_array_info {
    int rank;
    cvol_transform transform;
    int block;                   /* B; 0: whole */
    size_t blocks[3];            /* blocks along each axis; 1 each for a whole array */
    size_t low[3];               /* k of the low box of a whole array; 0: no low box */
    double step;                 /* quantizer step, in units of the samples; 0: not quantized */
    uint64_t coefficients;       /* number of terms */
    double rho;                  /* whole: (k^rank + 2 s) / N; blocks: terms / N */
    uint64_t resident_bytes;     /* memory of this array */
    double value_min, value_max; /* bounds of the exact samples */
    double l2_error;    /* upper bound of the L2 norm of (exact - evaluated) samples; see below */
    double point_error; /* upper bound of |exact - evaluated| at every sample, before clamping */
    double max_abs;     /* upper bound of |evaluated sample|, before clamping */
    int measured;       /* 1: compression measured the next two; 0: they */
                        /* follow from l2_error and point_error: at least, at most */
    double psnr_db;     /* dB; infinity: exact */
    double max_error;   /* largest |original - decoded| */
    uint64_t background_samples; /* number of samples in the separately stored background
                                    (cvol/codec.h); 0: there is none */
    double background;           /* their value */
    size_t brick[3]; /* samples along each axis of the bricks of its file (cvol/codec.h); 0: not a
                        volume in DCT blocks */
    uint64_t missing_samples; /* number of samples without a value, which have no error: psnr_db is
                                 of the others */
} cvol_array_info;
/* Copies the properties of an array to *out. Cost: O(1); it evaluates nothing. */
CVOL_API void cvol_array_get_info(cvol_array_info *out, const cvol_array *array);

/* Sets the sample type of an array, for example of the float32 result of an operation. Terms do not
 * change. The bound grows if a separate background is rounded; psnr_db and max_error are no longer
 * measured, and include rounding to integers. Errors: ARGUMENT (invalid type), DATA (value_min ..
 * value_max do not fit; the message names a type that fits). */
CVOL_API int cvol_array_set_type(cvol_context *context, cvol_array *array, cvol_type type);

/* Sets the attributes: a JSON text (UTF-8, at most 16 MiB), which files store byte for byte.
 * Results of operations have none. The array keeps a copy; NULL: none. Errors: ARGUMENT (not JSON:
 * line and column), LIMIT, MEMORY. */
CVOL_API int cvol_array_set_attributes(cvol_context *context, cvol_array *array, const char *json);
/* The attributes, or NULL. The array owns them. */
CVOL_API const char *cvol_array_attributes(const cvol_array *array);

/* ---- the certified bound --------------------------------------------------------------------
 *
 * Every operation updates l2_error and point_error. l2_error bounds the L2 distance, over all
 * samples, between the evaluated array and the exact result of the same operations on the original
 * samples:
 *
 *     compress    norm of the dropped terms (Parseval), and quantization
 *     add         |alpha| e_a + |beta| e_b                 + dropped
 *     convolve    max|H| e_a                               + dropped
 *     multiply    min(max|a| e_b + max|b~| e_a, max|a~| e_b + max|b| e_a)   + dropped
 *
 * where a is exact and a~ evaluated. point_error, here p, bounds the difference at every sample,
 * and is never larger than l2_error:
 *
 *     compress    the largest error, if it is measured; otherwise d
 *     add         |alpha| p_a + |beta| p_b                                  + d
 *     kernel      sum|taps| p_a                                             + d
 *     gradient    sqrt(sum 1 / spacing^2) p_a                               + d
 *     multiply    min(max|a| p_b + max|b~| p_a, max|a~| p_b + max|b| p_a)   + d
 *     convolve    |a~|_2 e_b + |b~|_2 e_a + e_a e_b                         + d
 *
 * where d bounds what any sample lost by truncation: the most that one block lost, or, of volumes
 * truncated by default, one sample; in whole arrays the L2 norm of the dropped terms.
 * Rounding of single precision is included. value_min and value_max bound the exact samples in the
 * same way, by interval arithmetic. */

/* ---- evaluating ------------------------------------------------------------------------------ */

/* Evaluates the box of samples [begin, end) (x, y, z) into `out`, x fastest, in the type of the
 * grid: integers are rounded to nearest and clamped to value_min .. value_max. Same bits for any
 * number of threads and any processor (blocks of rank 3 under DCT). Cost: the inverse transforms of
 * the blocks that touch the box; for a whole array the cheaper of one transform of all N samples
 * and sums over the box axis by axis. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_box(cvol_context *context, void *out, const cvol_array *array,
                                     const size_t begin[3], const size_t end[3]);

/* Finds the samples of the box without a value (cvol/codec.h): out[i] = 1 + the index of the fill,
 * 0 for samples with a value. Returns how many are not 0. */
CVOL_API uint64_t cvol_array_evaluate_mask(uint8_t *out, const cvol_array *array,
                                           const size_t begin[3], const size_t end[3]);

/* Evaluates the box as floats, neither rounded nor clamped; l2_error, point_error and max_abs are
 * about these. Samples without a value are their fill, as a float. Same errors as
 * cvol_array_evaluate_box. */
CVOL_API int cvol_array_evaluate_real(cvol_context *context, float *out, const cvol_array *array,
                                      const size_t begin[3], const size_t end[3]);

/* Evaluates the interpolant of a whole array at points[a] places per axis that share the span of
 * the samples: DFT and DHT at x = i n / points, DCT at x = (i + 1/2) n / points - 1/2. out: x
 * fastest. With points = dims these are the samples. The interpolant is the sum over the kept terms
 * at real x; in DFT and DHT, frequency n/2 stands for cos(pi x). Cost: O(M log M) for M points;
 * frequencies beyond the grid alias onto it, as sampling does. Errors: ARGUMENT, UNSUPPORTED
 * (blocks), LIMIT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_grid(cvol_context *context, float *out, const cvol_array *array,
                                      const size_t points[3]);

/* Evaluates a whole array at chirp points x_a = start[a] + i step[a], i < count[a], for any real
 * start and step, by the chirp z-transform (Rabiner, Schafer and Rader 1969). Cost: O((k + count)
 * log (k + count)) per line; sparse terms count as lines of their axis. Errors: ARGUMENT,
 * UNSUPPORTED (blocks), LIMIT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_evaluate_chirp(cvol_context *context, float *out, const cvol_array *array,
                                       const double start[3], const double step[3],
                                       const size_t count[3]);

/* Evaluates at scattered points: points[rank i + a] is coordinate a of point i, in samples. Whole
 * arrays: anywhere; arrays in blocks: by the interpolant of the block with the nearest sample, or
 * the fill or background of that sample if it is masked. The residual of lossless files, and of
 * those with a largest error, is left out: the bound of every sample holds, the largest error does
 * not.
 * Cost: O(terms) per point. Errors: ARGUMENT (a coordinate is NaN or infinite), MEMORY, CANCELLED.
 */
CVOL_API int cvol_array_evaluate_points(cvol_context *context, float *out, const cvol_array *array,
                                        const double *points, size_t count);

/* ---- interpolation ----------------------------------------------------------------------------
 *
 * From values to a whole array whose samples have the given grid. */

/* Makes an array from values at points[a] <= dims[a] places per axis, placed like those of
 * cvol_array_evaluate_grid. It has the frequencies that the points resolve (DFT, DHT: |u| <=
 * points/2, at points/2 the cosine alone; DCT: u < points) and passes through the values; then
 * `keep` truncates it (NULL: ALL). Exact for spectra within these frequencies. l2_error counts only
 * the truncation: points say nothing about higher frequencies. value_min and value_max are those of
 * the samples of the result. Errors: ARGUMENT, DATA, LIMIT, TARGET, MEMORY, CANCELLED. */
CVOL_API int cvol_array_interpolate_grid(cvol_context *context, cvol_array **out,
                                         const float *values, const size_t points[3],
                                         const cvol_grid *grid, int rank, cvol_transform transform,
                                         const cvol_keep *keep);

/* Rank 1, known support: fits terms at `terms` places (0 <= place < n, in any order; DFT: both
 * places of a pair) to values at `count` >= terms chirp points start + i step, in the least squares
 * sense, by conjugate gradients on the normal equations. *residual (may be NULL) is set to the norm
 * of the residual. l2_error counts rounding only. Errors: ARGUMENT, DATA, TARGET (the points do not
 * determine the terms: condition beyond single precision), LIMIT, MEMORY, CANCELLED. */
CVOL_API int cvol_array_interpolate_chirp(cvol_context *context, cvol_array **out, double *residual,
                                          const float *values, size_t count, double start,
                                          double step, const uint32_t *places, size_t terms,
                                          const cvol_grid *grid, cvol_transform transform);

/* Rank 1, unknown support: finds at most `most` terms (most <= 64) from 2 most values at samples x
 * = 0, 1, ..., by the matrix pencil method (Hua and Sarkar 1990), in double precision. DFT and DHT.
 * Both places of a pair count, even if one has no term. *residual as above. Errors: UNSUPPORTED
 * (DCT), TARGET (no `most` terms pass through the values within 1e-4 of their norm), ARGUMENT,
 * DATA, MEMORY. */
CVOL_API int cvol_array_interpolate_pencil(cvol_context *context, cvol_array **out,
                                           double *residual, const float *values, size_t most,
                                           const cvol_grid *grid, cvol_transform transform);

#ifdef __cplusplus
}
#endif
#endif
