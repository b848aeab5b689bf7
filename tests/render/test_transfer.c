/* Transfer functions: evaluation, files of both kinds and their errors, histograms, and named
 * functions fitted to them. */
#include "test.h"

#include "random.h"
#include "render/transfer/transfer.h"
#include "support.h"
#include "support_files.h"

static void expect_near(double a, double b)
{
    if (!(fabs(a - b) < 1e-12))
        fail_msg("%.17g is not %.17g", a, b);
}

static void expect_point(const cvol_transfer *t, double value, double r, double g, double b,
                         double opacity)
{
    cvol_transfer_point p = cvol_transfer_at(t, value);
    expect_near(p.r, r);
    expect_near(p.g, g);
    expect_near(p.b, b);
    expect_near(p.opacity, opacity);
}

static cvol_transfer *create(const cvol_transfer_point *points, size_t count)
{
    cvol_transfer *t;
    assert_int_equal(cvol_transfer_create(context, &t, points, count), CVOL_OK);
    return t;
}

/* ---- evaluation -------------------------------------------------------------------------- */

static void test_linear_between_constant_outside(void **state)
{
    (void)state;
    const cvol_transfer_point points[] = {{30, 1, 0, 0.5, 1}, {10, 0, 1, 0.5, 0.2}};
    cvol_transfer *t = create(points, 2);
    expect_point(t, -1e300, 0, 1, 0.5, 0.2);
    expect_point(t, 10, 0, 1, 0.5, 0.2);
    expect_point(t, 15, 0.25, 0.75, 0.5, 0.4);
    expect_point(t, 30, 1, 0, 0.5, 1);
    expect_point(t, INFINITY, 1, 0, 0.5, 1);
    expect_point(t, NAN, 0, 1, 0.5, 0.2);
    assert_int_equal(cvol_transfer_count(t), 2);
    expect_near(cvol_transfer_point_at(t, 0).value, 10);
    cvol_transfer_free(t);
}

static void test_jumps_keep_their_order(void **state)
{
    (void)state;
    const cvol_transfer_point points[] = {
        {5, 0, 0, 0, 0.9}, {2, 0, 0, 0, 0.1}, {2, 0, 0, 0, 0.7}, {2, 0, 0, 0, 0.3}};
    cvol_transfer *t = create(points, 4);
    expect_near(cvol_transfer_at(t, 1.999).opacity, 0.1);
    expect_near(cvol_transfer_before(t, 2).opacity, 0.1);
    expect_near(cvol_transfer_at(t, 2).opacity, 0.3);
    expect_near(cvol_transfer_at(t, 3.5).opacity, 0.6);
    expect_near(cvol_transfer_max_opacity(t, 2, 2), 0.7);
    expect_near(cvol_transfer_max_opacity(t, 0, 1), 0.1);
    cvol_transfer_free(t);
}

static void test_extreme_values(void **state)
{
    (void)state;
    const cvol_transfer_point points[] = {{-1.7e308, 0, 0, 0, 0}, {1.7e308, 1, 1, 1, 1}};
    cvol_transfer *t = create(points, 2);
    expect_near(cvol_transfer_at(t, 0).opacity, 0.5);
    cvol_transfer_free(t);
    const cvol_transfer_point tiny[] = {{0, 0, 0, 0, 0}, {4.9e-324, 1, 1, 1, 1}};
    t = create(tiny, 2);
    expect_near(cvol_transfer_at(t, 0).opacity, 0);
    cvol_transfer_free(t);
}

