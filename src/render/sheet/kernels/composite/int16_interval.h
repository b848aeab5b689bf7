/* Matter of 32 pixels' samples of 16 bits, and intervals between these: classified by
 * cvol_sheet_words, divided where the transfer function bends, composited in whole numbers.
 *
 * To be included by int16.h only.
 */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERVAL_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERVAL_H

/* ---- matter ------------------------------------------------------------------------------------
 */

CVOL_INLINE __m512i of_pieces(const int16_t values[CVOL_WORDS_PIECES], __m512i piece)
{
    return _mm512_permutexvar_epi16(piece, _mm512_load_si512(values));
}

CVOL_INLINE words_matter matter_of_words(const cvol_sheet_words *w, __m512i q)
{
    const __m512i from = _mm512_set1_epi16(w->from);
    q = _mm512_min_epi16(_mm512_max_epi16(q, from), _mm512_set1_epi16(w->to));
    const __m512i bin = _mm512_mulhi_epu16(_mm512_sub_epi16(q, from),
                                           _mm512_set1_epi16((int16_t)w->bins));
    __m512i piece = _mm512_permutex2var_epi16(_mm512_load_si512(w->piece_of), bin,
                                              _mm512_load_si512(w->piece_of + 32));
    for (int step = 0; step < w->steps; step++) {
        const __mmask32 beyond = _mm512_cmpge_epi16_mask(q, of_pieces(w->end, piece));
        piece = _mm512_mask_add_epi16(piece, beyond, piece, _mm512_set1_epi16(1));
    }
    const __m512i part = _mm512_sllv_epi16(_mm512_sub_epi16(q, of_pieces(w->begin, piece)),
                                           of_pieces(w->up, piece));
    words_matter m;
    for (int k = 0; k < 4; k++)
        m.v[k] = _mm512_add_epi16(of_pieces(w->start[k], piece),
                                  _mm512_mulhrs_epi16(part, of_pieces(w->rise[k], piece)));
    return m;
}

CVOL_INLINE __m512i half_of_opacity(const cvol_sheet_words *w, __m512i opacity)
{
    const __m512i i = _mm512_srli_epi16(opacity, 10);
    const __m512i part = _mm512_and_si512(_mm512_slli_epi16(opacity, 5),
                                          _mm512_set1_epi16(ONE_WORD));
    return _mm512_adds_epi16(of_pieces(w->half_start, i),
                             _mm512_mulhrs_epi16(part, of_pieces(w->half_rise, i)));
}

/* How an interval is divided: in which pixels into halves, in which of these into quarters. */
typedef struct words_parts {
    __mmask32 halves, quarters;
} words_parts;

