/* The coding order of a sub-block's coefficients, and their contexts from neighbours.
 *
 * A sub-block is one DCT of side M = 4, 8, 16 or 32. Its coefficients (u, v, w) are coded in
 * *subbands* of cubes: max(u, v, w) below 1, 2, 4, 8, 16, 32; within a subband in order of u + v +
 * w, ties in order of place u + M v + M^2 w. So index i lies in the cube of side 2^c if i < 8^c,
 * and the bit length of an index gives its subband.
 *
 * A coefficient's context consists of
 * - its level: the scattered sum of the magnitudes m (clamped to 4000) of earlier coefficients
 *   nearby: one at (u, v, w) adds 2 m to its neighbours at distance 1 along an axis, and m to those
 *   at (2, 0, 0), (1, 1, 0) and permutations; the DC adds at most as a 2. The sum has 22 classes;
 * - its band: six classes of (u + v + w) / M, times the number of zeros among u, v, w (0, 1, 2).
 *
 * A sub-block that crosses the volume's end (true_length.h) has only coefficients below n[]: its
 * scan is the full scan without the others, and it codes indices of the full scan. */
#ifndef CVOL_CODEC_ENTROPY_SCAN_H
#define CVOL_CODEC_ENTROPY_SCAN_H

#include <stdint.h>
#include <string.h>

#include "base/vector.h"

enum {
    CVOL_SUB_BLOCK_SIZES = 4, /* sides 4, 8, 16, 32: size class 0 .. 3 */
    CVOL_SUB_BLOCK_SAMPLES_MAX = 32 * 32 * 32,
    CVOL_SCATTER_MAX = 34 * 34 * 34,
    CVOL_BANDS = 18,
    CVOL_LEVELS = 22,
    CVOL_FINE_LEVELS = 26,
    CVOL_SCAN_RUNS_MAX = 256,
    CVOL_SCAN_NONE = 65535,
    CVOL_LEVEL_TABLE = 1024,
    CVOL_SCATTER_LIMIT = 4000
};

/* One place of a scan order. */
typedef struct cvol_scan_entry {
    uint16_t place;   /* u + M v + M^2 w */
    uint16_t in_cell; /* of sub-blocks in cells of 16^3, an offset from frequency 0: (16 / M) (u
                         + 16 v + 256 w); M = 32: same as place */
    uint16_t scatter; /* the same with sides of M + 2, so that scattering needs no bounds checks */
    uint16_t band;
} cvol_scan_entry;

typedef struct cvol_scan {
    int side, count, size_class;
    int row, sheet;                 /* strides of the scattered sums */
    const cvol_scan_entry *entries; /* count = M^3 entries */
    const uint16_t *index_of_place; /* the inverse */
    /* Ends of runs of indices, from 1 on, in which no coefficient is in another's context; the last
     * one is count. */
    const uint16_t *run_ends;
    const uint16_t *index;   /* index in the full scan; of full scans the same index */
    const uint16_t *compact; /* the inverse; CVOL_SCAN_NONE for missing places */
    int subband_end[4];      /* one past the last entry of each subband (brick_code.h) */
    int weight;              /* a DC times this is comparable between sub-blocks: 2^16 /
                                sqrt(number of samples) */
} cvol_scan;

/* The scan of a size class; static, read-only after the first call. */
const cvol_scan *cvol_sub_block_scan_of(int size_class);
/* The scan of a sub-block that crosses the volume's end, with n[] coefficients along each axis;
 * malloc's, or NULL. */
cvol_scan *cvol_sub_block_scan_ended(int size_class, const int n[3]);
/* Classes of sums below CVOL_LEVEL_TABLE; valid after the first cvol_sub_block_scan_of. */
extern uint8_t cvol_level_table[CVOL_LEVEL_TABLE];
extern uint8_t cvol_fine_level_table[CVOL_LEVEL_TABLE];

CVOL_INLINE int cvol_bit_length(uint32_t value)
{
    return 32 - __builtin_clz(value);
}

/* The class of a scattered sum. */
CVOL_INLINE int cvol_level_of(uint32_t sum)
{
    if (__builtin_expect(sum < CVOL_LEVEL_TABLE, 1))
        return cvol_level_table[sum];
    return 17 + (sum > 1600) + (sum > 3200) + (sum > 6400) + (sum > 12800);
}

/* The same for sums of trellis-quantized values, which are twice as large. */
CVOL_INLINE int cvol_fine_level_of(uint32_t sum)
{
    if (__builtin_expect(sum < CVOL_LEVEL_TABLE, 1))
        return cvol_fine_level_table[sum];
    return 20 + (sum > 1600) + (sum > 3200) + (sum > 6400) + (sum > 12800) + (sum > 25600);
}

/* Adds a magnitude to the nine later neighbours. `at` is the coefficient's place among the sums. */
CVOL_INLINE void cvol_scatter(uint16_t *at, int row, int sheet, uint32_t magnitude)
{
    const uint16_t once = (uint16_t)(magnitude < CVOL_SCATTER_LIMIT ? magnitude
                                                                    : CVOL_SCATTER_LIMIT);
    const uint16_t twice = (uint16_t)(2 * once);
    at[1] = (uint16_t)(at[1] + twice);
    at[row] = (uint16_t)(at[row] + twice);
    at[sheet] = (uint16_t)(at[sheet] + twice);
    at[2] = (uint16_t)(at[2] + once);
    at[2 * row] = (uint16_t)(at[2 * row] + once);
    at[2 * sheet] = (uint16_t)(at[2 * sheet] + once);
    at[1 + row] = (uint16_t)(at[1 + row] + once);
    at[1 + sheet] = (uint16_t)(at[1 + sheet] + once);
    at[row + sheet] = (uint16_t)(at[row + sheet] + once);
}

CVOL_INLINE uint32_t cvol_magnitude(int32_t value)
{
    return value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
}

/* The DC predicts the other coefficients poorly: it counts as 2 at most. */
CVOL_INLINE void cvol_scatter_dc(uint16_t *sums, int row, int sheet, int32_t dc)
{
    const uint32_t magnitude = cvol_magnitude(dc);
    cvol_scatter(sums, row, sheet, magnitude < 2 ? magnitude : 2);
}

/* The size class of a sub-block's side. */
CVOL_INLINE int cvol_size_class(int side)
{
    return __builtin_ctz((unsigned)side) - 2;
}

/* Zeros the sums of a cube of frequencies below `side`, and two places beyond it. */
CVOL_INLINE void cvol_scatter_clear(uint16_t *sums, int row, int sheet, int side)
{
    for (int w = 0; w < side + 2; w++)
        memset(sums + w * sheet, 0, sizeof *sums * (size_t)((side + 1) * row + side + 2));
}

/* One past the last index of subband s (brick_code.h) of a sub-block of this size class. */
CVOL_INLINE int cvol_subband_end(int size_class, int subband)
{
    const int log2 = size_class + 2 - (3 - subband);
    return 1 << 3 * (log2 > 0 ? log2 : 0);
}

#endif
