/* cvol_compress_stream: the file is as good as that of samples in memory, its header states the
 * true error, it has the same bytes for any number of threads, and it is either complete or
 * absent. */
#include "test.h"

#include <signal.h>
#include <sys/resource.h>

#include "array/core/array.h"
#include "base/context.h"
#include "codec/rate/compress_stream.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_files.h"
#include "support_samples.h"

/* ---- volumes ---------------------------------------------------------------------------- */

/* A ball in waves, with noise, within -1 .. 1. */
static void *make_volume(const cvol_grid *grid, uint64_t seed, double noise)
{
    void *samples = calloc(cvol_grid_samples(grid), cvol_type_size(grid->type));
    random_state r = {seed};
    size_t i = 0;
    assert_non_null(samples);
    for (size_t z = 0; z < grid->dims[2]; z++)
        for (size_t y = 0; y < grid->dims[1]; y++)
            for (size_t x = 0; x < grid->dims[0]; x++, i++) {
                const double wave = sin(0.2 * (double)x) * cos(0.13 * (double)y + 0.07 * (double)z);
                const double ball = hypot((double)x - 30, (double)y - 24) < 19 ? 0.4 : 0;
                support_store(samples, grid->type, i,
                              (1 - noise) * (0.5 * wave + ball) + noise * random_signed(&r));
            }
    return samples;
}

/* Samples in memory, passed by slab; fails at a given slice, if any. */
typedef struct given {
    const uint8_t *samples;
    size_t slice_bytes, slices, fails_at, read;
} given;

static int read_given(cvol_context *c, void *user, void *samples, size_t first, size_t slices)
{
    given *from = user;
    assert_true(first + slices <= from->slices && slices > 0 && slices <= 68);
    from->read += slices;
    if (from->fails_at < first + slices)
        return cvol_fail(c, CVOL_ERROR_IO, "slice %zu cannot be read", from->fails_at);
    memcpy(samples, from->samples + first * from->slice_bytes, slices * from->slice_bytes);
    return CVOL_OK;
}

static given give(const void *samples, const cvol_grid *grid)
{
    const size_t slices = grid->dims[2];
    return (given){samples, cvol_grid_bytes(grid) / slices, slices, SIZE_MAX, 0};
}

static int stream(cvol_compress_report *report, given *from, const cvol_grid *grid,
                  cvol_target target, double value)
{
    const cvol_sample_source source = {.read = read_given, .user = from};
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = target;
    options.target_value = value;
    options.attributes = "{\"a\": 1}";
    return cvol_compress_stream(context, report, file_path, &source, grid, &options);
}

/* ---- results ---------------------------------------------------------------------------- */

/* The bounds of levels hold: the file alone gives their distance from all subbands. */
static void check_levels(const cvol_array *whole)
{
    const size_t zero[3] = {0, 0, 0}, *dims = whole->grid.dims;
    const size_t count = cvol_grid_samples(&whole->grid);
    float *all = malloc(count * sizeof *all), *coarse = malloc(count * sizeof *coarse);
    assert_non_null(all);
    assert_non_null(coarse);
    check_ok(cvol_array_evaluate_real(context, all, whole, zero, dims));
    for (int level = 1; level < 4; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        cvol_array *array;
        double squares = 0;
        check_ok(cvol_array_read_part(context, &array, NULL, file_path, &part));
        check_ok(cvol_array_evaluate_real(context, coarse, array, zero, dims));
        for (size_t i = 0; i < count; i++)
            squares += pow((double)all[i] - (double)coarse[i], 2);
        const double left = array->error_bound.l2_error - whole->error_bound.l2_error;
        const double rounding = 1e-6 * whole->error_bound.max_abs * sqrt((double)count);
        assert_true(left >= 0.99 * sqrt(squares) - rounding);
        if (dims[0] > 32 && dims[1] > 32 &&
            dims[2] > 32) /* in others a large part lies beyond the faces */
            assert_true(left <= 1.6 * sqrt(squares) + rounding);
        cvol_array_free(array);
    }
    free(all);
    free(coarse);
}

