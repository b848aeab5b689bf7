/* Volumes: statistics, and every reader and writer on good files and on every kind of lie. */
#define _GNU_SOURCE
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include <cmocka.h>

#include "cvol/volume.h"
#include "random.h"
#include "support.h"

static cvol_context *context;
static char *folder;

static int open_all(void **state)
{
    (void)state;
    context = cvol_context_create();
    folder = support_folder_make();
    return context == NULL;
}

static int close_all(void **state)
{
    (void)state;
    support_folder_remove(folder);
    cvol_context_destroy(context);
    return 0;
}

/* ---- files in the folder ------------------------------------------------------------- */

/* FOLDER/NAME, in storage that the next sixteen calls leave alone. */
static const char *in_folder(const char *name)
{
    static char paths[16][512];
    static size_t next;
    char *path = paths[next++ % 16];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

/* Writes FOLDER/NAME; its path. */
static const char *write_bytes(const char *name, const void *data, size_t size)
{
    const char *path = in_folder(name);
    support_write(path, data, size);
    return path;
}

/* A text header and bytes behind it. */
static const char *write_text(const char *name, const char *text, const void *data, size_t size)
{
    size_t length = strlen(text);
    uint8_t *bytes = malloc(length + size + 1);
    assert_non_null(bytes);
    memcpy(bytes, text, length);
    if (size)
        memcpy(bytes + length, data, size);
    const char *path = write_bytes(name, bytes, length + size);
    free(bytes);
    return path;
}

static int exists(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file)
        fclose(file);
    return file != NULL;
}

/* ---- helpers ------------------------------------------------------------------------- */

static void check_ok(int code)
{
    if (code)
        print_error("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
}

static cvol_volume *read_ok(const char *path)
{
    cvol_volume *volume = NULL;
    check_ok(cvol_volume_read(context, &volume, path, NULL));
    assert_non_null(volume);
    assert_int_equal((uintptr_t)volume->data % 64, 0);
    return volume;
}

/* Reading fails with this code and a sentence that names the file and has both words. */
static void read_fails_with(const char *path, const cvol_read_options *options, int code,
                            const char *word, const char *other)
{
    cvol_volume *volume = (cvol_volume *)&volume;
    int got = cvol_volume_read(context, &volume, path, options);
    const char *message = cvol_context_message(context);
    if (got != code || !strstr(message, word) || !strstr(message, other))
        print_error("code %d (not %d), '%s' lacks '%s' or '%s'\n", got, code, message, word, other);
    assert_int_equal(got, code);
    assert_null(volume);
    assert_non_null(strstr(message, word));
    assert_non_null(strstr(message, other));
    assert_int_equal(strncmp(message, path, strlen(path)), 0);
    assert_null(strchr(message, '\n'));
}

static void read_fails(const char *path, int code, const char *word, const char *other)
{
    read_fails_with(path, NULL, code, word, other);
}

static void fill_random(cvol_volume *volume, uint64_t seed)
{
    random_state r = {seed};
    size_t samples = cvol_grid_samples(&volume->grid);
    for (size_t i = 0; i < samples; i++) {
        uint64_t bits = random_u64(&r);
        if (volume->grid.type == CVOL_FLOAT32)
            ((float *)volume->data)[i] = (float)random_signed(&r);
        else if (volume->grid.type == CVOL_FLOAT64)
            ((double *)volume->data)[i] = random_signed(&r);
        else {
            size_t size = cvol_type_size(volume->grid.type);
            memcpy((uint8_t *)volume->data + i * size, &bits, size);
        }
    }
}

/* A rotation about an odd axis, times a mirror if asked. */
static cvol_grid odd_grid(cvol_type type, int mirrored)
{
    cvol_grid grid = cvol_grid_make(5, 4, 3, type);
    const double axes[3][3] = {{2, 3, 6}, {-6, -2, 3}, {3, -6, 2}}; /* orthogonal, of length 7 */
    const double spacing[3] = {0.1, 1.75, 2.0 / 3}, origin[3] = {-12.5, 1.0 / 3, 4000.25};
    for (int a = 0; a < 3; a++) {
        grid.spacing[a] = spacing[a];
        grid.origin[a] = origin[a];
        for (int i = 0; i < 3; i++)
            grid.direction[a][i] = axes[a][i] / (a == 2 && mirrored ? -7 : 7);
    }
    grid.space = CVOL_SPACE_RAS;
    memcpy(grid.unit, "mm", 3);
    return grid;
}

static cvol_volume *make_volume(const cvol_grid *grid, uint64_t seed)
{
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, grid));
    fill_random(volume, seed);
    return volume;
}

static void near(double a, double b, double relative)
{
    if (!(fabs(a - b) <= relative * fmax(1, fabs(b))))
        print_error("%.17g is not near %.17g\n", a, b);
    assert_true(fabs(a - b) <= relative * fmax(1, fabs(b)));
}

static void same_samples(const cvol_volume *a, const cvol_volume *b)
{
    assert_int_equal(a->grid.type, b->grid.type);
    for (int i = 0; i < 3; i++)
        assert_int_equal(a->grid.dims[i], b->grid.dims[i]);
    assert_memory_equal(a->data, b->data, cvol_grid_bytes(&a->grid));
}

/* b lies where a does, with the signs of the first two world axes turned if told. */
static void same_place(const cvol_grid *a, const cvol_grid *b, double relative, int turned)
{
    for (int i = 0; i < 3; i++) {
        double sign = turned && i < 2 ? -1 : 1;
        near(b->spacing[i], a->spacing[i], relative);
        near(sign * b->origin[i], a->origin[i], relative);
        for (int axis = 0; axis < 3; axis++)
            near(sign * b->direction[axis][i], a->direction[axis][i], relative);
    }
}

/* ---- volumes and statistics ---------------------------------------------------------- */

static void test_create(void **state)
{
    (void)state;
    cvol_volume *volume;
    cvol_grid grid = cvol_grid_make(3, 2, 1, CVOL_INT16);
    check_ok(cvol_volume_create(context, &volume, &grid));
    for (int i = 0; i < 6; i++)
        assert_int_equal(((int16_t *)volume->data)[i], 0);
    cvol_volume_free(volume);
    cvol_volume_free(NULL);
    grid.dims[1] = 0;
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_ARGUMENT);
    assert_null(volume);
    grid = cvol_grid_make(SIZE_MAX / 2, SIZE_MAX / 2, 9, CVOL_FLOAT64);
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_LIMIT);
}

static void test_stats(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(100, 90, 33, CVOL_FLOAT32);
    cvol_volume *volume = make_volume(&grid, 1);
    float *samples = volume->data;
    size_t count = cvol_grid_samples(&grid);
    samples[70000] = NAN;
    samples[200001] = -INFINITY;
    samples[123] = -7;
    samples[count - 1] = 11;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        if (isfinite(samples[i]))
            sum += samples[i];
    cvol_sample_stats first = {0}, stats;
    for (int threads = 1; threads <= 5; threads++) {
        cvol_context_set_threads(context, threads);
        check_ok(cvol_volume_stats(context, &stats, volume));
        assert_true(stats.min == -7 && stats.max == 11);
        near(stats.mean, sum / (double)(count - 2), 1e-12);
        assert_int_equal(stats.bad_count, 2);
        assert_int_equal(stats.bad_first, 70000);
        if (threads == 1)
            first = stats;
        assert_true(stats.mean == first.mean);
    }
    cvol_context_set_threads(context, 0);
    check_ok(cvol_volume_fill(context, volume, -3));
    assert_true(samples[70000] == -3 && samples[200001] == -3 && samples[123] == -7);
    check_ok(cvol_volume_stats(context, &stats, volume));
    assert_int_equal(stats.bad_count, 0);
    assert_int_equal(cvol_volume_fill(context, volume, NAN), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_volume_fill(context, volume, 1e39), CVOL_ERROR_ARGUMENT);
    for (size_t i = 0; i < count; i++)
        samples[i] = NAN;
    check_ok(cvol_volume_stats(context, &stats, volume));
    assert_int_equal(stats.bad_count, count);
    assert_true(stats.bad_first == 0 && stats.min == 0 && stats.max == 0 && stats.mean == 0);
    cvol_volume_free(volume);
}

static void test_stats_types(void **state)
{
    (void)state;
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++) {
        cvol_grid grid = cvol_grid_make(7, 3, 2, (cvol_type)type);
        cvol_volume *volume;
        check_ok(cvol_volume_create(context, &volume, &grid));
        memset((uint8_t *)volume->data + cvol_type_size(grid.type), 0x7f, 1);
        memset((uint8_t *)volume->data + cvol_type_size(grid.type), 0x3f,
               cvol_type_size(grid.type));
        cvol_sample_stats stats;
        check_ok(cvol_volume_stats(context, &stats, volume));
        double expected[] = {0, 0x3f, 0x3f, 0x3f3f, 0x3f3f, 0x3f3f3f3f, 0x3f3f3f3f, 0, 0};
        if (type < CVOL_FLOAT32) {
            assert_true(stats.max == expected[type]);
            near(stats.mean, expected[type] / 42, 1e-15);
        } else
            assert_true(stats.max > 0 && stats.max < 1);
        assert_true(stats.min == 0);
        check_ok(cvol_volume_fill(context, volume, 5));
        cvol_volume_free(volume);
    }
}

