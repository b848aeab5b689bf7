/* Products of whole arrays: every plan against products of the samples in double precision, with
 * the same terms kept; the certified bound; the choice of a plan. */
#include "test.h"

#include "array/core/array.h"
#include "array/multiply/cost.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "transform/whole.h"

#define TOLERANCE 1e-5

enum { ROUNDS_STEP = 2 * SUPPORT_STRIDE - 1 }; /* 1 or 5: coprime to 6 and to the transforms */

static const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};
static const cvol_plan exact_plans[] = {CVOL_PLAN_DIRECT, CVOL_PLAN_GRID, CVOL_PLAN_FULL};

static const size_t shapes[][3] = {{1, 1, 1},  {2, 1, 1},   {3, 1, 1}, {24, 1, 1}, {31, 1, 1},
                                   {97, 1, 1}, {256, 1, 1}, {8, 6, 1}, {7, 10, 1}, {1, 9, 1},
                                   {16, 1, 1}, {13, 16, 1}, {6, 4, 8}, {5, 7, 3},  {8, 5, 6},
                                   {4, 1, 6},  {1, 6, 5},   {1, 1, 8}};
#define SHAPES (sizeof shapes / sizeof shapes[0])

static uint64_t seed; /* of the case at hand, for messages */

static int rank_of(const size_t dims[3])
{
    return dims[2] > 1 ? 3 : dims[1] > 1 ? 2 : 1;
}

static size_t count_of(const size_t dims[3])
{
    return dims[0] * dims[1] * dims[2];
}

/* ---- arrays ---------------------------------------------------------------------------------- */

/* The samples that an array evaluates to, in double precision. */
static double *samples_of(const cvol_array *array)
{
    const size_t *dims = array->grid.dims, count = count_of(dims);
    float *slots = malloc(count * sizeof *slots);
    double *wide = malloc(count * sizeof *wide), *samples = malloc(count * sizeof *samples);
    assert_true(slots && wide && samples);
    cvol_spectrum_scatter(slots, &array->whole, dims);
    for (size_t i = 0; i < count; i++)
        wide[i] = (double)slots[i];
    cvol_whole_inverse_reference(array->transform, samples, wide, dims);
    free(slots);
    free(wide);
    return samples;
}

static cvol_array *make_empty(const size_t dims[3], cvol_transform transform, size_t k)
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const size_t low[3] = {k, k, k};
    cvol_array *array;
    assert_int_equal(cvol_array_create_as(context, &array, &grid, rank_of(dims), transform, 0),
                     CVOL_OK);
    assert_int_equal(cvol_spectrum_start(context, &array->whole, transform, dims, low), CVOL_OK);
    return array;
}

static void add_sparse(cvol_array *array, uint32_t place, float value)
{
    cvol_spectrum *whole = &array->whole;
    if (whole->sparse_count == whole->sparse_capacity)
        assert_int_equal(cvol_spectrum_reserve(context, whole, 2 * whole->sparse_count + 8),
                         CVOL_OK);
    whole->places[whole->sparse_count] = place;
    whole->values[whole->sparse_count++] = value;
}

static int in_box(const cvol_spectrum *whole, size_t place, const size_t dims[3])
{
    const size_t at[3] = {place % dims[0], place / dims[0] % dims[1], place / dims[0] / dims[1]};
    int inside = whole->low_count > 0;
    for (int a = 0; a < 3 && inside; a++)
        inside = cvol_box_index(at[a], whole->low[a], whole->box[a], dims[a]) != SIZE_MAX;
    return inside;
}

/* Values from the samples, as if they were exact; l2_error as given. */
static void set_error_bound(cvol_array *array, double l2_error)
{
    const size_t count = count_of(array->grid.dims);
    double *samples = samples_of(array);
    cvol_error_bound *error_bound = &array->error_bound;
    *error_bound = (cvol_error_bound){
        .l2_error = l2_error, .value_min = (double)INFINITY, .value_max = -(double)INFINITY};
    for (size_t i = 0; i < count; i++) {
        error_bound->value_min = fmin(error_bound->value_min, samples[i]);
        error_bound->value_max = fmax(error_bound->value_max, samples[i]);
        error_bound->max_abs = fmax(error_bound->max_abs, fabs(samples[i]));
    }
    error_bound->value_min -= l2_error;
    error_bound->value_max += l2_error;
    free(samples);
}

