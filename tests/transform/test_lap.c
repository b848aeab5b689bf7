/* The filter across faces: against its definition, inverses, the filtered faces, the matrices, the
 * norms, boxes and halos, and the same bits from every instruction set. */
#include "test.h"

#include "base/cpu.h"
#include "random.h"
#include "support_kernels.h"
#include "transform/lap.h"
#include "transform/lap_faces.h"

#define MAX_SAMPLES (70 * 70 * 70)

static float in[MAX_SAMPLES], fast[MAX_SAMPLES], slow[MAX_SAMPLES];

typedef void filter_function(float *, const cvol_lap_box *, int);

static int64_t count_of(const cvol_lap_box *box)
{
    return box->shape[0] * box->shape[1] * box->shape[2];
}

/* All of a volume, x fastest. */
static cvol_lap_box whole_volume(int64_t nx, int64_t ny, int64_t nz)
{
    return (cvol_lap_box){
        .shape = {nx, ny, nz}, .size = {nx, ny, nz}, .stride = {1, nx, nx * ny}, .grid = 16};
}

static void fill_random(float *data, int64_t count, random_state *r)
{
    for (int64_t i = 0; i < count; i++)
        data[i] = (float)(100 * random_signed(r));
}

static double largest_difference(const float *a, const float *b, int64_t count)
{
    double largest = 0;
    for (int64_t i = 0; i < count; i++)
        largest = fmax(largest, fabs((double)a[i] - (double)b[i]));
    return largest;
}

static double norm(const float *data, int64_t count)
{
    double sum = 0;
    for (int64_t i = 0; i < count; i++)
        sum += (double)data[i] * (double)data[i];
    return sqrt(sum);
}

static double peak(const float *data, int64_t count)
{
    double largest = 0;
    for (int64_t i = 0; i < count; i++)
        largest = fmax(largest, fabs((double)data[i]));
    return largest;
}

static void filter_all(filter_function *filter, float *data, const cvol_lap_box *box)
{
    for (int axis = 0; axis < 3; axis++)
        filter(data, box, axis);
}

/* A volume of any shape, any grid. */
static cvol_lap_box random_volume(random_state *r)
{
    cvol_lap_box box = whole_volume(1 + random_below(r, 70), 1 + random_below(r, 70),
                                    1 + random_below(r, 20));
    static const int64_t grids[] = {16, 16, 8, 4, 5};
    box.grid = grids[random_below(r, 5)];
    return box;
}

static void test_equals_reference(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 60; attempt++) {
        random_state r = {.state = 1u + (unsigned)attempt};
        cvol_lap_box box = random_volume(&r);
        int64_t count = count_of(&box);
        fill_random(in, count, &r);
        for (int axis = 0; axis < 3; axis++)
            for (int post = 0; post < 2; post++) {
                memcpy(fast, in, sizeof(float) * (size_t)count);
                memcpy(slow, in, sizeof(float) * (size_t)count);
                (post ? cvol_lap_post : cvol_lap_pre)(fast, &box, axis);
                (post ? cvol_lap_post_reference : cvol_lap_pre_reference)(slow, &box, axis);
                if (largest_difference(fast, slow, count) > 4e-5)
                    fail_msg("seed %d, axis %d, post %d", attempt, axis, post);
            }
    }
}

static void test_post_inverts_pre(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 60; attempt++) {
        random_state r = {.state = 100u + (unsigned)attempt};
        cvol_lap_box box = random_volume(&r);
        int64_t count = count_of(&box);
        fill_random(in, count, &r);
        memcpy(fast, in, sizeof(float) * (size_t)count);
        filter_all(cvol_lap_pre, fast, &box);
        for (int axis = 2; axis >= 0; axis--)
            cvol_lap_post(fast, &box, axis);
        assert_true(largest_difference(fast, in, count) < 2e-4);
        filter_all(cvol_lap_post, fast, &box);
        filter_all(cvol_lap_pre, fast, &box);
        assert_true(largest_difference(fast, in, count) < 4e-4);
    }
}

/* Constants stay unchanged, to the bit. */
static void test_constants_pass(void **state)
{
    (void)state;
    cvol_lap_box box = whole_volume(40, 35, 33);
    for (int64_t i = 0; i < count_of(&box); i++)
        fast[i] = 0.3f;
    filter_all(cvol_lap_pre, fast, &box);
    filter_all(cvol_lap_post, fast, &box);
    for (int64_t i = 0; i < count_of(&box); i++)
        assert_true(fast[i] == 0.3f);
}

