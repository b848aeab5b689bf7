/* Light along rays (light.h).
 *
 * The gradient at a place p uses the interpolated volume f; along each axis it is
 *
 *     (f(p + e) - f(p - e)) / 2
 *
 * This equals central differences at the samples, interpolated like the samples. Beyond the faces f
 * is constant. If part of f has no value, the difference to each side is weighted by the cover
 * there: with the covers a+ and a-
 *
 *     (a+ (f(p + e) - f(p)) + a- (f(p) - f(p - e))) / (a+ + a-). */
#include "render/ray/light.h"

#include <math.h>
#include <string.h>

#include "render/view/light.h"

cvol_ray_light cvol_ray_light_make(const cvol_render_options *options, const cvol_view *view,
                                   const cvol_grid *grid, double flat)
{
    cvol_ray_light light = {.shading = options->shading,
                            .fill = options->illumination.fill,
                            .flat = flat,
                            .flats = {flat, flat}};
    const double *given = options->shading.light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    for (int a = 0; a < 3; a++) {
        light.eye[a] = view->eye[a];
        light.shading.light[a] = length > 0 ? given[a] / length : view->eye[a];
        light.rise[a] = view->mean_spacing / grid->spacing[a];
    }
    if (options->mode != CVOL_MODE_ISO && !(options->shading.gradient_opacity > 0)) {
        light.cuts = view->cuts;
        memcpy(light.cut, view->cut, sizeof light.cut);
    }
    return light;
}

static double fade_at(const cvol_ray_light *light, const double place[3])
{
    double depth = 1;
    for (int k = 0; k < light->cuts; k++) {
        const double *cut = light->cut[k];
        depth = fmin(depth, cut[0] * place[0] + cut[1] * place[1] + cut[2] * place[2] + cut[3]);
    }
    return light->cuts ? cvol_cut_fade(depth) : 1;
}

/* Along one axis, in samples. *reach: how much it changes at most if every sample changes by 1. */
static double difference(double *reach, const cvol_ray_reader *reader, const double place[3],
                         int axis, double value)
{
    const double start[3] = {place[0] - (axis == 0), place[1] - (axis == 1),
                             place[2] - (axis == 2)};
    const double delta[3] = {2 * (axis == 0), 2 * (axis == 1), 2 * (axis == 2)};
    double f[2], cover[2];
    *reach = 1;
    if (!reader->field->mask) {
        reader->line(f, reader->field, start, delta, 2);
        return (f[1] - f[0]) / 2;
    }
    reader->masked(f, cover, reader->field, start, delta, 2);
    const double both = cover[0] + cover[1];
    if (!(both > 0))
        return 0;
    *reach = 1 + fabs(cover[1] - cover[0]) / both;
    return (cover[1] * (f[1] - value) + cover[0] * (value - f[0])) / both;
}

void cvol_ray_gradient(double gradient[3], double reach[3], const cvol_ray_light *light,
                       const cvol_ray_reader *reader, const double place[3], double value)
{
    const double fade = fade_at(light, place);
    for (int a = 0; a < 3; a++) {
        gradient[a] = fade * light->rise[a] * difference(&reach[a], reader, place, a, value);
        reach[a] *= fade * light->rise[a];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

cvol_ray_lit cvol_ray_light_at(const cvol_ray_light *light, const cvol_ray_reader *reader,
                               const double place[3], double value)
{
    const cvol_shading *shading = &light->shading;
    double n[3], reach[3];
    cvol_ray_gradient(n, reach, light, reader, place, value);
    const double steepness = sqrt(dot(n, n));
    for (int a = 0; a < 3; a++)
        n[a] = steepness > 0 ? n[a] / steepness : light->eye[a];
    const double square = steepness * steepness, flat = light->flat * light->flat;
    const double facing = dot(shading->light, light->eye),
                 flatness = flat > 0 ? flat / (square + flat) : 0;
    const double to_eye = dot(n, light->eye);
    const double lit = cvol_light_turn(dot(n, shading->light), to_eye, facing) * (1 - flatness) +
                       facing * flatness;
    const double seen = fabs(to_eye) * (1 - flatness) + flatness;
    const double along = 2 * lit * seen - facing;
    const double gloss = lit > 0 ? shading->specular * pow(fmax(along, 0), shading->shininess) : 0;
    const double reaching = light->factor_at ? light->factor_at(light->source, place) : 1;
    const double factor = shading->ambient + shading->diffuse * fmax(lit, 0) + light->fill * seen;
    return (cvol_ray_lit){.factor = reaching * factor,
                          .gloss = reaching * gloss,
                          .density = shading->gradient_opacity > 0
                                         ? fmin(steepness / shading->gradient_opacity, 1)
                                         : 1};
}
