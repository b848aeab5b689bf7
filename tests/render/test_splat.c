/* The splat engine against a direct sum of footprints, against results computed by hand, and
 * against the ray engine. */
#include "test.h"

#include "random.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

static cvol_image *draw(cvol_renderer *renderer, const cvol_transfer_point *points, size_t count,
                        const cvol_render_options *options)
{
    support_set_transfer(context, renderer, points, count);
    cvol_image *image = support_picture(context, renderer, options);
    cvol_renderer_free(renderer);
    return image;
}

static cvol_image *splat(const cvol_volume *volume, const cvol_transfer_point *points, size_t count,
                         const cvol_render_options *options)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SPLAT, CVOL_SOURCE(.volume = volume)),
        CVOL_OK);
    return draw(renderer, points, count, options);
}

static cvol_image *splat_array(const cvol_array *array, const cvol_transfer_point *points,
                               size_t count, const cvol_render_options *options)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SPLAT, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    return draw(renderer, points, count, options);
}

/* ---- the direct sum ---------------------------------------------------------------------- */

/* A footprint at (x, y) pixels from its sample. Gram-Schmidt on the rows of the projection gives
 * the ellipse's matrix: y depends on one coordinate, x on both. */
static double footprint(const cvol_splat_options *o, double project[2][3], double x, double y)
{
    double yy = 0, xy = 0, rest = 0, half = o->size / 2.0;
    for (int a = 0; a < 3; a++) {
        yy += project[1][a] * project[1][a];
        xy += project[0][a] * project[1][a];
    }
    for (int a = 0; a < 3; a++) {
        double p = project[0][a] - xy / yy * project[1][a];
        rest += p * p;
    }
    double qy = y / sqrt(yy), qx = (x - y * xy / yy) / sqrt(rest), r = sqrt(qx * qx + qy * qy);
    if (o->footprint == CVOL_FOOTPRINT_BOX)
        return fmin(fmax((half - fabs(qx)) * 8 + 0.5, 0), 1) *
               fmin(fmax((half - fabs(qy)) * 8 + 0.5, 0), 1);
    if (fabs(qx) >= half || fabs(qy) >= half)
        return 0;
    if (o->footprint == CVOL_FOOTPRINT_CONE)
        return r < half ? 1 - r / half : 0;
    if (o->footprint == CVOL_FOOTPRINT_GAUSSIAN) {
        double sigma = o->sigma > 0 ? o->sigma : o->size / 6.0;
        return exp(-r * r / (2 * sigma * sigma));
    }
    double product = 1;
    for (int k = 0; k < 2; k++) {
        double t = k ? qy : qx, pi = acos(-1);
        product *= fabs(t) < 1e-9 ? 1 : sin(pi * t) / (pi * t) * pow(cos(pi * t / o->size), 2);
    }
    return product;
}

/* The picture of a float volume, unlit, pixel by pixel and sample by sample; RGB, not rounded. */
static double *direct_sum(const cvol_volume *volume, const cvol_transfer_point *points,
                          size_t count, const cvol_render_options *options)
{
    cvol_view view;
    assert_int_equal(cvol_view_make(context, &view, &volume->grid, options), CVOL_OK);
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, points, count), CVOL_OK);
    const double *spacing = volume->grid.spacing;
    const size_t *n = volume->grid.dims;
    double project[2][3];
    int axis = 0;
    for (int a = 0; a < 3; a++) {
        project[0][a] = view.right[a] * spacing[a] / view.pixel;
        project[1][a] = -view.up[a] * spacing[a] / view.pixel;
        if (fabs(view.eye[a] / spacing[a]) > fabs(view.eye[axis] / spacing[axis]))
            axis = a;
    }
    const int lane = (axis + 1) % 3, row = (axis + 2) % 3;
    const double distance = spacing[axis] / fabs(view.eye[axis]) / view.mean_spacing;
    double *out = calloc(3 * (size_t)(view.width * view.height), sizeof *out);
    assert_non_null(out);
    for (int j = 0; j < view.height; j++)
        for (int i = 0; i < view.width; i++) {
            double rgb[3] = {0}, through = 1;
            for (size_t k = 0; k < n[axis]; k++) {
                const size_t slice = view.eye[axis] > 0 ? n[axis] - 1 - k : k;
                double sums[4] = {0}, weights = 0;
                /* samples beyond the volume count for the weights only */
                for (long v = -35; v < (long)n[row] + 35; v++)
                    for (long u = -35; u < (long)n[lane] + 35; u++) {
                        long at[3];
                        at[axis] = (long)slice;
                        at[lane] = u;
                        at[row] = v;
                        double x = i + 0.5 - view.width / 2.0, y = j + 0.5 - view.height / 2.0;
                        for (int a = 0; a < 3; a++) {
                            double place = (double)at[a] - (double)(n[a] - 1) / 2;
                            x -= project[0][a] * place;
                            y -= project[1][a] * place;
                        }
                        double w = footprint(&options->splat, project, x, y);
                        weights += w;
                        if (w == 0 || u < 0 || v < 0 || u >= (long)n[lane] || v >= (long)n[row])
                            continue;
                        float value = ((float *)volume->data)[support_index(
                            volume, (size_t)at[0], (size_t)at[1], (size_t)at[2])];
                        cvol_transfer_point p = cvol_transfer_at(transfer, (double)value);
                        double opacity = 1 - pow(1 - p.opacity, distance);
                        sums[0] += w * opacity * p.r;
                        sums[1] += w * opacity * p.g;
                        sums[2] += w * opacity * p.b;
                        sums[3] += w * opacity;
                    }
                for (int c = 0; c < 3; c++)
                    rgb[c] += through * sums[c] / weights;
                through *= 1 - fmin(fmax(sums[3] / weights, 0), 1);
            }
            for (int c = 0; c < 3; c++) {
                double level = rgb[c] + through * options->background[c];
                out[3 * (j * view.width + i) + c] = 255 * fmin(fmax(level, 0), 1);
            }
        }
    cvol_transfer_free(transfer);
    return out;
}

