/* The common part of interpolation: terms, and properties of the array that they define. */
#include "array/evaluate/interpolated.h"

#include <math.h>
#include <stdlib.h>

#include "array/evaluate/interpolant.h"
#include "base/context.h"
#include "transform/fft.h"
#include "transform/whole.h"

#define MAX_EVALUATED ((size_t)1 << 24)

int cvol_interpolated_check_values(cvol_context *context, const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return cvol_fail(context, CVOL_ERROR_DATA, "value %zu is %g", i, (double)values[i]);
    return CVOL_OK;
}

/* The least and the largest sample, evaluated. */
static int evaluate_bounds(cvol_context *context, double bounds[2], const cvol_array *array)
{
    const size_t *dims = array->grid.dims, count = cvol_grid_samples(&array->grid);
    float *samples = cvol_fft_allocate(count);
    if (!samples)
        return cvol_fail_memory(context, count * sizeof *samples, "the samples");
    cvol_spectrum_scatter(samples, &array->whole, dims);
    int code = cvol_whole_inverse(context, array->transform, samples, samples, dims);
    if (!code) {
        float lo = samples[0], hi = samples[0];
        for (size_t i = 1; i < count; i++) {
            lo = samples[i] < lo ? samples[i] : lo;
            hi = samples[i] > hi ? samples[i] : hi;
        }
        bounds[0] = (double)lo;
        bounds[1] = (double)hi;
    }
    free(samples);
    return code;
}

/* The constant term, plus and minus the most that all others can add. */
static void sum_bounds(double bounds[2], const cvol_array *array)
{
    const cvol_spectrum *whole = &array->whole;
    const double samples = (double)cvol_grid_samples(&array->grid);
    const double factor = array->transform == CVOL_DCT ? ldexp(1, array->rank) : 2;
    double constant = whole->low_count ? (double)whole->low_values[0] : 0, sum = 0;
    for (size_t i = 1; i < whole->low_count; i++)
        sum += fabs((double)whole->low_values[i]);
    for (size_t i = 0; i < whole->sparse_count; i++)
        if (whole->places[i])
            sum += fabs((double)whole->values[i]);
        else
            constant = (double)whole->values[i];
    bounds[0] = constant / sqrt(samples) - sum * sqrt(factor / samples);
    bounds[1] = constant / sqrt(samples) + sum * sqrt(factor / samples);
}

int cvol_interpolated_finish(cvol_context *context, cvol_array *array, double dropped)
{
    const double norm = sqrt(cvol_spectrum_energy(&array->whole));
    double bounds[2] = {0, 0};
    if (cvol_grid_samples(&array->grid) > MAX_EVALUATED) {
        sum_bounds(bounds, array);
    } else {
        int code = evaluate_bounds(context, bounds, array);
        if (code)
            return code;
    }
    cvol_error_bound *error_bound = &array->error_bound;
    *error_bound = (cvol_error_bound){.max_abs = fmax(fabs(bounds[0]), fabs(bounds[1]))};
    cvol_error_bound_drop(error_bound, dropped, norm + dropped, (double)INFINITY);
    error_bound->value_min = bounds[0] - error_bound->l2_error;
    error_bound->value_max = bounds[1] + error_bound->l2_error;
    cvol_array_derive_figures(array);
    return cvol_error_bound_check(context, error_bound, "interpolating");
}

int cvol_interpolated_set(cvol_context *context, cvol_array *array, const uint32_t *places,
                          const double *values, size_t count)
{
    int code = cvol_spectrum_reserve(context, &array->whole, count);
    if (code)
        return code;
    for (size_t i = 0; i < count; i++) {
        array->whole.places[i] = places[i];
        array->whole.values[i] = (float)values[i];
    }
    array->whole.sparse_count = count;
    return CVOL_OK;
}

void cvol_interpolated_column(double *column, cvol_transform transform, size_t n, size_t place,
                              double start, double step, size_t count)
{
    const size_t dims[3] = {n, 1, 1}, at[3] = {place, 0, 0};
    double g[2], phi[2];
    cvol_slot_factor(g, transform, at, dims);
    for (size_t j = 0; j < count; j++) {
        cvol_axis_value(phi, transform, place, start + (double)j * step, n);
        column[j] = g[0] * phi[0] - g[1] * phi[1];
    }
}
