/* Subbands: places, norms, levels. */
#include "codec/brick/subbands.h"

#include <math.h>
#include <string.h>

#include "array/core/share.h"
#include "base/elementary.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/split_extension.h"
#include "codec/quantize/true_length.h"
#include "transform/cell.h"
#include "transform/lap.h"

/* A factor above the rounding error of sums of squares in double. */
#define NORM_ROUNDING 1.000001

/* The side of the sub-block that a place in a cell of 16 belongs to. */
static uint32_t part_side(uint32_t u, uint32_t v, uint32_t w, uint16_t split)
{
    const uint32_t octant = (u & 1) + 2 * (v & 1) + 4 * (w & 1);
    return !(split & 1) ? 16 : split >> (1 + octant) & 1 ? 4 : 8;
}

int cvol_subband_of(uint32_t place, int block_log2, uint16_t split)
{
    const uint32_t block = UINT32_C(1) << block_log2, mask = block - 1;
    const uint32_t u = place & mask, v = place >> block_log2 & mask, w = place >> 2 * block_log2;
    const uint32_t side = split ? part_side(u, v, w, split) : block, stride = block / side;
    uint32_t most = u > v ? u : v;
    most = (most > w ? most : w) / stride; /* the highest frequency */
    int subband = 0;
    while (subband < CVOL_SUBBANDS - 1) {
        const uint32_t edge = side >> (CVOL_SUBBANDS - 1 - subband);
        if (most < (edge ? edge : 1))
            break;
        subband++;
    }
    return subband;
}

/* Threads' stacks may be small: noinline keeps these arrays out of one common frame. */
#define NOINLINE static __attribute__((noinline))

/* The squared distance of a level's samples from the full cell, for a cell that crosses the
 * volume's end. */
NOINLINE double squared_gap(const cvol_block *block, const int32_t *level, const int inside[3])
{
    double lacks[CVOL_CELL_SAMPLES], all = 0;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        lacks[i] = 0 - (double)level[i];
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(4));
        lacks[place] = (double)value - (double)level[place];
    }
    cvol_true_length_from_terms(lacks, inside, block->split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        all += lacks[i] * lacks[i];
    return all;
}

/* Does the same for the level that has `left` subbands. */
NOINLINE double squared_gap_with(const cvol_block *block, const int32_t *coded, const int inside[3],
                                 int bits, int left)
{
    int32_t level[CVOL_CELL_SAMPLES];
    uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
    for (uint32_t place = 0; place < CVOL_CELL_SAMPLES; place++) {
        const int subband = cvol_subband_of(place, 4, block->split);
        level[place] = subband < left ? coded[place] : 0;
        found[place / 64] |= (uint64_t)(level[place] != 0) << place % 64;
    }
    cvol_true_length_take(level, found, inside, block->split, bits);
    return squared_gap(block, level, inside);
}

/* For a cell that crosses the volume's end: the differences of its levels' squared distances,
 * because terms are rounded in each level. */
NOINLINE void ended_squares(double squares[CVOL_SUBBANDS], const cvol_block *block,
                            const int inside[3], int bits)
{
    int32_t coded[CVOL_CELL_SAMPLES] = {0};
    double before = 0;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(4));
        coded[place] = value;
    }
    cvol_true_length_put(coded, inside, block->split, bits);
    for (int left = CVOL_SUBBANDS - 1; left >= 0; left--) {
        const double all = squared_gap_with(block, coded, inside, bits, left);
        squares[left] += fmax(all - before, 0);
        before = fmax(all, before);
    }
}

/* True if the cell crosses the volume's end; inside: its samples within the volume. */
static int find_inside(int inside[3], const cvol_array *array, size_t block)
{
    static const int origin[3] = {0, 0, 0};
    const size_t *blocks = array->blocks;
    cvol_cell_find_inside(inside, array->grid.dims,
                          (const size_t[3]){block % blocks[0], block / blocks[0] % blocks[1],
                                            block / blocks[0] / blocks[1]});
    return cvol_cell_reaches_beyond(inside, origin, CVOL_CELL);
}

void cvol_subband_squares(double squares[CVOL_SUBBANDS], const cvol_array *array, size_t index)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    const cvol_block *block = &array->block_table[index];
    const int block_log2 = array->block_log2;
    int inside[3];
    if (coding->true_length && block->words && find_inside(inside, array, index)) {
        ended_squares(squares, block, inside, coding->true_length);
        return;
    }
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        const double value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        squares[cvol_subband_of(place, block_log2, block->split)] += value * value;
    }
}

void cvol_subband_norms_of(double norm[CVOL_SUBBANDS], const double squares[CVOL_SUBBANDS],
                           double step)
{
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        norm[s] = sqrt(squares[s]) * step * NORM_ROUNDING;
}

void cvol_subband_norms(double norm[CVOL_SUBBANDS], const cvol_array *array)
{
    double squares[CVOL_SUBBANDS] = {0};
    for (size_t b = 0; b < array->block_count; b++)
        cvol_subband_squares(squares, array, b);
    cvol_subband_norms_of(norm, squares, array->step);
}

/* One process after the other adds its blocks to the sums of those before: the squares of cells
 * that cross the volume's end are no integers, so their sum depends on the order. */
int cvol_subband_norms_by_team(cvol_context *context, double norm[CVOL_SUBBANDS],
                               const cvol_array *array)
{
    const cvol_share share = cvol_share_of(context, array);
    double squares[CVOL_SUBBANDS] = {0};
    int code = CVOL_OK;
    for (int rank = 0; rank < share.team->size; rank++) {
        const int is_own = rank == share.team->rank;
        cvol_gathered all;
        for (size_t b = share.blocks[0]; b < share.blocks[1] && is_own; b++)
            cvol_subband_squares(squares, array, b);
        code = cvol_team_gather(context, &all, share.team, code, squares,
                                is_own ? sizeof squares : 0);
        if (!code)
            memcpy(squares, all.all, sizeof squares);
        cvol_gathered_free(&all);
    }
    cvol_subband_norms_of(norm, squares, array->step);
    return code;
}

void cvol_subbands_bound_level(cvol_array *array, const double norm[CVOL_SUBBANDS], int level)
{
    double left = 0;
    for (int s = CVOL_SUBBANDS - level; s < CVOL_SUBBANDS; s++)
        left = cvol_hypot(left, norm[s]);
    left *= NORM_ROUNDING * (array->lapped ? CVOL_LAP_POST_NORM_3 : 1);
    cvol_error_bound_widen(&array->error_bound, left, left);
    array->error_bound.max_abs += left;
    cvol_array_derive_figures(array);
}
