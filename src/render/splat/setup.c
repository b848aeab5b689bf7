/* The set-up that engines splat and transform share. */
#include "render/splat/setup.h"

#include <stdlib.h>

#include "base/context.h"
#include "render/view/shading.h"

#define FOOTPRINT_MAX 31

int cvol_splat_state_create(cvol_context *context, void **out, size_t bytes,
                            const cvol_array *array, const cvol_volume *volume)
{
    *out = NULL;
    void *state = calloc(1, bytes);
    if (!state)
        return cvol_fail_memory(context, bytes, "a renderer");
    const int code = cvol_splat_input_make(context, state, array, volume);
    if (code)
        free(state);
    else
        *out = state;
    return code;
}

int cvol_splat_options_check(cvol_context *context, const cvol_splat_options *splat)
{
    if (splat->footprint < CVOL_FOOTPRINT_GAUSSIAN || splat->footprint > CVOL_FOOTPRINT_BOX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a footprint",
                         (int)splat->footprint);
    if (splat->size < 3 || splat->size > FOOTPRINT_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "footprint size %d: must be 3 to %d samples",
                         splat->size, FOOTPRINT_MAX);
    if (splat->sigma != 0 && !(splat->sigma >= 0.2 && splat->sigma <= FOOTPRINT_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "sigma %g: must be 0 (size / 6), or 0.2 to %d samples", splat->sigma,
                         FOOTPRINT_MAX);
    if (splat->plane != CVOL_FOOTPRINT_IN_VIEW && splat->plane != CVOL_FOOTPRINT_IN_SLICES)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a plane of footprints",
                         (int)splat->plane);
    if (splat->order != CVOL_ORDER_FRONT && splat->order != CVOL_ORDER_BACK)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not an order of compositing",
                         (int)splat->order);
    return CVOL_OK;
}

void cvol_splat_setup_make(cvol_splat_setup *out, const cvol_splat_input *input,
                           const cvol_view *view, const cvol_shading *shading, int front)
{
    cvol_splat_plan_make(&out->plan, &input->grid, view);
    out->front = front;
    out->ascending = out->plan.rising == front;
    const double range = input->source.max - input->source.min,
                 flat = cvol_flat_gradient(cvol_transfer_width(input->transfer), range);
    cvol_splat_light_set(&out->light, &out->plan, &input->grid, view, shading,
                         (cvol_light_values){flat, range}, out->ascending);
}

int cvol_splat_setup_picture(cvol_context *context, cvol_splat_setup *out,
                             const cvol_splat_input *input, const cvol_view *view,
                             const cvol_render_options *options, const char *engine)
{
    if (options->mode != CVOL_MODE_COMPOSITE)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the %s engine has mode composite only",
                         engine);
    const int code = cvol_splat_options_check(context, &options->splat);
    if (!code)
        cvol_splat_setup_make(out, input, view, &options->shading,
                              options->splat.order == CVOL_ORDER_FRONT);
    return code;
}
