/* Coding of a brick's mask (array/mask.h): a stream of tokens and raw bits (token_stream.h).
 *
 * No bytes: no sample is masked. Else one raw bit first, what is thought to be beyond the brick's
 * faces (1: masked); then for every cell of 16^3, x fastest, a raw bit, 1 if its samples differ,
 * and if they do not, what they all are, in as many raw bits as the number of fills has: 0, or 1 +
 * the number of the fill. Then for every sample of other cells, in the brick's order, a token: 1 if
 * it is masked, in the context of six neighbours, each 1 if masked:
 *
 *     (-1, 0, 0) + 2 (0, -1, 0) + 4 (0, 0, -1) + 8 (1, -1, 0) + 16 (1, 0, -1) + 32 (0, 1, -1);
 *
 * and if it is and there are several fills, a token that is the fill's number, from 0 on, in the
 * context of that of the masked sample before (0 at first).
 */
#ifndef CVOL_CODEC_MASK_CODE_H
#define CVOL_CODEC_MASK_CODE_H

#include "codec/brick_code.h"
#include "codec/token_stream.h"

/* which: as cvol_fills_match, x fastest. The bytes replace those of *out. counts: may be NULL. 1,
 * or 0 when memory is short. tables NULL: nothing is written, only counted. */
int cvol_mask_encode(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                     const uint8_t *which, const size_t size[3], int fills,
                     cvol_token_counts *counts);
/* 0 if the bytes say what cannot be. */
int cvol_mask_decode(uint8_t *which, const size_t size[3], int fills,
                     const cvol_token_tables *tables, cvol_span data);

#endif
