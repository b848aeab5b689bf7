/* Reconstruction: what a line of the intermediate image sees of one sheet.
 *
 * Each sheet's samples are reconstructed by the linear footprint on the sheet's own grid: two rows,
 * two lanes. Under parallel projection all pixels of a line share the row weights, and, where
 * intermediate image and samples have one pitch, the lane weights too.
 *
 * To be included by kernel files only: each compiles it for its instruction set.
 */
#ifndef CVOL_RENDER_SHEET_FOOTPRINT_H
#define CVOL_RENDER_SHEET_FOOTPRINT_H

#include <math.h>

#include "base/vector.h"
#include "render/sheet.h"

/* Less weight than this is none. */
#define LEAST_WEIGHT 1e-4f

/* One sheet as one line of the image sees it. */
typedef struct line_view {
    const float *near, *far; /* the two rows of samples */
    float near_weight, far_weight;
    float slab_begin,
        slab_end; /* where the line's rays are within, but for the side lanes' faces */
    const uint8_t *windows;
    const float *levels; /* of the windows that cannot be seen */
} line_view;

/* The windows of the row of blocks, or of the two, that a line at sample coordinate r lies in, and
 * their levels; *y: the row of samples before it. */
CVOL_INLINE const uint8_t *find_windows(const float **levels, long *y, const cvol_layer *layer,
                                        const cvol_windows *windows, double r)
{
    const int last = layer->block_rows * layer->row_points - 1;
    *y = r < last + 1 ? (long)floor(r) : last;
    int low = *y < 0 ? 0 : (int)*y, high = *y + 1 > last ? last : (int)*y + 1;
    low = low > last ? last : low;
    const int block_row = (int)((uint64_t)low * layer->row_points_inverse >> 32);
    const int across = high >= (block_row + 1) * layer->row_points;
    *levels = (across ? windows->across_level : windows->within_level) + block_row * windows->count;
    return (across ? windows->across : windows->within) + block_row * windows->count;
}

/* The sheet stands for the slab from `slab_begin` to `slab_end`, in sheets from itself. */
CVOL_INLINE void view_line(line_view *view, const cvol_layer *layer, const cvol_sheet_view *sheet,
                           int j, float slab_begin, float slab_end)
{
    const int last = layer->block_rows * layer->row_points - 1;
    double r = sheet->row_at + j * layer->row_step;
    float enter = (float)(layer->row_enter - r) * layer->row_turn;
    float leave = (float)(layer->row_leave - r) * layer->row_turn;
    float front = enter > sheet->front ? enter : sheet->front;
    float back = leave < sheet->back ? leave : sheet->back;
    view->slab_begin = front > slab_begin ? front : slab_begin;
    view->slab_end = back < slab_end ? back : slab_end;
    /* Rows -1 and one past the last exist as copies. */
    r = r < -1 ? -1 : r > last + 1 ? last + 1 : r;
    long y;
    view->windows = find_windows(&view->levels, &y, layer, &layer->windows, r);
    view->far_weight = (float)(r - (double)y);
    view->near_weight = 1 - view->far_weight;
    view->near = sheet->samples + (sheet->first + y * layer->row_stride);
    view->far = view->near + layer->row_stride;
}

/* The window that 16 pixels from sample x on see. */
CVOL_INLINE long window_of(long x)
{
    return x < -CVOL_GROUP ? 0 : (x + CVOL_GROUP) / CVOL_GROUP;
}

/* The linear footprint where pixels and samples have one pitch: four weights for all pixels. */
typedef struct unit_footprint {
    long x; /* sample left of pixel 0 */
    cvol_vf near_left, near_right, far_left, far_right;
} unit_footprint;

CVOL_INLINE unit_footprint make_unit_footprint(const line_view *view, const cvol_sheet_view *sheet)
{
    double whole = floor(sheet->lane_at);
    float right = (float)(sheet->lane_at - whole), left = 1 - right;
    return (unit_footprint){.x = (long)whole,
                            .near_left = cvol_splat(view->near_weight * left),
                            .near_right = cvol_splat(view->near_weight * right),
                            .far_left = cvol_splat(view->far_weight * left),
                            .far_right = cvol_splat(view->far_weight * right)};
}

