/* The .cvol file: round trips, and cut, flipped, invalid and fuzzed files. */
#include "test.h"

#include "base/context.h"
#include "random.h"
#include "support.h"

#include "fuzz/fuzz_cvol.c"
#include "support_context.h"

/* Places of fields in a file: signature 8, version 4, section header 24, then HEAD; header, GEOM;
 * header, ERRS. */
enum { HEAD_AT = 36, TYPE_AT = HEAD_AT + 24, TRANSFORM_AT = TYPE_AT + 4, RANK_AT = TYPE_AT + 8 };
enum {
    BLOCK_AT = TYPE_AT + 12,
    LAPPED_AT = TYPE_AT + 16,
    TRELLIS_AT = TYPE_AT + 20,
    STEP_AT = TYPE_AT + 24
};
enum { VALUE_MIN_AT = STEP_AT + 16, COUNT_AT = STEP_AT + 32, HEAD_END = COUNT_AT + 8 };
enum { GEOM_AT = HEAD_END + 24, SPACING_AT = GEOM_AT + 4, UNIT_AT = GEOM_AT + 124 };
enum { GEOM_END = GEOM_AT + 156, ERRS_AT = GEOM_END + 24, MAX_ABS_AT = ERRS_AT + 24 };
enum { MEASURED_AT = ERRS_AT + 72, ERRS_END = ERRS_AT + 76 };

/* The file that small_file copies. */
static uint8_t *kept;
static size_t kept_size;

static int stop(void **state)
{
    free(kept);
    return context_teardown(state);
}

static cvol_grid small_grid(void)
{
    cvol_grid grid = cvol_grid_make(21, 18, 9, CVOL_INT16);
    grid.spacing[1] = 0.25;
    grid.origin[2] = -7;
    grid.direction[0][0] = -1;
    grid.space = CVOL_SPACE_RAS;
    strcpy(grid.unit, "mm");
    grid.value_scale = 2;
    grid.value_offset = -1024;
    return grid;
}

