/* The lapped transform's filter across the faces of cells (Tran, Liang and Tu 2003, "Lapped
 * transform via time-domain pre- and post-filtering"): before blocks are transformed, the
 * pre-filter mixes two samples on each side of every face, so that basis functions extend across
 * faces. After the inverse transform the post-filter undoes this, which smooths the jumps that
 * quantization causes there.
 *
 * The filter keeps the mirror-even part of the samples a0 a1 | a2 a3 at a face; the odd part
 *     w = (a1 - a2, a0 - a3)    becomes    V w,    V = J C2^T diag(s, 1) C4 J,    s = sqrt 2,
 * C2 the DCT-II and C4 the DCT-IV of two points, orthonormal, J the exchange of the two:
 *     P = 1/2 [I J; J -I] diag(I, V) [I J; J -I],
 * and the post-filter has V^-1. So constants stay unchanged, and, with H = (V - I) / 2, d = H w:
 *     a1 += d0,  a2 -= d0,  a0 += d1,  a3 -= d1.
 *
 * Axes are filtered one after the other; they commute except for rounding. Faces lie between
 * samples e - 1 and e of the volume, e = grid, 2 grid, ... A face is filtered if the volume has all
 * four samples: not at its ends, and not if the last cell has only one sample.
 *
 * Norms. C2 and C4 are orthogonal, so V has the singular values s and 1: the post-filter's L2 norm
 * is 1 (errors of coefficients do not grow), the pre-filter's sqrt 2, per axis; three axes are a
 * tensor product, whose norm is the product. In L-infinity the norm is the largest sum of a row's
 * magnitudes, 1 + cos(pi / 8) / 2 for the post-filter. White noise on coefficients keeps 7/8 of its
 * energy on the four samples: 1 - 1/32 per axis of a volume in cells of 16. Rounding: an output is
 * made of seven operations on numbers of the input's size, and its error is below 8 * 2^-24 of
 * the input in either norm, which the constants below include.
 */
#ifndef CVOL_TRANSFORM_LAP_H
#define CVOL_TRANSFORM_LAP_H

#include <stdint.h>

/* A box of samples of one volume in memory. */
typedef struct cvol_lap_box {
    int64_t shape[3]; /* of the volume */
    int64_t begin[3]; /* the box's first sample; the box may reach beyond the volume */
    int64_t size[3];
    int64_t stride[3]; /* floats from a sample to its neighbour along each axis */
    int64_t grid;      /* samples from face to face, at least 4: 16 for cells */
} cvol_lap_box;

/* Certified bounds of the filters' operator norms, rounding included: L2 ("norm") and L-infinity
 * ("peak"), of one axis and of all three. */
#define CVOL_LAP_POST_NORM 1.000001
#define CVOL_LAP_POST_NORM_3 1.000003
#define CVOL_LAP_POST_PEAK 1.461942
#define CVOL_LAP_POST_PEAK_3 3.124560
#define CVOL_LAP_PRE_NORM 1.414215
#define CVOL_LAP_PRE_NORM_3 2.828431

/* H of the pre- and of the post-filter, row by row. */
#define CVOL_LAP_PRE_H                                                                       \
    {                                                                                        \
        0.01798245740163906f, 0.3266407412190941f, -0.1352990250365492f, 0.0972387912921927f \
    }
#define CVOL_LAP_POST_H                                                                         \
    {                                                                                           \
        -0.07768840068963345f, -0.2309698831278217f, 0.09567085809127243f, -0.1337310918356290f \
    }

/* P of the pre-filter and its inverse: out[i] = sum_j P[i][j] a[j]. */
extern const float cvol_lap_pre_matrix[4][4];
extern const float cvol_lap_post_matrix[4][4];

/* Filters every face across `axis` whose four samples all lie in the box, in place; one thread.
 * samples is the box's first. A sample's result does not depend on the box nor on the processor, to
 * the bit. */
void cvol_lap_pre(float *samples, const cvol_lap_box *box, int axis);
void cvol_lap_post(float *samples, const cvol_lap_box *box, int axis);

/* The same by the definition of P, in double precision. */
void cvol_lap_pre_reference(float *samples, const cvol_lap_box *box, int axis);
void cvol_lap_post_reference(float *samples, const cvol_lap_box *box, int axis);

#endif
