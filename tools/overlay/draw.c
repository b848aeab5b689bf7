/* Draws an overlay. */
#include <stdlib.h>

#include "tools/overlay/overlay.h"

int overlay_mode_has_depth(cvol_mode mode)
{
    return mode == CVOL_MODE_COMPOSITE || mode == CVOL_MODE_ISO;
}

int overlay_draw_labels(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                        const cvol_render_options *options, const cvol_volume *numbers,
                        const double *colours, size_t count, const cvol_transfer *transfer)
{
    const int had_depth = image->depth != NULL;
    int code = had_depth ? CVOL_OK : cvol_image_add_depth(context, image);
    if (!code)
        code = cvol_renderer_render(context, renderer, image, options);
    if (!code)
        code = cvol_image_colour_labels(context, image, numbers, colours, count, transfer, options);
    if (!had_depth) {
        free(image->depth);
        image->depth = NULL;
    }
    return code;
}

/* The options of an overlay. Labels are lit like the volume, which shows their shapes. The colours
 * of values must not depend on light. */
static cvol_render_options options_of(const overlay *o, const cvol_render_options *of_volume)
{
    cvol_render_options options = *of_volume;
    options.mode = CVOL_MODE_COMPOSITE;
    for (int a = 0; a < 3; a++) {
        options.clip.from[a] *= o->share[a];
        options.clip.to[a] *= o->share[a];
    }
    options.shading.on = o->of->is_labels &&
                         (options.shading.on || of_volume->mode == CVOL_MODE_ISO);
    return options;
}

int overlay_draw(cvol_context *context, const overlay *o, cvol_renderer *renderer,
                 cvol_image *image, const cvol_render_options *options)
{
    const cvol_render_options own = options_of(o, options);
    if (!o->numbers)
        return cvol_renderer_render(context, renderer, image, &own);
    const int code = overlay_mode_has_depth(options->mode) ? cvol_image_add_depth(context, image)
                                                           : CVOL_OK;
    return code ? code
                : overlay_draw_labels(context, renderer, image, &own, o->numbers, o->of->colours,
                                      o->of->count, NULL);
}

int overlay_needs_depths(const overlay *o, cvol_mode mode)
{
    return !o->numbers && overlay_mode_has_depth(mode);
}

int overlay_add_depths(cvol_context *context, const overlay *o, cvol_renderer *renderer,
                       cvol_image *image, const cvol_render_options *options)
{
    cvol_render_options own = options_of(o, options);
    cvol_image *deep = NULL;
    own.shading.on = 0;
    int code = cvol_image_create_float(context, &deep, image->width, image->height);
    if (!code)
        code = cvol_image_add_depth(context, deep);
    if (!code)
        code = cvol_renderer_render(context, renderer, deep, &own);
    if (!code) {
        image->depth = deep->depth;
        deep->depth = NULL;
    }
    cvol_image_free(deep);
    return code;
}
