/* The sheet engine's pictures against those of the ray engine, which evaluates the volume itself.
 * Each floor is the measured PSNR minus about 1.5 dB; if a slice shifts by half a pixel or a row of
 * blocks is lost, many floors fail. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "support.h"
#include "support_context.h"
#include "support_render.h"
#include "support_split.h"

/* ---- helpers ----------------------------------------------------------------------------- */

/* A volume and its array. */
typedef struct subject {
    cvol_volume volume;
    cvol_array *array;
} subject;

static subject compress(cvol_volume volume, int block)
{
    return (subject){volume, support_compress(context, &volume, block, 80)};
}

static subject blobs(size_t nx, size_t ny, size_t nz, int block)
{
    return compress(support_blobs(nx, ny, nz), block);
}

static void release(subject *s)
{
    cvol_array_free(s->array);
    free(s->volume.data);
}

typedef struct function {
    const char *name;
    const cvol_transfer_point *points;
    size_t count;
} function;

static const cvol_transfer_point jump_points[] = {
    {25, 0, 0, 0, 0}, {25, 1, .4, .1, .1}, {50, 1, .4, .1, .1}, {50, .2, .9, 1, .6}};
static const cvol_transfer_point surface_points[] = {
    {30, .3, .2, .1, 0}, {40, .6, .4, .3, .5}, {60, 1, .9, .8, 1}};

static const function soft = {"soft", support_blob_points, SUPPORT_BLOB_POINTS};
static const function jumps = {"jumps", jump_points, 4};
static const function surface = {"surface", surface_points, 3};

static void describe(const subject *s, const function *f, const cvol_render_options *o, double psnr,
                     int largest)
{
    const size_t *n = s->volume.grid.dims;
    print_message("%zux%zux%zu mode %d %s azimuth %g elevation %g roll %g zoom %g %dx%d: "
                  "%.2f dB, largest %d\n",
                  n[0], n[1], n[2], (int)o->mode, f->name, o->camera.azimuth_deg,
                  o->camera.elevation_deg, o->camera.roll_deg, o->camera.zoom, o->width, o->height,
                  psnr, largest);
}

/* 1 if all pixels within `reach` of (i, j) have the colour of `colour`, or none has. */
static int is_uniform(const cvol_image *image, int i, int j, int reach, const uint8_t *colour)
{
    int same = 0, count = 0;
    for (int y = j - reach; y <= j + reach; y++)
        for (int x = i - reach; x <= i + reach; x++)
            if (x >= 0 && y >= 0 && x < image->width && y < image->height) {
                same += !memcmp(support_pixel(image, x, y), colour, 3);
                count++;
            }
    return same == 0 || same == count;
}

/* At the volume's silhouette, and at the picture's edge, replaces the sheet engine's pixels by
 * those of the ray engine: only one engine has sharp silhouettes. */
static void forget_silhouette(cvol_image *sheet, const cvol_image *ray,
                              const cvol_render_options *options)
{
    uint8_t background[3];
    for (int c = 0; c < 3; c++)
        background[c] = (uint8_t)(255 * options->background[c] + 0.5);
    for (int j = 0; j < ray->height; j++)
        for (int i = 0; i < ray->width; i++)
            if (i < 4 || j < 4 || i >= ray->width - 4 || j >= ray->height - 4 ||
                !is_uniform(ray, i, j, 3, background))
                memcpy(sheet->rgba + 4 * (j * ray->width + i), support_pixel(ray, i, j), 4);
}

/* The PSNR of both engines' pictures must be at least `floor_db`. */
static void expect(const subject *s, const function *f, cvol_render_options options, int silhouette,
                   double floor_db)
{
    cvol_image *sheet = support_sheet(context, s->array, f->points, f->count, &options);
    options.step_voxels = 0.25;
    cvol_image *ray = support_ray(context, &s->volume, f->points, f->count, &options);
    if (!silhouette)
        forget_silhouette(sheet, ray, &options);
    double psnr = support_psnr(sheet, ray);
    if (test_verbose() || psnr < floor_db)
        describe(s, f, &options, psnr, support_difference(sheet, ray));
    if (psnr < floor_db)
        fail_msg("%.2f dB, expected %.2f", psnr, floor_db);
    cvol_image_free(sheet);
    cvol_image_free(ray);
}

