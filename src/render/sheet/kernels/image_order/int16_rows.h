/* int16 samples along lines that cross rows of samples obliquely (line_slanted.h), 32 pixels
 * together, with AVX-512: it loads rows one after the other, and each pixel takes its four samples
 * from its own rows.
 *
 * Only render/sheet/kernels/composite/int16.h includes this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_INT16_ROWS_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_INT16_ROWS_H

/* The lower halves of 32 numbers. */
CVOL_INLINE __m512i join_int16(__m512i low, __m512i high)
{
    const __m512i even = _mm512_set_epi16(62, 60, 58, 56, 54, 52, 50, 48, 46, 44, 42, 40, 38, 36,
                                          34, 32, 30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6,
                                          4, 2, 0);
    return _mm512_permutex2var_epi16(low, even, high);
}

/* The positions of 32 pixels, relative to the first sample and row that any of them takes: lanes
 * and rows, and the distances from them. */
typedef struct image_order_place {
    const int16_t *from;             /* that sample, */
    int column, line;                /* which is this one */
    __m512i lane, right, row, below; /* in int16; parts are times 2^15 */
    int last_lane, last_row;         /* of the requested pixels */
} image_order_place;

/* `count`: 16 or 32 pixels are requested. */
CVOL_INLINE image_order_place place_int16(const int16_job *c, const sheet_line *sheet, int group,
                                          int count)
{
    const double i = (double)group * GROUP_ACROSS;
    const int pair = count == PAIR_LANES;
    const int32_t u_before = c->before[0][pair], v_before = c->before[1][pair];
    const double x = sheet->lane_at + i * sheet->lane_step + u_before * (1 / PLACE_ONE),
                 y = sheet->row_at + i * sheet->row_right + v_before * (1 / PLACE_ONE);
    const double x0 = floor(x), y0 = floor(y);
    const __m512i odd = _mm512_set_epi16(63, 61, 59, 57, 55, 53, 51, 49, 47, 45, 43, 41, 39, 37, 35,
                                         33, 31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3,
                                         1);
    const int32_t u0 = (int32_t)((x - x0) * PLACE_ONE), v0 = (int32_t)((y - y0) * PLACE_ONE);
    __m512i u[2], v[2];
    for (int half = 0; half < 2; half++) {
        const int further = half * GROUP_ACROSS;
        u[half] = _mm512_add_epi32(c->ramp[0],
                                   _mm512_set1_epi32(u0 - u_before + further * c->steps[0]));
        v[half] = _mm512_add_epi32(c->ramp[1],
                                   _mm512_set1_epi32(v0 - v_before + further * c->steps[1]));
    }
    return (image_order_place){
        .from = sheet->origin + (ptrdiff_t)y0 * c->job->layer->row_stride + (ptrdiff_t)x0,
        .column = (int)x0,
        .line = (int)y0,
        .lane = _mm512_permutex2var_epi16(u[0], odd, u[1]),
        .right = _mm512_srli_epi16(join_int16(u[0], u[1]), 1),
        .row = _mm512_permutex2var_epi16(v[0], odd, v[1]),
        .below = _mm512_srli_epi16(join_int16(v[0], v[1]), 1),
        .last_lane = (u0 + c->behind[0][pair] - u_before) >> 16,
        .last_row = (v0 + c->behind[1][pair] - v_before) >> 16,
    };
}

/* ---- invisible pixels ------------------------------------------------------------------------ */

/* Adjacent windows whose levels pixels look up together. */
#define WINDOWS_AT_ONCE 8

CVOL_INLINE __m128i level_int16(const cvol_layer *layer, const float *levels)
{
    const __m256 scaled = _mm256_add_ps(
        _mm256_mul_ps(_mm256_loadu_ps(levels), _mm256_set1_ps(layer->int16.scale)),
        _mm256_set1_ps(layer->int16.offset));
    return _mm_max_epi16(_mm256_cvtsepi32_epi16(_mm256_cvtps_epi32(scaled)), _mm_setzero_si128());
}

/* Levels of windows c0 .. c0 + 7 as int16, 8 behind 8: within row r0 of blocks, across it and the
 * next one, within row r1; -1 for visible windows. */
