/* The sheet engine's kernels: evaluation of blocks onto a layer's samples, and one line of the
 * intermediate image through all sheets of a layer, in groups of 16 pixels.
 *
 * Each sheet's samples are reconstructed by the linear footprint on the sheet's own grid: two rows,
 * two lanes. Under parallel projection all pixels of a line share the row weights, and, where
 * intermediate image and samples have one pitch, the lane weights too.
 */
#include <math.h>

#include "base/vector.h"
#include "render/sheet.h"

/* A group whose transmittance is below this in every pixel is done: what lies behind could change
 * no channel by more than half a step of 255. */
#define OPAQUE_BELOW (1.0f / 512)

void CVOL_SIMD(cvol_sheet_evaluate)(float *out, long row_stride, long sheet_stride,
                                    const cvol_block *block, const cvol_block_axes *axes,
                                    int block_log2, float step, cvol_block_work *work)
{
    cvol_block_inverse(out, row_stride, sheet_stride, block, axes, block_log2, step, work);
}

/* One sheet as one line of the image sees it. */
typedef struct line_view {
    const float *near, *far; /* the two rows of samples */
    cvol_v16 near_weight, far_weight;
    const uint8_t *windows;
    int begin, end; /* groups that meet the sheet */
} line_view;

/* 0 if the line misses the sheet. */
CVOL_INLINE int view_line(line_view *view, const cvol_layer *layer, const cvol_sheet_view *sheet,
                          int j, int width)
{
    const double tolerance = 1e-4;
    double r = sheet->row_at + j * layer->row_step;
    if (r < layer->row_lo - tolerance || r > layer->row_hi + tolerance)
        return 0;
    /* Rows -1 and one past the last exist as copies, so that floor() needs no clamp. */
    double whole = floor(r);
    long y = (long)whole;
    float fraction = (float)(r - whole);
    view->near = sheet->samples + y * layer->row_stride;
    view->far = view->near + layer->row_stride;
    view->near_weight = cvol_splat16(1 - fraction);
    view->far_weight = cvol_splat16(fraction);
    long last = (long)layer->block_rows * layer->row_points - 1;
    long low = y < 0 ? 0 : y > last ? last : y, high = y + 1 > last ? last : y + 1;
    long block_row = low / layer->row_points;
    int across = high / layer->row_points != block_row;
    view->windows = (across ? layer->across : layer->within) + block_row * layer->windows;
    double first = ceil((layer->lane_lo - tolerance - sheet->lane_at) / layer->lane_step);
    double final = floor((layer->lane_hi + tolerance - sheet->lane_at) / layer->lane_step);
    view->begin = first > 0 ? (int)first / CVOL_GROUP : 0;
    view->end = final < width - 1 ? (final < 0 ? 0 : (int) final / CVOL_GROUP + 1)
                                  : width / CVOL_GROUP;
    return view->begin < view->end;
}

/* The reconstructed samples of 16 pixels, `unit`: pixels and samples have one pitch. */
CVOL_INLINE cvol_v16 reconstruct(const line_view *view, long x, double position, double step,
                                 int unit)
{
    if (unit) {
        float fraction = (float)(position - (double)x);
        cvol_v16 left = view->near_weight * cvol_load16(view->near + x) +
                        view->far_weight * cvol_load16(view->far + x);
        cvol_v16 right = view->near_weight * cvol_load16(view->near + x + 1) +
                         view->far_weight * cvol_load16(view->far + x + 1);
        return left + fraction * (right - left);
    }
    cvol_v16 low = view->near_weight * cvol_load16(view->near + x) +
                   view->far_weight * cvol_load16(view->far + x);
    cvol_v16 high = view->near_weight * cvol_load16(view->near + x + 16) +
                    view->far_weight * cvol_load16(view->far + x + 16);
    cvol_v16 at = (float)(position - (double)x) + cvol_iota16() * (float)step;
    cvol_i16 index = cvol_to_int16(at);
    cvol_v16 fraction = at - cvol_to_float16(index);
    cvol_v16 left = cvol_shuffle16(low, high, index);
    cvol_v16 right = cvol_shuffle16(low, high, index + 1);
    return left + fraction * (right - left);
}

/* Which pixels of a group lie within the sheet. */
CVOL_INLINE cvol_i16 inside_mask(const cvol_layer *layer, double position)
{
    const float tolerance = 1e-4f;
    cvol_v16 offset = cvol_iota16() * (float)layer->lane_step;
    return (offset >= (float)(layer->lane_lo - position) - tolerance) &
           (offset <= (float)(layer->lane_hi - position) + tolerance);
}

CVOL_INLINE int is_inside(const cvol_layer *layer, double position)
{
    return position >= layer->lane_lo && position + 15 * layer->lane_step <= layer->lane_hi;
}

