/* The compression of GIF. */
#ifndef CVOL_IMAGE_GIF_LZW_H
#define CVOL_IMAGE_GIF_LZW_H

#include "base/bytes.h"

/* Appends the image data of 8-bit indices, `count` at least 1: code size, blocks, and their end. */
void cvol_gif_lzw(cvol_bytes *out, const uint8_t *indices, size_t count);

#endif
