/* The look of pictures when nothing is chosen: default views, frames, and colours by kind of data.
 */
#include "test.h"

#include <math.h>
#include <string.h>

#include "cvol/look.h"
#include "random.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

static const cvol_transfer_point bright[] = {{40, 1, 1, 1, 0}, {60, 1, 1, 1, 0.8}};

/* ---- default views ----------------------------------------------------------------------- */

static cvol_grid grid_of(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = support_volume(1, 1, 1, CVOL_UINT8);
    cvol_grid grid = volume.grid;
    free(volume.data);
    grid.dims[0] = nx;
    grid.dims[1] = ny;
    grid.dims[2] = nz;
    return grid;
}

/* The direction of the eye along the axes of the samples. */
static void eye_of(double eye[3], const cvol_camera *camera)
{
    const double a = camera->azimuth_deg / 57.29577951308232,
                 e = camera->elevation_deg / 57.29577951308232;
    eye[0] = cos(e) * sin(a);
    eye[1] = -cos(e) * cos(a);
    eye[2] = sin(e);
}

static void test_plain_views(void **state)
{
    (void)state;
    const struct {
        size_t dims[3];
        int axis; /* of the slab; -1: none */
    } cases[] = {{{50, 60, 70}, -1}, {{100, 100, 20}, 2}, {{20, 90, 100}, 0}, {{90, 20, 100}, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const cvol_grid grid = grid_of(cases[k].dims[0], cases[k].dims[1], cases[k].dims[2]);
        cvol_camera camera = cvol_render_options_defaults().camera;
        int mirrored;
        double eye[3];
        cvol_camera_set_default(&camera, &mirrored, &grid, 0);
        eye_of(eye, &camera);
        assert_false(mirrored);
        assert_true(fabs(camera.roll_deg) < 1e-9);
        assert_true(eye[1] < -0.3 || cases[k].axis == 0); /* from the front */
        assert_true(eye[2] > 0.3);                        /* and from above */
        for (int a = 0; a < 3 && cases[k].axis >= 0; a++)
            assert_true(fabs(eye[a]) <= fabs(eye[cases[k].axis]));
        cvol_camera_set_default(&camera, &mirrored, &grid, 25);
        double turned[3];
        eye_of(turned, &camera);
        assert_true(fabs(turned[2] - eye[2]) < 1e-9);
        assert_true(fabs(turned[0] * eye[0] + turned[1] * eye[1] -
                         cos(25 / 57.29577951308232) * (1 - eye[2] * eye[2])) < 1e-9);
    }
}

/* A single slice is seen as a picture: x or y to the right, and rows of slices across z downwards.
 */
static void test_views_of_slices(void **state)
{
    (void)state;
    const struct {
        size_t dims[3];
        double eye[3], up[3];
    } cases[] = {{{100, 80, 1}, {0, 0, -1}, {0, -1, 0}},
                 {{1, 90, 100}, {1, 0, 0}, {0, 0, 1}},
                 {{90, 1, 100}, {0, -1, 0}, {0, 0, 1}}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const cvol_grid grid = grid_of(cases[k].dims[0], cases[k].dims[1], cases[k].dims[2]);
        cvol_render_options options = support_square(8, CVOL_MODE_COMPOSITE, 0, 0);
        cvol_view view;
        int mirrored;
        cvol_camera_set_default(&options.camera, &mirrored, &grid, 0);
        assert_false(mirrored);
        assert_int_equal(cvol_view_make(context, &view, &grid, &options), CVOL_OK);
        for (int a = 0; a < 3; a++) {
            assert_true(fabs(view.eye[a] - cases[k].eye[a]) < 1e-9);
            assert_true(fabs(view.up[a] - cases[k].up[a]) < 1e-9);
        }
    }
}

/* The face of a patient lies at -P: in front of it is the eye, whatever the axes of the samples. */
static void test_patients(void **state)
{
    (void)state;
    for (int space = CVOL_SPACE_LPS; space <= CVOL_SPACE_RAS; space++)
        for (int k = 0; k < 16; k++) {
            cvol_grid grid = grid_of(40, 50, 60);
            const int order = k % 2, flips = k / 2;
            memset(grid.direction, 0, sizeof grid.direction);
            for (int a = 0; a < 3; a++)
                grid.direction[a][order ? (a + 1) % 3 : a] = flips >> a & 1 ? -1 : 1;
            grid.space = (cvol_space)space;
            cvol_camera camera = cvol_render_options_defaults().camera;
            int mirrored;
            double eye[3], patient[3] = {0, 0, 0};
            cvol_camera_set_default(&camera, &mirrored, &grid, 0);
            eye_of(eye, &camera);
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++)
                    patient[b] += eye[a] * grid.direction[a][b];
            const double front = space == CVOL_SPACE_RAS ? patient[1] : -patient[1];
            assert_true(front > 0.7);
            assert_true(patient[2] > 0.2);
            assert_int_equal(mirrored, (flips & 1) ^ (flips >> 1 & 1) ^ (flips >> 2 & 1));
        }
}

