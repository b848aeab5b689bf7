/* Classified int16 samples of 32 pixels, and intervals between these: classified by
 * cvol_int16_table, divided where the transfer function bends, composited in integers.
 *
 * Only int16.h includes this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERVAL_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERVAL_H

/* ---- classified samples ---------------------------------------------------------------------- */

CVOL_INLINE __m512i of_segments(const int16_t values[CVOL_INT16_SEGMENTS], __m512i segment)
{
    return _mm512_permutexvar_epi16(segment, _mm512_load_si512(values));
}

CVOL_INLINE int16_classified classified_of_int16(const cvol_int16_table *w, __m512i q)
{
    const __m512i from = _mm512_set1_epi16(w->from);
    q = _mm512_min_epi16(_mm512_max_epi16(q, from), _mm512_set1_epi16(w->to));
    const __m512i bin = _mm512_mulhi_epu16(_mm512_sub_epi16(q, from),
                                           _mm512_set1_epi16((int16_t)w->bins));
    __m512i segment = _mm512_permutex2var_epi16(_mm512_load_si512(w->segment_of), bin,
                                                _mm512_load_si512(w->segment_of + 32));
    for (int step = 0; step < w->steps; step++) {
        const __mmask32 beyond = _mm512_cmpge_epi16_mask(q, of_segments(w->end, segment));
        segment = _mm512_mask_add_epi16(segment, beyond, segment, _mm512_set1_epi16(1));
    }
    const __m512i part = _mm512_sllv_epi16(_mm512_sub_epi16(q, of_segments(w->begin, segment)),
                                           of_segments(w->up, segment));
    int16_classified m;
    for (int k = 0; k < 4; k++)
        m.v[k] = _mm512_add_epi16(of_segments(w->start[k], segment),
                                  _mm512_mulhrs_epi16(part, of_segments(w->rise[k], segment)));
    return m;
}

CVOL_INLINE __m512i half_of_opacity(const cvol_int16_table *w, __m512i opacity)
{
    const __m512i i = _mm512_srli_epi16(opacity, 10);
    const __m512i part = _mm512_and_si512(_mm512_slli_epi16(opacity, 5),
                                          _mm512_set1_epi16(INT16_ONE));
    return _mm512_adds_epi16(of_segments(w->half_start, i),
                             _mm512_mulhrs_epi16(part, of_segments(w->half_rise, i)));
}

/* The division of an interval: the pixels with halves, the pixels with quarters, and others that
 * use integrals. */
typedef struct int16_parts {
    __mmask32 midpoints, quarters, integrated;
} int16_parts;

/* Composites one part of an interval, with the mean of the classified samples at its ends, where
 * `mask` is set. */
CVOL_INLINE void composite_int16(int16_pixels *p, const cvol_int16_table *w,
                                 const int16_classified *from, const int16_classified *to,
                                 const int16_parts *parts, __mmask32 mask)
{
    const __m128i shift = _mm_cvtsi32_si128(w->shift);
    const __m512i opacity = _mm512_adds_epi16(from->v[3], to->v[3]);
    __m512i share = p->transmittance;
    if (parts) {
        const __m512i whole = _mm512_srl_epi16(opacity, _mm_cvtsi32_si128(w->shift + w->fine));
        const __m512i half = half_of_opacity(w, whole);
        share = _mm512_mask_mulhrs_epi16(share, parts->midpoints, share, half);
        if (parts->quarters) {
            const __m512i quarter = half_of_opacity(w, _mm512_mulhrs_epi16(whole, half));
            share = _mm512_mask_mulhrs_epi16(share, parts->quarters, share, quarter);
        }
        share = _mm512_maskz_mov_epi16(mask, share);
    }
    if (w->fine)
        share = _mm512_mulhrs_epi16(share, _mm512_set1_epi16((int16_t)(32768 >> w->fine)));
    for (int k = 0; k < 3; k++)
        p->gained[k] = _mm512_adds_epi16(
            p->gained[k], _mm512_mulhrs_epi16(share, _mm512_adds_epi16(from->v[k], to->v[k])));
    p->gained[3] = _mm512_adds_epi16(p->gained[3], _mm512_mulhrs_epi16(share, opacity));
    p->transmittance = _mm512_subs_epu16(p->start, _mm512_srl_epi16(p->gained[3], shift));
}

CVOL_INLINE void replace_int16(int16_classified *m, __mmask32 mask, const int16_classified *by)
{
    for (int k = 0; k < 4; k++)
        m->v[k] = _mm512_mask_mov_epi16(m->v[k], mask, by->v[k]);
}

/* ---- intervals ------------------------------------------------------------------------------- */

CVOL_INLINE __mmask32 find_open(__m512i transmittance)
{
    return _mm512_cmpge_epi16_mask(transmittance, _mm512_set1_epi16(INT16_OPAQUE));
}

