/* Truncation: every rule against sorting, pairs, low boxes, candidates of all shapes, messages. */
#include "test.h"

#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/truncate.h"
#include "random.h"
#include "support_context.h"
#include "transform/whole.h"

#define MAX_SAMPLES 20000

static float slots[MAX_SAMPLES], kept[MAX_SAMPLES];
static double keys[MAX_SAMPLES];
static uint32_t places[MAX_SAMPLES];
static float listed[MAX_SAMPLES];
static float boxed[MAX_SAMPLES];

#define CHECK(condition)                                              \
    do {                                                              \
        if (!(condition)) {                                           \
            print_error("seed %u: %s\n", (unsigned)seed, #condition); \
            fail();                                                   \
        }                                                             \
    } while (0)

static size_t count_of(const size_t dims[3])
{
    return dims[0] * dims[1] * dims[2];
}

static size_t mirror_of(size_t p, const size_t dims[3])
{
    return cvol_mirror_index(p % dims[0], dims[0]) +
           dims[0] * (cvol_mirror_index(p / dims[0] % dims[1], dims[1]) +
                      dims[1] * cvol_mirror_index(p / dims[0] / dims[1], dims[2]));
}

static void random_shape(size_t dims[3], int *rank, random_state *r)
{
    static const size_t lengths[] = {1, 2, 3, 4, 5, 7, 8, 12, 13, 16, 17, 25};
    *rank = 1 + (int)random_below(r, 3);
    for (int a = 0; a < 3; a++)
        dims[a] = a < *rank ? lengths[random_below(r, 12)] : 1;
    if (*rank == 1 && random_below(r, 4) == 0)
        dims[0] = 1000 + random_below(r, 15000);
}

/* kind 0: random and falling; 1: many ties; 2: sparse; 3: all zero */
static void random_slots(size_t n, int kind, random_state *r)
{
    for (size_t i = 0; i < n; i++) {
        const double value = random_signed(r);
        slots[i] = kind == 0   ? (float)(value / (1 + (double)i / 16))
                   : kind == 1 ? (float)(1 + random_below(r, 3)) * (value < 0 ? -1 : 1)
                   : kind == 2 ? (random_below(r, 8) ? 0 : (float)value)
                               : 0;
    }
}

static void find_keys(cvol_transform transform, const size_t dims[3])
{
    for (size_t p = 0; p < count_of(dims); p++) {
        const size_t m = transform == CVOL_DFT ? mirror_of(p, dims) : p;
        const double a = (double)slots[p], b = (double)slots[m];
        keys[p] = sqrt((a * a + b * b) / 2);
    }
}

static int in_box(const cvol_spectrum *s, size_t p, const size_t dims[3])
{
    size_t at[3] = {p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]};
    for (int a = 0; a < 3; a++)
        if (!s->low_count || cvol_box_index(at[a], s->low[a], s->box[a], dims[a]) == SIZE_MAX)
            return 0;
    return 1;
}

static int descending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* Candidates: all slots, a box and a list, or a list. Slots that are neither become 0. */
static cvol_candidates random_candidates(cvol_transform transform, const size_t dims[3],
                                         random_state *r, cvol_spectrum *box)
{
    const size_t n = count_of(dims);
    cvol_candidates c = {.slots = slots};
    const uint32_t kind = random_below(r, 3);
    memset(box, 0, sizeof *box);
    if (kind == 0) {
        for (int a = 0; a < 3; a++) {
            c.box[a] = dims[a];
            c.low[a] = transform == CVOL_DCT ? dims[a] : dims[a] / 2 + 1;
        }
        return c;
    }
    if (kind == 1) {
        size_t low[3];
        for (int a = 0; a < 3; a++)
            low[a] = 1 + random_below(r, (uint32_t)dims[a]);
        assert_int_equal(cvol_spectrum_start(context, box, transform, dims, low), CVOL_OK);
    }
    c.slots = NULL;
    size_t dense = 0;
    for (size_t p = 0; p < n; p++) {
        if (in_box(box, p, dims)) {
            boxed[dense++] = slots[p];
        } else if (slots[p] < 0 || slots[p] > 0 ||
                   (transform == CVOL_DFT && fabsf(slots[mirror_of(p, dims)]) > 0)) {
            places[c.count] = (uint32_t)p;
            listed[c.count++] = slots[p];
        }
    }
    if (dense) {
        c.slots = boxed;
        memcpy(c.low, box->low, sizeof c.low);
        memcpy(c.box, box->box, sizeof c.box);
    }
    c.places = places;
    c.values = listed;
    return c;
}

