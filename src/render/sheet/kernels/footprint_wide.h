/* Reconstruction by filters wider than linear (reconstruction_filter.h): rows first, onto the
 * adjacent samples that some pixels see, then lanes.
 *
 * Cubic filters overshoot at edges. Their result is clamped to the smallest and the largest of the
 * 4 x 4 samples in the middle. So it lies within the ranges of blocks, which decide visibility, and
 * does not depend on skipping; and no edge has a halo.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_FOOTPRINT_WIDE_H
#define CVOL_RENDER_SHEET_KERNELS_FOOTPRINT_WIDE_H

#include "render/sheet/kernels/footprint.h"

/* Vectors of samples that CVOL_LANES pixels, at most a sample apart, see in a row. */
#define WIDE_VECTORS (CVOL_LANES < CVOL_FILTER_TAPS ? 3 : 2)

/* The weights of rows, and, for pixels as far apart as samples, of lanes. */
typedef struct wide_view {
    float rows[CVOL_FILTER_TAPS], lanes[CVOL_FILTER_TAPS];
} wide_view;

/* The position of CVOL_LANES pixels on a slice. */
typedef struct wide_place {
    const float *at; /* the first sample left of the first pixel, in the row before the line */
    cvol_vf offset;  /* of pixels from it, in samples */
    int unit;        /* they are a sample apart */
    ptrdiff_t row_stride, cover_at;
} wide_place;

CVOL_INLINE void find_wide_weights(float *weights, const cvol_reconstruction_filter *wide, float t)
{
    for (int i = 0; i < 2 + 2 * wide->reach; i++) {
        weights[i] = wide->factors[i][wide->degree];
        for (int d = wide->degree - 1; d >= 0; d--)
            weights[i] = weights[i] * t + wide->factors[i][d];
    }
}

CVOL_INLINE void make_wide_view(wide_view *out, const cvol_layer *layer, const line_view *view,
                                const cvol_sheet_view *sheet)
{
    find_wide_weights(out->rows, layer->wide, view->far_weight);
    if (layer->unit)
        find_wide_weights(out->lanes, layer->wide, (float)(sheet->lane_at - floor(sheet->lane_at)));
}

/* `near`: sample 0 of the row before the line, of pixels from `position` on. */
CVOL_INLINE wide_place find_wide_place(const cvol_layer *layer, const float *near, double position,
                                       double step)
{
    const double whole = floor(position);
    return (wide_place){near + (ptrdiff_t)whole,
                        (float)(position - whole) + cvol_iota() * (float)step, layer->unit,
                        layer->row_stride, layer->cover_at};
}

/* Sample index[k] of adjacent samples. */
CVOL_INLINE cvol_vf pick(const cvol_vf samples[WIDE_VECTORS], cvol_vi index)
{
#if CVOL_LANES < CVOL_FILTER_TAPS
    float all[WIDE_VECTORS * CVOL_LANES];
    cvol_vf out;
    memcpy(all, samples, sizeof all);
    for (int k = 0; k < CVOL_LANES; k++)
        out[k] = all[index[k]];
    return out;
#else
    return cvol_shuffle(samples[0], samples[1], index);
#endif
}

CVOL_INLINE cvol_vf wide_weight(const cvol_reconstruction_filter *wide, const wide_view *view,
                                int unit, int i, cvol_vf t)
{
    if (unit)
        return cvol_splat(view->lanes[i]);
    cvol_vf weight = cvol_splat(wide->factors[i][wide->degree]);
    for (int d = wide->degree - 1; d >= 0; d--)
        weight = weight * t + wide->factors[i][d];
    return weight;
}

/* The smallest and the largest of four adjacent ones. */
CVOL_INLINE void find_bounds(cvol_vf *lo, cvol_vf *hi, const cvol_vf least[WIDE_VECTORS],
                             const cvol_vf most[WIDE_VECTORS], cvol_vi first)
{
    *lo = pick(least, first);
    *hi = pick(most, first);
    for (int i = 1; i < 4; i++) {
        *lo = cvol_min(*lo, pick(least, first + i));
        *hi = cvol_max(*hi, pick(most, first + i));
    }
}