static void test_compare(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(64, 65, 66, CVOL_INT16), wide = grid;
    wide.type = CVOL_FLOAT64;
    cvol_volume *a = make_volume(&grid, 3), *b;
    check_ok(cvol_volume_create(context, &b, &wide));
    size_t count = cvol_grid_samples(&grid);
    int16_t *in_a = a->data;
    double *in_b = b->data;
    for (size_t i = 0; i < count; i++)
        in_b[i] = in_a[i];
    cvol_volume_difference d;
    check_ok(cvol_volume_compare(context, &d, a, b));
    assert_true(isinf(d.psnr_db) && d.psnr_db > 0 && d.rmse == 0 && d.max_abs_error == 0);
    cvol_sample_stats stats;
    check_ok(cvol_volume_stats(context, &stats, a));
    assert_true(d.peak == stats.max - stats.min);
    for (size_t i = 0; i < count; i++)
        in_b[i] = in_a[i] + (i % 2 ? 3 : -4);
    double rmse = sqrt(12.5), first = 0;
    for (int threads = 1; threads <= 4; threads++) {
        cvol_context_set_threads(context, threads);
        check_ok(cvol_volume_compare(context, &d, a, b));
        near(d.rmse, rmse, 1e-13);
        near(d.psnr_db, 20 * log10(d.peak / rmse), 1e-12);
        assert_true(d.max_abs_error == 4);
        first = threads == 1 ? d.rmse : first;
        assert_true(d.rmse == first);
    }
    cvol_context_set_threads(context, 0);
    in_b[5] = NAN;
    check_ok(cvol_volume_compare(context, &d, a, b));
    assert_true(isinf(d.rmse) && isinf(d.max_abs_error));
    check_ok(cvol_volume_compare(context, &d, b, b)); /* a NaN equals itself here */
    assert_true(d.rmse == 0);
    cvol_volume_free(b);
    grid.dims[2]--;
    b = make_volume(&grid, 3);
    assert_int_equal(cvol_volume_compare(context, &d, a, b), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "64 x 65 x 65"));
    cvol_volume_free(b);
    cvol_volume_free(a);
}

/* ---- round trips --------------------------------------------------------------------- */

static const struct {
    const char *name;
    const char *data; /* the second file, if the format has one */
    cvol_space space; /* that the format writes */
    double relative;  /* to which geometry survives */
} writers[] = {
    {"a.nrrd", NULL, CVOL_SPACE_RAS, 1e-15}, {"a.nhdr", "a.raw", CVOL_SPACE_RAS, 1e-15},
    {"a.mha", NULL, CVOL_SPACE_LPS, 1e-15},  {"a.mhd", "a.raw", CVOL_SPACE_LPS, 1e-15},
    {"a.nii", NULL, CVOL_SPACE_RAS, 3e-7},   {"a.nii.gz", NULL, CVOL_SPACE_RAS, 3e-7},
};

#define WRITERS (sizeof writers / sizeof writers[0])

static void test_round_trips(void **state)
{
    (void)state;
    for (size_t w = 0; w < WRITERS; w++)
        for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++)
            for (int mirrored = 0; mirrored < 2; mirrored++) {
                cvol_grid grid = odd_grid((cvol_type)type, mirrored);
                cvol_volume *volume = make_volume(&grid, (uint64_t)type);
                const char *path = in_folder(writers[w].name);
                check_ok(cvol_volume_write(context, volume, path));
                assert_int_equal(support_folder_count(folder), writers[w].data ? 2 : 1);
                cvol_volume *back = read_ok(path);
                same_samples(volume, back);
                same_place(&grid, &back->grid, writers[w].relative,
                           writers[w].space != CVOL_SPACE_RAS);
                assert_int_equal(back->grid.space, writers[w].space);
                assert_string_equal(back->grid.unit, "mm");
                remove(path);
                if (writers[w].data)
                    remove(in_folder(writers[w].data));
                cvol_volume_free(back);
                cvol_volume_free(volume);
            }
}

/* Every space, through every format: the places must be the same in the world. */
static void test_spaces(void **state)
{
    (void)state;
    for (size_t w = 0; w < WRITERS; w++)
        for (int space = CVOL_SPACE_UNKNOWN; space <= CVOL_SPACE_RAS; space++) {
            cvol_grid grid = odd_grid(CVOL_UINT8, 0);
            grid.space = (cvol_space)space;
            cvol_volume *volume = make_volume(&grid, 9);
            const char *path = in_folder(writers[w].name);
            check_ok(cvol_volume_write(context, volume, path));
            cvol_volume *back = read_ok(path);
            int is_nrrd = w < 2;
            assert_int_equal(back->grid.space, is_nrrd ? grid.space : writers[w].space);
            int turned = space != CVOL_SPACE_UNKNOWN && back->grid.space != grid.space;
            same_place(&grid, &back->grid, writers[w].relative, turned);
            cvol_volume_free(back);
            cvol_volume_free(volume);
        }
}

/* Equal volumes give equal files. */
static void test_same_bytes(void **state)
{
    (void)state;
    cvol_grid grid = odd_grid(CVOL_INT16, 0);
    cvol_volume *volume = make_volume(&grid, 4);
    for (size_t w = 0; w < WRITERS; w++) {
        const char *path = in_folder(writers[w].name);
        size_t size, again;
        check_ok(cvol_volume_write(context, volume, path));
        uint8_t *bytes = support_read(path, &size);
        check_ok(cvol_volume_write(context, volume, path));
        uint8_t *more = support_read(path, &again);
        assert_int_equal(size, again);
        assert_memory_equal(bytes, more, size);
        if (strstr(path, ".gz")) /* no time in the gzip header */
            assert_memory_equal(bytes + 4, "\0\0\0\0", 4);
        free(bytes);
        free(more);
    }
    cvol_volume_free(volume);
}

static void test_value_scale(void **state)
{
    (void)state;
    const char *names[] = {"a.nii", "a.mha"};
    for (int i = 0; i < 2; i++) {
        cvol_grid grid = odd_grid(CVOL_UINT8, 0);
        grid.value_scale = 0.5;
        grid.value_offset = -1024;
        cvol_volume *volume = make_volume(&grid, 4);
        check_ok(cvol_volume_write(context, volume, in_folder(names[i])));
        cvol_volume *back = read_ok(in_folder(names[i]));
        same_samples(volume, back);
        assert_true(back->grid.value_scale == 0.5 && back->grid.value_offset == -1024);
        cvol_volume_free(back);
        cvol_volume_free(volume);
    }
}

/* Larger than a step of reading and a step of writing. */
static void test_large(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(300, 200, 101, CVOL_INT16);
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, &grid));
    for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
        ((int16_t *)volume->data)[i] = (int16_t)(i % 30011);
    for (size_t w = 0; w < WRITERS; w++) {
        check_ok(cvol_volume_write(context, volume, in_folder(writers[w].name)));
        cvol_volume *back = read_ok(in_folder(writers[w].name));
        same_samples(volume, back);
        cvol_volume_free(back);
        remove(in_folder(writers[w].name));
    }
    remove(in_folder("a.raw"));
    cvol_volume_free(volume);
}

static int cancel_after(void *user, const char *what, double fraction)
{
    assert_true(fraction > 0 && fraction <= 1);
    assert_non_null(what);
    return --*(int *)user < 0;
}

static void test_cancel(void **state)
{
    (void)state;
    cvol_grid grid = odd_grid(CVOL_UINT8, 0);
    cvol_volume *volume = make_volume(&grid, 4);
    for (size_t w = 0; w < WRITERS; w++) {
        const char *path = in_folder(writers[w].name);
        check_ok(cvol_volume_write(context, volume, path));
        size_t size, again;
        uint8_t *before = support_read(path, &size);
        int left = 0;
        cvol_context_set_progress(context, cancel_after, &left);
        assert_int_equal(cvol_volume_write(context, volume, path), CVOL_ERROR_CANCELLED);
        left = 0;
        cvol_volume *back;
        assert_int_equal(cvol_volume_read(context, &back, path, NULL), CVOL_ERROR_CANCELLED);
        assert_null(back);
        cvol_context_set_progress(context, NULL, NULL);
        uint8_t *after = support_read(path, &again); /* what was there is still there */
        assert_int_equal(size, again);
        assert_memory_equal(before, after, size);
        free(before);
        free(after);
        assert_int_equal(support_folder_count(folder), writers[w].data ? 2 : 1);
        remove(path);
        remove(in_folder("a.raw"));
    }
    cvol_volume_free(volume);
}

