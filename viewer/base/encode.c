/* Encodes pictures as PNG and JPEG. */
#include "viewer/base/encode.h"

#include <stdlib.h>
#include <turbojpeg.h>

/* Level of zlib: fast. */
enum { PNG_LEVEL = 1 };

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
    void *bytes = NULL;
    size_t size = 0;
    const int code = cvol_image_encode_png(context, image, PNG_LEVEL, &bytes, &size);
    return code ? answer_error(500, "%s", answer_message(context, code))
                : answer_bytes("image/png", bytes, size, free);
}

answer encode_picture(cvol_context *context, const cvol_image *image, int quality)
{
    return quality ? encode_jpeg(image, quality) : encode_png(context, image);
}
