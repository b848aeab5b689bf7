/* Bounds, lossless compression and masks, through files: bounds hold for every sample, exact
 * samples are the same to the bit, masked ones too; parts of files, damage, and results of
 * operations. */
#include "test.h"

#include <unistd.h>

#include "array/core/array.h"
#include "base/for_type.h"
#include "codec/container/container.h"
#include "codec/residual/residual_array.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"

static const char *path = "test_modes.cvol";

/* Smooth, with noise; of any type. The caller frees. */
static void *make_samples(cvol_grid *grid, cvol_type type, uint64_t seed)
{
    random_state r = {seed};
    /* At least two bricks in x. */
    *grid = cvol_grid_make(70 + random_below(&r, SUPPORT_STRIDE > 1 ? 3 : 30), SUPPORT_SIDE(66),
                           20 + random_below(&r, SUPPORT_STRIDE > 1 ? 3 : 30), type);
    const size_t *dims = grid->dims, count = cvol_grid_samples(grid);
    void *samples = malloc(count * cvol_type_size(type));
    const double scale = type == CVOL_UINT8 || type == CVOL_INT8 ? 50 : 2000;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0] % dims[1]);
        double value = scale * (1 + 0.6 * sin(0.09 * x) * cos(0.07 * y)) +
                       0.02 * scale * random_signed(&r);
        if (type == CVOL_INT8 || !cvol_type_is_integer(type))
            value -= scale;
#define STORE(t) ((t *)samples)[i] = (t)value
        CVOL_FOR_TYPE(type, STORE);
#undef STORE
    }
    return samples;
}

static double value_of(const void *samples, cvol_type type, size_t i)
{
    double value = 0;
#define LOAD(t) value = (double)((const t *)samples)[i]
    CVOL_FOR_TYPE(type, LOAD);
#undef LOAD
    return value;
}

/* Writes, reads, evaluates; the caller frees both. */
static void *pass_through_file(cvol_context *context, cvol_array *array, cvol_array **read)
{
    const size_t zero[3] = {0, 0, 0};
    void *decoded = malloc(cvol_grid_bytes(&array->grid));
    uint64_t bytes;
    assert_non_null(decoded);
    assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
    if (cvol_file_verify(context, NULL, path) || cvol_array_read(context, read, path, NULL))
        fail_msg("%s", cvol_context_message(context));
    assert_int_equal(cvol_array_evaluate_box(context, decoded, *read, zero, array->grid.dims),
                     CVOL_OK);
    return decoded;
}

/* Compares a box, from a part of the file, with all samples. */
static void check_box(cvol_context *context, const uint8_t *decoded, const cvol_grid *grid,
                      const size_t begin[3], const size_t end[3])
{
    cvol_array *part;
    const size_t size = cvol_type_size(grid->type), line = size * (end[0] - begin[0]);
    uint8_t *box = malloc(line * (end[1] - begin[1]) * (end[2] - begin[2]));
    if (cvol_array_read_box(context, &part, path, begin, end, NULL) ||
        cvol_array_evaluate_box(context, box, part, begin, end))
        fail_msg("type %d, %zu:%zu,%zu:%zu,%zu:%zu: %s", (int)grid->type, begin[0], end[0],
                 begin[1], end[1], begin[2], end[2], cvol_context_message(context));
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            assert_memory_equal(
                box + line * (y - begin[1] + (end[1] - begin[1]) * (z - begin[2])),
                decoded + size * (begin[0] + grid->dims[0] * (y + grid->dims[1] * z)), line);
    free(box);
    cvol_array_free(part);
}

/* Boxes of all sizes: some meet one brick far from its neighbours. */
static void check_boxes(cvol_context *context, const uint8_t *decoded, const cvol_grid *grid)
{
    check_box(context, decoded, grid, (const size_t[3]){3, 17, 5},
              (const size_t[3]){67, grid->dims[1], 18});
    random_state r = {31 + (uint64_t)grid->type};
    for (int k = 0; k < 8; k++) {
        size_t begin[3], end[3];
        for (int a = 0; a < 3; a++) {
            const size_t most = k % 2 ? 6 : grid->dims[a];
            begin[a] = random_below(&r, (uint32_t)grid->dims[a]);
            end[a] = begin[a] + 1 + random_below(&r, (uint32_t)most);
            end[a] = end[a] < grid->dims[a] ? end[a] : grid->dims[a];
        }
        check_box(context, decoded, grid, begin, end);
    }
}

