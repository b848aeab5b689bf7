/* Volumes of labels through files: the same to the bit for every integer type and shape, parts of
 * files too; files take fewer bytes than with a residual; damage is reported or harmless. */
#include "test.h"

#include <sys/stat.h>

#include <unistd.h>

#include "array/core/array.h"
#include "base/for_type.h"
#include "codec/residual/residual_array.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"

static const char *path = "test_label_file.cvol";

/* Regions of the nearest of `count` seeds, within a ball; outside is the smallest id. Ids are
 * spread over the range of the type. The caller frees. */
static void *make_labels(const cvol_grid *grid, int count, uint64_t seed)
{
    enum { SEEDS_MAX = 40 };
    random_state r = {seed};
    double place[SEEDS_MAX][3], id[SEEDS_MAX], lo, hi;
    const size_t *dims = grid->dims;
    void *samples = malloc(cvol_grid_bytes(grid));
    assert_non_null(samples);
    cvol_type_get_range(&lo, &hi, grid->type);
    for (int i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++)
            place[i][a] = random_below(&r, (uint32_t)dims[a]);
        id[i] = i ? floor(lo + (hi - lo) * (double)random_below(&r, 1 << 30) / (1 << 30)) : 0;
    }
    for (size_t k = 0; k < cvol_grid_samples(grid); k++) {
        const double at[3] = {(double)(k % dims[0]), (double)(k / dims[0] % dims[1]),
                              (double)(k / dims[0] / dims[1])};
        double least = INFINITY, value = 0;
        for (int i = 0; i < count; i++) {
            double squares = 0;
            for (int a = 0; a < 3; a++)
                squares += (at[a] - place[i][a]) * (at[a] - place[i][a]);
            value = squares < least ? id[i] : value;
            least = fmin(least, squares);
        }
        if (count > 1 && fabs(2 * at[0] - (double)dims[0]) > 0.8 * (double)dims[0])
            value = lo;
#define STORE(t) ((t *)samples)[k] = (t)value
        CVOL_FOR_TYPE(grid->type, STORE);
#undef STORE
    }
    return samples;
}

static cvol_array *compress(cvol_context *context, const void *samples, const cvol_grid *grid,
                            const int brick[3])
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_compress_report report;
    cvol_array *array;
    options.lossless = 1;
    for (int a = 0; a < 3 && brick; a++)
        options.brick[a] = brick[a];
    if (cvol_compress(context, &array, &report, samples, grid, &options))
        fail_msg("type %d, %zu x %zu x %zu: %s", (int)grid->type, grid->dims[0], grid->dims[1],
                 grid->dims[2], cvol_context_message(context));
    assert_true(report.lossless && report.max_error == 0);
    return array;
}

static cvol_residual_kind kind_of(const cvol_array *array)
{
    const cvol_residual_data *residual = cvol_residual_of(array);
    return residual ? residual->kind : CVOL_RESIDUAL_NOT;
}

/* Writes, reads, compares; then a box of the file. Returns the bytes of the file. */
static uint64_t check(cvol_context *context, cvol_array *array, const void *samples)
{
    const cvol_grid *grid = &array->grid;
    const size_t zero[3] = {0, 0, 0}, size = cvol_type_size(grid->type);
    cvol_array *read, *part;
    uint64_t bytes;
    uint8_t *decoded = malloc(cvol_grid_bytes(grid));
    assert_non_null(decoded);
    assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
    if (cvol_file_verify(context, NULL, path) || cvol_array_read(context, &read, path, NULL))
        fail_msg("%s", cvol_context_message(context));
    assert_int_equal(kind_of(read), kind_of(array));
    assert_int_equal(cvol_array_evaluate_box(context, decoded, read, zero, grid->dims), CVOL_OK);
    assert_memory_equal(decoded, samples, cvol_grid_bytes(grid));
    assert_true(read->measured && read->max_error == 0);
    cvol_array_free(read);

    size_t begin[3], end[3];
    for (int a = 0; a < 3; a++) {
        begin[a] = grid->dims[a] / 3;
        end[a] = grid->dims[a] - grid->dims[a] / 5;
    }
    const size_t line = size * (end[0] - begin[0]);
    assert_int_equal(cvol_array_read_box(context, &part, path, begin, end, NULL), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_box(context, decoded, part, begin, end), CVOL_OK);
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            assert_memory_equal(decoded +
                                    line * (y - begin[1] + (end[1] - begin[1]) * (z - begin[2])),
                                (const uint8_t *)samples +
                                    size * (begin[0] + grid->dims[0] * (y + grid->dims[1] * z)),
                                line);
    cvol_array_free(part);
    free(decoded);
    return bytes;
}

