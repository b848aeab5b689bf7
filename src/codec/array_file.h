/* How many bytes an array's file has. */
#ifndef CVOL_CODEC_ARRAY_FILE_H
#define CVOL_CODEC_ARRAY_FILE_H

#include "array/array.h"

/* What cvol_array_write would give, to the byte: it is coded, and counted. Errors: those of
 * cvol_array_write but IO. */
int cvol_array_file_bytes(cvol_context *context, const cvol_array *array, uint64_t *file_bytes);

#endif
