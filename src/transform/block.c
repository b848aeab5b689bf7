/* DCT-II of cubic blocks: the basis matrices, the scalar reference, and the choice of kernel. */
#include "transform/block.h"

#include <math.h>
#include <pthread.h>

#include "base/cpu.h"

#define PI 3.14159265358979323846

/* One matrix per side, filled once and only read after. */
static float basis8[8 * 8] __attribute__((aligned(64)));
static float basis16[16 * 16] __attribute__((aligned(64)));
static float basis32[32 * 32] __attribute__((aligned(64)));
static pthread_once_t basis_once = PTHREAD_ONCE_INIT;

static double basis_value(int u, int x, int block)
{
    double c = sqrt((u ? 2.0 : 1.0) / block);
    return c * cos(PI * u * (x + 0.5) / block);
}

static void fill(float *basis, int block)
{
    for (int u = 0; u < block; u++)
        for (int x = 0; x < block; x++)
            basis[u * block + x] = (float)basis_value(u, x, block);
}

static void fill_all(void)
{
    fill(basis8, 8);
    fill(basis16, 16);
    fill(basis32, 32);
}

const float *cvol_block_basis(int block)
{
    pthread_once(&basis_once, fill_all);
    return block == 8 ? basis8 : block == 16 ? basis16 : basis32;
}

/* One dimension of the forward (or inverse) transform: every line of stride `stride`. */
static void transform_lines(double *block_data, int block, int stride, int inverse)
{
    int count = block * block * block;
    for (int start = 0; start < count; start++) {
        if (start / stride % block)
            continue;
        double line[CVOL_BLOCK_MAX];
        for (int i = 0; i < block; i++) {
            line[i] = 0;
            for (int j = 0; j < block; j++) {
                double d = inverse ? basis_value(j, i, block) : basis_value(i, j, block);
                line[i] += d * block_data[start + j * stride];
            }
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
