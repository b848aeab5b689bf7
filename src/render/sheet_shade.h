/* Mode composite with light, as sheet_composite_simd.c without; and surfaces, mode iso.
 *
 * An interval between two sheets is lit at both, and by straight lines in between. At a sheet, the
 * gradient is of what the sheet itself and those before and behind it have there (sheet_slope.h).
 * So an interval is drawn when the sheet after its end is met: until then it is pending. Between
 * two layers, what is needed of the first one's samples is kept in the line: the slopes at its last
 * sheet, and how that sheet and the one before it continue into those beside them. Where a
 * neighbour is one that cannot be seen, values are continued straight, within the range of its
 * window.
 *
 * To be included by kernel files only, as sheet_composite.h.
 */
#ifndef CVOL_RENDER_SHEET_SHADE_H
#define CVOL_RENDER_SHEET_SHADE_H

#include "render/phong.h"
#include "render/sheet_between.h"
#include "render/sheet_classify.h"
#include "render/sheet_slope.h"

#define SHEET_LIT 1

/* How the value beside the end of a pending interval, in the sheet before or behind, is had. */
enum {
    KNOWN = 0,
    CONTINUED, /* as on the other side */
    BOUNDED,   /* the same, within a range */
    AT_FACE    /* no more samples there: as at the end itself */
};

/* A value beside. */
typedef struct beside {
    int edge;
    float level, spread; /* if it is bounded */
    cvol_vf value[PARTS], cover[PARTS];
} beside;

/* A group while it is drawn. Of a pending interval: */
typedef struct shade_state {
    pixels p[PARTS];
    cvol_vf value[PARTS], cover[PARTS];         /* at its end */
    cvol_vf before[PARTS], cover_before[PARTS]; /* at its beginning */
    lit_matter lit[PARTS];                      /* at its beginning, */
    int is_lit;                                 /* if that is known */
    cvol_vf weight[PARTS];
    int pending, weighted, visible;
    int end;     /* the ordinal of the sheet that it ends at */
    int divided; /* an extra: samples between its ends are known */
#if SHEET_EXTRAS
    cvol_vf between[CVOL_PARTS - 1][PARTS];
#endif
    cvol_vf length[PARTS]; /* of an interval, over that of the table: in perspective, else 1 */
    /* If its end is in a layer before, or the first sheet of this one: */
    slope slope[PARTS];
    beside behind;                            /* in the sheet before its end */
    cvol_vf ahead[PARTS], cover_ahead[PARTS]; /* its end's sheet, where the next one is met */
} shade_state;

/* ---- the line ----------------------------------------------------------------------------------
 */

/* Moves one vector from or to a line. */
CVOL_INLINE void move(cvol_vf *v, float *at, int store)
{
    if (store)
        cvol_store(at, *v);
    else
        *v = cvol_load(at);
}

/* Loads or stores a group; what is pending of it, only if there is anything. */
CVOL_INLINE void move_group(shade_state *g, const line_job *job, int group, int has_void, int store)
{
    const cvol_line *line = job->line;
    const long width = line->width;
    float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES, s += CVOL_LANES) {
        move(&g->p[k].r, r, store);
        move(&g->p[k].g, r + width, store);
        move(&g->p[k].b, r + 2 * width, store);
        move(&g->p[k].through, r + 3 * width, store);
        if (SHEET_EXTRAS && line->depth)
            move(&g->p[k].half, line->depth + group * CVOL_GROUP + k * CVOL_LANES, store);
        if (!g->pending)
            continue;
#if SHEET_EXTRAS
        for (int part = 1; part < job->layer->parts; part++)
            move(&g->between[part - 1][k], kept_between(job, CVOL_PARTS - 2 + part, group, k),
                 store);
#endif
        cvol_vf *const kept[] = {&g->before[k],        &g->lit[k].factor,   &g->lit[k].gloss,
                                 &g->lit[k].thickness, &g->weight[k],       &g->slope[k].lane,
                                 &g->slope[k].row,     &g->behind.value[k], &g->ahead[k]};
        cvol_vf *const covers[] = {&g->cover_before[k], &g->behind.cover[k], &g->cover_ahead[k]};
        move(&g->value[k], r + 4 * width, store);
        for (int n = 0; n < 9; n++)
            move(kept[n], s + n * width, store);
        if (has_void)
            move(&g->cover[k], r + 5 * width, store);
        for (int n = 0; n < 3; n++)
            if (has_void)
                move(covers[n], s + (n + 9) * width, store);
            else if (!store)
                *covers[n] = g->cover[k] = cvol_splat(1);
    }
}

