/* The slices of a layer under a line of the picture itself (image-order plans, plan_image_order.c):
 * the counterpart of line.h if lines cross rows of samples, so that every pixel has its own rows
 * and weights.
 *
 * A line has CVOL_SQUARE lines of the picture, and a group is a square of these. With 16 pixels in
 * one row, the first would meet a surface well before the last, and all slices between would be
 * examined for all of them. A group meets several windows of a slice; it sees something if one of
 * them is visible.
 *
 * Only line.h includes this file, for kernel files. */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_LINE_SLANTED_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_LINE_SLANTED_H

/* Fixed-point places have 16 bits behind the point. */
#define PLACE_ONE 65536.0

/* ---- extents of lines ------------------------------------------------------------------------ */

/* Slices of a layer, and two before and one behind. */
#define SHEETS_AROUND (CVOL_BLOCK_MAX + 3)

/* The columns between which rays are within the drawn part, for one axis, slice by slice: for some
 * of a group's lines, and for all. */
typedef struct pixels_within {
    double begin[SHEETS_AROUND], end[SHEETS_AROUND];
    double inner_begin[SHEETS_AROUND], inner_end[SHEETS_AROUND];
} pixels_within;

/* For `count` slices, crossed at `at`, moving by `rate` per slice; `step` from column to column,
 * `down` from line to line. */
CVOL_INLINE void find_pixels_within(pixels_within *out, int count, double at, double rate,
                                    double step, double down, double lo, double hi)
{
    const double least = 1e-9; /* lines along rows have a long extent, one way or the other */
    const double inverse = 1 / (fabs(step) > least ? step : step < 0 ? -least : least);
    const double before = least_reach(down, GROUP_DOWN), behind = most_reach(down, GROUP_DOWN);
    const double some[2] = {lo - behind, hi - before}, all[2] = {lo - before, hi - behind};
    const int falls = inverse < 0;
    for (int s = 0; s < count; s++) {
        const double place = at + s * rate;
        out->begin[s] = (some[falls] - place) * inverse;
        out->end[s] = (some[!falls] - place) * inverse;
        out->inner_begin[s] = (all[falls] - place) * inverse;
        out->inner_end[s] = (all[!falls] - place) * inverse;
    }
}

/* Groups as in cvol_sheet_view, slice by slice. */
typedef struct group_ranges {
    int begin[CVOL_BLOCK_MAX], end[CVOL_BLOCK_MAX], inside_begin[CVOL_BLOCK_MAX],
        inside_end[CVOL_BLOCK_MAX];
} group_ranges;

#if defined(__AVX512F__)

CVOL_INLINE void store_groups(int *to, __mmask8 which, __m512d group, int groups)
{
    const __m512d zero = _mm512_setzero_pd(), most = _mm512_set1_pd(groups);
    const __m256i number = _mm512_cvttpd_epi32(_mm512_min_pd(_mm512_max_pd(group, zero), most));
    _mm256_storeu_si256((__m256i *)to, _mm256_maskz_mov_epi32(which, number));
}

#endif

/* For `count` slices from number 2 of `within` on: groups that may be inside somewhere from the
 * slice before to that behind, and groups that are inside on all from two before on. */
