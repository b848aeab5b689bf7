/* The sheet engine against itself: threads, earlier frames, skipping, instruction sets and
 * cancelling do not change a picture.
 */
#include "test.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "array/core/array.h"
#include "base/cpu.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* ---- helpers ------------------------------------------------------------------------------- */

static cvol_array *compress_and_free(cvol_volume volume, int block)
{
    cvol_array *array = support_compress(context, &volume, block, 80);
    free(volume.data);
    return array;
}

static const cvol_transfer_point surface_points[] = {
    {30, .3, .2, .1, 0}, {40, .6, .4, .3, .5}, {60, 1, .9, .8, 1}};

/* Requests of all kinds: the first `REQUESTS` of an unlimited list. */
#define REQUESTS 16
static cvol_render_options request(int k)
{
    static const double zooms[] = {1, 4, 0.3, 2, 20};
    cvol_render_options options = support_square(60 + 37 * (k % 5), (cvol_mode)(1 + k % 3),
                                                 k % 4 ? 77 * k : 90 * k, k % 3 ? 31 * k - 90 : 0);
    options.height = k % 2 ? options.width : 150;
    options.camera.roll_deg = 13 * k;
    options.camera.zoom = zooms[k % 5];
    options.background[1] = 0.4;
    if (k >= 12) {
        options.camera.fov_deg = 25 * (k - 11);
        options.clip.planes = k % 2;
        options.clip.plane[0][0] = options.clip.plane[0][1] = 1;
    }
    return options;
}

static cvol_image *fresh(const cvol_array *array, const cvol_render_options *options)
{
    return support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS, options);
}

static cvol_renderer *make_renderer(const cvol_array *array)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    return renderer;
}

static void expect_same(const cvol_image *a, const cvol_image *b, const char *what, int k)
{
    int difference = support_difference(a, b);
    if (difference)
        fail_msg("%s %d: %d levels", what, k, difference);
}

/* ---- threads, frames ----------------------------------------------------------------------- */

static void test_same_for_any_threads(void **state)
{
    (void)state;
    static const int counts[] = {2, 3, 7};
    cvol_array *array = compress_and_free(support_blobs(70, 64, 81), 16);
    for (int k = 0; k < REQUESTS; k++) {
        cvol_render_options options = request(k);
        options.height = 400; /* bands, for any number of threads */
        cvol_context_set_threads(context, 1);
        cvol_image *one = fresh(array, &options);
        for (int i = 0; i < 3; i++) {
            cvol_context_set_threads(context, counts[i]);
            cvol_image *many = fresh(array, &options);
            expect_same(one, many, "request", k);
            cvol_image_free(many);
        }
        cvol_image_free(one);
    }
    cvol_array_free(array);
}

static void test_earlier_frames_have_no_effect(void **state)
{
    (void)state;
    cvol_array *array = compress_and_free(support_blobs(37, 45, 41), 16);
    cvol_renderer *renderer = make_renderer(array);
    cvol_image *first[REQUESTS];
    for (int k = 0; k < REQUESTS; k++) {
        cvol_render_options options = request(k);
        first[k] = fresh(array, &options);
    }
    for (int round = 0; round < 3 * REQUESTS; round++) {
        int k = round * 7 % REQUESTS; /* each one after different ones */
        k = round >= 2 * REQUESTS ? REQUESTS - 1 - k : k;
        cvol_render_options options = request(k);
        cvol_context_set_threads(context, 1 + round % 3);
        cvol_image *again = support_picture(context, renderer, &options);
        expect_same(first[k], again, "request", k);
        cvol_image_free(again);
    }
    for (int k = 0; k < REQUESTS; k++)
        cvol_image_free(first[k]);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
}

