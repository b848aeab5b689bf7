/* Pictures in memory: width x height pixels R G B A, the top row first. */
#include "cvol/image.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

int cvol_image_create(cvol_context *context, cvol_image **out, int width, int height)
{
    *out = NULL;
    if (width < 1 || height < 1 || width > CVOL_IMAGE_SIZE_MAX || height > CVOL_IMAGE_SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a picture of %d x %d pixels: width and height are 1 to %d", width, height,
                         CVOL_IMAGE_SIZE_MAX);
    size_t pixels = (size_t)width * (size_t)height;
    cvol_image *image = calloc(1, sizeof *image);
    if (!image)
        return cvol_fail_memory(context, sizeof *image, "a picture");
    image->width = width;
    image->height = height;
    image->rgba = cvol_allocate_zero(pixels, 4);
    if (!image->rgba) {
        free(image);
        return cvol_fail_memory(context, pixels * 4, "a picture");
    }
    *out = image;
    return CVOL_OK;
}

void cvol_image_free(cvol_image *image)
{
    if (!image)
        return;
    free(image->rgba);
    free(image);
}