CVOL_INLINE void find_group_ranges(group_ranges *out, const pixels_within within[2], int count,
                                   int groups)
{
    const double inverse = 1.0 / GROUP_ACROSS;
#if defined(__AVX512F__)
    enum { /* constants without optimisation, too */
           up = _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC,
           down = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC
    };
    const __m512d one = _mm512_set1_pd(1), share = _mm512_set1_pd(inverse);
    for (int s = 0; s < count; s += 8) {
        __m512d most[2], least[2];
        for (int axis = 0; axis < 2; axis++) {
            /* Linear from slice to slice. */
            const double *begin = within[axis].begin + s, *end = within[axis].end + s,
                         *from = within[axis].inner_begin + s, *to = within[axis].inner_end + s;
            const __m512d first = _mm512_min_pd(_mm512_loadu_pd(begin + 1),
                                                _mm512_loadu_pd(begin + 3)),
                          last = _mm512_max_pd(_mm512_loadu_pd(end + 1), _mm512_loadu_pd(end + 3)),
                          inside = _mm512_max_pd(_mm512_loadu_pd(from), _mm512_loadu_pd(from + 2)),
                          until = _mm512_min_pd(_mm512_loadu_pd(to), _mm512_loadu_pd(to + 2));
            most[0] = axis ? _mm512_max_pd(most[0], first) : first;
            most[1] = axis ? _mm512_min_pd(most[1], last) : last;
            least[0] = axis ? _mm512_max_pd(least[0], inside) : inside;
            least[1] = axis ? _mm512_min_pd(least[1], until) : until;
        }
        const __mmask8 there = _mm512_cmp_pd_mask(most[0], most[1], _CMP_LE_OQ);
        const __m512d last = _mm512_roundscale_pd(most[1], down),
                      until = _mm512_add_pd(_mm512_roundscale_pd(least[1], down), one);
        store_groups(out->begin + s, there, _mm512_mul_pd(_mm512_roundscale_pd(most[0], up), share),
                     groups);
        store_groups(out->end + s, there,
                     _mm512_add_pd(_mm512_roundscale_pd(_mm512_mul_pd(last, share), down), one),
                     groups);
        store_groups(out->inside_begin + s, there,
                     _mm512_roundscale_pd(_mm512_mul_pd(least[0], share), up), groups);
        store_groups(out->inside_end + s, there, _mm512_mul_pd(until, share), groups);
    }
#else
    for (int s = 0; s < count; s++) {
        double most[2] = {-INFINITY, INFINITY}, least[2] = {-INFINITY, INFINITY};
        for (int axis = 0; axis < 2; axis++) {
            const double *begin = within[axis].begin + s, *end = within[axis].end + s,
                         *from = within[axis].inner_begin + s, *to = within[axis].inner_end + s;
            const double first = begin[1] < begin[3] ? begin[1] : begin[3],
                         last = end[1] > end[3] ? end[1] : end[3],
                         inside = from[0] > from[2] ? from[0] : from[2],
                         until = to[0] < to[2] ? to[0] : to[2];
            most[0] = most[0] > first ? most[0] : first;
            most[1] = most[1] < last ? most[1] : last;
            least[0] = least[0] > inside ? least[0] : inside;
            least[1] = least[1] < until ? least[1] : until;
        }
        const int there = most[0] <= most[1] ? groups : 0;
        out->begin[s] = clamp_to_groups(ceil(most[0]) * inverse, there);
        out->end[s] = clamp_to_groups(floor(floor(most[1]) * inverse) + 1, there);
        out->inside_begin[s] = clamp_to_groups(ceil(least[0] * inverse), there);
        out->inside_end[s] = clamp_to_groups((floor(least[1]) + 1) * inverse, there);
    }
#endif
}

/* All slices of the layer, as seen by the line. */
CVOL_INLINE void view_image_order(line_job *job)
{
    const cvol_layer *layer = job->layer;
    const int j = job->line->number, groups = job->line->width / CVOL_GROUP;
    const int count = layer->sheet_count;
    if (!count)
        return;
    const cvol_sheet_view *near = &layer->sheets[0];
    pixels_within within[2];
    find_pixels_within(
        &within[0], count + 3, near->lane_at + j * near->lane_down - 2 * near->lane_rate[0],
        near->lane_rate[0], near->lane_step, near->lane_down, layer->lane_lo, layer->lane_hi);
    find_pixels_within(&within[1], count + 3,
                       near->row_at + j * near->row_step - 2 * near->row_rate[0], near->row_rate[0],
                       near->row_right, near->row_step, layer->row_lo, layer->row_hi);
    group_ranges ranges;
    find_group_ranges(&ranges, within, count, groups);
    for (int s = 0; s < count; s++) {
        const cvol_sheet_view *sheet = &layer->sheets[s];
        sheet_line *out = &job->sheets[s];
        out->view.enter = sheet->front;
        out->view.leave = sheet->back;
        out->lane_at = sheet->lane_at + j * sheet->lane_down;
        out->lane_step = sheet->lane_step;
        out->row_at = sheet->row_at + j * sheet->row_step;
        out->row_right = sheet->row_right;
        job->lane_at[s] = (float)out->lane_at;
        job->row_at[s] = (float)out->row_at;
        out->origin = samples_of(sheet) + sheet->first;
        out->number = s;
        out->windows = sheet->is_of_previous_layer ? &layer->windows_before : &layer->windows;
        const float begin = layer->only ? -0.5f : -1, end = layer->only ? 0.5f : 1;
        const int intersected = out->view.enter < end && out->view.leave > begin + MIN_WEIGHT;
        const int whole = !layer->only && out->view.enter < MIN_WEIGHT - 2 &&
                          out->view.leave > -MIN_WEIGHT;
        group_range range = {
            ranges.begin[s], ranges.end[s], ranges.inside_begin[s], ranges.inside_end[s], 0, 0};
        if (!intersected)
            range.end = range.begin;
        if (!whole)
            range.inside_begin = range.inside_end = 0;
        if (layer->cuts && intersected)
            cut_groups(&range, layer, sheet, j, groups);
        set_groups(out, layer, &range);
    }
    /* find_group_windows takes sixteen slices at once. */
    for (int s = count; s % CVOL_GROUP; s++)
        job->lane_at[s] = job->row_at[s] = 0;
}

