/* Mode composite: one line of the intermediate image through all slices of a layer.
 *
 * A ray's value is known where it crosses the slices; it is linear between two of them. Each
 * interval between slices is classified at the ends of its 1, 2 or 4 parts. Their number depends on
 * the transfer function over the values that the interval spans (cvol_sheet_table.flat); a part has
 * the mean of both ends (the trapezoidal rule). Parts are composited front to back:
 *     I += (1 - A) F D,  A += (1 - A) D
 *
 * The kernel first finds the position of each slice under the line. Then each group of pixels
 * passes the slices of the layer in which it meets something visible, with its colour in registers.
 * Values are stored as table coordinates.
 *
 * Only kernel files include this file: each compiles it for its instruction set, with or without
 * extras (SHEET_EXTRAS, classify.h). */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_COMPOSITE_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_COMPOSITE_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/between.h"
#include "render/sheet/kernels/composite/line.h"
#if SHEET_IMAGE_ORDER
#include "render/sheet/kernels/image_order/midpoint.h"
#endif

/* A group while it is drawn. */
typedef struct group_state {
    pixels p[PARTS];
    cvol_vf value[PARTS],
        cover[PARTS]; /* at the slice before; cover only if some samples have no value */
    cvol_vf
        length[PARTS]; /* of an interval, relative to that of the table: in perspective, else 1 */
} group_state;

/* ---- one group ------------------------------------------------------------------------------- */

CVOL_INLINE void load_group(group_state *g, const line_job *job, int group, int has_void,
                            int lengths)
{
    const cvol_line *line = job->line;
    const float *r = line->values + group * CVOL_GROUP;
    const int width = line->width;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES) {
        g->p[k] = (pixels){cvol_load(r),
                           cvol_load(r + width),
                           cvol_load(r + 2 * width),
                           cvol_load(r + 3 * width),
                           {0},
                           0};
        if (SHEET_EXTRAS && line->depth)
            g->p[k].half = cvol_load(line->depth + group * CVOL_GROUP + k * CVOL_LANES);
        g->value[k] = cvol_load(r + 4 * width);
        g->cover[k] = has_void ? cvol_load(r + 5 * width) : cvol_splat(1);
        g->length[k] = lengths ? find_lengths(job, group * CVOL_GROUP + k * CVOL_LANES)
                               : cvol_splat(1);
        if (SHEET_EXTRAS) /* the table is for parts */
            g->length[k] *= (float)job->layer->parts;
    }
}

/* With extras: counts the samples and parts of a group, if requested. */
CVOL_INLINE void count_samples(const line_job *job, int sheets)
{
    if (SHEET_EXTRAS && job->line->multiply_adds)
        *job->line->multiply_adds += (uint64_t)sheets * CVOL_GROUP * CVOL_ADDS_OF_SAMPLE;
}

CVOL_INLINE void count_parts(const group_state *g, const cvol_line *line)
{
    for (int k = 0; SHEET_EXTRAS && line->multiply_adds && k < PARTS; k++)
        *line->multiply_adds += (uint64_t)g->p[k].parts * CVOL_LANES * CVOL_ADDS_OF_PART;
}

/* Pixels of all lines exceed the second-level cache. */
#define AHEAD 3

CVOL_INLINE void prefetch_group(const cvol_line *line, int group)
{
    const float *r = line->values + group * CVOL_GROUP;
    for (int k = 0; k < CVOL_LINES - 1; k++)
        __builtin_prefetch(r + k * line->width, 1);
}

CVOL_INLINE void store_group(const group_state *g, const cvol_line *line, int group, int has_void)
{
    float *r = line->values + group * CVOL_GROUP;
    const int width = line->width;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES) {
        cvol_store(r, g->p[k].r);
        cvol_store(r + width, g->p[k].g);
        cvol_store(r + 2 * width, g->p[k].b);
        cvol_store(r + 3 * width, g->p[k].transmittance);
        cvol_store(r + 4 * width, g->value[k]);
        if (SHEET_EXTRAS && line->depth)
            cvol_store(line->depth + group * CVOL_GROUP + k * CVOL_LANES, g->p[k].half);
        if (has_void)
            cvol_store(r + 5 * width, g->cover[k]);
    }
}

CVOL_INLINE int is_closed(const group_state *g)
{
    cvol_vf most = g->p[0].transmittance;
    for (int k = 1; k < PARTS; k++)
        most = cvol_max(most, g->p[k].transmittance);
    return !any_above(most, OPAQUE_BELOW);
}

