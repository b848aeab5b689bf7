/* The .cvol container, version 1: doc/format.md is its description. Reading; for writing see
 * writer.h. */
#ifndef CVOL_CODEC_CONTAINER_CONTAINER_H
#define CVOL_CODEC_CONTAINER_CONTAINER_H

#include "array/core/array.h"
#include "codec/brick/bricks.h"
#include "codec/section/section.h"
#include "cvol/codec.h"

enum { CVOL_SIGNATURE_BYTES = 8, CVOL_FORMAT_VERSION = 1, CVOL_SECTIONS_AT = 12 };

/* 1 if data begins with the signature. */
int cvol_container_is(const uint8_t *data, size_t size);
/* How many bytes of data are the signature's; its byte `i`. */
size_t cvol_container_matches(const uint8_t *data, size_t size);
uint8_t cvol_container_signature(size_t i);
/* Refuses any version but this one. Errors: UNSUPPORTED. */
int cvol_container_check_version(cvol_context *context, uint32_t version, const char *name);

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
