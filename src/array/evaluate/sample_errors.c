/* Bounds of the errors of decoded samples: sample_errors.h. */
#include "array/evaluate/sample_errors.h"

#include <math.h>

/* A float is off by so much, relative to its size, after it was stored. */
#define ROUNDED 1e-6

static int fits_float(const cvol_array *array)
{
    return array->grid.type == CVOL_FLOAT32 ||
           (cvol_type_is_integer(array->grid.type) &&
            cvol_error_bound_largest(&array->error_bound) <= 1 << 24);
}

int cvol_array_has_exact_background(const cvol_array *array)
{
    return cvol_mask_is_background(array->mask) && (array->measured || array->residual);
}

double cvol_array_stored_error(const cvol_array *array)
{
    const double largest = cvol_error_bound_largest(&array->error_bound) + array->max_error;
    if (array->residual)
        return array->max_error;
    return array->max_error + (fits_float(array) ? 0 : ROUNDED * largest);
}

void cvol_array_sample_errors(double *all, double *each, const cvol_array *array)
{
    const int is_integer = cvol_type_is_integer(array->grid.type);
    *all = array->error_bound.l2_error;
    *each = cvol_error_bound_point(&array->error_bound);
    if (array->residual) { /* samples as they are stored */
        *each = array->max_error;
        *all = *each * sqrt((double)cvol_grid_samples(&array->grid));
    } else if (array->measured) { /* in the stored type: integers were rounded */
        const double measured = array->max_error + (is_integer ? 0.5 : 0) +
                                ROUNDED * cvol_error_bound_largest(&array->error_bound);
        *each = fmin(*each, measured);
    }
}
