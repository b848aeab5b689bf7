/* The coder's probabilities: a table of token frequencies for each context.
 *
 * Every number of a brick is coded as a token of 0 .. 15 in a context (a *row*), followed by raw
 * bits if the token covers several numbers. 15 codes give the token probabilities of a row: code t
 * gives the probability of token t under the condition that the token is at least t. With a total
 * of 2^14, token t gets
 *      f[t] = (left P[code[t]] + 2^15) >> 16,  at least 1 and at most left - (15 - t),
 *      left = 2^14 - f[0] - ... - f[t - 1],    f[15] = the rest;
 *      P[j] = 2^16 / (1 + exp((127.5 - j) / 12.75)), rounded.
 *
 * Rows are built in (tables/token_codes.inc); a file stores its differences from them. */
#ifndef CVOL_CODEC_ENTROPY_TOKEN_TABLES_H
#define CVOL_CODEC_ENTROPY_TOKEN_TABLES_H

#include <stdint.h>

#include "base/bytes.h"
#include "codec/entropy/scan.h"
#include "cvol/base.h"

enum {
    CVOL_TOKENS = 16,
    CVOL_TOKEN_CODES = CVOL_TOKENS - 1,
    CVOL_TOKEN_SCALE = 14, /* frequencies add up to 2^14 */
    CVOL_CODE_STEP = 2     /* a file's codes differ from the built-in ones by multiples of this */
};

/* The rows. */
enum {
    CVOL_SPREADS = 12,
    CVOL_AROUND = 17,
    CVOL_DC_CLASSES = 4,
    CVOL_LENGTHS = 16,
    CVOL_SPLIT_CONTEXTS = 11,
    /* Magnitudes: [size class][band][level]; of the last coefficient, minus one: [size
     * class][level]; bit length after the escape token 15: [level]. */
    CVOL_ROW_VALUE = 0,
    CVOL_ROW_LAST = CVOL_ROW_VALUE + CVOL_SUB_BLOCK_SIZES * CVOL_BANDS * CVOL_LEVELS,
    CVOL_ROW_ESCAPE = CVOL_ROW_LAST + CVOL_SUB_BLOCK_SIZES * CVOL_LEVELS,
    /* The DC's difference: [size class][spread]. */
    CVOL_ROW_DC = CVOL_ROW_ESCAPE + CVOL_LEVELS,
    /* The last index: its bit length [size class][around][DC class], the two bits after its first
     * one [size class][length]. */
    CVOL_ROW_LENGTH = CVOL_ROW_DC + CVOL_SUB_BLOCK_SIZES * CVOL_SPREADS,
    CVOL_ROW_MORE = CVOL_ROW_LENGTH + CVOL_SUB_BLOCK_SIZES * CVOL_AROUND * CVOL_DC_CLASSES,
    /* The split of a cell: [around]; the split octants: [half]. */
    CVOL_ROW_SPLIT = CVOL_ROW_MORE + CVOL_SUB_BLOCK_SIZES * CVOL_LENGTHS,
    CVOL_ROW_OCTANTS = CVOL_ROW_SPLIT + CVOL_SPLIT_CONTEXTS,
    /* Residual (residual_code.h): magnitudes and escapes, [level]; exponents near 0. */
    CVOL_RESIDUAL_LEVELS = 24,
    CVOL_ROW_RESIDUAL = CVOL_ROW_OCTANTS + 2,
    CVOL_ROW_RESIDUAL_MORE = CVOL_ROW_RESIDUAL + CVOL_RESIDUAL_LEVELS,
    CVOL_ROW_RESIDUAL_DEEP = CVOL_ROW_RESIDUAL_MORE + CVOL_RESIDUAL_LEVELS,
    /* Trellis quantization (trellis_states.h) has separate rows: magnitudes of indices [odd][size
     * class][band][level], of the last one minus one [odd][size class][level], escapes [level]. Its
     * sub-blocks are those in cells of 16^3. */
    CVOL_INDEX_SIZES = 3,
    CVOL_ROW_INDEX = CVOL_ROW_RESIDUAL_DEEP + 1,
    CVOL_ROW_LAST_INDEX = CVOL_ROW_INDEX + 2 * CVOL_INDEX_SIZES * CVOL_BANDS * CVOL_FINE_LEVELS,
    CVOL_ROW_INDEX_ESCAPE = CVOL_ROW_LAST_INDEX + 2 * CVOL_INDEX_SIZES * CVOL_FINE_LEVELS,
    CVOL_ROWS = CVOL_ROW_INDEX_ESCAPE + CVOL_FINE_LEVELS
};

/* Token t has the numbers bounds[7 + t] .. bounds[8 + t] - 1 of 0 .. 2^14 - 1; bounds[0 .. 7] are
 * 0, so that the 16 upper ends stand at a multiple of 16 bytes. */
typedef struct cvol_token_row {
    uint16_t bounds[24] __attribute__((aligned(16)));
} cvol_token_row;

typedef struct cvol_token_tables {
    uint8_t codes[CVOL_ROWS][CVOL_TOKEN_CODES];
    cvol_token_row rows[CVOL_ROWS];
} cvol_token_tables;

/* The number of uses of each token in each row. */
typedef struct cvol_token_counts {
    uint64_t of[CVOL_ROWS][CVOL_TOKENS];
} cvol_token_counts;

/* The built-in codes. */
extern const uint8_t cvol_token_defaults[CVOL_ROWS][CVOL_TOKEN_CODES];

/* Makes the built-in tables. NULL when memory is short. The caller frees them with free(). */
cvol_token_tables *cvol_token_tables_create(void);
/* Copies rows first .. end - 1 from other tables. */
void cvol_token_tables_copy_rows(cvol_token_tables *tables, const cvol_token_tables *from,
                                 int first, int end);
/* Computes the rows from the codes. */
void cvol_token_tables_commit(cvol_token_tables *tables);

/* Fits codes to counts: changes a built-in code only if this saves more bits than the change
 * costs. */
void cvol_token_tables_fit(cvol_token_tables *tables, const cvol_token_counts *counts);

/* Appends the content of section TABL: the differences from the built-in tables. Errors: MEMORY. */
int cvol_token_tables_put(cvol_context *context, cvol_bytes *out, const cvol_token_tables *tables);
/* Reads the content. `name` begins the message. Errors: CORRUPT. */
int cvol_token_tables_take(cvol_context *context, cvol_token_tables *tables, cvol_cursor *content,
                           const char *name);

#endif
