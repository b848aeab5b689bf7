/* Builds an array in blocks from dense blocks of coefficients.
 *
 * A producer computes the coefficients of one block at a time, on any thread, once or more often.
 * The builder selects by a cvol_keep and packs (array.h). Rules that depend on all magnitudes (ALL,
 * TERMS, RHO, RATIO, PSNR, L2) run the producer once for a histogram of magnitudes, and once more
 * to keep; LOSS runs it for a part of the blocks, and then until a step and a threshold lose
 * almost what they may, usually once; THRESHOLD and STEP run it once. At most one block per thread
 * is dense at any time.
 *
 * LOSS counts the loss of visible samples only (visible.h), and blocks without one get no terms. */
#ifndef CVOL_ARRAY_TRUNCATE_BUILD_H
#define CVOL_ARRAY_TRUNCATE_BUILD_H

#include "array/core/array.h"
#include "array/truncate/producer.h"

/* Fills `array` (created, without terms). array->error_bound.max_abs and array->offset must be set.
 * As bounds of coefficients (cvol_array_coefficient_bound), they give the fine step of all rules
 * except STEP, LOSS and ALL: a power of two with which the largest coefficient takes 22 bits
 * (finer if an L2 error needs it). LOSS becomes ALL if its step would be finer than 28 bits. ALL
 * uses the actual largest coefficient, which takes 29 bits. PSNR uses array->error_bound.value_min
 * and value_max. RHO counts like cvol_array_info, RATIO counts resident bytes. Under DFT both slots
 * (a, b) of a pair are kept or dropped together, by the magnitude |F| = sqrt((a^2 + b^2) / 2). Sets
 * step, threshold, coefficients; not the ranges, not the error bound. The bits of the result do not
 * depend on the numbers of threads and processes. With a team, which TERMS, RHO, RATIO, PSNR and L2
 * refuse (UNSUPPORTED), a process gets the terms of its share (array/core/share.h) alone. Errors:
 * ARGUMENT, DATA (coefficients beyond the range of a step), TARGET, MEMORY, CANCELLED. */
int cvol_build_blocks(cvol_context *context, cvol_array *array, cvol_build_result *result,
                      const cvol_producer *producer, const cvol_keep *keep);

#endif
