/* The DCT of cells of 16^3 samples, which are split, like an octree, into DCTs of 16, 8 or 4
 * (Ahmed, Natarajan and Rao 1974; blocks of variable size: Vaisey and Gersho 1992): small ones for
 * sharp samples, large ones for smooth samples.
 *
 * A split is 9 bits. Bit 0: the cell is split into its octants of 8^3. Bit 1 + i, only with bit 0:
 * octant i = cx + 2 cy + 4 cz (c = 1: the upper half of an axis) is split into eight sub-blocks of
 * 4^3. A sub-block of M^3 samples that begins at sample b has the orthonormal coefficients
 *
 *     A[f, g, h] = sum_{x, y, z < M} D[f][x] D[g][y] D[h][z] a[bx + x, by + y, bz + z]
 *     D[f][x]    = c(f) cos(pi f (x + 1/2) / M),  c(0) = sqrt(1/M), c(f) = sqrt(2/M)
 *
 * Cells are dense arrays of 16^3 floats, x (or u) fastest. Coefficients are ordered by frequency
 * first: along an axis, frequency f has index u = f if the cell is whole, u = 2 f + c in an octant
 * of half c, and u = 4 f + 2 c' + c in the sub-block of quarter c' of half c. So a low box of the
 * cell holds the low frequencies of all its sub-blocks, and octant (cx, cy, cz) has the places of
 * the parities (cx, cy, cz) in every split. Octants are independent, so the coefficients of a mixed
 * split are copied, octant by octant, from the two uniform splits.
 */
#ifndef CVOL_TRANSFORM_CELL_H
#define CVOL_TRANSFORM_CELL_H

#include <stdint.h>

#define CVOL_CELL 16
#define CVOL_CELL_SAMPLES (CVOL_CELL * CVOL_CELL * CVOL_CELL)
#define CVOL_SUB_BLOCKS_MAX 64

/* All octants whole, all octants split. */
#define CVOL_CELL_WHOLE UINT16_C(0)
#define CVOL_CELL_OCTANTS UINT16_C(1)
#define CVOL_CELL_FOURS UINT16_C(0x1ff)

/* One DCT of a cell: its side M, its first sample, and the place of its frequency 0. Frequency f of
 * an axis has the place first + f (16 / M). */
typedef struct cvol_sub_block {
    int side;
    int begin[3], first[3];
} cvol_sub_block;

/* 1 if the split is valid: no bit beyond the nine, and bits 1 to 8 only with bit 0. */
int cvol_cell_valid_split(uint16_t split);

/* Lists the DCTs of a split, x fastest; returns their number. */
int cvol_cell_list_sub_blocks(cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX], uint16_t split);

/* The sums of the formulas above, in double precision, term by term: the reference for tests of the
 * fast ones. in and out may not overlap. */
void cvol_cell_forward_reference(float *out, const float *in, uint16_t split);
void cvol_cell_inverse_reference(float *out, const float *in, uint16_t split);

/* The same on vectors, 64-byte aligned cells. Bit-identical on every processor (no fused
 * multiply-add). The bits of an octant do not depend on the splits of the others. in and out may
 * not overlap. */
void cvol_cell_forward(float *out, const float *in, uint16_t split);
/* Coefficients at u >= box[0], v >= box[1] or w >= box[2] are taken as zero and not read. */
void cvol_cell_inverse(float *out, const float *in, uint16_t split, const int box[3]);

#endif
