/* Operations on volumes with a separate background or with samples that have no value: the same
 * operation on the decoded samples, in double precision, is the reference. A result may be off by
 * what its truncation dropped: its bound less the bound that the operands carry. */
#include "test.h"

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

/* Cells at the far faces are partial. */
enum { NX = 53, NY = SUPPORT_SIDE(42), NZ = SUPPORT_SIDE(58), COUNT = NX * NY * NZ };

static const size_t dims[3] = {NX, NY, NZ}, zero[3] = {0, 0, 0};

/* ---- operands -------------------------------------------------------------------------------- */

/* What is around a body; FACE: a background that ends at the faces of blocks. */
typedef enum around { BACKGROUND, FACE, VOID, NOTHING } around;

typedef struct body {
    around around;
    double value; /* of what is around it */
    double shift; /* along x */
    int lapped;
} body;

static int is_inside(size_t i, double shift)
{
    const double x = (double)(i % NX) / NX - 0.5 - shift, y = (double)(i / NX % NY) / NY - 0.45,
                 z = (double)(i / NX / NY) / NZ - 0.55;
    return x * x + 1.2 * y * y + z * z < 0.15;
}

static cvol_array *make_body(const body *of, uint64_t seed)
{
    random_state r = {seed};
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    float *samples = volume.data;
    for (size_t i = 0; i < COUNT; i++) {
        const double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / NX / NY);
        samples[i] = (float)(70 + 15 * sin(x / 5 + (double)seed) * cos(y / 6) + 9 * sin(z / 4) +
                             random_signed(&r));
        if (of->around == FACE ? i % NX < 16 : of->around != NOTHING && !is_inside(i, of->shift))
            samples[i] = (float)of->value;
    }
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 40;
    options.effort = CVOL_EFFORT_FAST;
    options.lapped = of->lapped;
    options.has_fill = of->around == VOID;
    options.fill = of->value;
    options.background = of->around <= FACE ? CVOL_BACKGROUND_VALUE : CVOL_BACKGROUND_NONE;
    options.background_value = of->value;
    cvol_array *array;
    if (cvol_compress(context, &array, NULL, samples, &volume.grid, &options))
        fail_msg("%s", cvol_context_message(context));
    assert_true((array->mask != NULL) == (of->around != NOTHING));
    free(samples);
    return array;
}

/* The array's samples, and 1 for those without a value. Terms define those: the operations continue
 * them. Public functions give their fill instead. */
