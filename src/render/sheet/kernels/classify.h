/* Classification of samples by the table of a frame (cvol_sheet_table), and compositing of the
 * classified samples.
 *
 * With AVX-512, permutations look up the segments of the table: a coordinate's bin gives the first
 * segment to test, and at most two steps lead to its own. Without AVX-512, or if a function does
 * not fit into the segments, entries are gathered.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_CLASSIFY_H
#define CVOL_RENDER_SHEET_KERNELS_CLASSIFY_H

#include "render/sheet/frame/frame.h"
#include "render/sheet/kernels/integrate.h"
#include "render/view/phong.h"

#if defined(__AVX512F__)
#define HAVE_SEGMENTS 1
#else
#define HAVE_SEGMENTS 0
#endif

/* Kernels are compiled twice: without extras, and with extras, which arguments select at run
 * time. */
#ifndef SHEET_EXTRAS
#define SHEET_EXTRAS 0
#endif

/* A group whose transmittance is below this in every pixel is finished: samples behind it change no
 * channel by more than half a step of 255. */
#define OPAQUE_BELOW (1.0f / 512)

/* The composite of CVOL_LANES pixels: premultiplied colour and the transmittance 1 - A. half, an
 * extra: the place where A passes one half. */
typedef struct pixels {
    cvol_vf r, g, b, transmittance, half;
    int parts; /* number of composited parts: counted with extras only */
} pixels;

/* Start and end of an interval or a part of it, in slices in the order of rays; used for extras
 * only. */
typedef struct ray_interval {
    cvol_vf from, to;
} ray_interval;

CVOL_INLINE ray_interval ray_interval_of(float from, float to)
{
    return (ray_interval){cvol_splat(from), cvol_splat(to)};
}

/* After a part, before which the transmittance was `before`. */
CVOL_INLINE void find_half(pixels *p, cvol_vf before, ray_interval at)
{
    if (!SHEET_EXTRAS)
        return;
    const cvol_vi passed = (before > 0.5f) & (p->transmittance <= 0.5f);
    if (!cvol_any(passed))
        return;
    const cvol_vf t = (before - 0.5f) / cvol_max(before - p->transmittance, cvol_splat(1e-20f));
    p->half = cvol_select(passed, at.from + t * (at.to - at.from), p->half);
}

/* Pixels that take a sample, and among them the pixels that take it for a half or a quarter of the
 * interval. */
typedef struct sample_parts {
    cvol_vi midpoints, quarters, mask;
    int divided; /* known at compile time: if any of the three is used */
} sample_parts;

/* Returns 1 if a lane of v is above a limit. */
CVOL_INLINE int any_above(cvol_vf v, float limit)
{
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)v, _mm512_set1_ps(limit), _CMP_GT_OQ) != 0;
#else
    return cvol_any(v > limit);
#endif
}

/* Returns 1 if a range least .. most overlaps from .. to. */
CVOL_INLINE int any_within(cvol_vf most, cvol_vf least, float from, float to)
{
#if defined(__AVX512F__)
    const __mmask16 above = _mm512_cmp_ps_mask((__m512)most, _mm512_set1_ps(from), _CMP_GE_OQ);
    return _mm512_mask_cmp_ps_mask(above, (__m512)least, _mm512_set1_ps(to), _CMP_LE_OQ) != 0;
#else
    return cvol_any((most >= from) & (least <= to));
#endif
}

CVOL_INLINE cvol_vf table_clamp(cvol_vf t)
{
    return cvol_min(cvol_max(t, cvol_splat(0)), cvol_splat(CVOL_TABLE_SIZE - 1));
}

/* v^w for v in 0..1 and w from 0 on: 2^(w log2 v), each by a polynomial; 1 if v is 1, within 2e-5
 * otherwise. */
