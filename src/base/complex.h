/* Complex numbers from their parts. */
#ifndef CVOL_BASE_COMPLEX_H
#define CVOL_BASE_COMPLEX_H

#include <complex.h>

/* re + i im, also for infinite parts: C11's CMPLX, which some compilers lack. */
static inline double complex cvol_complex(double re, double im)
{
    const union {
        double parts[2];
        double complex whole;
    } number = {{re, im}};
    return number.whole;
}

#endif
