/* The sheet engine's inside: what its plan, its skipping, its kernels and its warp share.
 *
 * Axes: `lane` and `row` lie in the sheets, `sheet` is the principal viewing axis. All in-plane
 * coordinates are sample indices of the volume along lane and row.
 *
 * A layer is the sheets of one layer of blocks. Its samples are evaluated onto a regular grid of
 * `points` per block and axis: sample s of an axis lies at index  first + s pitch,
 * pitch = block / points, first = (pitch - 1) / 2, also along the sheets' own: sheet s lies there.
 *
 * Intermediate pixel (i, j) is the ray that crosses sheet 0 at the in-plane point
 *     U = u0 + i du,  V = v0 + j dv
 * and the plane of samples z at (U + shear_lane z, V + shear_row z). In perspective, with the eye
 * at (eye_lane, eye_row, eye_sheet), these lie on the plane one sample before the eye, and the ray
 * crosses the plane that is t samples before it at eye + t (U - eye_lane, V - eye_row). A picture
 * in perspective is drawn by up to six plans, each of the pixels whose rays run most along its
 * axis.
 *
 * Near the faces of what is drawn, the volume's or a clip's, a sheet or an interval between sheets
 * weighs as much as of a ray's way through it lies within. As for the ray engine, an axis of one
 * sample is one spacing thick. Samples beyond the volume are copies of those at its faces.
 */
#ifndef CVOL_RENDER_SHEET_FRAME_FRAME_H
#define CVOL_RENDER_SHEET_FRAME_FRAME_H

#include "array/block/block_inverse.h"
#include "array/core/array.h"
#include "base/cpu.h"
#include "base/vector.h"
#include "render/engine/engine.h"
#include "render/sheet/frame/int16_format.h"
#include "render/sheet/frame/reconstruction_filter.h"
#include "render/view/light.h"

#define CVOL_TABLE_SIZE 2048
/* The most samples from one sheet to the next. */
#define CVOL_PARTS 4
/* How far opacity and colour may depart from a straight line before an interval is divided. */
#define CVOL_FLAT_TOLERANCE 0.05f
/* Along the lattice, which loses more than that, where samples are off by more, or all is clear,
 * unlit, and bends slowly: CVOL_BROAD of the function's span at least. */
#define CVOL_FLAT_TOLERANCE_COARSE 0.175f
#define CVOL_SMOOTH 0.07
/* Opacity up to which matter is clear. */
#define CVOL_TRANSLUCENT 0.45
/* Pixels of the intermediate image are worked on in groups of this many. */
#define CVOL_GROUP 16
/* Of image-order plans a group is a square of so many pixels, whose rays lie close together and so
 * meet about the same. Their lines are so many lines of the picture, which lie in memory square by
 * square. */
#define CVOL_SQUARE 4
#define CVOL_SQUARE_LOG2 2
/* Samples left and right of each row of a sheet, so that a group may reach beyond it. */
#define CVOL_SHEET_PAD 32

/* Pieces of a table, and bins of its coordinates that say where to look for theirs. */
#define CVOL_SEGMENTS 32
#define CVOL_SEGMENTS_FEW 16
#define CVOL_SEGMENT_BINS 64
#define CVOL_SEGMENT_BIN_LOG2 5

/* Classification of one frame (table.c). The table coordinate of a value is
 * (value - offset - from) scale, and entry t stands for t .. t + 1. Entries have the opacity
 * (first) over the distance between two sheets, and the colour (second: r | g << 10 | b << 20).
 * Over intervals of up to `flat` entries both are as good as linear.
 *
 * The same as pieces: colour times opacity (0 to 2) and opacity (3) are
 *     segment_start[k][i] + t segment_rise[k][i]
 * of the first piece i whose end lies beyond t; it is no more than two after that of t's bin, of
 * few pieces no more than one. */