CVOL_INLINE int is_visible(const line_job *job, const cvol_vf a[PARTS], const cvol_vf b[PARTS])
{
    int visible = 0;
    for (int k = 0; k < PARTS; k++)
        visible |= any_within(cvol_max(a[k], b[k]), cvol_min(a[k], b[k]), job->table->visible_from,
                              job->table->visible_to);
    return visible;
}

CVOL_INLINE void load_group(shade_state *g, const line_job *job, int group, int has_void,
                            int lengths)
{
    const cvol_line *line = job->line;
    g->pending = line->met[group] != INT32_MIN;
    g->end = line->met[group];
    g->is_lit = g->visible = 0;
    g->weighted = 1;
    g->behind.edge = KNOWN;
    g->behind.level = g->behind.spread = 0;
    for (int k = 0; k < PARTS; k++)
        g->length[k] = lengths ? find_lengths(job, group * CVOL_GROUP + k * CVOL_LANES)
                               : cvol_splat(1);
    for (int k = 0; k < PARTS && SHEET_EXTRAS; k++) /* the table is of parts */
        g->length[k] *= (float)job->layer->parts;
    g->divided = 0;
    move_group(g, job, group, has_void, 0);
    if (!g->pending)
        return;
    g->behind.edge = line->edges[group] & 3;
    g->is_lit = line->edges[group] >> 2 & 1;
    g->divided = line->edges[group] >> 3;
    g->visible = is_visible(job, g->before, g->value);
    if (g->behind.edge == BOUNDED) { /* where the value would be */
        const float *range = line->pending + 7 * (long)line->width + group * CVOL_GROUP;
        g->behind.level = range[0];
        g->behind.spread = range[1];
    }
}

CVOL_INLINE void store_group(shade_state *g, const line_job *job, int group, int has_void)
{
    const cvol_line *line = job->line;
    for (int k = 0; k < PARTS && !g->weighted; k++)
        g->weight[k] = SHEET_EXTRAS ? g->length[k] : cvol_splat(1);
    move_group(g, job, group, has_void, 1);
    line->edges[group] = (uint8_t)(g->behind.edge | g->is_lit << 2 | g->divided << 3);
    if (g->pending && g->behind.edge == BOUNDED) {
        float *range = line->pending + 7 * (long)line->width + group * CVOL_GROUP;
        range[0] = g->behind.level;
        range[1] = g->behind.spread;
    }
}

CVOL_INLINE int is_closed(const shade_state *g)
{
    cvol_vf most = g->p[0].through;
    for (int k = 1; k < PARTS; k++)
        most = cvol_max(most, g->p[k].through);
    return !any_above(most, OPAQUE_BELOW);
}

/* ---- light at the end of a pending interval -----------------------------------------------------
 */

/* A sheet's samples, of part k of a group, where it meets `place`: that sheet itself, or one
 * `offset` before or behind it in memory. */
CVOL_INLINE cvol_vf value_at(cvol_vf *cover, const line_job *job, const sheet_line *place,
                             long offset, int group, int k, int unit, int masked)
{
    sheet_line sheet = *place;
#if SHEET_EXTRAS
    if (job->layer->wide && masked)
        return to_table(job, reconstruct_widely_masked(cover, job, &sheet, offset, group, k, unit));
#endif
    if (masked) {
        const cvol_layer *layer = job->layer;
        const long i = group * CVOL_GROUP + k * CVOL_LANES;
        sheet.view.near += offset;
        sheet.view.far += offset;
        return to_table(job,
                        unit ? reconstruct_unit_masked(cover, &sheet.view, &sheet.footprint,
                                                       sheet.footprint.x + i, layer->cover_at)
                             : reconstruct_finer_masked(cover, &sheet.view,
                                                        sheet.lane_at + (double)i * sheet.lane_step,
                                                        sheet.lane_step, layer->cover_at));
    }
    sheet.near += offset;
    sheet.far += offset;
    *cover = cvol_splat(1);
    return reconstruct(job, &sheet, group, k, unit);
}