static void test_bad_points_are_named(void **state)
{
    (void)state;
    const cvol_transfer_point good = {1, 0.5, 0.5, 0.5, 0.5};
    struct {
        cvol_transfer_point bad;
        const char *words;
    } cases[] = {
        {{NAN, 0, 0, 0, 0}, "point 1: value"},      {{INFINITY, 0, 0, 0, 0}, "point 1: value"},
        {{0, -0.1, 0, 0, 0}, "point 1: r is -0.1"}, {{0, 0, 1.5, 0, 0}, "point 1: g is 1.5"},
        {{0, 0, 0, NAN, 0}, "point 1: b"},          {{0, 0, 0, 0, 2}, "point 1: opacity is 2"}};
    cvol_transfer *t;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const cvol_transfer_point points[] = {good, cases[i].bad};
        assert_int_equal(cvol_transfer_create(context, &t, points, 2), CVOL_ERROR_ARGUMENT);
        assert_null(t);
        assert_non_null(strstr(cvol_context_message(context), cases[i].words));
    }
    assert_int_equal(cvol_transfer_create(context, &t, &good, 0), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_transfer_create(context, &t, &good, 65537), CVOL_ERROR_ARGUMENT);
}

static void test_opacity_over(void **state)
{
    (void)state;
    expect_near(cvol_opacity_over(0.3, 1), 0.3);
    expect_near(cvol_opacity_over(0.3, 2), 1 - 0.49);
    expect_near(cvol_opacity_over(0.75, 0.5), 0.5);
    expect_near(cvol_opacity_over(0, 5), 0);
    expect_near(cvol_opacity_over(1, 0.01), 1);
    expect_near(cvol_opacity_over(1, 0), 0);
    /* Tiny opacities keep their digits. */
    assert_true(fabs(cvol_opacity_over(1e-12, 0.5) / 5e-13 - 1) < 1e-9);
}

static void test_max_opacity_equals_search(void **state)
{
    (void)state;
    random_state r = {3};
    for (int attempt = 0; attempt < 50; attempt++) {
        cvol_transfer_point points[6];
        for (int i = 0; i < 6; i++)
            points[i] = (cvol_transfer_point){.value = random_below(&r, 20),
                                              .opacity = random_below(&r, 100) / 100.0};
        cvol_transfer *t = create(points, 6);
        double lo = random_below(&r, 20) - 0.5, hi = lo + random_below(&r, 10), most = 0;
        for (double v = lo; v <= hi; v += 1.0 / 64)
            most = fmax(most,
                        fmax(cvol_transfer_at(t, v).opacity, cvol_transfer_before(t, v).opacity));
        double found = cvol_transfer_max_opacity(t, lo, hi);
        /* A search never finds the middle of three points of one value. */
        assert_true(found >= most - 1e-12 && found <= 1);
        cvol_transfer_free(t);
    }
}

/* ---- files ------------------------------------------------------------------------------- */

static cvol_transfer *read_text(const char *text)
{
    cvol_transfer *t;
    support_write_text(file_path, text);
    int code = cvol_transfer_read(context, &t, file_path);
    if (code)
        fail_msg("%s", cvol_context_message(context));
    /* The text itself reads the same; bytes behind it are ignored. */
    cvol_transfer *parsed;
    const size_t size = strlen(text);
    char *longer = malloc(size + 1);
    assert_non_null(longer);
    memcpy(longer, text, size);
    longer[size] = '!';
    assert_int_equal(cvol_transfer_parse(context, &parsed, longer, size, "text"), CVOL_OK);
    assert_int_equal(cvol_transfer_count(parsed), cvol_transfer_count(t));
    for (size_t i = 0; i < cvol_transfer_count(t); i++) {
        const cvol_transfer_point a = cvol_transfer_point_at(t, i),
                                  b = cvol_transfer_point_at(parsed, i);
        assert_memory_equal(&a, &b, sizeof a);
    }
    cvol_transfer_free(parsed);
    assert_int_equal(cvol_transfer_parse(context, &parsed, longer, size - 1, "my text"),
                     CVOL_ERROR_FORMAT);
    assert_null(parsed);
    assert_non_null(strstr(cvol_context_message(context), "my text: "));
    free(longer);
    return t;
}

