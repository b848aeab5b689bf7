/* Reconstruction: the values of a line of the intermediate image on one slice.
 *
 * Each slice's samples are reconstructed on the slice's own grid by the linear footprint, two rows,
 * two lanes; or by a reconstruction filter, if requested (footprint_wide.h). All pixels of a line
 * share the row weights. In parallel projection, if intermediate image and samples have one pitch,
 * they also share the lane weights.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_FOOTPRINT_H
#define CVOL_RENDER_SHEET_KERNELS_FOOTPRINT_H

#include <math.h>

#include "base/vector.h"
#include "render/sheet/frame/frame.h"

/* 1 if the lines are the picture's own, see line_slanted.h. */
#ifndef SHEET_IMAGE_ORDER
#define SHEET_IMAGE_ORDER 0
#endif

/* Columns of pixels in a group, and lines. */
#if SHEET_IMAGE_ORDER
#define GROUP_ACROSS CVOL_SQUARE
#define GROUP_DOWN CVOL_SQUARE
#else
#define GROUP_ACROSS CVOL_GROUP
#define GROUP_DOWN 1
#endif

/* The position of pixel number i of a line in memory, the first of CVOL_LANES: its column, and its
 * line within the group. */
CVOL_INLINE int column_of(int i)
{
    return SHEET_IMAGE_ORDER ? i / CVOL_GROUP * GROUP_ACROSS : i;
}

CVOL_INLINE int line_of(int i)
{
    return SHEET_IMAGE_ORDER ? i % CVOL_GROUP / GROUP_ACROSS : 0;
}

/* The distance of these CVOL_LANES pixels from the first of them: `across` from column to column,
 * and `down` from line to line. */
CVOL_INLINE cvol_vf spread_pixels(float across, float down)
{
#if SHEET_IMAGE_ORDER
    const cvol_vi number = cvol_to_int(cvol_iota());
    return cvol_to_float(number & (CVOL_SQUARE - 1)) * across +
           cvol_to_float(number / CVOL_SQUARE) * down;
#else
    (void)down;
    return cvol_iota() * across;
#endif
}

/* The least and the most of a quantity over `count` pixels of a row, or of a line, if it grows by
 * `step`. */
CVOL_INLINE double least_reach(double step, int count)
{
    return step < 0 ? (count - 1) * step : 0;
}

CVOL_INLINE double most_reach(double step, int count)
{
    return step < 0 ? 0 : (count - 1) * step;
}

/* Kernels are compiled for samples of either kind, see cvol_int16_scale. */
#ifdef SHEET_INT16
typedef int16_t sheet_sample;
#else
typedef float sheet_sample;
#endif

CVOL_INLINE const sheet_sample *samples_of(const cvol_sheet_view *sheet)
{
#ifdef SHEET_INT16
    return sheet->int16;
#else
    return sheet->samples;
#endif
}

/* CVOL_LANES samples, in stored form. */
CVOL_INLINE cvol_vf load_samples(const sheet_sample *from)
{
#ifdef SHEET_INT16
    int16_t values __attribute__((vector_size(2 * CVOL_LANES)));
    memcpy(&values, from, sizeof values);
    return __builtin_convertvector(values, cvol_vf);
#else
    return cvol_load(from);
#endif
}

/* Slices around a part that its kernels meet. */
#define PART_REACH 3

/* Smaller weights count as none. */
#define MIN_WEIGHT 1e-4f

/* One slice, as seen by one line of the image. */
typedef struct line_view {
    const sheet_sample *near, *far; /* the two rows of samples */
    float near_weight, far_weight;
    float enter, leave; /* the interval of the line's rays within the slices' and rows' faces, in */
                        /* slices from this one */
    const uint8_t *windows;
    const float *levels; /* of the invisible windows */
} line_view;

/* The windows of the row of blocks, or of the two, at sample coordinate r of a line, and their
 * levels; *y: the row of samples before it. */
CVOL_INLINE const uint8_t *find_windows(const float **levels, ptrdiff_t *y, const cvol_layer *layer,
                                        const cvol_windows *windows, double r)
{
    const int last = layer->block_rows * layer->row_points - 1;
    *y = r < last + 1 ? (ptrdiff_t)floor(r) : last;
    const ptrdiff_t from = *y - layer->reach, to = *y + 1 + layer->reach;
    int low = from < 0 ? 0 : (int)from, high = to > last ? last : (int)to;
    low = low > last ? last : low;
    const int block_row = (int)((uint64_t)low * layer->row_points_inverse >> 32);
    const int across = high >= (block_row + 1) * layer->row_points;
    *levels = (across ? windows->across_level : windows->within_level) + block_row * windows->count;
    return (across ? windows->across : windows->within) + block_row * windows->count;
}

