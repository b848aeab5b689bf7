/* A tour of the library's functions, in small steps: compressing, reading, decoding, operations,
 * pictures. For tests of its environment: small stacks, processes that fork, lack of memory. */
#ifndef CVOL_TESTS_SUPPORT_TOUR_H
#define CVOL_TESTS_SUPPORT_TOUR_H

#include "cvol/cvol.h"

typedef struct tour {
    cvol_context *context;
    cvol_volume volume; /* float32, smooth */
    const char *path;   /* where files may be written */
} tour;

typedef struct tour_step {
    const char *name;
    int (*go)(tour *t); /* the first error; its objects are freed in any case */
} tour_step;

extern const tour_step tour_compressing[], tour_reading[], tour_operations[], tour_pictures[];
/* Ends with a step without a name. */
extern const tour_step *const tour_all[4];

/* A volume of one of the library's own formats, written to t->path, which tour_reading reads and
 * draws. */
int tour_write(tour *t, int lossless);
/* Makes t->volume; the caller frees its data. 0: not enough memory. */
int tour_begin(tour *t, cvol_context *context, const char *path);

#endif