static void test_own_file(void **state)
{
    (void)state;
    cvol_transfer *t = read_text("{\"points\": [[100, 1, 1, 1, 0.5], [0, 0, 0, 0, 0]]}");
    expect_point(t, 50, 0.5, 0.5, 0.5, 0.25);
    cvol_transfer_free(t);
    t = read_text("\xef\xbb\xbf{\"note\": \"x\", \"points\": [[-1.5e3, 0, 0, 0, 1]]}");
    expect_near(cvol_transfer_point_at(t, 0).value, -1500);
    cvol_transfer_free(t);
}

static void test_paraview_file(void **state)
{
    (void)state;
    cvol_transfer *t = read_text("[{\"ColorSpace\": \"RGB\", \"Name\": \"x\","
                                 " \"RGBPoints\": [0, 0, 0, 1, 100, 1, 0, 0],"
                                 " \"Points\": [20, 0, 0.5, 0, 60, 0.8, 0.5, 0]}]");
    expect_point(t, 0, 0, 0, 1, 0);
    expect_point(t, 20, 0.2, 0, 0.8, 0);
    expect_point(t, 40, 0.4, 0, 0.6, 0.4);
    expect_point(t, 60, 0.6, 0, 0.4, 0.8);
    expect_point(t, 90, 0.9, 0, 0.1, 0.8);
    assert_int_equal(cvol_transfer_count(t), 4);
    cvol_transfer_free(t);
    /* Without opacities; as a bare object. */
    t = read_text("{\"RGBPoints\": [10, 1, 1, 1, 30, 1, 1, 1, 20, 0, 0, 0]}");
    expect_point(t, 15, 0.5, 0.5, 0.5, 0.25);
    expect_point(t, 20, 0, 0, 0, 0.5);
    expect_point(t, 30, 1, 1, 1, 1);
    cvol_transfer_free(t);
    /* The joined function keeps jumps of either. */
    t = read_text("{\"RGBPoints\": [0, 0, 0, 0, 5, 0, 0, 0, 5, 1, 1, 1, 9, 1, 1, 1],"
                  " \"Points\": [0, 0.1, 0.5, 0, 7, 0.1, 0.5, 0, 7, 0.9, 0.5, 0]}");
    expect_point(t, 4.999, 0, 0, 0, 0.1);
    expect_point(t, 5, 1, 1, 1, 0.1);
    expect_point(t, 6.999, 1, 1, 1, 0.1);
    expect_point(t, 7, 1, 1, 1, 0.9);
    cvol_transfer_free(t);
}

static void test_paraview_midpoint_and_sharpness(void **state)
{
    (void)state;
    cvol_transfer *t = read_text("{\"RGBPoints\": [0, 1, 1, 1, 16, 1, 1, 1],"
                                 " \"Points\": [0, 0, 0.25, 0, 16, 1, 0.5, 0]}");
    expect_near(cvol_transfer_at(t, 4).opacity, 0.5);
    expect_near(cvol_transfer_at(t, 2).opacity, 0.25);
    expect_near(cvol_transfer_at(t, 10).opacity, 0.75);
    cvol_transfer_free(t);
    t = read_text("{\"RGBPoints\": [0, 1, 1, 1, 16, 1, 1, 1],"
                  " \"Points\": [0, 0, 0.5, 1, 16, 1, 0.5, 0]}");
    expect_near(cvol_transfer_at(t, 6).opacity, 0);
    expect_near(cvol_transfer_at(t, 10).opacity, 1);
    cvol_transfer_free(t);
}