static double psnr_to_sum(const cvol_image *image, const double *sum, double *worst)
{
    double square = 0;
    const int pixels = image->width * image->height;
    *worst = 0;
    for (int p = 0; p < pixels; p++)
        for (int c = 0; c < 3; c++) {
            double d = image->rgba[4 * p + c] - sum[3 * p + c];
            square += d * d;
            *worst = fmax(*worst, fabs(d));
        }
    return 10 * log10(255 * 255 / (square / (3 * pixels)));
}

static const char *const names[] = {"", "gaussian", "cone", "sinc", "box"};

static void test_direct_sum(void **state)
{
    (void)state;
    random_state random = {77};
    cvol_volume volume = support_volume(7, 8, 6, CVOL_FLOAT32);
    for (int i = 0; i < 7 * 8 * 6; i++)
        ((float *)volume.data)[i] = (float)(50 + 50 * random_signed(&random));
    const cvol_transfer_point points[] = {
        {20, 0.2, 0.4, 0.6, 0}, {50, 0.9, 0.3, 0.1, 0.3}, {80, 0.5, 0.9, 0.5, 0.7}};
    const struct {
        cvol_footprint kind;
        int size;
        double sigma, azimuth, elevation, roll, zoom, spacing[3];
    } cases[] = {
        {CVOL_FOOTPRINT_GAUSSIAN, 3, 0, 0, 0, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_GAUSSIAN, 5, 0, 30, 20, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_GAUSSIAN, 5, 0.6, 200, -35, 25, 0.6, {1, 1.5, 0.7}},
        {CVOL_FOOTPRINT_GAUSSIAN, 4, 0.5, 45, 45, 0, 2.5, {1, 1, 3}},
        {CVOL_FOOTPRINT_GAUSSIAN, 31, 4, 110, 60, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_CONE, 3, 0, 17, 71, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_CONE, 7, 0, 290, 10, 50, 1.4, {0.8, 1, 1.2}},
        {CVOL_FOOTPRINT_SINC, 5, 0, 60, 30, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_SINC, 9, 0, 180, -90, 0, 1, {1, 2, 1}},
        {CVOL_FOOTPRINT_BOX, 3, 0, 0, 0, 0, 1, {1, 1, 1}},
        {CVOL_FOOTPRINT_BOX, 15, 0, 75, 40, 10, 1, {1, 1, 1}},
    };
    for (int k = 0; k < (int)(sizeof cases / sizeof *cases); k = support_next(k)) {
        memcpy(volume.grid.spacing, cases[k].spacing, sizeof volume.grid.spacing);
        cvol_render_options options = support_square(24, CVOL_MODE_COMPOSITE, cases[k].azimuth,
                                                     cases[k].elevation);
        options.camera.roll_deg = cases[k].roll;
        options.camera.zoom = cases[k].zoom;
        options.splat.footprint = cases[k].kind;
        options.splat.size = cases[k].size;
        options.splat.sigma = cases[k].sigma;
        options.background[2] = 0.4;
        cvol_image *image = splat(&volume, points, 3, &options);
        double *sum = direct_sum(&volume, points, 3, &options), worst;
        double psnr = psnr_to_sum(image, sum, &worst);
        if (!(psnr >= 46) || !(worst <= 4))
            fail_msg("case %d, %s %d: %.1f dB, off by %.1f", k, names[cases[k].kind], cases[k].size,
                     psnr, worst);
        free(sum);
        cvol_image_free(image);
    }
    free(volume.data);
}

