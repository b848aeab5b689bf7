/* Samples midpoint between two sheets, along the rays of the picture's pixels: what the volume,
 * interpolated along all three axes, is there is the mean of what both sheets have at that place.
 * A straight line between the two ends of an interval misses it by more, the further a ray moves
 * along the sheets from one to the next. They are looked at where the ends differ by so much that
 * it may be seen.
 *
 * Of a layer's last sheet, what it has midpoint to the next one is kept in the line until the layer
 * with that is there, if the interval before would be looked at. Where nothing can be seen of a
 * sheet there, pixels have the levels of their windows; where nothing was kept, what lies straight
 * between.
 *
 * To be included by composite.h only, after between.h.
 */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_H

/* Line 5 is for samples that may have no value: these rays go along the lattice. */
CVOL_INLINE float *kept_midpoint(const line_job *job, int group)
{
    return job->line->values + 5 * (long)job->line->width + (long)group * CVOL_GROUP;
}

/* Sheet s as rays meet it `by` sheets further on. */
CVOL_INLINE sheet_line view_midpoint(const line_job *job, int s, double by)
{
    const cvol_sheet_view *sheet = &job->layer->sheets[s];
    sheet_line out = job->sheets[s];
    out.number = -1;
    out.lane_at += by * sheet->lane_rate[0];
    out.row_at += by * sheet->row_rate[0];
    return out;
}

/* By how much an interval from a to b rises, the less, the less is seen of it. What lies midpoint
 * is looked at where that is more than the table's `midpoint`. */
CVOL_INLINE cvol_vf find_curvature(cvol_vf a, cvol_vf b, cvol_vf transmittance)
{
    return (cvol_max(a, b) - cvol_min(a, b)) * transmittance;
}

/* Part k of a group midpoint from `a`, at the sheet before, to `b` at sheet s. */
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

/* Lets part k of a group have what lies midpoint through the interval that ends at sheet s, in
 * *middle, where that is looked at. */
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
    i->bent = curvature > job->table->midpoint;
}

/* What the layer's last sheet has midpoint to the next; if not asked for, that it is not known. */
CVOL_COLD void keep_midpoint(const line_job *job, int group, int wanted)
{
    const int last = job->layer->sheet_count - 1;
    wanted &= (int)(job->inside[group - job->first_group] >> last & 1);
    const sheet_line sheet = view_midpoint(job, last, 0.5);
    for (int k = 0; k < PARTS; k++)
        cvol_store(kept_midpoint(job, group) + k * CVOL_LANES,
                   wanted ? reconstruct_there(job, &sheet, group, k, 0) : cvol_splat(NAN));
}

/* The same of a group that did not meet that sheet, as it could see nothing there: levels, where
 * midpoint it can see nothing either; elsewhere what the sheet behind has is as good (infinity). */
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
