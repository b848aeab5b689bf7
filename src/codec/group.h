/* Groups: cubes of 128^3 samples whose blocks are coded together, and apart from all others.
 *
 * Groups are numbered x fastest, and so are the blocks in a group. A group at the volume's end has
 * fewer blocks. Groups are coded and decoded by as many threads as the context allows; the bytes
 * and the terms are the same for any number.
 */
#ifndef CVOL_CODEC_GROUP_H
#define CVOL_CODEC_GROUP_H

#include "array/array.h"
#include "base/bytes.h"
#include "codec/block_code.h"

/* The groups of an array, encoded; zeroed before the first use. */
typedef struct cvol_groups {
    size_t count;
    cvol_bytes *bytes; /* of each group */
} cvol_groups;

void cvol_groups_free(cvol_groups *groups);
/* The bytes of all groups together. */
uint64_t cvol_groups_size(const cvol_groups *groups);

/* The group grid of an array. */
size_t cvol_group_count(const cvol_array *array);
/* Whether a group has samples within the box [begin, end). */
int cvol_group_touches(const cvol_array *array, size_t group, const size_t begin[3],
                       const size_t end[3]);

/* Where a group's blocks come from: fetch() writes block `index` (of the array) in scan order as
 * cvol_block_encode wants it and returns `used`, or 0 when a value is out of range. `coder` is the
 * group's state before the block, `place` the block's number within the group. Called by several
 * threads. */
typedef struct cvol_block_source {
    int (*fetch)(const void *user, int32_t *values, cvol_block_coder *coder, size_t place,
                 size_t index);
    const void *user;
} cvol_block_source;

/* Encodes groups first, first + stride, ... of an array of this shape into groups->bytes (others
 * stay as they are). The progress callback hears `fraction` now and then. Errors: MEMORY,
 * CANCELLED, TARGET (a value out of range: no message). */
int cvol_groups_encode(cvol_context *context, cvol_groups *groups, const cvol_array *shape,
                       const cvol_block_source *source, size_t first, size_t stride,
                       double fraction);

/* Encodes the terms of an array. Errors: MEMORY, CANCELLED. */
int cvol_array_encode(cvol_context *context, cvol_groups *groups, const cvol_array *array);

/* One group's bytes. */
typedef struct cvol_span {
    const uint8_t *data;
    size_t size;
} cvol_span;

/* Decodes all groups into an array that has no terms yet; sets its coefficients. Groups whose data
 * is NULL are left without terms. If checksums is not NULL, each group's bytes must have it. `name`
 * begins the message. Errors: CORRUPT, MEMORY, CANCELLED. */
int cvol_array_decode(cvol_context *context, cvol_array *array, const cvol_span *groups,
                      const uint32_t *checksums, const char *name);

#endif