static void check(cvol_context *context, const void *samples, const cvol_grid *grid,
                  const cvol_compress_options *options, double bound)
{
    cvol_array *array, *read;
    cvol_compress_report report;
    if (cvol_compress(context, &array, &report, samples, grid, options))
        fail_msg("type %d, bound %g: %s", (int)grid->type, bound, cvol_context_message(context));
    void *decoded = pass_through_file(context, array, &read);
    double most = 0;
    for (size_t i = 0; i < cvol_grid_samples(grid); i++)
        most = fmax(most,
                    fabs(value_of(samples, grid->type, i) - value_of(decoded, grid->type, i)));
    if (bound == 0)
        assert_memory_equal(decoded, samples, cvol_grid_bytes(grid));
    assert_true(most <= bound);
    assert_true(report.max_error == most && read->max_error == most);
    assert_int_equal(report.lossless, most == 0);
    check_boxes(context, decoded, grid);
    free(decoded);
    cvol_array_free(array);
    cvol_array_free(read);
}

static void test_lossless_of_all_types(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type += SUPPORT_STRIDE) {
        cvol_grid grid;
        void *samples = make_samples(&grid, (cvol_type)type, (uint64_t)type);
        check(context, samples, &grid, &options, 0);
        free(samples);
    }
    for (int block = 8; block <= 32; block += 24) {
        cvol_grid grid;
        void *samples = make_samples(&grid, CVOL_INT16, 99);
        options.block = block;
        check(context, samples, &grid, &options, 0);
        free(samples);
    }
    cvol_context_free(context);
}

/* Lossless compression ignores the target, so any value of it is accepted. */
static void test_lossless_takes_any_target(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const double values[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, -1, 0, 1e300};
    const size_t zero[3] = {0, 0, 0};
    const cvol_grid grid = cvol_grid_make(5, 4, 3, CVOL_UINT8);
    uint8_t samples[60], decoded[60];
    for (int k = 0; k < 60; k++)
        samples[k] = (uint8_t)(k * k);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    for (int target = CVOL_TARGET_RATIO; target <= CVOL_TARGET_BITS; target++)
        for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
            cvol_array *array;
            cvol_compress_report report;
            if ((i + (size_t)target) % SUPPORT_STRIDE)
                continue;
            options.target = (cvol_target)target;
            options.target_value = values[i];
            if (cvol_compress(context, &array, &report, samples, &grid, &options))
                fail_msg("target %d, %g: %s", target, values[i], cvol_context_message(context));
            assert_true(report.lossless && report.target_met);
            assert_int_equal(cvol_array_evaluate_box(context, decoded, array, zero, grid.dims),
                             CVOL_OK);
            assert_memory_equal(decoded, samples, sizeof samples);
            cvol_array_free(array);
        }
    cvol_context_free(context);
}

static void test_bounds_of_all_types(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_MAX_ERROR;
    for (int i = 0; i < 10; i += SUPPORT_STRIDE) {
        static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_UINT16, CVOL_FLOAT32,
                                          CVOL_FLOAT64};
        cvol_grid grid;
        const cvol_type type = types[i % 5];
        void *samples = make_samples(&grid, type, (uint64_t)i);
        options.target_value = pow(10, 2 - i / 2.0) * (type == CVOL_UINT8 ? 0.1 : 1);
        check(context, samples, &grid, &options, options.target_value);
        free(samples);
    }
    cvol_context_free(context);
}

static void test_psnr_and_bound_both_hold(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_grid grid;
    void *samples = make_samples(&grid, CVOL_FLOAT32, 5);
    options.target = CVOL_TARGET_PSNR;
    for (int i = 0; i < 2; i++) {
        cvol_array *array;
        cvol_compress_report report;
        options.target_value = i ? 70 : 35;
        options.max_error = i ? 100 : 5;
        assert_int_equal(cvol_compress(context, &array, &report, samples, &grid, &options),
                         CVOL_OK);
        assert_true(report.psnr_db >= options.target_value);
        assert_true(report.max_error <= options.max_error);
        check(context, samples, &grid, &options, report.max_error);
        cvol_array_free(array);
    }
    free(samples);
    cvol_context_free(context);
}

