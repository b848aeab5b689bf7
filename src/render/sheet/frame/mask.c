/* Masks, by blocks. On fewer points than samples, the cover of a point is interpolated between the
 * two samples around it, linearly but steeper, along lanes and along rows. */
#include "render/sheet/frame/mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* A row's bits are in words of 16. */
static int int16_of(int block)
{
    return (block + 15) / 16;
}

static size_t int16_of_block(int block)
{
    return 2 * (size_t)(block * block * int16_of(block));
}

static void set_bit(uint16_t *row, int i)
{
    row[i / 16] = (uint16_t)(row[i / 16] | 1u << i % 16);
}

/* Makes both sets of rows of a block from the flags `which` of its samples within the volume. */
static void make_bits(uint16_t *bits, const uint8_t *which, const int size[3], int block)
{
    const int words = int16_of(block);
    uint16_t *along_x = bits, *along_y = bits + block * block * words;
    memset(bits, 0, sizeof *bits * int16_of_block(block));
    for (int z = 0; z < block; z++)
        for (int y = 0; y < block; y++) {
            const uint8_t *from = which + ((z < size[2] ? z : size[2] - 1) * size[1] +
                                           (y < size[1] ? y : size[1] - 1)) *
                                              size[0];
            for (int x = 0; x < block; x++) {
                if (!from[x < size[0] ? x : size[0] - 1])
                    continue;
                set_bit(along_x + (z * block + y) * words, x);
                set_bit(along_y + (z * block + x) * words, y);
            }
        }
}

/* ---- blocks equal to mask blocks ------------------------------------------------------------- */

void cvol_sheet_mask_rows(uint16_t rows[CVOL_MASK_ROWS], const cvol_mask *mask,
                          const size_t cell[3])
{
    const cvol_mask_rows *of_bits;
    const int fills = cvol_mask_fills(mask)->count, bits = fills < 2 ? 1 : fills < 4 ? 2 : 3;
    cvol_mask_cell_get(mask, cell, &of_bits);
    memcpy(rows, of_bits[0].of, CVOL_MASK_ROWS * sizeof *rows);
    for (int b = 1; b < bits; b++)
        for (int i = 0; i < CVOL_MASK_ROWS; i++)
            rows[i] = (uint16_t)(rows[i] | of_bits[b].of[i]);
}

/* Bit j of word i becomes bit i of word j. */
static void transpose(uint16_t a[16])
{
    uint16_t m = 0x00ff;
    for (int j = 8; j; j >>= 1, m = (uint16_t)(m ^ m << j))
        for (int k = 0; k < 16; k = (k + j + 1) & ~j) {
            const int t = (a[k] >> j ^ a[k + j]) & m;
            a[k] = (uint16_t)(a[k] ^ t << j);
            a[k + j] = (uint16_t)(a[k + j] ^ t);
        }
}

/* Both sets of rows of a block of the mask, `size` of whose samples are within the volume. */
static void make_cell_bits(uint16_t *bits, const uint16_t *rows, const int size[3])
{
    uint16_t *along_x = bits, *along_y = bits + CVOL_MASK_ROWS;
    const unsigned within = (1u << size[0]) - 1;
    for (int z = 0; z < CVOL_MASK_CELL; z++) {
        for (int y = 0; y < CVOL_MASK_CELL; y++) {
            const unsigned row = rows[(y < size[1] ? y : size[1] - 1) +
                                      CVOL_MASK_CELL * (z < size[2] ? z : size[2] - 1)] &
                                 within;
            const int last = row >> (size[0] - 1) & 1;
            along_x[CVOL_MASK_CELL * z + y] = (uint16_t)(last ? row | ~within : row);
        }
        memcpy(along_y + CVOL_MASK_CELL * z, along_x + CVOL_MASK_CELL * z,
               CVOL_MASK_CELL * sizeof *bits);
        transpose(along_y + CVOL_MASK_CELL * z);
    }
}

static int count_cell(const uint16_t *rows, const int size[3])
{
    int count = 0;
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            count += __builtin_popcount(rows[y + CVOL_MASK_CELL * z] & ((1u << size[0]) - 1));
    return count;
}

/* The rows and the size of the mask's block that begins there. */
static void find_cell(uint16_t rows[CVOL_MASK_ROWS], int size[3], const cvol_array *array,
                      const size_t begin[3])
{
    size_t cell[3];
    for (int a = 0; a < 3; a++) {
        const size_t left = array->grid.dims[a] - begin[a];
        cell[a] = begin[a] / CVOL_MASK_CELL;
        size[a] = left < CVOL_MASK_CELL ? (int)left : CVOL_MASK_CELL;
    }
    cvol_sheet_mask_rows(rows, array->mask, cell);
}

/* ---- any blocks ------------------------------------------------------------------------------ */

/* Returns 1 if a block is one block of the mask and all of its samples are of one kind; otherwise
 * the samples must be examined. */