typedef struct cvol_sheet_table {
    /* Of lit frames, for differences of table coordinates between points two apart, along lane,
     * row, and sheet as sheets are met. */
    const cvol_light *light;
    /* Between two sheets light turns: what is straight there is the gradient, and every interval is
     * lit in its middle, too. */
    int turns;
    /* What lies in its middle, beside what lies straight there, is that much of how far the
     * gradients of its ends, along lane and row, are apart. */
    float twist[2];
    int is_surface; /* then only the first coordinate of `at` or more is seen, with this colour */
    float at, colour[3];
    float from, scale, flat, flat_coarse; /* the latter: where less counts */
    int is_translucent;                   /* and bends slowly */
    /* Along image-order rays, intervals that rise by more than so many entries are looked at
     * midpoint (midpoint.h), and what is found there counts the more, the more they do, wholly from
     * midpoint + midpoint_ramp on. Below 0: all. */
    float midpoint, midpoint_ramp;
    float steep;   /* and those that rise by more than so many have four parts */
    int midpoints; /* of lit image-order plans: every interval has a sample in its middle */
    float visible_from, visible_to; /* opacity is 0 outside of these table coordinates */
    int segments;                   /* CVOL_SEGMENTS, or _FEW of them; 0: there are only entries */
    float segment_end[CVOL_SEGMENTS] __attribute__((aligned(64)));
    float segment_start[4][CVOL_SEGMENTS] __attribute__((aligned(64)));
    float segment_rise[4][CVOL_SEGMENTS] __attribute__((aligned(64)));
    int16_t segment_of[CVOL_SEGMENT_BINS] __attribute__((aligned(64)));
    cvol_pair entries[CVOL_TABLE_SIZE] __attribute__((aligned(64)));
    cvol_int16_table words; /* of frames whose samples are kept in 16 bits */
} cvol_sheet_table;

/* What samples that are no part of the transform are (array/core/mask.h). */
typedef enum cvol_sheet_masked {
    CVOL_SHEET_ALL_PLAIN,      /* there are none */
    CVOL_SHEET_SOME_VOID,      /* without a value */
    CVOL_SHEET_SOME_BACKGROUND /* of the background's value */
} cvol_sheet_masked;

/* Samples of a layer may be kept in 16 bits, which kernels that classify by pieces read: a value v,
 * less the array's offset, as v scale + offset, rounded, at least 0 and at most CVOL_INT16_MOST.
 * scale 0: they are floats. */
#define CVOL_INT16_MOST 32767
typedef struct cvol_int16_scale {
    float scale, offset;
} cvol_int16_scale;

static inline int16_t cvol_int16_scale_of(const cvol_int16_scale *int16, float value)
{
    const float word = value * int16->scale + int16->offset + 0.5f;
    return (int16_t)(word > 0 ? word < CVOL_INT16_MOST ? word : CVOL_INT16_MOST : 0);
}