CVOL_INLINE cvol_vf raise_to(cvol_vf v, cvol_vf w)
{
    const cvol_vi bits = (cvol_vi)cvol_max(v, cvol_splat(1e-30f));
    const cvol_vf mantissa = (cvol_vf)((bits & 0x7fffff) | 0x3f800000), m = mantissa - 1;
    const cvol_vf log2_m = m * (1.4425532f +
                                m * (-0.7182822f +
                                     m * (0.4582724f +
                                          m * (-0.2795419f + m * (0.1234555f + m * -0.0264590f)))));
    const cvol_vf log2_x = cvol_to_float((bits >> 23) - 127) + log2_m;
    const cvol_vf y = cvol_min(cvol_max(w * log2_x, cvol_splat(-100)), cvol_splat(0));
    const cvol_vi whole = cvol_to_int(y + 128) - 128;
    const cvol_vf t = y - cvol_to_float(whole);
    const cvol_vf part = 1 +
                         t * (0.6930186f + t * (0.2414452f + t * (0.0519512f + t * 0.0135808f)));
    return (cvol_vf)((cvol_vi)part + (whole << 23));
}

/* 1 - (1 - a)^w, divided by a. A separate function: it has many callers, and few intervals need it.
 */
static __attribute__((noinline)) cvol_vf share_of_part(cvol_vf a, cvol_vf w)
{
    const cvol_vf little = w * (1 + (1 - w) * a * (0.5f + (2 - w) * a * (1.0f / 6)));
    return cvol_select(a < 0.02f, little,
                       (1 - raise_to(1 - a, w)) / cvol_max(a, cvol_splat(0.01f)));
}

CVOL_INLINE cvol_vf weight_share(cvol_vf share, cvol_vf opacity, cvol_vf weight)
{
    const cvol_vi some = weight >= 1e-4f, all = weight == 1;
    share = (cvol_vf)((cvol_vi)share & some);
    if (!cvol_any(some & ~all))
        return share;
    return cvol_select(all, share, share * share_of_part(opacity, weight));
}

/* A classified sample over the distance of two slices: colour times opacity, and opacity. */
typedef struct classified {
    cvol_vf v[4];
} classified;

CVOL_INLINE classified classified_of_entry(const cvol_sheet_table *table, cvol_vf t)
{
    cvol_vf opacity;
    cvol_vi colour;
    cvol_lookup(&opacity, &colour, table->entries, cvol_to_int(table_clamp(t)));
    const cvol_vf share = opacity * (1.0f / 1023);
    return (classified){{share * cvol_to_float(colour & 1023),
                         share * cvol_to_float((colour >> 10) & 1023),
                         share * cvol_to_float(colour >> 20), opacity}};
}

#if HAVE_SEGMENTS
/* With `segments` segments at most: CVOL_SEGMENTS_FEW fit into one register. */
CVOL_INLINE cvol_vf segment_value(const float values[CVOL_SEGMENTS], __m512i segment, int segments)
{
    if (segments == CVOL_SEGMENTS_FEW)
        return (cvol_vf)_mm512_permutexvar_ps(segment, _mm512_load_ps(values));
    return (cvol_vf)_mm512_permutex2var_ps(_mm512_load_ps(values), segment,
                                           _mm512_load_ps(values + 16));
}

CVOL_INLINE __m512i next_segment(const cvol_sheet_table *table, __m512i segment, cvol_vf t,
                                 int segments)
{
    const __mmask16 beyond = _mm512_cmp_ps_mask(
        (__m512)t, (__m512)segment_value(table->segment_end, segment, segments), _CMP_GE_OQ);
    return _mm512_mask_add_epi32(segment, beyond, segment, _mm512_set1_epi32(1));
}

CVOL_INLINE classified classified_of_segment(const cvol_sheet_table *table, cvol_vf t, int segments)
{
    /* Entries lie in the middle of their coordinates. */
    t = cvol_min(cvol_max(t, cvol_splat(0.5f)), cvol_splat(CVOL_TABLE_SIZE - 0.5f));
    const __m512i bin = _mm512_srli_epi32(_mm512_cvttps_epi32((__m512)t), CVOL_SEGMENT_BIN_LOG2);
    /* The bin is in the lower half of each word; the result of the upper half is ignored. */
    __m512i segment = _mm512_permutex2var_epi16(_mm512_load_si512(table->segment_of), bin,
                                                _mm512_load_si512(table->segment_of + 32));
    segment = _mm512_and_si512(segment, _mm512_set1_epi32(CVOL_SEGMENTS - 1));
    segment = next_segment(table, segment, t, segments);
    if (segments != CVOL_SEGMENTS_FEW) /* with few segments no two end in the same bin */
        segment = next_segment(table, segment, t, segments);
    classified m;
    for (int k = 0; k < 4; k++)
        m.v[k] = segment_value(table->segment_start[k], segment, segments) +
                 t * segment_value(table->segment_rise[k], segment, segments);
    return m;
}
#endif