static void expect_truth(const subject *s, const function *f, cvol_render_options options,
                         double floor_db)
{
    expect(s, f, options, 1, floor_db);
}

static const double views[][2] = {{0, 0},     {90, 0},   {180, 0},  {270, 0},      {0, 90},
                                  {0, -90},   {30, 20},  {45, 0},   {45, 35.2644}, {0, 45},
                                  {200, -35}, {135, 89}, {300, 60}, {180, -44.999}};
#define VIEWS (sizeof views / sizeof *views)

static cvol_render_options look(size_t view, int size, cvol_mode mode)
{
    cvol_render_options options = support_square(size, mode, views[view][0], views[view][1]);
    options.background[0] = mode == CVOL_MODE_COMPOSITE ? 0.2 : 0;
    options.background[2] = mode == CVOL_MODE_COMPOSITE ? 0.6 : 0;
    return options;
}

/* ---- against the reference ----------------------------------------------------------------- */

static void test_directions(void **state)
{
    (void)state;
    subject s = blobs(37, 45, 41, 16);
    const size_t stride = (size_t)support_stride();
    for (size_t v = 0; v < VIEWS; v += stride) {
        expect_truth(&s, &soft, look(v, 96, CVOL_MODE_COMPOSITE), 58);
        expect_truth(&s, &jumps, look(v, 96, CVOL_MODE_COMPOSITE), 37);
        expect_truth(&s, &surface, look(v, 96, CVOL_MODE_COMPOSITE), 45);
        expect_truth(&s, &soft, look(v, 96, CVOL_MODE_XRAY), 64);
        expect_truth(&s, &soft, look(v, 96, CVOL_MODE_MIP), 56);
    }
    release(&s);
}

static void test_split_cells(void **state)
{
    (void)state;
    subject s = blobs(37, 45, 41, 16);
    support_split_cells(context, s.array, 1);
    const size_t stride = (size_t)support_stride();
    for (size_t v = 0; v < VIEWS; v += stride) {
        expect_truth(&s, &soft, look(v, 96, CVOL_MODE_COMPOSITE), 58);
        expect_truth(&s, &surface, look(v, 96, CVOL_MODE_COMPOSITE), 45);
        expect_truth(&s, &soft, look(v, 96, CVOL_MODE_XRAY), 64);
        cvol_render_options far = look(v, 80, CVOL_MODE_COMPOSITE);
        far.camera.zoom = 0.3;
        expect_truth(&s, &soft, far, 50);
    }
    release(&s);
}

/* From 16 pixels, which evaluate blocks at half their resolution, to 20 pixels per sample. */
static void test_zooms_and_rolls(void **state)
{
    (void)state;
    subject s = blobs(37, 45, 41, 16);
    static const double zooms[] = {0.3, 1, 4, 20}, rolls[] = {90, -50, 180, 17};
    for (size_t v = 0; v < VIEWS; v += 3)
        for (size_t z = 0; z < 4; z++)
            for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
                cvol_render_options options = look(v, 80, (cvol_mode)mode);
                options.camera.zoom = zooms[z];
                options.camera.roll_deg = rolls[z];
                expect_truth(&s, &soft, options, mode == CVOL_MODE_XRAY ? 61 : 50);
            }
    release(&s);
}

static void test_block_sides_and_spacings(void **state)
{
    (void)state;
    const size_t stride = (size_t)support_stride();
    static const double spacings[][3] = {{1, 1, 1}, {1, 1.5, 0.7}, {0.2, 0.2, 1}, {3, 1, 1}};
    for (int block = 8; block <= 32; block *= 2)
        for (size_t k = 0; k < 4; k++) {
            if ((k + (size_t)block / 8) % stride)
                continue;
            cvol_volume volume = support_blobs(37, 45, 41);
            memcpy(volume.grid.spacing, spacings[k], sizeof spacings[k]);
            subject s = compress(volume, block);
            for (size_t v = k % 2; v < VIEWS; v += 4) {
                expect_truth(&s, &soft, look(v, 96, CVOL_MODE_COMPOSITE), 58);
                expect_truth(&s, &soft, look(v, 96, CVOL_MODE_XRAY), 64);
            }
            release(&s);
        }
}

