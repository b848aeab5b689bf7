/* Counts, means and statistics over regions, and statistics of the whole: those of the original
 * samples must lie within the bounds, for random thresholds and boxes, and the bounds must say
 * something. */
#include "test.h"

#include "base/for_type.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { NX = 45, NY = SUPPORT_SIDE(50), NZ = SUPPORT_SIDE(70), COUNT = NX * NY * NZ, TRIES = 60 };

static cvol_volume make_volume(cvol_type type, double around, random_state *r)
{
    cvol_volume volume = support_volume(NX, NY, NZ, type);
#define SET(t)                                                                                   \
    for (size_t i = 0; i < COUNT; i++) {                                                         \
        const double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / NX / NY); \
        const double value = 100 + 40 * sin(x / 5) * cos(y / 7) + 20 * sin(z / 4);               \
        const int is_inside = hypot(x - 22, y - NY / 2) < 18;                                    \
        ((t *)volume.data)[i] = (t)(is_inside ? value + 4 * random_signed(r) : around);          \
    }
    CVOL_FOR_TYPE(type, SET)
#undef SET
    return volume;
}

/* The figures of the original samples. */
static cvol_region measure(const cvol_volume *volume, const size_t begin[3], const size_t end[3],
                           double least, double largest, int has_void, double fill)
{
    cvol_region out = {.samples = 0};
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            for (size_t x = begin[0]; x < end[0]; x++) {
                const double value = support_sample(volume, x + NX * (y + NY * z));
                if (has_void && value == fill)
                    continue;
                out.samples++;
                out.inside += value >= least && value <= largest;
                out.sum += value;
            }
    out.mean = out.samples ? out.sum / (double)out.samples : 0;
    return out;
}

static void random_box(size_t begin[3], size_t end[3], random_state *r)
{
    const size_t dims[3] = {NX, NY, NZ};
    for (int a = 0; a < 3; a++) {
        begin[a] = random_below(r, (uint32_t)dims[a]);
        end[a] = begin[a] + 1 + random_below(r, (uint32_t)(dims[a] - begin[a]));
    }
}

static void expect_near(const char *what, double got, double want, double bound)
{
    if (!(fabs(got - want) <= bound + 1e-12 * fabs(want)))
        fail_msg("%s is %.12g, not %.12g +- %g", what, want, got, bound);
}

/* Statistics of the samples with a value, and their comparison with twice the samples. */
static void check_statistics(const cvol_volume *volume, const cvol_array *array, int has_void,
                             double fill)
{
    long double sums = 0, sums_of_squares = 0, variation = 0;
    double count = 0;
    cvol_array *twice;
    cvol_array_statistics got;
    cvol_array_comparison compared;
    double inner;
    for (size_t i = 0; i < COUNT; i++) {
        const double value = support_sample(volume, i);
        const int counts = !has_void || value != fill;
        count += counts;
        sums += counts ? value : 0;
        sums_of_squares += counts ? value * value : 0;
    }
    const double sum = (double)sums, squares = (double)sums_of_squares;
    for (size_t i = 0; i < COUNT; i++)
        if (!has_void || support_sample(volume, i) != fill)
            variation += pow(support_sample(volume, i) - sum / count, 2);
    assert_int_equal(cvol_array_compute_statistics(context, &got, array), CVOL_OK);
    expect_near("the sum", got.sum, sum, got.sum_error);
    expect_near("the mean", got.mean, sum / count, got.mean_error);
    expect_near("the L2 norm", got.l2_norm, sqrt(squares), got.l2_norm_error);
    expect_near("the deviation", got.standard_deviation, sqrt((double)variation / count),
                got.standard_deviation_error);
    assert_int_equal(cvol_array_scale(context, &twice, 2, array, 1), CVOL_OK);
    assert_int_equal(cvol_array_compare(context, &compared, array, twice), CVOL_OK);
    expect_near("the inner product", compared.inner_product, 2 * squares + sum,
                compared.inner_product_error);
    expect_near("the distance", compared.distance, sqrt(squares + 2 * sum + count),
                compared.distance_error);
    assert_int_equal(cvol_array_compute_inner_product(context, &inner, array, twice), CVOL_OK);
    assert_true(fabs(inner - compared.inner_product) <= 1e-12 * fabs(inner));
    cvol_array_free(twice);
}

