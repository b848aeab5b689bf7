/* Samples of 16 bits, and how they rise, at a group's pixels along lines that cross rows at a slant
 * (sheet_slant.h), with AVX-512: the rows that the pixels lie in are loaded one after the other,
 * and each pixel takes its samples when its own are there: those of its near row in the lower 16
 * words of a register, of the far row in the upper.
 *
 * To be included by kernel files only, behind sheet_line.h.
 */
#ifndef CVOL_RENDER_SHEET_SLANT_SHADE_WORDS_H
#define CVOL_RENDER_SHEET_SLANT_SHADE_WORDS_H

/* Samples of a row that are loaded at once. */
#define ROW_SAMPLES 32

/* Where the pixels of a group lie. */
typedef struct group_place {
    const int16_t *from; /* the sample before the first pixel's, in the row before that */
    long stride;
    int first, last;      /* rows from there on that lie before pixels, */
    int least, most;      /* and all that are there */
    int x, y;             /* that sample */
    int wide;             /* pixels reach further than 32 samples */
    __m512i lane;         /* in words, twice: how far from there a pixel's sample lies */
    __m512i inner, outer; /* rows near and far, and the two beside these */
    __m512i right_words;  /* times 2^15 */
    __m512 right, below;
} group_place;

/* Words of a row from `line` on, where a mask is set; `wide`: as many more. */
CVOL_INLINE __m512i take_from(__m512i out, __mmask32 own, __m512i lane, __m512i samples,
                              __m512i more, int wide)
{
    if (wide)
        return _mm512_mask_mov_epi16(out, own, _mm512_permutex2var_epi16(samples, lane, more));
    return _mm512_mask_permutexvar_epi16(out, own, lane, samples);
}

CVOL_INLINE group_place place_group(const line_job *job, const sheet_line *sheet, int group)
{
    const cvol_layer *layer = job->layer;
    const double i = (double)group * CVOL_GROUP;
    const double x = sheet->lane_at + i * sheet->lane_step,
                 y = sheet->row_at + i * sheet->row_right;
    const double x0 = floor(x), y0 = floor(y);
    const int steps[2] = {(int)lrint(sheet->lane_step * PLACE_ONE),
                          (int)lrint(sheet->row_right * PLACE_ONE)};
    const int v0 = (int)((y - y0) * PLACE_ONE);
    const __m512i iota = (__m512i)cvol_to_int(cvol_iota());
    const __m512i u = _mm512_add_epi32(_mm512_mullo_epi32(iota, _mm512_set1_epi32(steps[0])),
                                       _mm512_set1_epi32((int)((x - x0) * PLACE_ONE))),
                  v = _mm512_add_epi32(_mm512_mullo_epi32(iota, _mm512_set1_epi32(steps[1])),
                                       _mm512_set1_epi32(v0));
    const __m512i part = _mm512_set1_epi32(0xffff);
    const __m512i right = _mm512_and_si512(u, part), below = _mm512_and_si512(v, part);
    const __m512 unit = _mm512_set1_ps((float)(1 / PLACE_ONE));
    const __m512i row = _mm512_broadcast_i64x4(_mm512_cvtepi32_epi16(_mm512_srai_epi32(v, 16)));
    const __m512i behind = _mm512_inserti64x4(_mm512_setzero_si512(), _mm256_set1_epi16(1), 1);
    const __m512i around = _mm512_inserti64x4(_mm512_set1_epi16(-1), _mm256_set1_epi16(2), 1);
    const int end = (v0 + (CVOL_GROUP - 1) * steps[1]) >> 16;
    return (group_place){
        .from = sheet->origin + (long)y0 * layer->row_stride + (long)x0,
        .stride = layer->row_stride,
        .first = end < 0 ? end : 0,
        .last = end < 0 ? 0 : end,
        .least = layer->from_row - (int)y0,
        .most = layer->to_row - (int)y0,
        .wide = (CVOL_GROUP - 1) * sheet->lane_step + 4 >= ROW_SAMPLES,
        .x = (int)x0,
        .y = (int)y0,
        .lane = _mm512_broadcast_i64x4(_mm512_cvtepi32_epi16(_mm512_srli_epi32(u, 16))),
        .inner = _mm512_add_epi16(row, behind),
        .outer = _mm512_add_epi16(row, around),
        .right_words = _mm512_broadcast_i64x4(_mm512_cvtepi32_epi16(_mm512_srli_epi32(right, 1))),
        .right = _mm512_mul_ps(_mm512_cvtepi32_ps(right), unit),
        .below = _mm512_mul_ps(_mm512_cvtepi32_ps(below), unit),
    };
}

/* The lower or the upper 16 words as floats. */
CVOL_INLINE __m512 floats_of_half(__m512i words, int half)
{
    const __m256i part = half ? _mm512_extracti64x4_epi64(words, 1) : _mm512_castsi512_si256(words);
    return _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(part));
}

CVOL_INLINE __m512 mix_floats(__m512 a, __m512 b, __m512 t)
{
    return _mm512_fmadd_ps(t, _mm512_sub_ps(b, a), a);
}

/* Of words left and right of pixels, near and far. */
CVOL_INLINE cvol_vf mix_words(const group_place *at, __m512i left, __m512i right)
{
    const __m512 near = mix_floats(floats_of_half(left, 0), floats_of_half(right, 0), at->right),
                 far = mix_floats(floats_of_half(left, 1), floats_of_half(right, 1), at->right);
    return (cvol_vf)mix_floats(near, far, at->below);
}

