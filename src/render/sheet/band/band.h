/* Bands of the intermediate image: each is drawn through its layers by one thread, by itself.
 *
 * Two bands that share a row of blocks both have its samples; for that, no thread waits for another
 * while it draws, and a band's samples stay in its core's cache. Who comes to a block first
 * evaluates it, and lends it the other (block_exchange.h).
 */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_H
#define CVOL_RENDER_SHEET_BAND_BAND_H

#include "render/sheet/band/band_memory.h"

/* What samples of a layer take that bands of up to `lines` lines need. */
size_t cvol_band_sample_bytes(const cvol_sheet_plan *plan, int lines);
/* Makes room for bands of up to `lines` lines; 0 without memory. */
int cvol_band_memory_prepare(cvol_band_memory *memory, const cvol_sheet_plan *plan, int lines);
void cvol_band_memory_free(cvol_band_memory *memory);

/* Draws a band from its layer on, to the last one or until it is stopped; other threads that ask
 * may get some of its lines. */
void cvol_band_draw(cvol_work_stealing *share, int thread, cvol_band *band);

#endif
