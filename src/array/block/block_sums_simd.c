/* The words of a block, 16 together if none of them is an escape. Values are then below 2^22 if a
 * block has 2^9 of them, and smaller if it has more, so that double precision sums their squares
 * exactly, in any order. */
#include "array/block/block_sums.h"
#include "base/cpu.h"
#include "base/vector.h"

double CVOL_SIMD(cvol_block_squares)(const cvol_block *block, int place_bits);
typedef int32_t vi8 __attribute__((vector_size(32)));
typedef double vd8 __attribute__((vector_size(64)));

enum { WORDS = 16 };

/* Reads the values of 16 words; returns 1 if one of them is an escape. */
CVOL_INLINE int read_values(vi8 values[2], const uint32_t *words, int place_bits)
{
    const int32_t escape = cvol_term_escape(place_bits);
    memcpy(values, words, WORDS * sizeof *words);
    values[0] >>= place_bits;
    values[1] >>= place_bits;
    const vi8 found = (values[0] == escape) | (values[1] == escape);
#if defined(__AVX2__)
    return !_mm256_testz_si256((__m256i)found, (__m256i)found);
#else
    int64_t any[4];
    memcpy(any, &found, sizeof any);
    return (any[0] | any[1] | any[2] | any[3]) != 0;
#endif
}

CVOL_INLINE double sum_of(vd8 lanes)
{
    double sum = 0;
    for (int lane = 0; lane < 8; lane++)
        sum += lanes[lane];
    return sum;
}

double CVOL_SIMD(cvol_block_squares)(const cvol_block *block, int place_bits)
{
    const uint32_t *words = block->terms, *const end = cvol_block_end(block);
    vd8 small[2] = {{0}, {0}};
    double large = 0;
    while (words < end) {
        vi8 values[2];
        if (end - words >= WORDS && !read_values(values, words, place_bits)) {
            for (int half = 0; half < 2; half++) {
                const vd8 v = __builtin_convertvector(values[half], vd8);
                small[half] += v * v;
            }
            words += WORDS;
            continue;
        }
        const uint32_t *const stop = end - words > WORDS ? words + WORDS : end;
        while (words < stop) {
            uint32_t place;
            const double v = (double)cvol_term_unpack(&words, &place, place_bits);
            large += v * v;
        }
    }
    return sum_of(small[0] + small[1]) + large;
}
