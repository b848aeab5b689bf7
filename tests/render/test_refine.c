/* Pictures within a time budget: the drawn levels, each equal to the level drawn alone. Budgets are
 * so large or so small that no machine's speed matters. */
#include "test.h"

#include "support_render.h"

static const double ages = 1e9, no_time = 1e-6;

/* The volume and options of all tests. */
typedef struct stage {
    cvol_context *context;
    cvol_array *array;
    cvol_renderer *renderer;
    cvol_image *image;
    cvol_render_options options;
} stage;

static int setup(void **state)
{
    stage *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->context = cvol_context_create();
    cvol_volume volume = support_blobs(67, 50, 59);
    s->array = support_compress(s->context, &volume, 16, 60);
    s->options = support_square(70, CVOL_MODE_COMPOSITE, 30, 20);
    free(volume.data);
    assert_int_equal(cvol_image_create(s->context, &s->image, 70, 70), CVOL_OK);
    assert_int_equal(cvol_renderer_create(s->context, &s->renderer, CVOL_ENGINE_SHEET,
                                          CVOL_SOURCE(.array = s->array)),
                     CVOL_OK);
    support_set_transfer(s->context, s->renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    *state = s;
    return 0;
}

static int teardown(void **state)
{
    stage *s = *state;
    cvol_renderer_free(s->renderer);
    cvol_image_free(s->image);
    cvol_array_free(s->array);
    cvol_context_free(s->context);
    free(s);
    return 0;
}

/* The image is the picture of this level. */
static void expect_level(stage *s, int level)
{
    cvol_render_options options = s->options;
    options.level = level;
    cvol_image *alone = support_sheet(s->context, s->array, support_blob_points,
                                      SUPPORT_BLOB_POINTS, &options);
    assert_int_equal(support_difference(alone, s->image), 0);
    cvol_image_free(alone);
}

typedef struct gallery {
    stage *stage;
    int levels[8], count, stop_at;
} gallery;

static int on_picture(void *user, const cvol_image *image, int level)
{
    gallery *g = user;
    assert_ptr_equal(image, g->stage->image);
    expect_level(g->stage, level);
    g->levels[g->count++] = level;
    return g->count == g->stop_at;
}

static int refine(stage *s, double budget, gallery *g, cvol_refine_report *report)
{
    return cvol_renderer_refine(s->context, s->renderer, s->image, &s->options, budget,
                                g ? on_picture : NULL, g, report);
}

static void test_from_coarse_to_fine(void **state)
{
    stage *s = *state;
    for (int finest = 0; finest < 4; finest++) {
        gallery g = {.stage = s};
        cvol_refine_report report;
        s->options.level = finest;
        assert_int_equal(refine(s, ages, &g, &report), CVOL_OK);
        assert_int_equal(g.count, 4 - finest);
        for (int i = 0; i < g.count; i++)
            assert_int_equal(g.levels[i], 3 - i);
        assert_int_equal(report.level, finest);
        assert_true(report.picture_ms > 0 && report.total_ms >= report.picture_ms);
        expect_level(s, finest);
    }
}

static void test_zero_budget_draws_one_level(void **state)
{
    stage *s = *state;
    for (int again = 0; again < 2; again++) {
        cvol_refine_report report;
        assert_int_equal(refine(s, no_time, NULL, &report), CVOL_OK);
        assert_int_equal(report.level, 3);
        expect_level(s, 3);
    }
}

static void test_level_times_are_remembered(void **state)
{
    stage *s = *state;
    cvol_refine_report first, second;
    assert_int_equal(refine(s, ages, NULL, &first), CVOL_OK);
    assert_int_equal(refine(s, ages, NULL, &second), CVOL_OK);
    assert_true(first.level == 0 && second.level == 0);
    expect_level(s, 0);
    /* Another kind of picture has its own times. */
    gallery g = {.stage = s};
    s->options.camera.azimuth_deg = 200;
    assert_int_equal(refine(s, ages, &g, NULL), CVOL_OK);
    assert_int_equal(g.count, 4);
}

static void test_caller_can_stop(void **state)
{
    stage *s = *state;
    gallery g = {.stage = s, .stop_at = 2};
    cvol_refine_report report;
    assert_int_equal(refine(s, ages, &g, &report), CVOL_OK);
    assert_int_equal(g.count, 2);
    assert_int_equal(report.level, 2);
    expect_level(s, 2);
}

static int refuse(void *user, const char *what, double fraction)
{
    (void)user, (void)what, (void)fraction;
    return 1;
}

static void test_progress_cancels(void **state)
{
    stage *s = *state;
    cvol_context_set_progress(s->context, refuse, NULL);
    assert_int_equal(refine(s, ages, NULL, NULL), CVOL_ERROR_CANCELLED);
    assert_int_equal(refine(s, no_time, NULL, NULL), CVOL_ERROR_CANCELLED);
    cvol_context_set_progress(s->context, NULL, NULL);
    assert_int_equal(refine(s, ages, NULL, NULL), CVOL_OK);
}

static void test_refusals(void **state)
{
    stage *s = *state;
    cvol_volume volume = support_blobs(10, 10, 10);
    cvol_renderer *ray;
    assert_int_equal(refine(s, 0, NULL, NULL), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(s->context), "must be above 0"));
    s->options.level = 4;
    assert_int_equal(refine(s, ages, NULL, NULL), CVOL_ERROR_ARGUMENT);
    s->options.level = 0;
    assert_int_equal(
        cvol_renderer_create(s->context, &ray, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    assert_int_equal(
        cvol_renderer_refine(s->context, ray, s->image, &s->options, ages, NULL, NULL, NULL),
        CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(s->context), "only engine sheet"));
    cvol_renderer_free(ray);
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_from_coarse_to_fine, setup, teardown),
        cmocka_unit_test_setup_teardown(test_zero_budget_draws_one_level, setup, teardown),
        cmocka_unit_test_setup_teardown(test_level_times_are_remembered, setup, teardown),
        cmocka_unit_test_setup_teardown(test_caller_can_stop, setup, teardown),
        cmocka_unit_test_setup_teardown(test_progress_cancels, setup, teardown),
        cmocka_unit_test_setup_teardown(test_refusals, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
