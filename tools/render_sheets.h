/* Where projections go: a volume with one sheet for each, or numbered grey pictures. */
#ifndef CVOL_TOOLS_RENDER_SHEETS_H
#define CVOL_TOOLS_RENDER_SHEETS_H

#include "render_options.h"

typedef struct sheet_writer {
    const char *output;
    cvol_volume_writer *sink; /* NULL: pictures */
    cvol_image *image;
    double range[2]; /* black, white */
    int bits, digits;
    size_t written;
} sheet_writer;

/* Whether a name is that of numbered pictures. */
int is_numbered(const char *output);

/* Each answers a code, and the sentence is on the context. grid: of the stack. */
int open_sheets(cvol_context *context, sheet_writer *w, const render_arguments *a, const scene *s,
                const cvol_grid *grid);
int write_sheets(cvol_context *context, sheet_writer *w, const float *sheets, size_t count);
/* Keeps what was written if code is 0, or else nothing of it. */
int close_sheets(cvol_context *context, sheet_writer *w, int code);

#endif