static int is_plain_cell(cvol_mask_state *state, const cvol_array *array, const size_t begin[3])
{
    if (array->block != CVOL_MASK_CELL)
        return 0;
    const size_t cell[3] = {begin[0] / CVOL_MASK_CELL, begin[1] / CVOL_MASK_CELL,
                            begin[2] / CVOL_MASK_CELL};
    *state = cvol_mask_cell(array->mask, cell);
    return *state != CVOL_MASK_SOME;
}

/* Finds the samples of a block that are within the volume; returns how many of them are masked. */
static size_t get_block(uint8_t *which, int size[3], const cvol_array *array, const size_t begin[3])
{
    size_t end[3];
    for (int a = 0; a < 3; a++) {
        end[a] = begin[a] + (size_t)array->block;
        end[a] = end[a] < array->grid.dims[a] ? end[a] : array->grid.dims[a];
        size[a] = (int)(end[a] - begin[a]);
    }
    return cvol_mask_get(which, array->mask, begin, end);
}

static cvol_mask_state find_state(const cvol_array *array, size_t index)
{
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    size_t begin[3];
    int size[3];
    cvol_mask_state state;
    cvol_block_origin(begin, array, index);
    if (is_plain_cell(&state, array, begin))
        return state;
    size_t masked;
    if (array->block == CVOL_MASK_CELL) {
        uint16_t rows[CVOL_MASK_ROWS];
        find_cell(rows, size, array, begin);
        masked = (size_t)count_cell(rows, size);
    } else {
        masked = get_block(which, size, array, begin);
    }
    return masked == 0                                       ? CVOL_MASK_NONE
           : masked == (size_t)(size[0] * size[1] * size[2]) ? CVOL_MASK_ALL
                                                             : CVOL_MASK_SOME;
}

static void make_block_bits(uint16_t *bits, const cvol_array *array, size_t index)
{
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    uint16_t rows[CVOL_MASK_ROWS];
    size_t begin[3];
    int size[3];
    cvol_block_origin(begin, array, index);
    if (array->block == CVOL_MASK_CELL) {
        find_cell(rows, size, array, begin);
        make_cell_bits(bits, rows, size);
    } else {
        get_block(which, size, array, begin);
        make_bits(bits, which, size, array->block);
    }
}

int cvol_sheet_mask_make(cvol_context *context, cvol_sheet_mask *mask, const cvol_array *array)
{
    const size_t words = int16_of_block(array->block);
    size_t mixed = 0;
    mask->block = array->block;
    mask->states = cvol_allocate(array->block_count, 1);
    mask->mixed = cvol_allocate(array->block_count, sizeof *mask->mixed);
    if (!mask->states || !mask->mixed) {
        cvol_sheet_mask_free(mask);
        return cvol_fail_memory(context, array->block_count, "a mask's blocks");
    }
    for (size_t i = 0; i < array->block_count; i++) {
        mask->states[i] = (uint8_t)find_state(array, i);
        mask->mixed[i] = (uint32_t)mixed;
        mixed += mask->states[i] == CVOL_MASK_SOME;
    }
    mask->bytes = mixed * words * sizeof *mask->bits;
    mask->bits = cvol_allocate(mixed ? mixed : 1, words * sizeof *mask->bits);
    if (!mask->bits) {
        cvol_sheet_mask_free(mask);
        return cvol_fail_memory(context, mixed * words, "a mask's samples");
    }
    for (size_t i = 0; i < array->block_count; i++)
        if (mask->states[i] == CVOL_MASK_SOME)
            make_block_bits(mask->bits + mask->mixed[i] * words, array, i);
    return CVOL_OK;
}

float cvol_sheet_background(const cvol_array *array, const cvol_mask *mask)
{
    if (!cvol_mask_is_background(mask))
        return 0;
    return (float)(cvol_fills_value(cvol_mask_fills(mask), 0, array->grid.type) - array->offset);
}

void cvol_sheet_mask_free(cvol_sheet_mask *mask)
{
    free(mask->states);
    free(mask->mixed);
    free(mask->bits);
    *mask = (cvol_sheet_mask){0};
}

/* A block's rows along the lanes of a view: row r of slice z begins at first[r row_step + z
 * sheet_step]. */
typedef struct block_bits {
    const uint16_t *first;
    int row_step, sheet_step;
} block_bits;

static block_bits find_bits(const cvol_sheet_plan *plan, const cvol_sheet_mask *mask, size_t index)
{
    const int words = int16_of(mask->block), lines = mask->block * words;
    block_bits bits = {mask->bits + mask->mixed[index] * int16_of_block(mask->block), lines, words};
    if (plan->axis_sheet == 2)
        bits = (block_bits){bits.first, words, lines};
    if (plan->axis_lane == 1)
        bits.first += mask->block * lines;
    return bits;
}