/* A smooth volume with some noise, compressed. */
static cvol_array *small_array(const cvol_grid *grid, double ratio)
{
    const size_t count = cvol_grid_samples(grid);
    int16_t *samples = malloc(count * sizeof *samples);
    random_state r = {11};
    cvol_array *array;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = (int16_t)(1000 * sin((double)i / 50) + 40 * random_signed(&r));
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target_value = ratio;
    options.block = 8;
    int code = cvol_compress(context, &array, NULL, samples, grid, &options);
    if (code)
        print_message("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    free(samples);
    return array;
}

static uint8_t *make_small_file(size_t *size)
{
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    cvol_grid grid = small_grid();
    cvol_array *array = small_array(&grid, 5);
    uint64_t file_bytes;
    assert_int_equal(cvol_array_write(context, array, path, &file_bytes), CVOL_OK);
    uint8_t *data = support_read(path, size);
    assert_int_equal(*size, file_bytes);
    assert_true(cvol_file_is_cvol(path));
    cvol_array_free(array);
    free(path);
    support_folder_remove(folder);
    return support_unpack(data, size);
}

/* The bytes of a small file, which is made once; the caller frees them. */
static uint8_t *small_file(size_t *size)
{
    if (!kept)
        kept = make_small_file(&kept_size);
    uint8_t *data = malloc(kept_size);
    assert_non_null(data);
    memcpy(data, kept, kept_size);
    *size = kept_size;
    return data;
}

static int read_code(const uint8_t *data, size_t size)
{
    cvol_array *array = NULL;
    int code = cvol_container_read(context, &array, data, size, "f.cvol");
    cvol_array_free(array);
    return code;
}

/* ---- whole files ------------------------------------------------------------------------ */

static void file_keeps_everything(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    cvol_grid grid = small_grid();
    cvol_array *array = small_array(&grid, 5), *back;
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    assert_int_equal(cvol_array_read(context, &back, path, NULL), CVOL_OK);
    const cvol_grid *got = cvol_array_grid(back);
    assert_memory_equal(got->dims, grid.dims, sizeof grid.dims);
    assert_memory_equal(got->spacing, grid.spacing, sizeof grid.spacing);
    assert_memory_equal(got->origin, grid.origin, sizeof grid.origin);
    assert_memory_equal(got->direction, grid.direction, sizeof grid.direction);
    assert_string_equal(got->unit, grid.unit);
    assert_int_equal(got->space, grid.space);
    assert_true(got->value_scale == 2 && got->value_offset == -1024);
    cvol_array_info a, b;
    cvol_array_get_info(&a, array);
    cvol_array_get_info(&b, back);
    assert_true(a.psnr_db == b.psnr_db && a.max_error == b.max_error && a.l2_error == b.l2_error);
    assert_true(a.step == b.step && a.coefficients == b.coefficients);
    assert_true(a.max_abs == b.max_abs && a.measured == 1 && b.measured == 1 && b.rank == 3);
    assert_true(a.value_min == b.value_min && a.value_max == b.value_max);
    for (size_t i = 0; i < array->block_count; i++)
        assert_true(!back->has_ranges ||
                    !memcmp(array->block_table[i].range, back->block_table[i].range, 2));
    int16_t *one = calloc(cvol_grid_samples(&grid), 2), *two = calloc(cvol_grid_samples(&grid), 2);
    const size_t zero[3] = {0, 0, 0};
    assert_int_equal(cvol_array_evaluate_box(context, one, array, zero, grid.dims), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_box(context, two, back, zero, grid.dims), CVOL_OK);
    assert_memory_equal(one, two, cvol_grid_bytes(&grid));
    free(one);
    free(two);
    cvol_array_free(array);
    cvol_array_free(back);
    free(path);
    support_folder_remove(folder);
}

static void ranges_hold(void **state)
{
    (void)state;
    cvol_grid grid = small_grid();
    cvol_array *array = small_array(&grid, 5);
    float samples[512];
    for (size_t b = 0; b < array->block_count; b++) {
        double lo, hi;
        cvol_array_range(array, b, &lo, &hi);
        cvol_block_evaluate(samples, array, b);
        for (int i = 0; i < 512; i++) {
            assert_true((double)samples[i] + array->offset >= lo);
            assert_true((double)samples[i] + array->offset <= hi);
        }
    }
    cvol_array_free(array);
}

static void truncation_is_detected(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = small_file(&size);
    assert_int_equal(read_code(data, size), CVOL_OK);
    for (size_t cut = 0; cut < size; cut += SUPPORT_DAMAGE) {
        uint8_t *exact = malloc(cut ? cut : 1);
        assert_non_null(exact);
        memcpy(exact, data, cut);
        int code = read_code(exact, cut);
        assert_int_equal(code, cut < 8 ? CVOL_ERROR_FORMAT : CVOL_ERROR_CORRUPT);
        assert_non_null(strstr(cvol_context_message(context), "f.cvol: "));
        free(exact);
    }
    assert_int_equal(read_code(data, size - 10), CVOL_ERROR_CORRUPT);
    assert_non_null(
        strstr(cvol_context_message(context), "truncated: section CORR or ENDS at byte "));
    assert_non_null(strstr(cvol_context_message(context), "; it is whole up to level 0"));
    free(data);
}

static void every_flipped_byte_is_detected(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = small_file(&size);
    random_state r = {3};
    for (size_t i = 0; i < size; i += SUPPORT_DAMAGE) {
        uint8_t flip = (uint8_t)(1u << random_below(&r, 8)), other = (uint8_t)(random_u64(&r) | 1);
        data[i] ^= flip;
        assert_int_not_equal(read_code(data, size), CVOL_OK);
        data[i] ^= flip;
        data[i] ^= other;
        assert_int_not_equal(read_code(data, size), CVOL_OK);
        data[i] ^= other;
    }
    assert_int_equal(read_code(data, size), CVOL_OK);
    free(data);
}

static void trailing_bytes_are_refused(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = small_file(&size);
    data = realloc(data, size + 1);
    assert_non_null(data);
    data[size] = 0;
    assert_int_equal(read_code(data, size + 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "f.cvol: 1 bytes follow the end"));
    free(data);
}

/* ---- boxes ------------------------------------------------------------------------------- */

/* Samples of a box, read as that and cut from the whole, as floats. */
static void expect_box(const char *path, const cvol_array *whole, const size_t begin[3],
                       const size_t end[3])
{
    const cvol_grid grid = cvol_grid_box(cvol_array_grid(whole), begin, end);
    const size_t bytes = cvol_grid_bytes(&grid);
    cvol_array *part;
    uint64_t file_bytes = 0;
    assert_int_equal(cvol_array_read_box(context, &part, path, begin, end, &file_bytes), CVOL_OK);
    assert_true(file_bytes > 0);
    assert_memory_equal(cvol_array_grid(part)->dims, cvol_array_grid(whole)->dims,
                        sizeof grid.dims);
    void *a = calloc(1, bytes), *b = calloc(1, bytes);
    assert_true(a && b);
    assert_int_equal(cvol_array_evaluate_box(context, a, whole, begin, end), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_box(context, b, part, begin, end), CVOL_OK);
    assert_memory_equal(a, b, bytes);
    free(a);
    free(b);
    cvol_array_free(part);
}

/* Five bricks along x, three along y; the caller frees the path, the folder and the array. */
static cvol_array *bricked_file(const char *path)
{
    cvol_grid grid = cvol_grid_make(270, 140, 11, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid);
    const cvol_keep keep = cvol_keep_step(100);
    int16_t *samples = malloc(count * sizeof *samples);
    cvol_array *array, *back;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = (int16_t)(1000 * sin((double)i / 50));
    assert_int_equal(cvol_array_compress(context, &array, samples, &grid, 3, CVOL_DCT, 8, &keep),
                     CVOL_OK);
    free(samples);
    assert_int_equal(cvol_brick_count(array), 15);
    assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
    cvol_array_free(array);
    assert_int_equal(cvol_array_read(context, &back, path, NULL), CVOL_OK);
    return back;
}

static void boxes_equal_crops_of_the_whole(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    cvol_array *whole = bricked_file(path);
    const size_t *dims = cvol_array_grid(whole)->dims;
    random_state r = {21};
    cvol_array *part;
    expect_box(path, whole, (size_t[3]){0, 0, 0}, dims);
    expect_box(path, whole, (size_t[3]){127, 127, 0}, (size_t[3]){129, 129, 1});
    expect_box(path, whole, (size_t[3]){64, 64, 0}, (size_t[3]){128, 128, 11});
    expect_box(path, whole, (size_t[3]){269, 139, 10}, dims);
    for (int i = 0; i < 40; i += SUPPORT_STRIDE) {
        size_t begin[3], end[3];
        for (int a = 0; a < 3; a++) {
            begin[a] = random_below(&r, (uint32_t)dims[a]);
            end[a] = begin[a] + 1 + random_below(&r, (uint32_t)(dims[a] - begin[a]));
        }
        expect_box(path, whole, begin, end);
    }
    /* Only the bricks that the box touches were decoded. */
    cvol_array_info all, some;
    assert_int_equal(cvol_array_read_box(context, &part, path, (size_t[3]){0, 0, 0},
                                         (size_t[3]){128, 128, 11}, NULL),
                     CVOL_OK);
    cvol_array_get_info(&all, whole);
    cvol_array_get_info(&some, part);
    assert_true(some.coefficients > 0 && some.coefficients < all.coefficients * 2 / 3);
    cvol_array_free(part);
    cvol_array_free(whole);
    free(path);
    support_folder_remove(folder);
}

static void boxes_detect_damage_inside(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    size_t size;
    cvol_array *whole = bricked_file(path), *part;
    uint8_t *data = support_unpack(support_read(path, &size), &size);
    data[size - 25] ^= 1; /* the finest subband of the last brick, before ENDS */
    support_write(path, data, size);
    assert_int_equal(cvol_array_read(context, &part, path, NULL), CVOL_ERROR_CORRUPT);
    /* All fifteen bricks are one run, except for coarser levels. */
    const cvol_file_part coarse = {.size = sizeof(cvol_file_part), .level = 1},
                         corner = {.size = sizeof(cvol_file_part),
                                   .begin = (size_t[3]){0, 0, 0},
                                   .end = (size_t[3]){9, 9, 9},
                                   .level = 1};
    assert_int_equal(cvol_array_read_part(context, &part, NULL, path, &coarse), CVOL_OK);
    cvol_array_free(part);
    assert_int_equal(cvol_array_read_part(context, &part, NULL, path, &corner), CVOL_OK);
    cvol_array_free(part);
    assert_int_equal(cvol_array_read_box(context, &part, path, (size_t[3]){256, 128, 0},
                                         (size_t[3]){257, 129, 1}, NULL),
                     CVOL_ERROR_CORRUPT);
    assert_null(part);
    assert_non_null(strstr(cvol_context_message(context),
                           "section SHL3: the run of bricks from brick 0 of 15 is damaged"));
    /* Sections that every reader needs are always checked. */
    data[40] ^= 1;
    support_write(path, data, size);
    assert_int_equal(
        cvol_array_read_box(context, &part, path, (size_t[3]){0, 0, 0}, (size_t[3]){1, 1, 1}, NULL),
        CVOL_ERROR_CORRUPT);
    free(data);
    cvol_array_free(whole);
    free(path);
    support_folder_remove(folder);
}

static void wrong_boxes_are_refused(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    static const struct {
        size_t begin[3], end[3];
        const char *sentence;
    } cases[] = {
        {{5, 0, 0}, {5, 9, 9}, "the box is empty along x: it is 5:5 there, the volume 0:270"},
        {{0, 7, 0}, {5, 2, 9}, "the box is reversed along y: it is 7:2 there, the volume 0:140"},
        {{0, 0, 0},
         {5, 9, 12},
         "the box reaches beyond the volume along z: it is 0:12 there, the "
         "volume 0:11"},
        {{SIZE_MAX - 1, 0, 0}, {SIZE_MAX, 9, 1}, "the box reaches beyond the volume along x"},
    };
    cvol_array_free(bricked_file(path));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cvol_array *part;
        assert_int_equal(
            cvol_array_read_box(context, &part, path, cases[i].begin, cases[i].end, NULL),
            CVOL_ERROR_ARGUMENT);
        assert_null(part);
        if (!strstr(cvol_context_message(context), cases[i].sentence))
            fail_msg("%s", cvol_context_message(context));
    }
    for (int side = 0; side < 2; side++) {
        cvol_array *array;
        cvol_file_report report;
        cvol_file_part part = {.size = sizeof part};
        *(side ? &part.end : &part.begin) = cases[0].begin;
        assert_int_equal(cvol_array_read_part(context, &array, &report, path, &part),
                         CVOL_ERROR_ARGUMENT);
        assert_non_null(strstr(cvol_context_message(context), "a box needs begin and end"));
    }
    free(path);
    support_folder_remove(folder);
}

