/* Mode composite for int16 samples, with AVX-512: the same as composite.h, for ordinary intervals
 * of two adjacent groups, 32 pixels, in integers.
 *
 * Values are samples in stored form, classified by cvol_int16_table. Transmittances are numbers of
 * 2^-15. The colours and opacity of a layer's slices are summed separately, times 2^(15 + shift),
 * and added to the groups' floats behind the last slice. Groups that begin or end, or are near a
 * face, are drawn by composite.h.
 *
 * Only kernel files include this file, behind composite.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_H

#if defined(__AVX512F__)

/* Two groups. */
#define PAIR 2
#define PAIR_LANES (PAIR * CVOL_GROUP)
/* Transmittance below which nothing is visible, see OPAQUE_BELOW. */
#define INT16_OPAQUE 64

/* The most slices of a run: a group that closes within it does not need the slices behind. */
#define RUN_SHEETS (SHEET_IMAGE_ORDER ? 8 : CVOL_BLOCK_MAX)

#define INT16_ONE 32767

/* The slices under a line, in int16. */
typedef struct int16_job {
    line_job *job;
    const cvol_int16_table *int16;
    int32_t weights[CVOL_BLOCK_MAX]
                   [4]; /* of near, its next sample, far, its next: two times 2^15 */
    __m512i ramp[2];    /* lane steps to pixels 0 .. 31, in 2^-16 */
#if SHEET_IMAGE_ORDER   /* or steps along lanes, and rows, to pixels 0 .. 15 */
    int32_t steps[2];
    int32_t before[2][2], behind[2][2]; /* reach of 16 pixels, or 32, from the first */
    int lanes_at_once; /* samples that contain 32 pixels' of a row: 32, 64, or 0: more */
    int rows[2];       /* the most rows of samples for 16 pixels, and for 32 */
#endif
    float sample_rate, sample_from; /* samples = table coordinates sample_rate + sample_from */
} int16_job;

/* Two groups while they are drawn. */
typedef struct pair_state {
    group_state groups[PAIR];
    uint32_t run[PAIR], apart[PAIR]; /* slices still to be met: in runs, and singly */
    int active[PAIR], closed[PAIR];
} pair_state;

/* Classified samples of 32 pixels. */
typedef struct int16_classified {
    __m512i v[4];
} int16_classified;

/* The result of a run. */
typedef struct int16_pixels {
    __m512i gained[4], start, transmittance; /* transmittances: at its start, and now */
} int16_pixels;

/* ---- values ---------------------------------------------------------------------------------- */

CVOL_INLINE int32_t weight_pair(float weight)
{
    int fixed = (int)(weight * 32768 + 0.5f);
    fixed = fixed > INT16_ONE ? INT16_ONE : fixed;
    return fixed << 16 | fixed;
}

CVOL_INLINE void begin_int16(int16_job *c, line_job *job, int unit)
{
    const cvol_layer *layer = job->layer;
    c->job = job;
    c->int16 = &job->table->int16;
    c->sample_rate = 1 / job->sample_scale;
    c->sample_from = -job->sample_offset / job->sample_scale;
#if SHEET_IMAGE_ORDER
    const cvol_sheet_view *view = &layer->sheets[0];
    const double steps[2] = {view->lane_step, view->row_right},
                 downs[2] = {view->lane_down, view->row_step};
    const __m512i number = (__m512i)cvol_to_int(cvol_iota());
    for (int axis = 0; axis < 2; axis++) {
        const int32_t step = (int32_t)lrint(steps[axis] * PLACE_ONE),
                      down = (int32_t)lrint(downs[axis] * PLACE_ONE);
        c->steps[axis] = step;
        c->ramp[axis] = _mm512_add_epi32(
            _mm512_mullo_epi32(_mm512_and_si512(number, _mm512_set1_epi32(CVOL_SQUARE - 1)),
                               _mm512_set1_epi32(step)),
            _mm512_mullo_epi32(_mm512_srli_epi32(number, CVOL_SQUARE_LOG2),
                               _mm512_set1_epi32(down)));
        for (int pair = 0; pair < 2; pair++) {
            const int across = GROUP_ACROSS * (pair + 1);
            c->before[axis][pair] = (int32_t)(least_reach(step, across) +
                                              least_reach(down, GROUP_DOWN));
            c->behind[axis][pair] = (int32_t)(most_reach(step, across) +
                                              most_reach(down, GROUP_DOWN));
        }
    }
    const int reach = ((c->behind[0][1] - c->before[0][1]) >> 16) + 3;
    c->lanes_at_once = reach <= CVOL_GROUP      ? CVOL_GROUP
                       : reach < PAIR_LANES     ? PAIR_LANES
                       : reach < 2 * PAIR_LANES ? 2 * PAIR_LANES
                                                : 0;
    for (int pair = 0; pair < 2; pair++) /* one more if they begin late in a row */
        c->rows[pair] = ((c->behind[1][pair] - c->before[1][pair]) >> 16) + 3;
    (void)unit;
#else
    for (int s = 0; s < layer->sheet_count; s++) {
        const line_view *view = &job->sheets[s].view;
        const double at = job->sheets[s].lane_at;
        const float right = unit ? (float)(at - floor(at)) : 0, left = 1 - right;
        c->weights[s][0] = weight_pair(view->near_weight * left);
        c->weights[s][1] = weight_pair(view->near_weight * right);
        c->weights[s][2] = weight_pair(view->far_weight * left);
        c->weights[s][3] = weight_pair(view->far_weight * right);
    }
    if (!unit && layer->sheet_count) {
        const __m512 step = _mm512_set1_ps((float)layer->sheets[0].lane_step);
        for (int half = 0; half < 2; half++) {
            const __m512 i = _mm512_add_ps((__m512)cvol_iota(),
                                           _mm512_set1_ps((float)(half * CVOL_GROUP)));
            c->ramp[half] = _mm512_cvtps_epi32(
                _mm512_mul_ps(_mm512_mul_ps(i, step), _mm512_set1_ps(65536)));
        }
    }
#endif
}

