/* Which rays a picture is drawn along: those of its pixels where these bring it nearer to the
 * volume, those of a lattice along the samples, which are quicker, where they do not
 * (doc/decisions/0010). */
#include "render/sheet/frame/policy.h"

#include <math.h>

#include "array/core/array.h"
#include "render/sheet/frame/frame.h"

/* Where pixels span more samples, the lattice has as many rays as the picture, and is softer. */
#define WIDEST_PIXEL 1.45
/* Where a sample's own error changes its opacity by so much, rays no longer tell. */
#define MOST_NOISE 0.095
/* Where it does by no more than this, what is left is what lies between the samples of a ray. */
#define FINE_NOISE 0.005
/* Of what is clear less is seen. */
#define EXACT_NOISE 0.001
/* Where what is clear bends by more than this between samples (opacity_curvature.h), light on it
 * shows which of its places were looked at, and so does an array that is nearly exact. */
#define MOST_CURVATURE 0.34
/* Of what is clear and bends slowly, of means and of extremes so many pixels can lie between two
 * rays; and between the points that means are of. */
#define TRANSLUCENT_APART 1.5
#define MEAN_PITCH 1.3
/* What is soft has no opacity above this, and bends slowly over such a part of all values. */
#define SOFT 0.55
#define SOFT_SMOOTH 0.05
/* Where its pixels span more than a sample, sheets lie up to so much further apart along a ray, for
 * each that they span more, and no more than so far: straight lines between them would be seen. */
#define SOFT_APART 1.7
#define SOFT_MOST_APART 1.8
/* Of pixels that span less the grain shows of what is lit at sheets alone. */
#define TURNING_PIXEL 0.55
/* A jump counts as a slope over such a part of all values. */
#define LEAST_SLOPE 0.2
/* A transfer function is looked at in so many steps, and so many before it begins and behind. */
#define STEPS 1024
#define BESIDE 64

/* The steepest rise or fall of opacity between two values. */
static double find_steepest(const cvol_transfer *transfer, double lo, double hi)
{
    const double least = LEAST_SLOPE * (hi - lo);
    double steepest = 0;
    for (size_t i = 1; i < transfer->count; i++) {
        const cvol_transfer_point *from = transfer->points + i - 1, *to = from + 1;
        if (to->value >= lo && from->value <= hi && to->opacity != from->opacity)
            steepest = fmax(steepest, fabs(to->opacity - from->opacity) /
                                          fmax(to->value - from->value, 1e-300));
    }
    return least > 0 ? fmin(steepest, 1 / least) : 0;
}

/* Whether opacity is as good as straight over every such part of what lies between two values, and
 * where the function begins and ends. */
static int is_smooth(const cvol_transfer *transfer, double lo, double hi, double part)
{
    const int half = (int)(part * STEPS / 2);
    double opacity[STEPS + 2 * BESIDE + 1];
    if (hi <= lo)
        return cvol_transfer_before(transfer, lo).opacity == cvol_transfer_at(transfer, lo).opacity;
    for (int t = 0; t <= STEPS + 2 * BESIDE; t++)
        opacity[t] = cvol_transfer_at(transfer, lo + (hi - lo) * (t - BESIDE) / STEPS).opacity;
    for (int t = half; t + half <= STEPS + 2 * BESIDE; t++)
        if (fabs(opacity[t] - 0.5 * (opacity[t - half] + opacity[t + half])) >
            (double)CVOL_FLAT_TOLERANCE)
            return 0;
    return 1;
}

cvol_transfer_traits cvol_sheet_traits_of(const cvol_array *array, const cvol_transfer *transfer)
{
    const double lo = array->error_bound.value_min, hi = array->error_bound.value_max;
    const double error = array->error_bound.l2_error /
                         sqrt((double)cvol_grid_samples(&array->grid));
    const double noise = error * find_steepest(transfer, lo, hi),
                 most = cvol_transfer_max_opacity(transfer, lo, hi);
    const double from = fmax(lo, transfer->points[0].value),
                 to = fmin(hi, transfer->points[transfer->count - 1].value);
    return (cvol_transfer_traits){
        .is_translucent = most <= CVOL_TRANSLUCENT && is_smooth(transfer, from, to, CVOL_SMOOTH),
        .is_soft = most <= SOFT && is_smooth(transfer, lo, hi, SOFT_SMOOTH),
        .is_noisy = noise > MOST_NOISE,
        .is_fine = noise <= FINE_NOISE,
        .is_exact = noise <= EXACT_NOISE,
        .curvature = -1};
}

int cvol_policy_needs_curvature(const cvol_transfer_traits *traits,
                                const cvol_render_options *options)
{
    return options->mode == CVOL_MODE_COMPOSITE && options->sheet.rays == CVOL_SHEET_RAYS_AUTO &&
           traits->is_translucent && (options->shading.on || traits->is_exact) &&
           traits->curvature < 0;
}

cvol_sheet_rays cvol_policy_suited(const cvol_transfer_traits *traits, const cvol_view *view,
                                   const cvol_render_options *options)
{
    if (options->sheet.rays != CVOL_SHEET_RAYS_AUTO)
        return options->sheet.rays;
    if (options->step_voxels > 0 || view->pixel > WIDEST_PIXEL * view->mean_spacing)
        return CVOL_SHEET_RAYS_PIXELS;
    const int shows_all = options->shading.on || traits->is_exact,
              is_smooth = traits->is_translucent &&
                          (!shows_all || traits->curvature <= MOST_CURVATURE);
    return traits->is_noisy || is_smooth ? CVOL_SHEET_RAYS_LATTICE : CVOL_SHEET_RAYS_PIXELS;
}

int cvol_policy_turn(const cvol_view *view)
{
    return view->pixel < TURNING_PIXEL * view->mean_spacing;
}

void cvol_policy_space(cvol_view *view, const cvol_transfer_traits *traits,
                       const cvol_render_options *options)
{
    if (options->mode == CVOL_MODE_COMPOSITE && traits->is_soft && !options->shading.on &&
        !(view->step > 0) && !view->planes)
        view->sheets_apart = fmin(1 + SOFT_APART * fmax(view->pixel / view->mean_spacing - 1, 0),
                                  SOFT_MOST_APART);
    if (options->sheet.rays != CVOL_SHEET_RAYS_AUTO || view->rays != 1 || view->planes)
        return;
    const int is_mean = options->mode == CVOL_MODE_XRAY,
              is_translucent = options->mode == CVOL_MODE_COMPOSITE && traits->is_translucent &&
                               cvol_policy_suited(traits, view, options) == CVOL_SHEET_RAYS_LATTICE;
    if (is_translucent || cvol_mode_is_grey(options->mode))
        view->apart = TRANSLUCENT_APART;
    if (is_mean)
        view->coarsest = MEAN_PITCH;
}
