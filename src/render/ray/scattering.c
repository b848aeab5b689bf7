/* Rays of light (scattering.h). Every place shifts the directions by numbers of its own, so that
 * the error of few directions is noise and not a pattern. */
#include "render/ray/scattering.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "render/view/view_ray.h"

/* Samples that are fetched together. */
#define RUN 16
/* What passes less light is opaque. */
#define DARK 1e-3

int cvol_ray_scattering_make(cvol_context *context, cvol_ray_scattering *out,
                             const cvol_ray_job *job, const cvol_render_options *options,
                             double cell)
{
    const cvol_illumination *light = &options->illumination;
    const cvol_ray_field *field = &job->state->field;
    const double diffuse = options->shading.diffuse,
                 all = diffuse + options->shading.ambient + light->fill,
                 direct = all > 0 ? diffuse / all : 0;
    memset(out, 0, sizeof *out);
    out->job = job;
    out->directions = cvol_directions_make(job->view, options);
    out->from_sky = (1 - direct) * light->occlusion;
    out->from_disc = direct * light->shadows;
    out->start = cell;
    if (job->mode == CVOL_MODE_ISO)
        return CVOL_OK;
    return cvol_ray_table_make(context, &out->table, job->state->transfer, field->min, field->max,
                               1);
}

void cvol_ray_scattering_free(cvol_ray_scattering *scattering)
{
    cvol_ray_table_free(&scattering->table);
}

/* The share of light that a sample lets through. */
static double pass(const cvol_ray_scattering *of, double value, double cover)
{
    if (!(cover > 0))
        return 1;
    if (of->job->mode == CVOL_MODE_ISO)
        return value >= of->job->surface->value ? 0 : 1;
    double sample[4];
    cvol_ray_table_at(sample, &of->table, value);
    return 1 - cover * sample[3];
}

/* The transmittance from a place towards a direction. */
static double find_transmittance(const cvol_ray_scattering *of, const double place[3],
                                 const double way[3])
{
    const cvol_ray_state *state = of->job->state;
    const double spacing = of->job->view->mean_spacing;
    double direction[3], delta[3], near = of->start, far = INFINITY, through = 1;
    double values[RUN], covers[RUN];
    for (int a = 0; a < 3; a++) {
        direction[a] = way[a] / state->grid.spacing[a];
        delta[a] = direction[a] * spacing;
    }
    cvol_view_cut(&near, &far, of->job->view, place, direction);
    if (!(far > near))
        return 1;
    const size_t count = (size_t)((far - near) / spacing + 0.5);
    for (size_t first = 0; first < count && through > DARK; first += RUN) {
        const size_t left = count - first, run = left < RUN ? left : RUN;
        double start[3];
        for (int a = 0; a < 3; a++)
            start[a] = place[a] + near * direction[a] + ((double)first + 0.5) * delta[a];
        if (state->field.mask)
            state->masked(values, covers, &state->field, start, delta, run);
        else
            state->line(values, &state->field, start, delta, run);
        for (size_t k = 0; k < run; k++)
            through *= pass(of, values[k], state->field.mask ? covers[k] : 1);
    }
    return through;
}

/* A number within 0 and 1 that depends on all bits of the state (Steele, Lea and Flood, "Fast
 * splittable pseudorandom number generators", 2014). */
static double next_number(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static uint64_t seed_of(const double place[3])
{
    uint64_t bits[3], seed = 0;
    memcpy(bits, place, sizeof bits);
    for (int a = 0; a < 3; a++)
        seed = (seed ^ bits[a]) * 0x9e3779b97f4a7c15;
    return seed;
}

double cvol_ray_scattering_at(const void *source, const double place[3])
{
    const cvol_ray_scattering *scattering = source;
    const cvol_directions *directions = &scattering->directions;
    uint64_t random = seed_of(place);
    double factor = 1 - scattering->from_sky - scattering->from_disc, way[3];
    for (int is_sky = 0; is_sky < 2; is_sky++) {
        const double share = is_sky ? scattering->from_sky : scattering->from_disc;
        const int count = is_sky ? directions->sky : directions->disc;
        const double first = next_number(&random), shift[2] = {first, next_number(&random)};
        double sum = 0;
        for (int i = 0; i < count && share > 0; i++) {
            (is_sky ? cvol_direction_to_sky : cvol_direction_to_disc)(way, directions, i, shift);
            sum += find_transmittance(scattering, place, way);
        }
        factor += share * sum / count;
    }
    return factor;
}
