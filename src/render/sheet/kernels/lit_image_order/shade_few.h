/* Few of 16 pixels have an interval with many parts, as a rule. Two or four of them share one
 * vector, part behind part, so that all of these parts are classified and lit together
 * (shade_interval.h). Only with AVX-512: shorter vectors are processed part by part.
 *
 * Only kernel files include this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_FEW_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_FEW_H

#include "render/sheet/kernels/lit_image_order/shade_interval.h"

#if defined(__AVX512F__)

/* With more pixels than these, whole groups are processed part by part. */
#define FEW_OF_EIGHT 6
#define FEW_OF_FOUR 8

/* The contribution of some pixels' intervals, and their transmittance. */
typedef struct few_pixels {
    __m512 v[3], transmittance;
    __mmask16 which;
} few_pixels;

/* The ends or middle of an interval at which a lane's half of it begins and ends, by pixel. */
typedef struct few_lanes {
    __m512i pixel, half;
} few_lanes;

CVOL_INLINE cvol_vf take_between(const few_lanes *at, cvol_vf a, cvol_vf middle, cvol_vf b,
                                 cvol_vf t)
{
    const cvol_vf from = (cvol_vf)_mm512_permutex2var_ps((__m512)a, at->half, (__m512)middle),
                  to = (cvol_vf)_mm512_permutex2var_ps((__m512)middle, at->half, (__m512)b);
    return from + t * (to - from);
}

/* weigh_classified for the samples at the ends of parts. */
CVOL_INLINE void weigh_few(classified *end, const classified *last, const few_lanes *at,
                           const cvol_vf weights[3], __m512i part, int parts)
{
    const __m512i iota = (__m512i)cvol_to_int(cvol_iota());
    for (int level = 0, half = parts / 2; half; level++, half /= 2) {
        const __m512i reach = _mm512_set1_epi32(half),
                      place = _mm512_and_si512(part, _mm512_set1_epi32(2 * half - 1)),
                      before = _mm512_sub_epi32(iota, reach),
                      behind = _mm512_add_epi32(iota, reach);
        const __mmask16 own = _mm512_cmpeq_epi32_mask(place, _mm512_set1_epi32(half - 1)),
                        later = _mm512_cmpge_epi32_mask(part, reach);
        const __m512 weight = _mm512_permutexvar_ps(at->pixel, (__m512)weights[level]);
        for (int k = 0; k < 4; k++) {
            const __m512 own_value = (__m512)end->v[k],
                         from = _mm512_mask_permutexvar_ps(
                             _mm512_permutexvar_ps(at->pixel, (__m512)last->v[k]), later, before,
                             own_value),
                         straight = _mm512_mul_ps(
                             _mm512_set1_ps(0.5f),
                             _mm512_add_ps(from, _mm512_permutexvar_ps(behind, own_value)));
            end->v[k] = (cvol_vf)_mm512_mask_mov_ps(
                own_value, own,
                _mm512_fmadd_ps(weight, _mm512_sub_ps(own_value, straight), straight));
        }
    }
}

/* Draws `parts` parts of the intervals of some pixels, 16 / parts of them or fewer. */
CVOL_INLINE void draw_few(few_pixels *out, __mmask16 which, const cvol_sheet_table *table,
                          const classified *last, const lit_interval *i, const cvol_vf weights[3],
                          int parts, int segments)
{
    const int log2_parts = parts == 8 ? 3 : 2;
    const __m512i iota = (__m512i)cvol_to_int(cvol_iota());
    const __m512i slot = _mm512_srli_epi32(iota, (unsigned)log2_parts),
                  part = _mm512_and_si512(iota, _mm512_set1_epi32(parts - 1)),
                  within = _mm512_and_si512(iota, _mm512_set1_epi32(parts / 2 - 1));
    few_lanes at;
    at.pixel = _mm512_permutexvar_epi32(slot, _mm512_maskz_compress_epi32(which, iota));
    at.half = _mm512_mask_add_epi32(at.pixel,
                                    _mm512_cmpge_epi32_mask(part, _mm512_set1_epi32(parts / 2)),
                                    at.pixel, _mm512_set1_epi32(CVOL_GROUP));
    /* The values at the ends of parts; each begins at the end before. */
    const cvol_vf t = (cvol_to_float((cvol_vi)within) + 1) * (2.0f / (float)parts);
    gradient rise;
    for (int k = 0; k < 3; k++)
        rise.v[k] = take_between(&at, i->from.v[k], i->half.v[k], i->to.v[k], t);
    rise.reach = take_between(&at, i->from.reach, i->half.reach, i->to.reach, t);
    classified end = classified_of_gradient(table, take_between(&at, i->a, i->middle, i->b, t),
                                            &rise, segments);
    weigh_few(&end, last, &at, weights, part, parts);
    const __mmask16 later = _mm512_test_epi32_mask(part, part);
    const __m512i before = _mm512_sub_epi32(iota, _mm512_set1_epi32(1));
    classified begin;
    for (int k = 0; k < 4; k++)
        begin.v[k] = (cvol_vf)_mm512_mask_permutexvar_ps(
            _mm512_permutexvar_ps(at.pixel, (__m512)last->v[k]), later, before, (__m512)end.v[k]);
    pixels p = {.transmittance = cvol_splat(1)};
    cvol_vf transmittance = transmittance_between(&begin, &end), share = p.transmittance;
    for (int k = 0; k < log2_parts; k++)
        share *= half_share(&transmittance);
    add_lit_part(&p, &begin, &end, share, transmittance);
    /* Combines adjacent parts, in pairs. */
    for (int step = 1; step < parts; step *= 2) {
        const __m512i behind = _mm512_add_epi32(iota, _mm512_set1_epi32(step));
        p.r += p.transmittance * (cvol_vf)_mm512_permutexvar_ps(behind, (__m512)p.r);
        p.g += p.transmittance * (cvol_vf)_mm512_permutexvar_ps(behind, (__m512)p.g);
        p.b += p.transmittance * (cvol_vf)_mm512_permutexvar_ps(behind, (__m512)p.b);
        p.transmittance *= (cvol_vf)_mm512_permutexvar_ps(behind, (__m512)p.transmittance);
    }
    const __m512i first = _mm512_slli_epi32(_mm512_maskz_expand_epi32(which, iota),
                                            (unsigned)log2_parts);
    out->v[0] = _mm512_mask_permutexvar_ps(out->v[0], which, first, (__m512)p.r);
    out->v[1] = _mm512_mask_permutexvar_ps(out->v[1], which, first, (__m512)p.g);
    out->v[2] = _mm512_mask_permutexvar_ps(out->v[2], which, first, (__m512)p.b);
    out->transmittance = _mm512_mask_permutexvar_ps(out->transmittance, which, first,
                                                    (__m512)p.transmittance);
    out->which |= which;
}

