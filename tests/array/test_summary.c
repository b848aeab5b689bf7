/* The summary of the samples that files carry: transfer functions fitted to values are the same for
 * the original samples, for every compression of them, and for every part of a file. */
#include "test.h"

#include "array/core/array.h"
#include "array/core/summary.h"
#include "codec/container/array_file.h"
#include "codec/container/summary_section.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "cvol/series.h"
#include "cvol/transfer.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"

/* ---- volumes ---------------------------------------------------------------------------- */

enum { NX = 33, NY = 28, NZ = 20, COUNT = NX * NY * NZ };

typedef struct sample_volume {
    const char *name;
    cvol_grid grid;
    void *samples;
    double fill; /* the value of missing samples; 0: none */
} sample_volume;

static double blob(size_t x, size_t y, size_t z, double cx, double cy, double cz, double size)
{
    const double dx = (double)x - cx, dy = (double)y - cy, dz = (double)z - cz;
    return exp(-(dx * dx + dy * dy + dz * dz) / (size * size));
}

/* A density map: noise around zero, and peaks; from -0.05 to about 1. */
static double density(random_state *r, size_t x, size_t y, size_t z)
{
    return blob(x, y, z, 14, 16, 9, 4) + 0.6 * blob(x, y, z, 25, 9, 11, 5) +
           0.02 * ((double)random_below(r, 1000) / 500 - 1);
}

static const struct kind {
    const char *name;
    cvol_type type;
    double scale, offset, fill;
} kinds[] = {{"a density map", CVOL_FLOAT32, 1, 0, 0},       {"its bytes", CVOL_UINT8, 190, 20, 0},
             {"a scan", CVOL_INT16, 2500, -1000, 0},         {"counts", CVOL_UINT16, 4000, 300, 0},
             {"large integers", CVOL_INT32, 2e6, -70000, 0}, {"doubles", CVOL_FLOAT64, 1e-5, 3, 0},
             {"a map with land", CVOL_FLOAT32, 1, 0, 1e35}};

enum { KINDS = sizeof kinds / sizeof *kinds };

static void store(void *samples, cvol_type type, size_t i, double v)
{
    switch (type) {
    case CVOL_UINT8:
        ((uint8_t *)samples)[i] = (uint8_t)v;
        break;
    case CVOL_INT16:
        ((int16_t *)samples)[i] = (int16_t)v;
        break;
    case CVOL_UINT16:
        ((uint16_t *)samples)[i] = (uint16_t)v;
        break;
    case CVOL_INT32:
        ((int32_t *)samples)[i] = (int32_t)v;
        break;
    case CVOL_FLOAT64:
        ((double *)samples)[i] = v;
        break;
    default:
        ((float *)samples)[i] = (float)v;
    }
}

static sample_volume make(const struct kind *kind)
{
    sample_volume v = {.name = kind->name, .grid = cvol_grid_make(NX, NY, NZ, kind->type)};
    random_state r = {1};
    v.samples = malloc(COUNT * cvol_type_size(kind->type));
    v.fill = kind->fill;
    assert_non_null(v.samples);
    v.grid.spacing[2] = 1.5;
    size_t i = 0;
    for (size_t z = 0; z < NZ; z++)
        for (size_t y = 0; y < NY; y++)
            for (size_t x = 0; x < NX; x++, i++) {
                const int is_fill = kind->fill > 0 && x < 9;
                const double value = kind->offset + kind->scale * density(&r, x, y, z);
                store(v.samples, kind->type, i, is_fill ? kind->fill : value);
            }
    return v;
}

/* ---- the same function ------------------------------------------------------------------ */

static void expect_same_histogram(const cvol_histogram *a, const cvol_histogram *b,
                                  const char *volume, const char *what)
{
    if (a->min != b->min || a->max != b->max || memcmp(a->bins, b->bins, sizeof a->bins) ||
        a->chord != b->chord || a->integers != b->integers || a->distinct != b->distinct)
        fail_msg("%s, %s: another histogram, of %g to %g, not %g to %g", volume, what, b->min,
                 b->max, a->min, a->max);
}

