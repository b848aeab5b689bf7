/* Pictures as inputs and outputs: PNG files and compressed ones. */
#ifndef CVOL_TOOLS_PICTURE_H
#define CVOL_TOOLS_PICTURE_H

#include "tools/base/cli.h"

/* Decided by the first bytes of the file. */
int is_png(const char *path);
/* A PNG or a compressed picture. */
int is_picture(const char *path);

/* Reads the pixels of either; the caller frees *image. A code of the library. */
int read_picture(cvol_context *context, cvol_image **image, const char *path);

/* Describes a compressed picture as a JSON object; NULL without memory. */
json_t *describe_picture(const cvol_picture_info *info);

/* Convert a PNG to a .cvi, and back. Exit status. */
int compress_picture(cvol_context *context, const char *in_path, const char *out_path,
                     const cvol_picture_options *options, int json);
int decompress_picture(cvol_context *context, const char *in_path, const char *out_path, int json);

#endif