/* The place at which a quantity with `value` at a slice and growth `rate` per slice reaches 0. */
CVOL_INLINE double find_crossing(double value, double rate)
{
    const double least = 1e-5;
    return -value / (fabs(rate) > least ? rate : rate < 0 ? -least : least);
}

CVOL_INLINE void view_line(line_view *view, const cvol_layer *layer, const cvol_sheet_view *sheet,
                           int j)
{
    const int last = layer->block_rows * layer->row_points - 1;
    double r = sheet->row_at + j * sheet->row_step;
    float enter, leave;
    if (layer->perspective) {
        const double rate = sheet->row_rate[0] + j * sheet->row_rate[1];
        const double a = find_crossing(r - layer->row_lo, rate),
                     b = find_crossing(r - layer->row_hi, rate);
        enter = (float)(a < b ? a : b);
        leave = (float)(a < b ? b : a);
    } else {
        enter = (float)(layer->row_enter - r) * layer->row_slices;
        leave = (float)(layer->row_leave - r) * layer->row_slices;
    }
    view->enter = enter > sheet->front ? enter : sheet->front;
    view->leave = leave < sheet->back ? leave : sheet->back;
    /* Rows -1 and one past the last exist as copies. */
    r = r < -1 ? -1 : r > last + 1 ? last + 1 : r;
    ptrdiff_t y;
    view->windows = find_windows(
        &view->levels, &y, layer,
        sheet->is_of_previous_layer ? &layer->windows_before : &layer->windows, r);
    view->far_weight = (float)(r - (double)y);
    view->near_weight = 1 - view->far_weight;
    view->near = samples_of(sheet) + (sheet->first + y * layer->row_stride);
    view->far = view->near + layer->row_stride;
}

/* ---- groups that planes cut ------------------------------------------------------------------ */

CVOL_INLINE int clamp_to_groups(double group, int groups)
{
    return !(group > 0) ? 0 : group > groups ? groups : (int)group;
}

/* The groups *begin .. *end - 1 in which `at` + i `step` is at least 0 for some pixel i, or, if
 * `whole`, for all. */
CVOL_INLINE void find_half_line(int *begin, int *end, double at, double step, int whole, int groups)
{
    *begin = 0;
    *end = groups;
    const double i = -at / step;
    if (step > 0)
        *begin = clamp_to_groups(whole ? ceil(i / GROUP_ACROSS) : floor(ceil(i) / GROUP_ACROSS),
                                 groups);
    else if (step < 0)
        *end = clamp_to_groups(whole ? floor((floor(i) + 1) / GROUP_ACROSS)
                                     : floor(floor(i) / GROUP_ACROSS) + 1,
                               groups);
    else if (at < 0)
        *end = 0;
}

/* The groups of a slice that planes leave in line j: begin .. end - 1 meet it; inside are those
 * that are within it, from two slices before on; and within the clip, which has no faces of a
 * part. */
typedef struct group_range {
    int begin, end, inside_begin, inside_end, clip_begin, clip_end;
} group_range;

static __attribute__((noinline)) void cut_groups(group_range *range, const cvol_layer *layer,
                                                 const cvol_sheet_view *sheet, int j, int groups)
{
    for (int k = 0; k < layer->cuts; k++) {
        const cvol_sheet_linear *cut = &sheet->cuts[k];
        const double at = cut->value[0] + j * cut->value[2], rate = cut->rate[0] + j * cut->rate[2];
        const double some = at + most_reach(cut->value[2], GROUP_DOWN), /* of a group's lines */
            all = at + least_reach(cut->value[2], GROUP_DOWN);
        /* At faces of parts, values and gradients come from slices outside, too. */
        const int is_part = k >= layer->cuts - layer->part_cuts, reach = is_part ? PART_REACH : 1;
        if (k == layer->cuts - layer->part_cuts) {
            range->clip_begin = range->inside_begin;
            range->clip_end = range->inside_end;
        }
        int begin[2], end[2];
        /* Linear along rays, so it has its extremes at both ends. */
        for (int i = 0; i < 2; i++)
            find_half_line(&begin[i], &end[i], some + reach * (2 * i - 1) * rate,
                           cut->value[1] + reach * (2 * i - 1) * cut->rate[1], 0, groups);
        if (begin[0] >= end[0]) {
            begin[0] = begin[1];
            end[0] = end[1];
        } else if (begin[1] < end[1]) {
            begin[0] = begin[0] < begin[1] ? begin[0] : begin[1];
            end[0] = end[0] > end[1] ? end[0] : end[1];
        }
        range->begin = range->begin > begin[0] ? range->begin : begin[0];
        range->end = range->end < end[0] ? range->end : end[0];
        for (int i = 0; i < 2; i++) {
            find_half_line(&begin[i], &end[i], all - 2 * i * rate,
                           cut->value[1] - 2 * i * cut->rate[1], 1, groups);
            range->inside_begin = range->inside_begin > begin[i] ? range->inside_begin : begin[i];
            range->inside_end = range->inside_end < end[i] ? range->inside_end : end[i];
        }
    }
}