/* ---- frames ------------------------------------------------------------------------------ */

/* A ball away from the middle, and a few bright samples elsewhere. */
static cvol_volume make_ball(double x, double y, double z, double radius)
{
    cvol_volume volume = support_volume(70, 60, 80, CVOL_UINT8);
    for (size_t k = 0; k < 80; k++)
        for (size_t j = 0; j < 60; j++)
            for (size_t i = 0; i < 70; i++) {
                const double r = sqrt(pow((double)i - x, 2) + pow((double)j - y, 2) +
                                      pow((double)k - z, 2));
                ((uint8_t *)volume.data)[support_index(&volume, i, j, k)] = (uint8_t)fmax(
                    0, fmin(200, 50 + 20 * (radius - r)));
            }
    ((uint8_t *)volume.data)[support_index(&volume, 2, 2, 2)] = 80;
    return volume;
}

/* The rectangle of the pixels that are not black. */
static void find_rectangle(double out[4], const cvol_image *image)
{
    out[0] = out[1] = 1;
    out[2] = out[3] = 0;
    for (int j = 0; j < image->height; j++)
        for (int i = 0; i < image->width; i++)
            if (support_pixel(image, i, j)[1] > 60) {
                out[0] = fmin(out[0], (double)i / image->width);
                out[2] = fmax(out[2], (double)(i + 1) / image->width);
                out[1] = fmin(out[1], (double)j / image->height);
                out[3] = fmax(out[3], (double)(j + 1) / image->height);
            }
}

static void test_fit(void **state)
{
    (void)state;
    static const int sizes[][2] = {{120, 120}, {200, 100}, {90, 160}};
    cvol_volume volume = make_ball(45, 22, 50, 16);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, bright, 2), CVOL_OK);
    for (int k = 0; k < 12; k++) {
        cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 37 * k, 15 * k - 80);
        options.width = sizes[k % 3][0];
        options.height = sizes[k % 3][1];
        const cvol_source source = {
            .size = sizeof source, .array = k % 2 ? array : NULL, .volume = k % 2 ? NULL : &volume};
        assert_int_equal(cvol_camera_fit(context, &options, &source, transfer, 1), CVOL_OK);
        cvol_image *image = support_sheet(context, array, bright, 2, &options);
        double box[4];
        find_rectangle(box, image);
        const double most = fmax(box[2] - box[0], box[3] - box[1]);
        if (test_verbose())
            print_message("%d: %.3f %.3f %.3f %.3f\n", k, box[0], box[1], box[2], box[3]);
        assert_true(most > CVOL_FIT_SHARE - 0.07 && most < CVOL_FIT_SHARE + 0.04);
        assert_true(fabs(box[0] + box[2] - 1) < 0.07 && fabs(box[1] + box[3] - 1) < 0.07);
        cvol_image_free(image);
    }
    cvol_transfer_free(transfer);
    cvol_array_free(array);
    free(volume.data);
}

