/* Light of a frame: the inputs of Phong's model (cvol_shading) from a view, and what reaches places
 * of the volume. */
#ifndef CVOL_RENDER_VIEW_LIGHT_H
#define CVOL_RENDER_VIEW_LIGHT_H

#include <math.h>
#include <stddef.h>

/* The cosine of a normal and the eye below which the light of both sides mixes. */
#define CVOL_EDGE_ON 0.0625

/* Directions are in the world, along three axes of the volume in the caller's order: towards the
 * eye, and towards the light. */
typedef struct cvol_light {
    int on;
    float eye[3], light[3];
    float rise[3];      /* a difference of samples two apart times this is the gradient; its unit is
                           near the range of the samples, so that its square is a float */
    float facing_light; /* eye light */
    float ambient, diffuse, specular, fill;
    int shininess;
    float flat;     /* the square of the gradient of cvol_flat_gradient, in this unit */
    float thinning; /* 1 / gradient_opacity, likewise; 0: none */
    /* Factors of light in cells of the volume (cvol_illumination), along the same axes: cell i j k
     * is factors[i stride[0] + j stride[1] + k stride[2]], and its middle lies at the sample or
     * slice from which scale and offset lead to i, j or k. NULL: all factors are 1. */
    const float *factors;
    float scale[3], offset[3];
    int cells[3];
    ptrdiff_t stride[3];
} cvol_light;

/* The cosine of a normal and the light, `lit`, after the normal has turned towards the eye, to
 * which its cosine is `seen`. A surface has two sides; where the eye sees it edge-on, noise and
 * rounding decide the side. So light changes gradually there, and is a continuous function of the
 * gradient: from n l to |n e| l e, which is the same on both sides. `facing`: the cosine of eye and
 * light. */
static inline double cvol_light_turn(double lit, double seen, double facing)
{
    const double both = fabs(seen) * facing, share = fmin(fabs(seen) / CVOL_EDGE_ON, 1);
    return both + share * ((seen < 0 ? -lit : lit) - both);
}

#endif
