/* Pictures as JPEG (libturbojpeg) and WebP (libwebp). */
#include <stdlib.h>

#include "base/context.h"
#include "base/file.h"
#include "image/pixels.h"

#ifdef CVOL_HAVE_TURBOJPEG
#include <turbojpeg.h>
#endif
#ifdef CVOL_HAVE_WEBP
#include <webp/encode.h>
#endif

/* From this quality on, colours have the resolution of brightness. */
#define FULL_COLOUR 90
#define WEBP_SIDE_MAX 16383

static int check(cvol_context *context, const cvol_image *image, int quality, int least,
                 const char *path)
{
    const int code = cvol_image_need_bytes(context, image, path);
    if (!code && (quality < least || quality > 100))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "quality is %d, must be %d to 100", quality,
                         least);
    return code;
}

#if defined(CVOL_HAVE_TURBOJPEG) || defined(CVOL_HAVE_WEBP)
static int write_bytes(cvol_context *context, const void *bytes, size_t size, const char *path)
{
    cvol_output *output;
    int code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    code = cvol_output_write(context, output, bytes, size);
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}
#endif

#ifdef CVOL_HAVE_TURBOJPEG
static int write_jpeg(cvol_context *context, const cvol_image *image, int quality, const char *path)
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
        code = write_bytes(context, bytes, size, path);
    tjFree(bytes);
    tjDestroy(encoder);
    return code;
}
#else
static int write_jpeg(cvol_context *context, const cvol_image *image, int quality, const char *path)
{
    (void)image;
    (void)quality;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s: this build has no JPEG (libturbojpeg)",
                     path);
}
#endif

#ifdef CVOL_HAVE_WEBP
static int write_webp(cvol_context *context, const cvol_image *image, int quality, const char *path)
{
    uint8_t *bytes = NULL;
    if (image->width > WEBP_SIDE_MAX || image->height > WEBP_SIDE_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: WebP has at most %d pixels a side, the picture has %d x %d", path,
                         WEBP_SIDE_MAX, image->width, image->height);
    const size_t size = quality == 100
                            ? WebPEncodeLosslessRGBA(image->rgba, image->width, image->height,
                                                     4 * image->width, &bytes)
                            : WebPEncodeRGBA(image->rgba, image->width, image->height,
                                             4 * image->width, (float)quality, &bytes);
    const int code = size ? write_bytes(context, bytes, size, path)
                          : cvol_fail_memory(context, 0, "a WebP encoder");
    WebPFree(bytes);
    return code;
}
#else
static int write_webp(cvol_context *context, const cvol_image *image, int quality, const char *path)
{
    (void)image;
    (void)quality;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s: this build has no WebP (libwebp)", path);
}
#endif

int cvol_image_write_jpeg(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    const int code = check(context, image, quality, 1, path);
    return code ? code : write_jpeg(context, image, quality, path);
}

int cvol_image_write_webp(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    const int code = check(context, image, quality, 0, path);
    return code ? code : write_webp(context, image, quality, path);
}
