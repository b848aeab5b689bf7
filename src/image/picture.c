/* Compressed pictures: from pixels to planes, and back. */
#include "image/picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/options.h"
#include "image/pixels.h"
#include "image/spline_warp.h"

/* ---- back to pixels ------------------------------------------------------------------------- */

/* Red, green and blue from their orthonormal mix, in place. */
static void unmix(float *planes[3], size_t count)
{
    const float a = (float)sqrt(1.0 / 3), b = (float)sqrt(0.5), c = (float)sqrt(1.0 / 6);
    for (size_t i = 0; i < count; i++) {
        const float x = a * planes[0][i], y = b * planes[1][i], z = c * planes[2][i];
        planes[0][i] = x + y + z;
        planes[1][i] = x - 2 * z;
        planes[2][i] = x - y + z;
    }
}

static uint8_t to_byte(float level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5f) : 255;
}

/* Planes that are the pixels. */
static void draw_pixels(cvol_context *context, cvol_image *image, const cvol_picture_source *source)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < CVOL_PICTURE_PLANES; c++)
            image->rgba[4 * i + (size_t)c] = source->planes[c] ? to_byte(source->planes[c][i])
                                                               : 255;
}

int cvol_picture_draw_planes(cvol_context *context, cvol_image *image,
                             const cvol_picture_source *source)
{
    const size_t count = source->lattice[0] * source->lattice[1];
    if (!source->is_over) {
        draw_pixels(context, image, source);
        return CVOL_OK;
    }
    float *places = cvol_allocate(4 * count, sizeof *places);
    if (!places)
        return cvol_fail_memory(context, 4 * count * sizeof *places, "a picture's lattice");
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 4; c++)
            places[4 * i + c] = source->planes[c][i];
    const int code = cvol_spline_warp(context, image, places, source->lattice,
                                      source->to_intermediate, source->background);
    free(places);
    return code;
}

int cvol_picture_draw(cvol_context *context, cvol_image *image, const cvol_picture *picture)
{
    const size_t *lattice = picture->lattice, count = lattice[0] * lattice[1];
    const size_t begin[3] = {0, 0, 0}, end[3] = {lattice[0], lattice[1], 1};
    float *planes[CVOL_PICTURE_PLANES] = {0};
    cvol_picture_source source = {.lattice = {lattice[0], lattice[1]},
                                  .width = picture->width,
                                  .height = picture->height,
                                  .is_over = picture->is_over};
    memcpy(source.background, picture->background, sizeof source.background);
    memcpy(source.to_intermediate, picture->to_intermediate, sizeof source.to_intermediate);
    int code = CVOL_OK;
    for (int c = 0; c < picture->plane_count && !code; c++) {
        planes[c] = cvol_allocate(count, sizeof(float));
        code = planes[c]
                   ? cvol_array_evaluate_real(context, planes[c], picture->planes[c], begin, end)
                   : cvol_fail_memory(context, count * sizeof(float), "a picture's planes");
        source.planes[c] = planes[c];
    }
    if (!code) {
        unmix(planes, count);
        code = cvol_picture_draw_planes(context, image, &source);
    }
    for (int c = 0; c < CVOL_PICTURE_PLANES; c++)
        free(planes[c]);
    return code;
}

int cvol_picture_evaluate(cvol_context *context, cvol_image **out, const cvol_picture *picture)
{
    const uint64_t bytes = 4 * (uint64_t)picture->width * (uint64_t)picture->height;
    *out = NULL;
    if (bytes > cvol_context_limit_bytes(context))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "a picture of %d x %d pixels", picture->width,
                         picture->height);
    cvol_image *image;
    int code = cvol_image_create(context, &image, picture->width, picture->height);
    if (code)
        return code;
    code = cvol_picture_draw(context, image, picture);
    if (code)
        cvol_image_free(image);
    else
        *out = image;
    return code;
}

/* ---- from pixels ---------------------------------------------------------------------------- */

static const cvol_picture_options defaults = {
    .size = sizeof(cvol_picture_options), .transform = CVOL_DCT, .block = 16, .psnr_db = 45};

void cvol_picture_options_set_defaults(cvol_picture_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}

int cvol_picture_options_complete(cvol_context *context, cvol_picture_options *out,
                                  const cvol_picture_options *options)
{
    *out = defaults;
    return cvol_options_copy(context, out, sizeof *out, CVOL_SIZE_TO(cvol_picture_options, psnr_db),
                             "cvol_picture_options", options);
}

static int has_alpha(const cvol_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        if (image->rgba[4 * i + 3] != 255)
            return 1;
    return 0;
}

int cvol_picture_compress(cvol_context *context, cvol_picture **out, const cvol_image *image,
                          const cvol_picture_options *options)
{
    cvol_picture_options full;
    *out = NULL;
    int code = cvol_picture_options_complete(context, &full, options);
    if (!code)
        code = cvol_image_need_bytes(context, image, "compressing");
    if (code)
        return code;
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const int count = has_alpha(image) ? 4 : 3;
    cvol_picture_source from = {.lattice = {(size_t)image->width, (size_t)image->height},
                                .width = image->width,
                                .height = image->height};
    float *levels = cvol_allocate((size_t)count * pixels, sizeof *levels);
    if (!levels)
        return cvol_fail_memory(context, (size_t)count * pixels * sizeof *levels, "a picture");
    for (int c = 0; c < count; c++) {
        float *plane = levels + (size_t)c * pixels;
        for (size_t i = 0; i < pixels; i++)
            plane[i] = (float)image->rgba[4 * i + (size_t)c] / 255;
        from.planes[c] = plane;
    }
    code = cvol_picture_make(context, out, &from, &full);
    free(levels);
    return code;
}