void cvol_sheet_mask_prefetch(const cvol_sheet_mask *mask, const cvol_sheet_plan *plan,
                              size_t index)
{
    enum { LINE = 32 }; /* words of a cache line */
    if (mask->states[index] != CVOL_MASK_SOME)
        return;
    const size_t count = (size_t)mask->block * (size_t)mask->block * (size_t)int16_of(mask->block);
    const uint16_t *bits = mask->bits + mask->mixed[index] * int16_of_block(mask->block) +
                           (plan->axis_lane == 1 ? count : 0);
    for (size_t word = 0; word < count; word += LINE)
        __builtin_prefetch(bits + word);
}

/* Between an unmasked and a masked sample, cover rises this much faster than linearly. Points lie
 * further apart than samples, and linear interpolation between them makes edges even softer: for a
 * brain on three quarters of the points this cost 0.25 dB. A larger value gains more there, but
 * less for objects with thin edges (test_background). */
#define STEEPER 1.25

static void find_points(cvol_mask_points *p, int points, double first, double pitch, int block)
{
    p->count = points;
    p->are_samples = points == block;
    for (int i = 0; i < points; i++) {
        const double at = first + i * pitch;
        p->near[i] = (int)at;
        p->far[i] = p->near[i] + 1 < block ? p->near[i] + 1 : block - 1;
        p->weight[i] = (float)fmin(fmax(STEEPER * (at - p->near[i] - 0.5) + 0.5, 0), 1);
    }
}

void cvol_mask_points_find(cvol_mask_points points[3], const cvol_sheet_plan *plan, int block)
{
    find_points(&points[0], plan->points_lane, plan->first_lane, plan->pitch_lane, block);
    find_points(&points[1], plan->points_row, plan->first_row, plan->pitch_row, block);
    find_points(&points[2], plan->points_sheet, plan->first_sheet, plan->pitch_sheet, block);
}

/* Finds the positions of a block's points among its bits. */
static cvol_mask_grid find_grid(const cvol_sheet_plan *plan, const cvol_mask_points points[3],
                                const cvol_sheet_mask *mask, size_t index)
{
    const block_bits bits = find_bits(plan, mask, index);
    return (cvol_mask_grid){.bits = bits.first,
                            .row_step = bits.row_step,
                            .sheet_step = bits.sheet_step,
                            .block = mask->block,
                            .lane = &points[0],
                            .row = &points[1],
                            .sheet = &points[2]};
}

static void fill(const cvol_sheet_piece *p, const cvol_sheet_plan *plan, float value)
{
    for (int z = 0; z < p->sheets; z++)
        for (int y = 0; y < p->rows; y++) {
            float *at = (float *)p->at + z * p->sheet_stride + y * p->row_stride;
            for (int x = 0; x < plan->points_lane; x++)
                at[x] = value;
        }
}

static void fill_int16(const cvol_sheet_piece *p, const cvol_sheet_plan *plan, int16_t value)
{
    for (int z = 0; z < p->sheets; z++)
        for (int y = 0; y < p->rows; y++) {
            int16_t *at = (int16_t *)p->at + z * p->sheet_stride + y * p->row_stride;
            for (int x = 0; x < plan->points_lane; x++)
                at[x] = value;
        }
}

void cvol_sheet_mask_cover(const cvol_sheet_piece *piece, const cvol_sheet_plan *plan,
                           const cvol_mask_points points[3], const cvol_sheet_mask *mask,
                           size_t index)
{
    if (mask->states[index] != CVOL_MASK_SOME) {
        fill(piece, plan, mask->states[index] == CVOL_MASK_NONE);
        return;
    }
    const cvol_mask_grid grid = find_grid(plan, points, mask, index);
    CVOL_SIMD_CHOOSE(cvol_sheet_cover)(piece, &grid);
}

void cvol_sheet_mask_fill(const cvol_sheet_piece *p, const cvol_sheet_plan *plan,
                          const cvol_mask_points points[3], const cvol_sheet_mask *mask,
                          size_t index, float background)
{
    const int is_int16 = plan->int16.scale > 0;
    const int16_t word = is_int16 ? cvol_int16_scale_of(&plan->int16, background) : 0;
    if (mask->states[index] == CVOL_MASK_NONE)
        return;
    if (mask->states[index] == CVOL_MASK_ALL) {
        if (is_int16)
            fill_int16(p, plan, word);
        else
            fill(p, plan, background);
        return;
    }
    if (!points[0].are_samples || !points[1].are_samples || !points[2].are_samples) {
        const cvol_mask_grid grid = find_grid(plan, points, mask, index);
        if (is_int16)
            CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked_points_int16)(p, &grid, word);
        else
            CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked_points)(p, &grid, background);
        return;
    }
    block_bits bits = find_bits(plan, mask, index);
    bits.first += p->row * bits.row_step + p->sheet * bits.sheet_step;
    if (is_int16)
        CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked_int16)
    (p->at, p->row_stride, p->sheet_stride, p->rows, p->sheets, mask->block, bits.first,
     bits.row_step, bits.sheet_step, word);
    else CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked)(p->at, p->row_stride, p->sheet_stride, p->rows,
                                                  p->sheets, mask->block, bits.first, bits.row_step,
                                                  bits.sheet_step, background);
}