/* Bytes do not depend on threads; the file's figures equal the measured ones. */
static cvol_compress_report compress(const void *samples, const cvol_grid *grid, cvol_target target,
                                     double value)
{
    cvol_compress_report report, again;
    given from = give(samples, grid);
    size_t size, other_size;
    uint64_t file_bytes;
    cvol_array *array;
    cvol_array_info said, found;
    cvol_context_set_threads(context, 3);
    check_ok(stream(&report, &from, grid, target, value));
    unsigned char *bytes = support_read(file_path, &size);
    cvol_context_set_threads(context, 1);
    check_ok(stream(&again, &from, grid, target, value));
    unsigned char *other = support_read(file_path, &other_size);
    assert_int_equal(size, other_size);
    assert_memory_equal(bytes, other, size);
    assert_true(report.psnr_db == again.psnr_db && report.max_error == again.max_error);
    assert_int_equal(report.trials, again.trials);
    free(bytes);
    free(other);
    cvol_context_set_threads(context, 2);
    assert_int_equal(support_folder_count(folder), 1);

    check_ok(cvol_file_verify(context, NULL, file_path));
    check_ok(cvol_array_read(context, &array, file_path, &file_bytes));
    assert_int_equal(file_bytes, size);
    assert_int_equal(report.file_bytes, size);
    assert_true(fabs(report.ratio * (double)size / (double)cvol_grid_bytes(grid) - 1) < 1e-12);
    assert_string_equal(cvol_array_attributes(array), "{\"a\": 1}");
    assert_memory_equal(cvol_array_grid(array)->dims, grid->dims, sizeof grid->dims);
    cvol_array_get_info(&said, array);
    assert_true(said.measured);
    assert_int_equal(said.coefficients, report.coefficients);
    check_levels(array);
    array->error_bound.l2_error = array->error_bound.max_abs =
        1e300; /* so that measuring counts its own */
    check_ok(cvol_array_measure(context, array, samples));
    cvol_array_get_info(&found, array);
    assert_true(report.max_error == found.max_error && said.max_error == found.max_error);
    assert_true(report.psnr_db == said.psnr_db);
    assert_int_equal(report.lossless, found.max_error == 0);
    assert_true(found.max_error == 0 ? isinf(said.psnr_db)
                                     : fabs(said.psnr_db - found.psnr_db) < 1e-9);
    /* Both round evaluated samples to float, perhaps differently. */
    const double last_bit = 0x1p-24 * found.max_abs * sqrt((double)cvol_grid_samples(grid));
    assert_true(fabs(said.l2_error - found.l2_error) <= 1e-9 * found.l2_error + last_bit);
    assert_true(fabs(said.max_abs - found.max_abs) <= 1e-6 * found.max_abs);
    cvol_array_free(array);
    return report;
}

/* The PSNR of the same in memory. */
static double in_memory(const void *samples, const cvol_grid *grid, cvol_target target,
                        double value, double *ratio)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_compress_report report;
    cvol_array *array;
    options.target = target;
    options.target_value = value;
    check_ok(cvol_compress(context, &array, &report, samples, grid, &options));
    cvol_array_free(array);
    *ratio = report.ratio;
    return report.psnr_db;
}

