/* Pictures of surfaces without jagged edges (engine.h).
 *
 * A ray either hits a surface or misses it, so with one ray per pixel edges are stairs, and rough
 * surfaces are specks. The picture is drawn with two rays per pixel along each axis, and a pixel is
 * the mean of its four: of their colours as they are stored, from 0 to 1. Its depth is their mean,
 * too, if they meet one surface; else that of the second nearest, at which the opacity reaches one
 * half. */
#include "render/engine/engine.h"

#include <math.h>

#include "base/context.h"

/* Rays per pixel along each axis. */
#define FINER 2
/* Rays whose depths differ by more than this number of finer pixels meet different surfaces. */
#define ONE_SURFACE 8

int cvol_antialias_suits(const cvol_render_options *options)
{
    const int largest = CVOL_IMAGE_SIZE_MAX / FINER;
    return options->mode == CVOL_MODE_ISO && !(options->oversample > 0) && options->level == 0 &&
           options->width <= largest && options->height <= largest && options->rows.of <= largest;
}

/* The first of the finer pixels of pixel (x, y), and of the finer row below. */
static void find_pixels(size_t at[2], const cvol_image *fine, int x, int y)
{
    at[0] = (size_t)(FINER * y) * (size_t)fine->width + (size_t)(FINER * x);
    at[1] = at[0] + (size_t)fine->width;
}

static void mean_of_bytes(uint8_t *out, const uint8_t *near, const uint8_t *below)
{
    for (int c = 0; c < 4; c++)
        out[c] = (uint8_t)((near[c] + near[c + 4] + below[c] + below[c + 4] + 2) / 4);
}

/* A colour or an opacity as bytes have it: interpolation overshoots next to edges. */
static float within_bytes(float value)
{
    return fminf(fmaxf(value, 0), 1);
}

/* The mean of the four colours over the background, as bytes have them, without the background's
 * share: where light is brighter than white, it does not shine through other rays. */
static void mean_of_floats(float *out, const float *near, const float *below,
                           const double background[3])
{
    const float *const rays[4] = {near, near + 4, below, below + 4};
    float opacity = 0;
    for (int k = 0; k < 4; k++)
        opacity += 0.25f * within_bytes(rays[k][3]);
    for (int c = 0; c < 3; c++) {
        const float ground = (float)background[c];
        float sum = 0;
        for (int k = 0; k < 4; k++)
            sum += within_bytes(rays[k][c] + (1 - within_bytes(rays[k][3])) * ground);
        out[c] = 0.25f * sum - (1 - opacity) * ground;
    }
    out[3] = opacity;
}

static float mean_of_depths(const float *near, const float *below, double pixel)
{
    const float all[4] = {near[0], near[1], below[0], below[1]};
    float nearest = INFINITY, second = INFINITY, farthest = 0;
    for (int k = 0; k < 4; k++) {
        second = all[k] < nearest ? nearest : fminf(second, all[k]);
        nearest = fminf(nearest, all[k]);
        farthest = fmaxf(farthest, all[k]);
    }
    return farthest - nearest <= ONE_SURFACE * pixel ? (all[0] + all[1] + all[2] + all[3]) / 4
                                                     : second;
}

static void average(cvol_image *image, const cvol_image *fine, double size_of_pixel,
                    const double background[3])
{
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            const size_t pixel = (size_t)y * (size_t)image->width + (size_t)x;
            size_t at[2];
            find_pixels(at, fine, x, y);
            if (image->values)
                mean_of_floats(image->values + 4 * pixel, fine->values + 4 * at[0],
                               fine->values + 4 * at[1], background);
            else
                mean_of_bytes(image->rgba + 4 * pixel, fine->rgba + 4 * at[0],
                              fine->rgba + 4 * at[1]);
            if (image->depth)
                image->depth[pixel] = mean_of_depths(fine->depth + at[0], fine->depth + at[1],
                                                     size_of_pixel);
        }
}

int cvol_antialias_draw(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                        const cvol_render_options *options)
{
    cvol_render_options finer = *options;
    cvol_image *fine;
    cvol_view view;
    finer.width = FINER * image->width;
    finer.height = FINER * image->height;
    finer.rows.first *= FINER;
    finer.rows.of *= FINER;
    int code = image->values ? cvol_image_create_float(context, &fine, finer.width, finer.height)
                             : cvol_image_create(context, &fine, finer.width, finer.height);
    if (code)
        return code;
    if (image->depth)
        code = cvol_image_add_depth(context, fine);
    if (!code)
        code = cvol_view_make(context, &view, &renderer->grid, &finer);
    if (!code)
        code = renderer->engine->draw(context, renderer->state, fine, &view, &finer);
    if (!code)
        average(image, fine, view.pixel, options->background);
    cvol_image_free(fine);
    return code;
}