#include "render/sheet/kernels/image_order/visible_slices.h"

/* ---- invisible windows ----------------------------------------------------------------------- */

/* Returns 1 if all samples of a slice that a group reads exist. */
CVOL_INLINE int is_there_image_order(const line_job *job, const sheet_line *sheet, int group)
{
    group_windows at;
    place_windows(&at, 0, job, (float)sheet->lane_at, (float)sheet->row_at, group);
    return find_all_seen(sheet->windows, at.c0[0], at.c1[0], at.r0[0], at.r1[0]);
}

/* Values in the middle of a group's windows, part by part, pixel by pixel, as table coordinates, at
 * its position `by` slices from slice s. Returns 1 if one of these windows is visible. */
CVOL_INLINE int find_levels(cvol_vf *levels, const line_job *job, int s,
                            const cvol_windows *windows, int group, double by)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const int last = layer->block_rows * layer->row_points - 1;
    const double lane_at = job->sheets[s].lane_at + by * sheet->lane_rate[0],
                 row_at = job->sheets[s].row_at + by * sheet->row_rate[0];
    group_windows at;
    place_windows(&at, 0, job, (float)lane_at, (float)row_at, group);
#if defined(__AVX512F__)
    const double i = group * GROUP_ACROSS, begin = lane_at + i * sheet->lane_step,
                 top = row_at + i * sheet->row_right;
    const __m512i x = find_places(begin, sheet->lane_step, sheet->lane_down),
                  y = clamp_int16(find_places(top, sheet->row_right, sheet->row_step), last);
    const __m512i block = _mm512_cvttps_epi32(
        _mm512_mul_ps(_mm512_add_ps(_mm512_cvtepi32_ps(y), _mm512_set1_ps(0.5f)),
                      _mm512_set1_ps(1 / (float)layer->row_points)));
    const __m512i block_row = _mm512_max_epi32(
                      _mm512_min_epi32(block, _mm512_set1_epi32(windows->last_row)),
                      _mm512_set1_epi32(windows->first_row)),
                  window = _mm512_max_epi32(
                      _mm512_min_epi32(
                          _mm512_srai_epi32(_mm512_add_epi32(x, _mm512_set1_epi32(CVOL_GROUP)), 4),
                          _mm512_set1_epi32(at.c1[0])),
                      _mm512_set1_epi32(at.c0[0]));
    const __m512i of = _mm512_add_epi32(
        _mm512_mullo_epi32(block_row, _mm512_set1_epi32(windows->count)), window);
    levels[0] = (cvol_vf)_mm512_i32gather_ps(of, windows->within_level, 4);
#else
    for (int k = 0; k < CVOL_GROUP; k++) {
        const int i = group * GROUP_ACROSS + k % GROUP_ACROSS, j = k / GROUP_ACROSS;
        const double x = lane_at + i * sheet->lane_step + j * sheet->lane_down,
                     y = row_at + i * sheet->row_right + j * sheet->row_step;
        const uint64_t row = (uint64_t)(y < 0 ? 0 : y > last ? last : floor(y));
        const ptrdiff_t block_row = clamp_row(windows,
                                              (int)(row * layer->row_points_inverse >> 32));
        ptrdiff_t c = window_of((ptrdiff_t)floor(x));
        c = c < at.c0[0] ? at.c0[0] : c > at.c1[0] ? at.c1[0] : c;
        levels[k / CVOL_LANES][k % CVOL_LANES] =
            windows->within_level[c + block_row * windows->count];
    }
