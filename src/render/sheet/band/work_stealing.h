/* How threads share the lines of an intermediate image.
 *
 * Each begins with a band of its own, as high as they all are: what two bands share of blocks both
 * need, so there are as few as there are threads. A thread that is done asks the one
 * with the most left for half of its lines. That one answers between two tiles of lines, and the
 * other goes on with them from the layer that they have come to. No line knows who drew it.
 */
#ifndef CVOL_RENDER_SHEET_BAND_WORK_STEALING_H
#define CVOL_RENDER_SHEET_BAND_WORK_STEALING_H

#include "render/sheet/band/band_memory.h"
#include "render/sheet/band/worker.h"

/* How many lines bands have at first. */
int cvol_work_stealing_lines(const cvol_sheet_plan *plan, int threads);

/* Draws a frame into its intermediate image, each band by `draw`. `bands` have room for bands of
 * `lines` lines. Reports progress from the calling thread. Errors: CANCELLED. */
int cvol_work_stealing_draw(cvol_context *context, const cvol_sheet_frame *frame,
                            cvol_band_memory *bands,
                            void (*draw)(cvol_work_stealing *share, int thread, cvol_band *band),
                            int threads, int lines);

/* To be called by those who draw a band: before a layer; 0 if they are to stop. */
int cvol_work_stealing_layer(cvol_work_stealing *share, int thread, const cvol_band *band);
/* Before the tile of lines from `next` on: gives the band's last lines away, if another thread
 * waits for some. */
void cvol_work_stealing_tile(cvol_work_stealing *share, int thread, cvol_band *band, int next);

#endif