static void ratios_equal_those_in_memory(void **state)
{
    (void)state;
    random_state r = {11};
    /* psnr_and_bits_are_kept: the others */
    for (int t = CVOL_INT8; t <= CVOL_FLOAT64; t += 2 * SUPPORT_STRIDE) {
        const size_t nx = 34 + random_below(&r, 36), ny = 18 + random_below(&r, 24);
        const cvol_grid grid = cvol_grid_make(nx, ny, 50 + random_below(&r, 90), (cvol_type)t);
        void *samples = make_volume(&grid, (uint64_t)t, 0.02);
        const double asked = 8 + 6 * t;
        double ratio;
        const cvol_compress_report report = compress(samples, &grid, CVOL_TARGET_RATIO, asked);
        const double psnr = in_memory(samples, &grid, CVOL_TARGET_RATIO, asked, &ratio);
        print_message("%s %zu x %zu x %zu at 1/%g: 1/%.3f, %.2f dB in %d passes, in memory %.3f, "
                      "%.2f dB\n",
                      cvol_type_name(grid.type), nx, ny, grid.dims[2], asked, report.ratio,
                      report.psnr_db, report.trials, ratio, psnr);
        assert_true(report.ratio >= asked && report.ratio <= 1.02 * asked);
        assert_true(report.target_met);
        assert_true(report.psnr_db > psnr - 0.3);
        free(samples);
    }
}

static void psnr_and_bits_are_kept(void **state)
{
    (void)state;
    random_state r = {12};
    for (int t = CVOL_UINT8; t <= CVOL_FLOAT64; t += 2 * SUPPORT_STRIDE) {
        const cvol_grid grid = cvol_grid_make(40, SUPPORT_SIDE(32), 70 + random_below(&r, 40),
                                              (cvol_type)t);
        void *samples = make_volume(&grid, (uint64_t)t, 0.05);
        const double wanted = 36 + t, bits = 0.3 + 0.1 * t;
        double ratio;
        cvol_compress_report report = compress(samples, &grid, CVOL_TARGET_PSNR, wanted);
        (void)in_memory(samples, &grid, CVOL_TARGET_PSNR, wanted, &ratio);
        print_message("%s at %g dB: %.3f dB, 1/%.2f in %d passes, in memory 1/%.2f\n",
                      cvol_type_name(grid.type), wanted, report.psnr_db, report.ratio,
                      report.trials, ratio);
        assert_true(report.psnr_db >= wanted && report.psnr_db < wanted + 0.2);
        assert_true(report.target_met && report.ratio > 0.96 * ratio);
        report = compress(samples, &grid, CVOL_TARGET_BITS, bits);
        const double got = 8 * (double)report.file_bytes / (double)cvol_grid_samples(&grid);
        assert_true(got <= bits && got >= bits / 1.0201);
        free(samples);
    }
}

/* ---- large volumes ---------------------------------------------------------------------- */

/* Samples that are computed on request and never in memory: a wave with noise, except in the first
 * slices. */
enum { MADE_SIDE = 128, MADE_SLICES = 640 };

#if defined(__SANITIZE_ADDRESS__)
#define HAS_OWN_ALLOCATOR 1 /* which never frees memory */
#else
#define HAS_OWN_ALLOCATOR 0
#endif

static double made_sample(size_t x, size_t y, size_t z)
{
    uint32_t h = (uint32_t)(x + 1) * 0x9E3779B1u ^ (uint32_t)(y + 1) * 0x85EBCA77u ^
                 (uint32_t)(z + 1) * 0xC2B2AE3Du;
    h = (h ^ h >> 15) * 0x2C1B3C6Du;
    const uint32_t noise = z < 100 ? 0 : (h >> 24) % 9;
    const uint32_t wave = (uint32_t)((x * y / 8 + 3 * z) % 256);
    return 40 + noise + (wave < 128 ? wave : 255 - wave);
}

static int read_made(cvol_context *c, void *user, void *samples, size_t first, size_t slices)
{
    double *next = samples;
    size_t *read = user;
    (void)c;
    assert_true(first + slices <= MADE_SLICES && slices > 0 && slices <= 68);
    *read += slices;
    for (size_t z = first; z < first + slices; z++)
        for (size_t y = 0; y < MADE_SIDE; y++)
            for (size_t x = 0; x < MADE_SIDE; x++)
                *next++ = made_sample(x, y, z);
    return CVOL_OK;
}

