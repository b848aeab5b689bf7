/* The transform engine against the splat engine, its orders, schedules and transforms against each
 * other, and its bound against the measured error of truncation. */
#include "test.h"

#include "random.h"
#include "render/spectral/frame.h"
#include "support.h"
#include "support_render.h"

static cvol_context *context;
static cvol_volume blobs;

static int setup(void **state)
{
    (void)state;
    context = cvol_context_create();
    blobs = support_blobs(30, 26, 22);
    blobs.grid.spacing[1] = 1.25;
    return context ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    free(blobs.data);
    cvol_context_free(context);
    return 0;
}

static cvol_image *picture(int by_transforms, const cvol_render_options *options)
{
    cvol_renderer *renderer;
    const cvol_engine engine = by_transforms ? CVOL_ENGINE_TRANSFORM : CVOL_ENGINE_SPLAT;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, engine, CVOL_SOURCE(.volume = &blobs)), CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    cvol_image *image = support_picture(context, renderer, options);
    cvol_renderer_free(renderer);
    return image;
}

static double against(const cvol_image *truth, const cvol_render_options *options)
{
    cvol_image *image = picture(1, options);
    const double psnr = support_psnr(truth, image);
    cvol_image_free(image);
    return psnr;
}

/* ---- with all terms: splatting --------------------------------------------------------------- */

typedef struct kind {
    cvol_transform transform;
    int tile;
} kind;
static const kind kinds[] = {{CVOL_DCT, 8}, {CVOL_DCT, 16}, {CVOL_DCT, 32},
                             {CVOL_DCT, 0}, {CVOL_DHT, 0},  {CVOL_DFT, 0}};
enum { KINDS = sizeof kinds / sizeof *kinds };

static void set_kind(cvol_render_options *options, int k)
{
    options->transform.transform = kinds[k].transform;
    options->transform.tile = kinds[k].tile;
}

static void test_all_terms_are_splats(void **state)
{
    /* All three axes, both ends, sheared. */
    static const double views[][2] = {{0, 0},   {90, 0},  {180, 0},   {270, 0},  {0, 90},
                                      {0, -90}, {30, 20}, {205, -35}, {118, 15}, {60, 70}};
    (void)state;
    for (size_t v = 0; v < sizeof views / sizeof *views; v++) {
        cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, views[v][0],
                                                     views[v][1]);
        options.transform.rho = 1;
        options.splat.plane = CVOL_FOOTPRINT_IN_SLICES;
        options.splat.sigma = 1;
        options.splat.size = 7;
        for (int order = CVOL_ORDER_FRONT; order <= CVOL_ORDER_BACK; order++) {
            options.splat.order = (cvol_order)order;
            cvol_image *truth = picture(0, &options);
            /* Under sanitizers: both orders and schedules of every kind. */
            for (int k = ((int)v / 2 + CVOL_ORDER_BACK - order) % SUPPORT_STRIDE; k < KINDS;
                 k += SUPPORT_STRIDE)
                for (int schedule = CVOL_SCHEDULE_DEFERRED; schedule <= CVOL_SCHEDULE_LITERAL;
                     schedule++) {
                    /* the slow one: alternating views */
                    if (schedule == CVOL_SCHEDULE_LITERAL && (v + (size_t)(k + order)) % 3)
                        continue;
                    set_kind(&options, k);
                    options.transform.schedule = (cvol_schedule)schedule;
                    const double psnr = against(truth, &options);
                    if (psnr < 60)
                        fail_msg("azimuth %g, elevation %g, %s %d, order %d, schedule %d: %.1f dB",
                                 views[v][0], views[v][1], cvol_transform_name(kinds[k].transform),
                                 kinds[k].tile, order, schedule, psnr);
                }
            cvol_image_free(truth);
        }
    }
}

