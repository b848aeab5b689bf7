/* Lists a file's sections and verifies every checksum.
 *
 * Unlike the reader (container.h) it continues after damage as long as lengths are plausible, and
 * gives the byte of the damage. */
#ifndef CVOL_CODEC_CONTAINER_LAYOUT_H
#define CVOL_CODEC_CONTAINER_LAYOUT_H

#include "cvol/codec.h"

/* Does the work of cvol_file_read_layout on a file in memory; `name` begins its messages. */
int cvol_layout_walk(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                     const char *name);
/* Does the work of cvol_file_verify. */
int cvol_layout_verify(cvol_context *context, cvol_file_layout *out, const uint8_t *data,
                       size_t size, const char *name);

#endif