typedef struct cvol_sheet_plan {
    int axis_lane, axis_row, axis_sheet;
    size_t lanes, rows, sheets; /* the volume's samples along each */
    size_t blocks_lane, blocks_row, layers;
    int block_lane, block_row, block_sheet; /* samples of a block along each */
    size_t sheet_count;
    int beyond; /* rays end up to half a sheet behind the last: it is met once more behind that */
    int level;  /* what is drawn is a level of the volume (level.h); 0: itself */
    int lapped; /* the array is, and not a level of it */
    int lit;    /* samples one point further are looked at */
    const cvol_reconstruction_filter *wide; /* the footprint, where it is not linear; else NULL */
    int reach; /* how many points further than a linear footprint's samples are looked at, for light
                  and the footprint */
    cvol_int16_scale int16;
    cvol_sheet_masked masked;
    int ascending; /* sheets are met in rising order */
    double shear_lane, shear_row;
    double distance; /* between sheets along a ray, in mean spacings; in perspective the largest */
    int parts;       /* samples from sheet to sheet: 1, or CVOL_PARTS at most */
    int clipped;     /* these are not the volume's faces, or there are planes */
    double lo[3], hi[3]; /* what is drawn: of lane, row, sheet, in sample indices, */
    int planes;          /* and where plane . (lane, row, sheet, 1) >= 0 in all */
    double plane[CVOL_VIEW_PLANES][4];
    int perspective;
    double eye_lane, eye_row, eye_sheet;
    double spacing[3]; /* of lane, row, sheet, over the mean */
    int points_lane, points_row, points_sheet;
    double pitch_lane, pitch_row, pitch_sheet, first_lane, first_row, first_sheet;
    double u0, v0, du, dv;
    int width, height; /* of the intermediate image; width a multiple of CVOL_GROUP */
    /* picture pixel (x, y) sees (U, V) = warp[.][0] + x warp[.][1] + y warp[.][2]; in perspective
     * that is the direction along lane, row and, third, from sheet to sheet of its ray, and
     * U - eye_lane = direction[0] / direction[2] */
    double warp[3][3];
    double own[2]; /* of the picture's pixels, those are drawn whose V is own[0] or more and less
                      than own[1]: not all, if the plan is a strip (frame_tile.h) */
    /* Of plans whose rays are those of the picture's pixels (plan_image_order.c): ray (i, j)
     * crosses sheet 0 at the in-plane point place[.][0] + i place[.][1] + j place[.][2]. What U and
     * V are elsewhere, i and j are then: u0 = v0 = 0, du = dv = 1, and the warp maps pixels onto
     * these.
     */
    int image_order;
    double place[2][3];
} cvol_sheet_plan;

/* Where rays cross a plane of samples: U at lane + scale U, V at row + scale V. */
typedef struct cvol_sheet_crossing {
    double lane, row, scale;
} cvol_sheet_crossing;

static inline cvol_sheet_crossing cvol_sheet_cross(const cvol_sheet_plan *plan, double z)
{
    if (!plan->perspective)
        return (cvol_sheet_crossing){plan->shear_lane * z, plan->shear_row * z, 1};
    const double scale = plan->ascending ? z - plan->eye_sheet : plan->eye_sheet - z;
    return (cvol_sheet_crossing){(1 - scale) * plan->eye_lane, (1 - scale) * plan->eye_row, scale};
}

/* How far the volume reaches beyond the centres of its first and last sample. */
static inline double cvol_sheet_margin(size_t samples)
{
    return samples > 1 ? 0 : 0.5;
}

/* Where sheet s is, as an index of samples. */
static inline double cvol_sheet_place(const cvol_sheet_plan *plan, size_t sheet)
{
    return plan->first_sheet + (double)sheet * plan->pitch_sheet;
}

/* Finds axes, shear, resolution and extent of the intermediate image for a view in parallel
 * projection. `level`: of what is drawn. Errors: LIMIT (an intermediate image beyond reason). */
int cvol_sheet_plan_make(cvol_context *context, cvol_sheet_plan *plan, const cvol_array *array,
                         int level, const cvol_view *view);
/* Those of a view in perspective: for what of the picture is seen along an axis (`along` 0 to 5:
 * twice the axis, and 1 if sheets are met in rising order). *empty: there is nothing. Errors:
 * LIMIT.
 */
int cvol_sheet_plan_make_along(cvol_context *context, cvol_sheet_plan *plan, int *empty,
                               const cvol_array *array, int level, const cvol_view *view,
                               int along);
/* Whether pixel (x, y) of the picture is a plan's: in parallel projection all are. */
static inline int cvol_sheet_plan_has(const cvol_sheet_plan *plan, double x, double y)
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = plan->warp[k][0] + x * plan->warp[k][1] + y * plan->warp[k][2];
    /* Where two axes are alike the first of x, y, z has it. */
    const int first_lane = plan->axis_sheet < plan->axis_lane,
              first_row = plan->axis_sheet < plan->axis_row;
    const double lane = d[0] < 0 ? -d[0] : d[0], row = d[1] < 0 ? -d[1] : d[1];
    return d[2] > 0 && (first_lane ? d[2] >= lane : d[2] > lane) &&
           (first_row ? d[2] >= row : d[2] > row);
}