/* A low box of k (0: none) and about `share` of the other places. */
static cvol_array *make_array(const size_t dims[3], cvol_transform transform, size_t k,
                              double share, random_state *r)
{
    cvol_array *array = make_empty(dims, transform, k);
    for (size_t i = 0; i < array->whole.low_count; i++)
        array->whole.low_values[i] = (float)random_signed(r);
    for (size_t i = 0; i < count_of(dims); i++)
        if (!in_box(&array->whole, i, dims) && fabs(random_signed(r)) < share)
            add_sparse(array, (uint32_t)i, (float)random_signed(r));
    set_error_bound(array, 0);
    return array;
}

/* ---- the reference --------------------------------------------------------------------------- */

/* Slots of the exact product. */
static double *exact_slots(const cvol_array *a, const cvol_array *b)
{
    const size_t count = count_of(a->grid.dims);
    double *x = samples_of(a), *y = samples_of(b), *slots = malloc(count * sizeof *slots);
    assert_non_null(slots);
    for (size_t i = 0; i < count; i++)
        x[i] *= y[i];
    cvol_whole_forward_reference(a->transform, slots, x, a->grid.dims);
    free(x);
    free(y);
    return slots;
}

/* The reference norm of errors: that of a product of this size without cancellation. */
static double scale_of(const cvol_array *a, const cvol_array *b)
{
    return sqrt(cvol_spectrum_energy(&a->whole)) * cvol_error_bound_largest(&b->error_bound) +
           sqrt(cvol_spectrum_energy(&b->whole)) * cvol_error_bound_largest(&a->error_bound) +
           1e-30;
}

/* Checks a result: its terms are those of the product, the reported dropped norm is the norm of the
 * rest, and the bound holds. */
static void check_result(const cvol_array *out, const cvol_array *a, const cvol_array *b,
                         const char *what)
{
    const size_t *dims = a->grid.dims, count = count_of(dims);
    double *exact = exact_slots(a, b), worst = 0, rest = 0, error = 0;
    float *slots = malloc(count * sizeof *slots);
    char *kept = calloc(count, 1);
    assert_true(slots && kept);
    cvol_spectrum_scatter(slots, &out->whole, dims);
    for (size_t i = 0; i < count; i++)
        kept[i] = (char)in_box(&out->whole, i, dims);
    for (size_t i = 0; i < out->whole.sparse_count; i++)
        kept[out->whole.places[i]] = 1;
    for (size_t i = 0; i < count; i++) {
        const double difference = (double)slots[i] - exact[i];
        error += difference * difference;
        if (kept[i])
            worst = fmax(worst, fabs(difference));
        else
            rest += exact[i] * exact[i];
    }
    const double scale = scale_of(a, b);
    /* both operands are exact here, so the bound is the dropped norm plus rounding */
    const double claimed = out->error_bound.l2_error, dropped = sqrt(rest);
    double *samples = samples_of(out), largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, fabs(samples[i]));
    const int good = worst <= TOLERANCE * scale && fabs(claimed - dropped) <= TOLERANCE * scale &&
                     sqrt(error) <= claimed && largest <= out->error_bound.max_abs;
    if (!good)
        print_error("%s, %s %zux%zux%zu, seed %llu: term off by %g, bound %g, dropped %g, error "
                    "%g, scale %g, largest %g, max_abs %g\n",
                    what, cvol_transform_name(a->transform), dims[0], dims[1], dims[2],
                    (unsigned long long)seed, worst, claimed, dropped, sqrt(error), scale, largest,
                    out->error_bound.max_abs);
    assert_true(good);
    free(samples);
    free(exact);
    free(slots);
    free(kept);
}

