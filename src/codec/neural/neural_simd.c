/* The neural coder's networks and transforms. */
#include "codec/neural/neural_kernels.h"

#include <string.h>

#include "array/core/array.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

void CVOL_SIMD(cvol_neural_evaluate)(int16_t *out, const cvol_neural_pairs *network,
                                     const int16_t *x, int inputs);
void CVOL_SIMD(cvol_neural_evaluate_kinds)(int16_t (*out)[CVOL_NEURAL_OUTPUTS],
                                           const cvol_neural_pairs *network, int16_t *x);
void CVOL_SIMD(cvol_neural_inverse)(int32_t *samples, const int32_t *known, const int n[3],
                                    int cube, const cvol_neural_basis *basis);
void CVOL_SIMD(cvol_neural_face)(int32_t *level, int32_t *slope, const int32_t *near,
                                 const int32_t *far, const int stride[2], const int n[2],
                                 const cvol_neural_basis *basis);

enum { SIDE = CVOL_BRICK_SIDE, SLICE = SIDE * SIDE };
/* The number of kinds of states whose sums fit into registers. */
enum { AT_ONCE = CVOL_LANES >= 16 ? CVOL_NEURAL_KINDS : CVOL_LANES >= 8 ? 2 : 1 };

/* sums[u] += weights[u][0] x[0] + weights[u][1] x[1], for a vector of units. The intrinsics add
 * without checks: the undefined-behaviour sanitizer would check the sums of vectors one number at a
 * time. */
CVOL_INLINE cvol_vi add_pair(cvol_vi sums, const int16_t (*weights)[2], const int16_t x[2])
{
#if defined(__AVX512BW__)
    int32_t both;
    memcpy(&both, x, sizeof both);
    const __m512i products = _mm512_madd_epi16(_mm512_loadu_si512(weights),
                                               _mm512_set1_epi32(both));
    return (cvol_vi)_mm512_add_epi32((__m512i)sums, products);
#elif defined(__AVX2__)
    int32_t both;
    memcpy(&both, x, sizeof both);
    const __m256i products = _mm256_madd_epi16(_mm256_loadu_si256((const __m256i *)weights),
                                               _mm256_set1_epi32(both));
    return (cvol_vi)_mm256_add_epi32((__m256i)sums, products);
#elif defined(__SSE2__)
    int32_t both;
    memcpy(&both, x, sizeof both);
    const __m128i products = _mm_madd_epi16(_mm_loadu_si128((const __m128i *)weights),
                                            _mm_set1_epi32(both));
    return (cvol_vi)_mm_add_epi32((__m128i)sums, products);
#elif defined(__wasm_simd128__)
    int32_t both;
    memcpy(&both, x, sizeof both);
    const v128_t products = wasm_i32x4_dot_i16x8(wasm_v128_load(weights), wasm_i32x4_splat(both));
    return (cvol_vi)wasm_i32x4_add((v128_t)sums, products);
#else
    for (int lane = 0; lane < CVOL_LANES; lane++)
        sums[lane] += weights[lane][0] * x[0] + weights[lane][1] * x[1];
    return sums;
#endif
}

/* Adds a layer's inputs first .. end - 1 to the sums of all its units. */
CVOL_INLINE void add_inputs(cvol_vi *sums, const int16_t *weights, const int16_t *x, int first,
                            int end, int units)
{
    for (int i = first; i < end; i += 2)
        for (int k = 0; k < units / CVOL_LANES; k++)
            sums[k] = add_pair(
                sums[k], (const int16_t(*)[2])(weights + i * units + 2 * CVOL_LANES * k), x + i);
}

/* Clamps to least .. most. */
CVOL_INLINE cvol_vi limit(cvol_vi sums, int least, int most)
{
#if defined(__AVX512F__)
    return (cvol_vi)_mm512_min_epi32(_mm512_max_epi32((__m512i)sums, _mm512_set1_epi32(least)),
                                     _mm512_set1_epi32(most));
#elif defined(__AVX2__)
    return (cvol_vi)_mm256_min_epi32(_mm256_max_epi32((__m256i)sums, _mm256_set1_epi32(least)),
                                     _mm256_set1_epi32(most));
#else
    const cvol_vi low = least - (cvol_vi){0}, high = most - (cvol_vi){0};
    const cvol_vi below = sums<low, above = sums> high;
    return (sums & ~(below | above)) | (low & below) | (high & above);
#endif
}