static double *decode(const cvol_array *array, uint8_t *is_void)
{
    float *real = malloc(COUNT * sizeof *real);
    double *out = malloc(COUNT * sizeof *out);
    assert_true(real && out);
    assert_int_equal(cvol_array_evaluate_unmasked(context, real, array, zero, dims), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        out[i] = (double)real[i];
    free(real);
    memset(is_void, 0, COUNT);
    if (cvol_mask_is_void(array->mask))
        cvol_mask_get(is_void, array->mask, zero, dims);
    return out;
}

/* ---- the comparison -------------------------------------------------------------------------- */

/* The result against its reference, apart from samples without a value, of which there must be
 * `voids`. `carried`: the bound of the operands. */
static void check(cvol_array *result, const double *reference, const uint8_t *voids, double carried,
                  const char *what)
{
    uint8_t *is_void = malloc(COUNT);
    assert_non_null(is_void);
    double *samples = decode(result, is_void), squares = 0, norm = 0;
    for (size_t i = 0; i < COUNT; i++) {
        if ((is_void[i] != 0) != (voids[i] != 0))
            fail_msg("%s: sample %zu has %s value", what, i, is_void[i] ? "no" : "a");
        const double off = samples[i] - reference[i];
        squares += voids[i] ? 0 : off * off;
        norm += reference[i] * reference[i];
    }
    const double dropped = result->error_bound.l2_error - carried;
    if (!(sqrt(squares) <= dropped + 1e-6 * sqrt(norm)))
        fail_msg("%s: off by %g, the bound allows %g", what, sqrt(squares), dropped);
    /* By default, truncation adds at most a fifth. */
    if (!(dropped <= 0.2 * carried + 4e-5 * sqrt(norm)))
        fail_msg("%s: dropped %g, the operands %g", what, dropped, carried);
    if (test_verbose())
        print_message("%s: off by %g, may be off by %g, operands %g\n", what, sqrt(squares),
                      dropped, carried);
    free(samples);
    free(is_void);
    cvol_array_free(result);
}

static const cvol_array *checked(int code, cvol_array *const *array)
{
    if (code)
        fail_msg("%s", cvol_context_message(context));
    return *array;
}

static uint64_t background_in(const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    return info.background_samples;
}

/* ---- two operands ---------------------------------------------------------------------------- */

/* An operand, its samples, and which of them have no value. */
typedef struct operand {
    body body;
    cvol_array *array;
    double *samples;
    uint8_t *voids;
} operand;

static operand make_operand(const body *of, uint64_t seed)
{
    operand o = {.body = *of, .array = make_body(of, seed), .voids = malloc(COUNT)};
    assert_non_null(o.voids);
    o.samples = decode(o.array, o.voids);
    return o;
}

static void free_operand(operand *o)
{
    cvol_array_free(o->array);
    free(o->samples);
    free(o->voids);
}

static void add_and_multiply(const operand *x, const operand *y)
{
    const cvol_array *a = x->array, *b = y->array;
    const double *p = x->samples, *q = y->samples;
    cvol_array *result;
    uint8_t *voids = malloc(COUNT);
    double *reference = malloc(COUNT * sizeof *reference);
    assert_true(voids && reference);
    for (size_t i = 0; i < COUNT; i++) {
        reference[i] = 1.5 * p[i] - 0.75 * q[i];
        voids[i] = x->voids[i] || y->voids[i];
    }
    const cvol_error_bound sum = cvol_error_bound_add(1.5, &a->error_bound, -0.75, &b->error_bound);
    checked(cvol_array_add(context, &result, 1.5, a, -0.75, b, NULL), &result);
    const int alike = x->body.around == y->body.around && x->body.shift == y->body.shift;
    if (alike && x->body.around == BACKGROUND)
        assert_int_equal(background_in(result), background_in(a));
    check(result, reference, voids, sum.l2_error, "add");

    for (size_t i = 0; i < COUNT; i++)
        reference[i] = p[i] * q[i];
    const cvol_error_bound product = cvol_error_bound_multiply(&a->error_bound, &b->error_bound);
    checked(cvol_array_multiply(context, &result, a, b, NULL, CVOL_PLAN_AUTO, NULL), &result);
    if (x->body.around == BACKGROUND && x->body.value == 0 && y->body.around != VOID)
        assert_true(background_in(result) >= background_in(a));
    check(result, reference, voids, product.l2_error, "multiply");
    free(reference);
    free(voids);
}

static void test_two_operands(void **state)
{
    (void)state;
    static const body bodies[] = {
        {BACKGROUND, 0, 0, 1}, {BACKGROUND, 0, 0.2, 1}, {BACKGROUND, -40, 0.1, 1},
        {BACKGROUND, 7, 0, 0}, {NOTHING, 0, 0, 1},      {NOTHING, 0, 0, 0},
        {VOID, 1e35, -0.2, 1}, {VOID, -9999, 0.1, 0},   {FACE, -40, 0, 1}};
    enum { BODIES = sizeof bodies / sizeof *bodies };
    operand first[BODIES], second[BODIES];
    for (int k = 0; k < BODIES; k++) {
        first[k] = make_operand(&bodies[k], 1);
        second[k] = make_operand(&bodies[k], 2);
    }
    for (int k = 0; k < BODIES * BODIES; k += SUPPORT_STRIDE)
        add_and_multiply(&first[k / BODIES], &second[k % BODIES]);
    for (int k = 0; k < BODIES; k++) {
        free_operand(&first[k]);
        free_operand(&second[k]);
    }
}

/* ---- one operand ----------------------------------------------------------------------------- */

static size_t mirror(long x, size_t n)
{
    return (size_t)(x < 0 ? -1 - x : x >= (long)n ? 2 * (long)n - 1 - x : x);
}

/* One line of taps along an axis. */
static void filter_axis(double *out, const double *in, int axis, const double *taps, int radius,
                        int sign)
{
    for (size_t i = 0; i < COUNT; i++) {
        size_t at[3] = {i % NX, i / NX % NY, i / NX / NY};
        const long here = (long)at[axis];
        out[i] = 0;
        for (int t = -radius; t <= radius; t++) {
            at[axis] = mirror(here - t, dims[axis]);
            out[i] += taps[t < 0 ? -t : t] * (t < 0 ? sign : 1) *
                      in[at[0] + NX * (at[1] + NY * at[2])];
        }
    }
}

static void filter_reference(double *out, const double *in, const cvol_kernel *kernel)
{
    double *other = malloc(COUNT * sizeof *other);
    assert_non_null(other);
    assert_int_equal(kernel->parts, 1);
    memcpy(out, in, COUNT * sizeof *out);
    for (int axis = 0; axis < 3; axis++) {
        const cvol_kernel_line *line = &kernel->line[0][axis];
        filter_axis(other, out, axis, line->taps, line->radius, line->antisymmetric ? -1 : 1);
        memcpy(out, other, COUNT * sizeof *out);
    }
    for (size_t i = 0; i < COUNT; i++)
        out[i] *= kernel->weight[0];
    free(other);
}

static void gradient_reference(double *out, const double *in)
{
    static const double taps[2] = {0, 0.5};
    double *one = malloc(COUNT * sizeof *one);
    assert_non_null(one);
    memset(out, 0, COUNT * sizeof *out);
    for (int axis = 0; axis < 3; axis++) {
        filter_axis(one, in, axis, taps, 1, -1);
        for (size_t i = 0; i < COUNT; i++)
            out[i] += one[i] * one[i];
    }
    for (size_t i = 0; i < COUNT; i++)
        out[i] = sqrt(out[i]);
    free(one);
}

static void filter(const body *x)
{
    static const char *const names[] = {"gaussian:1", "derivative:x", "box:3"};
    cvol_array *a = make_body(x, 3), *result;
    uint8_t *voids = malloc(COUNT);
    assert_non_null(voids);
    double *p = decode(a, voids), *reference = malloc(COUNT * sizeof *reference);
    assert_non_null(reference);
    const double error = a->error_bound.l2_error;
    for (size_t i = 0; i < COUNT; i++)
        reference[i] = -2 * p[i] + 3;
    checked(cvol_array_scale(context, &result, -2, a, 3), &result);
    assert_int_equal(background_in(result), background_in(a));
    check(result, reference, voids, 2 * error, "scale");
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        cvol_kernel kernel;
        assert_int_equal(cvol_kernel_parse(context, &kernel, 3, names[k]), CVOL_OK);
        filter_reference(reference, p, &kernel);
        checked(cvol_array_convolve_kernel(context, &result, a, &kernel, NULL), &result);
        check(result, reference, voids, error, names[k]);
    }
    gradient_reference(reference, p);
    checked(cvol_array_gradient(context, &result, a, NULL), &result);
    check(result, reference, voids, sqrt(3) * error, "gradient");
    cvol_array_free(a);
    free(p);
    free(reference);
    free(voids);
}

