/* Samples of 16 bits along lines that cross rows of samples at a slant (sheet_slant.h), 32 pixels
 * at once, with AVX-512: rows are loaded one after the other, and each pixel takes its four samples
 * when its own are there.
 *
 * To be included by sheet_compact.h only.
 */
#ifndef CVOL_RENDER_SHEET_SLANT_COMPACT_H
#define CVOL_RENDER_SHEET_SLANT_COMPACT_H

/* The lower words of 32 numbers. */
CVOL_INLINE __m512i join_words(__m512i low, __m512i high)
{
    const __m512i even = _mm512_set_epi16(62, 60, 58, 56, 54, 52, 50, 48, 46, 44, 42, 40, 38, 36,
                                          34, 32, 30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6,
                                          4, 2, 0);
    return _mm512_permutex2var_epi16(low, even, high);
}

/* 16 pixels of a group, at u and v in 2^-16 samples from (x0, y0): which have a window with nothing
 * to be seen, and what these hold, as words in 32 bits. */
CVOL_INLINE __mmask16 find_unseen(__m512i *levels, const compact_job *c, const sheet_line *sheet,
                                  int group)
{
    const cvol_layer *layer = c->job->layer;
    const cvol_windows *windows = sheet->windows;
    const long i = (long)group * CVOL_GROUP;
    const double x = sheet->lane_at + (double)i * sheet->lane_step,
                 y = sheet->row_at + (double)i * sheet->row_right;
    const double x0 = floor(x), y0 = floor(y);
    const __m512i u = _mm512_add_epi32(c->ramp[0],
                                       _mm512_set1_epi32((int32_t)((x - x0) * PLACE_ONE))),
                  v = _mm512_add_epi32(c->ramp[1],
                                       _mm512_set1_epi32((int32_t)((y - y0) * PLACE_ONE)));
    const __m512i zero = _mm512_setzero_si512(),
                  last = _mm512_set1_epi32(layer->block_rows * layer->row_points - 1),
                  last_window = _mm512_set1_epi32(windows->count - 1);
    const __m512i column = _mm512_add_epi32(_mm512_srli_epi32(u, 16),
                                            _mm512_set1_epi32((int)x0 + CVOL_GROUP)),
                  low = _mm512_add_epi32(_mm512_srai_epi32(v, 16), _mm512_set1_epi32((int)y0)),
                  high = _mm512_add_epi32(low, _mm512_set1_epi32(1));
    const __m512i window = _mm512_max_epi32(
        _mm512_min_epi32(_mm512_srai_epi32(column, 4), last_window), zero);
    const float inverse = 1 / (float)layer->row_points;
    __m512i rows[2];
    for (int k = 0; k < 2; k++) {
        const __m512i row = _mm512_max_epi32(_mm512_min_epi32(k ? high : low, last), zero);
        const __m512i block = _mm512_cvttps_epi32(_mm512_mul_ps(
            _mm512_add_ps(_mm512_cvtepi32_ps(row), _mm512_set1_ps(0.5f)), _mm512_set1_ps(inverse)));
        rows[k] = _mm512_max_epi32(_mm512_min_epi32(block, _mm512_set1_epi32(windows->last_row)),
                                   _mm512_set1_epi32(windows->first_row));
    }
    const __mmask16 crosses = _mm512_cmpgt_epi32_mask(rows[1], rows[0]);
    const __m512i first = _mm512_add_epi32(
        _mm512_mullo_epi32(rows[0], _mm512_set1_epi32(windows->count)), window);
    /* What is across lies behind what is within. */
    const __m512i at = _mm512_mask_add_epi32(
        first, crosses, first, _mm512_set1_epi32((int)(windows->across - windows->within)));
    const __m512i bits = _mm512_i32gather_epi32(at, windows->within, 1);
    const __mmask16 unseen = _mm512_testn_epi32_mask(bits, _mm512_set1_epi32(CVOL_WINDOW_SEEN));
    const __m512 level = _mm512_mask_i32gather_ps(_mm512_setzero_ps(), unseen, at,
                                                  windows->within_level, 4);
    const __m512i word = _mm512_cvtps_epi32(
        _mm512_add_ps(_mm512_mul_ps(level, _mm512_set1_ps(layer->compact.scale)),
                      _mm512_set1_ps(layer->compact.offset)));
    *levels = _mm512_max_epi32(_mm512_min_epi32(word, _mm512_set1_epi32(ONE_WORD)), zero);
    return unseen;
}

