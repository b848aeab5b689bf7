/* Counts of multiply-adds, for benchmarks. They are not public: libcvol.so does not export them. */
#ifndef CVOL_RENDER_COUNTERS_H
#define CVOL_RENDER_COUNTERS_H

#include "cvol/render.h"

/* Counts the multiply-adds of the last picture of engine splat: of the pixels of footprints, and of
 * compositing slices. Errors: ARGUMENT (another engine). */
int cvol_renderer_splat_multiply_adds(cvol_context *context, const cvol_renderer *renderer,
                                      uint64_t *out);
/* Draws a picture by engine sheet with counting kernels, and counts multiply-adds: of evaluating
 * blocks, by the boxes of their frequencies; four per interpolated sample; eight per segment of a
 * ray interval that is composited. It does not count the filters of lapped arrays and the warp.
 * Mode composite, no light, level 0. Errors: those of cvol_renderer_render, ARGUMENT (another
 * engine, mode or level). */
int cvol_renderer_sheet_multiply_adds(cvol_context *context, cvol_renderer *renderer,
                                      cvol_image *image, const cvol_render_options *options,
                                      uint64_t *out);

#endif
