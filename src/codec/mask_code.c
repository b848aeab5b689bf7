/* Coding of masks, both ways. */
#include "codec/mask_code.h"

#include <string.h>

enum {
    LINE = CVOL_BRICK_SIDE + 2,
    SHEET = LINE * LINE,
    CELL = 16,
    CELLS = CVOL_BRICK_SIDE / CELL,
    MIXED = 255
};

/* Two sheets of a brick's bits with a border, and what its cells of 16^3 are: MIXED, or what all of
 * their samples are. */
typedef struct brick_bits {
    uint8_t sheets[2][SHEET];
    uint8_t cells[CELLS][CELLS][CELLS];
} brick_bits;

static uint8_t *line_at(brick_bits *bits, size_t y, size_t z)
{
    return bits->sheets[z & 1] + LINE * (y + 1) + 1;
}

CVOL_INLINE int row_at(const uint8_t *line, const uint8_t *front, size_t x)
{
    const uint8_t *at = line + x, *before = front + x;
    return CVOL_ROW_MASK + at[-1] + 2 * at[-LINE] + 4 * before[0] + 8 * at[1 - LINE] +
           16 * before[1] + 32 * before[LINE];
}

/* Raw bits that tell what a cell's samples are. */
static int bits_of_cell(int fills)
{
    int bits = 1;
    while (fills >> bits)
        bits++;
    return bits;
}

static size_t cells_along(size_t size)
{
    return (size - 1) / CELL + 1;
}

static uint8_t find_cell(const uint8_t *which, const size_t size[3], const size_t place[3])
{
    size_t end[3];
    for (int a = 0; a < 3; a++)
        end[a] = (place[a] + 1) * CELL < size[a] ? (place[a] + 1) * CELL : size[a];
    const size_t begin = place[0] * CELL;
    const uint8_t first = which[begin + size[0] * (place[1] * CELL + size[1] * (place[2] * CELL))];
    for (size_t z = place[2] * CELL; z < end[2]; z++)
        for (size_t y = place[1] * CELL; y < end[1]; y++) {
            const uint8_t *line = which + size[0] * (y + size[1] * z);
            for (size_t x = begin; x < end[0]; x++)
                if (line[x] != first)
                    return MIXED;
        }
    return first;
}

/* The run of one cell on a line. */
static size_t run_end(size_t begin, size_t width)
{
    return begin + CELL < width ? begin + CELL : width;
}

/* ---- to bytes --------------------------------------------------------------------------- */

static void put_cells(cvol_token_writer *writer, brick_bits *bits, const uint8_t *which,
                      const size_t size[3], int fills)
{
    for (size_t l = 0; l < cells_along(size[2]); l++)
        for (size_t j = 0; j < cells_along(size[1]); j++)
            for (size_t i = 0; i < cells_along(size[0]); i++) {
                const uint8_t cell = find_cell(which, size, (size_t[3]){i, j, l});
                bits->cells[l][j][i] = cell;
                cvol_raw_put(writer, cell == MIXED, 1);
                if (cell != MIXED)
                    cvol_raw_put(writer, cell, bits_of_cell(fills));
            }
}

