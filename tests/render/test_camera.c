/* The camera: its directions and scale, and the places at which the ray engine shows voxels. */
#include "test.h"

#include "random.h"
#include "render/view/camera.h"
#include "support_context.h"
#include "support_render.h"

/* ---- the view ------------------------------------------------------------- */

static void test_view_directions(void **state)
{
    (void)state;
    random_state r = {1};
    cvol_grid grid = cvol_grid_make(10, 20, 30, CVOL_UINT8);
    for (int attempt = 0; attempt < 200; attempt++) {
        cvol_render_options options = cvol_render_options_defaults();
        double a = 400 * random_signed(&r), e = 400 * random_signed(&r);
        options.camera = (cvol_camera){
            .azimuth_deg = a, .elevation_deg = e, .roll_deg = 400 * random_signed(&r), .zoom = 1};
        cvol_view v;
        assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
        a *= acos(-1) / 180;
        e *= acos(-1) / 180;
        const double eye[3] = {cos(e) * sin(a), -cos(e) * cos(a), sin(e)};
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            assert_true(fabs(v.eye[i] - eye[i]) < 1e-12);
            /* right x up = eye */
            assert_true(fabs(v.right[j] * v.up[k] - v.right[k] * v.up[j] - eye[i]) < 1e-12);
        }
        double dot = 0, length = 0;
        for (int i = 0; i < 3; i++) {
            dot += v.right[i] * v.up[i];
            length += v.right[i] * v.right[i];
        }
        assert_true(fabs(dot) < 1e-12 && fabs(length - 1) < 1e-12);
    }
}

static void test_view_scale(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(4, 5, 13, CVOL_UINT8); /* 3, 4, 12: diagonal 13 */
    cvol_render_options options = cvol_render_options_defaults();
    options.width = 50;
    options.height = 26;
    cvol_view v;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 0.5) < 1e-12);
    assert_true(v.centre[2] == 6 && v.extent[1] == 4 && fabs(v.mean_spacing - 1) < 1e-12);
    options.camera.zoom = 4;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 0.125) < 1e-12);
    grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    grid.spacing[0] = 4;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 2.0 / 26 / 4) < 1e-12);
}

static void expect_refused(const cvol_render_options *options, const char *word)
{
    cvol_grid grid = cvol_grid_make(4, 5, 6, CVOL_UINT8);
    cvol_view v;
    assert_int_equal(cvol_view_make(context, &v, &grid, options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), word));
}

static void test_bad_options_are_named(void **state)
{
    (void)state;
    const cvol_render_options good = cvol_render_options_defaults();
    cvol_render_options bad = good;
#define REFUSE(field, value, word) \
    bad = good;                    \
    bad.field = value;             \
    expect_refused(&bad, word)
    REFUSE(width, 0, "width 0");
    REFUSE(width, CVOL_IMAGE_SIZE_MAX + 1, "width");
    REFUSE(height, -3, "height -3");
    REFUSE(camera.zoom, 0, "zoom 0");
    REFUSE(camera.zoom, -1, "zoom -1");
    REFUSE(camera.zoom, NAN, "zoom");
    REFUSE(camera.zoom, INFINITY, "zoom");
    REFUSE(camera.zoom, 1e-320, "zoom");
    REFUSE(camera.zoom, 1e300, "zoom 1e+300: must be");
    REFUSE(camera.azimuth_deg, NAN, "azimuth");
    REFUSE(camera.elevation_deg, INFINITY, "elevation");
    REFUSE(camera.roll_deg, NAN, "roll");
    REFUSE(step_voxels, -1, "step -1");
    REFUSE(step_voxels, 0.01, "step 0.01");
    REFUSE(step_voxels, INFINITY, "step");
    REFUSE(background[1], 1.5, "green is 1.5");
    REFUSE(background[2], NAN, "blue");
}

/* ---- pictures ------------------------------------------------------------- */

/* A bright voxel appears at the place that the camera's definition gives. */
static void test_voxels_appear_in_their_places(void **state)
{
    (void)state;
    random_state r = {7};
    const int size = 160;
    for (int attempt = 0; attempt < 20; attempt++) {
        cvol_volume volume = support_volume(12, 17, 14, CVOL_UINT8);
        volume.grid.spacing[2] = 1.5;
        size_t at[3] = {1 + random_below(&r, 10), 1 + random_below(&r, 15),
                        1 + random_below(&r, 12)};
        ((uint8_t *)volume.data)[support_index(&volume, at[0], at[1], at[2])] = 200;
        cvol_render_options options = support_square(size, CVOL_MODE_MIP, 180 * random_signed(&r),
                                                     90 * random_signed(&r));
        options.step_voxels = 1.0 / 16;
        options.camera.roll_deg = 180 * random_signed(&r);
        cvol_view v;
        assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
        double across = 0, above = 0, sum = 0, sum_i = 0, sum_j = 0;
        for (int k = 0; k < 3; k++) {
            double offset = (double)at[k] * volume.grid.spacing[k] - v.extent[k] / 2;
            across += offset * v.right[k] / v.pixel;
            above += offset * v.up[k] / v.pixel;
        }
        cvol_image *image = support_ray(context, &volume, NULL, 0, &options);
        for (int j = 0; j < size; j++)
            for (int i = 0; i < size; i++) {
                double grey = support_pixel(image, i, j)[0];
                sum += grey;
                sum_i += grey * (i + 0.5 - size / 2.0);
                sum_j += grey * (size / 2.0 - j - 0.5);
            }
        assert_true(sum > 0);
        assert_true(hypot(sum_i / sum - across, sum_j / sum - above) < 0.5);
        cvol_image_free(image);
        free(volume.data);
    }
}

