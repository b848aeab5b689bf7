/* The .cvol container, version 1: doc/format.md is its description. Reading; for writing see
 * writer.h. */
#ifndef CVOL_CODEC_CONTAINER_CONTAINER_H
#define CVOL_CODEC_CONTAINER_CONTAINER_H

#include "array/core/array.h"
#include "codec/brick/bricks.h"
#include "codec/section/section.h"
#include "cvol/codec.h"

/* Reads a file, or what is there of it, from memory: what cvol_array_read_part does. `name` begins
 * the messages. part, report: may be NULL. */
int cvol_container_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                             const uint8_t *data, size_t size, const cvol_file_part *part,
                             const char *name);
/* What cvol_file_grid does. */
int cvol_container_read_grid(cvol_context *context, cvol_grid *out, const uint8_t *data,
                             size_t size, const cvol_file_part *part, const char *name);
/* All of it. Errors: FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY, CANCELLED. */
int cvol_container_read(cvol_context *context, cvol_array **out, const uint8_t *data, size_t size,
                        const char *name);
/* Whether that would succeed, in less memory: terms are decoded, and not kept. The same errors. */
int cvol_container_try(cvol_context *context, const uint8_t *data, size_t size, const char *name);

#endif
