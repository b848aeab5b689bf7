/* H_d = D C_d D^T, in double precision, for each kind of block of an axis. */
#include "array/convolve/face_matrices.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* Blocks with matrices of their own: the first, an inner one, and the last two. (Mirrored samples
 * may reach the last but one from the last, whose far neighbour is cut short.) */
enum { KINDS_MAX = 4 };

static int width_of(int block)
{
    return block < 16 ? 16 : block;
}

static size_t matrix_floats(int block)
{
    return (size_t)(block * width_of(block));
}

static size_t kind_of(size_t i, size_t count)
{
    if (count <= KINDS_MAX || i == 0)
        return i;
    return i >= count - 2 ? i - (count - 2) + 2 : 1;
}

static size_t block_of_kind(size_t kind, size_t count)
{
    if (count <= KINDS_MAX || kind < 2)
        return kind;
    return count - 2 + (kind - 2);
}

/* The sample at index x of an axis mirrored about its ends. */
static size_t mirrored(ptrdiff_t x, size_t n)
{
    const ptrdiff_t period = 2 * (ptrdiff_t)n;
    x %= period;
    if (x < 0)
        x += period;
    return (size_t)(x < (ptrdiff_t)n ? x : period - 1 - x);
}

static double tap_at(const cvol_kernel_line *line, int m)
{
    if (m >= 0)
        return line->taps[m];
    return line->antisymmetric ? -line->taps[-m] : line->taps[-m];
}

/* C[x][y] between block i and block j; beyond the axis its last sample is repeated. */
static void fill_samples(double *C, const cvol_kernel_line *line, size_t n, size_t B, size_t i,
                         size_t j)
{
    memset(C, 0, B * B * sizeof *C);
    for (size_t x = 0; x < B; x++) {
        const size_t at = i * B + x < n ? i * B + x : n - 1;
        for (int m = -line->radius; m <= line->radius; m++) {
            size_t y = mirrored((ptrdiff_t)at - m, n);
            if (y / B == j)
                C[x * B + y % B] += tap_at(line, m);
        }
    }
}

static void fill_matrix(float *out, const double *C, double *half, int B, int transposed)
{
    const float *D = cvol_block_basis(B);
    const int width = transposed ? width_of(B) : B;
    for (int u = 0; u < B; u++)
        for (int y = 0; y < B; y++) {
            double sum = 0;
            for (int x = 0; x < B; x++)
                sum += (double)D[u * B + x] * C[x * B + y];
            half[u * B + y] = sum;
        }
    for (int u = 0; u < B; u++)
        for (int v = 0; v < B; v++) {
            double sum = 0;
            for (int y = 0; y < B; y++)
                sum += half[u * B + y] * (double)D[v * B + y];
            out[transposed ? v * width + u : u * width + v] = (float)sum;
        }
}

int cvol_axis_matrices_make(cvol_context *context, cvol_axis_matrices *out,
                            const cvol_kernel_line *line, size_t n, int block, int transposed)
{
    const size_t B = (size_t)block;
    double C[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX], half[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    out->block_count = (n - 1) / B + 1;
    out->kinds = out->block_count < KINDS_MAX ? out->block_count : KINDS_MAX;
    out->memory = cvol_allocate_zero(3 * out->kinds * matrix_floats(block), sizeof(float));
    if (!out->memory)
        return cvol_fail_memory(context, 3 * out->kinds * matrix_floats(block) * sizeof(float),
                                "a kernel's matrices");
    for (size_t kind = 0; kind < out->kinds; kind++)
        for (size_t d = 0; d < 3; d++) {
            const size_t i = block_of_kind(kind, out->block_count), j = i + d - 1;
            if (j >= out->block_count)
                continue;
            fill_samples(C, line, n, B, i, j);
            fill_matrix(out->memory + (3 * kind + d) * matrix_floats(block), C, half, block,
                        transposed);
        }
    return CVOL_OK;
}

void cvol_axis_matrices_free(cvol_axis_matrices *matrices)
{
    free(matrices->memory);
    matrices->memory = NULL;
}

cvol_face_matrices cvol_axis_matrices_at(const cvol_axis_matrices *matrices, size_t i, int block,
                                         int radius)
{
    const float *first = matrices->memory +
                         3 * kind_of(i, matrices->block_count) * matrix_floats(block);
    cvol_face_matrices at;
    for (size_t d = 0; d < 3; d++) {
        int there = i + d >= 1 && i + d - 1 < matrices->block_count;
        at.of[d] = there && (d == 1 || radius > 0) ? first + d * matrix_floats(block) : NULL;
    }
    return at;
}