/* Light may reduce the density, if the table says so. */
CVOL_INLINE void light_classified(classified *m, const cvol_sheet_table *table,
                                  const lit_sample *lit)
{
    if (table->light->thinning > 0) {
        const cvol_vf share = weight_share(cvol_splat(1), m->v[3], lit->thickness);
        for (int k = 0; k < 4; k++)
            m->v[k] *= share;
    }
    for (int k = 0; k < 3; k++)
        m->v[k] = m->v[k] * lit->factor + m->v[3] * lit->gloss;
}

/* Lights a gradient that is stored in place of light. */
CVOL_INLINE lit_sample light_of_gradient(const lit_sample *at, const cvol_light *light)
{
    const cvol_vf gradient[3] = {at->factor, at->gloss, at->thickness};
    lit_sample lit = illuminate(gradient, light);
    lit.factor *= at->reach;
    lit.gloss *= at->reach;
    return lit;
}

/* `lit` NULL: no light. */
CVOL_INLINE classified classified_of(const cvol_sheet_table *table, cvol_vf t,
                                     const lit_sample *lit, int segments)
{
    classified m;
#if HAVE_SEGMENTS
    if (segments)
        m = classified_of_segment(table, t, segments);
    else
#endif
        m = classified_of_entry(table, t);
    (void)segments;
    if (lit)
        light_classified(&m, table, lit);
    return m;
}

/* The same where `at` may be a gradient. Samples without opacity need no light. */
CVOL_INLINE classified light_sample(const cvol_sheet_table *table, cvol_vf t, const lit_sample *at,
                                    int is_gradient, int segments)
{
    if (!is_gradient)
        return classified_of(table, t, at, segments);
    classified m = classified_of(table, t, NULL, segments);
    if (!any_above(m.v[3], 0))
        return m;
    const lit_sample lit = light_of_gradient(at, table->light);
    light_classified(&m, table, &lit);
    return m;
}

/* The share of an opacity over half the length, 1 / (1 + sqrt(T)), with T = *transmittance = 1 -
 * opacity; *transmittance becomes that of the half. */
CVOL_INLINE cvol_vf half_share(cvol_vf *transmittance)
{
#if defined(__AVX512F__)
    *transmittance = (cvol_vf)_mm512_mul_ps((__m512)*transmittance,
                                            _mm512_rsqrt14_ps((__m512)*transmittance));
    return (cvol_vf)_mm512_rcp14_ps((__m512)(1 + *transmittance));
#else
    *transmittance = cvol_sqrt(*transmittance);
    return 1 / (1 + *transmittance);
#endif
}

/* Composites one part of an interval, with the mean of the classified samples at its ends; if
 * `weighted`, only this part of its length. */
CVOL_INLINE void composite_part(pixels *p, const classified *from, const classified *to,
                                sample_parts parts, ray_interval at, cvol_vf weight, int weighted)
{
    const cvol_vf before = p->transmittance;
    cvol_vf share = before;
    const cvol_vf twice = from->v[3] + to->v[3];
    if (parts.divided) {
        cvol_vf transmittance = cvol_max(1 - 0.5f * twice, cvol_splat(1e-12f));
        share = cvol_select(parts.midpoints, share * half_share(&transmittance), share);
        share = cvol_select(parts.quarters, share * half_share(&transmittance), share);
        share = (cvol_vf)((cvol_vi)share & parts.mask);
    }
    if (weighted)
        share = weight_share(share, 0.5f * twice, weight);
    share *= 0.5f;
    p->r += share * (from->v[0] + to->v[0]);
    p->g += share * (from->v[1] + to->v[1]);
    p->b += share * (from->v[2] + to->v[2]);
    p->transmittance -= share * twice;
    if (SHEET_EXTRAS)
        p->parts++;
    find_half(p, before, at);
}

