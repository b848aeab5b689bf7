/* Grids of OpenVDB. The files in vdb/ are those that vdb/make_vdb.cpp writes with libopenvdb;
 * tests/cli/test_formats.sh reads files that its Python module writes. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <zlib.h>

#include "cvol/codec.h"
#include "cvol/volume.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"

#define FILE_BYTES (4 << 20)

static const char *const compressions[] = {"plain", "zip", "zip_mask", "blosc_mask"};
#define COMPRESSIONS (sizeof compressions / sizeof *compressions)

typedef struct kind {
    const char *name;
    cvol_type type;
    double background;
    double steps[4][3]; /* of the voxels along x, y, z; the place of voxel 0 */
} kind;

static const kind kinds[] = {
    {"float", CVOL_FLOAT32, -4, {{0.25, 0, 0}, {0, 0.25, 0}, {0, 0, 0.25}, {0, 0, 0}}},
    {"double", CVOL_FLOAT64, 5, {{0, 2, 0}, {-3, 0, 0}, {0, 0.5, 4}, {10, 20, 30}}},
    {"float_as_half", CVOL_FLOAT32, 1, {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {0, 0, 0}}},
    {"double_as_half", CVOL_FLOAT64, 0, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 2, 3}}},
    {"half", CVOL_FLOAT32, 1, {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {-1, 0, 1}}},
    {"int32", CVOL_INT32, 1, {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0.5, 0, -0.5}}},
    {"int64", CVOL_INT32, 3, {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, 0}}},
    {"bool", CVOL_UINT8, 1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}},
    {"mask", CVOL_UINT8, 0, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}},
};
#define KINDS (sizeof kinds / sizeof *kinds)

/* The box of voxels. */
static const int first[3] = {-5, 0, 3};
static const size_t dims[3] = {17, 9, 14};

/* What make_vdb.cpp writes at a voxel. */
static double value_at(const kind *k, int x, int y, int z)
{
    const int value = x + 10 * y + 100 * z, rest = (x + 2 * y + 3 * z) & 7;
    double v = k->background;
    if (!strcmp(k->name, "mask"))
        return rest < 3;
    if (rest < 3)
        v = value % 2 ? value : 0;
    else if (rest == 3 && x < 8)
        v = 7;
    else if (rest == 4 && y < 8)
        v = -1;
    return k->type == CVOL_UINT8 ? v < 0 || v > 0 : v;
}

static double sample_at(const cvol_volume *volume, size_t i)
{
    switch (volume->grid.type) {
    case CVOL_UINT8:
        return ((const uint8_t *)volume->data)[i];
    case CVOL_INT32:
        return ((const int32_t *)volume->data)[i];
    case CVOL_FLOAT32:
        return (double)((const float *)volume->data)[i];
    default:
        return ((const double *)volume->data)[i];
    }
}

/* The inflated bytes of vdb/NAME.vdb.gz, freed with free(). */
static uint8_t *load(size_t *size, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/../tests/volume/vdb/%s.vdb.gz", CVOL_TEST_SAMPLES, name);
    gzFile file = gzopen(path, "rb");
    assert_non_null(file);
    uint8_t *bytes = malloc(FILE_BYTES);
    assert_non_null(bytes);
    const int got = gzread(file, bytes, FILE_BYTES);
    assert_true(got > 0 && got < FILE_BYTES);
    gzclose(file);
    *size = (size_t)got;
    return bytes;
}

/* 0 if this build has no libblosc and the file needs it. */
static int can_read(const char *path)
{
    cvol_volume *volume;
    const int code = cvol_volume_read(context, &volume, path, NULL);
    cvol_volume_free(volume);
    return !(code == CVOL_ERROR_UNSUPPORTED &&
             strstr(cvol_context_message(context), "without libblosc"));
}

static void check_grid(const char *path, const kind *k)
{
    cvol_volume *volume = read_ok(path);
    const cvol_grid *grid = &volume->grid;
    assert_int_equal(grid->type, k->type);
    if (k->type == CVOL_UINT8) /* the samples do not look like labels: the type of the grid tells */
        assert_int_equal(cvol_volume_is_labels(volume, path), 1);
    for (int a = 0; a < 3; a++) {
        double origin = k->steps[3][a];
        assert_int_equal(grid->dims[a], dims[a]);
        for (int i = 0; i < 3; i++) {
            origin += first[i] * k->steps[i][a];
            assert_true(fabs(grid->spacing[a] * grid->direction[a][i] - k->steps[a][i]) < 1e-12);
        }
        assert_true(fabs(grid->origin[a] - origin) < 1e-12);
    }
    size_t i = 0;
    for (int z = 0; z < (int)dims[2]; z++)
        for (int y = 0; y < (int)dims[1]; y++)
            for (int x = 0; x < (int)dims[0]; x++, i++)
                assert_true(sample_at(volume, i) ==
                            value_at(k, first[0] + x, first[1] + y, first[2] + z));
    cvol_volume_free(volume);
}

