/* Sections SPEC and TERM: the terms of arrays other than volumes in DCT blocks.
 *
 * SPEC has a whole array's low box and its other terms, TERM the terms of all blocks. Both are one
 * zstd frame (packed.h); doc/format.md gives its content. These arrays have no subbands and no
 * ranges. */
#ifndef CVOL_CODEC_CONTAINER_TERMS_H
#define CVOL_CODEC_CONTAINER_TERMS_H

#include "array/core/array.h"
#include "codec/container/header.h"
#include "codec/section/packed.h"

/* Checks that a file can hold the terms of an array in blocks, and floats its samples. Errors:
 * DATA. */
int cvol_terms_check(cvol_context *context, const cvol_array *array);

/* Appends a section's content. Errors: DATA (terms so large that floats could not hold the
 * samples), MEMORY. */
int cvol_spectrum_put(cvol_context *context, cvol_bytes *out, const cvol_array *array);
int cvol_terms_put(cvol_context *context, cvol_bytes *out, const cvol_array *array);

/* Checks a section's content and fills the array, which has no terms yet. TERM: before making the
 * array, the caller checks the header's claims against the content's length
 * (cvol_terms_check_length). Errors: CORRUPT, LIMIT, MEMORY. */
int cvol_spectrum_take(cvol_context *context, cvol_array *array, cvol_cursor *content,
                       const char *name);
int cvol_terms_take(cvol_context *context, cvol_array *array, const cvol_header *header,
                    cvol_cursor *content, const char *name);
int cvol_terms_check_length(cvol_context *context, const cvol_header *header,
                            const cvol_cursor *content, const char *name);

#endif
