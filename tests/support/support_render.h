/* Common code of tests of the renderers: small volumes, requests and pictures. */
#ifndef CVOL_TESTS_SUPPORT_RENDER_H
#define CVOL_TESTS_SUPPORT_RENDER_H

#include "cvol/codec.h"
#include "cvol/render.h"

/* Samples zero; the caller frees volume.data. */
cvol_volume support_volume(size_t nx, size_t ny, size_t nz, cvol_type type);
/* Sample i of the volume, of any type. */
double support_sample(const cvol_volume *volume, size_t i);
size_t support_index(const cvol_volume *volume, size_t x, size_t y, size_t z);

/* A smooth volume of float32 without symmetry, 0..about 90, and suitable transfer points. */
cvol_volume support_blobs(size_t nx, size_t ny, size_t nz);
#define SUPPORT_BLOB_POINTS 4
extern const cvol_transfer_point support_blob_points[SUPPORT_BLOB_POINTS];

/* A square picture from this direction. */
cvol_render_options support_square(int size, cvol_mode mode, double azimuth, double elevation);

/* The volume compressed to `psnr_db` in blocks of side `block`; the caller frees it. */
cvol_array *support_compress(cvol_context *context, const cvol_volume *volume, int block,
                             double psnr_db);

/* A picture by the ray engine; the caller frees it. No points: no transfer function. */
cvol_image *support_ray(cvol_context *context, const cvol_volume *volume,
                        const cvol_transfer_point *points, size_t count,
                        const cvol_render_options *options);

/* The same at a step of 0.25; samples with which[] set have no value. */
cvol_image *support_ray_masked(cvol_context *context, const cvol_volume *volume,
                               const uint8_t *which, const cvol_transfer_point *points,
                               size_t count, cvol_render_options options);

/* The same by the sheet engine. */
cvol_image *support_sheet(cvol_context *context, const cvol_array *array,
                          const cvol_transfer_point *points, size_t count,
                          const cvol_render_options *options);

/* The PSNR of the sheet engine's picture against the ray engine's at a step of 0.125, in dB. */
double support_sheet_db(cvol_context *context, const cvol_array *array, const cvol_volume *volume,
                        const cvol_transfer_point *points, size_t count,
                        cvol_render_options options);

/* A picture by the caller's renderer; the test fails if a pixel is not opaque. */
cvol_image *support_picture(cvol_context *context, cvol_renderer *renderer,
                            const cvol_render_options *options);
void support_set_transfer(cvol_context *context, cvol_renderer *renderer,
                          const cvol_transfer_point *points, size_t count);

const uint8_t *support_pixel(const cvol_image *image, int i, int j);
/* The largest difference of any channel of two pictures of one size. */
int support_difference(const cvol_image *a, const cvol_image *b);
/* 10 log10(255^2 / mean squared difference) over R, G and B; 99 when equal. */
double support_psnr(const cvol_image *a, const cvol_image *b);

#endif