CVOL_INLINE long window_at(const sheet_line *sheet, int group, int unit)
{
    return window_of(lane_sample(sheet, group, unit));
}

CVOL_INLINE int is_masked(const sheet_line *sheet, int group, int unit, int has_void)
{
    return has_void && sheet->view.windows[window_at(sheet, group, unit)] & CVOL_WINDOW_MASKED;
}

/* How far sheet b of the layer lies behind sheet a in memory. */
CVOL_INLINE long offset_to(const line_job *job, int b, int a)
{
    return job->layer->sheets[b].first - job->layer->sheets[a].first;
}

CVOL_INLINE void bound_by(beside *out, const line_job *job, const sheet_line *sheet, long window)
{
    out->edge = BOUNDED;
    out->level = sheet->view.levels[window] * job->table->scale + job->table_offset;
    out->spread = sheet->view.levels[window + job->layer->windows.spread_at] * job->table->scale;
}

/* Beside sheet `s` of the layer (-1: the last one of the layer before), in the sheet after it. */
CVOL_INLINE void find_after(beside *out, const line_job *job, int s, int at_face, int group,
                            int unit, int has_void)
{
    out->level = out->spread = 0;
    if (s + 1 >= job->layer->sheet_count || s < -1) {
        out->edge = at_face ? AT_FACE : CONTINUED;
        return;
    }
    const sheet_line *place = s < 0 ? &job->before : &job->sheets[s];
    const long window = window_at(place, group, unit);
    if (s < 0 && !(place->view.windows[window] & CVOL_WINDOW_SEEN)) {
        bound_by(out, job, place, window);
        return;
    }
    const int masked = is_masked(place, group, unit, has_void);
    const long offset = s < 0 ? 0 : offset_to(job, s + 1, s);
    out->edge = KNOWN;
    for (int k = 0; k < PARTS; k++)
        out->value[k] = value_at(&out->cover[k], job, place, offset, group, k, unit, masked);
}

/* The same in the sheet before it, s > 0. */
CVOL_INLINE void find_behind(beside *out, const line_job *job, int s, int group, int unit,
                             int has_void)
{
    const sheet_line *place = &job->sheets[s];
    const int masked = is_masked(place, group, unit, has_void);
    out->level = out->spread = 0;
    out->edge = KNOWN;
    for (int k = 0; k < PARTS; k++)
        out->value[k] = value_at(&out->cover[k], job, place, offset_to(job, s - 1, s), group, k,
                                 unit, masked);
}

CVOL_INLINE cvol_vf bound(cvol_vf value, const beside *by)
{
    return cvol_min(cvol_max(value, cvol_splat(by->level - by->spread)),
                    cvol_splat(by->level + by->spread));
}

/* Of part k, whose end has `value`. Where there are samples between sheets, the gradient alone, in
 * the place of what it makes: as an opaque surface is between two sheets, one of them is where
 * gradients are faint and point anywhere, and should count as little as they are long. */
CVOL_INLINE lit_matter light_end(const line_job *job, cvol_vf value, slope at, const beside *after,
                                 const beside *behind, int k, int has_void)
{
    const cvol_light *light = job->table->light;
    cvol_vf rise = {0}, fall = {0}; /* to the sheet after, from the one before */
    if (after->edge == KNOWN)
        rise = after->value[k] - value;
    if (behind->edge == KNOWN)
        fall = value - behind->value[k];
    if (after->edge == CONTINUED || after->edge == BOUNDED)
        rise = fall;
    if (behind->edge == CONTINUED || behind->edge == BOUNDED)
        fall = rise;
    if (after->edge == BOUNDED)
        rise = bound(value + rise, after) - value;
    if (behind->edge == BOUNDED)
        fall = value - bound(value - fall, behind);
    cvol_vf across = rise + fall;
    if (has_void)
        across = weigh_differences(rise, fall,
                                   after->edge == KNOWN ? after->cover[k] : cvol_splat(1),
                                   behind->edge == KNOWN ? behind->cover[k] : cvol_splat(1));
    const cvol_vf gradient[3] = {at.lane * light->rise[0], at.row * light->rise[1],
                                 across * light->rise[2]};
    if (SHEET_EXTRAS && job->layer->parts > 1)
        return (lit_matter){gradient[0], gradient[1], gradient[2]};
    return illuminate(gradient, light);
}

