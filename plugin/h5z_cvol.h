/* The HDF5 filter's number and parameters (doc/hdf5.md). */
#ifndef CVOL_H5Z_CVOL_H
#define CVOL_H5Z_CVOL_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/codec.h"

/* A number for tests (256 to 511). The HDF Group has not assigned one yet: do not distribute files
 * before that. */
#define CVOL_H5Z_ID 444

/* The filter message of a dataset, in words of 32 bits. The user gives the first three, or fewer:
 * none: ratio 30; one: a mode without a value; two: a mode and a whole number. */
enum {
    CVOL_H5Z_MODE,   /* a cvol_target, or CVOL_H5Z_LOSSLESS */
    CVOL_H5Z_LOW,    /* lower half of the value, a double */
    CVOL_H5Z_HIGH,   /* its upper half */
    CVOL_H5Z_LAYOUT, /* CVOL_H5Z_LAYOUT_1: the plugin set the following words */
    CVOL_H5Z_TYPE,   /* a cvol_type */
    CVOL_H5Z_ORDER,  /* 0: low byte first, 1: high byte first */
    CVOL_H5Z_NX,     /* size of a chunk along its last axis */
    CVOL_H5Z_NY,     /* along the axis before, or 1 */
    CVOL_H5Z_NZ,     /* along the one before that, or 1 */
    CVOL_H5Z_WORDS
};
enum { CVOL_H5Z_LOSSLESS = 5, CVOL_H5Z_LAYOUT_1 = 1 };

/* Grid and options of a chunk, from its parameters. */
typedef struct cvol_h5z_plan {
    cvol_grid grid;
    size_t bytes;
    int swaps; /* 1: swap the bytes of samples */
    cvol_compress_options options;
} cvol_h5z_plan;

/* Reads the words of the user. 1, or 0 and a message. */
int cvol_h5z_read_options(cvol_compress_options *options, const unsigned *words, size_t count,
                          char *message, size_t message_bytes);
/* Reads all words. 1, or 0 and a message. */
int cvol_h5z_read_plan(cvol_h5z_plan *plan, const unsigned *words, size_t count, char *message,
                       size_t message_bytes);
/* Stores a value in its two words. */
void cvol_h5z_put_value(unsigned words[CVOL_H5Z_WORDS], double value);

/* Convert the samples of a chunk, in the byte order of the file, to the bytes of a .cvol file and
 * back. 1, and the caller frees *out with free(); or 0 and a message. Any thread may call them;
 * they use one thread and print nothing. */
int cvol_h5z_encode(void **out, size_t *size, const cvol_h5z_plan *plan, const void *samples,
                    char *message, size_t message_bytes);
/* Refuses data that do not match the plan before it allocates memory. */
int cvol_h5z_decode(void **out, const cvol_h5z_plan *plan, const void *data, size_t size,
                    char *message, size_t message_bytes);

#endif
