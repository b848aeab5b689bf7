/* What the bands of a frame share, and the memory that a thread draws one with. */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_MEMORY_H
#define CVOL_RENDER_SHEET_BAND_BAND_MEMORY_H

#include "render/sheet/band/block_cache.h"
#include "render/sheet/band/extreme.h"
#include "render/sheet/band/lapped_layer.h"
#include "render/sheet/band/worker.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/mask.h"

/* What all bands of a frame share. */
struct cvol_sheet_frame {
    const cvol_array *array;       /* of blocks and ranges */
    const cvol_sheet_level *level; /* whose these are; NULL: they are the volume's */
    const cvol_sheet_plan *plan;
    cvol_block_cache cache;
    cvol_block_axes axes;
    cvol_lapped_filters filters; /* of lapped arrays */
    const cvol_sheet_table *table;
    const cvol_visibility *visibility;
    const cvol_sheet_mask *mask;     /* NULL: there is none */
    cvol_mask_points mask_points[3]; /* of lane, row and sheet */
    float background;                /* value of masked samples, less the array's offset */
    cvol_sheet_kernel *kernel;
    cvol_sheet_evaluator *evaluate;
    cvol_intermediate *intermediate;
    const cvol_tiles *tiles;
    cvol_extremes extremes;  /* of maxima and minima */
    float start[CVOL_LINES]; /* what the lines hold before the first sheet */
    int counts;              /* multiply-adds, into those of the band's memory */
    double progress[2];      /* how much of the picture was drawn before, and will be */
};

/* One thread's working memory; all zero is empty. */
struct cvol_band_memory {
    void *allocated;
    void *samples; /* of one layer: [sheets][rows + 2][row_stride]; lapped: two sheets more */
    int are_int16;
    long row_stride, sheet_stride;
    long cover_at;           /* see cvol_layer */
    cvol_layer_skip skip[2]; /* of layers in turn */
    uint8_t *seen;           /* for each row of blocks: whether some of it can be seen */
    uint8_t *pending; /* for each row of tiles: whether the layer before was drawn to its end */
    cvol_block_work *work;
    size_t sample_capacity, seen_capacity, pending_capacity, work_capacity;
    cvol_layer layer, first_sheet; /* what is drawn: large for a thread's stack */
    cvol_lapped_memory lapped;
    uint64_t multiply_adds;
    cvol_worker worker;
};

/* How large samples of a plan's layers are: floats, or as plan->compact says. */
static inline size_t cvol_sample_size(const cvol_sheet_plan *plan)
{
    return plan->int16.scale > 0 ? sizeof(int16_t) : sizeof(float);
}

/* The one that lies `at` samples behind that one. */
static inline void *cvol_sample_at(const cvol_sheet_plan *plan, void *samples, long at)
{
    return (char *)samples + at * (long)cvol_sample_size(plan);
}

#endif