static void test_write_errors(void **state)
{
    (void)state;
    cvol_grid grid = odd_grid(CVOL_UINT8, 0);
    cvol_volume *volume = make_volume(&grid, 4);
    assert_int_equal(cvol_volume_write(context, volume, in_folder("a.jpg")), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), ".nhdr"));
    for (size_t w = 0; w < WRITERS; w++) {
        char name[64];
        snprintf(name, sizeof name, "missing/%s", writers[w].name);
        assert_int_equal(cvol_volume_write(context, volume, in_folder(name)), CVOL_ERROR_IO);
    }
    volume->grid.spacing[1] = -1;
    assert_int_equal(cvol_volume_write(context, volume, in_folder("a.nrrd")), CVOL_ERROR_ARGUMENT);
    assert_int_equal(support_folder_count(folder), 0);
    cvol_volume_free(volume);
    for (const char *ending = cvol_volume_formats(); *ending;) {
        char name[32] = "f";
        size_t length = strcspn(ending, " ");
        snprintf(name, sizeof name, "F%.*s", (int)length, ending);
        volume = make_volume(&grid, 5);
        check_ok(cvol_volume_write(context, volume, in_folder(name)));
        remove(in_folder(name));
        cvol_volume_free(volume);
        ending += length + strspn(ending + length, " ");
    }
    remove(in_folder("F.raw"));
}

/* Decimal points stay points where the language has commas. */
static void test_locale(void **state)
{
    (void)state;
    char *before = strdup(setlocale(LC_ALL, NULL));
    const char *comma[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    int found = 0;
    for (int i = 0; i < 4 && !found; i++)
        found = setlocale(LC_ALL, comma[i]) != NULL;
    if (!found)
        print_message("skipped: no locale with a decimal comma\n");
    cvol_grid grid = odd_grid(CVOL_UINT8, 0);
    cvol_volume *volume = make_volume(&grid, 4);
    for (size_t w = 0; w < WRITERS; w++) {
        check_ok(cvol_volume_write(context, volume, in_folder(writers[w].name)));
        cvol_volume *back = read_ok(in_folder(writers[w].name));
        near(back->grid.spacing[0], 0.1, writers[w].relative);
        cvol_volume_free(back);
    }
    cvol_volume_free(volume);
    setlocale(LC_ALL, before);
    free(before);
}

/* ---- NRRD by hand -------------------------------------------------------------------- */

#define NRRD_START "NRRD0004\n# a comment: with a colon\n"
/* 2 x 3 x 2 samples, as bytes 1 .. 24 */
#define SIZES "dimension: 3\nsizes: 2 3 2\n"

static uint8_t counting[64];

static const char *nrrd(const char *text, size_t size)
{
    for (size_t i = 0; i < sizeof counting; i++)
        counting[i] = (uint8_t)(i + 1);
    return write_text("h.nrrd", text, counting, size);
}

static void test_nrrd_plain(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(NRRD_START "key:=value\ncontent: a thing\ntype: unsigned char\n"
                                             "dimension: 3\nsizes: 2 3 2\nspacings: 2 nan 0.5\n"
                                             "units: \"um\" \"um\" \"um\"\nencoding: raw\n\n",
                                  12));
    assert_int_equal(v->grid.dims[1], 3);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 1 && v->grid.spacing[2] == 0.5);
    assert_string_equal(v->grid.unit, "um");
    assert_int_equal(v->grid.space, CVOL_SPACE_UNKNOWN);
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* carriage returns, other cases, version 1 */
    v = read_ok(nrrd("NRRD0001\r\nType: UINT8\r\ndimension: 3\r\nsizes: 2 3 2\r\n"
                     "encoding: RAW\r\n\r\n",
                     12));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
}

static void test_nrrd_endian(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(
        nrrd(NRRD_START "type: ushort\n" SIZES "endian: big\nencoding: raw\n\n", 24));
    for (int i = 0; i < 12; i++)
        assert_int_equal(((uint16_t *)v->data)[i], (2 * i + 1) << 8 | (2 * i + 2));
    cvol_volume_free(v);
    v = read_ok(nrrd(NRRD_START "type: uint32\ndimension: 3\nsizes: 1 3 2\nendian: little\n"
                                "encoding: raw\n\n",
                     24));
    assert_int_equal(((uint32_t *)v->data)[1], 0x08070605);
    cvol_volume_free(v);
    double value = 0.1;
    uint8_t swapped[8];
    for (int i = 0; i < 8; i++)
        swapped[7 - i] = ((uint8_t *)&value)[i];
    v = read_ok(write_text("h.nrrd",
                           NRRD_START "type: double\ndimension: 3\nsizes: 1 1 1\n"
                                      "endian: big\nencoding: raw\n\n",
                           swapped, 8));
    assert_true(*(double *)v->data == 0.1);
    cvol_volume_free(v);
    read_fails(nrrd(NRRD_START "type: short\n" SIZES "encoding: raw\n\n", 24), CVOL_ERROR_FORMAT,
               "endian", "short");
    read_fails(nrrd(NRRD_START "type: short\n" SIZES "endian: middle\nencoding: raw\n\n", 24),
               CVOL_ERROR_FORMAT, "endian", "middle");
}

static void test_nrrd_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        cvol_type type;
    } names[] = {
        {"uchar", CVOL_UINT8},      {"uint8_t", CVOL_UINT8},
        {"signed char", CVOL_INT8}, {"int8", CVOL_INT8},
        {"short int", CVOL_INT16},  {"signed short int", CVOL_INT16},
        {"int16_t", CVOL_INT16},    {"unsigned short int", CVOL_UINT16},
        {"uint16", CVOL_UINT16},    {"signed int", CVOL_INT32},
        {"int", CVOL_INT32},        {"unsigned int", CVOL_UINT32},
        {"uint", CVOL_UINT32},      {"float", CVOL_FLOAT32},
        {"double", CVOL_FLOAT64},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[200];
        snprintf(text, sizeof text,
                 "NRRD0005\ntype: %s\ndimension: 3\nsizes: 1 2 1\nendian: little\n"
                 "encoding: raw\n\n",
                 names[i].name);
        cvol_volume *v = read_ok(nrrd(text, 2 * cvol_type_size(names[i].type)));
        assert_int_equal(v->grid.type, names[i].type);
        cvol_volume_free(v);
    }
}

static void test_nrrd_text(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(NRRD_START "type: short\n" SIZES "encoding: ascii\n\n"
                                             "-32768 32767 3\n4,5, 6\r\n7\t8 9 10 11 12\n",
                                  0));
    assert_int_equal(((int16_t *)v->data)[0], -32768);
    assert_int_equal(((int16_t *)v->data)[11], 12);
    cvol_volume_free(v);
    v = read_ok(nrrd("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 3\nencoding: txt\n\n"
                     "-1.5e3 nan .25",
                     0));
    assert_true(((float *)v->data)[0] == -1500 && isnan(((float *)v->data)[1]));
    cvol_volume_free(v);
#define TEXT(type) "NRRD0004\ntype: " type "\ndimension: 3\nsizes: 1 1 3\nencoding: text\n\n"
    read_fails(nrrd(TEXT("uint8") "1 2", 0), CVOL_ERROR_FORMAT, "2 of the 3 samples", "");
    read_fails(nrrd(TEXT("uint8") "1 2 3 4", 0), CVOL_ERROR_FORMAT, "4 of the 3 samples", "");
    read_fails(nrrd(TEXT("uint8") "1 256 3", 0), CVOL_ERROR_FORMAT, "'256'", "uint8");
    read_fails(nrrd(TEXT("uint8") "1 -1 3", 0), CVOL_ERROR_FORMAT, "'-1'", "sample 1");
    read_fails(nrrd(TEXT("int32") "1 2 12abc", 0), CVOL_ERROR_FORMAT, "'12abc'", "sample 2");
    read_fails(nrrd(TEXT("int32") "1 2 1.5", 0), CVOL_ERROR_FORMAT, "'1.5'", "int32");
    read_fails(nrrd(TEXT("uint32") "1 2 4294967296", 0), CVOL_ERROR_FORMAT, "4294967296", "");
    read_fails(nrrd(TEXT("float") "1 2 x", 0), CVOL_ERROR_FORMAT, "'x'", "float32");
    read_fails(nrrd(TEXT("float") "1 2 1e999999", 0), CVOL_ERROR_FORMAT, "1e999999", "");
}

