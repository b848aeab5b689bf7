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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_messages)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
