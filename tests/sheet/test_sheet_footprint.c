/* Footprints of the sheet engine: their weights, and pictures against direct sums of decoded
 * samples; skipping, threads and earlier frames have no effect.
 */
#include "test.h"

#include "array/core/array.h"
#include "array/core/mask.h"
#include "random.h"
#include "render/sheet/frame/reconstruction_filter.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

static const cvol_sheet_options kinds[] = {{CVOL_SHEET_CATMULL_ROM, 0, CVOL_RAY_ORDER_IMAGE},
                                           {CVOL_SHEET_B_SPLINE, 0, CVOL_RAY_ORDER_IMAGE},
                                           {CVOL_SHEET_GAUSSIAN, 0, CVOL_RAY_ORDER_IMAGE},
                                           {CVOL_SHEET_GAUSSIAN, 0.5, CVOL_RAY_ORDER_IMAGE},
                                           {CVOL_SHEET_GAUSSIAN, 1, CVOL_RAY_ORDER_IMAGE}};
#define KINDS (int)(sizeof kinds / sizeof *kinds)
#define PI 3.14159265358979323846

/* ---- weights --------------------------------------------------------------------------------- */

/* The weight of the sample `i` after the one before the place t. */
static double weight(const cvol_reconstruction_filter *wide, int i, double t)
{
    double sum = 0;
    if (i < -wide->reach || i > wide->reach + 1)
        return 0;
    for (int d = wide->degree; d >= 0; d--)
        sum = sum * t + (double)wide->factors[i + wide->reach][d];
    return sum;
}

/* The reconstruction of samples i^power at t. */
static double moment(const cvol_reconstruction_filter *wide, int power, double t)
{
    double sum = 0;
    for (int i = -4; i <= 5; i++)
        sum += weight(wide, i, t) * pow(i, power);
    return sum;
}

static void test_weights(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        cvol_reconstruction_filter wide;
        cvol_reconstruction_filter_make(&wide, &kinds[k]);
        const double sigma = kinds[k].sigma > 0 ? kinds[k].sigma : 5 / 6.0;
        const int exact = kinds[k].footprint == CVOL_SHEET_GAUSSIAN      ? 0
                          : kinds[k].footprint == CVOL_SHEET_CATMULL_ROM ? 2
                                                                         : 3;
        assert_true(wide.reach <= CVOL_FILTER_REACH && wide.degree <= CVOL_FILTER_DEGREE);
        for (int n = 0; n <= 64; n++) {
            const double t = n / 64.0;
            for (int power = 0; power <= exact; power++)
                assert_true(fabs(moment(&wide, power, t) - pow(t, power)) < 3e-6);
            double sum = 0;
            for (int i = -2; i <= 3; i++)
                sum += exp(-(i - t) * (i - t) / (2 * sigma * sigma));
            for (int i = -2; i <= 3 && !exact; i++)
                assert_true(fabs(weight(&wide, i, t) -
                                 exp(-(i - t) * (i - t) / (2 * sigma * sigma)) / sum) <
                            CVOL_FILTER_ERROR);
        }
        /* Continuous from sample to sample, except where a Gaussian is cut off. */
        for (int i = -4; i <= 4; i++)
            assert_true(fabs(weight(&wide, i, 1) - weight(&wide, i - 1, 0)) <
                        (exact ? 1e-6 : 0.006));
    }
}

/* The remaining amplitude of a frequency at the samples: all for Catmull-Rom, for the B-spline the
 * response of its prefilter of five taps, for the exact one all. */