/* D[u] at `points` points of a block of side B, rows `width` long. */
void cvol_sheet_basis(float *basis, int B, int points, int width);

/* The intermediate image: per row six lines of `width` floats. Mode composite: premultiplied
 * colour r g b, transmittance, the table coordinate at the last sheet that the group met, and how
 * much of it was of samples that have a value (arrays with a mask only); the others: see their
 * kernels. */
#define CVOL_LINES 6
typedef struct cvol_intermediate {
    int width, height;
    int down;        /* so many lines lie in one another: CVOL_SQUARE, or 1 */
    float *lines;    /* [height][CVOL_LINES][width] */
    float *scratch;  /* one line for each thread */
    int *spans;      /* [2][height][2]: where lines, and those around, are not empty (warp.c) */
    uint8_t *opaque; /* [height][width / CVOL_GROUP]: nothing behind this group is seen */
    int32_t *intersected; /* [height][width / CVOL_GROUP]: number of the last sheet that it met */
    float *pending;       /* [height][pending_lines][width], of lit frames: see
                             render/sheet/kernels/lit_object_order/shade.h */
    int pending_lines;
    uint8_t *edges; /* [height][width / CVOL_GROUP], the same */
    float *depth;   /* [height][width], if it is asked for: where opacity passes one half, in sheets
                       as they are met; infinity where it never does. Else NULL */
    float *between; /* [height][2 (CVOL_PARTS - 1)][width], where there are samples between sheets:
                       see between.h. Else NULL */
} cvol_intermediate;

/* Where pixel i of line j is in an array that has so many floats for each pixel, the k-th of them.
 */
static inline size_t cvol_pixel_place(const cvol_intermediate *image, int floats, int k, long i,
                                      long j)
{
    const long width = image->width, down = image->down, first = j / down * down;
    const long at = down == 1 ? i : i / down * CVOL_GROUP + (j - first) * down + i % down;
    return (size_t)((first * floats + k * down) * width + at);
}

/* How many lines lie in one another. */
static inline int cvol_lines_at_once(const cvol_sheet_plan *plan)
{
    return plan->image_order ? CVOL_SQUARE : 1;
}

/* Lines of `pending`; the last three only if samples may be without a value. */
#define CVOL_PENDING_LINES 12
#define CVOL_PENDING_LINES_PLAIN 9

/* Multiply-adds for each interpolated sample, and for each part of an interval: of its matter, from
 * the table, and of compositing. */
#define CVOL_ADDS_OF_SAMPLE 4
#define CVOL_ADDS_OF_PART 8

/* One row of it, as kernels see it, or `down` of them. */
typedef struct cvol_line {
    float *values; /* [CVOL_LINES][width] */
    uint8_t *opaque;
    int32_t *intersected;
    float *pending; /* [pending_lines][width] */
    uint8_t *edges;
    float *depth, *between;
    uint64_t *multiply_adds; /* to be added to, if they are to be counted; else NULL */
    int number, width;       /* of the first of the lines that lie in one another; of all of them */
} cvol_line;

/* Bits of a window: something in it can be seen; some samples in it have no value. */
#define CVOL_WINDOW_SEEN 1
#define CVOL_WINDOW_MASKED 2

/* Which windows of a layer's samples can be seen: window c of block row y covers samples
 * 16 (c - 1) .. 16 (c - 1) + 31; `within` for rows inside block row y, `across` for those between y
 * and y + 1. `..._level`: of those that cannot, a value amidst their samples, which says where an
 * interval begins or ends whose other end is seen, and `spread_at` behind it how far from it they
 * may be. [block_rows][count] */
typedef struct cvol_windows {
    const uint8_t *within, *across;
    const float *within_level, *across_level;
    int count, spread_at;
    int first_row, last_row; /* of blocks: those that there are windows of */
} cvol_windows;

/* value[0] + i value[1] + j value[2] of pixel i of line j, and how it grows from sheet to sheet. */
typedef struct cvol_sheet_cut {
    double value[3], rate[3];
} cvol_sheet_cut;