static void test_nrrd_axes(void **state)
{
    (void)state;
#define TYPE8 "NRRD0004\ntype: uint8\n"
#define RAW "encoding: raw\n\n"
    cvol_volume *v = read_ok(nrrd(TYPE8 "dimension: 2\nsizes: 4 3\nspacings: 2 3\n" RAW, 12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[1] == 3 && v->grid.spacing[2] == 1);
    cvol_volume_free(v);
    v = read_ok(nrrd(TYPE8 "dimension: 4\nsizes: 1 4 3 1\nspacings: nan 2 3 4\n" RAW, 12));
    assert_true(v->grid.dims[0] == 1 && v->grid.dims[2] == 3 && v->grid.spacing[2] == 3);
    cvol_volume_free(v);
    v = read_ok(nrrd(TYPE8 "dimension: 4\nspace: LPS\nsizes: 1 4 3 1\n"
                           "space directions: none (2,0,0) (0,3,0) (0, 0, 4)\n" RAW,
                     12));
    assert_true(v->grid.dims[0] == 4 && v->grid.dims[2] == 1 && v->grid.spacing[2] == 4);
    cvol_volume_free(v);
    read_fails(nrrd(TYPE8 "dimension: 4\nsizes: 2 3 2 5\n" RAW, 60), CVOL_ERROR_UNSUPPORTED,
               "sizes '2 3 2 5'", "series");
    read_fails(nrrd(TYPE8 "dimension: 5\nsizes: 1 1 2 3 2\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "dimension '5'", "");
    read_fails(nrrd(TYPE8 "dimension: 1\nsizes: 12\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "dimension '1'", "");
    read_fails(nrrd(TYPE8 "dimension: 17\nsizes: 12\n" RAW, 12), CVOL_ERROR_FORMAT,
               "dimension is 17", "");
    read_fails(nrrd(TYPE8 "dimension: 3\nspace: LPS\nsizes: 3 2 2\n"
                          "space directions: none (1,0,0) (0,1,0)\n" RAW,
                    12),
               CVOL_ERROR_UNSUPPORTED, "space directions", "none");
}

static void test_nrrd_space(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(TYPE8 SIZES
                                  "space: left-anterior-superior\nspace origin: (1,2,3)\n"
                                  "space directions: (0,2,0) (-3,0,0) (0,0,0.25)\n"
                                  "space units: \"mm\" \"mm\" \"mm\"\n" RAW,
                                  12));
    assert_int_equal(v->grid.space, CVOL_SPACE_LPS); /* LAS, its second axis turned */
    assert_true(v->grid.origin[0] == 1 && v->grid.origin[1] == -2 && v->grid.origin[2] == 3);
    assert_true(v->grid.direction[0][1] == -1 && v->grid.direction[1][0] == -1);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 3 && v->grid.spacing[2] == 0.25);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    /* a picture in space gets its normal */
    v = read_ok(nrrd(TYPE8 "dimension: 2\nsizes: 4 3\nspace dimension: 3\n"
                           "space directions: (0,1,0) (0,0,1)\n" RAW,
                     12));
    assert_true(v->grid.direction[2][0] == 1 && v->grid.space == CVOL_SPACE_UNKNOWN);
    cvol_volume_free(v);
#define DIRECTIONS(text) nrrd(TYPE8 SIZES "space: RAS\nspace directions: " text "\n" RAW, 12)
    read_fails(DIRECTIONS("(1,0,0) (0,1,0)"), CVOL_ERROR_FORMAT, "space directions", "3 vectors");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,1) (0,0,1)"), CVOL_ERROR_FORMAT, "more", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1) (0,0,1)"), CVOL_ERROR_FORMAT, "of 3 numbers", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,1"), CVOL_ERROR_FORMAT, "space directions", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1x,0) (0,0,1)"), CVOL_ERROR_FORMAT, "1x", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,0)"), CVOL_ERROR_FORMAT, "without a length", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (nan,0,1)"), CVOL_ERROR_FORMAT, "length", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (1,1,0)"), CVOL_ERROR_FORMAT, "span", "");
    read_fails(nrrd(TYPE8 SIZES "space: right-up\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "space 'right-up'", "");
    read_fails(nrrd(TYPE8 SIZES "space: RAS\nspace origin: (1,2)\n" RAW, 12), CVOL_ERROR_FORMAT,
               "space origin '(1,2)'", "");
    read_fails(nrrd(TYPE8 SIZES "spacings: 1 0 1\n" RAW, 12), CVOL_ERROR_FORMAT,
               "spacing of axis y is 0", "");
    read_fails(nrrd(TYPE8 SIZES "spacings: 1 1 1mm\n" RAW, 12), CVOL_ERROR_FORMAT,
               "spacings has the value '1mm'", "");
}

static void test_nrrd_detached(void **state)
{
    (void)state;
    nrrd("", 0);
    write_bytes("d.bin", counting, 30);
    const char *path = write_text(
        "d.nhdr", TYPE8 SIZES "encoding: raw\nbyte skip: 5\ndata file: d.bin\n", NULL, 0);
    cvol_volume *v = read_ok(path);
    assert_memory_equal(v->data, counting + 5, 12);
    cvol_volume_free(v);
    path = write_text("d.nhdr", TYPE8 SIZES "encoding: raw\nbyteskip: -1\ndatafile: ./d.bin\n\n",
                      NULL, 0);
    v = read_ok(path);
    assert_memory_equal(v->data, counting + 18, 12);
    cvol_volume_free(v);
    write_text("d.txt", "one\ntwo\n", counting, 13);
    v = read_ok(write_text(
        "d.nhdr", TYPE8 SIZES "encoding: raw\nline skip: 2\nbyte skip: 1\ndata file: d.txt\n\n",
        NULL, 0));
    assert_memory_equal(v->data, counting + 1, 12);
    cvol_volume_free(v);
    char absolute[700];
    snprintf(absolute, sizeof absolute, "%sencoding: raw\ndata file: %s\n", TYPE8 SIZES,
             in_folder("d.bin"));
    v = read_ok(write_text("d.nhdr", absolute, NULL, 0));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
#define DETACHED(text) write_text("d.nhdr", TYPE8 SIZES "encoding: raw\n" text, NULL, 0)
    read_fails(DETACHED("data file: gone.bin\n"), CVOL_ERROR_IO, "gone.bin", "No such file");
    read_fails(DETACHED("data file: LIST\nd.bin\n"), CVOL_ERROR_UNSUPPORTED, "'LIST'", "one file");
    read_fails(DETACHED("data file: d%02d.bin 1 3 1\n"), CVOL_ERROR_UNSUPPORTED, "d%02d.bin", "");
    read_fails(DETACHED("data file: \n"), CVOL_ERROR_FORMAT, "data file", "");
    read_fails(DETACHED("line skip: 2x\ndata file: d.txt\n"), CVOL_ERROR_FORMAT, "line skip", "2x");
    read_fails(DETACHED("byte skip: -2\ndata file: d.txt\n"), CVOL_ERROR_FORMAT, "byte skip", "-2");
    cvol_volume *none;
    path = DETACHED("byte skip: 9223372036854775807\ndata file: d.bin\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    path = DETACHED("line skip: 70\ndata file: d.txt\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "3 of the 70 lines"));
    path = DETACHED("byte skip: 20\ndata file: d.bin\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "d.bin: holds 10 of the 12 bytes"));
}

static size_t gzip(uint8_t *out, size_t room, const void *data, size_t size, int window_bits)
{
    z_stream stream;
    memset(&stream, 0, sizeof stream);
    assert_int_equal(deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY),
                     Z_OK);
    stream.next_in = (z_const Bytef *)data;
    stream.avail_in = (uInt)size;
    stream.next_out = out;
    stream.avail_out = (uInt)room;
    assert_int_equal(deflate(&stream, Z_FINISH), Z_STREAM_END);
    deflateEnd(&stream);
    return room - stream.avail_out;
}

static void test_nrrd_gzip(void **state)
{
    (void)state;
    nrrd("", 0);
    uint8_t packed[256];
#define GZIP(extra) TYPE8 SIZES "encoding: gzip\n" extra "\n"
    size_t size = gzip(packed, sizeof packed, counting, 12, 15 + 16);
    cvol_volume *v = read_ok(write_text("g.nrrd", GZIP(""), packed, size));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* two members and padding */
    size_t first = gzip(packed, sizeof packed, counting, 5, 15 + 16);
    size_t second = gzip(packed + first, sizeof packed - first, counting + 5, 7, 15 + 16);
    memset(packed + first + second, 0, 9);
    v = read_ok(write_text("g.nrrd", GZIP(""), packed, first + second + 9));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* bytes are skipped after inflating */
    size = gzip(packed, sizeof packed, counting, 16, 15 + 16);
    v = read_ok(write_text("g.nrrd", GZIP("byte skip: 4\n"), packed, size));
    assert_memory_equal(v->data, counting + 4, 12);
    cvol_volume_free(v);
    read_fails(write_text("g.nrrd", GZIP("byte skip: -1\n"), packed, size), CVOL_ERROR_FORMAT,
               "byte skip", "-1");
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT, "more than",
               "12 bytes");
    size = gzip(packed, sizeof packed, counting, 10, 15 + 16);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT,
               "10 of the 12 bytes", "");
    size = gzip(packed, sizeof packed, counting, 12, 15 + 16);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size - 1), CVOL_ERROR_FORMAT, "check sum",
               "");
    memcpy(packed + size, "garbage", 7);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size + 7), CVOL_ERROR_FORMAT, "follow", "");
    packed[size - 5] ^= 1; /* the check sum */
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT, "damaged", "");
    read_fails(nrrd(GZIP(""), 20), CVOL_ERROR_FORMAT, "damaged", "");
    read_fails(nrrd(GZIP(""), 0), CVOL_ERROR_FORMAT, "0 of the 12", "");
    /* a small file cannot claim gigabytes */
    read_fails(write_text("g.nrrd", TYPE8 "dimension: 3\nsizes: 1000 1000 1000\nencoding: gz\n\n",
                          packed, size),
               CVOL_ERROR_FORMAT, "cannot hold", "1000000000");
}