/* Samples left and right of pixels, `offset` behind the sheet's. */
CVOL_INLINE void take_rows(__m512i out[2], const group_place *at, long offset, int wide)
{
    const int first = at->first > at->least ? at->first : at->least,
              last = at->last + 1 < at->most ? at->last + 1 : at->most;
    const __m512i lane = at->lane, next = _mm512_add_epi16(lane, _mm512_set1_epi16(1));
    const int16_t *line = at->from + offset + first * at->stride;
    __m512i left = _mm512_setzero_si512(), right = left;
    for (int row = first; row <= last; row++, line += at->stride) {
        const __m512i samples = _mm512_loadu_si512(line),
                      more = wide ? _mm512_loadu_si512(line + ROW_SAMPLES) : samples;
        const __mmask32 own = _mm512_cmpeq_epi16_mask(at->inner, _mm512_set1_epi16((int16_t)row));
        left = take_from(left, own, lane, samples, more, wide);
        right = take_from(right, own, next, samples, more, wide);
    }
    out[0] = left;
    out[1] = right;
}

CVOL_INLINE void take_words(__m512i out[2], const group_place *at, long offset)
{
    at->wide ? take_rows(out, at, offset, 1) : take_rows(out, at, offset, 0);
}

CVOL_INLINE cvol_vf value_of_group(const group_place *at, long offset)
{
    __m512i two[2];
    take_words(two, at, offset);
    const __m512i rows = _mm512_add_epi16(
        two[0], _mm512_mulhrs_epi16(_mm512_sub_epi16(two[1], two[0]), at->right_words));
    return (cvol_vf)mix_floats(floats_of_half(rows, 0), floats_of_half(rows, 1), at->below);
}

/* Samples around pixels: four beside each other, near and far; and those two before and behind. */
typedef struct around_group {
    __m512i inner[4], outer[2];
} around_group;

CVOL_INLINE around_group take_around(const group_place *at, long offset, int wide)
{
    const int first = at->first > at->least ? at->first - 1 : at->least - 1,
              last = at->last + 1 < at->most ? at->last + 2 : at->most + 1;
    const __m512i one = _mm512_set1_epi16(1), zero = _mm512_setzero_si512();
    __m512i lane[4] = {at->lane};
    for (int k = 1; k < 4; k++)
        lane[k] = _mm512_add_epi16(lane[k - 1], one);
    const int16_t *line = at->from + offset - 1 + first * at->stride;
    around_group out = {{zero, zero, zero, zero}, {zero, zero}};
    for (int row = first; row <= last; row++, line += at->stride) {
        const __m512i samples = _mm512_loadu_si512(line),
                      more = wide ? _mm512_loadu_si512(line + ROW_SAMPLES) : samples,
                      number = _mm512_set1_epi16((int16_t)row);
        const __mmask32 inner = _mm512_cmpeq_epi16_mask(at->inner, number),
                        outer = _mm512_cmpeq_epi16_mask(at->outer, number);
        for (int k = 0; k < 4; k++)
            out.inner[k] = take_from(out.inner[k], inner, lane[k], samples, more, wide);
        for (int k = 0; k < 2; k++)
            out.outer[k] = take_from(out.outer[k], outer, lane[k + 1], samples, more, wide);
    }
    return out;
}

/* How samples rise along lanes and rows. */
CVOL_INLINE void slope_of_group(cvol_vf out[2], const group_place *at, long offset)
{
    const around_group around = at->wide ? take_around(at, offset, 1) : take_around(at, offset, 0);
    const __m512i p0 = around.inner[0], p1 = around.inner[1], p2 = around.inner[2],
                  p3 = around.inner[3], q1 = around.outer[0], q2 = around.outer[1];
    out[0] = mix_words(at, _mm512_sub_epi16(p2, p0), _mm512_sub_epi16(p3, p1));
    /* Far less near of what lies beside: in the upper half the other way round. */
    const __m512i d1 = _mm512_sub_epi16(_mm512_shuffle_i64x2(p1, p1, 0x4e), q1),
                  d2 = _mm512_sub_epi16(_mm512_shuffle_i64x2(p2, p2, 0x4e), q2);
    const __m512 near = mix_floats(floats_of_half(d1, 0), floats_of_half(d2, 0), at->right),
                 far = mix_floats(floats_of_half(d1, 1), floats_of_half(d2, 1), at->right);
    out[1] = (cvol_vf)_mm512_fnmadd_ps(at->below, _mm512_add_ps(near, far), near);
}

/* Which pixels have a window with nothing to be seen in it, and what these hold. */
CVOL_INLINE __mmask16 find_unseen_of_group(__m512 *levels, const cvol_layer *layer,
                                           const cvol_windows *windows, const group_place *at)
{
    const __m512i lane = _mm512_cvtepi16_epi32(_mm512_castsi512_si256(at->lane)),
                  row = _mm512_cvtepi16_epi32(_mm512_castsi512_si256(at->inner));
    return find_unseen(levels, layer, windows, _mm512_add_epi32(lane, _mm512_set1_epi32(at->x)),
                       _mm512_add_epi32(row, _mm512_set1_epi32(at->y)));
}

/* From the sheet before to that behind. */
CVOL_INLINE cvol_vf rise_of_group(const group_place *at, long before, long behind)
{
    __m512i from[2], to[2];
    take_words(from, at, before);
    take_words(to, at, behind);
    return mix_words(at, _mm512_sub_epi16(to[0], from[0]), _mm512_sub_epi16(to[1], from[1]));
}

#endif
