/* Lossy or lossless: a lossy file is never larger than the lossless one of the same volume and
 * mask, and integers with a mask meet their target, whether it is looser than lossless or not. */
#include "test.h"

#include "array/core/array.h"
#include "base/for_type.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"

enum { NX = SUPPORT_SIDE(49), NY = SUPPORT_SIDE(45), NZ = SUPPORT_SIDE(33), COUNT = NX * NY * NZ };

typedef enum kind { LABELS, NOISE, SPARSE, STRIPPED, SMOOTH, KINDS } kind;

static double ball(size_t x, size_t y, size_t z)
{
    return pow((double)x / NX - 0.5, 2) + pow((double)y / NY - 0.5, 2) +
           pow((double)z / NZ - 0.5, 2);
}

/* Zero outside a ball, but smooth values and noise without a mask. */
static double sample_of(kind what, random_state *r, size_t x, size_t y, size_t z)
{
    const double wave = sin(0.09 * (double)x) * cos(0.07 * (double)y) + 0.01 * (double)z;
    const double chance = random_signed(r);
    switch (what) {
    case LABELS: /* columns of 9 x 7, each with its number */
        return ball(x, y, z) < 0.2 ? (double)(1 + x / 9 + 37 * (y / 7)) : 0;
    case NOISE:
        return chance < 0 ? 0 : 200;
    case SPARSE:
        return chance > 0.98 ? 60 : 0;
    case STRIPPED:
        return ball(x, y, z) < 0.15 ? round(100 + 40 * wave + 6 * chance) : 0;
    default:
        return x < NX / 2 ? 0 : round(1000 + 300 * wave);
    }
}

/* The caller frees. */
static void *make(cvol_grid *grid, kind what, cvol_type type)
{
    random_state r = {7};
    *grid = cvol_grid_make(NX, NY, NZ, type);
    void *samples = malloc(cvol_grid_bytes(grid));
    assert_non_null(samples);
    for (size_t i = 0; i < COUNT; i++) {
        const double value = sample_of(what, &r, i % NX, i / NX % NY, i / NX / NY);
#define STORE(t) ((t *)samples)[i] = (t)value
        CVOL_FOR_TYPE(type, STORE);
#undef STORE
    }
    return samples;
}

/* Compresses, writes, reads and compares with the samples: the report is true, and masked samples
 * are unchanged. */
static cvol_compress_report compress(const void *samples, const cvol_grid *grid,
                                     const cvol_compress_options *options, const char *name)
{
    const size_t zero[3] = {0, 0, 0};
    cvol_array *array, *read;
    cvol_compress_report report;
    void *file, *decoded = malloc(cvol_grid_bytes(grid));
    size_t size;
    if (cvol_compress(context, &array, &report, samples, grid, options))
        fail_msg("%s: %s", name, cvol_context_message(context));
    if (cvol_array_write_memory(context, array, &file, &size) ||
        cvol_array_read_memory(context, &read, file, size, name) ||
        cvol_array_evaluate_box(context, decoded, read, zero, grid->dims))
        fail_msg("%s: %s", name, cvol_context_message(context));
    double most = 0;
#define COMPARE(t)                                                                 \
    for (size_t i = 0; i < cvol_grid_samples(grid); i++)                           \
        if (options->has_fill && (double)((const t *)samples)[i] == options->fill) \
            assert_true(((const t *)decoded)[i] == ((const t *)samples)[i]);       \
        else                                                                       \
            most = fmax(most,                                                      \
                        fabs((double)((const t *)decoded)[i] - (double)((const t *)samples)[i]))
    CVOL_FOR_TYPE(grid->type, COMPARE);
#undef COMPARE
    if (fabs(report.max_error - most) > 0 || report.file_bytes != size ||
        report.lossless != (most <= 0))
        fail_msg("%s: error %g, reported %g; %zu bytes, reported %llu", name, most,
                 report.max_error, size, (unsigned long long)report.file_bytes);
    free(file);
    free(decoded);
    cvol_array_free(array);
    cvol_array_free(read);
    return report;
}

static cvol_compress_options target(cvol_target what, double value)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = what;
    options.target_value = value;
    return options;
}

static void test_masked_integers_at_loose_targets(void **state)
{
    (void)state;
    const cvol_compress_options asked[] = {
        target(CVOL_TARGET_RATIO, 2), target(CVOL_TARGET_RATIO, 3), target(CVOL_TARGET_BITS, 4),
        target(CVOL_TARGET_RATIO, 30), target(CVOL_TARGET_PSNR, 80)};
    static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_INT32};
    for (int i = 0; i < 5 * 3 * 2; i += SUPPORT_STRIDE) {
        const kind what = i % 2 ? SMOOTH : STRIPPED;
        if (what == SMOOTH && i / 2 % 3 != i / 6 % 3) /* of a single type */
            continue;
        cvol_grid grid;
        const cvol_type type = what == SMOOTH ? CVOL_INT32 : types[i / 2 % 3];
        void *samples = make(&grid, what, type);
        cvol_compress_options options = asked[i / 6];
        options.has_fill = 1;
        options.effort = i / 2 % 3 == 1 ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
        const cvol_compress_report report = compress(samples, &grid, &options, "masked");
        assert_true(report.target_met);
        free(samples);
    }
}

