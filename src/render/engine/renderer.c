/* Renderers: the common part of all engines. The engines themselves are behind engine.h. */
#include "render/engine/engine.h"

#include <math.h>
#include <stdlib.h>

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"

typedef int (*create_fn)(cvol_context *context, void **state, const void *source);

static int create_sheet(cvol_context *context, void **state, const void *source)
{
    return cvol_sheet_create(context, state, source);
}

typedef struct ray_source {
    const cvol_volume *volume;
    const uint8_t *mask;
} ray_source;

static int create_ray(cvol_context *context, void **state, const void *source)
{
    const ray_source *of = source;
    return cvol_ray_create(context, state, of->volume, of->mask);
}

static int create_splat(cvol_context *context, void **state, const void *source)
{
    return cvol_splat_create(context, state, source);
}

static int create_splat_dense(cvol_context *context, void **state, const void *source)
{
    return cvol_splat_create_dense(context, state, source);
}

static int create_transform(cvol_context *context, void **state, const void *source)
{
    return cvol_transform_create(context, state, source);
}

static int create_transform_dense(cvol_context *context, void **state, const void *source)
{
    return cvol_transform_create_dense(context, state, source);
}

typedef struct fourier_source {
    const cvol_array *array;
    const cvol_volume *volume;
    double rho;
} fourier_source;

static int create_fourier(cvol_context *context, void **state, const void *source)
{
    const fourier_source *of = source;
    return of->array ? cvol_fourier_create(context, state, of->array, of->rho)
                     : cvol_fourier_create_dense(context, state, of->volume, of->rho);
}

static int create_renderer(cvol_context *context, cvol_renderer **out, const cvol_grid *grid,
                           const cvol_engine_table *engine, create_fn create, const void *source)
{
    *out = NULL;
    cvol_renderer *renderer = calloc(1, sizeof *renderer);
    if (!renderer)
        return cvol_fail_memory(context, sizeof *renderer, "a renderer");
    renderer->engine = engine;
    renderer->grid = *grid;
    int code = create(context, &renderer->state, source);
    if (code)
        free(renderer);
    else
        *out = renderer;
    return code;
}

int cvol_renderer_create_sheet(cvol_context *context, cvol_renderer **out, const cvol_array *array)
{
    *out = NULL;
    int code = cvol_array_decoded_terms(context, &array, array);
    if (!code)
        code = create_renderer(context, out, cvol_array_grid(array), &cvol_sheet_engine,
                               create_sheet, array);
    if (!code) {
        (*out)->has_range = 1;
        (*out)->range[0] = array->error_bound.value_min;
        (*out)->range[1] = array->error_bound.value_max;
    }
    return code;
}

int cvol_renderer_create_ray(cvol_context *context, cvol_renderer **out, const cvol_volume *volume)
{
    return cvol_renderer_create_ray_masked(context, out, volume, NULL);
}

int cvol_renderer_create_ray_masked(cvol_context *context, cvol_renderer **out,
                                    const cvol_volume *volume, const uint8_t *mask)
{
    const ray_source source = {volume, mask};
    const int code = create_renderer(context, out, &volume->grid, &cvol_ray_engine, create_ray,
                                     &source);
    if (!code) {
        (*out)->has_range = 1;
        cvol_ray_range((*out)->state, (*out)->range);
    }
    return code;
}

int cvol_renderer_create_splat(cvol_context *context, cvol_renderer **out, const cvol_array *array)
{
    return create_renderer(context, out, cvol_array_grid(array), &cvol_splat_engine, create_splat,
                           array);
}

int cvol_renderer_create_splat_dense(cvol_context *context, cvol_renderer **out,
                                     const cvol_volume *volume)
{
    return create_renderer(context, out, &volume->grid, &cvol_splat_engine, create_splat_dense,
                           volume);
}

int cvol_renderer_create_transform(cvol_context *context, cvol_renderer **out,
                                   const cvol_array *array)
{
    return create_renderer(context, out, cvol_array_grid(array), &cvol_transform_engine,
                           create_transform, array);
}

int cvol_renderer_create_transform_dense(cvol_context *context, cvol_renderer **out,
                                         const cvol_volume *volume)
{
    return create_renderer(context, out, &volume->grid, &cvol_transform_engine,
                           create_transform_dense, volume);
}

static int create_fourier_renderer(cvol_context *context, cvol_renderer **out,
                                   const cvol_grid *grid, const fourier_source *source)
{
    const int code = create_renderer(context, out, grid, &cvol_fourier_engine, create_fourier,
                                     source);
    if (!code) {
        (*out)->has_range = 1;
        cvol_fourier_range((*out)->state, (*out)->range);
    }
    return code;
}

int cvol_renderer_create_fourier(cvol_context *context, cvol_renderer **out,
                                 const cvol_array *array, double rho)
{
    const fourier_source source = {.array = array, .rho = rho};
    return create_fourier_renderer(context, out, cvol_array_grid(array), &source);
}