/* All named functions of both, to the last bit. */
static void expect_same_functions(const cvol_histogram *a, const cvol_histogram *b,
                                  const char *volume, const char *what)
{
    char names[200];
    snprintf(names, sizeof names, "%s", cvol_transfer_names());
    for (char *name = strtok(names, " "); name; name = strtok(NULL, " ")) {
        cvol_transfer *s, *t;
        check_ok(cvol_transfer_create_named(context, &s, name, a));
        check_ok(cvol_transfer_create_named(context, &t, name, b));
        assert_int_equal(cvol_transfer_count(s), cvol_transfer_count(t));
        for (size_t i = 0; i < cvol_transfer_count(s); i++) {
            const cvol_transfer_point p = cvol_transfer_point_at(s, i),
                                      q = cvol_transfer_point_at(t, i);
            if (memcmp(&p, &q, sizeof p))
                fail_msg("%s, %s: point %zu of %s is at %g, not %g", volume, what, i, name, q.value,
                         p.value);
        }
        cvol_transfer_free(s);
        cvol_transfer_free(t);
    }
}

static void expect_same(const sample_volume *v, const cvol_array *array, const char *what)
{
    const cvol_volume volume = {v->grid, v->samples};
    cvol_histogram of_samples, of_array;
    check_ok(cvol_volume_compute_histogram(context, &of_samples, &volume));
    check_ok(cvol_array_compute_histogram(context, &of_array, array));
    assert_int_equal(cvol_array_summary(array)->state, CVOL_SUMMARY_KNOWN);
    expect_same_histogram(&of_samples, &of_array, v->name, what);
    expect_same_functions(&of_samples, &of_array, v->name, what);
}

/* The same for a file: at each level, in a box, and for the rest of it after a cut. */
static void expect_same_file(const sample_volume *v, const char *path, const char *what)
{
    const size_t begin[3] = {5, 7, 9}, end[3] = {20, 20, 19};
    cvol_array *array;
    for (int level = 0; level <= 3; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        cvol_file_report report;
        check_ok(cvol_array_read_part(context, &array, &report, path, &part));
        expect_same(v, array, what);
        cvol_array_free(array);
    }
    check_ok(cvol_array_read_box(context, &array, path, begin, end, NULL));
    expect_same(v, array, what);
    cvol_array_free(array);
}

static cvol_compress_options options_of(const sample_volume *v)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.has_fill = v->fill > 0;
    options.fill = v->fill;
    return options;
}

static cvol_array *compress(const sample_volume *v, const cvol_compress_options *options)
{
    cvol_array *array;
    const int code = cvol_compress(context, &array, NULL, v->samples, &v->grid, options);
    if (code)
        fail_msg("%s: %s", v->name, cvol_context_message(context));
    return array;
}

static void expect_same_of(const sample_volume *v, const cvol_compress_options *options,
                           const char *what)
{
    const char *path = in_folder("a.cvol");
    cvol_array *array = compress(v, options);
    uint64_t counted, written;
    expect_same(v, array, what);
    check_ok(cvol_array_file_bytes(context, array, &counted));
    check_ok(cvol_array_write(context, array, path, &written));
    assert_true(counted == written);
    cvol_array_free(array);
    expect_same_file(v, path, what);
}

static void test_every_compression_keeps_the_function(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; k += SUPPORT_STRIDE) {
        sample_volume v = make(&kinds[k]);
        cvol_compress_options options = options_of(&v);
        options.target_value = 10;
        options.effort = CVOL_EFFORT_FAST; /* the search for a step takes long for few samples */
        expect_same_of(&v, &options, "ratio 10");
        options.target_value = 30;
        options.background = v.fill > 0 ? CVOL_BACKGROUND_NONE : CVOL_BACKGROUND_FIND;
        expect_same_of(&v, &options, "in haste");
        free(v.samples);
    }
}

static void test_exact_and_coarse_files_keep_the_function(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; k += 3) { /* floats, counts, a map with missing samples */
        sample_volume v = make(&kinds[k]);
        cvol_compress_options options = options_of(&v);
        if (k == 0) {
            options.target_value = 100;
            expect_same_of(&v, &options, "ratio 100");
        }
        options = options_of(&v);
        options.target = CVOL_TARGET_MAX_ERROR;
        options.target_value = 0.02 * kinds[k].scale;
        expect_same_of(&v, &options, "a bound");
        options = options_of(&v);
        options.lossless = 1;
        expect_same_of(&v, &options, "lossless");
        free(v.samples);
    }
}

static void test_max_effort_and_blocks(void **state)
{
    (void)state;
    sample_volume v = make(&kinds[0]);
    cvol_compress_options options = options_of(&v);
    options.effort = CVOL_EFFORT_MAX;
    options.target_value = 60;
    expect_same_of(&v, &options, "smallest");
    options = options_of(&v);
    options.block = 8;
    expect_same_of(&v, &options, "blocks of 8");
    free(v.samples);
}

