/* Encoding PNG files: by libpng (png_encode.c), or by zlib alone (png_encode_missing.c). */
#ifndef CVOL_IMAGE_PNG_ENCODE_H
#define CVOL_IMAGE_PNG_ENCODE_H

#include "base/bytes.h"
#include "image/pixels.h"

/* The file's bytes, which the caller frees, also after an error. `level` is zlib's 0 to 9, or
 * CVOL_PNG_QUICK. `name` begins messages. Error: MEMORY. */
int cvol_png_encode(cvol_context *context, cvol_bytes *out, const cvol_png_rows *rows, int level,
                    const char *name);

#endif
