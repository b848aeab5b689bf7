/* Bands of the intermediate image: each is drawn through its layers by one thread, by itself.
 *
 * Two bands that share a row of blocks both have its samples; for that, no thread waits for another
 * while it draws, and a band's samples stay in its core's cache. Who comes to a block first
 * evaluates it, and lends it the other (block_exchange.h).
 */
#ifndef CVOL_RENDER_SHEET_BAND_H
#define CVOL_RENDER_SHEET_BAND_H

#include "render/sheet/block_cache.h"
#include "render/sheet/block_exchange.h"
#include "render/sheet/extreme.h"
#include "render/sheet/frame.h"
#include "render/sheet/lapped.h"
#include "render/sheet/level.h"
#include "render/sheet/mask.h"
#include "render/sheet/skip.h"
#include "render/sheet/work_stealing.h"

/* What all bands of a frame share. */
struct cvol_sheet_frame {
    const cvol_array *array;       /* of blocks and ranges */
    const cvol_sheet_level *level; /* whose these are; NULL: they are the volume's */
    const cvol_sheet_plan *plan;
    cvol_kept *kept;       /* blocks from pictures before; NULL: none */
    cvol_lending *lending; /* those of other bands; NULL: none */
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
    int are_compact;
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
    cvol_seat seat;
};

/* What samples of a layer take that bands of up to `lines` lines need. */
size_t cvol_band_sample_bytes(const cvol_sheet_plan *plan, int lines);
/* Makes room for bands of up to `lines` lines; 0 without memory. */
int cvol_band_memory_prepare(cvol_band_memory *memory, const cvol_sheet_plan *plan, int lines);
void cvol_band_memory_free(cvol_band_memory *memory);

/* Draws a band from its layer on, to the last one or until it is stopped; other threads that ask
 * may get some of its lines. */
void cvol_band_draw(cvol_sheet_share *share, int thread, cvol_band *band);

/* How large samples of a plan's layers are: floats, or as plan->compact says. */
static inline size_t cvol_sample_size(const cvol_sheet_plan *plan)
{
    return plan->compact.scale > 0 ? sizeof(int16_t) : sizeof(float);
}

/* The one that lies `at` samples behind that one. */
static inline void *cvol_sample_at(const cvol_sheet_plan *plan, void *samples, long at)
{
    return (char *)samples + at * (long)cvol_sample_size(plan);
}

/* Copies a sample to the next `times` samples before (`way` -1) or behind it (1). */
void cvol_sample_repeat(const cvol_sheet_plan *plan, void *sample, int way, int times);

/* How many of the last block's points along lanes and rows lie within the volume. */
typedef struct cvol_points_inside {
    int lanes, rows;
} cvol_points_inside;

cvol_points_inside cvol_points_inside_of(const cvol_sheet_plan *plan);

/* How often a row's first and last sample are repeated beyond the volume's faces. */
typedef struct cvol_lane_copies {
    int left, right;
} cvol_lane_copies;

static inline cvol_lane_copies cvol_lane_copies_of(const cvol_sheet_plan *plan)
{
    return plan->wide ? (cvol_lane_copies){2 + plan->reach, 2 + plan->reach}
                      : (cvol_lane_copies){2, 1};
}

/* ---- what drawing lapped layers shares ------------------------------------------------------ */

/* The sheets of a layer: *begin .. *end - 1. */
void cvol_layer_sheets(size_t *begin, size_t *end, const cvol_sheet_plan *plan, size_t layer);

/* Rows of blocks that lines line_begin .. line_end - 1 reach in a layer: *first .. *last; 0 if
 * none. */
int cvol_layer_rows(size_t *first, size_t *last, const cvol_sheet_plan *plan, size_t layer,
                    int line_begin, int line_end);

/* `before`: of the layer that rays met before this one, NULL if it is not known. */
void cvol_layer_describe(cvol_layer *out, const void *samples, long row_stride, long sheet_stride,
                         const cvol_layer_skip *skip, const cvol_layer_skip *before,
                         const cvol_sheet_plan *plan, const cvol_band_layer *at);
/* Asks for the first terms of a block that will be evaluated soon, if it is: they lie elsewhere in
 * memory than those of the block before, but along one axis. What follows them comes by itself. */
void cvol_band_prefetch(const cvol_sheet_frame *frame, const cvol_layer_skip *skip,
                        const cvol_band_layer *at, size_t lane, size_t row);
cvol_skip_source cvol_band_skip_source(const cvol_sheet_frame *frame,
                                       const cvol_extremes_seen *extremes);
/* What the pixels of a band hold. */
cvol_extremes_seen cvol_band_extremes(const cvol_sheet_frame *frame, const cvol_band *band);
cvol_line cvol_band_line(const cvol_intermediate *image, int j);
/* The same for drawing: what is to be counted is. */
cvol_line cvol_band_line_of(cvol_band_memory *memory, const cvol_sheet_frame *frame, int j);
/* Counts what evaluating a block takes. */
void cvol_band_count_block(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t index);

/* Evaluates a block onto samples; sheets as axes->sheet_ends says. */
void cvol_band_evaluate(cvol_band_memory *memory, const cvol_sheet_frame *frame, void *out,
                        long sheet_stride, size_t index, const cvol_block_axes *axes);

/* Grows *memory (a pointer to any object pointer) to `count` elements, zeroed; what it held is
 * lost. 0 without memory. */
int cvol_ensure(void *memory, size_t *capacity, size_t count, size_t size);

#endif
