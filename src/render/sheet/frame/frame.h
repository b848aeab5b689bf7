/* Internals of the sheet engine: the common types of its plan, its skipping, its kernels and its
 * warp.
 *
 * Axes: `lane` and `row` lie in the slices, `sheet` is the principal viewing axis, across them. All
 * in-plane coordinates are sample indices of the volume along lane and row.
 *
 * A layer is the slices of one layer of blocks. Its samples are evaluated onto a regular grid of
 * `points` per block and axis: sample s of an axis lies at index  first + s pitch, pitch = block /
 * points, first = (pitch - 1) / 2. The same holds for slice s along its axis.
 *
 * Intermediate pixel (i, j) is the ray that crosses slice 0 at the in-plane point
 *     U = u0 + i du,  V = v0 + j dv
 * and the plane of samples z at (U + shear_lane z, V + shear_row z). In perspective, with the eye
 * at (eye_lane, eye_row, eye_sheet), these lie on the plane one sample before the eye, and the ray
 * crosses the plane that is t samples before it at eye + t (U - eye_lane, V - eye_row). A picture
 * in perspective is drawn by up to six plans, one for the pixels whose rays run most along its
 * axis.
 *
 * Near the faces of the drawn part (the volume or a clip), the weight of a slice, or of an interval
 * between slices, is the share of the ray's way through it that lies inside. As in engine ray, an
 * axis of one sample is one spacing thick. Samples beyond the volume are copies of those at its
 * faces. */
#ifndef CVOL_RENDER_SHEET_FRAME_FRAME_H
#define CVOL_RENDER_SHEET_FRAME_FRAME_H

#include "array/block/block_inverse.h"
#include "array/core/array.h"
#include "base/cpu.h"
#include "base/vector.h"
#include "cvol/image.h"
#include "cvol/render.h"
#include "render/sheet/frame/int16_format.h"
#include "render/sheet/frame/reconstruction_filter.h"
#include "render/view/light.h"
#include "render/view/view.h"

#define CVOL_TABLE_SIZE 2048
/* The most samples between two slices. */
#define CVOL_PARTS 4
/* The tolerance of opacity and colour against a straight line before an interval is divided. */
#define CVOL_FLAT_TOLERANCE 0.05f
/* The tolerance in object order, which has a larger error anyway, if the error of samples is large,
 * or if the function is translucent, unlit, and smooth: linear over at least CVOL_SMOOTH of the
 * function's span. */
#define CVOL_FLAT_TOLERANCE_COARSE 0.175f
#define CVOL_SMOOTH 0.07
/* Opacity up to which a function is translucent. */
#define CVOL_TRANSLUCENT 0.45
/* The number of intermediate pixels in a group, which kernels process together. */
#define CVOL_GROUP 16
/* In image order a group is a square with this side, whose rays lie close together and so see about
 * the same. A line then has this number of lines of the picture, stored square by square. */
#define CVOL_SQUARE 4
#define CVOL_SQUARE_LOG2 2
/* Samples left and right of each row of a slice, so that a group may reach beyond it. */
#define CVOL_SHEET_PAD 32

/* Segments of a table, and bins of its coordinates that give the first segment to test. */
#define CVOL_SEGMENTS 32
#define CVOL_SEGMENTS_FEW 16
#define CVOL_SEGMENT_BINS 64
#define CVOL_SEGMENT_BIN_LOG2 5

/* Cells of a table's integrals, of two entries each. */
#define CVOL_INTEGRAL_CELLS (CVOL_TABLE_SIZE / 2)

/* Classification of one frame (table.c). The table coordinate of a value is (value - offset - from)
 * scale, and entry t covers t .. t + 1. Entries have the opacity (first) over the distance between
 * two slices, and the colour (second: r | g << 10 | b << 20). Over intervals of up to `flat`
 * entries both are nearly linear.
 *
 * The same as segments: colour times opacity (0 to 2) and opacity (3) are
 *     segment_start[k][i] + t segment_rise[k][i]
 * with i the first segment whose end lies beyond t; it is at most two after that of t's bin, with
 * few segments at most one. */