/* Lossless compression, which such a volume would be given first, refuses the bits of its NaN. */
static void test_many_kinds_of_nan(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(64, 64, 40, CVOL_FLOAT32);
    uint32_t *samples = calloc(cvol_grid_samples(&grid), sizeof *samples);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    assert_non_null(samples);
    for (uint32_t i = 0; i < 9; i++)
        samples[1000 * i] = 0x7fc00000 + i;
    options.has_fill = 1;
    options.fill = (double)NAN;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                     CVOL_ERROR_DATA);
    assert_null(array);
    free(samples);
    cvol_context_free(context);
}

/* Noisy integers of few values: rounding hides most of a change of the step. */
static void test_psnr_of_few_integers_is_reached(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(36, 21, 17, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid);
    int16_t *samples = malloc(count * sizeof *samples);
    assert_non_null(samples);
    for (int i = 0; i < 4; i++) {
        random_state r = {7};
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        cvol_array *array;
        for (size_t k = 0; k < count; k++)
            samples[k] = (int16_t)(90 +
                                   (i & 1 ? 40 : 10) * sin(0.21 * (double)(k % 36)) *
                                       cos(0.17 * (double)(k / 36 % 21) + 0.1 * (double)(k / 756)) +
                                   random_signed(&r));
        options.target = CVOL_TARGET_PSNR;
        options.target_value = i & 1 ? 40 : 30;
        options.max_error = i & 2 ? 15 : 6;
        assert_int_equal(cvol_compress(context, &array, &report, samples, &grid, &options),
                         CVOL_OK);
        cvol_array *read;
        int16_t *decoded = pass_through_file(context, array, &read);
        double most = 0, squares = 0;
        int least = INT16_MAX, largest = INT16_MIN;
        for (size_t k = 0; k < count; k++) {
            const int off = samples[k] - decoded[k];
            most = fmax(most, abs(off));
            squares += (double)off * off;
            least = samples[k] < least ? samples[k] : least;
            largest = samples[k] > largest ? samples[k] : largest;
        }
        assert_true(20 * log10((largest - least) / sqrt(squares / (double)count)) >=
                    options.target_value);
        assert_true(most <= options.max_error && report.ratio > 2);
        free(decoded);
        cvol_array_free(read);
        cvol_array_free(array);
    }
    free(samples);
    cvol_context_free(context);
}

/* All modes with terms below a residual, with and without a mask. */
static void test_blocks_without_overlap_hold_with_all_modes(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_grid grid;
    for (int kind = 0; kind < 8; kind += SUPPORT_STRIDE) {
        const int masked = kind >= 4;
        uint8_t *samples = make_samples(&grid, CVOL_UINT8, 5);
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        cvol_array *array;
        if (kind % 4 == 0) {
            options.lossless = 1;
        } else if (kind % 4 == 1) {
            options.target = CVOL_TARGET_MAX_ERROR;
            options.target_value = 3;
        } else if (kind % 4 == 2) {
            options.target = CVOL_TARGET_PSNR;
            options.target_value = 45;
            options.max_error = 3;
        } else { /* lossless takes less */
            options.target_value = 1.1;
        }
        for (size_t i = 0; masked && i < cvol_grid_samples(&grid) / 3; i++)
            samples[i] = 0;
        options.has_fill = masked;
        options.lapped = 0;
        if (cvol_compress(context, &array, &report, samples, &grid, &options))
            fail_msg("kind %d: %s", kind, cvol_context_message(context));
        assert_false(array->lapped);
        cvol_array_free(array);
        check(context, samples, &grid, &options, kind % 4 == 1 || kind % 4 == 2 ? 3 : 0);
        free(samples);
    }
    cvol_context_free(context);
}

