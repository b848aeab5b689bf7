/* Exact files, and files with a bound, that end early: the remaining part reports its level. */
#include "test.h"

#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"

enum { NX = 33, NY = 20, NZ = 18, COUNT = NX * NY * NZ, CUTS = 24 };

typedef struct exact_case {
    const char *name;
    cvol_type type;
    int labels, lossless, fill;
    double max_error;
} exact_case;

static const exact_case cases[] = {{"lossless", CVOL_UINT8, 0, 1, 0, 0},
                                   {"lossless floats", CVOL_FLOAT32, 0, 1, 0, 0},
                                   {"labels", CVOL_UINT16, 1, 1, 0, 0},
                                   {"a bound", CVOL_INT16, 0, 0, 0, 3},
                                   {"a bound of floats", CVOL_FLOAT32, 0, 0, 0, 0.5},
                                   {"lossless, with a fill", CVOL_UINT8, 0, 1, 1, 0}};

static void *make_samples(const exact_case *c)
{
    random_state r = {2};
    void *samples = malloc(COUNT * cvol_type_size(c->type));
    assert_non_null(samples);
    for (int i = 0; i < COUNT; i++) {
        const int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        const double wave = 60 + 50 * sin(x / 5.0) * cos(y / 4.0 + z / 7.0);
        double v = c->labels ? 100 * (x / 8) + 7 * (y / 7) + z / 9
                             : wave + (double)random_below(&r, 1000) / 50;
        v = c->fill && z < 4 ? 0 : v + 1;
        if (c->type == CVOL_UINT8)
            ((uint8_t *)samples)[i] = (uint8_t)v;
        else if (c->type == CVOL_FLOAT32)
            ((float *)samples)[i] = (float)v;
        else
            ((uint16_t *)samples)[i] = (uint16_t)v;
    }
    return samples;
}

static double value_at(const void *samples, cvol_type type, int i)
{
    return type == CVOL_UINT8     ? ((const uint8_t *)samples)[i]
           : type == CVOL_FLOAT32 ? (double)((const float *)samples)[i]
                                  : ((const uint16_t *)samples)[i];
}

/* An array's own error bounds hold for its samples; returns the largest error. */
static double expect_true_figures(const cvol_array *array, const void *samples, cvol_type type)
{
    const size_t begin[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
    void *decoded = malloc(COUNT * cvol_type_size(type));
    double most = 0, squares = 0;
    cvol_array_info info;
    assert_non_null(decoded);
    check_ok(cvol_array_evaluate_box(context, decoded, array, begin, end));
    for (int i = 0; i < COUNT; i++) {
        const double off = fabs(value_at(decoded, type, i) - value_at(samples, type, i));
        most = fmax(most, off);
        squares += off * off;
    }
    free(decoded);
    cvol_array_get_info(&info, array);
    const double span = info.value_max - info.value_min;
    const double psnr = squares > 0 ? 10 * log10(span * span * COUNT / squares) : (double)INFINITY;
    if (most > info.max_error * (1 + 1e-9) || psnr < info.psnr_db - 1e-6)
        fail_msg("off by %g and %g dB, said %g and %g dB", most, psnr, info.max_error,
                 info.psnr_db);
    return most;
}

/* The offset of a section, in bytes from the file's start. */
static size_t find_section(const uint8_t *data, size_t size, const char *tag)
{
    cvol_file_layout layout;
    check_ok(cvol_layout_walk(context, &layout, data, size, "f"));
    for (int i = 0; i < layout.section_count; i++)
        if (!strcmp(layout.sections[i].tag, tag))
            return (size_t)layout.sections[i].offset;
    fail_msg("there is no %s", tag);
    return 0;
}

static void expect_cut(const exact_case *c, const uint8_t *data, size_t cut, size_t residual,
                       size_t end, const void *samples)
{
    uint8_t *exact = malloc(cut); /* so that reading beyond it is detected */
    cvol_array *array;
    cvol_array_info info;
    cvol_file_report report;
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .cut = 1};
    assert_non_null(exact);
    memcpy(exact, data, cut);
    assert_int_equal(cvol_container_read(context, &array, exact, cut, "f"), CVOL_ERROR_CORRUPT);
    const int said = strstr(cvol_context_message(context), "without the residual") != NULL;
    check_ok(cvol_container_read_part(context, &array, &report, exact, cut, &part, "f"));
    const double most = expect_true_figures(array, samples, c->type);
    cvol_array_get_info(&info, array);
    const int missing = cut >= residual && cut < end;
    assert_true(report.cut);
    assert_int_equal(report.residual_missing, missing);
    assert_int_equal(said, missing);
    if (cut < end && (info.measured || info.max_error <= c->max_error))
        fail_msg("%s, cut at %zu: passes for exact (off by %g)", c->name, cut, most);
    assert_true(cut < end || (info.measured && most <= c->max_error));
    cvol_array_free(array);
    free(exact);
}

static void test_cut_files_report_it(void **state)
{
    (void)state;
    cvol_context_set_threads(context, 1);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const exact_case *c = &cases[k];
        void *samples = make_samples(c), *file;
        const cvol_grid grid = cvol_grid_make(NX, NY, NZ, c->type);
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *array;
        size_t size;
        options.lossless = c->lossless;
        options.has_fill = c->fill;
        if (!c->lossless) {
            options.target = CVOL_TARGET_MAX_ERROR;
            options.target_value = c->max_error;
        }
        check_ok(cvol_compress(context, &array, NULL, samples, &grid, &options));
        check_ok(cvol_array_write_memory(context, array, &file, &size));
        uint8_t *data = support_unpack(file, &size);
        expect_true_figures(array, samples, c->type);
        /* From the end of the first subband, through the last one and the residual. */
        const size_t first = find_section(data, size, "SHL1");
        const size_t residual = find_section(data, size, "CORR");
        const size_t end = find_section(data, size, "ENDS");
        for (size_t i = 0; i <= CUTS; i++) {
            expect_cut(c, data, first + (residual - first) * i / CUTS, residual, end, samples);
            expect_cut(c, data, residual + (end - 1 - residual) * i / CUTS, residual, end, samples);
        }
        expect_cut(c, data, end, residual, end, samples);
        expect_cut(c, data, size - 1, residual, end, samples);
        cvol_array_free(array);
        free(data);
        free(samples);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cut_files_report_it)};
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