/* ---- by hand ------------------------------------------------------------------------------- */

/* A slice of one value is flat away from borders, for any footprint and direction, and as opaque as
 * its thickness along the view. */
static void test_flat_slices(void **state)
{
    (void)state;
    const size_t side = 48, slices = 3;
    cvol_volume volume = support_volume(side, side, slices, CVOL_UINT8);
    memset(volume.data, 9, side * side * slices);
    volume.grid.spacing[2] = 1.4;
    const double opacity = 0.3, mean = 3.4 / 3;
    const cvol_transfer_point points[] = {{0, 1, 1, 1, opacity}};
    for (int kind = CVOL_FOOTPRINT_GAUSSIAN; kind <= CVOL_FOOTPRINT_BOX; kind++)
        for (int size = 3; size <= 15; size += 4)
            for (int view = 0; view < 5; view++) {
                const double angles[5][2] = {{0, 90}, {30, 90}, {10, 60}, {45, 50}, {100, -60}};
                cvol_render_options options = support_square(63, CVOL_MODE_COMPOSITE,
                                                             angles[view][0], angles[view][1]);
                options.splat.footprint = (cvol_footprint)kind;
                options.splat.size = size;
                cvol_image *image = splat(&volume, points, 1, &options);
                double tilt = sin(fabs(angles[view][1]) * acos(-1) / 180);
                double expected = 255 * (1 - pow(1 - opacity, 3 * 1.4 / tilt / mean));
                double most = 0;
                for (int j = 26; j <= 36; j++)
                    for (int i = 26; i <= 36; i++)
                        most = fmax(most, fabs(support_pixel(image, i, j)[0] - expected));
                double allowed = size == 3 ? 2.5 : 1.5;
                if (!(most <= allowed))
                    fail_msg("%s %d, view %d: off by %.2f of %.1f", names[kind], size, view, most,
                             expected);
                cvol_image_free(image);
            }
    free(volume.data);
}

/* Slices of one value stay as opaque where many samples share a pixel; a picture of a volume far
 * smaller than a pixel has finite values. */
static void test_small_pictures(void **state)
{
    (void)state;
    const size_t side = 600;
    cvol_volume volume = support_volume(side, side, 1, CVOL_UINT8);
    memset(volume.data, 9, side * side);
    const cvol_transfer_point points[] = {{0, 1, 1, 1, 0.3}};
    for (int kind = CVOL_FOOTPRINT_GAUSSIAN; kind <= CVOL_FOOTPRINT_BOX; kind++)
        for (int size = 3; size <= 7; size += 4)
            for (int pixels = 3; pixels <= 300; pixels = pixels * 3 + 2) {
                cvol_render_options options = support_square(pixels, CVOL_MODE_COMPOSITE, 20, 90);
                options.splat.footprint = (cvol_footprint)kind;
                options.splat.size = size;
                cvol_image *image = splat(&volume, points, 1, &options);
                const double value = support_pixel(image, pixels / 2, pixels / 2)[0];
                if (!(fabs(value - 0.3 * 255) <= 2.5))
                    fail_msg("%s %d, %d pixels: %.2f", names[kind], size, pixels, value);
                cvol_image_free(image);
                options.camera.zoom = 1e-6;
                image = splat(&volume, points, 1, &options);
                for (int at = 0; at < pixels * pixels; at++)
                    assert_true(support_pixel(image, at % pixels, at / pixels)[0] <= 1);
                cvol_image_free(image);
            }
    free(volume.data);
}

