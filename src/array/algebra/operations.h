/* The two halves of the linear operations: on whole arrays (whole_*.c) and on blocks (blocks_*.c).
 *
 * A public function (linear.c, resample.c, ...) checks the operands, creates the result with
 * cvol_array_create_like, calls one of these to fill its terms, and derives the error bound from
 * the result of that call. `keep` is never NULL here. Each operation resolves LIKE_INPUTS
 * itself. */
#ifndef CVOL_ARRAY_ALGEBRA_OPERATIONS_H
#define CVOL_ARRAY_ALGEBRA_OPERATIONS_H

#include "array/truncate/account.h"
#include "array/truncate/producer.h"

/* result->dropped, ->norm, ->max_abs: see build.h. Whole arrays set max_abs negative if unknown. */

int cvol_whole_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                   const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep);
int cvol_blocks_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                    const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep);

/* What the samples of a result mean (cvol_grid.value_scale and value_offset). The result of an
 * operation means what the same operation gives for the values of the operands. */
void cvol_rescale_set(cvol_array *out, double scale, double offset);
/* 1 if both arrays have the same scale; offsets may differ. */
int cvol_rescale_is_same(const cvol_array *a, const cvol_array *b);
/* The array of the values: scale 1, offset 0. The caller frees it. Errors: as cvol_array_scale. */
int cvol_array_of_values(cvol_context *context, cvol_array **out, const cvol_array *a);

/* alpha a + beta */
int cvol_whole_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     double alpha, const cvol_array *a, double beta);
int cvol_blocks_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      double alpha, const cvol_array *a, double beta);

int cvol_whole_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep);
int cvol_blocks_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep);

/* weight[axis]: 1 / spacing. Whole arrays: rounding is a share of result->norm. */
int cvol_whole_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const double weight[3], const cvol_keep *keep);
int cvol_blocks_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const double weight[3], const cvol_keep *keep);

/* `out` has the new dims; they determine whether it is half or twice. */
int cvol_whole_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep);
int cvol_blocks_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep);

/* The energy of all terms except the mean's; sum a b; |a - b|. For cases in which the sums below
 * would cancel. */
double cvol_whole_variation(const cvol_array *a);
int cvol_whole_compare(cvol_context *context, double *inner, double *distance, const cvol_array *a,
                       const cvol_array *b);
/* Sums over the samples within the array: sum a, sum a^2; sum a b. They evaluate only blocks that
 * reach beyond the array. */
int cvol_whole_sums(cvol_context *context, double *sum, double *squares, const cvol_array *a);
int cvol_blocks_sums(cvol_context *context, double *sum, double *squares, double *variation,
                     const cvol_array *a);
int cvol_whole_inner(cvol_context *context, double *inner, const cvol_array *a,
                     const cvol_array *b);
int cvol_blocks_distance(cvol_context *context, double *squares, const cvol_array *a,
                         const cvol_array *b);
int cvol_blocks_inner(cvol_context *context, double *inner, const cvol_array *a,
                      const cvol_array *b);

#endif
