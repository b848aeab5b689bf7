/* Kernels on a cell's coefficients, one row of 16 at a time. */
#include "codec/quantize/split_kernels.h"

#include "base/cpu.h"
#include "base/vector.h"

enum { SIDE = 16, VECTORS = SIDE / CVOL_LANES };

void CVOL_SIMD(cvol_cell_quantise)(cvol_cell_quantised *out, const float *coefficients,
                                   const cvol_cell_rounding *how);

/* Returns a bit for every lane that is set. */
CVOL_INLINE uint64_t bits_of(cvol_vi mask)
{
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask);
#elif defined(__AVX2__)
    return (uint64_t)(uint32_t)_mm256_movemask_ps((__m256)mask);
#else
    uint64_t bits = 0;
    for (int lane = 0; lane < CVOL_LANES; lane++)
        bits |= (uint64_t)(mask[lane] & 1) << lane;
    return bits;
#endif
}

/* The sum of a row's lanes, as doubles. */
static double sum_of(const cvol_vf sums[VECTORS])
{
    float lanes[SIDE];
    double sum = 0;
    memcpy(lanes, sums, sizeof lanes);
    for (int u = 0; u < SIDE; u++)
        sum += (double)lanes[u];
    return sum;
}

/* Room before the first magnitude, which loads read but do not use: four at most. */
enum { BEFORE = SIDE };

/* Larger magnitudes are invalid anyway, and do not fit into integers. */
#define SIZE_MOST 0x1p30f

/* Adds the magnitudes `apart` places before these on each axis; a missing one counts as 1. */
CVOL_INLINE cvol_vf before(const float *sizes, int u, int v, int w, int apart)
{
    const float *at = sizes + u + SIDE * (v + SIDE * w);
    const cvol_vf lane = cvol_iota() + (float)u;
    cvol_vf sum = cvol_select(lane < (float)apart, cvol_splat(1), cvol_load(at - apart));
    sum += v < apart ? cvol_splat(1) : cvol_load(at - SIDE * apart);
    sum += w < apart ? cvol_splat(1) : cvol_load(at - SIDE * SIDE * apart);
    return sum;
}

void CVOL_SIMD(cvol_cell_quantise)(cvol_cell_quantised *out, const float *coefficients,
                                   const cvol_cell_rounding *how)
{
    float room[BEFORE + SIDE * SIDE * SIDE] __attribute__((aligned(64)));
    float *sizes = room + BEFORE;
    cvol_vf most = {0};
    out->error = 0;
    memset(room, 0, BEFORE * sizeof *room);
    for (int w = 0; w < SIDE; w++) {
        cvol_vf errors[VECTORS] = {{0}};
        for (int v = 0; v < SIDE; v++) {
            const int row = SIDE * (v + SIDE * w);
            uint64_t bits = 0;
            for (int k = 0; k < VECTORS; k++) {
                const int at = row + k * CVOL_LANES;
                const cvol_vf scaled = cvol_load(coefficients + at) * how->inverse;
                const cvol_vi sign = (cvol_vi)scaled >> 31;
                const cvol_vf size = (cvol_vf)((cvol_vi)scaled & INT32_MAX);
                cvol_store(sizes + at, size);
                const cvol_vf near = before(sizes, k * CVOL_LANES, v, w, how->apart);
                const cvol_vf threshold = how->low + how->alone / (1 + near);
                const cvol_vi kept = size >= threshold;
                const cvol_vi magnitude = cvol_to_int(
                                              cvol_min(size + how->up, cvol_splat(SIZE_MOST))) &
                                          kept;
                const cvol_vf error = size - cvol_to_float(magnitude);
                const cvol_vi value = (magnitude ^ sign) - sign;
                errors[k] += error * error;
                most = cvol_max(size, most);
                memcpy(out->values + at, &value, sizeof value);
                bits |= bits_of(magnitude != 0) << (k * CVOL_LANES);
            }
            if (v % 4 == 0)
                out->found[row / 64] = 0;
            out->found[row / 64] |= bits << (row % 64);
        }
        out->error += sum_of(errors);
    }
    out->most = 0;
    for (int lane = 0; lane < CVOL_LANES; lane++)
        out->most = most[lane] > out->most ? most[lane] : out->most;
}
