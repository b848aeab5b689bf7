/* Pictures in memory: width x height pixels R G B A, bytes or floats, the top row first. */
#include "cvol/image.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

static int create(cvol_context *context, cvol_image **out, int width, int height, int floats)
{
    *out = NULL;
    if (width < 1 || height < 1 || width > CVOL_IMAGE_SIZE_MAX || height > CVOL_IMAGE_SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a picture of %d x %d pixels: width and height are 1 to %d", width, height,
                         CVOL_IMAGE_SIZE_MAX);
    const size_t pixels = (size_t)width * (size_t)height, pixel = floats ? 4 * sizeof(float) : 4;
    cvol_image *image = calloc(1, sizeof *image);
    if (!image)
        return cvol_fail_memory(context, sizeof *image, "a picture");
    image->width = width;
    image->height = height;
    void *memory = cvol_allocate_zero(pixels, pixel);
    if (!memory) {
        free(image);
        return cvol_fail_memory(context, pixels * pixel, "a picture");
    }
    if (floats)
        image->values = memory;
    else
        image->rgba = memory;
    *out = image;
    return CVOL_OK;
}

int cvol_image_create(cvol_context *context, cvol_image **out, int width, int height)
{
    return create(context, out, width, height, 0);
}

int cvol_image_create_float(cvol_context *context, cvol_image **out, int width, int height)
{
    return create(context, out, width, height, 1);
}

int cvol_image_add_depth(cvol_context *context, cvol_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    if (!image->depth)
        image->depth = cvol_allocate_zero(pixels, sizeof *image->depth);
    return image->depth ? CVOL_OK
                        : cvol_fail_memory(context, pixels * sizeof *image->depth, "depths");
}

static void swap(uint8_t *a, uint8_t *b, size_t size)
{
    uint8_t kept[4 * sizeof(float)];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

static void mirror(void *memory, size_t pixel, const cvol_image *image)
{
    const size_t width = (size_t)image->width;
    for (int y = 0; y < image->height; y++) {
        uint8_t *row = (uint8_t *)memory + (size_t)y * width * pixel;
        for (size_t x = 0; x < width / 2; x++)
            swap(row + x * pixel, row + (width - 1 - x) * pixel, pixel);
    }
}

void cvol_image_mirror(cvol_image *image)
{
    if (image->values)
        mirror(image->values, 4 * sizeof(float), image);
    else
        mirror(image->rgba, 4, image);
    if (image->depth)
        mirror(image->depth, sizeof *image->depth, image);
}

void cvol_image_free(cvol_image *image)
{
    if (!image)
        return;
    free(image->rgba);
    free(image->values);
    free(image->depth);
    free(image);
}
