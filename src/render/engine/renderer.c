/* Renderers: the common part of all engines. The engines themselves are behind engine.h. */
#include "render/engine/engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"
#include "base/options.h"
#include "image/picture.h"
#include "render/view/options.h"
#include "render/view/shading.h"

/* Of samples, so that sums stay finite. */
#define CERTIFIED_ERROR_MAX 1e300

/* Makes the engine's state for a source that suits it. */
static int create_state(cvol_context *context, cvol_renderer *r, cvol_engine engine,
                        const cvol_source *source)
{
    const cvol_array *array = source->array;
    const cvol_volume *volume = source->volume;
    switch (engine) {
    case CVOL_ENGINE_SHEET:
        return cvol_sheet_create(context, &r->state, array, source->whole);
    case CVOL_ENGINE_RAY:
        return cvol_ray_create(context, &r->state, volume, source->mask);
    case CVOL_ENGINE_SPLAT:
        return array ? cvol_splat_create(context, &r->state, array)
                     : cvol_splat_create_dense(context, &r->state, volume);
    case CVOL_ENGINE_TRANSFORM:
        return array    ? cvol_transform_create(context, &r->state, array)
               : volume ? cvol_transform_create_dense(context, &r->state, volume)
                        : cvol_transform_create_baked(context, &r->state, source->baked_path);
    case CVOL_ENGINE_FOURIER:
        return array ? cvol_fourier_create(context, &r->state, array, source->rho)
                     : cvol_fourier_create_dense(context, &r->state, volume, source->rho);
    }
    return CVOL_OK; /* not reached: find_engine returns only these engines */
}

/* The black and white of grey modes. */
static void set_range(cvol_renderer *r, cvol_engine engine, const cvol_array *array)
{
    r->has_range = engine == CVOL_ENGINE_SHEET || engine == CVOL_ENGINE_RAY ||
                   engine == CVOL_ENGINE_FOURIER;
    if (engine == CVOL_ENGINE_SHEET) {
        r->range[0] = array->error_bound.value_min;
        r->range[1] = array->error_bound.value_max;
    } else if (engine == CVOL_ENGINE_RAY)
        cvol_ray_range(r->state, r->range);
    else if (engine == CVOL_ENGINE_FOURIER)
        cvol_fourier_range(r->state, r->range);
}

typedef struct engine_row {
    const char *name;
    const cvol_engine_table *table;
    int arrays, volumes, baked; /* whether it draws these */
} engine_row;

static const engine_row *find_engine(cvol_engine engine)
{
    static const engine_row rows[] = {
        [CVOL_ENGINE_SHEET] = {"sheet", &cvol_sheet_engine, 1, 0, 0},
        [CVOL_ENGINE_RAY] = {"ray", &cvol_ray_engine, 0, 1, 0},
        [CVOL_ENGINE_SPLAT] = {"splat", &cvol_splat_engine, 1, 1, 0},
        [CVOL_ENGINE_TRANSFORM] = {"transform", &cvol_transform_engine, 1, 1, 1},
        [CVOL_ENGINE_FOURIER] = {"fourier", &cvol_fourier_engine, 1, 1, 0}};
    const int i = (int)engine, count = sizeof rows / sizeof *rows;
    return i > 0 && i < count && rows[i].name ? &rows[i] : NULL;
}

static int check_source(cvol_context *context, const engine_row *engine, const cvol_source *source)
{
    const int count = (source->array != NULL) + (source->volume != NULL) +
                      (source->baked_path != NULL);
    if (count != 1)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a renderer draws one source: an array, a volume or a baked file; %d are "
                         "given",
                         count);
    if (!(source->array ? engine->arrays : source->volume ? engine->volumes : engine->baked))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "engine %s draws no %s", engine->name,
                         source->array    ? "compressed array"
                         : source->volume ? "dense volume"
                                          : "baked file");
    return CVOL_OK;
}

int cvol_renderer_create(cvol_context *context, cvol_renderer **out, cvol_engine engine,
                         const cvol_source *source)
{
    const engine_row *row = find_engine(engine);
    *out = NULL;
    if (!row)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not an engine", (int)engine);
    cvol_source drawn = {0};
    int code = cvol_options_copy(context, &drawn, sizeof drawn, CVOL_SIZE_TO(cvol_source, rho),
                                 "cvol_source", source);
    if (!code)
        code = check_source(context, row, &drawn);
    if (!code && engine == CVOL_ENGINE_SHEET)
        code = cvol_array_decoded_terms(context, &drawn.array, drawn.array);
    if (code)
        return code;
    cvol_renderer *renderer = calloc(1, sizeof *renderer);
    if (!renderer)
        return cvol_fail_memory(context, sizeof *renderer, "a renderer");
    renderer->engine = row->table;
    code = create_state(context, renderer, engine, &drawn);
    if (code) {
        free(renderer);
        return code;
    }
    renderer->grid = drawn.array    ? *cvol_array_grid(drawn.array)
                     : drawn.volume ? drawn.volume->grid
                                    : *cvol_transform_baked_grid(renderer->state);
    renderer->has_transfer = drawn.baked_path != NULL; /* the file's own */
    set_range(renderer, engine, drawn.array);
    *out = renderer;
    return CVOL_OK;
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
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a rendering mode",
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

/* Makes the view, if the engine can draw it; the options get the light in the world. */
static int make_view(cvol_context *context, cvol_view *view, const cvol_renderer *renderer,
                     cvol_render_options *options)
{
    const int code = cvol_view_make(context, view, &renderer->grid, options);
    const cvol_illumination *light = &options->illumination;
    if (!code && !renderer->engine->has_illumination &&
        (light->fill > 0 || cvol_illumination_needs_volume(light)))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine has one light without shadows: fill, occlusion, shadows and "
                         "kept brightness are for sheet and ray");
    if (!code && view->perspective && !renderer->engine->has_perspective)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine projects in parallel: perspective is for sheet and ray");
    if (!code && options->rows.of && !renderer->engine->has_clip)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine draws whole pictures: rows are for sheet and ray");
    if (!code && view->clipped && !renderer->engine->has_clip)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine draws whole volumes: clips are for sheet and ray");
    if (!code)
        cvol_shading_place(options, view);
    return code;
}

