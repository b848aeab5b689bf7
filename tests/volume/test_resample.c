/* cvol_volume_resample: samples at the places of another grid. */
#include "test.h"

#include "cvol/volume.h"
#include "support_context.h"
#include "support_volume.h"

/* A linear function of the place in RAS and millimetres, which linear interpolation keeps. */
static double field_at(const cvol_grid *g, size_t x, size_t y, size_t z)
{
    const size_t at[3] = {x, y, z};
    double p[3];
    for (int i = 0; i < 3; i++) {
        p[i] = g->origin[i];
        for (int a = 0; a < 3; a++)
            p[i] += g->direction[a][i] * g->spacing[a] * (double)at[a];
        p[i] *= g->space == CVOL_SPACE_LPS && i < 2 ? -1 : 1;
        p[i] *= strcmp(g->unit, "um") ? 1 : 1e-3;
    }
    return 3 + 0.5 * p[0] - 0.25 * p[1] + 2 * p[2];
}

static cvol_volume *make_linear(const cvol_grid *grid)
{
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, grid));
    for (size_t i = 0; i < cvol_grid_samples(grid); i++)
        ((float *)volume->data)[i] = (float)field_at(grid, i % grid->dims[0],
                                                     i / grid->dims[0] % grid->dims[1],
                                                     i / grid->dims[0] / grid->dims[1]);
    return volume;
}

/* Turned by 30 degrees about z, with other spacings. */
static cvol_grid turned_grid(void)
{
    const double c = cos(M_PI / 6), s = sin(M_PI / 6);
    cvol_grid grid = cvol_grid_make(31, 29, 17, CVOL_FLOAT32);
    const double direction[3][3] = {{c, s, 0}, {-s, c, 0}, {0, 0, 1}};
    const double spacing[3] = {1.5, 2, 3}, origin[3] = {-10, -35, -8};
    memcpy(grid.direction, direction, sizeof direction);
    memcpy(grid.spacing, spacing, sizeof spacing);
    memcpy(grid.origin, origin, sizeof origin);
    grid.space = CVOL_SPACE_RAS;
    return grid;
}

static cvol_grid plain_grid(void)
{
    cvol_grid grid = cvol_grid_make(21, 20, 19, CVOL_UINT8);
    const double origin[3] = {-8, -9, -4};
    memcpy(grid.origin, origin, sizeof origin);
    grid.space = CVOL_SPACE_RAS;
    return grid;
}

static void check_linear(const cvol_volume *from, const cvol_grid *grid, uint64_t least)
{
    cvol_volume *out;
    uint64_t inside, numbers = 0;
    check_ok(cvol_volume_resample(context, &out, &inside, from, grid, 0));
    assert_int_equal(out->grid.type, CVOL_FLOAT32);
    for (size_t i = 0; i < cvol_grid_samples(grid); i++) {
        const float value = ((const float *)out->data)[i];
        if (isnan(value))
            continue;
        numbers++;
        near(value,
             field_at(grid, i % grid->dims[0], i / grid->dims[0] % grid->dims[1],
                      i / grid->dims[0] / grid->dims[1]),
             2.5); /* places up to half a sample beyond the last one get its value */
    }
    assert_int_equal(numbers, inside);
    assert_true(inside >= least);
    near(((const float *)out->data)[10 + 21 * (10 + 20 * 9)], field_at(grid, 10, 10, 9), 1e-4);
    cvol_volume_free(out);
}

static void test_places(void **state)
{
    (void)state;
    cvol_grid grid = turned_grid();
    const cvol_grid plain = plain_grid();
    cvol_volume *volume = make_linear(&grid);
    check_linear(volume, &plain, cvol_grid_samples(&plain) / 2);
    cvol_volume_free(volume);

    /* The same places in LPS and in micrometres. */
    for (int i = 0; i < 3; i++) {
        grid.origin[i] *= 1000 * (i < 2 ? -1 : 1);
        grid.spacing[i] *= 1000;
        for (int a = 0; a < 3; a++)
            grid.direction[a][i] *= i < 2 ? -1 : 1;
    }
    cvol_grid millimetres = plain;
    grid.space = CVOL_SPACE_LPS;
    memcpy(grid.unit, "um", 3);
    memcpy(millimetres.unit, "mm", 3);
    volume = make_linear(&grid);
    check_linear(volume, &millimetres, cvol_grid_samples(&plain) / 2);
    cvol_volume_free(volume);
}

static void test_outside_and_missing(void **state)
{
    (void)state;
    const cvol_grid plain = plain_grid();
    cvol_grid grid = plain;
    grid.type = CVOL_FLOAT32;
    cvol_volume *volume = make_linear(&grid), *out;
    uint64_t inside;
    ((float *)volume->data)[7] = NAN;
    cvol_grid away = plain;
    away.origin[0] += 5; /* its last five samples are outside */
    check_ok(cvol_volume_resample(context, &out, &inside, volume, &away, 0));
    const float *samples = out->data;
    assert_int_equal(inside, 16 * 20 * 19);
    assert_true(isnan(samples[2])); /* the missing one */
    assert_true(!isnan(samples[15]) && isnan(samples[16]));
    cvol_volume_free(out);
    away.origin[0] += 100;
    check_ok(cvol_volume_resample(context, &out, &inside, volume, &away, 0));
    assert_int_equal(inside, 0);
    cvol_volume_free(out);
    cvol_volume_free(volume);
}

