/* The scan for coefficients above a threshold, 16 together for every instruction set, so that the
 * sum of squares of the rest has the same bits everywhere. Most of a block is below. */
#include "array/core/array.h"
#include "array/truncate/build_pack.h"
#include "base/cpu.h"
#include "base/vector_double.h"

void CVOL_SIMD(cvol_block_scan)(cvol_scan_task *task);
void CVOL_SIMD(cvol_block_pack)(cvol_pack_task *task);

enum { SCANNED = 16, REGISTERS = SCANNED / CVOL_LANES };

/* Appends the coefficients of the SCANNED from `at` on whose bit is set. */
CVOL_INLINE uint32_t append(cvol_scan_task *task, uint32_t count, uint32_t bits, uint32_t at)
{
#if defined(__AVX512F__)
    const __m512i lanes = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i places = _mm512_add_epi32(lanes, _mm512_set1_epi32((int)at));
    const __m512 value = _mm512_loadu_ps(task->coefficients + at);
    _mm512_storeu_ps(task->values + count, _mm512_maskz_compress_ps((__mmask16)bits, value));
    _mm512_storeu_si512(task->places + count, _mm512_maskz_compress_epi32((__mmask16)bits, places));
    return count + (uint32_t)__builtin_popcount(bits);
#else
    for (; bits; bits &= bits - 1) {
        const uint32_t place = at + (uint32_t)__builtin_ctz(bits);
        task->places[count] = place;
        task->values[count++] = task->coefficients[place];
    }
    return count;
#endif
}