#endif
    for (int k = 0; k < PARTS; k++)
        levels[k] = to_table(job, levels[k]);
    return find_seen(windows, at.c0[0], at.c1[0], at.r0[0], at.r1[0]);
}

/* The windows of the slice before. */
CVOL_INLINE const cvol_windows *windows_before(const cvol_layer *layer,
                                               const cvol_sheet_view *sheet)
{
    return sheet->is_first || sheet->is_of_previous_layer ? &layer->windows_before
                                                          : &layer->windows;
}

/* The values at which a group met the slice before slice `s`, which was skipped. Returns 0 if they
 * are unknown. */
CVOL_INLINE int find_levels_before(cvol_vf *levels, const line_job *job, int s, int group)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const cvol_windows *windows = windows_before(layer, sheet);
    if (!windows->count || (sheet->is_first && sheet->is_of_previous_layer))
        return 0;
    return !find_levels(levels, job, s, windows, group, -1);
}

/* ---- values ---------------------------------------------------------------------------------- */

#if defined(__AVX512F__)

/* The same for 16 pixels at (x, y); returns the invisible ones. */
CVOL_INLINE __mmask16 find_unseen(__m512 *levels, const cvol_layer *layer,
                                  const cvol_windows *windows, __m512i x, __m512i y)
{
    const __m512i zero = _mm512_setzero_si512(),
                  last = _mm512_set1_epi32(layer->block_rows * layer->row_points - 1);
    const __m512i column = _mm512_srai_epi32(_mm512_add_epi32(x, _mm512_set1_epi32(CVOL_GROUP)), 4),
                  window = _mm512_max_epi32(
                      _mm512_min_epi32(column, _mm512_set1_epi32(windows->count - 1)), zero);
    const float inverse = 1 / (float)layer->row_points;
    __m512i rows[2];
    for (int k = 0; k < 2; k++) {
        const __m512i row = _mm512_max_epi32(
            _mm512_min_epi32(_mm512_add_epi32(y, _mm512_set1_epi32(k)), last), zero);
        const __m512i block = _mm512_cvttps_epi32(_mm512_mul_ps(
            _mm512_add_ps(_mm512_cvtepi32_ps(row), _mm512_set1_ps(0.5f)), _mm512_set1_ps(inverse)));
        rows[k] = _mm512_max_epi32(_mm512_min_epi32(block, _mm512_set1_epi32(windows->last_row)),
                                   _mm512_set1_epi32(windows->first_row));
    }
    const __mmask16 crosses = _mm512_cmpgt_epi32_mask(rows[1], rows[0]);
    const __m512i first = _mm512_add_epi32(
        _mm512_mullo_epi32(rows[0], _mm512_set1_epi32(windows->count)), window);
    /* `across` lies behind `within`. */
    const __m512i at = _mm512_mask_add_epi32(
        first, crosses, first, _mm512_set1_epi32((int)(windows->across - windows->within)));
    const __m512i bits = _mm512_i32gather_epi32(at, windows->within, 1);
    const __mmask16 unseen = _mm512_testn_epi32_mask(bits, _mm512_set1_epi32(CVOL_WINDOW_SEEN));
    *levels = _mm512_mask_i32gather_ps(_mm512_setzero_ps(), unseen, at, windows->within_level, 4);
    return unseen;
}

/* A level in the format of stored samples. */
CVOL_INLINE __m512 kept_levels(const cvol_layer *layer, __m512 level)
{
#ifdef SHEET_INT16
    const __m512i rounded = _mm512_cvtps_epi32(
        _mm512_add_ps(_mm512_mul_ps(level, _mm512_set1_ps(layer->int16.scale)),
                      _mm512_set1_ps(layer->int16.offset)));
    return _mm512_cvtepi32_ps(_mm512_max_epi32(
        _mm512_min_epi32(rounded, _mm512_set1_epi32(INT16_MAX)), _mm512_setzero_si512()));
#endif
    (void)layer;
    return level;
}

#endif

/* The position of the first of the CVOL_LANES pixels from number i on in a slice, and the steps
 * from column to column and from line to line: along lanes, and rows. */
typedef struct image_order_part {
    double at[2], right[2], down[2];
} image_order_part;