typedef struct cvol_sheet_table {
    /* For lit frames: differences of table coordinates between points two apart, along lane, row,
     * and sheet in the order of rays. */
    const cvol_light *light;
    /* 1: gradients, not light, are interpolated between two slices, and every interval is also lit
     * in its middle. */
    int interpolates_gradients;
    /* An interval's middle differs from linear interpolation by this factor times the difference of
     * the gradients of its ends, along lane and row. */
    float shear_correction[2];
    int is_surface; /* then only coordinates of `at` or more are visible, with this colour */
    float at, colour[3];
    float cut_black, cut_scale;                      /* cut faces of a surface have the brightness
                                                        (coordinate - cut_black) cut_scale, within 0 .. 1 */
    float from, scale, flat, flat_coarse, flat_fine; /* for coarser and finer requirements */
    int is_translucent;                              /* and smooth */
    float slope; /* the steepest rise of colour or opacity per entry */
    /* In image order, intervals that rise by more than `midpoint` entries get a midpoint sample
     * (midpoint.h). Its weight grows with the rise, and is 1 from midpoint + midpoint_ramp on. */
    float midpoint, midpoint_ramp;
    float steep;        /* intervals that rise by more than this have four parts */
    float light_change; /* for lit image-order plans: intervals whose lit ends differ by more than
                           this in colour or opacity are divided, too */
    int midpoints;      /* for lit image-order plans: every interval has a midpoint sample */
    float visible_from, visible_to; /* opacity is 0 outside of these table coordinates */
    int segments;                   /* CVOL_SEGMENTS, or _FEW; 0: there are only entries */
    float segment_end[CVOL_SEGMENTS] __attribute__((aligned(64)));
    float segment_start[4][CVOL_SEGMENTS] __attribute__((aligned(64)));
    float segment_rise[4][CVOL_SEGMENTS] __attribute__((aligned(64)));
    int16_t segment_of[CVOL_SEGMENT_BINS] __attribute__((aligned(64)));
    cvol_pair entries[CVOL_TABLE_SIZE] __attribute__((aligned(64)));
    /* Integrals of the extinction -ln(1 - opacity) (3), and of colour times extinction (0 to 2),
     * from coordinate 0 to the start of each cell, over integral_unit; and their slopes at both
     * ends, beyond which the function is constant. Intervals that rise by more than `integrated`
     * entries use these. */
    int32_t integral[CVOL_INTEGRAL_CELLS + 1][4] __attribute__((aligned(64)));
    float integral_unit, extinction_before[4], extinction_behind[4];
    float integrated;
    cvol_int16_table int16;              /* for frames with int16 samples */
    double channels[CVOL_TABLE_SIZE][4]; /* the entries in double precision: colour times opacity,
                                            and opacity; too large for the stack of a thread */
} cvol_sheet_table;

/* The kind of samples that are not part of the transform (array/core/mask.h). */
typedef enum cvol_sheet_masked {
    CVOL_SHEET_ALL_PLAIN,      /* there are none */
    CVOL_SHEET_SOME_VOID,      /* without a value */
    CVOL_SHEET_SOME_BACKGROUND /* of the background's value */
} cvol_sheet_masked;

/* The format of a layer's int16 samples, which kernels that classify by segments read: a value v,
 * minus the array's offset, is stored as v scale + offset, rounded, at least 0 and at most
 * CVOL_INT16_MAX. scale 0: samples are floats. */
#define CVOL_INT16_MAX 32767
typedef struct cvol_int16_scale {
    float scale, offset;
} cvol_int16_scale;

static inline int16_t cvol_int16_scale_of(const cvol_int16_scale *int16, float value)
{
    const float scaled = value * int16->scale + int16->offset + 0.5f;
    return (int16_t)(scaled > 0 ? scaled < CVOL_INT16_MAX ? scaled : CVOL_INT16_MAX : 0);
}

/* Planes that limit what a plan draws: those of the view, and the faces of a part. */
#define CVOL_SHEET_PLANES (CVOL_VIEW_PLANES + 6)