CVOL_INLINE __m512i weigh_rows(const int16_t *near, const int16_t *far, __m512i near_weight,
                               __m512i far_weight)
{
    return _mm512_add_epi16(_mm512_mulhrs_epi16(cvol_load_32_int16(near), near_weight),
                            _mm512_mulhrs_epi16(cvol_load_32_int16(far), far_weight));
}

/* Samples of 32 pixels from a group on. */
CVOL_INLINE __m512i reconstruct_int16(const int16_job *c, int s, int group, int unit)
{
    const sheet_line *sheet = &c->job->sheets[s];
    const int32_t *w = c->weights[s];
    const __m512i near_left = _mm512_set1_epi32(w[0]), far_left = _mm512_set1_epi32(w[2]);
    if (unit) {
        const ptrdiff_t i = (ptrdiff_t)group * CVOL_GROUP;
        const __m512i near_right = _mm512_set1_epi32(w[1]), far_right = _mm512_set1_epi32(w[3]);
        return _mm512_add_epi16(
            weigh_rows(sheet->near + i, sheet->far + i, near_left, far_left),
            weigh_rows(sheet->near + i + 1, sheet->far + i + 1, near_right, far_right));
    }
    const __m512i odd = _mm512_set_epi16(63, 61, 59, 57, 55, 53, 51, 49, 47, 45, 43, 41, 39, 37, 35,
                                         33, 31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3,
                                         1);
    const double position = sheet->lane_at + (double)(group * CVOL_GROUP) * sheet->lane_step;
    const double whole = floor(position);
    const int16_t *near = sheet->near + (ptrdiff_t)whole, *far = sheet->far + (ptrdiff_t)whole;
    const __m512i low = weigh_rows(near, far, near_left, far_left),
                  high = weigh_rows(near + PAIR_LANES, far + PAIR_LANES, near_left, far_left);
    const __m512i from = _mm512_set1_epi32((int32_t)((position - whole) * 65536));
    const __m512i at[2] = {_mm512_add_epi32(c->ramp[0], from), _mm512_add_epi32(c->ramp[1], from)};
    const __m512i index = _mm512_permutex2var_epi16(at[0], odd, at[1]);
    const __m512i even = _mm512_sub_epi16(odd, _mm512_set1_epi16(1));
    const __m512i part = _mm512_srli_epi16(_mm512_permutex2var_epi16(at[0], even, at[1]), 1);
    const __m512i left = _mm512_permutex2var_epi16(low, index, high);
    const __m512i right = _mm512_permutex2var_epi16(
        low, _mm512_add_epi16(index, _mm512_set1_epi16(1)), high);
    return _mm512_add_epi16(left, _mm512_mulhrs_epi16(_mm512_sub_epi16(right, left), part));
}

/* 32 int16 from two vectors of floats, each at least 0, at most 32767. */
CVOL_INLINE __m512i int16_of(__m512 low, __m512 high)
{
    const __m256i a = _mm512_cvtsepi32_epi16(_mm512_cvtps_epi32(low)),
                  b = _mm512_cvtsepi32_epi16(_mm512_cvtps_epi32(high));
    const __m512i words = _mm512_inserti64x4(_mm512_castsi256_si512(a), b, 1);
    return _mm512_max_epi16(words, _mm512_setzero_si512());
}

