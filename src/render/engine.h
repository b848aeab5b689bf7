/* What a renderer is to its engines. */
#ifndef CVOL_RENDER_ENGINE_H
#define CVOL_RENDER_ENGINE_H

#include "render/camera.h"
#include "render/transfer.h"

/* An engine's own state, and how it draws. `draw` fills image->rgba whole. */
typedef struct cvol_engine_table {
    void (*free)(void *state);
    /* Called when the transfer function was set (never NULL). */
    int (*set_transfer)(cvol_context *context, void *state, const cvol_transfer *transfer);
    int (*draw)(cvol_context *context, void *state, cvol_image *image, const cvol_view *view,
                const cvol_render_options *options);
} cvol_engine_table;

struct cvol_renderer {
    const cvol_engine_table *engine;
    void *state;
    cvol_grid grid;
    int has_transfer;
};

/* Creates the engines' states. */
int cvol_sheet_create(cvol_context *context, void **state, const cvol_array *array);
int cvol_splat_create(cvol_context *context, void **state, const cvol_array *array);
int cvol_splat_create_dense(cvol_context *context, void **state, const cvol_volume *volume);
/* `mask`: see cvol_renderer_create_ray_masked; NULL: all samples have a value. */
int cvol_ray_create(cvol_context *context, void **state, const cvol_volume *volume,
                    const uint8_t *mask);
int cvol_transform_create(cvol_context *context, void **state, const cvol_array *array);
int cvol_transform_create_dense(cvol_context *context, void **state, const cvol_volume *volume);
int cvol_transform_picture(cvol_context *context, void *state, cvol_picture **out,
                           const cvol_view *view, const cvol_render_options *options,
                           const cvol_picture_options *how);
int cvol_fourier_create(cvol_context *context, void **state, const cvol_array *array, double rho);
int cvol_fourier_create_dense(cvol_context *context, void **state, const cvol_volume *volume,
                              double rho);
extern const cvol_engine_table cvol_sheet_engine;
extern const cvol_engine_table cvol_ray_engine;
extern const cvol_engine_table cvol_splat_engine;
extern const cvol_engine_table cvol_transform_engine;
extern const cvol_engine_table cvol_fourier_engine;

#endif