static void test_types(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    static const int small[3] = {32, 48, 16};
    for (int type = CVOL_UINT8; type <= CVOL_INT32; type++) {
        const cvol_grid grid = cvol_grid_make(90, SUPPORT_SIDE(70), SUPPORT_SIDE(40),
                                              (cvol_type)type);
        void *samples = make_labels(&grid, 20, (uint64_t)type);
        cvol_array *array = compress(context, samples, &grid, type % 2 ? NULL : small);
        assert_int_equal(kind_of(array), CVOL_RESIDUAL_LABELS);
        const uint64_t bytes = check(context, array, samples);
        if (test_verbose())
            printf("type %d: %llu bytes\n", type, (unsigned long long)bytes);
        assert_true(bytes < 6000);
        cvol_array_free(array);
        free(samples);
    }
    unlink(path);
    cvol_context_free(context);
}

static void test_shapes(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{1, 130, 90}, {130, 1, 90}, {130, 90, 1},
                                       {300, 1, 1},  {1, 1, 500},  {65, 64, 64},
                                       {1, 1, 1},    {7, 3, 5},    {129, 65, 17}};
    cvol_context *context = cvol_context_create();
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        /* 1: one value */
        for (int count = 1 + 4 * (int)(s % SUPPORT_STRIDE); count <= 9;
             count += 4 * SUPPORT_STRIDE) {
            const cvol_grid grid = cvol_grid_make(shapes[s][0], shapes[s][1], shapes[s][2],
                                                  s % 2 ? CVOL_INT32 : CVOL_UINT16);
            void *samples = make_labels(&grid, count, s);
            cvol_array *array = compress(context, samples, &grid, NULL);
            check(context, array, samples);
            cvol_array_free(array);
            free(samples);
        }
    unlink(path);
    cvol_context_free(context);
}

/* Noise is no volume of labels; the file has a residual or packed samples. */
static void test_noise(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(40, SUPPORT_SIDE(30), 20, CVOL_UINT32);
    uint32_t *samples = malloc(cvol_grid_bytes(&grid));
    assert_non_null(samples);
    for (int labels = 2; labels <= 200; labels *= 10) {
        random_state r = {(uint64_t)labels};
        for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
            samples[i] = 90000001u * random_below(&r, (uint32_t)labels);
        cvol_array *array = compress(context, samples, &grid, NULL);
        assert_int_not_equal(kind_of(array), CVOL_RESIDUAL_LABELS);
        check(context, array, samples);
        cvol_array_free(array);
    }
    free(samples);
    unlink(path);
    cvol_context_free(context);
}

/* A target that allows more than labels take gives a lossless file. */
static void test_lossy_files_never_exceed_labels(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(90, SUPPORT_SIDE(80), SUPPORT_SIDE(70), CVOL_UINT16);
    void *samples = make_labels(&grid, 20, 9);
    cvol_array *array = compress(context, samples, &grid, NULL);
    const double bytes = (double)check(context, array, samples);
    cvol_array_free(array);
    for (int i = 0; i < 3; i++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        options.target = i < 2 ? CVOL_TARGET_RATIO : CVOL_TARGET_PSNR;
        options.target_value = i == 0   ? (double)cvol_grid_bytes(&grid) / (1.8 * bytes)
                               : i == 1 ? (double)cvol_grid_bytes(&grid) / (1.1 * bytes)
                                        : 45;
        assert_int_equal(cvol_compress(context, &array, &report, samples, &grid, &options),
                         CVOL_OK);
        assert_true(report.lossless && (double)report.file_bytes <= bytes);
        check(context, array, samples);
        cvol_array_free(array);
    }
    free(samples);
    unlink(path);
    cvol_context_free(context);
}

/* Labels are not taken where terms or packed samples take fewer bytes: faces of sub-blocks of 8, a
 * ramp. */
static void test_others_may_be_smaller(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(96, 96, 96, CVOL_UINT8); /* the figures need this size */
    uint8_t *samples = malloc(cvol_grid_bytes(&grid));
    assert_non_null(samples);
    for (int ramp = 0; ramp < 2; ramp++) {
        for (size_t z = 0, i = 0; z < 96; z++)
            for (size_t y = 0; y < 96; y++)
                for (size_t x = 0; x < 96; x++, i++)
                    samples[i] = (uint8_t)(ramp ? (2 * x + y + z) / 10
                                                : (x / 8 + y / 8 + z / 8) % 2);
        cvol_array *array = compress(context, samples, &grid, NULL);
        assert_int_equal(kind_of(array), ramp ? CVOL_RESIDUAL_PACKED : CVOL_RESIDUAL_EXACT);
        assert_true(check(context, array, samples) < (ramp ? 4000 : 2000));
        cvol_array_free(array);
    }
    free(samples);
    unlink(path);
    cvol_context_free(context);
}

/* Labels have no coarse levels: each is the whole. In the file of a pack, of sections, and in a
 * box.
 */
