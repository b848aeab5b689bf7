/* Parts of a volume (cvol_part): put together, wherever the plane between them lies, they are the
 * picture of the whole. In image order every pixel is a ray, so pictures can be put together pixel
 * by pixel; cvol-mpi does it with intermediate images (tests/cli/test_mpi.sh). CVOL_TEST_VERBOSE=1
 * prints the measurements. */
#include "test.h"

#include <math.h>

#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SIZE 64

/* Thin shells with a rough inside: intervals are divided, and have samples in their middle. Little
 * opacity, because intervals behind matter have fewer parts in the picture of the whole. */
static const cvol_transfer_point thin[] = {
    {30, 0.1, 0.2, 1, 0}, {45, 1, 0.6, 0.1, 0.06}, {60, 0.2, 1, 0.3, 0}, {110, 1, 1, 1, 0.04}};

static cvol_volume make_shells(void)
{
    random_state r = {3};
    cvol_volume volume = support_volume(40, 37, 44, CVOL_FLOAT32);
    for (size_t z = 0; z < 44; z++)
        for (size_t y = 0; y < 37; y++)
            for (size_t x = 0; x < 40; x++) {
                const double off = hypot(hypot((double)x - 20, (double)y - 18), (double)z - 22);
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(100 / (1 + exp((off - 14) / 2)) + 6 * random_signed(&r));
            }
    return volume;
}

/* The picture of the part before a plane of an axis, or behind it. */
static void draw_part(cvol_renderer *renderer, cvol_image *image, cvol_render_options options,
                      int axis, double at, int above)
{
    options.part.axes = 1 << axis;
    options.part.from[axis] = above ? at : -1;
    options.part.to[axis] = above ? 1000 : at;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
}

/* The largest difference from the whole of one part over the other. */
static double find_difference(const cvol_image *front, const cvol_image *back,
                              const cvol_image *whole)
{
    double most = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++)
        for (size_t c = 0; c < 4; c++) {
            const float *of = front->values + 4 * i;
            const double both = (double)(of[c] + (1 - of[3]) * back->values[4 * i + c]);
            most = fmax(most, fabs(both - (double)whole->values[4 * i + c]));
        }
    return most;
}

static void check(const cvol_array *array, cvol_render_options options, const double eye[3],
                  double allowed)
{
    cvol_renderer *renderer;
    cvol_image *whole, *parts[2];
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, thin, sizeof thin / sizeof *thin);
    assert_int_equal(cvol_image_create_float(context, &whole, SIZE, SIZE), CVOL_OK);
    for (int k = 0; k < 2; k++)
        assert_int_equal(cvol_image_create_float(context, &parts[k], SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, whole, &options), CVOL_OK);
    double worst = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 14; i++) {
            /* Also in the middle between two slices. */
            const double at = i < 12 ? 3.003 + 2.7 * i : 7.5 + 9 * (i - 12);
            for (int k = 0; k < 2; k++)
                draw_part(renderer, parts[k], options, axis, at, k);
            const int front = eye[axis] > 0;
            const double difference = find_difference(parts[front], parts[!front], whole);
            if (difference > allowed)
                print_message("axis %d at %g: %.4f\n", axis, at, difference);
            worst = fmax(worst, difference);
        }
    if (test_verbose())
        print_message("worst difference %.4f of %.4f\n", worst, allowed);
    assert_true(worst <= allowed);
    cvol_image_free(whole);
    for (int k = 0; k < 2; k++)
        cvol_image_free(parts[k]);
    cvol_renderer_free(renderer);
}

/* Azimuth, elevation, and the signs of the direction to the eye. */
static const struct {
    double azimuth, elevation, eye[3];
} views[] = {
    {33, 12, {1, -1, 1}}, {140, -50, {1, 1, -1}}, {250, 65, {-1, 1, 1}}, {0, 0, {1, -1, 1}}};

static void test_parts_are_the_whole(void **state)
{
    (void)state;
    cvol_volume volume = make_shells();
    cvol_array *array = support_compress(context, &volume, 16, 60);
    for (size_t v = 0; v < sizeof views / sizeof *views; v++)
        for (int lit = 0; lit < 2; lit++) {
            cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE,
                                                         views[v].azimuth, views[v].elevation);
            options.sheet.ray_order = CVOL_RAY_ORDER_IMAGE;
            options.shading.on = lit;
            check(array, options, views[v].eye, (lit ? 4 : 1.5) / 255);
        }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_parts_are_the_whole)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