/* Of what light_end says. */
CVOL_INLINE lit_matter light_of(const line_job *job, const lit_matter *at)
{
    const cvol_vf gradient[3] = {at->factor, at->gloss, at->thickness};
    if (SHEET_EXTRAS && job->layer->parts > 1)
        return illuminate(gradient, job->table->light);
    return *at;
}

/* ---- drawing ------------------------------------------------------------------------------------
 */

/* Where the ray first has the surface's value or more: in an interval, as values are straight
 * lines. */
CVOL_INLINE void hit_surface(shade_state *g, const line_job *job, int k, const interval *i,
                             cvol_vf weight, int has_void)
{
    const cvol_vf a = i->a, b = i->b;
    const lit_matter *from = i->from, *to = i->to;
    const cvol_sheet_table *table = job->table;
    pixels *p = &g->p[k];
    const cvol_vf t = cvol_select(a >= table->at, cvol_splat(0),
                                  (table->at - a) / cvol_max(b - a, cvol_splat(1e-20f)));
    cvol_vi hit = (cvol_max(a, b) >= table->at) & (weight >= LEAST_WEIGHT) & (p->through > 0.5f);
    if (has_void)
        hit &= g->cover_before[k] + t * (g->cover[k] - g->cover_before[k]) >= 0.5f;
    const cvol_vf factor = from->factor + t * (to->factor - from->factor);
    const cvol_vf gloss = from->gloss + t * (to->gloss - from->gloss);
    p->r = cvol_select(hit, table->colour[0] * factor + gloss, p->r);
    p->g = cvol_select(hit, table->colour[1] * factor + gloss, p->g);
    p->b = cvol_select(hit, table->colour[2] * factor + gloss, p->b);
    p->through = cvol_select(hit, cvol_splat(0), p->through);
    if (SHEET_EXTRAS)
        p->half = cvol_select(hit, i->at.from + t * (i->at.to - i->at.from), p->half);
}

#if SHEET_EXTRAS
/* An interval in parts. */
CVOL_INLINE void draw_divided(shade_state *g, const line_job *job, int k, const interval *all,
                              int has_void, int pieces)
{
    const int parts = job->layer->parts;
    const float step = 1 / (float)parts;
    const cvol_vf weight = step * (g->weighted ? g->weight[k] : g->length[k]);
    cvol_vf last = all->a;
    lit_matter from = light_of(job, all->from);
    for (int part = 1; part <= parts; part++) {
        const float before = (float)(part - 1) * step, now = (float)part * step;
        const lit_matter there = mix(all->from, all->to, cvol_splat(now)),
                         to = light_of(job, &there);
        const cvol_vf next = part < parts ? g->between[part - 1][k] : all->b;
        const interval one = {last, next, &from, &to, {all->at.from + before, all->at.from + now}};
        if (job->table->is_surface)
            hit_surface(g, job, k, &one, weight, has_void);
        else
            composite_interval(&g->p[k], job->table, &one, weight, g->weighted, pieces);
        last = next;
        from = to;
    }
}
#endif