static void test_nrrd_lies(void **state)
{
    (void)state;
#define LIE(type, dimension, sizes, encoding, size)                          \
    nrrd("NRRD0004\ntype: " type "\ndimension: " dimension "\nsizes: " sizes \
         "\nendian: little\nencoding: " encoding "\n\n",                     \
         size)
    read_fails(LIE("uint8", "3", "2 0 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'0'");
    read_fails(LIE("uint8", "3", "2 -3 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'-3'");
    read_fails(LIE("uint8", "3", "2 3", "raw", 12), CVOL_ERROR_FORMAT,
               "sizes has 2 values, dimension is 3", "");
    read_fails(LIE("uint8", "3", "2 3 2 1", "raw", 12), CVOL_ERROR_FORMAT, "sizes has 4 values",
               "");
    read_fails(LIE("uint8", "3", "2 3.0 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'3.0'");
    read_fails(LIE("uint8", "3", "2 12abc 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'12abc'");
    read_fails(LIE("uint8", "3", "2147483648 1 1", "raw", 12), CVOL_ERROR_FORMAT,
               "12 of the 2147483648 bytes", "");
    read_fails(LIE("uint8", "3", "2147483648 2147483648 1", "raw", 12), CVOL_ERROR_LIMIT,
               "2147483648", "limit");
    read_fails(LIE("double", "3", "4294967296 4294967296 4294967296", "raw", 12), CVOL_ERROR_LIMIT,
               "4294967296", "");
    read_fails(LIE("double", "3", "4611686018427387904 4 1", "raw", 12), CVOL_ERROR_LIMIT,
               "4611686018427387904", "");
    read_fails(LIE("uint8", "3", "99999999999999999999 1 1", "raw", 12), CVOL_ERROR_FORMAT, "sizes",
               "99999999999999999999");
    read_fails(LIE("uint8", "three", "2 3 2", "raw", 12), CVOL_ERROR_FORMAT, "dimension", "three");
    read_fails(LIE("int128", "3", "2 3 2", "raw", 12), CVOL_ERROR_FORMAT, "type", "int128");
    read_fails(LIE("int64", "3", "2 3 2", "raw", 12), CVOL_ERROR_UNSUPPORTED, "type", "int64");
    read_fails(LIE("uint8", "3", "2 3 2", "zip", 12), CVOL_ERROR_FORMAT, "encoding", "zip");
    read_fails(LIE("uint8", "3", "2 3 2", "hex", 12), CVOL_ERROR_UNSUPPORTED, "encoding", "hex");
    read_fails(LIE("uint8", "3", "2 3 2", "bzip2", 12), CVOL_ERROR_UNSUPPORTED, "bzip2", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 11), CVOL_ERROR_FORMAT,
               "holds 11 of the 12 bytes of samples that its header announces", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 0), CVOL_ERROR_FORMAT, "0 of the 12", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 15), CVOL_ERROR_FORMAT, "holds 3 bytes more",
               "12 bytes");
    cvol_context_set_limit_bytes(context, 11);
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 12), CVOL_ERROR_LIMIT, "2 x 3 x 2", "11");
    cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
}

static void test_nrrd_headers(void **state)
{
    (void)state;
    read_fails(nrrd("NRRD0006\n\n", 0), CVOL_ERROR_UNSUPPORTED, "NRRD0006", "");
    read_fails(nrrd("Hello\n\n", 0), CVOL_ERROR_FORMAT, "does not begin with 'NRRD'", "");
    read_fails(nrrd(TYPE8 SIZES "\n", 12), CVOL_ERROR_FORMAT, "no 'encoding'", "");
    read_fails(nrrd(TYPE8 "sizes: 2 3 2\nencoding: raw\n\n", 12), CVOL_ERROR_FORMAT,
               "no 'dimension'", "");
    read_fails(nrrd("NRRD0001\n" SIZES "encoding: raw\n\n", 12), CVOL_ERROR_FORMAT, "no 'type'",
               "");
    read_fails(nrrd(TYPE8 SIZES "sizes: 2 3 2\n" RAW, 12), CVOL_ERROR_FORMAT, "'sizes' twice", "");
    read_fails(nrrd(TYPE8 SIZES "encoding: raw\n", 0), CVOL_ERROR_FORMAT, "empty line", "");
    read_fails(nrrd(TYPE8 SIZES "no field\n" RAW, 12), CVOL_ERROR_FORMAT, "line 5", "no field");
    static const char with_nul[] = "NRRD0004\ntype: ui\0nt8\ndimension: 3\n";
    read_fails(write_bytes("n.nrrd", with_nul, sizeof with_nul - 1), CVOL_ERROR_FORMAT, "line 2",
               "NUL");
    read_fails(nrrd("NRRD0004\ntype: \033[2J\n" SIZES RAW, 12), CVOL_ERROR_FORMAT, "type",
               "?[2J"); /* no escapes in messages */
    read_fails(write_bytes("e.nrrd", "", 0), CVOL_ERROR_FORMAT, "is empty", "");
    read_fails(in_folder("gone.nrrd"), CVOL_ERROR_IO, "No such file", "");
    read_fails(in_folder(""), CVOL_ERROR_IO, "is a directory", "");
    size_t size = (size_t)3 << 20;
    char *endless = malloc(size);
    memset(endless, 'x', size);
    memcpy(endless, "NRRD0004\n", 9);
    read_fails(write_bytes("x.nrrd", endless, size), CVOL_ERROR_FORMAT, "1048576", "header");
    free(endless);
    remove(in_folder("x.nrrd"));
}

/* ---- MetaImage by hand --------------------------------------------------------------- */

#define META "ObjectType = Image\nNDims = 3\n"

static const char *meta(const char *text, size_t size)
{
    nrrd("", 0);
    return write_text("m.mha", text, counting, size);
}

static void test_meta_plain(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(meta(META "DimSize = 2 3 2\nElementType = MET_UCHAR\n"
                                       "ElementSize = 2 3 4\nElementDataFile = LOCAL\n",
                                  12));
    assert_memory_equal(v->data, counting, 12);
    assert_true(v->grid.spacing[2] == 4 && v->grid.space == CVOL_SPACE_UNKNOWN);
    cvol_volume_free(v);
    v = read_ok(meta("NDims = 3\r\nComment = x = y\r\nBinaryData = True\r\n"
                     "BinaryDataByteOrderMSB = True\r\nDimSize = 2 3 2\r\n"
                     "TransformMatrix = 0 2 0 -1 0 0 0 0 1\r\nOffset = 1 2.5 -3\r\n"
                     "ElementSpacing = 0.5 1 2\r\nElementSize = 9 9 9\r\nDistanceUnits = um\r\n"
                     "ElementType = MET_SHORT\r\nElementDataFile = LOCAL\r\n",
                     24));
    assert_int_equal(((int16_t *)v->data)[11], 23 << 8 | 24);
    assert_true(v->grid.direction[0][1] == 1 && v->grid.direction[1][0] == -1);
    assert_true(v->grid.spacing[0] == 0.5 && v->grid.origin[1] == 2.5);
    assert_int_equal(v->grid.space, CVOL_SPACE_LPS);
    assert_string_equal(v->grid.unit, "um");
    cvol_volume_free(v);
    v = read_ok(meta("ObjectType = Image\nNDims = 2\nDimSize = 4 3\nElementSpacing = 2 3\n"
                     "Position = 5 6\nOrientation = 0 1 -1 0\nElementType = MET_CHAR\n"
                     "ElementDataFile = LOCAL\n",
                     12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[1] == 3 && v->grid.origin[1] == 6);
    assert_true(v->grid.direction[1][0] == -1 && v->grid.direction[2][2] == 1);
    cvol_volume_free(v);
    v = read_ok(meta(META "DimSize = 1 3 1\nBinaryData = False\nElementType = MET_FLOAT\n"
                          "ElementDataFile = LOCAL\n1 2.5\n-3",
                     0));
    assert_true(((float *)v->data)[1] == 2.5f);
    cvol_volume_free(v);
}

static void test_meta_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        cvol_type type;
    } names[] = {
        {"MET_CHAR", CVOL_INT8},      {"MET_UCHAR", CVOL_UINT8},  {"MET_SHORT", CVOL_INT16},
        {"MET_USHORT", CVOL_UINT16},  {"MET_INT", CVOL_INT32},    {"MET_UINT", CVOL_UINT32},
        {"MET_LONG", CVOL_INT32},     {"MET_ULONG", CVOL_UINT32}, {"MET_FLOAT", CVOL_FLOAT32},
        {"MET_DOUBLE", CVOL_FLOAT64},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[200];
        snprintf(text, sizeof text,
                 META "DimSize = 1 2 1\nElementType = %s\nElementDataFile = LOCAL\n",
                 names[i].name);
        cvol_volume *v = read_ok(meta(text, 2 * cvol_type_size(names[i].type)));
        assert_int_equal(v->grid.type, names[i].type);
        cvol_volume_free(v);
    }
}

