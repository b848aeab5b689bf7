/* Intervals between two slices whose ends have gradients, in image order (shade.h).
 *
 * Gradients, not light, are interpolated, and every classified sample is lit. Along a ray that
 * crosses cells obliquely neither samples nor gradients are linear: in a divided interval,
 * midpoints of both are computed, too.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_INTERVAL_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_INTERVAL_H

#include "render/sheet/kernels/classify.h"
#include "render/view/phong.h"

/* The largest span of an interval, relative to the table's flat interval, before it is divided:
 * light varies more than colour and opacity. */
#define HALVES_OF_FLAT 0.5f
#define QUARTERS_OF_FLAT 4.0f
#define EIGHTHS_OF_FLAT 16.0f
/* The weight of a span is the mean opacity times 4, at most 1. For quarters and eighths it is at
 * least MIN_OF_QUARTERS, for halves at least a tenth. */
#define OPACITY_COUNTS 2.0f
#define MIN_OF_QUARTERS 0.25f
/* How fast the weight of a sample that divides a part rises with these measures: to 1 at 3/2 of the
 * limits. */
#define DIVISION_RAMP 2
/* Added to the limit of the change of light, which may be 0. */
#define LEAST_CHANGE 1e-6f

/* The gradient of a value, along the light's axes, and the light there. */
typedef struct gradient {
    cvol_vf v[3];
    cvol_vf reach; /* the part of the light that reaches its place */
} gradient;

/* An interval's ends, and, if there is one, its middle. */
typedef struct lit_interval {
    cvol_vf a, b, middle;
    gradient from, to, half;
} lit_interval;

CVOL_INLINE gradient mix_gradients(const gradient *a, const gradient *b, cvol_vf t)
{
    gradient out;
    for (int k = 0; k < 3; k++)
        out.v[k] = a->v[k] + t * (b->v[k] - a->v[k]);
    out.reach = a->reach + t * (b->reach - a->reach);
    return out;
}

CVOL_INLINE gradient select_gradient(cvol_vi mask, const gradient *a, const gradient *b)
{
    gradient out;
    for (int k = 0; k < 3; k++)
        out.v[k] = cvol_select(mask, a->v[k], b->v[k]);
    out.reach = b->reach; /* each place has its own */
    return out;
}

/* Finds the pixels without a gradient. */
CVOL_INLINE cvol_vi find_level_pixels(const gradient *g)
{
    const cvol_vi any = (cvol_vi)g->v[0] | (cvol_vi)g->v[1] | (cvol_vi)g->v[2];
    return (any & INT32_MAX) == 0;
}

/* An end without a gradient takes the other's. */
CVOL_INLINE void take_other_gradient(gradient *a, gradient *b)
{
    const cvol_vi no_a = find_level_pixels(a), no_b = find_level_pixels(b);
    if (!cvol_any(no_a | no_b))
        return;
    const gradient first = *a;
    *a = select_gradient(no_a, b, a);
    *b = select_gradient(no_b, &first, b);
}

/* Light may reduce the density, if the table says so. Samples without opacity need no light. */
CVOL_INLINE classified classified_of_gradient(const cvol_sheet_table *table, cvol_vf t,
                                              const gradient *at, int segments)
{
    classified m = classified_of(table, t, NULL, segments);
    if (!any_above(m.v[3], 0))
        return m;
    lit_sample lit = illuminate(at->v, table->light);
    lit.factor *= at->reach;
    lit.gloss *= at->reach;
    if (table->light->thinning > 0) {
        const cvol_vf share = weight_share(cvol_splat(1), m.v[3], lit.thickness);
        for (int k = 0; k < 4; k++)
            m.v[k] *= share;
    }
    for (int k = 0; k < 3; k++)
        m.v[k] = m.v[k] * lit.factor + m.v[3] * lit.gloss;
    return m;
}

/* The weights of the samples that divide intervals into halves, these into quarters, and these into
 * eighths; the pixels that have them; and the pixels that draw their interval by parts at all: the
 * others use integrals. */
typedef struct lit_parts {
    cvol_vf weight[3];
    cvol_vi divided[3], drawn;
    int most;
} lit_parts;

/* The measures by which an interval is divided. */
typedef struct lit_change {
    cvol_vf span;  /* of its values. The less visible it is, the less its light matters */
    cvol_vf light; /* the visible change of colour and opacity between its lit ends */
} lit_change;

CVOL_INLINE lit_change find_change(cvol_vf span, const classified *from, const classified *to,
                                   cvol_vf transmittance)
{
    const cvol_vf opacity = OPACITY_COUNTS * (from->v[3] + to->v[3]);
    cvol_vf most = {0};
    for (int k = 0; k < 4; k++)
        most = cvol_max(most, cvol_max(from->v[k] - to->v[k], to->v[k] - from->v[k]));
    return (lit_change){span *
                            cvol_max(cvol_min(opacity, cvol_splat(1)), cvol_splat(HALVES_OF_FLAT)),
                        most * transmittance};
}

