/* Classification and illumination of a row of samples, for which all that can be seen are listed.
 *
 * Whole vectors are passed over if none of their samples is visible. The gradient is one of
 * central differences in the world; at the volume's faces a difference is of half the length.
 */
#include "base/vector.h"
#include "render/splat.h"

#include <math.h>

CVOL_INLINE cvol_vf square_root(cvol_vf v)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_sqrt_ps((__m512)v);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_sqrt_ps((__m256)v);
#else
    for (int lane = 0; lane < CVOL_LANES; lane++)
        v[lane] = sqrtf(v[lane]);
    return v;
#endif
}

CVOL_INLINE cvol_vf dot(const cvol_vf a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* What light makes of the samples from i on: a factor of their colour, and what is added to it. */
CVOL_INLINE void illuminate(cvol_vf *factor, cvol_vf *gloss, const cvol_splat_row *row, int i,
                            const cvol_splat_light *light)
{
    const cvol_vf gradient[3] = {
        (cvol_load(row->samples + i + 1) - cvol_load(row->samples + i - 1)) *
            light->inverse_spacing[0],
        (cvol_load(row->below + i) - cvol_load(row->above + i)) * light->inverse_spacing[1],
        (cvol_load(row->behind + i) - cvol_load(row->before + i)) * light->inverse_spacing[2]};
    const cvol_vf square = gradient[0] * gradient[0] + gradient[1] * gradient[1] +
                           gradient[2] * gradient[2];
    const cvol_vi sloped = square > 1e-30f;
    const cvol_vf inverse = 1 / square_root(cvol_max(square, cvol_splat(1e-30f)));
    const cvol_vi away = dot(gradient, light->eye) < 0;
    cvol_vf lit = dot(gradient, light->light) * inverse;
    cvol_vf half = dot(gradient, light->halfway) * inverse;
    lit = cvol_select(away, -lit, lit);
    half = cvol_select(away, -half, half);
    lit = cvol_select(sloped, lit, cvol_splat(light->facing_light));
    half = cvol_select(sloped, half, cvol_splat(light->facing_halfway));
    *factor = CVOL_SPLAT_AMBIENT + CVOL_SPLAT_DIFFUSE * cvol_max(lit, cvol_splat(0));
    half = cvol_max(half, cvol_splat(0));
    for (int square_again = 0; square_again < 5; square_again++)
        half *= half;
    *gloss = CVOL_SPLAT_SPECULAR * half;
}

/* Stores what of numbers and entries is visible, one after the other; how many that are. */
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

/* Lit channels of the samples that were listed from `first` on, which lie within a vector from i.
 */
CVOL_INLINE void light_list(cvol_splat_list *list, int first, int end, const cvol_splat_row *row,
                            int i, const cvol_splat_table *table, const cvol_splat_light *light)
{
    cvol_vf factor, gloss;
    illuminate(&factor, &gloss, row, i, light);
    for (int n = first; n < end; n++) {
        const float *from = table->entries[list->entries[n]];
        float *to = list->channels + CVOL_SPLAT_CHANNELS * n;
        const int lane = list->numbers[n] - i;
        for (int c = 0; c < 3; c++)
            to[c] = from[c] * factor[lane] + from[3] * gloss[lane];
        to[3] = from[3];
        list->entries[n] = n;
    }
}

void CVOL_SIMD(cvol_splat_list_make)(cvol_splat_list *list, const cvol_splat_row *row, int begin,
                                     int end, const cvol_splat_table *table,
                                     const cvol_splat_light *light)
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
        if (light->shade)
            light_list(list, first, count, row, i, table, light);
    }
    list->count = count;
    list->from = light->shade ? list->channels : table->entries[0];
}
