/* Encodes and decodes masks. */
#include "codec/mask/mask_code.h"

#include <string.h>

#include "codec/mask/mask_predict.h"

enum {
    CELL = CVOL_MASK_CELL,
    CELLS = CVOL_MASK_BRICK_CELLS,
    MIXED = CVOL_MASK_MIXED,
    NONE = 254, /* no cell */
    HALVES = CELLS + 2,
    ROWS = CVOL_BRICK_SIDE + 4,
    ABOVE = 10, /* other rows that predict a sample */
    NUMBERS = 8 /* range of a fill's number, and nodes of its bits */
};

/* Adaptive contexts, reset in each brick. */
typedef struct mask_model {
    cvol_probability outside;
    cvol_probability mixed[4][2][2];         /* [mixed neighbour cells][masked ones][clear ones] */
    cvol_probability whole[2][2];            /* [masked neighbour cells][clear ones] */
    cvol_probability stretches[CELL + 1][2]; /* [length][state] */
    cvol_probability samples[2][2][CVOL_MASK_LEVELS]; /* [above][left][level] */
    cvol_probability fills[NUMBERS][NUMBERS];         /* [previous fill][bits before] */
} mask_model;

/* Three slices of rows in halves of 16 samples: one half before the brick's, one after; two rows
 * above and two below. */
typedef struct mask_slices {
    uint16_t rows[3][ROWS][HALVES];
} mask_slices;

/* Encoder or decoder: a constant at compile time. */
typedef struct mask_coder {
    cvol_range_encoder *to;
    cvol_range_decoder from;
} mask_coder;

CVOL_INLINE int code_bit(mask_coder *coder, cvol_probability *p, int bit, int encode)
{
    if (!encode)
        return cvol_decode_bit(&coder->from, p);
    cvol_encode_bit(coder->to, p, bit);
    return bit;
}

static cvol_probability probability(uint16_t of_zero)
{
    return (cvol_probability){of_zero, of_zero};
}

static void start_model(mask_model *model)
{
    enum { EVEN = 1 << 15, SURE = 64225 };
    cvol_probability *all = (cvol_probability *)model;
    for (size_t i = 0; i < sizeof *model / sizeof *all; i++)
        all[i] = probability(EVEN);
    for (int length = 0; length <= CELL; length++)
        model->stretches[length][0] = model->stretches[length][1] = probability(SURE);
    for (int i = 0; i < CVOL_MASK_LEVELS; i++)
        model->samples[0][0][i] = probability(cvol_mask_probabilities[i]);
    for (int c = 1; c < 4; c++)
        memcpy(model->samples[c / 2][c % 2], model->samples[0][0], sizeof model->samples[0][0]);
}

static int bits_of(int fills)
{
    int bits = 0;
    while (fills >> bits)
        bits++;
    return bits;
}

static size_t cells_along(size_t size)
{
    return (size - 1) / CELL + 1;
}

/* The number of samples of a row in cell `i` along x; and a bit mask of `count` ones. */
static int width_of(const cvol_mask_brick *brick, size_t i)
{
    const size_t left = brick->size[0] - i * CELL;
    return left < CELL ? (int)left : CELL;
}

static uint32_t ones(int count)
{
    return (1u << count) - 1;
}

/* ---- encoder and decoder ---------------------------------------------------------------- */

/* Codes the number of a masked sample's fill, from 0 on. */
CVOL_INLINE int code_fill(mask_coder *coder, mask_model *model, int fills, int last, int fill,
                          int encode)
{
    int node = 1;
    for (int bit = bits_of(fills - 1); bit-- > 0;)
        node = 2 * node | code_bit(coder, &model->fills[last][node], fill >> bit & 1, encode);
    return node - (1 << bits_of(fills - 1));
}

/* Codes all cells' states; returns 0 if a fill is invalid. */
CVOL_INLINE int code_cells(mask_coder *coder, mask_model *model, cvol_mask_brick *brick, int *last,
                           int encode)
{
    for (size_t l = 0; l < cells_along(brick->size[2]); l++)
        for (size_t j = 0; j < cells_along(brick->size[1]); j++)
            for (size_t i = 0; i < cells_along(brick->size[0]); i++) {
                uint8_t *state = &brick->states[l][j][i];
                const uint8_t neighbours[3] = {i ? brick->states[l][j][i - 1] : NONE,
                                               j ? brick->states[l][j - 1][i] : NONE,
                                               l ? brick->states[l - 1][j][i] : NONE};
                int mixed = 0, masked = 0, clear = 0;
                for (int a = 0; a < 3; a++) {
                    mixed += neighbours[a] == MIXED;
                    masked |= neighbours[a] && neighbours[a] < NONE;
                    clear |= !neighbours[a];
                }
                if (code_bit(coder, &model->mixed[mixed][masked][clear], *state == MIXED, encode)) {
                    *state = MIXED;
                    if (!encode) /* padding stays clear */
                        memset(brick->rows[l][j][i], 0, sizeof brick->rows[l][j][i]);
                } else if (code_bit(coder, &model->whole[masked][clear], *state != 0, encode)) {
                    *last = code_fill(coder, model, brick->fills, *last, *state - 1, encode);
                    *state = (uint8_t)(1 + *last);
                } else {
                    *state = 0;
                }
                if (*last >= brick->fills)
                    return 0;
            }
    return 1;
}