/* If all samples have a value. */
static __attribute__((noinline)) cvol_vf reconstruct_wide(const cvol_reconstruction_filter *wide,
                                                          const wide_view *view,
                                                          const wide_place *place)
{
    const int reach = wide->reach, taps = 2 + 2 * reach;
    const float *at = place->at - reach - reach * place->row_stride;
    cvol_vf sum[WIDE_VECTORS] = {{0}}, least[WIDE_VECTORS], most[WIDE_VECTORS];
    for (int v = 0; v < WIDE_VECTORS; v++)
        least[v] = most[v] = cvol_load(place->at - reach + v * CVOL_LANES);
    for (int i = 0; i < taps; i++, at += place->row_stride) {
        const int amidst = wide->overshoot && i >= reach - 1 && i <= reach + 2;
        for (int v = 0; v < WIDE_VECTORS; v++) {
            const cvol_vf samples = cvol_load(at + v * CVOL_LANES);
            sum[v] += view->rows[i] * samples;
            if (amidst) {
                least[v] = cvol_min(least[v], samples);
                most[v] = cvol_max(most[v], samples);
            }
        }
    }
    const cvol_vi index = cvol_to_int(place->offset);
    const cvol_vf t = place->offset - cvol_to_float(index);
    cvol_vf value = {0}, lo, hi;
    for (int i = 0; i < taps; i++)
        value += wide_weight(wide, view, place->unit, i, t) * pick(sum, index + i);
    if (!wide->overshoot)
        return value;
    find_bounds(&lo, &hi, least, most, index + (reach - 1));
    return cvol_min(cvol_max(value, lo), hi);
}

/* The same if some have none: *cover is the weight of those that have one. Cubic filters take the
 * linear filter's value, `mean` of cover *cover, in place of samples without one: with weights
 * below 0 the remaining samples could give any value. */
static __attribute__((noinline)) cvol_vf
reconstruct_wide_masked(cvol_vf *cover, const cvol_reconstruction_filter *wide,
                        const wide_view *view, const wide_place *place, cvol_vf mean)
{
    const int reach = wide->reach, taps = 2 + 2 * reach;
    const float *at = place->at - reach - reach * place->row_stride;
    const cvol_vf none = cvol_splat(3e38f);
    cvol_vf sum[WIDE_VECTORS] = {{0}}, weight[WIDE_VECTORS] = {{0}}, least[WIDE_VECTORS],
            most[WIDE_VECTORS];
    for (int v = 0; v < WIDE_VECTORS; v++) {
        least[v] = none;
        most[v] = -none;
    }
    for (int i = 0; i < taps; i++, at += place->row_stride) {
        const int amidst = i >= reach - 1 && i <= reach + 2;
        for (int v = 0; v < WIDE_VECTORS; v++) {
            const cvol_vf samples = cvol_load(at + v * CVOL_LANES),
                          covered = cvol_load(at + place->cover_at + v * CVOL_LANES);
            sum[v] += view->rows[i] * covered * samples;
            weight[v] += view->rows[i] * covered;
            if (amidst) {
                const cvol_vi is = covered >= MIN_WEIGHT;
                least[v] = cvol_min(least[v], cvol_select(is, samples, none));
                most[v] = cvol_max(most[v], cvol_select(is, samples, -none));
            }
        }
    }
    const cvol_vi index = cvol_to_int(place->offset);
    const cvol_vf t = place->offset - cvol_to_float(index);
    cvol_vf value = {0}, with = {0}, lo, hi;
    for (int i = 0; i < taps; i++) {
        const cvol_vf w = wide_weight(wide, view, place->unit, i, t);
        value += w * pick(sum, index + i);
        with += w * pick(weight, index + i);
    }
    if (!wide->overshoot) {
        *cover = with;
        return mean_of(value, with);
    }
    const cvol_vi is_covered_here = *cover >= MIN_WEIGHT;
    find_bounds(&lo, &hi, least, most, index + (reach - 1));
    value = cvol_min(cvol_max(value + mean * (1 - with), lo), hi);
    *cover = cvol_select(is_covered_here, cvol_min(cvol_max(with, cvol_splat(0)), cvol_splat(1)),
                         *cover);
    return cvol_select(is_covered_here, value, mean);
}

#endif
