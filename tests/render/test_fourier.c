/* The fourier engine: its spectra against direct sums, its pictures against the ray engine. */
#include "test.h"

#include "random.h"
#include "render/fourier/spectrum.h"
#include "support_context.h"
#include "support_render.h"

static cvol_volume noise(size_t nx, size_t ny, size_t nz, uint64_t seed)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    random_state r = {seed};
    for (size_t i = 0; i < nx * ny * nz; i++)
        ((float *)volume.data)[i] = (float)(3 + random_signed(&r));
    return volume;
}

static cvol_renderer *renderer_of(const cvol_volume *volume)
{
    cvol_renderer *renderer;
    if (cvol_renderer_create(context, &renderer, CVOL_ENGINE_FOURIER,
                             CVOL_SOURCE(.volume = volume, .rho = 0)))
        fail_msg("%s", cvol_context_message(context));
    return renderer;
}

static float *project(cvol_renderer *renderer, const cvol_render_options *options,
                      const double (*rotations)[4], size_t count)
{
    float *out = calloc(count * (size_t)options->width * (size_t)options->height, sizeof *out);
    assert_non_null(out);
    if (cvol_renderer_project(context, renderer, out, options, rotations, count))
        fail_msg("%s", cvol_context_message(context));
    return out;
}

/* One projection from the options' angles. */
static float *project_camera(cvol_renderer *renderer, const cvol_render_options *options)
{
    double rotation[1][4];
    cvol_camera_get_rotation(rotation[0], &options->camera);
    return project(renderer, options, (const double(*)[4])rotation, 1);
}

/* ---- spectra --------------------------------------------------------------------------------- */

/* sum of f (near + i sum slope x 2 pi / i ...): F, or F weighted by slopes along g. */
static void direct(double out[2], const cvol_volume *volume, double base, const double g[3],
                   const size_t N[3], float near, const float slope[3])
{
    const size_t *n = volume->grid.dims;
    out[0] = out[1] = 0;
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        const size_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
        double f = (double)((float *)volume->data)[i] - base, interpolates_gradients = 0,
               weight = near;
        for (int a = 0; a < 3; a++) {
            const double place = (double)at[a] - (double)(n[a] / 2);
            f *= n[a] > 1 && (at[a] == 0 || at[a] + 1 == n[a]) ? 0.5 : 1;
            interpolates_gradients -= place * g[a] / (double)N[a];
            /* i d/dg exp(-2 pi i place g / N) multiplies it by 2 pi place / N */
            weight += (double)slope[a] * 2 * acos(-1) * place / (double)N[a];
        }
        out[0] += f * weight * cos(2 * acos(-1) * interpolates_gradients);
        out[1] += f * weight * sin(2 * acos(-1) * interpolates_gradients);
    }
}

static void test_spectrum(void **state)
{
    static const size_t shapes[][3] = {{12, 9, 7}, {5, 16, 11}, {1, 20, 8}, {7, 1, 1}, {1, 1, 1}};
    (void)state;
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        cvol_volume volume = noise(shapes[s][0], shapes[s][1], shapes[s][2], 11 + s);
        cvol_fourier_source source = {.volume = &volume, .min = 0, .max = 5};
        cvol_fourier_volume spectra;
        cvol_fourier_kernel kernel;
        random_state r = {77 + s};
        cvol_fourier_kernel_make(&kernel);
        assert_int_equal(cvol_fourier_volume_make(context, &spectra, &source, 0), CVOL_OK);
        const double samples = (double)(shapes[s][0] * shapes[s][1] * shapes[s][2]);
        for (int attempt = 0; attempt < 60; attempt++) {
            float re[64], im[64];
            cvol_fourier_line line = {.spectrum = &spectra.samples,
                                      .kernel = &kernel,
                                      .near = 1,
                                      .cued = attempt % 2,
                                      .count = 1 + random_below(&r, 40)};
            for (int a = 0; a < 3; a++) {
                const double N = (double)spectra.samples.dims[a];
                line.start[a] = attempt < 4 ? (attempt < 2 ? 0 : N / 2) : N * random_signed(&r);
                line.step[a] = random_signed(&r);
                line.slope[a] = line.cued ? (float)random_signed(&r) : 0;
            }
            CVOL_SIMD_CHOOSE(cvol_fourier_gather)(re, im, &line);
            for (size_t k = 0; k < line.count; k++) {
                double g[3], truth[2];
                for (int a = 0; a < 3; a++)
                    g[a] = line.start[a] + (double)k * line.step[a];
                direct(truth, &volume, spectra.base, g, spectra.samples.dims, line.near,
                       line.slope);
                const double off = hypot((double)re[k] - truth[0], (double)im[k] - truth[1]);
                /* noise has the amplitude sqrt(samples); half floats err by 0.00024 of the
                 * largest */
                if (!(off <= 0.0006 * (line.cued ? 12 : 1) * sqrt(samples) + 1e-4))
                    fail_msg("shape %zu, trial %d, point %zu (%g %g %g): %g + %g i, is %g + %g i",
                             s, attempt, k, g[0], g[1], g[2], truth[0], truth[1], (double)re[k],
                             (double)im[k]);
            }
        }
        cvol_fourier_volume_free(&spectra);
        free(volume.data);
    }
}

