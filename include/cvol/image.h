/* cvol/image.h - pictures: 8-bit RGBA rows or floats, PNG and PFM files, differences. */
#ifndef CVOL_IMAGE_H
#define CVOL_IMAGE_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* width x height pixels, the top row first: of four bytes R G B A (A: straight, not premultiplied)
 * in `rgba`, or of four floats in `values`, and then rgba is NULL. Floats are what a renderer
 * computed, not rounded and over no background: R G B times A, and A, each 0..1 or, where a filter
 * overshoots, a little beyond. Only functions that say so take pictures of floats. */
typedef struct cvol_image {
    int width, height;
    uint8_t *rgba;
    float *values;
    float *depth; /* NULL, or for each pixel: how far away what is seen is (cvol_image_add_depth) */
} cvol_image;

/* Largest width or height of a picture. */
#define CVOL_IMAGE_SIZE_MAX 32768

/* A black, transparent picture. The caller frees it. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_create(cvol_context *context, cvol_image **out, int width, int height);
/* One of floats, all 0. The caller frees it. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_create_float(cvol_context *context, cvol_image **out, int width,
                                     int height);
/* Makes room for depths, which renderers then tell with the picture: of each pixel the distance,
 * along the viewing direction and in world length, of the place where the opacity of what the ray
 * has passed reaches one half, or of mode iso's surface; infinity where it never does. It is the
 * distance from the plane through the eye, or, in parallel projection, from the one that touches
 * the ball around the volume's box (half its diagonal before its centre). Errors: MEMORY. */
CVOL_API int cvol_image_add_depth(cvol_context *context, cvol_image *image);
/* Frees a picture of either kind; NULL is allowed. */
CVOL_API void cvol_image_free(cvol_image *image);

/* Rounds a picture of floats to bytes, in `out` of the same size: over a background R G B, as
 * renderers do, or (NULL) with straight alpha, so that it looks the same over any. Errors:
 * ARGUMENT.
 */
CVOL_API int cvol_image_flatten(cvol_context *context, cvol_image *out, const cvol_image *image,
                                const double background[3]);
/* Turns left and right round, in place; of either kind, and depths. */
CVOL_API void cvol_image_mirror(cvol_image *image);

/* Reads any PNG as 8-bit RGBA. Errors: IO, FORMAT, LIMIT, MEMORY. */
CVOL_API int cvol_image_read_png(cvol_context *context, cvol_image **out, const char *path);
/* Writes a PNG: RGB when every pixel is opaque, RGBA otherwise. The file appears under its
 * name only when it is whole. Errors: IO, MEMORY. */
CVOL_API int cvol_image_write_png(cvol_context *context, const cvol_image *image, const char *path);
/* Levels of PNG: zlib's 0 to 9; 6 are the bytes that files get. Quick ones are for pictures that
 * are looked at once: of volumes about a tenth more bytes in an eighth of the time. */
#define CVOL_PNG_QUICK (-1)
/* The same file in memory, *size bytes at *out, which the caller frees with free(). *out is NULL
 * after an error. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_encode_png(cvol_context *context, const cvol_image *image, int level,
                                   void **out, size_t *size);
/* Writes a picture of floats as a PNG of 16 bits a channel: over a background R G B, or (NULL) with
 * straight alpha. With `grey`, one channel, R, for all three. Errors: ARGUMENT, IO, MEMORY. */
CVOL_API int cvol_image_write_png16(cvol_context *context, const cvol_image *image,
                                    const double background[3], int grey, const char *path);
/* Writes a picture of floats as it is, over a background, as a portable float map (PFM, low byte
 * first): RGB, or with `grey` R alone. Errors: ARGUMENT, IO, MEMORY. */
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

/* How far picture b is from picture a, over R, G and B:
 * psnr_db            = 10 log10(255^2 / mean squared difference), infinity when equal
 * psnr_foreground_db = the same over the pixels where either picture has a channel above 2
 * ssim               = mean structural similarity (Wang et al. 2004; window 7x7, uniform, sample
 *                      covariance, K = 0.01, 0.03, L = 255), mean over the three channels. */
typedef struct cvol_image_difference {
    double psnr_db, psnr_foreground_db, ssim, rmse, max_abs_error;
    size_t foreground_pixels;
} cvol_image_difference;
/* Compares two pictures of bytes of one size. Errors: ARGUMENT (sizes), MEMORY. */
CVOL_API int cvol_image_compare(cvol_context *context, cvol_image_difference *out,
                                const cvol_image *a, const cvol_image *b);

#ifdef __cplusplus
}
#endif
#endif
