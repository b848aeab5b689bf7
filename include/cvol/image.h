/* cvol/image.h - pictures: 8-bit RGBA rows or floats, PNG and PFM files, differences. */
#ifndef CVOL_IMAGE_H
#define CVOL_IMAGE_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* width x height pixels, top row first: four bytes R G B A per pixel in `rgba` (A straight, not
 * premultiplied), or four floats per pixel in `values`; the other pointer is NULL. Floats are the
 * result of a renderer, not rounded and over no background: R, G and B times A, and A, each 0..1,
 * or slightly outside where a filter overshoots. Only functions that say so accept pictures of
 * floats. */
typedef struct cvol_image {
    int width, height;
    uint8_t *rgba;
    float *values;
    float *depth; /* depth of each pixel (cvol_image_add_depth), or NULL */
} cvol_image;

/* The largest width and height of a picture. */
#define CVOL_IMAGE_SIZE_MAX 32768

/* Makes a black, transparent picture of bytes. The caller frees it. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_create(cvol_context *context, cvol_image **out, int width, int height);
/* Makes a picture of floats, all 0. The caller frees it. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_create_float(cvol_context *context, cvol_image **out, int width,
                                     int height);
/* Adds room for depths, which renderers then fill: for each pixel the distance, along the viewing
 * direction in world length, to the place where the opacity of the ray reaches one half, or to the
 * surface of mode iso; infinity if there is none. The distance is from the plane through the eye,
 * or, in parallel projection, from the plane that touches the sphere around the box of the volume
 * (half its diagonal before its centre). Errors: MEMORY. */
CVOL_API int cvol_image_add_depth(cvol_context *context, cvol_image *image);
/* Frees a picture of either kind; NULL is allowed. */
CVOL_API void cvol_image_free(cvol_image *image);

/* Rounds a picture of floats to bytes, in `out` of the same size: over a background R G B, as
 * renderers do, or (NULL) with straight alpha. Errors: ARGUMENT. */
CVOL_API int cvol_image_flatten(cvol_context *context, cvol_image *out, const cvol_image *image,
                                const double background[3]);
/* Adds a picture of floats to `sum`, of the same size, like the light of a dye, and clips the
 * colours at 1. With rgb (not NULL) the picture is grey and gets this colour. Errors: ARGUMENT. */
CVOL_API int cvol_image_add_light(cvol_context *context, cvol_image *sum, const cvol_image *image,
                                  const double *rgb);
/* Exchanges left and right, in place; for bytes, floats and depths. */
CVOL_API void cvol_image_mirror(cvol_image *image);

/* Reads any PNG as 8-bit RGBA. Errors: IO, FORMAT, LIMIT, MEMORY. */
CVOL_API int cvol_image_read_png(cvol_context *context, cvol_image **out, const char *path);
/* Writes a PNG: RGB if every pixel is opaque, else RGBA. The file gets its name only when it is
 * complete. Errors: IO, MEMORY. */
CVOL_API int cvol_image_write_png(cvol_context *context, const cvol_image *image, const char *path);
/* Compression level of a PNG: 0 to 9 as in zlib (files have 6), or CVOL_PNG_QUICK, for pictures
 * that are shown once: about a tenth more bytes in an eighth of the time. */
#define CVOL_PNG_QUICK (-1)
/* Writes a PNG to memory: *size bytes at *out, which the caller frees with free(). After an error
 * *out is NULL. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_encode_png(cvol_context *context, const cvol_image *image, int level,
                                   void **out, size_t *size);
/* Writes a JPEG of a picture of bytes, without its opacity; quality: 1 to 100. The file gets its
 * name only when it is complete. Errors: ARGUMENT, UNSUPPORTED (a build without libturbojpeg), IO,
 * MEMORY. */
CVOL_API int cvol_image_write_jpeg(cvol_context *context, const cvol_image *image, int quality,
                                   const char *path);
/* Writes a WebP of a picture of bytes, with its opacity; quality: 0 to 99, or 100 without loss. The
 * file gets its name only when it is complete. Errors: ARGUMENT, UNSUPPORTED (a build without
 * libwebp), LIMIT (more than 16383 pixels a side), IO, MEMORY. */
CVOL_API int cvol_image_write_webp(cvol_context *context, const cvol_image *image, int quality,
                                   const char *path);
/* Writes a picture of floats as a PNG with 16 bits per channel: over a background R G B, or (NULL)
 * with straight alpha. With `grey` it has one channel, R. Errors: ARGUMENT, IO, MEMORY. */
CVOL_API int cvol_image_write_png16(cvol_context *context, const cvol_image *image,
                                    const double background[3], int grey, const char *path);
/* Writes a picture of floats over a background as a portable float map (PFM, low byte first): RGB,
 * or with `grey` only R. Errors: ARGUMENT, IO, MEMORY. */
CVOL_API int cvol_image_write_pfm(cvol_context *context, const cvol_image *image,
                                  const double background[3], int grey, const char *path);
/* Writes the depths of a picture that has them as a PFM of one channel. Errors: ARGUMENT, IO,
 * MEMORY. */
CVOL_API int cvol_image_write_depth(cvol_context *context, const cvol_image *image,
                                    const char *path);
/* Writes the opacity of a picture of floats, within 0 and 1, as a PFM of one channel. Errors:
 * ARGUMENT, IO, MEMORY. */
CVOL_API int cvol_image_write_opacity(cvol_context *context, const cvol_image *image,
                                      const char *path);

/* The difference of picture b from picture a, over R, G and B:
 *
 *     psnr_db            = 10 log10(255^2 / mean squared difference), infinity if they are equal
 *     psnr_foreground_db = the same over pixels where either picture has a channel above 2
 *     ssim               = mean structural similarity (Wang et al. 2004; window 7x7, uniform,
 * sample covariance, K = 0.01, 0.03, L = 255), mean over the three channels. */
typedef struct cvol_image_difference {
    double psnr_db, psnr_foreground_db, ssim, rmse, max_abs_error;
    size_t foreground_pixels;
} cvol_image_difference;
/* Compares two pictures of bytes of the same size. Errors: ARGUMENT (sizes), MEMORY. */
CVOL_API int cvol_image_compare(cvol_context *context, cvol_image_difference *out,
                                const cvol_image *a, const cvol_image *b);

#ifdef __cplusplus
}
#endif
#endif
