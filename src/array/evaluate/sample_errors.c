/* Bounds of the errors of decoded samples: sample_errors.h. */
#include "array/evaluate/sample_errors.h"

#include <math.h>

/* A float is off by so much, relative to its size, after it was stored. */
#define ROUNDED 1e-6

/* The rounding of exact samples to floats. */
static double float_rounding(const cvol_array *array)
{
    const double largest = cvol_error_bound_largest(&array->error_bound);
    const int fits = array->grid.type == CVOL_FLOAT32 ||
                     (cvol_type_is_integer(array->grid.type) && largest <= 1 << 24);
    return fits ? 0 : ldexp(largest, -24);
}

void cvol_array_sample_errors(double *all, double *each, const cvol_array *array)
{
    const int is_integer = cvol_type_is_integer(array->grid.type);
    *all = array->error_bound.l2_error;
    *each = (double)INFINITY;
    if (array->residual) { /* samples as they are stored */
        *each = array->max_error + float_rounding(array);
        *all = *each * sqrt((double)cvol_grid_samples(&array->grid));
    } else if (array->measured) { /* in the stored type: integers were rounded */
        *each = array->max_error + (is_integer ? 0.5 : 0) +
                ROUNDED * cvol_error_bound_largest(&array->error_bound);
    }
}