/* A sample changes if and only if it is one of four around a face that has four. */
static void test_which_faces(void **state)
{
    (void)state;
    for (int64_t n = 1; n <= 70; n++) {
        cvol_lap_box box = whole_volume(n, 3, 2);
        for (int axis = 0; axis < 3; axis++) {
            for (int a = 0; a < 3; a++) {
                box.shape[(axis + a) % 3] = box.size[(axis + a) % 3] = a == 0 ? n : 4 - a;
                box.stride[a] = 0;
            }
            box.stride[0] = 1;
            box.stride[1] = box.shape[0];
            box.stride[2] = box.shape[0] * box.shape[1];
            for (int64_t i = 0; i < count_of(&box); i++)
                in[i] = fast[i] = (float)(i * i % 1009 + 7 * i);
            cvol_lap_pre(fast, &box, axis);
            for (int64_t i = 0; i < count_of(&box); i++) {
                int64_t x = i / box.stride[axis] % n, face = (x + 8) / 16 * 16;
                int near = face > 0 && face + 2 <= n && x >= face - 2 && x < face + 2;
                assert_int_equal(near, fast[i] != in[i]);
            }
        }
    }
}

/* The published matrices equal the filters of unit vectors, and are inverses. */
static void test_matrices(void **state)
{
    (void)state;
    cvol_lap_box box = whole_volume(32, 1, 1);
    for (int j = 0; j < 4; j++) {
        memset(fast, 0, sizeof(float) * 32);
        memset(slow, 0, sizeof(float) * 32);
        fast[14 + j] = slow[14 + j] = 1;
        cvol_lap_pre_reference(fast, &box, 0);
        cvol_lap_post_reference(slow, &box, 0);
        for (int i = 0; i < 4; i++) {
            assert_true(fast[14 + i] == cvol_lap_pre_matrix[i][j]);
            assert_true(slow[14 + i] == cvol_lap_post_matrix[i][j]);
            double product = 0;
            for (int k = 0; k < 4; k++)
                product += (double)cvol_lap_pre_matrix[i][k] * (double)cvol_lap_post_matrix[k][j];
            assert_true(fabs(product - (i == j)) < 3e-7);
        }
    }
}

static void test_linearity(void **state)
{
    (void)state;
    static float sum[MAX_SAMPLES];
    cvol_lap_box box = whole_volume(50, 41, 37);
    int64_t count = count_of(&box);
    random_state r = {.state = 3};
    fill_random(in, count, &r);
    fill_random(slow, count, &r);
    for (int64_t i = 0; i < count; i++)
        sum[i] = 3 * in[i] - 2 * slow[i];
    filter_all(cvol_lap_post, in, &box);
    filter_all(cvol_lap_post, slow, &box);
    filter_all(cvol_lap_post, sum, &box);
    for (int64_t i = 0; i < count; i++)
        in[i] = 3 * in[i] - 2 * slow[i];
    assert_true(largest_difference(sum, in, count) < 1e-3);
}

/* A box of a volume, with a halo of two samples, gives the bits of the whole volume. */
static void test_boxes_equal_volume(void **state)
{
    (void)state;
    for (int attempt = 0; attempt < 60; attempt++) {
        random_state r = {.state = 200u + (unsigned)attempt};
        cvol_lap_box box = random_volume(&r);
        int64_t count = count_of(&box);
        int axis = (int)random_below(&r, 3);
        fill_random(in, count, &r);
        memcpy(slow, in, sizeof(float) * (size_t)count);
        cvol_lap_post(slow, &box, axis);
        cvol_lap_box part = box;
        for (int a = 0; a < 3; a++) {
            int64_t end = 1 + random_below(&r, (uint32_t)box.shape[a]);
            part.begin[a] = random_below(&r, (uint32_t)end);
            part.size[a] = end - part.begin[a];
        }
        memcpy(fast, in, sizeof(float) * (size_t)count);
        int64_t first = part.begin[0] * part.stride[0] + part.begin[1] * part.stride[1] +
                        part.begin[2] * part.stride[2];
        cvol_lap_post(fast + first, &part, axis);
        for (int64_t i = 0; i < count; i++) {
            int inside = 1, whole = 1;
            for (int a = 0; a < 3; a++) {
                int64_t x = i / box.stride[a] % box.shape[a], e = (x + 2) / box.grid * box.grid;
                inside &= x >= part.begin[a] && x < part.begin[a] + part.size[a];
                if (a == axis && e > 0 && x < e + 2)
                    whole = e - 2 >= part.begin[a] && e + 2 <= part.begin[a] + part.size[a];
            }
            if (inside && whole ? fast[i] != slow[i] : fast[i] != in[i])
                fail_msg("seed %d, sample %d", attempt, (int)i);
        }
    }
}

