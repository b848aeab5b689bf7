/* The lattice of a view: slices behind each other, sheared, before the warp to the picture
 * (Lacroute and Levoy 1994).
 *
 * Sample (i, j) of slice k lies at
 *
 *     base[0] + i + k shear[0],   base[1] + j + k shear[1]
 *
 * in samples; place (p, q) of the lattice at (p step, q step). Footprints are round here, in the
 * plane of the slices: functions of one coordinate each, h(qx) h(qy). */
#ifndef CVOL_RENDER_SPLAT_OBJECT_ORDER_H
#define CVOL_RENDER_SPLAT_OBJECT_ORDER_H

#include "render/splat/frame.h"

typedef struct cvol_intermediate_grid {
    size_t dims[2]; /* places: for all slices with their footprints, and a free margin */
    double base[2], shear[2];
    double step;
    size_t reach; /* the most samples around a slice that its footprints reach */
} cvol_intermediate_grid;

/* The footprint of these options, round in the plane of slices: ux = uy = 1. */
cvol_footprint_shape cvol_intermediate_grid_shape(const cvol_splat_options *splat);
/* The coarsest step that resolves slices under this footprint: 1, 2 or 4. Half a Gaussian of 2.2
 * places, sampled at every other place, loses less than 1/1000. */
double cvol_intermediate_grid_step(const cvol_footprint_shape *shape);
/* The same, stretched: a coarser lattice resolves it, and pictures are softer, as if they had fewer
 * samples. */
cvol_footprint_shape cvol_intermediate_grid_stretch(const cvol_footprint_shape *shape,
                                                    double factor);
/* The lattice of a plan. Its lengths are even and have fast transforms. */
cvol_intermediate_grid cvol_intermediate_grid_make(const cvol_splat_plan *plan,
                                                   const cvol_footprint_shape *shape, double step);
int cvol_intermediate_grid_same(const cvol_intermediate_grid *a, const cvol_intermediate_grid *b);

/* The position of slice k along an axis: sample i adds weights[q - low] at i + place + q, in
 * samples, for q = low .. high; that is a place if the step divides it. Weights sum to 1. */
#define CVOL_INTERMEDIATE_TAPS_MAX 256
typedef struct cvol_intermediate_line {
    ptrdiff_t place;
    int low, high;
    double weights[CVOL_INTERMEDIATE_TAPS_MAX];
} cvol_intermediate_line;
cvol_intermediate_line cvol_intermediate_line_make(const cvol_intermediate_grid *image_grid,
                                                   const cvol_footprint_shape *shape, int axis,
                                                   size_t k);
/* Bounds the L2 norm of a slice's contribution to places, relative to the slice. */
double cvol_intermediate_grid_norm(const cvol_intermediate_grid *image_grid,
                                   const cvol_footprint_shape *shape);

/* The place of pixel (x, y): out[a][0] x + out[a][1] y + out[a][2]. plan: the view's, whose slice 0
 * begins at lattice->base. */
void cvol_intermediate_grid_matrix(double out[2][3], const cvol_intermediate_grid *image_grid,
                                   const cvol_splat_plan *plan);

/* From the lattice to the picture by cubic splines (Unser, Aldroubi and Eden 1993): it overwrites
 * `pixels`: colour, premultiplied, and opacity, four floats per place. Errors: MEMORY. */
int cvol_intermediate_grid_warp(cvol_context *context, cvol_image *image, float *pixels,
                                const cvol_intermediate_grid *image_grid,
                                const cvol_splat_plan *plan, const double background[3]);

#endif
