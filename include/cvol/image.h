/* cvol/image.h - pictures: 8-bit RGBA rows, PNG files, differences. */
#ifndef CVOL_IMAGE_H
#define CVOL_IMAGE_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* width x height pixels of four bytes R G B A (A: straight, not premultiplied), the top
 * row first. */
typedef struct cvol_image {
    int width, height;
    uint8_t *rgba;
} cvol_image;

/* Largest width or height of a picture. */
#define CVOL_IMAGE_SIZE_MAX 32768

/* A black, transparent picture. The caller frees it. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_image_create(cvol_context *context, cvol_image **out, int width, int height);
CVOL_API void cvol_image_free(cvol_image *image);

/* Reads any PNG as 8-bit RGBA. Errors: IO, FORMAT, LIMIT, MEMORY. */
CVOL_API int cvol_image_read_png(cvol_context *context, cvol_image **out, const char *path);
/* Writes a PNG: RGB when every pixel is opaque, RGBA otherwise. The file appears under its
 * name only when it is whole. Errors: IO, MEMORY. */
CVOL_API int cvol_image_write_png(cvol_context *context, const cvol_image *image, const char *path);

/* How far picture b is from picture a, over R, G and B:
 * psnr_db            = 10 log10(255^2 / mean squared difference), infinity when equal
 * psnr_foreground_db = the same over the pixels where either picture has a channel above 2
 * ssim               = mean structural similarity (Wang et al. 2004; window 7x7, uniform, sample
 *                      covariance, K = 0.01, 0.03, L = 255), mean over the three channels. */
typedef struct cvol_image_difference {
    double psnr_db, psnr_foreground_db, ssim, rmse, max_abs_error;
    size_t foreground_pixels;
} cvol_image_difference;
CVOL_API int cvol_image_compare(cvol_context *context, cvol_image_difference *out,
                                const cvol_image *a, const cvol_image *b);

#ifdef __cplusplus
}
#endif
#endif