/* Replaces a classified sample where a mask is set. */
CVOL_INLINE void replace_classified(classified *m, cvol_vi mask, const classified *by)
{
    for (int k = 0; k < 4; k++)
        m->v[k] = cvol_select(mask, by->v[k], m->v[k]);
}

CVOL_INLINE lit_sample mix(const lit_sample *a, const lit_sample *b, cvol_vf t)
{
    return (lit_sample){
        a->factor + t * (b->factor - a->factor), a->gloss + t * (b->gloss - a->gloss),
        a->thickness + t * (b->thickness - a->thickness), a->reach + t * (b->reach - a->reach)};
}

/* An interval from table coordinate a to b, and its light at both ends; NULL: none. `middle`: the
 * midpoint sample; NULL: all intervals are linear. */
typedef struct interval {
    cvol_vf a, b;
    const lit_sample *from, *to;
    ray_interval at;
    const cvol_vf *middle;
    cvol_vi has_midpoint;       /* the pixels that have a midpoint */
    int interpolates_gradients; /* `from` and `to` are gradients, and the interval is lit in its
                                   middle, too */
} interval;

/* The part of an interval that ends at a given place, for the lanes of a mask; *begin: the start of
 * the part. */
CVOL_INLINE ray_interval part_of(const interval *i, cvol_vf *begin, float end, cvol_vi mask)
{
    const cvol_vf to = i->at.from + end * (i->at.to - i->at.from);
    const ray_interval at = {*begin, to};
    *begin = cvol_select(mask, to, *begin);
    return at;
}

/* The classified sample at a place within an interval. */
CVOL_INLINE classified classified_within(const cvol_sheet_table *table, const interval *i, float t,
                                         int segments)
{
    cvol_vf value = i->a + t * (i->b - i->a);
    if (i->middle) {
        const cvol_vf m = *i->middle, end = t < 0.5f ? i->a : i->b;
        cvol_vf curved = m + fabsf(1 - 2 * t) * (end - m);
        if (t != 0.5f && !i->from) /* a quarter */
            curved += quarter_bow(i->a, m, i->b);
        value = cvol_select(i->has_midpoint, curved, value);
    }
    if (!i->from)
        return classified_of(table, value, NULL, segments);
    const lit_sample lit = mix(i->from, i->to, cvol_splat(t));
    return light_sample(table, value, &lit, i->interpolates_gradients, segments);
}

/* The rise from which an interval has 4 parts. */
CVOL_INLINE float quarters_from(const cvol_sheet_table *table)
{
#if SHEET_IMAGE_ORDER
    return table->steep;
#endif
    return 4 * table->flat;
}

/* The rise from which it has 2: less in image order if there are midpoint samples. */
CVOL_INLINE float midpoints_from(const cvol_sheet_table *table)
{
#if SHEET_IMAGE_ORDER
    return table->midpoint < table->flat ? table->midpoint : table->flat;
#endif
    return table->flat;
}

/* The larger difference between its middle and one of its ends. */
CVOL_INLINE cvol_vf steeper_half(const interval *i)
{
    const cvol_vf most = cvol_max(cvol_max(i->a, i->b), *i->middle),
                  least = cvol_min(cvol_min(i->a, i->b), *i->middle);
    return cvol_max(most - *i->middle, *i->middle - least);
}

/* Composites an unlit interval by its integrals, for the pixels of a mask. A separate function: it
 * has many callers. */
static __attribute__((noinline)) void composite_integrated(pixels *p, const cvol_sheet_table *table,
                                                           const interval *i, cvol_vi mask,
                                                           cvol_vf weight, int weighted)
{
    const cvol_vf straight = 0.5f * (i->a + i->b);
    const cvol_vf through[3] = {
        i->a, i->middle ? cvol_select(i->has_midpoint, *i->middle, straight) : straight, i->b};
    const cvol_vf before = p->transmittance;
    integrated sum;
    if (weighted) /* as in weight_share */
        mask &= weight >= 1e-4f;
    integrate_interval(&sum, table, through,
                       weighted ? cvol_max(weight, cvol_splat(0)) : cvol_splat(1),
                       0.5f / cvol_max(before, cvol_splat(1e-20f)));
    const cvol_vf share = (cvol_vf)((cvol_vi)before & mask);
    p->r += share * sum.colour[0];
    p->g += share * sum.colour[1];
    p->b += share * sum.colour[2];
    p->transmittance = cvol_select(mask, before * sum.transmittance, before);
    if (!SHEET_EXTRAS)
        return;
    p->parts += INTEGRATED_PARTS;
    const cvol_vi passed = (before > 0.5f) & (p->transmittance <= 0.5f);
    p->half = cvol_select(passed, i->at.from + sum.half * (i->at.to - i->at.from), p->half);
}

