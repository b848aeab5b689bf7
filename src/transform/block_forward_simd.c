/* The forward block transform on rows of floats, separable: x, then y, then z.
 *
 * Lanes are the frequencies u: a row's transform is a sum of basis columns, each weighted by one
 * sample. Rows then combine along y and z; there the basis' symmetry D[v][B - 1 - y] = (-1)^v
 * D[v][y] halves the work: even frequencies need only a[y] + a[B-1-y], odd ones only the
 * difference.
 */
#include "base/cpu.h"
#include "base/vector.h"
#include "transform/block.h"

void CVOL_SIMD(cvol_block_forward)(float *out, const float *in, const float *basis, int block);

/* Rows are `width` floats wide, a multiple of the lanes: 16 for B = 8 and 16, 32 for 32. */

/* columns[x][u] = D[u][x], padded to `width`. */
CVOL_INLINE void transpose_basis(float *columns, const float *basis, int B, int width)
{
    for (int x = 0; x < B; x++)
        for (int u = 0; u < width; u++)
            columns[x * width + u] = u < B ? basis[u * B + x] : 0;
}

/* Along x: out row = sum_x in[x] columns[x]. Rows of `out` are `width` floats apart. */
CVOL_INLINE void transform_x(float *out, const float *in, const float *columns, int B, int width)
{
    for (int row = 0; row < B * B; row++)
        for (int part = 0; part < width; part += CVOL_LANES) {
            cvol_vf sum = {0};
            for (int x = 0; x < B; x++)
                sum += in[row * B + x] * cvol_load(columns + x * width + part);
            cvol_store(out + row * width + part, sum);
        }
}

/* Along the axis whose neighbours lie `stride` floats apart, for CVOL_LANES lines; out may be
 * in. */
CVOL_INLINE void transform_line(float *out, const float *in, const float *basis, int B, int stride)
{
    cvol_vf even[CVOL_BLOCK_MAX / 2], odd[CVOL_BLOCK_MAX / 2];
    for (int i = 0; i < B / 2; i++) {
        cvol_vf a = cvol_load(in + i * stride), b = cvol_load(in + (B - 1 - i) * stride);
        even[i] = a + b;
        odd[i] = a - b;
    }
    for (int v = 0; v < B; v += 2) {
        cvol_vf sum_even = {0}, sum_odd = {0};
        for (int i = 0; i < B / 2; i++) {
            sum_even += basis[v * B + i] * even[i];
            sum_odd += basis[(v + 1) * B + i] * odd[i];
        }
        cvol_store(out + v * stride, sum_even);
        cvol_store(out + (v + 1) * stride, sum_odd);
    }
}

CVOL_INLINE void forward(float *out, const float *in, const float *basis, int B)
{
    const int width = B < 16 ? 16 : B;
    float columns[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float wide[8 * 8 * 16] __attribute__((aligned(64)));
    float *work = B == width ? out : wide;
    transpose_basis(columns, basis, B, width);
    transform_x(work, in, columns, B, width);
    for (int z = 0; z < B; z++)
        for (int part = 0; part < width; part += CVOL_LANES)
            transform_line(work + z * B * width + part, work + z * B * width + part, basis, B,
                           width);
    for (int y = 0; y < B; y++)
        for (int part = 0; part < width; part += CVOL_LANES)
            transform_line(work + y * width + part, work + y * width + part, basis, B, B * width);
    for (int row = 0; row < B * B && work != out; row++)
        memcpy(out + row * B, work + row * width, sizeof(float) * (size_t)B);
}

void CVOL_SIMD(cvol_block_forward)(float *out, const float *in, const float *basis, int block)
{
    if (block == 8)
        forward(out, in, basis, 8);
    else if (block == 16)
        forward(out, in, basis, 16);
    else
        forward(out, in, basis, 32);
}