/* Estimates lead to a step that needs few passes, in less memory than the samples would take. */
static void large_volumes_are_estimated(void **state)
{
    (void)state;
    static const struct {
        cvol_target target;
        double value;
    } asked[] = {{CVOL_TARGET_RATIO, 100}, {CVOL_TARGET_PSNR, 37}};
    const cvol_grid grid = cvol_grid_make(MADE_SIDE, MADE_SIDE, MADE_SLICES, CVOL_FLOAT64);
    size_t read;
    const cvol_sample_source source = {.read = read_made, .user = &read};
    if (HAS_OWN_ALLOCATOR) /* half a minute, without coverage beyond other tests */
        skip();
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        struct rusage before, after;
        options.target = asked[i].target;
        options.target_value = asked[i].value;
        read = 0;
        getrusage(RUSAGE_SELF, &before);
        check_ok(cvol_compress_stream_by(context, &report, file_path, &source, &grid, &options,
                                         &(cvol_stream_work){.estimated = 16}));
        getrusage(RUSAGE_SELF, &after);
        const long grown = after.ru_maxrss - before.ru_maxrss;
        print_message("%g: 1/%.3f, %.3f dB in %d passes, %zu slices read, %ld KiB more\n",
                      asked[i].value, report.ratio, report.psnr_db, report.trials, read, grown);
        assert_true(report.target_met && report.trials <= 3);
        assert_true(read >=
                    2 * MADE_SLICES + MADE_SLICES / 2); /* an estimate reads every other layer */
        if (options.target == CVOL_TARGET_RATIO)
            assert_true(report.ratio >= asked[i].value && report.ratio <= 1.02 * asked[i].value);
        else
            assert_true(report.psnr_db >= asked[i].value && report.psnr_db < asked[i].value + 0.2);
        assert_true(HAS_OWN_ALLOCATOR || grown < (long)(cvol_grid_bytes(&grid) / 4096 * 3));
        check_ok(cvol_file_verify(context, NULL, file_path));
    }
}

static int is_lapped(void)
{
    cvol_array *array;
    check_ok(cvol_array_read(context, &array, file_path, NULL));
    const int lapped = array->lapped;
    cvol_array_free(array);
    return lapped;
}

/* Lapping is useful if neighbours are similar; here blocks of 16 are not. */
static void stream_chooses_lapping(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(100, SUPPORT_SIDE(90), SUPPORT_SIDE(150), CVOL_UINT8);
    uint8_t *samples = make_volume(&grid, 1, 0.01);
    (void)compress(samples, &grid, CVOL_TARGET_PSNR, 40);
    assert_true(is_lapped());
    random_state r = {5};
    uint8_t levels[7 * 6 * 10];
    for (size_t i = 0; i < sizeof levels; i++)
        levels[i] = (uint8_t)random_below(&r, 256);
    for (size_t z = 0, i = 0; z < grid.dims[2]; z++)
        for (size_t y = 0; y < grid.dims[1]; y++)
            for (size_t x = 0; x < 100; x++, i++)
                samples[i] = levels[x / 16 + 7 * (y / 16 + 6 * (z / 16))];
    (void)compress(samples, &grid, CVOL_TARGET_PSNR, 35);
    assert_false(is_lapped());
    free(samples);
}

static void constant_volumes_are_exact(void **state)
{
    (void)state;
    for (int t = CVOL_UINT8; t <= CVOL_FLOAT64; t += 3) {
        const cvol_grid grid = cvol_grid_make(40, SUPPORT_SIDE(30), 130, (cvol_type)t);
        void *samples = calloc(cvol_grid_samples(&grid), cvol_type_size(grid.type));
        assert_non_null(samples);
        for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
            support_store(samples, grid.type, i, 0.5);
        assert_true(compress(samples, &grid, CVOL_TARGET_RATIO, 20).lossless);
        assert_true(compress(samples, &grid, CVOL_TARGET_PSNR, 80).lossless);
        free(samples);
    }
}