/* Composites an interval in 1, 2 or 4 parts, or by its integrals, chosen for each pixel, or groups
 * would become visible; fewer at low transmittance, where errors are less visible. If `weighted`,
 * only this part of its length. *last: the classified sample at its start; becomes that at its end.
 */
CVOL_INLINE void composite_from(pixels *p, const cvol_sheet_table *table, classified *last,
                                const interval *i, cvol_vf weight, int weighted, int segments)
{
    const cvol_vf most = cvol_max(i->a, i->b), least = cvol_min(i->a, i->b);
    if (!i->middle && !any_within(most, least, table->visible_from, table->visible_to)) {
        *last = (classified){{{0}}};
        return;
    }
    const classified end = light_sample(table, i->b, i->to, i->interpolates_gradients, segments);
    cvol_vf span = (most - least) * p->transmittance;
    sample_parts parts = {.divided = 1};
    if (!i->middle && !i->interpolates_gradients && !any_above(span, midpoints_from(table))) {
        parts.divided = 0;
        composite_part(p, last, &end, parts, i->at, weight, weighted);
        *last = end;
        return;
    }
    parts.midpoints = i->interpolates_gradients ? ~(cvol_vi){0} : span > midpoints_from(table);
    if (i->middle)
        span = cvol_select(i->has_midpoint, 2 * steeper_half(i) * p->transmittance, span);
    parts.quarters = span > quarters_from(table);
    cvol_vi others = ~(cvol_vi){0};
    if (!i->from && any_above(span, table->integrated)) {
        const cvol_vi steep = span > table->integrated;
        composite_integrated(p, table, i, steep, weight, weighted);
        others = ~steep;
        parts.midpoints &= others;
        parts.quarters &= others;
    }
    const int finest = cvol_any(parts.quarters);
    cvol_vf at = i->at.from;
    if (finest) {
        const classified first = classified_within(table, i, 0.25f, segments);
        parts.mask = parts.quarters;
        composite_part(p, last, &first, parts, part_of(i, &at, 0.25f, parts.mask), weight,
                       weighted);
        replace_classified(last, parts.quarters, &first);
    }
    const classified middle = classified_within(table, i, 0.5f, segments);
    parts.mask = parts.midpoints;
    composite_part(p, last, &middle, parts, part_of(i, &at, 0.5f, parts.mask), weight, weighted);
    replace_classified(last, parts.midpoints, &middle);
    if (finest) {
        const classified third = classified_within(table, i, 0.75f, segments);
        parts.mask = parts.quarters;
        composite_part(p, last, &third, parts, part_of(i, &at, 0.75f, parts.mask), weight,
                       weighted);
        replace_classified(last, parts.quarters, &third);
    }
    parts.mask = others;
    composite_part(p, last, &end, parts, part_of(i, &at, 1, parts.mask), weight, weighted);
    *last = end;
}

/* The classified sample at the start, for composite_from, if the interval before is unknown. */
CVOL_INLINE classified classified_at_start(const cvol_sheet_table *table, cvol_vf a,
                                           const lit_sample *at, int is_gradient, int segments)
{
    if (!any_within(a, a, table->visible_from, table->visible_to))
        return (classified){{{0}}};
    return light_sample(table, a, at, is_gradient, segments);
}

/* Composites a single interval. A separate function: it has many callers in some files. */
static __attribute__((noinline, unused)) void composite_interval(pixels *p,
                                                                 const cvol_sheet_table *table,
                                                                 const interval *i, cvol_vf weight,
                                                                 int weighted, int segments)
{
    classified last = classified_at_start(table, i->a, i->from, i->interpolates_gradients,
                                          segments);
    composite_from(p, table, &last, i, weight, weighted, segments);
}

#endif