static void boxes_keep_their_position(void **state)
{
    (void)state;
    cvol_grid grid = small_grid();
    const size_t begin[3] = {3, 4, 5}, end[3] = {10, 6, 9};
    grid.direction[1][0] = 0.6;
    grid.direction[1][1] = 0.8;
    const cvol_grid box = cvol_grid_box(&grid, begin, end);
    assert_int_equal(box.dims[0], 7);
    assert_int_equal(box.dims[1], 2);
    assert_int_equal(box.dims[2], 4);
    for (int i = 0; i < 3; i++) {
        double world = grid.origin[i];
        for (int a = 0; a < 3; a++)
            world += grid.direction[a][i] * grid.spacing[a] * (double)begin[a];
        assert_true(fabs(box.origin[i] - world) < 1e-12);
    }
    assert_true(fabs(box.origin[0] - (-3 + 0.6)) < 1e-12);
    assert_memory_equal(box.direction, grid.direction, sizeof grid.direction);
    assert_memory_equal(box.spacing, grid.spacing, sizeof grid.spacing);
    assert_string_equal(box.unit, grid.unit);
}

/* ---- invalid values with valid checksums ------------------------------------------------ */

/* Puts bytes at a place, repairs the checksums, and reads. */
static int overwrite(size_t at, const void *bytes, size_t count)
{
    size_t size;
    uint8_t *data = small_file(&size);
    memcpy(data + at, bytes, count);
    fuzz_repair(data, size);
    int code = read_code(data, size);
    free(data);
    return code;
}

