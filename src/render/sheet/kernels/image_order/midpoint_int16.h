/* Midpoint samples between two slices (midpoint.h) for 32 pixels together, in int16.
 *
 * Only render/sheet/kernels/composite/int16.h includes this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_INT16_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_MIDPOINT_INT16_H

CVOL_INLINE __mmask32 lanes_of_midpoints(int midpoints)
{
    return (midpoints & 1 ? 0xffffu : 0) | (midpoints & 2 ? 0xffff0000u : 0);
}

/* The lanes of `which`, if int16 values are for `halves`: with the second group alone its values
 * come first. */
CVOL_INLINE __mmask32 lanes_placed(int which, int midpoints)
{
    return lanes_of_midpoints(midpoints == 2 ? which >> 1 : which);
}

/* Both groups' values, if they were made for the second alone. */
CVOL_INLINE __m512i spread_second(__m512i values, int midpoints)
{
    return midpoints == 2 ? _mm512_shuffle_i64x2(values, values, 0x44) : values;
}

/* The values of slice s at the position `by` slices further on. */
CVOL_INLINE __m512i take_midpoint(const int16_job *c, int s, double by, int group, int midpoints)
{
    const sheet_line sheet = view_midpoint(c->job, s, by);
    const int count = midpoints == 3 ? PAIR_LANES : CVOL_GROUP;
    const image_order_place place = place_int16(c, &sheet, group + (midpoints == 2), count);
    const around_int16 four = find_around(c, &place, count, 0);
    __m512i samples = weigh_around(&four, &place);
    int mixed = 0;
    for (int half = 0; half < PAIR; half++)
        if (midpoints >> half & 1)
            mixed |= !is_there_image_order(c->job, &sheet, group + half) << half;
    if (mixed)
        samples = put_level_int16(samples, c, &sheet, &place, lanes_placed(mixed, midpoints));
    return spread_second(samples, midpoints);
}

/* Stores the values of the midpoints between the layer's last slice and the next layer. */
CVOL_COLD void keep_midpoint_int16(const int16_job *c, int group, int midpoints)
{
    const line_job *job = c->job;
    const int last = job->layer->sheet_count - 1;
    int inside = 0;
    for (int half = 0; half < PAIR; half++)
        if (midpoints >> half & 1)
            inside |= is_inside(&job->sheets[last], group + half) << half;
    __m512i values = _mm512_setzero_si512();
    if (inside)
        values = take_midpoint(c, last, 0.5, group, inside);
    for (int half = 0; half < PAIR; half++)
        if (midpoints >> half & 1)
            cvol_store(kept_midpoint(job, group + half),
                       inside >> half & 1 ? sample_to_table(job, floats_of(values, half))
                                          : cvol_splat(NAN));
}

/* The midpoint before slice s, if the slice before belongs to another layer or has the windows of
 * another; `straight` if that was not stored. */
CVOL_COLD __m512i reconstruct_between_layers(const int16_job *c, int s, int group, int midpoints,
                                             __m512i straight)
{
    const __m512i behind = take_midpoint(c, s, -0.5, group, midpoints);
    if (s > 0)
        return _mm512_avg_epu16(take_midpoint(c, s - 1, 0.5, group, midpoints), behind);
    const float *from = kept_midpoint(c->job, group);
    const cvol_vf low = cvol_load(from), high = cvol_load(midpoints & 2 ? from + CVOL_GROUP : from);
    const __m512 parts[2] = {(__m512)(low * c->sample_rate + c->sample_from),
                             (__m512)(high * c->sample_rate + c->sample_from)};
    __mmask32 kept = 0, known = 0; /* a number; or not unknown */
    for (int half = 0; half < PAIR; half++) {
        const __m512 far = _mm512_set1_ps(INFINITY);
        kept |= (__mmask32)_mm512_cmp_ps_mask(parts[half], far, _CMP_LT_OQ) << (half * CVOL_GROUP);
        known |= (__mmask32)_mm512_cmp_ps_mask(parts[half], far, _CMP_LE_OQ) << (half * CVOL_GROUP);
    }
    const __m512i value = _mm512_mask_avg_epu16(behind, kept, int16_of(parts[0], parts[1]), behind);
    return _mm512_mask_mov_epi16(straight, known, value);
}

/* The pixels that need a midpoint, for intervals with these rises. */
CVOL_INLINE __mmask32 find_curved_intervals(const cvol_int16_table *w, __m512i rise)
{
    return _mm512_cmpgt_epi16_mask(rise, _mm512_set1_epi16(w->midpoint));
}

/* Mixes the linear value and the midpoint sample `found`, for intervals with these rises. */
CVOL_INLINE __m512i mix_midpoint(const cvol_int16_table *w, __m512i rise, __m512i straight,
                                 __m512i found)
{
    const __m512i over = _mm512_subs_epi16(rise, _mm512_set1_epi16(w->midpoint));
    const __m512i within = _mm512_max_epi16(
        _mm512_min_epi16(over, _mm512_set1_epi16(w->midpoint_ramp)), _mm512_setzero_si512());
    const __m512i share = _mm512_mulhi_epu16(
        _mm512_sll_epi16(within, _mm_cvtsi32_si128(w->midpoint_up)),
        _mm512_set1_epi16((int16_t)w->midpoint_rate));
    return _mm512_add_epi16(straight,
                            _mm512_mulhrs_epi16(_mm512_sub_epi16(found, straight), share));
}

/* The rise or fall of an interval through `middle`: twice its steeper half. */
CVOL_INLINE __m512i find_steeper(__m512i a, __m512i middle, __m512i b)
{
    const __m512i half = _mm512_max_epi16(_mm512_abs_epi16(_mm512_sub_epi16(middle, a)),
                                          _mm512_abs_epi16(_mm512_sub_epi16(b, middle)));
    return _mm512_adds_epi16(half, half);
}

/* The midpoint between slice s - 1, with values `a`, and slice s, with `b`. */
CVOL_INLINE __m512i reconstruct_midpoint_int16(const int16_job *c, int s, int group, int midpoints,
                                               __m512i a, __m512i b)
{
    const line_job *job = c->job;
    const int at = group - job->first_group, second = midpoints & 2 ? at + 1 : at;
    const int mixed = midpoints &
                      ~((int)(job->ways[at] >> s & 1) | (int)(job->ways[second] >> s & 1) << 1);
    if (s == 0 || (mixed && job->sheets[s].windows != job->sheets[s - 1].windows))
        return reconstruct_between_layers(c, s, group, midpoints, _mm512_avg_epu16(a, b));
    const sheet_line sheet = view_midpoint(job, s, -0.5);
    const int count = midpoints == 3 ? PAIR_LANES : CVOL_GROUP;
    const image_order_place place = place_int16(c, &sheet, group + (midpoints == 2), count);
    const around_int16 mean = find_around(c, &place, count,
                                          job->sheets[s - 1].origin - job->sheets[s].origin);
    __m512i values = weigh_around(&mean, &place);
    if (mixed)
        values = put_level_int16(values, c, &sheet, &place, lanes_placed(mixed, midpoints));
    return spread_second(values, midpoints);
}

#endif
