/* The level of a file that a picture needs; the picture from it equals that from the whole file. */
#include "test.h"

#include <unistd.h>

#include "array/core/array.h"
#include "cvol/series.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

static cvol_grid make_grid(size_t nx, size_t ny, size_t nz, double thickness)
{
    cvol_grid grid = cvol_grid_make(nx, ny, nz, CVOL_UINT8);
    grid.spacing[2] = thickness;
    return grid;
}

static int level_of(const cvol_grid *grid, const cvol_render_options *options)
{
    int level = -1;
    assert_int_equal(cvol_render_choose_file_level(context, &level, grid, options), CVOL_OK);
    return level;
}

static int level_at(const cvol_grid *grid, int size)
{
    const cvol_render_options options = support_square(size, CVOL_MODE_COMPOSITE, 30, 20);
    return level_of(grid, &options);
}

static void test_pixels_span_samples(void **state)
{
    (void)state;
    const cvol_grid large = make_grid(1024, 1024, 1024, 1), cube = make_grid(512, 512, 512, 1);
    assert_int_equal(level_at(&large, 512), 1);
    assert_int_equal(level_at(&large, 620), 1); /* diagonal: 1771.9 */
    assert_int_equal(level_at(&large, 621), 0);
    assert_int_equal(level_at(&large, 32), 1);
    assert_int_equal(level_at(&cube, 512), 0);
    assert_int_equal(level_at(&cube, 256), 1);
    const cvol_grid smaller = make_grid(512, 512, 511, 1);
    assert_int_equal(level_at(&smaller, 32), 0);
    /* The axis with the largest sample spacing decides. */
    const cvol_grid slices = make_grid(1024, 1024, 300, 3), thin = make_grid(16384, 8192, 1, 99);
    assert_int_equal(level_at(&slices, 512), 0);
    assert_int_equal(level_at(&slices, 128), 1);
    assert_int_equal(level_at(&thin, 512), 1);
}

static void test_requested_levels(void **state)
{
    (void)state;
    const cvol_grid grid = make_grid(1024, 1024, 1024, 1);
    const cvol_render_options plain = support_square(512, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_render_options options = plain;
    options.camera.zoom = 1.3;
    assert_int_equal(level_of(&grid, &options), 0);
    options = plain;
    options.oversample = 2;
    assert_int_equal(level_of(&grid, &options), 0);
    options = plain;
    options.mode = CVOL_MODE_ISO;
    assert_int_equal(level_of(&grid, &options), 0);
    options.mode = CVOL_MODE_MIP;
    assert_int_equal(level_of(&grid, &options), 1);
    options = plain;
    options.camera.fov_deg = 40; /* near parts are larger */
    assert_int_equal(level_of(&grid, &options), 0);
    options.width = options.height = 256;
    assert_int_equal(level_of(&grid, &options), 1);
    options.camera.placed = 1; /* within the volume */
    options.camera.look_at[0] = 1;
    assert_int_equal(level_of(&grid, &options), 0);
    options = plain;
    options.camera.zoom = 0;
    int level;
    assert_int_equal(cvol_render_choose_file_level(context, &level, &grid, &options),
                     CVOL_ERROR_ARGUMENT);
}

static void make_path(char *path)
{
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
}

static void expect_grid(const char *path, const cvol_file_part *part, const cvol_grid *expected)
{
    cvol_grid grid;
    assert_int_equal(cvol_file_read_grid(context, &grid, path, part), CVOL_OK);
    assert_memory_equal(grid.dims, expected->dims, sizeof grid.dims);
    assert_memory_equal(grid.spacing, expected->spacing, sizeof grid.spacing);
    assert_int_equal(grid.type, expected->type);
}

/* A complete file, a cut one, and a series are accepted; other files are not. */
static void test_grids_of_files(void **state)
{
    (void)state;
    char path[] = "/tmp/cvol-test-grid-XXXXXX";
    make_path(path);
    cvol_volume volume = support_blobs(40, 33, 20);
    volume.grid.spacing[1] = 2.5;
    cvol_array *array = support_compress(context, &volume, 16, 70);
    uint64_t bytes;
    assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
    expect_grid(path, NULL, &volume.grid);
    assert_int_equal(truncate(path, (off_t)bytes - 1), 0);
    expect_grid(path, NULL, &volume.grid);
    cvol_series_options options = cvol_series_options_defaults();
    cvol_series_writer *writer;
    options.times = 2;
    assert_int_equal(cvol_series_writer_open(context, &writer, path, &options), CVOL_OK);
    for (int t = 0; t < 2; t++)
        assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
    assert_int_equal(cvol_series_writer_commit(context, writer, NULL), CVOL_OK);
    expect_grid(path, CVOL_FILE_PART(.time = 1), &volume.grid);
    cvol_grid grid;
    assert_int_equal(cvol_file_read_grid(context, &grid, path, CVOL_FILE_PART(.time = 2)),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(truncate(path, 30), 0);
    assert_int_not_equal(cvol_file_read_grid(context, &grid, path, NULL), CVOL_OK);
    assert_int_equal(truncate(path, 0), 0);
    assert_int_equal(cvol_file_read_grid(context, &grid, path, NULL), CVOL_ERROR_FORMAT);
    cvol_array_free(array);
    free(volume.data);
    unlink(path);
}

/* Pixels span 2.9 samples: the error of level 2 would be larger. */
static void test_a_picture_from_level_1(void **state)
{
    (void)state;
    char path[] = "/tmp/cvol-test-level-XXXXXX";
    make_path(path);
    cvol_volume volume = support_blobs(96, 90, 80);
    cvol_array *array = support_compress(context, &volume, 16, 60), *read;
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = 1};
    assert_int_equal(cvol_array_read_part(context, &read, NULL, path, &part), CVOL_OK);
    for (int lit = 0; lit < 2; lit++) {
        cvol_render_options options = support_square(52, CVOL_MODE_COMPOSITE, 30, 20);
        options.shading.on = lit;
        cvol_image *whole = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        cvol_image *from_level = support_sheet(context, read, support_blob_points,
                                               SUPPORT_BLOB_POINTS, &options);
        const double db = support_psnr(whole, from_level);
        if (test_verbose())
            print_message("lit %d: %.2f dB\n", lit, db);
        assert_true(db > 65);
        cvol_image_free(whole);
        cvol_image_free(from_level);
    }
    cvol_array_free(read);
    cvol_array_free(array);
    free(volume.data);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pixels_span_samples),
        cmocka_unit_test(test_requested_levels),
        cmocka_unit_test(test_grids_of_files),
        cmocka_unit_test(test_a_picture_from_level_1),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
