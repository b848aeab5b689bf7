/* Checks of the options of light and surfaces; the light of a frame. */
#include "render/view/shading.h"

#include <math.h>
#include <string.h>

#include "base/context.h"

#define FLAT_SAMPLES 512
#define FLAT_STEPS 2048

static int check_surface(cvol_context *context, const cvol_surface *surface)
{
    if (!isfinite(surface->value))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the surface's value %g: must be finite",
                         surface->value);
    for (int c = 0; c < 3; c++)
        if (!(surface->colour[c] >= 0 && surface->colour[c] <= 1))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "the surface's colour: %s is %g, must be within 0 and 1",
                             (const char *[]){"red", "green", "blue"}[c], surface->colour[c]);
    return CVOL_OK;
}

static int check_illumination(cvol_context *context, const cvol_illumination *light)
{
    const struct {
        const char *name;
        double value, most;
    } numbers[] = {
        {"fill", light->fill, 10},
        {"occlusion", light->occlusion, 1},
        {"shadows", light->shadows, 1},
    };
    for (int k = 0; k < 3; k++)
        if (!(numbers[k].value >= 0 && numbers[k].value <= numbers[k].most))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s is %g, must be 0 to %g",
                             numbers[k].name, numbers[k].value, numbers[k].most);
    if (light->samples && (light->samples < 2 || light->samples > CVOL_LIGHT_SAMPLES_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "samples is %d, must be 0 or 2 to %d",
                         light->samples, CVOL_LIGHT_SAMPLES_MAX);
    return CVOL_OK;
}

int cvol_shading_check(cvol_context *context, const cvol_render_options *options)
{
    const cvol_shading *shading = &options->shading;
    const struct {
        const char *name;
        double share;
    } shares[] = {{"ambient", shading->ambient},
                  {"diffuse", shading->diffuse},
                  {"specular", shading->specular}};
    if (!shading->on && options->mode != CVOL_MODE_ISO)
        return CVOL_OK;
    for (int a = 0; a < 3; a++)
        if (!(fabs(shading->light[a]) <= 1e30))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "light: %c is %g, must be a number of at most 1e30", "xyz"[a],
                             shading -> light[a]);
    for (int k = 0; k < 3; k++)
        if (!(shares[k].share >= 0 && shares[k].share <= 10))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s is %g, must be 0 to 10",
                             shares[k].name, shares[k].share);
    if (shading->shininess < 1 || shading->shininess > 256)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "shininess is %d, must be 1 to 256",
                         shading->shininess);
    if (!(shading->gradient_opacity >= 0 && shading->gradient_opacity <= 1e30))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "gradient opacity is %g, must be 0 (off) to 1e30",
                         shading->gradient_opacity);
    const int code = check_illumination(context, &options->illumination);
    if (code)
        return code;
    return options->mode == CVOL_MODE_ISO ? check_surface(context, &options->surface) : CVOL_OK;
}

void cvol_shading_place(cvol_render_options *options, const cvol_view *view)
{
    double *light = options->shading.light;
    if (!options->illumination.in_view)
        return;
    const double right = options->illumination.in_view < 0 ? -light[0] : light[0];
    const double given[3] = {right, light[1], light[2]};
    for (int a = 0; a < 3; a++)
        light[a] = given[0] * view->right[a] + given[1] * view->up[a] + given[2] * view->eye[a];
    options->illumination.in_view = 0;
}

double cvol_flat_gradient(double width, double range)
{
    return fmax(width / FLAT_SAMPLES, range > 0 ? range / FLAT_STEPS : 0);
}

/* The unit of gradients: the power of two below the range, so that it rounds nothing. */
static double unit_of(double range)
{
    return range > 0 && isfinite(range) ? exp2(fmin(fmax(floor(log2(range)), -120), 120)) : 1;
}

void cvol_light_set(cvol_light *light, const cvol_view *view, const cvol_grid *grid,
                    const cvol_shading *shading, double fill, cvol_light_values values,
                    const int axes[3], const int turns[3])
{
    const double unit = unit_of(values.range), flat = values.flat / unit;
    const double *given = shading->light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    double facing = 0;
    memset(light, 0, sizeof *light); /* lights are compared by their bytes */
    light->on = shading->on;
    if (!shading->on)
        return;
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        const double towards = length > 0 ? given[a] / length : view->eye[a];
        light->eye[k] = (float)(turns[k] * view->eye[a]);
        light->light[k] = (float)(turns[k] * towards);
        light->rise[k] = (float)(0.5 * view->mean_spacing / grid->spacing[a]) / (float)unit;
        facing += view->eye[a] * towards;
    }
    light->facing_light = (float)facing;
    light->ambient = (float)shading->ambient;
    light->diffuse = (float)shading->diffuse;
    light->specular = (float)shading->specular;
    light->fill = (float)fill;
    light->shininess = shading->shininess;
    light->flat = (float)(flat * flat);
    light->thinning = shading->gradient_opacity > 0 ? (float)(unit / shading->gradient_opacity) : 0;
}
