/* Lack of memory in the codec: in each step every allocation fails in turn that has a call stack of
 * its own, alone or with all that follow it. The result is either that of a run in which nothing
 * fails, or CVOL_ERROR_MEMORY with a message and no file. In both cases all memory is freed. Runs
 * if the C library lets a program replace its allocation. */
#include "test.h"

#include <unistd.h>

#include "array/core/array.h"
#include "base/bytes.h"
#include "base/context.h"
#include "base/for_type.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support.h"
#include "support_allocation.h"
#include "support_files.h"
#include "support_render.h"

typedef enum samples_kind { SMOOTH, LABELS, HOLES, OUTLIERS, BACKGROUND } samples_kind;

/* A step writes file_path, or makes a number that distinguishes its results. It frees its objects
 * in any case, and allocates nothing itself. */
typedef struct step {
    const char *name;
    int (*go)(const struct step *step, uint32_t *result);
    cvol_type type;
    samples_kind kind;
    cvol_compress_options options; /* without its size */
    int block;                     /* of arrays and pictures */
    double ratio;                  /* of pictures */
} step;

static cvol_volume volume; /* of the current step */
static char *in_path;      /* what the current step reads */
static cvol_image *image;
static uint8_t samples[8 * 30 * 17 * 9];

/* ---- samples ---------------------------------------------------------------------------- */

static double make_sample(samples_kind kind, const double at[3], double noise)
{
    const double wave = 90 + 40 * sin(0.21 * at[0]) * cos(0.17 * at[1] + 0.1 * at[2]) + noise;
    const int inside = hypot(hypot(at[0] - 14, at[1] - 9), at[2] - 5) < 7;
    switch (kind) {
    case LABELS:
        return floor(at[0] / 11) + 4 * floor(at[1] / 9) + 90 * floor(at[2] / 8);
    case HOLES:
        return inside ? -5 : wave;
    case OUTLIERS:
        return fabs(noise) > 0.999 ? 1e7 : wave;
    case BACKGROUND:
        return inside ? wave : 0;
    case SMOOTH:
        return wave;
    }
    return 0;
}

static void make_volume(const step *s)
{
    const int is_slow = s->options.effort == CVOL_EFFORT_MAX;
    random_state r = {7};
    size_t i = 0;
    free(volume.data);
    volume = is_slow ? support_volume(18, 16, 8, s->type)
                     : support_volume(SUPPORT_SIDE(30), 17, 9, s->type);
    volume.grid.spacing[2] = 1.5;
    for (size_t z = 0; z < volume.grid.dims[2]; z++)
        for (size_t y = 0; y < volume.grid.dims[1]; y++)
            for (size_t x = 0; x < volume.grid.dims[0]; x++, i++) {
                const double value = make_sample(
                    s->kind, (double[]){(double)x, (double)y, (double)z}, random_signed(&r));
#define STORE(T) ((T *)volume.data)[i] = (T)value
                CVOL_FOR_TYPE(s->type, STORE)
#undef STORE
            }
}

/* ---- writing volumes -------------------------------------------------------------------- */

static cvol_compress_options options_of(const step *s)
{
    cvol_compress_options options = s->options;
    const cvol_compress_options usual = cvol_compress_options_defaults();
    options.size = sizeof options;
    options.transform = usual.transform;
    options.block = options.block ? options.block : usual.block;
    options.lapped = options.block == 16 && !options.lapped;
    if (!options.target) {
        options.target = CVOL_TARGET_RATIO;
        options.target_value = 12;
    }
    options.attributes = "{\"a\": 1}";
    return options;
}

static int write_and_free(int code, cvol_array *array)
{
    if (code)
        return code;
    code = cvol_array_write(context, array, file_path, NULL);
    cvol_array_free(array);
    return code;
}

static int compress(const step *s, uint32_t *result)
{
    const cvol_compress_options options = options_of(s);
    cvol_array *array;
    (void)result;
    const int code = cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options);
    return write_and_free(code, array);
}