static void test_transfer_functions_replace_each_other(void **state)
{
    (void)state;
    cvol_array *array = compress_and_free(support_blobs(37, 45, 41), 16);
    cvol_renderer *renderer = make_renderer(array);
    cvol_render_options options = support_square(90, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_image *soft = support_picture(context, renderer, &options);
    support_set_transfer(context, renderer, surface_points, 3);
    cvol_image *hard = support_picture(context, renderer, &options);
    cvol_image *expected = support_sheet(context, array, surface_points, 3, &options);
    expect_same(expected, hard, "second function", 0);
    assert_true(support_difference(soft, hard) > 50);
    cvol_image_free(expected);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    expected = support_picture(context, renderer, &options);
    expect_same(expected, soft, "first function again", 0);
    cvol_image_free(expected);
    cvol_image_free(soft);
    cvol_image_free(hard);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
}

/* ---- stopping ------------------------------------------------------------------------------ */

typedef struct watch {
    int calls, stop_at, between;
    double last;
} watch;

static int on_progress(void *user, const char *what, double fraction)
{
    watch *w = user;
    assert_true(strlen(what) > 0 && fraction >= w->last && fraction <= 1);
    w->between |= fraction > 0.3 && fraction < 0.9;
    w->last = fraction;
    return ++w->calls == w->stop_at;
}

static void test_progress_and_cancel(void **state)
{
    (void)state;
    cvol_array *array = compress_and_free(support_blobs(70, 64, 81), 16);
    cvol_render_options options = support_square(300, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_image *expected = fresh(array, &options), *image;
    cvol_renderer *renderer = make_renderer(array);
    assert_int_equal(cvol_image_create(context, &image, 300, 300), CVOL_OK);
    for (int threads = 1; threads <= 3; threads++) {
        watch w = {0};
        cvol_context_set_threads(context, threads);
        cvol_context_set_progress(context, on_progress, &w);
        assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
        assert_true(w.last == 1);
        if (threads == 1) /* more than a begin and an end */
            assert_true(w.calls > 4 && w.between);
        expect_same(expected, image, "watched", threads);
        for (int stop = 1; stop <= w.calls && stop <= 6; stop++) {
            watch stopping = {.stop_at = stop};
            cvol_context_set_progress(context, on_progress, &stopping);
            int code = cvol_renderer_render(context, renderer, image, &options);
            /* The share of each thread is not known beforehand. */
            assert_true(code == (stopping.calls >= stop ? CVOL_ERROR_CANCELLED : CVOL_OK));
            if (threads == 1)
                assert_int_equal(stopping.calls, stop);
            cvol_context_set_progress(context, NULL, NULL);
            assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
            expect_same(expected, image, "after a stop at", stop);
        }
    }
    cvol_image_free(image);
    cvol_image_free(expected);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
}

/* ---- skipping ------------------------------------------------------------------------------ */

/* Bright planes, one sample thick, on both sides of the faces of blocks of 16. */
static double subbands(size_t x, size_t y, size_t z)
{
    return x % 16 == 0 || x % 16 == 15 || y % 16 == 0 || y % 16 == 15 || z % 16 == 15 ? 100 : 0;
}

/* One bright plane at the face of dark blocks. */
static double shell_x(size_t x, size_t y, size_t z)
{
    (void)y, (void)z;
    return x == 16 ? 100 : 0;
}

static double shell_y(size_t x, size_t y, size_t z)
{
    (void)x, (void)z;
    return y == 31 ? 100 : 0;
}

static double shell_z(size_t x, size_t y, size_t z)
{
    (void)x, (void)y;
    return z == 16 ? 100 : 0;
}

/* Half of the samples are 0, half 100: a function that shows 40..60 makes both transparent, and the
 * values between them visible. */
static double midpoints_x(size_t x, size_t y, size_t z)
{
    (void)y, (void)z;
    return x < 16 ? 0 : 100;
}

static double midpoints_y(size_t x, size_t y, size_t z)
{
    (void)x, (void)z;
    return y < 16 ? 0 : 100;
}

static double midpoints_z(size_t x, size_t y, size_t z)
{
    (void)x, (void)y;
    return z < 16 ? 0 : 100;
}

/* Every block has one constant value; some lie in the visible band. */
static double patches(size_t x, size_t y, size_t z)
{
    random_state r = {x / 16 + 100 * (y / 16) + 10000 * (z / 16)};
    return random_below(&r, 6) * 20.0;
}

/* A bright corner of eight blocks. */
static double corner(size_t x, size_t y, size_t z)
{
    return x == 16 && y == 16 && z == 15 ? 100 : 0;
}

typedef double sampler(size_t x, size_t y, size_t z);

/* As close to the samples as single precision allows. Coding errors are unknown here (where all
 * samples are 0 or 100, decoding may give 110 and clamp it), and would move a band's position
 * between 0 and 100. */
static cvol_array *compress_sampler(sampler *sample, int lapped)
{
    cvol_volume volume = support_volume(45, 40, 50, CVOL_FLOAT32);
    cvol_array *array;
    for (size_t z = 0; z < 50; z++)
        for (size_t y = 0; y < 40; y++)
            for (size_t x = 0; x < 45; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)sample(x, y, z);
    if (lapped) {
        array = support_lapped(context, volume.data, volume.grid.dims, 0, 0.01, 1, 7);
    } else {
        const cvol_keep keep = cvol_keep_psnr(100);
        assert_int_equal(
            cvol_array_compress(context, &array, volume.data, &volume.grid, 3, CVOL_DCT, 16, &keep),
            CVOL_OK);
    }
    assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
    free(volume.data);
    return array;
}

/* Opens the ranges of all blocks, so that no function makes them transparent. */
static void forget_ranges(cvol_array *array)
{
    for (size_t b = 0; b < array->block_count; b++) {
        array->block_table[b].range[0] = 0;
        array->block_table[b].range[1] = 255;
    }
}

static void test_skipping_is_safe(void **state)
{
    (void)state;
    static sampler *const samplers[] = {subbands,    shell_x,     shell_y, shell_z, midpoints_x,
                                        midpoints_y, midpoints_z, patches, corner};
    /* If a ray leaves a skipped block, the last value in it is known only by the block's range.
     * Such a step may be visible if nothing else is. */
    static const double floors_db[] = {99, 52, 52, 52, 57, 50, 45, 79, 65};
    static const cvol_transfer_point band[] = {
        {39, 1, 1, 1, 0}, {45, 1, .5, .2, .5}, {55, .5, .5, 1, .5}, {61, 1, 1, 1, 0}};
    static const cvol_transfer_point high[] = {{20, 1, 1, 1, 0}, {100, 1, .5, .2, .8}};
    static const cvol_transfer_point *const functions[] = {band, high};
    static const size_t counts[] = {4, 2};
    static const double zooms[] = {1, 3, 0.4};
    static const double views[][2] = {{0, 0},  {90, 0},    {180, 0},  {270, 0},
                                      {0, 90}, {0, -90},   {30, 20},  {45, 35.26},
                                      {45, 0}, {210, -50}, {120, -70}};
    const size_t count = sizeof samplers / sizeof *samplers;
    const size_t views_apart = 2 * (size_t)support_stride(); /* each function has its own views */
    for (size_t s = 0; s < 2 * count; s++) {
        const int lapped = s >= count;
        const double floor_db = floors_db[s % count];
        const int one_level = s % count < 3; /* at most, of 255 */
        cvol_array *array = compress_sampler(samplers[s % count], lapped);
        cvol_array *open = compress_sampler(samplers[s % count], lapped);
        forget_ranges(open);
        for (size_t f = 0; f < 2; f++)
            for (size_t v = (s + f) % views_apart; v < sizeof views / sizeof *views;
                 v += views_apart)
                for (size_t z = 0; z < 6; z++) {
                    const int image_order = z >= 3; /* which test more windows together */
                    cvol_render_options options = support_square(
                        z % 3 == 2 ? 30 : 80, CVOL_MODE_COMPOSITE, views[v][0], views[v][1]);
                    options.camera.zoom = zooms[z % 3];
                    options.sheet.ray_order = image_order ? CVOL_RAY_ORDER_IMAGE
                                                          : CVOL_RAY_ORDER_OBJECT;
                    cvol_image *skipped = support_sheet(context, array, functions[f], counts[f],
                                                        &options);
                    cvol_image *whole = support_sheet(context, open, functions[f], counts[f],
                                                      &options);
                    double psnr = support_psnr(skipped, whole);
                    if (test_verbose() || psnr < floor_db)
                        print_message("%s, %s, sampler %zu function %zu view %zu zoom %g: %.2f dB, "
                                      "largest %d\n",
                                      lapped ? "lapped" : "plain",
                                      image_order ? "pixels" : "lattice", s % count, f, v,
                                      zooms[z % 3], psnr, support_difference(skipped, whole));
                    assert_true(psnr >= floor_db);
                    assert_true(!one_level ||
                                support_difference(skipped, whole) <= (image_order ? 6 : 1));
                    cvol_image_free(skipped);
                    cvol_image_free(whole);
                }
        cvol_array_free(array);
        cvol_array_free(open);
    }
}

/* In ordinary volumes, skipping is invisible. */
static void test_skipping_is_invisible(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(70, 64, 81);
    cvol_array *array = support_compress(context, &volume, 16, 50);
    cvol_array *open = support_compress(context, &volume, 16, 50);
    forget_ranges(open);
    for (int azimuth = 0; azimuth < 360; azimuth += 45 * support_stride())
        for (int elevation = -90; elevation <= 90; elevation += 30) {
            cvol_render_options options = support_square(120, CVOL_MODE_COMPOSITE, azimuth,
                                                         elevation);
            options.shading.on = elevation % 60 != 0;
            cvol_image *skipped = support_sheet(context, array, surface_points, 3, &options);
            cvol_image *whole = support_sheet(context, open, surface_points, 3, &options);
            double psnr = support_psnr(skipped, whole);
            if (test_verbose() || psnr < 60)
                print_message("smooth %d %d: %.2f dB, largest %d\n", azimuth, elevation, psnr,
                              support_difference(skipped, whole));
            assert_true(psnr >= 60);
            cvol_image_free(skipped);
            cvol_image_free(whole);
        }
    free(volume.data);
    cvol_array_free(array);
    cvol_array_free(open);
}

/* Visible values between transparent blocks appear from every direction. */
static void test_bands_between_blocks_are_seen(void **state)
{
    (void)state;
    static sampler *const samplers[] = {midpoints_x, midpoints_y, midpoints_z};
    static const cvol_transfer_point band[] = {
        {20, 1, 1, 1, 0}, {25, 1, 1, 1, .9}, {75, 1, 1, 1, .9}, {80, 1, 1, 1, 0}};
    /* Along the axis, and from a distance: seen from the side, the band is thinner than a pixel. */
    static const double views[][2][2] = {
        {{90, 0}, {300, -40}}, {{0, 0}, {300, -40}}, {{0, -90}, {300, -40}}};
    for (size_t s = 0; s < 3; s++) {
        cvol_array *array = compress_sampler(samplers[s], 0);
        for (size_t v = 0; v < 2; v++) {
            cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, views[s][v][0],
                                                         views[s][v][1]);
            cvol_image *image = support_sheet(context, array, band, 4, &options);
            int brightest = 0;
            for (int i = 0; i < 80 * 80; i++)
                brightest = image->rgba[4 * i] > brightest ? image->rgba[4 * i] : brightest;
            if (brightest < 50)
                print_message("halves %zu from view %zu: %d\n", s, v, brightest);
            assert_true(brightest >= 50);
            cvol_image_free(image);
        }
        cvol_array_free(array);
    }
}

/* ---- instruction sets ------------------------------------------------------------------------ */

#define SET_BYTES (REQUESTS * 300 * 300 * 4)

/* In a separate process, since the set is chosen once: all requests' pictures into `out`. */
static void draw_with_set(uint8_t *out, const char *set)
{
    setenv("CVOL_CPU", set, 1);
    cvol_context *own = cvol_context_create();
    if (!own || strcmp(cvol_cpu_name(cvol_cpu_best()), set))
        _exit(own ? 2 : 1);
    cvol_context_set_threads(own, 1);
    cvol_volume volume = support_blobs(37, 45, 41);
    cvol_array *array = support_compress(own, &volume, 16, 80);
    for (int k = 0; k < REQUESTS; k++) {
        cvol_render_options options = request(k);
        cvol_image *image = support_sheet(own, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        size_t bytes = 4 * (size_t)image->width * (size_t)image->height;
        memcpy(out, image->rgba, bytes);
        out += bytes;
        cvol_image_free(image);
    }
    _exit(0);
}

/* 0 if the processor lacks the set. */
static int pictures_of_set(uint8_t *out, const char *set)
{
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        draw_with_set(out, set);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_true(WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == 2);
    return WEXITSTATUS(status) == 0;
}

static void test_instruction_sets_agree(void **state)
{
    (void)state;
    uint8_t *shared = mmap(NULL, 2 * SET_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                           -1, 0);
    assert_true(shared != MAP_FAILED);
    assert_true(pictures_of_set(shared, "base"));
    static const char *const sets[] = {"avx2", "avx512"};
    for (int s = 0; s < 2; s++) {
        if (!pictures_of_set(shared + SET_BYTES, sets[s])) {
            print_message("skipped: no %s\n", sets[s]);
            continue;
        }
        int largest = 0, count = 0;
        for (int i = 0; i < SET_BYTES; i++) {
            int difference = abs(shared[i] - shared[SET_BYTES + i]);
            largest = difference > largest ? difference : largest;
            count += difference > 0;
        }
        if (largest > 1)
            print_message("%s: %d levels, %d bytes differ\n", sets[s], largest, count);
        assert_true(largest <= 1);
    }
    munmap(shared, 2 * SET_BYTES);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_instruction_sets_agree), /* first: its children need to start without threads */
        TEST(test_same_for_any_threads),
        TEST(test_earlier_frames_have_no_effect),
        TEST(test_transfer_functions_replace_each_other),
        TEST(test_progress_and_cancel),
        TEST(test_skipping_is_safe),
        TEST(test_skipping_is_invisible),
        TEST(test_bands_between_blocks_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
