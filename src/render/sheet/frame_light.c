/* The light of a frame (frame_light.h). */
#include "render/sheet/frame_light.h"

#include "render/view/shading.h"

/* The midpoint sample is the mean of two slices. Each is sampled where the ray meets it, so the
 * error grows with the ray's movement. In perspective rays may move by any amount. */
static void set_shear_correction(cvol_sheet_table *table, const cvol_sheet_plan *plan,
                                 const cvol_light *light)
{
    const double way = plan->perspective ? 0 : plan->ascending ? 1 : -1;
    const double moves[2] = {way * plan->shear_lane * plan->pitch_sheet / plan->pitch_lane,
                             way * plan->shear_row * plan->pitch_sheet / plan->pitch_row};
    for (int k = 0; k < 2; k++)
        table->shear_correction[k] = table->interpolates_gradients && light->rise[k] > 0
                                         ? (float)(moves[k] / 8) / light->rise[k]
                                         : 0;
}

/* Slices count in the order of rays. */
static void set_factors(cvol_light *out, const cvol_sheet_plan *plan, const cvol_reach *reach)
{
    const cvol_coarse *coarse = &reach->coarse;
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_sheet};
    const double pitches[3] = {plan->pitch_lane, plan->pitch_row,
                               plan->ascending ? plan->pitch_sheet : -plan->pitch_sheet},
                 firsts[3] = {plan->first_lane, plan->first_row,
                              cvol_sheet_place(plan, plan->ascending ? 0 : plan->sheet_count - 1)};
    const ptrdiff_t strides[3] = {1, (ptrdiff_t)coarse->dims[0],
                                  (ptrdiff_t)(coarse->dims[0] * coarse->dims[1])};
    out->factors = reach->factors;
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        out->scale[k] = (float)(pitches[k] / coarse->pitch[a]);
        out->offset[k] = (float)((firsts[k] - coarse->first[a]) / coarse->pitch[a]);
        out->cells[k] = (int)coarse->dims[a];
        out->stride[k] = strides[a];
    }
}

/* Along an axis of one sample nothing changes. */
void cvol_frame_light_set(cvol_light *out, cvol_sheet_table *table, const cvol_grid *grid,
                          const cvol_sheet_plan *plan, const cvol_view *view,
                          const cvol_render_options *options, cvol_light_values values,
                          const cvol_reach *reach)
{
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_sheet};
    const int way = plan->ascending ? 1 : -1, ways[3] = {1, 1, way};
    const size_t samples[3] = {plan->lanes, plan->rows, plan->sheets};
    const double pitches[3] = {plan->pitch_lane, plan->pitch_row, plan->pitch_sheet};
    const double exposure = reach ? reach->exposure : 1;
    cvol_shading lit = options->shading;
    lit.on = 1;
    lit.ambient *= exposure;
    lit.diffuse *= exposure;
    lit.specular *= exposure;
    cvol_light_set(out, view, grid, &lit, exposure * options->illumination.fill, values, axes,
                   ways);
    for (int k = 0; k < 3; k++)
        out->rise[k] *= samples[k] > 1 ? (float)(1 / pitches[k]) / table->scale : 0;
    set_shear_correction(table, plan, out);
    if (reach)
        set_factors(out, plan, reach);
}