/* The bytes of slices, or of some of their rows. */
static int read_rows(cvol_context *c, void *user, void *to, size_t first, size_t slices,
                     size_t first_row, size_t rows)
{
    const size_t row = volume.grid.dims[0] * cvol_type_size(volume.grid.type);
    (void)c;
    (void)user;
    for (size_t z = 0; z < slices; z++)
        memcpy((uint8_t *)to + z * rows * row,
               (const uint8_t *)volume.data + ((first + z) * volume.grid.dims[1] + first_row) * row,
               rows * row);
    return CVOL_OK;
}

static int read_slices(cvol_context *c, void *user, void *to, size_t first, size_t slices)
{
    return read_rows(c, user, to, first, slices, 0, volume.grid.dims[1]);
}

static const cvol_sample_source slices_source = {.read = read_slices},
                                rows_source = {.read = read_slices, .read_rows = read_rows};

static int stream(const step *s, uint32_t *result)
{
    const cvol_compress_options options = options_of(s);
    (void)result;
    return cvol_compress_stream(context, NULL, file_path, &rows_source, &volume.grid, &options);
}

static int write_series(const step *s, uint32_t *result)
{
    const cvol_compress_options options = options_of(s);
    static const char *const names[] = {"DAPI", "GFP"};
    const cvol_series_options list = {
        .size = sizeof list, .times = 1, .channels = 2, .time_unit = "ms", .channel_names = names};
    cvol_series_writer *writer;
    cvol_array *array = NULL;
    (void)result;
    int code = cvol_series_writer_open(context, &writer, file_path, &list);
    if (code)
        return code;
    code = cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options);
    if (!code)
        code = cvol_series_add(context, writer, array, NULL);
    if (!code)
        code = cvol_series_add_stream(context, writer, NULL, &slices_source, &volume.grid,
                                      &options);
    cvol_array_free(array);
    if (!code)
        return cvol_series_writer_commit(context, writer, NULL);
    cvol_series_writer_abandon(writer);
    return code;
}

/* ---- reading volumes -------------------------------------------------------------------- */

/* The checksum of all samples. */
static int hash_and_free(uint32_t *result, int code, cvol_array *array)
{
    const size_t zero[3] = {0, 0, 0};
    if (code)
        return code;
    code = cvol_array_evaluate_box(context, samples, array, zero, array->grid.dims);
    if (!code)
        *result = cvol_crc32c(samples, cvol_grid_bytes(&array->grid));
    cvol_array_free(array);
    return code;
}

static int read_part(uint32_t *result, cvol_file_part part)
{
    cvol_array *array;
    part.size = sizeof part;
    const int code = cvol_array_read_part(context, &array, NULL, in_path, &part);
    return hash_and_free(result, code, array);
}

static int read_whole(const step *s, uint32_t *result)
{
    (void)s;
    return read_part(result, (cvol_file_part){.level = 0});
}

static int read_level(const step *s, uint32_t *result)
{
    (void)s;
    return read_part(result, (cvol_file_part){.level = 2});
}

static int read_box(const step *s, uint32_t *result)
{
    static const size_t begin[3] = {5, 6, 1}, end[3] = {14, 14, 8};
    (void)s;
    return read_part(result, (cvol_file_part){.begin = begin, .end = end, .with_ranges = 1});
}

static int read_channel(const step *s, uint32_t *result)
{
    (void)s;
    return read_part(result, (cvol_file_part){.channel = 1});
}

static int read_memory(const step *s, uint32_t *result)
{
    cvol_array *array, *again;
    void *bytes;
    size_t size;
    (void)s;
    int code = cvol_array_read(context, &array, in_path, NULL);
    if (code)
        return code;
    code = cvol_array_write_memory(context, array, &bytes, &size);
    cvol_array_free(array);
    if (code)
        return code;
    code = cvol_array_read_memory(context, &again, bytes, size, "memory");
    free(bytes);
    return hash_and_free(result, code, again);
}

static int verify(const step *s, uint32_t *result)
{
    cvol_file_layout layout;
    (void)s;
    const int code = cvol_file_verify(context, &layout, in_path);
    *result = (uint32_t)layout.section_count;
    return code;
}

