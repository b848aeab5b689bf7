/* How threads share the lines of an intermediate image.
 *
 * Each begins with a band of its own, as high as they all are: what two bands share of blocks both
 * need, so there are as few as there are threads. A thread that is done asks the one
 * with the most left for half of its lines. That one answers between two tiles of lines, and the
 * other goes on with them from the layer that they have come to. No line knows who drew it.
 */
#ifndef CVOL_RENDER_SHEET_WORK_STEALING_H
#define CVOL_RENDER_SHEET_WORK_STEALING_H

#include <stdatomic.h>

#include "render/sheet/skip.h"

typedef struct cvol_sheet_frame cvol_sheet_frame;
typedef struct cvol_band_memory cvol_band_memory;

/* Lines that are drawn together, through all layers from one on. */
typedef struct cvol_band {
    int begin, end; /* begin a multiple of CVOL_TILE */
    size_t step;    /* how many layers they have met */
} cvol_band;

/* The row of tiles behind its last. */
static inline int cvol_band_tile_end(const cvol_band *band)
{
    return (band->end + CVOL_TILE - 1) / CVOL_TILE;
}

/* A thread's place among those that share. */
typedef struct cvol_seat {
    atomic_int left;   /* lines times layers of its band that are worth asking for */
    atomic_int asker;  /* the thread that waits for some, plus 1; 0: none; -1: it has no band */
    atomic_int answer; /* to what it asked itself: 0: none yet; 1: `given`; -1: nothing */
    cvol_band given;
} cvol_seat;

typedef struct cvol_sheet_share {
    cvol_context *context;
    const cvol_sheet_frame *frame;
    cvol_band_memory *bands; /* one for each thread */
    int threads;
    int lines;            /* of the bands that are there at first, but the last */
    atomic_int next;      /* the first of these that none has begun */
    atomic_int cancelled; /* the code */
    atomic_long drawn;    /* lines times layers */
} cvol_sheet_share;

/* How many lines bands have at first. */
int cvol_share_lines(const cvol_sheet_plan *plan, int threads);

/* Draws a frame into its intermediate image. `bands` have room for bands of `lines` lines. Reports
 * progress from the calling thread. Errors: CANCELLED. */
int cvol_share_draw(cvol_context *context, const cvol_sheet_frame *frame, cvol_band_memory *bands,
                    int threads, int lines);

/* To be called by those who draw a band: before a layer; 0 if they are to stop. */
int cvol_share_layer(cvol_sheet_share *share, int thread, const cvol_band *band);
/* Before the tile of lines from `next` on: gives the band's last lines away, if another thread
 * waits for some. */
void cvol_share_tile(cvol_sheet_share *share, int thread, cvol_band *band, int next);

#endif
