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
/* The result code of reading all of it. */
int container_read_code(const uint8_t *data, size_t size);
/* The context's message must name the file f and an offset that is not behind the damage at this
 * byte. */
void container_expect_place(size_t at);

#endif
