/* Rays of a view (view_ray.h). */
#include "render/view/view_ray.h"

#include <math.h>

/* Cuts the range near..far of a ray to the part in which `value`, which grows by `rate` along it,
 * is at least 0. */
static void cut(double *near, double *far, double value, double rate)
{
    if (rate > 0)
        *near = fmax(*near, -value / rate);
    else if (rate < 0)
        *far = fmin(*far, -value / rate);
    else if (value < 0)
        *far = -INFINITY;
}

/* The start of the ray of pixel (i, j), and its direction, of length 1, in the world. */
static void find_ray(double p[3], double direction[3], const cvol_view *view, int i, int j)
{
    const double along = (i + 0.5 - view->width / 2.0) * view->pixel;
    const double above = (view->all_rows / 2.0 - view->first_row - j - 0.5) * view->pixel;
    double length = 0;
    for (int a = 0; a < 3; a++) {
        p[a] = view->centre[a] + along * view->right[a] + above * view->up[a];
        direction[a] = view->perspective ? p[a] - view->place[a] : -view->eye[a];
        length = hypot(length, direction[a]);
    }
    for (int a = 0; a < 3 && view->perspective; a++) {
        direction[a] /= length;
        p[a] = view->place[a];
    }
}

void cvol_view_cut(double *near, double *far, const cvol_view *view, const double start[3],
                   const double direction[3])
{
    for (int a = 0; a < 3; a++) {
        cut(near, far, start[a] - view->own_lo[a], direction[a]);
        cut(near, far, view->own_hi[a] - start[a], -direction[a]);
    }
    for (int k = 0; k < view->planes; k++) {
        const double *n = view->plane[k];
        cut(near, far, n[0] * start[0] + n[1] * start[1] + n[2] * start[2] + n[3],
            n[0] * direction[0] + n[1] * direction[1] + n[2] * direction[2]);
    }
}

int cvol_view_ray_make(cvol_view_ray *ray, const cvol_view *view, const double spacing[3], int i,
                       int j)
{
    double *p = ray->start, *direction = ray->direction;
    find_ray(p, direction, view, i, j);
    ray->near = view->perspective ? 0 : -INFINITY;
    ray->far = INFINITY;
    ray->depth = view->perspective ? 0 : view->ahead;
    ray->rise = 0;
    for (int a = 0; a < 3; a++) {
        ray->rise -= direction[a] * view->eye[a];
        p[a] /= spacing[a];
        direction[a] /= spacing[a];
    }
    cvol_view_cut(&ray->near, &ray->far, view, p, direction);
    return ray->far > ray->near;
}