static void test_half_floats(void **state)
{
    (void)state;
    float in[40], scale = 0.5f;
    uint16_t out[40];
    const float values[8] = {0,     2, -4, 131008, 1e9f, 2 * 6.103515625e-5f, 2 * 5.9604645e-8f,
                             -1e-9f};
    const uint16_t halves[8] = {0, 0x3c00, 0xc000, 0x7bff, 0x7bff, 0x0400, 0x0001, 0x8000};
    for (int i = 0; i < 40; i++)
        in[i] = values[i % 8];
    /* the vector's own rounding makes large values infinite; the expected value never is */
    CVOL_SIMD_CHOOSE(cvol_fourier_pack)(out, in, 40, scale);
    for (int i = 0; i < 40; i++)
        if (i % 8 != 4)
            assert_int_equal(out[i], halves[i % 8]);
}

/* ---- pictures -------------------------------------------------------------------------------- */

static cvol_image *ray(const cvol_volume *volume, cvol_render_options options)
{
    options.step_voxels = 0.25;
    return support_ray(context, volume, NULL, 0, &options);
}

static void test_against_rays(void **state)
{
    (void)state;
    random_state r = {5};
    cvol_volume volume = support_blobs(40, 33, 26);
    volume.grid.spacing[1] = 1.3;
    volume.grid.spacing[2] = 0.7;
    cvol_renderer *renderer = renderer_of(&volume);
    for (int v = 0; v < 24; v++) {
        cvol_render_options options = support_square(90, CVOL_MODE_XRAY, 180 * random_signed(&r),
                                                     90 * random_signed(&r));
        if (v < 8) { /* along the axes */
            options.camera.azimuth_deg = v < 4 ? 90 * v : 0;
            options.camera.elevation_deg = v < 4 ? 0 : 90 * (v % 2 ? 1 : -1);
        }
        options.camera.roll_deg = v % 3 ? 0 : 180 * random_signed(&r);
        options.camera.zoom = exp(1.5 * random_signed(&r));
        options.width = 60 + (int)random_below(&r, 80);
        options.height = 60 + (int)random_below(&r, 80);
        options.background[1] = 0.25;
        cvol_image *truth = ray(&volume, options);
        cvol_image *image = support_picture(context, renderer, &options);
        const double psnr = support_psnr(truth, image);
        if (psnr < 45)
            fail_msg("view %d, azimuth %g, elevation %g, zoom %g: %.1f dB", v,
                     options.camera.azimuth_deg, options.camera.elevation_deg, options.camera.zoom,
                     psnr);
        cvol_image_free(truth);
        cvol_image_free(image);
    }
    cvol_renderer_free(renderer);
    free(volume.data);
}

/* If rays are short, a mean is a small sum over a small length: the middle of the volume must not
 * leak into it. */
