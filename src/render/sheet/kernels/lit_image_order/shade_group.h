/* A group of lit pixels while it is drawn in image order (shade.h): its pending interval, and its
 * storage in a line from layer to layer.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_GROUP_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_GROUP_H

#include "render/sheet/kernels/composite/line.h"
#include "render/sheet/kernels/lit_image_order/shade_interval.h"

/* A group while it is drawn; for its pending interval: */
typedef struct lit_group {
    pixels p;
    cvol_vf before, value; /* at its start, and at its end */
    gradient from;         /* at its start, */
    int has_from;          /* if it is known */
    cvol_vf weight;        /* if it is not whole */
    int pending, weighted, visible;
    classified last; /* at its start, */
    int has_last;    /* if it is known */
    /* If its end is in an earlier layer, or the first slice of this one: */
    cvol_vf slope[2];
    cvol_vf behind; /* in the slice before its end, */
    cvol_vf ahead;  /* and in its end's slice, at the position of the next one */
} lit_group;

/* ---- storage in lines ------------------------------------------------------------------------ */

/* Flags of a part in `edges`. */
#define PART_FLAGS 2
#define HAS_FROM 1
#define WEIGHTED 2

CVOL_INLINE void load_group(lit_group *g, const cvol_line *line, int group, int part, int pending)
{
    const ptrdiff_t width = line->width, i = group * CVOL_GROUP + part * CVOL_LANES;
    const float *r = line->values + i, *s = line->pending + i;
    g->p = (pixels){cvol_load(r),
                    cvol_load(r + width),
                    cvol_load(r + 2 * width),
                    cvol_load(r + 3 * width),
                    {0},
                    0};
    g->pending = pending;
    g->has_from = g->has_last = g->visible = 0;
    g->weighted = 1;
    if (!g->pending)
        return;
    g->value = cvol_load(r + 4 * width);
    cvol_vf *const kept[] = {&g->before,   &g->from.v[0], &g->from.v[1], &g->from.v[2], &g->weight,
                             &g->slope[0], &g->slope[1],  &g->behind,    &g->ahead};
    for (int n = 0; n < CVOL_PENDING_LINES_PLAIN; n++)
        *kept[n] = cvol_load(s + n * width);
    g->has_from = line->edges[group] >> PART_FLAGS * part & HAS_FROM;
    g->weighted = line->edges[group] >> PART_FLAGS * part & WEIGHTED;
}

/* Pixels of all lines exceed the second-level cache. */
#define AHEAD 3

/* Groups from `end` on are not known to be seen. */
CVOL_INLINE void prefetch_group(const line_job *job, int group, int end)
{
    const cvol_line *line = job->line;
    const ptrdiff_t width = line->width;
    if ((group + 1) * CVOL_GROUP > width || line->opaque[group] ||
        !(line->intersected[group] != INT32_MIN ||
          (group < end && job->seen[group - job->first_group])))
        return;
    const float *r = line->values + group * CVOL_GROUP, *s = line->pending + group * CVOL_GROUP;
    for (int k = 0; k < 5; k++)
        __builtin_prefetch(r + k * width, 1);
    for (int k = 0; k < CVOL_PENDING_LINES_PLAIN && line->intersected[group] != INT32_MIN; k++)
        __builtin_prefetch(s + k * width, 1);
}

CVOL_INLINE void store_group(const lit_group *g, const cvol_line *line, int group, int part)
{
    const ptrdiff_t width = line->width, i = group * CVOL_GROUP + part * CVOL_LANES;
    float *r = line->values + i, *s = line->pending + i;
    cvol_store(r, g->p.r);
    cvol_store(r + width, g->p.g);
    cvol_store(r + 2 * width, g->p.b);
    cvol_store(r + 3 * width, g->p.transmittance);
    if (!g->pending)
        return;
    cvol_store(r + 4 * width, g->value);
    const cvol_vf *const kept[] = {&g->before,    &g->from.v[0], &g->from.v[1],
                                   &g->from.v[2], &g->weight,    &g->slope[0],
                                   &g->slope[1],  &g->behind,    &g->ahead};
    for (int n = 0; n < CVOL_PENDING_LINES_PLAIN; n++)
        cvol_store(s + n * width, *kept[n]);
    const int flags = (g->has_from ? HAS_FROM : 0) | (g->weighted ? WEIGHTED : 0),
              others = line->edges[group] & ~((HAS_FROM | WEIGHTED) << PART_FLAGS * part);
    line->edges[group] = (uint8_t)(others | flags << PART_FLAGS * part);
}

CVOL_INLINE int is_closed(const lit_group *g)
{
    return !any_above(g->p.transmittance, OPAQUE_BELOW);
}

/* Returns 1 if pixels that are not yet opaque see any part of an interval. */
CVOL_INLINE int is_visible(const line_job *job, cvol_vf transmittance, cvol_vf a, cvol_vf b)
{
#if defined(__AVX512F__)
    const __mmask16 open = _mm512_cmp_ps_mask((__m512)transmittance, _mm512_set1_ps(OPAQUE_BELOW),
                                              _CMP_GT_OQ),
                    above = _mm512_mask_cmp_ps_mask(open, (__m512)cvol_max(a, b),
                                                    _mm512_set1_ps(job->table->visible_from),
                                                    _CMP_GE_OQ);
    return _mm512_mask_cmp_ps_mask(above, (__m512)cvol_min(a, b),
                                   _mm512_set1_ps(job->table->visible_to), _CMP_LE_OQ) != 0;
#else
    return cvol_any((transmittance > OPAQUE_BELOW) & (cvol_max(a, b) >= job->table->visible_from) &
                    (cvol_min(a, b) <= job->table->visible_to));
#endif
}

#endif
