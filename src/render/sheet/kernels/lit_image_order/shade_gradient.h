/* Values and gradients at a group's pixels in image order (shade.h): in a slice, at an end in an
 * earlier layer, and at midpoints of two slices.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_GRADIENT_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_GRADIENT_H

#include "render/sheet/kernels/composite/reach.h"
#include "render/sheet/kernels/lit_image_order/shade_group.h"
#ifdef SHEET_INT16
#include "render/sheet/kernels/lit_image_order/shade_int16.h"
#else
#include "render/sheet/kernels/lit_image_order/shade_float.h"
#endif

/* ---- values ---------------------------------------------------------------------------------- */

/* A slice's samples at the position of the layer's slice `s`, `by` slices further. */
CVOL_INLINE sheet_line move_sheet(const line_job *job, int s, double by)
{
    sheet_line out = job->sheets[s];
    out.number = -1;
    out.lane_at += by * job->layer->sheets[s].lane_rate[0];
    out.row_at += by * job->layer->sheets[s].row_rate[0];
    return out;
}

/* The distance of slice b of the layer behind slice a in memory. */
CVOL_INLINE ptrdiff_t offset_to(const line_job *job, int b, int a)
{
    return job->sheets[b].origin - job->sheets[a].origin;
}

CVOL_INLINE int is_mixed(const line_job *job, int s, int group)
{
    return (int)(job->mixed[group - job->first_group] >> s & 1);
}

/* The invisible pixels of slice s. */
CVOL_COLD cvol_vi find_unseen_pixels(const line_job *job, int s, int group, int part)
{
    cvol_vf levels;
    group_place at;
    place_group(&at, job, &job->sheets[s], group, part);
    return find_unseen_of_group(&levels, job->layer, job->sheets[s].windows, &at);
}

/* For slice s; invisible pixels have a value in the middle of their window. */
CVOL_INLINE cvol_vf value_of_sheet(const line_job *job, int s, int group, const group_place *at)
{
    const sheet_line *sheet = &job->sheets[s];
    cvol_vf value = value_of_group(job, at, 0);
    if (is_mixed(job, s, group)) {
        cvol_vf levels;
        const cvol_vi unseen = find_unseen_of_group(&levels, job->layer, sheet->windows, at);
        value = cvol_select(unseen, levels, value);
    }
    return sample_to_table(job, value);
}

/* For a slice at the position of another one; invisible pixels have none. */
CVOL_INLINE cvol_vf value_ahead_of(const line_job *job, const sheet_line *sheet, int group,
                                   int part)
{
    group_place at;
    place_group(&at, job, sheet, group, part);
    const cvol_vf value = sample_to_table(job, value_of_group(job, &at, 0));
    if (is_there_image_order(job, sheet, group))
        return value;
    cvol_vf levels;
    const cvol_vi unseen = find_unseen_of_group(&levels, job->layer, sheet->windows, &at);
    return cvol_select(unseen, cvol_splat(NAN), value);
}

/* ---- gradients ------------------------------------------------------------------------------- */

/* From differences of samples two apart, in units given as a number per unit of the table. */
CVOL_INLINE gradient gradient_of(const line_job *job, const cvol_vf rise[3], float scale)
{
    gradient out;
    for (int k = 0; k < 3; k++)
        out.v[k] = rise[k] * (scale * job->table->light->rise[k]);
    return out;
}

/* At a slice with one before it and one behind. */
CVOL_INLINE gradient gradient_within(const line_job *job, int s, const group_place *at)
{
    cvol_vf rise[3];
    rise_of_group(rise, job, at, offset_to(job, s - 1, s), offset_to(job, s + 1, s));
    return gradient_of(job, rise, job->sample_scale);
}

/* Slopes of slice s, in the table's units, and the value in the slice before. */
CVOL_INLINE cvol_vf find_slopes(cvol_vf slopes[2], const lit_group *g, const line_job *job, int s,
                                int group, int part)
{
    group_place at;
    place_group(&at, job, &job->sheets[s], group, part);
    cvol_vf rise[3];
    rise_of_group(rise, job, &at, 0, 0);
    for (int k = 0; k < 2; k++)
        slopes[k] = rise[k] * job->sample_scale;
    return s > 0 ? sample_to_table(job, value_of_group(job, &at, offset_to(job, s - 1, s)))
                 : g->ahead;
}

