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
    float near_weight, far_weight;
    const uint8_t *windows;
} line_view;

/* 0 if the line misses the sheet. */
CVOL_INLINE int view_line(line_view *view, const cvol_layer *layer, const cvol_sheet_view *sheet,
                          int j)
{
    const double tolerance = 1e-4;
    double r = sheet->row_at + j * layer->row_step;
    if (r < layer->row_lo - tolerance || r > layer->row_hi + tolerance)
        return 0;
    /* Rows -1 and one past the last exist as copies, so that floor() needs no clamp. */
    long y = (long)floor(r);
    view->far_weight = (float)(r - (double)y);
    view->near_weight = 1 - view->far_weight;
    view->near = sheet->samples + (sheet->first + y * layer->row_stride);
    view->far = view->near + layer->row_stride;
    int last = layer->block_rows * layer->row_points - 1;
    int low = y < 0 ? 0 : (int)y, high = y + 1 > last ? last : (int)y + 1;
    low = low > last ? last : low;
    int block_row = low / layer->row_points;
    int across = high >= (block_row + 1) * layer->row_points;
    view->windows = (across ? layer->across : layer->within) + block_row * layer->windows;
    return 1;
}

/* The linear footprint where pixels and samples have one pitch: four weights for all pixels. */
typedef struct unit_footprint {
    long x; /* sample left of pixel 0 */
    cvol_vf near_left, near_right, far_left, far_right;
} unit_footprint;

CVOL_INLINE unit_footprint make_unit_footprint(const line_view *view, const cvol_sheet_view *sheet)
{
    double whole = floor(sheet->lane_at);
    float right = (float)(sheet->lane_at - whole), left = 1 - right;
    return (unit_footprint){.x = (long)whole,
                            .near_left = cvol_splat(view->near_weight * left),
                            .near_right = cvol_splat(view->near_weight * right),
                            .far_left = cvol_splat(view->far_weight * left),
                            .far_right = cvol_splat(view->far_weight * right)};
}

CVOL_INLINE cvol_vf reconstruct_unit(const line_view *view, const unit_footprint *footprint, long x)
{
    return footprint->near_left * cvol_load(view->near + x) +
           footprint->near_right * cvol_load(view->near + x + 1) +
           footprint->far_left * cvol_load(view->far + x) +
           footprint->far_right * cvol_load(view->far + x + 1);
}

/* The same where pixels lie closer than samples: CVOL_LANES pixels from `position` on. */
CVOL_INLINE cvol_vf reconstruct_finer(const line_view *view, double position, double step)
{
    double whole = floor(position);
    const float *near = view->near + (long)whole, *far = view->far + (long)whole;
    cvol_vf low = view->near_weight * cvol_load(near) + view->far_weight * cvol_load(far);
    cvol_vf high = view->near_weight * cvol_load(near + CVOL_LANES) +
                   view->far_weight * cvol_load(far + CVOL_LANES);
    cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    cvol_vi index = cvol_to_int(at);
    cvol_vf fraction = at - cvol_to_float(index);
    cvol_vf left = cvol_shuffle(low, high, index);
    cvol_vf right = cvol_shuffle(low, high, index + 1);
    return left + fraction * (right - left);
}

/* Which of the CVOL_LANES pixels from `position` on lie within the sheet. */
CVOL_INLINE cvol_vi inside_mask(const cvol_layer *layer, double position)
{
    const float tolerance = 1e-4f;
    cvol_vf offset = cvol_iota() * (float)layer->lane_step;
    return (offset >= (float)(layer->lane_lo - position) - tolerance) &
           (offset <= (float)(layer->lane_hi - position) + tolerance);
}

/* I += (1 - A) F D,  A += (1 - A) D, with the transmittance t = 1 - A, for CVOL_LANES pixels of the
 * four lines r g b t. `inside` masks those within the sheet. 1 if all of them are opaque now. */