/* Puts levels where pixels see nothing. */
CVOL_COLD __m512i put_level_words(__m512i values, const compact_job *c, const sheet_line *sheet,
                                  int group, int halves)
{
    __m512i levels[PAIR] = {_mm512_setzero_si512(), _mm512_setzero_si512()};
    __mmask32 unseen = 0;
    for (int half = 0; half < PAIR; half++)
        if (halves >> half & 1)
            unseen |= (__mmask32)find_unseen(&levels[half], c, sheet, group + half)
                      << (half * CVOL_GROUP);
    return _mm512_mask_mov_epi16(values, unseen, join_words(levels[0], levels[1]));
}

/* Where 32 pixels lie, from the first one's sample on: lanes and rows, and how far behind these. */
typedef struct slanted_place {
    const int16_t *from;             /* the sample before the first pixel, in the row before it */
    __m512i lane, right, row, below; /* in words; parts are times 2^15 */
    int first_row, last_row;         /* of those pixels that are asked for */
} slanted_place;

/* `count`: 16 pixels are asked for, or 32. */
CVOL_INLINE slanted_place place_words(const compact_job *c, const sheet_line *sheet, int group,
                                      int count)
{
    const double i = (double)group * CVOL_GROUP;
    const double x = sheet->lane_at + i * sheet->lane_step,
                 y = sheet->row_at + i * sheet->row_right;
    const double x0 = floor(x), y0 = floor(y);
    const __m512i odd = _mm512_set_epi16(63, 61, 59, 57, 55, 53, 51, 49, 47, 45, 43, 41, 39, 37, 35,
                                         33, 31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3,
                                         1);
    const int32_t u0 = (int32_t)((x - x0) * PLACE_ONE), v0 = (int32_t)((y - y0) * PLACE_ONE);
    __m512i u[2], v[2];
    for (int half = 0; half < 2; half++) {
        const int further = half * CVOL_GROUP;
        u[half] = _mm512_add_epi32(c->ramp[0], _mm512_set1_epi32(u0 + further * c->steps[0]));
        v[half] = _mm512_add_epi32(c->ramp[1], _mm512_set1_epi32(v0 + further * c->steps[1]));
    }
    const int end = (v0 + (count - 1) * c->steps[1]) >> 16;
    return (slanted_place){
        .from = sheet->origin + (long)y0 * c->job->layer->row_stride + (long)x0,
        .lane = _mm512_permutex2var_epi16(u[0], odd, u[1]),
        .right = _mm512_srli_epi16(join_words(u[0], u[1]), 1),
        .row = _mm512_permutex2var_epi16(v[0], odd, v[1]),
        .below = _mm512_srli_epi16(join_words(v[0], v[1]), 1),
        .first_row = end < 0 ? end : 0,
        .last_row = end < 0 ? 0 : end,
    };
}

/* Four samples around each of 32 pixels. */
typedef struct around_words {
    __m512i near_left, near_right, far_left, far_right;
} around_words;

/* From the rows that they lie in, one after the other, as far as these lie within 32 samples. */
CVOL_INLINE around_words take_around(const slanted_place *at, long stride)
{
    const __m512i left = at->lane, right = _mm512_add_epi16(left, _mm512_set1_epi16(1));
    around_words out = {_mm512_setzero_si512(), _mm512_setzero_si512(), _mm512_setzero_si512(),
                        _mm512_setzero_si512()};
    const int16_t *line = at->from + at->first_row * stride;
    __mmask32 far = 0;
    for (int row = at->first_row; row <= at->last_row + 1; row++, line += stride) {
        const __m512i samples = load_words(line);
        const __mmask32 near = _mm512_cmpeq_epi16_mask(at->row, _mm512_set1_epi16((int16_t)row));
        out.near_left = _mm512_mask_permutexvar_epi16(out.near_left, near, left, samples);
        out.near_right = _mm512_mask_permutexvar_epi16(out.near_right, near, right, samples);
        out.far_left = _mm512_mask_permutexvar_epi16(out.far_left, far, left, samples);
        out.far_right = _mm512_mask_permutexvar_epi16(out.far_right, far, right, samples);
        far = near;
    }
    return out;
}

