/* Draws all pictures of one volume. */
#include <stdlib.h>

#include "tools/render/movie.h"
#include "tools/render/render_parts.h"
#include "tools/render/render_picture.h"

/* The engines whose level is not only that of the terms. */
static int has_coarse_pictures(const scene *s)
{
    return s->engine == CVOL_ENGINE_SHEET || s->engine == CVOL_ENGINE_TRANSFORM;
}

/* pictures: the report of each, or NULL. */
static json_t *make_report(cvol_context *context, const scene *s, const render_arguments *a,
                           const outcome *result, const turn_times *turn, const char *path,
                           json_t *pictures)
{
    json_t *object = json_pack("{s:o, s:o, s:i, s:i, s:i, s:i, s:s, s:s, s:f, s:i}", "input",
                               json_text(path), "output", json_text(a->output), "level",
                               has_coarse_pictures(s) ? s->drawn_level : s->in.level, "file_level",
                               s->in.level, "width", s->options.width, "height", s->options.height,
                               "engine", a->engine_name, "mode", a->mode_name, "load_ms",
                               s->load_ms, "threads", cvol_context_threads(context));
    if (object)
        describe_outcome(object, context, s, result);
    if (object)
        describe_view(object, context, s, a);
    if (object)
        describe_maps(object, a);
    if (object)
        describe_certificate(object, &result->certificate);
    if (object)
        describe_overlays(object, s);
    if (object)
        describe_parts(object);
    if (object && pictures)
        json_object_set(object, "pictures", pictures);
    if (object && a->turntable_given)
        describe_turn(object, a, turn);
    return object;
}

/* Prints what was drawn, when the files have their names; stages have printed theirs. */
static void print_volume(const scene *s, const render_arguments *a, const outcome *result,
                         const turn_times *turn, const char *path)
{
    if (a->turntable_given)
        print_turn(s, a, turn);
    else if (!a->progressive)
        print_picture(s, a->output, result);
    if (a->certify)
        print_certificate(&result->certificate, path);
}

/* Draws an animation over time, with a scene for each time. */
static int render_times(cvol_context *context, scene *s, render_arguments *a, const char *path,
                        turn_times *turn)
{
    cvol_histogram *shared = NULL;
    int status = fit_times(context, &shared, s, a, path);
    if (!status) {
        s->shared = shared;
        status = open_time(context, s, a, path, 0);
    }
    if (!status)
        status = render_turntable(context, s, a, path, turn);
    free(shared);
    s->shared = NULL;
    return status;
}

int render_volume(cvol_context *context, const render_arguments *arguments, const scene *fresh,
                  const char *path, json_t **report)
{
    render_arguments a = *arguments;
    scene s = *fresh;
    outcome result = {0};
    turn_times turn = {0};
    char *output = output_name(a.output, path, 0, 0);
    if (!output)
        return report_error(EXIT_FAILED, "not enough memory");
    a.output = output;
    int status = name_maps(&a, path);
    json_t *pictures = a.progressive ? json_array() : NULL;
    const int writes_several = a.certify || a.depth_name || a.opacity_name ||
                               (a.turntable_given && !is_movie(output));
    if (writes_several) /* all of them, or none */
        cvol_context_hold_outputs(context);
    if (!status)
        status = check_output(path, output);
    if (!status && a.progressive)
        status = render_stages(context, &a, &s, path, pictures, &result);
    else if (!status && a.over_time)
        status = render_times(context, &s, &a, path, &turn);
    else if (!status && !(status = open_channels(context, &s, &a, path)) &&
             !(status = open_overlays(context, &s, &a, path)))
        status = a.turntable_given ? render_turntable(context, &s, &a, path, &turn)
                 : a.certify       ? render_certified(context, &s, &a, path, &result)
                                   : write_picture(context, &s, &a, output, &result);
    if (writes_several)
        status = release_outputs(context, status);
    if (!status && !a.common.json)
        print_volume(&s, &a, &result, &turn, path);
    if (!status && a.common.json) {
        *report = make_report(context, &s, &a, &result, &turn, path, pictures);
        if (!*report)
            status = report_error(EXIT_FAILED, "not enough memory for the JSON output");
    }
    json_decref(pictures);
    close_scene(&s);
    free_maps(&a);
    free_certificate(&result.certificate);
    free(output);
    return status;
}
