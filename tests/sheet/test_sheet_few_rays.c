/* Fewer rays than pixels (oversample below 1) at every level, in both projections, in all modes and
 * with all footprints: pictures stay close to those of oversample 1, and plans keep the invariants
 * of the line kernels. Also run with every instruction set, see CMakeLists.txt. CVOL_TEST_VERBOSE=1
 * prints the measurements. */
#include "test.h"

#include "array/core/array.h"
#include "random.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/plan.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* ---- plans ----------------------------------------------------------------------------------- */

/* Pixels lie at most one point apart on every slice that a ray can meet. */
static void expect_close(const cvol_sheet_plan *plan, const char *what)
{
    const size_t beyond = plan->beyond ? 1 : 0;
    for (size_t s = 0; s < plan->sheet_count + 2 * beyond; s++) {
        const double z = plan->first_sheet + ((double)s - (double)beyond) * plan->pitch_sheet;
        if (z < plan->lo[2] - plan->pitch_sheet || z > plan->hi[2] + plan->pitch_sheet)
            continue;
        const double scale = cvol_sheet_cross(plan, z).scale;
        const double lane = scale * plan->du / plan->pitch_lane,
                     row = scale * plan->dv / plan->pitch_row;
        if (lane > 1 + 1e-12 || row > 1 + 1e-12)
            fail_msg("%s, sheet %zu: pixels lie %g x %g points apart", what, s, lane, row);
    }
}

#define SEED 17

static double random_unit(random_state *r)
{
    return 0.5 + 0.5 * random_signed(r);
}

static cvol_render_options random_request(random_state *r, const size_t dims[3])
{
    cvol_render_options options = support_square(20 + (int)random_below(r, 200),
                                                 CVOL_MODE_COMPOSITE, 360 * random_unit(r),
                                                 180 * random_unit(r) - 90);
    options.camera.fov_deg = random_unit(r) < 0.6 ? 5 + 100 * random_unit(r) : 0;
    options.camera.zoom = exp(4 * random_unit(r) - 2);
    options.oversample = 0.25 + 1.5 * random_unit(r) * random_unit(r);
    options.step_voxels = random_unit(r) < 0.3 ? 4 : 0;
    const int is_clipped = random_unit(r) < 0.3;
    for (int k = 0; k < 3; k++) {
        options.clip.axes |= is_clipped && dims[k] > 1 ? 1 << k : 0;
        options.clip.from[k] = 0.4 * random_unit(r) * (double)(dims[k] - 1);
        options.clip.to[k] = (1 - 0.4 * random_unit(r)) * (double)(dims[k] - 1);
    }
    return options;
}

static void test_plans(void **state)
{
    (void)state;
    random_state random = {SEED};
    print_message("seed %d\n", SEED);
    for (int i = 0; i < 2000; i++) {
        size_t dims[3];
        for (int k = 0; k < 3; k++)
            dims[k] = 1 + random_below(&random, i % 5 ? 90 : 3);
        cvol_array array = {.block = 8 << random_below(&random, 3)};
        cvol_view view;
        array.grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_UINT8);
        for (int k = 0; k < 3; k++) {
            array.grid.spacing[k] = 0.5 + random_unit(&random);
            array.blocks[k] = (dims[k] + (size_t)array.block - 1) / (size_t)array.block;
        }
        const int level = (int)random_below(&random, 4);
        const cvol_render_options options = random_request(&random, dims);
        if (cvol_view_make(context, &view, &array.grid, &options))
            fail_msg("request %d: %s", i, cvol_context_message(context));
        char what[32];
        snprintf(what, sizeof what, "request %d", i);
        cvol_sheet_plan plan;
        for (int along = 0; along < (view.perspective ? 6 : 1); along++) {
            int empty = 0;
            assert_int_equal(view.perspective
                                 ? cvol_sheet_plan_make_along(context, &plan, &empty, &array, level,
                                                              &view, along)
                                 : cvol_sheet_plan_make(context, &plan, &array, level, &view),
                             CVOL_OK);
            if (!empty)
                expect_close(&plan, what);
        }
    }
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* Measured with every instruction set, minus about 1.5 dB. */
#define MIN_DB 34

static cvol_image *draw(const cvol_array *array, cvol_render_options options, double rays)
{
    options.oversample = rays;
    options.sheet.ray_order = CVOL_RAY_ORDER_OBJECT;
    return support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS, &options);
}

/* The PSNR of a picture with fewer rays, compared with one ray per pixel. */
static void expect_alike(const cvol_array *array, const char *what, int level, int perspective,
                         const cvol_render_options *options, double least_db)
{
    static const double rays[] = {0.25, 0.5, 0.8};
    cvol_image *one = draw(array, *options, 1);
    for (int i = 0; i < 3; i++) {
        cvol_image *fewer = draw(array, *options, rays[i]);
        const double db = support_psnr(one, fewer);
        const int good = db >= least_db;
        if (test_verbose() || !good)
            print_message("%s, level %d, %s, %g rays, mode %d, lit %d, footprint %d: %.2f dB\n",
                          what, level, perspective ? "perspective" : "parallel", rays[i],
                          (int)options->mode, options->shading.on, (int)options->sheet.footprint,
                          db);
        assert_true(good);
        cvol_image_free(fewer);
    }
    cvol_image_free(one);
}

/* The level, the projection, and modes and footprints of one array. */
static void expect_pictures(const cvol_array *array, const char *what, double least_db)
{
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY,
                                      CVOL_MODE_MIP,       CVOL_MODE_MIN,       CVOL_MODE_ISO};
    for (int level = 0; level < 3; level++)
        for (int perspective = 0; perspective < 2; perspective++)
            for (int m = 0; m < 6; m++) {
                const int turn = m + level + 3 * perspective;
                cvol_render_options options = support_square(60, modes[m], 70 * turn + 10,
                                                             40 * (turn % 3) - 40);
                options.level = level;
                options.camera.fov_deg = perspective ? 45 : 0;
                options.shading.on = m == 1;
                options.surface.value = 30;
                for (int c = 0; c < 3; c++)
                    options.surface.colour[c] = 0.8;
                options.sheet.footprint = (cvol_sheet_footprint)(turn % 4);
                expect_alike(array, what, level, perspective, &options, least_db);
            }
}

static void test_pictures(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(67, 50, 59);
    cvol_context_set_threads(context, 1); /* many small pictures */
    cvol_array *array = support_compress(context, &volume, 16, 60);
    expect_pictures(array, "blocks", MIN_DB);
    cvol_array_free(array);
    array = support_lapped(context, volume.data, volume.grid.dims, 3, 0.02, 1, 5);
    expect_pictures(array, "lapped", MIN_DB);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_plans), TEST(test_pictures)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