/* 1e35 in a ball, NaN in a corner; they are refused unless the options mask them. */
static float *make_holes(cvol_grid *grid, int with_nan)
{
    float *samples = make_samples(grid, CVOL_FLOAT32, 11);
    for (size_t i = 0; i < cvol_grid_samples(grid); i++) {
        const double x = (double)(i % grid->dims[0]) - 40,
                     y = (double)(i / grid->dims[0] % grid->dims[1]) - 30,
                     z = (double)(i / grid->dims[0] / grid->dims[1]) - 10;
        if (x * x + y * y + z * z < 300)
            samples[i] = 1e35f;
        else if (with_nan && x + y + z < -60)
            samples[i] = (float)NAN;
    }
    return samples;
}

static void test_masked_samples_round_trip(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (int i = 0; i < 6; i++) {
        cvol_grid grid;
        const int lossless = i == 3 || i == 4, to_psnr = i == 0 || i == 5;
        float *samples = make_holes(&grid, i >= 3); /* with NaN */
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        cvol_array *array, *read;
        options.has_fill = 1;
        options.fill = 1e35;
        options.lossless = lossless;
        options.target = to_psnr  ? CVOL_TARGET_PSNR
                         : i == 1 ? CVOL_TARGET_MAX_ERROR
                                  : CVOL_TARGET_RATIO;
        options.target_value = to_psnr ? 50 : i == 1 ? 2 : 40;
        if (i == 4)
            options.has_fill = 0; /* then 1e35 is an ordinary number */
        if (cvol_compress(context, &array, &report, samples, &grid, &options))
            fail_msg("%d: %s", i, cvol_context_message(context));
        float *decoded = pass_through_file(context, array, &read);
        check_boxes(context, (const uint8_t *)decoded, &grid);
        double squares = 0, count = 0;
        for (size_t k = 0; k < cvol_grid_samples(&grid); k++) {
            const int masked = !(samples[k] < 1e34f);
            if (masked || lossless)
                assert_memory_equal(&decoded[k], &samples[k], 4);
            else
                assert_true(fabs((double)decoded[k] - (double)samples[k]) <= report.max_error);
            if (!masked) {
                squares += pow((double)decoded[k] - (double)samples[k], 2);
                count++;
            }
        }
        assert_int_equal(report.lossless, lossless);
        assert_true(i == 4 || read->error_bound.value_max < 4000);
        assert_true(i != 1 || report.max_error <= 2);
        assert_true(i != 2 || (report.ratio >= 40 && report.ratio < 41.5));
        if (to_psnr)
            assert_true(
                report.psnr_db >= 50 &&
                fabs(10 * log10(pow(read->error_bound.value_max - read->error_bound.value_min, 2) *
                                count / squares) -
                     report.psnr_db) < 1e-6);
        free(decoded);
        free(samples);
        cvol_array_free(array);
        cvol_array_free(read);
    }
    cvol_context_free(context);
}

static void test_nonfinite_samples_are_refused_or_masked(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_grid grid;
    float *samples = make_holes(&grid, 1);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_true(cvol_mask_is_void(array->mask)); /* NaN have no value */
    cvol_array_free(array);
    samples[77] = (float)INFINITY;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                     CVOL_ERROR_DATA);
    options.has_fill = 1;
    options.fill = 1e35; /* and NaN and infinity */
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_int_equal(cvol_mask_fills(array->mask)->count, 3);
    cvol_array_free(array);
    options.fill = (double)NAN;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 40;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    cvol_array_free(array);
    for (uint32_t i = 0; i < 8; i++) { /* too many kinds */
        const uint32_t bits = 0x7fc00000 + i;
        memcpy(&samples[i], &bits, 4);
    }
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                     CVOL_ERROR_DATA);
    for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
        samples[i] = (float)NAN;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    cvol_array *read;
    float *decoded = pass_through_file(context, array, &read);
    assert_memory_equal(decoded, samples, cvol_grid_bytes(&grid));
    cvol_array_free(array);
    cvol_array_free(read);
    free(decoded);
    free(samples);
    cvol_context_free(context);
}

