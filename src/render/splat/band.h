/* Bands: rows of the picture that are drawn independently.
 *
 * A band passes the samples of a slab that reach it, on one thread, so a pixel's sums do not depend
 * on the number of threads; its sheet and its picture stay in the cache. */
#ifndef CVOL_RENDER_SPLAT_BAND_H
#define CVOL_RENDER_SPLAT_BAND_H

#include "render/splat/occlusion.h"

/* The working memory of one thread. */
typedef struct cvol_splat_memory {
    float *sheet;
    int (*spans)[2];
    cvol_splat_list list;
    uint64_t multiply_adds; /* of footprints and sheets */
} cvol_splat_memory;

/* The common data of all bands of a picture. */
typedef struct cvol_splat_job {
    const cvol_splat_plan *plan;
    const cvol_splat_slab *slab;
    const cvol_footprint_table *footprint;
    const cvol_splat_table *table;
    const cvol_light *light;
    const cvol_footprint_gain *gain;
    int ascending, front;
    int width, height, margin, band_rows;
    size_t row_stride;
    float *image;              /* [height][row_stride] */
    cvol_splat_memory *memory; /* of each thread */
    int threads;
    cvol_splat_hidden *hidden; /* of each band */
} cvol_splat_job;

/* Cuts a picture into empty bands, and allocates their memory; plan and footprint are set. Errors:
 * MEMORY. In any case cvol_splat_bands_free frees it. */
int cvol_splat_bands_make(cvol_context *context, cvol_splat_job *job, int width, int height);
void cvol_splat_bands_free(cvol_splat_job *job);

/* Draws the slices begin .. end - 1 in the order in which rays meet them, which lie in the slab. */
void cvol_splat_bands_draw(const cvol_splat_job *job, size_t begin, size_t end);
/* Multiply-adds of the picture: of pixels of footprints, and of composited pixels of sheets. */
uint64_t cvol_splat_bands_count(const cvol_splat_job *job);

#endif
