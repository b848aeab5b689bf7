/* Products and kernels on volumes in DCT blocks, against the same on samples. */
#include "test.h"

#include "array/multiply/block_product.h"
#include "random.h"

/* ---- the product of two blocks ------------------------------------------------------------- */

/* Terms below `low` per axis, about `share` of them; returns the words. */
static uint32_t make_terms(uint32_t *words, random_state *random, int block_log2, const int low[3],
                           double share)
{
    const uint32_t B = 1u << block_log2;
    uint32_t count = 0;
    for (uint32_t place = 0; place < B * B * B; place++) {
        const uint32_t at[3] = {place % B, place / B % B, place / B / B};
        if (at[0] >= (uint32_t)low[0] || at[1] >= (uint32_t)low[1] || at[2] >= (uint32_t)low[2] ||
            fabs(random_signed(random)) > share)
            continue;
        int32_t value = (int32_t)(random_signed(random) * 3000);
        if (random_below(random, 40) == 0)
            value *= 1000000 / 3000; /* an escape where B is 32 */
        if (value)
            count += cvol_term_pack(words + count, place, value, cvol_place_bits(block_log2));
    }
    return count;
}

static void unpack_terms(float *out, const cvol_block *block, int block_log2, float step)
{
    memset(out, 0, sizeof *out << 3 * block_log2);
    const uint32_t *words = block->terms, *end = words + block->words;
    while (words < end) {
        uint32_t place;
        int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        out[place] = step * (float)value;
    }
}

static void product_reference(float *out, const cvol_product_factor *a,
                              const cvol_product_factor *b, int block_log2)
{
    const int B = 1 << block_log2, count = B * B * B;
    float *work = malloc(4 * sizeof *work * (size_t)count);
    assert_non_null(work);
    float *spectrum = work, *fa = work + count, *fb = fa + count, *product = fb + count;
    unpack_terms(spectrum, a->block, block_log2, a->step);
    cvol_block_inverse_reference(fa, spectrum, B);
    unpack_terms(spectrum, b->block, block_log2, b->step);
    cvol_block_inverse_reference(fb, spectrum, B);
    for (int i = 0; i < count; i++)
        product[i] = a->offset * fb[i] + b->offset * fa[i] + fa[i] * fb[i];
    cvol_block_forward_reference(out, product, B);
    free(work);
}

static void check_product(uint64_t seed, int block_log2)
{
    random_state random = {seed};
    const int B = 1 << block_log2, count = B * B * B;
    uint32_t *words[2];
    cvol_block blocks[2] = {{0}};
    for (int i = 0; i < 2; i++) {
        int low[3];
        for (int a = 0; a < 3; a++)
            low[a] = 1 +
                     (int)random_below(&random, (uint32_t)(random_below(&random, 2) ? B : B / 3));
        words[i] = malloc(2 * sizeof **words * (size_t)count);
        assert_non_null(words[i]);
        double share = random_below(&random, 5) == 0 ? 0 : 0.4; /* sometimes no term at all */
        blocks[i].words = make_terms(words[i], &random, block_log2, low, share);
        blocks[i].terms = words[i];
        cvol_block_find_low(&blocks[i], block_log2);
    }
    const cvol_product_factor a = {&blocks[0], 0.25f, (float)(3 * random_signed(&random))};
    const cvol_product_factor b = {&blocks[1], 0.5f, (float)(3 * random_signed(&random))};
    cvol_product_work *work = aligned_alloc(64, sizeof *work);
    float *out = aligned_alloc(64, sizeof *out * (size_t)count);
    float *expected = malloc(sizeof *expected * (size_t)count);
    assert_true(work && out && expected);
    int box[3];
    for (int i = 0; i < count; i++)
        out[i] = NAN; /* nothing beyond the box may be read, and all within it is set */
    cvol_block_product(out, box, &a, &b, block_log2, work);
    product_reference(expected, &a, &b, block_log2);
    double error = 0, energy = 0;
    for (int i = 0; i < count; i++) {
        const int inside = i % B < box[0] && i / B % B < box[1] && i / B / B < box[2];
        const double got = inside ? (double)out[i] : 0;
        error += (got - (double)expected[i]) * (got - (double)expected[i]);
        energy += (double)expected[i] * (double)expected[i];
    }
    if (!(sqrt(error) <= 1e-6 * sqrt(energy))) {
        print_message("seed %llu, B %d: error %g of %g\n", (unsigned long long)seed, B, sqrt(error),
                      sqrt(energy));
        fail();
    }
    free(work);
    free(out);
    free(expected);
    free(words[0]);
    free(words[1]);
}

