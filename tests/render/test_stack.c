/* Threads with small stacks: the whole library runs in threads of 128 kB, the stack that musl gives
 * a thread: the caller's own and those of OpenMP (tests/CMakeLists.txt sets OMP_STACKSIZE). Each
 * step is a separate process and thread. CVOL_TEST_STACK_KB: another size. */
#include "test.h"

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support.h"
#include "support_tour.h"

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1 /* frames are several times as large */
#else
#define SANITIZED 0
#endif

static char *folder, *path;

typedef struct job {
    const tour_step *step;
    int code;
} job;

static void *run(void *user)
{
    job *j = user;
    cvol_context *context = cvol_context_create();
    tour t;
    cvol_context_set_threads(context, 2);
    if (tour_begin(&t, context, path))
        j->code = j->step->go(&t);
    if (j->code)
        fprintf(stderr, "%s: %s\n", j->step->name, cvol_context_message(context));
    free(t.volume.data);
    cvol_context_free(context);
    return NULL;
}

static int stack_kb(void)
{
    const char *text = getenv("CVOL_TEST_STACK_KB");
    return text ? atoi(text) : 128;
}

/* The step's exit status, or 128 + the signal that ended it. */
static int run_in_thread(const tour_step *step)
{
    fflush(NULL);
    const pid_t child = fork();
    if (!child) {
        pthread_attr_t attributes;
        pthread_t thread;
        job j = {step, CVOL_ERROR_MEMORY};
        const struct rlimit none = {0, 0};
        setrlimit(RLIMIT_CORE, &none);
        signal(SIGSEGV, SIG_DFL);
        signal(SIGBUS, SIG_DFL);
        pthread_attr_init(&attributes);
        if (pthread_attr_setstacksize(&attributes, (size_t)stack_kb() << 10) ||
            pthread_create(&thread, &attributes, run, &j) || pthread_join(thread, NULL))
            _exit(99);
        _exit(j.code ? 1 : 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static void run_all(const tour_step *steps)
{
    int failed = 0;
    if (SANITIZED)
        skip();
    for (; steps->name; steps++) {
        const int status = run_in_thread(steps);
        if (status)
            print_error("%s: status %d with a stack of %d kB\n", steps->name, status, stack_kb());
        failed |= status;
    }
    assert_int_equal(failed, 0);
}

static void compressing(void **state)
{
    (void)state;
    run_all(tour_compressing);
}

static int write_sample(tour *t)
{
    return tour_write(t, 1);
}

/* A process that has used OpenMP should not fork: another one writes the file that it reads. */
static void write_file(void)
{
    const tour_step step = {"the file that is read", write_sample};
    assert_int_equal(run_in_thread(&step), 0);
}

static void reading(void **state)
{
    (void)state;
    if (!SANITIZED)
        write_file();
    run_all(tour_reading);
}

static void operations(void **state)
{
    (void)state;
    run_all(tour_operations);
}

static void pictures(void **state)
{
    (void)state;
    if (!SANITIZED)
        write_file();
    run_all(tour_pictures);
}

static int start(void **state)
{
    (void)state;
    folder = support_folder_make();
    path = support_path(folder, "a.cvol");
    return 0;
}

static int stop(void **state)
{
    (void)state;
    free(path);
    support_folder_remove(folder);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compressing),
        cmocka_unit_test(reading),
        cmocka_unit_test(operations),
        cmocka_unit_test(pictures),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
