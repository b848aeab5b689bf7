/* Mode composite with light along the rays of the picture's own pixels, from samples of 16 bits,
 * with AVX-512: as sheet_shade.h does it along lines of the intermediate image.
 *
 * An interval between two sheets is drawn when the sheet after its end is met, as the gradient at
 * its end is of what that one, its own and the one before have there: until then it is pending.
 * Between two layers, what is needed of the first one's samples is kept in the line: the slopes at
 * its last sheet, and how that sheet and the one before it continue into those beside them. What is
 * not known of a pixel, because nothing there was evaluated, is no number; there values are
 * continued straight.
 *
 * To be included by kernel files only.
 */
#ifndef CVOL_RENDER_SHEET_SLANT_SHADE_H
#define CVOL_RENDER_SHEET_SLANT_SHADE_H

#include "render/sheet_line.h"
#include "render/sheet_slant_shade_interval.h"
#include "render/sheet_slant_shade_words.h"

/* A group while it is drawn; of its pending interval: */
typedef struct lit_group {
    pixels p;
    cvol_vf before, value; /* at its beginning, and at its end */
    gradient from;         /* at its beginning, */
    int has_from;          /* if that is known */
    cvol_vf weight;        /* if it is not whole */
    int pending, weighted, visible;
    matter last;  /* at its beginning, */
    int has_last; /* if that is known */
    /* Where its end is in a layer before, or the first sheet of this one: */
    cvol_vf slope[2];
    cvol_vf behind; /* in the sheet before its end, */
    cvol_vf ahead;  /* and in its end's sheet, where the next one is met */
} lit_group;

/* ---- what lines keep ---------------------------------------------------------------------------
 */

#define HAS_FROM 1
#define WEIGHTED 2

CVOL_INLINE void load_group(lit_group *g, const cvol_line *line, int group)
{
    const long width = line->width;
    const float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    g->p = (pixels){cvol_load(r),
                    cvol_load(r + width),
                    cvol_load(r + 2 * width),
                    cvol_load(r + 3 * width),
                    {0},
                    0};
    g->pending = line->met[group] != INT32_MIN;
    g->has_from = g->has_last = g->visible = 0;
    g->weighted = 1;
    if (!g->pending)
        return;
    g->value = cvol_load(r + 4 * width);
    cvol_vf *const kept[] = {&g->before,   &g->from.v[0], &g->from.v[1], &g->from.v[2], &g->weight,
                             &g->slope[0], &g->slope[1],  &g->behind,    &g->ahead};
    for (int n = 0; n < CVOL_PENDING_LINES_PLAIN; n++)
        *kept[n] = cvol_load(s + n * width);
    g->has_from = line->edges[group] & HAS_FROM;
    g->weighted = line->edges[group] & WEIGHTED;
}

CVOL_INLINE void store_group(const lit_group *g, const cvol_line *line, int group)
{
    const long width = line->width;
    float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    cvol_store(r, g->p.r);
    cvol_store(r + width, g->p.g);
    cvol_store(r + 2 * width, g->p.b);
    cvol_store(r + 3 * width, g->p.through);
    if (!g->pending)
        return;
    cvol_store(r + 4 * width, g->value);
    const cvol_vf *const kept[] = {&g->before,    &g->from.v[0], &g->from.v[1],
                                   &g->from.v[2], &g->weight,    &g->slope[0],
                                   &g->slope[1],  &g->behind,    &g->ahead};
    for (int n = 0; n < CVOL_PENDING_LINES_PLAIN; n++)
        cvol_store(s + n * width, *kept[n]);
    line->edges[group] = (uint8_t)((g->has_from ? HAS_FROM : 0) | (g->weighted ? WEIGHTED : 0));
}

CVOL_INLINE int is_closed(const lit_group *g)
{
    return !any_above(g->p.through, OPAQUE_BELOW);
}

CVOL_INLINE int is_visible(const line_job *job, cvol_vf a, cvol_vf b)
{
    return any_within(cvol_max(a, b), cvol_min(a, b), job->table->visible_from,
                      job->table->visible_to);
}