static int set_bricks(const step *s, uint32_t *result)
{
    cvol_array *array;
    (void)s;
    (void)result;
    int code = cvol_array_read(context, &array, in_path, NULL);
    if (code)
        return code;
    code = cvol_array_set_bricks(context, array, (const int[]){48, 32, 32});
    if (!code)
        return write_and_free(code, array);
    cvol_array_free(array);
    return code;
}

static int transcode(const step *s, uint32_t *result)
{
    cvol_compress_options options = options_of(s);
    cvol_array *array, *coarser;
    (void)result;
    int code = cvol_array_read(context, &array, in_path, NULL);
    if (code)
        return code;
    if (options.target == CVOL_TARGET_PSNR)
        options.target_value -= 8;
    else
        options.target_value *= 3;
    code = cvol_array_transcode(context, &coarser, NULL, array, &options);
    cvol_array_free(array);
    return write_and_free(code, coarser);
}

static int measure(const step *s, uint32_t *result)
{
    cvol_array *array;
    cvol_array_info info;
    (void)s;
    int code = cvol_array_read(context, &array, in_path, NULL);
    if (code)
        return code;
    code = cvol_array_measure(context, array, volume.data);
    cvol_array_get_info(&info, array);
    if (!code)
        *result = cvol_crc32c(&info.psnr_db, sizeof info.psnr_db);
    cvol_array_free(array);
    return code;
}

static int extract(const step *s, uint32_t *result)
{
    cvol_series *series;
    (void)s;
    int code = cvol_series_read(context, &series, in_path);
    if (code)
        return code;
    *result = (uint32_t)cvol_series_volume_bytes(series, 0, 1);
    cvol_series_free(series);
    return cvol_series_extract(context, in_path, 0, 1, file_path, NULL);
}

/* ---- other arrays, pictures, baked volumes ---------------------------------------------- */

static int write_array(const step *s, uint32_t *result)
{
    const cvol_keep keep = cvol_keep_ratio(5);
    const cvol_transform transform = s->options.transform;
    cvol_array *array;
    (void)result;
    const int code = cvol_array_compress(context, &array, volume.data, &volume.grid, 3, transform,
                                         s->block, &keep);
    return write_and_free(code, array);
}

static int write_picture(const step *s, uint32_t *result)
{
    cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture;
    cvol_picture_info info;
    options.block = s->block;
    options.ratio = s->ratio;
    int code = cvol_picture_compress(context, &picture, image, &options);
    if (code)
        return code;
    code = cvol_picture_get_info(context, &info, picture);
    if (!code)
        *result = (uint32_t)info.file_bytes;
    if (!code)
        code = cvol_picture_write(context, picture, file_path, NULL);
    cvol_picture_free(picture);
    return code;
}

static int read_picture(const step *s, uint32_t *result)
{
    cvol_picture *picture;
    cvol_image *decoded;
    (void)s;
    int code = cvol_picture_read(context, &picture, in_path);
    if (code)
        return code;
    code = cvol_picture_evaluate(context, &decoded, picture);
    cvol_picture_free(picture);
    if (code)
        return code;
    *result = cvol_crc32c(decoded->rgba, 4 * (size_t)decoded->width * (size_t)decoded->height);
    cvol_image_free(decoded);
    return code;
}

static cvol_render_options view(const step *s)
{
    cvol_render_options options = support_square(40, CVOL_MODE_COMPOSITE, 20, 10);
    options.transform.tile = s->block;
    options.transform.rho = 0.3;
    return options;
}

static int bake(const step *s, uint32_t *result)
{
    const cvol_render_options options = view(s);
    cvol_renderer *renderer;
    cvol_transfer *transfer = NULL;
    (void)result;
    int code = cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                    CVOL_SOURCE(.volume = &volume));
    if (code)
        return code;
    code = cvol_transfer_create(context, &transfer, support_blob_points, SUPPORT_BLOB_POINTS);
    if (!code)
        code = cvol_renderer_set_transfer(context, renderer, transfer);
    if (!code)
        code = cvol_renderer_bake(context, renderer, file_path, 1, "blobs", &options, NULL);
    cvol_transfer_free(transfer);
    cvol_renderer_free(renderer);
    return code;
}

