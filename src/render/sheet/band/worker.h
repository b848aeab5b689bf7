/* A thread that draws bands, as the others see it: work_stealing.h. */
#ifndef CVOL_RENDER_SHEET_BAND_WORKER_H
#define CVOL_RENDER_SHEET_BAND_WORKER_H

#include <stdatomic.h>

#include "render/sheet/band/intermediate.h"

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
typedef struct cvol_worker {
    atomic_int left;   /* lines times layers of its band that are worth asking for */
    atomic_int thief;  /* the thread that waits for some, plus 1; 0: none; -1: it has no band */
    atomic_int answer; /* to what it asked itself: 0: none yet; 1: `given`; -1: nothing */
    cvol_band given;
} cvol_worker;

typedef struct cvol_work_stealing cvol_work_stealing;
struct cvol_work_stealing {
    cvol_context *context;
    const cvol_sheet_frame *frame;
    cvol_band_memory *bands;                                              /* one for each thread */
    void (*draw)(cvol_work_stealing *share, int thread, cvol_band *band); /* cvol_band_draw */
    int threads;
    int lines;            /* of the bands that are there at first, but the last */
    atomic_int next;      /* the first of these that none has begun */
    atomic_int cancelled; /* the code */
    atomic_long drawn;    /* lines times layers */
};

#endif
