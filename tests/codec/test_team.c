/* Compression by a team of processes, for which threads stand here: the file has the same bytes as
 * that of one process, and a failure of one ends all. */
#include "test.h"

#include <pthread.h>

#include "base/context.h"
#include "base/team.h"
#include "codec/rate/compress_stream.h"
#include "codec/rate/measure.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_samples.h"

enum { MOST = 7 };

/* ---- teams of threads -------------------------------------------------------------------- */

/* A place where the threads meet. */
typedef struct meeting {
    pthread_barrier_t barrier;
    int size, codes[MOST];
    const void *own[MOST];
    size_t bytes[MOST];
} meeting;

typedef struct member {
    meeting *at;
    int rank;
} member;

static int gather(cvol_context *own, void *user, int code, uint8_t **all, size_t *offsets,
                  const void *bytes, size_t count)
{
    member *m = user;
    meeting *at = m->at;
    at->codes[m->rank] = code;
    at->own[m->rank] = bytes;
    at->bytes[m->rank] = count;
    pthread_barrier_wait(&at->barrier);
    int first = CVOL_OK;
    for (int r = at->size - 1; r >= 0; r--)
        first = at->codes[r] ? at->codes[r] : first;
    *all = NULL;
    for (int r = 0; r < at->size && !first; r++)
        offsets[r + 1] = offsets[r] + at->bytes[r];
    if (!first)
        *all = malloc(offsets[at->size] + 1);
    for (int r = 0; r < at->size && !first; r++)
        if (at->bytes[r])
            memcpy(*all + offsets[r], at->own[r], at->bytes[r]);
    pthread_barrier_wait(&at->barrier);
    return !first || code == first ? first : cvol_fail(own, first, "another process failed");
}

/* ---- volumes ------------------------------------------------------------------------------ */

/* A volume, and one slice that cannot be read by one process. */
typedef struct given {
    const uint8_t *samples;
    size_t slice_bytes, row_bytes, fails_at;
    size_t read, most; /* bytes, of all calls and of one */
} given;

static int read_given(cvol_context *own, void *user, void *samples, size_t first, size_t slices)
{
    given *from = user;
    if (first <= from->fails_at && from->fails_at < first + slices)
        return cvol_fail(own, CVOL_ERROR_IO, "slice %zu cannot be read", from->fails_at);
    memcpy(samples, from->samples + first * from->slice_bytes, slices * from->slice_bytes);
    from->read += slices * from->slice_bytes;
    return CVOL_OK;
}

static int read_given_rows(cvol_context *own, void *user, void *samples, size_t first,
                           size_t slices, size_t first_row, size_t rows)
{
    given *from = user;
    const size_t bytes = rows * from->row_bytes;
    if (first <= from->fails_at && from->fails_at < first + slices)
        return cvol_fail(own, CVOL_ERROR_IO, "slice %zu cannot be read", from->fails_at);
    for (size_t i = 0; i < slices; i++)
        memcpy((uint8_t *)samples + i * bytes,
               from->samples + (first + i) * from->slice_bytes + first_row * from->row_bytes,
               bytes);
    from->read += slices * bytes;
    from->most = slices * bytes > from->most ? slices * bytes : from->most;
    return CVOL_OK;
}

static given give(const void *samples, const cvol_grid *grid)
{
    const size_t row = grid->dims[0] * cvol_type_size(grid->type);
    return (given){samples, row * grid->dims[1], row, SIZE_MAX, 0, 0};
}

static void *make_volume(const cvol_grid *grid, random_state *random)
{
    void *samples = calloc(cvol_grid_samples(grid), cvol_type_size(grid->type));
    const double wide = 0.05 + 0.2 * fabs(random_signed(random)), noise = 0.05;
    size_t i = 0;
    for (size_t z = 0; z < grid->dims[2]; z++)
        for (size_t y = 0; y < grid->dims[1]; y++)
            for (size_t x = 0; x < grid->dims[0]; x++, i++)
                support_store(samples, grid->type, i,
                              0.9 * sin(wide * (double)x) *
                                      cos(0.11 * (double)y + 0.05 * (double)z) +
                                  noise * random_signed(random));
    return samples;
}

/* ---- compression --------------------------------------------------------------------------- */