/* The weight of the samples that divide a part, k 0: into halves, 1: quarters, 2: eighths. Light
 * may change along an interval whose value hardly does: where the gradient turns, in noise and on
 * thin skin. So that change counts, too. The weight rises from 0 on, or rounding would decide which
 * pixels have these samples. */
CVOL_INLINE cvol_vf weigh_division(const cvol_sheet_table *table, int k, cvol_vf span,
                                   cvol_vf light)
{
    const float limits[3] = {HALVES_OF_FLAT, QUARTERS_OF_FLAT, EIGHTHS_OF_FLAT};
    const float of_light = (float)(1 << k) * (table->light_change + LEAST_CHANGE);
    const cvol_vf measure = cvol_max(span * (1 / (limits[k] * table->flat)),
                                     light * (1 / of_light));
    return cvol_max(cvol_min((measure - 1) * DIVISION_RAMP, cvol_splat(1)), cvol_splat(0));
}

/* The weight of an interval's midpoint; 0 for pixels that do not see the interval. */
CVOL_INLINE cvol_vf weigh_halves(const cvol_sheet_table *table, const lit_interval *i,
                                 const lit_change *change)
{
    const cvol_vi visible = (cvol_max(i->a, i->b) >= table->visible_from) &
                            (cvol_min(i->a, i->b) <= table->visible_to);
    const cvol_vf weight = table->midpoints ? cvol_splat(1)
                                            : weigh_division(table, 0, change->span, change->light);
    return (cvol_vf)((cvol_vi)weight & visible);
}

/* Composites a part with the given transmittance and its share of the transmittance so far. Its
 * begin is more visible than its end, and light makes them differ: the start's weight exceeds a
 * half by 4/3 of the excess of its first half's share over a half, within 0.03 at opacity 1. */
CVOL_INLINE void add_lit_part(pixels *p, const classified *from, const classified *to,
                              cvol_vf share, cvol_vf transmittance)
{
    const cvol_vf first = 1.0f / 6 + (2.0f / 3) * half_share(&transmittance);
    const cvol_vf near = share * first, far = share - near;
    p->r += near * from->v[0] + far * to->v[0];
    p->g += near * from->v[1] + far * to->v[1];
    p->b += near * from->v[2] + far * to->v[2];
    p->transmittance -= 0.5f * share * (from->v[3] + to->v[3]);
}

CVOL_INLINE cvol_vf transmittance_between(const classified *from, const classified *to)
{
    return cvol_max(1 - 0.5f * (from->v[3] + to->v[3]), cvol_splat(1e-12f));
}

/* For the pixels of a mask. */
CVOL_INLINE void composite_lit_part(pixels *p, classified *last, const classified *to,
                                    const lit_parts *parts, cvol_vi mask)
{
    cvol_vf transmittance = transmittance_between(last, to), share = p->transmittance;
    for (int k = 0; 2 << k <= parts->most; k++) {
        cvol_vf half = transmittance;
        share = cvol_select(parts->divided[k], share * half_share(&half), share);
        transmittance = cvol_select(parts->divided[k], half, transmittance);
    }
    add_lit_part(p, last, to, (cvol_vf)((cvol_vi)share & mask), transmittance);
    replace_classified(last, mask, to);
}

/* The division of a whole interval with a middle, which has this weight. */
CVOL_INLINE lit_parts find_parts(const lit_interval *i, const cvol_sheet_table *table,
                                 const classified *last, const classified *end,
                                 cvol_vf transmittance, cvol_vf weight)
{
    const cvol_vf most = cvol_max(cvol_max(i->a, i->b), i->middle),
                  least = cvol_min(cvol_min(i->a, i->b), i->middle);
    const cvol_vf span = (most - least) * transmittance;
    const lit_change change = find_change(span, last, end, transmittance);
    const cvol_vf finer = cvol_max(change.span, span * MIN_OF_QUARTERS);
    lit_parts parts = {.weight = {weight}, .drawn = ~(cvol_vi){0}, .most = 2};
    for (int k = 1; k < 3; k++) {
        parts.weight[k] = cvol_min(parts.weight[k - 1],
                                   weigh_division(table, k, finer, change.light));
        if (any_above(parts.weight[k], 0))
            parts.most = 2 << k;
    }
    if (table->interpolates_gradients)
        parts.weight[0] = cvol_splat(1);
    if (any_above(span, table->integrated))
        parts.drawn = (span <= table->integrated) | (weight < 1);
    for (int k = 0; k < 3; k++)
        parts.divided[k] = (parts.weight[k] > 0) & parts.drawn;
    return parts;
}

