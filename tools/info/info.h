/* Parts of cvol info. */
#ifndef CVOL_TOOLS_INFO_H
#define CVOL_TOOLS_INFO_H

#include "tools/base/cli.h"

json_t *describe_grid(const cvol_grid *grid);
/* Prints one line per field, in the order of the object. The PSNR of an exact file is "exact". */
void print_fields(json_t *object);

/* info_series.c: files of several volumes: a .cvol series, and other formats. Exit status. */
int show_series(cvol_context *context, common_options *common, const char *path);
int show_several(cvol_context *context, common_options *common, const char *path, int times,
                 int channels);

#endif
