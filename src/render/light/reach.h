/* The light that reaches places within a volume: what occlusion and shadows leave of it. */
#ifndef CVOL_RENDER_LIGHT_REACH_H
#define CVOL_RENDER_LIGHT_REACH_H

#include "cvol/render.h"
#include "render/light/coarse.h"
#include "render/transfer/transfer.h"
#include "render/view/view.h"

/* On what the factors and the exposure of a picture depend, in addition to the volume, the transfer
 * function and the clip. */
typedef struct cvol_reach_cause {
    double eye[3], light[3], colour[3], ambient, diffuse, specular, gradient_opacity;
    double fill, occlusion, shadows;
    int shininess, keeps_brightness, samples, all_known; /* all_known: 1 */
} cvol_reach_cause;

/* The factors of light of a picture, and the data from which they follow, which further pictures
 * reuse; all zero is an empty one. */
typedef struct cvol_reach {
    cvol_coarse coarse; /* the volume; the owner makes it */
    /* Under the transfer function, the clip and the surface of the last picture: */
    float *extinction, *ambient; /* ambient: the share of directions from which light comes */
    float *weights, *scales;     /* of cells in a mean of factors, and 1 by the means of weights */
    int is_known, has_cones, has_weights;
    cvol_mode mode;
    cvol_clip clip;
    double surface;
    /* Of the last picture: the factor of light in each cell, 1 where nothing is in the way, and the
     * exposure, by which the light is multiplied to keep the brightness. */
    float *factors;
    double exposure;
    cvol_reach_cause cause; /* of these two; all_known 0: they are not known */
} cvol_reach;

/* Returns 1 if a picture needs factors of light or an exposure. */
int cvol_reach_suits(const cvol_render_options *options);
/* Adds the faces of the volume that show matter to the cuts of a view: as a face of the clip, such
 * a face would be lit by the noise of the matter. `transfer`: NULL in mode iso. Errors: MEMORY. */
int cvol_reach_find_cuts(cvol_context *context, cvol_reach *reach, cvol_view *view,
                         const cvol_grid *grid, const cvol_transfer *transfer,
                         const cvol_render_options *options);
/* Finds factors and exposure of a picture. `transfer`: NULL in mode iso. Errors: MEMORY. */
int cvol_reach_find(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                    const cvol_transfer *transfer, const cvol_view *view,
                    const cvol_render_options *options);
/* The transfer function has changed. */
void cvol_reach_forget(cvol_reach *reach);
void cvol_reach_free(cvol_reach *reach);

/* The factor at a place, in samples: linear between the middles of cells, constant outside. */
double cvol_reach_at(const cvol_reach *reach, const double place[3]);

#endif