static void test_frequencies(void **state)
{
    (void)state;
    cvol_reconstruction_filter cubic, spline;
    cvol_reconstruction_filter_make(&cubic, &kinds[0]);
    cvol_reconstruction_filter_make(&spline, &kinds[1]);
    double worst = 0;
    for (int n = 0; n <= 64; n++) {
        const double omega = PI * n / 64, s = 1 - cos(omega);
        double left[2] = {0, 0};
        for (int i = -4; i <= 4; i++) {
            left[0] += weight(&cubic, i, 0) * cos(omega * i);
            left[1] += weight(&spline, i, 0) * cos(omega * i);
        }
        assert_true(fabs(left[0] - 1) < 1e-6);
        assert_true(fabs(left[1] - (1 + s / 3 + s * s / 6) * (1 - s / 3)) < 1e-6);
        if (n <= 32)
            worst = fmax(worst, fabs(left[1] - 1));
        if (n == 64)
            assert_true(fabs(left[1] - 0.778) < 1e-3);
    }
    assert_true(worst < 0.009);
    /* Smooth functions: a wave of 8 samples, between them. */
    double errors[3] = {0};
    for (int n = 0; n <= 64; n++) {
        const double t = n / 64.0, omega = PI / 4;
        for (int phase = 0; phase < 8; phase++) {
            const double truth = sin(omega * (t + phase));
            double sums[2] = {0, 0};
            for (int i = -4; i <= 5; i++) {
                sums[0] += weight(&cubic, i, t) * sin(omega * (i + phase));
                sums[1] += weight(&spline, i, t) * sin(omega * (i + phase));
            }
            errors[0] = fmax(errors[0], fabs((1 - t) * sin(omega * phase) +
                                             t * sin(omega * (phase + 1)) - truth));
            errors[1] = fmax(errors[1], fabs(sums[0] - truth));
            errors[2] = fmax(errors[2], fabs(sums[1] - truth));
        }
    }
    if (test_verbose())
        print_message("waves of 8 samples: linear %.4f, Catmull-Rom %.4f, B-spline %.4f\n",
                      errors[0], errors[1], errors[2]);
    assert_true(errors[1] < 0.2 * errors[0] && errors[2] < 0.5 * errors[1]);
}

/* ---- direct sums ----------------------------------------------------------------------------- */

/* Sample (x, y, z) of a volume with repeated outermost samples. */
static double sample(const cvol_volume *volume, const int place[3])
{
    size_t at[3];
    for (int a = 0; a < 3; a++) {
        const int last = (int)volume->grid.dims[a] - 1;
        at[a] = (size_t)(place[a] < 0 ? 0 : place[a] > last ? last : place[a]);
    }
    return (double)((float *)volume->data)[support_index(volume, at[0], at[1], at[2])];
}

/* A slice across axis c at (u, v) of the other two axes. */
static double reconstruct(const cvol_volume *volume, const cvol_reconstruction_filter *wide, int c,
                          int slice, double u, double v)
{
    const int a = c == 0, b = c == 2 ? 1 : 2, x = (int)floor(u), y = (int)floor(v);
    double sum = 0, lo = INFINITY, hi = -INFINITY, across[CVOL_FILTER_TAPS], down[CVOL_FILTER_TAPS];
    for (int i = -wide->reach; i <= wide->reach + 1; i++) {
        across[i + wide->reach] = weight(wide, i, u - x);
        down[i + wide->reach] = weight(wide, i, v - y);
    }
    for (int j = -wide->reach; j <= wide->reach + 1; j++)
        for (int i = -wide->reach; i <= wide->reach + 1; i++) {
            int place[3];
            place[a] = x + i;
            place[b] = y + j;
            place[c] = slice;
            const double f = sample(volume, place);
            sum += across[i + wide->reach] * down[j + wide->reach] * f;
            if (i >= -1 && i <= 2 && j >= -1 && j <= 2) {
                lo = fmin(lo, f);
                hi = fmax(hi, f);
            }
        }
    return wide->overshoot ? fmin(fmax(sum, lo), hi) : sum;
}

static cvol_volume noise(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    random_state r = {5};
    for (size_t i = 0; i < nx * ny * nz; i++)
        ((float *)volume.data)[i] = (float)(50 + 40 * random_signed(&r));
    return volume;
}

/* Along an axis, an X-ray is the mean of its slices, of which the first and the last count half;
 * each pixel is a ray. Returns the largest error of pixels more than `within` inside of the faces,
 * relative to the range of values. */