/* Takes back an interval, up to slice s, where it belongs to another part. */
CVOL_INLINE void keep_own(pixels *p, const pixels *before, const line_job *job, int s, int i)
{
    const cvol_layer *layer = job->layer;
    if (!layer->part_cuts)
        return;
    const cvol_vi own = find_owned(layer, &layer->sheets[s], i, job->line->number);
    p->r = cvol_select(own, p->r, before->r);
    p->g = cvol_select(own, p->g, before->g);
    p->b = cvol_select(own, p->b, before->b);
    p->transmittance = cvol_select(own, p->transmittance, before->transmittance);
    p->half = cvol_select(own, p->half, before->half);
}

/* The part of an interval within the drawn part: from..to, 0 at its slice and -1 at the one before.
 * near: the part of that which is drawn separately, see composite_within; `even`: with the value at
 * its start. */
typedef struct span {
    cvol_vf from, to, near;
    int even;
} span;

/* For the interval that ends at a slice, for the CVOL_LANES pixels from i on. */
CVOL_INLINE void find_within(span *out, const line_job *job, int s, int i)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const cvol_vf begin = cvol_splat(layer->only ? -0.5f : -1),
                  end = cvol_splat(layer->only ? 0.5f : 0), zero = {0};
    cvol_vf enter, leave;
    find_span(&enter, &leave, layer, &layer->sheets[s], &sheet->view,
              sheet->lane_at + i * sheet->lane_step, i, job->line->number);
    out->from = cvol_min(cvol_max(enter, begin), end);
    out->to = cvol_min(cvol_max(leave, begin), end);
    const cvol_vf near = 0.5f * cvol_min(-enter, 2 + enter);
    out->near = cvol_max(cvol_min(near, out->to - out->from), zero);
    out->even = !SHEET_IMAGE_ORDER || layer->cuts > layer->part_cuts;
}

/* Composites the part of an interval, which ends at a slice of this ordinal, that is inside. For
 * opaque objects only the value at a face is visible. It would differ before and behind a slice,
 * which appears as rings. So half of the inside part of an interval that a face cuts is drawn
 * separately, and in the next interval half of the part that the face left of the one before.
 * Behind a cutting plane, and in object order, these have the value at the face. Image-order rays
 * omit this at the volume's own faces and at a box: a bright sample there would look half a slice
 * thicker, and rays near an edge are short. */
CVOL_COLD void composite_within(pixels *p, const cvol_sheet_table *table, cvol_vf from, cvol_vf to,
                                const span *within, int ordinal, cvol_vf length, int segments)
{
    const sample_parts whole = {.divided = 0};
    const cvol_vf rise = to - from, sheet = cvol_splat((float)ordinal);
    const cvol_vf face = to + within->from * rise;
    const ray_interval at = {sheet + within->from + within->near, sheet + within->to};
    const interval all = {within->even ? face : to + (within->from + within->near) * rise,
                          to + within->to * rise,
                          NULL,
                          NULL,
                          at,
                          NULL,
                          {0},
                          0};
    const cvol_vf rest = within->to - within->from - within->near;
    classified last = classified_at_start(table, face, NULL, 0, segments);
    if (any_above(within->near, MIN_WEIGHT)) {
        const classified next = within->even ? last
                                             : classified_at_start(table, all.a, NULL, 0, segments);
        composite_part(p, &last, &next, whole, (ray_interval){at.from - within->near, at.from},
                       within->near * length, 1);
        last = next;
    }
    composite_from(p, table, &last, &all, rest * length, 1, segments);
}

/* A group that was drawn up to the slice before meets an invisible window: draws the visible part
 * of the interval between the two. If samples there may have no value, only the half near the slice
 * before. */
