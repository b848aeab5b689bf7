/* gzip and zlib streams inside files, inflated part by part. */
#ifndef CVOL_VOLUME_IO_INFLATE_H
#define CVOL_VOLUME_IO_INFLATE_H

#include "volume/io/input.h"

/* deflate packs at most 1032 bytes into one: a claim beyond this factor (and a small margin for
 * small streams) is false. */
#define CVOL_INFLATE_FACTOR 1100
#define CVOL_INFLATE_SLACK 1024

typedef struct cvol_inflater cvol_inflater;

/* A gzip file (of any number of members) or a zlib stream in the `stored` bytes at `offset`. The
 * input must outlive the inflater. */
int cvol_inflater_open(cvol_context *context, cvol_inflater **out, const cvol_input *input,
                       uint64_t offset, uint64_t stored);
void cvol_inflater_close(cvol_inflater *inflater);
/* The next `size` bytes; *got is less if the stream ends, complete or cut off. Damage is a FORMAT
 * error. data may be NULL: then the bytes are skipped. */
int cvol_inflater_read(cvol_context *context, cvol_inflater *inflater, void *data, uint64_t size,
                       uint64_t *got);
/* 1 once the stream has ended correctly, with a valid check sum. */
int cvol_inflater_ended(const cvol_inflater *inflater);

/* Inflates the first bytes of a gzip file, given its own first bytes, for recognising formats. */
size_t cvol_inflate_head(void *out, size_t size, const void *head, size_t head_size);

#endif
