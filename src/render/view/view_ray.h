/* Rays of a view: the start of a pixel's ray, and its part within the drawn box. */
#ifndef CVOL_RENDER_VIEW_VIEW_RAY_H
#define CVOL_RENDER_VIEW_VIEW_RAY_H

#include "render/view/view.h"

/* Place start + t direction, in sample indices, is at world length t along the ray, and drawn for
 * near < t < far. It lies depth + t rise before the plane of depth 0. */
typedef struct cvol_view_ray {
    double start[3], direction[3];
    double near, far;
    double depth, rise;
} cvol_view_ray;

/* The ray of pixel (i, j). Returns 1 if any of it is drawn. */
int cvol_view_ray_make(cvol_view_ray *ray, const cvol_view *view, const double spacing[3], int i,
                       int j);

/* Cuts near..far to the part of a line, start + t direction in sample indices, that is drawn. */
void cvol_view_cut(double *near, double *far, const cvol_view *view, const double start[3],
                   const double direction[3]);

#endif
