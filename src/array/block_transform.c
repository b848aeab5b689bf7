/* Blocks of any rank and transform: matrices along the axes, and slots from separable transforms.
 */
#include "array/block_transform.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/cpu.h"
#include "transform/block.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846
#define CUBE (CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX)

CVOL_SIMD_DECLARE(void, cvol_block_matrix,
                  (float *data, float *work, const float *matrix, const float *transposed, int rank,
                   int block_log2));

/* ---- matrices, filled once and only read after ----------------------------------------------- */

static float dct_transposed[3][CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
static float cas[3][CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill_all(void)
{
    for (int s = 0; s < 3; s++) {
        const int B = 8 << s;
        const float *basis = cvol_block_basis(B);
        for (int u = 0; u < B; u++)
            for (int x = 0; x < B; x++) {
                const double t = 2 * PI * (u * x % B) / B;
                dct_transposed[s][x * B + u] = basis[u * B + x];
                cas[s][u * B + x] = (float)((cos(t) + sin(t)) / sqrt(B));
            }
    }
}

/* data: B^rank samples or slots; work: as many. */
static void apply_matrix(float *data, float *work, const cvol_array *shape, int inverse)
{
    pthread_once(&once, fill_all);
    const float *forward = cvol_block_basis(shape->block);
    const float *backward = dct_transposed[shape->block_log2 - 3];
    if (shape->transform != CVOL_DCT)
        forward = backward = cas[shape->block_log2 - 3];
    CVOL_SIMD_CHOOSE(cvol_block_matrix)
    (data, work, inverse ? backward : forward, inverse ? forward : backward, shape->rank,
     shape->block_log2);
}

/* ---- DHT and DFT ------------------------------------------------------------------------------
 */

/* out = what the formulas above make of the separable transform `in`; its own inverse. */
static void combine(float *out, const float *in, int rank, int block_log2)
{
    const uint32_t X = (UINT32_C(1) << block_log2) - 1, Y = X << block_log2, Z = Y << block_log2;
    const uint32_t count = UINT32_C(1) << rank * block_log2;
    for (uint32_t p = 0; p < count; p++) {
        const uint32_t x = p & X, y = p & Y, z = p & Z;
        const uint32_t mx = cvol_block_mirror(p, X), my = cvol_block_mirror(p, Y),
                       mz = cvol_block_mirror(p, Z);
        out[p] = rank == 2 ? 0.5f * ((in[p] + in[mx | y]) + (in[x | my] - in[mx | my]))
                           : 0.5f * ((in[mx | y | z] + in[x | my | z]) +
                                     (in[x | y | mz] - in[mx | my | mz]));
    }
}

/* Between DHT and DFT slots, in place. The pair is (a, b) in DFT slots. */
static void pair_slots(float *slots, int rank, int block_log2, int to_dft)
{
    const float half = 0.707106781f;
    const uint32_t X = (UINT32_C(1) << block_log2) - 1, Y = X << block_log2, Z = Y << block_log2;
    const uint32_t count = UINT32_C(1) << rank * block_log2;
    for (uint32_t p = 0; p < count; p++) {
        const uint32_t fields[3] = {X, Y, Z};
        uint32_t m = 0;
        int order = 0;
        for (int a = 0; a < rank; a++) {
            const uint32_t at = p & fields[a], opposite = cvol_block_mirror(p, fields[a]);
            m |= opposite;
            if (!order && at != opposite)
                order = at < opposite ? 1 : -1;
        }
        if (order != 1)
            continue;
        const float first = slots[p], second = slots[m];
        slots[p] = half * (to_dft ? first + second : first - second);
        slots[m] = half * (to_dft ? second - first : first + second);
    }
}

/* ---- public -----------------------------------------------------------------------------------
 */

void cvol_block_to_slots(float *slots, const float *samples, const cvol_array *shape)
{
    if (shape->rank == 3 && shape->transform == CVOL_DCT) {
        cvol_block_forward(slots, samples, shape->block);
        return;
    }
    float work[CUBE] __attribute__((aligned(64)));
    const size_t bytes = cvol_array_block_terms(shape) * sizeof *slots;
    memcpy(slots, samples, bytes);
    apply_matrix(slots, work, shape, 0);
    if (shape->transform == CVOL_DCT)
        return;
    if (shape->rank > 1) {
        memcpy(work, slots, bytes);
        combine(slots, work, shape->rank, shape->block_log2);
    }
    if (shape->transform == CVOL_DFT)
        pair_slots(slots, shape->rank, shape->block_log2, 1);
}

void cvol_block_from_slots(float *samples, const float *slots, const cvol_array *shape)
{
    float work[CUBE] __attribute__((aligned(64)));
    const size_t bytes = cvol_array_block_terms(shape) * sizeof *slots;
    memcpy(samples, slots, bytes);
    if (shape->transform == CVOL_DFT)
        pair_slots(samples, shape->rank, shape->block_log2, 0);
    if (shape->transform != CVOL_DCT && shape->rank > 1) {
        memcpy(work, samples, bytes);
        combine(samples, work, shape->rank, shape->block_log2);
    }
    apply_matrix(samples, work, shape, 1);
}

void cvol_block_unpack(float *slots, const cvol_array *array, size_t index)
{
    const cvol_block *block = &array->block_table[index];
    const int place_bits = cvol_place_bits(array->block_log2);
    const float step = (float)array->step;
    memset(slots, 0, cvol_array_block_terms(array) * sizeof *slots);
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, place_bits);
        slots[place] = step * (float)value;
    }
}