static double compare(const cvol_array *array, const cvol_volume *decoded, int kind, int c,
                      double zoom, double within)
{
    static const double angles[3][2] = {{90, 0}, {0, 0}, {0, 90}};
    cvol_render_options options = support_square(48, CVOL_MODE_XRAY, angles[c][0], angles[c][1]);
    cvol_reconstruction_filter wide;
    cvol_renderer *renderer;
    cvol_image *image;
    double range[2], error = 0, diagonal = 0;
    options.sheet = kinds[kind];
    options.camera.zoom = zoom;
    cvol_reconstruction_filter_make(&wide, &options.sheet);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    assert_int_equal(cvol_renderer_get_range(context, range, renderer), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &image, 48, 48), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
    const size_t *n = decoded->grid.dims;
    for (int a = 0; a < 3; a++)
        diagonal += (double)((n[a] - 1) * (n[a] - 1));
    const double pixel = sqrt(diagonal) / (48 * zoom);
    const int a = c == 0, b = c == 2 ? 1 : 2, slices = (int)n[c];
    int looked_at = 0;
    for (int j = 0; j < 48; j++)
        for (int i = 0; i < 48; i++) {
            const double u = (double)(n[a] - 1) / 2 + (i + 0.5 - 24) * pixel,
                         v = (double)(n[b] - 1) / 2 - (j + 0.5 - 24) * pixel;
            if (u < within || v < within || u > (double)(n[a] - 1) - within ||
                v > (double)(n[b] - 1) - within)
                continue;
            double sum = 0;
            for (int s = 0; s < slices; s++)
                sum += reconstruct(decoded, &wide, c, s, u, v) *
                       (s == 0 || s == slices - 1 ? 0.5 : 1);
            const double grey = (sum / (slices - 1) - range[0]) / (range[1] - range[0]);
            error = fmax(error, fabs(grey - (double)image->values[4 * (j * 48 + i)]));
            looked_at++;
        }
    assert_true(looked_at > 300);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    return error;
}

static void test_direct_sums(void **state)
{
    (void)state;
    static const size_t zero[3] = {0, 0, 0};
    for (int lapped = 0; lapped < 2; lapped++)
        for (int ragged = 0; ragged < 2; ragged++) {
            cvol_volume volume = ragged ? noise(37, 33, 21) : noise(32, 32, 16);
            const size_t *dims = volume.grid.dims;
            cvol_array *array = lapped ? support_lapped(context, volume.data, dims, 0, 0.01, 1, 7)
                                       : support_compress(context, &volume, 16, 90);
            cvol_volume decoded = support_volume(dims[0], dims[1], dims[2], CVOL_FLOAT32);
            assert_int_equal(cvol_array_evaluate_box(context, decoded.data, array, zero, dims),
                             CVOL_OK);
            for (int kind = 0; kind < KINDS; kind++)
                for (int c = 0; c < 3; c++) {
                    const double error = compare(array, &decoded, kind, c, c == 1 ? 4 : 2.2, 0);
                    if (test_verbose())
                        print_message("lapped %d ragged %d kind %d axis %d: %.1e\n", lapped, ragged,
                                      kind, c, error);
                    assert_true(error < 2e-5);
                }
            cvol_array_free(array);
            free(decoded.data);
            free(volume.data);
        }
}

/* ---- options without effect ------------------------------------------------------------------ */

/* Bright blobs in the dark, some blocks apart. */
static cvol_volume islands(void)
{
    cvol_volume volume = support_volume(110, 90, 70, CVOL_FLOAT32);
    random_state r = {9};
    for (int n = 0; n < 14; n++) {
        const double at[3] = {110 * fabs(random_signed(&r)), 90 * fabs(random_signed(&r)),
                              70 * fabs(random_signed(&r))};
        const double width = 1 + 4 * fabs(random_signed(&r));
        for (size_t z = 0; z < 70; z++)
            for (size_t y = 0; y < 90; y++)
                for (size_t x = 0; x < 110; x++) {
                    const double p[3] = {(double)x - at[0], (double)y - at[1], (double)z - at[2]};
                    const double d = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
                    float *f = (float *)volume.data + support_index(&volume, x, y, z);
                    *f = (float)fmax((double)*f, 100 / (1 + exp(4 * (d - width))));
                }
    }
    return volume;
}