static void test_bad_files_are_explained(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "is empty"},
        {"{\"points\": [[0, 1, 1, 1, 1]", "line 1"},
        {"{\"points\": [[0, 1, 1, 1, 1]]} x", "line 1"},
        {"[]", "neither"},
        {"{}", "neither"},
        {"3", "line 1"},
        {"[1, {}]", "neither"},
        {"{\"points\": 5}", "\"points\" is not an array"},
        {"{\"points\": []}", "\"points\" has 0 points"},
        {"{\"points\": [[0, 1, 1, 1, 1], 7]}", "point 1 is not an array"},
        {"{\"points\": [[0, 1, 1, 1, 1], [0, 1, 1]]}", "point 1 has 3 values"},
        {"{\"points\": [[0, 1, 1, \"x\", 1]]}", "point 0: b is not a number"},
        {"{\"points\": [[0, 1, 1, 1, 1], [0, 1, 1, 1, 1], [0, 1, 1, 1, 1.01]]}",
         "point 2: opacity is 1.01"},
        {"{\"points\": [[1e999, 1, 1, 1, 1]]}", "line 1"},
        {"{\"RGBPoints\": [0, 1, 1]}", "\"RGBPoints\" has 3 values"},
        {"{\"RGBPoints\": []}", "\"RGBPoints\" has 0 values"},
        {"{\"RGBPoints\": {}}", "\"RGBPoints\" is not an array"},
        {"{\"RGBPoints\": [0, 1, 1, null]}", "value 3 of point 0"},
        {"{\"RGBPoints\": [0, 1, 1, 1, 5, 255, 1, 1]}", "point 1: r is 255"},
        {"{\"RGBPoints\": [0, 1, 1, 1], \"Points\": [0, 0, 0.5, 0, 1, 7, 0.5, 0]}",
         "opacity of point 1 is 7"},
        {"{\"points\": [[0, 0, 0, 0, 0]], \"bad\": \"\xff\"}", "line 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        support_write_text(file_path, cases[i].text);
        cvol_transfer *t;
        assert_int_equal(cvol_transfer_read(context, &t, file_path), CVOL_ERROR_FORMAT);
        assert_null(t);
        const char *message = cvol_context_message(context);
        if (!strstr(message, cases[i].words) || strncmp(message, file_path, strlen(file_path)))
            fail_msg("%s -> %s", cases[i].text, message);
    }
}

static void test_deep_large_and_missing_files(void **state)
{
    (void)state;
    cvol_transfer *t;
    assert_int_equal(cvol_transfer_read(context, &t, file_path), CVOL_ERROR_IO);
    size_t size = ((size_t)16 << 20) + 5;
    char *text = malloc(size);
    assert_non_null(text);
    memset(text, '[', size);
    support_write(file_path, text, 100000);
    assert_int_equal(cvol_transfer_read(context, &t, file_path), CVOL_ERROR_FORMAT);
    memset(text, ' ', size);
    support_write(file_path, text, size);
    assert_int_equal(cvol_transfer_read(context, &t, file_path), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "larger than"));
    free(text);
}

/* ---- histograms -------------------------------------------------------------------------- */

static void test_histogram_counts(void **state)
{
    (void)state;
    float samples[4 * 3 * 2];
    for (int i = 0; i < 24; i++)
        samples[i] = (float)i;
    samples[5] = NAN;
    samples[6] = INFINITY;
    cvol_volume volume = {cvol_grid_make(4, 3, 2, CVOL_FLOAT32), samples};
    cvol_histogram h;
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    expect_near(h.min, 0);
    expect_near(h.max, 23);
    uint64_t total = 0;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        total += h.bins[i];
    assert_int_equal(total, 22 * 16); /* 16 different counts, of 16 bins each */
    assert_int_equal(h.bins[0], 2);
    assert_int_equal(h.bins[1 * 256 / 23], 2);
    assert_int_equal(h.bins[255], 2);
    for (int i = 0; i < 24; i++)
        samples[i] = NAN;
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    assert_true(h.min == 0 && h.max == 0 && h.bins[0] == 0);
    double wide[2] = {-1.7e308, 1.7e308};
    volume = (cvol_volume){cvol_grid_make(2, 1, 1, CVOL_FLOAT64), wide};
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    assert_true(h.bins[0] == 1 && h.bins[255] == 1);
}

