/* Volumes: samples and statistics, round trips through every format, refusals, recognition, damaged
 * files and real ones. Separate tests cover each format's own features. */
#define _GNU_SOURCE
#include "test.h"

#include <ftw.h>

#include "cvol/volume.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"

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
    grid.dims[1] = 2;
    grid.value_scale = 0;
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_ARGUMENT);
    assert_string_equal(cvol_context_message(context),
                        "volume: value scale is 0, must be positive or negative");
    grid.value_scale = 1;
    grid.space = (cvol_space)3;
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_ARGUMENT);
    assert_string_equal(cvol_context_message(context), "volume: space is 3, must be 0, 1 or 2");
    grid.space = CVOL_SPACE_RAS;
    memset(grid.unit, 'm', sizeof grid.unit);
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_ARGUMENT);
    assert_string_equal(cvol_context_message(context),
                        "volume: unit 'mmmmmmmmmmmmmmmm' has 16 bytes without an end, at most 15 "
                        "are possible");
    grid = cvol_grid_make(SIZE_MAX / 2, SIZE_MAX / 2, 9, CVOL_FLOAT64);
    assert_int_equal(cvol_volume_create(context, &volume, &grid), CVOL_ERROR_LIMIT);
}

/* Bytes that a program of 32 bits cannot address are beyond its limit, whatever that was set to. */
static void test_addresses(void **state)
{
    (void)state;
    cvol_grid wrong = cvol_grid_make(3, 4, 5, CVOL_UINT8);
    wrong.spacing[1] = 0; /* no file is to blame */
    assert_int_equal(cvol_grid_check(context, &wrong, "grid"), CVOL_ERROR_ARGUMENT);
    const uint64_t before = cvol_context_limit_bytes(context);
    const cvol_grid grid = cvol_grid_make(2048, 2048, 2048, CVOL_FLOAT64);
    cvol_context_set_limit_bytes(context, UINT64_MAX);
    assert_true(cvol_context_limit_bytes(context) == SIZE_MAX);
#if SIZE_MAX > 0xffffffff
    check_ok(cvol_grid_check(context, &grid, "grid"));
#else
    assert_int_equal(cvol_grid_check(context, &grid, "grid"), CVOL_ERROR_LIMIT);
    assert_string_equal(cvol_context_message(context),
                        "grid: 2048 x 2048 x 2048 samples of float64 are more than the limit of "
                        "4294967295 bytes");
#endif
    cvol_context_set_limit_bytes(context, before);
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
    cvol_volume_statistics first = {0}, stats;
    for (int threads = 1; threads <= 5; threads++) {
        cvol_context_set_threads(context, threads);
        check_ok(cvol_volume_compute_statistics(context, &stats, volume));
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
    check_ok(cvol_volume_compute_statistics(context, &stats, volume));
    assert_int_equal(stats.bad_count, 0);
    assert_int_equal(cvol_volume_fill(context, volume, NAN), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_volume_fill(context, volume, 1e39), CVOL_ERROR_ARGUMENT);
    for (size_t i = 0; i < count; i++)
        samples[i] = NAN;
    check_ok(cvol_volume_compute_statistics(context, &stats, volume));
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
        cvol_volume_statistics stats;
        check_ok(cvol_volume_compute_statistics(context, &stats, volume));
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
    cvol_volume_statistics stats;
    check_ok(cvol_volume_compute_statistics(context, &stats, a));
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
    check_ok(cvol_volume_compare(context, &d, b, b)); /* a NaN equals itself in this comparison */
    assert_true(d.rmse == 0);
    cvol_volume_free(b);
    grid.dims[2]--;
    b = make_volume(&grid, 3);
    assert_int_equal(cvol_volume_compare(context, &d, a, b), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "64 x 65 x 65"));
    cvol_volume_free(b);
    cvol_volume_free(a);
}