/* The window that 16 pixels from sample x on see. */
CVOL_INLINE ptrdiff_t window_of(ptrdiff_t x)
{
    return x < -CVOL_GROUP ? 0 : (x + CVOL_GROUP) / CVOL_GROUP;
}

/* The linear footprint if pixels and samples have one pitch: four weights for all pixels. */
typedef struct unit_footprint {
    ptrdiff_t x; /* sample left of pixel 0 */
    float near_left, near_right, far_left, far_right;
} unit_footprint;

CVOL_INLINE unit_footprint make_unit_footprint(const line_view *view, const cvol_sheet_view *sheet)
{
    double whole = floor(sheet->lane_at);
    float right = (float)(sheet->lane_at - whole), left = 1 - right;
    return (unit_footprint){.x = (ptrdiff_t)whole,
                            .near_left = view->near_weight * left,
                            .near_right = view->near_weight * right,
                            .far_left = view->far_weight * left,
                            .far_right = view->far_weight * right};
}

CVOL_INLINE cvol_vf reconstruct_unit(const line_view *view, const unit_footprint *footprint,
                                     ptrdiff_t x)
{
    return footprint->near_left * load_samples(view->near + x) +
           footprint->near_right * load_samples(view->near + x + 1) +
           footprint->far_left * load_samples(view->far + x) +
           footprint->far_right * load_samples(view->far + x + 1);
}

/* The same if pixels lie closer than samples: CVOL_LANES pixels from `position` on. */
CVOL_INLINE cvol_vf reconstruct_finer(const line_view *view, double position, double step)
{
    double whole = floor(position);
    const sheet_sample *near = view->near + (ptrdiff_t)whole, *far = view->far + (ptrdiff_t)whole;
    cvol_vf low = view->near_weight * load_samples(near) + view->far_weight * load_samples(far);
    cvol_vf high = view->near_weight * load_samples(near + CVOL_LANES) +
                   view->far_weight * load_samples(far + CVOL_LANES);
    cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    cvol_vi index = cvol_to_int(at);
    cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf left = cvol_shuffle(low, high, index);
    cvol_vf right = cvol_shuffle(low, high, index + 1);
    return left + fraction * (right - left);
}

/* The same two if samples may have no value: *cover is the weight of those that have one. */
CVOL_INLINE cvol_vf mean_of(cvol_vf sum, cvol_vf cover)
{
    return sum / cvol_max(cover, cvol_splat(MIN_WEIGHT));
}

CVOL_INLINE cvol_vf reconstruct_unit_masked(cvol_vf *cover, const line_view *view,
                                            const unit_footprint *footprint, ptrdiff_t x,
                                            ptrdiff_t cover_at)
{
    const cvol_vf a = footprint->near_left * load_samples(view->near + cover_at + x),
                  b = footprint->near_right * load_samples(view->near + cover_at + x + 1),
                  c = footprint->far_left * load_samples(view->far + cover_at + x),
                  d = footprint->far_right * load_samples(view->far + cover_at + x + 1);
    *cover = a + b + c + d;
    return mean_of(a * load_samples(view->near + x) + b * load_samples(view->near + x + 1) +
                       c * load_samples(view->far + x) + d * load_samples(view->far + x + 1),
                   *cover);
}

CVOL_INLINE cvol_vf reconstruct_finer_masked(cvol_vf *cover, const line_view *view, double position,
                                             double step, ptrdiff_t cover_at)
{
    const double whole = floor(position);
    const sheet_sample *near = view->near + (ptrdiff_t)whole, *far = view->far + (ptrdiff_t)whole;
    const cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    const cvol_vi index = cvol_to_int(at);
    const cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf sums[2], covers[2];
    for (int k = 0; k < 2; k++) {
        const ptrdiff_t i = k * CVOL_LANES;
        const cvol_vf a = view->near_weight * load_samples(near + cover_at + i),
                      b = view->far_weight * load_samples(far + cover_at + i);
        covers[k] = a + b;
        sums[k] = a * load_samples(near + i) + b * load_samples(far + i);
    }
    const cvol_vf left = cvol_shuffle(covers[0], covers[1], index),
                  right = cvol_shuffle(covers[0], covers[1], index + 1);
    const cvol_vf from = cvol_shuffle(sums[0], sums[1], index),
                  to = cvol_shuffle(sums[0], sums[1], index + 1);
    *cover = left + fraction * (right - left);
    return mean_of(from + fraction * (to - from), *cover);
}