static void test_one_operand(void **state)
{
    (void)state;
    static const body bodies[] = {
        {BACKGROUND, 0, 0, 1}, {BACKGROUND, -40, 0.1, 0}, {VOID, 1e35, 0, 1}, {NOTHING, 0, 0, 1}};
    for (size_t k = 0; k < sizeof bodies / sizeof *bodies; k++)
        filter(&bodies[k]);
}

/* ---- hidden samples -------------------------------------------------------------------------- */

/* True if the mask hides all samples that a block of a lapped volume reaches. */
static int is_hidden(const cvol_array *array, size_t index)
{
    uint8_t which[20 * 20 * 20];
    size_t begin[3], end[3], count = 1;
    cvol_block_origin(begin, array, index);
    for (int a = 0; a < 3; a++) {
        end[a] = begin[a] + 18 < dims[a] ? begin[a] + 18 : dims[a];
        begin[a] = begin[a] ? begin[a] - 2 : 0;
        count *= end[a] - begin[a];
    }
    return cvol_mask_get(which, array->mask, begin, end) == count;
}

/* Blocks of a result that the mask hides have no terms, and the loss of hidden samples does not
 * count: the rest of the result may lose what the bound allows. */
static void test_hidden_samples(void **state)
{
    (void)state;
    const body head = {BACKGROUND, 0, 0, 1};
    operand x = make_operand(&head, 1), y = make_operand(&head, 2);
    cvol_array *sum;
    checked(cvol_array_add(context, &sum, 1, x.array, 0.7, y.array, NULL), &sum);
    size_t hidden = 0;
    for (size_t i = 0; i < sum->block_count; i++)
        if (is_hidden(sum, i)) {
            assert_int_equal(sum->block_table[i].words, 0);
            hidden++;
        }
    assert_true(hidden > 0);
    const cvol_error_bound carried = cvol_error_bound_add(1, &x.array->error_bound, 0.7,
                                                          &y.array->error_bound);
    double *samples = decode(sum, x.voids), squares = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const double off = samples[i] - x.samples[i] - 0.7 * y.samples[i];
        squares += off * off;
    }
    const double added = sum->error_bound.l2_error - carried.l2_error;
    if (test_verbose())
        print_message("%zu hidden blocks; off by %g, added %g\n", hidden, sqrt(squares), added);
    assert_true(sqrt(squares) <= added);
    assert_true(sqrt(squares) > 0.8 * added);
    free(samples);
    cvol_array_free(sum);
    free_operand(&x);
    free_operand(&y);
}