/* Converts 16 of them to floats. */
CVOL_INLINE cvol_vf floats_of(__m512i words, int half)
{
    const __m256i part = half ? _mm512_extracti64x4_epi64(words, 1) : _mm512_castsi512_si256(words);
    return (cvol_vf)_mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(part));
}

#if SHEET_IMAGE_ORDER
#include "render/sheet/kernels/image_order/int16_rows.h"

#include "render/sheet/kernels/image_order/midpoint_int16.h"
#endif

#include "render/sheet/kernels/composite/int16_interval.h"

/* ---- runs ------------------------------------------------------------------------------------ */

/* The `count` slices from s on, for the groups with bits in `halves`: known intervals, whole, whose
 * samples all have a value. Opaque pixels are not drawn, independently of the others of their
 * group. */
CVOL_INLINE void draw_int16(pair_state *state, const int16_job *c, int s, int count, int group,
                            int midpoints, int unit)
{
    const cvol_int16_table *w = c->int16;
    const __mmask32 mask = (midpoints & 1 ? 0xffffu : 0) | (midpoints & 2 ? 0xffff0000u : 0);
    const __m512i visible_from = _mm512_set1_epi16(w->visible_from),
                  visible_to = _mm512_set1_epi16(w->visible_to);
    group_state *g = state->groups;
    __m512i values[CVOL_BLOCK_MAX + 1];
    uint64_t live = 0;
    __mmask32 sees[CVOL_BLOCK_MAX];
    const __m512i start = int16_of((__m512)(g[0].p[0].transmittance * 32768),
                                   (__m512)(g[1].p[0].transmittance * 32768));
    const __mmask32 open = mask & find_open(start);
    values[0] = int16_of((__m512)(g[0].value[0] * c->sample_rate + c->sample_from),
                         (__m512)(g[1].value[0] * c->sample_rate + c->sample_from));
    for (int i = 0; i < count; i++) {
#if SHEET_IMAGE_ORDER
        const __m512i from = values[i],
                      to = reconstruct_image_order_int16(c, s + i, group, midpoints);
        (void)unit;
#else
        const __m512i from = values[i], to = reconstruct_int16(c, s + i, group, unit);
#endif
        const __mmask32 above = _mm512_mask_cmpge_epi16_mask(open, _mm512_max_epi16(from, to),
                                                             visible_from);
        const __mmask32 seen = _mm512_mask_cmple_epi16_mask(above, _mm512_min_epi16(from, to),
                                                            visible_to);
        values[i + 1] = to;
        sees[i] = seen;
        live |= (uint64_t)(seen != 0) << i;
    }
    for (int half = 0; half < PAIR; half++)
        if (midpoints >> half & 1)
            g[half].value[0] = sample_to_table(c->job, floats_of(values[count], half));
    if (!live)
        return;
    int16_pixels p;
    for (int k = 0; k < 4; k++)
        p.gained[k] = _mm512_setzero_si512();
    p.start = p.transmittance = _mm512_maskz_mov_epi16(mask, start);
    const int16_run run = {c, s, group, midpoints};
    draw_intervals(&p, &run, values, sees, live);
    const float unit_of = 1.0f / (float)(32768 << w->shift);
    for (int half = 0; half < PAIR; half++) {
        if (!(midpoints >> half & 1))
            continue;
        pixels *to = &g[half].p[0];
        to->r += unit_of * floats_of(p.gained[0], half);
        to->g += unit_of * floats_of(p.gained[1], half);
        to->b += unit_of * floats_of(p.gained[2], half);
        to->transmittance = cvol_max(to->transmittance - unit_of * floats_of(p.gained[3], half),
                                     (cvol_vf){0});
        state->closed[half] = !is_open(p.transmittance, half);
    }
}

#include "render/sheet/kernels/composite/int16_intersected.h"

/* ---- groups ---------------------------------------------------------------------------------- */

/* Finds the slices that the two groups have to meet. */
CVOL_INLINE void begin_pair(pair_state *state, const line_job *job, int group, int end)
{
    const cvol_line *line = job->line;
    const int first_ordinal = job->layer->sheets[0].ordinal;
    for (int half = 0; half < PAIR; half++) {
        const int g = group + half, at = g - job->first_group;
        state->active[half] = state->closed[half] = 0;
        state->run[half] = state->apart[half] = 0;
        if (g >= end || line->opaque[g])
            continue;
        const uint32_t intersected = job->intersected[at], seen = job->seen[at];
        const uint32_t known = line->intersected[g] == first_ordinal - 1,
                       before = seen << 1 | known;
        state->run[half] = seen & job->inside[at] & before;
        state->apart[half] = (seen & ~state->run[half]) | (intersected & ~seen & before);
        state->active[half] = (state->run[half] | state->apart[half]) != 0;
    }
}

