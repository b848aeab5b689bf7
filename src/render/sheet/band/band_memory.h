/* The common data of a frame's bands, and the memory with which a thread draws one. */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_MEMORY_H
#define CVOL_RENDER_SHEET_BAND_BAND_MEMORY_H

#include "render/sheet/band/block_cache.h"
#include "render/sheet/band/extreme.h"
#include "render/sheet/band/lapped_layer.h"
#include "render/sheet/band/worker.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/mask.h"

/* The common data of all bands of a frame. */
struct cvol_sheet_frame {
    const cvol_array *array;       /* of blocks and ranges */
    const cvol_sheet_level *level; /* the owner of the samples; NULL: the volume */
    const cvol_sheet_plan *plan;
    cvol_block_cache cache;
    cvol_block_axes axes;
    cvol_lapped_filters filters; /* of lapped arrays */
    const cvol_sheet_table *table;
    const cvol_visibility *visibility;
    const cvol_sheet_mask *mask;     /* NULL: no mask */
    cvol_mask_points mask_points[3]; /* of lane, row and slice */
    float background;                /* value of masked samples, minus the array's offset */
    cvol_sheet_kernel *kernel;
    cvol_sheet_evaluator *evaluate;
    cvol_intermediate *intermediate;
    const cvol_tiles *tiles;
    cvol_extremes extremes;  /* for maxima and minima */
    float start[CVOL_LINES]; /* content of the lines before the first slice */
    int counts;              /* multiply-adds, into the counter of the band's memory */
    double progress[2];      /* share of the picture drawn before and after this plan */
};

/* One thread's working memory; all zero is empty. */
struct cvol_band_memory {
    void *allocated;
    void *samples; /* of one layer: [slices][rows + 2][row_stride]; lapped: two slices more */
    int are_int16;
    ptrdiff_t row_stride, sheet_stride;
    ptrdiff_t cover_at;      /* see cvol_layer */
    cvol_layer_skip skip[2]; /* of layers, cyclically */
    uint8_t *seen;           /* for each row of blocks: 1 if part of it is visible */
    uint8_t *pending;        /* for each row of tiles: 1 if the layer before was drawn to its end */
    cvol_block_work *work;
    size_t sample_capacity, seen_capacity, pending_capacity, work_capacity;
    cvol_layer layer, first_sheet; /* too large for a thread's stack */
    cvol_lapped_memory lapped;
    uint64_t multiply_adds;
    cvol_worker worker;
};

/* The size of samples of a plan's layers: floats, or int16 as in plan->int16. */
static inline size_t cvol_sample_size(const cvol_sheet_plan *plan)
{
    return plan->int16.scale > 0 ? sizeof(int16_t) : sizeof(float);
}

/* The sample `at` samples behind this one. */
static inline void *cvol_sample_at(const cvol_sheet_plan *plan, void *samples, ptrdiff_t at)
{
    return (char *)samples + at * (ptrdiff_t)cvol_sample_size(plan);
}

#endif
