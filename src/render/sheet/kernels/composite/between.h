/* Samples between two slices, an extra: the volume, interpolated along all three axes, at places of
 * a ray between one slice and the next. For parts 1 .. n - 1 of n it is
 *
 *     (1 - t) a(t) + t b(t),  t = part / n,
 *
 * with a and b the two slices' own values where the ray is at t. The values of a layer's last slice
 * are stored in the line until the next layer is available: line->between has, part by part, first
 * these, and then, for lit frames, the samples of the pending interval. If a window under the ray
 * was not evaluated, the value is NaN, and the interval is linear.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_BETWEEN_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_BETWEEN_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/line.h"

/* The positions of slices' samples for a line at parts 1 .. of the interval from the slice before;
 * and, behind the last slice, in the interval from it. */
typedef struct between_views {
    sheet_line to[CVOL_BLOCK_MAX][CVOL_PARTS - 1], from_last[CVOL_PARTS - 1];
} between_views;

/* Moves a view by a number of slices. */
CVOL_INLINE void move_by(cvol_sheet_view *view, double by)
{
    view->lane_at += by * view->lane_rate[0];
    view->lane_step += by * view->lane_rate[1];
    view->row_at += by * view->row_rate[0];
    view->row_step += by * view->row_rate[1];
}

#if SHEET_IMAGE_ORDER
static inline void view_between(between_views *out, const line_job *job, int unit)
{
    const cvol_layer *layer = job->layer;
    (void)unit;
    for (int part = 1; part < layer->parts; part++) {
        const double t = (double)part / layer->parts;
        for (int s = 0; s <= layer->sheet_count; s++) {
            const int of = s < layer->sheet_count ? s : s - 1;
            const double by = s < layer->sheet_count ? t - 1 : t;
            sheet_line *to = s < layer->sheet_count ? &out->to[s][part - 1]
                                                    : &out->from_last[part - 1];
            *to = job->sheets[of];
            to->number = -1;
            to->lane_at += by * layer->sheets[of].lane_rate[0];
            to->row_at += by * layer->sheets[of].row_rate[0];
        }
    }
}
#else
static inline void view_between(between_views *out, const line_job *job, int unit)
{
    const cvol_layer *layer = job->layer;
    for (int part = 1; part < layer->parts; part++) {
        const double t = (double)part / layer->parts;
        for (int s = 0; s < layer->sheet_count; s++) {
            cvol_sheet_view view = layer->sheets[s];
            move_by(&view, t - 1);
            view_sheet(&out->to[s][part - 1], job, &view, unit);
        }
        cvol_sheet_view view = layer->sheets[layer->sheet_count - 1];
        move_by(&view, t);
        view_sheet(&out->from_last[part - 1], job, &view, unit);
    }
}

#endif

/* A part of a group. If samples do not exist, image-order rays take the levels of their windows;
 * other rays NaN. */
CVOL_INLINE cvol_vf reconstruct_there(const line_job *job, const sheet_line *sheet, int group,
                                      int k, int unit)
{
#if SHEET_IMAGE_ORDER
    sheet_line view = *sheet;
    view.mixed = !is_there_image_order(job, sheet, group);
    return reconstruct(job, &view, group, k, unit);
#else
    const ptrdiff_t window = window_of(lane_sample(sheet, group, unit));
    return sheet->view.windows[window] & CVOL_WINDOW_SEEN ? reconstruct(job, sheet, group, k, unit)
                                                          : cvol_splat(NAN);
#endif
}

/* For part k of a group. */
CVOL_INLINE float *kept_between(const line_job *job, int index, int group, int k)
{
    return job->line->between + (ptrdiff_t)index * job->line->width + group * CVOL_GROUP +
           k * CVOL_LANES;
}

/* Stores the values of the layer's last slice behind it. */
CVOL_INLINE void keep_between(const line_job *job, int group, int unit)
{
    for (int part = 1; part < job->layer->parts; part++)
        for (int k = 0; k < PARTS; k++)
            cvol_store(kept_between(job, part - 1, group, k),
                       reconstruct_there(job, &job->between->from_last[part - 1], group, k, unit));
}

/* The sample of a part of the interval from `a`, at the slice before, to `b` at slice s. */
CVOL_INLINE cvol_vf find_between(const line_job *job, int s, int part, int group, int k, int unit,
                                 cvol_vf a, cvol_vf b)
{
    const sheet_line *view = &job->between->to[s][part - 1];
    const float t = (float)part / (float)job->layer->parts;
    const cvol_vf straight = a + t * (b - a);
    const cvol_vf end = reconstruct_there(job, view, group, k, unit);
    cvol_vf start;
    if (s > 0) {
        sheet_line before = *view;
        const ptrdiff_t offset = job->layer->sheets[s - 1].first - job->layer->sheets[s].first;
#if SHEET_IMAGE_ORDER
        before.origin += offset;
        before.windows = job->sheets[s - 1].windows;
#else
        before.near += offset;
        before.far += offset;
#endif
        start = reconstruct_there(job, &before, group, k, unit);
    } else {
        start = cvol_load(kept_between(job, part - 1, group, k));
    }
    const cvol_vf value = start + t * (end - start);
    return cvol_select(value == value, value, straight);
}

#endif
