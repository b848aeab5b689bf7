/* Settings of published pictures: named views, windows of transfer functions, presets of Hounsfield
 * units. */
#include "test.h"

#include "random.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"
#include "support_context.h"
#include "support_render.h"

/* ---- views -------------------------------------------------------------------------------- */

/* Three perpendicular axes, right- or left-handed. */
static void random_axes(double axes[3][3], random_state *r, int handed)
{
    for (int a = 0; a < 2; a++) {
        double length = 0;
        for (int i = 0; i < 3; i++)
            axes[a][i] = random_signed(r);
        for (int b = 0; b < a; b++) {
            double along = 0;
            for (int i = 0; i < 3; i++)
                along += axes[a][i] * axes[b][i];
            for (int i = 0; i < 3; i++)
                axes[a][i] -= along * axes[b][i];
        }
        for (int i = 0; i < 3; i++)
            length += axes[a][i] * axes[a][i];
        for (int i = 0; i < 3; i++)
            axes[a][i] /= sqrt(length);
    }
    for (int i = 0; i < 3; i++)
        axes[2][i] = handed * (axes[0][(i + 1) % 3] * axes[1][(i + 2) % 3] -
                               axes[0][(i + 2) % 3] * axes[1][(i + 1) % 3]);
}

/* The anatomical directions to the right, upwards and towards the eye in the picture, in LPS. */
static void shown(double out[3][3], const cvol_grid *grid, const char *name, double turned)
{
    cvol_render_options options = cvol_render_options_defaults();
    cvol_view view;
    int mirrored;
    assert_int_equal(cvol_camera_set_view(context, &options.camera, &mirrored, name, grid, turned),
                     CVOL_OK);
    assert_int_equal(cvol_view_make(context, &view, grid, &options), CVOL_OK);
    const double *of[3] = {view.right, view.up, view.eye};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) {
            double sum = 0;
            for (int a = 0; a < 3; a++)
                sum += of[k][a] * grid->direction[a][i];
            out[k][i] = sum * (k == 0 && mirrored ? -1 : 1) *
                        (grid->space == CVOL_SPACE_RAS && i < 2 ? -1 : 1);
        }
}

