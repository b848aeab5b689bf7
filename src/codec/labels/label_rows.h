/* Rows of labels: comparisons of whole rows, and windows of neighbours for the network of masks. */
#ifndef CVOL_CODEC_LABELS_LABEL_ROWS_H
#define CVOL_CODEC_LABELS_LABEL_ROWS_H

#include <stdint.h>

#include "array/core/array.h"
#include "base/vector.h"
#include "codec/mask/mask_predict.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

enum {
    CVOL_LABEL_BORDER = 8, /* labels beyond either end of a row */
    CVOL_LABEL_WIDTH = CVOL_BRICK_SIDE + 2 * CVOL_LABEL_BORDER,
    CVOL_LABEL_ROWS = CVOL_BRICK_SIDE + 4 /* of a slice: two above the brick's, two below */
};

/* A row of positions in the list of labels. The brick's begin at CVOL_LABEL_BORDER. */
typedef struct cvol_label_row {
    uint16_t at[CVOL_LABEL_WIDTH];
} cvol_label_row;

/* The rows around a sample: [2] of each has its y. The later rows of `own` are not known. */
typedef struct cvol_label_rows {
    cvol_label_row *own;
    const cvol_label_row *before, *second; /* one and two slices before */
} cvol_label_rows;

/* Bit i: a[i] equals b[i]; 64 labels. */
CVOL_INLINE uint64_t cvol_label_equal(const uint16_t *a, const uint16_t *b)
{
    uint64_t bits = 0;
#if defined(__SSE2__)
    for (int i = 0; i < 64; i += 16) {
        const __m128i *p = (const __m128i *)(const void *)(a + i);
        const __m128i *q = (const __m128i *)(const void *)(b + i);
        const __m128i low = _mm_cmpeq_epi16(_mm_loadu_si128(p), _mm_loadu_si128(q));
        const __m128i high = _mm_cmpeq_epi16(_mm_loadu_si128(p + 1), _mm_loadu_si128(q + 1));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_packs_epi16(low, high)) << i;
    }
#elif defined(__wasm_simd128__)
    for (int i = 0; i < 64; i += 8)
        bits |= (uint64_t)wasm_i16x8_bitmask(
                    wasm_i16x8_eq(wasm_v128_load(a + i), wasm_v128_load(b + i)))
                << i;
#else
    for (int i = 0; i < 64; i++)
        bits |= (uint64_t)(a[i] == b[i]) << i;
#endif
    return bits;
}

/* Bit k: row[k - 4] equals the label; 8 labels. */
CVOL_INLINE unsigned cvol_label_window(const uint16_t *row, uint16_t label)
{
#if defined(__SSE2__)
    const __m128i labels = _mm_loadu_si128((const __m128i *)(const void *)(row - 4));
    const __m128i same = _mm_cmpeq_epi16(labels, _mm_set1_epi16((int16_t)label));
    return (unsigned)_mm_movemask_epi8(_mm_packs_epi16(same, _mm_setzero_si128()));
#elif defined(__wasm_simd128__)
    return wasm_i16x8_bitmask(wasm_i16x8_eq(wasm_v128_load(row - 4), wasm_u16x8_splat(label)));
#else
    unsigned bits = 0;
    for (int k = 0; k < 8; k++)
        bits |= (unsigned)(row[k - 4] == label) << k;
    return bits;
#endif
}

/* Bit x: all samples at dx = -1 .. 1 in the rows (dy, dz) = (-1, -1), (0, -1), (1, -1), (-1, 0) of
 * sample x of the brick's row are equal. */
CVOL_INLINE uint64_t cvol_label_uniform(const cvol_label_rows *rows)
{
    const uint16_t *above = rows->own[1].at + CVOL_LABEL_BORDER;
    const uint16_t *before = rows->before[2].at + CVOL_LABEL_BORDER;
    const uint16_t *upper = rows->before[1].at + CVOL_LABEL_BORDER;
    const uint16_t *lower = rows->before[3].at + CVOL_LABEL_BORDER;
    const uint64_t across = cvol_label_equal(before, above) & cvol_label_equal(before, upper) &
                            cvol_label_equal(before, lower);
    const uint64_t along = cvol_label_equal(above, above + 1); /* and its next sample */
    uint64_t ends[2];
    for (int i = 0; i < 2; i++) {
        const int x = i ? CVOL_BRICK_SIDE : -1;
        ends[i] = before[x] == above[x] && before[x] == upper[x] && before[x] == lower[x];
    }
    return across & (across << 1 | ends[0]) & (across >> 1 | ends[1] << 63) & along &
           (along << 1 | (uint64_t)(above[-1] == above[0]));
}

/* Which neighbours equal a label: the level of the network for it, and the pattern of twelve near
 * ones. */
typedef struct cvol_label_view {
    int level;
    unsigned pattern;
} cvol_label_view;

/* For the sample in column x of a row, from CVOL_LABEL_BORDER on. */
CVOL_INLINE cvol_label_view cvol_label_look(const cvol_mask_sums *table,
                                            const cvol_label_rows *rows, size_t x, uint16_t label)
{
    const unsigned second = cvol_label_window(rows->second[2].at + x, label);
    const unsigned upper = cvol_label_window(rows->before[1].at + x, label);
    const unsigned before = cvol_label_window(rows->before[2].at + x, label);
    const unsigned lower = cvol_label_window(rows->before[3].at + x, label);
    const unsigned highest = cvol_label_window(rows->own[0].at + x, label);
    const unsigned above = cvol_label_window(rows->own[1].at + x, label);
    const unsigned own = cvol_label_window(rows->own[2].at + x, label);
    const unsigned windows[] = {cvol_label_window(rows->second[1].at + x, label) >> 3 & 7,
                                second >> 3 & 7,
                                cvol_label_window(rows->second[3].at + x, label) >> 3 & 7,
                                cvol_label_window(rows->before[0].at + x, label) >> 2 & 31,
                                upper >> 2 & 31,
                                before >> 2 & 31,
                                lower >> 2 & 31,
                                cvol_label_window(rows->before[4].at + x, label) >> 2 & 31,
                                highest >> 2 & 31};
    cvol_mask_half sums[2] = {{0}, {0}};
    for (int k = 0; k < 3; k++, table += 8)
        cvol_mask_add(sums, table + windows[k]);
    for (int k = 3; k < 9; k++, table += 32)
        cvol_mask_add(sums, table + windows[k]);
    cvol_mask_add(sums, table + (above >> 1 & 127));
    cvol_mask_add(sums, table + 128 + (own & 15));
    const unsigned pattern = (own >> 2 & 3) | (above >> 3 & 7) << 2 | (before >> 3 & 7) << 5 |
                             (upper >> 4 & 1) << 8 | (lower >> 4 & 1) << 9 |
                             (highest >> 4 & 1) << 10 | (second >> 4 & 1) << 11;
    return (cvol_label_view){cvol_mask_level(cvol_mask_output(sums)), pattern};
}

#endif
