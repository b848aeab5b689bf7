/* The possible number of threads; threads and fork.
 *
 * libgomp ends the process if it cannot start a thread. So the library limits the number of threads
 * to what the address space (ulimit -v) allows for stacks, and to a number that no machine exceeds.
 *
 * libgomp keeps a thread's workers for its next parallel region. A child of fork has that thread
 * without its workers, and would wait for them forever. So the library ends them before a fork;
 * parent and child start new ones when they need them. Clang's runtime does this itself.
 */
#define _GNU_SOURCE
#include "base/thread.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

enum { THREADS_MAX = 256, THREADS_PER_CORE = 4 };
/* Memory of the work itself, without stacks. */
static const size_t spare_bytes = (size_t)32 << 20;

/* The system's default stack; OMP_STACKSIZE may set less. */
static size_t stack_bytes(void)
{
    pthread_attr_t attributes;
    size_t bytes = 0;
    if (pthread_attr_init(&attributes) || pthread_attr_getstacksize(&attributes, &bytes) || !bytes)
        bytes = (size_t)8 << 20;
    return bytes;
}

static int has_room(size_t bytes)
{
    void *memory = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory != MAP_FAILED && !munmap(memory, bytes);
}

int cvol_threads_possible(int threads)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const int most = cores > THREADS_MAX / THREADS_PER_CORE ? (int)cores * THREADS_PER_CORE
                                                            : THREADS_MAX;
    struct rlimit limit;
    if (threads > most)
        threads = most;
    if (!getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur != RLIM_INFINITY) {
        const size_t stack = stack_bytes();
        while (threads > 1 && !has_room(spare_bytes + (size_t)(threads - 1) * stack))
            threads--;
    }
    return threads;
}

#if defined(_OPENMP) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 9
#define ENDS_WORKERS 1

static void end_workers(void)
{
    /* Fails within a parallel region, where nested regions have one thread anyway. */
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

#if defined(_OPENMP) && defined(__has_feature)
#if __has_feature(thread_sanitizer)
/* Under a sanitizer, libomp (14 to 19) reads the record of the thread that used it first, even if
 * that thread has ended. So the main thread, which stays, uses it first. */
__attribute__((constructor)) static void begin_with_main_thread(void)
{
    (void)omp_get_max_threads();
}
#endif
#endif