static void odd_shapes_work(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{1100, 1, 1}, {1, 1, 200}, {1, 1, 1},     {17, 33, 5},
                                       {16, 16, 64}, {5, 7, 65},  {64, 20, 128}, {31, 8, 130}};
    for (size_t s = 0; s < sizeof shapes / sizeof shapes[0]; s += SUPPORT_STRIDE) {
        const size_t *n = shapes[s];
        const cvol_grid grid = cvol_grid_make(n[0], n[1], n[2], (cvol_type)(1 + s));
        void *samples = make_volume(&grid, s, 0.05);
        const cvol_compress_report report = compress(samples, &grid, CVOL_TARGET_RATIO, 2);
        assert_true(!report.target_met || report.ratio >= 2);
        (void)compress(samples, &grid, CVOL_TARGET_PSNR, 35);
        free(samples);
    }
}

static void lossless_if_smaller(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(64, SUPPORT_SIDE(48), 100, CVOL_UINT8);
    uint8_t *samples = make_volume(&grid, 1, 0);
    const cvol_compress_report report = compress(samples, &grid, CVOL_TARGET_RATIO, 1.01);
    assert_true(report.lossless && report.target_met && report.ratio > 1.03);
    free(samples);
}

/* ---- failures --------------------------------------------------------------------------- */

/* Fails with this message, and leaves an existing file unchanged. */
static void check_failure(int code, int expected, const char *words)
{
    size_t size;
    if (code != expected || !strstr(cvol_context_message(context), words))
        print_message("%d: %s\n", code, cvol_context_message(context));
    assert_int_equal(code, expected);
    assert_non_null(strstr(cvol_context_message(context), words));
    assert_int_equal(support_folder_count(folder), 1);
    unsigned char *bytes = support_read(file_path, &size);
    assert_int_equal(size, 3);
    assert_memory_equal(bytes, "old", 3);
    free(bytes);
}

static void bad_samples_are_reported(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(20, 10, 200, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 1, 0.1);
    given from = give(samples, &grid);
    cvol_compress_report report;
    char place[64];
    support_write_text(file_path, "old");
    samples[20 * 10 * 150 + 33] = NAN;
    snprintf(place, sizeof place, "(13, 1, 150)");
    check_failure(stream(&report, &from, &grid, CVOL_TARGET_RATIO, 10), CVOL_ERROR_DATA, place);
    free(samples);
}

static void failing_sources_leave_no_file(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(70, SUPPORT_SIDE(50), 200, CVOL_INT16);
    void *samples = make_volume(&grid, 1, 0.1);
    given from = give(samples, &grid);
    cvol_compress_report report;
    support_write_text(file_path, "old");
    from.fails_at = 140;
    check_failure(stream(&report, &from, &grid, CVOL_TARGET_RATIO, 10), CVOL_ERROR_IO,
                  "slice 140 cannot be read");
    free(samples);
}

static int cancel_at(void *user, const char *what, double fraction)
{
    int *left = user;
    (void)what;
    assert_true(fraction >= 0 && fraction <= 1);
    return --*left == 0;
}

/* At every possible moment. */
static void cancelling_leaves_no_file(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(40, SUPPORT_SIDE(50), 200, CVOL_UINT8);
    void *samples = make_volume(&grid, 1, 0.1);
    cvol_compress_report report;
    int code = CVOL_ERROR_CANCELLED, moments = 0;
    for (int after = 1; code == CVOL_ERROR_CANCELLED;
         after += SUPPORT_STRIDE + after / 4, moments++) {
        given from = give(samples, &grid);
        int left = after;
        support_write_text(file_path, "old");
        cvol_context_set_progress(context, cancel_at, &left);
        code = stream(&report, &from, &grid, CVOL_TARGET_RATIO, 10);
        if (code)
            check_failure(code, CVOL_ERROR_CANCELLED, "cancelled");
    }
    check_ok(code);
    assert_true(moments > 5);
    cvol_context_set_progress(context, NULL, NULL);
    free(samples);
}

