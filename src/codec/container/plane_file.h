/* Files of planes: pictures and baked volumes. Signature and version are those of all .cvol files;
 * then come a head (PICT or BAKE), the planes (PLNS) and the end.
 */
#ifndef CVOL_CODEC_CONTAINER_PLANE_FILE_H
#define CVOL_CODEC_CONTAINER_PLANE_FILE_H

#include "codec/container/plane_code.h"
#include "codec/section/section.h"
#include "cvol/codec.h"

/* Appends the whole file. Errors: MEMORY. */
int cvol_plane_file_put(cvol_context *context, cvol_bytes *out, cvol_section_kind head,
                        const cvol_bytes *head_content, const cvol_bytes *planes);

/* Writes bytes that went well (code is CVOL_OK) as a file, and frees them in any case; their number
 * goes to *file_bytes, if that is not NULL. Errors: IO, MEMORY. */
int cvol_plane_file_end(cvol_context *context, cvol_bytes *bytes, int code, const char *path,
                        uint64_t *file_bytes);

/* Finds both sections, checked; `kind` is the head's. Errors: FORMAT (another kind of file),
 * CORRUPT, UNSUPPORTED. */
int cvol_plane_file_take(cvol_context *context, cvol_section *head, cvol_section *planes,
                         cvol_section_kind kind, const uint8_t *data, size_t size,
                         const char *name);

/* Whether so many planes of a shape may be in so many bytes, and in memory. Errors: CORRUPT, LIMIT.
 */
int cvol_plane_file_check(cvol_context *context, const cvol_plane_shape *shape, uint64_t planes,
                          uint64_t bytes, const char *name);

/* What a file's bytes begin like. */
cvol_file_kind cvol_plane_file_kind(const uint8_t *data, size_t size);

#endif
