/* Mode composite: one line of the intermediate image through all sheets of a layer.
 *
 * A ray's value is known where it crosses the sheets; between two of them it is taken to be linear.
 * Each interval between sheets is classified at the middles of 1, 2 or 4 parts of it, so many as
 * the transfer function needs over the values that the interval spans (cvol_sheet_table.flat), and
 * composited front to back:
 *     I += (1 - A) F D,  A += (1 - A) D
 */
#include "render/sheet_footprint.h"

/* A group whose transmittance is below this in every pixel is done: what lies behind could change
 * no channel by more than half a step of 255. */
#define OPAQUE_BELOW (1.0f / 512)

/* What composite has of CVOL_LANES pixels: premultiplied colour and the transmittance 1 - A. */
typedef struct pixels {
    cvol_vf r, g, b, through;
} pixels;

CVOL_INLINE pixels load_pixels(const float *r, int width)
{
    return (pixels){cvol_load(r), cvol_load(r + width), cvol_load(r + 2 * width),
                    cvol_load(r + 3 * width)};
}

CVOL_INLINE void store_pixels(float *r, int width, pixels p)
{
    cvol_store(r, p.r);
    cvol_store(r + width, p.g);
    cvol_store(r + 2 * width, p.b);
    cvol_store(r + 3 * width, p.through);
}

CVOL_INLINE cvol_vi table_index(cvol_vf t)
{
    return cvol_to_int(cvol_min(cvol_max(t, cvol_splat(0)), cvol_splat(CVOL_TABLE_SIZE - 1)));
}

/* 1 - (1 - a)^w for 0..1, exact where a or w is 0 or 1, within 0.02 elsewhere. */
CVOL_INLINE cvol_vf opacity_of_part(cvol_vf a, cvol_vf w)
{
    cvol_vf a2 = a * a;
    return a * w / (1 - a * (1 - w) * (0.5f + 0.5f * a2 * a2 * a2));
}

/* One sample of those pixels that `mask` has, at table coordinate t in the entries of each pixel's
 * own level (`base`); if `weighted`, only this part of its length. */
CVOL_INLINE void composite_sample(pixels *p, const cvol_sheet_table *table, cvol_vi base, cvol_vf t,
                                  cvol_vi mask, cvol_vf weight, int weighted)
{
    cvol_vf opacity;
    cvol_vi colour;
    cvol_lookup(&opacity, &colour, table->entries[0], base + table_index(t));
    opacity = (cvol_vf)((cvol_vi)opacity & mask);
    if (weighted)
        opacity = cvol_select(weight >= LEAST_WEIGHT, opacity_of_part(opacity, weight),
                              cvol_splat(0));
    cvol_vf share = p->through * opacity;
    p->through -= share;
    share *= 1.0f / 1023;
    p->r += share * cvol_to_float(colour & 1023);
    p->g += share * cvol_to_float((colour >> 10) & 1023);
    p->b += share * cvol_to_float(colour >> 20);
}

/* The interval from table coordinate a to b, in 1, 2 or 4 parts: each pixel by itself, or the
 * groups would be seen; the less light still comes through, the fewer, for the less an error is
 * seen. A part's sample lies at its far end, so that what counts most, the sheet's own value, is
 * exact. 1 if all pixels are opaque now. */
CVOL_INLINE int composite_parts(const cvol_sheet_table *table, float *r, int width, cvol_vf a,
                                cvol_vf b, cvol_vf weight, int weighted)
{
    pixels p = load_pixels(r, width);
    const cvol_vf span = (cvol_max(a, b) - cvol_min(a, b)) * p.through;
    const cvol_vi halves = span > table->flat, quarters = span > 4 * table->flat;
    const cvol_vi base = ((halves & 1) + (quarters & 1)) * CVOL_TABLE_SIZE;
    const cvol_vi all = ~(cvol_vi){0};
    if (cvol_any(halves)) {
        const cvol_vf quarter = 0.25f * (b - a);
        const int finest = cvol_any(quarters);
        if (finest)
            composite_sample(&p, table, base, a + quarter, quarters, weight, weighted);
        composite_sample(&p, table, base, a + 2 * quarter, halves, weight, weighted);
        if (finest)
            composite_sample(&p, table, base, a + 3 * quarter, quarters, weight, weighted);
    }
    composite_sample(&p, table, base, b, all, weight, weighted);
    store_pixels(r, width, p);
    return !cvol_any(p.through >= OPAQUE_BELOW);
}