/* Shifts sums down and clamps them. */
CVOL_INLINE void cut_sums(int16_t *out, const cvol_vi *sums, int units, int shift, int least,
                          int most)
{
    typedef int16_t halves __attribute__((vector_size(2 * CVOL_LANES)));
    for (int k = 0; k < units / CVOL_LANES; k++) {
        const halves cut = __builtin_convertvector(limit(sums[k] >> shift, least, most), halves);
        memcpy(out + k * CVOL_LANES, &cut, sizeof cut);
    }
}

CVOL_INLINE void layer(int16_t *out, const int16_t *weights, const int32_t *biases,
                       const int16_t *x, int inputs, int units, int shift, int least, int most)
{
    cvol_vi sums[CVOL_NEURAL_FIRST / CVOL_LANES];
    memcpy(sums, biases, (size_t)units * sizeof *biases);
    add_inputs(sums, weights, x, 0, inputs, units);
    cut_sums(out, sums, units, shift, least, most);
}

/* Evaluates a layer for several kinds of states, which share the reads of weights; inputs and units
 * of the kinds follow one another. */
CVOL_INLINE void layers(int16_t *out, const int16_t *weights, const int32_t *biases,
                        const int16_t *x, int inputs, int units, int shift, int least, int most,
                        int kinds)
{
    cvol_vi sums[AT_ONCE][CVOL_NEURAL_SECOND / CVOL_LANES];
    for (int kind = 0; kind < kinds; kind++)
        memcpy(sums[kind], biases, (size_t)units * sizeof *biases);
    for (int i = 0; i < inputs; i += 2)
        for (int k = 0; k < units / CVOL_LANES; k++)
            for (int kind = 0; kind < kinds; kind++)
                sums[kind][k] = add_pair(
                    sums[kind][k], (const int16_t(*)[2])(weights + i * units + 2 * CVOL_LANES * k),
                    x + kind * inputs + i);
    for (int kind = 0; kind < kinds; kind++)
        cut_sums(out + kind * units, sums[kind], units, shift, least, most);
}

/* Evaluates all layers after the first. */
CVOL_INLINE void further_layers(int16_t (*out)[CVOL_NEURAL_OUTPUTS],
                                const cvol_neural_pairs *network,
                                const int16_t (*first)[CVOL_NEURAL_FIRST], int kinds)
{
    int16_t second[AT_ONCE][CVOL_NEURAL_SECOND];
    layers(second[0], network->second[0][0], network->second_bias, first[0], CVOL_NEURAL_FIRST,
           CVOL_NEURAL_SECOND, 12, 0, 255, kinds);
    layers(out[0], network->third[0][0], network->third_bias, second[0], CVOL_NEURAL_SECOND,
           CVOL_NEURAL_OUTPUTS, 10, -CVOL_NEURAL_LOGIT_MAX, CVOL_NEURAL_LOGIT_MAX, kinds);
}

void CVOL_SIMD(cvol_neural_evaluate)(int16_t *out, const cvol_neural_pairs *network,
                                     const int16_t *x, int inputs)
{
    int16_t first[CVOL_NEURAL_FIRST];
    layer(first, network->first[0][0], network->first_bias, x, inputs, CVOL_NEURAL_FIRST, 11, 0,
          255);
    further_layers((int16_t(*)[CVOL_NEURAL_OUTPUTS])out, network,
                   (const int16_t(*)[CVOL_NEURAL_FIRST])first, 1);
}

void CVOL_SIMD(cvol_neural_evaluate_kinds)(int16_t (*out)[CVOL_NEURAL_OUTPUTS],
                                           const cvol_neural_pairs *network, int16_t *x)
{
    enum { FROM = CVOL_NEURAL_ODD / 2 * 2, BEHIND = CVOL_NEURAL_LATE / 2 * 2 + 2 };
    const int16_t *weights = network->first[0][0];
    cvol_vi shared[CVOL_NEURAL_FIRST / CVOL_LANES], sums[CVOL_NEURAL_FIRST / CVOL_LANES];
    int16_t first[CVOL_NEURAL_KINDS][CVOL_NEURAL_FIRST];
    memcpy(shared, network->first_bias, sizeof network->first_bias);
    add_inputs(shared, weights, x, 0, FROM, CVOL_NEURAL_FIRST);
    add_inputs(shared, weights, x, BEHIND, CVOL_NEURAL_INPUTS, CVOL_NEURAL_FIRST);
    for (int kind = 0; kind < CVOL_NEURAL_KINDS; kind++) {
        x[CVOL_NEURAL_ODD] = kind & 1 ? 64 : 0;
        x[CVOL_NEURAL_LATE] = kind & 2 ? 64 : 0;
        memcpy(sums, shared, sizeof sums);
        add_inputs(sums, weights, x, FROM, BEHIND, CVOL_NEURAL_FIRST);
        cut_sums(first[kind], sums, CVOL_NEURAL_FIRST, 11, 0, 255);
    }
    for (int kind = 0; kind < CVOL_NEURAL_KINDS; kind += AT_ONCE)
        further_layers(out + kind, network, (const int16_t(*)[CVOL_NEURAL_FIRST])(first + kind),
                       AT_ONCE);
}