static void test_tinted(void **state)
{
    (void)state;
    const cvol_transfer_point points[] = {{0, 0, 0, 0, 0}, {10, 0.5, 0.25, 0.125, 0.75}};
    const double orange[3] = {1, 0.5, 0};
    cvol_transfer *from, *tinted;
    assert_int_equal(cvol_transfer_create(context, &from, points, 2), CVOL_OK);
    assert_int_equal(cvol_transfer_create_tinted(context, &tinted, from, orange), CVOL_OK);
    assert_int_equal(cvol_transfer_count(tinted), 2);
    const cvol_transfer_point p = cvol_transfer_point_at(tinted, 1);
    expect_near(p.r, 0.5);
    expect_near(p.g, 0.25);
    expect_near(p.b, 0);
    expect_near(p.opacity, 0.75);
    cvol_transfer_free(from);
    cvol_transfer_free(tinted);
}

static void test_component(void **state)
{
    (void)state;
    const double red[3] = {1, 0, 0};
    double range[2];
    cvol_transfer *t;
    cvol_component_get_range(range, CVOL_UINT8);
    expect_near(range[1], 255);
    cvol_component_get_range(range, CVOL_FLOAT32);
    expect_near(range[1], 1);
    assert_int_equal(cvol_transfer_create_component(context, &t, NULL, range, red), CVOL_OK);
    const cvol_transfer_point dark = cvol_transfer_point_at(t, 0),
                              bright = cvol_transfer_point_at(t, cvol_transfer_count(t) - 1);
    expect_near(dark.opacity, 0);
    expect_near(bright.value, 1);
    expect_near(bright.r, 1);
    expect_near(bright.g, 0);
    cvol_transfer_free(t);
}

static void test_joined_histograms(void **state)
{
    (void)state;
    cvol_histogram each[2] = {{.min = 0, .max = 256, .integers = 1, .distinct = 3},
                              {.min = 128, .max = 512, .integers = 1, .distinct = 5}},
                   sum;
    each[0].bins[0] = 7;
    each[0].bins[255] = 2;
    each[1].bins[0] = 4;
    each[1].bins[255] = 1;
    cvol_histogram_join(&sum, each, 2);
    expect_near(sum.min, 0);
    expect_near(sum.max, 512);
    assert_int_equal(sum.distinct, 5);
    assert_int_equal(sum.integers, 1);
    assert_int_equal(sum.bins[0], 7);
    assert_int_equal(sum.bins[127], 2); /* 255.5 of 512, in bins of 2 */
    assert_int_equal(sum.bins[64], 4);  /* 128.75 */
    assert_int_equal(sum.bins[255], 1);
    each[1].distinct = 0; /* unknown */
    cvol_histogram_join(&sum, each, 2);
    assert_int_equal(sum.distinct, 0);
}

static void test_histogram_of_many_samples(void **state)
{
    (void)state;
    size_t nx = 300, ny = 200, nz = 150;
    uint8_t *samples = malloc(nx * ny * nz);
    assert_non_null(samples);
    for (size_t i = 0; i < nx * ny * nz; i++)
        samples[i] = (uint8_t)(i % nx);
    cvol_volume volume = {cvol_grid_make(nx, ny, nz, CVOL_UINT8), samples};
    cvol_histogram h;
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++) { /* rounded to a quarter of an octave */
        const double count = (double)(ny * nz) * (i < 300 - 256 ? 2 : 1);
        assert_true(fabs((double)h.bins[i] / count - 1) < 0.125);
    }
    free(samples);
}