static void test_meta_detached(void **state)
{
    (void)state;
    nrrd("", 0);
    write_bytes("m.raw", counting, 24);
#define MHD(text) \
    write_text("m.mhd", META "DimSize = 2 3 2\nElementType = MET_UCHAR\n" text, NULL, 0)
    cvol_volume *v = read_ok(MHD("HeaderSize = 3\nElementDataFile = m.raw\nIgnored\n"));
    assert_memory_equal(v->data, counting + 3, 12);
    cvol_volume_free(v);
    v = read_ok(MHD("HeaderSize = -1\nElementDataFile = m.raw"));
    assert_memory_equal(v->data, counting + 12, 12);
    cvol_volume_free(v);
    uint8_t packed[128];
    size_t size = gzip(packed, sizeof packed, counting, 12, 15);
    memcpy(packed + size, "tail", 4);
    write_bytes("m.zraw", packed, size);
    v = read_ok(MHD("CompressedData = True\nElementDataFile = m.zraw\n"));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    write_bytes("m.zraw", packed, size + 4);
    char text[200];
    snprintf(text, sizeof text,
             META "DimSize = 2 3 2\nElementType = MET_UCHAR\nCompressedData = True\n"
                  "CompressedDataSize = %zu\nElementDataFile = m.zraw\n",
             size);
    v = read_ok(write_text("m.mhd", text, NULL, 0));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    cvol_volume *none;
    const char *path = MHD("CompressedData = True\nCompressedDataSize = 10000\n"
                           "ElementDataFile = m.zraw\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "of the 10000 compressed bytes"));
    read_fails(MHD("ElementDataFile = gone.raw\n"), CVOL_ERROR_IO, "gone.raw", "No such file");
    read_fails(MHD("ElementDataFile = LIST\na.raw\n"), CVOL_ERROR_UNSUPPORTED, "ElementDataFile",
               "LIST");
    read_fails(MHD("ElementDataFile = a%02d.raw 0 1 1\n"), CVOL_ERROR_UNSUPPORTED, "a%02d", "");
    read_fails(MHD("HeaderSize = -2\nElementDataFile = m.raw\n"), CVOL_ERROR_FORMAT, "HeaderSize",
               "-2");
    read_fails(MHD("CompressedData = True\nHeaderSize = -1\nElementDataFile = m.zraw\n"),
               CVOL_ERROR_FORMAT, "HeaderSize", "-1");
    read_fails(MHD("ElementDataFile = \n"), CVOL_ERROR_FORMAT, "ElementDataFile", "");
}

static void test_meta_lies(void **state)
{
    (void)state;
#define MHA(size, dims, type, more) \
    meta(META "DimSize = " dims "\nElementType = " type "\n" more "ElementDataFile = LOCAL\n", size)
    read_fails(MHA(12, "2 0 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "'0'");
    read_fails(MHA(12, "2 -3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "'-3'");
    read_fails(MHA(12, "2 3", "MET_UCHAR", ""), CVOL_ERROR_FORMAT,
               "DimSize has 2 values, NDims is 3", "");
    read_fails(MHA(12, "2 3 2k", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "2k");
    read_fails(MHA(12, "2147483648 2 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT,
               "12 of the 8589934592", "");
    read_fails(MHA(12, "2147483648 2147483648 2147483648", "MET_UCHAR", ""), CVOL_ERROR_LIMIT,
               "2147483648", "");
    read_fails(MHA(11, "2 3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "11 of the 12 bytes", "");
    read_fails(MHA(14, "2 3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "2 bytes more", "");
    read_fails(MHA(12, "2 3 2", "MET_LONG_LONG", ""), CVOL_ERROR_UNSUPPORTED, "ElementType",
               "MET_LONG_LONG");
    read_fails(MHA(12, "2 3 2", "int", ""), CVOL_ERROR_FORMAT, "ElementType", "int");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementNumberOfChannels = 3\n"),
               CVOL_ERROR_UNSUPPORTED, "ElementNumberOfChannels", "3");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "CompressedData = True\n"), CVOL_ERROR_FORMAT,
               "damaged", "");
    read_fails(MHA(12, "900 900 900", "MET_UCHAR", "CompressedData = True\n"), CVOL_ERROR_FORMAT,
               "cannot hold", "729000000");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "CompressedData = Maybe\n"), CVOL_ERROR_FORMAT,
               "CompressedData", "Maybe");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementSpacing = 1 1 -1\n"), CVOL_ERROR_FORMAT,
               "spacing of axis z", "-1");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementSpacing = 1 nan 1\n"), CVOL_ERROR_FORMAT,
               "spacing of axis y", "nan");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "Offset = 1 inf 1\n"), CVOL_ERROR_FORMAT, "origin",
               "inf");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "TransformMatrix = 1 0 0 0 1 0 0 0\n"),
               CVOL_ERROR_FORMAT, "TransformMatrix has 8 values", "9");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "TransformMatrix = 1 0 0 0 1 0 0 0 0\n"),
               CVOL_ERROR_FORMAT, "TransformMatrix", "length");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "DimSize = 2 3 2\n"), CVOL_ERROR_FORMAT,
               "DimSize twice", "");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "nonsense\n"), CVOL_ERROR_FORMAT, "line 5",
               "nonsense");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "HeaderSize = 4\n"), CVOL_ERROR_FORMAT, "HeaderSize",
               "4");
    read_fails(meta("ObjectType = Image\nNDims = 4\nDimSize = 2 3 2 1\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n",
                    12),
               CVOL_ERROR_UNSUPPORTED, "NDims '4'", "");
    read_fails(meta("ObjectType = Tube\nNDims = 3\nDimSize = 2 3 2\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n",
                    12),
               CVOL_ERROR_UNSUPPORTED, "ObjectType 'Tube'", "");
    read_fails(meta(META "DimSize = 2 3 2\nElementType = MET_UCHAR\n", 0), CVOL_ERROR_FORMAT,
               "no ElementDataFile", "");
    read_fails(meta("rubbish", 30), CVOL_ERROR_FORMAT, "line 1", "rubbish");
}

/* ---- NIfTI by hand ------------------------------------------------------------------- */

/* A header of 2 x 3 x 2 uint8 in this machine's order or the other; fields are set by offset. */
typedef struct header {
    uint8_t bytes[600];
    int version, swapped;
} header;

static void set(header *h, size_t at, const void *value, size_t width)
{
    for (size_t i = 0; i < width; i++)
        h->bytes[at + i] = ((const uint8_t *)value)[h->swapped ? width - 1 - i : i];
}

static void set16(header *h, size_t at, int value)
{
    int16_t v = (int16_t)value;
    set(h, at, &v, sizeof v);
}

static void set32(header *h, size_t at, int32_t value)
{
    set(h, at, &value, sizeof value);
}

static void set64(header *h, size_t at, int64_t value)
{
    set(h, at, &value, sizeof value);
}

static void set_float(header *h, size_t at, float value)
{
    set(h, at, &value, sizeof value);
}

static void set_double(header *h, size_t at, double value)
{
    set(h, at, &value, sizeof value);
}

static void set_dims(header *h, int64_t count, int64_t x, int64_t y, int64_t z, int64_t t)
{
    const int64_t dims[8] = {count, x, y, z, t, 1, 1, 1};
    for (size_t i = 0; i < 8; i++)
        if (h->version == 1)
            set16(h, 40 + 2 * i, (int)dims[i]);
        else
            set64(h, 16 + 8 * i, dims[i]);
}

static header nifti1(int swapped)
{
    header h = {.version = 1, .swapped = swapped};
    set32(&h, 0, 348);
    set_dims(&h, 3, 2, 3, 2, 1);
    set16(&h, 70, 2);
    set16(&h, 72, 8);
    for (size_t i = 0; i < 4; i++)
        set_float(&h, 76 + 4 * i, (float)i + 1);
    set_float(&h, 108, 352);
    memcpy(h.bytes + 344, "n+1", 4);
    return h;
}

static header nifti2(int swapped)
{
    header h = {.version = 2, .swapped = swapped};
    set32(&h, 0, 540);
    memcpy(h.bytes + 4, "n+2\0\r\n\032\n", 8);
    set_dims(&h, 3, 2, 3, 2, 1);
    set16(&h, 12, 2);
    set16(&h, 14, 8);
    for (size_t i = 0; i < 4; i++)
        set_double(&h, 104 + 8 * i, (double)i + 1);
    set64(&h, 168, 544);
    return h;
}

/* The header and `size` counting bytes behind it. */
static const char *nifti(const header *h, size_t size)
{
    uint8_t bytes[1000];
    size_t length = h->version == 1 ? 352 : 544;
    nrrd("", 0);
    memcpy(bytes, h->bytes, length);
    memcpy(bytes + length, counting, size);
    return write_bytes("n.nii", bytes, length + size);
}

static void test_nifti_plain(void **state)
{
    (void)state;
    for (int version = 1; version <= 2; version++)
        for (int swapped = 0; swapped < 2; swapped++) {
            header h = version == 1 ? nifti1(swapped) : nifti2(swapped);
            set16(&h, version == 1 ? 70 : 12, 512);
            cvol_volume *v = read_ok(nifti(&h, 24));
            assert_int_equal(v->grid.type, CVOL_UINT16);
            uint16_t expected = swapped ? 1 << 8 | 2 : 2 << 8 | 1;
            assert_int_equal(((uint16_t *)v->data)[0], expected);
            assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[2] == 4);
            assert_int_equal(v->grid.space, CVOL_SPACE_RAS);
            assert_true(v->grid.value_scale == 1 && v->grid.value_offset == 0);
            cvol_volume_free(v);
        }
    header h = nifti1(0);
    set_dims(&h, 2, 4, 3, 9, 9);
    set_float(&h, 108, 0); /* "right behind the header" */
    set_float(&h, 88, 0);  /* pixdim[3] */
    cvol_volume *v = read_ok(nifti(&h, 12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[2] == 1);
    cvol_volume_free(v);
}

