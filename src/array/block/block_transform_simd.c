/* One dense matrix along each axis of a block. Sums have the same order for every instruction set,
 * without fused multiply-add. */
#include "array/block/block_transform.h"
#include "base/cpu.h"
#include "base/vector.h"
#include "transform/block.h"

void CVOL_SIMD(cvol_block_matrix)(float *data, const float *matrix, const float *transposed,
                                  int rank, int block_log2);

/* Eight floats: a row of the smallest block. */
typedef float row8 __attribute__((vector_size(32)));

CVOL_INLINE row8 load8(const float *from)
{
    row8 v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* In place: out[u] = sum_x matrix[u][x] in[x] along x, for `rows` rows. */
CVOL_INLINE void along_rows(float *data, const float *transposed, int rows, int B)
{
    float in[CVOL_BLOCK_MAX];
    for (int row = 0; row < rows; row++) {
        memcpy(in, data + row * B, sizeof *in * (size_t)B);
        for (int part = 0; part < B; part += 8) {
            row8 sum = {0};
            for (int x = 0; x < B; x++)
                sum += in[x] * load8(transposed + x * B + part);
            memcpy(data + row * B + part, &sum, sizeof sum);
        }
    }
}

/* The same along the axis whose neighbours lie `stride` floats apart, for `count` floats. */
CVOL_INLINE void across_rows(float *data, const float *matrix, int stride, int count, int B)
{
    row8 in[CVOL_BLOCK_MAX];
    for (int start = 0; start < count; start += stride * B)
        for (int part = 0; part < stride; part += 8) {
            for (int x = 0; x < B; x++)
                in[x] = load8(data + start + x * stride + part);
            for (int u = 0; u < B; u++) {
                row8 sum = {0};
                for (int x = 0; x < B; x++)
                    sum += matrix[u * B + x] * in[x];
                memcpy(data + start + u * stride + part, &sum, sizeof sum);
            }
        }
}

CVOL_INLINE void apply(float *data, const float *matrix, const float *transposed, int rank, int B)
{
    const int count = rank == 3 ? B * B * B : rank == 2 ? B * B : B;
    along_rows(data, transposed, count / B, B);
    if (rank > 1)
        across_rows(data, matrix, B, count, B);
    if (rank > 2)
        across_rows(data, matrix, B * B, count, B);
}

void CVOL_SIMD(cvol_block_matrix)(float *data, const float *matrix, const float *transposed,
                                  int rank, int block_log2)
{
    if (block_log2 == 3)
        apply(data, matrix, transposed, rank, 8);
    else if (block_log2 == 4)
        apply(data, matrix, transposed, rank, 16);
    else
        apply(data, matrix, transposed, rank, 32);
}