CVOL_INLINE cvol_vf reconstruct_unit(const line_view *view, const unit_footprint *footprint, long x)
{
    return footprint->near_left * cvol_load(view->near + x) +
           footprint->near_right * cvol_load(view->near + x + 1) +
           footprint->far_left * cvol_load(view->far + x) +
           footprint->far_right * cvol_load(view->far + x + 1);
}

/* The same where pixels lie closer than samples: CVOL_LANES pixels from `position` on. */
CVOL_INLINE cvol_vf reconstruct_finer(const line_view *view, double position, double step)
{
    double whole = floor(position);
    const float *near = view->near + (long)whole, *far = view->far + (long)whole;
    cvol_vf low = view->near_weight * cvol_load(near) + view->far_weight * cvol_load(far);
    cvol_vf high = view->near_weight * cvol_load(near + CVOL_LANES) +
                   view->far_weight * cvol_load(far + CVOL_LANES);
    cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    cvol_vi index = cvol_to_int(at);
    cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf left = cvol_shuffle(low, high, index);
    cvol_vf right = cvol_shuffle(low, high, index + 1);
    return left + fraction * (right - left);
}

/* The same two where samples may have no value: *cover is the weight of those that have. */
CVOL_INLINE cvol_vf mean_of(cvol_vf sum, cvol_vf cover)
{
    return sum / cvol_max(cover, cvol_splat(LEAST_WEIGHT));
}

CVOL_INLINE cvol_vf reconstruct_unit_masked(cvol_vf *cover, const line_view *view,
                                            const unit_footprint *footprint, long x, long cover_at)
{
    const cvol_vf a = footprint->near_left * cvol_load(view->near + cover_at + x),
                  b = footprint->near_right * cvol_load(view->near + cover_at + x + 1),
                  c = footprint->far_left * cvol_load(view->far + cover_at + x),
                  d = footprint->far_right * cvol_load(view->far + cover_at + x + 1);
    *cover = a + b + c + d;
    return mean_of(a * cvol_load(view->near + x) + b * cvol_load(view->near + x + 1) +
                       c * cvol_load(view->far + x) + d * cvol_load(view->far + x + 1),
                   *cover);
}

CVOL_INLINE cvol_vf reconstruct_finer_masked(cvol_vf *cover, const line_view *view, double position,
                                             double step, long cover_at)
{
    const double whole = floor(position);
    const float *near = view->near + (long)whole, *far = view->far + (long)whole;
    const cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    const cvol_vi index = cvol_to_int(at);
    const cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf sums[2], covers[2];
    for (int k = 0; k < 2; k++) {
        const long i = k * CVOL_LANES;
        const cvol_vf a = view->near_weight * cvol_load(near + cover_at + i),
                      b = view->far_weight * cvol_load(far + cover_at + i);
        covers[k] = a + b;
        sums[k] = a * cvol_load(near + i) + b * cvol_load(far + i);
    }
    const cvol_vf left = cvol_shuffle(covers[0], covers[1], index),
                  right = cvol_shuffle(covers[0], covers[1], index + 1);
    const cvol_vf from = cvol_shuffle(sums[0], sums[1], index),
                  to = cvol_shuffle(sums[0], sums[1], index + 1);
    *cover = left + fraction * (right - left);
    return mean_of(from + fraction * (to - from), *cover);
}

/* How much of its slab the CVOL_LANES pixels from `position` on spend within; 0 or less: none. */
CVOL_INLINE cvol_vf weigh(const cvol_layer *layer, const line_view *view, double position)
{
    cvol_vf offset = cvol_iota() * (float)layer->lane_step;
    cvol_vf enter = ((float)(layer->lane_enter - position) - offset) * layer->lane_turn;
    cvol_vf leave = ((float)(layer->lane_leave - position) - offset) * layer->lane_turn;
    return cvol_min(leave, cvol_splat(view->slab_end)) -
           cvol_max(enter, cvol_splat(view->slab_begin));
}

#endif
