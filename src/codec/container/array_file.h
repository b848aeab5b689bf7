/* The size of an array's file; files within files. */
#ifndef CVOL_CODEC_CONTAINER_ARRAY_FILE_H
#define CVOL_CODEC_CONTAINER_ARRAY_FILE_H

#include "array/core/array.h"
#include "base/file.h"

/* The exact size of the file that cvol_array_write would write: codes the array and counts bytes.
 * Errors: as cvol_array_write, except IO. */
int cvol_array_file_bytes(cvol_context *context, const cvol_array *array, uint64_t *file_bytes);

/* Writes as cvol_array_write, but as a part of an output, from the output's current position.
 * Errors: as cvol_array_write. */
int cvol_array_write_within(cvol_context *context, const cvol_array *array, cvol_output *output,
                            uint64_t *file_bytes);

/* True if a file whose subbands have this many bytes may have RNGE. RNGE takes at least two bits
 * per cell of 16^3. It is left out if that exceeds a hundredth of the subbands, and in files of the
 * neural coder. */
int cvol_array_may_have_ranges(const cvol_array *array, uint64_t subbands);

#endif
