/* Pictures as inputs and outputs: PNG files and compressed ones. */
#ifndef CVOL_TOOLS_PICTURE_H
#define CVOL_TOOLS_PICTURE_H

#include "cli.h"

/* By the file's first bytes. */
int is_png(const char *path);
/* A PNG or a compressed picture. */
int is_picture(const char *path);

/* The pixels of either; the caller frees *image. An error code of the library. */
int read_picture(cvol_context *context, cvol_image **image, const char *path);

/* What a compressed picture is, as an object; NULL without memory. */
json_t *describe_picture(const cvol_picture_info *info);

/* A PNG to a .cvi, and back. Exit status. */
int compress_picture(cvol_context *context, const char *in_path, const char *out_path,
                     const cvol_picture_options *options, int json);
int decompress_picture(cvol_context *context, const char *in_path, const char *out_path, int json);

#endif