/* Samples 16 half - 8 .. 16 half + 23 of a row, low bits first. */
CVOL_INLINE uint32_t around_half(const uint16_t row[HALVES], size_t half)
{
    return row[half] >> 8 | (uint32_t)row[half + 1] << 8 | (uint32_t)row[half + 2] << 24;
}

/* The bits of one window. */
CVOL_INLINE uint32_t window_of(uint32_t row, int at, int dx, int width)
{
    return row >> (at + CELL / 2 + dx) & ones(width);
}

/* Codes one sample, bit 8 + at of its row. */
CVOL_INLINE int code_sample(mask_coder *coder, mask_model *model, const cvol_mask_sums *table,
                            const uint32_t above[ABOVE], uint32_t row, int at, int bit, int encode)
{
    cvol_mask_half sums[2] = {{0}, {0}};
    for (int i = 0; i < 3; i++, table += 8)
        cvol_mask_add(sums, table + window_of(above[i], at, -1, 3));
    for (int i = 3; i < 9; i++, table += 32)
        cvol_mask_add(sums, table + window_of(above[i], at, -2, 5));
    cvol_mask_add(sums, table + window_of(above[9], at, -3, 7));
    cvol_mask_add(sums, table + 128 + window_of(row, at, -4, 4));
    const int level = cvol_mask_level(cvol_mask_output(sums));
    cvol_probability *p =
        &model->samples[above[9] >> (at + CELL / 2) & 1][row >> (at + CELL / 2 - 1) & 1][level];
    return code_bit(coder, p, bit, encode);
}

/* Codes a row of a mixed cell: its samples are bits 8 and up of the result; row: the eight samples
 * before. */
CVOL_INLINE uint32_t code_row(mask_coder *coder, mask_model *model, const cvol_mask_sums *table,
                              const uint32_t above[ABOVE], uint32_t row, int width, uint32_t wanted,
                              int encode)
{
    const uint32_t some = above[4] | above[5] | above[6] | above[9];
    const uint32_t all = above[4] & above[5] & above[6] & above[9];
    const uint32_t like[2] = {~(some << 1 | some | some >> 1), all << 1 & all & all >> 1};
    for (int at = 0; at < width;) {
        const int left = row >> (at + CELL / 2 - 1) & 1;
        const int found = __builtin_ctz(~(like[left] >> (at + CELL / 2)));
        const int stretch = found < width - at ? found : width - at;
        const int end = at + stretch;
        const uint32_t same = ones(stretch) * (uint32_t)left, here = wanted >> at;
        if (stretch < 2) {
            const int bit = code_sample(coder, model, table, above, row, at, here & 1, encode);
            row |= (uint32_t)bit << (at++ + CELL / 2);
        } else if (!code_bit(coder, &model->stretches[stretch][left],
                             (here & ones(stretch)) != same, encode)) {
            row |= same << (at + CELL / 2);
            at = end;
        } else {
            /* The last sample must differ if no earlier one does. */
            for (int bit = left; bit == left; at++) {
                bit = !left;
                if (at < end - 1)
                    bit = code_sample(coder, model, table, above, row, at, wanted >> at & 1,
                                      encode);
                row |= (uint32_t)bit << (at + CELL / 2);
            }
        }
    }
    return row;
}

/* Codes the fills of a row's masked samples: the values of its planes. */
CVOL_INLINE void code_fills(mask_coder *coder, mask_model *model, cvol_mask_brick *brick,
                            cvol_mask_rows *planes, size_t at, uint32_t masked, int *last,
                            int encode)
{
    const int count = bits_of(brick->fills);
    uint32_t values[CVOL_MASK_PLANES] = {0};
    for (; masked; masked &= masked - 1) {
        const int x = __builtin_ctz(masked);
        int value = 0;
        for (int plane = 0; encode && plane < count; plane++)
            value |= (planes[plane].of[at] >> x & 1) << plane;
        *last = code_fill(coder, model, brick->fills, *last, value - 1, encode);
        for (int plane = 0; plane < count; plane++)
            values[plane] |= (uint32_t)((*last + 1) >> plane & 1) << x;
    }
    for (int plane = 0; !encode && plane < count; plane++)
        planes[plane].of[at] = (uint16_t)values[plane];
}

/* Extends a row beyond its ends with its end samples. */
static void end_row(uint16_t row[HALVES], size_t width)
{
    const size_t last = (width - 1) / CELL + 1, used = width - CELL * (last - 1);
    const int end = row[last] >> (used - 1) & 1;
    row[0] = row[1] & 1 ? UINT16_MAX : 0;
    row[last] = (uint16_t)(row[last] | (end ? (uint32_t)UINT16_MAX << used : 0));
    row[last + 1] = end ? UINT16_MAX : 0;
}

