/* Writes projections: a volume with one slice for each, or numbered grey pictures. */
#ifndef CVOL_TOOLS_RENDER_PROJECTIONS_H
#define CVOL_TOOLS_RENDER_PROJECTIONS_H

#include "tools/render/render_options.h"

typedef struct projection_writer {
    const char *output;
    cvol_volume_writer *sink; /* NULL: pictures */
    cvol_image *image;
    double range[2]; /* black, white */
    int bits, digits;
    size_t written;
    int lacks_memory; /* for the name of a picture: the context has no message */
} projection_writer;

/* 1 if the name is a pattern for numbered pictures. */
int is_numbered(const char *output);

/* Each returns a code of the library; the context has the message, or lacks_memory is set. grid:
 * that of the stack. */
int open_projections(cvol_context *context, projection_writer *w, const render_arguments *a,
                     const scene *s, const cvol_grid *grid);
int write_projections(cvol_context *context, projection_writer *w, const float *slices,
                      size_t count);
/* Finishes the output if `code` is 0, else removes it. */
int close_projections(cvol_context *context, projection_writer *w, int code);

#endif