static void test_levels(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(80, 70, 66, CVOL_UINT8);
    const size_t zero[3] = {0, 0, 0};
    uint8_t *samples = make_labels(&grid, 8, 3), *decoded = malloc(cvol_grid_bytes(&grid));
    cvol_array *array = compress(context, samples, &grid, NULL), *read;
    assert_int_equal(kind_of(array), CVOL_RESIDUAL_LABELS);
    assert_true(array->step > 2 * (array->error_bound.value_max - array->error_bound.value_min) -
                                  1); /* too coarse to be taken for the samples */
    check(context, array, samples);
    for (int level = 1; level <= 3; level++) {
        const size_t begin[3] = {3, 5, 7}, end[3] = {70, 66, 40};
        for (int is_box = 0; is_box <= 1; is_box++) {
            cvol_file_part part = {.size = sizeof part, .level = level};
            cvol_file_report report;
            cvol_grid box = grid;
            if (is_box) {
                part.begin = begin;
                part.end = end;
                box = cvol_grid_box(&grid, begin, end);
            }
            assert_int_equal(cvol_array_read_part(context, &read, &report, path, &part), CVOL_OK);
            assert_true(report.level == 0 && !report.residual_missing);
            assert_int_equal(cvol_array_evaluate_box(context, decoded, read, is_box ? begin : zero,
                                                     is_box ? end : grid.dims),
                             CVOL_OK);
            const size_t *from = is_box ? begin : zero;
            for (size_t i = 0; i < cvol_grid_samples(&box); i++) {
                const size_t x = from[0] + i % box.dims[0],
                             y = from[1] + i / box.dims[0] % box.dims[1],
                             z = from[2] + i / box.dims[0] / box.dims[1];
                assert_int_equal(decoded[i], samples[x + grid.dims[0] * (y + grid.dims[1] * z)]);
            }
            cvol_array_free(read);
        }
    }
    const uint8_t levels[8] = {0, 1, 2, 3, 3, 2, 1, 0};
    const cvol_file_part of_bricks = {
        .size = sizeof of_bricks, .brick_levels = levels, .brick_count = 8};
    assert_int_equal(cvol_array_read_part(context, &read, NULL, path, &of_bricks),
                     CVOL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(cvol_context_message(context), "labels, whose bricks have no levels"));
    /* A file that ends early has no level that is whole. */
    struct stat facts;
    assert_int_equal(stat(path, &facts), 0);
    for (int tenths = 3; tenths <= 9; tenths += 2) {
        const cvol_file_part part = {.size = sizeof part, .cut = 1};
        check(context, array, samples); /* writes the file */
        assert_int_equal(truncate(path, facts.st_size * tenths / 10), 0);
        assert_int_equal(cvol_array_read_part(context, &read, NULL, path, &part),
                         CVOL_ERROR_CORRUPT);
        assert_null(strstr(cvol_context_message(context), "level"));
    }
    cvol_array_free(array);
    free(samples);
    free(decoded);
    unlink(path);
    cvol_context_free(context);
}

/* Bytes of labels that are damaged but have correct checksums: an error that names the brick, or
 * labels within the range. */
static void test_damage(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(70, 66, 20, CVOL_INT16);
    const size_t zero[3] = {0, 0, 0};
    int16_t *samples = make_labels(&grid, 30, 5), *decoded = malloc(cvol_grid_bytes(&grid));
    cvol_array *array = compress(context, samples, &grid, NULL), *read;
    cvol_residual_data *labels = (cvol_residual_data *)array->residual;
    uint64_t bytes;
    int refused = 0;
    random_state r = {1};
    assert_int_equal(kind_of(array), CVOL_RESIDUAL_LABELS);
    for (int i = 0; i < 60; i += SUPPORT_STRIDE) {
        const size_t at = random_below(&r, (uint32_t)labels->data.size);
        const uint8_t bit = (uint8_t)(1u << random_below(&r, 8));
        labels->data.data[at] ^= bit;
        assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
        labels->data.data[at] ^= bit;
        assert_int_equal(cvol_array_read(context, &read, path, NULL), CVOL_OK);
        const int code = cvol_array_evaluate_box(context, decoded, read, zero, grid.dims);
        assert_true(code == CVOL_OK || code == CVOL_ERROR_CORRUPT);
        if (code) {
            assert_non_null(strstr(cvol_context_message(context), "the labels of brick"));
            refused++;
        }
        for (size_t k = 0; !code && k < cvol_grid_samples(&grid); k++)
            assert_true(decoded[k] >= array->error_bound.value_min &&
                        decoded[k] <= array->error_bound.value_max);
        cvol_array_free(read);
    }
    assert_true(refused > 5);
    /* A usual label that is none. */
    const double usual = labels->rule.quantum;
    for (int i = 0; i < 3; i++) {
        labels->rule.quantum = i == 0 ? 0.5 : i == 1 ? 40000 : (double)NAN;
        assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
        assert_int_equal(cvol_array_read(context, &read, path, NULL), CVOL_ERROR_CORRUPT);
        assert_non_null(strstr(cvol_context_message(context), "quantum"));
    }
    labels->rule.quantum = usual;
    check(context, array, samples);
    cvol_array_free(array);
    free(samples);
    free(decoded);
    unlink(path);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_types),
                                       cmocka_unit_test(test_shapes),
                                       cmocka_unit_test(test_noise),
                                       cmocka_unit_test(test_others_may_be_smaller),
                                       cmocka_unit_test(test_lossy_files_never_exceed_labels),
                                       cmocka_unit_test(test_levels),
                                       cmocka_unit_test(test_damage)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
