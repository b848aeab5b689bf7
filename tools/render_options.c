/* From render options to a renderer. */
#include "render_options.h"

#include <string.h>

static int choose_mode(cvol_mode *mode, const char *name)
{
    if (!strcmp(name, "composite"))
        *mode = CVOL_MODE_COMPOSITE;
    else if (!strcmp(name, "xray"))
        *mode = CVOL_MODE_XRAY;
    else if (!strcmp(name, "mip"))
        *mode = CVOL_MODE_MIP;
    else
        return complain(EXIT_MISUSED, "--mode is '%s', must be composite, xray or mip", name);
    return EXIT_DONE;
}

static int choose_engine(cvol_engine *engine, const char *name)
{
    if (!strcmp(name, "sheet"))
        *engine = CVOL_ENGINE_SHEET;
    else if (!strcmp(name, "ray"))
        *engine = CVOL_ENGINE_RAY;
    else
        return complain(EXIT_MISUSED, "--engine is '%s', must be sheet or ray", name);
    return EXIT_DONE;
}

int check_render_arguments(scene *s, const render_arguments *a)
{
    s->options = cvol_render_options_defaults();
    if (choose_mode(&s->options.mode, a->mode_name) || choose_engine(&s->engine, a->engine_name))
        return EXIT_MISUSED;
    if (a->step != 0 && s->engine != CVOL_ENGINE_RAY)
        return complain(EXIT_MISUSED, "--step is for engine ray; sheet takes one sheet a slice");
    if (a->step < 0)
        return complain(EXIT_MISUSED, "--step is %g, must be above 0", a->step);
    if (!(a->zoom > 0))
        return complain(EXIT_MISUSED, "--zoom is %g, must be above 0", a->zoom);
    if (a->common.level > 3)
        return complain(EXIT_MISUSED, "--level is %d, must be 0 to 3", a->common.level);
    for (int i = 0; i < 2; i++)
        if (a->size[i] > CVOL_IMAGE_SIZE_MAX)
            return complain(EXIT_MISUSED, "--size has %d, must be 1 to %d", a->size[i],
                            CVOL_IMAGE_SIZE_MAX);
    for (int k = 0; k < 3; k++)
        if (!(a->background[k] >= 0 && a->background[k] <= 1))
            return complain(EXIT_MISUSED, "--background has %g, each must be 0 to 1",
                            a->background[k]);
    s->options.width = a->size[0];
    s->options.height = a->size[1];
    s->options.camera = (cvol_camera){a->azimuth, a->elevation, a->roll, a->zoom};
    s->options.step_voxels = a->step;
    memcpy(s->options.background, a->background, sizeof a->background);
    return EXIT_DONE;
}

/* Whether the transfer function is one of the named ones; a file's name has a dot or a slash. */
static int is_file_name(const char *name)
{
    return strchr(name, '.') || strchr(name, '/');
}

static int make_transfer(cvol_context *context, cvol_transfer **transfer, const scene *s,
                         const char *name)
{
    int code;
    if (is_file_name(name)) {
        code = cvol_transfer_read(context, transfer, name);
        return code ? complain_context(context, code, NULL) : EXIT_DONE;
    }
    cvol_histogram histogram;
    code = s->in.array ? cvol_array_histogram(context, &histogram, s->in.array)
                       : cvol_volume_histogram(context, &histogram, s->in.volume);
    if (!code)
        code = cvol_transfer_create_named(context, transfer, name, &histogram);
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}

static int make_renderer(cvol_context *context, scene *s, const char *path)
{
    int status = s->engine == CVOL_ENGINE_SHEET ? need_array(context, &s->in, path, 0)
                                                : need_volume(context, &s->in);
    if (status)
        return status;
    int code = s->engine == CVOL_ENGINE_SHEET
                   ? cvol_renderer_create_sheet(context, &s->renderer, s->in.array)
                   : cvol_renderer_create_ray(context, &s->renderer, s->in.volume);
    if (code)
        return complain_context(context, code, NULL);
    /* What the engine does not look at need not stay in memory. */
    if (s->engine == CVOL_ENGINE_SHEET) {
        cvol_volume_free(s->in.volume);
        s->in.volume = NULL;
    }
    return EXIT_DONE;
}

int open_scene(cvol_context *context, scene *s, render_arguments *arguments, const char *path)
{
    double start = milliseconds();
    int status = open_input(context, &s->in, path, &arguments->common);
    if (!status && s->in.cut) {
        clear_progress();
        fprintf(stderr, "cvol: %s: ends early; drawn at level %d, which is whole\n", path,
                s->in.level);
    }
    if (!status)
        status = make_renderer(context, s, path);
    if (!status && s->options.mode == CVOL_MODE_COMPOSITE) {
        cvol_transfer *transfer = NULL;
        status = make_transfer(context, &transfer, s, arguments->transfer_name);
        int code = status ? 0 : cvol_renderer_set_transfer(context, s->renderer, transfer);
        if (code)
            status = complain_context(context, code, NULL);
        cvol_transfer_free(transfer);
    }
    s->load_ms = milliseconds() - start;
    return status;
}

void close_scene(scene *s)
{
    cvol_renderer_free(s->renderer);
    close_input(&s->in);
}