/* The same of vectors. */
CVOL_INLINE cvol_vf find_crossings(cvol_vf value, cvol_vf rate)
{
    const cvol_vf least = cvol_splat(1e-5f);
    const cvol_vf away = cvol_select(rate < 0, cvol_min(rate, -least), cvol_max(rate, least));
    return -value / away;
}

/* The interval in which the CVOL_LANES pixels from number i of line j on (`position` except in
 * image order) are within the drawn part: in slices from this one. */
CVOL_INLINE void find_span(cvol_vf *enter, cvol_vf *leave, const cvol_layer *layer,
                           const cvol_sheet_view *sheet, const line_view *view, double position,
                           int i, int j)
{
    const int column = column_of(i);
    j += line_of(i);
#if SHEET_IMAGE_ORDER
    position = sheet->lane_at + column * sheet->lane_step + j * sheet->lane_down;
#endif
    const cvol_vf offset = spread_pixels((float)sheet->lane_step, (float)sheet->lane_down);
    if (layer->perspective) {
        const cvol_vf rate = (float)(sheet->lane_rate[0] + i * sheet->lane_rate[1]) +
                             cvol_iota() * (float)sheet->lane_rate[1];
        const cvol_vf a = find_crossings((float)(position - layer->lane_lo) + offset, rate),
                      b = find_crossings((float)(position - layer->lane_hi) + offset, rate);
        *enter = cvol_min(a, b);
        *leave = cvol_max(a, b);
    } else {
        *enter = ((float)(layer->lane_enter - position) - offset) * layer->lane_slices;
        *leave = ((float)(layer->lane_leave - position) - offset) * layer->lane_slices;
    }
#if SHEET_IMAGE_ORDER
    const double row = sheet->row_at + j * sheet->row_step + column * sheet->row_right;
    const cvol_vf below = spread_pixels((float)sheet->row_right, (float)sheet->row_step);
    *enter = cvol_max(*enter, ((float)(layer->row_enter - row) - below) * layer->row_slices);
    *leave = cvol_min(*leave, ((float)(layer->row_leave - row) - below) * layer->row_slices);
#endif
    *enter = cvol_max(*enter, cvol_splat(view->enter));
    *leave = cvol_min(*leave, cvol_splat(view->leave));
    for (int k = 0; k < layer->cuts - layer->part_cuts; k++) {
        const cvol_sheet_linear *cut = &sheet->cuts[k];
        const double at = cut->value[0] + j * cut->value[2],
                     grows = cut->rate[0] + j * cut->rate[2];
        const cvol_vf value = (float)(at + column * cut->value[1]) +
                              spread_pixels((float)cut->value[1], (float)cut->value[2]);
        const cvol_vf rate = (float)(grows + column * cut->rate[1]) +
                             spread_pixels((float)cut->rate[1], (float)cut->rate[2]);
        const cvol_vf crossing = find_crossings(value, rate);
        *enter = cvol_select(rate < 0, *enter, cvol_max(*enter, crossing));
        *leave = cvol_select(rate < 0, cvol_min(*leave, crossing), *leave);
    }
}

/* The pixels from number i of line j on whose interval, from the slice before to this one, belongs
 * to the part: it has the interval's middle. */
CVOL_INLINE cvol_vi find_owned(const cvol_layer *layer, const cvol_sheet_view *sheet, int i, int j)
{
    const int column = column_of(i);
    const double middle = layer->only ? 0 : -0.5;
    cvol_vi owned = ~(cvol_vi){0};
    j += line_of(i);
    for (int k = layer->cuts - layer->part_cuts; k < layer->cuts; k++) {
        const cvol_sheet_linear *cut = &sheet->cuts[k];
        double at[3];
        for (int d = 0; d < 3; d++)
            at[d] = cut->value[d] + middle * cut->rate[d];
        const cvol_vf value = (float)(at[0] + column * at[1] + j * at[2]) +
                              spread_pixels((float)at[1], (float)at[2]);
        owned &= value >= 0;
    }
    return owned;
}

/* The length of their way inside within the slab begin .. end; 0 or less: none. */
CVOL_INLINE cvol_vf weigh(const cvol_layer *layer, const cvol_sheet_view *sheet,
                          const line_view *view, double position, int i, int j, float begin,
                          float end)
{
    cvol_vf enter, leave;
    find_span(&enter, &leave, layer, sheet, view, position, i, j);
    return cvol_min(leave, cvol_splat(end)) - cvol_max(enter, cvol_splat(begin));
}

#endif
