/* Factors of light at a group's pixels (cvol_light.factors).
 *
 * Factors are found where rays of every fourth pixel meet slices, and are linear in between: over
 * squares of 4 x 4 pixels in image order, which are the same for every instruction set, else over
 * four pixels of a line.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_REACH_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_REACH_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/line.h"
#include "render/view/light.h"

/* The factor at a place of lanes, rows and slices. */
static __attribute__((noinline)) float sample_reach(const cvol_light *light, float lane, float row,
                                                    float slice)
{
    const float place[3] = {lane, row, slice}, *from = light->factors;
    float part[3];
    ptrdiff_t next[3];
    for (int k = 0; k < 3; k++) {
        const float last = (float)(light->cells[k] - 1);
        float at = place[k] * light->scale[k] + light->offset[k];
        at = at > 0 ? at < last ? at : last : 0;
        const int cell = (int)at;
        part[k] = at - (float)cell;
        from += cell * light->stride[k];
        next[k] = cell + 1 < light->cells[k] ? light->stride[k] : 0;
    }
    /* Along slices, then along rows or lanes. */
    const float *far = from + next[2];
    float edge[2][2];
    for (int l = 0; l < 2; l++)
        for (int r = 0; r < 2; r++) {
            const ptrdiff_t corner = l * next[0] + r * next[1];
            edge[l][r] = from[corner] + part[2] * (far[corner] - from[corner]);
        }
    const float left = edge[0][0] + part[1] * (edge[0][1] - edge[0][0]),
                right = edge[1][0] + part[1] * (edge[1][1] - edge[1][0]);
    return left + part[0] * (right - left);
}

/* Pixels between two places whose factors are looked up. */
#define REACH_STEP 4

/* The factors of CVOL_LANES pixels from pixel i on, at slice s of the layer. A negative s counts
 * back from the layer's first slice. Without factors: 1. */
#if SHEET_IMAGE_ORDER
CVOL_INLINE cvol_vf reach_of_pixels(const line_job *job, int s, int i)
{
    if (!job->table->light->factors)
        return cvol_splat(1);
    const cvol_sheet_view *view = &job->layer->sheets[s < 0 ? 0 : s];
    const double by = s < 0 ? s : 0;
    const ptrdiff_t first_column = column_of(i), line = job->line->number + line_of(i),
                    first_line = line - line % REACH_STEP;
    float corners[2][2]; /* [line][column] */
    for (int k = 0; k < 4; k++) {
        const double x = (double)(first_column + REACH_STEP * (k & 1)),
                     y = (double)(first_line + REACH_STEP * (k >> 1));
        corners[k >> 1][k & 1] = sample_reach(job->table->light,
                                              (float)(view->lane_at + x * view->lane_step +
                                                      y * view->lane_down +
                                                      by * view->lane_rate[0]),
                                              (float)(view->row_at + x * view->row_right +
                                                      y * view->row_step + by * view->row_rate[0]),
                                              (float)(view->ordinal + by));
    }
    const float each = 1.0f / REACH_STEP;
    const cvol_vf across = spread_pixels(each, 0),
                  down = (float)(line - first_line) * each + spread_pixels(0, each);
    const cvol_vf above = corners[0][0] + across * (corners[0][1] - corners[0][0]),
                  below = corners[1][0] + across * (corners[1][1] - corners[1][0]);
    return above + down * (below - above);
}
#else
CVOL_INLINE cvol_vf reach_of_pixels(const line_job *job, int s, int i)
{
    if (!job->table->light->factors)
        return cvol_splat(1);
    const cvol_sheet_view *view = &job->layer->sheets[s < 0 ? 0 : s];
    const double by = s < 0 ? s : 0, j = job->line->number;
    const double step = view->lane_step + by * view->lane_rate[1];
    const double lane = view->lane_at + by * view->lane_rate[0] + i * step,
                 row = view->row_at + j * view->row_step +
                       by * (view->row_rate[0] + j * view->row_rate[1]);
    const float slice = (float)(view->ordinal + by);
    float factors[CVOL_LANES];
    float from = sample_reach(job->table->light, (float)lane, (float)row, slice);
    for (int k = 0; k < CVOL_LANES; k += REACH_STEP) {
        const float to = sample_reach(job->table->light, (float)(lane + (k + REACH_STEP) * step),
                                      (float)row, slice);
        for (int n = 0; n < REACH_STEP; n++)
            factors[k + n] = from + (float)n / REACH_STEP * (to - from);
        from = to;
    }
    return cvol_load(factors);
}
#endif

/* cvol_cut_fade, `s` slices from the layer's first one, for CVOL_LANES pixels from pixel i on. */
CVOL_COLD cvol_vf fade_of_pixels(const line_job *job, double s, int i)
{
    const cvol_layer *layer = job->layer;
    const int column = column_of(i), j = job->line->number + line_of(i);
    cvol_vf depth = cvol_splat(1);
    for (int k = 0; k < layer->fades; k++) {
        const cvol_sheet_linear *fade = &layer->fade[k];
        double at[3];
        for (int d = 0; d < 3; d++)
            at[d] = fade->value[d] + s * fade->rate[d];
        const cvol_vf value = (float)(at[0] + column * at[1] + j * at[2]) +
                              spread_pixels((float)at[1], (float)at[2]);
        depth = cvol_min(depth, value);
    }
    return cvol_max(depth, cvol_splat(0.01f));
}

CVOL_INLINE void fade_gradient(cvol_vf gradient[3], const line_job *job, double s, int i)
{
    if (!job->layer->fades)
        return;
    const cvol_vf fade = fade_of_pixels(job, s, i);
    for (int k = 0; k < 3; k++)
        gradient[k] *= fade;
}

#endif
