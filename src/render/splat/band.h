/* Bands: rows of the picture that are drawn by themselves.
 *
 * A band goes through the samples of a slab that reach it, on one thread, so that a pixel's sums do
 * not depend on the number of threads; its sheet and its picture stay in the cache.
 */
#ifndef CVOL_RENDER_SPLAT_BAND_H
#define CVOL_RENDER_SPLAT_BAND_H

#include "render/splat/occlusion.h"

/* What a thread works with. */
typedef struct cvol_splat_memory {
    float *sheet;
    int (*spans)[2];
    cvol_splat_list list;
    uint64_t multiply_adds; /* of footprints and sheets */
} cvol_splat_memory;

/* What all bands of one picture share. */
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

/* Cuts a picture into bands, empty ones, and makes what they are drawn with; plan and footprint
 * are set. Errors: MEMORY. In any case cvol_splat_bands_free frees what there is. */
int cvol_splat_bands_make(cvol_context *context, cvol_splat_job *job, int width, int height);
void cvol_splat_bands_free(cvol_splat_job *job);

/* Draws the slices that are met as numbers begin .. end - 1, which lie in the slab. */
void cvol_splat_bands_draw(const cvol_splat_job *job, size_t begin, size_t end);
/* Multiply-adds of all that was drawn: of pixels of footprints, and of those of sheets that were
 * composited. */
uint64_t cvol_splat_bands_count(const cvol_splat_job *job);

#endif
