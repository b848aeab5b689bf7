/* The rules that decide how a frame is drawn.
 *
 * Composites go through the picture's pixels (image order) wherever there are kernels for that:
 * nothing is resampled between the slices and the picture. Object-order rays, on a grid along the
 * samples, draw the rest; and unlit translucent objects of lossy files, in a half to a fifth of the
 * time (doc/decisions/0013). */
#include "render/sheet/frame/policy.h"

#include <math.h>

#include "array/core/array.h"
#include "render/sheet/frame/frame.h"

/* Above this opacity error, the array's own error hides that of coarse intervals. */
#define MAX_NOISE 0.095
/* Up to this opacity error, the sampling of translucent objects decides. */
#define EXACT_NOISE 0.001
/* Above this pixel size, in samples, object order has no fewer rays than the picture, and is
 * softer. */
#define WIDEST_PIXEL 1.45
/* The most pixels between two rays for translucent objects, means and extremes; and between the
 * points of means. */
#define SMOOTH_PITCH 1.5
#define MEAN_PITCH 1.3
/* Below this pixel size, light at slices alone shows a grain. */
#define GRAINY_PIXEL 0.55
/* A jump counts as a slope over this part of the value range. */
#define MIN_SLOPE 0.2
/* The number of steps in which a transfer function is examined, and of those before its start and
 * behind its end. */
#define STEPS 1024
#define OUTER_STEPS 64

/* The steepest rise or fall of opacity between two values. */
static double find_steepest(const cvol_transfer *transfer, double lo, double hi)
{
    const double least = MIN_SLOPE * (hi - lo);
    double steepest = 0;
    for (size_t i = 1; i < transfer->count; i++) {
        const cvol_transfer_point *from = transfer->points + i - 1, *to = from + 1;
        if (to->value >= lo && from->value <= hi && to->opacity != from->opacity)
            steepest = fmax(steepest, fabs(to->opacity - from->opacity) /
                                          fmax(to->value - from->value, 1e-300));
    }
    return least > 0 ? fmin(steepest, 1 / least) : 0;
}

/* Returns 1 if opacity is nearly linear over every such part of the range between two values, and
 * at the ends of the function. */
static int is_smooth(const cvol_transfer *transfer, double lo, double hi, double part)
{
    const int half = (int)(part * STEPS / 2);
    double opacity[STEPS + 2 * OUTER_STEPS + 1];
    if (hi <= lo)
        return cvol_transfer_before(transfer, lo).opacity == cvol_transfer_at(transfer, lo).opacity;
    for (int t = 0; t <= STEPS + 2 * OUTER_STEPS; t++)
        opacity[t] = cvol_transfer_at(transfer, lo + (hi - lo) * (t - OUTER_STEPS) / STEPS).opacity;
    for (int t = half; t + half <= STEPS + 2 * OUTER_STEPS; t++)
        if (fabs(opacity[t] - 0.5 * (opacity[t - half] + opacity[t + half])) >
            (double)CVOL_FLAT_TOLERANCE)
            return 0;
    return 1;
}

cvol_transfer_traits cvol_transfer_traits_of(const cvol_array *array, const cvol_transfer *transfer)
{
    const double lo = array->error_bound.value_min, hi = array->error_bound.value_max;
    const int is_exact = array->is_of_exact || (array->residual && !(array->max_error > 0));
    const double error = is_exact ? 0 : cvol_array_rms_error(array);
    const double most = cvol_transfer_max_opacity(transfer, lo, hi);
    const double from = fmax(lo, transfer->points[0].value),
                 to = fmin(hi, transfer->points[transfer->count - 1].value);
    return (cvol_transfer_traits){.is_translucent = most <= CVOL_TRANSLUCENT &&
                                                    is_smooth(transfer, from, to, CVOL_SMOOTH),
                                  .noise = error * find_steepest(transfer, lo, hi)};
}

/* Returns 1 if object-order rays, further apart than pixels, are close enough: unlit and
 * translucent objects of a lossy file. */
static int suits_object_order(const cvol_policy_case *in)
{
    return in->traits.is_translucent && in->traits.noise > EXACT_NOISE && !in->lit &&
           !(in->step > 0) && in->pixel <= WIDEST_PIXEL;
}

/* The ray order for a composite from this view. It is the same from every angle, so that nothing
 * changes while a view turns. */
static cvol_ray_order suited_order(const cvol_policy_case *in)
{
    if (in->asked != CVOL_RAY_ORDER_AUTO)
        return in->asked;
    return suits_object_order(in) ? CVOL_RAY_ORDER_OBJECT : CVOL_RAY_ORDER_IMAGE;
}

/* Returns 1 if int16 samples can be drawn. */
static int has_int16(const cvol_policy_case *in)
{
    return in->cpu == CVOL_CPU_AVX512 && in->has_range && !in->perspective && !in->is_wide &&
           in->masked != CVOL_SHEET_SOME_VOID;
}

/* Returns 1 if there are image-order kernels for the case. */
static int has_image_order(const cvol_policy_case *in)
{
    return in->mode == CVOL_MODE_COMPOSITE && !in->is_oblique && !in->is_wide && !in->level &&
           !in->perspective && in->rays == 1 && in->masked != CVOL_SHEET_SOME_VOID &&
           (!in->lit || (!in->has_depth && !in->is_thin));
}

static cvol_sample_type choose_samples(const cvol_policy_case *in, cvol_ray_order order)
{
    if (!has_int16(in))
        return CVOL_SAMPLES_FLOAT;
    if (in->mode == CVOL_MODE_MIP || in->mode == CVOL_MODE_MIN)
        return in->level ? CVOL_SAMPLES_FLOAT : CVOL_SAMPLES_INT16;
    if (in->mode != CVOL_MODE_COMPOSITE)
        return CVOL_SAMPLES_FLOAT;
    if (in->lit)
        return order == CVOL_RAY_ORDER_IMAGE && in->fits_lit_int16 ? CVOL_SAMPLES_INT16
                                                                   : CVOL_SAMPLES_FLOAT;
    return in->has_depth || in->counts ? CVOL_SAMPLES_FLOAT : CVOL_SAMPLES_INT16;
}

cvol_policy cvol_policy_choose(const cvol_policy_case *in)
{
    const int is_image_order = suited_order(in) == CVOL_RAY_ORDER_IMAGE && has_image_order(in);
    cvol_policy out = {.order = is_image_order ? CVOL_RAY_ORDER_IMAGE : CVOL_RAY_ORDER_OBJECT,
                       .rays_apart = 1,
                       .coarsest = CVOL_COARSEST_PITCH};
    const int is_smooth = cvol_mode_is_grey(in->mode) ||
                          (in->mode == CVOL_MODE_COMPOSITE && suits_object_order(in));
    if (is_smooth && in->asked == CVOL_RAY_ORDER_AUTO && in->rays == 1 && !in->planes) {
        out.rays_apart = SMOOTH_PITCH;
        if (in->mode == CVOL_MODE_XRAY)
            out.coarsest = MEAN_PITCH;
    }
    if (!is_image_order)
        out.intervals = in->traits.noise > MAX_NOISE ? CVOL_INTERVALS_COARSE
                        : !in->lit                   ? CVOL_INTERVALS_COARSE_IF_TRANSLUCENT
                                                     : CVOL_INTERVALS_FINE;
    /* Image-order rays already sample opaque functions more densely. */
    out.gradient_interpolation = in->lit && in->pixel < GRAINY_PIXEL &&
                                 (!is_image_order || in->traits.is_translucent);
    out.samples = choose_samples(in, out.order);
    return out;
}
