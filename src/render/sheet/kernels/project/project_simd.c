/* Modes xray, mip and min: sums, maxima and minima of the samples along the rays. */
#include "render/sheet/kernels/footprint_wide.h"
#include "render/sheet/kernels/project/extreme.h"

enum { SUM, LARGEST, SMALLEST };

/* Line 0 becomes the weighted sum of the samples, or the largest or smallest; line 1 their weight,
 * or 1.
 */
CVOL_INLINE void project(float *first, float *second, cvol_vf value, cvol_vf weight, int what)
{
    cvol_vf result = cvol_load(first), count = cvol_load(second);
    cvol_vi inside = weight >= MIN_WEIGHT;
    if (what != SUM) {
        const cvol_vi further = what == LARGEST ? value > result : value < result;
        const cvol_vi better = inside & (further | (count == 0));
        cvol_store(first, cvol_select(better, value, result));
        cvol_store(second, cvol_select(inside, cvol_splat(1), count));
    } else {
        cvol_store(first, cvol_select(inside, result + weight * value, result));
        cvol_store(second, cvol_select(inside, count + weight, count));
    }
}

/* A slice represents the slab of half an interval before and behind it. */
CVOL_INLINE void project_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet,
                               const cvol_line *line, int unit, int what, int has_void, int wide)
{
    line_view view;
    view_line(&view, layer, sheet, line->number);
    if (view.enter > 0.5f - MIN_WEIGHT || view.leave < MIN_WEIGHT - 0.5f ||
        view.leave - view.enter < MIN_WEIGHT)
        return;
    const double step = sheet->lane_step;
    const unit_footprint footprint = make_unit_footprint(&view, sheet);
    wide_view by;
    if (wide)
        make_wide_view(&by, layer, &view, sheet);
    group_range range = {sheet->begin, sheet->end, 0, 0, 0, 0};
    if (layer->cuts)
        cut_groups(&range, layer, sheet, line->number, line->width / CVOL_GROUP);
    for (int i = range.begin * CVOL_GROUP; i < range.end * CVOL_GROUP; i += CVOL_LANES) {
        double position = sheet->lane_at + i * step;
        const ptrdiff_t x = unit ? footprint.x + i : (ptrdiff_t)floor(position);
        cvol_vf weight = weigh(layer, sheet, &view, position, i, line->number, -0.5f, 0.5f);
        const wide_place place = find_wide_place(layer, view.near, position, step);
        cvol_vf value, cover;
        if (has_void) {
            if (!(view.windows[window_of(x)] & CVOL_WINDOW_SEEN)) /* no sample has a value */
                continue;
            value = unit ? reconstruct_unit_masked(&cover, &view, &footprint, x, layer->cover_at)
                         : reconstruct_finer_masked(&cover, &view, position, step, layer->cover_at);
            if (wide)
                value = reconstruct_wide_masked(&cover, layer->wide, &by, &place, value);
            weight = what != SUM ? cvol_select(cover >= 0.5f, weight, cvol_splat(0))
                                 : weight * cover;
        } else if (wide) {
            value = reconstruct_wide(layer->wide, &by, &place);
        } else {
            value = unit ? reconstruct_unit(&view, &footprint, x)
                         : reconstruct_finer(&view, position, step);
        }
        project(line->values + i, line->values + line->width + i, value, weight, what);
    }
}

CVOL_INLINE void project_layer(const cvol_layer *layer, const cvol_line *line, int what)
{
    const int unit = layer->unit;
    if (what != SUM && !layer->wide && !layer->cover_at) {
        if (unit)
            draw_extremes(layer, line, 1, what == LARGEST);
        else
            draw_extremes(layer, line, 0, what == LARGEST);
        return;
    }
    for (int s = 0; s < layer->sheet_count; s++) {
        const cvol_sheet_view *sheet = &layer->sheets[s];
        if (layer->wide)
            project_sheet(layer, sheet, line, unit, what, layer->cover_at != 0, 1);
        else if (layer->cover_at)
            project_sheet(layer, sheet, line, unit, what, 1, 0);
        else if (unit)
            project_sheet(layer, sheet, line, 1, what, 0, 0);
        else
            project_sheet(layer, sheet, line, 0, what, 0, 0);
    }
}

void CVOL_SIMD(cvol_sheet_sum)(const cvol_layer *layer, const cvol_sheet_table *table,
                               const cvol_line *line)
{
    (void)table;
    project_layer(layer, line, SUM);
}

void CVOL_SIMD(cvol_sheet_max)(const cvol_layer *layer, const cvol_sheet_table *table,
                               const cvol_line *line)
{
    (void)table;
    project_layer(layer, line, LARGEST);
}

void CVOL_SIMD(cvol_sheet_min)(const cvol_layer *layer, const cvol_sheet_table *table,
                               const cvol_line *line)
{
    (void)table;
    project_layer(layer, line, SMALLEST);
}
