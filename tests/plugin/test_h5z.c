/* The HDF5 filter's chunks without HDF5: parameters, round trips of samples, and damage. */
#include "test.h"

#include "h5z_cvol.h"

#define ROOM 400

/* A chunk of 20 x 12 x 7 samples: parameters as HDF5 keeps them. */
static void set_words(unsigned words[CVOL_H5Z_WORDS], unsigned mode, double value, cvol_type type)
{
    const unsigned all[] = {mode, 0, 0, CVOL_H5Z_LAYOUT_1, type, 0, 20, 12, 7};
    memcpy(words, all, sizeof all);
    cvol_h5z_put_value(words, value);
}

static cvol_h5z_plan plan_of(const unsigned *words)
{
    cvol_h5z_plan plan;
    char message[ROOM];
    assert_true(cvol_h5z_read_plan(&plan, words, CVOL_H5Z_WORDS, message, sizeof message));
    return plan;
}

static float value_at(size_t i)
{
    return 60 + 50 * sinf((float)(i % 20) / 7) * cosf((float)(i / 20 % 12) / 5) +
           (float)(i * 7 % 5);
}

enum { SAMPLES = 20 * 12 * 7 };

static void test_options(void **state)
{
    static const struct {
        unsigned words[3];
        size_t count;
        cvol_target target;
        double value;
        int lossless;
    } good[] = {{{0}, 0, CVOL_TARGET_RATIO, 30, 0},
                {{1, 12}, 2, CVOL_TARGET_RATIO, 12, 0},
                {{2, 0, 0x40450000}, 3, CVOL_TARGET_PSNR, 42, 0},
                {{3, 0}, 2, CVOL_TARGET_MAX_ERROR, 0, 0},
                {{4, 0, 0x3fe00000}, 3, CVOL_TARGET_BITS, 0.5, 0},
                {{5}, 1, CVOL_TARGET_RATIO, 30, 1}};
    static const struct {
        unsigned words[3];
        size_t count;
        const char *says;
    } bad[] = {{{0, 3}, 2, "mode is 0"},
               {{6, 3}, 2, "mode is 6"},
               {{1}, 1, "value is 0"},
               {{1, 0, 0xbff00000}, 3, "value is -1"},
               {{2, 0, 0x7ff80000}, 3, "value is nan"}};
    cvol_compress_options options;
    char message[ROOM];
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_true(
            cvol_h5z_read_options(&options, good[i].words, good[i].count, message, sizeof message));
        assert_int_equal(options.target, good[i].target);
        assert_true(fabs(options.target_value - good[i].value) <= 0);
        assert_int_equal(options.lossless, good[i].lossless);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_false(
            cvol_h5z_read_options(&options, bad[i].words, bad[i].count, message, sizeof message));
        assert_non_null(strstr(message, bad[i].says));
    }
}

static void test_plans(void **state)
{
    static const struct {
        int word;
        unsigned value;
        const char *says;
    } bad[] = {{CVOL_H5Z_LAYOUT, 2, "do not match layout 1"},
               {CVOL_H5Z_TYPE, 0, "type 0"},
               {CVOL_H5Z_TYPE, 9, "type 9"},
               {CVOL_H5Z_ORDER, 2, "byte order 2"},
               {CVOL_H5Z_NX, 0, "0 x 12 x 7"},
               {CVOL_H5Z_NY, 0x20000000, "x 536870912 x"},
               {CVOL_H5Z_MODE, 9, "mode is 9"}};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        unsigned words[CVOL_H5Z_WORDS];
        cvol_h5z_plan plan;
        char message[ROOM] = "";
        set_words(words, 1, 10, CVOL_UINT8);
        words[bad[i].word] = bad[i].value;
        assert_false(cvol_h5z_read_plan(&plan, words, CVOL_H5Z_WORDS, message, sizeof message));
        assert_non_null(strstr(message, bad[i].says));
        assert_false(cvol_h5z_read_plan(&plan, words, 3, message, sizeof message));
    }
}

/* High byte first is low byte first with swapped bytes: the decoded samples equal the given
 * ones. */