typedef struct task {
    member member;
    given from;
    const cvol_grid *grid;
    const cvol_compress_options *options;
    const char *path;
    size_t estimated, strip_bytes;
    int by_rows; /* the source reads rows */
    int code;
    cvol_compress_report report;
} task;

static void *run(void *user)
{
    task *t = user;
    cvol_context *own = cvol_context_create();
    const cvol_sample_source source = {read_given, &t->from, t->by_rows ? read_given_rows : NULL};
    cvol_team team = {
        .rank = t->member.rank, .size = t->member.at->size, .gather = gather, .user = &t->member};
    cvol_context_set_threads(own, 1 + t->member.rank % 2);
    const cvol_stream_work work = {.estimated = t->estimated,
                                   .strip_bytes = t->strip_bytes,
                                   .team = t->member.at->size > 1 ? &team : NULL};
    t->code = cvol_compress_stream_by(own, &t->report, t->path, &source, t->grid, t->options,
                                      &work);
    cvol_context_free(own);
    return NULL;
}

/* Runs a team. fails_by: the process that cannot read slice fails_at, or -1. */
static void run_team(task tasks[MOST], int size, const task *like, int fails_by, size_t fails_at)
{
    meeting at = {.size = size};
    pthread_t threads[MOST];
    pthread_barrier_init(&at.barrier, NULL, (unsigned)size);
    for (int r = 0; r < size; r++) {
        tasks[r] = *like;
        tasks[r].member = (member){&at, r};
        tasks[r].from.fails_at = r == fails_by ? fails_at : SIZE_MAX;
        assert_int_equal(pthread_create(&threads[r], NULL, run, &tasks[r]), 0);
    }
    for (int r = 0; r < size; r++)
        pthread_join(threads[r], NULL);
    pthread_barrier_destroy(&at.barrier);
}

static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_FLOAT32};

static cvol_compress_options options_of(random_state *random)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lapped = random_below(random, 3) > 0;
    options.effort = random_below(random, 3) ? CVOL_EFFORT_DEFAULT : CVOL_EFFORT_FAST;
    options.no_histogram = random_below(random, 4) == 0;
    if (random_below(random, 2)) {
        options.target = CVOL_TARGET_PSNR;
        options.target_value = 35 + random_below(random, 20);
    }
    for (int a = 0; a < 3; a++)
        options.brick[a] = 16 << random_below(random, 2);
    return options;
}

/* The bytes of a strip: of one row of bricks, a few, or all. */
static size_t strips_of(random_state *random, const cvol_grid *grid)
{
    static const size_t rows[] = {1, 36, 52, 0};
    return rows[random_below(random, 4)] * grid->dims[0] * cvol_type_size(grid->type) * 68;
}

/* The figures in the file's header are those of its decoded samples. */
static void check_measured(const char *path, const void *samples)
{
    cvol_array *array;
    cvol_distance distance;
    cvol_context *own = cvol_context_create();
    assert_int_equal(cvol_array_read(own, &array, path, NULL), CVOL_OK);
    assert_int_equal(cvol_measure_distance(own, &distance, array, samples), CVOL_OK);
    const double psnr = array->psnr_db, most = array->max_error;
    cvol_array_set_measured(array, &distance);
    assert_true(fabs(array->psnr_db - psnr) <= 1e-9 * psnr);
    assert_true(fabs(array->max_error - most) <= 1e-9 * most);
    cvol_array_free(array);
    cvol_context_free(own);
}

