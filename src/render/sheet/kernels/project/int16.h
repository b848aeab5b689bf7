/* Maxima and minima from int16 samples, if pixels and samples are equally far apart: 32 pixels
 * together in integers. With weights of 2^-14, which sum to 1 exactly, of two adjacent samples, a
 * pixel is one multiply-add of pairs: even pixels from one place on, odd ones from the next.
 *
 * Groups at faces are drawn as in extreme.h.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_PROJECT_INT16_H
#define CVOL_RENDER_SHEET_KERNELS_PROJECT_INT16_H

#include "render/sheet/kernels/project/extreme.h"

#if defined(__AVX512F__)

#define WEIGHT_ONE 16384

/* For two adjacent groups: even pixels and odd ones, times WEIGHT_ONE. */
typedef struct extreme_pair {
    __m512i even, odd;
} extreme_pair;

/* The weights of a row's sample and of the next one. */
typedef struct pair_weights {
    __m512i near, far;
} pair_weights;

CVOL_INLINE __m512i both_weights(int left, int right)
{
    return _mm512_set1_epi32((int32_t)((uint32_t)right << 16 | (uint32_t)left));
}

CVOL_INLINE pair_weights find_pair_weights(const unit_footprint *footprint)
{
    const int near_left = (int)(footprint->near_left * WEIGHT_ONE + 0.5f),
              far_left = (int)(footprint->far_left * WEIGHT_ONE + 0.5f),
              far_right = (int)(footprint->far_right * WEIGHT_ONE + 0.5f);
    int near_right = WEIGHT_ONE - near_left - far_left - far_right, last = far_right;
    if (near_right < 0) { /* by the excess from rounding the others up */
        last += near_right;
        near_right = 0;
    }
    return (pair_weights){both_weights(near_left, near_right), both_weights(far_left, last)};
}

CVOL_INLINE __m512i widen_int16(__m512i held, __mmask16 lanes, __m512i by, int largest)
{
    return largest ? _mm512_mask_max_epi32(held, lanes, held, by)
                   : _mm512_mask_min_epi32(held, lanes, held, by);
}

CVOL_INLINE void widen_pair(extreme_pair *pair, __mmask16 lanes, const extreme_sheet *of,
                            const pair_weights *weights, int i, int largest)
{
    const int16_t *near = of->view.near + of->footprint.x + i,
                  *far = of->view.far + of->footprint.x + i;
    const __m512i even = _mm512_add_epi32(
                      _mm512_madd_epi16(cvol_load_32_int16(near), weights->near),
                      _mm512_madd_epi16(cvol_load_32_int16(far), weights->far)),
                  odd = _mm512_add_epi32(
                      _mm512_madd_epi16(cvol_load_32_int16(near + 1), weights->near),
                      _mm512_madd_epi16(cvol_load_32_int16(far + 1), weights->far));
    pair->even = widen_int16(pair->even, lanes, even, largest);
    pair->odd = widen_int16(pair->odd, lanes, odd, largest);
}

/* A value that any other exceeds. */
CVOL_INLINE __m512i extreme_identity(int largest)
{
    return _mm512_set1_epi32(largest ? INT32_MIN : INT32_MAX);
}

/* The values of the lines. */
CVOL_INLINE __m512i load_held(const cvol_line *line, int i, int largest)
{
    const __m512 value = _mm512_loadu_ps(line->values + i),
                 count = _mm512_loadu_ps(line->values + line->width + i);
    const __mmask16 holds = _mm512_cmp_ps_mask(count, _mm512_setzero_ps(), _CMP_GT_OQ);
    return _mm512_mask_cvtps_epi32(extreme_identity(largest), holds,
                                   _mm512_mul_ps(value, _mm512_set1_ps(WEIGHT_ONE)));
}

CVOL_INLINE extreme_pair load_pair(const cvol_line *line, int i, int largest)
{
    const __m512i low = load_held(line, i, largest),
                  high = load_held(line, i + CVOL_GROUP, largest);
    const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2,
                                          0),
                  odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
    return (extreme_pair){_mm512_permutex2var_epi32(low, even, high),
                          _mm512_permutex2var_epi32(low, odd, high)};
}

