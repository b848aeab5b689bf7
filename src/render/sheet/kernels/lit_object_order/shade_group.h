/* A group of lit pixels while it is drawn (shade.h): its pending interval, and its storage in a
 * line from layer to layer.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_GROUP_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_OBJECT_ORDER_SHADE_GROUP_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/between.h"
#include "render/sheet/kernels/composite/reach.h"
#include "render/sheet/kernels/composite/slope.h"

/* The source of the value next to the end of a pending interval, in the slice before or behind. */
enum {
    KNOWN = 0,
    CONTINUED, /* extrapolated from the other side */
    BOUNDED,   /* the same, clamped to a range */
    AT_FACE    /* no more samples: the value at the end itself */
};

/* A value next to the end. */
typedef struct end_neighbour {
    int edge;
    float level, spread; /* if it is bounded */
    cvol_vf value[PARTS], cover[PARTS];
} end_neighbour;

/* A group while it is drawn. For a pending interval: */
typedef struct shade_state {
    pixels p[PARTS];
    cvol_vf value[PARTS], cover[PARTS];         /* at its end */
    cvol_vf before[PARTS], cover_before[PARTS]; /* at its start */
    lit_sample lit[PARTS];                      /* at its start, */
    int is_lit;                                 /* if it is known */
    cvol_vf weight[PARTS];
    int pending, weighted, visible;
    classified last[PARTS]; /* at its start, */
    int has_last;           /* if it is known */
    int end;                /* the ordinal of the slice at its end */
    int divided;            /* an extra: samples between its ends are known */
#if SHEET_EXTRAS
    cvol_vf between[CVOL_PARTS - 1][PARTS];
#endif
    cvol_vf
        length[PARTS]; /* of an interval, relative to that of the table: in perspective, else 1 */
    /* If its end is in an earlier layer, or the first slice of this one: */
    slope slope[PARTS];
    end_neighbour behind;                     /* in the slice before its end */
    cvol_vf ahead[PARTS], cover_ahead[PARTS]; /* its end's slice, at the position of the next one */
} shade_state;

/* Moves one vector from or to a line. */
CVOL_INLINE void move(cvol_vf *v, float *at, int store)
{
    if (store)
        cvol_store(at, *v);
    else
        *v = cvol_load(at);
}

/* Loads or stores a group; its pending interval only if there is one. */
CVOL_INLINE void move_group(shade_state *g, const line_job *job, int group, int has_void, int store)
{
    const cvol_line *line = job->line;
    const ptrdiff_t width = line->width;
    float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES, s += CVOL_LANES) {
        move(&g->p[k].r, r, store);
        move(&g->p[k].g, r + width, store);
        move(&g->p[k].b, r + 2 * width, store);
        move(&g->p[k].transmittance, r + 3 * width, store);
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

/* Returns 1 if pixels that are not yet opaque see any part of an interval. */
CVOL_INLINE int sees(const line_job *job, cvol_vf transmittance, cvol_vf a, cvol_vf b)
{
    const cvol_vf most = cvol_max(a, b), least = cvol_min(a, b);
    const float from = job->table->visible_from, to = job->table->visible_to;
#if defined(__AVX512F__)
    const __mmask16 open = _mm512_cmp_ps_mask((__m512)transmittance, _mm512_set1_ps(OPAQUE_BELOW),
                                              _CMP_GT_OQ),
                    above = _mm512_mask_cmp_ps_mask(open, (__m512)most, _mm512_set1_ps(from),
                                                    _CMP_GE_OQ);
    return _mm512_mask_cmp_ps_mask(above, (__m512)least, _mm512_set1_ps(to), _CMP_LE_OQ) != 0;
#else
    return cvol_any((transmittance > OPAQUE_BELOW) & (most >= from) & (least <= to));
#endif
}

CVOL_INLINE int is_visible(const line_job *job, const pixels p[PARTS], const cvol_vf a[PARTS],
                           const cvol_vf b[PARTS])
{
    int visible = 0;
    for (int k = 0; k < PARTS; k++)
        visible |= sees(job, p[k].transmittance, a[k], b[k]);
    return visible;
}

CVOL_INLINE void load_group(shade_state *g, const line_job *job, int group, int has_void,
                            int lengths)
{
    const cvol_line *line = job->line;
    g->pending = line->intersected[group] != INT32_MIN;
    g->end = line->intersected[group];
    g->is_lit = g->visible = g->has_last = 0;
    g->weighted = 1;
    g->behind.edge = KNOWN;
    g->behind.level = g->behind.spread = 0;
    for (int k = 0; k < PARTS; k++)
        g->length[k] = lengths ? find_lengths(job, group * CVOL_GROUP + k * CVOL_LANES)
                               : cvol_splat(1);
    for (int k = 0; k < PARTS && SHEET_EXTRAS; k++) /* the table is for parts */
        g->length[k] *= (float)job->layer->parts;
    g->divided = 0;
    move_group(g, job, group, has_void, 0);
    if (!g->pending)
        return;
    g->behind.edge = line->edges[group] & 3;
    g->is_lit = line->edges[group] >> 2 & 1;
    g->divided = line->edges[group] >> 3;
    g->visible = is_visible(job, g->p, g->before, g->value);
    for (int k = 0; k < PARTS; k++) /* it is not stored */
        g->lit[k].reach = g->is_lit && job->table->interpolates_gradients
                              ? reach_of_pixels(job, g->end - job->layer->sheets[0].ordinal - 1,
                                                group * CVOL_GROUP + k * CVOL_LANES)
                              : cvol_splat(1);
    if (g->behind.edge == BOUNDED) { /* the extrapolated value */
        const float *range = line->pending + 7 * (ptrdiff_t)line->width + group * CVOL_GROUP;
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
        float *range = line->pending + 7 * (ptrdiff_t)line->width + group * CVOL_GROUP;
        range[0] = g->behind.level;
        range[1] = g->behind.spread;
    }
}

/* Pixels of all lines exceed the second-level cache. */
#define AHEAD 3

CVOL_INLINE void prefetch_group(const line_job *job, int group)
{
    const cvol_line *line = job->line;
    const ptrdiff_t width = line->width;
    const int pending = line->intersected[group] != INT32_MIN;
    if (line->opaque[group] || !(pending || job->seen[group - job->first_group]))
        return;
    const float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    for (int k = 0; k < 5; k++)
        __builtin_prefetch(r + k * width, 1);
    for (int k = 0; k < CVOL_PENDING_LINES_PLAIN && pending; k++)
        __builtin_prefetch(s + k * width, 1);
}

CVOL_INLINE int is_closed(const shade_state *g)
{
    cvol_vf most = g->p[0].transmittance;
    for (int k = 1; k < PARTS; k++)
        most = cvol_max(most, g->p[k].transmittance);
    return !any_above(most, OPAQUE_BELOW);
}

#endif