/* Exact copies at a large distance: no transform exploits them. */
static void test_repeated_samples_are_packed(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_grid grid = cvol_grid_make(40, 30, 40, CVOL_FLOAT32);
    const size_t half = 40 * 30 * 10, count = cvol_grid_samples(&grid);
    float *samples = malloc(count * sizeof *samples);
    random_state r = {3};
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array, *read;
    options.lossless = 1;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = i < half ? (float)random_signed(&r) : samples[i - half];
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_int_equal(cvol_residual_of(array)->kind, CVOL_RESIDUAL_PACKED);
    float *decoded = pass_through_file(context, array, &read);
    assert_memory_equal(decoded, samples, cvol_grid_bytes(&grid));
    cvol_array_free(array);
    cvol_array_free(read);
    free(decoded);
    free(samples);
    cvol_context_free(context);
}

static void test_levels_and_results_have_no_residual(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_grid grid;
    void *samples = make_samples(&grid, CVOL_INT16, 8);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array, *read, *twice;
    options.lossless = 1;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    for (int level = 0; level < 4; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        assert_int_equal(cvol_array_read_part(context, &read, NULL, path, &part), CVOL_OK);
        assert_true((read->residual != NULL) == (level == 0));
        cvol_array_free(read);
    }
    assert_int_equal(cvol_array_scale(context, &twice, 2, array, 1), CVOL_OK);
    assert_null(twice->residual);
    cvol_array_free(twice);
    cvol_array_free(array);
    free(samples);
    cvol_context_free(context);
}

/* An array that was read is written again: with the residual as it was coded. */
static void test_residuals_are_written_again(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    for (int type = CVOL_INT16; type <= CVOL_FLOAT32; type += CVOL_FLOAT32 - CVOL_INT16) {
        cvol_grid grid;
        void *samples = make_samples(&grid, (cvol_type)type, 4);
        cvol_array *array, *read, *again;
        assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
        free(pass_through_file(context, array, &read));
        void *decoded = pass_through_file(context, read, &again);
        assert_memory_equal(decoded, samples, cvol_grid_bytes(&grid));
        cvol_array_free(array);
        cvol_array_free(read);
        cvol_array_free(again);
        free(decoded);
        free(samples);
    }
    cvol_context_free(context);
}

/* One changed byte of any section: refused, or without effect. */
static void test_damaged_files(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_grid grid;
    float *samples = make_holes(&grid, 1);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    uint64_t bytes;
    options.lossless = options.has_fill = 1;
    options.fill = 1e35;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_int_equal(cvol_array_write(context, array, path, &bytes), CVOL_OK);
    cvol_array_free(array);
    uint8_t *file = malloc(bytes);
    FILE *in = fopen(path, "rb");
    assert_true(file && in && fread(file, 1, bytes, in) == bytes);
    fclose(in);
    random_state r = {1};
    for (int i = 0; i < 300; i += SUPPORT_DAMAGE) {
        const size_t at = i < 150 ? (size_t)i * 9 : random_below(&r, (uint32_t)bytes);
        file[at] ^= 16;
        const int code = cvol_container_read(context, &array, file, bytes, "damaged");
        if (!code)
            fail_msg("byte %zu may be anything", at);
        file[at] ^= 16;
        const size_t cut = random_below(&r, (uint32_t)bytes);
        assert_true(cvol_container_read(context, &array, file, cut, "cut") != CVOL_OK);
    }
    free(file);
    free(samples);
    cvol_context_free(context);
}

static int clean(void **state)
{
    (void)state;
    unlink(path);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lossless_of_all_types),
        cmocka_unit_test(test_lossless_takes_any_target),
        cmocka_unit_test(test_bounds_of_all_types),
        cmocka_unit_test(test_psnr_and_bound_both_hold),
        cmocka_unit_test(test_psnr_of_few_integers_is_reached),
        cmocka_unit_test(test_many_kinds_of_nan),
        cmocka_unit_test(test_blocks_without_overlap_hold_with_all_modes),
        cmocka_unit_test(test_masked_samples_round_trip),
        cmocka_unit_test(test_residuals_are_written_again),
        cmocka_unit_test(test_nonfinite_samples_are_refused_or_masked),
        cmocka_unit_test(test_repeated_samples_are_packed),
        cmocka_unit_test(test_levels_and_results_have_no_residual),
        cmocka_unit_test(test_damaged_files),
    };
    return cmocka_run_group_tests(tests, NULL, clean);
}
