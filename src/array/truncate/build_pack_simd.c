/* The scan for coefficients above a threshold, 16 together for every instruction set, so that the
 * sum of squares of the rest has the same bits everywhere. Most of a block is below. */
#include "array/core/array.h"
#include "array/truncate/build_pack.h"
#include "base/cpu.h"
#include "base/vector.h"

void CVOL_SIMD(cvol_block_scan)(cvol_scan_task *task);
void CVOL_SIMD(cvol_block_pack)(cvol_pack_task *task);

typedef float vf16 __attribute__((vector_size(64)));
typedef int32_t vi16 __attribute__((vector_size(64)));
typedef float vf8 __attribute__((vector_size(32)));
typedef double vd8 __attribute__((vector_size(64)));
typedef int32_t vi8 __attribute__((vector_size(32)));
typedef int64_t vl8 __attribute__((vector_size(64)));

/* One bit per lane of a comparison's mask. */
CVOL_INLINE uint32_t mask_bits(vi16 mask)
{
#if defined(__AVX512F__)
    return (uint32_t)_mm512_test_epi32_mask((__m512i)mask, (__m512i)mask);
#elif defined(__AVX2__)
    __m256 halves[2];
    memcpy(halves, &mask, sizeof mask);
    return (uint32_t)_mm256_movemask_ps(halves[0]) | (uint32_t)_mm256_movemask_ps(halves[1]) << 8;
#else
    uint32_t bits = 0;
    for (int lane = 0; lane < 16; lane++)
        bits |= ((uint32_t)mask[lane] & 1) << lane;
    return bits;
#endif
}

/* The first and the last eight lanes in double precision. */
CVOL_INLINE void widen(vd8 *first, vd8 *last, vf16 v)
{
#if defined(__AVX512F__)
    *first = (vd8)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)v));
    *last = (vd8)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)v, 1));
#else
    vf8 half[2];
    memcpy(half, &v, sizeof v);
    *first = __builtin_convertvector(half[0], vd8);
    *last = __builtin_convertvector(half[1], vd8);
#endif
}

/* Appends the lanes whose bit is set. */
CVOL_INLINE uint32_t append(cvol_scan_task *task, uint32_t count, uint32_t bits, vf16 value,
                            uint32_t at)
{
#if defined(__AVX512F__)
    const __m512i lanes = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i places = _mm512_add_epi32(lanes, _mm512_set1_epi32((int)at));
    _mm512_storeu_ps(task->values + count,
                     _mm512_maskz_compress_ps((__mmask16)bits, (__m512)value));
    _mm512_storeu_si512(task->places + count, _mm512_maskz_compress_epi32((__mmask16)bits, places));
    return count + (uint32_t)__builtin_popcount(bits);
#else
    float lanes[16];
    memcpy(lanes, &value, sizeof value);
    for (; bits; bits &= bits - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(bits);
        task->places[count] = at + lane;
        task->values[count++] = lanes[lane];
    }
    return count;
#endif
}

CVOL_INLINE void scan(cvol_scan_task *task, int with_keys)
{
    const int B = 1 << task->block_log2;
    const vi16 iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const vi16 positive = INT32_MAX - (vi16){0};
    const int rows = task->rank > 1 ? task->box[1] : 1, sheets = task->rank > 2 ? task->box[2] : 1;
    /* Rows that are scanned whole are contiguous. */
    const int merged = task->box[0] == B;
    const int length = merged ? rows * B : task->box[0], lines = merged ? 1 : rows;
    const float *coefficients = task->coefficients, *keys = task->keys;
    const float least = task->least;
    vd8 low = {0}, high = {0};
    uint32_t count = 0;
    for (int sheet = 0; sheet < sheets; sheet++)
        for (int line = 0; line < lines; line++) {
            const int begin = (sheet * B + line) * B;
            for (int i = 0; i < length; i += 16) {
                vf16 value, key;
                memcpy(&value, coefficients + begin + i, sizeof value);
                const vi16 inside = iota < length - i;
                value = (vf16)((vi16)value & inside);
                key = (vf16)((vi16)value & positive);
                if (with_keys) {
                    memcpy(&key, keys + begin + i, sizeof key);
                    key = (vf16)((vi16)key & inside);
                }
                const vi16 kept = key >= least;
                const uint32_t bits = mask_bits(kept);
                if (bits)
                    count = append(task, count, bits, value, (uint32_t)(begin + i));
                const vf16 rest = (vf16)((vi16)value & ~kept);
                vd8 a, b;
                widen(&a, &b, rest);
                low += a * a;
                high += b * b;
            }
        }
    low += high;
    double sum = 0;
    for (int lane = 0; lane < 8; lane++)
        sum += low[lane];
    task->lost = sum;
    task->count = count;
}

void CVOL_SIMD(cvol_block_scan)(cvol_scan_task *task)
{
    if (task->keys)
        scan(task, 1);
    else
        scan(task, 0);
}