static int draw_baked(const step *s, uint32_t *result)
{
    const cvol_render_options options = view(s);
    cvol_renderer *renderer;
    cvol_image *picture;
    int code = cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                    CVOL_SOURCE(.baked_path = in_path));
    if (code)
        return code;
    code = cvol_image_create(context, &picture, options.width, options.height);
    if (!code) {
        code = cvol_renderer_render(context, renderer, picture, &options);
        *result = cvol_crc32c(picture->rgba, 4 * (size_t)picture->width * (size_t)picture->height);
        cvol_image_free(picture);
    }
    cvol_renderer_free(renderer);
    return code;
}

/* ---- trying ----------------------------------------------------------------------------- */

/* What a step made. */
typedef struct outcome {
    uint32_t result, file; /* checksum of file_path; 0: there is none */
} outcome;

static uint32_t hash_file(void)
{
    size_t size;
    if (access(file_path, F_OK))
        return 0;
    unsigned char *bytes = support_read(file_path, &size);
    const uint32_t hash = cvol_crc32c(bytes, size);
    free(bytes);
    return hash;
}

/* Runs the step; the n-th allocation fails, or none if n is 0. If the step succeeds all the same,
 * *out must be `truth`, unless that is NULL. */
static void try(outcome *out, const step *s, long n, allocation_failure how, const outcome *truth)
{
    *out = (outcome){0, 0};
    (void)unlink(file_path);
    context->message[0] = 0;
    const size_t files = support_folder_count(folder);
    const long before = allocation_count();
    if (n)
        allocation_fail(n, how);
    const int code = s->go(s, &out->result);
    (void)allocation_stop();
    const long left = allocation_count() - before;
    const char *wrong = NULL;
    out->file = hash_file();
    if (!code)
        wrong = truth && memcmp(out, truth, sizeof *out) ? "another result" : NULL;
    else if (code != CVOL_ERROR_MEMORY || !strstr(context->message, "memory"))
        wrong = "another error";
    else if (support_folder_count(folder) != files)
        wrong = "left a file";
    if (left && truth)
        wrong = "memory that is not freed";
    if (wrong)
        fail_msg("%s, allocation %ld%s: %s: code %d, '%s', %ld pieces left", s->name, n,
                 how == ALLOCATION_ALL_FROM ? " and all later ones" : "", wrong, code,
                 context->message, left);
}

static void try_all(const step *s)
{
    outcome truth, out;
    const long *numbers;
    try(&truth, s, 0, ALLOCATION_ONE, NULL); /* also allocations that are made once a process */
    assert_true(truth.file || truth.result);
    allocation_record();
    try(&out, s, 0, ALLOCATION_ONE, &truth);
    const size_t count = allocation_recorded(&numbers);
    for (size_t i = 0; i < count; i++) {
        try(&out, s, numbers[i], ALLOCATION_ONE, &truth);
        if (i % (3 * SUPPORT_STRIDE) == 0)
            try(&out, s, numbers[i], ALLOCATION_ALL_FROM, &truth);
    }
    try(&out, s, 0, ALLOCATION_ONE, &truth);
    if (test_verbose())
        print_message("%s: %zu allocations\n", s->name, count);
}

/* Tries a step that writes a file, then some that read it. */
static void try_file(const step *s, const step *readers)
{
    make_volume(s);
    try_all(s);
    assert_int_equal(rename(file_path, in_path), 0);
    for (; readers->go; readers++) {
        step reader = *readers;
        char name[100];
        snprintf(name, sizeof name, "%s, %s", s->name, readers->name);
        reader.name = name;
        reader.type = s->type;
        reader.block = s->block;
        reader.options = s->options;
        try_all(&reader);
    }
}

/* ---- tests ------------------------------------------------------------------------------ */

#define BRICKS_OF_16 .brick = {16, 16, 16}