CVOL_INLINE int composite(const cvol_sheet_table *table, float *r, int width, cvol_vf value,
                          cvol_vi inside, int masked)
{
    float *g = r + width, *b = g + width, *through = b + width;
    cvol_vi seen = (value >= table->visible_from) & (value <= table->visible_to);
    if (masked)
        seen &= inside;
    if (!cvol_any(seen))
        return !cvol_any(cvol_load(through) >= OPAQUE_BELOW);
    cvol_vf t = (value - table->from) * table->scale;
    t = cvol_min(cvol_max(t, cvol_splat(0)), cvol_splat(CVOL_TABLE_SIZE - 1));
    cvol_vi index = cvol_to_int(t);
    cvol_vf opacity = (cvol_vf)(cvol_lookup(table->opacity, index) & seen);
    cvol_vi colour = cvol_lookup(table->colour, index);
    cvol_vf before = cvol_load(through);
    cvol_vf weight = before * opacity, after = before - weight;
    cvol_store(through, after);
    weight *= 1.0f / 1023;
    cvol_store(r, cvol_load(r) + weight * cvol_to_float(colour & 1023));
    cvol_store(g, cvol_load(g) + weight * cvol_to_float((colour >> 10) & 1023));
    cvol_store(b, cvol_load(b) + weight * cvol_to_float(colour >> 20));
    return !cvol_any(after >= OPAQUE_BELOW);
}

CVOL_INLINE void composite_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet,
                                 const cvol_sheet_table *table, float *lines, uint8_t *opaque,
                                 int j, int width, int unit)
{
    line_view view;
    if (!view_line(&view, layer, sheet, j))
        return;
    const double step = layer->lane_step;
    const unit_footprint footprint = make_unit_footprint(&view, sheet);
    for (int group = sheet->begin; group < sheet->end; group++) {
        if (opaque[group])
            continue;
        const int i = group * CVOL_GROUP;
        long x = unit ? footprint.x + i : (long)floor(sheet->lane_at + i * step);
        if (!view.windows[(unsigned long)(x + CVOL_GROUP) / CVOL_GROUP])
            continue;
        const int masked = group < sheet->inside_begin || group >= sheet->inside_end;
        int closed = 1;
        for (int part = 0; part < CVOL_GROUP; part += CVOL_LANES) {
            double position = sheet->lane_at + (i + part) * step;
            cvol_vf value = unit ? reconstruct_unit(&view, &footprint, x + part)
                                 : reconstruct_finer(&view, position, step);
            closed &= masked ? composite(table, lines + i + part, width, value,
                                         inside_mask(layer, position), 1)
                             : composite(table, lines + i + part, width, value, (cvol_vi){0}, 0);
        }
        opaque[group] = (uint8_t)closed;
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

/* Line 0 becomes the sum of the samples, or the largest; line 1 their number, or 1. */
CVOL_INLINE void project(float *first, float *second, cvol_vf value, cvol_vi inside, int largest)
{
    cvol_vf result = cvol_load(first), count = cvol_load(second), one = cvol_splat(1);
    if (largest) {
        cvol_vi better = inside & ((value > result) | (count == 0));
        cvol_store(first, cvol_select(better, value, result));
        cvol_store(second, cvol_select(inside, one, count));
    } else {
        cvol_store(first, cvol_select(inside, result + value, result));
        cvol_store(second, cvol_select(inside, count + one, count));
    }
}

CVOL_INLINE void project_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet, float *lines,
                               int j, int width, int unit, int largest)
{
    line_view view;
    if (!view_line(&view, layer, sheet, j))
        return;
    const double step = layer->lane_step;
    const unit_footprint footprint = make_unit_footprint(&view, sheet);
    for (int i = sheet->begin * CVOL_GROUP; i < sheet->end * CVOL_GROUP; i += CVOL_LANES) {
        double position = sheet->lane_at + i * step;
        cvol_vf value = unit ? reconstruct_unit(&view, &footprint, footprint.x + i)
                             : reconstruct_finer(&view, position, step);
        project(lines + i, lines + width + i, value, inside_mask(layer, position), largest);
    }
}

CVOL_INLINE void project_layer(const cvol_layer *layer, float *lines, int j, int width, int largest)
{
    if (layer->lane_step == 1)
        for (int s = 0; s < layer->sheet_count; s++)
            project_sheet(layer, &layer->sheets[s], lines, j, width, 1, largest);
    else
        for (int s = 0; s < layer->sheet_count; s++)
            project_sheet(layer, &layer->sheets[s], lines, j, width, 0, largest);
}

void CVOL_SIMD(cvol_sheet_sum)(const cvol_layer *layer, const cvol_sheet_table *table, float *lines,
                               uint8_t *opaque, int j, int width)
{
    (void)table;
    (void)opaque;
    project_layer(layer, lines, j, width, 0);
}

void CVOL_SIMD(cvol_sheet_max)(const cvol_layer *layer, const cvol_sheet_table *table, float *lines,
                               uint8_t *opaque, int j, int width)
{
    (void)table;
    (void)opaque;
    project_layer(layer, lines, j, width, 1);
}
