/* Codes tiles of quantized coefficients, of planes of rank 2 in blocks or whole, with an adaptive
 * binary range coder.
 *
 * A coefficient's contexts are where its frequency lies, and the magnitudes of those around it that
 * are coded before: in the tile, and at its place in the tiles left of and above it, or, of a whole
 * plane under DFT or DHT, at the mirrored frequency; and at its place in a plane that is alike.
 * doc/format.md has all of it.
 */
#ifndef CVOL_CODEC_ENTROPY_TILE_CODE_H
#define CVOL_CODEC_ENTROPY_TILE_CODE_H

#include "codec/entropy/range_coder.h"
#include "cvol/array.h"

/* Bits cost 1/700 at least, so that a byte holds no more coefficients, or empty tiles, than this.
 */
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

/* The largest magnitude that is coded; what is predicted may be off by twice that. */
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

/* Where a tile lies. */
typedef struct cvol_tile {
    size_t size[2]; /* coefficients, u fastest */
    cvol_transform transform;
    int is_whole;                /* no tile of several: nothing is predicted */
    const int32_t *left, *above; /* the tiles there; NULL: none */
    const int32_t *before;       /* the same tile of a plane that is alike; NULL: none */
} cvol_tile;

/* Codes values[size[0] size[1]], or fills it: then 0 if a magnitude is beyond the
 * limit. */
int cvol_tile_code(const cvol_tile_coder *coder, int32_t *values, const cvol_tile *tile);

#endif
