/* Pictures that are added like light, and clipped at white. Microscopes and composites of Fiji add
 * too; they do not screen (1 - product of 1 - c). Green and magenta of equal strength give white,
 * and a channel looks the same where the others are dark. */
#include <math.h>

#include "base/context.h"
#include "cvol/image.h"

int cvol_image_add_light(cvol_context *context, cvol_image *sum, const cvol_image *image,
                         const double *rgb)
{
    if (!sum->values || !image->values || sum->width != image->width ||
        sum->height != image->height)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "pictures to add must be floats of the same size, are %d x %d and %d x %d",
                         sum->width, sum->height, image->width, image->height);
    const size_t pixels = (size_t)sum->width * (size_t)sum->height;
    for (size_t i = 0; i < pixels; i++) {
        const float *from = image->values + 4 * i;
        float *to = sum->values + 4 * i;
        for (int k = 0; k < 3; k++)
            to[k] = fminf(1, to[k] + (rgb ? (float)rgb[k] * from[k] : from[k]));
        to[3] = rgb ? fmaxf(to[3], from[3]) : to[3] + from[3] - to[3] * from[3];
    }
    return CVOL_OK;
}