static void block_products_equal_sample_products(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 60; seed++)
        for (int block_log2 = 3; block_log2 <= 5; block_log2++)
            check_product(seed, block_log2);
}

/* ---- kernels across faces -------------------------------------------------------------------- */

typedef struct field {
    size_t n[3], count;
    double *samples;
} field;

static size_t mirrored(long i, size_t n)
{
    const long period = 2 * (long)n;
    i %= period;
    i += i < 0 ? period : 0;
    return (size_t)(i < (long)n ? i : period - 1 - i);
}

static double tap(const cvol_kernel_line *line, int m)
{
    if (abs(m) > line->radius)
        return 0;
    return m < 0 && line->antisymmetric ? -line->taps[-m] : line->taps[abs(m)];
}

/* samples along one axis with one line of taps, in double precision. */
static void filter_axis(double *samples, const field *f, int axis, const cvol_kernel_line *line)
{
    const size_t n = f->n[axis], stride = axis == 0 ? 1 : axis == 1 ? f->n[0] : f->n[0] * f->n[1];
    double *was = malloc(n * sizeof *was);
    assert_non_null(was);
    for (size_t i = 0; i < f->count; i++) {
        if (i / stride % n)
            continue; /* the first sample of a line */
        for (size_t x = 0; x < n; x++)
            was[x] = samples[i + x * stride];
        for (size_t x = 0; x < n; x++) {
            double sum = 0;
            for (int m = -line->radius; m <= line->radius; m++)
                sum += tap(line, m) * was[mirrored((long)x - m, n)];
            samples[i + x * stride] = sum;
        }
    }
    free(was);
}

static double *convolved(const field *f, const cvol_kernel *kernel)
{
    double *out = calloc(f->count, sizeof *out), *part = malloc(f->count * sizeof *part);
    assert_true(out && part);
    for (int p = 0; p < kernel->parts; p++) {
        memcpy(part, f->samples, f->count * sizeof *part);
        for (int axis = 0; axis < 3; axis++)
            filter_axis(part, f, axis, &kernel->line[p][axis]);
        for (size_t i = 0; i < f->count; i++)
            out[i] += kernel->weight[p] * part[i];
    }
    free(part);
    return out;
}

static void check_kernel(const size_t n[3], int block, const char *text, uint64_t seed)
{
    random_state random = {seed};
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(n[0], n[1], n[2], CVOL_FLOAT32);
    field f = {{n[0], n[1], n[2]}, cvol_grid_samples(&grid), NULL};
    float *samples = malloc(f.count * sizeof *samples);
    f.samples = malloc(f.count * sizeof *f.samples);
    assert_true(context && samples && f.samples);
    for (size_t i = 0; i < f.count; i++)
        samples[i] = (float)(5 + random_signed(&random) * 3 + 4 * sin(0.2 * (double)(i % n[0])));
    const cvol_keep all = cvol_keep_all(), half = cvol_keep_rho(0.2);
    cvol_array *a, *filtered;
    assert_int_equal(cvol_array_compress(context, &a, samples, &grid, 3, CVOL_DCT, block, &half),
                     0);
    const size_t begin[3] = {0, 0, 0};
    assert_int_equal(cvol_array_evaluate_real(context, samples, a, begin, n), 0);
    for (size_t i = 0; i < f.count; i++)
        f.samples[i] = (double)samples[i];
    cvol_kernel kernel;
    assert_int_equal(cvol_kernel_parse(context, &kernel, 3, text), 0);
    int code = cvol_array_convolve_kernel(context, &filtered, a, &kernel, &all);
    if (code)
        print_message("%s\n", cvol_context_message(context));
    assert_int_equal(code, 0);
    assert_int_equal(cvol_array_evaluate_real(context, samples, filtered, begin, n), 0);
    double worst = 0, largest = 0, *expected = convolved(&f, &kernel);
    for (size_t i = 0; i < f.count; i++) {
        worst = fmax(worst, fabs((double)samples[i] - expected[i]));
        largest = fmax(largest, fabs(expected[i]));
    }
    free(expected);
    if (!(worst <= 1e-5 * fmax(largest, 1))) {
        print_message("%s, block %d, %zux%zux%zu: error %g of %g\n", text, block, n[0], n[1], n[2],
                      worst, largest);
        fail();
    }
    cvol_array_free(a);
    cvol_array_free(filtered);
    cvol_context_free(context);
    free(samples);
    free(f.samples);
}