CVOL_INLINE void store_held(const cvol_line *line, int i, __m512i value, int largest)
{
    const __mmask16 holds = _mm512_cmpneq_epi32_mask(value, extreme_identity(largest));
    const __m512 one = _mm512_set1_ps(1), unit = _mm512_set1_ps(1.0f / WEIGHT_ONE);
    _mm512_storeu_ps(line->values + i, _mm512_maskz_mul_ps(holds, _mm512_cvtepi32_ps(value), unit));
    _mm512_storeu_ps(line->values + line->width + i, _mm512_maskz_mov_ps(holds, one));
}

CVOL_INLINE void store_pair(const cvol_line *line, int i, const extreme_pair *pair, int largest)
{
    const __m512i low = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0),
                  high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    store_held(line, i, _mm512_permutex2var_epi32(pair->even, low, pair->odd), largest);
    store_held(line, i + CVOL_GROUP, _mm512_permutex2var_epi32(pair->even, high, pair->odd),
               largest);
}

CVOL_INLINE __mmask16 find_beyond(__m512i most, __m512i held, int largest)
{
    return largest ? _mm512_cmpgt_epi32_mask(most, held) : _mm512_cmplt_epi32_mask(most, held);
}

/* The most that a window contains; if its level is not an integer, less than one unit is lost. */
CVOL_INLINE __m512i most_int16(float level)
{
    return _mm512_set1_epi32((int32_t)(level * WEIGHT_ONE));
}

/* The lanes of a pair's windows that must be examined; none if no window exceeds the values of all
 * its pixels. The first window belongs to half of the lanes. */
CVOL_INLINE __mmask16 find_lanes(const cvol_layer *layer, const line_view *view, ptrdiff_t window,
                                 const extreme_pair *pair, int largest)
{
    const uint8_t *bits = view->windows + window;
    const float *level = view->levels + window;
    const __mmask16 seen = (__mmask16)((bits[0] & CVOL_WINDOW_SEEN ? 0x00ff : 0) |
                                       (bits[1] & CVOL_WINDOW_SEEN ? 0xff00 : 0));
    if (!seen || !layer->bounded)
        return seen;
    const __m512i most = _mm512_mask_blend_epi32(0xff00, most_int16(level[0]),
                                                 most_int16(level[1]));
    const __mmask16 beyond = find_beyond(most, pair->even, largest) |
                             find_beyond(most, pair->odd, largest);
    return beyond & seen ? seen : 0;
}

/* Groups g and g + 1, which lie within the drawn part on all slices. */
CVOL_INLINE void draw_pair(const extreme_job *job, const pair_weights *weights, int g, int largest)
{
    const int i = g * CVOL_GROUP;
    extreme_pair pair = load_pair(job->line, i, largest);
    int changed = 0;
    for (int s = 0; s < job->count; s++) {
        const extreme_sheet *of = &job->sheets[s];
        const __mmask16 lanes = find_lanes(job->layer, &of->view, window_of(of->footprint.x + i),
                                           &pair, largest);
        if (!lanes)
            continue;
        widen_pair(&pair, lanes, of, &weights[s], i, largest);
        changed = 1;
    }
    if (changed)
        store_pair(job->line, i, &pair, largest);
}

#endif

CVOL_INLINE void draw_int16_extremes(const cvol_layer *layer, const cvol_line *line, int largest)
{
    extreme_job job;
    begin_extremes(&job, layer, line);
    int g = job.begin;
#if defined(__AVX512F__)
    pair_weights weights[CVOL_BLOCK_MAX];
    for (int s = 0; s < job.count; s++)
        weights[s] = find_pair_weights(&job.sheets[s].footprint);
    for (; g < job.inside_begin && g < job.end; g++)
        draw_extreme_group(&job, g, 1, largest);
    for (; g + 1 < job.inside_end; g += 2)
        draw_pair(&job, weights, g, largest);
#endif
    for (; g < job.end; g++)
        draw_extreme_group(&job, g, 1, largest);
}

#endif