static cvol_keep random_keep(const size_t dims[3], int rank, double norm, random_state *r)
{
    const size_t n = count_of(dims);
    cvol_keep keep = {0};
    switch (random_below(r, 7)) {
    case 0:
        keep = cvol_keep_all();
        break;
    case 1:
        keep = cvol_keep_terms(0, random_below(r, (uint32_t)n + 1));
        break;
    case 2:
        keep = cvol_keep_rho(0.01 + 0.8 * fabs(random_signed(r)));
        break;
    case 3:
        keep = cvol_keep_ratio(1 + fabs(random_signed(r)));
        break;
    case 4:
        keep = cvol_keep_psnr(5 + 50 * fabs(random_signed(r)));
        break;
    case 5:
        keep = cvol_keep_l2((1e-4 + norm) * fabs(random_signed(r)) + 1e-4 * norm);
        break;
    default:
        keep = cvol_keep_threshold(fabs(random_signed(r)));
    }
    if (random_below(r, 2))
        for (int a = 0; a < rank; a++)
            keep.low[a] = 1 + random_below(r, (uint32_t)dims[a]) / 3;
    return keep;
}

/* Invariants of every rule: values, order, pairs, the dropped norm, and that no term dropped
 * outside of the box is larger than a kept one. */
static void check_kept(unsigned seed, const cvol_array *array, double dropped)
{
    const cvol_spectrum *s = &array->whole;
    const size_t *dims = array->grid.dims, n = count_of(dims);
    double energy = 0, most_dropped = 0, least_kept = INFINITY;
    for (size_t i = 1; i < s->sparse_count; i++)
        CHECK(s->places[i - 1] < s->places[i]);
    for (size_t i = 0; i < s->sparse_count; i++)
        CHECK(!in_box(s, s->places[i], dims));
    cvol_spectrum_scatter(kept, s, dims);
    char *is_kept = calloc(n, 1);
    for (size_t i = 0; i < s->sparse_count; i++)
        is_kept[s->places[i]] = 1;
    for (size_t p = 0; p < n; p++) {
        const size_t m = array->transform == CVOL_DFT ? mirror_of(p, dims) : p;
        if (in_box(s, p, dims) || is_kept[p])
            CHECK(fabsf(kept[p] - slots[p]) <= 0);
        if (in_box(s, p, dims))
            continue;
        CHECK(is_kept[p] == is_kept[m]);
        CHECK(!is_kept[p] || keys[p] > 0);
        if (is_kept[p] && keys[p] < least_kept)
            least_kept = keys[p];
        if (!is_kept[p]) {
            energy += (double)slots[p] * (double)slots[p];
            most_dropped = fmax(most_dropped, keys[p]);
        }
    }
    free(is_kept);
    CHECK(most_dropped <= least_kept * (1 + 1e-6));
    CHECK(fabs(sqrt(energy) - dropped) <= 1e-12 * dropped);
    if (energy <= 0)
        CHECK(array->threshold <= 0);
    else
        CHECK(fabs(array->threshold - (s->sparse_count ? least_kept : most_dropped)) <=
              1e-6 * array->threshold);
}

