/* Rays through a layer of the sheet engine in double precision: the reference of its line kernels.
 */
#ifndef CVOL_TESTS_SUPPORT_RAYS_H
#define CVOL_TESTS_SUPPORT_RAYS_H

#include "random.h"
#include "render/sheet/frame/frame.h"

enum {
    RAYS_SHEETS = 12,
    RAYS_GROUPS = 3,
    RAYS_WIDTH = RAYS_GROUPS * CVOL_GROUP,
    RAYS_ROWS = 48,    /* of samples */
    RAYS_ORDINAL = 100 /* of the layer's first slice: there are others before and behind it */
};

/* The shape of a layer. */
typedef struct rays_kind {
    int is_image_order, is_int16, is_unit, is_perspective, is_void, is_lit;
} rays_kind;

/* A layer of random samples, all of which may be visible, and the places where rays cross its
 * slices. */
typedef struct rays_scene {
    rays_kind kind;
    cvol_layer layer;
    cvol_sheet_table table;
    cvol_light light;
    int width; /* pixels of the line */
    float *floats;
    int16_t *words;
    uint8_t *flags;
    float *levels;
} rays_scene;

void rays_make(rays_scene *scene, const rays_kind *kind, random_state *r);
void rays_free(rays_scene *scene);

/* The result at a pixel of a slice; `error`: the bound of the effect of rounded places and samples
 * on `value`. */
typedef struct rays_sample {
    double value, cover, error;
} rays_sample;

/* In stored form. The sample of slice `of` where the ray of pixel i crosses slice `at`, `lane` and
 * `row` samples further. `is_widest`: by the kernels of AVX-512. */
rays_sample rays_sample_at(const rays_scene *scene, int of, int at, int i, int lane, int row,
                           int is_widest);

/* A pixel along its ray, and bounds of the errors of colours and of transmittance. */
typedef struct rays_pixel {
    double colour[3], transmittance, colour_error, transmittance_error;
    double half, half_error; /* the place at which opacity passes one half, in ordinals of slices */
} rays_pixel;

/* The pixel behind the layer; `start`: before it. *value: the table coordinate at the slice before
 * the first one; set to that at the last one, and *value_error to its error bound. *cover likewise,
 * for layers with samples without a value. */
rays_pixel rays_composite(const rays_scene *scene, const rays_pixel *start, int i, int is_widest,
                          double *value, double *value_error, double *cover);
/* The same with light; the first slice is the first that the ray reaches, and rays end with the
 * last. */
rays_pixel rays_shade(const rays_scene *scene, const rays_pixel *start, int i, int is_widest);

/* The sum of samples over the slices, weighted, and that of the weights; or the largest, the
 * smallest one. */
typedef struct rays_projection {
    double sum, weight, largest, smallest, error;
} rays_projection;
rays_projection rays_project(const rays_scene *scene, int i, int is_widest);

#endif