static void test_nifti_affine(void **state)
{
    (void)state;
    header h = nifti1(1);
    /* a qform: half a turn about y, mirrored z, then scl and units */
    set16(&h, 252, 1);
    set_float(&h, 76, -1);
    set_float(&h, 260, 1);
    set_float(&h, 268, 10);
    set_float(&h, 112, 2);
    set_float(&h, 116, -5);
    h.bytes[123] = 2 | 8;
    cvol_volume *v = read_ok(nifti(&h, 12));
    assert_true(v->grid.direction[0][0] == -1 && v->grid.direction[1][1] == 1);
    assert_true(v->grid.direction[2][2] == 1 && v->grid.origin[0] == 10);
    assert_true(v->grid.value_scale == 2 && v->grid.value_offset == -5);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    /* an sform goes before it */
    set16(&h, 254, 1);
    const float rows[12] = {0, 0, 3, 7, 2, 0, 0, 8, 0, 5, 0, 9};
    for (size_t i = 0; i < 12; i++)
        set_float(&h, 280 + 4 * i, rows[i]);
    v = read_ok(nifti(&h, 12));
    assert_true(v->grid.direction[0][1] == 1 && v->grid.direction[1][2] == 1 &&
                v->grid.direction[2][0] == 1);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 5 && v->grid.spacing[2] == 3);
    assert_true(v->grid.origin[2] == 9);
    cvol_volume_free(v);
    set_float(&h, 288, 0);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sform", "axis z");
    set_float(&h, 288, NAN);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sform", "nan");
    set_float(&h, 288, 3);
    set_float(&h, 292, INFINITY);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "origin", "inf");
}

/* NIfTI-2 is written where NIfTI-1 is too narrow. */
static void test_nifti_wide(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(2, 40000, 1, CVOL_INT8);
    grid.spacing[1] = 0.1;
    cvol_volume *volume = make_volume(&grid, 2);
    check_ok(cvol_volume_write(context, volume, in_folder("w.nii")));
    cvol_volume *back = read_ok(in_folder("w.nii"));
    same_samples(volume, back);
    near(back->grid.spacing[1], 0.1, 1e-15);
    cvol_volume_free(back);
    cvol_volume_free(volume);
}

static void test_nifti_pair(void **state)
{
    (void)state;
    header h = nifti1(0);
    memcpy(h.bytes + 344, "ni1", 4);
    set_float(&h, 108, 2);
    nrrd("", 0);
    write_bytes("p.img", counting, 14);
    const char *path = write_bytes("p.hdr", h.bytes, 348);
    cvol_volume *v = read_ok(path);
    assert_memory_equal(v->data, counting + 2, 12);
    cvol_volume_free(v);
    uint8_t packed[128];
    size_t size = gzip(packed, sizeof packed, counting, 14, 15 + 16);
    remove(in_folder("p.img"));
    read_fails(path, CVOL_ERROR_IO, "p.img", "No such file");
    write_bytes("p.img.gz", packed, size);
    v = read_ok(path);
    assert_memory_equal(v->data, counting + 2, 12);
    cvol_volume_free(v);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, ".hdr", "");
}

static void test_nifti_dims(void **state)
{
    (void)state;
    for (int version = 1; version <= 2; version++) {
        header h = version == 1 ? nifti1(0) : nifti2(0);
#define DIMS(n, x, y, z, t) (set_dims(&h, n, x, y, z, t), nifti(&h, 12))
        read_fails(DIMS(0, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is 0", "");
        read_fails(DIMS(8, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is 8", "");
        read_fails(DIMS(-3, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is -3", "");
        read_fails(DIMS(3, 2, 0, 2, 1), CVOL_ERROR_FORMAT, "dim[2] is 0", "");
        read_fails(DIMS(3, 2, 3, -2, 1), CVOL_ERROR_FORMAT, "dim[3] is -2", "");
        read_fails(DIMS(4, 2, 3, 2, 7), CVOL_ERROR_UNSUPPORTED, "dim[4] is 7", "time series");
        read_fails(DIMS(3, 2, 3, 3, 1), CVOL_ERROR_FORMAT, "12 of the 18 bytes", "");
        read_fails(DIMS(3, 2, 3, 1, 1), CVOL_ERROR_FORMAT, "6 bytes more", "");
        read_fails(DIMS(3, 30000, 30000, 70, 1), CVOL_ERROR_FORMAT, "12 of the 63000000000", "");
        read_fails(DIMS(3, 30000, 30000, 30000, 1), CVOL_ERROR_LIMIT, "30000", "limit");
    }
    header h = nifti2(0);
    read_fails(DIMS(3, INT64_C(1) << 31, 1, 1, 1), CVOL_ERROR_FORMAT, "12 of the 2147483648", "");
    read_fails(DIMS(3, INT64_C(1) << 62, 4, 2, 1), CVOL_ERROR_LIMIT, "4611686018427387904", "");
    read_fails(DIMS(3, INT64_MIN, 4, 2, 1), CVOL_ERROR_FORMAT, "dim[1] is -9223372036854775808",
               "");
}

static void test_nifti_lies(void **state)
{
    (void)state;
    header h = nifti1(0);
    set16(&h, 70, 1024);
    read_fails(nifti(&h, 12), CVOL_ERROR_UNSUPPORTED, "datatype 1024", "INT64");
    set16(&h, 70, 128);
    read_fails(nifti(&h, 12), CVOL_ERROR_UNSUPPORTED, "datatype 128", "RGB24");
    set16(&h, 70, 77);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "datatype is 77", "");
    set16(&h, 70, 0);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "datatype is 0", "");
    h = nifti1(0);
    const float offsets[] = {1, -352, 352.5f, 1e30f, INFINITY, NAN};
    const char *shown[] = {"1", "-352", "352.5", "1e+30", "inf", "nan"};
    for (int i = 0; i < 6; i++) {
        set_float(&h, 108, offsets[i]);
        read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "vox_offset is", shown[i]);
    }
    set_float(&h, 108, 1000000);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "0 of the 12 bytes", "");
    h = nifti1(0);
    memcpy(h.bytes + 344, "abcd", 4);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "magic is 'abcd'", "n+1");
    set32(&h, 0, 347);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sizeof_hdr is 347", "");
    h = nifti1(0);
    read_fails(write_bytes("n.nii", h.bytes, 200), CVOL_ERROR_FORMAT, "200 of the 348 bytes", "");
    read_fails(write_bytes("n.nii", h.bytes, 2), CVOL_ERROR_FORMAT, "sizeof_hdr", "");
    set_float(&h, 84, INFINITY);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "spacing of axis y is inf", "");
}

static void test_nifti_gzip(void **state)
{
    (void)state;
    header h = nifti1(1);
    nrrd("", 0);
    uint8_t plain[400], packed[600];
    memcpy(plain, h.bytes, 352);
    memcpy(plain + 352, counting, 20);
    size_t size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    cvol_volume *v = read_ok(write_bytes("n.nii.gz", packed, size));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    v = read_ok(write_bytes("nameless", packed, size)); /* known by content alone */
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    read_fails(write_bytes("n.nii.gz", packed, size - 20), CVOL_ERROR_FORMAT, "12 bytes", "");
    read_fails(write_bytes("n.nii.gz", packed, 20), CVOL_ERROR_FORMAT, "header", "");
    read_fails(write_bytes("n.nii.gz", "\x1f\x8bnonsense", 10), CVOL_ERROR_FORMAT, "damaged", "");
    size = gzip(packed, sizeof packed, plain, 366, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "more than", "12 bytes");
    set_dims(&h, 3, 2000, 2000, 1000, 1);
    memcpy(plain, h.bytes, 352);
    size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "cannot hold",
               "4000000000");
    set_dims(&h, 3, 2, 3, 2, 1);
    set_float(&h, 108, 0x1p61f);
    memcpy(plain, h.bytes, 352);
    size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "cannot hold", "12");
}

/* ---- raw, and files that nobody knows ------------------------------------------------ */