/* Memory beyond the volume, such as the rest of whole cells, stays unchanged. */
static void test_beyond_the_volume(void **state)
{
    (void)state;
    cvol_lap_box box = whole_volume(64, 3, 3);
    random_state r = {.state = 4};
    fill_random(in, count_of(&box), &r);
    for (int64_t n = 30; n <= 64; n++) {
        box.shape[0] = n;
        memcpy(fast, in, sizeof in);
        cvol_lap_pre(fast, &box, 0);
        int64_t last = (n - 2) / 16 * 16;
        for (int64_t i = 0; i < 64 * 9; i++)
            if (i % 64 >= last + 2)
                assert_true(fast[i] == in[i]);
        assert_true(fast[last] != in[last]);
    }
}

/* Any axis may be contiguous in memory, or none: the same bits. */
static void test_strides(void **state)
{
    (void)state;
    const int64_t n[3] = {37, 21, 34};
    cvol_lap_box box = whole_volume(n[0], n[1], n[2]);
    random_state r = {.state = 5};
    fill_random(in, count_of(&box), &r);
    static const int orders[][3] = {{1, 0, 2}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}};
    for (int axis = 0; axis < 3; axis++) {
        memcpy(slow, in, sizeof slow);
        cvol_lap_post(slow, &box, axis);
        for (int spread = 1; spread <= 2; spread++)
            for (size_t o = 0; o < sizeof orders / sizeof *orders; o++) {
                cvol_lap_box turned = box;
                int64_t stride = spread;
                for (int a = 0; a < 3; a++) {
                    turned.stride[orders[o][a]] = stride;
                    stride *= n[orders[o][a]];
                }
                for (int pass = 0; pass < 2; pass++) {
                    for (int64_t i = 0; i < count_of(&box); i++) {
                        int64_t at = i % n[0] * turned.stride[0] +
                                     i / n[0] % n[1] * turned.stride[1] +
                                     i / n[0] / n[1] * turned.stride[2];
                        if (pass == 0)
                            fast[at] = in[i];
                        else
                            assert_true(fast[at] == slow[i]);
                    }
                    if (pass == 0)
                        cvol_lap_post(fast, &turned, axis);
                }
            }
    }
}

/* The largest singular value by power iteration on P^T P, in double precision. */
static double measured_norm(const float matrix[4][4])
{
    double x[4] = {1, 0.3, -0.2, 0.7}, length = 0;
    for (int round = 0; round < 400; round++) {
        double y[4] = {0}, z[4] = {0};
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++)
                y[i] += (double)matrix[i][j] * x[j];
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++)
                z[j] += (double)matrix[i][j] * y[i];
        length = sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2] + z[3] * z[3]);
        for (int i = 0; i < 4; i++)
            x[i] = z[i] / length;
    }
    return sqrt(length);
}

/* The largest of a filtered line's magnitudes over all signs of its four samples. */
static double measured_peak(filter_function *filter)
{
    cvol_lap_box box = whole_volume(32, 1, 1);
    double largest = 0;
    for (int signs = 0; signs < 16; signs++) {
        for (int i = 0; i < 32; i++)
            fast[i] = i >= 14 && i < 18 && (signs >> (i - 14) & 1) ? -1.0f : 1.0f;
        filter(fast, &box, 0);
        largest = fmax(largest, peak(fast, 32));
    }
    return largest;
}

static void check_norm(double measured, double bound)
{
    if (measured > bound || measured < 0.99 * bound)
        fail_msg("measured %.9g, bound %.9g", measured, bound);
}

static void test_norms_of_one_axis(void **state)
{
    (void)state;
    check_norm(measured_norm(cvol_lap_post_matrix), CVOL_LAP_POST_NORM);
    check_norm(measured_norm(cvol_lap_pre_matrix), CVOL_LAP_PRE_NORM);
    check_norm(measured_peak(cvol_lap_post), CVOL_LAP_POST_PEAK);
}

