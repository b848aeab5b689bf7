/* Directions of light that is scattered once: cvol_illumination.samples. */
#ifndef CVOL_RENDER_LIGHT_DIRECTIONS_H
#define CVOL_RENDER_LIGHT_DIRECTIONS_H

#include "cvol/render.h"
#include "render/view/view.h"

typedef struct cvol_directions {
    double towards[3], across[2][3]; /* of length 1: to the middle of the light, and across */
    int disc, sky;                   /* the number of directions to each */
} cvol_directions;

/* The directions of a picture, from its light and its number of samples. */
cvol_directions cvol_directions_make(const cvol_view *view, const cvol_render_options *options);

/* Direction i of those to the disc, or to the sky. They are evenly spread for any shift, within 0
 * and 1, of the two numbers that choose one. */
void cvol_direction_to_disc(double out[3], const cvol_directions *of, int i, const double shift[2]);
void cvol_direction_to_sky(double out[3], const cvol_directions *of, int i, const double shift[2]);

#endif