/* Draws part k of the pending interval, whose end is lit by `now`. */
CVOL_INLINE void draw_pending(shade_state *g, const line_job *job, int k, const lit_matter *now,
                              int has_void, int pieces)
{
    const cvol_sheet_table *table = job->table;
    const cvol_vf weight = g->weighted ? g->weight[k] : cvol_splat(1);
    lit_matter from = g->is_lit ? g->lit[k] : *now, to = *now;
    cvol_vf a = g->before[k], b = g->value[k];
    if (has_void) { /* where an end has no value, the other's holds */
        const cvol_vi no_end = g->cover[k] < LEAST_WEIGHT;
        const cvol_vi no_start = g->cover_before[k] < LEAST_WEIGHT;
        b = cvol_select(no_end, g->before[k], b);
        a = cvol_select(no_start, g->value[k], a);
        /* And the light of an end that has less of a value counts less. */
        const cvol_vf least = cvol_splat(LEAST_WEIGHT);
        const cvol_vf start = cvol_max(g->cover_before[k], least),
                      end = cvol_max(g->cover[k], least);
        const lit_matter to_alone = to;
        to = mix(&from, &to, cvol_min(end / start, cvol_splat(1)));
        from = mix(&to_alone, &from, cvol_min(start / end, cvol_splat(1)));
    }
    const interval all = {a, b, &from, &to, stretch_of((float)g->end - 1, (float)g->end)};
#if SHEET_EXTRAS
    if (g->divided) {
        draw_divided(g, job, k, &all, has_void, pieces);
        return;
    }
#endif
    from = light_of(job, &from);
    to = light_of(job, &to);
    if (table->is_surface)
        hit_surface(g, job, k, &all, weight, has_void);
    else if (g->weighted)
        composite_interval(&g->p[k], table, &all, weight, 1, pieces);
    else
        composite_interval(&g->p[k], table, &all, weight, 0, pieces);
}

/* Draws the pending interval, which ends at sheet `s` of the layer (-1: the last one of the layer
 * before). `wanted`: the light at its end is needed in any case. */
CVOL_INLINE void finish(shade_state *g, const line_job *job, int s, int at_face, int group,
                        int wanted, int unit, int has_void, int pieces)
{
    if (!g->visible && !wanted)
        return;
    beside after = {0}, behind = {0};
    find_after(&after, job, s, at_face, group, unit, has_void);
    if (s > 0)
        find_behind(&behind, job, s, group, unit, has_void);
    else
        behind = g->behind;
    const int masked = s >= 0 && is_masked(&job->sheets[s], group, unit, has_void);
    for (int k = 0; k < PARTS; k++) {
        const slope at = s < 0    ? g->slope[k]
                         : masked ? find_slope_masked(job, &job->sheets[s], group, k, unit)
                                  : find_slope(job, &job->sheets[s], group, k, unit);
        const lit_matter now = light_end(job, g->value[k], at, &after, &behind, k, has_void);
        if (g->visible)
            draw_pending(g, job, k, &now, has_void, pieces);
        g->lit[k] = now;
    }
}

/* Sheets from s on, as long as `go` has them: known intervals, whole, of samples that all have a
 * value. Returns the sheet after the last that was met. */
CVOL_INLINE int draw_run(shade_state *state, int *closed, const line_job *job, uint64_t go, int s,
                         int group, int unit, int lengths, int pieces)
{
    shade_state g = *state;
    do {
        cvol_vf next[PARTS];
        for (int k = 0; k < PARTS; k++)
            next[k] = reconstruct(job, &job->sheets[s], group, k, unit);
        const int visible = is_visible(job, g.value, next);
        finish(&g, job, s - 1, 0, group, visible, unit, 0, pieces);
        if (s == 0)
            g.behind.edge = KNOWN;
        for (int k = 0; k < PARTS; k++) {
            if (s == 0)
                g.behind.value[k] = g.ahead[k];
            g.before[k] = g.value[k];
            g.value[k] = next[k];
#if SHEET_EXTRAS
            for (int part = 1; part < job->layer->parts; part++)
                g.between[part - 1][k] = find_between(job, s, part, group, k, unit, g.before[k],
                                                      g.value[k]);
#endif
        }
        g.divided = SHEET_EXTRAS && job->layer->parts > 1;
        *closed = g.visible && is_closed(&g);
        g.visible = visible;
        g.end = job->layer->sheets[0].ordinal + s;
        g.weighted = lengths;
        for (int k = 0; k < PARTS && g.weighted; k++)
            g.weight[k] = g.length[k];
        g.is_lit = 1;
        s++;
    } while (!*closed && go >> s & 1);
    *state = g;
    return s;
}

