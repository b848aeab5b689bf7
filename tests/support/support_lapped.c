#include "test.h"

#include "support_lapped.h"

#include "array/truncate/account.h"
#include "random.h"
#include "support_split.h"
#include "transform/cell.h"
#include "transform/lap.h"

enum { CELL = CVOL_CELL };

static cvol_lap_box whole_box(const size_t dims[3])
{
    cvol_lap_box box = {.grid = CELL,
                        .stride = {1, (int64_t)dims[0], (int64_t)(dims[0] * dims[1])}};
    for (int a = 0; a < 3; a++)
        box.shape[a] = box.size[a] = (int64_t)dims[a];
    return box;
}

void support_lapped_samples(float *out, const cvol_array *array)
{
    const size_t *dims = array->grid.dims, B = (size_t)array->block;
    const cvol_lap_box box = whole_box(dims);
    float *cell = aligned_alloc(64, B * B * B * sizeof *cell);
    assert_non_null(cell);
    for (size_t i = 0; i < array->block_count; i++) {
        size_t at[3];
        cvol_block_origin(at, array, i);
        cvol_block_evaluate(cell, array, i);
        for (size_t z = at[2]; z < at[2] + B && z < dims[2]; z++)
            for (size_t y = at[1]; y < at[1] + B && y < dims[1]; y++)
                for (size_t x = at[0]; x < at[0] + B && x < dims[0]; x++)
                    out[x + dims[0] * (y + dims[1] * z)] =
                        cell[x - at[0] + B * (y - at[1] + B * (z - at[2]))];
    }
    free(cell);
    for (int a = 0; a < 3 && array->lapped; a++)
        cvol_lap_post(out, &box, a);
}

static void measure(cvol_array *array, const float *samples)
{
    const size_t count = cvol_grid_samples(&array->grid);
    float *real = malloc(count * sizeof *real);
    cvol_error_bound *error_bound = &array->error_bound;
    double squares = 0, energy = 0, most = 0;
    assert_non_null(real);
    support_lapped_samples(real, array);
    *error_bound = (cvol_error_bound){.value_min = (double)samples[0],
                                      .value_max = (double)samples[0]};
    for (size_t i = 0; i < count; i++) {
        const double exact = (double)samples[i], value = (double)real[i] + array->offset;
        squares += (value - exact) * (value - exact);
        energy += value * value;
        most = fmax(most, fabs(value - exact));
        error_bound->max_abs = fmax(error_bound->max_abs, fabs(value) * (1 + 1e-6));
        error_bound->value_min = fmin(error_bound->value_min, exact);
        error_bound->value_max = fmax(error_bound->value_max, exact);
    }
    error_bound->l2_error = sqrt(squares) + CVOL_ROUNDING * sqrt(squares + energy);
    error_bound->point_error = most + cvol_array_sample_rounding(array);
    free(real);
}

cvol_array *support_lapped(cvol_context *context, const float *samples, const size_t dims[3],
                           double offset, double step, int is_split, uint64_t seed)
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&grid);
    const cvol_lap_box box = whole_box(dims);
    random_state r = {seed};
    cvol_array *array;
    assert_int_equal(cvol_array_create(context, &array, &grid, CELL), CVOL_OK);
    array->offset = offset;
    array->step = step;
    array->lapped = 1;
    float *filtered = malloc(count * sizeof *filtered);
    float *cell = aligned_alloc(64, CVOL_CELL_SAMPLES * sizeof *cell);
    uint32_t *pool = malloc(2 * CVOL_CELL_SAMPLES * array->block_count * sizeof *pool), *at = pool;
    assert_true(filtered && cell && pool);
    for (size_t i = 0; i < count; i++)
        filtered[i] = (float)((double)samples[i] - offset);
    for (int a = 0; a < 3; a++)
        cvol_lap_pre(filtered, &box, a);
    for (size_t i = 0; i < array->block_count; i++) {
        cvol_block *block = &array->block_table[i];
        const uint16_t split = (uint16_t)random_below(&r, 512);
        block->split = is_split && split & 1 ? split : 0;
        cvol_block_gather(cell, filtered, &grid, CELL, i, 0);
        at = support_cell_code(array, i, at, cell);
    }
    assert_int_equal(cvol_array_adopt_pool(context, array, pool, (size_t)(at - pool)), CVOL_OK);
    free(filtered);
    free(cell);
    measure(array, samples);
    cvol_array_derive_figures(array);
    return array;
}
