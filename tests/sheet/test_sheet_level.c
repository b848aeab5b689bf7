/* Levels of the sheet engine: coarse pictures resemble the fine one, for all kinds of volumes, and
 * equal those of a file's level. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include <unistd.h>

#include "array/core/array.h"
#include "cvol/codec.h"
#include "random.h"
#include "render/sheet/coarse_level.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"
#include "support_split.h"

static const double views[][2] = {{90, 0}, {30, 20}, {250, -60}}; /* all principal axes */
enum { VIEWS = sizeof views / sizeof *views };

static cvol_image *draw(const cvol_array *array, cvol_render_options options, int level)
{
    options.level = level;
    options.sheet.ray_order =
        CVOL_RAY_ORDER_OBJECT; /* as for levels: image-order rays may miss thin objects */
    return support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS, &options);
}

/* The minimum PSNR of a level's pictures against the volume's own. */
static double compare(const cvol_array *array, cvol_mode mode, int level, double zoom)
{
    double worst = 99;
    for (int v = 0; v < VIEWS; v++) {
        cvol_render_options options = support_square(70, mode, views[v][0], views[v][1]);
        options.camera.zoom = zoom;
        cvol_image *fine = draw(array, options, 0), *coarse = draw(array, options, level);
        worst = fmin(worst, support_psnr(fine, coarse));
        cvol_image_free(fine);
        cvol_image_free(coarse);
    }
    return worst;
}

static void expect(const cvol_array *array, const char *what, const double floors_db[3])
{
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_MIP};
    for (int level = 1; level <= 3; level++)
        for (int mode = 0; mode < 3; mode++) {
            const double db = compare(array, modes[mode], level, mode == 1 ? 3 : 1);
            if (test_verbose() || db < floors_db[level - 1])
                print_message("%s, level %d, mode %d: %.2f dB\n", what, level, mode, db);
            assert_true(db >= floors_db[level - 1]);
        }
}

/* ---- volumes --------------------------------------------------------------------------------- */

static void test_blocks_of_all_sizes(void **state)
{
    (void)state;
    static const double floors_db[3] = {38, 29, 19};
    cvol_volume volume = support_blobs(67, 50, 59);
    for (int block = 8; block <= 32; block *= 2) {
        char what[32];
        cvol_array *array = support_compress(context, &volume, block, 60);
        snprintf(what, sizeof what, "blocks of %d", block);
        expect(array, what, floors_db);
        cvol_array_free(array);
    }
    free(volume.data);
}

/* Not lapped, and lapped with randomly split cells. */
static void test_split_cells(void **state)
{
    (void)state;
    static const double floors_db[3] = {37, 27, 18};
    const size_t dims[3] = {67, 50, 59};
    cvol_volume volume = support_blobs(dims[0], dims[1], dims[2]);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    support_split_cells(context, array, 4);
    expect(array, "split", floors_db);
    cvol_array_free(array);
    array = support_lapped(context, volume.data, dims, 3, 0.02, 1, 5);
    expect(array, "lapped", floors_db);
    cvol_array_free(array);
    free(volume.data);
}

/* Slopes are in samples of the volume, at any level. */
static void test_light(void **state)
{
    (void)state;
    static const double floors_db[3] = {38, 30, 22};
    cvol_volume volume = support_blobs(67, 50, 59);
    cvol_array *array = support_compress(context, &volume, 16, 70);
    for (int level = 1; level <= 3; level++)
        for (int v = 0; v < VIEWS; v++) {
            cvol_render_options options = support_square(70, CVOL_MODE_COMPOSITE, views[v][0],
                                                         views[v][1]);
            options.shading.on = 1;
            cvol_image *fine = draw(array, options, 0), *coarse = draw(array, options, level);
            const double db = support_psnr(fine, coarse);
            if (test_verbose() || db < floors_db[level - 1])
                print_message("lit, level %d, view %d: %.2f dB\n", level, v, db);
            assert_true(db >= floors_db[level - 1]);
            cvol_image_free(fine);
            cvol_image_free(coarse);
        }
    cvol_array_free(array);
    free(volume.data);
}

/* Only a ball around the middle has a value, or is not background. */
static cvol_array *compress_ball(int is_background)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_volume volume = support_blobs(70, 64, 81);
    cvol_array *array;
    float *samples = volume.data;
    for (size_t z = 0; z < 81; z++)
        for (size_t y = 0; y < 64; y++)
            for (size_t x = 0; x < 70; x++) {
                const double square = pow((double)x - 35, 2) + pow((double)y - 32, 2) +
                                      pow((double)z - 40, 2);
                float *sample = &samples[support_index(&volume, x, y, z)];
                *sample = square < 900 ? *sample + 20 : is_background ? 0 : 1e35f;
            }
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 60;
    options.has_fill = !is_background;
    options.fill = (double)1e35f;
    options.background = is_background ? CVOL_BACKGROUND_VALUE : CVOL_BACKGROUND_NONE;
    if (cvol_compress(context, &array, NULL, samples, &volume.grid, &options))
        fail_msg("%s", cvol_context_message(context));
    free(samples);
    return array;
}