/* Products reach the products' norms: constants; signs; the odd part that the pre-filter
 * amplifies. */
static void test_norms_of_three_axes(void **state)
{
    (void)state;
    cvol_lap_box box = whole_volume(32, 32, 32);
    const int64_t count = count_of(&box);
    static const float signs[4] = {-1, 1, 1, 1};
    double w = cos(3.14159265358979323846 / 8), o = sin(3.14159265358979323846 / 8);
    const double odd[4] = {w, o, -o, -w};
    for (int64_t i = 0; i < count; i++) {
        const int64_t x[3] = {i % 32, i / 32 % 32, i / 1024};
        fast[i] = in[i] = slow[i] = 1;
        for (int a = 0; a < 3; a++) {
            int64_t k = x[a] - 14;
            in[i] *= k >= 0 && k < 4 ? signs[k] : 1;
            slow[i] *= k >= 0 && k < 4 ? (float)odd[k] : 0;
        }
    }
    double before = norm(fast, count);
    filter_all(cvol_lap_post, fast, &box);
    check_norm(norm(fast, count) / before, CVOL_LAP_POST_NORM_3);
    filter_all(cvol_lap_post, in, &box);
    check_norm(peak(in, count), CVOL_LAP_POST_PEAK_3);
    before = norm(slow, count);
    filter_all(cvol_lap_pre, slow, &box);
    check_norm(norm(slow, count) / before, CVOL_LAP_PRE_NORM_3);
    for (int attempt = 0; attempt < 20; attempt++) {
        random_state r = {.state = 300u + (unsigned)attempt};
        box = whole_volume(20 + random_below(&r, 50), 20 + random_below(&r, 50), 33);
        fill_random(in, count_of(&box), &r);
        before = norm(in, count_of(&box));
        double before_peak = peak(in, count_of(&box));
        memcpy(fast, in, sizeof in);
        filter_all(cvol_lap_post, fast, &box);
        filter_all(cvol_lap_pre, in, &box);
        assert_true(norm(fast, count_of(&box)) <= CVOL_LAP_POST_NORM_3 * before);
        assert_true(peak(fast, count_of(&box)) <= CVOL_LAP_POST_PEAK_3 * before_peak);
        assert_true(norm(in, count_of(&box)) <= CVOL_LAP_PRE_NORM_3 * before);
    }
}

#if defined(__x86_64__)
typedef void kernel_function(float *, const cvol_lap_faces *, const float *);
CVOL_SIMD_DECLARE(void, cvol_lap_filter,
                  (float *samples, const cvol_lap_faces *faces, const float h[4]));

static void test_same_bits_on_every_set(void **state)
{
    (void)state;
    kernel_function *kernels[] = CVOL_SIMD_SETS(cvol_lap_filter);
    static const float h[4] = CVOL_LAP_POST_H;
    static const cvol_lap_faces ways[] = {
        {.count = 3, .face_stride = 16, .stride = 1, .lines = {50, 9}, .line_stride = {60, 3000}},
        {.count = 3, .face_stride = 800, .stride = 50, .lines = {47, 9}, .line_stride = {1, 3000}},
        {.count = 3, .face_stride = 96, .stride = 6, .lines = {3, 9}, .line_stride = {2, 3000}},
    };
    random_state r = {.state = 7};
    for (int set = 1; set <= (int)cvol_cpu_best(); set++)
        for (size_t way = 0; way < sizeof ways / sizeof *ways; way++) {
            fill_random(in, 27000, &r);
            memcpy(slow, in, sizeof(float) * 27000);
            memcpy(fast, in, sizeof(float) * 27000);
            kernels[0](slow, &ways[way], h);
            kernels[set](fast, &ways[way], h);
            assert_memory_equal(slow, fast, sizeof(float) * 27000);
        }
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equals_reference),
        cmocka_unit_test(test_post_inverts_pre),
        cmocka_unit_test(test_constants_pass),
        cmocka_unit_test(test_which_faces),
        cmocka_unit_test(test_matrices),
        cmocka_unit_test(test_linearity),
        cmocka_unit_test(test_boxes_equal_volume),
        cmocka_unit_test(test_beyond_the_volume),
        cmocka_unit_test(test_strides),
        cmocka_unit_test(test_norms_of_one_axis),
        cmocka_unit_test(test_norms_of_three_axes),
#if defined(__x86_64__)
        cmocka_unit_test(test_same_bits_on_every_set),
#endif
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