/* Volumes of a few samples, which have one to six cells along an axis, fill the picture likewise;
 * a single sample is as large as its spacing. */
static void test_fit_small(void **state)
{
    (void)state;
    static const cvol_transfer_point solid[] = {{.value = 0, .r = 1, .g = 1, .b = 1, .opacity = 1}};
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, solid, 1), CVOL_OK);
    for (size_t n = 1; n < 13; n++) {
        cvol_volume volume = support_volume(n, n, n, CVOL_UINT8);
        memset(volume.data, 200, n * n * n);
        cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 30, 20);
        assert_int_equal(
            cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, 1),
            CVOL_OK);
        cvol_image *image = support_ray(context, &volume, solid, 1, &options);
        double box[4];
        find_rectangle(box, image);
        const double most = fmax(box[2] - box[0], box[3] - box[1]);
        if (test_verbose())
            print_message("%zu: %.3f %.3f %.3f %.3f\n", n, box[0], box[1], box[2], box[3]);
        assert_true(most > CVOL_FIT_SHARE - 0.07 && most < CVOL_FIT_SHARE + 0.04);
        cvol_image_free(image);
        free(volume.data);
    }
    cvol_transfer_free(transfer);
}

/* A cube of a few samples in a larger volume: the frame does not cut it. */
static void test_fit_small_object(void **state)
{
    (void)state;
    static const cvol_transfer_point solid[] = {
        {.value = 100, .opacity = 0}, {.value = 120, .r = 1, .g = 1, .b = 1, .opacity = 1}};
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, solid, 2), CVOL_OK);
    for (size_t n = 4; n < 12; n++) {
        cvol_volume volume = support_volume(44, 40, 42, CVOL_UINT8);
        for (size_t i = 0; i < n * n * n; i++)
            ((uint8_t *)volume
                 .data)[support_index(&volume, 13 + i % n, 14 + i / n % n, 11 + i / n / n)] = 200;
        for (int grey = 0; grey < 2; grey++) {
            cvol_render_options options = support_square(
                100, grey ? CVOL_MODE_MIP : CVOL_MODE_COMPOSITE, 30, 20);
            assert_int_equal(
                cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, 1),
                CVOL_OK);
            cvol_image *image = support_ray(context, &volume, solid, 2, &options);
            double box[4];
            find_rectangle(box, image);
            if (test_verbose())
                print_message("%zu: %.3f %.3f %.3f %.3f\n", n, box[0], box[1], box[2], box[3]);
            assert_true(box[0] > 0.02 && box[1] > 0.02 && box[2] < 0.98 && box[3] < 0.98);
            assert_true(fmax(box[2] - box[0], box[3] - box[1]) > 0.45);
            cvol_image_free(image);
        }
        free(volume.data);
    }
    cvol_transfer_free(transfer);
}

/* Single samples in a larger volume, whose cells do not show them: the frame holds and centres
 * them.
 */
