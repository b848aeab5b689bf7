/* JPEG files, by libturbojpeg. */
#include <turbojpeg.h>

#include "base/context.h"
#include "image/photo.h"

/* From this quality on, colours have the resolution of brightness. */
#define FULL_COLOUR 90

int cvol_photo_write_jpeg(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    tjhandle encoder = tjInitCompress();
    if (!encoder)
        return cvol_fail_memory(context, 0, "a JPEG encoder");
    int code;
    if (tjCompress2(encoder, image->rgba, image->width, 4 * image->width, image->height, TJPF_RGBX,
                    &bytes, &size, quality >= FULL_COLOUR ? TJSAMP_444 : TJSAMP_420, quality,
                    TJFLAG_ACCURATEDCT))
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: JPEG: %s", path, tjGetErrorStr2(encoder));
    else
        code = cvol_photo_write_bytes(context, bytes, size, path);
    tjFree(bytes);
    tjDestroy(encoder);
    return code;
}