static int overwrite_u64(size_t at, uint64_t value)
{
    uint8_t bytes[8];
    for (int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
    return overwrite(at, bytes, 8);
}

static int overwrite_u32(size_t at, uint32_t value)
{
    uint8_t bytes[4];
    fuzz_put_u32(bytes, value);
    return overwrite(at, bytes, 4);
}

static int overwrite_f64(size_t at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, 8);
    return overwrite_u64(at, bits);
}

static void invalid_headers_are_refused(void **state)
{
    (void)state;
    assert_int_equal(overwrite_u32(TYPE_AT, CVOL_INT16), CVOL_OK); /* the unchanged value */
    assert_int_not_equal(overwrite_u64(HEAD_AT, 0), CVOL_OK);
    assert_int_not_equal(overwrite_u64(HEAD_AT, 22 + 8), CVOL_OK);
    assert_int_not_equal(overwrite_u64(HEAD_AT, UINT64_MAX), CVOL_OK);
    assert_int_not_equal(overwrite_u64(HEAD_AT, UINT64_C(1) << 32), CVOL_OK);
    assert_int_equal(overwrite_u64(HEAD_AT, UINT64_C(1) << 26),
                     CVOL_ERROR_CORRUPT); /* within limits */
    assert_non_null(strstr(cvol_context_message(context), "bricks are more than it can hold"));
    assert_int_not_equal(overwrite_u32(TYPE_AT, 9), CVOL_OK);
    assert_int_not_equal(overwrite_u32(TYPE_AT, CVOL_UINT8), CVOL_OK); /* value_min does not fit */
    assert_int_equal(overwrite_u32(TRANSFORM_AT, 4), CVOL_ERROR_UNSUPPORTED);
    assert_int_equal(overwrite_u32(TRANSFORM_AT, 2),
                     CVOL_ERROR_CORRUPT); /* then TERM would have to follow */
    assert_non_null(strstr(cvol_context_message(context), "section TERM is missing"));
    assert_int_equal(overwrite_u32(BLOCK_AT, 0), CVOL_ERROR_CORRUPT);
    assert_int_equal(overwrite_u32(RANK_AT, 2), CVOL_ERROR_CORRUPT);
    assert_int_equal(overwrite_u32(RANK_AT, 4), CVOL_ERROR_CORRUPT);
    assert_int_equal(overwrite_u32(LAPPED_AT, 1), CVOL_ERROR_CORRUPT); /* blocks of 8 */
    assert_int_equal(overwrite_u32(LAPPED_AT, 2), CVOL_ERROR_CORRUPT);
    assert_int_equal(overwrite_u32(TRELLIS_AT, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "dependent is 1, must be 0, or 1 of"));
    assert_int_equal(overwrite_u32(TRELLIS_AT, 2), CVOL_ERROR_CORRUPT);
    assert_int_not_equal(overwrite_u32(BLOCK_AT, 16), CVOL_OK);
    assert_int_not_equal(overwrite_u32(BLOCK_AT, 4), CVOL_OK);
    assert_int_not_equal(overwrite_f64(STEP_AT, 0), CVOL_OK);
    assert_int_not_equal(overwrite_f64(STEP_AT, -1), CVOL_OK);
    assert_int_not_equal(overwrite_f64(STEP_AT, (double)INFINITY), CVOL_OK);
    assert_int_not_equal(overwrite_f64(STEP_AT, 1e38),
                         CVOL_OK); /* floats cannot represent the samples */
    assert_int_not_equal(overwrite_f64(STEP_AT + 8, (double)NAN), CVOL_OK);
    assert_int_not_equal(overwrite_f64(VALUE_MIN_AT, -40000), CVOL_OK);
    assert_int_not_equal(overwrite_f64(VALUE_MIN_AT, 0.5), CVOL_OK);
    assert_int_not_equal(overwrite_f64(VALUE_MIN_AT + 8, -3000), CVOL_OK);
    assert_int_equal(overwrite_u64(COUNT_AT, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "section HEAD says 1"));
    assert_int_not_equal(overwrite_u32(GEOM_AT, 3), CVOL_OK);
    assert_int_not_equal(overwrite_f64(SPACING_AT, 0), CVOL_OK);
    assert_int_not_equal(overwrite_f64(SPACING_AT, (double)NAN), CVOL_OK);
    assert_int_not_equal(overwrite(UNIT_AT, "0123456789abcdef", 16), CVOL_OK);
    assert_int_not_equal(overwrite_f64(UNIT_AT + 16, (double)NAN), CVOL_OK);
    assert_int_equal(overwrite_f64(UNIT_AT + 16, -2), CVOL_OK);
    assert_int_equal(overwrite_f64(UNIT_AT + 16, 0), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "value scale is 0, must be positive or"));
    assert_int_equal(overwrite_f64(ERRS_AT, (double)NAN), CVOL_ERROR_CORRUPT);
    for (size_t at = ERRS_AT + 8; at < MEASURED_AT; at += 8) {
        assert_int_equal(overwrite_f64(at, -1), CVOL_ERROR_CORRUPT);
        assert_int_equal(overwrite_f64(at, (double)INFINITY), CVOL_ERROR_CORRUPT);
        assert_int_equal(overwrite_f64(at, (double)NAN), CVOL_ERROR_CORRUPT);
    }
    assert_int_equal(overwrite_u32(MEASURED_AT, 2), CVOL_ERROR_CORRUPT);
}

