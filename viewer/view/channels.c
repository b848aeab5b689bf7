/* Pictures of several channels, as cvol render draws them. */
#include "viewer/view/channels.h"

#include <string.h>

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

int channels_draw(cvol_context *context, const view *v, cvol_image *image,
                  const cvol_render_options *options)
{
    const int is_grey = options->mode != CVOL_MODE_COMPOSITE;
    cvol_image *sum = NULL, *one = NULL;
    int code = cvol_image_create_float(context, &sum, image->width, image->height);
    if (!code)
        code = cvol_image_create_float(context, &one, image->width, image->height);
    for (int c = 0; c < v->channel_count && !code; c++) {
        code = draw_one(context, &v->channels[c], one, options);
        if (!code)
            code = cvol_image_add_light(context, sum, one, is_grey ? v->channels[c].colour : NULL);
    }
    if (!code)
        code = cvol_image_flatten(context, image, sum, options->background);
    cvol_image_free(one);
    cvol_image_free(sum);
    return code;
}