/* All gradients of a ramp are the same: every sample is lit equally. */
static void test_light(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(20, 22, 24, CVOL_FLOAT32);
    const double slope[3] = {0.6, -0.3, 0.5};
    const double spacing[3] = {1, 1.3, 0.8};
    memcpy(volume.grid.spacing, spacing, sizeof spacing);
    for (size_t z = 0; z < 24; z++)
        for (size_t y = 0; y < 22; y++)
            for (size_t x = 0; x < 20; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(100 + slope[0] * (double)x * spacing[0] +
                            slope[1] * (double)y * spacing[1] + slope[2] * (double)z * spacing[2]);
    /* Opaque inside, and a shell of transparent samples with one-sided differences. */
    const cvol_transfer_point points[] = {{0, 0.5, 0.5, 0.5, 0.4}};
    const double lights[3][3] = {{0, 0, 0}, {1, 2, 3}, {-5, -20, 3}};
    for (int a = 0; a < 360; a += 30)
        for (int l = 0; l < 3; l++) {
            cvol_render_options options = support_square(41, CVOL_MODE_COMPOSITE, a + 5, a / 4.0);
            options.shading.on = 1;
            memcpy(options.shading.light, lights[l], sizeof lights[l]);
            cvol_view view;
            assert_int_equal(cvol_view_make(context, &view, &volume.grid, &options), CVOL_OK);
            double n[3], light[3], norms[2] = {0}, dots[2] = {0}, away = 0, facing = 0;
            for (int k = 0; k < 3; k++) {
                light[k] = l ? lights[l][k] : view.eye[k];
                n[k] = slope[k];
                norms[0] += n[k] * n[k];
                norms[1] += light[k] * light[k];
                away += n[k] * view.eye[k];
            }
            for (int k = 0; k < 3; k++) {
                double turned = (away < 0 ? -n[k] : n[k]) / sqrt(norms[0]);
                dots[0] += turned * light[k] / sqrt(norms[1]);
                dots[1] += turned * view.eye[k];
                facing += light[k] / sqrt(norms[1]) * view.eye[k];
            }
            double expected = 0.5 * (0.1 + 0.7 * fmax(dots[0], 0));
            if (dots[0] > 0)
                expected += 0.2 * pow(fmax(2 * dots[0] * dots[1] - facing, 0), 10);
            cvol_image *image = splat(&volume, points, 1, &options);
            /* of the light; at the near face other normals hide 40% and more */
            double level = support_pixel(image, 20, 20)[0] / 255.0;
            if (fabs(away) / sqrt(norms[0]) > 0.2 && fabs(level - expected) > 0.12)
                fail_msg("azimuth %d, light %d: %.3f, expected %.3f", a + 5, l, level, expected);
            cvol_image_free(image);
        }
    free(volume.data);
}

/* ---- invariances --------------------------------------------------------------------------- */

static void test_same_for_any_order(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(40, 44, 48);
    for (int a = 0; a < 360; a += 60)
        for (int e = -90; e <= 90; e += 45) {
            cvol_render_options options = support_square(70, CVOL_MODE_COMPOSITE, a + 7, e);
            options.shading.on = a > 100;
            options.background[0] = 0.3;
            cvol_image *front = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS, &options);
            options.splat.order = CVOL_ORDER_BACK;
            cvol_image *back = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS, &options);
            assert_true(support_difference(front, back) <= 1);
            assert_true(support_psnr(front, back) >= 70);
            cvol_image_free(front);
            cvol_image_free(back);
        }
    free(volume.data);
}

static void test_same_for_any_threads(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(60, 34, 38);
    for (int size = 3; size <= 31; size += 28) {
        cvol_render_options options = support_square(197, CVOL_MODE_COMPOSITE, 77, 12);
        options.splat.size = size;
        options.shading.on = 1;
        cvol_context_set_threads(context, 1);
        cvol_image *one = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS, &options);
        for (int threads = 2; threads <= 5; threads += 3) {
            cvol_context_set_threads(context, threads);
            cvol_image *many = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS, &options);
            assert_int_equal(support_difference(one, many), 0);
            cvol_image_free(many);
        }
        cvol_image_free(one);
    }
    free(volume.data);
}

/* Smooth volumes look the same by rays and by footprints that hardly blur them. */
static void test_equals_rays(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(64, 70, 76);
    for (int a = 0; a < 360; a += 72)
        for (int e = -60; e <= 90; e += 75) {
            cvol_render_options options = support_square(90, CVOL_MODE_COMPOSITE, a, e);
            options.step_voxels = 0.25;
            cvol_image *ray = support_ray(context, &volume, support_blob_points,
                                          SUPPORT_BLOB_POINTS, &options);
            for (int kind = CVOL_FOOTPRINT_GAUSSIAN; kind <= CVOL_FOOTPRINT_CONE; kind++) {
                options.splat.footprint = (cvol_footprint)kind;
                options.splat.size = kind == CVOL_FOOTPRINT_CONE ? 3 : 5;
                options.splat.sigma = 0.7;
                cvol_image *sum = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                        &options);
                double psnr = support_psnr(ray, sum);
                if (!(psnr >= 40))
                    fail_msg("%s, azimuth %d, elevation %d: %.1f dB", names[kind], a, e, psnr);
                cvol_image_free(sum);
            }
            cvol_image_free(ray);
        }
    free(volume.data);
}

