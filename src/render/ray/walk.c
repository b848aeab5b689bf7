/* Paths of rays and their intervals (walk.h). */
#include "render/ray/walk.h"

#include <math.h>

#include "render/view/view_ray.h"

int cvol_ray_path_make(cvol_ray_path *path, const cvol_ray_job *job, int i, int j)
{
    cvol_view_ray ray;
    if (!cvol_view_ray_make(&ray, job->view, job->state->grid.spacing, i, j))
        return 0;
    const double count = (ray.far - ray.near) / job->step;
    if (!(count > 0))
        return 0;
    for (int a = 0; a < 3; a++) {
        path->entry[a] = ray.start[a] + ray.near * ray.direction[a];
        path->delta[a] = ray.direction[a] * job->step;
    }
    path->steps = (size_t)(ceil(count) - 1);
    path->rest = count - (double)path->steps;
    path->depth = ray.depth + ray.near * ray.rise;
    path->rise = job->step * ray.rise;
    return 1;
}

void cvol_ray_fetch(double *out, double *cover, const cvol_ray_job *job, const cvol_ray_path *path,
                    double place, size_t count)
{
    const cvol_ray_state *state = job->state;
    double start[3];
    for (int a = 0; a < 3; a++)
        start[a] = path->entry[a] + place * path->delta[a];
    if (state->field.mask) {
        state->masked(out, cover, &state->field, start, path->delta, count);
        return;
    }
    state->line(out, &state->field, start, path->delta, count);
    for (size_t k = 0; k < count; k++)
        cover[k] = 1;
}

cvol_ray_point cvol_ray_halfway(const cvol_ray_job *job, const cvol_ray_point s[4])
{
    const double a = s[1].value, b = s[2].value, cover = fmin(s[1].cover, s[2].cover);
    if (!(s[0].cover > 0 && s[3].cover > 0))
        return cvol_ray_between(job, &s[1], &s[2], 0.5);
    const double cubic = (9 * (a + b) - (s[0].value + s[3].value)) / 16;
    return cvol_ray_point_make(job, fmin(fmax(cubic, fmin(a, b)), fmax(a, b)), cover);
}

/* An end without a value has that of the middle. */
static cvol_ray_point end_of(cvol_ray_point end, const cvol_ray_point *middle)
{
    return end.cover > 0 ? end : *middle;
}

void cvol_ray_step_ends(cvol_ray_point ends[2], const cvol_ray_job *job, const cvol_ray_step *step)
{
    const cvol_ray_point *s = step->s;
    ends[0] = end_of(step->front ? *step->front : cvol_ray_halfway(job, s), &s[2]);
    ends[1] = end_of(step->back ? *step->back : cvol_ray_halfway(job, s + 1), &s[2]);
}
