/* Bounds of light (light_bound.c): random gradients, and all extreme ones within an error of them.
 */
#include "test.h"

#include "random.h"
#include "render/ray/light_bound.h"

enum { CASES = 4000, SAMPLES = 27, MIDDLE = 13 };

/* The middle of 3 x 3 x 3 samples, and its neighbours along the axes. */
static const int places[] = {MIDDLE, 12, 14, 10, 16, 4, 22};
enum { PLACES = sizeof places / sizeof *places };

/* A random light; the direction of the eye in half of the cases. */
static cvol_ray_light make_light(random_state *r)
{
    cvol_ray_light light = {.rise = {0.5 + (random_signed(r) + 1) / 2, 1, 1.5},
                            .flat = random_below(r, 2) ? 0.5 * fabs(random_signed(r)) : 0};
    light.flats[0] = light.flats[1] = light.flat;
    cvol_shading *shading = &light.shading;
    double length[2] = {0, 0};
    const int from_eye = random_below(r, 2) == 0;
    for (int a = 0; a < 3; a++) {
        light.eye[a] = random_signed(r);
        shading->light[a] = from_eye ? light.eye[a] : random_signed(r);
        length[0] = hypot(length[0], light.eye[a]);
        length[1] = hypot(length[1], shading->light[a]);
    }
    for (int a = 0; a < 3; a++) {
        light.eye[a] /= length[0];
        shading->light[a] /= length[1];
    }
    shading->ambient = 0.1;
    shading->diffuse = 0.7;
    shading->specular = 0.2;
    shading->shininess = 1 + (int)random_below(r, 30);
    shading->gradient_opacity = 2;
    return light;
}

static void is_within(double value, double lo, double hi)
{
    assert_true(lo - 1e-9 <= value && value <= hi + 1e-9);
}

/* Checks all patterns of signs of an error. Returns how many factors are near their upper bound. */
static int check_patterns(const cvol_ray_lit_range *bound, const cvol_ray_light *light,
                          const cvol_ray_reader *reader, double moved[SAMPLES],
                          const double drawn[SAMPLES], double error)
{
    const double centre[3] = {1, 1, 1}, width = bound->hi.factor - bound->lo.factor;
    int near = 0;
    for (int pattern = 0; pattern < 1 << PLACES; pattern++) {
        for (int i = 0; i < PLACES; i++)
            moved[places[i]] = drawn[places[i]] + (pattern >> i & 1 ? error : -error);
        const cvol_ray_lit lit = cvol_ray_light_at(light, reader, centre, moved[MIDDLE]);
        is_within(lit.factor, bound->lo.factor, bound->hi.factor);
        is_within(lit.gloss, bound->lo.gloss, bound->hi.gloss);
        is_within(lit.density, bound->lo.density, bound->hi.density);
        near += width > 0 && bound->hi.factor - lit.factor < 0.05 * width;
    }
    return near;
}

static void test_light_lies_within(void **state)
{
    (void)state;
    random_state r = {20261126};
    int near = 0;
    for (int k = 0; k < CASES; k++) {
        double drawn[SAMPLES], moved[SAMPLES];
        uint8_t mask[SAMPLES];
        const double centre[3] = {1, 1, 1}, error = exp(2.5 * random_signed(&r) - 1.5);
        cvol_volume volume = {.grid = cvol_grid_make(3, 3, 3, CVOL_FLOAT64), .data = drawn};
        const cvol_ray_light light = make_light(&r);
        for (int i = 0; i < SAMPLES; i++) {
            drawn[i] = random_signed(&r);
            mask[i] = i != MIDDLE && random_below(&r, 100) < 30 ? 1 : 0;
        }
        cvol_ray_field field = cvol_ray_field_make(&volume, -100, 100);
        field.mask = k % 3 ? NULL : mask;
        const cvol_ray_reader reader = {&field, cvol_ray_line_of(CVOL_FLOAT64),
                                        cvol_ray_masked_of(CVOL_FLOAT64)};
        const cvol_ray_lit_range bound = cvol_ray_light_bound(&light, &reader, centre,
                                                              drawn[MIDDLE], error);
        memcpy(moved, drawn, sizeof moved);
        field.data = moved;
        near += check_patterns(&bound, &light, &reader, moved, drawn, error);
    }
    assert_true(near > CASES); /* the bounds are not much too wide */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_light_lies_within)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
