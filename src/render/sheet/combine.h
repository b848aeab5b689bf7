/* Pictures by several processes (mpi/exchange.h). Every process draws its part (cvol_part) into an
 * intermediate image; all have the same plan, which depends on the whole view. The parts are put
 * together there, before the warp: between the pixels of intermediate images the warp interpolates,
 * and over the edge between two parts only an image that has both is right. */
#ifndef CVOL_RENDER_SHEET_COMBINE_H
#define CVOL_RENDER_SHEET_COMBINE_H

#include "cvol/base.h"
#include "cvol/render.h"

/* The groups of lines of an intermediate image: group g has its four values per pixel at values + g
 * stride, each as `count` floats, and behind those other floats (cvol_intermediate.lines). */
typedef struct cvol_sheet_lines {
    float *values;
    size_t groups, stride, count;
    double unit[2]; /* a value v of modes mip, min and xray is unit[0] v + unit[1] here */
} cvol_sheet_lines;

/* Each function is called by all processes, also by those with an error; then all return one, and
 * no process calls a function again for this picture. */
typedef struct cvol_sheet_combine {
    int is_idle;  /* this process has no part of the picture */
    int is_first; /* this process gets the picture; the images of others stay empty */
    void *data;
    /* Makes *value the largest of all processes. */
    int (*agree)(void *data, cvol_context *context, int code, size_t *value);
    /* Widens a range to those of all processes. */
    int (*widen)(void *data, cvol_context *context, int code, double range[2]);
    /* Puts the parts together, in the first process. */
    int (*combine)(void *data, cvol_context *context, int code, const cvol_sheet_lines *lines,
                   cvol_mode mode);
} cvol_sheet_combine;

/* For the pictures of a renderer from now on; NULL: this process draws them alone. Not copied.
 * Errors: ARGUMENT (not of engine sheet). */
int cvol_renderer_set_combine(cvol_context *context, cvol_renderer *renderer,
                              const cvol_sheet_combine *combine);

#endif