typedef struct cvol_sheet_plan {
    int axis_lane, axis_row, axis_sheet;
    size_t lanes, rows, sheets; /* the volume's samples along each */
    size_t blocks_lane, blocks_row, layers;
    int block_lane, block_row, block_sheet; /* samples of a block along each */
    size_t sheet_count;
    int beyond; /* 1: rays end up to half a slice behind the last one; they meet it once more behind
                   it */
    int level;  /* a level of the volume is drawn (level.h); 0: the volume itself */
    int lapped; /* the array is lapped, and no level is drawn */
    int lit;    /* samples one point further are read */
    const cvol_reconstruction_filter *wide; /* the reconstruction filter; NULL: linear */
    int reach; /* number of points beyond the linear filter's that are read, for light and the
                  reconstruction filter */
    cvol_int16_scale int16;
    cvol_sheet_masked masked;
    int ascending; /* rays meet slices in rising order */
    double shear_lane, shear_row;
    double distance; /* between slices along a ray, in mean spacings; in perspective the largest */
    int parts;       /* samples between slices: 1, or CVOL_PARTS at most */
    int clipped;     /* lo, hi are not the volume's faces, or there are planes */
    double lo[3], hi[3];           /* the drawn part: of lane, row, sheet, in sample indices, */
    double used_lo[3], used_hi[3]; /* the samples that it needs: fewer for a part */
    int planes;                    /* and plane . (lane, row, sheet, 1) >= 0 for all */
    int part_planes; /* the last of them are faces of a part: cvol_sheet_plan_narrow */
    double plane[CVOL_SHEET_PLANES][4];
    int fades; /* faces of the clip: fade . (lane, row, sheet, 1) as cvol_view.cut */
    double fade[CVOL_VIEW_CUTS][4];
    int perspective;
    double eye_lane, eye_row, eye_sheet;
    double spacing[3]; /* of lane, row, sheet, over the mean */
    int points_lane, points_row, points_sheet;
    double pitch_lane, pitch_row, pitch_sheet, first_lane, first_row, first_sheet;
    double u0, v0, du, dv;
    int width, height; /* of the intermediate image; width a multiple of CVOL_GROUP */
    /* picture pixel (x, y) sees (U, V) = warp[.][0] + x warp[.][1] + y warp[.][2]. In perspective
     * that is the direction of its ray along lane, row and, third, sheet, and U - eye_lane =
     * direction[0] / direction[2] */
    double warp[3][3];
    double own[2]; /* the plan draws the picture's pixels with own[0] <= V < own[1]: not all pixels,
                      if the plan is a tile (frame_tile.h) */
    /* For image-order plans (plan_image_order.c): ray (i, j) crosses slice 0 at the in-plane point
     * place[.][0] + i place[.][1] + j place[.][2]. Here i and j replace U and V: u0 = v0 = 0, du =
     * dv = 1, and the warp maps pixels to these. */
    int image_order;
    double place[2][3];
} cvol_sheet_plan;

/* The points at which rays cross a plane of samples: U at lane + scale U, V at row + scale V. */
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

/* The distance that the volume reaches beyond the centres of its first and last sample. */
static inline double cvol_sheet_margin(size_t samples)
{
    return samples > 1 ? 0 : 0.5;
}

/* The position of slice s, as an index of samples. */
static inline double cvol_sheet_place(const cvol_sheet_plan *plan, size_t sheet)
{
    return plan->first_sheet + (double)sheet * plan->pitch_sheet;
}

/* Finds axes, shear, resolution and extent of the intermediate image for a view in parallel
 * projection. `level`: the source's level. Errors: LIMIT (the intermediate image is too large). */
int cvol_sheet_plan_make(cvol_context *context, cvol_sheet_plan *plan, const cvol_array *array,
                         int level, const cvol_view *view);
/* The same for a view in perspective: for the part of the picture that is seen along an axis
 * (`along` 0 to 5: twice the axis, and 1 if rays meet slices in rising order). *empty: there is
 * none. Errors: LIMIT. */
int cvol_sheet_plan_make_along(cvol_context *context, cvol_sheet_plan *plan, int *empty,
                               const cvol_array *array, int level, const cvol_view *view,
                               int along);
/* Limits a plan, whose rays and extent are those of the whole view, to the view's part. In modes
 * composite and iso an interval of a ray belongs to the part that has its middle, whole; values and
 * gradients at its ends are those of the volume, as the slices around the part are read, too. So
 * the parts put together are the picture of the whole. Other modes draw the part as a box. */
void cvol_sheet_plan_narrow(cvol_sheet_plan *plan, const cvol_view *view, cvol_mode mode);