static void test_fit_single_samples(void **state)
{
    (void)state;
    static const cvol_transfer_point solid[] = {
        {.value = 120, .opacity = 0}, {.value = 121, .r = 1, .g = 1, .b = 1, .opacity = 1}};
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, solid, 2), CVOL_OK);
    for (int k = 0; k < 12; k++) {
        const size_t z = k % 4 < 2 ? 90 : 7;
        cvol_volume volume = support_volume(64, 80, 100, CVOL_UINT8);
        cvol_array *array = NULL;
        ((uint8_t *)volume.data)[support_index(&volume, 50, 11, z)] = 200;
        if (k % 3 == 1) /* and one not far from it */
            ((uint8_t *)volume.data)[support_index(&volume, 45, 14, z)] = 200;
        if (k % 3 == 2) {
            cvol_compress_options options = cvol_compress_options_defaults();
            options.lossless = 1;
            assert_int_equal(
                cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options), CVOL_OK);
        }
        for (int perspective = 0; perspective < 2; perspective++) {
            cvol_render_options options = support_square(
                100, k % 2 ? CVOL_MODE_ISO : CVOL_MODE_COMPOSITE, 30, 20);
            options.surface.value = 120;
            options.camera.fov_deg = perspective ? 50 : 0;
            options.step_voxels = 0.05;
            const cvol_source source = {
                .size = sizeof source, .array = array, .volume = array ? NULL : &volume};
            assert_int_equal(cvol_camera_fit(context, &options, &source, transfer, 1), CVOL_OK);
            cvol_image *image = support_ray(context, &volume, solid, 2, &options);
            double box[4];
            find_rectangle(box, image);
            if (test_verbose())
                print_message("%d: at %g %g %g, zoom %g: %.3f %.3f %.3f %.3f\n", k,
                              options.camera.look_at[0], options.camera.look_at[1],
                              options.camera.look_at[2], options.camera.zoom, box[0], box[1],
                              box[2], box[3]);
            assert_true(box[0] > 0.02 && box[1] > 0.02 && box[2] < 0.98 && box[3] < 0.98);
            assert_true(fmax(box[2] - box[0], box[3] - box[1]) > 0.15);
            if (k % 3 != 1 && !perspective)
                assert_true(fabs(box[0] + box[2] - 1) < 0.06 && fabs(box[1] + box[3] - 1) < 0.06);
            cvol_image_free(image);
            options.clip = (cvol_clip){.axes = 1, .from = {0}, .to = {40}}; /* hides all */
            assert_int_equal(cvol_camera_fit(context, &options, &source, transfer, 1), CVOL_OK);
            assert_true(options.camera.zoom < 2);
        }
        cvol_array_free(array);
        free(volume.data);
    }
    cvol_transfer_free(transfer);
}

/* One frame for a whole turn: nothing is cut, and somewhere the ball comes near the edge. */
static void test_turn(void **state)
{
    (void)state;
    cvol_volume volume = make_ball(45, 22, 50, 16);
    for (size_t i = 0; i < 70; i++) /* and a bar */
        for (size_t j = 0; j < 4; j++)
            for (size_t k = 0; k < 4; k++)
                ((uint8_t *)volume.data)[support_index(&volume, i, 30 + j, 40 + k)] = 200;
    cvol_transfer *transfer;
    double most = 0;
    assert_int_equal(cvol_transfer_create(context, &transfer, bright, 2), CVOL_OK);
    cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 0, 20);
    assert_int_equal(
        cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, 12), CVOL_OK);
    for (int k = 0; k < 12; k++) {
        double box[4];
        options.camera.azimuth_deg = 30 * k;
        cvol_image *image = support_ray(context, &volume, bright, 2, &options);
        find_rectangle(box, image);
        assert_true(box[0] > 0.02 && box[1] > 0.02 && box[2] < 0.98 && box[3] < 0.98);
        most = fmax(most, box[2] - box[0]);
        cvol_image_free(image);
    }
    assert_true(most > CVOL_FIT_SHARE - 0.08);
    cvol_transfer_free(transfer);
    free(volume.data);
}

/* In perspective nothing is cut either, in one picture and in a turn: near parts look larger. */
static void test_fit_in_perspective(void **state)
{
    (void)state;
    static const int sizes[][2] = {{120, 120}, {200, 100}, {90, 160}};
    cvol_volume volume = make_ball(45, 22, 50, 16);
    for (size_t i = 0; i < 70; i++) /* and two bars */
        for (size_t j = 0; j < 4; j++)
            for (size_t k = 0; k < 4; k++) {
                ((uint8_t *)volume.data)[support_index(&volume, i, 30 + j, 40 + k)] = 200;
                ((uint8_t *)volume.data)[support_index(&volume, 50 + j, 20 + k, i)] = 200;
            }
    ((uint8_t *)volume.data)[support_index(&volume, 2, 2, 2)] = 0;
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, bright, 2), CVOL_OK);
    for (int k = 0; k < 12; k++) {
        const int turns = k % 4 == 3 ? 6 : 1;
        double most = 0;
        cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 37 * k, 15 * k - 80);
        options.width = sizes[k % 3][0];
        options.height = sizes[k % 3][1];
        options.camera.fov_deg = 20 + 6 * k;
        assert_int_equal(
            cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, turns),
            CVOL_OK);
        for (int t = 0; t < turns; t++) {
            double box[4];
            cvol_image *image = support_ray(context, &volume, bright, 2, &options);
            find_rectangle(box, image);
            if (test_verbose())
                print_message("%d, %d: %.3f %.3f %.3f %.3f\n", k, t, box[0], box[1], box[2],
                              box[3]);
            assert_true(box[0] > 0.02 && box[1] > 0.02 && box[2] < 0.98 && box[3] < 0.98);
            most = fmax(most, fmax(box[2] - box[0], box[3] - box[1]));
            cvol_image_free(image);
            options.camera.azimuth_deg += 60;
        }
        assert_true(turns > 1 || most > CVOL_FIT_SHARE - 0.14); /* half a cell near the eye */
    }
    cvol_transfer_free(transfer);
    free(volume.data);
}

