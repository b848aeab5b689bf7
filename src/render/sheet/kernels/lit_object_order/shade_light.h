/* The light at the end of a pending interval (shade.h): from the slopes of its slice, and from the
 * values of the adjacent slices.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_LIGHT_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_LIGHT_H

#include "render/sheet/kernels/lit_object_order/shade_group.h"
#include "render/view/phong.h"

/* A slice's samples, for part k of a group, at the position `place`: that slice itself, or one
 * `offset` before or behind it in memory. */
CVOL_INLINE cvol_vf value_at(cvol_vf *cover, const line_job *job, const sheet_line *place,
                             ptrdiff_t offset, int group, int k, int unit, int masked)
{
    sheet_line sheet = *place;
#if SHEET_EXTRAS
    if (job->layer->wide && masked)
        return to_table(job, reconstruct_widely_masked(cover, job, &sheet, offset, group, k, unit));
#endif
    if (masked) {
        const cvol_layer *layer = job->layer;
        const ptrdiff_t i = group * CVOL_GROUP + k * CVOL_LANES;
        sheet.view.near += offset;
        sheet.view.far += offset;
        return to_table(job,
                        unit ? reconstruct_unit_masked(cover, &sheet.view, &sheet.footprint,
                                                       sheet.footprint.x + i, layer->cover_at)
                             : reconstruct_finer_masked(cover, &sheet.view,
                                                        sheet.lane_at + (double)i * sheet.lane_step,
                                                        sheet.lane_step, layer->cover_at));
    }
    sheet.near += offset;
    sheet.far += offset;
    *cover = cvol_splat(1);
    return reconstruct(job, &sheet, group, k, unit);
}

CVOL_INLINE ptrdiff_t window_at(const sheet_line *sheet, int group, int unit)
{
    return window_of(lane_sample(sheet, group, unit));
}

CVOL_INLINE int is_masked(const sheet_line *sheet, int group, int unit, int has_void)
{
    return has_void && sheet->view.windows[window_at(sheet, group, unit)] & CVOL_WINDOW_MASKED;
}

/* The distance of slice b of the layer behind slice a in memory. */
CVOL_INLINE ptrdiff_t offset_to(const line_job *job, int b, int a)
{
    return job->layer->sheets[b].first - job->layer->sheets[a].first;
}

CVOL_INLINE void bound_neighbour(end_neighbour *out, const line_job *job, const sheet_line *sheet,
                                 ptrdiff_t window)
{
    out->edge = BOUNDED;
    out->level = sheet->view.levels[window] * job->table->scale + job->table_offset;
    out->spread = sheet->view.levels[window + job->layer->windows.spread_at] * job->table->scale;
}

/* Where rays meet slice `place` of the layer, in another slice of it. */
CVOL_INLINE void find_neighbour(end_neighbour *out, const line_job *job, int place, int slice,
                                int group, int unit, int has_void)
{
    const sheet_line *sheet = &job->sheets[place];
    const int masked = is_masked(sheet, group, unit, has_void);
    out->level = out->spread = 0;
    out->edge = KNOWN;
    for (int k = 0; k < PARTS; k++)
        out->value[k] = value_at(&out->cover[k], job, sheet, offset_to(job, slice, place), group, k,
                                 unit, masked);
}

/* Next to slice `s` of the layer (-1: the last one of the layer before), in the slice after it. */
CVOL_INLINE void find_after(end_neighbour *out, const line_job *job, int s, int at_face, int group,
                            int unit, int has_void)
{
    out->level = out->spread = 0;
    if (s + 1 >= job->layer->sheet_count || s < -1) {
        out->edge = at_face ? AT_FACE : CONTINUED;
        return;
    }
    if (s >= 0) {
        find_neighbour(out, job, s, s + 1, group, unit, has_void);
        return;
    }
    const ptrdiff_t window = window_at(&job->before, group, unit);
    if (!(job->before.view.windows[window] & CVOL_WINDOW_SEEN)) {
        bound_neighbour(out, job, &job->before, window);
        return;
    }
    const int masked = is_masked(&job->before, group, unit, has_void);
    out->edge = KNOWN;
    for (int k = 0; k < PARTS; k++)
        out->value[k] = value_at(&out->cover[k], job, &job->before, 0, group, k, unit, masked);
}

CVOL_INLINE cvol_vf bound(cvol_vf value, const end_neighbour *by)
{
    return cvol_min(cvol_max(value, cvol_splat(by->level - by->spread)),
                    cvol_splat(by->level + by->spread));
}

/* For part k, whose end has `value`, from pixel i on at slice s of the layer (reach.h). With
 * gradient interpolation, it returns the gradient in place of the light. When an opaque surface
 * lies between two slices, the gradient of one of them is faint and has an arbitrary direction, and
 * should have a weight by its length. */
CVOL_INLINE lit_sample light_end(const line_job *job, cvol_vf value, slope at,
                                 const end_neighbour *after, const end_neighbour *behind, int k,
                                 int s, int i, int has_void)
{
    const cvol_light *light = job->table->light;
    cvol_vf rise = {0}, fall = {0}; /* to the slice after, from the one before */
    if (after->edge == KNOWN)
        rise = after->value[k] - value;
    if (behind->edge == KNOWN)
        fall = value - behind->value[k];
    if (after->edge == CONTINUED || after->edge == BOUNDED)
        rise = fall;
    if (behind->edge == CONTINUED || behind->edge == BOUNDED)
        fall = rise;
    if (after->edge == BOUNDED)
        rise = bound(value + rise, after) - value;
    if (behind->edge == BOUNDED)
        fall = value - bound(value - fall, behind);
    cvol_vf across = rise + fall;
    if (has_void)
        across = weigh_differences(rise, fall,
                                   after->edge == KNOWN ? after->cover[k] : cvol_splat(1),
                                   behind->edge == KNOWN ? behind->cover[k] : cvol_splat(1));
    cvol_vf gradient[3] = {at.lane * light->rise[0], at.row * light->rise[1],
                           across * light->rise[2]};
    fade_gradient(gradient, job, s, i);
    const cvol_vf reach = reach_of_pixels(job, s, i);
    if (job->table->interpolates_gradients)
        return (lit_sample){gradient[0], gradient[1], gradient[2], reach};
    lit_sample lit = illuminate(gradient, light);
    lit.factor *= reach;
    lit.gloss *= reach;
    return lit;
}

#endif
