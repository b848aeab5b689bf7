/* The values of a node of OpenVDB: compressed, and without inactive ones that are equal. */
#ifndef CVOL_VOLUME_FORMATS_VDB_VALUES_H
#define CVOL_VOLUME_FORMATS_VDB_VALUES_H

#include "volume/formats/vdb/file.h"

/* The most values of a node. */
#define CVOL_VDB_MOST_VALUES 32768

/* The file and the grid that values belong to. */
typedef struct cvol_vdb_source {
    const uint8_t *data; /* the file */
    size_t size;
    const cvol_vdb_type *type;
    int is_half;
    uint32_t compression;
    uint8_t background[8]; /* a sample */
} cvol_vdb_source;

int cvol_vdb_is_set(const uint8_t *mask, size_t i);

/* Converts values of the file to samples; 0 or 1 of booleans. `half`: floats of 2 bytes. */
void cvol_vdb_to_samples(void *out, const uint8_t *values, size_t count, const cvol_vdb_type *type,
                         int half);

/* Moves the cursor behind `count` values of a node with this mask of active ones. */
void cvol_vdb_values_skip(cvol_cursor *cursor, const cvol_vdb_source *source, size_t count,
                          const uint8_t *active);
/* Reads them at `offset` as samples. `room` is scratch of CVOL_VDB_MOST_VALUES samples. Errors:
 * FORMAT, UNSUPPORTED. */
int cvol_vdb_values_read(cvol_context *context, void *out, void *room,
                         const cvol_vdb_source *source, size_t offset, size_t count,
                         const uint8_t *active, const char *name);

#endif