/* Returns 1 if pixel (x, y) of the picture belongs to a plan: in parallel projection all do. */
static inline int cvol_sheet_plan_has(const cvol_sheet_plan *plan, double x, double y)
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = plan->warp[k][0] + x * plan->warp[k][1] + y * plan->warp[k][2];
    /* If two axes are equal, the first of x, y, z owns the pixel. */
    const int first_lane = plan->axis_sheet < plan->axis_lane,
              first_row = plan->axis_sheet < plan->axis_row;
    const double lane = d[0] < 0 ? -d[0] : d[0], row = d[1] < 0 ? -d[1] : d[1];
    return d[2] > 0 && (first_lane ? d[2] >= lane : d[2] > lane) &&
           (first_row ? d[2] >= row : d[2] > row);
}

/* D[u] at `points` points of a block of side B, rows `width` long. */
void cvol_sheet_basis(float *basis, int B, int points, int width);

/* The intermediate image: per row six lines of `width` floats. Mode composite: premultiplied colour
 * r g b, transmittance, the table coordinate at the last slice that the group met, and the cover
 * there (arrays with a mask only). Other modes: see their kernels. */
#define CVOL_LINES 6
typedef struct cvol_intermediate {
    int width, height;
    int down;        /* number of interleaved lines: CVOL_SQUARE, or 1 */
    float *lines;    /* [height][CVOL_LINES][width] */
    float *scratch;  /* one line for each thread */
    int *spans;      /* [2][height][2]: spans of lines, and of their neighbours, that are not empty
                        (warp.c) */
    uint8_t *opaque; /* [height][width / CVOL_GROUP]: 1: everything behind this group is hidden */
    int32_t *intersected; /* [height][width / CVOL_GROUP]: number of the last slice that it met */
    float *pending;       /* [height][pending_lines][width], of lit frames: see
                             render/sheet/kernels/lit_object_order/shade.h */
    int pending_lines;
    uint8_t *edges; /* [height][width / CVOL_GROUP], the same */
    float *depth;   /* [height][width], if requested: the place where opacity passes one half, in
                       slices in the order of rays; infinity if it never does. Else NULL */
    float *between; /* [height][2 (CVOL_PARTS - 1)][width], if there are samples between slices: see
                       between.h. Else NULL */
} cvol_intermediate;

/* The position of pixel i of line j in an array with `floats` floats per pixel, for float k. */
static inline size_t cvol_pixel_place(const cvol_intermediate *image, int floats, int k,
                                      ptrdiff_t i, ptrdiff_t j)
{
    const ptrdiff_t width = image->width, down = image->down, first = j / down * down;
    const ptrdiff_t at = down == 1 ? i : i / down * CVOL_GROUP + (j - first) * down + i % down;
    return (size_t)((first * floats + k * down) * width + at);
}

/* The number of interleaved lines. */
static inline int cvol_lines_interleaved(const cvol_sheet_plan *plan)
{
    return plan->image_order ? CVOL_SQUARE : 1;
}

/* Lines of `pending`; the last three only if samples may have no value. */
#define CVOL_PENDING_LINES 12
#define CVOL_PENDING_LINES_PLAIN 9

/* Multiply-adds for each interpolated sample, and for each part of an interval: for its
 * classification and compositing. */
#define CVOL_ADDS_OF_SAMPLE 4
#define CVOL_ADDS_OF_PART 8

/* One row of the image, in the form that kernels use, or `down` of them. */
typedef struct cvol_line {
    float *values; /* [CVOL_LINES][width] */
    uint8_t *opaque;
    int32_t *intersected;
    float *pending; /* [pending_lines][width] */
    uint8_t *edges;
    float *depth, *between;
    uint64_t *multiply_adds; /* counter, if multiply-adds are counted; else NULL */
    int number, width;       /* of the first of the interleaved lines; of all of them */
} cvol_line;

/* Bits of a window: some sample in it is visible; some samples in it have no value. */
#define CVOL_WINDOW_SEEN 1
#define CVOL_WINDOW_MASKED 2

/* The visibility of a layer's windows: window c of block row y covers samples 16 (c - 1) .. 16 (c -
 * 1) + 31; `within` for rows inside block row y, `across` for rows between y and y + 1. For
 * invisible windows, `..._level` is a value in the middle of their samples, which is used at the
 * end of an interval whose other end is visible. The spread, `spread_at` behind it, is the largest
 * distance of samples from it. [block_rows][count] */
