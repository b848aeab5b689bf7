/* Phong's model (cvol_shading) for CVOL_LANES gradients.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_VIEW_PHONG_H
#define CVOL_RENDER_VIEW_PHONG_H

#include <math.h>

#include "base/vector.h"
#include "render/view/light.h"

/* The effect of light on a classified sample: a factor of its colour, an added term, and its
 * density. */
typedef struct lit_sample {
    cvol_vf factor, gloss, thickness;
    cvol_vf reach; /* the part of the light that reaches it, if the factor does not include it */
} lit_sample;

CVOL_INLINE cvol_vf inverse_root(cvol_vf v)
{
#if defined(__AVX512F__)
    const cvol_vf guess = (cvol_vf)_mm512_rsqrt14_ps((__m512)v);
    return guess * (1.5f - 0.5f * v * guess * guess);
#elif defined(__AVX2__)
    const cvol_vf guess = (cvol_vf)_mm256_rsqrt_ps((__m256)v);
    return guess * (1.5f - 0.5f * v * guess * guess);
#else
    return 1 / cvol_sqrt(v);
#endif
}

CVOL_INLINE cvol_vf dot(const cvol_vf a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* v^n, n > 0 */
CVOL_INLINE cvol_vf power(cvol_vf v, int n)
{
    while (!(n & 1)) {
        v *= v;
        n >>= 1;
    }
    cvol_vf product = v;
    while (n >>= 1) {
        v *= v;
        if (n & 1)
            product *= v;
    }
    return product;
}

/* `gradient` in units of the light (cvol_light.rise) per mean spacing, along the light's axes. */
CVOL_INLINE lit_sample illuminate(const cvol_vf gradient[3], const cvol_light *light)
{
    const cvol_vf square = gradient[0] * gradient[0] + gradient[1] * gradient[1] +
                           gradient[2] * gradient[2];
    const cvol_vf inverse = inverse_root(cvol_max(square, cvol_splat(1e-30f)));
    cvol_vf seen = dot(gradient, light->eye) * inverse;
    cvol_vf lit = dot(gradient, light->light) * inverse;
    /* cvol_light_turn */
    lit = cvol_select(seen < 0, -lit, lit);
    seen = cvol_max(seen, -seen);
    const cvol_vf both = seen * light->facing_light;
    lit = both + cvol_min(seen * (float)(1 / CVOL_EDGE_ON), cvol_splat(1)) * (lit - both);
    /* Flat matter faces the eye. */
    const cvol_vf flat = cvol_splat(light->flat + 1e-30f), flatness = flat / (square + flat);
    lit += flatness * (light->facing_light - lit);
    seen += flatness * (1 - seen);
    const cvol_vi dark = lit <= 0;
    lit = cvol_max(lit, cvol_splat(0));
    const cvol_vf along = cvol_max(2 * lit * seen - light->facing_light, cvol_splat(0));
    lit_sample out;
    out.factor = light->ambient + light->diffuse * lit + light->fill * seen;
    out.gloss = cvol_select(dark, cvol_splat(0), light->specular * power(along, light->shininess));
    out.thickness = out.reach = cvol_splat(1);
    if (light->thinning > 0)
        out.thickness = cvol_min(square * inverse * light->thinning, cvol_splat(1));
    return out;
}

#endif