static const size_t shapes[][3] = {{17, 33, 5}, {1, 40, 40}, {40, 1, 40}, {40, 40, 1}, {1, 1, 1},
                                   {100, 3, 3}, {2, 2, 2},   {1, 1, 30},  {16, 16, 16}};
#define SHAPES (sizeof shapes / sizeof *shapes)

static void test_shapes(void **state)
{
    (void)state;
    const size_t stride = (size_t)support_stride();
    for (size_t k = 0; k < SHAPES; k++) {
        subject s = blobs(shapes[k][0], shapes[k][1], shapes[k][2], 16);
        for (size_t v = k % stride; v < VIEWS; v += stride)
            expect(&s, &soft, look(v, 64, CVOL_MODE_COMPOSITE), 0, 45);
        release(&s);
    }
}

static void test_picture_shapes(void **state)
{
    (void)state;
    static const int sizes[][2] = {{150, 60}, {60, 150}, {1, 1}, {5, 3}, {1, 90}, {200, 2}};
    const size_t stride = (size_t)support_stride();
    subject s = blobs(37, 45, 41, 16);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (size_t v = k % stride; v < VIEWS; v += 1 + stride) {
            cvol_render_options options = look(v, 1, CVOL_MODE_COMPOSITE);
            options.width = sizes[k][0];
            options.height = sizes[k][1];
            options.camera.roll_deg = 10 * (double)v;
            expect_truth(&s, &soft, options, 42);
        }
    release(&s);
}

/* A volume that is opaque everywhere, unlike the blobs: its faces are visible. */
static subject full(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_UINT8);
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx; x++)
                ((uint8_t *)volume.data)[support_index(&volume, x, y, z)] =
                    (uint8_t)(128 + 60 * sin(0.2 * (double)x) * cos(0.15 * (double)y + 1) +
                              40 * sin(0.1 * (double)z));
    return compress(volume, 16);
}

static const cvol_transfer_point fog_points[] = {{50, .2, .5, 1, .02}, {200, 1, .6, .1, .1}};
static const function fog = {"fog", fog_points, 2};

static void test_faces(void **state)
{
    (void)state;
    const size_t stride = (size_t)support_stride();
    for (size_t k = 0; k < SHAPES; k++) {
        subject s = full(shapes[k][0], shapes[k][1], shapes[k][2]);
        for (size_t v = k % stride; v < VIEWS; v += stride) {
            for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
                static const double floors_db[] = {0, 36, 52, 34};
                if (shapes[k][0] == 2 && mode != CVOL_MODE_COMPOSITE)
                    continue; /* a single cell: everything lies between its two slices */
                cvol_render_options options = look(v, 64, (cvol_mode)mode);
                options.background[0] = 0.2; /* not grey, also in the grey modes */
                options.camera.zoom = 1.3;
                expect(&s, &fog, options, 0, floors_db[mode]);
            }
        }
        release(&s);
    }
}

/* ---- cases without a floor ------------------------------------------------------------------- */

/* Opaque samples of one colour fill the volume: except for the silhouette's pixels, both engines
 * draw the same: no holes, no seams, no missing parts. */
static void test_opaque_boxes_are_whole(void **state)
{
    (void)state;
    const size_t stride = (size_t)support_stride();
    static const cvol_transfer_point points[] = {{0, 1, .5, .25, 1}};
    static const double zooms[] = {1, 2, 4, 15};
    for (size_t k = 0; k < SHAPES; k++) {
        subject s = full(shapes[k][0], shapes[k][1], shapes[k][2]);
        for (size_t v = k % stride; v < VIEWS; v += stride)
            for (size_t z = 0; z < 4; z++) {
                cvol_render_options options = look(v, 64, CVOL_MODE_COMPOSITE);
                options.camera.zoom = zooms[z];
                options.camera.roll_deg = 25 * (double)z;
                cvol_image *sheet = support_sheet(context, s.array, points, 1, &options);
                cvol_image *ray = support_ray(context, &s.volume, points, 1, &options);
                forget_silhouette(sheet, ray, &options);
                int wrong = support_difference(sheet, ray) > 10; /* the warp overshoots */
                if (wrong)
                    print_message("%zux%zux%zu view %zu zoom %g: %d wrong\n", shapes[k][0],
                                  shapes[k][1], shapes[k][2], v, zooms[z],
                                  support_difference(sheet, ray));
                assert_int_equal(wrong, 0);
                cvol_image_free(sheet);
                cvol_image_free(ray);
            }
        release(&s);
    }
}