/* All footprints and sizes. */
static void test_footprints(void **state)
{
    static const struct {
        cvol_footprint footprint;
        int size;
    } cases[] = {{CVOL_FOOTPRINT_GAUSSIAN, 3},  {CVOL_FOOTPRINT_GAUSSIAN, 5},
                 {CVOL_FOOTPRINT_GAUSSIAN, 15}, {CVOL_FOOTPRINT_GAUSSIAN, 31},
                 {CVOL_FOOTPRINT_SINC, 9},      {CVOL_FOOTPRINT_BOX, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, 25, -15);
        options.splat.plane = CVOL_FOOTPRINT_IN_SLICES;
        options.splat.footprint = cases[i].footprint;
        options.splat.size = cases[i].size;
        options.transform.rho = 1;
        cvol_image *truth = picture(0, &options);
        for (int k = (int)i % SUPPORT_STRIDE; k < KINDS; k += SUPPORT_STRIDE) {
            set_kind(&options, k);
            const double psnr = against(truth, &options);
            if (psnr < 60)
                fail_msg("footprint %d, size %d, %s %d: %.1f dB", (int)cases[i].footprint,
                         cases[i].size, cvol_transform_name(kinds[k].transform), kinds[k].tile,
                         psnr);
        }
        cvol_image_free(truth);
    }
}

/* Level L is the picture of a footprint 2^L times as wide, from a lattice of every 2^L-th place;
 * slices of level 0 serve it. */
static void test_levels(void **state)
{
    static const double least[4] = {60, 45, 40, 35};
    cvol_transform_report report, first = {0};
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        cvol_renderer *renderer;
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                              CVOL_SOURCE(.volume = &blobs)),
                         CVOL_OK);
        support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
        for (int level = 0; level < 4; level++) {
            cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, 25, -15);
            const int factor = kinds[k].transform == CVOL_DCT ? 1 << level : 1;
            options.splat.plane = CVOL_FOOTPRINT_IN_SLICES;
            options.splat.size = 3 * factor;
            options.splat.sigma = 0.8 * factor;
            cvol_image *truth = picture(0, &options);
            options.splat.size = 3;
            options.splat.sigma = 0.8;
            options.level = level;
            options.transform.rho = 1;
            set_kind(&options, k);
            cvol_image *image = support_picture(context, renderer, &options);
            const double psnr = support_psnr(truth, image);
            cvol_image_free(truth);
            cvol_image_free(image);
            assert_int_equal(cvol_renderer_get_transform_report(context, &report, renderer),
                             CVOL_OK);
            if (level == 0)
                first = report;
            else
                assert_true(report.bake_ms <= 0 && report.terms == first.terms);
            assert_true(report.step == factor);
            if (psnr < least[level])
                fail_msg("%s %d, level %d: %.1f dB", cvol_transform_name(kinds[k].transform),
                         kinds[k].tile, level, psnr);
        }
        cvol_renderer_free(renderer);
    }
}

static void test_light(void **state)
{
    cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, 40, 25);
    (void)state;
    options.transform.rho = 1;
    options.splat.plane = CVOL_FOOTPRINT_IN_SLICES;
    options.shading.on = 1;
    options.splat.sigma = 1;
    options.splat.size = 7;
    cvol_image *truth = picture(0, &options);
    assert_true(against(truth, &options) >= 60);
    cvol_image_free(truth);
}

/* Fewer terms are worse, but cause no haze over the whole picture; tiles are better. */
static void test_fewer_terms(void **state)
{
    static const double shares[] = {1, 0.3, 0.1, 0.03};
    static const double least[2][4] = {{60, 30, 25, 19}, {60, 60, 50, 35}};
    cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, 30, 20);
    (void)state;
    for (int tiles = 0; tiles < 2; tiles++) {
        double before = INFINITY;
        options.transform.tile = tiles ? 16 : 0;
        options.transform.rho = 1;
        cvol_image *truth = picture(1, &options);
        for (int i = 0; i < 4; i++) {
            options.transform.rho = shares[i];
            const double psnr = against(truth, &options);
            if (psnr < least[tiles][i] || psnr > before)
                fail_msg("tiles %d, rho %g: %.2f dB, before %.2f", tiles, shares[i], psnr, before);
            before = psnr;
        }
        cvol_image_free(truth);
    }
}

/* ---- the bound ------------------------------------------------------------------------------- */

