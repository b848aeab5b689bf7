/* Which thread of a parallel region this is; how many there may be; and threads of processes that
 * fork. */
#ifndef CVOL_BASE_THREAD_H
#define CVOL_BASE_THREAD_H

#ifdef _OPENMP
#include <omp.h>
#endif

/* 0 without OpenMP. */
static inline int cvol_thread_index(void)
{
#ifdef _OPENMP
    return omp_get_thread_num();
#else
    return 0;
#endif
}

/* So many threads, or as many as there may be. */
int cvol_threads_possible(int threads);

/* From here on a child of fork may use threads, whatever its parent used. */
void cvol_threads_survive_fork(void);

#endif
