/* Pictures as plain pixels, which need no decoding in a page. It takes the place of
 * viewer/base/encode.c. */
#include "viewer/base/encode.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

answer encode_picture(cvol_context *context, const cvol_image *image, int quality)
{
    const size_t bytes = 4 * (size_t)image->width * (size_t)image->height;
    void *pixels = malloc(bytes);
    (void)context;
    (void)quality;
    if (!pixels)
        return answer_error(500, "not enough memory for a picture");
    memcpy(pixels, image->rgba, bytes);
    answer a = answer_bytes("image/x-rgba", pixels, bytes, free);
    char size[32];
    snprintf(size, sizeof size, "%d %d", image->width, image->height);
    answer_header(&a, "Cvol-Size", size);
    return a;
}
