/* The thread's index in a parallel region, the possible number of threads, and threads of processes
 * that fork. */
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

/* This number of threads, or the largest possible one. */
int cvol_threads_possible(int threads);

/* From here on a child of fork may use threads, even if its parent did. */
void cvol_threads_survive_fork(void);

#endif
