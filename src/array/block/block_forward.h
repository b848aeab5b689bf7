/* From a block's samples to its coefficients, on the smallest number of points and frequencies: the
 * inverse of block_inverse.h.
 *
 *     A[u, v, w] = (B / points_y) (B / points_z) sum a[z][y][x] D_u[x] D_v[y] D_w[z]
 *
 * for u, v, w within `box`. This is exact if the samples' own degree and the frequency sum to less
 * than twice the points. The sheet axis comes first, then rows, then lanes. The symmetry D_v[M - 1
 * - y] = (-1)^v D_v[y] halves the work along z and y; lanes are the frequencies u in the end.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_FORWARD_H
#define CVOL_ARRAY_BLOCK_BLOCK_FORWARD_H

#include "base/vector.h"
#include "transform/block.h"

typedef struct cvol_forward_axes {
    int row_points, sheet_points;         /* along y and z: even, at most B */
    const float *row_basis, *sheet_basis; /* cvol_block_points_basis */
    const float *columns;                 /* cvol_block_columns */
    int box[3];                           /* requested frequencies along x, y, z */
} cvol_forward_axes;

/* `count` frequencies of a line of M samples, M even; neighbours lie in_stride and out_stride
 * floats apart. It makes four sums together: even and odd frequencies need different halves of the
 * folded line. */
CVOL_INLINE void cvol_lines_forward_of(float *out, ptrdiff_t out_stride, const float *in,
                                       ptrdiff_t in_stride, int count, const float *basis, int M)
{
    cvol_vf even[CVOL_BLOCK_MAX / 2], odd[CVOL_BLOCK_MAX / 2];
    const int half = M / 2;
    for (int i = 0; i < half; i++) {
        cvol_vf a = cvol_load(in + i * in_stride), b = cvol_load(in + (M - 1 - i) * in_stride);
        even[i] = a + b;
        odd[i] = a - b;
    }
    int v = 0;
    for (; v + 4 <= count; v += 4) {
        const float *row = basis + v * M;
        cvol_vf sum[4] = {{0}, {0}, {0}, {0}};
        for (int i = 0; i < half; i++) {
            sum[0] += row[i] * even[i];
            sum[1] += row[M + i] * odd[i];
            sum[2] += row[2 * M + i] * even[i];
            sum[3] += row[3 * M + i] * odd[i];
        }
        for (int k = 0; k < 4; k++)
            cvol_store(out + (v + k) * out_stride, sum[k]);
    }
    for (; v < count; v++) {
        cvol_vf sum = {0};
        for (int i = 0; i < half; i++)
            sum += basis[v * M + i] * (v & 1 ? odd[i] : even[i]);
        cvol_store(out + v * out_stride, sum);
    }
}

/* The common lengths with their loops unrolled; one function for all sizes of blocks. */
static __attribute__((noinline)) void cvol_lines_forward(float *out, ptrdiff_t out_stride,
                                                         const float *in, ptrdiff_t in_stride,
                                                         int count, const float *basis, int M)
{
    if (M == 16)
        cvol_lines_forward_of(out, out_stride, in, in_stride, count, basis, 16);
    else if (M == 10)
        cvol_lines_forward_of(out, out_stride, in, in_stride, count, basis, 10);
    else if (M == 8)
        cvol_lines_forward_of(out, out_stride, in, in_stride, count, basis, 8);
    else
        cvol_lines_forward_of(out, out_stride, in, in_stride, count, basis, M);
}

/* Along x: out row = sum_x in[x] columns[x], four rows together to keep the sums independent. */
CVOL_INLINE void cvol_rows_forward(float *out, const float *in, int rows, const float *columns,
                                   int B, int width)
{
    int row = 0;
    for (; row + 4 <= rows; row += 4)
        for (int part = 0; part < width; part += CVOL_LANES) {
            cvol_vf sum[4] = {{0}, {0}, {0}, {0}};
            for (int x = 0; x < B; x++) {
                cvol_vf column = cvol_load(columns + x * width + part);
                for (int r = 0; r < 4; r++)
                    sum[r] += in[(row + r) * width + x] * column;
            }
            for (int r = 0; r < 4; r++)
                if (part < B)
                    cvol_store_first(out + (row + r) * B + part, sum[r],
                                     B - part < CVOL_LANES ? B - part : CVOL_LANES);
        }
    for (; row < rows; row++)
        for (int part = 0; part < B; part += CVOL_LANES) {
            cvol_vf sum = {0};
            for (int x = 0; x < B; x++)
                sum += in[row * width + x] * cvol_load(columns + x * width + part);
            cvol_store_first(out + row * B + part, sum,
                             B - part < CVOL_LANES ? B - part : CVOL_LANES);
        }
}

/* in: slices of row_points rows of `width` lanes, destroyed; out[B^3]: set within box (whole rows
 * of it), unchanged outside. scratch: the size of in. */
CVOL_INLINE void cvol_block_forward_box(float *out, float *in, float *scratch,
                                        const cvol_forward_axes *axes, int B)
{
    const int width = B < 16 ? 16 : B;
    const ptrdiff_t row = width, sheet = (ptrdiff_t)axes->row_points * width;
    for (int y = 0; y < axes->row_points; y++)
        for (int part = 0; part < width; part += CVOL_LANES)
            cvol_lines_forward(scratch + y * row + part, sheet, in + y * row + part, sheet,
                               axes->box[2], axes->sheet_basis, axes->sheet_points);
    for (int w = 0; w < axes->box[2]; w++) {
        for (int part = 0; part < width; part += CVOL_LANES)
            cvol_lines_forward(in + part, row, scratch + w * sheet + part, row, axes->box[1],
                               axes->row_basis, axes->row_points);
        cvol_rows_forward(out + (ptrdiff_t)w * B * B, in, axes->box[1], axes->columns, B, width);
    }
}

#endif
