/* Jobs of a backend of fft.c: fft_own.c or fft_fftw.c; a build has one. */
#ifndef CVOL_TRANSFORM_FFT_BACKEND_H
#define CVOL_TRANSFORM_FFT_BACKEND_H

#include <stddef.h>

#include "cvol/base.h"

/* n elements, with these distances in the input and in the output. */
typedef struct cvol_fft_axis {
    size_t n, in_stride, out_stride;
} cvol_fft_axis;

/* A transform along `rank` axes, fastest first, of each of `lines.n` arrays. Compared as bytes:
 * set to zero before it is filled. Nothing is empty, and rank is at least 1. */
typedef struct cvol_fft_job {
    cvol_fft_axis axes[3], lines;
    int rank, kind;
} cvol_fft_job;

int cvol_fft_execute(cvol_context *context, const cvol_fft_job *job, float *out, float *in);

/* "own" or "fftw". */
const char *cvol_fft_backend_name(void);

#endif
