/* The certified bound of the error of every sample, of compressed volumes: it holds for the samples
 * before rounding and clamping, in memory, in files, at every level, after transcoding and through
 * operations; and it is close to the largest error where that was measured. */
#include "test.h"

#include "array/core/array.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_exact.h"
#include "support_render.h"

enum { SIDE = 72, COUNT = SIDE * SIDE * SIDE };

/* A textured body in an empty background, as dense double precision numbers. */
static double *make_exact(double size, uint64_t seed)
{
    random_state r = {seed};
    double *exact = malloc(COUNT * sizeof *exact);
    assert_non_null(exact);
    for (size_t i = 0; i < COUNT; i++) {
        const double x = (double)(i % SIDE), y = (double)(i / SIDE % SIDE),
                     z = (double)(i / SIDE / SIDE);
        const double u = x / SIDE - 0.5, v = y / SIDE - 0.45, w = z / SIDE - 0.55;
        const double value = 110 + 30 * sin(x / 5) * cos(y / 6) + 20 * sin(z / 4) +
                             5 * random_signed(&r);
        exact[i] = u * u + 1.2 * v * v + w * w > 0.15 ? 0 : rint(size * value);
    }
    return exact;
}

static cvol_volume make_volume(const double *exact, cvol_type type)
{
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, type);
    for (size_t i = 0; i < COUNT; i++)
        if (type == CVOL_UINT8)
            ((uint8_t *)volume.data)[i] = (uint8_t)exact[i];
        else if (type == CVOL_INT16)
            ((int16_t *)volume.data)[i] = (int16_t)exact[i];
        else
            ((float *)volume.data)[i] = (float)exact[i];
    return volume;
}

static cvol_array *compress(const double *exact, cvol_type type,
                            const cvol_compress_options *options)
{
    cvol_volume volume = make_volume(exact, type);
    cvol_array *array;
    if (cvol_compress(context, &array, NULL, volume.data, &volume.grid, options))
        fail_msg("%s", cvol_context_message(context));
    free(volume.data);
    return array;
}

static cvol_array_info info_of(const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    return info;
}

/* Checks the bound against exact samples; returns bound / largest error. */
static double check(const cvol_array *array, const double *exact, const char *what)
{
    static const size_t zero[3] = {0, 0, 0};
    const cvol_array_info info = info_of(array);
    float *real = malloc(COUNT * sizeof *real);
    double most = 0;
    assert_non_null(real);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, zero, array->grid.dims), 0);
    for (size_t i = 0; i < COUNT; i++)
        most = fmax(most, fabs((double)real[i] - exact[i]));
    free(real);
    if (test_verbose())
        print_message("%s: largest error %g, bound %g, L2 bound %g\n", what, most, info.point_error,
                      info.l2_error);
    if (!(most <= info.point_error && info.point_error <= info.l2_error))
        fail_msg("%s: the largest error is %g, its bound %g, the L2 bound %g", what, most,
                 info.point_error, info.l2_error);
    return info.point_error / most;
}

/* ---- compression ----------------------------------------------------------------------------- */

typedef struct compression {
    const char *what;
    cvol_type type;
    double size, value; /* of samples; of the target */
    cvol_target target;
    int fast, plain; /* effort fast; blocks that are not lapped */
} compression;

static const compression compressions[] = {
    {"ratio 30", CVOL_UINT8, 1, 30, CVOL_TARGET_RATIO, 0, 0},
    {"effort fast", CVOL_INT16, 10, 30, CVOL_TARGET_RATIO, 1, 0},
    {"plain blocks", CVOL_INT16, 10, 30, CVOL_TARGET_RATIO, 0, 1},
    {"float32", CVOL_FLOAT32, 1000, 50, CVOL_TARGET_RATIO, 0, 0},
    {"PSNR", CVOL_FLOAT32, 1, 70, CVOL_TARGET_PSNR, 0, 0},
    {"largest error", CVOL_INT16, 10, 20, CVOL_TARGET_MAX_ERROR, 0, 0}};

static cvol_compress_options options_of(const compression *c)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = c->target;
    options.target_value = c->value;
    options.effort = c->fast ? CVOL_EFFORT_FAST : options.effort;
    options.lapped = c->plain ? 0 : options.lapped;
    return options;
}

/* A file holds the bound, rounded up by at most 1/4096. */
static void check_file(const cvol_array *array, const double *exact, const char *what)
{
    cvol_array *back;
    void *data;
    size_t size;
    assert_int_equal(cvol_array_write_memory(context, array, &data, &size), CVOL_OK);
    assert_int_equal(cvol_array_read_memory(context, &back, data, size, "file"), CVOL_OK);
    const double before = info_of(array).point_error, after = info_of(back).point_error;
    if (!(after >= before && after <= before * (1 + 0x1p-12)))
        fail_msg("%s: a bound of %g is %g in the file", what, before, after);
    check(back, exact, what);
    free(data);
    cvol_array_free(back);
}

/* Its bound is less than a quarter above the largest error, where that is of terms. */
static void test_compressed(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof compressions / sizeof *compressions; i++) {
        const compression *c = &compressions[i];
        double *exact = make_exact(c->size, i + 1);
        const cvol_compress_options options = options_of(c);
        cvol_array *array = compress(exact, c->type, &options);
        const double loose = check(array, exact, c->what);
        if (!array->residual && loose > 1.25)
            fail_msg("%s: the bound is %g times the largest error", c->what, loose);
        check_file(array, exact, c->what);
        cvol_array_free(array);
        free(exact);
    }
}