/* ---- values ------------------------------------------------------------------------------------
 */

/* A sheet's samples where its layer's sheet `s` is met, `by` sheets further. */
CVOL_INLINE sheet_line move_sheet(const line_job *job, int s, double by)
{
    sheet_line out = job->sheets[s];
    out.number = -1;
    out.lane_at += by * job->layer->sheets[s].lane_rate[0];
    out.row_at += by * job->layer->sheets[s].row_rate[0];
    return out;
}

/* How far sheet b of the layer lies behind sheet a in memory. */
CVOL_INLINE long offset_to(const line_job *job, int b, int a)
{
    return job->sheets[b].origin - job->sheets[a].origin;
}

CVOL_INLINE int is_mixed(const line_job *job, int s, int group)
{
    return (int)(job->mixed[group - job->first_group] >> s & 1);
}

/* Pixels of sheet s with nothing to be seen. */
CVOL_COLD cvol_vi find_unseen_pixels(const line_job *job, int s, int group)
{
    __m512 levels;
    const group_place at = place_group(job, &job->sheets[s], group);
    return (cvol_vi)_mm512_movm_epi32(
        find_unseen_of_group(&levels, job->layer, job->sheets[s].windows, &at));
}

/* Of sheet s; pixels with nothing to be seen have a value amidst what is there. */
CVOL_INLINE cvol_vf value_of_sheet(const line_job *job, int s, int group, const group_place *at)
{
    const sheet_line *sheet = &job->sheets[s];
    cvol_vf value = value_of_group(at, 0);
    if (is_mixed(job, s, group)) {
        __m512 levels;
        const __mmask16 unseen = find_unseen_of_group(&levels, job->layer, sheet->windows, at);
        value = (cvol_vf)_mm512_mask_mov_ps((__m512)value, unseen, kept_levels(job->layer, levels));
    }
    return sample_to_table(job, value);
}

/* Of a sheet where another is met; pixels with nothing to be seen there have none. */
CVOL_INLINE cvol_vf value_beside(const line_job *job, const sheet_line *sheet, int group)
{
    const group_place at = place_group(job, sheet, group);
    const cvol_vf value = sample_to_table(job, value_of_group(&at, 0));
    if (is_there_slanted(job, sheet, group))
        return value;
    __m512 levels;
    const __mmask16 unseen = find_unseen_of_group(&levels, job->layer, sheet->windows, &at);
    return (cvol_vf)_mm512_mask_mov_ps((__m512)value, unseen, _mm512_set1_ps(NAN));
}

/* ---- gradients ---------------------------------------------------------------------------------
 */

/* Of differences of samples two apart, in units of which so many are one of the table's. */
CVOL_INLINE gradient gradient_of(const line_job *job, const cvol_vf slopes[2], cvol_vf rise,
                                 float scale)
{
    const cvol_light *light = job->table->light;
    return (gradient){{slopes[0] * (scale * light->rise[0]), slopes[1] * (scale * light->rise[1]),
                       rise * (scale * light->rise[2])}};
}

/* At a sheet with one before it and one behind. */
CVOL_INLINE gradient gradient_within(const line_job *job, int s, const group_place *at)
{
    cvol_vf slopes[2];
    slope_of_group(slopes, at, 0);
    return gradient_of(job, slopes,
                       rise_of_group(at, offset_to(job, s - 1, s), offset_to(job, s + 1, s)),
                       job->sample_scale);
}

/* Slopes of sheet s, in the table's units, and what is in the sheet before. */
CVOL_INLINE cvol_vf find_slopes(cvol_vf slopes[2], const lit_group *g, const line_job *job, int s,
                                int group)
{
    const group_place at = place_group(job, &job->sheets[s], group);
    slope_of_group(slopes, &at, 0);
    for (int k = 0; k < 2; k++)
        slopes[k] *= job->sample_scale;
    return s > 0 ? sample_to_table(job, value_of_group(&at, offset_to(job, s - 1, s))) : g->ahead;
}