/* The composed planes of the engine; *places: their number of places. */
static cvol_composed compose(const cvol_transform_options *own, int step, int front, double azimuth,
                             double elevation, size_t *places)
{
    cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, azimuth, elevation);
    cvol_view view;
    cvol_splat_plan plan;
    cvol_splat_input input;
    cvol_light light = {0};
    cvol_transfer *transfer;
    cvol_baked baked;
    cvol_composed out;
    options.splat.size = 5;
    assert_int_equal(cvol_view_make(context, &view, &blobs.grid, &options), CVOL_OK);
    assert_int_equal(cvol_splat_input_make(context, &input, NULL, &blobs), CVOL_OK);
    assert_int_equal(
        cvol_transfer_create(context, &transfer, support_blob_points, SUPPORT_BLOB_POINTS),
        CVOL_OK);
    cvol_splat_plan_make(&plan, &blobs.grid, &view);
    const int ascending = plan.rising == front;
    assert_int_equal(cvol_splat_input_set_transfer(context, &input, transfer), CVOL_OK);
    cvol_splat_input_tabulate(&input, plan.distance, 1);
    cvol_splat_light_set(&light, &plan, &blobs.grid, &view, &options.shading,
                         (cvol_light_values){.range = 1}, ascending);
    const cvol_footprint_shape shape = cvol_intermediate_grid_shape(&options.splat);
    const cvol_footprint_shape spread = cvol_intermediate_grid_stretch(&shape, step);
    const cvol_intermediate_grid lattice = cvol_intermediate_grid_make(&plan, &spread, step);
    const cvol_bake_source source = {&input.source, &plan, input.table, &light, ascending};
    assert_int_equal(cvol_bake(context, &baked, &source, &lattice, &shape, own), CVOL_OK);
    assert_int_equal(cvol_compose(context, &out, &baked, &lattice, &spread, plan.distance,
                                  plan.rising, front, own),
                     CVOL_OK);
    assert_true(out.certified);
    *places = lattice.dims[0] * lattice.dims[1];
    cvol_baked_free(&baked);
    cvol_transfer_free(transfer);
    cvol_splat_input_free(&input);
    return out;
}

static double distance(const cvol_composed *a, const cvol_composed *b, size_t places)
{
    double squares = 0;
    for (int c = 0; c < 3; c++)
        for (size_t at = 0; at < places; at++)
            squares += pow((double)a->planes[c][at] - (double)b->planes[c][at], 2);
    return sqrt(squares);
}

/* Both schedules are within their bounds of the picture from all terms, and of each other. */
static void test_bound(void **state)
{
    random_state random = {20031};
    (void)state;
    for (int i = 0; i < 12; i += 2 * SUPPORT_STRIDE - 1) { /* 1 or 5: coprime to KINDS */
        const int front = i & 1;
        const double azimuth = 180 * random_signed(&random),
                     elevation = 80 * random_signed(&random);
        cvol_transform_options own = {kinds[i % KINDS].transform, kinds[i % KINDS].tile, 1,
                                      CVOL_SCHEDULE_DEFERRED, 0};
        const int step = kinds[i % KINDS].transform == CVOL_DCT ? 1 << i / 2 % 3 : 1;
        cvol_composed pictures[3];
        size_t places;
        for (int schedule = 0; schedule < 3; schedule++) {
            own.rho = schedule ? 0.02 + 0.1 * i : 1;
            own.schedule = schedule == 2 ? CVOL_SCHEDULE_LITERAL : CVOL_SCHEDULE_DEFERRED;
            pictures[schedule] = compose(&own, step, front, azimuth, elevation, &places);
        }
        for (int p = 0; p < 3; p++)
            for (int q = 0; q < p; q++) {
                const double error = distance(&pictures[p], &pictures[q], places);
                const double bound = pictures[p].bound + pictures[q].bound;
                if (!(error <= bound) || !isfinite(bound))
                    fail_msg("seed 20031, case %d, %d and %d: error %g, bound %g", i, p, q, error,
                             bound);
            }
        assert_true(pictures[0].bound < 0.5);
        for (int p = 0; p < 3; p++)
            cvol_composed_free(&pictures[p]);
    }
}

/* ---- reports and refusals -------------------------------------------------------------------- */

static void report_after(cvol_renderer *renderer, const cvol_render_options *options,
                         cvol_transform_report *out)
{
    cvol_image_free(support_picture(context, renderer, options));
    assert_int_equal(cvol_renderer_get_transform_report(context, out, renderer), CVOL_OK);
}

