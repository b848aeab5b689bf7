/* JPEG as slices of a volume, by libturbojpeg: grey files have one channel, all others three. */
#include <stdlib.h>
#include <turbojpeg.h>

#include "base/context.h"
#include "base/file.h"
#include "volume/formats/pictures/picture.h"

/* By Huffman's codes each block of 8 x 8 pixels takes a bit at least: 512 pixels a byte. Arithmetic
 * codes, which are rare, may take less: 64 times as many pixels are believed. */
#define PIXELS_PER_BYTE_MOST 32768

static int fail_jpeg(cvol_context *context, tjhandle decoder, const char *path)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: JPEG: %s", path, tjGetErrorStr2(decoder));
}

static int decode(cvol_context *context, cvol_picture *out, tjhandle decoder, const cvol_map *file,
                  const char *path)
{
    int width = 0, height = 0, sampling, space = 0;
    if (tjDecompressHeader3(decoder, file->data, (unsigned long)file->size, &width, &height,
                            &sampling, &space))
        return fail_jpeg(context, decoder, path);
    if (space == TJCS_CMYK || space == TJCS_YCCK)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: its colours are those of printers (CMYK), which are not supported",
                         path);
    *out = (cvol_picture){.width = (size_t)width,
                          .height = (size_t)height,
                          .channels = space == TJCS_GRAY ? 1 : 3,
                          .bits = 8};
    const int code = cvol_picture_check(context, out, path);
    if (code)
        return code;
    if (out->width * out->height / PIXELS_PER_BYTE_MOST > file->size)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: %zu bytes cannot hold the %d x %d pixels that its header claims",
                         path, file->size, width, height);
    const size_t bytes = out->width * out->height * (size_t)out->channels;
    out->pixels = malloc(bytes);
    if (!out->pixels)
        return cvol_fail_memory(context, bytes, path);
    return tjDecompress2(decoder, file->data, (unsigned long)file->size, out->pixels, width,
                         width * out->channels, height, out->channels == 1 ? TJPF_GRAY : TJPF_RGB,
                         TJFLAG_ACCURATEDCT)
               ? fail_jpeg(context, decoder, path)
               : CVOL_OK;
}

int cvol_picture_read_jpeg(cvol_context *context, cvol_picture *out, const char *path)
{
    cvol_map file;
    *out = (cvol_picture){0};
    int code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    tjhandle decoder = tjInitDecompress();
    code = decoder ? decode(context, out, decoder, &file, path)
                   : cvol_fail_memory(context, 0, "a JPEG decoder");
    if (decoder)
        tjDestroy(decoder);
    cvol_file_unmap(&file);
    if (code) {
        free(out->pixels);
        out->pixels = NULL;
    }
    return code;
}