/* What a line kernel needs to know of one sheet. */
typedef struct cvol_sheet_view {
    const float *samples; /* sample s of row r: samples[first + r row_stride + s] */
    const int16_t *int16; /* the same, if they are kept in 16 bits; the other is NULL then */
    long first;
    int ordinal;       /* in the order in which rays meet the sheets */
    float front, back; /* of what is drawn, in sheets from this one, the way that rays take */
    double lane_at, lane_step;        /* sample coordinate of pixel i: lane_at + i lane_step */
    double row_at, row_step;          /* sample coordinate of line j: row_at + j row_step */
    double lane_down, row_right;      /* of image-order plans: how these move with j, and with i */
    double lane_rate[2], row_rate[2]; /* how far, at [0] + i [1], they move from sheet to sheet */
    int begin, end;                   /* groups that lie within, one sheet before or behind */
    int inside_begin, inside_end;     /* those that do, and did from two sheets before on */
    int is_first;                     /* of its layer: the sheet before it lies in another */
    int is_of_before;                 /* it is one of the layer before, whose windows it has */
    cvol_sheet_cut cuts[CVOL_VIEW_PLANES];
} cvol_sheet_view;

typedef struct cvol_layer {
    int sheet_count;
    cvol_int16_scale int16;
    cvol_sheet_view sheets[CVOL_BLOCK_MAX]; /* front to back */
    long row_stride;
    long cover_at; /* how far behind each sample its cover lies (mask.h); 0: all have values */
    int unit;      /* in parallel projection, pixels and samples lie equally far apart */
    int parts;     /* samples from sheet to sheet */
    int only;      /* the volume is one sheet */
    int bounded;   /* windows' levels are what no sample there is beyond: cvol_extremes_bound */
    const cvol_reconstruction_filter *wide; /* of plans, */
    int reach; /* whose windows are of so many samples more; 0: linear */
    int perspective;
    /* Sample coordinates of the faces, a little outwards. In parallel projection also of those
     * through which rays would enter and leave, and in how many sheets a ray moves by one sample;
     * the latter is never zero or infinite. */
    double lane_lo, lane_hi, row_lo, row_hi;
    double lane_enter, lane_leave, row_enter, row_leave;
    float lane_turn, row_turn;
    int cuts; /* of each sheet: drawn is where none is below 0 */
    /* In perspective intervals have the length sqrt(length + (length_lane[0] + i [1])^2 +
     * (length_row[0] + j [1])^2) of that which the table is for. */
    double length, length_lane[2], length_row[2];
    int row_points, block_rows;
    int from_row, to_row, from_lane, to_lane; /* samples that are there: of image-order plans */
    uint64_t row_points_inverse; /* row / row_points = row times this >> 32, of rows below 2^27 */
    cvol_windows windows, windows_before; /* of this layer and the one before; count 0: none */
} cvol_layer;

/* Draws one line of the intermediate image through all sheets of a layer. `sum`: line 0 becomes the
 * weighted sum of the samples, line 1 their weight; `max` and `min`: line 0 the largest or
 * smallest, line 1 becomes 1. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same where samples are kept in 16 bits, without what is asked for seldom. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same with light from 16 bits, of image-order plans, where vectors are the widest. */
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_shade,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The first of image-order plans; with samples between sheets; and from 16 bits. */
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same with light, or a surface. A layer without sheets, whose sheets[0].ordinal would be the
 * next, is what rays end with. */