CVOL_INLINE int is_opaque(const float *r, int width)
{
    return !cvol_any(cvol_load(r + 3 * width) >= OPAQUE_BELOW);
}

/* The interval from value a to b; if `weighted`, only this part of its length. */
CVOL_INLINE int composite_interval(const cvol_sheet_table *table, float *r, int width, cvol_vf a,
                                   cvol_vf b, cvol_vf weight, int weighted)
{
    cvol_vi seen = (cvol_max(a, b) >= table->visible_from) & (cvol_min(a, b) <= table->visible_to);
    if (!cvol_any(seen))
        return is_opaque(r, width);
    return composite_parts(table, r, width, (a - table->from) * table->scale,
                           (b - table->from) * table->scale, weight, weighted);
}

/* The value at which the group whose first pixel lies at sample coordinate `position` met the sheet
 * before, which was skipped: about the level of the window there. 0 if it is not known. */
CVOL_INLINE int find_level_before(float *level, const cvol_layer *layer,
                                  const cvol_sheet_view *sheet, int line, double position)
{
    const cvol_windows *windows = sheet->is_first ? &layer->windows_before : &layer->windows;
    if (!windows->count)
        return 0;
    const float *levels;
    long y;
    const uint8_t *bits = find_windows(&levels, &y, layer, windows,
                                       sheet->row_at + line * layer->row_step - layer->row_drift);
    const long window = window_of((long)floor(position - layer->lane_drift));
    *level = levels[window];
    return !bits[window];
}

/* A group that was drawn up to the sheet before meets a window that cannot be seen: what of the
 * interval between the two can be, is drawn. If samples there may have no value, then what half of
 * it has by the sheet before. */
CVOL_INLINE void composite_end(const cvol_layer *layer, const cvol_sheet_view *sheet,
                               const cvol_sheet_table *table, const cvol_line *line,
                               const line_view *view, int group, long window, int has_void)
{
    int closed = 1;
    for (int i = group * CVOL_GROUP; i < (group + 1) * CVOL_GROUP; i += CVOL_LANES) {
        const cvol_vf before = cvol_load(line->values + 4 * line->width + i);
        cvol_vf weight = weigh(layer, view, sheet->lane_at + i * layer->lane_step), to = before;
        if (has_void && view->windows[window] & CVOL_WINDOW_MASKED)
            weight *= 0.5f * cvol_load(line->values + 5 * line->width + i);
        else
            to = cvol_splat(view->levels[window]);
        closed &= composite_interval(table, line->values + i, line->width, before, to, weight, 1);
    }
    line->opaque[group] = (uint8_t)closed;
}

/* One end of an interval: the value there and, of arrays with a mask, its cover. */
typedef struct interval_end {
    cvol_vf value, cover;
} interval_end;

/* The interval between two ends of which parts may have no value; where an end has none, the
 * other's value holds. */
CVOL_INLINE int composite_masked(const cvol_sheet_table *table, float *r, int width, interval_end a,
                                 interval_end b, cvol_vf weight)
{
    const cvol_vf from = cvol_select(a.cover < LEAST_WEIGHT, b.value, a.value);
    const cvol_vf to = cvol_select(b.cover < LEAST_WEIGHT, a.value, b.value);
    return composite_interval(table, r, width, from, to, weight * 0.5f * (a.cover + b.cover), 1);
}