int cvol_mask_encode(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                     const uint8_t *which, const size_t size[3], int fills,
                     cvol_token_counts *counts)
{
    const size_t width = size[0], sheet = size[0] * size[1], count = sheet * size[2];
    size_t found = 0, found_first = 0;
    brick_bits bits;
    out->size = 0;
    for (size_t i = 0; i < sheet; i++)
        found_first += which[i] != 0;
    for (size_t i = 0; i < count; i++)
        found += which[i] != 0;
    if (!found)
        return 1;
    const int outside = 2 * found_first > sheet;
    memset(&bits.sheets, outside, sizeof bits.sheets);
    cvol_token_writer_start(writer);
    cvol_raw_put(writer, (uint32_t)outside, 1);
    put_cells(writer, &bits, which, size, fills);
    int last = 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            uint8_t *line = line_at(&bits, y, z);
            const uint8_t *front = line_at(&bits, y, z + 1);
            const uint8_t *from = which + width * (y + size[1] * z);
            for (size_t begin = 0; begin < width; begin += CELL) {
                const uint8_t cell = bits.cells[z / CELL][y / CELL][begin / CELL];
                const size_t end = run_end(begin, width);
                if (cell != MIXED) {
                    memset(line + begin, cell != 0, end - begin);
                    continue;
                }
                for (size_t x = begin; x < end; x++) {
                    const uint8_t bit = from[x] != 0;
                    cvol_token_put(writer, row_at(line, front, x), bit);
                    line[x] = bit;
                    if (!bit || fills < 2)
                        continue;
                    cvol_token_put(writer, CVOL_ROW_FILL + last, (uint32_t)from[x] - 1);
                    last = from[x] - 1;
                }
            }
        }
    if (counts)
        cvol_token_writer_count(writer, counts);
    return !tables || cvol_token_writer_finish(writer, tables, out);
}

/* ---- from bytes ------------------------------------------------------------------------- */

static int take_cells(brick_bits *bits, cvol_token_reader *in, const size_t size[3], int fills)
{
    for (size_t l = 0; l < cells_along(size[2]); l++)
        for (size_t j = 0; j < cells_along(size[1]); j++)
            for (size_t i = 0; i < cells_along(size[0]); i++) {
                const uint32_t cell = cvol_raw_take(in, 1) ? MIXED
                                                           : cvol_raw_take(in, bits_of_cell(fills));
                if (cell != MIXED && cell > (uint32_t)fills)
                    return 0;
                bits->cells[l][j][i] = (uint8_t)cell;
            }
    return 1;
}

/* One run of a mixed cell; 0 if the bytes say what cannot be. */
CVOL_INLINE int take_run(uint8_t *to, uint8_t *line, const uint8_t *front, cvol_token_reader *in,
                         size_t begin, size_t end, uint32_t fills, uint32_t *last)
{
    for (size_t x = begin; x < end; x++) {
        const uint32_t bit = cvol_token_take(in, row_at(line, front, x));
        if (bit > 1)
            return 0;
        line[x] = (uint8_t)bit;
        if (bit && fills > 1) {
            *last = cvol_token_take(in, CVOL_ROW_FILL + (int)*last);
            if (*last >= fills)
                return 0;
        }
        to[x] = bit ? (uint8_t)(1 + *last) : 0;
    }
    return 1;
}

int cvol_mask_decode(uint8_t *which, const size_t size[3], int fills,
                     const cvol_token_tables *tables, cvol_span data)
{
    const size_t width = size[0];
    cvol_token_reader in;
    brick_bits bits;
    uint32_t last = 0;
    if (!data.size) {
        memset(which, 0, size[0] * size[1] * size[2]);
        return 1;
    }
    cvol_token_reader_start(&in, tables, data.data, data.size);
    memset(&bits.sheets, (int)cvol_raw_take(&in, 1), sizeof bits.sheets);
    if (!take_cells(&bits, &in, size, fills))
        return 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            uint8_t *line = line_at(&bits, y, z);
            const uint8_t *front = line_at(&bits, y, z + 1);
            uint8_t *to = which + width * (y + size[1] * z);
            for (size_t begin = 0; begin < width; begin += CELL) {
                const uint8_t cell = bits.cells[z / CELL][y / CELL][begin / CELL];
                const size_t end = run_end(begin, width);
                if (cell != MIXED) {
                    memset(line + begin, cell != 0, end - begin);
                    memset(to + begin, cell, end - begin);
                } else if (!take_run(to, line, front, &in, begin, end, (uint32_t)fills, &last)) {
                    return 0;
                }
            }
        }
    return cvol_token_reader_ended(&in);
}
