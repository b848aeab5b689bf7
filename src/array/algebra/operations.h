/* The operations' two halves: on whole arrays (whole_*.c) and on blocks (blocks_*.c).
 *
 * The public functions (linear.c, convolve.c, multiply.c, ...) check the operands, create the
 * result with cvol_array_create_like, call one of these to fill its terms, and set its ledger from
 * what it reports. `keep` is never NULL here; LIKE_INPUTS is resolved here, as each operation sees
 * fit.
 */
#ifndef CVOL_ARRAY_ALGEBRA_OPERATIONS_H
#define CVOL_ARRAY_ALGEBRA_OPERATIONS_H

#include "array/core/array.h"
#include "array/truncate/build.h"

/* Enters what a half reports into the result's ledger: what was dropped, and the rounding of its
 * terms, of its offset, and of factors of this norm. */
void cvol_array_account(cvol_array *array, const cvol_build_result *result, double factors);
/* What transforms of this array may lose, as a share of the L2 norm: CVOL_ROUNDING, and more for
 * whole arrays whose lengths have large prime factors. */
double cvol_array_rounding(const cvol_array *array);
/* CVOL_ERROR_DATA where a result of this shape and ledger is beyond what float32 computes with. */
int cvol_array_check_ledger(cvol_context *context, const cvol_array *array,
                            const cvol_ledger *ledger, const char *operation);

/* result->dropped, ->norm, ->max_abs: see build.h; whole arrays set max_abs negative unless known.
 */

int cvol_whole_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const void *samples, const cvol_keep *keep);
int cvol_blocks_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const void *samples, const cvol_keep *keep);

int cvol_whole_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                   const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep);
int cvol_blocks_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                    const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep);

/* alpha a + beta */
int cvol_whole_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     double alpha, const cvol_array *a, double beta);
int cvol_blocks_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      double alpha, const cvol_array *a, double beta);

int cvol_whole_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep);
int cvol_blocks_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep);

int cvol_whole_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                               const cvol_array *a, const cvol_kernel *kernel,
                               const cvol_keep *keep);
int cvol_blocks_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                                const cvol_array *a, const cvol_kernel *kernel,
                                const cvol_keep *keep);

/* Array by array, circular; DFT and DHT. */
int cvol_whole_convolve(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_array *b, const cvol_keep *keep);
/* The largest |F| of a DFT's or DHT's coefficients as complex numbers: at places of which b has
 * both slots too, and at others. Errors: MEMORY. */
typedef struct cvol_largest {
    double common, alone;
} cvol_largest;
int cvol_whole_largest_coefficients(cvol_context *context, cvol_largest *out, const cvol_array *a,
                                    const cvol_array *b);

/* weight[axis]: 1 / spacing. Whole arrays: result->norm counts what rounding is a share of. */
int cvol_whole_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const double weight[3], const cvol_keep *keep);
int cvol_blocks_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const double weight[3], const cvol_keep *keep);

/* `out` has the new dims already; they say whether it is half or twice. */
int cvol_whole_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep);
int cvol_blocks_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep);

/* One plan each; they resolve nothing: the caller has chosen. */
int cvol_multiply_direct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);
/* points[axis]: those of cvol_multiply_points, or dims: the plan `full`. */
int cvol_multiply_grid(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       const cvol_array *a, const cvol_array *b, const size_t points[3],
                       const cvol_keep *keep);
/* *verified 0: nothing was made, an exact plan has to. It is not carried out if it would take more
 * than limit_ms on one thread, which is known once the supports have been looked at. */
int cvol_multiply_sparse(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                         double limit_ms, int *verified);
int cvol_blocks_multiply(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);

/* The energy of all terms but the mean's; sum a b and |a - b|: where sums as below would cancel. */
double cvol_whole_variation(const cvol_array *a);
int cvol_whole_compare(cvol_context *context, double *inner, double *distance, const cvol_array *a,
                       const cvol_array *b);
/* Sums over the samples within the array: sum a, sum a^2; sum a b. Never evaluates more than the
 * blocks that reach beyond the array. */
int cvol_whole_sums(cvol_context *context, double *sum, double *squares, const cvol_array *a);
int cvol_blocks_sums(cvol_context *context, double *sum, double *squares, const cvol_array *a);
int cvol_whole_inner(cvol_context *context, double *inner, const cvol_array *a,
                     const cvol_array *b);
int cvol_blocks_distance(cvol_context *context, double *squares, const cvol_array *a,
                         const cvol_array *b);
int cvol_blocks_inner(cvol_context *context, double *inner, const cvol_array *a,
                      const cvol_array *b);

/* Whether all of the array is in its terms. Errors: UNSUPPORTED. */
int cvol_array_need_plain(cvol_context *context, const cvol_array *array);
/* Whether a box is one. Errors: ARGUMENT. */
int cvol_array_check_box(cvol_context *context, const cvol_array *array, const size_t begin[3],
                         const size_t end[3]);
/* A box of a whole array in the grid's type; arguments checked. */
int cvol_whole_evaluate_stored(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3]);
/* Real values of a box; arguments checked. */
int cvol_whole_evaluate(cvol_context *context, float *out, const cvol_array *array,
                        const size_t begin[3], const size_t end[3]);
int cvol_blocks_evaluate(cvol_context *context, float *out, const cvol_array *array,
                         const size_t begin[3], const size_t end[3]);

/* ---- kernels (kernel.c) -----------------------------------------------------------------------
 */

/* H(omega) = sum_i g[i] exp(-i omega i): the real value of a symmetric line, or the imaginary part
 * of an antisymmetric one (whose real part is 0). */
double cvol_kernel_response(const cvol_kernel_line *line, double omega);
/* Bounds of max |H| over all frequencies (*norm) and of sum |h| (*sum); certified, by interval
 * arithmetic over the parts and axes. */
void cvol_kernel_bounds(const cvol_kernel *kernel, double *norm, double *sum);
/* The sum of all taps: what the kernel makes of a constant 1. */
double cvol_kernel_total(const cvol_kernel *kernel);
/* The L2 norm of all taps: what a filter makes of white noise of deviation 1. */
double cvol_kernel_noise_gain(const cvol_kernel *kernel);
/* Whether the kernel is one: radii, parts, finite taps, antisymmetric taps[0] = 0. ARGUMENT. */
int cvol_kernel_check(cvol_context *context, const cvol_kernel *kernel);
/* The largest radius along an axis. */
int cvol_kernel_radius(const cvol_kernel *kernel, int axis);

#endif
