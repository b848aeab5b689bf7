/* Whole arrays of tests. */
#include "test.h"

#include "support_whole.h"

#include "transform/whole.h"

double *support_doubles(size_t count)
{
    double *out = calloc(count ? count : 1, sizeof *out);
    assert_non_null(out);
    return out;
}

double support_distance(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

double support_norm(const double *a, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * a[i];
    return sqrt(sum);
}

double *support_whole_samples(const cvol_array *array)
{
    const size_t *dims = array->grid.dims, N = cvol_grid_samples(&array->grid);
    double *slots = support_doubles(N), *samples = support_doubles(N);
    float *floats = malloc(N * sizeof *floats);
    assert_non_null(floats);
    cvol_spectrum_scatter(floats, &array->whole, dims);
    for (size_t i = 0; i < N; i++)
        slots[i] = (double)floats[i];
    cvol_whole_inverse_reference(array->transform, samples, slots, dims);
    free(floats);
    free(slots);
    return samples;
}

support_whole support_whole_make(cvol_context *context, random_state *r, cvol_transform transform,
                                 int rank, const size_t dims[3], const size_t low[3], double share,
                                 double offset)
{
    support_whole w;
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const size_t N = cvol_grid_samples(&grid);
    assert_int_equal(cvol_array_create_as(context, &w.array, &grid, rank, transform, 0), CVOL_OK);
    w.exact = support_doubles(N);
    double *slots = support_doubles(N);
    cvol_error_bound *error_bound = &w.array->error_bound;
    *error_bound = (cvol_error_bound){.value_min = (double)INFINITY,
                                      .value_max = -(double)INFINITY};
    for (size_t i = 0; i < N; i++) {
        w.exact[i] = offset + random_signed(r);
        error_bound->value_min = fmin(error_bound->value_min, w.exact[i]);
        error_bound->value_max = fmax(error_bound->value_max, w.exact[i]);
    }
    cvol_whole_forward_reference(transform, slots, w.exact, dims);

    cvol_spectrum *s = &w.array->whole;
    assert_int_equal(cvol_spectrum_start(context, s, transform, dims, low), CVOL_OK);
    assert_int_equal(cvol_spectrum_reserve(context, s, N), CVOL_OK);
    for (size_t i = 0; i < N; i++) {
        const size_t place[3] = {i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]};
        size_t index[3];
        int inside = s->low_count != 0;
        for (int a = 0; a < 3 && inside; a++) {
            index[a] = cvol_box_index(place[a], s->low[a], s->box[a], dims[a]);
            inside = index[a] != SIZE_MAX;
        }
        if (inside) {
            s->low_values[index[0] + s->box[0] * (index[1] + s->box[1] * index[2])] = (float)
                slots[i];
        } else if (random_signed(r) < 2 * share - 1) {
            s->places[s->sparse_count] = (uint32_t)i;
            s->values[s->sparse_count++] = (float)slots[i];
        }
    }
    double *kept = support_whole_samples(w.array);
    for (size_t i = 0; i < N; i++)
        error_bound->max_abs = fmax(error_bound->max_abs, fabs(kept[i]));
    error_bound->l2_error = support_distance(kept, w.exact, N);
    free(kept);
    free(slots);
    return w;
}

void support_whole_free(support_whole *w)
{
    cvol_array_free(w->array);
    free(w->exact);
    memset(w, 0, sizeof *w);
}
