/* Background work. */
#define _GNU_SOURCE
#include "viewer/base/priority.h"

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { NICE = 15 };
#endif

void lower_thread_priority(void)
{
#ifdef __linux__ /* each thread has its own niceness */
    setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), NICE);
#endif
}