typedef struct cvol_windows {
    const uint8_t *within, *across;
    const float *within_level, *across_level;
    int count, spread_at;
    int first_row, last_row; /* of blocks: the rows that have windows */
} cvol_windows;

/* value[0] + i value[1] + j value[2] for pixel i of line j, and its growth per slice. */
typedef struct cvol_sheet_linear {
    double value[3], rate[3];
} cvol_sheet_linear;

/* A slice, as a line kernel sees it. */
typedef struct cvol_sheet_view {
    const float *samples; /* sample s of row r: samples[first + r row_stride + s] */
    const int16_t *int16; /* the same as int16; the other is NULL */
    ptrdiff_t first;
    int ordinal;                 /* in the order in which rays meet the slices */
    float front, back;           /* of the drawn part, in slices from this one, in ray direction */
    double lane_at, lane_step;   /* sample coordinate of pixel i: lane_at + i lane_step */
    double row_at, row_step;     /* sample coordinate of line j: row_at + j row_step */
    double lane_down, row_right; /* for image-order plans: change of these with j, and with i */
    double lane_rate[2], row_rate[2]; /* change per slice, at [0] + i [1] */
    int begin, end; /* groups that meet the drawn part within one slice before or behind */
    int inside_begin, inside_end; /* groups inside it, from two slices before on */
    int is_first;                 /* of its layer: the slice before it lies in another one */
    int is_of_previous_layer;     /* it belongs to the layer before, and has its windows */
    cvol_sheet_linear cuts[CVOL_SHEET_PLANES];
} cvol_sheet_view;

typedef struct cvol_layer {
    int sheet_count;
    cvol_int16_scale int16;
    cvol_sheet_view sheets[CVOL_BLOCK_MAX]; /* front to back */
    ptrdiff_t row_stride;
    ptrdiff_t
        cover_at; /* distance in memory between a sample and its cover (mask.h); 0: all have values
                   */
    int unit;     /* in parallel projection, pixels and samples are equally far apart */
    int parts;    /* samples between slices */
    int only;     /* the volume is one slice */
    int bounded;  /* levels of windows bound their samples: cvol_extremes_bound */
    const cvol_reconstruction_filter *wide; /* the plan's filter, */
    int reach; /* whose windows have this number of samples more; 0: linear */
    int perspective;
    /* Sample coordinates of the faces, moved a little outwards. In parallel projection also of the
     * faces through which rays would enter and leave, and the number of slices in which a ray moves
     * by one sample, which is never zero or infinite. */
    double lane_lo, lane_hi, row_lo, row_hi;
    double lane_enter, lane_leave, row_enter, row_leave;
    float lane_slices, row_slices;
    int cuts;      /* of each slice: drawn if none is below 0 */
    int part_cuts; /* the last of them are faces of a part */
    int fades;     /* at the layer's first slice: depths behind faces of the clip (cvol_cut_fade) */
    cvol_sheet_linear fade[CVOL_VIEW_CUTS];
    /* In perspective an interval has the length sqrt(length + (length_lane[0] + i [1])^2 +
     * (length_row[0] + j [1])^2), relative to that of the table. */
    double length, length_lane[2], length_row[2];
    int row_points, block_rows;
    int from_row, to_row, from_lane, to_lane; /* existing samples: for image-order plans */
    uint64_t row_points_inverse; /* row / row_points = row times this >> 32, for rows below 2^27 */
    cvol_windows windows, windows_before; /* of this layer and the one before; count 0: none */
} cvol_layer;

/* Draws one line of the intermediate image through all slices of a layer. `sum`: line 0 becomes the
 * weighted sum of the samples, line 1 their weight; `max` and `min`: line 0 the largest or
 * smallest, line 1 becomes 1. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same for int16 samples, without the extras. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same with light, for image-order plans; and from int16 samples, with the widest vectors. */
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_shade,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_shade_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The first for image-order plans; with samples between slices; and from int16 samples. */
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_image_order_int16,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same with light, or a surface. A layer without slices, with sheets[0].ordinal the next
 * number, ends the rays. */