/* Weighs a sample against the mean of two others. */
CVOL_INLINE void weigh_classified(classified *m, const classified *from, const classified *to,
                                  cvol_vf weight)
{
    for (int k = 0; k < 4; k++) {
        const cvol_vf straight = 0.5f * (from->v[k] + to->v[k]);
        m->v[k] = straight + weight * (m->v[k] - straight);
    }
}

/* The classified samples of an interval in eighths, 0 and 8 at its ends, which are known. */
CVOL_INLINE void classify_parts(classified at[9], const cvol_sheet_table *table,
                                const lit_interval *i, const lit_parts *parts, int segments)
{
    for (int k = 0, half = 4; 2 << k <= parts->most; k++, half /= 2)
        for (int part = half; part < 8; part += 2 * half) {
            const int late = part >= 4;
            const cvol_vf t = cvol_splat((float)(part & 3) / 4);
            const cvol_vf from = late ? i->middle : i->a, to = late ? i->b : i->middle;
            const gradient rise = part == 4 ? i->half
                                  : late    ? mix_gradients(&i->half, &i->to, t)
                                            : mix_gradients(&i->from, &i->half, t);
            at[part] = classified_of_gradient(table, from + t * (to - from), &rise, segments);
            weigh_classified(&at[part], &at[part - half], &at[part + half], parts->weight[k]);
        }
}

/* Draws these parts one after the other. *last: the classified sample at the interval's start;
 * becomes that at its end. */
CVOL_INLINE void composite_parts(pixels *p, const cvol_sheet_table *table, classified *last,
                                 const classified *end, const lit_interval *i,
                                 const lit_parts *parts, int segments)
{
    const int step = 8 / parts->most;
    classified at[9];
    at[0] = *last;
    at[8] = *end;
    classify_parts(at, table, i, parts, segments);
    for (int part = step; part < 8; part += step)
        composite_lit_part(p, last, &at[part], parts,
                           parts->divided[part == 4  ? 0
                                          : part & 1 ? 2
                                                     : 1]);
    composite_lit_part(p, last, end, parts, parts->drawn);
    *last = *end;
}

/* Draws an interval by the integrals of the transfer function (integrate.h), for the pixels of a
 * mask; each part is lit in its middle. A separate function: few intervals need it. */
CVOL_COLD void composite_lit_integrals(pixels *p, const cvol_sheet_table *table,
                                       const lit_interval *i, cvol_vi mask)
{
    table_integral ends[2];
    cvol_vf transmittance = (cvol_vf)((cvol_vi)p->transmittance & mask);
    const cvol_vf before = transmittance, weight = cvol_splat(1.0f / INTEGRATED_PARTS);
    find_integral(&ends[0], table, i->a);
    for (int part = 1; part <= INTEGRATED_PARTS; part++) {
        const float place = 2 * (float)part / INTEGRATED_PARTS,
                    centre = place - 1.0f / INTEGRATED_PARTS;
        const int late = place > 1;
        const cvol_vf t = cvol_splat(late ? place - 1 : place),
                      middle = cvol_splat(late ? centre - 1 : centre);
        const cvol_vf begin = late ? i->middle : i->a, end = late ? i->b : i->middle;
        const gradient at = late ? mix_gradients(&i->half, &i->to, middle)
                                 : mix_gradients(&i->from, &i->half, middle);
        cvol_vf mean[4], passed;
        find_integral(&ends[part & 1], table, begin + t * (end - begin));
        find_mean(mean, table, &ends[(part - 1) & 1], &ends[part & 1]);
        lit_sample lit = illuminate(at.v, table->light);
        lit.factor *= at.reach;
        lit.gloss *= at.reach;
        if (table->light->thinning > 0)
            for (int k = 0; k < 4; k++)
                mean[k] *= lit.thickness;
        const cvol_vf share = transmittance * weight * absorbed_share(&passed, weight * mean[3]);
        p->r += share * (mean[0] * lit.factor + mean[3] * lit.gloss);
        p->g += share * (mean[1] * lit.factor + mean[3] * lit.gloss);
        p->b += share * (mean[2] * lit.factor + mean[3] * lit.gloss);
        transmittance *= passed;
    }
    p->transmittance += transmittance - before;
}

/* Part of an interval, linear, in four parts: at faces, and where it begins or ends unseen. */
CVOL_COLD void composite_weighted(pixels *p, const cvol_sheet_table *table, const lit_interval *i,
                                  cvol_vf weight, int segments)
{
    const sample_parts whole = {.divided = 0};
    classified last = classified_of_gradient(table, i->a, &i->from, segments);
    for (int part = 1; part <= 4; part++) {
        const cvol_vf t = cvol_splat((float)part / 4);
        const gradient at = mix_gradients(&i->from, &i->to, t);
        const classified m = classified_of_gradient(table, i->a + t * (i->b - i->a), &at, segments);
        composite_part(p, &last, &m, whole, (ray_interval){t, t}, 0.25f * weight, 1);
        last = m;
    }
}

#endif
