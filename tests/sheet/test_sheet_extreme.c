/* Maxima and minima skip blocks that cannot change the picture (extreme.h): pictures equal those
 * drawn without knowledge of the blocks' ranges, and blocks behind brighter samples are not
 * evaluated. */
#include "test.h"

#include "array/core/array.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

static const cvol_mode modes[] = {CVOL_MODE_MIP, CVOL_MODE_MIN};

/* By 1 thread, and by 3. */
static cvol_image *draw(const cvol_array *array, const cvol_render_options *options, int threads)
{
    cvol_context_set_threads(context, threads);
    return support_sheet(context, array, NULL, 0, options);
}

static void expect_alike(const cvol_image *a, const cvol_image *b, const char *what, int k)
{
    if (support_difference(a, b))
        fail_msg("%s, view %d: pictures differ by %d", what, k, support_difference(a, b));
}

/* ---- the same pictures ----------------------------------------------------------------------- */

/* Blobs in a volume that is mostly exactly 0, behind and in front of them. */
static cvol_volume make_blobs(void)
{
    cvol_volume volume = support_blobs(75, 60, 82);
    float *samples = volume.data;
    for (size_t z = 0; z < 82; z++)
        for (size_t y = 0; y < 60; y++)
            for (size_t x = 0; x < 75; x++)
                if (z < 17 || z > 60 || y < 14 || x > 62)
                    samples[support_index(&volume, x, y, z)] = 0;
    return volume;
}

/* All other views have pixels closer than samples, or cuts. */
static cvol_render_options request(cvol_mode mode, int k)
{
    cvol_render_options options = support_square(k % 2 ? 200 : 104, mode, 71 * k + 5,
                                                 47 * (k % 4) - 70);
    options.camera.zoom = k % 3 == 2 ? 1.4 : 1;
    options.camera.fov_deg = k % 6 == 5 ? 50 : 0;
    options.clip.planes = k % 5 == 3;
    options.clip.plane[0][0] = 1;
    options.clip.plane[0][2] = 0.3;
    return options;
}

/* The ranges of blocks are unknown. */
static void forget_ranges(cvol_array *array)
{
    for (size_t i = 0; i < array->block_count; i++) {
        array->block_table[i].range[0] = 0;
        array->block_table[i].range[1] = 255;
    }
}

static void expect_same_pictures(cvol_array *array, const char *what)
{
    enum { VIEWS = 8 };
    cvol_image *known[2][VIEWS];
    assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
    for (int m = 0; m < 2; m++)
        for (int k = 0; k < VIEWS; k++) {
            const cvol_render_options options = request(modes[m], k);
            known[m][k] = draw(array, &options, 1);
            cvol_image *three = draw(array, &options, 3);
            expect_alike(known[m][k], three, what, k);
            cvol_image_free(three);
        }
    forget_ranges(array);
    for (int m = 0; m < 2; m++)
        for (int k = 0; k < VIEWS; k++) {
            const cvol_render_options options = request(modes[m], k);
            cvol_image *image = draw(array, &options, 1);
            expect_alike(known[m][k], image, what, k);
            cvol_image_free(image);
            cvol_image_free(known[m][k]);
        }
    cvol_array_free(array);
}

/* Coarse ones are drawn from int16, if there are kernels for it. */
static void test_same_pictures(void **state)
{
    (void)state;
    const cvol_volume volume = make_blobs();
    expect_same_pictures(support_compress(context, &volume, 16, 45), "coarse");
    expect_same_pictures(support_compress(context, &volume, 8, 60), "by 8");
    expect_same_pictures(support_compress(context, &volume, 16, 110), "fine");
    expect_same_pictures(support_lapped(context, volume.data, volume.grid.dims, 3, 0.02, 0, 5),
                         "lapped");
    free(volume.data);
}

/* ---- skipped blocks -------------------------------------------------------------------------- */

/* Bright (for minima dark) for z < 16, and more so in one corner; values in between behind it. */
static cvol_volume make_wall(int sign)
{
    cvol_volume volume = support_volume(64, 64, 64, CVOL_FLOAT32);
    float *samples = volume.data;
    for (size_t z = 0; z < 64; z++)
        for (size_t y = 0; y < 64; y++)
            for (size_t x = 0; x < 64; x++)
                samples[support_index(&volume, x, y, z)] =
                    (float)sign * (z >= 16            ? 10 + (float)((x * 7 + y * 5 + z * 3) % 11)
                                   : x < 16 && y < 16 ? 90 + (float)(x % 2)
                                                      : 60);
    return volume;
}

/* The last blocks behind the wall get the corner's terms, which would be visible. In lapped arrays,
 * blocks next to the wall are evaluated before it is drawn. */
static void damage(cvol_array *array)
{
    for (size_t i = 48; i < array->block_count; i++) {
        cvol_block spoilt = array->block_table[0];
        memcpy(spoilt.range, array->block_table[i].range, sizeof spoilt.range);
        array->block_table[i] = spoilt;
    }
}

/* From the middle of the wall; from behind it, rays reach the damaged blocks first. */
static cvol_image *look(const cvol_array *array, int m, int size, int from_behind)
{
    cvol_render_options options = support_square(size, modes[m], 20, from_behind ? 85 : -85);
    options.camera.zoom = 4;
    return draw(array, &options, 1);
}

static void test_hidden_blocks_are_not_evaluated(void **state)
{
    (void)state;
    for (int m = 0; m < 2; m++)
        for (int k = 0; k < 4; k++) {
            const int size =
                k % 2 ? 22
                      : 80; /* pixels and samples are equally far apart, or pixels are closer */
            const cvol_volume volume = make_wall(m ? -1 : 1);
            cvol_array *array = support_compress(context, &volume, 16, k / 2 ? 110 : 45);
            assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
            cvol_image *whole = look(array, m, size, 0);
            damage(array);
            cvol_image *before = look(array, m, size, 0), *behind = look(array, m, size, 1);
            expect_alike(whole, before, "spoilt", k);
            assert_true(support_difference(whole, behind) > 20);
            cvol_image_free(whole);
            cvol_image_free(before);
            cvol_image_free(behind);
            cvol_array_free(array);
            free(volume.data);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_pictures),
        cmocka_unit_test(test_hidden_blocks_are_not_evaluated),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