/* Codes one row of the brick. */
CVOL_INLINE int code_line(mask_coder *coder, mask_model *model, const cvol_mask_sums *table,
                          cvol_mask_brick *brick, mask_slices *slices, size_t y, size_t z,
                          int *last, int encode)
{
    uint16_t(*own)[HALVES] = slices->rows[z % 3] + y,
    (*before)[HALVES] = slices->rows[(z + 2) % 3] + y;
    uint16_t(*second)[HALVES] = slices->rows[(z + 1) % 3] + y, *row = own[2];
    const size_t at = y % CELL + CELL * (z % CELL);
    row[0] = own[1][1] & 1 ? UINT16_MAX : 0;
    for (size_t i = 0; i * CELL < brick->size[0]; i++) {
        const uint8_t state = brick->states[z / CELL][y / CELL][i];
        const int width = width_of(brick, i);
        cvol_mask_rows *planes = brick->rows[z / CELL][y / CELL][i];
        if (state != MIXED) {
            row[i + 1] = state ? (uint16_t)ones(width) : 0;
            continue;
        }
        uint32_t above[ABOVE], wanted = 0;
        for (int k = 0; k < 3; k++)
            above[k] = around_half(second[1 + k], i);
        for (int k = 0; k < 5; k++)
            above[3 + k] = around_half(before[k], i);
        above[8] = around_half(own[0], i);
        above[9] = around_half(own[1], i);
        for (int plane = 0; encode && plane < bits_of(brick->fills); plane++)
            wanted |= planes[plane].of[at];
        wanted = code_row(coder, model, table, above, row[i] >> 8, width, wanted, encode) >> 8;
        row[i + 1] = (uint16_t)wanted;
        if (brick->fills > 1)
            code_fills(coder, model, brick, planes, at, wanted, last, encode);
        else
            planes[0].of[at] = (uint16_t)wanted;
        if (*last >= brick->fills)
            return 0;
    }
    end_row(row, brick->size[0]);
    return 1;
}

CVOL_INLINE int code_brick(mask_coder *coder, cvol_mask_brick *brick, int outside, int encode)
{
    const cvol_mask_sums *table = cvol_mask_predictor();
    mask_model model;
    mask_slices slices;
    int last = 0;
    start_model(&model);
    outside = code_bit(coder, &model.outside, outside, encode);
    int is_sound = code_cells(coder, &model, brick, &last, encode);
    memset(&slices, outside ? 255 : 0, sizeof slices);
    for (size_t z = 0; is_sound && z < brick->size[2]; z++) {
        uint16_t(*own)[HALVES] = slices.rows[z % 3], (*before)[HALVES] = slices.rows[(z + 2) % 3];
        const size_t end = brick->size[1] + 2;
        memcpy(own[0], before[2], sizeof own[0]);
        memcpy(own[1], before[2], sizeof own[1]);
        for (size_t y = 0; is_sound && y < brick->size[1]; y++)
            is_sound = code_line(coder, &model, table, brick, &slices, y, z, &last, encode);
        memcpy(own[0], own[2], sizeof own[0]);
        memcpy(own[1], own[2], sizeof own[0]);
        memcpy(own[end], own[end - 1], sizeof own[0]);
        memcpy(own[end + 1], own[end - 1], sizeof own[0]);
    }
    return is_sound;
}

/* ---- encoding --------------------------------------------------------------------------- */

/* Tests if the brick has a masked sample; *outside: if more than half of its first slice is
 * masked. */
static int look_around(const cvol_mask_brick *brick, int *outside)
{
    size_t masked = 0;
    int any = 0;
    for (size_t l = 0; l < cells_along(brick->size[2]); l++)
        for (size_t j = 0; j < cells_along(brick->size[1]); j++)
            for (size_t i = 0; i < cells_along(brick->size[0]); i++) {
                const uint8_t state = brick->states[l][j][i];
                any |= state;
                for (size_t y = j * CELL; y < (j + 1) * CELL && y < brick->size[1] && !l; y++) {
                    uint32_t row = state == MIXED ? 0 : state ? ones(width_of(brick, i)) : 0;
                    for (int p = 0; p < bits_of(brick->fills) && state == MIXED; p++)
                        row |= brick->rows[l][j][i][p].of[y % CELL];
                    masked += (size_t)__builtin_popcount(row);
                }
            }
    *outside = 2 * masked > brick->size[0] * brick->size[1];
    return any;
}

int cvol_mask_encode(cvol_range_encoder *coder, cvol_bytes *out, cvol_mask_brick *brick)
{
    mask_coder both = {.to = coder};
    int outside;
    out->size = 0;
    if (!look_around(brick, &outside))
        return 1;
    cvol_range_encoder_start(coder);
    code_brick(&both, brick, outside, 1);
    return cvol_range_encoder_finish(coder, out);
}

/* ---- decoding --------------------------------------------------------------------------- */

int cvol_mask_decode(cvol_mask_brick *brick, cvol_span data)
{
    mask_coder coder = {0};
    memset(brick->states, 0, sizeof brick->states);
    if (!data.size)
        return 1;
    cvol_range_decoder_start(&coder.from, data.data, data.size);
    return code_brick(&coder, brick, 0, 0) && !cvol_range_decoder_overrun(&coder.from);
}