static void test_no_aliasing(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(48, 60, 50, CVOL_FLOAT32);
    for (size_t i = 0; i < 48 * 60 * 50; i++) {
        const double x = (double)(i % 48) - 23, y = (double)(i / 48 % 60) - 30;
        const double z = (double)(i / 48 / 60) - 26;
        ((float *)volume.data)[i] = (float)fmin(fmax(20 - sqrt(x * x + y * y + z * z), 0), 1) * 200;
    }
    cvol_renderer *renderer = renderer_of(&volume);
    for (int v = 0; v < 12; v++) {
        const cvol_render_options options = support_square(160, CVOL_MODE_XRAY, 31 * v,
                                                           80 - 14 * v);
        cvol_image *truth = ray(&volume, options);
        cvol_image *image = support_picture(context, renderer, &options);
        int most = 0;
        for (int i = 0; i < 160 * 160; i++)
            if (truth->rgba[4 * i] == 0 && image->rgba[4 * i] > most)
                most = image->rgba[4 * i];
        if (most > 8)
            fail_msg("view %d: %d of 255 where there is nothing", v, most);
        cvol_image_free(truth);
        cvol_image_free(image);
    }
    cvol_renderer_free(renderer);
    free(volume.data);
}

/* Objects that reach the volume's faces do not fade there and have no ghosts. */
static void test_faces(void **state)
{
    static const double angles[][2] = {{0, 0}, {90, 0}, {0, 90}, {33, 0}, {20, 15}, {200, -48}};
    (void)state;
    cvol_volume volume = support_volume(24, 30, 20, CVOL_FLOAT32);
    /* rising in the middle: the subtracted mean of the sides equals neither end */
    for (size_t i = 0; i < 24 * 30 * 20; i++)
        ((float *)volume.data)[i] = (float)fmin(fmax(((double)(i % 24) - 8) / 7, 0), 1) * 200;
    cvol_renderer *renderer = renderer_of(&volume);
    for (size_t v = 0; v < sizeof angles / sizeof *angles; v++)
        for (int zoomed = 0; zoomed < 2; zoomed++) {
            cvol_render_options options = support_square(96, CVOL_MODE_XRAY, angles[v][0],
                                                         angles[v][1]);
            options.camera.zoom = zoomed ? 2.5 : 1;
            cvol_image *truth = ray(&volume, options);
            cvol_image *image = support_picture(context, renderer, &options);
            int bad = 0;
            for (int i = 0; i < 96 * 96; i++)
                bad += abs(truth->rgba[4 * i] - image->rgba[4 * i]) > 20;
            if (bad > 96 || support_psnr(truth, image) < 36)
                fail_msg("azimuth %g, elevation %g, zoom %g: %d pixels are off, %.1f dB",
                         angles[v][0], angles[v][1], options.camera.zoom, bad,
                         support_psnr(truth, image));
            cvol_image_free(truth);
            cvol_image_free(image);
        }
    cvol_renderer_free(renderer);
    free(volume.data);
}

static void test_thin_volumes(void **state)
{
    static const size_t shapes[][3] = {{30, 20, 1}, {1, 30, 20}, {25, 1, 25}, {1, 1, 1}, {2, 2, 2}};
    (void)state;
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        cvol_volume volume = support_blobs(shapes[s][0], shapes[s][1], shapes[s][2]);
        cvol_render_options options = support_square(64, CVOL_MODE_XRAY, 25, 30);
        cvol_renderer *renderer = renderer_of(&volume);
        cvol_image *truth = ray(&volume, options);
        cvol_image *image = support_picture(context, renderer, &options);
        if (support_psnr(truth, image) < 20)
            fail_msg("shape %zu: %.1f dB", s, support_psnr(truth, image));
        cvol_image_free(truth);
        cvol_image_free(image);
        cvol_renderer_free(renderer);
        free(volume.data);
    }
}

/* From an array, with any transform: as from its samples. */
static void test_arrays(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(37, 30, 41);
    for (int block = 0; block <= 16; block += 16) {
        const cvol_keep keep = cvol_keep_terms(10, 4000);
        cvol_array *array;
        if (block)
            array = support_compress(context, &volume, block, 60);
        else
            assert_int_equal(cvol_array_compress(context, &array, volume.data, &volume.grid, 3,
                                                 CVOL_DFT, 0, &keep),
                             CVOL_OK);
        cvol_render_options options = support_square(80, CVOL_MODE_XRAY, 40, 20);
        cvol_renderer *renderer;
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_FOURIER,
                                              CVOL_SOURCE(.array = array, .rho = 0)),
                         CVOL_OK);
        cvol_image *truth = ray(&volume, options);
        cvol_image *image = support_picture(context, renderer, &options);
        assert_true(support_psnr(truth, image) > 45);
        cvol_image_free(truth);
        cvol_image_free(image);
        cvol_renderer_free(renderer);
        cvol_array_free(array);
    }
    free(volume.data);
}