/* Transparent samples show the background, exactly. */
static void test_transparent_is_background(void **state)
{
    (void)state;
    static const cvol_transfer_point clear[] = {{0, 1, 1, 1, 0}, {100, 1, .5, 0, 0}};
    static const cvol_transfer_point beyond[] = {{500, 1, 1, 1, 0}, {600, 1, .5, 0, 1}};
    static const cvol_transfer_point below[] = {{-600, 1, 1, 1, 1}, {-500, 1, .5, 0, 0}};
    const cvol_transfer_point *const functions[] = {clear, beyond, below};
    subject s = blobs(37, 45, 41, 16);
    for (size_t v = 0; v < VIEWS; v++)
        for (size_t f = 0; f < 3; f++) {
            cvol_render_options options = look(v, 40, CVOL_MODE_COMPOSITE);
            cvol_image *image = support_sheet(context, s.array, functions[f], 2, &options);
            for (int i = 0; i < 40 * 40; i++) {
                assert_int_equal(image->rgba[4 * i], 51);
                assert_int_equal(image->rgba[4 * i + 1], 0);
                assert_int_equal(image->rgba[4 * i + 2], 153);
            }
            cvol_image_free(image);
        }
    release(&s);
}

/* Functions that begin or end with a jump, within the data and at their ends. */
static void test_jumps_at_the_ends(void **state)
{
    (void)state;
    subject s = blobs(37, 45, 41, 16);
    for (int at = 10; at <= 70; at += 20)
        for (int falling = 0; falling < 2; falling++) {
            const cvol_transfer_point points[] = {{at, 1, .5, .2, falling ? .3 : 0},
                                                  {at, .2, .5, 1, falling ? 0 : .3}};
            const function jump = {falling ? "falling" : "rising", points, 2};
            for (size_t v = 0; v < VIEWS; v += 5)
                expect_truth(&s, &jump, look(v, 96, CVOL_MODE_COMPOSITE), 37);
        }
    release(&s);
}

/* At a change of the principal axis the picture hardly changes. */
static void test_axes_agree(void **state)
{
    (void)state;
    static const double pairs[][4] = {{44.99, 0, 45.01, 0},       {44.99, 20, 45.01, 20},
                                      {0, 44.99, 0, 45.01},       {225.01, -10, 224.99, -10},
                                      {45, 35.25, 45, 35.28},     {89.99, 45.01, 90.01, 44.99},
                                      {135.01, -30, 134.99, -30}, {30, 40.8, 30, 41}};
    subject s = blobs(37, 45, 41, 16);
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++)
        for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
            cvol_render_options options = look(0, 96, (cvol_mode)mode);
            cvol_image *images[2];
            for (int side = 0; side < 2; side++) {
                options.camera.azimuth_deg = pairs[k][2 * side];
                options.camera.elevation_deg = pairs[k][2 * side + 1];
                images[side] = support_sheet(context, s.array, soft.points, soft.count, &options);
            }
            double psnr = support_psnr(images[0], images[1]);
            if (test_verbose())
                print_message("axes: pair %zu mode %d: %.2f dB\n", k, mode, psnr);
            assert_true(psnr >= (mode == CVOL_MODE_XRAY ? 64 : 55));
            cvol_image_free(images[0]);
            cvol_image_free(images[1]);
        }
    release(&s);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_directions),
        TEST(test_split_cells),
        TEST(test_zooms_and_rolls),
        TEST(test_block_sides_and_spacings),
        TEST(test_shapes),
        TEST(test_picture_shapes),
        TEST(test_faces),
        TEST(test_opaque_boxes_are_whole),
        TEST(test_transparent_is_background),
        TEST(test_jumps_at_the_ends),
        TEST(test_axes_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