CVOL_SIMD_DECLARE(void, cvol_sheet_shade,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The same two with extras: depth, samples between slices. */
CVOL_SIMD_DECLARE(void, cvol_sheet_composite_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_shade_extra,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
CVOL_SIMD_DECLARE(void, cvol_sheet_sum,
                  (const cvol_layer *layer, const cvol_sheet_table *table, const cvol_line *line));
/* The last two from int16 samples; results stay in that format. */
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
                  (float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                   const cvol_block *block, const cvol_block_axes *axes, int block_log2, float step,
                   cvol_block_work *work));
typedef void cvol_sheet_evaluator(float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                  const cvol_block *block, const cvol_block_axes *axes,
                                  int block_log2, float step, cvol_block_work *work);
/* The same for int16 samples; and from 16^3 samples stored as floats. */
CVOL_SIMD_DECLARE(void, cvol_sheet_evaluate_int16,
                  (int16_t * out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                   const cvol_block *block, const cvol_block_axes *axes, int block_log2, float step,
                   const cvol_int16_scale *int16, cvol_block_work *work));
CVOL_SIMD_DECLARE(void, cvol_sheet_copy_int16,
                  (int16_t * out, ptrdiff_t row_stride, ptrdiff_t sheet_stride, const float *in,
                   ptrdiff_t in_row_stride, ptrdiff_t in_sheet_stride,
                   const cvol_int16_scale *int16));

/* Filters the four samples nearest to faces in place (transform/lap.h), a0 a1 | a2 a3:
 *     d = h (a1 - a2, a0 - a3),  a1 += d0,  a2 -= d0,  a0 += d1,  a3 -= d1.
 * Faces between lanes: `a2` is the first of `rows` rows in each of `sheets`. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_lanes,
                  (float *a2, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int rows, int sheets,
                   const float h[4]));
/* Other faces: for each of the four, `lines` lines of `columns` samples, which lie `stride`
 * apart. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_across,
                  (float *const a[4], ptrdiff_t stride, int columns, int lines, const float h[4]));
/* The same for int16 samples. */
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_lanes_int16,
                  (int16_t * a2, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int rows, int sheets,
                   const float h[4]));
CVOL_SIMD_DECLARE(void, cvol_sheet_lap_across_int16,
                  (int16_t *const a[4], ptrdiff_t stride, int columns, int lines,
                   const float h[4]));
/* Writes `background` where bits are set: row y of slice z has bits[z sheet_step + y row_step +
 * ...], 16 samples per word. */
CVOL_SIMD_DECLARE(void, cvol_sheet_fill_masked,
                  (float *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int rows,
                   int sheets, int lanes, const uint16_t *bits, int row_step, int sheet_step,
                   float background));
CVOL_SIMD_DECLARE(void, cvol_sheet_fill_masked_int16,
                  (int16_t * samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int rows,
                   int sheets, int lanes, const uint16_t *bits, int row_step, int sheet_step,
                   int16_t background));
/* Clamps samples to a range. */
CVOL_SIMD_DECLARE(void, cvol_sheet_clamp,
                  (float *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int columns,
                   int rows, int sheets, float lo, float hi));
CVOL_SIMD_DECLARE(void, cvol_sheet_clamp_int16,
                  (int16_t * samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride, int columns,
                   int rows, int sheets, int16_t lo, int16_t hi));

/* Draws the picture from the intermediate image's colour and transmittance by Catmull-Rom
 * interpolation, over the background. It overwrites the lines: they become pixels in place. */
void cvol_warp_composite(cvol_image *image, cvol_intermediate *intermediate,
                         const cvol_sheet_plan *plan, const double background[3], int threads);
/* An empty picture: background, or transparent floats. */
void cvol_warp_nothing(cvol_image *image, int grey, const double background[3]);
/* The same for grey = (line 0 / line 1 - lo) / (hi - lo) where line 1 > 0. */
void cvol_warp_grey(cvol_image *image, cvol_intermediate *intermediate, const cvol_sheet_plan *plan,
                    double lo, double hi, const double background[3], int threads);
/* Depths of the plan's pixels, into image->depth; and of an empty picture. */
void cvol_sheet_depth_draw(cvol_image *image, const cvol_intermediate *intermediate,
                           const cvol_sheet_plan *plan, const cvol_view *view,
                           const double spacing[3], int threads);
void cvol_sheet_depth_clear(cvol_image *image);

#endif
