/* Streams with one part per brick: the bricks that a box of samples needs, and their checksums. */
#ifndef CVOL_CODEC_BRICK_BRICK_STREAM_H
#define CVOL_CODEC_BRICK_BRICK_STREAM_H

#include "codec/brick/brick_index.h"
#include "codec/brick/bricks.h"
#include "codec/section/section.h"

/* The samples of a brick. */
cvol_box cvol_brick_samples_of(const cvol_array *array, size_t brick);
/* True if the brick's samples meet a box; always true for NULL. */
int cvol_brick_intersects(const cvol_array *array, size_t brick, const cvol_box *box);
/* Verifies the checksums of a stream's runs that contain a brick which meets the box. Errors:
 * CORRUPT. */
int cvol_brick_stream_check(cvol_context *context, const cvol_array *array,
                            const cvol_brick_index *index, int stream, const cvol_section *section,
                            const cvol_box *box, const char *name);

#endif