CVOL_INLINE __m512i find_level_int16(const cvol_layer *layer, const cvol_windows *windows, int c0,
                                     int r0, int r1)
{
    const ptrdiff_t at = (ptrdiff_t)r0 * windows->count + c0,
                    next = (ptrdiff_t)r1 * windows->count + c0;
    const int across = r1 > r0;
    const float *across_level = across ? windows->across_level : windows->within_level;
    const uint8_t *across_flags = across ? windows->across : windows->within;
    __m512i samples = _mm512_castsi128_si512(level_int16(layer, windows->within_level + at));
    samples = _mm512_inserti32x4(samples, level_int16(layer, across_level + at), 1);
    samples = _mm512_inserti32x4(samples, level_int16(layer, windows->within_level + next), 2);
    const __m256i flags = _mm256_set_epi64x(0, (int64_t)load_flags(windows->within + next),
                                            (int64_t)load_flags(across_flags + at),
                                            (int64_t)load_flags(windows->within + at));
    return _mm512_mask_mov_epi16(samples,
                                 _mm256_test_epi8_mask(flags, _mm256_set1_epi8(CVOL_WINDOW_SEEN)),
                                 _mm512_set1_epi16(-1));
}

/* Places along a group, as int16. */
CVOL_INLINE __m512i int16_of_place(int place)
{
    return _mm512_set1_epi16((int16_t)clamp_to(place + 8192, 16383) - 8192);
}

/* The same pixel by pixel. */
CVOL_COLD __m512i gather_level_int16(__m512i values, const cvol_layer *layer,
                                     const cvol_windows *windows, const image_order_place *at,
                                     __mmask32 which)
{
    __m256i samples[2];
    __mmask32 unseen = 0;
    for (int half = 0; half < PAIR; half++) {
        const __m256i lane = half ? _mm512_extracti64x4_epi64(at->lane, 1)
                                  : _mm512_castsi512_si256(at->lane),
                      row = half ? _mm512_extracti64x4_epi64(at->row, 1)
                                 : _mm512_castsi512_si256(at->row);
        __m512 levels;
        unseen |= (__mmask32)find_unseen(
                      &levels, layer, windows,
                      _mm512_add_epi32(_mm512_cvtepi16_epi32(lane), _mm512_set1_epi32(at->column)),
                      _mm512_add_epi32(_mm512_cvtepi16_epi32(row), _mm512_set1_epi32(at->line)))
                  << (half * CVOL_GROUP);
        samples[half] = _mm512_cvtepi32_epi16(_mm512_cvtps_epi32(kept_levels(layer, levels)));
    }
    return _mm512_mask_mov_epi16(
        values, unseen & which,
        _mm512_inserti64x4(_mm512_castsi256_si512(samples[0]), samples[1], 1));
}

/* Writes levels to the invisible pixels among `which`. */
CVOL_INLINE __m512i put_level_int16(__m512i values, const int16_job *c, const sheet_line *sheet,
                                    const image_order_place *at, __mmask32 which)
{
    const cvol_layer *layer = c->job->layer;
    const cvol_windows *windows = sheet->windows;
    const int last = layer->block_rows * layer->row_points - 1, last_window = windows->count - 1;
    const int c0 = clamp_to((at->column + CVOL_GROUP) >> 4, last_window),
              c1 = clamp_to((at->column + at->last_lane + CVOL_GROUP) >> 4, last_window);
    const uint64_t low = (uint64_t)clamp_to(at->line, last),
                   high = (uint64_t)clamp_to(at->line + at->last_row + 1, last);
    const int r0 = clamp_row(windows, (int)(low * layer->row_points_inverse >> 32)),
              r1 = clamp_row(windows, (int)(high * layer->row_points_inverse >> 32));
    if (c1 - c0 >= WINDOWS_AT_ONCE || r1 - r0 > 1)
        return gather_level_int16(values, layer, windows, at, which);
    const __m512i levels = find_level_int16(layer, windows, c0, r0, r1);
    const __m512i window = _mm512_srai_epi16(
        _mm512_add_epi16(at->lane, int16_of_place(at->column + CVOL_GROUP - 16 * c0)), 4);
    __m512i number = _mm512_max_epi16(_mm512_min_epi16(window, int16_of_place(last_window - c0)),
                                      _mm512_setzero_si512());
    if (r1 > r0) {
        const int next = (r0 + 1) * layer->row_points - at->line;
        const __mmask32 across = _mm512_cmpge_epi16_mask(at->row, int16_of_place(next - 1)),
                        beyond = _mm512_cmpge_epi16_mask(at->row, int16_of_place(next));
        const __m512i further = _mm512_set1_epi16(WINDOWS_AT_ONCE);
        number = _mm512_mask_add_epi16(number, across, number, further);
        number = _mm512_mask_add_epi16(number, beyond, number, further);
    }
    const __m512i level = _mm512_permutexvar_epi16(number, levels);
    return _mm512_mask_mov_epi16(values, which & ~_mm512_movepi16_mask(level), level);
}