/* The picture of a patient is the same for every orientation of the file. */
static void test_views_of_patients(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double right[3], up[3], eye[3]; /* LPS */
    } wanted[] = {
        {"front", {1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {"back", {-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
        {"left", {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},   {"right", {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}},
        {"top", {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {"bottom", {1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
    random_state r = {3};
    for (int attempt = 0; attempt < 60; attempt++) {
        cvol_grid grid = cvol_grid_make(8, 9, 10, CVOL_UINT8);
        grid.space = attempt % 2 ? CVOL_SPACE_RAS : CVOL_SPACE_LPS;
        if (attempt < 4) /* the axes themselves */
            grid.direction[0][0] = attempt < 2 ? 1 : -1;
        else
            random_axes(grid.direction, &r, attempt % 4 < 2 ? 1 : -1);
        for (int k = 0; k < 6; k++) {
            double seen[3][3];
            shown(seen, &grid, wanted[k].name, 0);
            const double *is[3] = {wanted[k].right, wanted[k].up, wanted[k].eye};
            for (int v = 0; v < 3; v++)
                for (int i = 0; i < 3; i++)
                    if (fabs(seen[v][i] - is[v][i]) > 1e-4)
                        fail_msg("trial %d, view %s: direction %d has %g along %d, must be %g",
                                 attempt, wanted[k].name, v, seen[v][i], i, is[v][i]);
        }
        /* A quarter turn leads from the front to the patient's left. */
        double left[3][3], turned[3][3];
        shown(left, &grid, "left", 0);
        shown(turned, &grid, "front", 90);
        for (int i = 0; i < 9; i++)
            assert_true(fabs(left[i / 3][i % 3] - turned[i / 3][i % 3]) < 1e-4);
    }
}

static void test_views_of_others(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double azimuth, elevation;
    } wanted[] = {{"front", 0, 0},  {"back", 180, 0}, {"left", -90, 0},
                  {"right", 90, 0}, {"top", 0, 90},   {"bottom", 0, -90}};
    cvol_grid grid = cvol_grid_make(8, 9, 10, CVOL_UINT8);
    grid.direction[0][0] = -1; /* of an unknown space */
    for (int k = 0; k < 6; k++) {
        cvol_camera camera = {.zoom = 3};
        int mirrored = 1;
        assert_int_equal(
            cvol_camera_set_view(context, &camera, &mirrored, wanted[k].name, &grid, 0), CVOL_OK);
        assert_int_equal(mirrored, 0);
        const double turns = (camera.azimuth_deg - wanted[k].azimuth) / 360;
        assert_true(fabs(turns - round(turns)) < 1e-12);
        assert_true(fabs(camera.elevation_deg - wanted[k].elevation) < 1e-12);
        assert_true(fabs(camera.roll_deg) < 1e-12 && camera.zoom > 2.9);
        assert_int_equal(cvol_camera_set_view(context, &camera, &mirrored, "front", &grid, 33.25),
                         CVOL_OK);
        assert_true(fabs(camera.azimuth_deg - 33.25) < 1e-9);
    }
    cvol_camera camera;
    int mirrored;
    assert_int_equal(cvol_camera_set_view(context, &camera, &mirrored, "above", &grid, 0),
                     CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "bottom"));
}

static cvol_image *picture_of(const cvol_volume *volume, const char *name, double turned,
                              double roll)
{
    cvol_render_options options = support_square(48, CVOL_MODE_COMPOSITE, 0, 0);
    int mirrored;
    assert_int_equal(
        cvol_camera_set_view(context, &options.camera, &mirrored, name, &volume->grid, turned),
        CVOL_OK);
    options.camera.roll_deg += mirrored ? -roll : roll;
    cvol_image *image = support_ray(context, volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                    &options);
    if (mirrored)
        cvol_image_mirror(image);
    return image;
}

/* The same patient, stored from left to right and from right to left. */
static void test_pictures_of_both_hands(void **state)
{
    (void)state;
    static const char *const names[] = {"front", "back", "left", "right", "top", "bottom"};
    cvol_volume right = support_blobs(24, 28, 20), left = support_blobs(24, 28, 20);
    float *to = left.data;
    for (size_t row = 0; row < 28 * 20; row++)
        for (size_t x = 0; x < 24; x++)
            to[24 * row + x] = ((float *)right.data)[24 * row + 23 - x];
    right.grid.space = left.grid.space = CVOL_SPACE_LPS;
    left.grid.direction[0][0] = -1;
    for (int k = 0; k < 12; k++) {
        cvol_image *a = picture_of(&right, names[k % 6], 17 * (k / 6), 25 * (k / 6));
        cvol_image *b = picture_of(&left, names[k % 6], 17 * (k / 6), 25 * (k / 6));
        if (support_difference(a, b) > 1)
            fail_msg("view %s, case %d: pictures differ by %d", names[k % 6], k,
                     support_difference(a, b));
        cvol_image_free(a);
        cvol_image_free(b);
    }
    free(right.data);
    free(left.data);
}

/* ---- transfer functions ------------------------------------------------------------------- */

static void test_adjusted(void **state)
{
    (void)state;
    const cvol_transfer_point points[] = {{10, 0, 0, 0, 0}, {20, 1, 0, 0, 0.2}, {50, 1, 1, 1, 1}};
    const double window[2] = {-100, 300};
    cvol_transfer *from, *to;
    assert_int_equal(cvol_transfer_create(context, &from, points, 3), CVOL_OK);
    assert_int_equal(cvol_transfer_create_adjusted(context, &to, from, window, 2), CVOL_OK);
    assert_true(fabs(cvol_transfer_point_at(to, 0).value + 100) < 1e-9);
    assert_true(fabs(cvol_transfer_point_at(to, 1).value) < 1e-9);
    assert_true(fabs(cvol_transfer_point_at(to, 2).value - 300) < 1e-9);
    assert_true(fabs(cvol_transfer_point_at(to, 1).opacity - 0.36) < 1e-9);
    assert_true(cvol_transfer_point_at(to, 2).opacity >= 1 &&
                cvol_transfer_point_at(to, 0).opacity <= 0);
    cvol_transfer_free(to);
    assert_int_equal(cvol_transfer_create_adjusted(context, &to, from, NULL, 0), CVOL_OK);
    assert_true(fabs(cvol_transfer_point_at(to, 1).value - 20) < 1e-9);
    assert_true(cvol_transfer_point_at(to, 1).opacity <= 0);
    cvol_transfer_free(to);
    const double empty[2] = {3, 3};
    assert_int_equal(cvol_transfer_create_adjusted(context, &to, from, empty, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_transfer_create_adjusted(context, &to, from, NULL, -1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_transfer_create_adjusted(context, &to, from, NULL, INFINITY),
                     CVOL_ERROR_ARGUMENT);
    assert_null(to);
    cvol_transfer_free(from);
}

/* Air, soft tissue and some bone, at values that mean these after a rescaling. */
static cvol_histogram ct_histogram(double slope, double offset)
{
    cvol_histogram h = {.min = (-1024 - offset) / slope, .max = (3000 - offset) / slope};
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++) {
        const double value = -1024 + (i + 0.5) * 4024 / CVOL_HISTOGRAM_BINS;
        h.bins[i] = value < -900 ? 5000 : fabs(value - 40) < 60 ? 8000 : value > 200 ? 100 : 10;
    }
    return h;
}

/* The guess for samples of a box of 32^3. */
static cvol_hounsfield guess_of(const uint16_t *samples, cvol_grid *grid)
{
    double rescale[2];
    cvol_histogram h;
    const cvol_volume volume = {*grid, (void *)samples};
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    return cvol_hounsfield_guess(rescale, &h, grid);
}

/* Labels, identifiers and other integers are not Hounsfield units, for any values. */
static void test_labels_are_not_hounsfield(void **state)
{
    enum { COUNT = 32 * 32 * 32 };
    (void)state;
    cvol_grid grid = cvol_grid_make(32, 32, 32, CVOL_UINT16);
    uint16_t *samples = malloc(COUNT * sizeof *samples);
    random_state r = {1};
    assert_non_null(samples);
    for (int i = 0; i < COUNT; i++) /* a parcellation: 1000 and more left, 2000 and more right */
        samples[i] = (uint16_t)(i % 3 ? 0 : 1000 * (1 + (i / 3) % 2) + (i / 1024) * 3 % 36);
    assert_int_equal(guess_of(samples, &grid), CVOL_HOUNSFIELD_NO);
    for (int i = 0; i < COUNT; i++) /* 101 labels from 1000 to 3000 on zeros */
        samples[i] = (uint16_t)(i % 2 ? 0 : 1000 + 20 * ((i / 8) % 101));
    assert_int_equal(guess_of(samples, &grid), CVOL_HOUNSFIELD_NO);
    for (int i = 0; i < COUNT; i++) /* identifiers */
        samples[i] = (uint16_t)random_below(&r, 3001);
    assert_int_equal(guess_of(samples, &grid), CVOL_HOUNSFIELD_NO);
    for (int i = 0; i < COUNT; i++) /* a magnetic resonance image */
        samples[i] = (uint16_t)(i % 2 ? random_below(&r, 60)
                                      : (i % 4 ? 550 : 1050) + random_below(&r, 200));
    assert_int_equal(guess_of(samples, &grid), CVOL_HOUNSFIELD_NO);
    for (int i = 0; i < COUNT; i++) /* a body: air, fat and muscle, some bone */
        samples[i] = (uint16_t)(i % 2    ? random_below(&r, 50)
                                : i % 20 ? 930 + random_below(&r, 180)
                                         : 1300 + random_below(&r, 900));
    assert_int_equal(guess_of(samples, &grid), CVOL_HOUNSFIELD_SHIFTED);
    free(samples);
}

static void test_hounsfield(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(8, 9, 10, CVOL_INT16);
    double rescale[2];
    cvol_histogram h = ct_histogram(1, 0);
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_YES);
    assert_true(fabs(rescale[0] - 1) < 1e-12 && fabs(rescale[1]) < 1e-12);
    h = ct_histogram(1, -1024);
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_SHIFTED);
    assert_true(fabs(rescale[1] + 1024) < 1e-12);
    grid.value_scale = 2;
    grid.value_offset = -500;
    h = ct_histogram(2, -500);
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_YES);
    assert_true(fabs(rescale[0] - 2) < 1e-12 && fabs(rescale[1] + 500) < 1e-12);
    grid.value_scale = 1;
    grid.value_offset = 0;
    h = (cvol_histogram){.min = 0, .max = 255};
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        h.bins[i] = 10;
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_NO);
    h.max = 65535; /* 16 bits of a microscope */
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_NO);
    h.min = -32768; /* amplitudes around zero */
    h.max = 32767;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        h.bins[i] = (uint64_t)(1e6 * exp(-0.5 * pow((i - 127.5) / 30, 2)));
    assert_int_equal(cvol_hounsfield_guess(rescale, &h, &grid), CVOL_HOUNSFIELD_NO);

    static const char *const names[] = {"ct-bone", "ct-skin", "ct-lung", "ct-vessels"};
    const double seen[4][3] = {/* in HU: visible and invisible values */
                               {800, 40, -1000},
                               {40, -900, -1000},
                               {-700, 40, -1000},
                               {300, 40, -1000}};
    for (int k = 0; k < 4; k++) {
        cvol_transfer *transfer;
        const double by[2] = {0.5, -1024};
        assert_true(cvol_transfer_is_ct(names[k]));
        assert_int_equal(cvol_transfer_create_ct(context, &transfer, names[k], by), CVOL_OK);
        double opacities[3];
        for (int i = 0; i < 3; i++)
            opacities[i] = cvol_transfer_at(transfer, (seen[k][i] + 1024) / 0.5).opacity;
        assert_true(opacities[0] > 0.01 && opacities[1] <= 0 && opacities[2] <= 0);
        cvol_transfer_free(transfer);
    }
    cvol_transfer *none;
    const double by[2] = {1, 0}, zero[2] = {0, 0};
    assert_false(cvol_transfer_is_ct("bone"));
    assert_int_equal(cvol_transfer_create_ct(context, &none, "ct-bones", by), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_transfer_create_ct(context, &none, "ct-bone", zero), CVOL_ERROR_ARGUMENT);
    assert_null(none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_views_of_patients, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_views_of_others, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_pictures_of_both_hands, context_setup,
                                        context_teardown),
        cmocka_unit_test_setup_teardown(test_adjusted, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_hounsfield, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_labels_are_not_hounsfield, context_setup,
                                        context_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
