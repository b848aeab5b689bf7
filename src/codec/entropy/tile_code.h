/* Codes tiles of quantized coefficients, of planes of rank 2 in blocks or whole, with an adaptive
 * binary range coder.
 *
 * A coefficient's contexts are its frequency and the magnitudes of earlier coefficients around it:
 * in the tile, at its place in the tiles to the left and above, or, in a whole plane under DFT or
 * DHT, at the mirrored frequency; and at its place in a similar plane. doc/format.md has the
 * details. */
#ifndef CVOL_CODEC_ENTROPY_TILE_CODE_H
#define CVOL_CODEC_ENTROPY_TILE_CODE_H

#include "codec/entropy/range_coder.h"
#include "cvol/array.h"

/* A bit costs at least 1/700, so a byte holds at most this many coefficients or empty tiles. */
#define CVOL_TILE_EXPANSION 8192

enum {
    CVOL_TILE_BANDS = 10,
    CVOL_TILE_LEVELS = 16,
    CVOL_TILE_UNARY = 15,
    CVOL_TILE_LENGTHS = 24,
    CVOL_TILE_SIDE = 32,
    CVOL_TILE_SUMS = 202,
    CVOL_TILE_FREQUENCIES = 129
};

/* The largest magnitude that is coded; a prediction may be off by twice that. */
#define CVOL_TILE_LIMIT (INT32_C(1) << 29)

/* Probabilities that planes of one class share. */
typedef struct cvol_tile_contexts {
    /* Contexts by sums and frequencies. */
    uint8_t levels[CVOL_TILE_SUMS], bands[CVOL_TILE_FREQUENCIES];
    cvol_probability empty[4], rows[CVOL_TILE_SIDE], columns[CVOL_TILE_SIDE],
        zero[CVOL_TILE_BANDS][CVOL_TILE_LEVELS], more[CVOL_TILE_LEVELS][CVOL_TILE_UNARY],
        length[CVOL_TILE_LENGTHS];
} cvol_tile_contexts;

void cvol_tile_contexts_start(cvol_tile_contexts *contexts);

/* One of the two is NULL. */
typedef struct cvol_tile_coder {
    cvol_range_encoder *encoder;
    cvol_range_decoder *decoder;
    cvol_tile_contexts *contexts;
} cvol_tile_coder;

/* A tile and its neighbours. */
typedef struct cvol_tile {
    size_t size[2]; /* coefficients, u fastest */
    cvol_transform transform;
    int is_whole;                /* the only tile of its plane: no prediction */
    const int32_t *left, *above; /* the tiles left of it and above it; NULL: none */
    const int32_t *before;       /* the same tile of a similar plane; NULL: none */
} cvol_tile;

/* Codes values[size[0] size[1]], or decodes into it; returns 0 if a decoded magnitude exceeds the
 * limit. */
int cvol_tile_code(const cvol_tile_coder *coder, int32_t *values, const cvol_tile *tile);

#endif