/* How much of the interval that ends at sheet s is within what is drawn. */
CVOL_INLINE cvol_vf weigh_part(const line_job *job, int s, int i)
{
    const sheet_line *sheet = &job->sheets[s];
    const int only = job->layer->only;
    return weigh(job->layer, &job->layer->sheets[s], &sheet->view,
                 sheet->lane_at + i * sheet->lane_step, i, job->line->number, only ? -0.5f : -1,
                 only ? 0.5f : 0);
}

/* A group meets a window that cannot be seen: what of the interval up to there can be, is drawn. */
CVOL_COLD void draw_end(shade_state *g, const line_job *job, int s, int group, int unit,
                        int has_void, int pieces)
{
    const sheet_line *sheet = &job->sheets[s];
    const long window = window_at(sheet, group, unit);
    const int masked = has_void && sheet->view.windows[window] & CVOL_WINDOW_MASKED;
    const cvol_vf level = to_table(job, cvol_splat(sheet->view.levels[window]));
    finish(g, job, s - 1, 0, group, 1, unit, has_void, pieces);
    g->weighted = 1;
    g->divided = 0;
    g->is_lit = 1;
    g->end = job->layer->sheets[s].ordinal;
    for (int k = 0; k < PARTS; k++) {
        const int i = group * CVOL_GROUP + k * CVOL_LANES;
        const lit_matter lit = g->lit[k];
        g->weight[k] = g->length[k] * weigh_part(job, s, i);
        if (masked)
            g->weight[k] *= 0.5f * g->cover[k];
        g->before[k] = g->value[k];
        g->value[k] = masked ? g->value[k] : level;
        draw_pending(g, job, k, &lit, 0, pieces);
    }
    g->pending = 0;
}

/* The ray ends behind sheet s, or what comes next is not known. */
CVOL_COLD void draw_last(shade_state *g, const line_job *job, int s, int at_face, int group,
                         int unit, int has_void, int pieces)
{
    finish(g, job, s, at_face, group, 0, unit, has_void, pieces);
    g->pending = 0;
}

/* A sheet of any kind that is seen. */
CVOL_COLD void draw_sheet(shade_state *g, const line_job *job, int s, int group, int unit,
                          int has_void, int pieces)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const int known = g->pending, ordinal = layer->sheets[s].ordinal;
    const int inside = group >= sheet->inside_begin && group < sheet->inside_end;
    const int masked = is_masked(sheet, group, unit, has_void);
    float level = 0, spread = 0;
    const int has_level = !known && find_level_before(&level, &spread, job, s, group);
    if (known)
        finish(g, job, s - 1, 0, group, 1, unit, has_void, pieces);
    for (int k = 0; k < PARTS; k++) {
        const int i = group * CVOL_GROUP + k * CVOL_LANES;
        cvol_vf cover;
        const cvol_vf value = value_at(&cover, job, sheet, 0, group, k, unit, masked);
        g->before[k] = known ? g->value[k] : has_level ? cvol_splat(level) : value;
        g->cover_before[k] = known ? g->cover[k] : has_level ? cvol_splat(1) : cover;
        g->value[k] = value;
        g->cover[k] = cover;
        g->weight[k] = !inside ? weigh_part(job, s, i) : cvol_splat(known || has_level ? 1 : 0.5f);
        g->weight[k] *= g->length[k];
        if (has_void)
            g->weight[k] *= 0.5f * (g->cover_before[k] + cover);
        g->behind.value[k] = g->ahead[k];
        g->behind.cover[k] = g->cover_ahead[k];
    }
    g->behind.edge = known ? KNOWN : has_level ? BOUNDED : ordinal == 0 ? AT_FACE : CONTINUED;
    g->behind.level = level;
    g->behind.spread = spread;
    g->is_lit = known;
    g->divided = 0;
    g->weighted = 1;
    g->end = ordinal;
    g->visible = is_visible(job, g->before, g->value);
    g->pending = 1;
}

/* Keeps of the layer's sheet s, at which the interval ends that stays pending, what the next layer
 * needs. */