/* ---- files without the field ----------------------------------------------------------------- */

static void test_missing_field(void **state)
{
    (void)state;
    double *exact = make_exact(1, 7);
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array = compress(exact, CVOL_UINT8, &options), *back;
    void *data[2];
    size_t size[2];
    assert_int_equal(cvol_array_write_memory(context, array, &data[0], &size[0]), CVOL_OK);
    array->error_bound.point_error = 0;
    assert_int_equal(cvol_array_write_memory(context, array, &data[1], &size[1]), CVOL_OK);
    assert_true(size[1] < size[0] && size[0] <= size[1] + 8);
    assert_int_equal(cvol_array_read_memory(context, &back, data[1], size[1], "file"), CVOL_OK);
    assert_true(info_of(back).point_error == info_of(array).l2_error);
    check(back, exact, "without the field");
    cvol_array_free(back);
    cvol_array_free(array);
    free(data[0]);
    free(data[1]);
    free(exact);
}

/* ---- levels and transcoding ------------------------------------------------------------------ */

static void test_levels(void **state)
{
    (void)state;
    double *exact = make_exact(10, 8);
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array = compress(exact, CVOL_INT16, &options);
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    for (int level = 0; level <= 3; level++) {
        const cvol_file_part part = {.size = sizeof part, .level = level};
        cvol_array *coarse;
        assert_int_equal(cvol_array_read_part(context, &coarse, NULL, path, &part), CVOL_OK);
        check(coarse, exact, "a level");
        cvol_array_free(coarse);
    }
    free(path);
    support_folder_remove(folder);
    cvol_array_free(array);
    free(exact);
}

static void test_transcoded(void **state)
{
    (void)state;
    double *exact = make_exact(10, 9);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target_value = 20;
    cvol_array *array = compress(exact, CVOL_INT16, &options), *coarse;
    options.target_value = 60;
    assert_int_equal(cvol_array_transcode(context, &coarse, NULL, array, &options), CVOL_OK);
    assert_true(check(coarse, exact, "transcoded") < 3);
    cvol_array_free(coarse);
    cvol_array_free(array);
    /* Of samples with a bounded error. */
    options.target = CVOL_TARGET_MAX_ERROR;
    options.target_value = 20;
    array = compress(exact, CVOL_INT16, &options);
    options.target = CVOL_TARGET_RATIO;
    options.target_value = 60;
    assert_int_equal(cvol_array_transcode(context, &coarse, NULL, array, &options), CVOL_OK);
    check(coarse, exact, "transcoded from bounded errors");
    cvol_array_free(coarse);
    cvol_array_free(array);
    free(exact);
}

/* ---- operations ------------------------------------------------------------------------------ */

/* Operations on compressed volumes: bounds hold, and stay far below the L2 bound. */
static void test_operations(void **state)
{
    (void)state;
    const support_shape shape = {
        .rank = 3, .dims = {SIDE, SIDE, SIDE}, .block = 16, .transform = CVOL_DCT};
    static const double weight[3] = {1, 1, 1};
    double *x = make_exact(1, 10), *y = make_exact(1, 11), *dense = malloc(COUNT * sizeof *dense);
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *a = compress(x, CVOL_UINT8, &options), *b = compress(y, CVOL_UINT8, &options);
    cvol_array *out;
    cvol_kernel kernel;
    assert_non_null(dense);
    const double far = 4; /* the L2 bound is more than so many times larger */
#define CHECK(what)                                                         \
    do {                                                                    \
        check(out, dense, what);                                            \
        assert_true(far *info_of(out).point_error < info_of(out).l2_error); \
        cvol_array_free(out);                                               \
    } while (0)
    assert_int_equal(cvol_array_scale(context, &out, -2, a, 30), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        dense[i] = -2 * x[i] + 30;
    CHECK("scale");
    assert_int_equal(cvol_array_add(context, &out, 2, a, -0.5, b, NULL), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        dense[i] = 2 * x[i] - 0.5 * y[i];
    CHECK("add");
    assert_int_equal(cvol_array_multiply(context, &out, a, b, NULL, CVOL_PLAN_AUTO, NULL), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        dense[i] = x[i] * y[i];
    CHECK("multiply");
    assert_int_equal(cvol_kernel_gaussian(context, &kernel, 3, 1.5), CVOL_OK);
    assert_int_equal(cvol_array_convolve_kernel(context, &out, a, &kernel, NULL), CVOL_OK);
    memcpy(dense, x, COUNT * sizeof *dense);
    support_filter(dense, &shape, &kernel);
    CHECK("smooth");
    assert_int_equal(cvol_array_gradient(context, &out, a, NULL), CVOL_OK);
    memcpy(dense, x, COUNT * sizeof *dense);
    support_gradient(dense, &shape, weight);
    CHECK("gradient");
#undef CHECK
    cvol_array_free(a);
    cvol_array_free(b);
    free(x);
    free(y);
    free(dense);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_compressed), cmocka_unit_test(test_missing_field),
        cmocka_unit_test(test_levels), cmocka_unit_test(test_transcoded),
        cmocka_unit_test(test_operations)};
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
