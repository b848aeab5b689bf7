/* The table of a frame of the sheet engine, and the format of its samples. */
#include "render/sheet/frame_values.h"

#include <math.h>

#include "render/sheet/band/band.h"
#include "render/sheet/frame/plan.h"
#include "render/sheet/frame/table.h"

/* ---- int16 samples -------------------------------------------------------------------------- */

/* The mean error, in int16 units, from which maxima and minima are drawn from int16: the rounding
 * of int16 is then a small part of it. */
#define INT16_ERROR_MIN 4

/* The int16 format of maxima and minima: if pixels and samples are equally far apart, and the
 * array's error is larger than an int16 unit. */
static cvol_int16_scale choose_int16_extremes(const cvol_sheet_plan *plan, const cvol_array *array)
{
    const double range = array->range_max - array->range_min;
    /* Between samples, if points are fewer, values overshoot. */
    const double beyond = plan->lapped                      ? CVOL_INT16_MAX / 2.8
                          : cvol_extremes_have_bounds(plan) ? 64
                                                            : CVOL_INT16_MAX / 8.0;
    const double scale = (CVOL_INT16_MAX - 2 * beyond) / range;
    if (plan->du != plan->pitch_lane || !(cvol_array_rms_error(array) * scale >= INT16_ERROR_MIN))
        return (cvol_int16_scale){0, 0};
    return (cvol_int16_scale){(float)scale,
                              (float)(beyond - scale * (array->range_min - array->offset))};
}

/* The int16 format of an array's samples. Samples that the filter across faces has not yet mixed
 * may lie outside of the range. */
static cvol_int16_scale int16_scale_of(const cvol_array *array, int lapped)
{
    const double least = lapped ? CVOL_INT16_MAX / 2.8 : 64, most = CVOL_INT16_MAX - least;
    const double scale = (most - least) / (array->range_max - array->range_min);
    return (cvol_int16_scale){(float)scale,
                              (float)(least - scale * (array->range_min - array->offset))};
}

/* Light depends on the direction of a gradient, whatever its length: where samples hardly change,
 * int16 shows terraces. The array's own error covers them if it is this number of int16 units. */
#define LIT_INT16_ERROR_MIN 8

int cvol_frame_fits_lit_int16(const cvol_array *array, int lapped)
{
    return cvol_array_rms_error(array) * (double)int16_scale_of(array, lapped).scale >=
           LIT_INT16_ERROR_MIN;
}

/* The int16 format of a composite, if int16 samples separate the table's entries. */
static cvol_int16_scale choose_int16(cvol_sheet_table *table, const cvol_sheet_plan *plan,
                                     const cvol_array *array)
{
    const cvol_int16_scale int16 = int16_scale_of(array, plan->lapped);
    if (plan->lit)
        return !plan->image_order || cvol_sheet_plan_fits_lit_int16(plan)
                   ? int16
                   : (cvol_int16_scale){0, 0};
    cvol_int16_table_fill(&table->int16, table, int16.scale, int16.offset);
    return table->int16.usable ? int16 : (cvol_int16_scale){0, 0};
}

/* ---- the table ------------------------------------------------------------------------------ */

/* Table coordinates for a surface: as for a function that is opaque from its value on. */
static int set_surface(cvol_context *context, cvol_sheet_table *table, cvol_visibility *visibility,
                       const cvol_array *array, const cvol_render_options *options)
{
    const cvol_surface *surface = &options->surface;
    const cvol_transfer_point points[2] = {{surface->value, 0, 0, 0, 0},
                                           {surface->value, 0, 0, 0, 1}};
    cvol_transfer *step;
    const int code = cvol_transfer_create(context, &step, points, 2);
    if (code)
        return code;
    cvol_visibility_make(visibility, array, step);
    cvol_sheet_table_fill(table, array, step, 1, 0);
    table->at = (float)(surface->value - array->offset - (double)table->from) * table->scale;
    table->visible_from = table->at;
    table->visible_to = INFINITY;
    for (int c = 0; c < 3; c++)
        table->colour[c] = (float)surface->colour[c];
    double window[2];
    cvol_window_of_cuts(window, options, array->error_bound.value_min,
                        array->error_bound.value_max);
    const double origin = array->offset + (double)table->from;
    table->cut_black = (float)(window[0] - origin) * table->scale;
    table->cut_scale = 1 / ((float)(window[1] - window[0]) * table->scale);
    cvol_transfer_free(step);
    return CVOL_OK;
}

int cvol_frame_values_set(cvol_context *context, cvol_sheet_table *table, cvol_sheet_plan *plan,
                          cvol_visibility *by_surface, const cvol_array *array,
                          const cvol_transfer *transfer, double noise,
                          const cvol_render_options *options, const cvol_policy *policy)
{
    const int wants_int16 = policy->samples == CVOL_SAMPLES_INT16;
    table->is_surface = options->mode == CVOL_MODE_ISO;
    plan->int16 = (cvol_int16_scale){0, 0};
    if (table->is_surface)
        return set_surface(context, table, by_surface, array, options);
    if (cvol_mode_is_grey(options->mode)) {
        if (wants_int16)
            plan->int16 = choose_int16_extremes(plan, array);
        return CVOL_OK;
    }
    cvol_sheet_table_fill(table, array, transfer, plan->distance / plan->parts, noise);
    if (policy->intervals == CVOL_INTERVALS_COARSE ||
        (policy->intervals == CVOL_INTERVALS_COARSE_IF_TRANSLUCENT && table->is_translucent))
        table->flat = table->flat_coarse;
    const double shear = plan->pitch_sheet * (fabs(plan->shear_lane) / plan->pitch_lane +
                                              fabs(plan->shear_row) / plan->pitch_row);
    if (plan->pitch_sheet > 1) /* what lies between two slices is unknown: no finer parts */
        table->midpoint = table->midpoint_ramp = table->flat;
    else if (plan->image_order)
        cvol_sheet_table_image_order(table, shear, noise, plan->lit);
    if (wants_int16 && plan->parts == 1)
        plan->int16 = choose_int16(table, plan, array);
    return CVOL_OK;
}