/* to[0 .. 16) += factor from[0 .. 16) */
CVOL_INLINE void add_line(uint32_t to[16], const uint32_t from[16], uint32_t factor)
{
    for (int x = 0; x < 16; x++)
        to[x] += factor * from[x];
}

CVOL_INLINE void round_line(uint32_t line[16])
{
    for (int x = 0; x < 16; x++)
        line[x] = (uint32_t)((int32_t)(line[x] + 512) >> 10);
}

void CVOL_SIMD(cvol_neural_inverse)(int32_t *samples, const int32_t *known, const int n[3],
                                    int cube, const cvol_neural_basis *basis)
{
    uint32_t by_x[16][16][16], by_y[16][16][16]; /* [w][v][x], [w][y][x] */
    int count[3];
    for (int a = 0; a < 3; a++)
        count[a] = cube < n[a] ? cube : n[a];
    for (int w = 0; w < count[2]; w++)
        for (int v = 0; v < count[1]; v++) {
            memset(by_x[w][v], 0, sizeof by_x[w][v]);
            for (int u = 0; u < count[0]; u++) {
                const uint32_t value = (uint32_t)known[u + SIDE * v + SLICE * w] << 4;
                if (value)
                    add_line(by_x[w][v], (const uint32_t *)basis->of[n[0]][u], value);
            }
            round_line(by_x[w][v]);
        }
    for (int w = 0; w < count[2]; w++)
        for (int y = 0; y < n[1]; y++) {
            memset(by_y[w][y], 0, sizeof by_y[w][y]);
            for (int v = 0; v < count[1]; v++)
                add_line(by_y[w][y], by_x[w][v], (uint32_t)basis->of[n[1]][v][y]);
            round_line(by_y[w][y]);
        }
    for (int z = 0; z < n[2]; z++)
        for (int y = 0; y < n[1]; y++) {
            uint32_t line[16] = {0};
            for (int w = 0; w < count[2]; w++)
                add_line(line, by_y[w][y], (uint32_t)basis->of[n[2]][w][z]);
            round_line(line);
            memcpy(samples + SIDE * y + SLICE * z, line, (size_t)n[0] * sizeof *line);
        }
}

/* The DCT of plane[i][j], times 2^8, to[v + 16 w]. */
CVOL_INLINE void transform_plane(int32_t *to, uint32_t plane[16][16], const int n[2],
                                 const cvol_neural_basis *basis)
{
    uint32_t half[16][16], turned[16][16]; /* [v][j], [j][v] */
    for (int v = 0; v < n[0]; v++) {
        memset(half[v], 0, sizeof half[v]);
        for (int i = 0; i < n[0]; i++)
            add_line(half[v], plane[i], (uint32_t)basis->of[n[0]][v][i]);
        round_line(half[v]);
    }
    for (int j = 0; j < n[1]; j++)
        for (int v = 0; v < 16; v++)
            turned[j][v] = v < n[0] ? half[v][j] : 0;
    for (int w = 0; w < n[1]; w++) {
        uint32_t line[16] = {0};
        for (int j = 0; j < n[1]; j++)
            add_line(line, turned[j], (uint32_t)basis->of[n[1]][w][j]);
        round_line(line);
        for (int v = 0; v < n[0]; v++)
            to[v + 16 * w] = (int32_t)(line[v] << 8);
    }
}

void CVOL_SIMD(cvol_neural_face)(int32_t *level, int32_t *slope, const int32_t *near,
                                 const int32_t *far, const int stride[2], const int n[2],
                                 const cvol_neural_basis *basis)
{
    uint32_t planes[2][16][16]; /* [i][j] */
    memset(planes, 0, sizeof planes);
    for (int i = 0; i < n[0]; i++)
        for (int j = 0; j < n[1]; j++) {
            const int at = stride[0] * i + stride[1] * j;
            planes[0][i][j] = (uint32_t)near[at];
            planes[1][i][j] = (uint32_t)near[at] - (uint32_t)far[at];
        }
    transform_plane(level, planes[0], n, basis);
    transform_plane(slope, planes[1], n, basis);
}
