/* The memory of a picture: at most 24 bytes for each of its pixels and 16 MB, for all options (32
 * MB if samples are stored as floats and image-order rays cross the rows of a wide volume). Tiles
 * limit it and cover each pixel once. Bytes are counted as they are allocated, if the C library
 * lets a program do so. CVOL_TEST_VERBOSE=1 prints them. */
#include "test.h"

#include <stdatomic.h>

#include "array/core/array.h"
#include "base/cpu.h"
#include "render/sheet/frame_tile.h"
#include "render/sheet/warp/row.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

/* ---- counting -------------------------------------------------------------------------------- */

static atomic_long held, most_held;

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define COUNTED 1
#include <malloc.h>

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *memory, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void *memory);

static void *count(void *memory, int sign)
{
    const long bytes = memory ? sign * (long)malloc_usable_size(memory) : 0;
    const long now = atomic_fetch_add(&held, bytes) + bytes;
    long most = atomic_load(&most_held);
    while (now > most && !atomic_compare_exchange_weak(&most_held, &most, now))
        continue;
    return memory;
}

void *malloc(size_t bytes)
{
    return count(__libc_malloc(bytes), 1);
}

void *calloc(size_t items, size_t bytes)
{
    return count(__libc_calloc(items, bytes), 1);
}

void *realloc(void *memory, size_t bytes)
{
    count(memory, -1);
    void *moved = __libc_realloc(memory, bytes);
    count(moved ? moved : memory, 1);
    return moved;
}

void *aligned_alloc(size_t alignment, size_t bytes)
{
    return count(__libc_memalign(alignment, bytes), 1);
}

void free(void *memory)
{
    __libc_free(count(memory, -1));
}
#else
#define COUNTED 0
#endif

/* ---- pictures -------------------------------------------------------------------------------- */

/* int16 samples, which take half of the bytes. */
static int has_int16(void)
{
    return cvol_cpu_best() == CVOL_CPU_AVX512;
}

/* Draws the picture and returns the number of bytes above the limit. */
static double draw(const cvol_array *array, const cvol_render_options *options, const char *what)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    memset(image->rgba, 0, 4 * (size_t)image->width * (size_t)image->height);
    const long before = atomic_load(&held);
    atomic_store(&most_held, before);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), CVOL_OK);
    const double bytes = (double)(atomic_load(&most_held) - before);
    cvol_renderer_free(renderer);
    const int pixels = image->width * image->height;
    for (int i = 0; i < pixels; i++)
        if (image->rgba[4 * i + 3] != 255)
            fail_msg("%s: pixel %d was not drawn", what, i);
    cvol_image_free(image);
    const double beyond = bytes - 24.0 * pixels - (has_int16() ? 16e6 : 32e6);
    if (test_verbose() || beyond > 0)
        print_message("%s, lit %d, %d x %d: %.1f MB, %.1f more than it may\n", what,
                      options->shading.on, options->width, options->height, bytes / 1e6,
                      beyond / 1e6);
    return beyond;
}

static void expect_little(const cvol_array *array, cvol_render_options options, const char *what)
{
    for (int lit = 0; lit < 2; lit++) {
        options.shading.on = lit;
        assert_true(draw(array, &options, what) <= 0);
    }
}

/* Layers of many samples. */
static void test_wide_volumes(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(700, 600, 18);
    cvol_array *array = support_compress(context, &volume, 16, 50);
    cvol_render_options options = support_square(300, CVOL_MODE_COMPOSITE, 20, 70);
    expect_little(array, options, "wide");
    options.camera.fov_deg = 50;
    expect_little(array, options, "wide, in perspective");
    cvol_array_free(array);
    free(volume.data);
}

/* Intermediate images that are larger than the picture. */
static void test_large_pictures(void **state)
{
    (void)state;
    if (!COUNTED)
        skip();
    cvol_volume volume = support_blobs(24, 24, 24);
    cvol_array *array = support_compress(context, &volume, 16, 50);
    cvol_render_options options = support_square(900, CVOL_MODE_COMPOSITE, 45, 35);
    options.camera.zoom = 4;
    options.camera.roll_deg = 40;
    expect_little(array, options, "large");
    cvol_array_free(array);
    free(volume.data);
}

/* ---- tiles ----------------------------------------------------------------------------------- */

enum { WIDTH = 50, HEIGHT = 40 };

static void expect_each_once(const cvol_sheet_plan *plan, uint8_t times[HEIGHT][WIDTH])
{
    for (int count = 1; count <= 7; count += 3)
        for (int i = 0; i < count; i++) {
            const cvol_sheet_plan tile = cvol_frame_tile_make(plan, i, count);
            for (int y = 0; y < HEIGHT; y++) {
                int begin, end;
                cvol_warp_pixels(&begin, &end, &tile, y, WIDTH);
                for (int x = begin; x < end; x++)
                    times[y][x]++;
            }
        }
}

static void test_tiles_cover_each_pixel_once(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(40, 30, 20);
    cvol_array *array = support_compress(context, &volume, 16, 40);
    for (int k = 0; k < 12; k++) {
        uint8_t times[HEIGHT][WIDTH] = {{0}};
        cvol_render_options options = support_square(WIDTH, CVOL_MODE_COMPOSITE, 45 * k, 30 * k);
        options.height = HEIGHT;
        options.camera.roll_deg = 20 * (k % 5);
        options.camera.fov_deg = k % 2 ? 100 : 0;
        cvol_view view;
        assert_int_equal(cvol_view_make(context, &view, &volume.grid, &options), CVOL_OK);
        for (int along = 0; along < (k % 2 ? 6 : 1); along++) {
            cvol_sheet_plan plan;
            int empty = 0;
            assert_int_equal(
                k % 2 ? cvol_sheet_plan_make_along(context, &plan, &empty, array, 0, &view, along)
                      : cvol_sheet_plan_make(context, &plan, array, 0, &view),
                CVOL_OK);
            if (!empty)
                expect_each_once(&plan, times);
        }
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) /* in 1, 4 and 7 tiles; some pixels belong to no plan */
                if (times[y][x] != 3 && !(k % 2 && !times[y][x]))
                    fail_msg("view %d: pixel (%d, %d) is had %d times", k, x, y, times[y][x]);
    }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wide_volumes),
        cmocka_unit_test(test_large_pictures),
        cmocka_unit_test(test_tiles_cover_each_pixel_once),
    };
    if (!COUNTED)
        print_message("bytes are not counted here\n");
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