/* ---- transcoding, series, operations ---------------------------------------------------- */

static void test_transcoding_keeps_the_function(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; k += 6) { /* plain, and with a mask */
        sample_volume v = make(&kinds[k]);
        cvol_compress_options options = options_of(&v);
        options.target_value = 8;
        cvol_array *fine = compress(&v, &options), *coarse;
        cvol_compress_options to = cvol_compress_options_defaults();
        to.target_value = 50;
        check_ok(cvol_array_transcode(context, &coarse, NULL, fine, &to));
        expect_same(&v, coarse, "transcoded");
        check_ok(cvol_array_write(context, coarse, in_folder("b.cvol"), NULL));
        expect_same_file(&v, in_folder("b.cvol"), "transcoded");
        cvol_array_free(fine);
        cvol_array_free(coarse);
        free(v.samples);
    }
}

static void test_series_keep_the_function(void **state)
{
    (void)state;
    const char *path = in_folder("series.cvol");
    sample_volume v[2] = {make(&kinds[0]), make(&kinds[0])};
    cvol_series_writer *writer;
    cvol_series_options series = cvol_series_options_defaults();
    series.times = 2;
    for (int i = 0; i < COUNT; i++)
        ((float *)v[1].samples)[i] *= 3;
    check_ok(cvol_series_writer_open(context, &writer, path, &series));
    for (int t = 0; t < 2; t++) {
        cvol_compress_options options = options_of(&v[t]);
        cvol_array *array = compress(&v[t], &options);
        check_ok(cvol_series_add(context, writer, array, NULL));
        cvol_array_free(array);
    }
    check_ok(cvol_series_writer_commit(context, writer, NULL));
    for (int t = 0; t < 2; t++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .time = t};
        cvol_file_report report;
        cvol_array *array;
        check_ok(cvol_array_read_part(context, &array, &report, path, &part));
        expect_same(&v[t], array, "a time");
        cvol_array_free(array);
        free(v[t].samples);
    }
}

/* Results of operations are summarised by their own terms, and a file of them gives the same
 * summary; scaling scales the samples' summary. */
static void test_results_have_their_own(void **state)
{
    (void)state;
    sample_volume v = make(&kinds[0]);
    cvol_compress_options options = options_of(&v);
    cvol_array *a = compress(&v, &options), *scaled, *sum, *read;
    cvol_histogram of_samples, of_array, of_file;
    check_ok(cvol_array_scale(context, &scaled, -2, a, 7));
    for (int i = 0; i < COUNT; i++)
        ((float *)v.samples)[i] = -2 * ((float *)v.samples)[i] + 7;
    check_ok(
        cvol_volume_compute_histogram(context, &of_samples, &(cvol_volume){v.grid, v.samples}));
    check_ok(cvol_array_compute_histogram(context, &of_array, scaled));
    near(of_array.min, of_samples.min, 1e-6);
    near(of_array.max, of_samples.max, 1e-6);
    assert_int_equal(cvol_array_summary(scaled)->state, CVOL_SUMMARY_KNOWN);
    check_ok(cvol_array_add(context, &sum, 1, a, 1, scaled, NULL));
    assert_int_equal(cvol_array_summary(sum)->state, CVOL_SUMMARY_NONE);
    check_ok(cvol_array_compute_histogram(context, &of_array, sum));
    check_ok(cvol_array_write(context, sum, in_folder("sum.cvol"), NULL));
    check_ok(cvol_array_read(context, &read, in_folder("sum.cvol"), NULL));
    check_ok(cvol_array_compute_histogram(context, &of_file, read));
    expect_same_functions(&of_array, &of_file, v.name, "a sum's file");
    cvol_array_free(a);
    cvol_array_free(scaled);
    cvol_array_free(sum);
    cvol_array_free(read);
    free(v.samples);
}

/* ---- by slab ---------------------------------------------------------------------------- */

static int read_slices(cvol_context *c, void *user, void *out, size_t first, size_t count)
{
    const sample_volume *v = user;
    const size_t bytes = (size_t)NX * NY * cvol_type_size(v->grid.type);
    (void)c;
    memcpy(out, (const uint8_t *)v->samples + first * bytes, count * bytes);
    return CVOL_OK;
}

