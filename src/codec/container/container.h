/* Reads the .cvol container, version 1, which doc/format.md describes; writer.h writes it. */
#ifndef CVOL_CODEC_CONTAINER_CONTAINER_H
#define CVOL_CODEC_CONTAINER_CONTAINER_H

#include "array/core/array.h"
#include "codec/brick/bricks.h"
#include "codec/section/section.h"
#include "cvol/codec.h"

/* Does the work of cvol_array_read_part on a file, or the beginning of a file, in memory. `name`
 * begins the messages. part, report: may be NULL. */
int cvol_container_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                             const uint8_t *data, size_t size, const cvol_file_part *part,
                             const char *name);
/* Does the work of cvol_file_read_grid. */
int cvol_container_read_grid(cvol_context *context, cvol_grid *out, const uint8_t *data,
                             size_t size, const cvol_file_part *part, const char *name);
/* Reads a whole file. Errors: FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY, CANCELLED. */
int cvol_container_read(cvol_context *context, cvol_array **out, const uint8_t *data, size_t size,
                        const char *name);
/* Tests if cvol_container_read would succeed, in less memory: decodes terms without keeping them.
 * The same errors. */
int cvol_container_try(cvol_context *context, const uint8_t *data, size_t size, const char *name);

#endif
