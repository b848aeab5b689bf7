/* Viterbi's algorithm (1967) on eight states at once. */
#include "codec/quantize/trellis_kernel.h"

#include <math.h>

#include "base/cpu.h"
#include "base/vector.h"
#include "codec/quantize/trellis.h"

void CVOL_SIMD(cvol_trellis_walk)(cvol_trellis *t, const float *scaled, int extent,
                                  const cvol_scan *scan, const cvol_token_costs *costs,
                                  uint16_t *scatter);

/* The distance in rows from even states to odd ones. */
enum { ODD_ROWS = CVOL_INDEX_SIZES * CVOL_BANDS * CVOL_FINE_LEVELS };

/* Four or eight numbers: plain C except where it has no expression for the operation. */
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_int __attribute__((vector_size(16)));
typedef float eight __attribute__((vector_size(32)));

/* Costs of branches whose magnitudes need an escape. */
static void cost_long_ones(float cost[CVOL_BRANCHES], int32_t index[CVOL_BRANCHES],
                           const cvol_token_costs *costs, cvol_place_code code, float size)
{
    for (int j = 0; j < CVOL_BRANCHES; j++) {
        const int odd = j >> 1;
        const float error = size - ((float)index[j] - 0.5f * (float)odd);
        code.row += odd ? ODD_ROWS : 0;
        cost[j] = error * error +
                  CVOL_LAMBDA_TRELLIS * cvol_bits_of_value(costs, code, (uint32_t)index[j]);
        code.row -= odd ? ODD_ROWS : 0;
    }
}

/* The nearest index of each branch, or 0, and its cost. */
CVOL_INLINE four find_branches(int32_t index[CVOL_BRANCHES], const cvol_token_costs *costs,
                               cvol_place_code code, float size)
{
    static const four begin = {0.5f, 0, 0.75f, 0.25f}, apart = {0, 0, 0.5f, 0.5f};
    static const four_int parity = {0, 1, 0, 1};
    const float *rows[2] = {costs->of[code.row], costs->of[code.row + ODD_ROWS]};
    const four_int half = __builtin_convertvector(0.5f * size + begin, four_int);
    const four_int k = 2 * half + parity;
    const four error = size - (__builtin_convertvector(k, four) - apart);
    const float shift = (float)code.shift;
    four cost, none = {rows[0][0], INFINITY, rows[1][0], INFINITY};
    none = size * size + CVOL_LAMBDA_TRELLIS * (none + shift);
    memcpy(index, &k, sizeof k);
    if (__builtin_expect(index[2] >> code.shift > 13, 0)) {
        float longer[CVOL_BRANCHES];
        cost_long_ones(longer, index, costs, code, size);
        memcpy(&cost, longer, sizeof cost);
    } else {
        const four bits = {rows[0][index[0] >> code.shift], rows[0][index[1] >> code.shift],
                           rows[1][index[2] >> code.shift], rows[1][index[3] >> code.shift]};
        cost = error * error + CVOL_LAMBDA_TRELLIS * (bits + (1 + shift));
    }
    const four_int any = cost < none, kept = k & any;
    memcpy(index, &kept, sizeof kept);
    return (four)(((four_int)cost & any) | ((four_int)none & ~any));
}

/* Extends the best paths by one coefficient; returns the states reached by odd indices. */
CVOL_INLINE uint8_t step_on(eight *sums, four cost)
{
#if defined(__AVX2__)
    const __m256 all = _mm256_castps128_ps256((__m128)cost), before = (__m256)*sums;
    const __m256i to_even = _mm256_setr_epi32(0, 2, 4, 6, 5, 1, 3, 7),
                  to_odd = _mm256_setr_epi32(4, 6, 0, 2, 3, 7, 5, 1),
                  of_even = _mm256_setr_epi32(0, 0, 0, 0, 2, 2, 2, 2),
                  of_odd = _mm256_setr_epi32(1, 1, 1, 1, 3, 3, 3, 3);
    const __m256 even = _mm256_add_ps(_mm256_permutevar8x32_ps(before, to_even),
                                      _mm256_permutevar8x32_ps(all, of_even)),
                 odd = _mm256_add_ps(_mm256_permutevar8x32_ps(before, to_odd),
                                     _mm256_permutevar8x32_ps(all, of_odd));
    *sums = (eight)_mm256_min_ps(odd, even);
    return (uint8_t)_mm256_movemask_ps(_mm256_cmp_ps(odd, even, _CMP_LT_OQ));
#else
    float before[CVOL_STATES], after[CVOL_STATES], branch[CVOL_BRANCHES];
    unsigned bits = 0;
    memcpy(before, sums, sizeof before);
    memcpy(branch, &cost, sizeof branch);
    for (int s = 0; s < CVOL_STATES; s++) {
        const float even = before[cvol_state_before[0][s]] + branch[s & 4 ? 2 : 0],
                    odd = before[cvol_state_before[1][s]] + branch[s & 4 ? 3 : 1];
        after[s] = odd < even ? odd : even;
        bits |= (unsigned)(odd < even) << s;
    }
    memcpy(sums, after, sizeof after);
    return (uint8_t)bits;
#endif
}

/* The first state with the least cost. */
CVOL_INLINE int best_state(eight sums)
{
#if defined(__AVX2__)
    const __m256 all = (__m256)sums,
                 halves = _mm256_min_ps(all, _mm256_permute2f128_ps(all, all, 1)),
                 pairs = _mm256_min_ps(halves, _mm256_permute_ps(halves, _MM_SHUFFLE(1, 0, 3, 2))),
                 least = _mm256_min_ps(pairs, _mm256_permute_ps(pairs, _MM_SHUFFLE(2, 3, 0, 1)));
    return __builtin_ctz((unsigned)_mm256_movemask_ps(_mm256_cmp_ps(all, least, _CMP_EQ_OQ)));
#else
    int best = 0;
    for (int s = 1; s < CVOL_STATES; s++)
        best = sums[s] < sums[best] ? s : best;
    return best;
#endif
}

/* Scatters a run's magnitudes on the best path so far. */
CVOL_INLINE void scatter_run(const cvol_trellis *t, int begin, int end, int state,
                             const cvol_scan *scan, uint16_t *scatter)
{
    for (int i = end - 1; i >= begin; i--) {
        const uint32_t k = cvol_trellis_back(t, i, &state);
        if (k)
            cvol_scatter(scatter + scan->entries[i].scatter, scan->row, scan->sheet,
                         cvol_trellis_magnitude(state, k));
    }
}

void CVOL_SIMD(cvol_trellis_walk)(cvol_trellis *t, const float *scaled, int extent,
                                  const cvol_scan *scan, const cvol_token_costs *costs,
                                  uint16_t *scatter)
{
    eight sums = {0, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f};
    for (int i = 1, run = 0; i < extent; run++) {
        const int begin = i, end = scan->run_ends[run] < extent ? scan->run_ends[run] : extent;
        for (; i < end; i++) {
            const cvol_scan_entry *entry = &scan->entries[i];
            const uint32_t near = scatter[entry->scatter];
            const cvol_place_code code = cvol_value_code(scan->size_class, entry->band, near, 1, 0);
            t->near[i] = (uint16_t)near;
            memcpy(t->sums[i], &sums, sizeof sums);
            t->odd[i] = step_on(&sums, find_branches(t->index[i], costs, code, fabsf(scaled[i])));
        }
        if (end < extent)
            scatter_run(t, begin, end, best_state(sums), scan, scatter);
    }
    memcpy(t->sums[extent], &sums, sizeof sums);
}