/* ---- backgrounds behind filters -------------------------------------------------------------- */

/* True if all samples of the volume within `radius` are background. */
static int is_deep(const uint8_t *background, size_t i, size_t radius)
{
    const size_t at[3] = {i % NX, i / NX % NY, i / NX / NY};
    size_t begin[3], end[3];
    for (int a = 0; a < 3; a++) {
        begin[a] = at[a] > radius ? at[a] - radius : 0;
        end[a] = at[a] + radius < dims[a] ? at[a] + radius + 1 : dims[a];
    }
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            for (size_t x = begin[0]; x < end[0]; x++)
                if (!background[x + NX * (y + NY * z)])
                    return 0;
    return 1;
}

static void expect_background(const cvol_array *result, const uint8_t *background, size_t radius,
                              double value)
{
    uint8_t *got = malloc(COUNT);
    float *samples = malloc(COUNT * sizeof *samples);
    assert_true(got && samples && cvol_mask_is_background(result->mask));
    assert_true(cvol_array_background(result) == (double)(float)value);
    assert_int_equal(cvol_array_evaluate_real(context, samples, result, zero, dims), CVOL_OK);
    cvol_mask_get(got, result->mask, zero, dims);
    size_t count = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const int deep = is_deep(background, i, radius);
        assert_int_equal(got[i], deep);
        assert_true(!deep || samples[i] == (float)value);
        count += (size_t)deep;
    }
    assert_true(count > 0);
    free(got);
    free(samples);
}

/* The result of a filter is background, exactly, if the filter reads only background. A kernel that
 * smooths the edge away leaves none: a mask would only take bytes. */