static void test_lossy_files_never_exceed_lossless(void **state)
{
    (void)state;
    const cvol_compress_options asked[] = {
        target(CVOL_TARGET_RATIO, 5), target(CVOL_TARGET_PSNR, 50), target(CVOL_TARGET_PSNR, 75),
        target(CVOL_TARGET_MAX_ERROR, 1), target(CVOL_TARGET_BITS, 2)};
    for (int k = 0; k < KINDS; k += SUPPORT_STRIDE) {
        cvol_grid grid;
        void *samples = make(&grid, k, k == LABELS || k == SMOOTH ? CVOL_UINT16 : CVOL_UINT8);
        for (int fill = 0; fill < 2; fill++) {
            cvol_compress_options exact = cvol_compress_options_defaults();
            exact.lossless = 1;
            exact.has_fill = fill;
            uint64_t most[2];
            for (exact.effort = CVOL_EFFORT_DEFAULT; exact.effort <= CVOL_EFFORT_FAST;
                 exact.effort++)
                most[exact.effort] = compress(samples, &grid, &exact, "lossless").file_bytes;
            for (int i = (k + fill) % 2; i < (fill ? 2 : 5); i += 2) {
                cvol_compress_options options = asked[i];
                options.has_fill = fill;
                options.effort = i == 1 ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
                options.background = i % 2 && !fill ? CVOL_BACKGROUND_FIND : CVOL_BACKGROUND_NONE;
                const cvol_compress_report report = compress(samples, &grid, &options, "lossy");
                if (report.file_bytes > most[options.effort])
                    fail_msg("kind %d, fill %d, target %d: %llu bytes, lossless %llu", k, fill, i,
                             (unsigned long long)report.file_bytes,
                             (unsigned long long)most[options.effort]);
            }
        }
        free(samples);
    }
}

/* The step that a bound of the error gives can take more bytes in the header than a lossless file.
 */
static void test_constants_never_exceed_lossless(void **state)
{
    (void)state;
    int16_t samples[37 * 22 * 19];
    const cvol_grid grid = cvol_grid_make(37, 22, 19, CVOL_INT16);
    for (int value = -90; value <= 90; value += 30) {
        for (size_t i = 0; i < sizeof samples / sizeof *samples; i++)
            samples[i] = (int16_t)value;
        cvol_compress_options options = target(CVOL_TARGET_MAX_ERROR, 0);
        options.lossless = 1;
        const uint64_t most = compress(samples, &grid, &options, "lossless").file_bytes;
        for (int bound = 1; bound <= 3; bound++) {
            options = target(CVOL_TARGET_MAX_ERROR, bound);
            const cvol_compress_report report = compress(samples, &grid, &options, "lossy");
            if (report.file_bytes > most)
                fail_msg("samples of %d, error %d: %llu bytes, lossless %llu", value, bound,
                         (unsigned long long)report.file_bytes, (unsigned long long)most);
        }
    }
}

/* Floats become lossless before their PSNR is unreachable. */
static void test_floats_fall_back_to_lossless(void **state)
{
    (void)state;
    cvol_grid grid;
    float *samples = make(&grid, SMOOTH, CVOL_FLOAT32);
    for (size_t i = 0; i < COUNT; i++)
        samples[i] += 1e-3f * (float)sin((double)i);
    const cvol_compress_options options = target(CVOL_TARGET_PSNR, 195);
    const cvol_compress_report report = compress(samples, &grid, &options, "floats");
    assert_true(report.lossless && report.target_met);
    free(samples);
}

/* Nearly empty volumes: the lossless file is certainly small enough, so only it is made. */
static void test_sparse_volumes_are_lossless_at_once(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(64, 64, 40, CVOL_UINT8);
    uint8_t *samples = calloc(cvol_grid_samples(&grid), 1);
    assert_non_null(samples);
    random_state r = {11};
    for (int i = 0; i < 300; i++)
        samples[random_below(&r, 64 * 64 * 40)] = (uint8_t)(1 + random_below(&r, 255));
    cvol_compress_options options = cvol_compress_options_defaults();
    for (int fill = 0; fill < 2; fill++) {
        cvol_array *array;
        cvol_compress_report with, without;
        options.has_fill = fill;
        options.lossless = 1;
        assert_int_equal(cvol_compress(context, &array, &without, samples, &grid, &options), 0);
        cvol_array_free(array);
        options.lossless = 0;
        assert_int_equal(cvol_compress(context, &array, &with, samples, &grid, &options), 0);
        cvol_array_free(array);
        assert_true(with.lossless && with.target_met && with.file_bytes == without.file_bytes);
        assert_int_equal(with.trials, without.trials);
    }
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_masked_integers_at_loose_targets),
        cmocka_unit_test(test_lossy_files_never_exceed_lossless),
        cmocka_unit_test(test_constants_never_exceed_lossless),
        cmocka_unit_test(test_floats_fall_back_to_lossless),
        cmocka_unit_test(test_sparse_volumes_are_lossless_at_once),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