/* The statistics of the original samples of a box, or of its ellipsoid, in double precision. */
static cvol_region_statistics compute(const cvol_volume *volume, const size_t begin[3],
                                      const size_t end[3], cvol_region_shape shape, int has_void,
                                      double fill)
{
    cvol_region_statistics out = {.samples = 0};
    double *kept = malloc(COUNT * sizeof *kept);
    long double sum = 0, variation = 0;
    size_t at[3];
    for (at[2] = begin[2]; at[2] < end[2]; at[2]++)
        for (at[1] = begin[1]; at[1] < end[1]; at[1]++)
            for (at[0] = begin[0]; at[0] < end[0]; at[0]++) {
                const double value = support_sample(volume, at[0] + NX * (at[1] + NY * at[2]));
                double square = 0;
                for (int a = 0; a < 3; a++) {
                    const double side = (double)(end[a] - begin[a]);
                    const double u = 2 * (double)at[a] + 1 - (double)(begin[a] + end[a]);
                    square += u * u / side / side;
                }
                if (has_void && value == fill)
                    continue;
                if (shape == CVOL_REGION_BOX || square <= 1 + 1e-9)
                    kept[out.samples++] = value;
            }
    for (size_t i = 0; i < out.samples; i++) {
        sum += kept[i];
        out.least = i ? fmin(out.least, kept[i]) : kept[i];
        out.largest = i ? fmax(out.largest, kept[i]) : kept[i];
    }
    out.mean = out.samples ? (double)(sum / out.samples) : 0;
    for (size_t i = 0; i < out.samples; i++)
        variation += (kept[i] - out.mean) * (kept[i] - out.mean);
    out.standard_deviation = out.samples ? sqrt((double)(variation / out.samples)) : 0;
    free(kept);
    return out;
}

/* Checks the statistics of a box and of its ellipsoid; returns the largest bound of a mean. */
static double check_shapes(const cvol_volume *volume, const cvol_array *array,
                           const size_t begin[3], const size_t end[3], int has_void, double fill)
{
    double bound = 0;
    for (int shape = CVOL_REGION_BOX; shape <= CVOL_REGION_ELLIPSOID; shape++) {
        cvol_region_statistics got;
        const cvol_region_statistics want = compute(volume, begin, end, (cvol_region_shape)shape,
                                                    has_void, fill);
        assert_int_equal(cvol_array_compute_region_statistics(context, &got, array, begin, end,
                                                              (cvol_region_shape)shape),
                         CVOL_OK);
        assert_int_equal(got.samples, want.samples);
        expect_near("the mean", got.mean, want.mean, got.mean_error);
        expect_near("the deviation", got.standard_deviation, want.standard_deviation,
                    got.standard_deviation_error + 1e-5);
        expect_near("the least sample", got.least, want.least, got.least_error);
        expect_near("the largest sample", got.largest, want.largest, got.largest_error);
        bound = fmax(bound, got.mean_error);
    }
    return bound;
}

