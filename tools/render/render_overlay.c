/* --overlay: further volumes in the picture of a volume, as PET over MRI (tools/overlay). */
#include "tools/render/render_overlay.h"
#include "tools/render/overlay_options.h"

#include <stdlib.h>
#include <string.h>

/* ---- options ---- */

int check_overlays(const scene *s, const render_arguments *a)
{
    const char *other = a->certify           ? "--certify"
                        : a->depth_name      ? "--depth"
                        : a->poses           ? "--poses"
                        : a->over_time       ? "--over-time"
                        : a->progressive     ? "--progressive"
                        : a->budget_given    ? "--budget-ms"
                        : a->channel_colours ? "--channel-colors"
                        : a->output && picture_kind_of(a->output) == PICTURE_CVI
                            ? "a compressed picture"
                            : NULL;
    if (!a->overlay.files.count)
        return EXIT_DONE;
    if (s->engine != CVOL_ENGINE_SHEET && s->engine != CVOL_ENGINE_RAY)
        return report_error(EXIT_MISUSED, "--overlay works only with engines sheet and ray");
    if (other)
        return report_error(EXIT_MISUSED, "--overlay cannot be combined with %s", other);
    return check_overlay_values(&a->overlay);
}

/* ---- opening ---- */

/* Exit status. */
static int fit(cvol_context *context, const scene *s, scene_overlay *o, const char *path)
{
    int code = overlay_fit(context, &o->fitted, &o->source, input_grid(&s->in), path, s->engine,
                           NULL);
    if (!code)
        code = overlay_create_transfers(context, &o->colours, &o->depths, &o->source, &o->look,
                                        o->fitted.density);
    overlay_get_rescale(o->rescale, &o->source);
    cvol_volume_free(o->source.samples);
    o->source.samples = NULL;
    if (!code)
        code = overlay_create_renderer(context, &o->renderer, &o->fitted, s->engine);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

static int open_overlay(cvol_context *context, const scene *s, scene_overlay *o,
                        const render_arguments *a, int i, const char *path)
{
    int status = read_overlay(context, &o->source, &o->labels, &a->overlay, i, a->common.threads);
    if (!status)
        status = choose_overlay_look(context, &o->look, &o->file, &o->source, &a->overlay, i);
    if (!status && o->look.depth < 0)
        o->look.depth = overlay_default_depth(input_grid(&s->in));
    if (!status)
        status = fit(context, s, o, path);
    if (!status)
        warn_of_blank_overlay(&o->source, &o->look);
    return status;
}

int open_overlays(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    const double start = milliseconds();
    int status = EXIT_DONE;
    if (!a->overlay.files.count)
        return EXIT_DONE;
    if (s->other_count)
        return report_error(EXIT_MISUSED,
                            "%s: has several channels: choose one with --channel to draw an "
                            "overlay",
                            path);
    s->overlays = calloc((size_t)a->overlay.files.count, sizeof *s->overlays);
    if (!s->overlays)
        return report_error(EXIT_FAILED, "not enough memory");
    s->overlay_count = a->overlay.files.count;
    for (int i = 0; i < s->overlay_count && !status; i++)
        status = open_overlay(context, s, &s->overlays[i], a, i, path);
    s->load_ms += milliseconds() - start;
    return status;
}

void close_overlays(scene *s)
{
    for (int i = 0; i < s->overlay_count; i++) {
        scene_overlay *o = &s->overlays[i];
        cvol_renderer_free(o->renderer);
        cvol_transfer_free(o->colours);
        cvol_transfer_free(o->depths);
        cvol_transfer_free(o->file);
        overlay_free(&o->fitted);
        cvol_volume_free(o->source.samples);
        free(o->labels);
    }
    free(s->overlays);
    s->overlays = NULL;
    s->overlay_count = 0;
}

/* ---- drawing ---- */

/* Draws one overlay: its colours, with the depths of its dense picture. A code of the library. */
static int draw_overlay(cvol_context *context, const scene *s, const scene_overlay *o,
                        cvol_image **out)
{
    const cvol_render_options *options = &s->options;
    int code = cvol_image_create_float(context, out, options->width, options->height);
    if (!code)
        code = cvol_renderer_set_transfer(context, o->renderer, o->colours);
    if (!code)
        code = overlay_draw(context, &o->fitted, o->renderer, *out, options);
    if (code || !overlay_needs_depths(&o->fitted, options->mode))
        return code;
    code = cvol_renderer_set_transfer(context, o->renderer, o->depths);
    return code ? code : overlay_add_depths(context, &o->fitted, o->renderer, *out, options);
}

int draw_overlays(cvol_context *context, scene *s, cvol_image *image)
{
    overlay_layer layers[OVERLAYS_MAX] = {{NULL, 0, 0}};
    int code = overlay_mode_has_depth(s->options.mode) ? cvol_image_add_depth(context, image)
                                                       : CVOL_OK;
    if (!code)
        code = s->numbers || s->colours
                   ? draw_coloured(context, s, 0, image)
                   : cvol_renderer_render(context, s->renderer, image, &s->options);
    for (int i = 0; i < s->overlay_count && !code; i++) {
        layers[i].opacity = s->overlays[i].look.opacity;
        layers[i].depth = s->overlays[i].look.depth;
        code = draw_overlay(context, s, &s->overlays[i], &layers[i].picture);
    }
    if (!code)
        overlay_blend(image, layers, s->overlay_count);
    for (int i = 0; i < s->overlay_count; i++)
        cvol_image_free(layers[i].picture);
    return code;
}

/* ---- describing ---- */

const cvol_transfer *overlay_bar(double rescale[2], const scene *s)
{
    for (int i = 0; i < s->overlay_count; i++)
        if (!s->overlays[i].source.is_labels) {
            memcpy(rescale, s->overlays[i].rescale, sizeof s->overlays[i].rescale);
            return s->overlays[i].colours;
        }
    return NULL;
}

void describe_overlays(json_t *object, const scene *s)
{
    json_t *list = s->overlay_count ? json_array() : NULL;
    for (int i = 0; i < s->overlay_count; i++) {
        const scene_overlay *o = &s->overlays[i];
        json_t *entry = json_pack("{s:o, s:b, s:f, s:f, s:f}", "input", json_text(o->source.path),
                                  "labels", o->source.is_labels, "opacity", o->look.opacity,
                                  "depth", o->look.depth, "overlap", o->fitted.overlap);
        if (o->labels)
            json_object_set_new(entry, "drawn", describe_labels(o->labels));
        json_array_append_new(list, entry);
    }
    if (list)
        json_object_set_new(object, "overlays", list);
}
