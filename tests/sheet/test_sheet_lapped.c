/* The sheet engine on lapped arrays: their pictures equal those of the decoded samples. */
#include "test.h"

#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* Slopes and bumps of a few samples' width everywhere, so that errors at faces would be visible. */
static cvol_volume bumpy(size_t nx, size_t ny, size_t nz, uint64_t seed)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    random_state r = {seed};
    double wave[6][4];
    for (int k = 0; k < 6; k++)
        for (int a = 0; a < 4; a++)
            wave[k][a] = (a < 3 ? 0.25 : 3.2) * random_signed(&r);
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx; x++) {
                double value = 50;
                for (int k = 0; k < 6; k++)
                    value += 12 * sin(wave[k][0] * (double)x + wave[k][1] * (double)y +
                                      wave[k][2] * (double)z + wave[k][3]);
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)value;
            }
    return volume;
}

/* As a lapped array, close to the samples; *decoded has exactly its decoded samples. */
static cvol_array *make_lapped(cvol_volume *decoded, const cvol_volume *volume, double step,
                               uint64_t split_seed)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    cvol_array *array = support_lapped(context, volume->data, volume->grid.dims, 3, step,
                                       split_seed != 0, split_seed);
    assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
    if (decoded) {
        *decoded = *volume;
        decoded->data = malloc(count * sizeof(float));
        assert_non_null(decoded->data);
        support_lapped_samples(decoded->data, array);
        for (size_t i = 0; i < count; i++)
            ((float *)decoded->data)[i] += (float)array->offset;
    }
    return array;
}

static const cvol_transfer_point soft_points[] = {
    {0, .1, .2, .9, 0}, {30, .9, .3, .1, .04}, {60, 1, .9, .5, .15}, {100, 1, 1, 1, .3}};
/* Most cells are transparent, many only slightly. */
static const cvol_transfer_point band_points[] = {
    {70, .3, .2, .1, 0}, {74, .9, .4, .3, .5}, {80, 1, .9, .8, .9}, {84, .2, .9, .3, 0}};

static const double views[][2] = {{0, 0},   {90, 0},  {180, 0},   {270, 0},   {0, 90},
                                  {0, -90}, {30, 20}, {45, 35.3}, {210, -50}, {120, -70}};
enum { VIEWS = sizeof views / sizeof *views };

/* Pictures of both arrays, which must be the same, from all views. */
static double worst_view(const cvol_array *lapped, const cvol_array *plain,
                         const cvol_transfer_point *points, size_t count, cvol_mode mode, int size,
                         double zoom, const char *what)
{
    static int from; /* so that different cells are skipped from case to case, if any are */
    double worst = 99;
    for (int v = from++ % support_stride(); v < VIEWS; v += support_stride()) {
        cvol_render_options options = support_square(size, mode, views[v][0], views[v][1]);
        options.camera.zoom = zoom;
        cvol_image *a = support_sheet(context, lapped, points, count, &options);
        cvol_image *b = support_sheet(context, plain, points, count, &options);
        const double psnr = support_psnr(a, b);
        if (test_verbose())
            print_message("%s, mode %d, size %d, zoom %g, view %d: %.2f dB\n", what, (int)mode,
                          size, zoom, v, psnr);
        worst = fmin(worst, psnr);
        cvol_image_free(a);
        cvol_image_free(b);
    }
    return worst;
}

typedef struct scale {
    int size;
    double zoom;
    double floor_db; /* the minimum PSNR of the pictures */
} scale;

static void expect_alike(const size_t n[3], uint64_t split_seed, const scale *scales, size_t count)
{
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY,
                                      CVOL_MODE_MIP};
    cvol_volume volume = bumpy(n[0], n[1], n[2], 7 + split_seed), decoded;
    cvol_array *lapped = make_lapped(&decoded, &volume, 0.05, split_seed);
    cvol_array *plain = support_compress(context, &decoded, 16, 90);
    plain->error_bound.value_min = lapped->error_bound.value_min;
    plain->error_bound.value_max = lapped->error_bound.value_max;
    for (size_t s = 0; s < count; s++)
        for (int m = 0; m < 4; m++) {
            cvol_context_set_threads(context, m % 2 ? 3 : 1);
            const double db = worst_view(lapped, plain, m ? band_points : soft_points, 4, modes[m],
                                         scales[s].size, scales[s].zoom, m ? "band" : "soft");
            if (db < scales[s].floor_db)
                print_message("%zu x %zu x %zu, split seed %llu, mode %d (%s), size %d, zoom %g: "
                              "%.2f dB\n",
                              n[0], n[1], n[2], (unsigned long long)split_seed, (int)modes[m],
                              m ? "band" : "soft", scales[s].size, scales[s].zoom, db);
            assert_true(db >= scales[s].floor_db);
        }
    free(volume.data);
    free(decoded.data);
    cvol_array_free(lapped);
    cvol_array_free(plain);
}

static void test_pictures_equal_those_of_samples(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{64, 48, 40}, {33, 50, 35}, {70, 33, 49}, {18, 34, 66}};
    static const scale scales[] = {{100, 1, 45}, {100, 3, 45}};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        expect_alike(shapes[s], s % 2 ? 11 * s : 0, scales, 2);
}

static void test_thin_volumes(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{40, 40, 1}, {1, 33, 40},  {50, 2, 35},
                                       {5, 7, 64},  {17, 17, 17}, {18, 18, 18}};
    static const scale scales[] = {{80, 1, 45}};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        expect_alike(shapes[s], s, scales, 1);
}