static void kernels_filter_across_faces(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{37, 18, 25}, {16, 16, 16}, {8, 49, 3}, {1, 1, 40},
                                       {17, 33, 9},  {65, 5, 7},   {64, 1, 2}};
    static const char *const kernels[] = {"gaussian:0.7",  "box:7",        "laplacian",
                                          "unsharp:0.6,2", "derivative:x", "derivative:y",
                                          "derivative:z"};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        for (size_t k = 0; k < sizeof kernels / sizeof *kernels; k++)
            for (int block = 8; block <= 32; block *= 2)
                check_kernel(shapes[s], block, kernels[k], s * 100 + k);
    const size_t wide[3] = {70, 40, 36}, middle[3] = {33, 18, 25}, line[3] = {81, 3, 2};
    check_kernel(wide, 32, "gaussian:3", 1);
    check_kernel(middle, 16, "gaussian:2", 2);
    check_kernel(middle, 8, "gaussian:2", 3); /* the largest reach */
    for (size_t x = 0; x <= 16; x += 4) {
        const size_t cut[3] = {line[0] - x, line[1], line[2]};
        check_kernel(cut, 16, "gaussian:4", x);
    }
}

/* ---- default selection of terms -------------------------------------------------------------- */

/* A volume of multiples of a step, as files have them; with `mask` 0 or 1, by halves. */
static cvol_array *quantised(cvol_context *context, double step, int mask)
{
    enum { N = 48 };
    const cvol_grid grid = cvol_grid_make(N, N, N, CVOL_FLOAT32);
    const cvol_keep keep = cvol_keep_step(step);
    float *samples = malloc(N * N * N * sizeof *samples);
    random_state random = {7};
    cvol_array *out;
    assert_non_null(samples);
    for (size_t i = 0; i < N * N * N; i++)
        samples[i] = mask ? (float)(i % N < N / 3)
                          : (float)(20 * random_signed(&random) + 40 * sin(0.1 * (double)(i % N)));
    assert_int_equal(cvol_array_compress(context, &out, samples, &grid, 3, CVOL_DCT, 16, &keep), 0);
    free(samples);
    return out;
}

/* The truncation of a result uses what it may lose, at most a fifth of the bound that the operands
 * carry, but no more. */
static void check_dropped(const cvol_array *out, double carried, double allowed)
{
    const double dropped = out->error_bound.l2_error - carried;
    if (!(dropped <= 1.001 * allowed && dropped >= 0.5 * allowed))
        fail_msg("dropped %g, may drop %g of %g", dropped, allowed, carried);
}

static void results_drop_terms_below_noise(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    assert_non_null(context);
    cvol_array *a = quantised(context, 4, 0), *mask = quantised(context, 1e-3, 1), *out;
    const double error = a->error_bound.l2_error;
    cvol_kernel kernel;
    assert_int_equal(cvol_kernel_gaussian(context, &kernel, 3, 2), 0);
    assert_int_equal(cvol_array_convolve_kernel(context, &out, a, &kernel, NULL), 0);
    check_dropped(out, error, 0.2 * error);
    cvol_array_free(out);
    /* A mask has energy where it is 1, even if that part is small; its own fine step does not
     * decide. */
    const cvol_error_bound product = cvol_error_bound_multiply(&a->error_bound, &mask->error_bound);
    assert_int_equal(cvol_array_multiply(context, &out, a, mask, NULL, CVOL_PLAN_AUTO, NULL), 0);
    check_dropped(out, product.l2_error, fmin(0.2 * product.l2_error, 0.5 * error));
    cvol_array_free(out);
    const cvol_error_bound sum = cvol_error_bound_add(1, &a->error_bound, -3, &mask->error_bound);
    assert_int_equal(cvol_array_add(context, &out, 1, a, -3, mask, NULL), 0);
    check_dropped(out, sum.l2_error, 0.2 * sum.l2_error);
    cvol_array_free(out);
    /* Multiples of one step stay what they are, and a volume added to itself is scaled without
     * loss.
     */
    assert_int_equal(cvol_array_add(context, &out, 1, a, -1, a, NULL), 0);
    assert_int_equal(out->coefficients, 0);
    cvol_array_free(out);
    assert_int_equal(cvol_array_add(context, &out, 1, a, 1, a, NULL), 0);
    assert_true(out->step == 2 * a->step && out->coefficients == a->coefficients);
    assert_true(out->error_bound.l2_error <= 2.01 * error);
    cvol_array_free(out);
    cvol_array_free(a);
    cvol_array_free(mask);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(block_products_equal_sample_products),
        cmocka_unit_test(kernels_filter_across_faces),
        cmocka_unit_test(results_drop_terms_below_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
