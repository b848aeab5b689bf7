/* Encodes pictures as PNG and JPEG. */
#ifndef CVOL_VIEWER_BASE_ENCODE_H
#define CVOL_VIEWER_BASE_ENCODE_H

#include "cvol/image.h"
#include "viewer/base/answer.h"

/* The picture as an answer; quality 1 to 100, or 0 for PNG. */
answer encode_picture(cvol_context *context, const cvol_image *image, int quality);

#endif