/* The extent gives the frames of pictures of all shapes. */
static void test_extent(void **state)
{
    (void)state;
    cvol_volume volume = make_ball(45, 22, 50, 16);
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, bright, 2), CVOL_OK);
    const cvol_source *source = CVOL_SOURCE(.volume = &volume);
    const double diagonal = sqrt(69 * 69 + 59 * 59 + 79 * 79);
    for (int k = 0; k < 5; k++) {
        const int shapes[5][2] = {{100, 100}, {300, 100}, {100, 300}, {32768, 1}, {1, 32768}};
        cvol_render_options one = support_square(100, CVOL_MODE_COMPOSITE, 30 * k, 20);
        cvol_render_options other = one;
        double extent[2];
        one.width = shapes[k][0];
        one.height = shapes[k][1];
        assert_int_equal(cvol_camera_fit(context, &one, source, transfer, 1), CVOL_OK);
        assert_int_equal(cvol_camera_fit_extent(context, &other, extent, source, transfer),
                         CVOL_OK);
        const double needed = fmax(extent[1], extent[0] * one.height / one.width);
        assert_true(fabs(one.camera.zoom * needed / (CVOL_FIT_SHARE * diagonal) - 1) < 1e-9);
        assert_memory_equal(one.camera.look_at, other.camera.look_at, sizeof one.camera.look_at);
        assert_true(extent[0] > 28 && extent[0] < 36 && extent[1] > 28 && extent[1] < 36);
    }
    cvol_transfer_free(transfer);
    free(volume.data);
}

/* Nothing is visible: the whole volume; and a source that is none. */
static void test_nothing(void **state)
{
    (void)state;
    static const cvol_transfer_point invisible = {.value = 0};
    cvol_volume volume = make_ball(45, 22, 50, 16);
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, &invisible, 1), CVOL_OK);
    cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 0, 0);
    assert_int_equal(
        cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, 1), CVOL_OK);
    /* The front of the box is 69 x 79, its diagonal 120.1. */
    const double diagonal = sqrt(69 * 69 + 59 * 59 + 79 * 79);
    assert_true(fabs(options.camera.zoom - diagonal * CVOL_FIT_SHARE / 79) < 1e-9);
    assert_int_equal(cvol_camera_fit(context, &options, CVOL_SOURCE(0), transfer, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), NULL, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(
        cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), transfer, 0),
        CVOL_ERROR_ARGUMENT);
    options.mode = CVOL_MODE_ISO;
    options.surface.value = 100;
    assert_int_equal(cvol_camera_fit(context, &options, CVOL_SOURCE(.volume = &volume), NULL, 1),
                     CVOL_OK);
    assert_true(options.camera.zoom > 2);
    cvol_transfer_free(transfer);
    free(volume.data);
}

