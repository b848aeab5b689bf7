/* The slices that groups meet in object order, and in which they see something: sixteen groups
 * together. (In image order: visible_slices.h.)
 *
 * Only int16.h includes this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERSECTED_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_INT16_INTERSECTED_H

/* The windows that groups `group` .. + 15 see of a slice, counted from *base. */
CVOL_INLINE __m512i find_window_numbers(int *base, const sheet_line *sheet, int group, int unit)
{
    __m512i x;
    if (unit) {
        x = _mm512_add_epi32(
            _mm512_slli_epi32((__m512i)cvol_to_int(cvol_iota()), 4),
            _mm512_set1_epi32((int)(sheet->footprint.x + (ptrdiff_t)group * CVOL_GROUP)));
    } else {
        const __m512d step = _mm512_set1_pd(CVOL_GROUP * sheet->lane_step),
                      first = _mm512_set1_pd(sheet->lane_at +
                                             (double)(group * CVOL_GROUP) * sheet->lane_step);
        const __m512d low = _mm512_set_pd(7, 6, 5, 4, 3, 2, 1, 0),
                      high = _mm512_set_pd(15, 14, 13, 12, 11, 10, 9, 8);
        const __m256i a = _mm512_cvt_roundpd_epi32(_mm512_fmadd_pd(low, step, first),
                                                   _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC),
                      b = _mm512_cvt_roundpd_epi32(_mm512_fmadd_pd(high, step, first),
                                                   _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
        x = _mm512_inserti64x4(_mm512_castsi256_si512(a), b, 1);
    }
    const __m512i number = _mm512_max_epi32(
        _mm512_srai_epi32(_mm512_add_epi32(x, _mm512_set1_epi32(CVOL_GROUP)), 4),
        _mm512_setzero_si512());
    *base = _mm_cvtsi128_si32(_mm512_castsi512_si128(number));
    return _mm512_sub_epi32(number, _mm512_set1_epi32(*base));
}

/* Lanes begin .. end - 1 of sixteen. */
CVOL_INLINE __mmask16 lanes_of(int begin, int end)
{
    begin = begin < 0 ? 0 : begin > 16 ? 16 : begin;
    end = end < begin ? begin : end > 16 ? 16 : end;
    return (__mmask16)((1u << end) - (1u << begin));
}

CVOL_INLINE void add_sheet(uint32_t *to, __mmask16 lanes, __mmask16 where, __m512i bit)
{
    const __m512i sheets = _mm512_maskz_loadu_epi32(lanes, to);
    _mm512_mask_storeu_epi32(to, lanes, _mm512_mask_or_epi32(sheets, where, sheets, bit));
}

/* The result of find_intersected, for sixteen groups together. */
CVOL_INLINE void find_intersected_int16(line_job *job, int first, int count, int unit)
{
    const __m512i one = _mm512_set1_epi32(CVOL_WINDOW_SEEN);
    memset(job->intersected, 0, sizeof *job->intersected * (size_t)count);
    memset(job->seen, 0, sizeof *job->seen * (size_t)count);
    memset(job->inside, 0, sizeof *job->inside * (size_t)count);
    job->first_group = first;
    for (int s = 0; s < job->layer->sheet_count; s++) {
        const sheet_line *sheet = &job->sheets[s];
        const int begin = sheet->begin > first ? sheet->begin : first,
                  end = sheet->end < first + count ? sheet->end : first + count;
        const __m512i bit = _mm512_set1_epi32((int)(1u << s));
        for (int group = begin; group < end; group += 16) {
            int base;
            const __mmask16 lanes = lanes_of(0, end - group);
            const __m512i number = find_window_numbers(&base, sheet, group, unit);
            const int left = job->layer->windows.count - base;
            const __mmask32 there = left >= 32 ? ~0u : left > 0 ? (1u << left) - 1 : 0;
            const __m512i windows = _mm512_cvtepu8_epi16(
                _mm256_maskz_loadu_epi8(there, sheet->view.windows + base));
            const __mmask16 seen = _mm512_mask_test_epi32_mask(
                lanes, _mm512_permutexvar_epi16(number, windows), one);
            add_sheet(job->intersected + (group - first), lanes, lanes, bit);
            add_sheet(job->seen + (group - first), lanes, seen, bit);
            add_sheet(job->inside + (group - first), lanes,
                      lanes & lanes_of(sheet->inside_begin - group, sheet->inside_end - group),
                      bit);
        }
    }
}

#endif