static const step volume_readers[] = {{.name = "read", .go = read_whole},
                                      {.name = "level", .go = read_level},
                                      {.name = "box", .go = read_box},
                                      {.name = "memory", .go = read_memory},
                                      {.name = "verify", .go = verify},
                                      {.name = NULL}},
                  terms_changed[] = {{.name = "bricks", .go = set_bricks},
                                     {.name = "transcode", .go = transcode},
                                     {.name = "measure", .go = measure},
                                     {.name = NULL}},
                  residual_changed[] = {{.name = "transcode", .go = transcode}, {.name = NULL}},
                  array_readers[] = {{.name = "read", .go = read_whole},
                                     {.name = "verify", .go = verify},
                                     {.name = NULL}},
                  series_readers[] = {{.name = "read", .go = read_channel},
                                      {.name = "verify", .go = verify},
                                      {.name = "extract", .go = extract},
                                      {.name = NULL}},
                  picture_readers[] = {{.name = "read", .go = read_picture},
                                       {.name = "verify", .go = verify},
                                       {.name = NULL}},
                  baked_readers[] = {{.name = "draw", .go = draw_baked},
                                     {.name = "verify", .go = verify},
                                     {.name = NULL}};

static void try_files(const step *steps, size_t count, const step *readers)
{
    if (!allocation_is_replaced())
        skip();
    for (size_t i = 0; i < count; i++)
        try_file(&steps[i], readers);
}

#define TRY_FILES(steps, readers) try_files(steps, sizeof(steps) / sizeof *(steps), readers)

static void volumes(void **state)
{
    static const step steps[] = {
        {"ratio", compress, CVOL_INT16, SMOOTH, {BRICKS_OF_16}, 0, 0},
        {"blocks of 8, not lapped",
         compress,
         CVOL_FLOAT32,
         SMOOTH,
         {.block = 8, .lapped = 1, .target = CVOL_TARGET_PSNR, .target_value = 40},
         0,
         0},
        {"blocks of 32", compress, CVOL_UINT8, SMOOTH, {.block = 32}, 0, 0},
        {"fast", compress, CVOL_UINT16, SMOOTH, {.effort = CVOL_EFFORT_FAST}, 0, 0},
        {"max", compress, CVOL_UINT8, SMOOTH, {.effort = CVOL_EFFORT_MAX}, 0, 0},
        {"background",
         compress,
         CVOL_FLOAT32,
         BACKGROUND,
         {.background = CVOL_BACKGROUND_FIND, BRICKS_OF_16},
         0,
         0},
        {"outliers",
         compress,
         CVOL_FLOAT32,
         OUTLIERS,
         {.target = CVOL_TARGET_PSNR, .target_value = 60},
         0,
         0},
    };
    (void)state;
    TRY_FILES(steps, volume_readers);
}

static void residuals(void **state)
{
    static const step steps[] = {
        {"largest error",
         compress,
         CVOL_FLOAT32,
         SMOOTH,
         {.target = CVOL_TARGET_MAX_ERROR, .target_value = 0.5, BRICKS_OF_16},
         0,
         0},
        {"PSNR and largest error",
         compress,
         CVOL_INT16,
         SMOOTH,
         {.target = CVOL_TARGET_PSNR, .target_value = 30, .max_error = 8},
         0,
         0},
        {"lossless uint8", compress, CVOL_UINT8, SMOOTH, {.lossless = 1, BRICKS_OF_16}, 0, 0},
        {"lossless float32", compress, CVOL_FLOAT32, SMOOTH, {.lossless = 1}, 0, 0},
        {"lossless float64", compress, CVOL_FLOAT64, BACKGROUND, {.lossless = 1}, 0, 0},
        {"labels", compress, CVOL_UINT32, LABELS, {.lossless = 1, BRICKS_OF_16}, 0, 0},
        {"lossless with a fill",
         compress,
         CVOL_INT16,
         HOLES,
         {.lossless = 1, .has_fill = 1, .fill = -5},
         0,
         0},
    };
    (void)state;
    TRY_FILES(steps, volume_readers);
}

