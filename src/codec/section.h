/* Sections of a .cvol: a tag of four letters, a length, two checksums, and the content.
 *
 *     tag[4]  length u64  checksum of the content u32  checksum of the 16 bytes so far u32  content
 */
#ifndef CVOL_CODEC_SECTION_H
#define CVOL_CODEC_SECTION_H

#include "base/bytes.h"
#include "cvol/base.h"

enum { CVOL_SECTION_HEADER_BYTES = 20 };

/* Appends a section's header. */
void cvol_section_put_header(cvol_bytes *out, const char *tag, uint64_t length, uint32_t checksum);
/* Appends a whole section. */
void cvol_section_put(cvol_bytes *out, const char *tag, const cvol_bytes *content);

/* Reads the header of the section that must come next and takes its content; *checksum is what the
 * header says of it. Errors: CORRUPT ("NAME: truncated in section DATA, 1000 of 2000 bytes"). */
int cvol_section_take(cvol_context *context, cvol_cursor *content, uint32_t *checksum,
                      cvol_cursor *file, const char *tag, const char *name);

/* Compares a content's checksum with what the header says. Errors: CORRUPT. */
int cvol_section_check(cvol_context *context, uint32_t stored, uint32_t found, const char *tag,
                       const char *name);

#endif