/* A wide Gaussian against rays through a volume that is blurred by the same kernel beforehand.
 * Footprints blur after classification, so colour and opacity must be proportional to samples, and
 * small. */
static void test_wide_gaussian(void **state)
{
    (void)state;
    const size_t n = 48;
    const double sigma = 2;
    cvol_volume volume = support_volume(n, n, n, CVOL_FLOAT32);
    float *samples = volume.data;
    for (size_t z = 12; z < 36; z++)
        for (size_t y = 12; y < 36; y++)
            for (size_t x = 12; x < 36; x++)
                samples[support_index(&volume, x, y, z)] = (x / 6 + y / 6 + z / 6) % 2 ? 1.25f
                                                                                       : 0.25f;
    cvol_volume blurred = support_volume(n, n, n, CVOL_FLOAT32);
    memcpy(blurred.data, samples, n * n * n * sizeof *samples);
    const size_t steps[3] = {1, n, n * n};
    for (int a = 0; a < 3; a++)
        for (size_t line = 0; line < n * n; line++) {
            float *at = (float *)blurred.data + line % n * steps[a == 0] +
                        line / n * steps[a == 2 ? 1 : 2];
            float old[48];
            for (size_t i = 0; i < n; i++)
                old[i] = at[i * steps[a]];
            for (size_t i = 0; i < n; i++) {
                double sum = 0, weights = 0;
                for (long k = -9; k <= 9; k++) {
                    double w = exp(-(double)(k * k) / (2 * sigma * sigma));
                    weights += w;
                    if ((long)i + k >= 0 && (long)i + k < (long)n)
                        sum += w * (double)old[(long)i + k];
                }
                at[i * steps[a]] = (float)(sum / weights);
            }
        }
    const cvol_transfer_point points[] = {{0, 1, 1, 1, 0}, {1.25, 1, 1, 1, 0.05}};
    for (int a = 0; a < 180; a += 60)
        for (int e = 0; e <= 60; e += 30) {
            cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, a, e);
            options.splat.size = 13;
            options.splat.sigma = sigma;
            options.step_voxels = 0.25;
            cvol_image *sum = splat(&volume, points, 2, &options);
            cvol_image *ray = support_ray(context, &blurred, points, 2, &options);
            double psnr = support_psnr(sum, ray);
            if (!(psnr >= 38))
                fail_msg("azimuth %d, elevation %d: %.1f dB", a, e, psnr);
            cvol_image_free(sum);
            cvol_image_free(ray);
        }
    free(volume.data);
    free(blurred.data);
}

/* Samples of arrays come slab by slab: the pictures are those of the decompressed samples. */
static void test_arrays(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(50, 44, 72);
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *array = support_compress(context, &volume, lapped ? 16 : 8, 45);
        cvol_volume dense = support_volume(50, 44, 72, CVOL_FLOAT32);
        const size_t begin[3] = {0, 0, 0};
        assert_int_equal(
            cvol_array_evaluate_box(context, dense.data, array, begin, volume.grid.dims), CVOL_OK);
        for (int a = 0; a < 360; a += 45)
            for (int e = -80; e <= 80; e += 80) {
                cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, a, e);
                options.shading.on = 1;
                options.splat.order = a % 90 ? CVOL_ORDER_FRONT : CVOL_ORDER_BACK;
                cvol_image *from_array = splat_array(array, support_blob_points,
                                                     SUPPORT_BLOB_POINTS, &options);
                cvol_image *from_dense = splat(&dense, support_blob_points, SUPPORT_BLOB_POINTS,
                                               &options);
                assert_true(support_psnr(from_array, from_dense) >= 55);
                cvol_image_free(from_array);
                cvol_image_free(from_dense);
            }
        free(dense.data);
        cvol_array_free(array);
    }
    free(volume.data);
}

