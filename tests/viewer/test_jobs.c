/* The queue of the viewer's jobs. */
#include "test.h"

#include <pthread.h>

#include "viewer/service/jobs.h"

/* One job and its answer. */
typedef struct asked {
    jobs *all;
    answer (*run)(cvol_context *context, const job *j);
    int begun, released; /* run waits for `released` */
    answer answer;       /* status 0: not yet */
} asked;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;

static void set(int *value)
{
    pthread_mutex_lock(&lock);
    *value = 1;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

static void wait_for(const int *value)
{
    pthread_mutex_lock(&lock);
    while (!*value)
        pthread_cond_wait(&changed, &lock);
    pthread_mutex_unlock(&lock);
}

static answer run(job *j, cvol_context *context, void *state)
{
    asked *a = state;
    set(&a->begun);
    wait_for(&a->released);
    return a->run(context, j);
}

static void free_nothing(void *state)
{
    (void)state;
}

static void done(void *user, answer given)
{
    asked *a = user;
    pthread_mutex_lock(&lock);
    a->answer = given;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

static void add(asked *a, const char *viewer, int large)
{
    job j = {.sequence = -1,
             .large = large,
             .run = run,
             .state = a,
             .free_state = free_nothing,
             .done = done,
             .user = a};
    snprintf(j.viewer, sizeof j.viewer, "%s", viewer);
    jobs_add(a->all, &j);
}

/* Waits for the answer; checks its status and that its text has `part`. */
static void check_answer(asked *a, int status, const char *part)
{
    wait_for(&a->answer.status);
    assert_int_equal(a->answer.status, status);
    if (!strstr(a->answer.bytes, part))
        fail_msg("'%s' lacks '%s'", (const char *)a->answer.bytes, part);
    answer_free(&a->answer);
}

/* ---- messages -------------------------------------------------------------------------------- */

static answer read_nothing(cvol_context *context, const job *j)
{
    cvol_volume *v;
    return jobs_failed(j, context, cvol_volume_read(context, &v, "missing.nrrd", NULL));
}

static answer lack_memory(cvol_context *context, const job *j)
{
    return jobs_failed(j, context, CVOL_ERROR_MEMORY);
}

static answer ignore_and_lack_memory(cvol_context *context, const job *j)
{
    cvol_volume *v;
    (void)cvol_volume_read(context, &v, "missing.nrrd", NULL);
    return jobs_failed(j, context, CVOL_ERROR_MEMORY);
}

/* One thread does all large jobs. A job without a message does not report that of another one. */
static void test_messages(void **state)
{
    (void)state;
    jobs *all = jobs_open(1);
    asked failing = {.all = all, .run = read_nothing, .released = 1},
          second = {.all = all, .run = lack_memory, .released = 1},
          third = {.all = all, .run = ignore_and_lack_memory, .released = 1};
    assert_non_null(all);
    add(&failing, "", 1);
    check_answer(&failing, 500, "missing.nrrd");
    add(&second, "", 1);
    check_answer(&second, 500, "\"not enough memory\"");
    add(&third, "", 1);
    check_answer(&third, 500, "\"not enough memory\"");
    jobs_free(all);
}

/* ---- limits ---------------------------------------------------------------------------------- */

enum { THREADS = 2 }; /* for small jobs */

static answer succeed(cvol_context *context, const job *j)
{
    (void)context;
    return j->cancelled ? answer_error(409, "cancelled")
                        : answer_json(200, json_pack("{s:b}", "done", 1));
}

static asked *make(jobs *all, size_t count)
{
    asked *list = calloc(count, sizeof *list);
    assert_non_null(all);
    assert_non_null(list);
    for (size_t i = 0; i < count; i++)
        list[i] = (asked){.all = all, .run = succeed};
    return list;
}

static void finish(asked *list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        set(&list[i].released);
    for (size_t i = 0; i < count; i++)
        check_answer(&list[i], 200, "done");
}

/* Viewers whose job waits keep their place, whenever their last request was. */
static void test_too_many_viewers(void **state)
{
    (void)state;
    jobs *all = jobs_open(THREADS);
    asked *list = make(all, THREADS + VIEWERS_MAX), refused = {.all = all, .run = succeed};
    char name[16];
    jobs_set_forget_ms(all, -1);
    for (int i = 0; i < THREADS; i++) {
        add(&list[i], "", 0);
        wait_for(&list[i].begun);
    }
    for (int i = 0; i < VIEWERS_MAX; i++) {
        snprintf(name, sizeof name, "v%d", i);
        add(&list[THREADS + i], name, 0);
    }
    add(&refused, "another", 0);
    check_answer(&refused, 429, "viewers");
    finish(list, THREADS + VIEWERS_MAX);
    asked last = {.all = all, .run = succeed, .released = 1};
    add(&last, "another", 0); /* replaces an idle one */
    check_answer(&last, 200, "done");
    jobs_free(all);
    free(list);
}

/* A request that is refused cancels nothing; one that replaces a waiting one is not refused. */
static void test_too_many_jobs(void **state)
{
    (void)state;
    jobs *all = jobs_open(THREADS);
    asked *list = make(all, THREADS + WAITING_MAX), refused = {.all = all, .run = succeed};
    asked newer = refused;
    for (int i = 0; i < THREADS; i++) {
        add(&list[i], i ? "" : "drawing", 0);
        wait_for(&list[i].begun);
    }
    add(&list[THREADS], "waiting", 0);
    for (int i = 1; i < WAITING_MAX; i++)
        add(&list[THREADS + i], "", 0);
    add(&refused, "drawing", 0);
    check_answer(&refused, 429, "requests are waiting");
    add(&newer, "waiting", 0);
    check_answer(&list[THREADS], 409, "replaced");
    list[THREADS].answer.status = 0;
    set(&newer.released);
    finish(list, THREADS);
    check_answer(&newer, 200, "done");
    finish(list + THREADS + 1, WAITING_MAX - 1);
    jobs_free(all);
    free(list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_messages),
                                       cmocka_unit_test(test_too_many_viewers),
                                       cmocka_unit_test(test_too_many_jobs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
