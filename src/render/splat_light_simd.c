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

void CVOL_SIMD(cvol_splat_list_make)(cvol_splat_list *list, const cvol_splat_row *row, int begin,
                                     int end, const cvol_splat_table *table,
                                     const cvol_splat_light *light)
{
    int count = 0;
    float *channels = list->channels;
    const cvol_vf last = cvol_splat(CVOL_SPLAT_ENTRIES - 1);
    for (int i = begin; i < end; i += CVOL_LANES) {
        const cvol_vf values = cvol_load(row->samples + i);
        const cvol_vi visible = (values >= table->visible_from) & (values <= table->visible_to) &
                                (cvol_iota() < (float)(end - i));
        if (!cvol_any(visible))
            continue;
        cvol_vf factor = {0}, gloss = {0};
        if (light->shade)
            illuminate(&factor, &gloss, row, i, light);
        const cvol_vf place = (values - table->from) * table->scale + 0.5f;
        const cvol_vi entry = cvol_to_int(cvol_max(cvol_min(place, last), cvol_splat(0)));
        for (int lane = 0; lane < CVOL_LANES; lane++) {
            const float *from = table->entries[entry[lane]];
            if (!visible[lane] || !(from[3] > 0))
                continue;
            for (int c = 0; c < 3; c++)
                channels[c] = light->shade ? from[c] * factor[lane] + from[3] * gloss[lane]
                                           : from[c];
            channels[3] = from[3];
            list->numbers[count++] = i + lane;
            channels += CVOL_SPLAT_CHANNELS;
        }
    }
    list->count = count;
}