CVOL_INLINE image_order_part place_part(const line_job *job, const sheet_line *sheet, int i)
{
    const cvol_sheet_view *view = &job->layer->sheets[0];
    const int column = column_of(i), line = line_of(i);
    return (image_order_part){{sheet->lane_at + column * sheet->lane_step + line * view->lane_down,
                               sheet->row_at + column * sheet->row_right + line * view->row_step},
                              {sheet->lane_step, sheet->row_right},
                              {view->lane_down, view->row_step}};
}

#if !defined(__AVX512F__)

/* The samples before which CVOL_LANES pixels of a part lie, along lanes (axis 0) or rows (1). */
CVOL_INLINE cvol_vi find_places(const image_order_part *part, int axis)
{
    const double whole = floor(part->at[axis]);
    const cvol_vf from = (float)(part->at[axis] - whole) +
                         spread_pixels((float)part->right[axis], (float)part->down[axis]);
    const float bias = 1024; /* they may lie before the first pixel's */
    return cvol_to_int(from + bias) + ((int)whole - (int)bias);
}

/* Finds the invisible ones among CVOL_LANES pixels, whose samples do not exist, and their levels.
 */
CVOL_INLINE cvol_vi find_unseen(cvol_vf *levels, const cvol_layer *layer,
                                const cvol_windows *windows, cvol_vi x, cvol_vi y)
{
    const int last = layer->block_rows * layer->row_points - 1;
    const cvol_vi window = cvol_clamp_int((x + CVOL_GROUP) >> 4, 0, windows->count - 1);
    cvol_vi rows[2];
    for (int k = 0; k < 2; k++) {
        const cvol_vf middle = cvol_to_float(cvol_clamp_int(y + k, 0, last)) + 0.5f;
        rows[k] = cvol_clamp_int(cvol_to_int(middle * (1 / (float)layer->row_points)),
                                 windows->first_row, windows->last_row);
    }
    /* `across` lies behind `within`. */
    const cvol_vi at = rows[0] * windows->count + window +
                       ((rows[1] > rows[0]) & (int)(windows->across - windows->within));
    cvol_vi bits;
    for (int k = 0; k < CVOL_LANES; k++)
        bits[k] = windows->within[at[k]];
    const cvol_vi unseen = (bits & CVOL_WINDOW_SEEN) == 0;
    *levels = cvol_splat(0);
    for (int k = 0; k < CVOL_LANES && cvol_any(unseen); k++)
        (*levels)[k] = windows->within_level[at[k]];
    return unseen;
}

/* Levels in the format of stored samples. */
CVOL_INLINE cvol_vf kept_levels(const cvol_layer *layer, cvol_vf levels)
{
#ifdef SHEET_INT16
    for (int k = 0; k < CVOL_LANES; k++)
        levels[k] = cvol_int16_scale_of(&layer->int16, levels[k]);
#endif
    (void)layer;
    return levels;
}

#endif

/* Writes levels to the invisible pixels among CVOL_LANES pixels from number i on. */
CVOL_COLD cvol_vf put_levels(cvol_vf value, const line_job *job, const sheet_line *sheet, int i)
{
#if defined(__AVX512F__)
    const image_order_part of = place_part(job, sheet, i);
    __m512 levels;
    const __mmask16 unseen = find_unseen(&levels, job->layer, sheet->windows,
                                         find_places(of.at[0], of.right[0], of.down[0]),
                                         find_places(of.at[1], of.right[1], of.down[1]));
    return (cvol_vf)_mm512_mask_mov_ps((__m512)value, unseen, kept_levels(job->layer, levels));
#else
    const image_order_part of = place_part(job, sheet, i);
    cvol_vf levels;
    const cvol_vi unseen = find_unseen(&levels, job->layer, sheet->windows, find_places(&of, 0),
                                       find_places(&of, 1));
    return cvol_select(unseen, kept_levels(job->layer, levels), value);
#endif
}

#if defined(SHEET_INT16) && !defined(__AVX512F__)
CVOL_INLINE ptrdiff_t clamp_to_range(ptrdiff_t value, ptrdiff_t least, ptrdiff_t most)
{
    value = value < least ? least : value;
    return value > most ? most : value;
}
#endif

/* Samples, in stored form, at CVOL_LANES pixels from pixel i on. Samples beyond the existing ones
 * are don't-care: such pixels are not drawn. */