/* At the end of the pending interval, which is sheet s of the layer, below 0: of one before;
 * `after`: what is in the sheet behind. */
CVOL_INLINE gradient gradient_at_end(const lit_group *g, const line_job *job, int s, int group,
                                     cvol_vf after)
{
    cvol_vf slopes[2] = {g->slope[0], g->slope[1]}, behind = g->behind;
    if (s >= 0)
        behind = find_slopes(slopes, g, job, s, group);
    cvol_vf rise = after - g->value, fall = g->value - behind;
    rise = cvol_select(rise == rise, rise, fall);
    fall = cvol_select(fall == fall, fall, rise);
    const cvol_vi known = (slopes[0] == slopes[0]) & (rise == rise);
    const gradient none = {{{0}}}, at = gradient_of(job, slopes, rise + fall, 1);
    return select_gradient(known, &at, &none);
}

/* What a pending interval's end has behind it. */
CVOL_INLINE cvol_vf value_after(const line_job *job, int s, int group)
{
    if (s < -1 || s + 1 >= job->layer->sheet_count)
        return cvol_splat(NAN);
    if (s < 0)
        return value_beside(job, &job->before, group);
    const group_place at = place_group(job, &job->sheets[s], group);
    return sample_to_table(job, value_of_group(&at, offset_to(job, s + 1, s)));
}

/* Half way from the sheet before to sheet s: straight where what lies there is not known. */
CVOL_INLINE void find_half_way(lit_interval *i, const line_job *job, int s, int group)
{
    const cvol_vf half = cvol_splat(0.5f);
    const gradient straight = mix_gradients(&i->from, &i->to, half);
    i->middle = half * (i->a + i->b);
    i->half = straight;
    if (s < 1 || (job->seen[group - job->first_group] >> (s - 1) & 3) != 3)
        return;
    const long before = offset_to(job, s - 1, s);
    const sheet_line sheet = move_sheet(job, s, -0.5);
    const group_place at = place_group(job, &sheet, group);
    i->middle = sample_to_table(job, half * (value_of_group(&at, before) + value_of_group(&at, 0)));
    if (s > 1 && s + 1 < job->layer->sheet_count) {
        cvol_vf here[2], there[2];
        slope_of_group(here, &at, 0);
        slope_of_group(there, &at, before);
        for (int k = 0; k < 2; k++)
            here[k] = half * (here[k] + there[k]);
        const cvol_vf rise = rise_of_group(&at, before, offset_to(job, s + 1, s)) +
                             rise_of_group(&at, offset_to(job, s - 2, s), 0);
        i->half = gradient_of(job, here, half * rise, job->sample_scale);
    }
    if (is_mixed(job, s, group) || is_mixed(job, s - 1, group)) {
        const cvol_vi unseen = find_unseen_pixels(job, s, group) |
                               find_unseen_pixels(job, s - 1, group);
        i->middle = cvol_select(unseen, half * (i->a + i->b), i->middle);
        i->half = select_gradient(unseen, &straight, &i->half);
    }
}

/* ---- intervals ---------------------------------------------------------------------------------
 */

/* Draws the pending interval, which ends at sheet s with a gradient. */
CVOL_INLINE void draw_interval(lit_group *g, const line_job *job, int s, int group,
                               const gradient *now, int pieces)
{
    const cvol_sheet_table *table = job->table;
    lit_interval i;
    i.a = g->before;
    i.b = g->value;
    i.from = g->has_from ? g->from : *now;
    i.to = *now;
    take_other_gradient(&i.from, &i.to);
    if (g->weighted) {
        composite_weighted(&g->p, table, &i, g->weight, pieces);
        g->has_last = 0;
        return;
    }
    if (!g->has_last)
        g->last = matter_of_gradient(table, i.a, &i.from, pieces);
    g->has_last = 1;
    const matter end = matter_of_gradient(table, i.b, &i.to, pieces);
    const cvol_vf span = (cvol_max(i.a, i.b) - cvol_min(i.a, i.b)) * g->p.through;
    if (!table->halves &&
        !any_above(weigh_span(span, &g->last, &end), HALVES_OF_FLAT * table->flat)) {
        add_lit_part(&g->p, &g->last, &end, g->p.through, through_between(&g->last, &end));
        g->last = end;
        return;
    }
    find_half_way(&i, job, s, group);
    composite_divided(&g->p, table, &g->last, &end, &i, pieces);
}

