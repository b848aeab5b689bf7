/* Bricks of cells hold, to the bit, the values that gathering from the pre-filtered volume gives,
 * for any brick and any slab. */
#include "test.h"

#include "array/block/brick.h"
#include "cvol/cvol.h"
#include "random.h"
#include "transform/lap.h"

static void *fill(random_state *r, cvol_type type, size_t count)
{
    const size_t size = cvol_type_size(type);
    uint8_t *bytes = malloc(count * size);
    assert_non_null(bytes);
    for (size_t i = 0; i < count; i++) {
        const double value = 100 * random_signed(r);
        const uint64_t word = random_u64(r);
        const float single = (float)value;
        memcpy(bytes + i * size,
               type == CVOL_FLOAT32   ? (const void *)&single
               : type == CVOL_FLOAT64 ? (const void *)&value
                                      : (const void *)&word,
               size);
    }
    return bytes;
}

/* All cells of the volume, converted to floats and filtered as a whole. */
static float *expected_cells(const cvol_array *array, const void *samples)
{
    const cvol_grid *grid = &array->grid;
    const size_t count = cvol_grid_samples(grid), per_cell = cvol_array_block_terms(array);
    float *dense = malloc(count * sizeof *dense);
    float *cells = malloc(array->block_count * per_cell * sizeof *cells);
    assert_true(dense && cells);
    cvol_samples_load(dense, samples, grid->type, 0, count, array->offset);
    cvol_lap_box box = {.grid = 16, .stride = {1, (int64_t)grid->dims[0]}};
    box.stride[2] = box.stride[1] * (int64_t)grid->dims[1];
    for (int a = 0; a < 3; a++)
        box.shape[a] = box.size[a] = (int64_t)grid->dims[a];
    for (int a = 0; a < 3 && array->lapped; a++)
        cvol_lap_pre(dense, &box, a);
    cvol_grid as_floats = *grid;
    as_floats.type = CVOL_FLOAT32;
    for (size_t i = 0; i < array->block_count; i++)
        cvol_block_gather(cells + i * per_cell, dense, &as_floats, array->block, i, 0);
    free(dense);
    return cells;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void check_brick(random_state *r, const cvol_array *array, const uint8_t *samples,
                        const float *expected, uint64_t seed)
{
    const size_t per_cell = cvol_array_block_terms(array), B = (size_t)array->block;
    const size_t *dims = array->grid.dims, margin = array->lapped ? 2 : 0;
    size_t first[3], count[3];
    for (int a = 0; a < 3; a++) {
        first[a] = random_below(r, (uint32_t)array->blocks[a]);
        count[a] = 1 + random_below(r, (uint32_t)least(4, array->blocks[a] - first[a]));
    }
    /* Exactly the needed rows and slices, in separate memory. */
    cvol_slab slab = {.first_slice = first[2] ? first[2] * B - margin : 0,
                      .first_row = first[1] ? first[1] * B - margin : 0};
    slab.slices = least((first[2] + count[2]) * B + margin, dims[2]) - slab.first_slice;
    slab.rows = least((first[1] + count[1]) * B + margin, dims[1]) - slab.first_row;
    const size_t line = dims[0] * cvol_type_size(array->grid.type), sheet = line * slab.rows;
    uint8_t *part = malloc(slab.slices * sheet);
    assert_non_null(part);
    for (size_t z = 0; z < slab.slices; z++)
        memcpy(part + z * sheet,
               samples + (slab.first_row + dims[1] * (slab.first_slice + z)) * line, sheet);
    slab.samples = part;
    float *scratch = aligned_alloc(64, (cvol_brick_scratch(array, count) * sizeof *scratch + 63) /
                                           64 * 64);
    float *cells = aligned_alloc(64, count[0] * count[1] * count[2] * per_cell * sizeof *cells);
    assert_true(scratch && cells);
    cvol_brick_gather(cells, scratch, &slab, array, first, count);
    for (size_t i = 0; i < count[0] * count[1] * count[2]; i++) {
        const size_t cell = first[0] + i % count[0] +
                            array->blocks[0] *
                                (first[1] + i / count[0] % count[1] +
                                 array->blocks[1] * (first[2] + i / count[0] / count[1]));
        if (memcmp(cells + i * per_cell, expected + cell * per_cell, per_cell * sizeof *cells)) {
            print_message("seed %llu: cell %zu of a %zux%zux%zu volume of type %d, lapped %d\n",
                          (unsigned long long)seed, cell, dims[0], dims[1], dims[2],
                          (int)array->grid.type, array->lapped);
            fail();
        }
    }
    free(cells);
    free(scratch);
    free(part);
}

static void bricks_equal_the_volume(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 120; seed++) {
        random_state r = {seed};
        size_t dims[3];
        for (int a = 0; a < 3; a++)
            dims[a] = 1 + random_below(&r, random_below(&r, 3) ? 40 : 90);
        const cvol_type type = (cvol_type)(CVOL_UINT8 + random_below(&r, 8));
        const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], type);
        const int lapped = random_below(&r, 4) != 0;
        cvol_array *array;
        assert_int_equal(
            cvol_array_create(context, &array, &grid, lapped ? 16 : 8 << random_below(&r, 3)), 0);
        array->lapped = lapped;
        array->offset = 10 * random_signed(&r);
        void *samples = fill(&r, type, cvol_grid_samples(&grid));
        float *expected = expected_cells(array, samples);
        for (int attempt = 0; attempt < 4; attempt++)
            check_brick(&r, array, samples, expected, seed);
        free(expected);
        free(samples);
        cvol_array_free(array);
    }
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bricks_equal_the_volume)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
