/* Several channels in one picture: the renderer draws each channel in its own colour, then the
 * pictures are added, like the light of dyes, and clipped at white.
 *
 * The channels of RGB files are the components of one colour: they share one window, and a picture
 * shows the colours of the samples.
 */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

/* 1 if pictures of this mode and format can be added. */
static int can_be_added(const scene *s, const render_arguments *a)
{
    const cvol_mode mode = s->options.mode;
    return (mode == CVOL_MODE_COMPOSITE || mode == CVOL_MODE_MIP || mode == CVOL_MODE_XRAY) &&
           picture_kind_of(a->output) != PICTURE_CVI && !a->depth_name && !a->budget_given;
}

/* Colours from the options, the file, or the defaults. *are_components: the channels are red, green
 * and blue of one colour. */
static int find_colours(cvol_context *context, double *colours, int *are_components, int channels,
                        render_arguments *a, const char *path)
{
    *are_components = 0;
    if (a->channel_colours)
        return parse_colours(colours, channels, a->channel_colours);
    volume_labels labels;
    const int status = find_labels(context, &labels, &a->common, path, 1, channels);
    if (!status)
        memcpy(colours, labels.colours, 3 * (size_t)channels * sizeof *colours);
    *are_components = !status && labels.are_colours;
    free_labels(&labels);
    return status;
}

