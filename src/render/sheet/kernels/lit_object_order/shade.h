/* Mode composite with light (composite/object_order_simd.c draws it without); and surfaces, mode
 * iso.
 *
 * An interval between two slices is lit at both, and light is linear in between. With gradient
 * interpolation (cvol_sheet_table), gradients are linear in between, and the interval is also lit
 * in its middle, so that the grain of a slice is not visible if pixels are smaller than samples. At
 * a slice, the gradient depends on the values there of the slice itself and those before and behind
 * (slope.h). So an interval is drawn when the rays reach the slice after its end; until then it is
 * pending. Between two layers, the line stores the necessary data of the first one: the slopes at
 * its last slice, and the values of that slice and the one before where rays meet their neighbours.
 * If a neighbour is invisible, values are extrapolated linearly, within the range of its window.
 *
 * Only kernel files include this file, like composite.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_H

#include "render/sheet/kernels/lit_object_order/shade_interval.h"

/* Draws slices from s on, while `go` has them: known intervals, whole, whose samples all have a
 * value. Returns the slice after the last one. */
CVOL_INLINE int draw_run(shade_state *g, int *closed, const line_job *job, uint64_t go, int s,
                         int group, int unit, int lengths, int segments, int rare)
{
    do {
        cvol_vf next[PARTS];
        for (int k = 0; k < PARTS; k++)
            next[k] = reconstruct(job, &job->sheets[s], group, k, unit);
        const int visible = is_visible(job, g->p, g->value, next);
        if (rare)
            finish_rare(g, job, s - 1, 0, group, visible, unit, 0, segments);
        else
            finish(g, job, s - 1, 0, group, visible, unit, 0, segments, 0);
        if (s == 0)
            g->behind.edge = KNOWN;
        for (int k = 0; k < PARTS; k++) {
            if (s == 0)
                g->behind.value[k] = g->ahead[k];
            g->before[k] = g->value[k];
            g->value[k] = next[k];
#if SHEET_EXTRAS
            for (int part = 1; part < job->layer->parts; part++)
                g->between[part - 1][k] = find_between(job, s, part, group, k, unit, g->before[k],
                                                       g->value[k]);
#endif
        }
        g->divided = SHEET_EXTRAS && job->layer->parts > 1;
        *closed = g->visible && is_closed(g);
        g->visible = visible;
        g->end = job->layer->sheets[0].ordinal + s;
        g->weighted = lengths;
        for (int k = 0; k < PARTS && g->weighted; k++)
            g->weight[k] = g->length[k];
        g->is_lit = visible; /* else light was not computed */
        s++;
    } while (!*closed && go >> s & 1);
    return s;
}

/* The common kinds are compiled separately, for each footprint: in parallel projection, and, with
 * AVX-512, with segments. Lit intervals take long to compile, so the others share one function. */
CVOL_INLINE int draw_run_of_kind(shade_state *g, int *closed, const line_job *job, uint64_t go,
                                 int s, int group, int unit, int lengths, int segments)
{
    enum { USUAL = HAVE_SEGMENTS ? CVOL_SEGMENTS : 0 };
    if (SHEET_EXTRAS || lengths || segments != USUAL)
        return draw_run(g, closed, job, go, s, group, unit, lengths, segments, 1);
    return unit ? draw_run(g, closed, job, go, s, group, 1, 0, USUAL, 0)
                : draw_run(g, closed, job, go, s, group, 0, 0, USUAL, 0);
}

/* The share of the interval that ends at slice s within the drawn part. */
CVOL_INLINE cvol_vf weigh_part(const line_job *job, int s, int i)
{
    const sheet_line *sheet = &job->sheets[s];
    const int only = job->layer->only;
    return weigh(job->layer, &job->layer->sheets[s], &sheet->view,
                 sheet->lane_at + i * sheet->lane_step, i, job->line->number, only ? -0.5f : -1,
                 only ? 0.5f : 0);
}