/* The number of slices from s on that both, or one, of the groups meet in a run; *halves: which. */
CVOL_INLINE int find_run(int *midpoints, const pair_state *state, int s)
{
    const uint64_t a = state->run[0] >> s, b = state->run[1] >> s;
    const int both = a & b & 1;
    *midpoints = (int)(a & 1) | (int)(b & 1) << 1;
    return __builtin_ctzll(~(both ? a & b : a & 1 ? a & ~b : b & ~a));
}

CVOL_INLINE void draw_pair(const int16_job *c, int group, int end, int unit, int segments)
{
    const line_job *job = c->job;
    const cvol_line *line = job->line;
    pair_state state;
    begin_pair(&state, job, group, end);
    if (!state.active[0] && !state.active[1])
        return;
    int known[PAIR];
    uint32_t seen[PAIR];
    for (int half = 0; half < PAIR; half++) {
        /* A group beyond the end is loaded like its neighbour, and ignored. */
        load_group(&state.groups[half], job, group + half < end ? group + half : group, 0, 0);
        known[half] = state.active[half] &&
                      line->intersected[group + half] == job->layer->sheets[0].ordinal - 1;
        seen[half] = state.active[half] ? job->seen[group + half - job->first_group] : 0;
    }
    uint32_t left;
    while ((left = state.run[0] | state.apart[0] | state.run[1] | state.apart[1]) != 0) {
        const int s = __builtin_ctz(left);
        int midpoints;
        for (int half = 0; half < PAIR; half++)
            if (state.apart[half] >> s & 1) {
                const uint32_t before = seen[half] << 1 | (uint32_t)known[half];
                state.apart[half] &= state.apart[half] - 1;
                draw_sheet(&state.groups[half], job, s, group + half, before >> s & 1, unit, 0,
                           segments);
                state.closed[half] = is_closed(&state.groups[half]);
            }
        const int all = find_run(&midpoints, &state, s),
                  count = all < RUN_SHEETS ? all : RUN_SHEETS;
        if (midpoints) {
            const uint32_t done = (uint32_t)(((UINT64_C(1) << count) - 1) << s);
            draw_int16(&state, c, s, count, group, midpoints, unit);
            for (int half = 0; half < PAIR; half++)
                if (midpoints >> half & 1)
                    state.run[half] &= ~done;
        }
        for (int half = 0; half < PAIR; half++)
            if (state.closed[half])
                state.run[half] = state.apart[half] = 0;
    }
#if SHEET_IMAGE_ORDER
    const int last = job->layer->sheet_count - 1;
    for (int half = 0; half < PAIR; half++)
        if (state.active[half] && !state.closed[half] && seen[half] >> last)
            keep_midpoint_int16(c, group, 1 << half);
#endif
    for (int half = 0; half < PAIR; half++) {
        if (!state.active[half])
            continue;
        const int g = group + half;
        store_group(&state.groups[half], line, g, 0);
        if (seen[half])
            line->intersected[g] = job->layer->sheets[0].ordinal + 31 - __builtin_clz(seen[half]);
        line->opaque[g] = (uint8_t)state.closed[half];
    }
}

CVOL_INLINE void draw_int16_line(line_job *job, int unit, int segments)
{
    const cvol_layer *layer = job->layer;
    int begin = job->line->width / CVOL_GROUP, end = 0;
#if SHEET_IMAGE_ORDER
    view_image_order(job);
#endif
    for (int s = 0; s < layer->sheet_count; s++) {
#if !SHEET_IMAGE_ORDER
        view_sheet(&job->sheets[s], job, &layer->sheets[s], unit);
#endif
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
    if (begin >= end)
        return;
    int16_job c;
    begin_int16(&c, job, unit);
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
#if SHEET_IMAGE_ORDER
        find_intersected_image_order(job, first, count);
#else
        find_intersected_int16(job, first, count, unit);
#endif
        for (int group = first; group < first + count; group += PAIR) {
            const int ahead = group + 2 * PAIR;
            for (int k = ahead; k < ahead + PAIR && k < first + count; k++)
                if (job->seen[k - first] && !job->line->opaque[k])
                    prefetch_group(job->line, k);
            draw_pair(&c, group, first + count, unit, segments);
        }
    }
}

#endif
#endif
