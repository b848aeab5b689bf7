/* Common code of tests of files' parts and sections: files in memory. */
#ifndef CVOL_TESTS_SUPPORT_CONTAINER_H
#define CVOL_TESTS_SUPPORT_CONTAINER_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/codec.h"
#include "support_files.h"

/* The bytes of the array's file, also in file_path; and those of the same file without section
 * PACK. The caller frees them. */
uint8_t *container_written(const cvol_array *array, size_t *size);
uint8_t *container_file_of(const cvol_array *array, size_t *size);
/* The file's bytes; it is verified, too. */
uint8_t *container_verified(const cvol_array *array, size_t *size);
/* Split and lapped, of several bricks. */
cvol_array *container_small_array(void);
/* A copy of the file with this content in a section, which it need not have yet; with valid
 * checksums. content NULL: without the section. The caller frees it. */
uint8_t *container_with_section(const uint8_t *data, size_t *size, const char *tag,
                                const void *content, size_t length);
/* A copy with other bytes from byte `at` of a section's content on. */
uint8_t *container_with_field(const uint8_t *data, size_t *size, const char *tag, size_t at,
                              const void *bytes, size_t count);
/* The result code of reading all of it. */
int container_read_code(const uint8_t *data, size_t size);
/* The context's message must name the file f and an offset that is not behind the damage at this
 * byte. */
void container_expect_place(size_t at);

#endif
