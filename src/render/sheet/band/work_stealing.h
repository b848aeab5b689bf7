/* Threads share the lines of an intermediate image.
 *
 * Each begins with its own band; all bands have the same height. Both neighbours need the blocks
 * between two bands, so there is only one band per thread. An idle thread asks the thread with the
 * most lines left for half of them. That thread answers between two tiles of lines, and the thief
 * continues with the lines from the layer that they have reached. The result does not depend on the
 * thread that draws a line. */
#ifndef CVOL_RENDER_SHEET_BAND_WORK_STEALING_H
#define CVOL_RENDER_SHEET_BAND_WORK_STEALING_H

#include "render/sheet/band/band_memory.h"
#include "render/sheet/band/worker.h"

/* The number of lines of bands at the start. */
int cvol_work_stealing_lines(const cvol_sheet_plan *plan, int threads);

/* Draws a frame into its intermediate image, each band by `draw`. `bands` have memory for bands of
 * `lines` lines. Reports progress from the calling thread. Errors: CANCELLED. */
int cvol_work_stealing_draw(cvol_context *context, const cvol_sheet_frame *frame,
                            cvol_band_memory *bands,
                            void (*draw)(cvol_work_stealing *share, int thread, cvol_band *band),
                            int threads, int lines);

/* The owner of a band calls it before each layer; 0 if it must stop. */
int cvol_work_stealing_layer(cvol_work_stealing *share, int thread, const cvol_band *band);
/* The owner calls it before the tile of lines from `next` on: gives the band's last lines to a
 * waiting thread. */
void cvol_work_stealing_tile(cvol_work_stealing *share, int thread, cvol_band *band, int next);

#endif
