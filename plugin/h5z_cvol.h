/* The HDF5 filter's number and parameters (doc/hdf5.md). */
#ifndef CVOL_H5Z_CVOL_H
#define CVOL_H5Z_CVOL_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/codec.h"

/* Of those that are free for anyone to try with (256 to 511): The HDF Group has not been asked for
 * one yet, and files that are given away should wait for that. */
#define CVOL_H5Z_ID 444

/* What a dataset's filter message holds, words of 32 bits. The first three are the user's, who may
 * leave some away: none, ratio 30; one, a mode without a value; two, a mode and a whole number. */
enum {
    CVOL_H5Z_MODE,   /* of cvol_target, or CVOL_H5Z_LOSSLESS */
    CVOL_H5Z_LOW,    /* the value, a double: its lower half, */
    CVOL_H5Z_HIGH,   /* and its upper */
    CVOL_H5Z_LAYOUT, /* CVOL_H5Z_LAYOUT_1: what follows was filled in as here */
    CVOL_H5Z_TYPE,   /* of cvol_type */
    CVOL_H5Z_ORDER,  /* 0: samples lie low byte first, 1: high byte first */
    CVOL_H5Z_NX,     /* places of a chunk: its last axis, */
    CVOL_H5Z_NY,     /* the one before it, or 1, */
    CVOL_H5Z_NZ,     /* and so on */
    CVOL_H5Z_WORDS
};
enum { CVOL_H5Z_LOSSLESS = 5, CVOL_H5Z_LAYOUT_1 = 1 };

/* A chunk as its parameters say it. */
typedef struct cvol_h5z_plan {
    cvol_grid grid;
    size_t bytes;
    int swaps; /* samples lie in the other order of bytes than the machine's */
    cvol_compress_options options;
} cvol_h5z_plan;

/* What the user's words ask for. 1, or 0 and one sentence. */
int cvol_h5z_read_options(cvol_compress_options *options, const unsigned *words, size_t count,
                          char *message, size_t room);
/* All words. 1, or 0 and one sentence. */
int cvol_h5z_read_plan(cvol_h5z_plan *plan, const unsigned *words, size_t count, char *message,
                       size_t room);
/* The words of a value. */
void cvol_h5z_put_value(unsigned words[CVOL_H5Z_WORDS], double value);

/* A chunk's samples, as they lie in a file, to the bytes of a .cvol file and back: 1, and *out is
 * freed with free(); or 0 and one sentence. They may be called by any thread, have one thread each,
 * and print nothing. */
int cvol_h5z_encode(void **out, size_t *size, const cvol_h5z_plan *plan, const void *samples,
                    char *message, size_t room);
/* What is not the plan's chunk is refused before there is memory for it. */
int cvol_h5z_decode(void **out, const cvol_h5z_plan *plan, const void *data, size_t size,
                    char *message, size_t room);

#endif