static int check_depth(cvol_context *context, const cvol_renderer *renderer,
                       const cvol_image *image, const cvol_render_options *options)
{
    if (image->depth && !renderer->engine->has_depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this engine has no depths: use sheet or ray");
    if (image->depth && cvol_mode_is_grey(options->mode))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "depths need mode composite or iso: others show the whole ray");
    return CVOL_OK;
}

static int is_window_given(const cvol_render_options *options)
{
    const double *window = options->window;
    return window[0] < 0 || window[0] > 0 || window[1] < 0 || window[1] > 0;
}

static int has_window(const cvol_render_options *options)
{
    return cvol_mode_is_grey(options->mode) && is_window_given(options);
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
    return cvol_renderer_get_range(context, range, renderer);
}

int cvol_renderer_get_range(cvol_context *context, double range[2], const cvol_renderer *renderer)
{
    if (!renderer->has_range)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this engine has mode composite only");
    range[0] = renderer->range[0];
    range[1] = renderer->range[1];
    return CVOL_OK;
}

int cvol_renderer_render_compressed(cvol_context *context, cvol_renderer *renderer,
                                    cvol_picture **out, const cvol_render_options *options,
                                    const cvol_picture_options *picture)
{
    cvol_render_options full;
    cvol_picture_options how;
    cvol_view view;
    *out = NULL;
    if (renderer->engine != &cvol_transform_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "only engine transform composes compressed pictures");
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = cvol_picture_options_complete(context, &how, picture);
    const cvol_image size = {.width = full.width, .height = full.height};
    if (!code)
        code = check_request(context, renderer, &size, &full);
    if (!code)
        code = make_view(context, &view, renderer, &full);
    if (!code)
        code = cvol_transform_picture(context, renderer->state, out, &view, &full, &how);
    return code;
}

/* By floats: the engines only use the samples' own range. */
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
    cvol_render_options full;
    cvol_view view;
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = check_request(context, renderer, image, &full);
    if (!code)
        code = check_depth(context, renderer, image, &full);
    if (!code && full.mode == CVOL_MODE_ISO && is_window_given(&full))
        code = check_window(context, renderer, &full);
    if (!code)
        code = make_view(context, &view, renderer, &full);
    if (code)
        return code;
    if (has_window(&full))
        return draw_window(context, renderer, image, &view, &full);
    if (cvol_antialias_suits(&full))
        return cvol_antialias_draw(context, renderer, image, &full);
    return renderer->engine->draw(context, renderer->state, image, &view, &full);
}

/* ---- certified pictures ------------------------------------------------------------------ */

static int check_certified(cvol_context *context, const cvol_renderer *renderer,
                           const cvol_image *lower, const cvol_image *upper,
                           const cvol_render_options *options, double error, const double *range)
{
    if (!renderer->engine->certify)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "only engine ray certifies pictures; create a renderer of that engine");
    if (!(error >= 0 && error <= CERTIFIED_ERROR_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the error is %g, must be 0 to %g", error,
                         CERTIFIED_ERROR_MAX);
    if (range && !(isfinite(range[0]) && isfinite(range[1]) && range[0] <= range[1]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the original samples have a range from %g to %g: must be finite, the "
                         "second not smaller",
                         range[0], range[1]);
    if (!lower->values != !upper->values)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "one image has bytes and the other floats: give two of one kind");
    if (cvol_illumination_needs_volume(&options->illumination) && options->shading.on)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "certified pictures have light without occlusion, shadows and kept "
                         "brightness, which depend on the samples of the whole volume");
    if (error > 0 && options->mode == CVOL_MODE_ISO)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "mode iso has no certified pictures of samples with an error: use another "
                         "mode, or lossless samples");
    const int code = check_request(context, renderer, lower, options);
    return code ? code : check_request(context, renderer, upper, options);
}

static void copy_pixels(cvol_image *to, const cvol_image *from)
{
    const size_t count = 4 * (size_t)from->width * (size_t)from->height;
    if (from->values)
        memcpy(to->values, from->values, count * sizeof *to->values);
    else
        memcpy(to->rgba, from->rgba, count);
}

int cvol_renderer_certify(cvol_context *context, cvol_renderer *renderer, cvol_image *lower,
                          cvol_image *upper, const cvol_render_options *options, double error,
                          const double *range)
{
    cvol_render_options full;
    cvol_view view;
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = check_certified(context, renderer, lower, upper, &full, error, range);
    if (!code && has_window(&full))
        code = check_window(context, renderer, &full);
    if (!code)
        code = make_view(context, &view, renderer, &full);
    if (code)
        return code;
    if (error > 0)
        return renderer->engine->certify(context, renderer->state, lower, upper, &view, &full,
                                         error, range);
    code = cvol_renderer_render(context, renderer, lower, &full);
    if (!code)
        copy_pixels(upper, lower);
    return code;
}
