/* A box of samples, piece by piece: what is decoded together fits in memory. */
#ifndef CVOL_ARRAY_EVALUATE_PIECES_H
#define CVOL_ARRAY_EVALUATE_PIECES_H

#include "cvol/base.h"

/* Samples of a piece, at most. */
enum { CVOL_PIECE_X = 256, CVOL_PIECE_Y = 256, CVOL_PIECE_Z = 64 };
#define CVOL_PIECE_SAMPLES ((size_t)CVOL_PIECE_X * CVOL_PIECE_Y * CVOL_PIECE_Z)

/* Handles the piece begin .. end - 1. Returns an error code. */
typedef int cvol_piece_fn(cvol_context *context, void *user, const size_t begin[3],
                          const size_t end[3]);

/* Calls `add` for each piece of the box, and reports progress as "measuring". Returns the first
 * error. */
int cvol_pieces_walk(cvol_context *context, cvol_piece_fn *add, void *user, const size_t begin[3],
                     const size_t end[3]);

#endif
