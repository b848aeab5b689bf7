/* A thread that draws bands, as other threads see it: work_stealing.h. */
#ifndef CVOL_RENDER_SHEET_BAND_WORKER_H
#define CVOL_RENDER_SHEET_BAND_WORKER_H

#include <stdatomic.h>

#include "render/sheet/band/intermediate.h"

typedef struct cvol_sheet_frame cvol_sheet_frame;
typedef struct cvol_band_memory cvol_band_memory;

/* Lines that are drawn together, through all layers from `step` on. */
typedef struct cvol_band {
    int begin, end; /* begin a multiple of CVOL_TILE */
    size_t step;    /* the number of layers drawn */
} cvol_band;

/* The row of tiles behind its last. */
static inline int cvol_band_tile_end(const cvol_band *band)
{
    return (band->end + CVOL_TILE - 1) / CVOL_TILE;
}

/* A worker's state. */
typedef struct cvol_worker {
    atomic_int left;   /* lines times layers of its band that are worth stealing */
    atomic_int thief;  /* the thread that waits for some, plus 1; 0: none; -1: it has no band */
    atomic_int answer; /* to its own request: 0: none yet; 1: `given`; -1: nothing */
    cvol_band given;
} cvol_worker;

typedef struct cvol_work_stealing cvol_work_stealing;
struct cvol_work_stealing {
    cvol_context *context;
    const cvol_sheet_frame *frame;
    cvol_band_memory *bands;                                              /* one for each thread */
    void (*draw)(cvol_work_stealing *share, int thread, cvol_band *band); /* cvol_band_draw */
    int threads;
    int lines;            /* of the initial bands, except the last */
    atomic_int next;      /* the first of these that has not begun */
    atomic_int cancelled; /* the code */
    atomic_long drawn;    /* lines times layers */
};

#endif