/* A sheet stands for the interval before it. */
CVOL_INLINE void composite_sheet(const cvol_layer *layer, const cvol_sheet_view *sheet,
                                 const cvol_sheet_table *table, const cvol_line *line, int unit,
                                 int has_void)
{
    line_view view;
    const int only = sheet->front == -0.5f;
    view_line(&view, layer, sheet, line->number, only ? -0.5f : -1, only ? 0.5f : 0);
    /* The first sheet has nothing before it, but its values are needed. */
    if (view.slab_end - view.slab_begin < LEAST_WEIGHT && sheet->ordinal > 0)
        return;
    const double step = layer->lane_step;
    const unit_footprint footprint = make_unit_footprint(&view, sheet);
    const int whole = view.slab_end - view.slab_begin > 1 - LEAST_WEIGHT;
    float *previous = line->values + 4 * line->width;
    for (int group = sheet->begin; group < sheet->end; group++) {
        if (line->opaque[group])
            continue;
        const int i = group * CVOL_GROUP;
        long x = unit ? footprint.x + i : (long)floor(sheet->lane_at + i * step);
        const long window = window_of(x);
        const int inside = whole && group >= sheet->inside_begin && group < sheet->inside_end;
        int known = line->met[group] == sheet->ordinal - 1;
        if (!(view.windows[window] & CVOL_WINDOW_SEEN)) {
            if (known)
                composite_end(layer, sheet, table, line, &view, group, window, has_void);
            continue;
        }
        float level = 0;
        const int begins = !known && find_level_before(&level, layer, sheet, line->number,
                                                       sheet->lane_at + i * step);
        known |= begins;
        int closed = 1;
        for (int part = 0; part < CVOL_GROUP; part += CVOL_LANES) {
            double position = sheet->lane_at + (i + part) * step;
            interval_end end = {.cover = cvol_splat(1)}, before;
            if (has_void && view.windows[window] & CVOL_WINDOW_MASKED)
                end.value = unit ? reconstruct_unit_masked(&end.cover, &view, &footprint, x + part,
                                                           layer->cover_at)
                                 : reconstruct_finer_masked(&end.cover, &view, position, step,
                                                            layer->cover_at);
            else
                end.value = unit ? reconstruct_unit(&view, &footprint, x + part)
                                 : reconstruct_finer(&view, position, step);
            before.value = begins  ? cvol_splat(level)
                           : known ? cvol_load(previous + i + part)
                                   : end.value;
            float *r = line->values + i + part;
            cvol_store(previous + i + part, end.value);
            if (inside && known && !has_void) {
                closed &= composite_interval(table, r, line->width, before.value, end.value,
                                             end.value, 0);
                continue;
            }
            cvol_vf weight = !inside ? weigh(layer, &view, position) : cvol_splat(known ? 1 : 0.5f);
            if (has_void) {
                before.cover = begins  ? cvol_splat(1)
                               : known ? cvol_load(r + 5 * line->width)
                                       : end.cover;
                cvol_store(r + 5 * line->width, end.cover);
                closed &= composite_masked(table, r, line->width, before, end, weight);
                continue;
            }
            closed &= composite_interval(table, r, line->width, before.value, end.value, weight, 1);
        }
        line->met[group] = sheet->ordinal;
        line->opaque[group] = (uint8_t)closed;
    }
}

CVOL_INLINE void composite_layer(const cvol_layer *layer, const cvol_sheet_table *table,
                                 const cvol_line *line, int unit, int has_void)
{
    for (int s = 0; s < layer->sheet_count; s++)
        composite_sheet(layer, &layer->sheets[s], table, line, unit, has_void);
}

void CVOL_SIMD(cvol_sheet_composite)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     const cvol_line *line)
{
    const int unit = layer->lane_step == 1;
    if (layer->cover_at)
        unit ? composite_layer(layer, table, line, 1, 1)
             : composite_layer(layer, table, line, 0, 1);
    else
        unit ? composite_layer(layer, table, line, 1, 0)
             : composite_layer(layer, table, line, 0, 0);
}