/* Samples without a value do not count; means are over the others. */
static void test_mask(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(36, 36, 36);
    const size_t zero[3] = {0, 0, 0}, *dims = volume.grid.dims, count = 36 * 36 * 36;
    for (size_t i = 0; i < count; i++)
        if (hypot((double)(i % 36) - 12, (double)(i / 36 % 36) - 20) < 7)
            ((float *)volume.data)[i] = 1e35f;
    cvol_compress_options compress = cvol_compress_options_defaults();
    compress.target = CVOL_TARGET_PSNR;
    compress.target_value = 70;
    compress.has_fill = 1;
    compress.fill = 1e35f;
    cvol_array *array;
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &compress),
                     CVOL_OK);
    uint8_t *mask = malloc(count);
    assert_true(cvol_array_evaluate_mask(mask, array, zero, dims) > 0);
    for (int v = 0; v < 4; v++) {
        cvol_render_options options = support_square(96, CVOL_MODE_XRAY, 50 * v, 80 - 25 * v);
        cvol_renderer *by_rays, *renderer;
        options.step_voxels = 0.25;
        options.background[0] = 1;
        assert_int_equal(cvol_renderer_create(context, &by_rays, CVOL_ENGINE_RAY,
                                              CVOL_SOURCE(.volume = &volume, .mask = mask)),
                         CVOL_OK);
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_FOURIER,
                                              CVOL_SOURCE(.array = array, .rho = 0)),
                         CVOL_OK);
        cvol_image *truth = support_picture(context, by_rays, &options);
        cvol_image *image = support_picture(context, renderer, &options);
        if (support_psnr(truth, image) < 24)
            fail_msg("view %d: %.1f dB", v, support_psnr(truth, image));
        cvol_image_free(truth);
        cvol_image_free(image);
        cvol_renderer_free(renderer);
        cvol_renderer_free(by_rays);
    }
    free(mask);
    cvol_array_free(array);
    free(volume.data);
}

/* ---- projections ----------------------------------------------------------------------------- */

static void test_rotations(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(22, 30, 18);
    cvol_renderer *renderer = renderer_of(&volume);
    random_state r = {9};
    for (int v = 0; v < 6; v++) {
        cvol_render_options options = support_square(50, CVOL_MODE_XRAY, 180 * random_signed(&r),
                                                     90 * random_signed(&r));
        options.camera.roll_deg = 180 * random_signed(&r);
        float *values = project_camera(renderer, &options);
        cvol_image *image = support_picture(context, renderer, &options);
        cvol_volume_statistics stats;
        assert_int_equal(cvol_volume_compute_statistics(context, &stats, &volume), CVOL_OK);
        int off = 0;
        for (int i = 0; i < 50 * 50; i++) {
            const double level = ((double)values[i] - stats.min) / (stats.max - stats.min);
            off += fabs(255 * level - image->rgba[4 * i]) > 0.6;
        }
        assert_true(off <= 3); /* rounding may rotate the outline */
        cvol_image_free(image);
        free(values);
    }
    /* From above, x to the right and y up; and scaled quaternions are the same. */
    cvol_render_options options = support_square(50, CVOL_MODE_XRAY, 0, 90);
    const double ways[3][4] = {{1, 0, 0, 0}, {-2, 0, 0, 0}, {1e-200, 0, 0, 0}};
    float *values = project(renderer, &options, ways, 3);
    float *above = project_camera(renderer, &options);
    for (int i = 0; i < 3 * 2500; i++)
        assert_true(fabs((double)(values[i] - above[i % 2500])) < 1e-4);
    free(values);
    free(above);
    cvol_renderer_free(renderer);
    free(volume.data);
}

/* A bright sample at a known depth, with and without cueing; and integrals have the stated
 * value. */
