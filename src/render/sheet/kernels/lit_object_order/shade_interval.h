/* Draws a pending interval with lit ends (shade.h): as classified samples, or as a surface.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_INTERVAL_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_INTERVAL_H

#include "render/sheet/kernels/lit_object_order/shade_light.h"

/* The first place where the ray reaches the surface's value: in an interval, since values are
 * linear. Where a ray enters the volume beyond that value, it meets a cut face, which shows the
 * values there: their gradients are not those of a surface. */
CVOL_INLINE void hit_surface(shade_state *g, const line_job *job, int k, const interval *i,
                             cvol_vf weight, int has_void)
{
    const cvol_vf a = i->a, b = i->b;
    const lit_sample *from = i->from, *to = i->to;
    const cvol_sheet_table *table = job->table;
    pixels *p = &g->p[k];
    const cvol_vf t = cvol_select(a >= table->at, cvol_splat(0),
                                  (table->at - a) / cvol_max(b - a, cvol_splat(1e-20f)));
    cvol_vi hit = (cvol_max(a, b) >= table->at) & (weight >= MIN_WEIGHT) &
                  (p->transmittance > 0.5f);
    if (has_void)
        hit &= g->cover_before[k] + t * (g->cover[k] - g->cover_before[k]) >= 0.5f;
    lit_sample lit = mix(from, to, t);
    if (i->interpolates_gradients)
        lit = light_of_gradient(&lit, table->light);
    if (!has_void) {
        const cvol_vf level = cvol_min(
            cvol_max((a - table->cut_black) * table->cut_scale, cvol_splat(0)), cvol_splat(1));
        lit.factor = cvol_select(a >= table->at, level, lit.factor);
        lit.gloss = cvol_select(a >= table->at, cvol_splat(0), lit.gloss);
    }
    p->r = cvol_select(hit, table->colour[0] * lit.factor + lit.gloss, p->r);
    p->g = cvol_select(hit, table->colour[1] * lit.factor + lit.gloss, p->g);
    p->b = cvol_select(hit, table->colour[2] * lit.factor + lit.gloss, p->b);
    p->transmittance = cvol_select(hit, cvol_splat(0), p->transmittance);
    if (SHEET_EXTRAS)
        p->half = cvol_select(hit, i->at.from + t * (i->at.to - i->at.from), p->half);
}

#if SHEET_EXTRAS
/* Draws an interval in parts. */
CVOL_INLINE void draw_divided(shade_state *g, const line_job *job, int k, const interval *all,
                              int has_void, int segments)
{
    const int parts = job->layer->parts;
    const float step = 1 / (float)parts;
    const cvol_vf weight = step * (g->weighted ? g->weight[k] : g->length[k]);
    cvol_vf last = all->a;
    lit_sample from = light_of_gradient(all->from, job->table->light);
    for (int part = 1; part <= parts; part++) {
        const float before = (float)(part - 1) * step, now = (float)part * step;
        const lit_sample there = mix(all->from, all->to, cvol_splat(now)),
                         to = light_of_gradient(&there, job->table->light);
        const cvol_vf next = part < parts ? g->between[part - 1][k] : all->b;
        const interval one = {last, next, &from, &to, {all->at.from + before, all->at.from + now},
                              NULL, {0},  0};
        if (job->table->is_surface)
            hit_surface(g, job, k, &one, weight, has_void);
        else
            composite_interval(&g->p[k], job->table, &one, weight, g->weighted, segments);
        last = next;
        from = to;
    }
}
#endif

