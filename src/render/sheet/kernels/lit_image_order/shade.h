/* Mode composite with light in image order: the counterpart of
 * render/sheet/kernels/lit_object_order/shade.h. A group's pixels are drawn in parts of CVOL_LANES,
 * one after the other.
 *
 * An interval between two slices is drawn when the rays reach the slice after its end, since the
 * gradient at its end depends on that slice, its own and the one before; until then it is pending.
 * Between two layers, the line stores the necessary data of the first one: the slopes at its last
 * slice, and the values of that slice and the one before where rays meet their neighbours. Values
 * that are unknown, because nothing there was evaluated, are NaN; they are extrapolated linearly.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_H

#include "render/sheet/kernels/composite/reach.h"
#include "render/sheet/kernels/lit_image_order/shade_few.h"
#include "render/sheet/kernels/lit_image_order/shade_gradient.h"

/* ---- intervals ------------------------------------------------------------------------------- */

/* Draws an interval that is nearly linear, but whose light varies: a separate function, as it is
 * used only for small pixels. */
CVOL_COLD void draw_turning(lit_group *g, const cvol_sheet_table *table, lit_interval *i,
                            const classified *end, int segments)
{
    i->middle = 0.5f * (i->a + i->b) + find_shear_correction(i, table);
    i->half = mix_gradients(&i->from, &i->to, cvol_splat(0.5f));
    const lit_parts midpoints = {
        {cvol_splat(1), {0}, {0}}, {~(cvol_vi){0}, {0}, {0}}, ~(cvol_vi){0}, 2};
    composite_parts(&g->p, table, &g->last, end, i, &midpoints, segments);
}

/* Draws a whole interval. It is divided if any pixel of the part divides it; but every pixel
 * decides for itself, so that a picture does not depend on the number of lanes. */
CVOL_INLINE void draw_whole(lit_group *g, const line_job *job, lit_interval i, int s, int group,
                            int part, int segments)
{
    const cvol_sheet_table *table = job->table;
    if (!g->has_last)
        g->last = classified_of_gradient(table, i.a, &i.from, segments);
    g->has_last = 1;
    const classified end = classified_of_gradient(table, i.b, &i.to, segments);
    const cvol_vf span = (cvol_max(i.a, i.b) - cvol_min(i.a, i.b)) * g->p.transmittance;
    const lit_change change = find_change(span, &g->last, &end, g->p.transmittance);
    if (!table->midpoints && !any_above(change.span, HALVES_OF_FLAT * table->flat) &&
        !any_above(change.light, table->light_change)) {
        if (table->interpolates_gradients) {
            draw_turning(g, table, &i, &end, segments);
            return;
        }
        add_lit_part(&g->p, &g->last, &end, g->p.transmittance,
                     transmittance_between(&g->last, &end));
        g->last = end;
        return;
    }
    const cvol_vf weight = weigh_halves(table, &i, &change);
    find_middle(&i, job, s, group, part, weight);
    composite_divided(&g->p, table, &g->last, &end, &i, weight, segments);
}

/* The weight of a whole interval at a face of a part: see own_weight. */
#define WHOLE 2

/* Draws a whole interval for the pixels to whose part it belongs. */
CVOL_COLD void draw_owned(lit_group *g, const line_job *job, const lit_interval *i, int s,
                          int group, int part, int segments)
{
    const pixels before = g->p;
    const cvol_vi own = g->weight > 0;
    draw_whole(g, job, *i, s, group, part, segments);
    g->p.r = cvol_select(own, g->p.r, before.r);
    g->p.g = cvol_select(own, g->p.g, before.g);
    g->p.b = cvol_select(own, g->p.b, before.b);
    g->p.transmittance = cvol_select(own, g->p.transmittance, before.transmittance);
}