/* One part of an interval, of the mean of the matter at its ends, where `mask` is set. */
CVOL_INLINE void composite_words(words_pixels *p, const cvol_sheet_words *w,
                                 const words_matter *from, const words_matter *to,
                                 const words_parts *parts, __mmask32 mask)
{
    const __m128i shift = _mm_cvtsi32_si128(w->shift);
    const __m512i opacity = _mm512_adds_epi16(from->v[3], to->v[3]);
    __m512i share = p->through;
    if (parts) {
        const __m512i whole = _mm512_srl_epi16(opacity, _mm_cvtsi32_si128(w->shift + w->fine));
        const __m512i half = half_of_opacity(w, whole);
        share = _mm512_mask_mulhrs_epi16(share, parts->halves, share, half);
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
    p->through = _mm512_subs_epu16(p->start, _mm512_srl_epi16(p->gained[3], shift));
}

CVOL_INLINE void replace_words(words_matter *m, __mmask32 mask, const words_matter *by)
{
    for (int k = 0; k < 4; k++)
        m->v[k] = _mm512_mask_mov_epi16(m->v[k], mask, by->v[k]);
}

/* ---- intervals ---------------------------------------------------------------------------------
 */

CVOL_INLINE __mmask32 find_open(__m512i through)
{
    return _mm512_cmpge_epi16_mask(through, _mm512_set1_epi16(OPAQUE_WORD));
}

CVOL_INLINE int is_open(__m512i through, int half)
{
    return (find_open(through) >> (half * CVOL_GROUP) & 0xffff) != 0;
}

/* Some intervals that follow one another: what matter they have is found before any is composited,
 * as one does not wait for the other then. */
#define TURN 4
typedef struct words_turn {
    words_matter ends[TURN + 1], middle[TURN], quarter[TURN][2];
    __m512i rise[TURN];
    __mmask32 bent[TURN]; /* pixels that are looked at half way, and so have two parts at least */
} words_turn;

/* As much as light still comes through: the less, the fewer, for the less an error is seen. */
CVOL_INLINE words_parts find_parts(const cvol_sheet_words *w, __m512i rise, __m512i through)
{
    const int coarse = SHEET_PIXELS ? w->steep : 4 * w->flat;
    const __m512i seen = _mm512_mulhrs_epi16(rise, through);
    return (words_parts){
        _mm512_cmpgt_epi16_mask(seen, _mm512_set1_epi16(w->flat)),
        _mm512_cmpgt_epi16_mask(
            seen, _mm512_set1_epi16((int16_t)(coarse > ONE_WORD ? ONE_WORD : coarse)))};
}

/* A run that is drawn: sheets from s on, of those groups that have bits in `halves`. */
typedef struct words_run {
    const compact_job *job;
    int s, group, halves;
} words_run;

/* Of which pixels an interval may be divided. */
CVOL_INLINE __mmask32 find_divided(const cvol_sheet_words *w, __m512i rise, __m512i through)
{
    const int16_t from = SHEET_PIXELS && w->midway < w->flat ? w->midway : w->flat;
    const __m512i least = _mm512_set1_epi16(from);
    return _mm512_cmpgt_epi16_mask(_mm512_mulhrs_epi16(rise, through), least);
}

/* About what comes through an interval. */
CVOL_INLINE __m512i pass_interval(const cvol_sheet_words *w, __m512i through,
                                  const words_matter *from, const words_matter *to)
{
    const __m512i opacity = _mm512_srl_epi16(_mm512_adds_epi16(from->v[3], to->v[3]),
                                             _mm_cvtsi32_si128(w->shift + w->fine));
    return _mm512_subs_epu16(through, _mm512_mulhrs_epi16(through, opacity));
}

/* The `live` intervals between `values`, of which the first is the run's interval `first`. Where
 * one pixel sees something, what lies half way is looked at for all: shells that are thinner than
 * an interval lie between two ends at which there is nothing. */
CVOL_INLINE void find_turn(words_turn *turn, const words_run *run, int first, const __m512i *values,
                           unsigned live, const __m512i begin)
{
    const cvol_sheet_words *w = run->job->words;
    const unsigned ends = live | live << 1;
#if SHEET_PIXELS
    __m512i through = begin;
#endif
    for (int i = 0; i <= TURN; i++)
        if (ends >> i & 1)
            turn->ends[i] = matter_of_words(w, values[i]);
    for (int i = 0; i < TURN; i++) {
        const __m512i a = values[i], b = values[i + 1];
        if (!(live >> i & 1))
            continue;
        turn->rise[i] = _mm512_abs_epi16(_mm512_sub_epi16(b, a));
        turn->bent[i] = 0;
        const __mmask32 divided = find_divided(w, turn->rise[i], begin);
#if SHEET_PIXELS
        const __m512i seen = _mm512_mulhrs_epi16(turn->rise[i], through), before = through;
        through = pass_interval(w, through, &turn->ends[i], &turn->ends[i + 1]);
#endif
        if (!divided)
            continue;
        __m512i middle = _mm512_avg_epu16(a, b);
#if SHEET_PIXELS
        turn->bent[i] = find_bent(w, seen) & find_open(before);
        if (turn->bent[i]) {
            middle = mix_midway(w, seen, middle,
                                reconstruct_midway_words(run->job, run->s + first + i, run->group,
                                                         run->halves, a, b));
            turn->rise[i] = _mm512_mask_mov_epi16(turn->rise[i], turn->bent[i],
                                                  find_steeper(a, middle, b));
        }
#else
        (void)first;
#endif
        turn->middle[i] = matter_of_words(w, middle);
        if (find_parts(w, turn->rise[i], begin).quarters) {
            turn->quarter[i][0] = matter_of_words(w, _mm512_avg_epu16(a, middle));
            turn->quarter[i][1] = matter_of_words(w, _mm512_avg_epu16(middle, b));
        }
    }
}

CVOL_INLINE void composite_divided(words_pixels *p, const cvol_sheet_words *w,
                                   const words_turn *turn, int i, const words_parts *parts)
{
    words_matter last = turn->ends[i];
    if (parts->quarters) {
        composite_words(p, w, &last, &turn->quarter[i][0], parts, parts->quarters);
        replace_words(&last, parts->quarters, &turn->quarter[i][0]);
    }
    composite_words(p, w, &last, &turn->middle[i], parts, parts->halves);
    replace_words(&last, parts->halves, &turn->middle[i]);
    if (parts->quarters) {
        composite_words(p, w, &last, &turn->quarter[i][1], parts, parts->quarters);
        replace_words(&last, parts->quarters, &turn->quarter[i][1]);
    }
    composite_words(p, w, &last, &turn->ends[i + 1], parts, ~(__mmask32)0);
}

/* The `live` ones of the intervals between `values`, of which pixels see something where `sees` has
 * them; those that are opaque by then do not count. */
CVOL_INLINE void draw_intervals(words_pixels *p, const words_run *run, const __m512i *values,
                                const __mmask32 *sees, uint64_t live)
{
    const cvol_sheet_words *w = run->job->words;
    words_turn turn;
    while (live) {
        const int first = __builtin_ctzll(live);
        unsigned now = (unsigned)(live >> first) & ((1u << TURN) - 1);
        const __mmask32 open = find_open(p->through);
        for (int i = 0; i < TURN; i++)
            if (now >> i & 1 && !(sees[first + i] & open))
                now &= ~(1u << i);
        live &= ~((UINT64_C(1) << TURN) - 1) << first;
        if (!now)
            continue;
        find_turn(&turn, run, first, values + first, now, p->through);
        for (int i = 0; i < TURN; i++) {
            if (!(now >> i & 1))
                continue;
            words_parts parts = find_parts(w, turn.rise[i], p->through);
#if SHEET_PIXELS
            parts.halves |= turn.bent[i];
#endif
            if (!parts.halves)
                composite_words(p, w, &turn.ends[i], &turn.ends[i + 1], NULL, 0);
            else
                composite_divided(p, w, &turn, i, &parts);
        }
        if (!find_open(p->through))
            break;
    }
}

#endif