static void test_labels(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(2, 1, 1, CVOL_INT16),
              fine = cvol_grid_make(9, 1, 1, CVOL_UINT8);
    cvol_volume *volume, *out;
    check_ok(cvol_volume_create(context, &volume, &grid));
    ((int16_t *)volume->data)[0] = 7;
    ((int16_t *)volume->data)[1] = -300;
    fine.spacing[0] = 0.3;
    fine.origin[0] = -0.72;
    check_ok(cvol_volume_resample(context, &out, NULL, volume, &fine, 1));
    static const int16_t expected[9] = {0, 7, 7, 7, 7, -300, -300, -300, 0};
    assert_int_equal(out->grid.type, CVOL_INT16);
    assert_memory_equal(out->data, expected, sizeof expected);
    cvol_volume_free(out);
    cvol_volume_free(volume);
}

/* A label in one corner of a cell wins where its weight is the largest. */
static void test_largest_weight(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(2, 2, 2, CVOL_UINT8);
    cvol_grid fine = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    cvol_volume *volume, *out;
    check_ok(cvol_volume_create(context, &volume, &grid));
    uint8_t *samples = volume->data;
    memcpy(samples, "\5\7\7\7\7\7\7\7", 8);
    static const double places[][2] = {{0.1, 5}, {0.19, 5}, {0.22, 7}, {0.49, 7}, {0.9, 7}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        for (int a = 0; a < 3; a++)
            fine.origin[a] = places[i][0];
        check_ok(cvol_volume_resample(context, &out, NULL, volume, &fine, 1));
        assert_int_equal(*(const uint8_t *)out->data, (int)places[i][1]); /* 0.79^3 = 0.49 */
        cvol_volume_free(out);
    }
    cvol_volume_free(volume);
}

static void test_spaces(void **state)
{
    (void)state;
    cvol_grid grid = plain_grid(), other = cvol_grid_make(21, 20, 19, CVOL_UINT8);
    cvol_volume *volume, *out;
    uint64_t inside;
    check_ok(cvol_volume_create(context, &volume, &grid));
    ((uint8_t *)volume->data)[50] = 9;
    check_ok(cvol_volume_resample(context, &out, &inside, volume, &other, 1));
    assert_int_equal(inside, cvol_grid_samples(&other));
    assert_int_equal(((const uint8_t *)out->data)[50], 9);
    cvol_volume_free(out);
    other.dims[2]++;
    assert_int_equal(cvol_volume_resample(context, &out, &inside, volume, &other, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_null(out);
    assert_non_null(strstr(cvol_context_message(context), "no common space"));
    other.space = CVOL_SPACE_RAS;
    memcpy(volume->grid.direction[1], volume->grid.direction[0], sizeof volume->grid.direction[0]);
    assert_int_equal(cvol_volume_resample(context, &out, &inside, volume, &other, 1),
                     CVOL_ERROR_ARGUMENT);
    cvol_volume_free(volume);
}

/* The same box with fewer samples: two for each sample of the coarser grid along the axis that is
 * most nearly parallel; and samples there are those of the linear function. */
static void test_coarser(void **state)
{
    (void)state;
    cvol_grid from = turned_grid(), grid = plain_grid(), coarse;
    for (int a = 0; a < 3; a++) {
        grid.dims[a] = 10 * grid.dims[a] - 9; /* the same box */
        grid.spacing[a] /= 10;
    }
    check_ok(cvol_grid_coarsen(context, &coarse, &grid, &from));
    for (int a = 0; a < 3; a++) {
        const double box = (double)(grid.dims[a] - 1) * grid.spacing[a];
        assert_true(fabs((double)(coarse.dims[a] - 1) * coarse.spacing[a] - box) < 1e-9);
        assert_true(fabs(coarse.origin[a] - grid.origin[a]) < 1e-12);
    }
    /* Along x a step of 1 is cos 30 / 1.5 samples of the turned grid; along y cos 30 / 2 or sin 30
     * / 1.5; along z 1 / 3. */
    assert_int_equal(coarse.dims[0], (int)ceil(2 * cos(M_PI / 6) / 1.5 * 20) + 1);
    assert_int_equal(coarse.dims[1], (int)ceil(2 * cos(M_PI / 6) / 2 * 19) + 1);
    assert_int_equal(coarse.dims[2], (int)ceil(2.0 / 3 * 18) + 1);
    cvol_volume *volume = make_linear(&from);
    cvol_volume *out;
    check_ok(cvol_volume_resample(context, &out, NULL, volume, &coarse, 0));
    const size_t middle = 10 + coarse.dims[0] * (9 + coarse.dims[1] * 6);
    near((double)((const float *)out->data)[middle], field_at(&coarse, 10, 9, 6), 1e-4);
    cvol_volume_free(out);
    cvol_volume_free(volume);
    /* Not finer: as it is. */
    check_ok(cvol_grid_coarsen(context, &coarse, &from, &grid));
    assert_memory_equal(coarse.dims, from.dims, sizeof from.dims);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places), cmocka_unit_test(test_outside_and_missing),
        cmocka_unit_test(test_labels), cmocka_unit_test(test_largest_weight),
        cmocka_unit_test(test_spaces), cmocka_unit_test(test_coarser),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