/* Draws the pending interval, which ends at slice s with a gradient. */
CVOL_INLINE void draw_interval(lit_group *g, const line_job *job, int s, int group, int part,
                               const gradient *now, int segments)
{
    lit_interval i;
    i.a = g->before;
    i.b = g->value;
    i.from = g->has_from ? g->from : *now;
    i.to = *now;
    take_other_gradient(&i.from, &i.to);
    if (!g->weighted) {
        draw_whole(g, job, i, s, group, part, segments);
    } else if (job->layer->part_cuts && !cvol_any((g->weight != WHOLE) & (g->weight != -WHOLE))) {
        draw_owned(g, job, &i, s, group, part, segments);
    } else {
        composite_weighted(&g->p, job->table, &i, g->weight, segments);
        g->has_last = 0;
    }
}

/* The same, and finds the gradient of its end. `wanted`: the gradient is needed in any case; `at`:
 * position in the slice, NULL: unknown. */
CVOL_INLINE void finish(lit_group *g, const line_job *job, int s, int group, int part, int wanted,
                        const group_place *at, int segments)
{
    if (!g->visible && !wanted) {
        g->has_last = 0;
        return;
    }
    gradient now;
    if (s > 0 && s + 1 < job->layer->sheet_count) {
        group_place found;
        if (!at)
            place_group(&found, job, &job->sheets[s], group, part);
        now = gradient_within(job, s, at ? at : &found);
    } else
        now = gradient_at_end(g, job, s, group, part, value_after(job, s, group, part));
    now.reach = reach_of_pixels(job, s, group * CVOL_GROUP + part * CVOL_LANES);
    fade_gradient(now.v, job, s, group * CVOL_GROUP + part * CVOL_LANES);
    if (s >= 0 && is_mixed(job, s, group)) {
        const gradient none = {.reach = {0}};
        now = select_gradient(find_unseen_pixels(job, s, group, part), &none, &now);
    }
    if (g->visible)
        draw_interval(g, job, s, group, part, &now, segments);
    else
        g->has_last = 0;
    g->from = now;
    g->has_from = 1;
}

/* The same with an unknown position: a separate function, as few intervals need it. */
CVOL_COLD void finish_alone(lit_group *g, const line_job *job, int s, int group, int part,
                            int wanted, int segments)
{
    finish(g, job, s, group, part, wanted, NULL, segments);
}

/* Draws slices from s on, while `go` has them: known intervals, whole. Returns the slice after the
 * last one. */
CVOL_INLINE int draw_run(lit_group *g, int *closed, const line_job *job, uint64_t go, int s,
                         int group, int part, int segments)
{
    group_place places[2]; /* in turns: of a slice, and of the one before */
    if (s > 0)
        place_group(&places[(s - 1) & 1], job, &job->sheets[s - 1], group, part);
    do {
        group_place *at = &places[s & 1];
        place_group(at, job, &job->sheets[s], group, part);
        const cvol_vf next = value_of_sheet(job, s, group, at);
        const int visible = is_visible(job, g->p.transmittance, g->value, next);
        finish(g, job, s - 1, group, part, visible, &places[(s - 1) & 1], segments);
        *closed = g->visible && is_closed(g);
        g->before = g->value;
        g->value = next;
        g->visible = visible;
        g->has_from = visible; /* else it was not found */
        g->weighted = 0;
        s++;
    } while (!*closed && go >> s & 1);
    return s;
}

/* The share of the interval that ends at slice s within the drawn part. */
CVOL_INLINE cvol_vf weigh_interval(const line_job *job, int s, int group, int part)
{
    const sheet_line *sheet = &job->sheets[s];
    const int only = job->layer->only, i = group * CVOL_GROUP + part * CVOL_LANES;
    return weigh(job->layer, &job->layer->sheets[s], &sheet->view,
                 sheet->lane_at + i * sheet->lane_step, i, job->line->number, only ? -0.5f : -1,
                 only ? 0.5f : 0);
}