CVOL_INLINE cvol_vf reconstruct_image_order(const line_job *job, const sheet_line *sheet, int i)
{
    const cvol_layer *layer = job->layer;
    const image_order_part of = place_part(job, sheet, i);
    const double x0 = floor(of.at[0]), y0 = floor(of.at[1]);
    const cvol_vf u = (float)(of.at[0] - x0) + spread_pixels((float)of.right[0], (float)of.down[0]),
                  v = (float)(of.at[1] - y0) + spread_pixels((float)of.right[1], (float)of.down[1]);
    const float bias = 1024; /* samples may lie before the first pixel's */
    const cvol_vi column = cvol_to_int(u + bias) - (int)bias,
                  row = cvol_to_int(v + bias) - (int)bias;
    const cvol_vf right = u - cvol_to_float(column), below = v - cvol_to_float(row);
    const ptrdiff_t stride = layer->row_stride;
    cvol_vf a = {0}, b = {0}, c = {0}, d = {0};
#if defined(__AVX512F__)
    const __m512i lane = _mm512_max_epi32(
                      _mm512_min_epi32(
                          _mm512_add_epi32((__m512i)column, _mm512_set1_epi32((int)x0)),
                          _mm512_set1_epi32(layer->to_lane - 1)),
                      _mm512_set1_epi32(layer->from_lane)),
                  line = _mm512_max_epi32(
                      _mm512_min_epi32(_mm512_add_epi32((__m512i)row, _mm512_set1_epi32((int)y0)),
                                       _mm512_set1_epi32(layer->to_row - 1)),
                      _mm512_set1_epi32(layer->from_row));
    /* Relative to the first existing row, so that 32 bits suffice. */
    const sheet_sample *from_row = sheet->origin + layer->from_row * stride;
    const __m512i at = _mm512_add_epi32(
        _mm512_mullo_epi32(_mm512_sub_epi32(line, _mm512_set1_epi32(layer->from_row)),
                           _mm512_set1_epi32((int)stride)),
        lane);
#ifdef SHEET_INT16
    const __m512i pairs[2] = {_mm512_i32gather_epi32(at, from_row, 2),
                              _mm512_i32gather_epi32(at, from_row + stride, 2)};
    a = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(pairs[0], 16), 16));
    b = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(pairs[0], 16));
    c = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(pairs[1], 16), 16));
    d = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(pairs[1], 16));
#else
    a = (cvol_vf)_mm512_i32gather_ps(at, from_row, 4);
    b = (cvol_vf)_mm512_i32gather_ps(at, from_row + 1, 4);
    c = (cvol_vf)_mm512_i32gather_ps(at, from_row + stride, 4);
    d = (cvol_vf)_mm512_i32gather_ps(at, from_row + stride + 1, 4);
#endif
#elif defined(SHEET_INT16)
    for (int k = 0; k < CVOL_LANES; k++) {
        const ptrdiff_t at = clamp_to_range((ptrdiff_t)x0 + column[k], layer->from_lane,
                                            layer->to_lane - 1),
                        line = clamp_to_range((ptrdiff_t)y0 + row[k], layer->from_row,
                                              layer->to_row - 1);
        const sheet_sample *from = sheet->origin + line * stride + at;
        a[k] = from[0];
        b[k] = from[1];
        c[k] = from[stride];
        d[k] = from[stride + 1];
    }
#else
    const cvol_vi lane = cvol_clamp_int(column + (int)x0, layer->from_lane, layer->to_lane - 1),
                  line = cvol_clamp_int(row + (int)y0, layer->from_row, layer->to_row - 1);
    const cvol_vi at = (line - layer->from_row) * (int)stride + lane;
    const sheet_sample *from_row = sheet->origin + layer->from_row * stride;
    cvol_four around[CVOL_LANES];
    for (int k = 0; k < CVOL_LANES; k++)
        around[k] = cvol_load_pairs(from_row + at[k], from_row + at[k] + stride);
    cvol_vf all[4];
    cvol_transpose_fours(all, around);
    a = all[0];
    b = all[1];
    c = all[2];
    d = all[3];
#endif
    const cvol_vf near = a + right * (b - a), far = c + right * (d - c);
    const cvol_vf value = near + below * (far - near);
    const int mixed = sheet->number < 0
                          ? sheet->mixed
                          : (int)(job->mixed[i / CVOL_GROUP - job->first_group] >> sheet->number &
                                  1);
    if (mixed)
        return put_levels(value, job, sheet, i);
    return value;
}

#endif
