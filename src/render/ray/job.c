/* The data of a picture that all its rays share (job.h). */
#include "render/ray/job.h"

#include "render/view/shading.h"

cvol_ray_job cvol_ray_job_make(const cvol_ray_state *state, cvol_ray_light *light,
                               const cvol_view *view, const cvol_render_options *options)
{
    const double step = options->step_voxels > 0 ? options->step_voxels : CVOL_RAY_DEFAULT_STEP;
    cvol_ray_job job = {.state = state,
                        .view = view,
                        .mode = options->mode,
                        .step = step * view->mean_spacing,
                        .table = {.step = step},
                        .surface = &options->surface};
    cvol_window_of_cuts(job.cuts, options, state->field.min, state->field.max);
    for (int c = 0; c < 3; c++)
        job.background[c] = options->background[c];
    const double flat = job.mode == CVOL_MODE_ISO
                            ? 0
                            : cvol_flat_gradient(cvol_transfer_width(state->transfer),
                                                 state->field.max - state->field.min);
    *light = cvol_ray_light_make(options, view, &state->grid, flat);
    if (options->shading.on || job.mode == CVOL_MODE_ISO)
        job.light = light;
    return job;
}