/* Returns the mean width of the bounds of the count, as a share of the samples. */
static double check(const cvol_volume *volume, const cvol_compress_options *options,
                    random_state *r)
{
    cvol_array *array;
    double width = 0;
    int whole = 0; /* regions */
    if (cvol_compress(context, &array, NULL, volume->data, &volume->grid, options))
        fail_msg("%s", cvol_context_message(context));
    check_statistics(volume, array, options->has_fill, options->fill);
    cvol_array_statistics whole_volume;
    assert_int_equal(cvol_array_compute_statistics(context, &whole_volume, array), CVOL_OK);
    assert_true(whole_volume.mean_error < 8); /* of a range of 170: 30 dB are 5.4 */
    for (int k = 0; k < TRIES; k += SUPPORT_STRIDE) {
        const uint64_t seed = r->state;
        size_t begin[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
        if (k % 3)
            random_box(begin, end, r);
        double least = 100 + 90 * random_signed(r), largest = least + 80 * fabs(random_signed(r));
        if (k % 2) { /* values that samples have */
            least = floor(least);
            largest = (double)INFINITY;
        }
        cvol_region got;
        assert_int_equal(
            cvol_array_compute_region(context, &got, array, begin, end, least, largest), CVOL_OK);
        const cvol_region want = measure(volume, begin, end, least, largest, options->has_fill,
                                         options->fill);
        if (got.samples != want.samples || want.inside < got.inside_least ||
            want.inside > got.inside_most || got.inside < got.inside_least ||
            got.inside > got.inside_most)
            fail_msg("seed %llu: %llu inside, but %llu .. %llu are promised",
                     (unsigned long long)seed, (unsigned long long)want.inside,
                     (unsigned long long)got.inside_least, (unsigned long long)got.inside_most);
        const double bound = check_shapes(volume, array, begin, end, options->has_fill,
                                          options->fill);
        if (options->lossless)
            assert_true(bound == 0);
        const double rounding = 1e-6 * fabs(want.sum);
        if (!(fabs(got.sum - want.sum) <= got.sum_error + rounding))
            fail_msg("seed %llu: the sum is %g, not %g +- %g", (unsigned long long)seed, want.sum,
                     got.sum, got.sum_error);
        if (!(k % 3)) {
            width += (double)(got.inside_most - got.inside_least) / COUNT;
            whole++;
        }
    }
    cvol_array_free(array);
    return width / whole;
}

static void test_bounds_hold(void **state)
{
    (void)state;
    static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_FLOAT32};
    random_state r = {42};
    for (int t = 0; t < 3; t++) {
        cvol_volume volume = make_volume(types[t], 3, &r);
        cvol_compress_options options = cvol_compress_options_defaults();
        options.effort = CVOL_EFFORT_FAST;
        options.target = CVOL_TARGET_PSNR;
        options.target_value = 30;
        random_state same = r; /* regions */
        const double coarse = check(&volume, &options, &r);
        options.target_value = 48;
        options.background = CVOL_BACKGROUND_VALUE;
        options.background_value = 3;
        const double fine = check(&volume, &options, &same);
        if (test_verbose())
            print_message("width of the bounds: %g of the samples at 30 dB, %g at 48 dB\n", coarse,
                          fine);
        assert_true(fine < coarse && fine < 0.1);
        options.background = CVOL_BACKGROUND_NONE;
        options.has_fill = 1;
        options.fill = 3;
        check(&volume, &options, &r);
        options.has_fill = 0;
        options.max_error = 2;
        check(&volume, &options, &r);
        options.max_error = 0;
        options.lossless = 1;
        assert_true(check(&volume, &options, &r) == 0);
        free(volume.data);
    }
}

/* Values of types and sizes that single precision does not hold, with samples that have no value or
 * a background. */
static void test_statistics_of_masked_volumes(void **state)
{
    (void)state;
    static const struct {
        cvol_type type;
        double middle, spread;
    } cases[] = {{CVOL_FLOAT64, 1000, 1},   {CVOL_UINT32, 2e9, 3000}, {CVOL_INT32, -1e9, 1e8},
                 {CVOL_FLOAT64, 0.3, 1e-7}, {CVOL_FLOAT32, 16e6, 5},  {CVOL_UINT8, 100, 90}};
    random_state r = {9};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const cvol_type type = cases[k].type;
        cvol_volume volume = support_volume(NX, NY, NZ, type);
        const double outside = cvol_type_is_integer(type) ? 7 : 0.1;
        for (size_t i = 0; i < COUNT; i++) {
            const double x = (double)(i % NX), z = (double)(i / NX / NY);
            const double value = cases[k].middle +
                                 cases[k].spread *
                                     (0.7 * sin(x / 5) * cos(z / 4) + 0.3 * random_signed(&r));
#define SET(t) ((t *)volume.data)[i] = (t)(z < 6 ? outside : value)
            CVOL_FOR_TYPE(type, SET)
#undef SET
        }
        const double fill = support_sample(&volume, 0);
        for (int mode = 0; mode < 4; mode++) {
            cvol_compress_options options = cvol_compress_options_defaults();
            cvol_array *array;
            options.effort = CVOL_EFFORT_FAST;
            options.target = CVOL_TARGET_PSNR;
            options.target_value = 50;
            options.lossless = mode == 0;
            options.max_error = mode == 1 ? fmax(1, cases[k].spread / 100) : 0;
            options.has_fill = mode < 3;
            options.fill = fill;
            options.background = mode < 3 ? CVOL_BACKGROUND_NONE : CVOL_BACKGROUND_VALUE;
            options.background_value = fill;
            check_ok(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options));
            check_statistics(&volume, array, options.has_fill, fill);
            cvol_array_free(array);
        }
        free(volume.data);
    }
}