/* Draws part k of the pending interval, whose end has the light `now`. */
CVOL_INLINE void draw_pending(shade_state *g, const line_job *job, int k, const lit_sample *now,
                              int has_void, int segments)
{
    const cvol_sheet_table *table = job->table;
    const cvol_vf weight = g->weighted ? g->weight[k] : cvol_splat(1);
    lit_sample from = g->is_lit ? g->lit[k] : *now, to = *now;
    cvol_vf a = g->before[k], b = g->value[k];
    if (has_void) { /* an end without a value takes the other's */
        const cvol_vi no_end = g->cover[k] < MIN_WEIGHT;
        const cvol_vi no_start = g->cover_before[k] < MIN_WEIGHT;
        b = cvol_select(no_end, g->before[k], b);
        a = cvol_select(no_start, g->value[k], a);
        /* The light of an end is weighted by its cover. */
        const cvol_vf least = cvol_splat(MIN_WEIGHT);
        const cvol_vf start = cvol_max(g->cover_before[k], least),
                      end = cvol_max(g->cover[k], least);
        const lit_sample to_alone = to;
        to = mix(&from, &to, cvol_min(end / start, cvol_splat(1)));
        from = mix(&to_alone, &from, cvol_min(start / end, cvol_splat(1)));
    }
    interval all = {a,
                    b,
                    &from,
                    &to,
                    ray_interval_of((float)g->end - 1, (float)g->end),
                    NULL,
                    {0},
                    table->interpolates_gradients};
    cvol_vf middle;
    if (table->interpolates_gradients) {
        middle = 0.5f * (a + b) + table->shear_correction[0] * (from.factor - to.factor) +
                 table->shear_correction[1] * (from.gloss - to.gloss);
        all.middle = &middle;
        all.has_midpoint = ~(cvol_vi){0};
    }
#if SHEET_EXTRAS
    if (g->divided) {
        draw_divided(g, job, k, &all, has_void, segments);
        return;
    }
#endif
    if (table->is_surface)
        hit_surface(g, job, k, &all, weight, has_void);
    else {
        if (has_void || !g->has_last)
            g->last[k] = classified_at_start(table, a, &from, table->interpolates_gradients,
                                             segments);
        composite_from(&g->p[k], table, &g->last[k], &all, weight, g->weighted, segments);
    }
}

/* One function for all kinds of intervals but the common ones (draw_run_of_kind). */
CVOL_COLD void draw_pending_rare(shade_state *g, const line_job *job, int k, const lit_sample *now,
                                 int has_void, int segments)
{
    draw_pending(g, job, k, now, has_void, segments);
}

/* find_after where a kernel of the common kinds calls it, once for each layer. */
CVOL_COLD void find_after_layer(end_neighbour *out, const line_job *job, int group, int unit)
{
    find_after(out, job, -1, 0, group, unit, 0);
}

/* Draws the pending interval, which ends at slice `s` of the layer (-1: the last one of the layer
 * before). `wanted`: the light at its end is needed in any case; `rare`: compiled for all kinds. */
CVOL_INLINE void finish(shade_state *g, const line_job *job, int s, int at_face, int group,
                        int wanted, int unit, int has_void, int segments, int rare)
{
    if (!g->visible && !wanted) {
        g->has_last = 0;
        return;
    }
    end_neighbour after = {0}, behind = {0};
    if (rare)
        find_after(&after, job, s, at_face, group, unit, has_void);
    else if (s < 0)
        find_after_layer(&after, job, group, unit);
    else
        find_neighbour(&after, job, s, s + 1, group, unit, has_void);
    if (s > 0)
        find_neighbour(&behind, job, s, s - 1, group, unit, has_void);
    else
        behind = g->behind;
    const int masked = s >= 0 && is_masked(&job->sheets[s], group, unit, has_void);
    for (int k = 0; k < PARTS; k++) {
        const slope at = s < 0    ? g->slope[k]
                         : masked ? find_slope_masked(job, &job->sheets[s], group, k, unit)
                                  : find_slope(job, &job->sheets[s], group, k, unit);
        const lit_sample now = light_end(job, g->value[k], at, &after, &behind, k, s,
                                         group * CVOL_GROUP + k * CVOL_LANES, has_void);
        if (g->visible && rare)
            draw_pending_rare(g, job, k, &now, has_void, segments);
        else if (g->visible)
            draw_pending(g, job, k, &now, has_void, segments);
        g->lit[k] = now;
    }
    g->has_last = g->visible && !g->divided;
}

CVOL_COLD void finish_rare(shade_state *g, const line_job *job, int s, int at_face, int group,
                           int wanted, int unit, int has_void, int segments)
{
    finish(g, job, s, at_face, group, wanted, unit, has_void, segments, 1);
}

#endif