CVOL_INLINE int is_open(__m512i transmittance, int half)
{
    return (find_open(transmittance) >> (half * CVOL_GROUP) & 0xffff) != 0;
}

/* Consecutive intervals: their samples are all classified before any is composited, since these
 * computations then do not wait for each other. */
#define BATCH 4
typedef struct int16_batch {
    int16_classified ends[BATCH + 1], middle[BATCH], quarter[BATCH][2];
    __m512i value[BATCH], rise[BATCH]; /* of middles; of intervals */
    __mmask32 has_midpoint[BATCH]; /* pixels with a midpoint, which so have at least two parts */
} int16_batch;

/* The number of parts depends on the transmittance: the lower it is, the fewer, since errors are
 * less visible. */
CVOL_INLINE int16_parts find_parts(const cvol_int16_table *w, __m512i rise, __m512i transmittance)
{
    const int coarse = SHEET_IMAGE_ORDER ? w->steep : 4 * w->flat;
    const __m512i seen = _mm512_mulhrs_epi16(rise, transmittance);
    const __mmask32 steep = _mm512_cmpgt_epi16_mask(seen, _mm512_set1_epi16(w->integrated));
    return (int16_parts){
        _mm512_cmpgt_epi16_mask(seen, _mm512_set1_epi16(w->flat)) & ~steep,
        _mm512_cmpgt_epi16_mask(
            seen, _mm512_set1_epi16((int16_t)(coarse > INT16_ONE ? INT16_ONE : coarse))) &
            ~steep,
        steep};
}

/* A run that is drawn: slices from s on, for the groups with bits in `halves`. */
typedef struct int16_run {
    const int16_job *job;
    int s, group, midpoints;
} int16_run;

/* The pixels whose interval may be divided. */
CVOL_INLINE __mmask32 find_divided(const cvol_int16_table *w, __m512i rise, __m512i transmittance)
{
    const int16_t from = SHEET_IMAGE_ORDER && w->midpoint < w->flat ? w->midpoint : w->flat;
    const __m512i least = _mm512_set1_epi16(from);
    return _mm512_cmpgt_epi16_mask(_mm512_mulhrs_epi16(rise, transmittance), least);
}

/* An estimate of the transmittance after an interval. */
CVOL_INLINE __m512i pass_interval(const cvol_int16_table *w, __m512i transmittance,
                                  const int16_classified *from, const int16_classified *to)
{
    const __m512i opacity = _mm512_srl_epi16(_mm512_adds_epi16(from->v[3], to->v[3]),
                                             _mm_cvtsi32_si128(w->shift + w->fine));
    return _mm512_subs_epu16(transmittance, _mm512_mulhrs_epi16(transmittance, opacity));
}

/* Finds the `live` intervals between `values`, from the run's interval `first` on. If one pixel
 * sees something, all get midpoints: bands that are thinner than an interval lie between two
 * invisible ends. */
CVOL_INLINE void find_batch(int16_batch *batch, const int16_run *run, int first,
                            const __m512i *values, unsigned live, const __m512i begin)
{
    const cvol_int16_table *w = run->job->int16;
    const unsigned ends = live | live << 1;
#if SHEET_IMAGE_ORDER
    __m512i transmittance = begin;
#endif
    for (int i = 0; i <= BATCH; i++)
        if (ends >> i & 1)
            batch->ends[i] = classified_of_int16(w, values[i]);
    for (int i = 0; i < BATCH; i++) {
        if (!(live >> i & 1)) /* and values may end before */
            continue;
        const __m512i a = values[i], b = values[i + 1];
        batch->rise[i] = _mm512_abs_epi16(_mm512_sub_epi16(b, a));
        batch->has_midpoint[i] = 0;
        const __mmask32 divided = find_divided(w, batch->rise[i], begin);
#if SHEET_IMAGE_ORDER
        const __m512i seen = _mm512_mulhrs_epi16(batch->rise[i], transmittance),
                      before = transmittance;
        transmittance = pass_interval(w, transmittance, &batch->ends[i], &batch->ends[i + 1]);
#endif
        if (!divided)
            continue;
        __m512i middle = _mm512_avg_epu16(a, b);
#if SHEET_IMAGE_ORDER
        batch->has_midpoint[i] = find_curved_intervals(w, seen) & find_open(before);
        if (batch->has_midpoint[i]) {
            middle = mix_midpoint(w, seen, middle,
                                  reconstruct_midpoint_int16(run->job, run->s + first + i,
                                                             run->group, run->midpoints, a, b));
            batch->rise[i] = _mm512_mask_mov_epi16(batch->rise[i], batch->has_midpoint[i],
                                                   find_steeper(a, middle, b));
        }
#else
        (void)first;
#endif
        batch->value[i] = middle;
        batch->middle[i] = classified_of_int16(w, middle);
        /* Pixels that would use integrals may have quarters when their transmittance is known. */
        const int16_parts parts = find_parts(w, batch->rise[i], begin);
        if (parts.quarters | parts.integrated) {
            /* From straight lines to the parabola, see quarter_bow; it may leave the range. */
            const __m512i bow = _mm512_srai_epi16(_mm512_sub_epi16(middle, _mm512_avg_epu16(a, b)),
                                                  2);
            const __m512i quarter = _mm512_adds_epi16(_mm512_avg_epu16(a, middle), bow),
                          third = _mm512_adds_epi16(_mm512_avg_epu16(middle, b), bow);
            batch->quarter[i][0] = classified_of_int16(w, quarter);
            batch->quarter[i][1] = classified_of_int16(w, third);
        }
    }
}