static void changes(void **state)
{
    static const step steps[] = {
        {"ratio", compress, CVOL_INT16, SMOOTH, {BRICKS_OF_16}, 0, 0},
        {"fill", compress, CVOL_FLOAT32, HOLES, {.has_fill = 1, .fill = -5}, 0, 0},
        {"PSNR",
         compress,
         CVOL_INT16,
         SMOOTH,
         {.target = CVOL_TARGET_PSNR, .target_value = 40},
         0,
         0},
    };
    static const step exact = {
        "lossless", compress, CVOL_INT16, HOLES, {.lossless = 1, .has_fill = 1, .fill = -5}, 0, 0};
    (void)state;
    TRY_FILES(steps, terms_changed);
    try_file(&exact, residual_changed);
}

static void streams(void **state)
{
    static const step steps[] = {
        {"stream to a ratio", stream, CVOL_INT16, SMOOTH, {BRICKS_OF_16}, 0, 0},
        {"stream to a PSNR",
         stream,
         CVOL_FLOAT32,
         SMOOTH,
         {.target = CVOL_TARGET_PSNR, .target_value = 40},
         0,
         0},
        {"stream, fast", stream, CVOL_UINT8, SMOOTH, {.effort = CVOL_EFFORT_FAST}, 0, 0},
    };
    static const step series = {"series", write_series, CVOL_INT16, SMOOTH, {BRICKS_OF_16}, 0, 0};
    (void)state;
    TRY_FILES(steps, array_readers);
    try_file(&series, series_readers);
}

static void other_arrays(void **state)
{
    static const step steps[] = {
        {"whole, DCT", write_array, CVOL_FLOAT32, SMOOTH, {.transform = CVOL_DCT}, 0, 0},
        {"whole, DFT", write_array, CVOL_FLOAT32, SMOOTH, {.transform = CVOL_DFT}, 0, 0},
        {"whole, DHT", write_array, CVOL_INT16, SMOOTH, {.transform = CVOL_DHT}, 0, 0},
        {"blocks, DFT", write_array, CVOL_FLOAT32, SMOOTH, {.transform = CVOL_DFT}, 8, 0},
        {"blocks, DCT", write_array, CVOL_FLOAT32, SMOOTH, {.transform = CVOL_DCT}, 16, 0},
    };
    (void)state;
    TRY_FILES(steps, array_readers);
}

static void pictures(void **state)
{
    static const step steps[] = {
        {"picture in tiles", write_picture, CVOL_UINT8, SMOOTH, {.block = 0}, 16, 0},
        {"whole picture", write_picture, CVOL_UINT8, SMOOTH, {.block = 0}, 0, 8},
    };
    static const step baked[] = {
        {"baked in tiles", bake, CVOL_FLOAT32, SMOOTH, {.block = 0}, 8, 0},
        {"baked", bake, CVOL_FLOAT32, SMOOTH, {.block = 0}, 0, 0},
    };
    (void)state;
    TRY_FILES(steps, picture_readers);
    TRY_FILES(baked, baked_readers);
}

static int start(void **state)
{
    if (files_setup(state))
        return -1;
    cvol_context_set_threads(context, 1); /* OpenMP ends a process if it cannot start threads */
    in_path = support_path(folder, "in.cvol");
    if (cvol_image_create(context, &image, 40, 30))
        return -1;
    for (int i = 0; i < 4 * 40 * 30; i++)
        image->rgba[i] = (uint8_t)(i % 4 == 3 ? 255 - i / 60 : i / 40 + i % 7);
    return 0;
}

static int stop(void **state)
{
    cvol_image_free(image);
    free(volume.data);
    free(in_path);
    return files_teardown(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volumes), cmocka_unit_test(residuals),    cmocka_unit_test(changes),
        cmocka_unit_test(streams), cmocka_unit_test(other_arrays), cmocka_unit_test(pictures),
    };
    if (getenv("CVOL_TEST_ONLY"))
        cmocka_set_test_filter(getenv("CVOL_TEST_ONLY"));
    return cmocka_run_group_tests(tests, start, stop);
}
