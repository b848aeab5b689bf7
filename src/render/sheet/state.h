/* The state of a renderer by the sheet engine. */
#ifndef CVOL_RENDER_SHEET_STATE_H
#define CVOL_RENDER_SHEET_STATE_H

#include "render/light/reach.h"
#include "render/sheet/band/band.h"
#include "render/sheet/combine.h"
#include "render/sheet/frame/policy.h"
#include "render/sheet/frame/reconstruction_filter.h"
#include "render/sheet/source.h"

typedef struct cvol_sheet_state {
    const cvol_array *array;
    const cvol_array *whole;                       /* for the light; see cvol_source */
    cvol_sheet_source sources[CVOL_SHEET_SOURCES]; /* the volume, and its levels */
    cvol_transfer *transfer;
    cvol_sheet_table *table;
    cvol_intermediate intermediate;
    float *depth, *between; /* of the intermediate image, if requested */
    cvol_tiles tiles;
    float *held; /* see cvol_extremes */
    size_t line_capacity, scratch_capacity, span_capacity, opaque_capacity, intersected_capacity,
        tile_capacity, pending_capacity, edge_capacity, depth_capacity, between_capacity,
        held_capacity;
    float *bases;            /* bases of lane, row and slice of the frame; of sub-blocks */
    cvol_band_memory *bands; /* one for each thread */
    int band_count;
    cvol_transfer_traits traits;     /* of the array with the transfer function */
    cvol_reconstruction_filter wide; /* the reconstruction filter of the picture */
    cvol_block_cache_memory cache;
    cvol_reach reach;
    const cvol_sheet_combine *combine; /* NULL: this process draws all parts */
    int counts;                        /* multiply-adds, of all plans of a picture */
    uint64_t multiply_adds;
} cvol_sheet_state;

/* draw.c: draws the source in parallel projection; a picture that is drawn from int16 samples stays
 * the same when its depth is requested. Errors: MEMORY, CANCELLED. */
int cvol_sheet_draw_parallel(cvol_context *context, cvol_sheet_state *state,
                             const cvol_sheet_source *source, cvol_image *image,
                             const cvol_view *view, const cvol_render_options *options);
/* The same in perspective: the view along each of the axes, one after the other. */
int cvol_sheet_draw_perspective(cvol_context *context, cvol_sheet_state *state,
                                const cvol_sheet_source *source, cvol_image *image,
                                const cvol_view *view, const cvol_render_options *options);

/* frame_memory.c: memory for a plan's frame with this number of threads; 0: there is not enough. */
int cvol_sheet_prepare_image(cvol_sheet_state *state, const cvol_sheet_plan *plan, int has_depth,
                             int threads);
int cvol_sheet_prepare_bands(cvol_sheet_state *state, const cvol_sheet_plan *plan, int threads,
                             int lines);
/* The bases of the points of a plan's frame. */
cvol_block_axes cvol_sheet_prepare_axes(cvol_sheet_state *state, const cvol_sheet_plan *plan);

#endif