/* Extremes of values that single precision does not hold. */
static void test_large_offset(void **state)
{
    (void)state;
    random_state r = {7};
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT64);
    double *x = volume.data, least = (double)INFINITY, largest = -least;
    for (size_t i = 0; i < COUNT; i++) {
        x[i] = 1e6 + 1e-3 * (sin((double)(i % NX) / 5) + random_signed(&r));
        least = fmin(least, x[i]);
        largest = fmax(largest, x[i]);
    }
    for (int psnr = 40; psnr <= 70; psnr += 30) {
        cvol_compress_options options = cvol_compress_options_defaults();
        options.target = CVOL_TARGET_PSNR;
        options.target_value = psnr;
        cvol_array *array;
        cvol_region_statistics got;
        const size_t begin[3] = {0, 0, 0};
        check_ok(cvol_compress(context, &array, NULL, x, &volume.grid, &options));
        check_ok(cvol_array_compute_region_statistics(context, &got, array, begin, volume.grid.dims,
                                                      CVOL_REGION_BOX));
        assert_true(fabs(got.least - least) <= got.least_error);
        assert_true(fabs(got.largest - largest) <= got.largest_error);
        cvol_array_free(array);
    }
    free(volume.data);
}

/* Samples far from 0, whose differences no float has: figures of lossless files are those of the
 * samples, and deviations of lossy ones do not cancel. */
static void test_differences_far_from_zero(void **state)
{
    (void)state;
    random_state r = {8};
    for (int k = 0; k < 8; k++) {
        const int is_lossless = k % 2, has_void = k / 2 % 2, is_double = k / 4;
        const double middle = is_double ? 1e9 : 4e9;
        cvol_volume volume = support_volume(NX, NY, NZ, is_double ? CVOL_FLOAT64 : CVOL_UINT32);
        double sum = 0, squares = 0, count = 0; /* of what samples have above the middle */
        uint64_t inside = 0;
        for (size_t i = 0; i < COUNT; i++) {
            const double wave = 100 * sin((double)(i % NX) / 5) + 20 * random_signed(&r);
            const double x = is_double ? middle + wave / 100 : middle + rint(wave);
            const int is_void = has_void && i % NX < 9;
            if (is_double)
                ((double *)volume.data)[i] = is_void ? 0 : x;
            else
                ((uint32_t *)volume.data)[i] = is_void ? 0 : (uint32_t)x;
            sum += is_void ? 0 : x - middle;
            squares += is_void ? 0 : (x - middle) * (x - middle);
            count += !is_void;
            inside += (uint64_t)(!is_void && x >= middle);
        }
        cvol_compress_options options = cvol_compress_options_defaults();
        options.target = CVOL_TARGET_PSNR;
        options.target_value = 50;
        options.lossless = is_lossless;
        options.has_fill = has_void;
        cvol_array *array;
        cvol_array_statistics all;
        cvol_region_statistics box;
        cvol_region region;
        const size_t begin[3] = {0, 0, 0}, *dims = volume.grid.dims;
        check_ok(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options));
        check_ok(cvol_array_compute_statistics(context, &all, array));
        check_ok(cvol_array_compute_region_statistics(context, &box, array, begin, dims,
                                                      CVOL_REGION_BOX));
        check_ok(cvol_array_compute_region(context, &region, array, begin, dims, middle,
                                           (double)INFINITY));
        const double mean = sum / count, deviation = sqrt(squares / count - mean * mean);
        const double near = (is_lossless ? 1e-6 : 1e-2) * deviation;
        assert_true(fabs(all.mean - middle - mean) <= 1e-2 * deviation);
        assert_true(fabs(all.standard_deviation - deviation) <= 1e-2 * deviation);
        assert_true(fabs(box.mean - middle - mean) <= near);
        assert_true(fabs(box.standard_deviation - deviation) <= near);
        assert_true(region.inside_least <= inside && inside <= region.inside_most);
        if (is_lossless) {
            assert_true(region.inside_least == inside && region.inside_most == inside);
            assert_true(box.mean_error <= 0 && box.least_error <= 0);
        }
        cvol_array_free(array);
        free(volume.data);
    }
}

