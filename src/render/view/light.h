/* Light of a frame: the inputs of Phong's model (cvol_shading) from a view. */
#ifndef CVOL_RENDER_VIEW_LIGHT_H
#define CVOL_RENDER_VIEW_LIGHT_H

/* Directions are in the world, along three axes of the volume in the caller's order: towards the
 * eye, and towards the light. */
typedef struct cvol_light {
    int on;
    float eye[3], light[3];
    float rise[3];      /* a difference of samples two apart times this is the gradient */
    float facing_light; /* eye light */
    float ambient, diffuse, specular;
    int shininess;
    float thinning; /* 1 / gradient_opacity; 0: none */
} cvol_light;

#endif