/* The lowest `count` bits that are set. */
CVOL_INLINE __mmask16 lowest_bits(unsigned bits, int count)
{
    unsigned rest = bits;
    for (int k = 0; k < count; k++)
        rest &= rest - 1;
    return (__mmask16)(bits & ~rest);
}

/* For pixels with more than two parts, if they are few; the others remain in parts->most. */
CVOL_INLINE void draw_many_parts(few_pixels *out, const cvol_sheet_table *table, lit_parts *parts,
                                 const classified *last, const lit_interval *i, int segments)
{
    unsigned eighths = _mm512_movepi32_mask((__m512i)parts->divided[2]),
             quarters = _mm512_movepi32_mask((__m512i)parts->divided[1]) & ~eighths;
    out->which = 0;
    if (__builtin_popcount(eighths) > FEW_OF_EIGHT)
        return;
    for (; eighths; eighths &= ~(unsigned)out->which)
        draw_few(out, lowest_bits(eighths, 2), table, last, i, parts->weight, 8, segments);
    parts->most = quarters ? 4 : 2;
    if (__builtin_popcount(quarters) > FEW_OF_FOUR)
        return;
    for (; quarters; quarters &= ~(unsigned)out->which)
        draw_few(out, lowest_bits(quarters, 4), table, last, i, parts->weight, 4, segments);
    parts->most = 2;
}

/* Composites their intervals on the pixels as they were before. */
CVOL_INLINE void replace_few(pixels *p, const pixels *start, const few_pixels *few)
{
    const __m512 share = (__m512)start->transmittance;
    p->r = (cvol_vf)_mm512_mask_mov_ps((__m512)p->r, few->which,
                                       _mm512_fmadd_ps(share, few->v[0], (__m512)start->r));
    p->g = (cvol_vf)_mm512_mask_mov_ps((__m512)p->g, few->which,
                                       _mm512_fmadd_ps(share, few->v[1], (__m512)start->g));
    p->b = (cvol_vf)_mm512_mask_mov_ps((__m512)p->b, few->which,
                                       _mm512_fmadd_ps(share, few->v[2], (__m512)start->b));
    p->transmittance = (cvol_vf)_mm512_mask_mul_ps((__m512)p->transmittance, few->which, share,
                                                   few->transmittance);
}

#endif

/* Composites a whole interval with a middle, in 2 to 8 parts; the middle may apply to single pixels
 * only. *last: the classified sample at its start; becomes that at its end. */
CVOL_INLINE void composite_divided(pixels *p, const cvol_sheet_table *table, classified *last,
                                   const classified *end, const lit_interval *i, cvol_vf weight,
                                   int segments)
{
    lit_parts parts = find_parts(i, table, last, end, p->transmittance, weight);
    if (cvol_any(~parts.drawn))
        composite_lit_integrals(p, table, i, ~parts.drawn);
#if defined(__AVX512F__)
    const pixels start = *p;
    few_pixels few = {.which = 0};
    if (parts.most > 2)
        draw_many_parts(&few, table, &parts, last, i, segments);
#endif
    composite_parts(p, table, last, end, i, &parts, segments);
#if defined(__AVX512F__)
    if (few.which)
        replace_few(p, &start, &few);
#endif
}

#endif
