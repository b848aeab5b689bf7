/* Which thread of a parallel region this is; 0 without OpenMP. */
#ifndef CVOL_BASE_THREAD_H
#define CVOL_BASE_THREAD_H

#ifdef _OPENMP
#include <omp.h>
#endif

static inline int cvol_thread_index(void)
{
#ifdef _OPENMP
    return omp_get_thread_num();
#else
    return 0;
#endif
}

#endif
