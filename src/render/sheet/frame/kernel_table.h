/* The line kernels of the sheet engine, and the choice of the one that draws a frame. */
#ifndef CVOL_RENDER_SHEET_FRAME_KERNEL_TABLE_H
#define CVOL_RENDER_SHEET_FRAME_KERNEL_TABLE_H

#include "cvol/render.h"
#include "render/sheet/frame/frame.h"

/* A frame's requirements on its kernel. */
typedef struct cvol_kernel_key {
    cvol_mode mode;
    int is_image_order, is_lit; /* lit: composites with light, and surfaces */
    int is_int16;               /* the type of the samples; else floats */
    int has_extras; /* depth, samples between slices, reconstruction filters, or counting */
} cvol_kernel_key;

typedef struct cvol_kernel_row {
    const char *name;
    cvol_kernel_key key;        /* CVOL_ANY: any value */
    cvol_sheet_kernel *sets[3]; /* by cvol_cpu */
} cvol_kernel_row;
#define CVOL_ANY (-1)

/* All rows; the first that fits a key draws the frame. */
const cvol_kernel_row *cvol_sheet_kernels(size_t *count);
/* The kernel of a frame; NULL if none fits. */
cvol_sheet_kernel *cvol_sheet_kernel_find(const cvol_kernel_key *key, cvol_cpu cpu);

#endif