/* Eight corners of eight colours: each view along an axis shows the four near ones, each in its
 * place. Corner bits: 1 for high x, 2 for high y, 4 for high z. */
static void test_corners_of_axis_views(void **state)
{
    (void)state;
    const size_t n = 17;
    cvol_volume volume = support_volume(n, n, n, CVOL_UINT8);
    cvol_transfer_point points[9] = {{0, 0, 0, 0, 0}};
    for (int corner = 0; corner < 8; corner++) {
        double value = 20 * (corner + 1);
        points[corner + 1] = (cvol_transfer_point){value, corner & 1 ? 1 : 0.2,
                                                   corner & 2 ? 1 : 0.2, corner & 4 ? 1 : 0.2, 1};
        for (size_t k = 0; k < 64; k++) {
            size_t place[3] = {k % 4, k / 4 % 4, k / 16};
            for (int a = 0; a < 3; a++)
                place[a] = corner >> a & 1 ? n - 1 - place[a] : place[a];
            ((uint8_t *)volume.data)[support_index(&volume, place[0], place[1], place[2])] =
                (uint8_t)value;
        }
    }
    /* Per view: azimuth, elevation, and the near corners top left, top right, bottom left,
     * bottom right. */
    static const int views[6][6] = {{0, 0, 4, 5, 0, 1},   {90, 0, 5, 7, 1, 3},
                                    {180, 0, 7, 6, 3, 2}, {270, 0, 6, 4, 2, 0},
                                    {0, 90, 6, 7, 4, 5},  {0, -90, 0, 1, 2, 3}};
    const int size = 101;
    /* Corner blocks' middles lie 6.5 from the centre; half the height is 8 sqrt(3). */
    const int offset = (int)(6.5 / (8 * sqrt(3)) * size / 2 + 0.5);
    for (int view = 0; view < 6; view++) {
        cvol_render_options options = support_square(size, CVOL_MODE_COMPOSITE, views[view][0],
                                                     views[view][1]);
        cvol_image *image = support_ray(context, &volume, points, 9, &options);
        for (int k = 0; k < 4; k++) {
            int corner = views[view][2 + k];
            const uint8_t *pixel = support_pixel(image, size / 2 + (k & 1 ? offset : -offset),
                                                 size / 2 + (k & 2 ? offset : -offset));
            for (int c = 0; c < 3; c++)
                assert_int_equal(pixel[c], corner >> c & 1 ? 255 : 51);
        }
        cvol_image_free(image);
    }
    free(volume.data);
}

/* The camera turned counter-clockwise by 90 degrees sees the picture turned clockwise. */
static void test_roll(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(20, 24, 28);
    const int size = 64;
    cvol_render_options options = support_square(size, CVOL_MODE_COMPOSITE, 33, 21);
    cvol_image *plain = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                    &options);
    options.camera.roll_deg = 90;
    cvol_image *rolled = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                     &options);
    for (int j = 0; j < size; j++)
        for (int i = 0; i < size; i++)
            for (int c = 0; c < 3; c++)
                assert_true(abs(support_pixel(rolled, i, j)[c] -
                                support_pixel(plain, j, size - 1 - i)[c]) <= 1);
    cvol_image_free(plain);
    cvol_image_free(rolled);
    free(volume.data);
}

/* Zoom 2 at size n is the middle of zoom 1 at size 2 n; a wide picture's middle is the square
 * one. */
static void test_zoom_and_width(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(20, 24, 28);
    cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, 200, -35);
    cvol_image *large = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                    &options);
    options.width = options.height = 40;
    options.camera.zoom = 2;
    cvol_image *zoomed = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                     &options);
    options.width = 60;
    cvol_image *wide = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                   &options);
    for (int j = 0; j < 40; j++)
        for (int i = 0; i < 40; i++)
            for (int c = 0; c < 3; c++) {
                int level = support_pixel(zoomed, i, j)[c];
                assert_true(abs(level - support_pixel(large, i + 20, j + 20)[c]) <= 1);
                assert_true(abs(level - support_pixel(wide, i + 10, j)[c]) <= 1);
            }
    cvol_image_free(large);
    cvol_image_free(zoomed);
    cvol_image_free(wide);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_view_directions),       TEST(test_view_scale),
        TEST(test_bad_options_are_named), TEST(test_voxels_appear_in_their_places),
        TEST(test_corners_of_axis_views), TEST(test_roll),
        TEST(test_zoom_and_width),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
