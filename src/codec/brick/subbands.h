/* Which coefficients the four subbands of a file hold (brick_code.h), and what it costs to leave
 * some away.
 *
 * Level l of a volume, 0 to 3, is what its subbands 0 .. 3 - l decode to. The transform is
 * orthonormal, so what the others hold is the L2 distance of the two, but for the filter of lapped
 * volumes, whose norm is known.
 */
#ifndef CVOL_CODEC_BRICK_SUBBANDS_H
#define CVOL_CODEC_BRICK_SUBBANDS_H

#include "codec/brick/brick_code.h"

/* The subband of the coefficient at `place` of a block. */
int cvol_subband_of(uint32_t place, int block_log2, uint16_t split);

/* The L2 norm of the coefficients of each subband, rounded up. */
void cvol_subband_norms(double norm[CVOL_SUBBANDS], const cvol_array *array);
/* The same block by block: adds the squares of its values (of cells that the volume ends in, of
 * what a file codes); and norms from all squares. */
void cvol_subband_squares(double squares[CVOL_SUBBANDS], const cvol_array *array, size_t block);
void cvol_subband_norms_of(double norm[CVOL_SUBBANDS], const double squares[CVOL_SUBBANDS],
                           double step);

/* Turns the error bounds of the whole volume into those of a level: the samples of subbands that
 * are not there are at most this far. */
void cvol_subbands_leave(cvol_array *array, const double norm[CVOL_SUBBANDS], int level);

#endif