/* I += (1 - A) F D,  A += (1 - A) D, with the transmittance t = 1 - A. */
CVOL_INLINE void composite_group(const cvol_sheet_table *table, float *lines, uint8_t *opaque,
                                 int group, int width, cvol_v16 value, cvol_i16 mask, int masked)
{
    cvol_i16 seen = (value >= table->visible_from) & (value <= table->visible_to);
    if (masked)
        seen &= mask;
    if (!cvol_any16(seen))
        return;
    cvol_v16 t = (value - table->from) * table->scale;
    t = cvol_min16(cvol_max16(t, cvol_splat16(0)), cvol_splat16(CVOL_TABLE_SIZE - 1));
    cvol_i16 index = cvol_to_int16(t);
    cvol_v16 opacity = (cvol_v16)(cvol_lookup16(table->opacity, index) & seen);
    cvol_i16 colour = cvol_lookup16(table->colour, index);
    float *r = lines + group * CVOL_GROUP, *g = r + width, *b = g + width, *through = b + width;
    cvol_v16 before = cvol_load16(through);
    cvol_v16 weight = before * opacity, after = before - weight;
    cvol_store16(through, after);
    weight *= 1.0f / 1023;
    cvol_store16(r, cvol_load16(r) + weight * cvol_to_float16(colour & 1023));
    cvol_store16(g, cvol_load16(g) + weight * cvol_to_float16((colour >> 10) & 1023));
    cvol_store16(b, cvol_load16(b) + weight * cvol_to_float16(colour >> 20));
    if (!cvol_any16(after >= OPAQUE_BELOW))
        opaque[group] = 1;
}

CVOL_INLINE void composite_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet,
                                 const cvol_sheet_table *table, float *lines, uint8_t *opaque,
                                 int j, int width, int unit)
{
    line_view view;
    if (!view_line(&view, layer, sheet, j, width))
        return;
    const double step = unit ? 1 : layer->lane_step;
    for (int group = view.begin; group < view.end; group++) {
        double position = sheet->lane_at + group * CVOL_GROUP * step;
        long x = (long)floor(position);
        if (opaque[group] || !view.windows[(x + CVOL_GROUP) / CVOL_GROUP])
            continue;
        cvol_v16 value = reconstruct(&view, x, position, step, unit);
        if (is_inside(layer, position))
            composite_group(table, lines, opaque, group, width, value, (cvol_i16){0}, 0);
        else
            composite_group(table, lines, opaque, group, width, value, inside_mask(layer, position),
                            1);
    }
}

void CVOL_SIMD(cvol_sheet_composite)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     float *lines, uint8_t *opaque, int j, int width)
{
    if (layer->lane_step == 1)
        for (int s = 0; s < layer->sheet_count; s++)
            composite_sheet(layer, &layer->sheets[s], table, lines, opaque, j, width, 1);
    else
        for (int s = 0; s < layer->sheet_count; s++)
            composite_sheet(layer, &layer->sheets[s], table, lines, opaque, j, width, 0);
}

/* Lines 0 and 1: the sum of the samples and their number, or the largest sample and 1. */
CVOL_INLINE void project_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet, float *lines,
                               int j, int width, int unit, int largest)
{
    line_view view;
    if (!view_line(&view, layer, sheet, j, width))
        return;
    const double step = unit ? 1 : layer->lane_step;
    for (int group = view.begin; group < view.end; group++) {
        double position = sheet->lane_at + group * CVOL_GROUP * step;
        long x = (long)floor(position);
        cvol_v16 value = reconstruct(&view, x, position, step, unit);
        cvol_i16 mask = inside_mask(layer, position);
        float *first = lines + group * CVOL_GROUP, *second = first + width;
        cvol_v16 result = cvol_load16(first), count = cvol_load16(second);
        cvol_v16 one = cvol_splat16(1);
        if (largest) {
            cvol_i16 better = mask & ((value > result) | (count == 0));
            cvol_store16(first, cvol_select16(better, value, result));
            cvol_store16(second, cvol_select16(mask, one, count));
        } else {
            cvol_store16(first, cvol_select16(mask, result + value, result));
            cvol_store16(second, cvol_select16(mask, count + one, count));
        }
    }
}

void CVOL_SIMD(cvol_sheet_sum)(const cvol_layer *layer, const cvol_sheet_table *table, float *lines,
                               uint8_t *opaque, int j, int width)
{
    (void)table;
    (void)opaque;
    for (int s = 0; s < layer->sheet_count; s++) {
        if (layer->lane_step == 1)
            project_sheet(layer, &layer->sheets[s], lines, j, width, 1, 0);
        else
            project_sheet(layer, &layer->sheets[s], lines, j, width, 0, 0);
    }
}

void CVOL_SIMD(cvol_sheet_max)(const cvol_layer *layer, const cvol_sheet_table *table, float *lines,
                               uint8_t *opaque, int j, int width)
{
    (void)table;
    (void)opaque;
    for (int s = 0; s < layer->sheet_count; s++) {
        if (layer->lane_step == 1)
            project_sheet(layer, &layer->sheets[s], lines, j, width, 1, 1);
        else
            project_sheet(layer, &layer->sheets[s], lines, j, width, 0, 1);
    }
}
