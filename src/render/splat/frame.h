/* Internals of the splat engine: the common types of its plan, its samples, its kernels and its
 * loop.
 *
 * Axes: `lane` and `row` lie in the slices; `slice` is the axis most parallel to the view, along
 * which rays cross the most slices. Sample (i, j, k) of lane, row and slice appears at
 *
 *     x = origin[0] + i along[0][0] + j along[1][0] + k along[2][0]   (y likewise)
 *
 * in pixels: pixel (0, 0) has its middle at 0, x runs to the right and y down. */
#ifndef CVOL_RENDER_SPLAT_FRAME_H
#define CVOL_RENDER_SPLAT_FRAME_H

#include "array/core/array.h"
#include "base/cpu.h"
#include "render/engine/engine.h"
#include "render/splat/footprint.h"
#include "render/view/light.h"
#include "render/view/shading.h"

/* A pixel of a sheet or of the picture is four floats: colour, premultiplied, and opacity (sheet)
 * or transmittance (picture). */
#define CVOL_SPLAT_CHANNELS 4

typedef struct cvol_splat_plan {
    int axis_lane, axis_row, axis_slice;
    size_t lanes, rows, slices; /* samples along each */
    int rising;                 /* slices rise with the distance from the eye */
    double distance;            /* between slices along the view, in mean spacings */
    double origin[2], along[3][2];
} cvol_splat_plan;

void cvol_splat_plan_make(cvol_splat_plan *plan, const cvol_grid *grid, const cvol_view *view);

/* ---- samples: slab.c ------------------------------------------------------------------ */

/* The source of samples: one of the two. */
typedef struct cvol_splat_source {
    const cvol_array *array;
    const cvol_volume *volume;
    double min, max; /* their range, if known */
    double offset;   /* of the array, or min: samples are loaded less it, so that single precision
                        suffices for values far from 0 */
} cvol_splat_source;

/* Copies of samples before and behind each row. */
#define CVOL_SPLAT_MARGIN 16

/* Slices in the order in which rays meet them: slots 0 and 1 are the last two of the slab before,
 * then follow new ones. */
typedef struct cvol_splat_slab {
    float *samples, *scratch;
    size_t row_stride, slice_stride;
    size_t most;   /* new slices per slab */
    size_t first;  /* the place, in the order of slices, of slot 2 */
    size_t filled; /* new slices in it */
    size_t room;   /* floats at `samples` */
} cvol_splat_slab;

/* Allocates memory for a suitable number of slices, and begins before the first; it reuses memory
 * from another picture. Errors: MEMORY. */
int cvol_splat_slab_prepare(cvol_context *context, cvol_splat_slab *slab,
                            const cvol_splat_source *source, const cvol_splat_plan *plan);
void cvol_splat_slab_free(cvol_splat_slab *slab);
/* Moves on to the next slices, in rising order if `ascending`. Errors: MEMORY. */
int cvol_splat_slab_next(cvol_context *context, cvol_splat_slab *slab,
                         const cvol_splat_source *source, const cvol_splat_plan *plan,
                         int ascending);
/* Sample 0 of row 0 of the slice at `place` in the order of slices, which must be in the slab. */
static inline const float *cvol_splat_slab_at(const cvol_splat_slab *slab, size_t place)
{
    return slab->samples + (place + 2 - slab->first) * slab->slice_stride + CVOL_SPLAT_MARGIN;
}

/* ---- classification and light: classify.c, light_simd.c -------------------------------------- */

#define CVOL_SPLAT_ENTRIES 8192
/* The largest contribution of lit samples, relative to their opacity. */
#define CVOL_SPLAT_BRIGHTEST 1.2f

/* Colour times opacity, and opacity, of one sample: entry t is for values around from + t /
 * scale. */
typedef struct cvol_splat_table {
    float from, scale;
    float visible_from, visible_to; /* opacity is 0 outside of these; less the offset */
    float entries[CVOL_SPLAT_ENTRIES][CVOL_SPLAT_CHANNELS] __attribute__((aligned(64)));
} cvol_splat_table;