/* Values far from all others mark missing samples; values that are only at both ends do not. */
static void test_histogram_marks(void **state)
{
    (void)state;
    float samples[1000];
    cvol_volume volume = {cvol_grid_make(10, 10, 10, CVOL_FLOAT32), samples};
    cvol_histogram h;
    for (int side = -1; side <= 1; side++) {
        for (int i = 0; i < 1000; i++)
            samples[i] = i % 10 == 3 && side ? (float)side * 1e35f : (float)i / 1000;
        assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
        assert_int_equal(h.mark_count, side ? 100 : 0);
        expect_near(h.min, 0);
        assert_true(fabs(h.max - 0.999) < 1e-6);
        assert_true(!side || fabs(h.mark / side / 1e35 - 1) < 1e-6);
        uint64_t total = 0;
        for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
            total += h.bins[i];
        assert_true(fabs((double)total / 16 / (side ? 900 : 1000) - 1) < 0.125);
    }
    for (int i = 0; i < 1000; i++) /* a segmentation */
        samples[i] = i % 3 ? 0 : 1000;
    assert_int_equal(cvol_volume_compute_histogram(context, &h, &volume), CVOL_OK);
    assert_true(h.mark_count == 0 && h.max > 999);
    expect_near(h.chord, 20.0 / 3);
}

/* ---- named ------------------------------------------------------------------------------- */

/* Adds a share of samples around `centre`, `width` wide, to the bins. */
static void add_bump(cvol_histogram *h, double centre, double width, double weight)
{
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        h->bins[i] += (uint64_t)(weight * exp(-0.5 * pow((i - centre) / width, 2)));
}

static cvol_transfer *create_named(const char *name, const cvol_histogram *h)
{
    cvol_transfer *t;
    int code = cvol_transfer_create_named(context, &t, name, h);
    if (code)
        fail_msg("%s: %s", name, cvol_context_message(context));
    return t;
}

static double opacity_at_bin(const cvol_transfer *t, const cvol_histogram *h, double bin)
{
    return cvol_transfer_at(t, h->min + (bin + 0.5) * (h->max - h->min) / 256).opacity;
}

static void test_auto_hides_background_and_shows_object(void **state)
{
    (void)state;
    cvol_histogram h = {.min = -1024, .max = 3071}; /* CT: air, soft tissue, bone */
    add_bump(&h, 2, 2, 1e6);
    add_bump(&h, 66, 4, 1e5);
    add_bump(&h, 120, 25, 4e3);
    cvol_transfer *t = create_named("auto", &h);
    expect_near(opacity_at_bin(t, &h, 0), 0);
    expect_near(opacity_at_bin(t, &h, 5), 0);
    double soft = opacity_at_bin(t, &h, 66), bone = opacity_at_bin(t, &h, 140);
    assert_true(soft > 0.005 && soft < 0.1);
    assert_true(bone > 2 * soft && bone <= 0.5);
    cvol_transfer_free(t);
    /* Padding far below the air. */
    cvol_histogram padded = {.min = -3024, .max = 3071};
    add_bump(&padded, 85, 1.5, 1e6);
    add_bump(&padded, 128, 3, 1e5);
    padded.bins[0] = 1500000;
    t = create_named("auto", &padded);
    expect_near(opacity_at_bin(t, &padded, 0), 0);
    expect_near(opacity_at_bin(t, &padded, 85), 0);
    assert_true(opacity_at_bin(t, &padded, 128) > 0.005);
    cvol_transfer_free(t);
}

/* An object of a few samples in a volume of one value, or of noise within one bin. */
static void test_auto_shows_small_objects(void **state)
{
    (void)state;
    for (int side = 0; side < 2; side++) {
        cvol_histogram h = {.min = 0, .max = 1000, .chord = 130};
        for (int i = 1; i < 256; i++)
            h.bins[side ? 255 - i : i] = (uint64_t)(600 / i);
        h.bins[side ? 255 : 0] = 8000000;
        cvol_transfer *t = create_named("auto", &h);
        expect_near(opacity_at_bin(t, &h, side ? 255 : 0), 0);
        assert_true(opacity_at_bin(t, &h, side ? 105 : 150) > 0.1);
        assert_true(opacity_at_bin(t, &h, side ? 0 : 255) > 0.2);
        cvol_transfer_free(t);
        cvol_histogram one = {.min = 0, .max = 1, .chord = 130}; /* of one sample */
        one.bins[side ? 255 : 0] = 8000000;
        one.bins[side ? 0 : 255] = 1;
        t = create_named("field", &one);
        expect_near(opacity_at_bin(t, &one, side ? 255 : 0), 0);
        assert_true(opacity_at_bin(t, &one, side ? 0 : 255) > 0.2);
        cvol_transfer_free(t);
    }
}

