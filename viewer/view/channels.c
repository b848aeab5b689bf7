/* Pictures of several channels, as cvol render draws them. */
#include "viewer/view/channels.h"

#include <math.h>
#include <string.h>

#include "viewer/volumes/colours.h"
#include "viewer/volumes/volume_renderers.h"

static int draw_one(cvol_context *context, const view *channel, cvol_image *image,
                    const cvol_render_options *options)
{
    cvol_render_options own = *options;
    idle_renderer *renderer = volume_take_renderer(context, channel->volume, 0);
    if (!renderer)
        return CVOL_ERROR_MEMORY;
    memcpy(own.window, channel->options.window, sizeof own.window);
    int code = view_set_transfer(context, renderer, channel);
    if (!code)
        code = volume_draw(context, channel->volume, renderer, image, &own);
    volume_return_renderer(channel->volume, renderer);
    return code;
}

/* ---- components of one colour -------------------------------------------------------------- */

static int is_alpha(const view *channel)
{
    return channel->volume->channel.is_component &&
           channel->volume->channel.number == CVOL_COLOURS_MAX - 1;
}

/* 1 if the channels are components of one colour, in mode composite; besides alpha there is one. */
static int are_components(const view *v)
{
    const view *first = &v->channels[0];
    int good = v->options.mode == CVOL_MODE_COMPOSITE && v->channel_count <= CVOL_COLOURS_MAX &&
               !is_alpha(first);
    for (int c = 0; c < v->channel_count && good; c++) {
        const view *one = &v->channels[c];
        good = one->volume->channel.is_component && !strcmp(one->transfer_name, VIEW_COMPONENT) &&
               one->volume->channel.first == first->volume->channel.first &&
               !(fabs(one->opacity_scale - first->opacity_scale) > 0) &&
               !memcmp(one->options.window, first->options.window, sizeof first->options.window) &&
               (!c || one->volume->channel.number > v->channels[c - 1].volume->channel.number);
    }
    return good;
}

static int draw_components(cvol_context *context, const view *v, cvol_image *image,
                           const cvol_render_options *options)
{
    colour_choice choice = {.count = (size_t)v->channel_count,
                            .opacity_scale = v->channels[0].opacity_scale};
    memcpy(choice.range, v->channels[0].options.window, sizeof choice.range);
    for (int c = 0; c < v->channel_count; c++) {
        choice.components[c] = v->channels[c].volume;
        memcpy(choice.rgb + 3 * c, v->channels[c].colour, 3 * sizeof *choice.rgb);
    }
    return colours_draw(context, volumes_colours(v->volume->all), &choice, image, options);
}

/* ---- channels ------------------------------------------------------------------------------ */

/* Adds the pictures of all channels but alpha. */
static int add_channels(cvol_context *context, const view *v, cvol_image *sum,
                        const cvol_render_options *options)
{
    const int is_grey = options->mode != CVOL_MODE_COMPOSITE;
    cvol_image *one = NULL;
    int code = cvol_image_create_float(context, &one, sum->width, sum->height);
    for (int c = 0; c < v->channel_count && !code; c++) {
        if (is_alpha(&v->channels[c]) && v->channel_count > 1)
            continue;
        code = draw_one(context, &v->channels[c], one, options);
        if (!code)
            code = cvol_image_add_light(context, sum, one, is_grey ? v->channels[c].colour : NULL);
    }
    cvol_image_free(one);
    return code;
}

int channels_draw(cvol_context *context, const view *v, cvol_image *image,
                  const cvol_render_options *options)
{
    cvol_image *sum = NULL;
    int code = cvol_image_create_float(context, &sum, image->width, image->height);
    if (!code)
        code = (are_components(v) ? draw_components : add_channels)(context, v, sum, options);
    if (!code)
        code = cvol_image_flatten(context, image, sum, options->background);
    cvol_image_free(sum);
    return code;
}
