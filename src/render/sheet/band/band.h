/* Bands of the intermediate image: one thread draws each through its layers, independently.
 *
 * Two bands that share a row of blocks both store its samples. In return no thread waits for
 * another while it draws, and a band's samples stay in its core's cache. The first thread that
 * needs a block evaluates it; the other copies it (block_exchange.h). */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_H
#define CVOL_RENDER_SHEET_BAND_BAND_H

#include "render/sheet/band/band_memory.h"

/* The bytes of a layer's samples for bands of up to `lines` lines. */
size_t cvol_band_sample_bytes(const cvol_sheet_plan *plan, int lines);
/* Allocates memory for bands of up to `lines` lines; 0 without memory. */
int cvol_band_memory_prepare(cvol_band_memory *memory, const cvol_sheet_plan *plan, int lines);
void cvol_band_memory_free(cvol_band_memory *memory);

/* Draws a band from its layer on, to the last one or until it is stopped; other threads may steal
 * some of its lines. */
void cvol_band_draw(cvol_work_stealing *share, int thread, cvol_band *band);

#endif