/* Small objects on both sides of zero, wherever in its bin zero lies, and of more or fewer samples.
 */
static void test_auto_shows_small_objects_of_two_signs(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        cvol_histogram h = {.min = -0.7 - 0.001 * k, .max = 1, .chord = 50};
        const double width = (h.max - h.min) / 256;
        const int zero = (int)(-h.min / width);
        for (int i = 3; i < 90; i++) {
            h.bins[zero - i] = (uint64_t)(k % 2 ? 30000 : 300) / (uint64_t)i;
            h.bins[zero + i] = (uint64_t)(k % 2 ? 50000 : 500) / (uint64_t)i;
        }
        for (int i = zero - k / 3; i <= zero + k / 3; i++) /* bins of one value may be equal ones */
            h.bins[i] = 500000;
        cvol_transfer *t = create_named("cool-warm", &h);
        expect_near(cvol_transfer_at(t, 0).opacity, 0);
        assert_true(opacity_at_bin(t, &h, zero + 60) > 0.1);
        assert_true(opacity_at_bin(t, &h, zero - 60) > 0.1);
        cvol_transfer_free(t);
    }
}

/* A single value is denser in smaller volumes, as objects are. */
static void test_plain_fits_shape(void **state)
{
    (void)state;
    cvol_histogram h = {.min = 7, .max = 7, .chord = 2.0 / 3};
    h.bins[0] = 1;
    cvol_transfer *small = create_named("auto", &h);
    h.chord = 170;
    cvol_transfer *large = create_named("auto", &h);
    expect_near(cvol_transfer_at(large, 7).opacity, 0.05);
    assert_true(cvol_transfer_at(small, 7).opacity > 0.5);
    cvol_transfer_free(small);
    cvol_transfer_free(large);
}

/* Grey levels are opaque, those of a single slice, too. */
static void test_dense_is_opaque(void **state)
{
    (void)state;
    cvol_histogram h = {.min = 0, .max = 100, .chord = 1000};
    for (int i = 0; i < 256; i++)
        h.bins[i] = 100;
    cvol_transfer *large = create_named("dense", &h);
    h.chord = 2;
    cvol_transfer *slice = create_named("dense", &h);
    const cvol_histogram one = {.min = 7, .max = 7, .chord = 2};
    cvol_transfer *plain = create_named("dense", &one), *lit = create_named("field", &one);
    assert_true(cvol_transfer_is_opaque(slice) && cvol_transfer_is_opaque(plain));
    assert_false(cvol_transfer_is_opaque(lit)); /* one colour */
    cvol_transfer_free(plain);
    cvol_transfer_free(lit);
    expect_near(cvol_transfer_at(large, 50).opacity, 0.5);
    assert_true(cvol_transfer_at(slice, 50).opacity > 0.99);
    cvol_transfer_free(large);
    cvol_transfer_free(slice);
}

static void test_auto_takes_sides(void **state)
{
    (void)state;
    cvol_histogram signed_data = {.min = -1, .max = 1};
    add_bump(&signed_data, 127.5, 5, 1e6);
    add_bump(&signed_data, 127.5, 40, 1e4);
    cvol_transfer *t = create_named("auto", &signed_data);
    assert_true(opacity_at_bin(t, &signed_data, 30) > 0.05);
    assert_true(opacity_at_bin(t, &signed_data, 225) > 0.05);
    expect_near(opacity_at_bin(t, &signed_data, 127), 0);
    cvol_transfer_free(t);
    cvol_histogram inverted = {.min = 0, .max = 255};
    add_bump(&inverted, 250, 2, 1e6);
    add_bump(&inverted, 120, 30, 1e4);
    t = create_named("auto", &inverted);
    expect_near(opacity_at_bin(t, &inverted, 250), 0);
    assert_true(opacity_at_bin(t, &inverted, 100) > 0.01);
    cvol_transfer_free(t);
}

