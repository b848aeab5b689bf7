/* Files of planes: pictures and baked volumes. They begin with the signature and version of all
 * .cvol files; then follow a head (PICT or BAKE), the planes (PLNS) and the end. */
#ifndef CVOL_CODEC_CONTAINER_PLANE_FILE_H
#define CVOL_CODEC_CONTAINER_PLANE_FILE_H

#include "codec/container/plane_code.h"
#include "codec/section/section.h"
#include "cvol/codec.h"

/* Appends the whole file. Errors: MEMORY. */
int cvol_plane_file_put(cvol_context *context, cvol_bytes *out, cvol_section_kind head,
                        const cvol_bytes *head_content, const cvol_bytes *planes);

/* If code is CVOL_OK, writes the bytes as a file and stores their number in *file_bytes, which may
 * be NULL. Frees the bytes in any case. Errors: IO, MEMORY. */
int cvol_plane_file_end(cvol_context *context, cvol_bytes *bytes, int code, const char *path,
                        uint64_t *file_bytes);

/* Finds and checks both sections; `kind` is the head's. Errors: FORMAT (another kind of file),
 * CORRUPT, UNSUPPORTED. */
int cvol_plane_file_take(cvol_context *context, cvol_section *head, cvol_section *planes,
                         cvol_section_kind kind, const uint8_t *data, size_t size,
                         const char *name);

/* Tests if this many planes of a shape fit into this many bytes, and into memory. Errors: CORRUPT,
 * LIMIT. */
int cvol_plane_file_check(cvol_context *context, const cvol_plane_shape *shape, uint64_t planes,
                          uint64_t bytes, const char *name);

/* The kind of file that these first bytes belong to. */
cvol_file_kind cvol_plane_file_kind(const uint8_t *data, size_t size);

#endif
