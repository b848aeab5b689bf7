/* One dense matrix along each axis of a block. Sums run in the same order whatever the instruction
 * set, without fused multiply-add. */
#include "array/block_transform.h"
#include "base/cpu.h"
#include "base/vector.h"

void CVOL_SIMD(cvol_block_matrix)(float *data, float *work, const float *matrix,
                                  const float *transposed, int rank, int block_log2);

/* Eight floats: as many as the smallest block has in a row. */
typedef float row8 __attribute__((vector_size(32)));

CVOL_INLINE row8 load8(const float *from)
{
    row8 v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* out[u] = sum_x matrix[u][x] in[x] along x, for `rows` rows. */
CVOL_INLINE void along_rows(float *out, const float *in, const float *transposed, int rows, int B)
{
    for (int row = 0; row < rows; row++)
        for (int part = 0; part < B; part += 8) {
            row8 sum = {0};
            for (int x = 0; x < B; x++)
                sum += in[row * B + x] * load8(transposed + x * B + part);
            memcpy(out + row * B + part, &sum, sizeof sum);
        }
}

/* The same along the axis whose neighbours lie `stride` floats apart, for `count` floats. */
CVOL_INLINE void across_rows(float *out, const float *in, const float *matrix, int stride,
                             int count, int B)
{
    for (int start = 0; start < count; start += stride * B)
        for (int part = 0; part < stride; part += 8)
            for (int u = 0; u < B; u++) {
                row8 sum = {0};
                for (int x = 0; x < B; x++)
                    sum += matrix[u * B + x] * load8(in + start + x * stride + part);
                memcpy(out + start + u * stride + part, &sum, sizeof sum);
            }
}

CVOL_INLINE void apply(float *data, float *work, const float *matrix, const float *transposed,
                       int rank, int B)
{
    const int count = rank == 3 ? B * B * B : rank == 2 ? B * B : B;
    along_rows(work, data, transposed, count / B, B);
    if (rank > 1)
        across_rows(data, work, matrix, B, count, B);
    if (rank > 2)
        across_rows(work, data, matrix, B * B, count, B);
    if (rank != 2)
        memcpy(data, work, sizeof(float) * (size_t)count);
}

void CVOL_SIMD(cvol_block_matrix)(float *data, float *work, const float *matrix,
                                  const float *transposed, int rank, int block_log2)
{
    if (block_log2 == 3)
        apply(data, work, matrix, transposed, rank, 8);
    else if (block_log2 == 4)
        apply(data, work, matrix, transposed, rank, 16);
    else
        apply(data, work, matrix, transposed, rank, 32);
}
