/* Section BAKE. */
#ifndef CVOL_CODEC_CONTAINER_BAKED_HEAD_H
#define CVOL_CODEC_CONTAINER_BAKED_HEAD_H

#include "codec/container/baked.h"

void cvol_baked_head_put(cvol_bytes *out, const cvol_baked_file *file);
/* Fills all members but the planes; allocates the points. Errors: CORRUPT, MEMORY. */
int cvol_baked_head_take(cvol_context *context, cvol_baked_file *out, cvol_cursor *content,
                         const char *name);

#endif