/* Decoded floats are clamped to the range of the original ones, and so are the extremes. */
static void test_constant_floats(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    const size_t begin[3] = {0, 0, 0};
    const cvol_keep all = cvol_keep_all();
    cvol_region_statistics got;
    cvol_array *array;
    for (size_t i = 0; i < COUNT; i++)
        ((float *)volume.data)[i] = 1000000.3F;
    check_ok(
        cvol_array_compress(context, &array, volume.data, &volume.grid, 3, CVOL_DCT, 16, &all));
    check_ok(cvol_array_measure(context, array, volume.data));
    check_ok(cvol_array_compute_region_statistics(context, &got, array, begin, volume.grid.dims,
                                                  CVOL_REGION_BOX));
    assert_true(fabs(got.least - (double)1000000.3F) <= got.least_error);
    assert_true(fabs(got.largest - (double)1000000.3F) <= got.largest_error);
    cvol_array_free(array);
    free(volume.data);
}

/* Small deviations far from the middle of the volume's range: nothing cancels. */
static void test_small_deviation(void **state)
{
    (void)state;
    random_state r = {9};
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    float *x = volume.data;
    for (size_t i = 0; i < COUNT; i++)
        x[i] = i % NX < 20 ? 0 : i % NX < 30 ? 1e6F : 1e6F + 0.0625F * (float)random_below(&r, 3);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *array;
    check_ok(cvol_compress(context, &array, NULL, x, &volume.grid, &options));
    for (int part = 0; part < 2; part++) {
        const size_t begin[3] = {part ? 30 : 20, 0, 0}, end[3] = {part ? NX : 30, NY, NZ};
        const double count = (double)((end[0] - begin[0]) * NY * NZ);
        double sum = 0, squares = 0; /* of x - 1e6, which are exact */
        for (size_t i = 0; i < COUNT; i++)
            if (i % NX >= begin[0] && i % NX < end[0]) {
                sum += (double)x[i] - 1e6;
                squares += ((double)x[i] - 1e6) * ((double)x[i] - 1e6);
            }
        const double sd = sqrt(squares / count - (sum / count) * (sum / count));
        cvol_region_statistics got;
        check_ok(cvol_array_compute_region_statistics(context, &got, array, begin, end,
                                                      CVOL_REGION_BOX));
        expect_near("deviation", got.standard_deviation, sd, got.standard_deviation_error + 1e-9);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Noise in a background that no float holds. */
static cvol_array *make_spots(cvol_volume *volume, double background)
{
    random_state r = {8};
    double *samples = volume->data;
    for (size_t i = 0; i < COUNT; i++)
        samples[i] = i % NX > 16 ? background : 4 + random_signed(&r);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 25;
    options.background = CVOL_BACKGROUND_VALUE;
    options.background_value = background;
    cvol_array *array;
    if (cvol_compress(context, &array, NULL, samples, &volume->grid, &options))
        fail_msg("%s", cvol_context_message(context));
    return array;
}

/* The samples of a result are those of `volume`, scaled by 3 or not at all. */
static void expect_spots(const cvol_array *array, const cvol_volume *volume, double factor)
{
    const size_t begin[3] = {10, 0, 1}, end[3] = {NX, NY, 3};
    const double original = support_sample(volume, NX - 1), least = factor * original;
    const cvol_region want = measure(volume, begin, end, original, original, 0, 0);
    cvol_region got;
    cvol_region_statistics figures;
    assert_int_equal(cvol_array_compute_region(context, &got, array, begin, end, least, least),
                     CVOL_OK);
    assert_true(want.inside > 0);
    assert_in_range(want.inside, got.inside_least, got.inside_most);
    expect_near("mean", got.mean, factor * want.mean, got.mean_error);
    assert_int_equal(
        cvol_array_compute_region_statistics(context, &figures, array, begin, end, CVOL_REGION_BOX),
        CVOL_OK);
    expect_near("mean", figures.mean, factor * want.mean, figures.mean_error);
    expect_near("least", figures.least, least, figures.least_error);
}

/* A background of doubles is exact; that of a result is a float. */
static void test_spots(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT64);
    cvol_array *array = make_spots(&volume, 0.1), *result;
    expect_spots(array, &volume, 1);
    assert_int_equal(cvol_array_scale(context, &result, 3, array, 0), CVOL_OK);
    expect_spots(result, &volume, 3);
    cvol_array_free(result);
    cvol_array_free(array);
    free(volume.data);
}

static void test_wrong_regions(void **state)
{
    (void)state;
    random_state r = {1};
    cvol_volume volume = make_volume(CVOL_UINT8, 3, &r);
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    cvol_region out;
    const size_t zero[3] = {0, 0, 0}, end[3] = {NX, NY, NZ}, far[3] = {NX, NY, NZ + 1};
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options),
                     CVOL_OK);
    assert_int_equal(cvol_array_compute_region(context, &out, array, zero, far, 0, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_compute_region(context, &out, array, zero, zero, 0, 1),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_compute_region(context, &out, array, zero, end, 1, 0),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_array_compute_region(context, &out, array, zero, end, (double)NAN, 0),
                     CVOL_ERROR_ARGUMENT);
    cvol_array_free(array);
    free(volume.data);
}