/* Every named function, on histograms of every shape, shows something. */
static void test_every_name_fits_every_histogram(void **state)
{
    (void)state;
    cvol_histogram shapes[7] = {{.min = 0, .max = 0}, {.min = 5, .max = 5}};
    shapes[1].bins[0] = 1000;
    for (int i = 2; i < 7; i++) {
        shapes[i].min = -3;
        shapes[i].max = 1e6;
    }
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        shapes[2].bins[i] = 7;
    shapes[3].bins[0] = 90;
    shapes[3].bins[255] = 10;
    shapes[4].bins[255] = 1000;
    shapes[4].bins[0] = 1;
    add_bump(&shapes[5], 100, 40, 1e5);
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i += 13)
        shapes[6].bins[i] = (uint64_t)(1000 / (i + 1)) + 3;
    char names[200];
    snprintf(names, sizeof names, "%s", cvol_transfer_names());
    int count = 0;
    for (char *name = strtok(names, " "); name; name = strtok(NULL, " "), count++)
        for (int i = 0; i < 7; i++) {
            cvol_transfer *t = create_named(name, &shapes[i]);
            assert_true(cvol_transfer_max_opacity(t, -INFINITY, INFINITY) > 0);
            cvol_transfer_free(t);
        }
    assert_true(count >= 7);
}

/* Thin volumes are denser; both sides of zero are visible. */
static void test_auto_fits_shape(void **state)
{
    (void)state;
    cvol_histogram h = {.min = -1, .max = 1, .chord = 170};
    add_bump(&h, 127.5, 5, 1e6);
    add_bump(&h, 127.5, 40, 1e4);
    cvol_transfer *thick = create_named("auto", &h);
    h.chord = 30;
    cvol_transfer *thin = create_named("auto", &h);
    assert_true(opacity_at_bin(thick, &h, 127 + 20) > 0.005);
    assert_true(opacity_at_bin(thick, &h, 127 - 20) > 0.005);
    assert_true(opacity_at_bin(thin, &h, 127 + 20) > 2 * opacity_at_bin(thick, &h, 127 + 20));
    expect_near(opacity_at_bin(thin, &h, 127), 0);
    cvol_transfer_free(thick);
    cvol_transfer_free(thin);
}

static void test_unknown_name(void **state)
{
    (void)state;
    cvol_histogram h = {.max = 1};
    cvol_transfer *t;
    assert_int_equal(cvol_transfer_create_named(context, &t, "nonesuch", &h), CVOL_ERROR_ARGUMENT);
    assert_null(t);
    assert_non_null(strstr(cvol_context_message(context), cvol_transfer_names()));
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, files_setup, files_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_linear_between_constant_outside),
        TEST(test_jumps_keep_their_order),
        TEST(test_extreme_values),
        TEST(test_bad_points_are_named),
        TEST(test_opacity_over),
        TEST(test_max_opacity_equals_search),
        TEST(test_own_file),
        TEST(test_paraview_file),
        TEST(test_paraview_midpoint_and_sharpness),
        TEST(test_bad_files_are_explained),
        TEST(test_deep_large_and_missing_files),
        TEST(test_histogram_counts),
        TEST(test_tinted),
        TEST(test_component),
        TEST(test_joined_histograms),
        TEST(test_histogram_of_many_samples),
        TEST(test_auto_hides_background_and_shows_object),
        TEST(test_auto_takes_sides),
        TEST(test_dense_is_opaque),
        TEST(test_auto_shows_small_objects),
        TEST(test_auto_shows_small_objects_of_two_signs),
        TEST(test_plain_fits_shape),
        TEST(test_every_name_fits_every_histogram),
        TEST(test_histogram_marks),
        TEST(test_auto_fits_shape),
        TEST(test_unknown_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