/* Samples without a value count as transparent. */
static void test_mask(void **state)
{
    (void)state;
    const size_t dims[3] = {40, 36, 44};
    cvol_volume volume = support_blobs(40, 36, 44);
    float *samples = volume.data;
    for (size_t z = 10; z < 30; z++)
        for (size_t y = 8; y < 30; y++)
            for (size_t x = 12; x < 40; x++)
                samples[support_index(&volume, x, y, z)] = 1e35f;
    cvol_compress_options compress = cvol_compress_options_defaults();
    compress.target = CVOL_TARGET_PSNR;
    compress.target_value = 90;
    compress.has_fill = 1;
    compress.fill = 1e35;
    cvol_array *array;
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &compress),
                     CVOL_OK);
    const size_t begin[3] = {0, 0, 0};
    assert_int_equal(cvol_array_evaluate_box(context, samples, array, begin, dims), CVOL_OK);
    for (size_t i = 0; i < dims[0] * dims[1] * dims[2]; i++)
        samples[i] = samples[i] > 1e30f ? 0 : samples[i];
    for (int a = 0; a < 360; a += 90) {
        cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, a + 10, a / 4.0);
        cvol_image *masked = splat_array(array, support_blob_points, SUPPORT_BLOB_POINTS, &options);
        cvol_image *cut = splat(&volume, support_blob_points, SUPPORT_BLOB_POINTS, &options);
        assert_true(support_psnr(masked, cut) >= 60);
        cvol_image_free(cut);
        cvol_image_free(masked);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* All sizes: wider ones are softer, but equally bright. */
static void test_all_sizes(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(30, 34, 38);
    double before = 0;
    for (int size = 3; size <= 31; size++) {
        cvol_render_options options = support_square(120, CVOL_MODE_COMPOSITE, 33, 21);
        options.camera.zoom = 0.5;
        options.splat.size = size;
        cvol_transfer_point faint[SUPPORT_BLOB_POINTS];
        for (int k = 0; k < SUPPORT_BLOB_POINTS; k++) {
            faint[k] = support_blob_points[k];
            faint[k].opacity *= 0.1;
        }
        cvol_image *image = splat(&volume, faint, SUPPORT_BLOB_POINTS, &options);
        double light = 0;
        for (int i = 0; i < 120 * 120; i++)
            light += image->rgba[4 * i];
        if (before > 0 && fabs(light / before - 1) > 0.06)
            fail_msg("size %d: light %g after %g", size, light, before);
        before = light;
        cvol_image_free(image);
    }
    free(volume.data);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refuse(const cvol_volume *volume, cvol_render_options options, const char *what)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SPLAT, CVOL_SOURCE(.volume = volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_image_create(context, &image, options.width, options.height), CVOL_OK);
    int code = cvol_renderer_render(context, renderer, image, &options);
    assert_true(code == CVOL_ERROR_ARGUMENT || code == CVOL_ERROR_LIMIT);
    if (!strstr(cvol_context_message(context), what))
        fail_msg("'%s' lacks '%s'", cvol_context_message(context), what);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(8, 8, 8);
    const cvol_render_options good = support_square(16, CVOL_MODE_COMPOSITE, 0, 0);
    cvol_render_options bad = good;
    bad.mode = CVOL_MODE_XRAY;
    refuse(&volume, bad, "composite");
    bad = good;
    bad.splat.footprint = (cvol_footprint)5;
    refuse(&volume, bad, "footprint");
    for (int size = 2; size <= 32; size += 30) {
        bad = good;
        bad.splat.size = size;
        refuse(&volume, bad, "3 to 31");
    }
    for (int k = 0; k < 4; k++) {
        bad = good;
        bad.splat.sigma = (const double[]){-1, 0.1, 32, NAN}[k];
        refuse(&volume, bad, "sigma");
    }
    bad = good;
    bad.splat.order = (cvol_order)0;
    refuse(&volume, bad, "order");
    bad = good;
    bad.shading.on = 1;
    bad.shading.light[1] = INFINITY;
    refuse(&volume, bad, "light");
    bad = good;
    bad.camera.zoom = 1e6;
    refuse(&volume, bad, "pixels");
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_direct_sum),
        cmocka_unit_test(test_flat_slices),
        cmocka_unit_test(test_small_pictures),
        cmocka_unit_test(test_light),
        cmocka_unit_test(test_same_for_any_order),
        cmocka_unit_test(test_same_for_any_threads),
        cmocka_unit_test(test_equals_rays),
        cmocka_unit_test(test_wide_gaussian),
        cmocka_unit_test(test_arrays),
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_all_sizes),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