/* Progress of one bar: the same stage while the fraction rises. */
typedef struct bar {
    char what[64];
    double fraction;
    int phases, falls;
} bar;

static int watch(void *user, const char *what, double fraction)
{
    bar *b = user;
    if (strcmp(what, b->what)) {
        snprintf(b->what, sizeof b->what, "%s", what);
        b->phases++;
    } else if (fraction < b->fraction) {
        b->falls++;
    }
    b->fraction = fraction;
    return 0;
}

static void progress_rises(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(70, SUPPORT_SIDE(40), 200, CVOL_UINT8);
    void *samples = make_volume(&grid, 1, 0.1);
    given from = give(samples, &grid);
    cvol_compress_report report;
    bar b = {.what = ""};
    cvol_context_set_progress(context, watch, &b);
    check_ok(stream(&report, &from, &grid, CVOL_TARGET_RATIO, 10));
    cvol_context_set_progress(context, NULL, NULL);
    assert_int_equal(b.phases, 2); /* scanning, compressing */
    assert_int_equal(b.falls, 0);
    free(samples);
}

/* A limit of the file's size simulates a full disk. */
static void full_disks_leave_no_file(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(70, SUPPORT_SIDE(50), 200, CVOL_INT16);
    void *samples = make_volume(&grid, 1, 0.1);
    given from = give(samples, &grid);
    cvol_compress_report report;
    struct rlimit old, small;
    support_write_text(file_path, "old");
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 100000;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const int code = stream(&report, &from, &grid, CVOL_TARGET_RATIO, 3);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    check_failure(code, CVOL_ERROR_IO, "File too large");
    free(samples);
}

static void other_options_are_refused(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(40, 50, 20, CVOL_UINT8);
    uint8_t *samples = make_volume(&grid, 1, 0.1);
    given from = give(samples, &grid);
    cvol_compress_report report;
    support_write_text(file_path, "old");
    check_failure(stream(&report, &from, &grid, CVOL_TARGET_MAX_ERROR, 3), CVOL_ERROR_UNSUPPORTED,
                  "read by slab");
    check_failure(stream(&report, &from, &grid, CVOL_TARGET_RATIO, 0.5), CVOL_ERROR_ARGUMENT,
                  "0.5");
    assert_int_equal(from.read, 0);
    free(samples);
}

/* A slab may not be stored without loss: a PSNR that floats cannot reach is an error. */
static void unreachable_psnr_is_reported(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(40, 50, 20, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 1, 0.5);
    given from = give(samples, &grid);
    cvol_compress_report report;
    support_write_text(file_path, "old");
    check_failure(stream(&report, &from, &grid, CVOL_TARGET_PSNR, 195), CVOL_ERROR_TARGET,
                  "a PSNR of 195 dB cannot be reached for these float32 samples");
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(
            large_volumes_are_estimated), /* first: the peak of memory is that of the process */
        cmocka_unit_test(ratios_equal_those_in_memory),
        cmocka_unit_test(psnr_and_bits_are_kept),
        cmocka_unit_test(stream_chooses_lapping),
        cmocka_unit_test(constant_volumes_are_exact),
        cmocka_unit_test(odd_shapes_work),
        cmocka_unit_test(lossless_if_smaller),
        cmocka_unit_test(bad_samples_are_reported),
        cmocka_unit_test(failing_sources_leave_no_file),
        cmocka_unit_test(cancelling_leaves_no_file),
        cmocka_unit_test(progress_rises),
        cmocka_unit_test(full_disks_leave_no_file),
        cmocka_unit_test(other_options_are_refused),
        cmocka_unit_test(unreachable_psnr_is_reported),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