/* The same, whose end's gradient is found. `wanted`: that is needed in any case; `at`: where the
 * sheet is met, NULL: not known yet. */
CVOL_INLINE void finish(lit_group *g, const line_job *job, int s, int group, int wanted,
                        const group_place *at, int pieces)
{
    if (!g->visible && !wanted) {
        g->has_last = 0;
        return;
    }
    gradient now;
    if (s > 0 && s + 1 < job->layer->sheet_count) {
        const group_place found = at ? *at : place_group(job, &job->sheets[s], group);
        now = gradient_within(job, s, &found);
    } else
        now = gradient_at_end(g, job, s, group, value_after(job, s, group));
    if (s >= 0 && is_mixed(job, s, group)) {
        const gradient none = {{{0}}};
        now = select_gradient(find_unseen_pixels(job, s, group), &none, &now);
    }
    if (g->visible)
        draw_interval(g, job, s, group, &now, pieces);
    else
        g->has_last = 0;
    g->from = now;
    g->has_from = 1;
}

/* Sheets from s on, as long as `go` has them: known intervals, whole. Returns the sheet after the
 * last that was met. */
CVOL_INLINE int draw_run(lit_group *g, int *closed, const line_job *job, uint64_t go, int s,
                         int group, int pieces)
{
    group_place at, before;
    if (s > 0)
        at = place_group(job, &job->sheets[s - 1], group);
    do {
        before = at;
        at = place_group(job, &job->sheets[s], group);
        const cvol_vf next = value_of_sheet(job, s, group, &at);
        const int visible = is_visible(job, g->value, next);
        finish(g, job, s - 1, group, visible, &before, pieces);
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

/* How much of the interval that ends at sheet s is within what is drawn. */
CVOL_INLINE cvol_vf weigh_interval(const line_job *job, int s, int group)
{
    const sheet_line *sheet = &job->sheets[s];
    const int only = job->layer->only, i = group * CVOL_GROUP;
    return weigh(job->layer, &job->layer->sheets[s], &sheet->view,
                 sheet->lane_at + i * sheet->lane_step, i, job->line->number, only ? -0.5f : -1,
                 only ? 0.5f : 0);
}

/* A group meets a sheet where nothing can be seen: what of the interval up to there can be, is
 * drawn. */
CVOL_COLD void draw_end(lit_group *g, const line_job *job, int s, int group, int pieces)
{
    cvol_vf levels[PARTS];
    find_levels(levels, job, s, job->sheets[s].windows, group, 0);
    finish(g, job, s - 1, group, 1, NULL, pieces);
    const lit_interval i = {.a = g->value, .b = levels[0], .from = g->from, .to = g->from};
    if (is_visible(job, i.a, i.b))
        composite_weighted(&g->p, job->table, &i, weigh_interval(job, s, group), pieces);
    g->pending = 0;
}

/* A sheet of any kind that is seen. */
CVOL_COLD void draw_sheet(lit_group *g, const line_job *job, int s, int group, int pieces)
{
    const sheet_line *sheet = &job->sheets[s];
    const int known = g->pending,
              inside = group >= sheet->inside_begin && group < sheet->inside_end;
    const group_place place = place_group(job, sheet, group);
    const cvol_vf value = value_of_sheet(job, s, group, &place);
    cvol_vf levels[PARTS] = {{0}};
    const int has_level = !known && find_levels_before(levels, job, s, group);
    if (known)
        finish(g, job, s - 1, group, 1, NULL, pieces);
    g->has_from = known;
    g->before = known ? g->value : has_level ? levels[0] : value;
    if (!known) /* at a face samples go on as they are there */
        g->ahead = job->layer->sheets[s].ordinal == 0 ? value : cvol_splat(NAN);
    g->behind = g->ahead;
    g->value = value;
    g->weight = inside ? cvol_splat(known || has_level ? 1 : 0.5f) : weigh_interval(job, s, group);
    g->weighted = !inside || !(known || has_level);
    g->has_last = 0;
    g->visible = is_visible(job, g->before, g->value);
    g->pending = 1;
}

/* Keeps of the layer's sheet s, at which the interval ends that stays pending, what the next layer
 * needs. */
CVOL_INLINE void keep(lit_group *g, const line_job *job, int s, int group)
{
    g->behind = find_slopes(g->slope, g, job, s, group);
    g->ahead = value_beside(job, &job->after, group);
    if (is_mixed(job, s, group))
        g->slope[0] = cvol_select(find_unseen_pixels(job, s, group), cvol_splat(NAN), g->slope[0]);
    if (!g->weighted)
        g->weight = cvol_splat(1);
}

/* A group through the sheets that it meets. */
CVOL_INLINE void draw_group(const line_job *job, int group, int pieces)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = seen & job->inside[at];
    uint32_t met = job->met[at];
    int last = line->met[group], closed = 0;
    if (!seen && last == INT32_MIN)
        return;
    lit_group g;
    load_group(&g, line, group);
    g.visible = g.pending && is_visible(job, g.before, g.value);
    while (met && !closed) {
        int s = __builtin_ctz(met);
        if (g.pending && last != first + s - 1) {
            finish(&g, job, last - first, group, 0, NULL, pieces);
            g.pending = 0;
            closed = is_closed(&g);
            continue;
        }
        if (g.pending && go >> s & 1) {
            s = draw_run(&g, &closed, job, go, s, group, pieces);
            last = first + s - 1;
            met &= ~UINT32_C(0) << (s - 1) << 1;
            continue;
        }
        met &= met - 1;
        if (seen >> s & 1) {
            draw_sheet(&g, job, s, group, pieces);
            last = first + s;
        } else {
            if (g.pending)
                draw_end(&g, job, s, group, pieces);
            met &= from_lowest(met & seen); /* nothing to be seen until then */
        }
        closed = is_closed(&g);
    }
    if (g.pending && last >= first)
        keep(&g, job, last - first, group);
    store_group(&g, line, group);
    line->met[group] = g.pending ? last : INT32_MIN;
    line->opaque[group] = (uint8_t)closed;
}

CVOL_INLINE void draw_lit_line(line_job *job, int pieces)
{
    const cvol_layer *layer = job->layer;
    int begin = job->line->width / CVOL_GROUP, end = 0;
    view_slanted(job);
    for (int s = 0; s < layer->sheet_count; s++) {
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
    job->before = move_sheet(job, 0, -1);
    job->after = move_sheet(job, layer->sheet_count - 1, 1);
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
        find_met_slanted(job, first, count);
        for (int group = first; group < first + count; group++)
            if (!job->line->opaque[group])
                draw_group(job, group, pieces);
    }
}

/* What is pending behind the last layer, whose last sheet is number layer->sheets[0].ordinal - 1:
 * at the volume's face samples go on as they are there. */
CVOL_COLD void end_lit_line(const line_job *job, int pieces)
{
    const cvol_line *line = job->line;
    for (int group = 0; group < line->width / CVOL_GROUP; group++) {
        const int last = line->met[group];
        if (line->opaque[group] || last == INT32_MIN)
            continue;
        lit_group g;
        load_group(&g, line, group);
        const int at_face = last == job->layer->sheets[0].ordinal - 1;
        const gradient now = gradient_at_end(&g, job, -1, group,
                                             at_face ? g.value : cvol_splat(NAN));
        if (is_visible(job, g.before, g.value))
            draw_interval(&g, job, -1, group, &now, pieces);
        g.pending = 0;
        store_group(&g, line, group);
        line->met[group] = INT32_MIN;
    }
}

#endif