CVOL_INLINE void keep(shade_state *g, const line_job *job, int s, int group, int unit, int has_void)
{
    const sheet_line *sheet = &job->sheets[s];
    const int masked = is_masked(sheet, group, unit, has_void);
    if (s > 0)
        find_behind(&g->behind, job, s, group, unit, has_void);
    for (int k = 0; k < PARTS; k++) {
        g->slope[k] = masked ? find_slope_masked(job, sheet, group, k, unit)
                             : find_slope(job, sheet, group, k, unit);
        g->ahead[k] = value_at(&g->cover_ahead[k], job, &job->after, 0, group, k, unit,
                               is_masked(&job->after, group, unit, has_void));
    }
}

/* A group through the sheets that it meets. */
CVOL_INLINE void draw_group(const line_job *job, int group, int unit, int has_void, int lengths,
                            int pieces)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = has_void ? 0 : seen & job->inside[at];
    uint32_t met = job->met[at];
    int last = line->met[group], closed = 0;
    if (!seen && last == INT32_MIN)
        return;
    shade_state g;
    load_group(&g, job, group, has_void, lengths);
    while (met && !closed) {
        int s = __builtin_ctz(met);
        if (g.pending && last != first + s - 1) {
            draw_last(&g, job, last - first, 0, group, unit, has_void, pieces);
            closed = is_closed(&g);
            continue;
        }
        if (g.pending && go >> s & 1) {
            s = draw_run(&g, &closed, job, go, s, group, unit, lengths, pieces);
            last = first + s - 1;
            met &= ~UINT32_C(0) << (s - 1) << 1;
            continue;
        }
        met &= met - 1;
        if (seen >> s & 1) {
            draw_sheet(&g, job, s, group, unit, has_void, pieces);
            last = first + s;
        } else {
            if (g.pending)
                draw_end(&g, job, s, group, unit, has_void, pieces);
            met &= from_lowest(met & seen); /* nothing to be seen until then */
        }
        closed = is_closed(&g);
    }
    if (g.pending && last >= first)
        keep(&g, job, last - first, group, unit, has_void);
    if (SHEET_EXTRAS && job->layer->parts > 1 && g.pending && !closed &&
        last == first + job->layer->sheet_count - 1)
        keep_between(job, group, unit);
    store_group(&g, job, group, has_void);
    line->met[group] = g.pending ? last : INT32_MIN;
    line->opaque[group] = (uint8_t)closed;
}

/* To where rays meet the sheet before or behind. */
CVOL_INLINE void move_view(cvol_sheet_view *view, int by)
{
    view->lane_at += by * view->lane_rate[0];
    view->lane_step += by * view->lane_rate[1];
    view->row_at += by * view->row_rate[0];
    view->row_step += by * view->row_rate[1];
}

CVOL_INLINE void draw_line(line_job *job, int unit, int has_void, int lengths, int pieces)
{
    const cvol_layer *layer = job->layer;
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
    cvol_sheet_view beyond = layer->sheets[0]; /* of the first sheet, where the one before is met */
    move_view(&beyond, -1);
    view_sheet(&job->before, job, &beyond, unit);
    beyond = layer->sheets[layer->sheet_count - 1]; /* of the last one, where the next is met */
    move_view(&beyond, 1);
    view_sheet(&job->after, job, &beyond, unit);
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
        find_met(job, first, count, unit);
        for (int group = first; group < first + count; group++)
            if (!job->line->opaque[group])
                draw_group(job, group, unit, has_void, lengths, pieces);
    }
}

/* What is pending behind the last layer, whose last sheet is number layer->sheets[0].ordinal - 1.
 */
CVOL_COLD void end_line(const line_job *job, int has_void)
{
    const cvol_line *line = job->line;
    for (int group = 0; group < line->width / CVOL_GROUP; group++) {
        const int last = line->met[group];
        if (line->opaque[group] || last == INT32_MIN)
            continue;
        shade_state g;
        load_group(&g, job, group, has_void, 0);
        draw_last(&g, job, -2, last == job->layer->sheets[0].ordinal - 1, group, 1, has_void, 0);
        store_group(&g, job, group, has_void);
        line->met[group] = INT32_MIN;
    }
}

#endif