/* Four samples around each of 32 pixels. */
typedef struct around_int16 {
    __m512i near_left, near_right, far_left, far_right;
} around_int16;

/* 32 samples, or their means with the samples of another slice, `other` further in memory. */
CVOL_INLINE __m512i load_row(const int16_t *from, ptrdiff_t other)
{
    return other ? _mm512_avg_epu16(cvol_load_32_int16(from), cvol_load_32_int16(from + other))
                 : cvol_load_32_int16(from);
}

/* Takes samples from their rows, one row after the other, if the samples of a row lie within 32, or
 * within 64 (`wide`). */
CVOL_INLINE around_int16 take_rows(const image_order_place *at, ptrdiff_t stride, int rows,
                                   int wide, ptrdiff_t other)
{
    const __m512i left = at->lane, right = _mm512_add_epi16(left, _mm512_set1_epi16(1));
    around_int16 out = {_mm512_setzero_si512(), _mm512_setzero_si512(), _mm512_setzero_si512(),
                        _mm512_setzero_si512()};
    const int last = at->last_row + 1;
    __mmask32 far = 0;
    for (int k = 0; k < rows; k++) {
        const int row = k < last ? k : last;
        const int16_t *line = at->from + row * stride;
        const __mmask32 near = _mm512_cmpeq_epi16_mask(at->row, _mm512_set1_epi16((int16_t)row));
        const __m512i low = load_row(line, other);
        if (wide) {
            const __m512i high = load_row(line + PAIR_LANES, other);
            const __m512i a = _mm512_permutex2var_epi16(low, left, high),
                          b = _mm512_permutex2var_epi16(low, right, high);
            out.near_left = _mm512_mask_mov_epi16(out.near_left, near, a);
            out.near_right = _mm512_mask_mov_epi16(out.near_right, near, b);
            out.far_left = _mm512_mask_mov_epi16(out.far_left, far, a);
            out.far_right = _mm512_mask_mov_epi16(out.far_right, far, b);
        } else {
            out.near_left = _mm512_mask_permutexvar_epi16(out.near_left, near, left, low);
            out.near_right = _mm512_mask_permutexvar_epi16(out.near_right, near, right, low);
            out.far_left = _mm512_mask_permutexvar_epi16(out.far_left, far, left, low);
            out.far_right = _mm512_mask_permutexvar_epi16(out.far_right, far, right, low);
        }
        far = near;
    }
    return out;
}

/* Four rows of 16 samples, in which one permutation finds a place. */
typedef struct four_rows {
    __m512i first, last;
} four_rows;

/* From row `from` on; rows behind the last repeat it. */
CVOL_INLINE four_rows load_four_rows(const image_order_place *at, ptrdiff_t stride, int from,
                                     ptrdiff_t other)
{
    const int last = at->last_row + 1;
    const int16_t *line[4];
    for (int k = 0; k < 4; k++)
        line[k] = at->from + (from + k < last ? from + k : last) * stride;
    four_rows out = {cvol_load_two_int16(line[0], line[1]), cvol_load_two_int16(line[2], line[3])};
    if (other) {
        out.first = _mm512_avg_epu16(out.first,
                                     cvol_load_two_int16(line[0] + other, line[1] + other));
        out.last = _mm512_avg_epu16(out.last,
                                    cvol_load_two_int16(line[2] + other, line[3] + other));
    }
    return out;
}

/* If all samples of a row lie within 16: from `fours` times four rows. */
CVOL_INLINE around_int16 take_fours(const image_order_place *at, ptrdiff_t stride, int fours,
                                    ptrdiff_t other)
{
    const __m512i place = _mm512_add_epi16(_mm512_slli_epi16(at->row, 4), at->lane);
    __m512i out[4];
    for (int k = 0; k < 4; k++)
        out[k] = _mm512_setzero_si512();
    for (int four = 0; four < fours; four++) {
        const four_rows rows = load_four_rows(at, stride, 4 * four, other);
        for (int k = 0; k < 4; k++) {
            const __m512i sample = _mm512_add_epi16(
                place, _mm512_set1_epi16((int16_t)((k & 1) + 16 * (k >> 1))));
            const __m512i found = _mm512_permutex2var_epi16(rows.first, sample, rows.last);
            out[k] = four ? _mm512_mask_mov_epi16(
                                out[k],
                                _mm512_cmpge_epi16_mask(sample,
                                                        _mm512_set1_epi16((int16_t)(64 * four))),
                                found)
                          : found;
        }
    }
    return (around_int16){out[0], out[1], out[2], out[3]};
}