/* A group meets an invisible slice: draws the visible part of the interval up to there. */
CVOL_COLD void draw_end(lit_group *g, const line_job *job, int s, int group, int part, int segments)
{
    cvol_vf levels[PARTS];
    find_levels(levels, job, s, job->sheets[s].windows, group, 0);
    finish_alone(g, job, s - 1, group, part, 1, segments);
    const lit_interval i = {.a = g->value, .b = levels[part], .from = g->from, .to = g->from};
    if (is_visible(job, g->p.transmittance, i.a, i.b))
        composite_weighted(&g->p, job->table, &i,
                           own_weight(weigh_interval(job, s, group, part), job, s,
                                      group * CVOL_GROUP + part * CVOL_LANES),
                           segments);
    g->pending = 0;
}

/* Draws a visible slice of any kind. */
CVOL_COLD void draw_sheet(lit_group *g, const line_job *job, int s, int group, int part,
                          int segments)
{
    const sheet_line *sheet = &job->sheets[s];
    const int known = g->pending, inside = is_inside(sheet, group);
    group_place place;
    place_group(&place, job, sheet, group, part);
    const cvol_vf value = value_of_sheet(job, s, group, &place);
    cvol_vf levels[PARTS] = {{0}};
    const int has_level = !known && find_levels_before(levels, job, s, group);
    if (known)
        finish_alone(g, job, s - 1, group, part, 1, segments);
    g->has_from = known;
    g->before = known ? g->value : has_level ? levels[part] : value;
    if (!known) /* at a face samples are constant */
        g->ahead = job->layer->sheets[s].ordinal == 0 ? value : cvol_splat(NAN);
    g->behind = g->ahead;
    g->value = value;
    g->weight = inside ? cvol_splat(known || has_level ? 1 : 0.5f)
                       : weigh_interval(job, s, group, part);
    g->weighted = !inside || !(known || has_level);
    if (job->layer->part_cuts) {
        if (!g->weighted)
            g->weight = cvol_splat(WHOLE);
        g->weight = own_weight(g->weight, job, s, group * CVOL_GROUP + part * CVOL_LANES);
        g->weighted = 1;
    }
    g->has_last = 0;
    g->visible = is_visible(job, g->p.transmittance, g->before, g->value);
    g->pending = 1;
}

/* Stores the data that the next layer needs of the layer's slice s, at which the pending interval
 * ends. */
CVOL_INLINE void keep(lit_group *g, const line_job *job, int s, int group, int part)
{
    g->behind = find_slopes(g->slope, g, job, s, group, part);
    g->ahead = value_ahead_of(job, &job->after, group, part);
    if (is_mixed(job, s, group))
        g->slope[0] = cvol_select(find_unseen_pixels(job, s, group, part), cvol_splat(NAN),
                                  g->slope[0]);
    if (!g->weighted)
        g->weight = cvol_splat(1);
}

/* Draws a part of a group through the slices that it meets. *pending: the last slice that the group
 * met if an interval was pending before, else INT32_MIN; becomes the same behind the layer. Returns
 * 1 if the part is opaque. */
#if CVOL_LANES < CVOL_GROUP /* several parts share one function */
#define DRAW_PART static __attribute__((noinline))
#else
#define DRAW_PART CVOL_INLINE
#endif
DRAW_PART int draw_part(const line_job *job, int group, int part, int *pending, int segments)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = seen & job->inside[at];
    uint32_t intersected = job->intersected[at];
    int last = *pending, closed = 0;
    lit_group g;
    load_group(&g, line, group, part, last != INT32_MIN);
    if (g.has_from)
        g.from.reach = reach_of_pixels(job, last - first - 1,
                                       group * CVOL_GROUP + part * CVOL_LANES);
    if (PARTS > 1 && is_closed(&g)) /* others of the group are not */
        return 1;
    g.visible = g.pending && is_visible(job, g.p.transmittance, g.before, g.value);
    while (intersected && !closed) {
        int s = __builtin_ctz(intersected);
        if (g.pending && last != first + s - 1) {
            finish_alone(&g, job, last - first, group, part, 0, segments);
            g.pending = 0;
            closed = is_closed(&g);
            continue;
        }
        if (g.pending && go >> s & 1) {
            s = draw_run(&g, &closed, job, go, s, group, part, segments);
            last = first + s - 1;
            intersected &= ~UINT32_C(0) << (s - 1) << 1;
            continue;
        }
        intersected &= intersected - 1;
        if (seen >> s & 1) {
            draw_sheet(&g, job, s, group, part, segments);
            last = first + s;
        } else {
            if (g.pending)
                draw_end(&g, job, s, group, part, segments);
            intersected &= from_lowest(intersected & seen); /* nothing visible before */
        }
        closed = is_closed(&g);
    }
    if (closed)
        g.pending = 0;
    if (g.pending && last >= first)
        keep(&g, job, last - first, group, part);
    store_group(&g, line, group, part);
    *pending = g.pending ? last : INT32_MIN;
    return closed;
}

