/* Midpoint samples between two slices, in image order: the volume there, interpolated along all
 * three axes, is the mean of both slices at that place. Linear interpolation between the ends of an
 * interval misses it by more, the further a ray moves within the slices from one to the next. An
 * interval gets a midpoint sample if its ends differ so much that the error may be visible.
 *
 * The midpoint values of a layer's last slice are stored in the line until the next layer is
 * available. If a slice is invisible there, pixels have the levels of their windows; if nothing was
 * stored, the interval is linear.
 *
 * Only composite.h includes this file, after between.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_H

/* Line 5 is for samples that may have no value, which use object-order rays. */
CVOL_INLINE float *kept_midpoint(const line_job *job, int group)
{
    return job->line->values + 5 * (ptrdiff_t)job->line->width + (ptrdiff_t)group * CVOL_GROUP;
}

/* Slice s at the position of rays `by` slices further on. */
CVOL_INLINE sheet_line view_midpoint(const line_job *job, int s, double by)
{
    const cvol_sheet_view *sheet = &job->layer->sheets[s];
    sheet_line out = job->sheets[s];
    out.number = -1;
    out.lane_at += by * sheet->lane_rate[0];
    out.row_at += by * sheet->row_rate[0];
    return out;
}

/* The rise of an interval from a to b, weighted by its visibility. An interval with more than the
 * table's `midpoint` gets a midpoint sample. */
CVOL_INLINE cvol_vf find_curvature(cvol_vf a, cvol_vf b, cvol_vf transmittance)
{
    return (cvol_max(a, b) - cvol_min(a, b)) * transmittance;
}

/* Part k of a group at the midpoint between `a`, at the slice before, and `b` at slice s. */
CVOL_COLD cvol_vf find_midpoint(const line_job *job, int s, int group, int k, cvol_vf a, cvol_vf b)
{
    sheet_line sheet = view_midpoint(job, s, -0.5);
    const cvol_vf behind = reconstruct_there(job, &sheet, group, k, 0);
    cvol_vf before;
    if (s > 0) {
        sheet.origin = job->sheets[s - 1].origin;
        sheet.windows = job->sheets[s - 1].windows;
        before = reconstruct_there(job, &sheet, group, k, 0);
    } else {
        before = cvol_load(kept_midpoint(job, group) + k * CVOL_LANES);
    }
    const cvol_vf value = cvol_select(before < INFINITY, 0.5f * (before + behind), behind);
    return cvol_select(before == before, value, 0.5f * (a + b));
}

/* Adds the midpoint sample, in *middle, to part k of a group in the interval that ends at slice s,
 * if it needs one. */
CVOL_INLINE void look_midpoint(interval *i, cvol_vf *middle, const line_job *job, int s, int group,
                               int k, cvol_vf transmittance)
{
    const cvol_vf curvature = find_curvature(i->a, i->b, transmittance);
    if (job->layer->parts != 1 || !any_above(curvature, job->table->midpoint))
        return;
    const cvol_vf straight = 0.5f * (i->a + i->b),
                  share = cvol_min((curvature - job->table->midpoint) *
                                       (1 / job->table->midpoint_ramp),
                                   cvol_splat(1));
    *middle = straight + share * (find_midpoint(job, s, group, k, i->a, i->b) - straight);
    i->middle = middle;
    i->has_midpoint = curvature > job->table->midpoint;
}

/* Stores the midpoint values of the layer's last slice towards the next, whose values are not known
 * yet; marks them as unknown near a face. */
CVOL_COLD void keep_midpoint(const line_job *job, int group)
{
    const int last = job->layer->sheet_count - 1, inside = is_inside(&job->sheets[last], group);
    const sheet_line sheet = view_midpoint(job, last, 0.5);
    for (int k = 0; k < PARTS; k++)
        cvol_store(kept_midpoint(job, group) + k * CVOL_LANES,
                   inside ? reconstruct_there(job, &sheet, group, k, 0) : cvol_splat(NAN));
}

/* The same for a group that did not meet that slice, since the slice is invisible there: levels, if
 * the midpoint is invisible, too; elsewhere infinity: the slice behind decides. */
CVOL_COLD void keep_levels_midpoint(const line_job *job, int group)
{
    sheet_line before = view_midpoint(job, 0, -0.5);
    before.windows = windows_before(job->layer, &job->layer->sheets[0]);
    for (int k = 0; k < PARTS; k++)
        cvol_store(kept_midpoint(job, group) + k * CVOL_LANES,
                   sample_to_table(job, put_levels(cvol_splat(INFINITY), job, &before,
                                                   group * CVOL_GROUP + k * CVOL_LANES)));
}

#endif
