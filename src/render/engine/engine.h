/* The interface between a renderer and its engines. */
#ifndef CVOL_RENDER_ENGINE_ENGINE_H
#define CVOL_RENDER_ENGINE_ENGINE_H

#include "render/transfer/transfer.h"
#include "render/view/camera.h"

/* An engine's own state, and its functions. `draw` fills the whole image: bytes over the
 * background, or floats (cvol/image.h) if the image has these, and depths if it has memory for
 * them. The engine ignores the options' window. */
typedef struct cvol_engine_table {
    void (*free)(void *state);
    /* Called after the transfer function was set (never NULL). */
    int (*set_transfer)(cvol_context *context, void *state, const cvol_transfer *transfer);
    int (*draw)(cvol_context *context, void *state, cvol_image *image, const cvol_view *view,
                const cvol_render_options *options);
    /* cvol_renderer_certify: both pictures, with an error above 0. range: NULL if unknown. NULL:
     * the engine does not certify pictures. */
    int (*certify)(cvol_context *context, void *state, cvol_image *lower, cvol_image *upper,
                   const cvol_view *view, const cvol_render_options *options, double error,
                   const double range[2]);
    uint64_t (*kept_bytes)(const void *state); /* NULL: it stores nothing from picture to picture */
    int has_clip, has_perspective, has_depth, has_illumination;
} cvol_engine_table;

/* The last times of the levels of pictures of one kind (refine.c); 0: unknown. */
typedef struct cvol_level_times {
    int width, height;
    cvol_mode mode;
    int lit;
    double ms[4];
} cvol_level_times;

struct cvol_renderer {
    const cvol_engine_table *engine;
    void *state;
    cvol_grid grid;
    int has_transfer;
    cvol_level_times pace;
    int has_range;
    double range[2]; /* of samples: black and white in grey modes */
};

/* Maps the grey levels of a picture of floats, range[0] .. range[1] within 0..1, to a window. */
void cvol_window_apply(cvol_image *image, const double range[2], const double window[2]);

/* The values of black and white of a surface's cut faces: the options' window, or min .. max if
 * there is none. */
void cvol_window_of_cuts(double window[2], const cvol_render_options *options, double min,
                         double max);

/* Returns 1 if a picture has more rays than pixels, so that edges of surfaces are smooth: in mode
 * iso, unless the options choose the number of rays or a coarser level. */
int cvol_antialias_suits(const cvol_render_options *options);
/* Draws such a picture; the options are valid. */
int cvol_antialias_draw(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                        const cvol_render_options *options);

/* Creates the engines' states. */
/* `whole`: see cvol_source, or NULL. */
int cvol_sheet_create(cvol_context *context, void **state, const cvol_array *array,
                      const cvol_array *whole);
int cvol_splat_create(cvol_context *context, void **state, const cvol_array *array);
int cvol_splat_create_dense(cvol_context *context, void **state, const cvol_volume *volume);
/* `mask`: see cvol_source; NULL: all samples have a value. */
int cvol_ray_create(cvol_context *context, void **state, const cvol_volume *volume,
                    const uint8_t *mask);
void cvol_ray_range(const void *state, double range[2]);
int cvol_transform_create(cvol_context *context, void **state, const cvol_array *array);
int cvol_transform_create_dense(cvol_context *context, void **state, const cvol_volume *volume);
/* Over a baked file; and the grid of its volume. */
int cvol_transform_create_baked(cvol_context *context, void **state, const char *path);
const cvol_grid *cvol_transform_baked_grid(const void *state);
int cvol_transform_picture(cvol_context *context, void *state, cvol_picture **out,
                           const cvol_view *view, const cvol_render_options *options,
                           const cvol_picture_options *how);
int cvol_fourier_create(cvol_context *context, void **state, const cvol_array *array, double rho);
int cvol_fourier_create_dense(cvol_context *context, void **state, const cvol_volume *volume,
                              double rho);
void cvol_fourier_range(const void *state, double range[2]);
extern const cvol_engine_table cvol_sheet_engine;
extern const cvol_engine_table cvol_ray_engine;
extern const cvol_engine_table cvol_splat_engine;
extern const cvol_engine_table cvol_transform_engine;
extern const cvol_engine_table cvol_fourier_engine;

#endif