/* Composites an interval from a through `middle` to b by its integrals, for the pixels of a mask,
 * in floats. */
CVOL_COLD void composite_integrals(int16_pixels *p, const int16_job *c, __m512i a, __m512i middle,
                                   __m512i b, __mmask32 mask)
{
    const cvol_int16_table *w = c->int16;
    const float unit = (float)(32768 << w->shift);
    __m512i gained[4] = {p->gained[0], p->gained[1], p->gained[2], p->gained[3]};
    __m256i sums[4][PAIR];
    for (int half = 0; half < PAIR; half++) {
        const cvol_vf through[3] = {sample_to_table(c->job, floats_of(a, half)),
                                    sample_to_table(c->job, floats_of(middle, half)),
                                    sample_to_table(c->job, floats_of(b, half))};
        const cvol_vf share = (unit / 32768) * floats_of(p->transmittance, half);
        integrated sum;
        integrate_interval(&sum, c->job->table, through, cvol_splat(1), cvol_splat(0));
        for (int k = 0; k < 3; k++)
            sums[k][half] = _mm512_cvtsepi32_epi16(
                _mm512_cvtps_epi32((__m512)(share * sum.colour[k])));
        sums[3][half] = _mm512_cvtsepi32_epi16(
            _mm512_cvtps_epi32((__m512)(share * (1 - sum.transmittance))));
    }
    for (int k = 0; k < 4; k++)
        p->gained[k] = _mm512_mask_adds_epi16(
            gained[k], mask, gained[k],
            _mm512_inserti64x4(_mm512_castsi256_si512(sums[k][0]), sums[k][1], 1));
    p->transmittance = _mm512_subs_epu16(
        p->start, _mm512_srl_epi16(p->gained[3], _mm_cvtsi32_si128(w->shift)));
}

CVOL_INLINE void composite_divided(int16_pixels *p, const cvol_int16_table *w,
                                   const int16_batch *batch, int i, const int16_parts *parts)
{
    int16_classified last = batch->ends[i];
    if (parts->quarters) {
        composite_int16(p, w, &last, &batch->quarter[i][0], parts, parts->quarters);
        replace_int16(&last, parts->quarters, &batch->quarter[i][0]);
    }
    composite_int16(p, w, &last, &batch->middle[i], parts, parts->midpoints);
    replace_int16(&last, parts->midpoints, &batch->middle[i]);
    if (parts->quarters) {
        composite_int16(p, w, &last, &batch->quarter[i][1], parts, parts->quarters);
        replace_int16(&last, parts->quarters, &batch->quarter[i][1]);
    }
    composite_int16(p, w, &last, &batch->ends[i + 1], parts, ~parts->integrated);
}

/* Draws the `live` intervals between `values`, for the pixels that see something in `sees`; pixels
 * that are opaque by then are ignored. */
CVOL_INLINE void draw_intervals(int16_pixels *p, const int16_run *run, const __m512i *values,
                                const __mmask32 *sees, uint64_t live)
{
    const cvol_int16_table *w = run->job->int16;
    int16_batch batch;
    while (live) {
        const int first = __builtin_ctzll(live);
        unsigned now = (unsigned)(live >> first) & ((1u << BATCH) - 1);
        const __mmask32 open = find_open(p->transmittance);
        for (int i = 0; i < BATCH; i++)
            if (now >> i & 1 && !(sees[first + i] & open))
                now &= ~(1u << i);
        live &= ~((UINT64_C(1) << BATCH) - 1) << first;
        if (!now)
            continue;
        find_batch(&batch, run, first, values + first, now, p->transmittance);
        for (int i = 0; i < BATCH; i++) {
            if (!(now >> i & 1))
                continue;
            int16_parts parts = find_parts(w, batch.rise[i], p->transmittance);
#if SHEET_IMAGE_ORDER
            parts.midpoints |= batch.has_midpoint[i] & ~parts.integrated;
#endif
            if (parts.integrated)
                composite_integrals(p, run->job, values[first + i], batch.value[i],
                                    values[first + i + 1], parts.integrated);
            if (!(parts.midpoints | parts.integrated))
                composite_int16(p, w, &batch.ends[i], &batch.ends[i + 1], NULL, 0);
            else
                composite_divided(p, w, &batch, i, &parts);
        }
        if (!find_open(p->transmittance))
            break;
    }
}

#endif