/* Tabulates the contribution of samples, over the range of the transfer function that they reach
 * and one entry more on both sides. Each integer has its own entry if there are enough. `distance`
 * of slices in mean spacings; `share` is the sum of weights that a slice would have. */
void cvol_splat_table_fill(cvol_splat_table *table, const cvol_transfer *transfer,
                           const cvol_splat_source *source, cvol_type type, double distance,
                           double share);
/* The light of a view, along lane, row and slice in the order of slices: rising, if `ascending`. */
void cvol_splat_light_set(cvol_light *light, const cvol_splat_plan *plan, const cvol_grid *grid,
                          const cvol_view *view, const cvol_shading *shading,
                          cvol_light_values values, int ascending);

/* The source, and the classification of its samples: source.c. */
typedef struct cvol_splat_input {
    cvol_splat_source source;
    cvol_grid grid;
    cvol_transfer *transfer; /* NULL: not set yet */
    cvol_splat_table *table; /* of the last cvol_splat_input_tabulate */
} cvol_splat_input;

/* For an array or a volume, the other one NULL. Errors: MEMORY, and as cvol_grid_check; then there
 * is nothing to free. */
int cvol_splat_input_make(cvol_context *context, cvol_splat_input *out, const cvol_array *array,
                          const cvol_volume *volume);
void cvol_splat_input_free(cvol_splat_input *input);
/* Copies the transfer function. Errors: MEMORY. */
int cvol_splat_input_set_transfer(cvol_context *context, cvol_splat_input *input,
                                  const cvol_transfer *transfer);
/* Sets the table (cvol_splat_table_fill). */
void cvol_splat_input_tabulate(cvol_splat_input *input, double distance, double share);

/* A row of samples with its neighbours, each beginning with sample 0; beyond the volume's faces a
 * neighbour is the row itself. */
typedef struct cvol_splat_row {
    const float *samples, *above, *below, *before, *behind;
} cvol_splat_row;

/* Visible samples: their numbers in the row, and the positions of their four channels: at from[4
 * entries[n]]. Lit samples have separate channels. There is room for CVOL_SPLAT_MARGIN more numbers
 * and entries. */
typedef struct cvol_splat_list {
    int count;
    int *numbers, *entries;
    const float *from;
    float *channels;
} cvol_splat_list;

/* Lists samples begin .. end - 1 of a row. */
CVOL_SIMD_DECLARE(void, cvol_splat_list_make,
                  (cvol_splat_list * list, const cvol_splat_row *row, int begin, int end,
                   const cvol_splat_table *table, const cvol_light *light));

/* ---- slices: slice_simd.c -------------------------------------------------------------------- */

/* Rows begin .. end - 1 of a picture: a sheet, to which the samples of a slice are added, and the
 * composited picture. `margin` pixels left and right collect parts outside of the picture. */
typedef struct cvol_splat_band {
    int begin, end, width, margin;
    size_t row_stride; /* floats: a multiple of 16 */
    float *sheet, *image;
    int (*spans)[2]; /* the nonempty pixels of each row of the sheet: from, up to; counted with the
                        margin */
} cvol_splat_band;

/* Adds listed samples of a row to the sheet; sample i lies at start + i step. Returns the number of
 * footprint rows. */
CVOL_SIMD_DECLARE(uint64_t, cvol_splat_add,
                  (const cvol_splat_band *band, const cvol_footprint_table *table,
                   const cvol_splat_list *list, const double start[2], const double step[2]));

/* A slice's gain in the picture: pixel (x, y) is at place at[k] + x step_x[k] + y step_y[k] of the
 * lattice. */
typedef struct cvol_splat_gain {
    const cvol_footprint_gain *gain;
    double at[2], step_x[2], step_y[2];
} cvol_splat_gain;

/* Composites the sheet behind (front 1) or in front of (0) the picture, and clears it. `gain` NULL:
 * none is needed. */
CVOL_SIMD_DECLARE(void, cvol_splat_composite,
                  (const cvol_splat_band *band, const cvol_splat_gain *gain, int front));

#endif
