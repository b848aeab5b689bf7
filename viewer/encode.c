/* Pictures as the bytes of PNG and JPEG files. */
#include "encode.h"

#include <stdlib.h>
#include <turbojpeg.h>

#include <png.h>

static void free_jpeg(void *bytes)
{
    tjFree(bytes);
}

static answer encode_jpeg(const cvol_image *image, int quality)
{
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    tjhandle encoder = tjInitCompress();
    if (!encoder)
        return answer_error(500, "not enough memory for a JPEG");
    const int subsampling = quality >= 90 ? TJSAMP_444 : TJSAMP_420;
    const int failed = tjCompress2(encoder, image->rgba, image->width, 4 * image->width,
                                   image->height, TJPF_RGBX, &bytes, &size, subsampling, quality,
                                   TJFLAG_FASTDCT);
    const answer a = failed ? answer_error(500, "JPEG: %s", tjGetErrorStr2(encoder))
                            : answer_bytes("image/jpeg", bytes, size, free_jpeg);
    if (failed)
        tjFree(bytes);
    tjDestroy(encoder);
    return a;
}

static answer encode_png(cvol_context *context, const cvol_image *image)
{
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGBA,
                     .flags = PNG_IMAGE_FLAG_FAST};
    png_alloc_size_t size = 0;
    (void)context;
    png_image_write_to_memory(&png, NULL, &size, 0, image->rgba, 0, NULL);
    void *bytes = malloc(size);
    png_image_write_to_memory(&png, bytes, &size, 0, image->rgba, 0, NULL);
    return answer_bytes("image/png", bytes, size, free);
}

answer encode_picture(cvol_context *context, const cvol_image *image, int quality)
{
    return quality ? encode_jpeg(image, quality) : encode_png(context, image);
}
