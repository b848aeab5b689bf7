/* Computes rows of frequencies from codes. */
#include "codec/entropy/token_tables.h"

#include <stdlib.h>
#include <string.h>

/* P[j] of token_tables.h. */
static const uint16_t probabilities[256] = {
#include "codec/tables/token_probabilities.inc"
};

static void finish_row_codes(cvol_token_row *row, const uint8_t codes[CVOL_TOKEN_CODES])
{
    uint32_t left = 1u << CVOL_TOKEN_SCALE, end = 0;
    memset(row, 0, sizeof *row);
    for (uint32_t t = 0; t < CVOL_TOKENS; t++) {
        uint32_t frequency = left;
        if (t < CVOL_TOKEN_CODES) {
            const uint32_t most = left - (CVOL_TOKEN_CODES - t);
            frequency = (left * probabilities[codes[t]] + (1u << 15)) >> 16;
            frequency = frequency < 1 ? 1 : frequency > most ? most : frequency;
        }
        left -= frequency;
        end += frequency;
        row->bounds[8 + t] = (uint16_t)end;
    }
}

void cvol_token_tables_commit(cvol_token_tables *tables)
{
    for (int r = 0; r < CVOL_ROWS; r++)
        finish_row_codes(&tables->rows[r], tables->codes[r]);
}

void cvol_token_tables_copy_rows(cvol_token_tables *tables, const cvol_token_tables *from,
                                 int first, int end)
{
    const size_t rows = (size_t)(end - first);
    memcpy(tables->codes[first], from->codes[first], rows * sizeof *tables->codes);
    memcpy(&tables->rows[first], &from->rows[first], rows * sizeof *tables->rows);
}

cvol_token_tables *cvol_token_tables_create(void)
{
    cvol_token_tables *tables = aligned_alloc(64, (sizeof *tables + 63) & ~(size_t)63);
    if (!tables)
        return NULL;
    memcpy(tables->codes, cvol_token_defaults, sizeof tables->codes);
    cvol_token_tables_commit(tables);
    return tables;
}
