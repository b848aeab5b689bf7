/* The sample type that an array evaluates to. */
#include <math.h>

#include "array/core/array.h"
#include "base/context.h"

/* The smallest type that holds lo .. hi; integers of one sign first. */
static cvol_type type_for(double lo, double hi)
{
    static const cvol_type types[] = {CVOL_UINT8,  CVOL_INT8,  CVOL_UINT16, CVOL_INT16,
                                      CVOL_UINT32, CVOL_INT32, CVOL_FLOAT32};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        double least, largest;
        cvol_type_get_range(&least, &largest, types[i]);
        if (lo >= least && hi <= largest)
            return types[i];
    }
    return CVOL_FLOAT64;
}

/* Counts that the background, which was `before`, was rounded to the new type. */
static void count_background(cvol_array *array, double before)
{
    const double off = fabs(cvol_array_background(array) - before);
    cvol_error_bound_widen(&array->error_bound, off * sqrt((double)cvol_mask_samples(array->mask)),
                           off);
    array->error_bound.max_abs += off;
}

int cvol_array_set_type(cvol_context *context, cvol_array *array, cvol_type type)
{
    if (!cvol_type_name(type))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a sample type", (int)type);
    const int integer = cvol_type_is_integer(type);
    double lo = array->error_bound.value_min, hi = array->error_bound.value_max, least, largest;
    if (integer) {
        lo = floor(lo);
        hi = ceil(hi);
    }
    cvol_type_get_range(&least, &largest, type);
    if (lo < least || hi > largest)
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "values may reach %.10g .. %.10g, %s holds %.10g .. %.10g; use --type %s",
                         lo, hi, cvol_type_name(type), least, largest,
                         cvol_type_name(type_for(lo, hi)));
    if (array->grid.type == type)
        return CVOL_OK;
    const double background = cvol_array_background(array);
    if (array->mask) {
        cvol_fills fills = *cvol_mask_fills(array->mask);
        if (!cvol_fills_convert(&fills, array->grid.type, type))
            return cvol_fail(context, CVOL_ERROR_DATA,
                             "samples without a value have %g, which %s cannot hold; use --type %s",
                             cvol_fills_value(cvol_mask_fills(array->mask), 0, array->grid.type),
                             cvol_type_name(type), cvol_type_name(CVOL_FLOAT32));
        const int code = cvol_mask_set_fills(context, &array->mask, &fills);
        if (code)
            return code;
    }
    cvol_mask *mask = array->mask;
    array->mask = NULL;
    cvol_array_drop_residual(array); /* its samples have the old type */
    array->mask = mask;
    array->grid.type = type;
    array->error_bound.value_min = lo;
    array->error_bound.value_max = hi;
    if (cvol_mask_is_background(mask))
        count_background(array, background);
    cvol_array_derive_figures(array);
    return CVOL_OK;
}