static void test_masks(void **state)
{
    (void)state;
    static const double floors_db[3] = {24, 19, 14};
    for (int is_background = 0; is_background < 2; is_background++) {
        cvol_array *array = compress_ball(is_background);
        assert_true(is_background ? cvol_mask_is_background(array->mask)
                                  : cvol_mask_is_void(array->mask));
        expect(array, is_background ? "background" : "void", floors_db);
        cvol_array_free(array);
    }
}

/* The total brightness of a picture. */
static double light_of(const cvol_image *image)
{
    double sum = 0;
    for (int i = 0; i < image->width * image->height; i++)
        sum += image->rgba[4 * i] + image->rgba[4 * i + 1] + image->rgba[4 * i + 2];
    return sum;
}

/* Slices far apart, and any small shape: levels have few samples, or one. */
static void test_shapes(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{40, 50, 12}, {1, 60, 60}, {60, 1, 60}, {60, 60, 1},
                                       {2, 60, 70},  {60, 3, 70}, {17, 5, 33}, {1, 1, 40},
                                       {1, 1, 1},    {4, 4, 4},   {16, 65, 64}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        cvol_volume volume = support_blobs(shapes[i][0], shapes[i][1], shapes[i][2]);
        float *samples = volume.data;
        for (size_t k = 0; k < cvol_grid_samples(&volume.grid); k++)
            samples[k] = 40 + 0.1f * samples[k] + (float)(k % shapes[i][0]) / 10;
        volume.grid.spacing[2] = i == 0 ? 4 : 1;
        cvol_array *array = support_compress(context, &volume, 16, 70);
        for (int level = 1; level <= 3; level++)
            for (int v = 0; v < VIEWS; v++) {
                const cvol_render_options options = support_square(70, CVOL_MODE_COMPOSITE,
                                                                   views[v][0], views[v][1]);
                cvol_image *fine = draw(array, options, 0), *coarse = draw(array, options, level);
                const double ratio = light_of(coarse) / light_of(fine);
                if (test_verbose() || !(fabs(ratio - 1) < 0.17))
                    print_message("shape %zu, level %d, view %d: %.3f\n", i, level, v, ratio);
                assert_true(fabs(ratio - 1) < 0.17);
                cvol_image_free(fine);
                cvol_image_free(coarse);
            }
        cvol_array_free(array);
        free(volume.data);
    }
}

/* ---- files, threads, frames ------------------------------------------------------------------ */

/* A file's level has the frequencies from which the volume's level is made. */
static void test_a_file_has_the_same_levels(void **state)
{
    (void)state;
    char path[] = "/tmp/cvol-test-level-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    cvol_volume volume = support_blobs(70, 64, 81);
    const size_t dims[3] = {70, 64, 81};
    cvol_array *array = support_lapped(context, volume.data, dims, 3, 0.5, 1, 9);
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    for (int level = 1; level <= 3; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        const cvol_render_options options = support_square(90, CVOL_MODE_COMPOSITE, 40, 20);
        cvol_array *read;
        assert_int_equal(cvol_array_read_part(context, &read, NULL, path, &part), CVOL_OK);
        cvol_image *of_file = draw(read, options, level), *of_volume = draw(array, options, level);
        assert_true(support_difference(of_file, of_volume) <= 1);
        cvol_image_free(of_file);
        cvol_image_free(of_volume);
        cvol_array_free(read);
    }
    unlink(path);
    cvol_array_free(array);
    free(volume.data);
}

/* One renderer draws all levels one after the other, on any number of threads, for several
 * functions. */
static void test_earlier_frames_have_no_effect(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(70, 64, 81);
    const size_t dims[3] = {70, 64, 81};
    static const cvol_transfer_point other[] = {{30, .3, .2, .1, 0}, {60, 1, .9, .8, 1}};
    cvol_array *array = support_lapped(context, volume.data, dims, 3, 0.5, 1, 9);
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    for (int k = 0; k < 24; k++) {
        const int level = k * 5 % 4, is_other = k / 12;
        const cvol_transfer_point *points = is_other ? other : support_blob_points;
        const size_t count = is_other ? 2 : SUPPORT_BLOB_POINTS;
        cvol_render_options options = support_square(60 + 40 * (k % 5), (cvol_mode)(1 + k % 3),
                                                     50 * k, k % 2 ? 70 : 10);
        options.level = level;
        options.sheet.ray_order =
            CVOL_RAY_ORDER_OBJECT; /* as for levels: image-order rays may miss thin objects */
        options.camera.zoom = k % 4 == 1 ? 6 : 1;
        if (k % 12 == 0)
            support_set_transfer(context, renderer, points, count);
        cvol_context_set_threads(context, 1);
        cvol_image *fresh = support_sheet(context, array, points, count, &options);
        cvol_context_set_threads(context, 1 + k % 3);
        cvol_image *image = support_picture(context, renderer, &options);
        if (support_difference(fresh, image))
            fail_msg("frame %d differs", k);
        cvol_image_free(fresh);
        cvol_image_free(image);
    }
    cvol_context_set_threads(context, 0);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    free(volume.data);
}

