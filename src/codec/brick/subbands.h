/* The coefficients in the four subbands of a file (brick_code.h), and the error of leaving some
 * out.
 *
 * Level l of a volume, 0 to 3, decodes from its subbands 0 .. 3 - l. The transform is orthonormal,
 * so the norm of the omitted coefficients is the L2 distance between level and volume, except for
 * the filter of lapped volumes, whose norm is known. */
#ifndef CVOL_CODEC_BRICK_SUBBANDS_H
#define CVOL_CODEC_BRICK_SUBBANDS_H

#include "codec/brick/brick_code.h"

/* The subband of the coefficient at `place` of a block. */
int cvol_subband_of(uint32_t place, int block_log2, uint16_t split);

/* The L2 norm of the coefficients of each subband, rounded up. */
void cvol_subband_norms(double norm[CVOL_SUBBANDS], const cvol_array *array);
/* The same by the processes of a team, each with the terms of its share (array/core/share.h): added
 * in the same order, so that the norms are equal. Errors: those of cvol_team_gather. */
int cvol_subband_norms_by_team(cvol_context *context, double norm[CVOL_SUBBANDS],
                               const cvol_array *array);
/* The same block by block: the first adds the squares of the block's values (in cells that cross
 * the volume's end: of the coded values); the second makes norms from all squares. */
void cvol_subband_squares(double squares[CVOL_SUBBANDS], const cvol_array *array, size_t block);
void cvol_subband_norms_of(double norm[CVOL_SUBBANDS], const double squares[CVOL_SUBBANDS],
                           double step);

/* Turns the error bounds of the whole volume into bounds of a level: the norms of the missing
 * subbands bound the distance. */
void cvol_subbands_bound_level(cvol_array *array, const double norm[CVOL_SUBBANDS], int level);

#endif