static void test_depth_and_integrals(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(21, 21, 21, CVOL_FLOAT32);
    for (int a = 0; a < 3; a++)
        volume.grid.spacing[a] = 0.5;
    for (int k = 0; k < 4; k++) {
        const size_t y = 2 + 5 * (size_t)k;
        memset(volume.data, 0, 21 * 21 * 21 * sizeof(float));
        ((float *)volume.data)[support_index(&volume, 10, y, 10)] = 100;
        cvol_renderer *renderer = renderer_of(&volume);
        cvol_render_options options = support_square(80, CVOL_MODE_XRAY, 0, 0);
        options.fourier.integrals = 1;
        const double diagonal = 10 * sqrt(3), pixel = diagonal / 80;
        for (int strength = 0; strength <= 2; strength++) {
            options.fourier.depth_cue = strength * 0.5;
            float *values = project_camera(renderer, &options);
            double sum = 0;
            for (int i = 0; i < 80 * 80; i++)
                sum += (double)values[i] * pixel * pixel;
            free(values);
            /* the eye is at -y: depth grows with y */
            const double depth = 0.5 + ((double)y - 10) * 0.5 / diagonal;
            const double truth = 100 * 0.125 * (1 - strength * 0.5 * depth);
            if (fabs(sum - truth) > 0.02 * truth)
                fail_msg("depth %g, strength %g: %g, must be %g", depth, strength * 0.5, sum,
                         truth);
        }
        cvol_renderer_free(renderer);
    }
    free(volume.data);
}

static void test_threads(void **state)
{
    (void)state;
    cvol_volume volume = noise(30, 25, 28, 3);
    const double rotations[5][4] = {
        {1, 2, 3, 4}, {0, 1, 0, 0}, {-1, 0.5, 0.2, 0}, {1, 0, 0, 0}, {3, -2, 1, 5}};
    float *values[2];
    cvol_image *images[4];
    for (int k = 0; k < 2; k++) {
        cvol_context_set_threads(context, k ? 4 : 1);
        cvol_renderer *renderer = renderer_of(&volume);
        cvol_render_options options = support_square(70, CVOL_MODE_XRAY, 40, 20);
        options.fourier.depth_cue = 0.5;
        values[k] = project(renderer, &options, rotations, 5);
        images[k] = support_picture(context, renderer, &options);
        options.camera.zoom = 4;
        images[2 + k] = support_picture(context, renderer, &options);
        /* drawn alone it equals the picture drawn among others */
        float *alone = project(renderer, &options, rotations + 4, 1);
        options.camera.zoom = 1;
        free(alone);
        alone = project(renderer, &options, rotations + 4, 1);
        assert_memory_equal(alone, values[k] + 4 * 4900, 4900 * sizeof(float));
        free(alone);
        cvol_renderer_free(renderer);
    }
    cvol_context_set_threads(context, 0);
    assert_memory_equal(values[0], values[1], 5 * 4900 * sizeof(float));
    for (int k = 0; k < 4; k += 2)
        assert_int_equal(support_difference(images[k], images[k + 1]), 0);
    for (int k = 0; k < 4; k++)
        cvol_image_free(images[k]);
    free(values[0]);
    free(values[1]);
    free(volume.data);
}