/* ---- packing ------------------------------------------------------------------------------- */

CVOL_INLINE uint32_t mask_bits8(vi8 mask)
{
#if defined(__AVX2__)
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#else
    uint32_t bits = 0;
    for (int lane = 0; lane < 8; lane++)
        bits |= ((uint32_t)mask[lane] & 1) << lane;
    return bits;
#endif
}

CVOL_INLINE vi8 larger_of(vi8 a, vi8 b)
{
    const vi8 first = a > b;
    return (a & first) | (b & ~first);
}

CVOL_INLINE int largest_lane(vi8 v)
{
    int largest = 0;
    for (int lane = 0; lane < 8; lane++)
        largest = v[lane] > largest ? v[lane] : largest;
    return largest;
}

/* Appends the words of the lanes whose bit is set. */
CVOL_INLINE uint32_t *append_words(uint32_t *words, vi8 word, uint32_t bits)
{
#if defined(__AVX512F__)
    const __m256i kept = _mm256_maskz_compress_epi32((__mmask8)bits, (__m256i)word);
    memcpy(words, &kept, sizeof kept);
    return words + __builtin_popcount(bits);
#else
    int32_t lanes[8];
    memcpy(lanes, &word, sizeof lanes);
    for (; bits; bits &= bits - 1)
        *words++ = (uint32_t)lanes[__builtin_ctz(bits)];
    return words;
#endif
}

/* The same if one of them is an escape. */
static uint32_t *append_terms(uint32_t *words, const int32_t *integers, const uint32_t *places,
                              uint32_t bits, int place_bits)
{
    for (; bits; bits &= bits - 1) {
        const int lane = __builtin_ctz(bits);
        words += cvol_term_pack(words, places[lane], integers[lane], place_bits);
    }
    return words;
}

/* Eight together in double precision, for the same reason. */
void CVOL_SIMD(cvol_block_pack)(cvol_pack_task *task)
{
    const vi8 iota = {0, 1, 2, 3, 4, 5, 6, 7};
    const vl8 positive = INT64_MAX - (vl8){0};
    const double step = task->step, inverse = 1 / step, least = (double)task->least;
    const double most = (double)(1 << CVOL_MAX_BITS);
    const int count = (int)task->count, log2 = task->block_log2;
    const int place_bits = cvol_place_bits(log2), field = (1 << log2) - 1;
    const int32_t escape = -cvol_term_escape(place_bits);
    uint32_t *words = task->words;
    vd8 lost = {0}, norm = {0}, largest = {0};
    vi8 last_u = {0}, last_v = {0}, last = {0};
    uint32_t terms = 0;
    for (int i = 0; i < count; i += 8) {
        vf8 value;
        memcpy(&value, task->values + i, sizeof value);
        const vi8 bits = (vi8)value & (iota < count - i);
        const vd8 c = __builtin_convertvector((vf8)bits, vd8);
        const vd8 magnitude = (vd8)((vl8)c & positive);
        const vd8 steps = magnitude * inverse + 0.5;
        const vl8 kept = (magnitude >= least) & (steps < most);
        const vi8 sign = bits >> 31;
        const vi8 whole = __builtin_convertvector((vd8)((vl8)steps & kept), vi8);
        const vi8 integer = (whole ^ sign) - sign;
        memcpy(task->integers + i, &integer, sizeof integer);
        const vd8 rest = c - __builtin_convertvector(integer, vd8) * step;
        const vl8 larger = magnitude > largest;
        lost += rest * rest;
        norm += c * c;
        largest = (vd8)(((vl8)magnitude & larger) | ((vl8)largest & ~larger));

        vi8 place;
        memcpy(&place, task->places + i, sizeof place);
        const vi8 there = whole != 0;
        const uint32_t set = mask_bits8(there);
        place &= there;
        last_u = larger_of(last_u, place & field);
        last_v = larger_of(last_v, place >> log2 & field);
        last = larger_of(last, place);
        terms += (uint32_t)__builtin_popcount(set);
        if (__builtin_expect(mask_bits8(whole >= escape) != 0, 0))
            words = append_terms(words, task->integers + i, task->places + i, set, place_bits);
        else
            words = append_words(words, integer << place_bits | place, set);
    }
    task->word_count = (uint32_t)(words - task->words);
    task->terms = terms;
    task->low[0] = (uint8_t)(terms ? largest_lane(last_u) + 1 : 0);
    task->low[1] = (uint8_t)(terms ? largest_lane(last_v) + 1 : 0);
    task->low[2] = (uint8_t)(terms ? (largest_lane(last) >> 2 * log2) + 1 : 0);
    task->lost = task->norm = task->largest = 0;
    for (int lane = 0; lane < 8; lane++) {
        task->lost += lost[lane];
        task->norm += norm[lane];
        task->largest = largest[lane] > task->largest ? largest[lane] : task->largest;
    }
}