/* The dropped norm outside of the array's own box when `s` terms are kept. */
static double least_dropped(const cvol_array *array, size_t s, size_t *nonzero)
{
    static double outside[MAX_SAMPLES];
    const size_t *dims = array->grid.dims;
    size_t count = 0;
    double energy = 0;
    for (size_t p = 0; p < count_of(dims); p++)
        if (!in_box(&array->whole, p, dims) && keys[p] > 0)
            outside[count++] = keys[p];
    qsort(outside, count, sizeof *outside, descending);
    for (size_t i = s; i < count; i++)
        energy += outside[i] * outside[i];
    *nonzero = count;
    return sqrt(energy);
}

static void check_rule(unsigned seed, const cvol_array *array, const cvol_keep *keep,
                       double dropped, double norm)
{
    const cvol_spectrum *s = &array->whole;
    const size_t n = count_of(array->grid.dims);
    const size_t pair = array->transform == CVOL_DFT ? 1 : 0;
    size_t nonzero, limit;
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    if ((keep->low[0] || keep->low[1] || keep->low[2]) && keep->rule != CVOL_KEEP_ALL)
        for (int a = 0; a < array->rank; a++)
            CHECK(s->low[a] == keep->low[a] ||
                  (array->transform != CVOL_DCT && s->low[a] == array->grid.dims[a] / 2 + 1));
    switch (keep->rule) {
    case CVOL_KEEP_ALL:
        CHECK(dropped <= 0);
        CHECK(s->low_count + 2 * s->sparse_count <= n + (array->transform == CVOL_DCT ? 0 : 2));
        break;
    case CVOL_KEEP_TERMS:
    case CVOL_KEEP_RHO:
    case CVOL_KEEP_RATIO:
        limit = (size_t)keep->sparse;
        if (keep->rule == CVOL_KEEP_RHO) {
            CHECK(info.rho <= keep->value * (1 + 1e-9));
            limit = (size_t)(keep->value * (double)n - (double)s->low_count) / 2;
        } else if (keep->rule == CVOL_KEEP_RATIO) {
            CHECK(4 * (double)n / (double)info.resident_bytes >= keep->value);
            limit = (size_t)((4 * (double)n / keep->value - (double)CVOL_ARRAY_BYTES) / 4 -
                             (double)s->low_count) /
                    2;
        }
        CHECK(s->sparse_count <= limit);
        CHECK(dropped <=
              (1 + 1e-6) * least_dropped(array, limit < pair ? 0 : limit - pair, &nonzero));
        CHECK(s->sparse_count >= nonzero || s->sparse_count + pair >= limit);
        break;
    case CVOL_KEEP_PSNR:
    case CVOL_KEEP_L2: {
        const double range = array->error_bound.value_max - array->error_bound.value_min;
        double allowed = keep->value, rounding = cvol_array_rounding(array) * norm;
        if (keep->rule == CVOL_KEEP_PSNR)
            allowed = range * sqrt((double)n) * pow(10, -keep->value / 20);
        CHECK(dropped + rounding <= allowed * (1 + 1e-12));
        const size_t fewer = s->sparse_count > 1 + pair ? s->sparse_count - 1 - pair : 0;
        if (s->sparse_count > 1 + pair)
            CHECK(least_dropped(array, fewer, &nonzero) + 2 * rounding >= allowed * (1 - 1e-6));
        break;
    }
    case CVOL_KEEP_THRESHOLD:
        for (size_t p = 0; p < n; p++)
            if (!in_box(s, p, array->grid.dims))
                CHECK(keys[p] > keep->value * (1 + 1e-6)
                          ? keys[p] <= 0 || fabsf(kept[p] - slots[p]) <= 0
                      : keys[p] < keep->value * (1 - 1e-6) ? fabsf(kept[p]) <= 0
                                                           : 1);
        break;
    default:
        break;
    }
}