static void test_orders(void **state)
{
    uint8_t low[2 * SAMPLES], high[2 * SAMPLES];
    (void)state;
    for (size_t i = 0; i < SAMPLES; i++) {
        const unsigned v = (unsigned)value_at(i) * 200;
        low[2 * i] = high[2 * i + 1] = (uint8_t)v;
        low[2 * i + 1] = high[2 * i] = (uint8_t)(v >> 8);
    }
    for (unsigned order = 0; order < 2; order++) {
        unsigned words[CVOL_H5Z_WORDS];
        set_words(words, CVOL_H5Z_LOSSLESS, 0, CVOL_UINT16);
        words[CVOL_H5Z_ORDER] = order;
        const cvol_h5z_plan plan = plan_of(words);
        void *code, *back;
        size_t size;
        char message[ROOM];
        assert_int_equal(plan.bytes, sizeof low);
        assert_true(cvol_h5z_encode(&code, &size, &plan, order ? high : low, message, ROOM));
        assert_true(size < sizeof low);
        assert_true(cvol_h5z_decode(&back, &plan, code, size, message, ROOM));
        assert_memory_equal(back, order ? high : low, sizeof low);
        free(code);
        free(back);
    }
}

/* Samples without a value are kept, and the others within the bound: NaN, and values far from all
 * others. */
static void check_holes(unsigned mode, double value, float bound, float hole, float other)
{
    float samples[SAMPLES];
    unsigned words[CVOL_H5Z_WORDS];
    void *code, *back;
    size_t size;
    char message[ROOM];
    for (size_t i = 0; i < SAMPLES; i++)
        samples[i] = i % 200 == 3 ? hole : i % 200 == 8 ? other : value_at(i);
    set_words(words, mode, value, CVOL_FLOAT32);
    const cvol_h5z_plan plan = plan_of(words);
    assert_true(cvol_h5z_encode(&code, &size, &plan, samples, message, ROOM));
    assert_true(cvol_h5z_decode(&back, &plan, code, size, message, ROOM));
    for (size_t i = 0; i < SAMPLES; i++) {
        float b;
        memcpy(&b, (const uint8_t *)back + 4 * i, 4);
        if (fabsf(samples[i]) < 1000)
            assert_true(fabsf(b - samples[i]) <= bound);
        else
            assert_memory_equal(&b, &samples[i], sizeof b);
    }
    free(code);
    free(back);
}

static void test_holes(void **state)
{
    (void)state;
    check_holes(CVOL_TARGET_MAX_ERROR, 0.5, 0.5f, NAN, NAN);
    check_holes(CVOL_TARGET_PSNR, 60, 0.5f, NAN, NAN);
    check_holes(CVOL_TARGET_PSNR, 60, 0.5f, 9.9692099683868690e36f, 9.9692099683868690e36f);
    check_holes(CVOL_TARGET_PSNR, 60, 0.5f, 9.9692099683868690e36f, NAN);
}

/* Other shapes and types than the parameters', cut and changed chunks: a message, or samples. */
static void test_damage(void **state)
{
    uint8_t samples[SAMPLES];
    unsigned words[CVOL_H5Z_WORDS];
    void *code, *back;
    size_t size, refused = 0;
    char message[ROOM];
    (void)state;
    for (size_t i = 0; i < SAMPLES; i++)
        samples[i] = (uint8_t)value_at(i);
    set_words(words, CVOL_TARGET_PSNR, 40, CVOL_UINT8);
    const cvol_h5z_plan plan = plan_of(words);
    assert_true(cvol_h5z_encode(&code, &size, &plan, samples, message, ROOM));
    static const int changed[] = {CVOL_H5Z_NX, CVOL_H5Z_NZ, CVOL_H5Z_TYPE};
    for (int i = 0; i < 6; i++) {
        unsigned other[CVOL_H5Z_WORDS];
        memcpy(other, words, sizeof words);
        other[changed[i / 2]] += i % 2 ? 1 : i / 2 == 2 ? 2 : -1u;
        const cvol_h5z_plan wrong = plan_of(other);
        assert_false(cvol_h5z_decode(&back, &wrong, code, size, message, ROOM));
        assert_null(back);
        assert_memory_equal(message, "cvol: a chunk", 13);
    }
    uint8_t *copy = malloc(size);
    assert_non_null(copy);
    for (size_t at = 0; at < size; at++) {
        memcpy(copy, code, size);
        copy[at] ^= (uint8_t)(1 << at % 8);
        const int done = cvol_h5z_decode(&back, &plan, copy, size, message, ROOM);
        refused += !done;
        free(back);
        assert_false(cvol_h5z_decode(&back, &plan, code, at, message, ROOM));
        assert_memory_equal(message, "cvol: a chunk", 13);
    }
    assert_true(refused * 20 >=
                size * 19); /* checksums detect all changes except in bytes that are not read */
    free(copy);
    free(code);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_options), cmocka_unit_test(test_plans),
        cmocka_unit_test(test_orders),  cmocka_unit_test(test_holes),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