/* The same where they lie within 64. */
CVOL_INLINE around_words take_around_widely(const slanted_place *at, long stride)
{
    const __m512i left = at->lane, right = _mm512_add_epi16(left, _mm512_set1_epi16(1));
    around_words out = {_mm512_setzero_si512(), _mm512_setzero_si512(), _mm512_setzero_si512(),
                        _mm512_setzero_si512()};
    const int16_t *line = at->from + at->first_row * stride;
    __mmask32 far = 0;
    for (int row = at->first_row; row <= at->last_row + 1; row++, line += stride) {
        const __m512i low = load_words(line), high = load_words(line + PAIR_LANES);
        const __mmask32 near = _mm512_cmpeq_epi16_mask(at->row, _mm512_set1_epi16((int16_t)row));
        const __m512i a = _mm512_permutex2var_epi16(low, left, high),
                      b = _mm512_permutex2var_epi16(low, right, high);
        out.near_left = _mm512_mask_mov_epi16(out.near_left, near, a);
        out.near_right = _mm512_mask_mov_epi16(out.near_right, near, b);
        out.far_left = _mm512_mask_mov_epi16(out.far_left, far, a);
        out.far_right = _mm512_mask_mov_epi16(out.far_right, far, b);
        far = near;
    }
    return out;
}

/* The same one by one, of the first `count` pixels: where rows are many, or samples far apart. */
CVOL_COLD around_words gather_around(const slanted_place *at, long stride, int count)
{
    int16_t lane[PAIR_LANES], row[PAIR_LANES], out[4][PAIR_LANES] = {{0}};
    _mm512_storeu_si512(lane, at->lane);
    _mm512_storeu_si512(row, at->row);
    for (int i = 0; i < count; i++) {
        const int16_t *from = at->from + row[i] * stride + lane[i];
        out[0][i] = from[0];
        out[1][i] = from[1];
        out[2][i] = from[stride];
        out[3][i] = from[stride + 1];
    }
    return (around_words){load_words(out[0]), load_words(out[1]), load_words(out[2]),
                          load_words(out[3])};
}

/* More rows than that are looked at pixel by pixel. */
#define ROWS_MOST 16

/* Samples of those of 32 pixels from a group on that have bits in `halves`. */
CVOL_INLINE __m512i reconstruct_slanted_words(const compact_job *c, int s, int group, int halves)
{
    const sheet_line *sheet = &c->job->sheets[s];
    const long stride = c->job->layer->row_stride;
    const int count = halves == 3 ? PAIR_LANES : CVOL_GROUP, only_second = halves == 2;
    const slanted_place at = place_words(c, sheet, group + only_second, count);
    const around_words four = c->lanes_at_once == 0 || at.last_row - at.first_row > ROWS_MOST
                                  ? gather_around(&at, stride, count)
                              : c->lanes_at_once == PAIR_LANES ? take_around(&at, stride)
                                                               : take_around_widely(&at, stride);
    const __m512i near = _mm512_add_epi16(
                      four.near_left,
                      _mm512_mulhrs_epi16(_mm512_sub_epi16(four.near_right, four.near_left),
                                          at.right)),
                  far = _mm512_add_epi16(
                      four.far_left,
                      _mm512_mulhrs_epi16(_mm512_sub_epi16(four.far_right, four.far_left),
                                          at.right));
    __m512i values = _mm512_add_epi16(near,
                                      _mm512_mulhrs_epi16(_mm512_sub_epi16(far, near), at.below));
    if (only_second)
        values = _mm512_shuffle_i64x2(values, values, 0x44);
    const uint32_t *mixed = &c->job->mixed[group - c->job->first_group];
    const int first = halves & 1 ? (int)(mixed[0] >> s & 1) : 0,
              second = halves & 2 ? (int)(mixed[1] >> s & 1) : 0;
    if (first | second)
        return put_level_words(values, c, sheet, group, first | second << 1);
    return values;
}

#endif