static void test_raw(void **state)
{
    (void)state;
    nrrd("", 0);
    const char *path = write_bytes("r.raw", counting, 24);
    cvol_read_options options = cvol_read_options_defaults();
    read_fails(path, CVOL_ERROR_ARGUMENT, "raw samples need --dims NXxNYxNZ and --type", "");
    options.type = CVOL_UINT16;
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "need --dims NXxNYxNZ", "");
    options = (cvol_read_options){.dims = {2, 3, 2}};
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "need --type", "");
    options.type = CVOL_UINT16;
    options.big_endian = 1;
    options.spacing[1] = 2.5;
    cvol_volume *v;
    check_ok(cvol_volume_read(context, &v, path, &options));
    assert_int_equal(((uint16_t *)v->data)[1], 3 << 8 | 4);
    assert_true(v->grid.spacing[0] == 1 && v->grid.spacing[1] == 2.5);
    cvol_volume_free(v);
    options.dims[2] = 3;
    read_fails_with(path, &options, CVOL_ERROR_FORMAT, "24 bytes", "36 bytes");
    options.dims[2] = 1;
    read_fails_with(path, &options, CVOL_ERROR_FORMAT, "24 bytes", "12 bytes");
    options.dims[2] = SIZE_MAX;
    read_fails_with(path, &options, CVOL_ERROR_LIMIT, "limit", "");
    options.dims[2] = 2;
    options.spacing[0] = -1;
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "spacing of axis x is -1", "");
    options.spacing[0] = 0;
    path = write_bytes("r.unknown", counting, 24);
    check_ok(cvol_volume_read(context, &v, path, &options));
    cvol_volume_free(v);
    read_fails(path, CVOL_ERROR_UNSUPPORTED, ".nii.gz", "--dims NXxNYxNZ and --type");
    path = nrrd(TYPE8 SIZES RAW, 12);
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "NRRD", "raw samples");
    /* what raw writes is little-endian */
    cvol_grid grid = cvol_grid_make(1, 2, 1, CVOL_UINT16);
    check_ok(cvol_volume_create(context, &v, &grid));
    ((uint16_t *)v->data)[1] = 0x1234;
    path = in_folder("r.raw");
    check_ok(cvol_volume_write(context, v, path));
    size_t size;
    uint8_t *bytes = support_read(path, &size);
    assert_int_equal(size, 4);
    assert_memory_equal(bytes, "\0\0\x34\x12", 4);
    free(bytes);
    cvol_volume_free(v);
}

/* Content goes before names. */
static void test_recognition(void **state)
{
    (void)state;
    nrrd("", 0);
    cvol_volume *v = read_ok(write_text("x.mha", TYPE8 SIZES RAW, counting, 12)); /* a NRRD */
    cvol_volume_free(v);
    v = read_ok(write_text("x",
                           "\n ObjectType= Image\nNDims = 3\nDimSize = 2 3 2\n"
                           "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
                           counting, 12));
    cvol_volume_free(v);
    header h = nifti2(1);
    uint8_t bytes[556];
    memcpy(bytes, h.bytes, 544);
    memcpy(bytes + 544, counting, 12);
    v = read_ok(write_bytes("x.nrrd", bytes, sizeof bytes));
    cvol_volume_free(v);
}

/* No prefix of a good file, and no changed byte of its header, may do more than fail. */
static void test_damage(void **state)
{
    (void)state;
    const char *names[] = {"a.nrrd", "a.mha", "a.nii", "a.nii.gz"};
    cvol_grid grid = odd_grid(CVOL_INT16, 0);
    cvol_volume *volume = make_volume(&grid, 8), *back;
    random_state r = {77};
    for (int f = 0; f < 4; f++) {
        size_t size;
        check_ok(cvol_volume_write(context, volume, in_folder(names[f])));
        uint8_t *bytes = support_read(in_folder(names[f]), &size);
        for (size_t cut = 1; cut < size; cut++) {
            write_bytes(names[f], bytes, cut);
            assert_true(cvol_volume_read(context, &back, in_folder(names[f]), NULL) < 0);
            assert_null(back);
            assert_true(strlen(cvol_context_message(context)) > 0);
        }
        for (int i = 0; i < 3000; i++) {
            size_t at = random_below(&r, (uint32_t)(size < 560 ? size : 560));
            uint8_t before = bytes[at];
            bytes[at] = (uint8_t)random_u64(&r);
            write_bytes(names[f], bytes, size);
            if (cvol_volume_read(context, &back, in_folder(names[f]), NULL) == CVOL_OK)
                cvol_volume_free(back);
            bytes[at] = before;
        }
        free(bytes);
    }
    cvol_volume_free(volume);
}

/* ---- real volumes -------------------------------------------------------------------- */

static void test_real(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        size_t dims[3];
        cvol_type type;
        double spacing[3], origin[3];
        cvol_space space;
    } files[] = {
        {"ch2better.nii.gz",
         {301, 370, 316},
         CVOL_UINT8,
         {.5, .5, .5},
         {-75, -107, -69.5},
         CVOL_SPACE_RAS},
        {"seg3d_mr.nii.gz",
         {160, 232, 160},
         CVOL_UINT8,
         {1, .8984, .8984},
         {-388.26, -81.12, 405.42},
         CVOL_SPACE_RAS},
        {"inia19.nii.gz",
         {168, 206, 128},
         CVOL_FLOAT32,
         {.5, .5, .5},
         {-42, -57.5, -30},
         CVOL_SPACE_RAS},
        {"cthead_8bit.nrrd", {256, 256, 99}, CVOL_UINT8, {1, 1, 2}, {0, 0, 0}, CVOL_SPACE_UNKNOWN},
        {"vhf_head.mha", {512, 512, 234}, CVOL_INT16, {1, 1, 1}, {0, 0, 0}, CVOL_SPACE_LPS},
        {"tooth.nrrd", {103, 94, 161}, CVOL_UINT16, {1, 1, 1}, {0, 0, 0}, CVOL_SPACE_UNKNOWN},
        {"fibsem_250.nrrd",
         {250, 250, 250},
         CVOL_UINT8,
         {10, 10, 10},
         {0, 0, 0},
         CVOL_SPACE_UNKNOWN},
        {"embryo.nrrd", {256, 256, 256}, CVOL_UINT8, {1, 1, 1}, {0, 0, 0}, CVOL_SPACE_UNKNOWN},
        {"betagal_em.nrrd",
         {100, 100, 100},
         CVOL_FLOAT32,
         {3.54, 3.54, 3.54},
         {0, 0, 0},
         CVOL_SPACE_UNKNOWN},
        {"ocean_v.nrrd", {128, 128, 24}, CVOL_FLOAT32, {1, 1, 1}, {0, 0, 0}, CVOL_SPACE_UNKNOWN},
    };
    for (size_t f = 0; f < sizeof files / sizeof files[0]; f++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", CVOL_TEST_DATA, files[f].name);
        if (!exists(path)) {
            print_message("skipped: %s\n", path);
            continue;
        }
        cvol_volume *v = read_ok(path);
        assert_int_equal(v->grid.type, files[f].type);
        assert_int_equal(v->grid.space, files[f].space);
        for (int a = 0; a < 3; a++) {
            assert_int_equal(v->grid.dims[a], files[f].dims[a]);
            near(v->grid.spacing[a], files[f].spacing[a], 1e-4);
            near(v->grid.origin[a], files[f].origin[a], 1e-4);
        }
        cvol_sample_stats stats;
        check_ok(cvol_volume_stats(context, &stats, v));
        assert_true(stats.bad_count == 0 && stats.max > stats.min);
        cvol_volume_free(v);
    }
    char path[512];
    cvol_read_options options = {.dims = {91, 91, 91}, .type = CVOL_FLOAT32};
    snprintf(path, sizeof path, "%s/wmag91_91x91x91_float32.raw", CVOL_TEST_DATA);
    cvol_volume *v;
    if (!exists(path))
        print_message("skipped: %s\n", path);
    else {
        check_ok(cvol_volume_read(context, &v, path, &options));
        cvol_volume_free(v);
    }
}

int main(void)
{
    const struct CMUnitTest samples[] = {
        cmocka_unit_test(test_create),
        cmocka_unit_test(test_stats),
        cmocka_unit_test(test_stats_types),
        cmocka_unit_test(test_compare),
    };
    const struct CMUnitTest writing[] = {
        cmocka_unit_test(test_round_trips), cmocka_unit_test(test_spaces),
        cmocka_unit_test(test_same_bytes),  cmocka_unit_test(test_value_scale),
        cmocka_unit_test(test_large),       cmocka_unit_test(test_locale),
    };
    const struct CMUnitTest refusing[] = {
        cmocka_unit_test(test_write_errors),
        cmocka_unit_test(test_cancel),
    };
    const struct CMUnitTest reading[] = {
        cmocka_unit_test(test_nrrd_plain),    cmocka_unit_test(test_nrrd_endian),
        cmocka_unit_test(test_nrrd_types),    cmocka_unit_test(test_nrrd_text),
        cmocka_unit_test(test_nrrd_axes),     cmocka_unit_test(test_nrrd_space),
        cmocka_unit_test(test_nrrd_detached), cmocka_unit_test(test_nrrd_gzip),
        cmocka_unit_test(test_nrrd_lies),     cmocka_unit_test(test_nrrd_headers),
        cmocka_unit_test(test_meta_plain),    cmocka_unit_test(test_meta_types),
        cmocka_unit_test(test_meta_detached), cmocka_unit_test(test_meta_lies),
        cmocka_unit_test(test_nifti_plain),   cmocka_unit_test(test_nifti_affine),
        cmocka_unit_test(test_nifti_wide),    cmocka_unit_test(test_nifti_pair),
        cmocka_unit_test(test_nifti_dims),    cmocka_unit_test(test_nifti_lies),
        cmocka_unit_test(test_nifti_gzip),    cmocka_unit_test(test_raw),
        cmocka_unit_test(test_recognition),   cmocka_unit_test(test_damage),
        cmocka_unit_test(test_real),
    };
    int failed = cmocka_run_group_tests(samples, open_all, close_all);
    failed += cmocka_run_group_tests(writing, open_all, close_all);
    failed += cmocka_run_group_tests(refusing, open_all, close_all);
    failed += cmocka_run_group_tests(reading, open_all, close_all);
    return failed != 0;
}