/* Squares of tiny or huge differences are beyond the range of doubles. */
static void test_compare_at_all_magnitudes(void **state)
{
    (void)state;
    static const double scales[] = {1e-310, 1e-200, 1e-150, 1, 1e150, 1e200, 1e307};
    const cvol_grid grid = cvol_grid_make(64, 33, 17, CVOL_FLOAT64);
    cvol_volume *a, *b;
    check_ok(cvol_volume_create(context, &a, &grid));
    check_ok(cvol_volume_create(context, &b, &grid));
    const size_t count = cvol_grid_samples(&grid);
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
        double *in_a = a->data, *in_b = b->data;
        for (size_t i = 0; i < count; i++) {
            in_a[i] = scales[k] * (i % 2 ? 8 : -8);
            in_b[i] = in_a[i] + scales[k] * (i % 2 ? 3 : -4);
        }
        cvol_volume_difference d;
        check_ok(cvol_volume_compare(context, &d, a, b));
        const double share = (double)(count / 2) / (double)count;
        const double rmse = sqrt(share * 9 + (1 - share) * 16);
        near(d.rmse / scales[k], rmse, 1e-4);
        near(d.max_abs_error / scales[k], 4, 1e-4);
        near(d.psnr_db, 20 * log10(16 / rmse), 1e-3);
    }
    cvol_volume_free(a);
    cvol_volume_free(b);
}

/* ---- round trips --------------------------------------------------------------------- */

static const struct {
    const char *name;
    const char *data; /* the second file, if the format has one */
    cvol_space space; /* that the format writes */
    double relative;  /* the format keeps geometry */
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
        uint8_t *after = support_read(path, &again); /* the old file is still there */
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

static int remove_one(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status, (void)kind, (void)place;
    return remove(path);
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
        nftw(in_folder(name), remove_one, 8, FTW_DEPTH | FTW_PHYS); /* Zarr is a folder */
        cvol_volume_free(volume);
        ending += length + strspn(ending + length, " ");
    }
    remove(in_folder("F.raw"));
}

/* Decimal points stay points in a locale with commas. */
static void test_locale(void **state)
{
    (void)state;
    char *before = support_locale_with_comma();
    cvol_grid grid = odd_grid(CVOL_UINT8, 0);
    cvol_volume *volume = make_volume(&grid, 4);
    for (size_t w = 0; w < WRITERS; w++) {
        check_ok(cvol_volume_write(context, volume, in_folder(writers[w].name)));
        cvol_volume *back = read_ok(in_folder(writers[w].name));
        near(back->grid.spacing[0], 0.1, writers[w].relative);
        cvol_volume_free(back);
    }
    cvol_volume_free(volume);
    support_locale_restore(before);
}

/* ---- files of any format ------------------------------------------------------------- */

/* Content has precedence over names. */
static void test_recognition(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(
        write_text("x.mha", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nencoding: raw\n\n",
                   counting, 12)); /* a NRRD */
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

static int exists(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file)
        fclose(file);
    return file != NULL;
}

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
        cvol_volume_statistics stats;
        check_ok(cvol_volume_compute_statistics(context, &stats, v));
        assert_true(stats.bad_count == 0 && stats.max > stats.min);
        cvol_volume_free(v);
    }
    char path[512];
    cvol_read_options options = {
        .size = sizeof(cvol_read_options), .dims = {91, 91, 91}, .type = CVOL_FLOAT32};
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
        cmocka_unit_test(test_create),  cmocka_unit_test(test_addresses),
        cmocka_unit_test(test_stats),   cmocka_unit_test(test_stats_types),
        cmocka_unit_test(test_compare), cmocka_unit_test(test_compare_at_all_magnitudes),
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
        cmocka_unit_test(test_recognition),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_real),
    };
    int failed = cmocka_run_group_tests(samples, files_setup, files_teardown);
    failed += cmocka_run_group_tests(writing, files_setup, files_teardown);
    failed += cmocka_run_group_tests(refusing, files_setup, files_teardown);
    failed += cmocka_run_group_tests(reading, files_setup, files_teardown);
    return failed != 0;
}
