/* The DCT-II of cubic blocks, B = 8, 16 or 32 (Ahmed, Natarajan and Rao 1974), orthonormal:
 *
 *     A[u, v, w] = sum_{x, y, z < B} D[u][x] D[v][y] D[w][z] a[x, y, z]
 *     a[x, y, z] = sum_{u, v, w < B} D[u][x] D[v][y] D[w][z] A[u, v, w]
 *     D[u][x]    = c(u) cos(pi u (x + 1/2) / B),  c(0) = sqrt(1/B), c(u) = sqrt(2/B)
 *
 * Blocks are dense arrays of B^3 floats, x (or u) fastest.
 */
#ifndef CVOL_TRANSFORM_BLOCK_H
#define CVOL_TRANSFORM_BLOCK_H

#define CVOL_BLOCK_MAX 32

/* D[u][x] of a block side; basis[u * B + x]. Static, read-only after the first call. */
const float *cvol_block_basis(int block);

/* The basis at `points` places (even, at most B) that are symmetric about the block's centre and
 * span it like its samples: basis[u * points + i] = c(u) cos(pi u (i + 1/2) / points), with the
 * c(u) of B. Static. */
const float *cvol_block_points_basis(int block, int points);
/* columns[x * width + u] = D[u][x], rows padded with zeros to width = max(B, 16). Static. */
const float *cvol_block_columns(int block);
/* basis[u * width + x] = D[u][x], padded likewise. Static. */
const float *cvol_block_lane_basis(int block);

/* The transforms by the formulas above, in double precision, one dimension after the other: the
 * reference for tests of the fast ones. in and out may not overlap. */
void cvol_block_forward_reference(float *out, const float *in, int block);
void cvol_block_inverse_reference(float *out, const float *in, int block);

/* The same on vectors of 16 floats, 64-byte aligned blocks. Bit-identical on every processor
 * (no fused multiply-add). in and out may not overlap. */
void cvol_block_forward(float *out, const float *in, int block);

#endif
