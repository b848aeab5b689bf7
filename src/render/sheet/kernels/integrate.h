/* Intervals over which the transfer function changes much: the mean of the function over the values
 * of each part, from its integrals (cvol_sheet_table), after Engel, Kraus and Ertl, "High-quality
 * pre-integrated volume rendering using hardware-accelerated pixel shading", 2001. A part from t0
 * to t1 has the extinction and the colour
 *
 *     e = (E(t1) - E(t0)) / (t1 - t0),  c = (C(t1) - C(t0)) / (E(t1) - E(t0)),
 *
 * with E the integral of the extinction and C that of colour times extinction; its opacity over the
 * length w is 1 - exp(-w e).
 *
 * Only kernel files include this file, through classify.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_INTEGRATE_H
#define CVOL_RENDER_SHEET_KERNELS_INTEGRATE_H

#include "base/vector.h"
#include "render/sheet/frame/frame.h"

/* The parts of an interval. */
#define INTEGRATED_PARTS 4
/* The least difference of coordinates between two integrals. */
#define MIN_INTEGRATED 0.5f

/* The integrals up to a coordinate `at`; `before` and `behind`: its distance from the table. */
typedef struct table_integral {
    cvol_vi v[4];
    cvol_vf slope[4]; /* the function there */
    cvol_vf at, before, behind;
} table_integral;

CVOL_INLINE void find_integral(table_integral *out, const cvol_sheet_table *table, cvol_vf t)
{
    const cvol_vf size = cvol_splat(CVOL_TABLE_SIZE), zero = {0};
    const cvol_vf place = 0.5f * cvol_min(cvol_max(t, zero), size);
    const cvol_vi cell = cvol_to_int(cvol_min(place, cvol_splat(CVOL_INTEGRAL_CELLS - 1)));
    const cvol_vf part = place - cvol_to_float(cell);
    cvol_four ends[2][CVOL_LANES];
    cvol_vf v[2][4];
    for (int i = 0; i < CVOL_LANES; i++)
        for (int end = 0; end < 2; end++)
            memcpy(&ends[end][i], table->integral[cell[i] + end], sizeof ends[end][i]);
    for (int end = 0; end < 2; end++)
        cvol_transpose_fours(v[end], ends[end]);
    for (int k = 0; k < 4; k++) {
        const cvol_vf rise = cvol_to_float((cvol_vi)v[1][k] - (cvol_vi)v[0][k]);
        out->v[k] = (cvol_vi)v[0][k] + cvol_to_int(part * rise);
        out->slope[k] = 0.5f * table->integral_unit * rise;
    }
    out->at = t;
    out->before = cvol_min(t, zero);
    out->behind = cvol_max(t - size, zero);
}

/* The mean of the function between two coordinates: colour times extinction, and extinction. */
CVOL_INLINE void find_mean(cvol_vf mean[4], const cvol_sheet_table *table,
                           const table_integral *from, const table_integral *to)
{
    const cvol_vf rise = to->at - from->at;
    const cvol_vi apart = cvol_max(rise, -rise) >= MIN_INTEGRATED;
    const cvol_vf inverse = 1 / cvol_select(apart, rise, cvol_splat(1));
    const cvol_vf before = to->before - from->before, behind = to->behind - from->behind;
    for (int k = 0; k < 4; k++) {
        const cvol_vf all = table->integral_unit * cvol_to_float(to->v[k] - from->v[k]) +
                            before * table->extinction_before[k] +
                            behind * table->extinction_behind[k];
        mean[k] = cvol_max(cvol_select(apart, inverse * all, from->slope[k]), cvol_splat(0));
    }
}

/* exp(-x) for x from 0 on, within 2e-5. */
CVOL_INLINE cvol_vf negative_exp(cvol_vf x)
{
    const cvol_vf y = cvol_max(-1.44269504f * x, cvol_splat(-100));
    const cvol_vi whole = cvol_to_int(y + 128) - 128;
    const cvol_vf t = y - cvol_to_float(whole);
    const cvol_vf part = 1 +
                         t * (0.6930186f + t * (0.2414452f + t * (0.0519512f + t * 0.0135808f)));
    return (cvol_vf)((cvol_vi)part + (whole << 23));
}

/* (1 - exp(-x)) / x, and *transmittance = exp(-x). */
CVOL_INLINE cvol_vf absorbed_share(cvol_vf *transmittance, cvol_vf x)
{
    *transmittance = negative_exp(x);
    return cvol_select(x < 0.02f, 1 - x * (0.5f - x * (1.0f / 6)),
                       (1 - *transmittance) / cvol_max(x, cvol_splat(0.01f)));
}

/* The sum over an interval: colour, and the transmittance through it. */
typedef struct integrated {
    cvol_vf colour[3], transmittance;
    cvol_vf half; /* the share of the interval at which the transmittance passes `half_at` */
} integrated;

/* The distance of a parabola through the start, the middle and the end of an interval from the
 * straight lines between these, at one and at three quarters. */
CVOL_INLINE cvol_vf quarter_bow(cvol_vf start, cvol_vf middle, cvol_vf end)
{
    return 0.125f * (middle + middle - start - end);
}

/* Composites an interval of a relative length, through its start, its middle and its end. half_at:
 * see integrated. A separate function: it has many callers, and few intervals need it. */
static __attribute__((noinline)) void integrate_interval(integrated *out,
                                                         const cvol_sheet_table *table,
                                                         const cvol_vf through[3], cvol_vf length,
                                                         cvol_vf half_at)
{
    table_integral ends[2];
    out->transmittance = cvol_splat(1);
    out->half = cvol_splat(1);
    for (int k = 0; k < 3; k++)
        out->colour[k] = cvol_splat(0);
    find_integral(&ends[0], table, through[0]);
    const cvol_vf bow = quarter_bow(through[0], through[1], through[2]);
    const cvol_vf weight = (1.0f / INTEGRATED_PARTS) * length;
    for (int part = 1; part <= INTEGRATED_PARTS; part++) {
        const float place = 2 * (float)part / INTEGRATED_PARTS;
        const int late = place > 1;
        const float t = late ? place - 1 : place;
        cvol_vf value = through[late] + t * (through[late + 1] - through[late]);
        if (part % 2)
            value += bow;
        table_integral *from = &ends[(part - 1) & 1], *to = &ends[part & 1];
        cvol_vf mean[4], passed;
        find_integral(to, table, value);
        find_mean(mean, table, from, to);
        const cvol_vf share = out->transmittance * weight *
                              absorbed_share(&passed, weight * mean[3]);
        for (int k = 0; k < 3; k++)
            out->colour[k] += share * mean[k];
        const cvol_vf before = out->transmittance;
        out->transmittance *= passed;
        const cvol_vi passes = (before > half_at) & (out->transmittance <= half_at);
        const cvol_vf within = (before - half_at) /
                               cvol_max(before - out->transmittance, cvol_splat(1e-20f));
        out->half = cvol_select(passes, ((float)(part - 1) + within) * (1.0f / INTEGRATED_PARTS),
                                out->half);
    }
}

#endif