static void test_streams_keep_the_function(void **state)
{
    (void)state;
    for (int k = 0; k < KINDS; k += 2) { /* floats, counted in two passes, and integers */
        if (kinds[k].fill > 0)
            continue;
        sample_volume v = make(&kinds[k]);
        const cvol_sample_source source = {.read = read_slices, .user = &v};
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        options.brick[0] = options.brick[1] = options.brick[2] = 16; /* many layers */
        check_ok(cvol_compress_stream(context, &report, in_folder("s.cvol"), &source, &v.grid,
                                      &options));
        expect_same_file(&v, in_folder("s.cvol"), "by slab");
        free(v.samples);
    }
}

/* ---- counting --------------------------------------------------------------------------- */

static void test_levels(void **state)
{
    (void)state;
    int last = 0;
    for (uint64_t count = 0; count < 100000; count++) {
        const int level = cvol_summary_level(count);
        const double back = (double)cvol_summary_count((uint8_t)level);
        assert_true(level == last || level > last);
        assert_true(fabs(back - (double)count) <= 0.13 * (double)count);
        assert_int_equal(cvol_summary_level((uint64_t)back), level);
        last = level;
    }
    assert_true(cvol_summary_level(UINT64_MAX) <= CVOL_SUMMARY_LEVEL_MAX);
}

/* The counts do not depend on threads or on how samples are passed; two passes give the counts of
 * one. */
static void test_counting_is_the_same_for_all_types(void **state)
{
    (void)state;
    random_state r = {7};
    const size_t count = 300007;
    uint16_t *words = malloc(count * sizeof *words);
    float *floats = malloc(count * sizeof *floats);
    assert_true(words && floats);
    for (size_t i = 0; i < count; i++)
        floats[i] = words[i] = (uint16_t)(random_below(&r, 90) * random_below(&r, 20));
    cvol_grid grid = cvol_grid_make(count, 1, 1, CVOL_UINT16);
    cvol_summary one, two;
    check_ok(cvol_summarise_samples(context, &one, words, &grid, NULL));
    grid.type = CVOL_FLOAT32;
    check_ok(cvol_summarise_samples(context, &two, floats, &grid, NULL));
    assert_memory_equal(&one, &two, sizeof one);
    assert_true(one.integers);
    cvol_context_set_threads(context, 3);
    check_ok(cvol_summarise_samples(context, &two, floats, &grid, NULL));
    assert_memory_equal(&one, &two, sizeof one);
    cvol_context_set_threads(context, 1);
    /* A fill is not counted, of either kind. */
    cvol_fills fills = {0};
    uint64_t bits;
    cvol_fills_of_value(&bits, CVOL_FLOAT32, 0);
    cvol_fills_add(&fills, bits);
    check_ok(cvol_summarise_samples(context, &two, floats, &grid, &fills));
    assert_true(two.min > 0 && two.levels[0] < one.levels[0]);
    grid.type = CVOL_UINT16;
    check_ok(cvol_summarise_samples(context, &one, words, &grid, &fills));
    assert_memory_equal(&one, &two, sizeof one);
    free(words);
    free(floats);
}

static void test_distinct_values(void **state)
{
    (void)state;
    static const size_t distinct[] = {1, 2, 101, 256, 257, 5000};
    double samples[5000];
    for (size_t d = 0; d < sizeof distinct / sizeof *distinct; d++)
        for (int part = 0; part < 2; part++) { /* integers, then not */
            cvol_summary s;
            const cvol_grid grid = cvol_grid_make(50, 100, 1, CVOL_FLOAT64);
            for (size_t i = 0; i < 5000; i++)
                samples[i] = 7 * (double)(i % distinct[d]) + 0.5 * part;
            check_ok(cvol_summarise_samples(context, &s, samples, &grid, NULL));
            assert_int_equal(s.distinct, distinct[d] <= 256 ? distinct[d] : 0);
            assert_int_equal(s.integers, !part);
        }
}

/* ---- the section ------------------------------------------------------------------------ */

static cvol_header header_of(int bins_log2)
{
    cvol_header head = {.grid = cvol_grid_make(64, 64, 64, CVOL_FLOAT32),
                        .transform = CVOL_DCT,
                        .rank = 3,
                        .block = 16,
                        .error_bound = {.value_min = -1, .value_max = 2}};
    head.summary = (cvol_summary){
        .state = CVOL_SUMMARY_KNOWN, .min = -1, .max = 2, .bins_log2 = bins_log2};
    return head;
}