/* Pictures of all kinds. */
#define REQUESTS 8
static cvol_render_options request(int k)
{
    cvol_render_options options = support_square(k % 2 ? 64 : 110, CVOL_MODE_COMPOSITE, 47 * k + 12,
                                                 31 * (k % 5) - 60);
    options.camera.zoom = k % 2 ? 5 : 1;
    options.camera.fov_deg = k == 3 || k == 6 ? 60 : 0;
    options.shading.on = k == 4 || k == 5 || k == 6;
    options.step_voxels = k == 7 ? 0.4 : 0;
    options.level = k == 2;
    options.clip.planes = k == 5 || k == 6;
    options.clip.plane[0][0] = options.clip.plane[0][2] = 1;
    return options;
}

static const cvol_transfer_point soft[] = {
    {0, 0.1, 0.2, 1, 0}, {8, 0.1, 0.2, 1, 0}, {60, 1, 0.6, 0.1, 0.4}};
static const cvol_transfer_point nowhere_clear[] = {
    {0, 0.1, 0.2, 1, 1e-7}, {8, 0.1, 0.2, 1, 1e-7}, {60, 1, 0.6, 0.1, 0.4}};

/* Skipping of blocks, the number of threads, and earlier pictures have no effect. */
static void expect_the_same(const cvol_array *array, int array_number, const char *what, int most)
{
    cvol_renderer *used;
    assert_int_equal(
        cvol_renderer_create(context, &used, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, used, soft, 3);
    for (int k = 0; k < REQUESTS; k++) {
        const int kind = (k + array_number) % 3;
        cvol_render_options options = request(k);
        options.sheet = kinds[kind];
        cvol_context_set_threads(context, 1);
        cvol_image *alone = support_sheet(context, array, soft, 3, &options);
        cvol_context_set_threads(context, 3);
        cvol_image *images[2] = {support_picture(context, used, &options),
                                 support_sheet(context, array, nowhere_clear, 3, &options)};
        const int differences[2] = {support_difference(alone, images[0]),
                                    support_difference(alone, images[1])};
        if (differences[0] || differences[1] > most)
            print_message("%s, request %d, kind %d: %d %d\n", what, k, kind, differences[0],
                          differences[1]);
        assert_true(!differences[0] && differences[1] <= most);
        cvol_image_free(alone);
        cvol_image_free(images[0]);
        cvol_image_free(images[1]);
    }
    cvol_renderer_free(used);
}

/* Samples without a value: balls, and every eleventh sample. */
static void make_holes(cvol_array *array)
{
    static const size_t zero[3] = {0, 0, 0};
    const size_t *dims = cvol_array_grid(array)->dims;
    uint8_t *which = calloc(dims[0] * dims[1] * dims[2], 1);
    cvol_fills fills = {0};
    uint64_t bits;
    assert_non_null(which);
    for (size_t i = 0; i < dims[0] * dims[1] * dims[2]; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0] % dims[1]),
                     z = (double)(i / dims[0] / dims[1]);
        which[i] = i % 11 == 0 || sin(0.2 * x) * sin(0.15 * y) * sin(0.3 * z + 1) > 0.3;
    }
    assert_true(cvol_fills_of_value(&bits, CVOL_FLOAT32, 1e35) && cvol_fills_add(&fills, bits));
    assert_int_equal(cvol_mask_create(context, &array->mask, dims, &fills), CVOL_OK);
    assert_true(cvol_mask_set(array->mask, which, zero, dims));
    free(which);
}

static void test_other_options_have_no_effect(void **state)
{
    (void)state;
    cvol_volume volume = islands();
    for (int block = 8; block <= 16; block += 8) {
        cvol_array *array = support_compress(context, &volume, block, 60);
        expect_the_same(array, block / 8, block == 8 ? "blocks of 8" : "blocks of 16", 2);
        cvol_array_free(array);
    }
    cvol_array *array = support_lapped(context, volume.data, volume.grid.dims, 0, 0.05, 1, 3);
    expect_the_same(array, 0, "lapped", 2);
    make_holes(array);
    expect_the_same(array, 1, "with holes", 32); /* linear ones differ by 26 */
    cvol_array_free(array);
    free(volume.data);
}

