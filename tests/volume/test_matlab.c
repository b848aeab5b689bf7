/* Damaged files of MATLAB 5: the seeds of the fuzzers, cut off and with changed bytes.
 * tests/cli/test_formats.sh reads sound files that SciPy writes. */
#include "test.h"

#include <stdio.h>
#include <stdlib.h>

#include "cvol/volume.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"

static const char *const seeds[] = {"four_plain", "four_packed", "colours_packed",
                                    "big_packed", "bytes",       "small"};
#define SEEDS (sizeof seeds / sizeof *seeds)

/* The bytes of a seed, freed with free(). */
static uint8_t *load(size_t *size, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/../fuzz/corpus/volume/matlab_%s.mat", CVOL_TEST_SAMPLES, name);
    return support_read(path, size);
}

/* The first volume of an array. */
static int read_first(const char *path, cvol_volume **out)
{
    cvol_read_options options = cvol_read_options_defaults();
    options.has_index = options.has_channel = 1;
    return cvol_volume_read(context, out, path, &options);
}

static void test_cut_files(void **state)
{
    (void)state;
    for (size_t s = 0; s < SEEDS; s++) {
        size_t size;
        char name[1024];
        cvol_volume *volume;
        uint8_t *bytes = load(&size, seeds[s]);
        for (size_t length = 1; length < size; length++) {
            snprintf(name, sizeof name, "%s%s", write_bytes("cut.mat", bytes, length),
                     length % 2 || s < 5 ? "" : ":s");
            const int code = read_first(name, &volume);
            if (!code) /* what is cut off is another variable */
                assert_true(s < 2 && length > size / 2);
            assert_true(!code == (volume != NULL));
            cvol_volume_free(volume);
        }
        free(bytes);
    }
    remove(in_folder("cut.mat"));
}

static void test_damaged_files(void **state)
{
    (void)state;
    const char *given = getenv("CVOL_TEST_SEED");
    const uint64_t seed = given ? strtoull(given, NULL, 10) : 1;
    random_state r = {seed};
    print_message("seed %llu\n", (unsigned long long)seed);
    cvol_context_set_limit_bytes(context, 64 << 20);
    for (int turn = 0; turn < 3000; turn++) {
        size_t size;
        cvol_volume *volume;
        uint8_t *bytes = load(&size, seeds[(size_t)turn % SEEDS]);
        for (int i = 0; i < 1 + turn % 5; i++) { /* most of them in the headers of variables */
            const uint32_t among = (uint32_t)(random_below(&r, 4) && size > 208 ? 80 : size - 128);
            bytes[128 + random_below(&r, among)] ^= (uint8_t)(1 + random_below(&r, 255));
        }
        const int code = read_first(write_bytes("damaged.mat", bytes, size), &volume);
        free(bytes);
        assert_true(code == CVOL_OK || code == CVOL_ERROR_FORMAT || code == CVOL_ERROR_ARGUMENT ||
                    code == CVOL_ERROR_UNSUPPORTED || code == CVOL_ERROR_LIMIT);
        assert_true(!code == (volume != NULL));
        cvol_volume_free(volume);
    }
    cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
    remove(in_folder("damaged.mat"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cut_files),
        cmocka_unit_test(test_damaged_files),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
