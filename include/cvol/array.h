/* cvol/array.h - compressed transform-domain arrays.
 *
 * A cvol_array of rank 3 is a volume kept as the quantised non-zero DCT-II coefficients of
 * cubic blocks: block (i, j, l) covers samples B i .. B i + B - 1 and so on, the last block
 * of an axis reaching beyond the volume; what lies beyond was extended when compressing and
 * is cut off when evaluating.
 *
 *     a[x, y, z] = sum_{u, v, w < B} D[u][x] D[v][y] D[w][z] A[u, v, w],
 *     D[u][x]    = c(u) cos(pi u (x + 1/2) / B),  c(0) = sqrt(1/B), c(u) = sqrt(2/B)
 *
 * orthonormal, so that Parseval holds block by block.
 */
#ifndef CVOL_ARRAY_H
#define CVOL_ARRAY_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cvol_array cvol_array;

typedef enum cvol_transform { CVOL_DCT = 1, CVOL_DHT = 2, CVOL_DFT = 3 } cvol_transform;

/* Frees an array; NULL is allowed. */
CVOL_API void cvol_array_free(cvol_array *array);
/* Shape, sample type and geometry of what the array stands for. Owned by the array. */
CVOL_API const cvol_grid *cvol_array_grid(const cvol_array *array);

/* What is kept, and what is known of it. */
typedef struct cvol_array_info {
    cvol_transform transform;
    int block;                   /* B; 8, 16 or 32 */
    size_t blocks[3];            /* blocks along each axis */
    double step;                 /* quantiser step, in units of the samples */
    uint64_t coefficients;       /* non-zero coefficients kept */
    double rho;                  /* coefficients / samples */
    uint64_t resident_bytes;     /* memory this array holds */
    double value_min, value_max; /* of the original samples */
    double psnr_db;              /* measured when compressing, by decoding; infinity: exact */
    double max_error;            /* largest |original - decoded|, measured likewise */
    double l2_error;             /* L2 norm of original - decoded, measured likewise */
} cvol_array_info;
CVOL_API void cvol_array_get_info(const cvol_array *array, cvol_array_info *out);

/* Evaluates the box of samples [begin, end) (x, y, z) into `out`, which holds the box x
 * fastest in the grid's own type: integers rounded to nearest and clamped to value_min ..
 * value_max. Bit-identical for any thread count and processor.
 * Cost: the inverse transform of the blocks that the box touches. Errors: ARGUMENT, MEMORY,
 * CANCELLED. */
CVOL_API int cvol_array_evaluate_box(cvol_context *context, void *out, const cvol_array *array,
                                     const size_t begin[3], const size_t end[3]);

#ifdef __cplusplus
}
#endif
#endif
