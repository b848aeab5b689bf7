/* The first twelve bytes of a .cvol file: a signature of eight bytes, and the version. */
#ifndef CVOL_CODEC_SECTION_SIGNATURE_H
#define CVOL_CODEC_SECTION_SIGNATURE_H

#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "cvol/base.h"

enum { CVOL_SIGNATURE_BYTES = 8, CVOL_FORMAT_VERSION = 1, CVOL_SECTIONS_AT = 12 };

/* 1 if data begins with the signature. */
int cvol_container_is(const uint8_t *data, size_t size);
/* The number of first bytes of data that match the signature; byte `i` of the signature. */
size_t cvol_container_matches(const uint8_t *data, size_t size);
uint8_t cvol_container_signature(size_t i);
/* Takes signature and version from the beginning of a file. Errors: FORMAT, CORRUPT (cut within the
 * version), UNSUPPORTED. */
int cvol_container_take_start(cvol_context *context, cvol_cursor *file, const char *name);
/* Rejects any version but this one. Errors: UNSUPPORTED. */
int cvol_container_check_version(cvol_context *context, uint32_t version, const char *name);

#endif
