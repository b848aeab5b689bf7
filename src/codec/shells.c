/* Shells: places, norms, levels. */
#include "codec/shells.h"

#include <math.h>

#include "transform/cell.h"
#include "transform/lap.h"

/* More than sums of squares of doubles may be too small by. */
#define NORM_ROUNDING 1.000001

/* The side of the part that a place of a cell of 16 belongs to. */
static uint32_t part_side(uint32_t u, uint32_t v, uint32_t w, uint16_t split)
{
    const uint32_t octant = (u & 1) + 2 * (v & 1) + 4 * (w & 1);
    return !(split & 1) ? 16 : split >> (1 + octant) & 1 ? 4 : 8;
}

int cvol_shell_of(uint32_t place, int block_log2, uint16_t split)
{
    const uint32_t block = UINT32_C(1) << block_log2, mask = block - 1;
    const uint32_t u = place & mask, v = place >> block_log2 & mask, w = place >> 2 * block_log2;
    const uint32_t side = split ? part_side(u, v, w, split) : block, stride = block / side;
    uint32_t most = u > v ? u : v;
    most = (most > w ? most : w) / stride; /* the highest frequency */
    int shell = 0;
    while (shell < CVOL_SHELLS - 1) {
        const uint32_t edge = side >> (CVOL_SHELLS - 1 - shell);
        if (most < (edge ? edge : 1))
            break;
        shell++;
    }
    return shell;
}

void cvol_shell_squares(double squares[CVOL_SHELLS], const cvol_block *block, int block_log2)
{
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        const double value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        squares[cvol_shell_of(place, block_log2, block->split)] += value * value;
    }
}

void cvol_shell_norms_of(double norm[CVOL_SHELLS], const double squares[CVOL_SHELLS], double step)
{
    for (int s = 0; s < CVOL_SHELLS; s++)
        norm[s] = sqrt(squares[s]) * step * NORM_ROUNDING;
}

void cvol_shell_norms(double norm[CVOL_SHELLS], const cvol_array *array)
{
    double squares[CVOL_SHELLS] = {0};
    for (size_t b = 0; b < array->block_count; b++)
        cvol_shell_squares(squares, &array->block_table[b], array->block_log2);
    cvol_shell_norms_of(norm, squares, array->step);
}

void cvol_shells_leave(cvol_array *array, const double norm[CVOL_SHELLS], int level)
{
    double left = 0;
    for (int s = CVOL_SHELLS - level; s < CVOL_SHELLS; s++)
        left = hypot(left, norm[s]);
    left *= NORM_ROUNDING * (array->lapped ? CVOL_LAP_POST_NORM_3 : 1);
    array->ledger.l2_error += left;
    array->ledger.max_abs += left;
    cvol_array_derive_figures(array);
}