/* A group meets an invisible window: draws the visible part of the interval up to there. */
CVOL_COLD void draw_end(shade_state *g, const line_job *job, int s, int group, int unit,
                        int has_void, int segments)
{
    const sheet_line *sheet = &job->sheets[s];
    const ptrdiff_t window = window_at(sheet, group, unit);
    const int masked = has_void && sheet->view.windows[window] & CVOL_WINDOW_MASKED;
    const cvol_vf level = to_table(job, cvol_splat(sheet->view.levels[window]));
    finish_rare(g, job, s - 1, 0, group, 1, unit, has_void, segments);
    g->weighted = 1;
    g->divided = 0;
    g->is_lit = 1;
    g->end = job->layer->sheets[s].ordinal;
    for (int k = 0; k < PARTS; k++) {
        const int i = group * CVOL_GROUP + k * CVOL_LANES;
        const lit_sample lit = g->lit[k];
        g->weight[k] = g->length[k] * own_weight(weigh_part(job, s, i), job, s, i);
        if (masked)
            g->weight[k] *= 0.5f * g->cover[k];
        g->before[k] = g->value[k];
        g->value[k] = masked ? g->value[k] : level;
        draw_pending_rare(g, job, k, &lit, 0, segments);
    }
    g->pending = 0;
}

/* The ray ends behind slice s, or the next value is unknown. */
CVOL_COLD void draw_last(shade_state *g, const line_job *job, int s, int at_face, int group,
                         int unit, int has_void, int segments)
{
    finish_rare(g, job, s, at_face, group, 0, unit, has_void, segments);
    g->pending = 0;
}

/* Draws a visible slice of any kind. */
CVOL_COLD void draw_sheet(shade_state *g, const line_job *job, int s, int group, int unit,
                          int has_void, int segments)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const int known = g->pending, ordinal = layer->sheets[s].ordinal;
    const int inside = is_inside(sheet, group);
    const int masked = is_masked(sheet, group, unit, has_void);
    float level = 0, spread = 0;
    const int has_level = !known && find_level_before(&level, &spread, job, s, group);
    cvol_vf value[PARTS], cover[PARTS], before[PARTS], weight[PARTS];
    int visible = 0;
    for (int k = 0; k < PARTS; k++) {
        value[k] = value_at(&cover[k], job, sheet, 0, group, k, unit, masked);
        before[k] = known ? g->value[k] : has_level ? cvol_splat(level) : value[k];
        weight[k] = inside ? cvol_splat(known || has_level ? 1 : 0.5f)
                           : weigh_part(job, s, group * CVOL_GROUP + k * CVOL_LANES);
        weight[k] = own_weight(weight[k], job, s, group * CVOL_GROUP + k * CVOL_LANES);
        visible |= sees(job, (cvol_vf)((cvol_vi)g->p[k].transmittance & (weight[k] > 0)), before[k],
                        value[k]);
    }
    if (known)
        finish_rare(g, job, s - 1, 0, group, visible, unit, has_void, segments);
    for (int k = 0; k < PARTS; k++) {
        g->before[k] = before[k];
        g->cover_before[k] = known ? g->cover[k] : has_level ? cvol_splat(1) : cover[k];
        g->value[k] = value[k];
        g->cover[k] = cover[k];
        g->weight[k] = weight[k] * g->length[k];
        if (has_void)
            g->weight[k] *= 0.5f * (g->cover_before[k] + cover[k]);
        g->behind.value[k] = g->ahead[k];
        g->behind.cover[k] = g->cover_ahead[k];
    }
    g->behind.edge = known ? KNOWN : has_level ? BOUNDED : ordinal == 0 ? AT_FACE : CONTINUED;
    g->behind.level = level;
    g->behind.spread = spread;
    g->is_lit = known && visible; /* else light was not computed */
    g->divided = 0;
    g->weighted = 1;
    g->end = ordinal;
    g->visible = visible;
    g->has_last &= known;
    g->pending = 1;
}

/* Stores the data that the next layer needs of the layer's slice s, at which the pending interval
 * ends. */
CVOL_INLINE void keep(shade_state *g, const line_job *job, int s, int group, int unit, int has_void)
{
    const sheet_line *sheet = &job->sheets[s];
    const int masked = is_masked(sheet, group, unit, has_void);
    if (s > 0)
        find_neighbour(&g->behind, job, s, s - 1, group, unit, has_void);
    for (int k = 0; k < PARTS; k++) {
        g->slope[k] = masked ? find_slope_masked(job, sheet, group, k, unit)
                             : find_slope(job, sheet, group, k, unit);
        g->ahead[k] = value_at(&g->cover_ahead[k], job, &job->after, 0, group, k, unit,
                               is_masked(&job->after, group, unit, has_void));
    }
}