/* Next to samples without a value, footprints use the existing samples: a ramp remains one. */
static void test_holes(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(40, 36, 34, CVOL_FLOAT32);
    for (size_t z = 0; z < 34; z++)
        for (size_t y = 0; y < 36; y++)
            for (size_t x = 0; x < 40; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)(10 + (double)x +
                                                                                  0.5 * (double)y +
                                                                                  0.7 * (double)z);
    cvol_array *array = support_lapped(context, volume.data, volume.grid.dims, 0, 0.01, 0, 3);
    make_holes(array);
    for (int k = 0; k < 6; k++) {
        cvol_render_options options = support_square(
            96, k / 3 ? CVOL_MODE_MIP : CVOL_MODE_COMPOSITE, 30 + 70 * k, 25);
        options.camera.zoom = k % 2 ? 3 : 1;
        cvol_image *linear = support_sheet(context, array, soft, 3, &options);
        options.sheet = kinds[k % 3];
        cvol_image *wide = support_sheet(context, array, soft, 3, &options);
        const double db = support_psnr(linear, wide);
        if (test_verbose())
            print_message("holes, request %d: %.1f dB\n", k, db);
        assert_true(db > 30);
        cvol_image_free(linear);
        cvol_image_free(wide);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Volumes of few samples along an axis: pictures show nothing else. (The warp is cubic, too, and
 * floats may overshoot.) */
static void test_thin(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {
        {1, 20, 20}, {20, 1, 5}, {2, 2, 2}, {17, 3, 40}, {33, 18, 1}};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        cvol_volume volume = noise(shapes[s][0], shapes[s][1], shapes[s][2]);
        cvol_array *array = support_compress(context, &volume, s % 2 ? 8 : 16, 60);
        cvol_renderer *renderer;
        cvol_image *image;
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET,
                                              CVOL_SOURCE(.array = array)),
                         CVOL_OK);
        support_set_transfer(context, renderer, soft, 3);
        assert_int_equal(cvol_image_create_float(context, &image, 40, 40), CVOL_OK);
        for (int k = 0; k < 12; k++) {
            cvol_render_options options = support_square(
                40, k % 2 ? CVOL_MODE_COMPOSITE : CVOL_MODE_MIP, 90 * (k % 4) + k / 4,
                40 * (k % 3));
            options.sheet = kinds[k % 3];
            options.shading.on = k % 4 == 1;
            options.camera.zoom = k % 5 ? 1 : 4;
            options.camera.fov_deg = k > 8 ? 60 : 0;
            if (cvol_renderer_render(context, renderer, image, &options))
                fail_msg("%s", cvol_context_message(context));
            for (int i = 0; i < 4 * 40 * 40; i++)
                if (!(image->values[i] > -0.2f && image->values[i] < 1.5f))
                    fail_msg("shape %zu, request %d, value %d: %g", s, k, i,
                             (double)image->values[i]);
        }
        cvol_image_free(image);
        cvol_renderer_free(renderer);
        cvol_array_free(array);
        free(volume.data);
    }
}

static void test_refused(void **state)
{
    (void)state;
    cvol_volume volume = noise(17, 16, 16);
    cvol_array *array = support_compress(context, &volume, 16, 40);
    cvol_render_options options = support_square(16, CVOL_MODE_MIP, 0, 0);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    assert_int_equal(cvol_image_create(context, &image, 16, 16), CVOL_OK);
    options.sheet.footprint = (cvol_sheet_footprint)4;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "footprint 4 is unknown"));
    options.sheet = (cvol_sheet_options){CVOL_SHEET_GAUSSIAN, 1.1, CVOL_RAY_ORDER_IMAGE};
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "sigma 1.1"));
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_weights),     TEST(test_frequencies),
        TEST(test_direct_sums), TEST(test_other_options_have_no_effect),
        TEST(test_holes),       TEST(test_thin),
        TEST(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