static void test_from_afar(void **state)
{
    (void)state;
    static const size_t shape[3] = {66, 80, 72};
    static const scale scales[] = {{60, 1, 35}, {40, 1, 35}, {30, 1, 35}};
    expect_alike(shape, 0, scales, 3);
    expect_alike(shape, 5, scales, 3);
}

/* Small bright bodies, many of them at faces, on a mostly transparent volume. */
static cvol_volume specks(size_t n, int count, uint64_t seed)
{
    cvol_volume volume = support_volume(n, n, n, CVOL_FLOAT32);
    random_state r = {seed};
    for (int k = 0; k < count; k++) {
        double centre[3], width = 0.8 + 2.2 * fabs(random_signed(&r));
        for (int a = 0; a < 3; a++)
            centre[a] = k % 2 ? 16.0 * (1 + random_below(&r, (uint32_t)n / 16)) - 0.5
                              : (double)random_below(&r, (uint32_t)n);
        for (size_t z = 0; z < n; z++)
            for (size_t y = 0; y < n; y++)
                for (size_t x = 0; x < n; x++) {
                    const double at[3] = {(double)x, (double)y, (double)z};
                    double r2 = 0;
                    for (int a = 0; a < 3; a++)
                        r2 += (at[a] - centre[a]) * (at[a] - centre[a]);
                    ((float *)volume.data)[support_index(&volume, x, y, z)] +=
                        (float)(100 * exp(-r2 / (width * width)));
                }
    }
    return volume;
}

static const cvol_transfer_point speck_points[] = {{20, .9, .3, .1, 0}, {60, 1, .9, .5, .6}};

/* Every cell is invisible in one of two ways, with a step to its neighbours; the filter loses the
 * step if a neighbour is not evaluated. */
static void add_cliffs(cvol_volume *volume)
{
    const size_t *n = volume->grid.dims;
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++)
                ((float *)volume->data)[support_index(volume, x, y, z)] +=
                    (x / 16 + y / 16 + z / 16) % 2 ? 15 : -85;
}

/* Skipped cells leave no visible trace at the faces of others. */
static void test_skipped_neighbours(void **state)
{
    (void)state;
    static const cvol_transfer_point shell_points[] = {
        {25, .9, .3, .1, 0}, {30, 1, .9, .5, .6}, {40, 1, .9, .5, .6}, {45, .9, .3, .1, 0}};
    const uint64_t stride = (uint64_t)support_stride();
    for (uint64_t seed = stride; seed <= 6; seed += stride) {
        cvol_volume volume = seed > 4 ? specks(112, 3, seed) : specks(72, 12, seed);
        if (seed > 4)
            add_cliffs(&volume);
        const uint64_t splits = seed % 2 ? 0 : seed;
        cvol_array *lapped = make_lapped(NULL, &volume, 0.1, splits);
        cvol_array *open = make_lapped(NULL, &volume, 0.1, splits);
        for (size_t b = 0; b < open->block_count; b++) {
            open->block_table[b].range[0] = 0;
            open->block_table[b].range[1] = 255;
        }
        static const scale scales[] = {{120, 1, 46}, {50, 1, 46}, {120, 3, 46}};
        for (int s = 0; s < 3; s++)
            for (int subband = 0; subband < 2; subband++) {
                const double db = worst_view(lapped, open, subband ? shell_points : speck_points,
                                             subband ? 4 : 2, CVOL_MODE_COMPOSITE, scales[s].size,
                                             scales[s].zoom, "skipped");
                if (db < scales[s].floor_db)
                    print_message("seed %llu, subband %d, size %d, zoom %g: %.2f dB\n",
                                  (unsigned long long)seed, subband, scales[s].size, scales[s].zoom,
                                  db);
                assert_true(db >= scales[s].floor_db);
            }
        free(volume.data);
        cvol_array_free(lapped);
        cvol_array_free(open);
    }
}

static void test_same_for_any_threads_and_bands(void **state)
{
    (void)state;
    static const int counts[] = {2, 3, 7};
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_MIP};
    cvol_volume volumes[2] = {bumpy(70, 64, 83, 3), specks(80, 12, 9)};
    for (int v = 0; v < 2; v++) {
        cvol_array *array = make_lapped(NULL, &volumes[v], 0.3, (uint64_t)v);
        for (int k = 0; k < 24; k = support_next(k)) {
            cvol_render_options options = support_square(100 + 50 * (k % 3),
                                                         modes[k % 4 == 3 ? 1 + k / 4 % 2 : 0],
                                                         views[k % VIEWS][0], views[k % VIEWS][1]);
            options.height = 400;
            options.camera.zoom = k % 5 == 4 ? 0.3 : 1 + k % 3;
            options.step_voxels = k % 6 == 2 ? 0.4 : 0;
            options.shading.on = k % 7 == 4;
            const cvol_transfer_point *points = v ? speck_points : band_points;
            cvol_context_set_threads(context, 1);
            cvol_image *one = support_sheet(context, array, points, v ? 2 : 4, &options);
            cvol_context_set_threads(context, counts[k % 3]);
            cvol_image *many = support_sheet(context, array, points, v ? 2 : 4, &options);
            if (support_difference(one, many))
                fail_msg("volume %d, request %d, %d threads: %d levels", v, k, counts[k % 3],
                         support_difference(one, many));
            cvol_image_free(many);
            cvol_image_free(one);
        }
        free(volumes[v].data);
        cvol_array_free(array);
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_pictures_equal_those_of_samples),
        TEST(test_thin_volumes),
        TEST(test_from_afar),
        TEST(test_skipped_neighbours),
        TEST(test_same_for_any_threads_and_bands),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
