/* Which rays a picture is drawn along: those of its pixels where these bring it nearer to the
 * volume, those of a lattice along the samples, which are quicker, where they do not
 * (doc/decisions/0010). */
#include "render/sheet_rays.h"

#include <math.h>

#include "array/array.h"

/* Matter that lets less through has edges as sharp as a picture's pixels. */
#define MOST_CLEAR 0.45
/* Where pixels span more samples, the lattice has as many rays as the picture, and is softer. */
#define WIDEST_PIXEL 1.45
/* Where a sample's own error changes its opacity by so much, rays no longer tell. */
#define MOST_NOISE 0.095
/* A jump counts as a slope over such a part of all values. */
#define LEAST_SLOPE 0.2

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

cvol_sheet_rays cvol_sheet_rays_suited(const cvol_array *array, const cvol_transfer *transfer,
                                       const cvol_view *view, const cvol_render_options *options)
{
    if (options->sheet.rays != CVOL_SHEET_RAYS_AUTO)
        return options->sheet.rays;
    const double lo = array->range_min, hi = array->range_max;
    const double error = array->ledger.l2_error / sqrt((double)cvol_grid_samples(&array->grid));
    if (options->step_voxels > 0 || view->pixel > WIDEST_PIXEL * view->mean_spacing)
        return CVOL_SHEET_RAYS_PIXELS;
    if (error * find_steepest(transfer, lo, hi) > MOST_NOISE)
        return CVOL_SHEET_RAYS_LATTICE;
    if (options->shading.on || cvol_transfer_max_opacity(transfer, lo, hi) > MOST_CLEAR)
        return CVOL_SHEET_RAYS_PIXELS;
    return CVOL_SHEET_RAYS_LATTICE;
}