CVOL_INLINE void draw_end(group_state *g, const line_job *job, int s, int group, int unit,
                          int has_void, int segments)
{
    const sheet_line *sheet = &job->sheets[s];
#if SHEET_IMAGE_ORDER
    const int masked = 0;
    cvol_vf levels[PARTS];
    find_levels(levels, job, s, sheet->windows, group, 0);
    (void)unit;
    (void)has_void;
#else
    const ptrdiff_t x = lane_sample(sheet, group, unit);
    const int masked = has_void && sheet->view.windows[window_of(x)] & CVOL_WINDOW_MASKED;
    const cvol_vf level = to_table(job, cvol_splat(sheet->view.levels[window_of(x)]));
#endif
    for (int k = 0; k < PARTS; k++) {
        const int i = group * CVOL_GROUP + k * CVOL_LANES;
        const pixels before = g->p[k];
#if SHEET_IMAGE_ORDER
        const cvol_vf level = levels[k];
#endif
        const cvol_vf end = masked ? g->value[k] : level;
#if SHEET_IMAGE_ORDER
        if (is_inside(sheet, group)) {
            cvol_vf middle;
            const float ordinal = (float)job->layer->sheets[s].ordinal;
            interval all = {g->value[k], level, NULL, NULL, ray_interval_of(ordinal - 1, ordinal),
                            NULL,        {0},   0};
            look_midpoint(&all, &middle, job, s, group, k, g->p[k].transmittance);
            composite_interval(&g->p[k], job->table, &all, g->length[k], 0, segments);
            keep_own(&g->p[k], &before, job, s, i);
            continue;
        }
#endif
        span within;
        find_within(&within, job, s, i);
        cvol_vf weight = g->length[k];
        if (masked)
            weight *= 0.5f * g->cover[k];
        composite_within(&g->p[k], job->table, g->value[k], end, &within,
                         job->layer->sheets[s].ordinal, weight, segments);
        keep_own(&g->p[k], &before, job, s, i);
    }
}

/* Draws the interval that ends at a slice. known: its start is g->value; else only its second half,
 * or, at the first slice, nothing is within the volume, and it has one value. */
CVOL_INLINE void draw_interval(group_state *g, const line_job *job, int s, int group, int known,
                               int unit, int has_void, int segments)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const double step = sheet->lane_step;
    const ptrdiff_t x = lane_sample(sheet, group, unit);
    const int masked = !SHEET_IMAGE_ORDER && has_void &&
                       sheet->view.windows[window_of(x)] & CVOL_WINDOW_MASKED;
    const int inside = is_inside(sheet, group);
    const int ordinal = layer->sheets[s].ordinal;
    const ray_interval at = ray_interval_of((float)ordinal - (known ? 1 : 0.5f), (float)ordinal);
    const int whole = known && !has_void && !layer->perspective &&
                      !(SHEET_EXTRAS && layer->parts > 1);
    count_samples(job, 1);
    for (int k = 0; k < PARTS; k++) {
        const double position = sheet->lane_at + (group * CVOL_GROUP + k * CVOL_LANES) * step;
        const pixels before = g->p[k];
        cvol_vf cover = cvol_splat(1), value;
#if SHEET_IMAGE_ORDER
        (void)masked;
        (void)x;
        (void)position;
        value = reconstruct_image_order(job, sheet, group * CVOL_GROUP + k * CVOL_LANES);
#else
#if SHEET_EXTRAS
        if (layer->wide)
            value = masked ? reconstruct_widely_masked(&cover, job, sheet, 0, group, k, unit)
                           : reconstruct_widely(job, sheet, sheet->view.near, group, k);
        else
#endif
            if (masked)
            value = unit ? reconstruct_unit_masked(&cover, &sheet->view, &sheet->footprint,
                                                   x + k * CVOL_LANES, layer->cover_at)
                         : reconstruct_finer_masked(&cover, &sheet->view, position, step,
                                                    layer->cover_at);
        else
            value = unit ? reconstruct_unit(&sheet->view, &sheet->footprint, x + k * CVOL_LANES)
                         : reconstruct_finer(&sheet->view, position, step);
#endif
        value = sample_to_table(job, value);
        cvol_vf from = known ? g->value[k] : value, to = value, weight = g->length[k];
        if (has_void) { /* an end without a value takes the other's */
            const cvol_vf cover_before = known ? g->cover[k] : cover;
            to = cvol_select(cover < MIN_WEIGHT, from, value);
            from = cvol_select(cover_before < MIN_WEIGHT, value, from);
            weight *= 0.5f * (cover_before + cover);
            g->cover[k] = cover;
        }
        interval all = {from, to, NULL, NULL, at, NULL, {0}, 0};
#if SHEET_IMAGE_ORDER
        cvol_vf middle;
        if (inside && known)
            look_midpoint(&all, &middle, job, s, group, k, g->p[k].transmittance);
#endif
        if (!inside) {
            span within;
            find_within(&within, job, s, group * CVOL_GROUP + k * CVOL_LANES);
            composite_within(&g->p[k], job->table, from, to, &within, ordinal, weight, segments);
        } else {
            composite_interval(&g->p[k], job->table, &all, known ? weight : 0.5f * weight, !whole,
                               segments);
        }
        keep_own(&g->p[k], &before, job, s, group * CVOL_GROUP + k * CVOL_LANES);
        g->value[k] = value;
    }
}

