/* How many bytes an array's file has; files within files. */
#ifndef CVOL_CODEC_CONTAINER_ARRAY_FILE_H
#define CVOL_CODEC_CONTAINER_ARRAY_FILE_H

#include "array/core/array.h"
#include "base/file.h"

/* What cvol_array_write would give, to the byte: it is coded, and counted. Errors: those of
 * cvol_array_write but IO. */
int cvol_array_file_bytes(cvol_context *context, const cvol_array *array, uint64_t *file_bytes);

/* What cvol_array_write would write, as a part of an output, from where that is. Errors: those of
 * cvol_array_write. */
int cvol_array_write_within(cvol_context *context, const cvol_array *array, cvol_output *output,
                            uint64_t *file_bytes);

/* Whether a file whose subbands have so many bytes may have RNGE: it takes two bits a cell of 16^3
 * at least, and is left out where that is more than a hundredth of the subbands, and of what is
 * coded smallest. */
int cvol_array_may_have_ranges(const cvol_array *array, uint64_t subbands);

#endif