CVOL_INLINE void scan(cvol_scan_task *task, int with_keys)
{
    const int B = 1 << task->block_log2;
    const cvol_vi iota = cvol_to_int(cvol_iota()), positive = INT32_MAX - (cvol_vi){0};
    const int rows = task->rank > 1 ? task->box[1] : 1, sheets = task->rank > 2 ? task->box[2] : 1;
    /* Rows that are scanned whole are contiguous. */
    const int merged = task->box[0] == B;
    const int length = merged ? rows * B : task->box[0], lines = merged ? 1 : rows;
    const float *coefficients = task->coefficients, *keys = task->keys;
    const float least = task->least;
    cvol_vd sums[2 * REGISTERS];
    memset(sums, 0, sizeof sums);
    uint32_t count = 0;
    for (int sheet = 0; sheet < sheets; sheet++)
        for (int line = 0; line < lines; line++) {
            const int begin = (sheet * B + line) * B;
            for (int i = 0; i < length; i += SCANNED) {
                uint32_t bits = 0;
#pragma GCC unroll 4
                for (int r = 0; r < REGISTERS; r++) {
                    const int at = begin + i + r * CVOL_LANES;
                    const cvol_vi inside = iota < length - i - r * CVOL_LANES;
                    const cvol_vi value = (cvol_vi)cvol_load(coefficients + at) & inside;
                    const cvol_vi key = with_keys ? (cvol_vi)cvol_load(keys + at) & inside
                                                  : value & positive;
                    const cvol_vi kept = (cvol_vf)key >= least;
                    bits |= cvol_mask_bits(kept) << r * CVOL_LANES;
                    cvol_vd first, last;
                    cvol_vd_widen(&first, &last, (cvol_vf)(value & ~kept));
                    sums[2 * r] += first * first;
                    sums[2 * r + 1] += last * last;
                }
                if (bits)
                    count = append(task, count, bits, (uint32_t)(begin + i));
            }
        }
    double lanes[SCANNED], sum = 0;
    memcpy(lanes, sums, sizeof lanes);
    for (int lane = 0; lane < SCANNED / 2; lane++)
        sum += lanes[lane] + lanes[SCANNED / 2 + lane];
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

enum { PACKED = 8, PACK_REGISTERS = PACKED / CVOL_VD_LANES };
typedef cvol_vd_ints ints;

/* 0, 1, 2, ... */
CVOL_INLINE ints iota_ints(void)
{
#if CVOL_VD_LANES == 8
    return (ints){0, 1, 2, 3, 4, 5, 6, 7};
#elif CVOL_VD_LANES == 4
    return (ints){0, 1, 2, 3};
#else
    return (ints){0, 1};
#endif
}

/* One bit per lane of a comparison's mask. */
CVOL_INLINE uint32_t bits_of(ints mask)
{
#if defined(__AVX512F__)
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#elif defined(__AVX2__)
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#else
    uint32_t bits = 0;
    for (int lane = 0; lane < CVOL_VD_LANES; lane++)
        bits |= ((uint32_t)mask[lane] & 1) << lane;
    return bits;
#endif
}

CVOL_INLINE ints larger_of(ints a, ints b)
{
    const ints first = a > b;
    return (a & first) | (b & ~first);
}

CVOL_INLINE int largest_lane(ints v)
{
    int largest = 0;
    for (int lane = 0; lane < CVOL_VD_LANES; lane++)
        largest = v[lane] > largest ? v[lane] : largest;
    return largest;
}

/* Appends the words of the lanes whose bit is set. */
CVOL_INLINE uint32_t *append_words(uint32_t *words, ints word, uint32_t bits)
{
#if defined(__AVX512F__)
    const __m256i kept = _mm256_maskz_compress_epi32((__mmask8)bits, (__m256i)word);
    memcpy(words, &kept, sizeof kept);
    return words + __builtin_popcount(bits);
#else
    int32_t lanes[CVOL_VD_LANES];
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
    const ints iota = iota_ints();
    const cvol_vl positive = INT64_MAX - (cvol_vl){0};
    const double step = task->step, inverse = 1 / step, least = (double)task->least;
    const double most = (double)(1 << CVOL_MAX_BITS);
    const int count = (int)task->count, log2 = task->block_log2;
    const int place_bits = cvol_place_bits(log2), field = (1 << log2) - 1;
    const int32_t escape = -cvol_term_escape(place_bits);
    uint32_t *words = task->words;
    cvol_vd lost[PACK_REGISTERS], norm[PACK_REGISTERS], largest = {0};
    memset(lost, 0, sizeof lost);
    memset(norm, 0, sizeof norm);
    ints last_u = {0}, last_v = {0}, last = {0};
    uint32_t terms = 0;
    for (int group = 0; group < count; group += PACKED) {
#pragma GCC unroll 4
        for (int r = 0; r < PACK_REGISTERS; r++) {
            const int i = group + r * CVOL_VD_LANES;
            ints bits, place;
            memcpy(&bits, task->values + i, sizeof bits);
            memcpy(&place, task->places + i, sizeof place);
            bits &= iota < count - i;
            const cvol_vd c = __builtin_convertvector((cvol_vd_floats)bits, cvol_vd);
            const cvol_vd magnitude = (cvol_vd)((cvol_vl)c & positive);
            const cvol_vd steps = magnitude * inverse + 0.5;
            const cvol_vl kept = (magnitude >= least) & (steps < most);
            const ints sign = bits >> 31;
            const ints whole = __builtin_convertvector((cvol_vd)((cvol_vl)steps & kept), ints);
            const ints integer = (whole ^ sign) - sign;
            memcpy(task->integers + i, &integer, sizeof integer);
            const cvol_vd rest = c - __builtin_convertvector(integer, cvol_vd) * step;
            lost[r] += rest * rest;
            norm[r] += c * c;
            largest = cvol_vd_above(magnitude, largest);

            const ints there = whole != 0;
            const uint32_t set = bits_of(there);
            place &= there;
            last_u = larger_of(last_u, place & field);
            last_v = larger_of(last_v, place >> log2 & field);
            last = larger_of(last, place);
            terms += (uint32_t)__builtin_popcount(set);
            if (__builtin_expect(bits_of(whole >= escape) != 0, 0))
                words = append_terms(words, task->integers + i, task->places + i, set, place_bits);
            else
                words = append_words(words, integer << place_bits | place, set);
        }
    }
    task->word_count = (uint32_t)(words - task->words);
    task->terms = terms;
    task->low[0] = (uint8_t)(terms ? largest_lane(last_u) + 1 : 0);
    task->low[1] = (uint8_t)(terms ? largest_lane(last_v) + 1 : 0);
    task->low[2] = (uint8_t)(terms ? (largest_lane(last) >> 2 * log2) + 1 : 0);
    task->lost = task->norm = task->largest = 0;
    for (int lane = 0; lane < PACKED; lane++) {
        task->lost += lost[lane / CVOL_VD_LANES][lane % CVOL_VD_LANES];
        task->norm += norm[lane / CVOL_VD_LANES][lane % CVOL_VD_LANES];
    }
    for (int lane = 0; lane < CVOL_VD_LANES; lane++)
        task->largest = largest[lane] > task->largest ? largest[lane] : task->largest;
}