/* Draws an interval in parts up to slice s. */
CVOL_INLINE void draw_parts(group_state *g, classified *last, const line_job *job, int s, int group,
                            int k, int unit, int lengths, int segments, cvol_vf start, cvol_vf end)
{
    const int parts = job->layer->parts;
    const float ordinal = (float)(job->layer->sheets[0].ordinal + s), step = 1 / (float)parts;
    cvol_vf from = start;
    for (int part = 1; part <= parts; part++) {
        const cvol_vf value = part < parts ? find_between(job, s, part, group, k, unit, start, end)
                                           : end;
        const interval all = {from,
                              value,
                              NULL,
                              NULL,
                              ray_interval_of(ordinal - 1 + (float)(part - 1) * step,
                                              ordinal - 1 + (float)part * step),
                              NULL,
                              {0},
                              0};
        composite_from(&g->p[k], job->table, last, &all, step * g->length[k], lengths, segments);
        from = value;
    }
}

/* The `count` slices from s on: known intervals, whole, whose samples all have a value. First it
 * computes all values and finds the intervals with something visible; then it draws only these. */
CVOL_INLINE void draw_run(group_state *state, int *closed, const line_job *job, int s, int count,
                          int group, int unit, int lengths, int segments)
{
    const cvol_sheet_table *table = job->table;
    cvol_vf values[CVOL_BLOCK_MAX + 1][PARTS];
    uint64_t live = 0;
    count_samples(job, count);
    for (int k = 0; k < PARTS; k++)
        values[0][k] = state->value[k];
    for (int i = 0; i < count; i++)
        for (int k = 0; k < PARTS; k++) {
            const cvol_vf from = values[i][k],
                          to = reconstruct(job, &job->sheets[s + i], group, k, unit);
            values[i + 1][k] = to;
            live |= (uint64_t)any_within(cvol_max(from, to), cvol_min(from, to),
                                         table->visible_from, table->visible_to)
                    << i;
        }
    if (SHEET_EXTRAS && job->layer->parts > 1) /* the ends do not bound values in between */
        live = (UINT64_C(1) << count) - 1;
    for (int k = 0; k < PARTS; k++)
        state->value[k] = values[count][k];
    if (!live)
        return;
    group_state g = *state;
    classified last[PARTS] = {{{{0}}}};
    int next = -1;
    while (live && !*closed) {
        const int i = __builtin_ctzll(live);
        live &= live - 1;
        const float ordinal = (float)(job->layer->sheets[0].ordinal + s + i);
        const ray_interval at = ray_interval_of(ordinal - 1, ordinal);
        for (int k = 0; k < PARTS; k++) {
            if (SHEET_IMAGE_ORDER && PARTS > 1 && !any_above(g.p[k].transmittance, OPAQUE_BELOW))
                continue;
            interval all = {values[i][k], values[i + 1][k], NULL, NULL, at, NULL, {0}, 0};
#if SHEET_IMAGE_ORDER
            cvol_vf middle;
            look_midpoint(&all, &middle, job, s + i, group, k, g.p[k].transmittance);
#endif
            if (i != next)
                last[k] = classified_at_start(table, all.a, NULL, 0, segments);
            if (SHEET_EXTRAS && job->layer->parts > 1)
                draw_parts(&g, &last[k], job, s + i, group, k, unit, lengths, segments, all.a,
                           all.b);
            else
                composite_from(&g.p[k], table, &last[k], &all, g.length[k], lengths, segments);
        }
        next = i + 1;
        *closed = is_closed(&g);
    }
    *state = g;
}

/* The common kinds are compiled separately, for each footprint and form of the table: in parallel
 * projection, and, with AVX-512, with segments. Others, and extras (classify.h), are selected at
 * run time. */
CVOL_INLINE void draw_run_of_kind(group_state *g, int *closed, const line_job *job, int s,
                                  int count, int group, int unit, int lengths, int segments)
{
    enum { USUAL = HAVE_SEGMENTS ? CVOL_SEGMENTS : 0 };
    if (SHEET_EXTRAS || lengths || (HAVE_SEGMENTS && !segments))
        draw_run(g, closed, job, s, count, group, unit, lengths, segments ? CVOL_SEGMENTS : 0);
    else if (segments == CVOL_SEGMENTS_FEW)
        unit ? draw_run(g, closed, job, s, count, group, 1, 0, CVOL_SEGMENTS_FEW)
             : draw_run(g, closed, job, s, count, group, 0, 0, CVOL_SEGMENTS_FEW);
    else
        unit ? draw_run(g, closed, job, s, count, group, 1, 0, USUAL)
             : draw_run(g, closed, job, s, count, group, 0, 0, USUAL);
}