static void test_background_behind_filters(void **state)
{
    (void)state;
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *a = make_body(&(body){BACKGROUND, -40, 0.1, lapped}, 6), *result;
        uint8_t *background = malloc(COUNT);
        assert_non_null(background);
        cvol_mask_get(background, a->mask, zero, dims);
        checked(cvol_array_gradient(context, &result, a, NULL), &result);
        expect_background(result, background, 1, 0);
        cvol_array_free(result);
        static const char *const names[] = {"box:3", "derivative:y", "box:5", "gaussian:1"};
        static const size_t radii[] = {1, 1, 2, 0};
        for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
            cvol_kernel kernel;
            assert_int_equal(cvol_kernel_parse(context, &kernel, 3, names[k]), CVOL_OK);
            checked(cvol_array_convolve_kernel(context, &result, a, &kernel, NULL), &result);
            if (!radii[k])
                assert_null(result->mask);
            else if (k == 1) /* it reads one line */
                assert_true(cvol_array_background(result) == 0 && background_in(result) > 0);
            else
                expect_background(result, background, radii[k], -40);
            cvol_array_free(result);
        }
        cvol_array_free(a);
        free(background);
    }
}

/* ---- types ----------------------------------------------------------------------------------- */

/* The background and samples without a value survive another type. */
static void test_types(void **state)
{
    (void)state;
    cvol_array *a = make_body(&(body){BACKGROUND, 2.5, 0, 1}, 4), *half;
    cvol_array_info before, after;
    assert_int_equal(cvol_array_scale(context, &half, 0.5, a, 0), CVOL_OK);
    assert_true(cvol_array_background(half) == 1.25);
    cvol_array_get_info(&before, half);
    assert_int_equal(cvol_array_set_type(context, half, CVOL_UINT8), CVOL_OK);
    assert_true(cvol_array_background(half) == 1);
    cvol_array_get_info(&after, half); /* all samples of the background moved by a quarter */
    const double moved = 0.25 * sqrt((double)after.background_samples);
    assert_true(after.l2_error - before.l2_error >= 0.999 * moved);
    assert_true(after.point_error - before.point_error >= 0.249);
    assert_int_equal(background_in(half), background_in(a));
    uint8_t *bytes = malloc(COUNT);
    assert_non_null(bytes);
    assert_int_equal(cvol_array_evaluate_box(context, bytes, half, zero, dims), CVOL_OK);
    assert_int_equal(bytes[0], 1);
    free(bytes);
    cvol_array_free(half);
    cvol_array_free(a);
    a = make_body(&(body){VOID, (double)NAN, 0, 1}, 5);
    assert_int_equal(cvol_array_scale(context, &half, 0.5, a, 0), CVOL_OK);
    assert_int_equal(cvol_array_set_type(context, half, CVOL_UINT8), CVOL_ERROR_DATA);
    assert_non_null(strstr(cvol_context_message(context), "samples without a value"));
    cvol_array_free(half);
    cvol_array_free(a);
}

/* ---- fills ------------------------------------------------------------------------------------
 */

static void expect_voids(const cvol_array *array, const uint8_t *which, int fills, const char *what)
{
    void *bytes;
    size_t size;
    cvol_array *back;
    uint8_t *is_void = malloc(COUNT);
    assert_non_null(is_void);
    assert_int_equal(cvol_mask_fills(array->mask)->count, fills);
    assert_int_equal(cvol_array_write_memory(context, array, &bytes, &size), CVOL_OK);
    if (cvol_array_read_memory(context, &back, bytes, size, what))
        fail_msg("%s", cvol_context_message(context));
    cvol_mask_get(is_void, back->mask, zero, dims);
    for (size_t i = 0; i < COUNT; i++)
        if (is_void[i] != which[i])
            fail_msg("%s: sample %zu has fill %d, must have %d", what, i, is_void[i], which[i]);
    cvol_array_free(back);
    free(bytes);
    free(is_void);
}