static void test_kinds(void **state)
{
    (void)state;
    for (size_t c = 0; c < COMPRESSIONS; c++) {
        size_t size;
        char name[1024];
        uint8_t *bytes = load(&size, compressions[c]);
        const char *path = write_bytes("kinds.vdb", bytes, size);
        free(bytes);
        read_fails(path, CVOL_ERROR_ARGUMENT, "has 9 grids: name one behind a colon",
                   "float, double, float_as_half");
        for (size_t k = 0; k < KINDS; k++) {
            snprintf(name, sizeof name, "%s:%s", path, kinds[k].name);
            if (can_read(name))
                check_grid(name, &kinds[k]);
        }
        snprintf(name, sizeof name, "%s:none", path);
        read_fails(name, CVOL_ERROR_FORMAT, "has no such grid", "int64, bool, ...");
        remove(path);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    size_t size;
    uint8_t *bytes = load(&size, "frustum");
    const char *path = write_bytes("refused.vdb", bytes, size);
    read_fails(path, CVOL_ERROR_UNSUPPORTED, "the transform of its grid is not affine", "");
    bytes[8] = 221;
    write_bytes("refused.vdb", bytes, size);
    read_fails(path, CVOL_ERROR_UNSUPPORTED, "of version 221", "222 to 224");
    bytes[8] = 224;
    bytes[20] = 0; /* whether the list has the places of grids */
    write_bytes("refused.vdb", bytes, size);
    read_fails(path, CVOL_ERROR_UNSUPPORTED, "stream of OpenVDB", "write it as a file");
    free(bytes);
    remove(path);
}

/* Reading ends, with samples or a message. */
static void read_any(const char *path)
{
    cvol_volume *volume;
    const int code = cvol_volume_read(context, &volume, path, NULL);
    assert_true(code == CVOL_OK || code == CVOL_ERROR_FORMAT || code == CVOL_ERROR_UNSUPPORTED ||
                code == CVOL_ERROR_LIMIT || code == CVOL_ERROR_ARGUMENT || code == CVOL_ERROR_IO ||
                code == CVOL_ERROR_MEMORY);
    cvol_volume_free(volume);
}

static void test_cut_files(void **state)
{
    (void)state;
    size_t size;
    char name[1024];
    uint8_t *bytes = load(&size, "zip_mask");
    for (size_t length = 1; length < 24000; length += length < 1500 ? 13 : 700) {
        const char *path = write_bytes("cut.vdb", bytes, length);
        snprintf(name, sizeof name, "%s:float", path);
        cvol_volume *volume;
        assert_int_not_equal(cvol_volume_read(context, &volume, name, NULL), CVOL_OK);
        assert_null(volume);
    }
    free(bytes);
    remove(in_folder("cut.vdb"));
}

static void test_damaged_files(void **state)
{
    (void)state;
    const char *given = getenv("CVOL_TEST_SEED");
    const uint64_t seed = given ? strtoull(given, NULL, 10) : 1;
    random_state r = {seed};
    print_message("seed %llu\n", (unsigned long long)seed);
    cvol_context_set_limit_bytes(context, 64 << 20);
    for (int turn = 0; turn < 400; turn++) {
        size_t size;
        char name[1024];
        uint8_t *bytes = load(&size, compressions[1 + turn % 3]);
        const kind *k = &kinds[random_below(&r, KINDS)];
        for (int i = 0; i < 1 + turn % 20; i++) { /* half of them in the headers */
            const uint32_t among = (uint32_t)(random_below(&r, 2) ? 2500 : size);
            bytes[random_below(&r, among)] ^= (uint8_t)(1 + random_below(&r, 255));
        }
        snprintf(name, sizeof name, "%s:%s", write_bytes("damaged.vdb", bytes, size), k->name);
        free(bytes);
        read_any(name);
    }
    cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
    remove(in_folder("damaged.vdb"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cut_files),
        cmocka_unit_test(test_damaged_files),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