static void test_report(void **state)
{
    cvol_render_options options = support_square(40, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_transform_report report;
    cvol_renderer *renderer;
    (void)state;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.volume = &blobs)),
                     CVOL_OK);
    assert_int_equal(cvol_renderer_get_transform_report(context, &report, renderer),
                     CVOL_ERROR_ARGUMENT);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    cvol_image_free(support_picture(context, renderer, &options));
    assert_int_equal(cvol_renderer_get_transform_report(context, &report, renderer), CVOL_OK);
    assert_true(report.lattice[0] >= 22 && report.lattice[1] >= 22 && report.slices <= 26);
    assert_true(report.rho > 0.05 && report.rho <= 0.1 && report.terms > 0 && report.bytes > 0);
    assert_true(report.bound > 0 && isfinite(report.bound));
    assert_true(report.bake_ms > 0);
    /* Zoom, roll and size only change the warp: slices stay. Another direction, rho or transfer
     * function needs new slices. */
    const uint64_t terms = report.terms;
    options = support_square(70, CVOL_MODE_COMPOSITE, 30, 20);
    options.camera.zoom = 1.5;
    options.camera.roll_deg = 40;
    report_after(renderer, &options, &report);
    assert_true(report.terms == terms && report.bake_ms <= 0);
    options.camera.azimuth_deg = 31;
    report_after(renderer, &options, &report);
    assert_true(report.bake_ms > 0);
    options.transform.rho = 0.2;
    report_after(renderer, &options, &report);
    assert_true(report.bake_ms > 0 && report.terms > terms);
    /* fewer terms are the strongest of the stored ones */
    options.transform.rho = 0.05;
    report_after(renderer, &options, &report);
    assert_true(report.bake_ms <= 0 && report.terms < terms && report.rho <= 0.05);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS - 1);
    report_after(renderer, &options, &report);
    assert_true(report.bake_ms > 0);
    cvol_renderer_free(renderer);
}

static void expect_refused(const cvol_render_options *options, int code, const char *part)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.volume = &blobs)),
                     CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), code);
    assert_non_null(strstr(cvol_context_message(context), part));
    cvol_image_free(image);
    cvol_renderer_free(renderer);
}

static void test_refusals(void **state)
{
    const cvol_render_options good = support_square(40, CVOL_MODE_COMPOSITE, 0, 0);
    cvol_render_options bad = good;
    (void)state;
    bad.mode = CVOL_MODE_MIP;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "composite only");
    bad = good;
    bad.transform.rho = 0;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "rho");
    bad.transform.rho = NAN;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "rho");
    bad = good;
    bad.transform.transform = (cvol_transform)9;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "not a transform");
    bad = good;
    bad.transform.schedule = (cvol_schedule)3;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "not a schedule");
    bad = good;
    bad.transform.tile = 12;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "tile is 12");
    bad = good;
    bad.transform.transform = CVOL_DFT;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "tiles need transform dct");
    bad = good;
    bad.splat.footprint = CVOL_FOOTPRINT_CONE;
    expect_refused(&bad, CVOL_ERROR_UNSUPPORTED, "cone");
    bad = good;
    bad.splat.size = 2;
    expect_refused(&bad, CVOL_ERROR_ARGUMENT, "footprint size 2");
}

static void test_threads(void **state)
{
    (void)state;
    for (int schedule = CVOL_SCHEDULE_DEFERRED; schedule <= CVOL_SCHEDULE_LITERAL; schedule++) {
        cvol_render_options options = support_square(60, CVOL_MODE_COMPOSITE, 50, -20);
        cvol_image *images[3];
        options.transform.schedule = (cvol_schedule)schedule;
        options.transform.rho = 0.1;
        for (int t = 0; t < 3; t++) {
            cvol_context_set_threads(context, t + 1);
            images[t] = picture(1, &options);
        }
        cvol_context_set_threads(context, 0);
        for (int t = 1; t < 3; t++)
            assert_int_equal(support_difference(images[0], images[t]), 0);
        for (int t = 0; t < 3; t++)
            cvol_image_free(images[t]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_terms_are_splats),
        cmocka_unit_test(test_footprints),
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_light),
        cmocka_unit_test(test_fewer_terms),
        cmocka_unit_test(test_bound),
        cmocka_unit_test(test_report),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
