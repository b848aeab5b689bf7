/* Processes that fork after they have used threads: children read, decode and draw like their
 * parent, and so do theirs; and the parent continues.
 */
#include "test.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support.h"
#include "support_context.h"
#include "support_files.h"
#include "support_tour.h"

enum { SECONDS = 60 };

static tour t;

/* The first error of these steps, 0 if there is none. */
static int go(const tour_step *steps)
{
    int code = 0;
    for (; steps->name && !code; steps++)
        code = steps->go(&t);
    return code;
}

static int go_on(void)
{
    const int code = go(tour_reading);
    return code ? code : tour_pictures[0].go(&t);
}

/* The exit code of a child that does this and has `children` generations below it. */
static int in_child(int children)
{
    const pid_t child = fork();
    if (!child) {
        signal(SIGALRM, SIG_DFL);
        alarm(SECONDS); /* a signal ends a child that hangs */
        const int code = go_on();
        _exit(code ? 1 : children ? in_child(children - 1) : 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static void children_use_threads(void **state)
{
    (void)state;
    assert_int_equal(go_on(), CVOL_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(in_child(1), 0);
        assert_int_equal(go_on(), CVOL_OK);
    }
}

/* A process that forks within its progress callback, between two parallel regions of a call. */
static int fork_once(void *user, const char *what, double fraction)
{
    int *result = user;
    (void)what;
    (void)fraction;
    if (*result >= 0)
        return 0;
    cvol_context *own = cvol_context_create(), *before = t.context;
    cvol_context_set_threads(own, 4);
    t.context = own;
    *result = 0;
    *result = in_child(0);
    t.context = before;
    cvol_context_free(own);
    return 0;
}

static void children_of_callbacks_use_threads(void **state)
{
    (void)state;
    int result = -1;
    cvol_context_set_progress(context, fork_once, &result);
    const int code = tour_reading[0].go(&t);
    cvol_context_set_progress(context, NULL, NULL);
    assert_int_equal(code, CVOL_OK);
    assert_int_equal(result, 0);
}

static int start(void **state)
{
    if (files_setup(state))
        return -1;
    cvol_context_set_threads(context, 4);
    return !tour_begin(&t, context, file_path) || tour_write(&t, 1);
}

static int stop(void **state)
{
    free(t.volume.data);
    return files_teardown(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(children_use_threads),
        cmocka_unit_test(children_of_callbacks_use_threads),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
