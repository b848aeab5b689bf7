/* Threads and fork.
 *
 * libgomp keeps a thread's workers for its next parallel region. A child of fork has that thread
 * without its workers, and waits for them for ever. So they are ended before a fork; parent and
 * child start others when they need some. Clang's runtime sees to that itself.
 */
#include "base/thread.h"

#include <pthread.h>

#if defined(_OPENMP) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 9
#define ENDS_WORKERS 1

static void end_workers(void)
{
    /* Fails within a parallel region, where regions have one thread anyway. */
    (void)omp_pause_resource_all(omp_pause_hard);
}

static void register_all(void)
{
    (void)pthread_atfork(end_workers, NULL, NULL);
}
#else
#define ENDS_WORKERS 0
#endif

void cvol_threads_survive_fork(void)
{
#if ENDS_WORKERS
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, register_all);
#endif
}