/* Few rows: the most that may be needed, so that the number of iterations is predictable. */
CVOL_INLINE around_int16 take_around(const image_order_place *at, ptrdiff_t stride, int most,
                                     int wide, ptrdiff_t other)
{
    switch (most) {
    case 3:
        return take_rows(at, stride, 3, wide, other);
    case 4:
        return take_rows(at, stride, 4, wide, other);
    case 5:
        return take_rows(at, stride, 5, wide, other);
    case 6:
        return take_rows(at, stride, 6, wide, other);
    case 7:
        return take_rows(at, stride, 7, wide, other);
    case 8:
        return take_rows(at, stride, 8, wide, other);
    default:
        return take_rows(at, stride, at->last_row + 2, wide, other);
    }
}

/* The same one by one, for the first `count` pixels: if rows are many, or samples far apart. */
CVOL_COLD around_int16 gather_around(const image_order_place *at, ptrdiff_t stride, int count,
                                     ptrdiff_t other)
{
    int16_t lane[PAIR_LANES], row[PAIR_LANES], out[4][PAIR_LANES] = {{0}};
    _mm512_storeu_si512(lane, at->lane);
    _mm512_storeu_si512(row, at->row);
    for (int i = 0; i < count; i++) {
        const int16_t *from = at->from + row[i] * stride + lane[i];
        for (int k = 0; k < 4; k++, from += k & 1 ? 1 : stride - 1)
            out[k][i] = (int16_t)((from[0] + from[other] + 1) / 2);
    }
    return (around_int16){cvol_load_32_int16(out[0]), cvol_load_32_int16(out[1]),
                          cvol_load_32_int16(out[2]), cvol_load_32_int16(out[3])};
}

/* With more rows, pixels are processed one by one. */
#define ROWS_MAX 16

/* Bilinear interpolation. */
CVOL_INLINE __m512i weigh_around(const around_int16 *four, const image_order_place *at)
{
    const __m512i near = _mm512_add_epi16(
                      four->near_left,
                      _mm512_mulhrs_epi16(_mm512_sub_epi16(four->near_right, four->near_left),
                                          at->right)),
                  far = _mm512_add_epi16(
                      four->far_left,
                      _mm512_mulhrs_epi16(_mm512_sub_epi16(four->far_right, four->far_left),
                                          at->right));
    return _mm512_add_epi16(near, _mm512_mulhrs_epi16(_mm512_sub_epi16(far, near), at->below));
}

/* `count`: as in place_int16; `other`: 0, or as in load_row. */
CVOL_INLINE around_int16 find_around(const int16_job *c, const image_order_place *at, int count,
                                     ptrdiff_t other)
{
    const ptrdiff_t stride = c->job->layer->row_stride;
    const int rows = c->rows[count == PAIR_LANES];
    if (c->lanes_at_once == CVOL_GROUP && rows <= 12)
        return rows <= 4   ? take_fours(at, stride, 1, other)
               : rows <= 8 ? take_fours(at, stride, 2, other)
                           : take_fours(at, stride, 3, other);
    return c->lanes_at_once == 0 || rows > ROWS_MAX ? gather_around(at, stride, count, other)
           : c->lanes_at_once <= PAIR_LANES         ? take_around(at, stride, rows, 0, other)
                                                    : take_around(at, stride, rows, 1, other);
}

/* Samples of the 32 pixels from a group on, for the groups with bits in `halves`. */
CVOL_INLINE __m512i reconstruct_image_order_int16(const int16_job *c, int s, int group,
                                                  int midpoints)
{
    const sheet_line *sheet = &c->job->sheets[s];
    const int count = midpoints == 3 ? PAIR_LANES : CVOL_GROUP, only_second = midpoints == 2;
    const image_order_place at = place_int16(c, sheet, group + only_second, count);
    const around_int16 four = find_around(c, &at, count, 0);
    __m512i values = weigh_around(&four, &at);
    const uint32_t *mixed = &c->job->mixed[group - c->job->first_group];
    const uint32_t first = midpoints & 1 ? mixed[0] >> s & 1 : 0,
                   second = midpoints & 2 ? mixed[1] >> s & 1 : 0;
    if (first | second)
        values = put_level_int16(values, c, sheet, &at,
                                 only_second ? 0xffff : first * 0xffff | second * 0xffff0000);
    if (only_second)
        values = _mm512_shuffle_i64x2(values, values, 0x44);
    return values;
}

#endif