static void test_section_round_trip(void **state)
{
    (void)state;
    random_state r = {11};
    for (int attempt = 0; attempt < 200; attempt = support_next(attempt)) {
        cvol_header head = header_of(4 + attempt % 5), read = head;
        cvol_summary *s = &head.summary;
        cvol_bytes bytes = {0};
        s->integers = attempt & 1;
        s->distinct = (uint32_t)random_below(&r, 257);
        s->min = attempt % 3 ? -1 : -0.5;
        s->mark_count = attempt % 4 ? 0 : 1 + random_below(&r, 1000);
        s->mark = s->mark_count ? 1e35 : 0;
        for (int i = 0; i < 1 << s->bins_log2; i++)
            s->levels[i] = random_below(&r, 3) ? (uint8_t)random_below(&r, attempt % 7 ? 60 : 254)
                                               : 0;
        cvol_summary_put(&bytes, &head);
        memset(&read.summary, 0, sizeof read.summary);
        cvol_cursor cursor = cvol_cursor_make(bytes.data, bytes.size);
        check_ok(cvol_summary_take(context, &read, &cursor, "a"));
        assert_memory_equal(&read.summary, s, sizeof *s);
        /* A shorter section is refused or gives a valid summary. */
        for (size_t size = 0; size < bytes.size; size += SUPPORT_DAMAGE) {
            cursor = cvol_cursor_make(bytes.data, size);
            memset(&read.summary, 0, sizeof read.summary);
            if (!cvol_summary_take(context, &read, &cursor, "a"))
                assert_true(read.summary.min <= read.summary.max);
            else
                assert_non_null(strstr(cvol_context_message(context), "a: section SUMM "));
        }
        cvol_bytes_free(&bytes);
    }
}

static void expect_refused(const uint8_t *bytes, size_t size, const char *words)
{
    cvol_header head = header_of(4);
    cvol_cursor cursor = cvol_cursor_make(bytes, size);
    assert_int_equal(cvol_summary_take(context, &head, &cursor, "a"), CVOL_ERROR_CORRUPT);
    if (!strstr(cvol_context_message(context), words))
        fail_msg("%s", cvol_context_message(context));
}

static void test_invalid_sections_are_refused(void **state)
{
    (void)state;
    uint8_t range[18] = {2, 0};
    double ends[2] = {3, 1};
    expect_refused((const uint8_t[]){0}, 1, "within its fields");
    expect_refused((const uint8_t[]){8, 0}, 2, "flags");
    expect_refused((const uint8_t[]){0x50, 0}, 2, "256 bins");
    expect_refused((const uint8_t[]){0, 0x81, 0x02}, 3, "distinct");
    memcpy(range + 2, ends, sizeof ends);
    expect_refused(range, sizeof range, "an invalid range");
    ends[0] = NAN;
    memcpy(range + 2, ends, sizeof ends);
    expect_refused(range, sizeof range, "an invalid range");
}

/* Random bytes are either refused or valid counts. */
static void test_random_counts(void **state)
{
    (void)state;
    random_state r = {3};
    int refused = 0;
    for (int attempt = 0; attempt < 3000; attempt = support_next(attempt)) {
        cvol_header head = header_of(8);
        uint8_t bytes[66] = {0x40, 0};
        for (int i = 2; i < 66; i++)
            bytes[i] = (uint8_t)(attempt % 2 ? random_below(&r, 256) : 255 - random_below(&r, 9));
        cvol_cursor cursor = cvol_cursor_make(bytes, 2 + random_below(&r, 65));
        memset(&head.summary, 0, sizeof head.summary);
        if (cvol_summary_take(context, &head, &cursor, "a"))
            refused++;
        else
            for (int i = 0; i < CVOL_SUMMARY_BINS; i++)
                assert_true(head.summary.levels[i] <= CVOL_SUMMARY_LEVEL_MAX);
    }
    assert_true(refused > 0);
}

/* A small volume's summary takes few bytes. */
static void test_size_of_small_summaries(void **state)
{
    (void)state;
    random_state r = {5};
    const struct {
        size_t side;
        uint64_t most;
    } cases[] = {{8, 24 + 20}, {12, 24 + 20}, {21, 24 + 28}, {48, 24 + 45}, {64, 24 + 75}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const size_t n = cases[c].side;
        uint8_t *samples = malloc(n * n * n);
        cvol_summary s;
        const cvol_grid grid = cvol_grid_make(n, n, n, CVOL_UINT8);
        const cvol_error_bound error_bound = {.value_min = 0, .value_max = 255};
        assert_non_null(samples);
        size_t i = 0;
        for (size_t z = 0; z < n; z++)
            for (size_t y = 0; y < n; y++)
                for (size_t x = 0; x < n; x++, i++)
                    samples[i] = (uint8_t)(240 * blob(x, y, z, (double)n / 2, (double)n / 2,
                                                      (double)n / 3, (double)n / 4) +
                                           (double)random_below(&r, 15));
        samples[0] = 0;
        samples[1] = 255;
        check_ok(cvol_summarise_samples(context, &s, samples, &grid, NULL));
        const uint64_t bytes = cvol_summary_section_bytes(&s, &error_bound);
        if (bytes > cases[c].most)
            fail_msg("%zu^3: %d bytes", n, (int)bytes);
        free(samples);
    }
}