/* Floats of samples without a value are their fill, as samples are, with a residual and without. */
static void test_floats_of_fills(void **state)
{
    (void)state;
    static const double fills[] = {1e35, (double)NAN, -9999};
    uint8_t *is_void = malloc(COUNT);
    float *real = malloc(COUNT * sizeof *real), *samples = malloc(COUNT * sizeof *samples);
    assert_true(is_void && real && samples);
    for (int k = 0; k < 6; k++) {
        cvol_array *array = make_body(&(body){VOID, fills[k / 2], 0, 1}, 9);
        if (k % 2) { /* a lossless file of the same samples */
            cvol_compress_options options = cvol_compress_options_defaults();
            options.lossless = options.has_fill = 1;
            options.fill = fills[k / 2];
            check_ok(cvol_array_evaluate_box(context, samples, array, zero, dims));
            const cvol_grid grid = array->grid;
            cvol_array_free(array);
            check_ok(cvol_compress(context, &array, NULL, samples, &grid, &options));
        }
        assert_true(cvol_array_evaluate_mask(is_void, array, zero, dims) > 0);
        check_ok(cvol_array_evaluate_box(context, samples, array, zero, dims));
        check_ok(cvol_array_evaluate_real(context, real, array, zero, dims));
        for (size_t i = 0; i < COUNT; i++)
            assert_true(!is_void[i] || !memcmp(&real[i], &samples[i], sizeof *real));
        cvol_array_free(array);
    }
    free(is_void);
    free(real);
    free(samples);
}

/* Equal fills of two operands are one fill of the result, and its file can be read. */
static void test_equal_fills(void **state)
{
    (void)state;
    static const double values[3] = {1e35, 1e35, -7};
    for (int other = 1; other < 3; other++) {
        cvol_array *a = make_body(&(body){VOID, values[0], 0, 1}, 6);
        cvol_array *b = make_body(&(body){VOID, values[other], 0.1, 1}, 7), *sum;
        uint8_t *which = malloc(COUNT);
        assert_non_null(which);
        for (size_t i = 0; i < COUNT; i++)
            which[i] = !is_inside(i, 0) ? 1 : !is_inside(i, 0.1) ? (uint8_t)other : 0;
        assert_int_equal(cvol_array_add(context, &sum, 1, a, 1, b, NULL), CVOL_OK);
        expect_voids(sum, which, other, other == 1 ? "equal fills" : "two fills");
        cvol_array_free(sum);
        cvol_array_free(b);
        cvol_array_free(a);
        free(which);
    }
}

/* Bit patterns of NaN that differ in float64 and not in float32. */
static void test_equal_fills_of_a_type(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT64);
    double *samples = volume.data;
    uint8_t *which = calloc(COUNT, 1);
    assert_non_null(which);
    for (size_t i = 0; i < COUNT; i++)
        samples[i] = sin((double)(i % NX) / 7);
    for (size_t i = 0; i < COUNT; i += 1 + i % 7) {
        const uint64_t bits = UINT64_C(0x7ff8) << 48 | i % 5 % 3;
        memcpy(&samples[i], &bits, sizeof bits);
        which[i] = 1;
    }
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    options.has_fill = 1;
    options.fill = (double)NAN;
    cvol_array *array, *same;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &volume.grid, &options),
                     CVOL_OK);
    assert_int_equal(cvol_mask_fills(array->mask)->count, 3);
    assert_int_equal(cvol_array_scale(context, &same, 1, array, 0), CVOL_OK);
    expect_voids(same, which, 1, "result");
    assert_int_equal(cvol_array_set_type(context, array, CVOL_FLOAT32), CVOL_OK);
    expect_voids(array, which, 1, "other type");
    cvol_array_free(same);
    cvol_array_free(array);
    free(which);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_two_operands),   TEST(test_one_operand),
        TEST(test_hidden_samples), TEST(test_background_behind_filters),
        TEST(test_types),          TEST(test_floats_of_fills),
        TEST(test_equal_fills),    TEST(test_equal_fills_of_a_type)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
