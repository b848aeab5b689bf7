/* A file's sections as they lie there, and whether every checksum in it holds.
 *
 * Unlike the reader (container.h) this goes on behind damage as far as lengths can be believed, and
 * says at which byte it is.
 */
#ifndef CVOL_CODEC_CONTAINER_LAYOUT_H
#define CVOL_CODEC_CONTAINER_LAYOUT_H

#include "cvol/codec.h"

/* What cvol_file_layout_read does, of a file in memory; `name` begins its messages. */
int cvol_layout_walk(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                     const char *name);
/* What cvol_file_verify does. */
int cvol_layout_verify(cvol_context *context, cvol_file_layout *out, const uint8_t *data,
                       size_t size, const char *name);

#endif
