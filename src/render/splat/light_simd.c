/* Classification and illumination of a row of samples, which lists the visible ones.
 *
 * Whole vectors are skipped if none of their samples is visible. The gradient is one of central
 * differences in the world; at the volume's faces a difference has half the length. */
#include "render/splat/frame.h"
#include "render/view/phong.h"

/* The light of the samples from i on. */
CVOL_INLINE lit_sample light_samples(const cvol_splat_row *row, int i, const cvol_light *light)
{
    const cvol_vf gradient[3] = {
        (cvol_load(row->samples + i + 1) - cvol_load(row->samples + i - 1)) * light->rise[0],
        (cvol_load(row->below + i) - cvol_load(row->above + i)) * light->rise[1],
        (cvol_load(row->behind + i) - cvol_load(row->before + i)) * light->rise[2]};
    return illuminate(gradient, light);
}

/* Stores the visible ones of numbers and entries, consecutively; returns their number. */
CVOL_INLINE int pack(int *numbers, int *entries, cvol_vi number, cvol_vi entry, cvol_vi visible)
{
#if defined(__AVX512F__)
    const __mmask16 mask = _mm512_test_epi32_mask((__m512i)visible, (__m512i)visible);
    _mm512_storeu_si512(numbers, _mm512_maskz_compress_epi32(mask, (__m512i)number));
    _mm512_storeu_si512(entries, _mm512_maskz_compress_epi32(mask, (__m512i)entry));
    return __builtin_popcount(mask);
#else
    int count = 0;
    for (int lane = 0; lane < CVOL_LANES; lane++) {
        numbers[count] = number[lane];
        entries[count] = entry[lane];
        count -= visible[lane];
    }
    return count;
#endif
}

/* Lights the channels of the samples listed from `first` on, which lie within a vector from i. */
CVOL_INLINE void light_list(cvol_splat_list *list, int first, int end, const cvol_splat_row *row,
                            int i, const cvol_splat_table *table, const cvol_light *light)
{
    const lit_sample lit = light_samples(row, i, light);
    for (int n = first; n < end; n++) {
        const float *from = table->entries[list->entries[n]];
        float *to = list->channels + CVOL_SPLAT_CHANNELS * n;
        const int lane = list->numbers[n] - i;
        float share = 1;
        if (lit.thickness[lane] < 1 && from[3] > 0)
            share = (1 - powf(fmaxf(1 - from[3], 0), lit.thickness[lane])) / from[3];
        for (int c = 0; c < 3; c++)
            to[c] = share * fminf(from[c] * lit.factor[lane] + from[3] * lit.gloss[lane],
                                  CVOL_SPLAT_BRIGHTEST * from[3]);
        to[3] = share * from[3];
        list->entries[n] = n;
    }
}

void CVOL_SIMD(cvol_splat_list_make)(cvol_splat_list *list, const cvol_splat_row *row, int begin,
                                     int end, const cvol_splat_table *table,
                                     const cvol_light *light)
{
    int count = 0;
    const cvol_vf last = cvol_splat(CVOL_SPLAT_ENTRIES - 1);
    for (int i = begin; i < end; i += CVOL_LANES) {
        const cvol_vf values = cvol_load(row->samples + i);
        const cvol_vi visible = (values >= table->visible_from) & (values <= table->visible_to) &
                                (cvol_iota() < (float)(end - i));
        if (!cvol_any(visible))
            continue;
        const cvol_vf place = (values - table->from) * table->scale + 0.5f;
        const cvol_vi entry = cvol_to_int(cvol_max(cvol_min(place, last), cvol_splat(0)));
        const int first = count;
        count += pack(list->numbers + count, list->entries + count, cvol_to_int(cvol_iota()) + i,
                      entry, visible);
        if (light->on)
            light_list(list, first, count, row, i, table, light);
    }
    list->count = count;
    list->from = light->on ? list->channels : table->entries[0];
}
