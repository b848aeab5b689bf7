/* Pictures that several processes draw together (tools/mpi). */
#ifndef CVOL_TOOLS_RENDER_PARTS_H
#define CVOL_TOOLS_RENDER_PARTS_H

#include "tools/render/render_options.h"

typedef struct part_drawing {
    int rank; /* process 0 gets the picture and writes it */
    /* The level at which a process needs the whole volume (cvol_mpi_level). */
    int (*level)(const cvol_grid *grid);
    /* Draws a picture of floats. An error code, the same for all processes. */
    int (*draw)(cvol_context *context, const scene *s, cvol_image *image);
    /* Agrees on success: an exit status, for all the same whether one has failed. */
    int (*agree)(cvol_context *context, int status);
    /* The stages of the pictures drawn since the last call, for --json; NULL: none. */
    json_t *(*describe)(void);
} part_drawing;

/* NULL: this process draws whole pictures. */
extern const part_drawing *drawing_of_parts;

/* 1 if this process writes files. */
int process_writes(void);
/* Between the pictures of a film: the exit status, or that another process has failed. */
int agree_on_status(cvol_context *context, int status);

/* Adds "stages": those of each picture. */
void describe_parts(json_t *object);

/* Refuses what several processes do not draw. Exit status. */
int check_parts(const scene *s, const render_arguments *a, int volumes);

#endif
