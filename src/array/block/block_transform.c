/* Blocks of any rank and transform: matrices along the axes, and slots from separable transforms.
 */
#include "array/block/block_transform.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/cpu.h"
#include "base/elementary.h"
#include "transform/block.h"
#include "transform/whole.h"

#define PI 3.14159265358979323846

CVOL_SIMD_DECLARE(void, cvol_block_matrix,
                  (float *data, const float *matrix, const float *transposed, int rank,
                   int block_log2));

/* ---- matrices: filled once, then read only -------------------------------------------------- */

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
                cas[s][u * B + x] = (float)((cvol_cos(t) + cvol_sin(t)) / sqrt(B));
            }
    }
}

/* data: B^rank samples or slots, in place. */
static void apply_matrix(float *data, const cvol_array *shape, int inverse)
{
    pthread_once(&once, fill_all);
    const float *forward = cvol_block_basis(shape->block);
    const float *backward = dct_transposed[shape->block_log2 - 3];
    if (shape->transform != CVOL_DCT)
        forward = backward = cas[shape->block_log2 - 3];
    CVOL_SIMD_CHOOSE(cvol_block_matrix)
    (data, inverse ? backward : forward, inverse ? forward : backward, shape->rank,
     shape->block_log2);
}

/* ---- DHT and DFT ----------------------------------------------------------------------------- */

/* Converts the separable transform to slots by the formulas above, in place; its own inverse. Only
 * a place and its mirror images depend on each other. Bit a of an image's number is set if it is
 * mirrored along axis a. */
static void combine(float *data, int rank, int block_log2)
{
    const uint32_t X = (UINT32_C(1) << block_log2) - 1, Y = X << block_log2, Z = Y << block_log2;
    const uint32_t count = UINT32_C(1) << rank * block_log2;
    const int images = 1 << rank;
    for (uint32_t p = 0; p < count; p++) {
        const uint32_t at[3][2] = {{p & X, cvol_block_mirror(p, X)},
                                   {p & Y, cvol_block_mirror(p, Y)},
                                   {p & Z, cvol_block_mirror(p, Z)}};
        float in[8] = {0};
        uint32_t place[8] = {0};
        if (at[0][0] > at[0][1] || at[1][0] > at[1][1] || at[2][0] > at[2][1])
            continue;
        for (int i = 0; i < images; i++) {
            place[i] = at[0][i & 1] | at[1][i >> 1 & 1] | at[2][i >> 2];
            in[i] = data[place[i]];
        }
        for (int i = 0; i < images; i++)
            data[place[i]] = rank == 2 ? 0.5f * ((in[i] + in[i ^ 1]) + (in[i ^ 2] - in[i ^ 3]))
                                       : 0.5f * ((in[i ^ 1] + in[i ^ 2]) + (in[i ^ 4] - in[i ^ 7]));
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

/* ---- public ---------------------------------------------------------------------------------- */

void cvol_block_to_slots(float *slots, const float *samples, const cvol_array *shape)
{
    if (shape->rank == 3 && shape->transform == CVOL_DCT) {
        cvol_block_forward(slots, samples, shape->block);
        return;
    }
    memcpy(slots, samples, cvol_array_block_terms(shape) * sizeof *slots);
    apply_matrix(slots, shape, 0);
    if (shape->transform == CVOL_DCT)
        return;
    if (shape->rank > 1)
        combine(slots, shape->rank, shape->block_log2);
    if (shape->transform == CVOL_DFT)
        pair_slots(slots, shape->rank, shape->block_log2, 1);
}

void cvol_block_from_slots(float *data, const cvol_array *shape)
{
    if (shape->transform == CVOL_DFT)
        pair_slots(data, shape->rank, shape->block_log2, 0);
    if (shape->transform != CVOL_DCT && shape->rank > 1)
        combine(data, shape->rank, shape->block_log2);
    apply_matrix(data, shape, 1);
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
