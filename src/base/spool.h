/* Bytes that are written now and copied into an output later: in memory, or, from some size on, in
 * a file without a name. */
#ifndef CVOL_BASE_SPOOL_H
#define CVOL_BASE_SPOOL_H

#include "base/bytes.h"
#include "base/file.h"

typedef struct cvol_spool {
    cvol_bytes held; /* in memory: the last bytes */
    int has_file, fd;
    uint64_t filed; /* bytes in the file */
} cvol_spool;

static inline uint64_t cvol_spool_size(const cvol_spool *spool)
{
    return spool->filed + spool->held.size;
}

/* Errors: MEMORY. */
int cvol_spool_append(cvol_context *context, cvol_spool *spool, const void *data, size_t size);
/* Moves the bytes in memory to a file in the output's folder. Errors: IO, MEMORY. */
int cvol_spool_spill(cvol_context *context, cvol_spool *spool, const cvol_output *output);
/* Writes all bytes to the output. Errors: IO, MEMORY. */
int cvol_spool_copy(cvol_context *context, const cvol_spool *spool, cvol_output *output);
void cvol_spool_free(cvol_spool *spool);

#endif