static cvol_array *multiply(const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                            cvol_plan plan, cvol_multiply_report *report)
{
    cvol_array *out;
    int code = cvol_array_multiply(context, &out, a, b, keep, plan, report);
    if (code)
        print_error("%s, seed %llu: %s\n", cvol_plan_name(plan), (unsigned long long)seed,
                    cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    return out;
}

/* All exact plans and AUTO, with some rules. */
static void check_plans(const cvol_array *a, const cvol_array *b)
{
    size_t k = a->whole.low[0] ? a->whole.low[0] : 1;
    for (int i = 0; i < rank_of(a->grid.dims); i++)
        k = k < a->grid.dims[i] ? k : a->grid.dims[i];
    const cvol_keep keeps[] = {cvol_keep_all(), cvol_keep_like_inputs(), cvol_keep_terms(k, 0),
                               cvol_keep_terms(0, 5 < count_of(a->grid.dims) ? 5 : 1)};
    for (size_t q = 0; q < sizeof keeps / sizeof keeps[0]; q++) {
        for (size_t p = 0; p < 4; p++) {
            cvol_plan plan = p < 3 ? exact_plans[p] : CVOL_PLAN_AUTO;
            cvol_multiply_report report;
            cvol_array *out = multiply(a, b, &keeps[q], plan, &report);
            check_result(out, a, b, cvol_plan_name(plan));
            assert_true(plan == CVOL_PLAN_AUTO || report.plan == plan);
            assert_true(report.reason[0]);
            if (keeps[q].rule == CVOL_KEEP_ALL)
                assert_true(out->error_bound.l2_error <= TOLERANCE * scale_of(a, b));
            cvol_array_free(out);
        }
    }
}

/* ---- tests ----------------------------------------------------------------------------------- */

static void test_products(void **state)
{
    (void)state;
    for (size_t s = 0; s < SHAPES; s++)
        for (size_t t = 0; t < 3; t++)
            for (int round = (int)(s + t) % ROUNDS_STEP; round < 6; round += ROUNDS_STEP) {
                random_state r = {.state = seed = 1000 * s + 100 * t + (unsigned)round};
                const size_t most = 1 + random_below(&r, 5);
                const double share = round % 3 == 0 ? 0 : round % 3 == 1 ? 0.1 : 1;
                cvol_array *a = make_array(shapes[s], transforms[t], round % 2 ? most : 0,
                                           round == 0 ? 0.3 : share, &r);
                cvol_array *b = make_array(shapes[s], transforms[t], 1 + random_below(&r, 4),
                                           round < 3 ? 0 : share, &r);
                check_plans(a, b);
                cvol_array_free(a);
                cvol_array_free(b);
            }
}

/* Low boxes: the grid has fewer points than there are samples, and holds the whole product. */
static void test_low_boxes(void **state)
{
    (void)state;
    static const size_t large[][3] = {{400, 1, 1}, {397, 1, 1}, {20, 22, 1},
                                      {19, 24, 1}, {10, 8, 9},  {8, 9, 11}};
    for (size_t s = 0; s < 6; s++)
        for (size_t t = 0; t < 3; t++) {
            random_state r = {.state = seed = 77 + 10 * s + t};
            const size_t k = s < 2 ? 20 : s < 4 ? 3 : 2;
            cvol_array *a = make_array(large[s], transforms[t], k, 0, &r);
            cvol_array *b = make_array(large[s], transforms[t], k - 1, 0, &r);
            cvol_multiply_report report;
            for (size_t q = (s + t) % SUPPORT_STRIDE; q < 4; q += SUPPORT_STRIDE) {
                const cvol_keep keeps[] = {cvol_keep_like_inputs(), cvol_keep_all(),
                                           cvol_keep_terms(2 * k + 1, 0), cvol_keep_rho(0.004)};
                cvol_array *out = multiply(a, b, &keeps[q], CVOL_PLAN_GRID, &report);
                assert_true(count_of(report.points) < count_of(large[s]));
                check_result(out, a, b, "low boxes");
                cvol_array_free(out);
            }
            cvol_array_free(a);
            cvol_array_free(b);
        }
}

/* Single terms at the ends of the axes: Nyquist, wrapping round, a DCT's folds. */
static void test_edges(void **state)
{
    (void)state;
    static const size_t small[][3] = {{1, 1, 1}, {2, 1, 1}, {8, 1, 1}, {7, 1, 1},
                                      {4, 3, 1}, {4, 4, 1}, {2, 3, 4}};
    seed = 0;
    for (size_t s = 0; s < 7; s++)
        for (size_t t = 0; t < 3; t++)
            for (size_t p = 0; p < count_of(small[s]); p++)
                for (size_t q = p; q < count_of(small[s]); q += SUPPORT_STRIDE) {
                    cvol_array *a = make_empty(small[s], transforms[t], 0);
                    cvol_array *b = make_empty(small[s], transforms[t], 0);
                    add_sparse(a, (uint32_t)p, 1.5F);
                    add_sparse(b, (uint32_t)q, -2);
                    set_error_bound(a, 0);
                    set_error_bound(b, 0);
                    const cvol_keep all = cvol_keep_all();
                    for (size_t i = 0; i < 3; i++) {
                        cvol_array *out = multiply(a, b, &all, exact_plans[i], NULL);
                        check_result(out, a, b, "edges");
                        cvol_array_free(out);
                    }
                    cvol_array_free(a);
                    cvol_array_free(b);
                }
}

static void test_empty(void **state)
{
    (void)state;
    static const size_t dims[3] = {12, 5, 1};
    for (size_t t = 0; t < 3; t++) {
        random_state r = {.state = seed = 5 + t};
        cvol_array *a = make_array(dims, transforms[t], 3, 0.1, &r);
        cvol_array *none = make_empty(dims, transforms[t], 0);
        check_plans(a, none);
        check_plans(none, a);
        check_plans(none, none);
        cvol_array_free(a);
        cvol_array_free(none);
    }
}

/* Operands with errors: the bound holds for the product of the exact ones. */
static void test_bound_of_inexact(void **state)
{
    (void)state;
    for (size_t s = 0; s < SHAPES; s++)
        for (size_t t = s % SUPPORT_STRIDE; t < 3; t += SUPPORT_STRIDE) {
            random_state r = {.state = seed = 4000 + 10 * s + t};
            const size_t *dims = shapes[s], count = count_of(dims);
            cvol_array *full[2], *kept[2];
            for (int i = 0; i < 2; i++) {
                full[i] = make_array(dims, transforms[t], 0, 1, &r);
                kept[i] = make_empty(dims, transforms[t], 2);
                for (size_t j = 0; j < count; j++)
                    if (!in_box(&kept[i]->whole, j, dims) && random_below(&r, 3) == 0)
                        add_sparse(kept[i], (uint32_t)j, 0);
                float *slots = malloc(count * sizeof *slots);
                assert_non_null(slots);
                cvol_spectrum_scatter(slots, &full[i]->whole, dims);
                for (size_t j = 0; j < kept[i]->whole.sparse_count; j++)
                    kept[i]->whole.values[j] = slots[kept[i]->whole.places[j]];
                free(slots);
                double *exact = samples_of(full[i]), *now = samples_of(kept[i]), error = 0;
                cvol_error_bound *error_bound = &kept[i]->error_bound;
                *error_bound = full[i]->error_bound;
                error_bound->max_abs = 0;
                for (size_t j = 0; j < count; j++) {
                    error += (exact[j] - now[j]) * (exact[j] - now[j]);
                    error_bound->max_abs = fmax(error_bound->max_abs, fabs(now[j]));
                }
                error_bound->l2_error = sqrt(error) * (1 + 1e-12);
                free(exact);
                free(now);
            }
            double *x = samples_of(full[0]), *y = samples_of(full[1]);
            for (size_t p = 0; p < 4; p++) {
                cvol_plan plan = p < 3 ? exact_plans[p] : CVOL_PLAN_AUTO;
                cvol_array *out = multiply(kept[0], kept[1], NULL, plan, NULL);
                double *z = samples_of(out), error = 0;
                for (size_t j = 0; j < count; j++) {
                    error += (z[j] - x[j] * y[j]) * (z[j] - x[j] * y[j]);
                    assert_true(fabs(z[j]) <= out->error_bound.max_abs);
                    assert_true(x[j] * y[j] <= out->error_bound.value_max + 1e-9 &&
                                x[j] * y[j] >= out->error_bound.value_min - 1e-9);
                }
                if (!(sqrt(error) <= out->error_bound.l2_error))
                    print_error("%s, seed %llu: error %g, bound %g\n", cvol_plan_name(plan),
                                (unsigned long long)seed, sqrt(error), out->error_bound.l2_error);
                assert_true(sqrt(error) <= out->error_bound.l2_error);
                free(z);
                cvol_array_free(out);
            }
            free(x);
            free(y);
            for (int i = 0; i < 2; i++) {
                cvol_array_free(full[i]);
                cvol_array_free(kept[i]);
            }
        }
}

/* The same bits for any number of threads. */
static void test_threads(void **state)
{
    (void)state;
    static const size_t large[][3] = {{3000, 1, 1}, {90, 120, 1}, {40, 36, 50}};
    for (size_t s = 0; s < 3; s++)
        for (size_t t = 0; t < 3; t++) {
            random_state r = {.state = seed = 900 + 3 * s + t};
            cvol_array *out[2];
            cvol_array *a = make_empty(large[s], transforms[t], 6);
            for (size_t i = 0; i < a->whole.low_count; i++)
                a->whole.low_values[i] = (float)random_signed(&r);
            a->error_bound = (cvol_error_bound){
                .max_abs = 1e3, .value_min = -1e3, .value_max = 1e3};
            for (size_t p = 1; p < 3; p++) {
                for (int threads = 0; threads < 2; threads++) {
                    cvol_context_set_threads(context, threads ? 5 : 1);
                    out[threads] = multiply(a, a, NULL, exact_plans[p], NULL);
                }
                const cvol_spectrum *x = &out[0]->whole, *y = &out[1]->whole;
                assert_int_equal(x->low_count, y->low_count);
                assert_memory_equal(x->low_values, y->low_values,
                                    x->low_count * sizeof *x->low_values);
                const cvol_error_bound *k = &out[0]->error_bound, *l = &out[1]->error_bound;
                assert_memory_equal(k, l, offsetof(cvol_error_bound, support_known));
                assert_int_equal(k->support_known,
                                 l->support_known); /* bytes behind it may differ */
                cvol_array_free(out[0]);
                cvol_array_free(out[1]);
            }
            cvol_array_free(a);
        }
    cvol_context_set_threads(context, 1);
}

/* AUTO takes the cheapest valid plan. */
static void test_choice(void **state)
{
    (void)state;
    static const size_t dims[3] = {4096, 1, 1};
    cvol_multiply_report report;
    for (size_t t = 0; t < 3; t++) {
        random_state r = {.state = seed = 60 + t};
        cvol_array *few = make_empty(dims, transforms[t], 0);
        add_sparse(few, 1000, 1);
        add_sparse(few, 2500, 1);
        few->error_bound = (cvol_error_bound){.max_abs = 1, .value_min = -1, .value_max = 1};
        cvol_array *low = make_empty(dims, transforms[t], 300);
        for (size_t i = 0; i < low->whole.low_count; i++)
            low->whole.low_values[i] = (float)random_signed(&r);
        low->error_bound = (cvol_error_bound){.max_abs = 100, .value_min = -100, .value_max = 100};
        cvol_array *wide = make_empty(dims, transforms[t], 2049);
        for (size_t i = 0; i < wide->whole.low_count; i++)
            wide->whole.low_values[i] = (float)random_signed(&r);
        wide->error_bound = (cvol_error_bound){.max_abs = 100, .value_min = -100, .value_max = 100};
        const cvol_keep all = cvol_keep_all();
        const cvol_array *operands[] = {few, low, wide};
        const cvol_plan expected[] = {CVOL_PLAN_DIRECT, CVOL_PLAN_GRID, CVOL_PLAN_FULL};
        for (int i = 0; i < 3; i++) {
            cvol_array *out = multiply(operands[i], operands[i], &all, CVOL_PLAN_AUTO, &report);
            assert_int_equal(report.plan, expected[i]);
            for (size_t p = 0; p < 3; p++) {
                assert_true(isfinite(report.cost_ms[exact_plans[p]]));
                assert_true(report.cost_ms[report.plan] <= report.cost_ms[exact_plans[p]]);
            }
            assert_true(isinf(report.cost_ms[CVOL_PLAN_BLOCKS]));
            assert_true(isinf(report.cost_ms[CVOL_PLAN_SPARSE]) == (transforms[t] == CVOL_DCT));
            assert_int_equal(report.terms_out, out->whole.low_count + out->whole.sparse_count);
            cvol_array_free(out);
        }
        cvol_array_free(few);
        cvol_array_free(low);
        cvol_array_free(wide);
    }
}

/* Tests if the proposed grid has no aliases, for many extents. */
static void test_points(void **state)
{
    (void)state;
    random_state r = {.state = seed = 8};
    for (int round = 0; round < 2000; round++) {
        cvol_multiply_task task = {.transform = transforms[random_below(&r, 3)], .rank = 1};
        const size_t n = 1 + random_below(&r, 5000);
        const size_t most = task.transform == CVOL_DCT ? n : n / 2 + 1;
        for (int a = 0; a < 3; a++)
            task.dims[a] = a ? 1 : n;
        task.extent[0][0] = random_below(&r, (uint32_t)most);
        task.extent[1][0] = random_below(&r, (uint32_t)most);
        const size_t sum = task.extent[0][0] + task.extent[1][0];
        const size_t need = task.transform == CVOL_DCT ? sum + 1 : 2 * sum + 1;
        size_t points[3];
        cvol_multiply_points(points, &task);
        assert_true(points[0] == n || (points[0] >= need && points[0] < n));
        assert_true(points[1] == 1 && points[2] == 1);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    static const size_t dims[3] = {16, 1, 1}, other[3] = {17, 1, 1};
    random_state r = {.state = seed = 3};
    cvol_array *out;
    cvol_array *a = make_array(dims, CVOL_DCT, 3, 0, &r),
               *b = make_array(other, CVOL_DCT, 3, 0, &r);
    assert_int_equal(cvol_array_multiply(context, &out, a, b, NULL, CVOL_PLAN_AUTO, NULL),
                     CVOL_ERROR_ARGUMENT);
    assert_null(out);
    assert_int_equal(cvol_array_multiply(context, &out, a, a, NULL, CVOL_PLAN_SPARSE, NULL),
                     CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(cvol_array_multiply(context, &out, a, a, NULL, CVOL_PLAN_BLOCKS, NULL),
                     CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(cvol_array_multiply(context, &out, a, a, NULL, (cvol_plan)17, NULL),
                     CVOL_ERROR_ARGUMENT);
    const cvol_keep wide = cvol_keep_terms(17, 0);
    assert_int_equal(cvol_array_multiply(context, &out, a, a, &wide, CVOL_PLAN_AUTO, NULL),
                     CVOL_ERROR_ARGUMENT);
    a->error_bound.value_max = 1e30;
    assert_int_equal(cvol_array_multiply(context, &out, a, a, NULL, CVOL_PLAN_AUTO, NULL),
                     CVOL_ERROR_DATA);
    assert_null(out);
    cvol_array_free(a);
    cvol_array_free(b);
    assert_string_equal(cvol_plan_name(CVOL_PLAN_GRID), "grid");
    assert_null(cvol_plan_name((cvol_plan)-1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_products),
        cmocka_unit_test(test_low_boxes),
        cmocka_unit_test(test_edges),
        cmocka_unit_test(test_empty),
        cmocka_unit_test(test_bound_of_inexact),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_choice),
        cmocka_unit_test(test_points),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, context_setup_one, context_teardown);
}