/* At the end of the pending interval, which is slice s of the layer, below 0: of an earlier layer;
 * `after`: the value in the slice behind. */
CVOL_COLD gradient gradient_at_end(const lit_group *g, const line_job *job, int s, int group,
                                   int part, cvol_vf after)
{
    cvol_vf slopes[2] = {g->slope[0], g->slope[1]}, behind = g->behind;
    if (s >= 0)
        behind = find_slopes(slopes, g, job, s, group, part);
    cvol_vf rise = after - g->value, fall = g->value - behind;
    rise = cvol_select(rise == rise, rise, fall);
    fall = cvol_select(fall == fall, fall, rise);
    const cvol_vi known = (slopes[0] == slopes[0]) & (rise == rise);
    const cvol_vf rises[3] = {slopes[0], slopes[1], rise + fall};
    const gradient none = {.reach = {0}}, at = gradient_of(job, rises, 1);
    return select_gradient(known, &at, &none);
}

/* The value behind a pending interval's end. */
CVOL_INLINE cvol_vf value_after(const line_job *job, int s, int group, int part)
{
    if (s < -1 || s + 1 >= job->layer->sheet_count)
        return cvol_splat(NAN);
    if (s < 0)
        return value_ahead_of(job, &job->before, group, part);
    group_place at;
    place_group(&at, job, &job->sheets[s], group, part);
    return sample_to_table(job, value_of_group(job, &at, offset_to(job, s + 1, s)));
}

/* The distance of the midpoint from linear interpolation, estimated from both ends. */
CVOL_INLINE cvol_vf find_shear_correction(const lit_interval *i, const cvol_sheet_table *table)
{
    return table->shear_correction[0] * (i->from.v[0] - i->to.v[0]) +
           table->shear_correction[1] * (i->from.v[1] - i->to.v[1]);
}

/* The midpoint before slice s: estimated from the ends if the sample is unknown. With gradient
 * interpolation every interval has one: pixels of weight 0 take the estimate. */
CVOL_INLINE void find_middle(lit_interval *i, const line_job *job, int s, int group, int part,
                             cvol_vf weight)
{
    const cvol_vf half = cvol_splat(0.5f);
    const gradient straight = mix_gradients(&i->from, &i->to, half);
    i->middle = half * (i->a + i->b);
    i->half = straight;
    if (s < 1 || (job->seen[group - job->first_group] >> (s - 1) & 3) != 3) {
        i->middle += find_shear_correction(i, job->table);
        return;
    }
    const ptrdiff_t before = offset_to(job, s - 1, s);
    const sheet_line sheet = move_sheet(job, s, -0.5);
    group_place at;
    place_group(&at, job, &sheet, group, part);
    if (s > 1 && s + 1 < job->layer->sheet_count) {
        const four_sheets of = {offset_to(job, s - 2, s), before, offset_to(job, s + 1, s)};
        cvol_vf rise[3];
        i->middle = sample_to_table(job, midpoint_of_group(rise, job, &at, &of));
        i->half = gradient_of(job, rise, job->sample_scale);
        i->half.reach = straight.reach;
        fade_gradient(i->half.v, job, s - 0.5, group * CVOL_GROUP + part * CVOL_LANES);
    } else {
        const cvol_vf sum = value_of_group(job, &at, before) + value_of_group(job, &at, 0);
        i->middle = sample_to_table(job, half * sum);
    }
    if (is_mixed(job, s, group) || is_mixed(job, s - 1, group)) {
        const cvol_vi unseen = find_unseen_pixels(job, s, group, part) |
                               find_unseen_pixels(job, s - 1, group, part);
        i->middle = cvol_select(unseen, half * (i->a + i->b), i->middle);
        i->half = select_gradient(unseen, &straight, &i->half);
    }
    if (!job->table->interpolates_gradients)
        return;
    const cvol_vf linear = half * (i->a + i->b) + find_shear_correction(i, job->table);
    i->middle = linear + weight * (i->middle - linear);
    i->half = mix_gradients(&straight, &i->half, weight);
}

#endif