CVOL_INLINE void draw_group(const line_job *job, int group, int segments)
{
    const cvol_line *line = job->line;
    const int before = line->intersected[group];
    if (!job->seen[group - job->first_group] && before == INT32_MIN)
        return;
    int opaque = 1, last = INT32_MIN;
    for (int part = 0; part < PARTS; part++) {
        int pending = before;
        const int closed = draw_part(job, group, part, &pending, segments);
        if (!closed)
            last = pending;
        opaque &= closed;
    }
    line->intersected[group] = last;
    line->opaque[group] = (uint8_t)opaque;
}

CVOL_INLINE void draw_lit_line(line_job *job, int segments)
{
    const cvol_layer *layer = job->layer;
    int begin = job->line->width / CVOL_GROUP, end = 0;
    view_image_order(job);
    begin_places(job);
    for (int s = 0; s < layer->sheet_count; s++) {
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
    job->before = move_sheet(job, 0, -1);
    job->after = move_sheet(job, layer->sheet_count - 1, 1);
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
        find_intersected_image_order(job, first, count);
        for (int group = first; group < first + count; group++)
            if (!job->line->opaque[group]) {
                prefetch_group(job, group + AHEAD, first + count);
                draw_group(job, group, segments);
            }
    }
}

/* Draws a part's pending interval, at the volume's face or before it. */
CVOL_COLD void end_part(const line_job *job, int group, int part, int at_face, int segments)
{
    lit_group g;
    load_group(&g, job->line, group, part, 1);
    if (is_closed(&g))
        return;
    const int i = group * CVOL_GROUP + part * CVOL_LANES;
    gradient now = gradient_at_end(&g, job, -1, group, part, at_face ? g.value : cvol_splat(NAN));
    now.reach = reach_of_pixels(job, -1, i);
    fade_gradient(now.v, job, -1, i);
    if (g.has_from)
        g.from.reach = reach_of_pixels(job, -2, i);
    if (is_visible(job, g.p.transmittance, g.before, g.value))
        draw_interval(&g, job, -1, group, part, &now, segments);
    g.pending = 0;
    store_group(&g, job->line, group, part);
}

/* Draws the pending interval behind the last layer, whose last slice is number
 * layer->sheets[0].ordinal - 1: samples are constant beyond the volume's face. */
CVOL_COLD void end_lit_line(const line_job *job, int segments)
{
    const cvol_line *line = job->line;
    for (int group = 0; group < line->width / CVOL_GROUP; group++) {
        const int last = line->intersected[group];
        if (line->opaque[group] || last == INT32_MIN)
            continue;
        for (int part = 0; part < PARTS; part++)
            end_part(job, group, part, last == job->layer->sheets[0].ordinal - 1, segments);
        line->intersected[group] = INT32_MIN;
    }
}

CVOL_INLINE void draw_lit(const cvol_layer *layer, const cvol_sheet_table *table,
                          const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    const int segments = HAVE_SEGMENTS && table->segments ? CVOL_SEGMENTS : 0;
    if (layer->sheet_count)
        draw_lit_line(&job, segments);
    else
        end_lit_line(&job, segments);
}

#endif