static void test_four_levels(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(20, 20, 20);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    cvol_render_options options = support_square(20, CVOL_MODE_XRAY, 0, 0);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, 20, 20), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    for (options.level = -1; options.level <= 4; options.level += 5) {
        assert_int_equal(cvol_renderer_render(context, renderer, image, &options),
                         CVOL_ERROR_ARGUMENT);
        assert_non_null(strstr(cvol_context_message(context), "must be 0 to 3"));
    }
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

/* ---- cells of low resolution ----------------------------------------------------------------- */

/* The means of 2^3 cells and more, each as far as it has a value. */
static void check_means(const cvol_coarse *cells, const cvol_coarse *fine, size_t count)
{
    const size_t *n = cells->dims;
    for (size_t i = 0; i < cvol_coarse_count(cells); i++) {
        const size_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
        double sum = 0, covers = 0, all = 0;
        for (size_t k = 0; k < count * count * count; k++) {
            const size_t from[3] = {at[0] * count + k % count, at[1] * count + k / count % count,
                                    at[2] * count + k / count / count};
            if (from[0] >= fine->dims[0] || from[1] >= fine->dims[1] || from[2] >= fine->dims[2])
                continue;
            const size_t j = from[0] + fine->dims[0] * (from[1] + fine->dims[1] * from[2]);
            const double cover = fine->cover ? (double)fine->cover[j] : 1;
            sum += cover * (double)fine->values[j];
            covers += cover;
            all++;
        }
        if (covers > 0)
            assert_true(fabs((double)cells->values[i] - sum / covers) <=
                        1e-5 * (1 + fabs(sum / covers)));
        if (cells->cover)
            assert_true(fabs((double)cells->cover[i] - covers / all) <= 1e-6);
    }
}

/* Cells coarser than the levels are made part by part: they are the means of those of the level
 * that is made as a whole. */
static void test_cells_of_parts(void **state)
{
    (void)state;
    static const int blocks[] = {8, 16, 32};
    const cvol_grid grid = cvol_grid_make(37, 50, 611, CVOL_FLOAT32);
    const size_t samples = cvol_grid_samples(&grid);
    random_state random = {8};
    float *values = malloc(samples * sizeof *values);
    for (size_t i = 0; i < samples; i++)
        values[i] = sinf(0.01f * (float)(i / (37 * 50))) + 0.3f * (float)random_signed(&random);
    for (size_t i = samples / 3; i < samples / 2; i++)
        values[i] = NAN;
    for (int k = 0; k < 6; k++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *array;
        cvol_coarse fine, cells;
        options.block = blocks[k % 3];
        options.lapped = k < 3;
        options.has_fill = 1;
        options.fill = (double)NAN;
        check_ok(cvol_compress(context, &array, NULL, values, &grid, &options));
        check_ok(cvol_coarse_of_array_at(context, &fine, array, 3));
        for (int number = 4; number < 6; number++) {
            check_ok(cvol_coarse_of_array_at(context, &cells, array, number));
            check_means(&cells, &fine, (size_t)1 << (number - 3));
            cvol_coarse_free(&cells);
        }
        cvol_coarse_free(&fine);
        cvol_array_free(array);
    }
    free(values);
}

static void test_cells_are_few(void **state)
{
    (void)state;
    static const struct {
        size_t longest;
        int level;
    } of[] = {{50, 1}, {384, 2}, {392, 3}, {2047, 3}, {2048, 4}, {4096, 5}, {10240, 6}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        const cvol_grid grid = cvol_grid_make(40, of[i].longest, 33, CVOL_UINT8);
        assert_int_equal(cvol_coarse_level(&grid), of[i].level);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks_of_all_sizes),
        cmocka_unit_test(test_split_cells),
        cmocka_unit_test(test_light),
        cmocka_unit_test(test_masks),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_a_file_has_the_same_levels),
        cmocka_unit_test(test_earlier_frames_have_no_effect),
        cmocka_unit_test(test_four_levels),
        cmocka_unit_test(test_cells_of_parts),
        cmocka_unit_test(test_cells_are_few),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
