/* Rows of frequencies from codes. */
#include "codec/entropy/token_tables.h"

#include <stdlib.h>
#include <string.h>

/* P[j] of token_tables.h. */
static const uint16_t probabilities[256] = {
    3,     3,     3,     4,     4,     4,     5,     5,     6,     6,     7,     7,     8,
    8,     9,     10,    10,    11,    12,    13,    14,    15,    17,    18,    20,    21,
    23,    25,    27,    29,    31,    34,    37,    40,    43,    46,    50,    54,    59,
    63,    68,    74,    80,    87,    94,    101,   110,   118,   128,   139,   150,   162,
    175,   189,   205,   222,   240,   259,   280,   303,   327,   354,   383,   414,   447,
    483,   523,   565,   611,   660,   713,   771,   833,   900,   972,   1050,  1134,  1225,
    1323,  1429,  1542,  1665,  1797,  1939,  2093,  2257,  2435,  2625,  2830,  3051,  3287,
    3541,  3813,  4104,  4417,  4751,  5108,  5490,  5898,  6332,  6796,  7288,  7812,  8368,
    8958,  9581,  10241, 10937, 11671, 12442, 13252, 14101, 14988, 15914, 16878, 17879, 18917,
    19989, 21095, 22233, 23399, 24592, 25808, 27045, 28298, 29566, 30843, 32126, 33410, 34693,
    35970, 37238, 38491, 39728, 40944, 42137, 43303, 44441, 45547, 46619, 47657, 48658, 49622,
    50548, 51435, 52284, 53094, 53865, 54599, 55295, 55955, 56578, 57168, 57724, 58248, 58740,
    59204, 59638, 60046, 60428, 60785, 61119, 61432, 61723, 61995, 62249, 62485, 62706, 62911,
    63101, 63279, 63443, 63597, 63739, 63871, 63994, 64107, 64213, 64311, 64402, 64486, 64564,
    64636, 64703, 64765, 64823, 64876, 64925, 64971, 65013, 65053, 65089, 65122, 65153, 65182,
    65209, 65233, 65256, 65277, 65296, 65314, 65331, 65347, 65361, 65374, 65386, 65397, 65408,
    65418, 65426, 65435, 65442, 65449, 65456, 65462, 65468, 65473, 65477, 65482, 65486, 65490,
    65493, 65496, 65499, 65502, 65505, 65507, 65509, 65511, 65513, 65515, 65516, 65518, 65519,
    65521, 65522, 65523, 65524, 65525, 65526, 65526, 65527, 65528, 65528, 65529, 65529, 65530,
    65530, 65531, 65531, 65532, 65532, 65532, 65533, 65533, 65533};

static void settle_row(cvol_token_row *row, const uint8_t codes[CVOL_TOKEN_CODES])
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

void cvol_token_tables_settle(cvol_token_tables *tables)
{
    for (int r = 0; r < CVOL_ROWS; r++)
        settle_row(&tables->rows[r], tables->codes[r]);
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
    cvol_token_tables_settle(tables);
    return tables;
}
