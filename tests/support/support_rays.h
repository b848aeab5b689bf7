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
    RAYS_ORDINAL = 100 /* of the layer's first sheet: there are others before and behind it */
};

/* The shape of a layer. */
typedef struct rays_kind {
    int is_image_order, is_int16, is_unit, is_perspective, is_void, is_lit;
} rays_kind;

/* A layer of random samples, all of which may be seen, and where rays cross its sheets. */
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

/* As samples are kept. The sample of sheet `of` where the ray of pixel i crosses sheet `at`, `lane`
 * and `row` samples further. `is_widest`: by the kernels of AVX-512. */
rays_sample rays_sample_at(const rays_scene *scene, int of, int at, int i, int lane, int row,
                           int is_widest);

/* A pixel while its ray goes on, and bounds of the errors of colours and of transmittance. */
typedef struct rays_pixel {
    double colour[3], transmittance, colour_error, transmittance_error;
    double half, half_error; /* where opacity passes one half, in ordinals of sheets */
} rays_pixel;

/* The pixel behind the layer; `start`: before it. *value: the table coordinate at the slice before
 * the first one; set to that at the last one, and *value_error to its error bound. *cover likewise,
 * for layers with samples without a value. */
rays_pixel rays_composite(const rays_scene *scene, const rays_pixel *start, int i, int is_widest,
                          double *value, double *value_error, double *cover);
/* The same with light, where the first sheet is the first that the ray meets, and rays end with
 * the last. */
rays_pixel rays_shade(const rays_scene *scene, const rays_pixel *start, int i, int is_widest);

/* The sum of samples over the sheets, weighted, and the weights'; or the largest, the smallest
 * one. */
typedef struct rays_projection {
    double sum, weight, largest, smallest, error;
} rays_projection;
rays_projection rays_project(const rays_scene *scene, int i, int is_widest);

#endif