static void test_same_bytes(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *one = support_path(folder, "one.cvol"),
         *many = support_path(folder, "many.cvol");
    const uint64_t seed = 34;
    random_state random = {seed};
    for (int round = 0; round < 16; round = support_next(round)) {
        cvol_grid grid = cvol_grid_make(
            20 + random_below(&random, 40), 20 + random_below(&random, 30),
            40 + random_below(&random, 130), types[random_below(&random, 3)]);
        const cvol_compress_options options = options_of(&random);
        void *samples = make_volume(&grid, &random);
        task alone[MOST], tasks[MOST];
        task like = {.from = give(samples, &grid),
                     .grid = &grid,
                     .options = &options,
                     .estimated = random_below(&random, 2) ? 0 : 2, /* 2: by estimates */
                     .strip_bytes = strips_of(&random, &grid),
                     .path = one};
        run_team(alone, 1, &like, -1, 0);
        assert_int_equal(alone[0].code, CVOL_OK);
        check_measured(one, samples);
        like.path = many;
        like.by_rows = random_below(&random, 2) > 0;
        const int size = 2 + (int)random_below(&random, MOST - 1);
        run_team(tasks, size, &like, -1, 0);
        size_t bytes[2];
        unsigned char *first = support_read(one, &bytes[0]), *second;
        for (int r = 0; r < size; r++) {
            assert_int_equal(tasks[r].code, CVOL_OK);
            assert_memory_equal(&tasks[r].report, &alone[0].report, sizeof tasks[r].report);
        }
        second = support_read(many, &bytes[1]);
        if (bytes[0] != bytes[1] || memcmp(first, second, bytes[0]) != 0)
            fail_msg("seed %llu, round %d: %d processes write another file",
                     (unsigned long long)seed, round, size);
        free(first);
        free(second);
        free(samples);
        remove(many);
    }
    free(one);
    free(many);
    support_folder_remove(folder);
}

/* Five processes read less than half of what one reads. */
static void check_shares(task tasks[MOST], const cvol_grid *grid, size_t strip_bytes, int by_rows)
{
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    random_state random = {5};
    const cvol_compress_options options = cvol_compress_options_defaults();
    void *samples = make_volume(grid, &random);
    task alone[MOST];
    const task like = {.from = give(samples, grid),
                       .grid = grid,
                       .options = &options,
                       .strip_bytes = strip_bytes,
                       .by_rows = by_rows,
                       .path = path};
    run_team(alone, 1, &like, -1, 0);
    run_team(tasks, 5, &like, -1, 0);
    for (int r = 0; r < 5; r++) {
        assert_int_equal(tasks[r].code, CVOL_OK);
        if (test_verbose())
            printf("process %d of 5: %zu bytes, alone %zu\n", r, tasks[r].from.read,
                   alone[0].from.read);
        assert_true(2 * tasks[r].from.read < alone[0].from.read);
    }
    free(samples);
    free(path);
    support_folder_remove(folder);
}

/* Layers are divided. */
static void test_shares(void **state)
{
    (void)state;
    task tasks[MOST];
    const cvol_grid grid = cvol_grid_make(20, 20, 640, CVOL_FLOAT32);
    check_shares(tasks, &grid, 0, 0);
}

/* With rows, a process never reads more than a strip and its margins at a time: strips of a flat
 * volume, of one layer, are divided as layers are. */
static void test_strips(void **state)
{
    (void)state;
    task tasks[MOST];
    const cvol_grid grid = cvol_grid_make(20, 640, 20, CVOL_FLOAT32);
    check_shares(tasks, &grid, 1, 1);
    for (int r = 0; r < 5; r++)
        assert_true(tasks[r].from.most <= (64 + 4) * 20 * tasks[r].from.row_bytes);
}

/* One process cannot read a slice: all end, and the old file stays. */
static void test_failure(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    random_state random = {7};
    cvol_grid grid = cvol_grid_make(24, 24, 300, CVOL_INT16);
    const cvol_compress_options options = cvol_compress_options_defaults();
    void *samples = make_volume(&grid, &random);
    const task like = {
        .from = give(samples, &grid), .grid = &grid, .options = &options, .path = path};
    for (int k = 0; k < 8; k++) {
        task tasks[MOST];
        support_write_text(path, "old");
        run_team(tasks, 3, &like, k % 3, random_below(&random, 300));
        size_t bytes;
        unsigned char *left = support_read(path, &bytes);
        const int failed = tasks[0].code != CVOL_OK; /* the slice may be another process's */
        for (int r = 0; r < 3; r++)
            assert_int_equal(tasks[r].code, failed ? CVOL_ERROR_IO : CVOL_OK);
        assert_true(failed ? bytes == 3 && !memcmp(left, "old", 3) : bytes > 3);
        assert_int_equal(support_folder_count(folder), 1);
        free(left);
    }
    free(samples);
    free(path);
    support_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_bytes),
                                       cmocka_unit_test(test_shares), cmocka_unit_test(test_strips),
                                       cmocka_unit_test(test_failure)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