/* A box of constant values, an anisotropic ellipse of one slice, and a wrong shape. */
static void test_exact_statistics(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_INT16);
    const size_t begin[3] = {10, 7, 4}, end[3] = {20, 11, 5}, far[3] = {NX, NY, NZ + 1};
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_region_statistics got;
    cvol_array *array;
    options.lossless = 1;
    for (size_t i = 0; i < COUNT; i++) {
        const size_t x = i % NX, y = i / NX % NY, z = i / NX / NY;
        const int is_inside = x >= 10 && x < 20 && y >= 7 && y < 11 && z == 4;
        ((int16_t *)volume.data)[i] = (int16_t)(is_inside ? 1234 : (int)(i % 100) - 50);
    }
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options),
                     CVOL_OK);
    assert_int_equal(
        cvol_array_compute_region_statistics(context, &got, array, begin, end, CVOL_REGION_BOX),
        CVOL_OK);
    assert_int_equal(got.samples, 40);
    assert_true(got.mean == 1234 && got.standard_deviation == 0);
    assert_true(got.least == 1234 && got.largest == 1234);
    assert_true(got.mean_error == 0 && got.standard_deviation_error == 0);
    assert_true(got.least_error == 0 && got.largest_error == 0);
    assert_int_equal(cvol_array_compute_region_statistics(context, &got, array, begin, end,
                                                          CVOL_REGION_ELLIPSOID),
                     CVOL_OK);
    /* rows at +-1/4 of the radius have |u| <= 0.968: all 10 samples; at +-3/4, 0.661: 6 of 10 */
    assert_int_equal(got.samples, 32);
    assert_int_equal(cvol_array_compute_region_statistics(context, &got, array, begin, end,
                                                          (cvol_region_shape)2),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(
        cvol_array_compute_region_statistics(context, &got, array, begin, far, CVOL_REGION_BOX),
        CVOL_ERROR_ARGUMENT);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_bounds_hold),
                                       TEST(test_large_offset),
                                       TEST(test_differences_far_from_zero),
                                       TEST(test_statistics_of_masked_volumes),
                                       TEST(test_spots),
                                       TEST(test_wrong_regions),
                                       TEST(test_exact_statistics),
                                       TEST(test_small_deviation),
                                       TEST(test_constant_floats)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
