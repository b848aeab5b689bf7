/* Values of results: operations on arrays whose samples s mean scale s + offset, compared with the
 * same operation on the values in double precision. */
#include "test.h"

#include "array/core/array.h"
#include "cvol/algebra.h"
#include "random.h"
#include "support_context.h"

enum { NX = 24, NY = 20, NZ = 16, COUNT = NX * NY * NZ };

static const size_t dims[3] = {NX, NY, NZ}, zero[3] = {0, 0, 0};

typedef struct operand {
    cvol_array *array;
    double values[COUNT];
} operand;

static void make(operand *out, double scale, double offset, int block, uint64_t seed)
{
    random_state r = {seed};
    cvol_grid grid = cvol_grid_make(NX, NY, NZ, CVOL_FLOAT32);
    const cvol_keep keep = block ? cvol_keep_step(0.01) : cvol_keep_all();
    float samples[COUNT];
    grid.value_scale = scale;
    grid.value_offset = offset;
    for (size_t i = 0; i < COUNT; i++) {
        const double x = (double)(i % NX), z = (double)(i / NX / NY);
        samples[i] = (float)(10 + 4 * sin(x / 3 + (double)seed) * cos(z / 4) + random_signed(&r));
        out->values[i] = scale * (double)samples[i] + offset;
    }
    check_ok(cvol_array_compress(context, &out->array, samples, &grid, 3,
                                 block ? CVOL_DCT : CVOL_DHT, block, &keep));
}

/* The result's values are those of `wanted`, within its bound in values. */
static void check(const char *what, cvol_array *result, const double *wanted)
{
    const cvol_grid *grid = cvol_array_grid(result);
    float samples[COUNT];
    double squares = 0, norm = 0;
    cvol_array_info info;
    check_ok(cvol_array_evaluate_real(context, samples, result, zero, dims));
    cvol_array_get_info(&info, result);
    for (size_t i = 0; i < COUNT; i++) {
        const double value = grid->value_scale * (double)samples[i] + grid->value_offset;
        squares += pow(value - wanted[i], 2);
        norm += wanted[i] * wanted[i];
    }
    const double bound = fabs(grid->value_scale) * info.l2_error + 1e-5 * sqrt(norm);
    if (!(sqrt(squares) <= bound && bound < 0.2 * sqrt(norm)))
        fail_msg("%s: off by %g, bound %g, norm %g", what, sqrt(squares), bound, sqrt(norm));
    cvol_array_free(result);
}

static void check_operations(double scale, double offset, double other, double other_offset,
                             int block)
{
    static operand a, b;
    static double wanted[COUNT];
    cvol_array *out;
    make(&a, scale, offset, block, 1);
    make(&b, other, other_offset, block, 2);
#define WANT(value)                    \
    for (size_t i = 0; i < COUNT; i++) \
    wanted[i] = (value)
    check_ok(cvol_array_scale(context, &out, -3, a.array, 2));
    WANT(-3 * a.values[i] + scale * 2);
    check("scale", out, wanted);
    check_ok(cvol_array_negate(context, &out, a.array));
    WANT(-a.values[i]);
    check("negate", out, wanted);
    check_ok(cvol_array_truncate(context, &out, a.array, NULL));
    WANT(a.values[i]);
    check("truncate", out, wanted);
    check_ok(cvol_array_add(context, &out, 2, a.array, -0.5, b.array, NULL));
    WANT(2 * a.values[i] - 0.5 * b.values[i]);
    check("add", out, wanted);
    check_ok(cvol_array_multiply(context, &out, a.array, b.array, NULL, CVOL_PLAN_AUTO, NULL));
    WANT(a.values[i] * b.values[i]);
    check("multiply", out, wanted);
    check_ok(cvol_array_multiply(context, &out, a.array, a.array, NULL, CVOL_PLAN_AUTO, NULL));
    WANT(a.values[i] * a.values[i]);
    check("square", out, wanted);
    cvol_kernel kernel;
    check_ok(cvol_kernel_parse(context, &kernel, 3, "box:1"));
    kernel.weight[0] *= 3; /* three times each sample */
    check_ok(cvol_array_convolve_kernel(context, &out, a.array, &kernel, NULL));
    WANT(3 * a.values[i]);
    check("convolve", out, wanted);
#undef WANT
    if (!block) {
        check_ok(cvol_array_convolve(context, &out, a.array, b.array, NULL));
        for (size_t i = 0; i < COUNT; i++) {
            wanted[i] = 0;
            const size_t x = i % NX, y = i / NX % NY, z = i / NX / NY;
            for (size_t k = 0; k < COUNT; k++) {
                const size_t p = (x + NX - k % NX) % NX, q = (y + NY - k / NX % NY) % NY,
                             r = (z + NZ - k / NX / NY) % NZ;
                wanted[i] += a.values[k] * b.values[p + NX * (q + NY * r)];
            }
        }
        check("convolve two", out, wanted);
    }
    cvol_array_free(a.array);
    cvol_array_free(b.array);
}

static void test_operations(void **state)
{
    (void)state;
    static const double pairs[][4] = {
        {2.5, -7, 2.5, 100}, {2.5, -7, -1, 5}, {1, -1024, 1, 0}, {-0.5, 0, 4, 0}, {1, 0, 1, 0}};
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++)
        for (int block = 0; block <= 8; block += 8)
            check_operations(pairs[k][0], pairs[k][1], pairs[k][2], pairs[k][3], block);
}

/* The gradient of values is |scale| times that of samples. */
static void test_gradient(void **state)
{
    (void)state;
    static operand a, b;
    cvol_array *of[2];
    static float samples[2][COUNT];
    make(&a, -2.5, 30, 8, 4);
    make(&b, 1, 0, 8, 4);
    check_ok(cvol_array_gradient(context, &of[0], a.array, NULL));
    check_ok(cvol_array_gradient(context, &of[1], b.array, NULL));
    for (int i = 0; i < 2; i++)
        check_ok(cvol_array_evaluate_real(context, samples[i], of[i], zero, dims));
    assert_memory_equal(samples[0], samples[1], sizeof samples[0]);
    assert_true(fabs(cvol_array_grid(of[0])->value_scale - 2.5) <= 0);
    assert_true(fabs(cvol_array_grid(of[0])->value_offset) <= 0);
    cvol_array_free(of[0]);
    cvol_array_free(of[1]);
    cvol_array_free(a.array);
    cvol_array_free(b.array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_operations, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_gradient, context_setup, context_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