/* All at once: the default view, its frame, and studio light. */
static void test_look_at_once(void **state)
{
    (void)state;
    cvol_volume volume = make_ball(45, 22, 50, 16);
    cvol_transfer *transfer;
    cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 77, 5), other = options;
    int mirrored = 5;
    volume.grid.space = CVOL_SPACE_LPS;
    volume.grid.direction[0][0] = -1;
    assert_int_equal(cvol_transfer_create(context, &transfer, bright, 2), CVOL_OK);
    assert_int_equal(cvol_render_options_set_look(context, &options, &mirrored,
                                                  CVOL_SOURCE(.volume = &volume), transfer),
                     CVOL_OK);
    assert_int_equal(mirrored, 1);
    assert_int_equal(options.shading.on, 1);
    assert_int_equal(options.illumination.in_view, -1);
    cvol_camera_set_default(&other.camera, &mirrored, &volume.grid, 0);
    assert_int_equal(cvol_camera_fit(context, &other, CVOL_SOURCE(.volume = &volume), transfer, 1),
                     CVOL_OK);
    assert_memory_equal(&other.camera, &options.camera, sizeof other.camera);
    static const cvol_transfer_point faces[] = {{0, 0, 0, 0, 0.5}, {255, 1, 1, 1, 0.5}};
    cvol_transfer *dense;
    assert_int_equal(cvol_transfer_is_opaque(transfer), 0);
    assert_int_equal(cvol_transfer_create(context, &dense, faces, 2), CVOL_OK);
    assert_int_equal(cvol_transfer_is_opaque(dense), 1);
    assert_int_equal(cvol_render_options_set_look(context, &options, &mirrored,
                                                  CVOL_SOURCE(.volume = &volume), dense),
                     CVOL_OK);
    assert_int_equal(options.shading.on, 0);
    cvol_transfer_free(dense);
    assert_int_equal(
        cvol_render_options_set_look(context, &options, &mirrored, CVOL_SOURCE(0), transfer),
        CVOL_ERROR_ARGUMENT);
    cvol_transfer_free(transfer);
    free(volume.data);
}

/* ---- kinds ------------------------------------------------------------------------------- */

/* Values of a kind of data. */
static double value_of(cvol_kind kind, random_state *r, size_t i)
{
    const double noise = random_signed(r);
    switch (kind) {
    case CVOL_KIND_CT:
        return i % 10 < 5 ? -1000 + 8 * noise : i % 10 < 9 ? 40 + 30 * noise : 700 + 300 * noise;
    case CVOL_KIND_SIGNED:
        return i % 4 ? 0.1 * noise : 4 * noise * fabs(noise);
    case CVOL_KIND_LABELS:
        return i % 10 < 6 ? 0 : 2 + 5 * (double)(i % 4);
    case CVOL_KIND_DENSE:
        return 120 + 20 * (noise + random_signed(r) + random_signed(r) + random_signed(r));
    default:
        return i % 10 < 7 ? 5 + 3 * noise : 80 + 60 * noise;
    }
}

/* A dozen labels have clearly different colours, whatever the step of their numbers is. */
static void test_label_colours(void **state)
{
    (void)state;
    static const double steps[] = {1, 2, 5, 10, 20, 50, 100, 200, 256, 500, 1000, 1024, 10000};
    enum { LABELS = 12 };
    for (size_t s = 0; s < sizeof steps / sizeof *steps; s++) {
        double colours[LABELS][3], nearest = 2;
        for (int i = 0; i < LABELS; i++) {
            cvol_label_get_colour(colours[i], steps[s] * (i + 1));
            for (int c = 0; c < 3; c++)
                assert_true(colours[i][c] >= 0 && colours[i][c] <= 1);
            for (int k = 0; k < i; k++)
                nearest = fmin(nearest, hypot(hypot(colours[i][0] - colours[k][0],
                                                    colours[i][1] - colours[k][1]),
                                              colours[i][2] - colours[k][2]));
        }
        if (!(nearest > 0.1))
            fail_msg("two of the labels %g, %g ... differ by %g only", steps[s], 2 * steps[s],
                     nearest);
    }
}