CVOL_SIMD_DECLARE(void, cvol_sheet_shade,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same two with what else is asked for: depth, samples between sheets. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_shade_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_sum,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The last two from samples of 16 bits, whose values stay as these are kept. */
CVOL_SIMD_DECLARE(void, cvol_sheet_max_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_min_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_max,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_min,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
typedef void cvol_sheet_kernel(const cvol_layer *layer, const cvol_sheet_table *table,
                               const cvol_line *line);

/* Evaluates a block onto the layer's samples. */
CVOL_SIMD_DECLARE(void, cvol_sheet_evaluate,
                  (float *out, long row_stride, long sheet_stride, const cvol_block *block,
                   const cvol_block_axes *axes, int block_log2, float step, cvol_block_work *work));
typedef void cvol_sheet_evaluator(float *out, long row_stride, long sheet_stride,
                                  const cvol_block *block, const cvol_block_axes *axes,
                                  int block_log2, float step, cvol_block_work *work);
/* The same onto samples of 16 bits; and 16^3 samples that are kept as floats. */
CVOL_SIMD_DECLARE(void, cvol_sheet_evaluate_int16,
                  (int16_t * out, long row_stride, long sheet_stride, const cvol_block *block,
                   const cvol_block_axes *axes, int block_log2, float step,
                   const cvol_int16_scale *int16, cvol_block_work *work));
CVOL_SIMD_DECLARE(void, cvol_sheet_copy_int16,
                  (int16_t * out, long row_stride, long sheet_stride, const float *in,
                   long in_row_stride, long in_sheet_stride, const cvol_int16_scale *int16));

/* Filters the four samples nearest to faces in place (transform/lap.h), a0 a1 | a2 a3:
 *     d = h (a1 - a2, a0 - a3),  a1 += d0,  a2 -= d0,  a0 += d1,  a3 -= d1.
 * Faces between lanes: `a2` is the first of `rows` rows in each of `sheets`. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_lanes,
                  (float *a2, long row_stride, long sheet_stride, int rows, int sheets,
                   const float h[4]));
/* Others: of each of the four, `lines` lines of `columns` samples, which lie `stride` apart. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_across,
                  (float *const a[4], long stride, int columns, int lines, const float h[4]));
/* The same on samples of 16 bits. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_lanes_int16,
                  (int16_t * a2, long row_stride, long sheet_stride, int rows, int sheets,
                   const float h[4]));
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_across_int16,
                  (int16_t *const a[4], long stride, int columns, int lines, const float h[4]));
/* Puts `background` where bits are set: row y of sheet z has bits[z sheet_step + y row_step + ...],
 * 16 samples a word. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lay,
                  (float *samples, long row_stride, long sheet_stride, int rows, int sheets,
                   int lanes, const uint16_t *bits, int row_step, int sheet_step,
                   float background));
CVOL_SIMD_DECLARE(void, cvol_sheet_lay_int16,
                  (int16_t * samples, long row_stride, long sheet_stride, int rows, int sheets,
                   int lanes, const uint16_t *bits, int row_step, int sheet_step,
                   int16_t background));
/* Bounds samples from below and above. */
CVOL_SIMD_DECLARE(void, cvol_sheet_clamp,
                  (float *samples, long row_stride, long sheet_stride, int columns, int rows,
                   int sheets, float lo, float hi));
CVOL_SIMD_DECLARE(void, cvol_sheet_clamp_int16,
                  (int16_t * samples, long row_stride, long sheet_stride, int columns, int rows,
                   int sheets, int16_t lo, int16_t hi));

/* Draws the picture from the intermediate image's colour and transmittance by Catmull-Rom
 * interpolation, over the background. The lines are used up: they are turned into pixels in place.
 */
void cvol_warp_composite(cvol_image *image, cvol_intermediate *intermediate,
                         const cvol_sheet_plan *plan, const double background[3], int threads);
/* A picture of nothing: background, or floats that are transparent. */
void cvol_warp_nothing(cvol_image *image, int grey, const double background[3]);
/* The same for grey = (line 0 / line 1 - lo) / (hi - lo) where line 1 > 0. */
void cvol_warp_grey(cvol_image *image, cvol_intermediate *intermediate, const cvol_sheet_plan *plan,
                    double lo, double hi, const double background[3], int threads);
/* Depths of the plan's pixels, where image->depth is, and of none. */
void cvol_sheet_depth_draw(cvol_image *image, const cvol_intermediate *intermediate,
                           const cvol_sheet_plan *plan, const cvol_view *view,
                           const double spacing[3], int threads);
void cvol_sheet_depth_clear(cvol_image *image);

#endif