/* Draws one slice of any other kind; *known: 1 if its value was found. */
CVOL_COLD int draw_sheet(group_state *g, const line_job *job, int s, int group, int known, int unit,
                         int has_void, int segments)
{
    float level = 0, spread;
    if (!(job->seen[group - job->first_group] >> s & 1)) {
        if (known)
            draw_end(g, job, s, group, unit, has_void, segments);
        return 0;
    }
#if SHEET_IMAGE_ORDER
    cvol_vf levels[PARTS];
    (void)level;
    (void)spread;
    if (!known && find_levels_before(levels, job, s, group)) {
        known = 1;
        for (int k = 0; k < PARTS; k++) {
            g->value[k] = levels[k];
            g->cover[k] = cvol_splat(1);
        }
        if (s == 0)
            keep_levels_midpoint(job, group);
    }
#else
    if (!known && find_level_before(&level, &spread, job, s, group)) {
        known = 1;
        for (int k = 0; k < PARTS; k++) {
            g->value[k] = cvol_splat(level);
            g->cover[k] = cvol_splat(1);
        }
    }
#endif
    draw_interval(g, job, s, group, known, unit, has_void, segments);
    return 1;
}

/* Draws a group through the slices that it meets. */
CVOL_INLINE void draw_group(const line_job *job, int group, int unit, int has_void, int lengths,
                            int segments)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first_ordinal = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = has_void ? 0 : seen & job->inside[at];
    uint32_t intersected = job->intersected[at];
    int known = line->intersected[group] == first_ordinal - 1;
    if (!seen && !(known && intersected & 1))
        return;
    group_state g;
    load_group(&g, job, group, has_void, lengths);
    int last = line->intersected[group], closed = 0;
    while (intersected && !closed) {
        int s = __builtin_ctz(intersected);
        known = last == first_ordinal + s - 1;
        if (known && go >> s & 1) {
            const int count = __builtin_ctzll(~(go >> s));
            draw_run_of_kind(&g, &closed, job, s, count, group, unit, lengths, segments);
            last = first_ordinal + s + count - 1;
            intersected &= ~UINT32_C(0) << (s + count - 1) << 1;
            continue;
        }
        intersected &= intersected - 1;
        if (draw_sheet(&g, job, s, group, known, unit, has_void, segments))
            last = first_ordinal + s;
        else
            intersected &= from_lowest(intersected & seen); /* nothing visible before */
        closed = is_closed(&g);
    }
    store_group(&g, line, group, has_void);
    count_parts(&g, line);
    if (SHEET_EXTRAS && job->layer->parts > 1 && !closed &&
        last == first_ordinal + job->layer->sheet_count - 1)
        keep_between(job, group, unit);
#if SHEET_IMAGE_ORDER
    if (job->layer->parts == 1 && !closed && last == first_ordinal + job->layer->sheet_count - 1)
        keep_midpoint(job, group);
#endif
    line->intersected[group] = last;
    line->opaque[group] = (uint8_t)closed;
}

CVOL_INLINE void draw_line(line_job *job, int unit, int has_void, int lengths, int segments)
{
    const cvol_layer *layer = job->layer;
    int begin = job->line->width / CVOL_GROUP, end = 0;
#if SHEET_IMAGE_ORDER
    view_image_order(job);
#endif
    for (int s = 0; s < layer->sheet_count; s++) {
#if !SHEET_IMAGE_ORDER
        view_sheet(&job->sheets[s], job, &layer->sheets[s], unit);
#endif
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
#if SHEET_EXTRAS
    between_views between;
    job->between = &between;
    if (layer->parts > 1 && begin < end)
        view_between(&between, job, unit);
#endif
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
#if SHEET_IMAGE_ORDER
        find_intersected_image_order(job, first, count);
#else
        find_intersected(job, first, count, unit);
#endif
        for (int group = first; group < first + count; group++) {
            const int ahead = group + AHEAD;
            if (ahead < first + count && job->seen[ahead - first] && !job->line->opaque[ahead])
                prefetch_group(job->line, ahead);
            if (!job->line->opaque[group])
                draw_group(job, group, unit, has_void, lengths, segments);
        }
    }
}

#endif