static void test_rules(void **state)
{
    (void)state;
    int done[8] = {0};
    for (unsigned seed = 0; seed < 3000; seed++) {
        random_state r = {.state = seed};
        size_t dims[3];
        int rank;
        random_shape(dims, &rank, &r);
        const cvol_transform transform = (cvol_transform)(1 + random_below(&r, 3));
        const size_t n = count_of(dims);
        random_slots(n, (int)(seed % 9 == 8 ? 3 : seed % 3), &r);
        find_keys(transform, dims);
        double norm = 0;
        for (size_t i = 0; i < n; i++)
            norm += (double)slots[i] * (double)slots[i];
        norm = sqrt(norm);
        cvol_spectrum box;
        cvol_candidates candidates = random_candidates(transform, dims, &r, &box);
        cvol_keep keep = random_keep(dims, rank, norm, &r);
        cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
        cvol_array *array;
        double dropped;
        assert_int_equal(cvol_array_create_as(context, &array, &grid, rank, transform, 0), CVOL_OK);
        array->error_bound.value_max = 2 * norm / sqrt((double)n);
        cvol_context_set_threads(context, seed % 16 == 0 ? 3 : 1);
        int code = cvol_truncate(context, array, &dropped, &candidates, &keep);
        if (code == CVOL_ERROR_TARGET) {
            CHECK(keep.rule == CVOL_KEEP_RATIO || (keep.rule == CVOL_KEEP_RHO && keep.low[0]));
            CHECK(!array->whole.low_values && !array->whole.places);
        } else {
            if (code)
                print_error("%s\n", cvol_context_message(context));
            CHECK(code == CVOL_OK);
            check_kept(seed, array, dropped);
            check_rule(seed, array, &keep, dropped, norm);
            done[keep.rule]++;
        }
        cvol_array_free(array);
        cvol_spectrum_free(&box);
    }
    for (int rule = CVOL_KEEP_ALL; rule <= CVOL_KEEP_THRESHOLD; rule++)
        assert_true(done[rule] > 20);
}

/* A spectrum dense in a box is stored as a box, a scattered one without, one of both as both. */
static void test_all_chooses_storage(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
            const size_t dims[3] = {24, 20, 18}, n = 24 * 20 * 18;
            random_state r = {.state = 7};
            memset(slots, 0, sizeof slots);
            cvol_spectrum box;
            const size_t low[3] = {5, 5, 5};
            assert_int_equal(cvol_spectrum_start(context, &box, (cvol_transform)t, dims, low),
                             CVOL_OK);
            if (kind != 1)
                for (size_t p = 0; p < n; p++)
                    if (in_box(&box, p, dims))
                        slots[p] = (float)(2 + random_signed(&r));
            for (int i = 0; i < 40 && kind; i++)
                slots[random_below(&r, (uint32_t)n)] = 1;
            find_keys((cvol_transform)t, dims);
            cvol_candidates c = {.slots = slots};
            for (int a = 0; a < 3; a++)
                c.box[a] = c.low[a] = dims[a];
            cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
            cvol_array *array;
            double dropped;
            cvol_keep keep = cvol_keep_all();
            assert_int_equal(cvol_array_create_as(context, &array, &grid, 3, (cvol_transform)t, 0),
                             CVOL_OK);
            assert_int_equal(cvol_truncate(context, array, &dropped, &c, &keep), CVOL_OK);
            check_kept((unsigned)kind, array, dropped);
            if (kind == 1)
                assert_true(array->whole.low_count <= 8);
            else
                assert_int_equal(array->whole.low_count, box.low_count);
            assert_int_equal(kind == 0, array->whole.sparse_count == 0);
            cvol_array_free(array);
            cvol_spectrum_free(&box);
        }
}