/* Complete bricks give the same bits; smaller ones give worse pictures in less memory. */
static void test_kept_planes(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(37, 30, 41);
    random_state r = {21};
    for (size_t i = 0; i < 37 * 30 * 41; i++)
        ((float *)volume.data)[i] += (float)random_signed(&r);
    cvol_render_options options = support_square(90, CVOL_MODE_XRAY, 0, 0);
    const double rhos[] = {0, 100, 0.3, 0.1, 0.03};
    double rotations[7][4];
    for (int v = 0; v < 7; v++)
        for (int k = 0; k < 4; k++)
            rotations[v][k] = v < 3 ? k == v : random_signed(&r);
    float *truth = NULL;
    double before = 0;
    uint64_t bytes = 0;
    for (int k = 0; k < 5; k++) {
        cvol_renderer *renderer;
        cvol_fourier_report report;
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_FOURIER,
                                              CVOL_SOURCE(.volume = &volume, .rho = rhos[k])),
                         CVOL_OK);
        options.fourier.depth_cue = k < 2 ? 0.5 : 0;
        if (k == 2) {
            cvol_renderer *whole = renderer_of(&volume);
            free(truth);
            truth = project(whole, &options, (const double(*)[4])rotations, 7);
            cvol_renderer_free(whole);
        }
        float *values = project(renderer, &options, (const double(*)[4])rotations, 7);
        assert_int_equal(cvol_renderer_get_fourier_report(context, &report, renderer), CVOL_OK);
        double square = 0;
        for (int i = 0; i < 7 * 8100 && k; i++)
            square += pow((double)(values[i] - truth[i]), 2);
        if (k == 1)
            assert_true(square == 0);
        if (k >= 2) {
            assert_true(square > before && square < 7 * 8100 * 4);
            assert_true((double)report.places <= rhos[k] * 1.2 * 37 * 30 * 41 / 2 + 500);
            assert_true((double)report.places >= rhos[k] * 0.8 * 37 * 30 * 41 / 2);
            assert_true(report.bytes < bytes);
            before = square;
        }
        bytes = report.bytes;
        if (k)
            free(values);
        else
            truth = values;
        cvol_renderer_free(renderer);
    }
    free(truth);
    free(volume.data);
    cvol_renderer *none;
    volume = support_blobs(10, 10, 10);
    assert_int_equal(cvol_renderer_create(context, &none, CVOL_ENGINE_FOURIER,
                                          CVOL_SOURCE(.volume = &volume, .rho = -1)),
                     CVOL_ERROR_ARGUMENT);
    free(volume.data);
}

/* refusals */

static int always(void *user, const char *what, double fraction)
{
    (void)user;
    (void)what;
    (void)fraction;
    return 1;
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(10, 10, 10);
    cvol_renderer *renderer = renderer_of(&volume), *other;
    cvol_render_options options = support_square(20, CVOL_MODE_MIP, 0, 0);
    cvol_image *image;
    cvol_fourier_report report;
    float out[400];
    const double sound[1][4] = {{1, 0, 0, 0}}, zero[1][4] = {{0, 0, 0, 0}};
    const double none[1][4] = {{1, NAN, 0, 0}};
    assert_int_equal(cvol_image_create(context, &image, 20, 20), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "xray"));
    options.mode = CVOL_MODE_XRAY;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
    assert_int_equal(cvol_renderer_project(context, renderer, out, &options, zero, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_renderer_project(context, renderer, out, &options, none, 1),
                     CVOL_ERROR_ARGUMENT);
    const double cues[] = {-0.1, 1.1, NAN};
    for (int k = 0; k < 3; k++) {
        options.fourier.depth_cue = cues[k];
        assert_int_equal(cvol_renderer_render(context, renderer, image, &options),
                         CVOL_ERROR_ARGUMENT);
    }
    options.fourier.depth_cue = 0;
    assert_int_equal(cvol_renderer_get_fourier_report(context, &report, renderer), CVOL_OK);
    assert_true(report.padded[0] >= 15 && report.bytes > 4000);
    assert_int_equal(
        cvol_renderer_create(context, &other, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    assert_int_equal(cvol_renderer_project(context, other, out, &options, sound, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_renderer_get_fourier_report(context, &report, other),
                     CVOL_ERROR_ARGUMENT);
    cvol_renderer_free(other);
    cvol_context_set_progress(context, always, NULL);
    assert_int_equal(cvol_renderer_project(context, renderer, out, &options, sound, 1),
                     CVOL_ERROR_CANCELLED);
    assert_int_equal(cvol_renderer_create(context, &other, CVOL_ENGINE_FOURIER,
                                          CVOL_SOURCE(.volume = &volume, .rho = 0)),
                     CVOL_ERROR_CANCELLED);
    cvol_context_set_progress(context, NULL, NULL);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_spectrum),     cmocka_unit_test(test_half_floats),
        cmocka_unit_test(test_against_rays), cmocka_unit_test(test_no_aliasing),
        cmocka_unit_test(test_faces),        cmocka_unit_test(test_thin_volumes),
        cmocka_unit_test(test_arrays),       cmocka_unit_test(test_mask),
        cmocka_unit_test(test_rotations),    cmocka_unit_test(test_depth_and_integrals),
        cmocka_unit_test(test_threads),      cmocka_unit_test(test_kept_planes),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