static void other_files_are_refused(void **state)
{
    (void)state;
    assert_int_equal(read_code((const uint8_t *)"NRRD0004\n", 9), CVOL_ERROR_FORMAT);
    assert_string_equal(cvol_context_message(context), "f.cvol: is not a .cvol file");
    assert_int_equal(overwrite_u32(8, 3), CVOL_ERROR_UNSUPPORTED);
    assert_string_equal(
        cvol_context_message(context),
        "f.cvol: is a .cvol of version 3 (at byte 8), this library reads version 1");
    assert_int_equal(overwrite_u32(8, 0), CVOL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(cvol_context_message(context),
                           "f.cvol: is a .cvol of version 0 (at byte 8), which is no longer read: "
                           "compress the volume again"));
    cvol_array *array;
    assert_int_equal(cvol_array_read(context, &array, "no/such/file.cvol", NULL), CVOL_ERROR_IO);
    assert_null(array);
    assert_false(cvol_file_is_cvol("no/such/file.cvol"));
}

/* ---- fuzzing ---------------------------------------------------------------------------- */

static void mutate(uint8_t *data, size_t size, random_state *r)
{
    for (uint32_t changes = 1 + random_below(r, 6); changes > 0; changes--) {
        size_t at = random_below(r, (uint32_t)size);
        switch (random_below(r, 4)) {
        case 0:
            data[at] ^= (uint8_t)(1u << random_below(r, 8));
            break;
        case 1:
            data[at] = (uint8_t)random_u64(r);
            break;
        case 2:
            data[at] = (uint8_t)(random_below(r, 2) ? 0 : 255);
            break;
        default:
            data[at] = data[random_below(r, (uint32_t)size)];
        }
    }
}

static void mutations_do_not_crash(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = small_file(&size), *changed = malloc(size);
    random_state r = {2024};
    assert_non_null(changed);
    for (int attempt = 0; attempt < 1000; attempt += SUPPORT_DAMAGE) {
        memcpy(changed, data, size);
        mutate(changed, size, &r);
        size_t cut = random_below(&r, 10) ? size : random_below(&r, (uint32_t)size);
        LLVMFuzzerTestOneInput(changed, cut);
    }
    free(changed);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(file_keeps_everything),
        cmocka_unit_test(ranges_hold),
        cmocka_unit_test(truncation_is_detected),
        cmocka_unit_test(every_flipped_byte_is_detected),
        cmocka_unit_test(boxes_equal_crops_of_the_whole),
        cmocka_unit_test(boxes_detect_damage_inside),
        cmocka_unit_test(wrong_boxes_are_refused),
        cmocka_unit_test(boxes_keep_their_position),
        cmocka_unit_test(trailing_bytes_are_refused),
        cmocka_unit_test(invalid_headers_are_refused),
        cmocka_unit_test(other_files_are_refused),
        cmocka_unit_test(mutations_do_not_crash),
    };
    return cmocka_run_group_tests(tests, context_setup_two, stop);
}