/* The same bits for any number of threads, where the work is divided. */
static void test_threads(void **state)
{
    (void)state;
    const size_t n = 3 << 18;
    float *many = malloc(n * sizeof *many);
    random_state r = {.state = 11};
    for (size_t i = 0; i < n; i++)
        many[i] = (float)(random_signed(&r) / (1 + (double)(i % 512)));
    cvol_keep keeps[] = {cvol_keep_rho(0.1), cvol_keep_l2(3), cvol_keep_all(),
                         cvol_keep_terms(9, 5000)};
    cvol_grid grid = cvol_grid_make(512, 48, 32, CVOL_FLOAT32);
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
        for (int k = 0; k < 4; k++) {
            cvol_array *arrays[2];
            double dropped[2];
            cvol_candidates c = {.slots = many, .low = {512, 48, 32}, .box = {512, 48, 32}};
            for (int i = 0; i < 2; i++) {
                assert_int_equal(
                    cvol_array_create_as(context, &arrays[i], &grid, 3, (cvol_transform)t, 0),
                    CVOL_OK);
                cvol_context_set_threads(context, 1 + 3 * i);
                assert_int_equal(cvol_truncate(context, arrays[i], &dropped[i], &c, &keeps[k]),
                                 CVOL_OK);
            }
            const cvol_spectrum *a = &arrays[0]->whole, *b = &arrays[1]->whole;
            assert_memory_equal(&dropped[0], &dropped[1], sizeof *dropped);
            assert_memory_equal(a->low, b->low, sizeof a->low);
            assert_int_equal(a->sparse_count, b->sparse_count);
            if (a->sparse_count)
                assert_memory_equal(a->places, b->places, a->sparse_count * sizeof *a->places);
            cvol_array_free(arrays[0]);
            cvol_array_free(arrays[1]);
        }
    free(many);
}

static void refuse(cvol_keep keep, int block, int code, const char *words)
{
    cvol_grid grid = cvol_grid_make(10, 6, 1, CVOL_FLOAT32);
    cvol_array *array;
    assert_int_equal(cvol_array_create_as(context, &array, &grid, 2, CVOL_DFT, block), CVOL_OK);
    assert_int_equal(cvol_keep_check(context, &keep, array), code);
    if (code && !strstr(cvol_context_message(context), words)) {
        print_error("'%s' does not say '%s'\n", cvol_context_message(context), words);
        fail();
    }
    cvol_array_free(array);
}

static void test_keep_check(void **state)
{
    (void)state;
    refuse(cvol_keep_terms(6, 60), 0, CVOL_OK, "");
    refuse(cvol_keep_terms(7, 0), 0, CVOL_ERROR_ARGUMENT, "k is 7 along y");
    refuse(cvol_keep_terms(0, 61), 0, CVOL_ERROR_ARGUMENT, "s is 61");
    refuse(cvol_keep_terms(9, 0), 8, CVOL_ERROR_ARGUMENT, "k is 9 along x, where the block");
    refuse(cvol_keep_rho(0), 0, CVOL_ERROR_ARGUMENT, "rho is 0");
    refuse(cvol_keep_rho((double)NAN), 0, CVOL_ERROR_ARGUMENT, "rho is");
    refuse(cvol_keep_ratio(-2), 0, CVOL_ERROR_ARGUMENT, "ratio is -2");
    refuse(cvol_keep_psnr((double)INFINITY), 0, CVOL_ERROR_ARGUMENT, "PSNR is inf");
    refuse(cvol_keep_l2(-1), 0, CVOL_ERROR_ARGUMENT, "L2 error is -1");
    refuse(cvol_keep_l2(0), 0, CVOL_OK, "");
    refuse(cvol_keep_threshold(-1), 0, CVOL_ERROR_ARGUMENT, "threshold is -1");
    refuse(cvol_keep_step(1), 0, CVOL_ERROR_ARGUMENT, "a step quantizes blocks");
    refuse(cvol_keep_step(1), 8, CVOL_OK, "");
    refuse(cvol_keep_step(0), 8, CVOL_ERROR_ARGUMENT, "step is 0");
    refuse(cvol_keep_like_inputs(), 0, CVOL_OK, "");
    refuse((cvol_keep){.rule = (cvol_keep_rule)77}, 0, CVOL_ERROR_ARGUMENT,
           "77 is not a cvol_keep_rule");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rules),
        cmocka_unit_test(test_all_chooses_storage),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_keep_check),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
