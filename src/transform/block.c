/* DCT-II of cubic blocks: the basis matrices, the scalar reference, and the choice of kernel. */
#include "transform/block.h"

#include <math.h>
#include <pthread.h>
#include <stddef.h>

#include "base/cpu.h"
#include "base/elementary.h"

#define PI 3.14159265358979323846

/* One matrix per side, filled once and then read only. */
static float basis8[8 * 8] __attribute__((aligned(64)));
static float basis16[16 * 16] __attribute__((aligned(64)));
static float basis32[32 * 32] __attribute__((aligned(64)));
/* Matrices of each side, with rows for lanes; and for every even number of points, one after the
 * other: the matrix for p points begins at block * (2 + 4 + ... + (p - 2)). */
static float lanes_of[3][CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
static float columns_of[3][CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
static float points_of[3][CVOL_BLOCK_MAX * 272] __attribute__((aligned(64)));
static pthread_once_t basis_once = PTHREAD_ONCE_INIT;

static double basis_at(int u, int x, int block, int points)
{
    double c = sqrt((u ? 2.0 : 1.0) / block);
    return c * cvol_cos(PI * u * (x + 0.5) / points);
}

static double basis_value(int u, int x, int block)
{
    return basis_at(u, x, block, block);
}

static int side_index(int block)
{
    return block == 8 ? 0 : block == 16 ? 1 : 2;
}

static size_t points_start(int block, int points)
{
    size_t half = (size_t)points / 2;
    return (size_t)block * half * (half - 1);
}

static void fill(float *basis, int block)
{
    for (int u = 0; u < block; u++)
        for (int x = 0; x < block; x++)
            basis[u * block + x] = (float)basis_value(u, x, block);
}

static void fill_padded(int block)
{
    const int width = block < 16 ? 16 : block, side = side_index(block);
    for (int u = 0; u < block; u++)
        for (int x = 0; x < block; x++) {
            lanes_of[side][u * width + x] = (float)basis_value(u, x, block);
            columns_of[side][x * width + u] = (float)basis_value(u, x, block);
        }
    for (int points = 2; points <= block; points += 2) {
        float *basis = points_of[side] + points_start(block, points);
        for (int u = 0; u < block; u++)
            for (int i = 0; i < points; i++)
                basis[u * points + i] = (float)basis_at(u, i, block, points);
    }
}

static void fill_all(void)
{
    for (int block = 8; block <= CVOL_BLOCK_MAX; block *= 2)
        fill_padded(block);
    fill(basis8, 8);
    fill(basis16, 16);
    fill(basis32, 32);
}

const float *cvol_block_basis(int block)
{
    pthread_once(&basis_once, fill_all);
    return block == 8 ? basis8 : block == 16 ? basis16 : basis32;
}

const float *cvol_block_lane_basis(int block)
{
    pthread_once(&basis_once, fill_all);
    return lanes_of[side_index(block)];
}

const float *cvol_block_columns(int block)
{
    pthread_once(&basis_once, fill_all);
    return columns_of[side_index(block)];
}

const float *cvol_block_points_basis(int block, int points)
{
    pthread_once(&basis_once, fill_all);
    return points_of[side_index(block)] + points_start(block, points);
}

/* One dimension of the forward (or inverse) transform: every line of stride `stride`. */
static void transform_lines(double *block_data, int block, int stride, int inverse)
{
    double basis[CVOL_BLOCK_MAX][CVOL_BLOCK_MAX];
    int count = block * block * block;
    for (int i = 0; i < block; i++)
        for (int j = 0; j < block; j++)
            basis[i][j] = inverse ? basis_value(j, i, block) : basis_value(i, j, block);
    for (int start = 0; start < count; start++) {
        if (start / stride % block)
            continue;
        double line[CVOL_BLOCK_MAX];
        for (int i = 0; i < block; i++) {
            line[i] = 0;
            for (int j = 0; j < block; j++)
                line[i] += basis[i][j] * block_data[start + j * stride];
        }
        for (int i = 0; i < block; i++)
            block_data[start + i * stride] = line[i];
    }
}

static void transform_reference(float *out, const float *in, int block, int inverse)
{
    double work[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    int count = block * block * block;
    for (int i = 0; i < count; i++)
        work[i] = in[i];
    for (int stride = 1; stride < count; stride *= block)
        transform_lines(work, block, stride, inverse);
    for (int i = 0; i < count; i++)
        out[i] = (float)work[i];
}

void cvol_block_forward_reference(float *out, const float *in, int block)
{
    transform_reference(out, in, block, 0);
}

void cvol_block_inverse_reference(float *out, const float *in, int block)
{
    transform_reference(out, in, block, 1);
}

CVOL_SIMD_DECLARE(void, cvol_block_forward,
                  (float *out, const float *in, const float *basis, int block));

void cvol_block_forward(float *out, const float *in, int block)
{
    CVOL_SIMD_CHOOSE(cvol_block_forward)(out, in, cvol_block_basis(block), block);
}