/* A single label ends half way to the background: between them nothing else has a colour. */
static void test_mask(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(20, 20, 20, CVOL_UINT8);
    cvol_histogram histogram;
    cvol_transfer *transfer;
    cvol_kind kind;
    for (int i = 0; i < 20 * 20 * 20; i++)
        ((uint8_t *)volume.data)[i] = i % 7 ? 0 : 200;
    assert_int_equal(cvol_volume_compute_histogram(context, &histogram, &volume), CVOL_OK);
    assert_int_equal(
        cvol_transfer_create_auto(context, &transfer, &kind, NULL, &histogram, &volume.grid, 1),
        CVOL_OK);
    assert_int_equal(kind, CVOL_KIND_LABELS);
    for (int value = 0; value <= 200; value += 10)
        if (value != 100 && (cvol_transfer_at(transfer, value).opacity > 0) != (value > 100))
            fail_msg("value %d: opacity %g", value, cvol_transfer_at(transfer, value).opacity);
    cvol_transfer_free(transfer);
    free(volume.data);
}

static void test_kinds(void **state)
{
    (void)state;
    const struct {
        cvol_kind kind;
        cvol_type type;
        cvol_space space;
        const char *unit;
    } cases[] = {
        {CVOL_KIND_CT, CVOL_INT16, CVOL_SPACE_LPS, "mm"},
        {CVOL_KIND_CT, CVOL_INT16, CVOL_SPACE_UNKNOWN, ""},
        {CVOL_KIND_MEDICAL, CVOL_UINT8, CVOL_SPACE_RAS, "mm"},
        {CVOL_KIND_MICROSCOPY, CVOL_UINT16, CVOL_SPACE_UNKNOWN, "um"},
        {CVOL_KIND_FIELD, CVOL_FLOAT32, CVOL_SPACE_UNKNOWN, ""},
        {CVOL_KIND_SIGNED, CVOL_FLOAT32, CVOL_SPACE_UNKNOWN, ""},
        {CVOL_KIND_DENSE, CVOL_UINT8, CVOL_SPACE_UNKNOWN, "nm"},
        {CVOL_KIND_LABELS, CVOL_UINT16, CVOL_SPACE_RAS, "mm"},
        {CVOL_KIND_GENERAL, CVOL_UINT8, CVOL_SPACE_UNKNOWN, "mm"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        random_state r = {k + 1};
        cvol_volume volume = support_volume(32, 32, 32, CVOL_FLOAT32);
        for (size_t i = 0; i < 32768; i++) {
            const double value = value_of(cases[k].kind, &r, i);
            ((float *)volume.data)[i] = (float)(cases[k].type == CVOL_FLOAT32 ? value
                                                                              : round(value));
        }
        cvol_histogram histogram;
        assert_int_equal(cvol_volume_compute_histogram(context, &histogram, &volume), CVOL_OK);
        cvol_grid grid = volume.grid;
        grid.type = cases[k].type;
        grid.space = cases[k].space;
        snprintf(grid.unit, sizeof grid.unit, "%s", cases[k].unit);
        cvol_transfer *transfer;
        cvol_kind kind;
        assert_int_equal(cvol_transfer_create_auto(context, &transfer, &kind, NULL, &histogram,
                                                   &grid, cases[k].kind == CVOL_KIND_LABELS),
                         CVOL_OK);
        if (test_verbose())
            print_message("%zu: %s\n", k, cvol_kind_text(kind));
        assert_int_equal(kind, cases[k].kind);
        assert_true(cvol_transfer_count(transfer) > 1);
        cvol_transfer_free(transfer);
        free(volume.data);
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_label_colours),
                                       TEST(test_plain_views),
                                       TEST(test_views_of_slices),
                                       TEST(test_patients),
                                       TEST(test_fit),
                                       TEST(test_fit_small),
                                       TEST(test_fit_small_object),
                                       TEST(test_turn),
                                       TEST(test_fit_in_perspective),
                                       TEST(test_extent),
                                       TEST(test_nothing),
                                       TEST(test_look_at_once),
                                       TEST(test_kinds),
                                       TEST(test_mask),
                                       TEST(test_fit_single_samples)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