int cvol_renderer_create_fourier_dense(cvol_context *context, cvol_renderer **out,
                                       const cvol_volume *volume, double rho)
{
    const fourier_source source = {.volume = volume, .rho = rho};
    return create_fourier_renderer(context, out, &volume->grid, &source);
}

uint64_t cvol_renderer_kept_bytes(const cvol_renderer *renderer)
{
    return renderer->engine->kept_bytes ? renderer->engine->kept_bytes(renderer->state) : 0;
}

void cvol_renderer_free(cvol_renderer *renderer)
{
    if (!renderer)
        return;
    renderer->engine->free(renderer->state);
    free(renderer);
}

int cvol_renderer_set_transfer(cvol_context *context, cvol_renderer *renderer,
                               const cvol_transfer *transfer)
{
    int code = renderer->engine->set_transfer(context, renderer->state, transfer);
    if (!code)
        renderer->has_transfer = 1;
    return code;
}

static int check_request(cvol_context *context, const cvol_renderer *renderer,
                         const cvol_image *image, const cvol_render_options *options)
{
    if (options->mode < CVOL_MODE_COMPOSITE || options->mode > CVOL_MODE_ISO)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is no rendering mode",
                         (int)options->mode);
    if (options->mode == CVOL_MODE_COMPOSITE && !renderer->has_transfer)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "mode composite needs a transfer function, none was set");
    if (options->level < 0 || options->level > 3)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "level is %d, must be 0 to 3",
                         options->level);
    if (image->width != options->width || image->height != options->height)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the image has %d x %d pixels, the options ask for %d x %d", image->width,
                         image->height, options->width, options->height);
    return CVOL_OK;
}

/* Makes the view, if the engine can draw it. */
static int make_view(cvol_context *context, cvol_view *view, const cvol_renderer *renderer,
                     const cvol_render_options *options)
{
    const int code = cvol_view_make(context, view, &renderer->grid, options);
    if (!code && view->perspective && !renderer->engine->has_perspective)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine projects in parallel: perspective is for sheet and ray");
    if (!code && view->clipped && !renderer->engine->has_clip)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine draws whole volumes: clips are for sheet and ray");
    return code;
}

static int check_depth(cvol_context *context, const cvol_renderer *renderer,
                       const cvol_image *image, const cvol_render_options *options)
{
    if (image->depth && !renderer->engine->has_depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine knows no depth: that is for sheet and ray");
    if (image->depth && cvol_mode_is_grey(options->mode))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "depth is of modes composite and iso: others show all of a ray");
    return CVOL_OK;
}

static int has_window(const cvol_render_options *options)
{
    const double *window = options->window;
    return cvol_mode_is_grey(options->mode) &&
           (window[0] < 0 || window[0] > 0 || window[1] < 0 || window[1] > 0);
}

static int check_window(cvol_context *context, const cvol_renderer *renderer,
                        const cvol_render_options *options)
{
    const double *window = options->window;
    if (!isfinite(window[0]) || !isfinite(window[1]) || !(window[1] > window[0]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a window from %g to %g: must be finite, the second larger", window[0],
                         window[1]);
    double range[2];
    return cvol_renderer_range(context, renderer, range);
}

int cvol_renderer_range(cvol_context *context, const cvol_renderer *renderer, double range[2])
{
    if (!renderer->has_range)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this engine has mode composite only");
    range[0] = renderer->range[0];
    range[1] = renderer->range[1];
    return CVOL_OK;
}

int cvol_renderer_picture(cvol_context *context, cvol_renderer *renderer, cvol_picture **out,
                          const cvol_render_options *options, const cvol_picture_options *picture)
{
    const cvol_image size = {.width = options->width, .height = options->height};
    cvol_view view;
    *out = NULL;
    if (renderer->engine != &cvol_transform_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "only engine transform composes compressed pictures");
    int code = check_request(context, renderer, &size, options);
    if (!code)
        code = make_view(context, &view, renderer, options);
    if (!code)
        code = cvol_transform_picture(context, renderer->state, out, &view, options, picture);
    return code;
}

/* Through floats: the engines only know the samples' own range. */
static int draw_window(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                       const cvol_view *view, const cvol_render_options *options)
{
    cvol_image *floats = image;
    int code = check_window(context, renderer, options);
    if (!code && !image->values)
        code = cvol_image_create_float(context, &floats, image->width, image->height);
    if (code)
        return code;
    code = renderer->engine->draw(context, renderer->state, floats, view, options);
    if (!code)
        cvol_window_apply(floats, renderer->range, options->window);
    if (!code && floats != image)
        code = cvol_image_flatten(context, image, floats, options->background);
    if (floats != image)
        cvol_image_free(floats);
    return code;
}

int cvol_renderer_render(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                         const cvol_render_options *options)
{
    cvol_view view;
    int code = check_request(context, renderer, image, options);
    if (!code)
        code = check_depth(context, renderer, image, options);
    if (!code)
        code = make_view(context, &view, renderer, options);
    if (code)
        return code;
    return has_window(options)
               ? draw_window(context, renderer, image, &view, options)
               : renderer->engine->draw(context, renderer->state, image, &view, options);
}