/* Mode composite: the value of a component gives the brightness of its colour. */
static int show_component(cvol_context *context, scene *s, const double range[2],
                          double opacity_scale)
{
    cvol_histogram h;
    cvol_transfer *plain = NULL, *own = NULL;
    const int is_known = !find_histogram(context, &h, s);
    int code = cvol_transfer_create_component(context, &plain, is_known ? &h : NULL, range,
                                              s->colour);
    if (!code)
        code = cvol_transfer_create_adjusted(context, &own, plain, NULL, opacity_scale);
    if (!code)
        code = cvol_renderer_set_transfer(context, s->renderer, own);
    cvol_transfer_free(plain);
    cvol_transfer_free(own ? s->transfer : NULL);
    if (own)
        s->transfer = own;
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* Opens a component of a colour; all three share one window. */
static int open_component(cvol_context *context, scene *s, render_arguments *a, const char *path)
{
    double range[2];
    a->common.are_colours = 1;
    int status = open_scene(context, s, a, path);
    if (status)
        return status;
    cvol_component_get_range(range, input_grid(&s->in)->type);
    if (a->window_text)
        for (int k = 0; k < 2; k++)
            range[k] = a->window[0] + (k ? 0.5 : -0.5) * a->window[1];
    if (s->options.mode == CVOL_MODE_COMPOSITE)
        return show_component(context, s, range, a->opacity_scale);
    memcpy(s->options.window, range, sizeof range);
    return EXIT_DONE;
}

/* Mode composite: replaces the colours of the transfer function by that of the channel, at the same
 * brightness. */
static int recolour(cvol_context *context, scene *s)
{
    cvol_transfer *own = NULL;
    int code = s->transfer ? cvol_transfer_create_tinted(context, &own, s->transfer, s->colour)
                           : CVOL_OK;
    if (!code && own)
        code = cvol_renderer_set_transfer(context, s->renderer, own);
    if (own) {
        cvol_transfer_free(s->transfer);
        s->transfer = own;
    }
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

static int open_channel(cvol_context *context, scene *s, const render_arguments *arguments,
                        int channel, int is_component, const char *path)
{
    render_arguments a = *arguments;
    a.common.read.has_channel = 1;
    a.common.read.channel = channel;
    a.is_channel = 1;
    if (!a.light_text && !a.shade) { /* colours add up; light of each would not */
        s->options.shading.on = 0;
        s->options.illumination = (cvol_illumination){.fill = 0};
    }
    if (is_component && !a.transfer_given && !a.window_auto)
        return open_component(context, s, &a, path);
    if (!a.transfer_given)
        a.transfer_name = "microscopy";
    if (s->options.mode != CVOL_MODE_COMPOSITE && !a.window_text) {
        a.window_auto = 1;
        a.window[1] = 1;
    }
    const int status = open_scene(context, s, &a, path);
    return status || s->options.mode != CVOL_MODE_COMPOSITE ? status : recolour(context, s);
}

/* *out: 1 if a shape with colours is drawn. Exit status. */
static int has_shape(cvol_context *context, int *out, const scene *s, render_arguments *a,
                     const char *path, int channels)
{
    volume_labels labels;
    *out = 0;
    if (channels < 2 || !can_draw_colours(s, a))
        return EXIT_DONE;
    const int status = find_labels(context, &labels, &a->common, path, 1, channels);
    *out = !status && labels.are_colours && channels <= CVOL_COLOURS_MAX;
    free_labels(&labels);
    return status;
}

int count_drawn(cvol_context *context, const scene *s, render_arguments *a, const char *path,
                int *times, int *channels)
{
    const cvol_file_kind kind = kind_of(path);
    int status = EXIT_DONE;
    *times = *channels = 1;
    if (kind == CVOL_FILE_SERIES || kind == CVOL_FILE_OTHER)
        status = count_volumes(context, &a->common, path, times, channels);
    if (!status && !can_be_added(s, a)) {
        int are_colours;
        status = has_shape(context, &are_colours, s, a, path, *channels);
        *channels = are_colours ? *channels : 1;
    }
    return status;
}

/* Chooses the first of several times of a file that is no .cvol, and prints that once. */
static void choose_first_time(render_arguments *a, const char *path, int times)
{
    if (times < 2 || a->common.read.has_index || is_cvol(path))
        return;
    a->common.read.has_index = 1;
    a->common.read.index = 0;
    clear_progress();
    fprintf(stderr, "cvol: %s: using time 0 of %d; --time chooses another\n", path, times);
}

int open_channels(cvol_context *context, scene *s, render_arguments *a, const char *path)
{
    int times, channels;
    int status = count_drawn(context, s, a, path, &times, &channels);
    if (status)
        return status;
    choose_first_time(a, path, times);
    if (channels == 1)
        return a->channel_colours
                   ? report_error(EXIT_MISUSED,
                                  "%s: --channel-colors needs several channels, mode "
                                  "composite, mip or xray, and a PNG or PFM",
                                  path)
                   : open_scene(context, s, a, path);
    if (channels > CHANNELS_MAX)
        return report_error(EXIT_MISUSED,
                            "%s: has %d channels, more than %d: choose one with --channel", path,
                            channels, CHANNELS_MAX);
    double colours[3 * CHANNELS_MAX];
    int are_components;
    status = find_colours(context, colours, &are_components, channels, a, path);
    if (status)
        return status;
    if (are_components && can_draw_colours(s, a) && channels <= CVOL_COLOURS_MAX)
        return open_colours(context, s, a, colours, channels, path);
    const char *detail = a->light_text || a->shade ? NULL : find_light_detail(a);
    if (detail)
        return report_error(EXIT_MISUSED,
                            "%s: %s needs a light, and channels that are added have none: give "
                            "--light, or choose a channel with --channel",
                            path, detail);
    if (are_components && channels == 4) {
        channels = 3;
        clear_progress();
        fprintf(stderr, "cvol: %s: the alpha channel is not drawn; --channel 3 draws it\n", path);
    }
    const scene fresh = *s;
    double load_ms = 0;
    scene *others = calloc((size_t)channels, sizeof *others);
    if (!others)
        return report_error(EXIT_FAILED, "not enough memory");
    for (int c = 0; c < channels && !status; c++) {
        scene *of = c ? &others[c - 1] : s;
        *of = fresh;
        memcpy(of->colour, colours + 3 * c, sizeof of->colour);
        if (fresh.shared)
            of->shared = fresh.shared + c;
        status = open_channel(context, of, a, c, are_components, path);
        load_ms += of->load_ms;
        a->common.choice_printed = 1; /* the first channel printed it */
        if (!c)
            s->others = others;
        else
            s->other_count = c;
    }
    s->load_ms = load_ms;
    return status ? status : aim_camera(context, s, a, 0); /* one frame for all */
}

int draw_channels(cvol_context *context, scene *s, cvol_image *image)
{
    cvol_image *one;
    int code = cvol_image_create_float(context, &one, image->width, image->height);
    for (int c = 0; c <= s->other_count && !code; c++) {
        scene *of = c ? &s->others[c - 1] : s;
        code = cvol_renderer_render(context, of->renderer, one, &of->options);
        if (!code)
            code = cvol_image_add_light(context, image, one,
                                        is_grey_mode(of->options.mode) ? of->colour : NULL);
    }
    cvol_image_free(one);
    return code;
}
