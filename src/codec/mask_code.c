/* Coding of masks, both ways. */
#include "codec/mask_code.h"

#include <string.h>

enum { LINE = CVOL_BRICK_SIDE + 2, SHEET = LINE * LINE };

/* Two sheets of a brick's bits with a border. */
typedef struct bit_sheets {
    uint8_t of[2][SHEET];
} bit_sheets;

static uint8_t *line_at(bit_sheets *sheets, size_t y, size_t z)
{
    return sheets->of[z & 1] + LINE * (y + 1) + 1;
}

CVOL_INLINE int row_at(const uint8_t *line, const uint8_t *front, size_t x)
{
    const uint8_t *at = line + x, *before = front + x;
    return CVOL_ROW_MASK + at[-1] + 2 * at[-LINE] + 4 * before[0] + 8 * at[1 - LINE] +
           16 * before[1] + 32 * before[LINE];
}

int cvol_mask_encode(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                     const uint8_t *which, const size_t size[3], int fills,
                     cvol_token_counts *counts)
{
    const size_t width = size[0], sheet = size[0] * size[1], count = sheet * size[2];
    size_t found = 0, found_first = 0;
    bit_sheets sheets;
    out->size = 0;
    for (size_t i = 0; i < count; i++) {
        found += which[i] != 0;
        found_first += i < sheet && which[i];
    }
    if (!found)
        return 1;
    const int outside = 2 * found_first > sheet;
    memset(&sheets, outside, sizeof sheets);
    cvol_token_writer_start(writer);
    cvol_raw_put(writer, (uint32_t)outside, 1);
    int last = 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            uint8_t *line = line_at(&sheets, y, z);
            const uint8_t *front = line_at(&sheets, y, z + 1);
            const uint8_t *from = which + width * (y + size[1] * z);
            for (size_t x = 0; x < width; x++) {
                const uint8_t bit = from[x] != 0;
                cvol_token_put(writer, row_at(line, front, x), bit);
                line[x] = bit;
                if (!bit || fills < 2)
                    continue;
                cvol_token_put(writer, CVOL_ROW_FILL + last, (uint32_t)from[x] - 1);
                last = from[x] - 1;
            }
        }
    if (counts)
        cvol_token_writer_count(writer, counts);
    return cvol_token_writer_finish(writer, tables, out);
}

int cvol_mask_decode(uint8_t *which, const size_t size[3], int fills,
                     const cvol_token_tables *tables, cvol_span data)
{
    const size_t width = size[0];
    cvol_token_reader in;
    bit_sheets sheets;
    if (!data.size) {
        memset(which, 0, size[0] * size[1] * size[2]);
        return 1;
    }
    cvol_token_reader_start(&in, tables, data.data, data.size);
    memset(&sheets, (int)cvol_raw_take(&in, 1), sizeof sheets);
    uint32_t last = 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            uint8_t *line = line_at(&sheets, y, z);
            const uint8_t *front = line_at(&sheets, y, z + 1);
            uint8_t *to = which + width * (y + size[1] * z);
            for (size_t x = 0; x < width; x++) {
                const uint32_t bit = cvol_token_take(&in, row_at(line, front, x));
                if (bit > 1)
                    return 0;
                line[x] = (uint8_t)bit;
                if (bit && fills > 1) {
                    last = cvol_token_take(&in, CVOL_ROW_FILL + (int)last);
                    if (last >= (uint32_t)fills)
                        return 0;
                }
                to[x] = bit ? (uint8_t)(1 + last) : 0;
            }
        }
    return cvol_token_reader_ended(&in);
}
