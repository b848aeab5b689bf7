/* Pictures of a shape that then gets its colours: of labels, and of RGB samples.
 *
 * The picture of RGB samples is that of the sum of their components, or of alpha, coloured by the
 * samples that each pixel sees (cvol_image_colour_components). */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_parts.h"
#include "tools/render/render_picture.h"

/* The components of a scene of RGB samples. */
struct scene_colours {
    input components[CVOL_COLOURS_MAX];
    const cvol_array *arrays[CVOL_COLOURS_MAX];
    const cvol_volume *volumes[CVOL_COLOURS_MAX];
    double rgb[3 * CVOL_COLOURS_MAX];
    cvol_colour_source source;
    cvol_colours *colours;
};

int can_draw_colours(const scene *s, const render_arguments *a)
{
    return (s->engine == CVOL_ENGINE_SHEET || s->engine == CVOL_ENGINE_RAY) &&
           s->options.mode == CVOL_MODE_COMPOSITE && !a->transfer_given && !a->colormap &&
           !a->channel_colours && !a->certify && !drawing_of_parts &&
           picture_kind_of(a->output) != PICTURE_CVI;
}

static void list_components(scene_colours *c)
{
    c->source.size = sizeof c->source;
    c->source.rgb = c->rgb;
    c->source.arrays = c->components[0].array ? c->arrays : NULL;
    c->source.volumes = c->components[0].array ? NULL : c->volumes;
    for (size_t i = 0; i < c->source.count; i++) {
        c->arrays[i] = c->components[i].array;
        c->volumes[i] = c->components[i].volume;
    }
}

/* Alpha counts if it is not the same everywhere. */
static int drop_constant_alpha(cvol_context *context, scene_colours *c)
{
    cvol_histogram h;
    const input *alpha = &c->components[c->source.count - 1];
    if (!c->source.has_alpha)
        return CVOL_OK;
    const int code = alpha->array ? cvol_array_compute_histogram(context, &h, alpha->array)
                                  : cvol_volume_compute_histogram(context, &h, alpha->volume);
    if (!code && !(h.max > h.min)) {
        c->source.has_alpha = 0;
        c->source.count--;
    }
    return code;
}

/* Puts the shape in the place of the samples. */
static int make_shape(cvol_context *context, scene *s)
{
    scene_colours *c = s->colours;
    int code = drop_constant_alpha(context, c);
    list_components(c);
    c->source.by_range = s->shared != NULL;
    return code
               ? code
               : cvol_colours_create(context, &c->colours, &s->in.array, &s->in.volume, &c->source);
}

static void set_range(double range[2], const scene *s, const render_arguments *a)
{
    cvol_component_get_range(range, input_grid(&s->in)->type);
    for (int k = 0; k < 2 && a->window_text; k++)
        range[k] = a->window[0] + (k ? 0.5 : -0.5) * a->window[1];
}

/* Opens component i, as the engine needs it. Exit status. */
static int open_component(cvol_context *context, scene *s, size_t i, common_options *common,
                          const char *path)
{
    input *in = &s->colours->components[i];
    common->read.channel = (int)i;
    int status = i ? open_input(context, in, path, common) : EXIT_DONE;
    if (status)
        return status;
    in->is_quiet = i > 0;
    if (s->engine == CVOL_ENGINE_SHEET) {
        status = need_array(context, in, path, 0, CVOL_BACKGROUND_FIND);
        cvol_volume_free(in->volume);
        in->volume = NULL;
    } else {
        status = need_volume(context, in);
        cvol_array_free(in->array);
        in->array = NULL;
    }
    return status;
}

int choose_colours(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    scene_colours *c = s->colours;
    common_options common = a->common;
    if (!c)
        return EXIT_DONE;
    set_range(c->source.range, s, a);
    c->components[0] = s->in;
    s->in.array = NULL;
    s->in.volume = NULL;
    common.level = s->in.level;
    common.choice_printed = 1; /* the first component printed it */
    int status = EXIT_DONE;
    for (size_t i = 0; i < c->source.count && !status; i++)
        status = open_component(context, s, i, &common, path);
    const int code = status ? CVOL_OK : make_shape(context, s);
    return code ? report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL)
                : status;
}

int open_colours(cvol_context *context, scene *s, const render_arguments *a, const double *rgb,
                 int channels, const char *path)
{
    render_arguments own = *a;
    own.common.read.has_channel = 1;
    own.common.read.channel = 0;
    own.common.are_colours = 1;
    own.is_channel = 1;
    s->colours = calloc(1, sizeof *s->colours);
    if (!s->colours)
        return report_error(EXIT_FAILED, "not enough memory");
    s->colours->source.count = (size_t)channels;
    s->colours->source.has_alpha = channels == CVOL_COLOURS_MAX;
    memcpy(s->colours->rgb, rgb, 3 * (size_t)channels * sizeof *rgb);
    return open_scene(context, s, &own, path);
}

void close_colours(scene *s)
{
    if (!s->colours)
        return;
    cvol_colours_free(s->colours->colours);
    for (size_t i = 0; i < CVOL_COLOURS_MAX; i++)
        close_input(&s->colours->components[i]);
    free(s->colours);
    s->colours = NULL;
}

int make_colour_transfer(cvol_context *context, cvol_transfer **out, const scene *s)
{
    return cvol_colours_create_transfer(context, out, s->colours->colours);
}

/* ---- drawing --------------------------------------------------------------------------------- */

static int add_colours(cvol_context *context, const scene *s, cvol_image *image,
                       const cvol_render_options *options)
{
    double colours[3 * LABELS_DRAWN_MAX];
    if (s->colours)
        return cvol_image_colour_components(context, image, s->colours->colours, s->transfer,
                                            options);
    list_colours(colours, s->labels);
    return cvol_image_colour_labels(context, image, s->numbers, colours, s->labels->count,
                                    s->transfer, options);
}

int draw_coloured(cvol_context *context, scene *s, double budget_ms, cvol_image *image)
{
    cvol_render_options options = s->options;
    cvol_refine_report report = {.level = options.level};
    const int had_depth = image->depth != NULL;
    int code = had_depth ? CVOL_OK : cvol_image_add_depth(context, image);
    if (!code)
        code = budget_ms > 0 ? cvol_renderer_refine(context, s->renderer, image, &options,
                                                    budget_ms, NULL, NULL, &report)
                             : cvol_renderer_render(context, s->renderer, image, &options);
    if (!code) {
        s->drawn_level = options.level = report.level;
        code = add_colours(context, s, image, &options);
    }
    if (!had_depth) {
        free(image->depth);
        image->depth = NULL;
    }
    return code;
}
