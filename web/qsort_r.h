/* qsort_r, which the C library of older emscriptens lacks; CMakeLists.txt then includes this before
 * series.c of DICOM. */
#ifndef CVOL_WEB_QSORT_R_H
#define CVOL_WEB_QSORT_R_H

#include <stddef.h>

void qsort_r(void *base, size_t count, size_t size,
             int (*compare)(const void *a, const void *b, void *user), void *user);

#endif
