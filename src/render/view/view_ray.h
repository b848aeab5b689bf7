/* Rays of a view: where a pixel's begins, and what of it runs through what is drawn. */
#ifndef CVOL_RENDER_VIEW_VIEW_RAY_H
#define CVOL_RENDER_VIEW_VIEW_RAY_H

#include "render/view/camera.h"

/* Place start + t direction, in sample indices, is t of world length along the ray, and drawn where
 * near < t < far. It lies depth + t rise before the plane that depths are told from. */
typedef struct cvol_view_ray {
    double start[3], direction[3];
    double near, far;
    double depth, rise;
} cvol_view_ray;

/* The ray of pixel (i, j). Returns whether any of it is drawn. */
int cvol_view_ray_make(cvol_view_ray *ray, const cvol_view *view, const double spacing[3], int i,
                       int j);

#endif
