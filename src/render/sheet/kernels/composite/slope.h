/* Slopes within slices: the rise of a slice's reconstructed values from one point before to one
 * behind, along lanes and along rows. In units of the table's coordinates.
 *
 * Reconstruction does not depend on the positions of the points. So the difference of values
 * reconstructed one point apart to either side equals the reconstruction of differences at the
 * samples.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_SLOPE_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_SLOPE_H

#include "render/sheet/kernels/composite/line.h"

typedef struct slope {
    cvol_vf lane, row;
} slope;

/* Part k of a group, if all samples have a value. */
CVOL_INLINE slope find_slope(const line_job *job, const sheet_line *sheet, int group, int k,
                             int unit)
{
    const ptrdiff_t i = group * CVOL_GROUP + k * CVOL_LANES, row = job->layer->row_stride;
    const float *w = sheet->weights;
    slope out;
#if SHEET_EXTRAS
    if (job->layer->wide) {
        const float *at = sheet->view.near;
        out.lane = reconstruct_widely(job, sheet, at + 1, group, k) -
                   reconstruct_widely(job, sheet, at - 1, group, k);
        out.row = reconstruct_widely(job, sheet, at + row, group, k) -
                  reconstruct_widely(job, sheet, at - row, group, k);
        return (slope){out.lane * job->table->scale, out.row * job->table->scale};
    }
#endif
    if (unit) {
        const float *near = sheet->near + i, *far = sheet->far + i;
        const float *above = near - row, *below = far + row;
        const cvol_vf n0 = cvol_load(near), n1 = cvol_load(near + 1);
        const cvol_vf f0 = cvol_load(far), f1 = cvol_load(far + 1);
        out.lane = w[0] * (n1 - cvol_load(near - 1)) + w[1] * (cvol_load(near + 2) - n0) +
                   w[2] * (f1 - cvol_load(far - 1)) + w[3] * (cvol_load(far + 2) - f0);
        out.row = w[0] * (f0 - cvol_load(above)) + w[1] * (f1 - cvol_load(above + 1)) +
                  w[2] * (cvol_load(below) - n0) + w[3] * (cvol_load(below + 1) - n1);
        return out;
    }
    const double step = sheet->lane_step, position = sheet->lane_at + (double)i * step;
    const double whole = floor(position);
    const cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    const cvol_vi index = cvol_to_int(at);
    const cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf lanes[2], rows[2];
    for (int half = 0; half < 2; half++) {
        const float *near = sheet->near + (ptrdiff_t)whole + half * CVOL_LANES;
        const float *far = sheet->far + (ptrdiff_t)whole + half * CVOL_LANES;
        lanes[half] = w[0] * (cvol_load(near + 1) - cvol_load(near - 1)) +
                      w[2] * (cvol_load(far + 1) - cvol_load(far - 1));
        rows[half] = w[0] * (cvol_load(far) - cvol_load(near - row)) +
                     w[2] * (cvol_load(far + row) - cvol_load(near));
    }
    out.lane = cvol_shuffle(lanes[0], lanes[1], index);
    out.lane += fraction * (cvol_shuffle(lanes[0], lanes[1], index + 1) - out.lane);
    out.row = cvol_shuffle(rows[0], rows[1], index);
    out.row += fraction * (cvol_shuffle(rows[0], rows[1], index + 1) - out.row);
    return out;
}

/* Twice the mean of two differences, of samples with these covers. */
CVOL_INLINE cvol_vf weigh_differences(cvol_vf after, cvol_vf before, cvol_vf cover_after,
                                      cvol_vf cover_before)
{
    const cvol_vf both = cover_after + cover_before;
    const cvol_vf mean = 2 * (cover_after * after + cover_before * before) /
                         cvol_max(both, cvol_splat(MIN_WEIGHT));
    return cvol_select(both < MIN_WEIGHT, cvol_splat(0), mean);
}

/* The same if some have none: differences are weighted by their cover. */
CVOL_COLD slope find_slope_masked(const line_job *job, const sheet_line *sheet, int group, int k,
                                  int unit)
{
    const cvol_layer *layer = job->layer;
    const double step = sheet->lane_step;
    const double position = sheet->lane_at + (group * CVOL_GROUP + k * CVOL_LANES) * step;
    const ptrdiff_t x = sheet->footprint.x + group * CVOL_GROUP + k * CVOL_LANES;
    cvol_vf value[5], cover[5]; /* here, lanes after and before, rows after and before */
    for (int n = 0; n < 5; n++) {
        const int lane = n == 1 ? 1 : n == 2 ? -1 : 0, row = n == 3 ? 1 : n == 4 ? -1 : 0;
        line_view view = sheet->view;
        view.near += row * layer->row_stride;
        view.far += row * layer->row_stride;
#if SHEET_EXTRAS
        if (layer->wide)
            value[n] = reconstruct_widely_masked(&cover[n], job, sheet,
                                                 lane + row * layer->row_stride, group, k, unit);
        else
#endif
            value[n] = unit ? reconstruct_unit_masked(&cover[n], &view, &sheet->footprint, x + lane,
                                                      layer->cover_at)
                            : reconstruct_finer_masked(&cover[n], &view, position + lane, step,
                                                       layer->cover_at);
        value[n] *= job->table->scale;
    }
    return (slope){weigh_differences(value[1] - value[0], value[0] - value[2], cover[1], cover[2]),
                   weigh_differences(value[3] - value[0], value[0] - value[4], cover[3], cover[4])};
}

#endif