/* The bytes of a file whose sections stand one after the other. */
static size_t unpacked_bytes(const char *path)
{
    size_t size;
    uint8_t *data = support_read(path, &size);
    free(support_unpack(data, &size));
    return size;
}

/* If it is not requested, the file has none, and the histogram is that of the terms. */
static void test_left_out_samples(void **state)
{
    (void)state;
    sample_volume v = make(&kinds[0]);
    cvol_compress_options options = options_of(&v);
    cvol_array *with = compress(&v, &options), *without, *read;
    uint64_t with_bytes, without_bytes;
    cvol_histogram h;
    options.no_histogram = 1;
    without = compress(&v, &options);
    const uint64_t section = cvol_summary_section_bytes(cvol_array_summary(with),
                                                        &with->error_bound);
    assert_int_equal(cvol_array_summary(without)->state, CVOL_SUMMARY_LEFT_OUT);
    check_ok(cvol_array_set_summary(context, without, cvol_array_summary(with)));
    check_ok(cvol_array_write(context, without, in_folder("w.cvol"), &with_bytes));
    const size_t plain_with = unpacked_bytes(in_folder("w.cvol"));
    const cvol_summary none = {.state = CVOL_SUMMARY_LEFT_OUT};
    check_ok(cvol_array_set_summary(context, without, &none));
    check_ok(cvol_array_write(context, without, in_folder("w.cvol"), &without_bytes));
    assert_int_equal(plain_with - unpacked_bytes(in_folder("w.cvol")), section);
    assert_true(with_bytes > without_bytes);
    check_ok(cvol_array_read(context, &read, in_folder("w.cvol"), NULL));
    assert_int_equal(cvol_array_summary(read)->state, CVOL_SUMMARY_NONE);
    check_ok(cvol_array_compute_histogram(context, &h, read));
    assert_true(h.max > h.min);
    cvol_array_free(with);
    cvol_array_free(without);
    cvol_array_free(read);
    free(v.samples);
}

/* ---- real volumes ----------------------------------------------------------------------- */

static void expect_same_of_data(const char *name)
{
    char path[1000];
    cvol_volume *volume;
    snprintf(path, sizeof path, "%s/%s", CVOL_TEST_DATA, name);
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    fclose(file);
    check_ok(cvol_volume_read(context, &volume, path, NULL));
    const sample_volume v = {.name = name, .grid = volume->grid, .samples = volume->data};
    cvol_compress_options options = options_of(&v);
    options.effort = CVOL_EFFORT_FAST;
    expect_same_of(&v, &options, "in haste");
    cvol_volume_free(volume);
}

static void test_real_volumes(void **state)
{
    (void)state;
    expect_same_of_data("tooth.nrrd");
}

/* Volumes are small: threads would only wait for each other. */
static int open_one_thread(void **state)
{
    const int failed = files_setup(state);
    cvol_context_set_threads(context, 1);
    return failed;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_counting_is_the_same_for_all_types),
        cmocka_unit_test(test_distinct_values),
        cmocka_unit_test(test_section_round_trip),
        cmocka_unit_test(test_invalid_sections_are_refused),
        cmocka_unit_test(test_random_counts),
        cmocka_unit_test(test_size_of_small_summaries),
        cmocka_unit_test(test_every_compression_keeps_the_function),
        cmocka_unit_test(test_exact_and_coarse_files_keep_the_function),
        cmocka_unit_test(test_max_effort_and_blocks),
        cmocka_unit_test(test_transcoding_keeps_the_function),
        cmocka_unit_test(test_series_keep_the_function),
        cmocka_unit_test(test_results_have_their_own),
        cmocka_unit_test(test_streams_keep_the_function),
        cmocka_unit_test(test_left_out_samples),
        cmocka_unit_test(test_real_volumes),
    };
    return cmocka_run_group_tests(tests, open_one_thread, files_teardown);
}