/* Draws a group through the slices that it meets. */
CVOL_INLINE void draw_group(const line_job *job, int group, int unit, int has_void, int lengths,
                            int segments)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = has_void ? 0 : seen & job->inside[at];
    uint32_t intersected = job->intersected[at];
    int last = line->intersected[group], closed = 0;
    if (!seen && last == INT32_MIN)
        return;
    shade_state g;
    load_group(&g, job, group, has_void, lengths);
    while (intersected && !closed) {
        int s = __builtin_ctz(intersected);
        if (g.pending && last != first + s - 1) {
            draw_last(&g, job, last - first, 0, group, unit, has_void, segments);
            closed = is_closed(&g);
            continue;
        }
        if (g.pending && go >> s & 1) {
            s = draw_run_of_kind(&g, &closed, job, go, s, group, unit, lengths, segments);
            last = first + s - 1;
            intersected &= ~UINT32_C(0) << (s - 1) << 1;
            continue;
        }
        intersected &= intersected - 1;
        if (seen >> s & 1) {
            draw_sheet(&g, job, s, group, unit, has_void, segments);
            last = first + s;
        } else {
            if (g.pending)
                draw_end(&g, job, s, group, unit, has_void, segments);
            intersected &= from_lowest(intersected & seen); /* nothing visible before */
        }
        closed = is_closed(&g);
    }
    if (g.pending && last >= first)
        keep(&g, job, last - first, group, unit, has_void);
    if (SHEET_EXTRAS && job->layer->parts > 1 && g.pending && !closed &&
        last == first + job->layer->sheet_count - 1)
        keep_between(job, group, unit);
    store_group(&g, job, group, has_void);
    line->intersected[group] = g.pending ? last : INT32_MIN;
    line->opaque[group] = (uint8_t)closed;
}

/* Moves a view to the position of the slice before or behind. */
CVOL_INLINE void move_view(cvol_sheet_view *view, int by)
{
    view->lane_at += by * view->lane_rate[0];
    view->lane_step += by * view->lane_rate[1];
    view->row_at += by * view->row_rate[0];
    view->row_step += by * view->row_rate[1];
}

CVOL_INLINE void draw_lit_line(line_job *job)
{
    const cvol_layer *layer = job->layer;
    const int unit = layer->unit, has_void = layer->cover_at != 0, lengths = layer->perspective;
    const int segments = HAVE_SEGMENTS && !has_void && job->table->segments ? CVOL_SEGMENTS : 0;
    int begin = job->line->width / CVOL_GROUP, end = 0;
    for (int s = 0; s < layer->sheet_count; s++) {
        view_sheet(&job->sheets[s], job, &layer->sheets[s], unit);
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
#if SHEET_EXTRAS
    between_views between;
    job->between = &between;
    if (layer->parts > 1 && begin < end)
        view_between(&between, job, unit);
#endif
    cvol_sheet_view beyond =
        layer->sheets[0]; /* of the first slice, at the position of the one before */
    move_view(&beyond, -1);
    view_sheet(&job->before, job, &beyond, unit);
    beyond =
        layer->sheets[layer->sheet_count - 1]; /* of the last one, at the position of the next */
    move_view(&beyond, 1);
    view_sheet(&job->after, job, &beyond, unit);
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
        find_intersected(job, first, count, unit);
        for (int group = first; group < first + count; group++) {
            if (group + AHEAD < first + count)
                prefetch_group(job, group + AHEAD);
            if (!job->line->opaque[group])
                draw_group(job, group, unit, has_void, lengths, segments);
        }
    }
}

/* Draws the pending interval behind the last layer, whose last slice is number
 * layer->sheets[0].ordinal - 1. */
CVOL_COLD void end_line(const line_job *job, int has_void)
{
    const cvol_line *line = job->line;
    for (int group = 0; group < line->width / CVOL_GROUP; group++) {
        const int last = line->intersected[group];
        if (line->opaque[group] || last == INT32_MIN)
            continue;
        shade_state g;
        load_group(&g, job, group, has_void, 0);
        draw_last(&g, job, -2, last == job->layer->sheets[0].ordinal - 1, group, 1, has_void, 0);
        store_group(&g, job, group, has_void);
        line->intersected[group] = INT32_MIN;
    }
}

#endif
