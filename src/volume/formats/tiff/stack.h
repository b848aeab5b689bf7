/* Spacing, channels and times from a TIFF's description, by ImageJ or OME. */
#ifndef CVOL_VOLUME_FORMATS_TIFF_STACK_H
#define CVOL_VOLUME_FORMATS_TIFF_STACK_H

#include "volume/io/stored.h"

typedef struct cvol_tiff_stack {
    int known; /* 1 if the file has such a description */
    /* Slices, channels and times, and the distance of pages that differ by one of each. */
    size_t slices, channels, times;
    size_t slice_step, channel_step, time_step;
    double spacing[3]; /* 0: unknown */
    char unit[3][16];  /* of each axis, as the file names it; "": unknown */
    int is_imagej;     /* x and y spacing are in the resolution tags */
    size_t images;     /* ImageJ: pages; a large file describes only the first */
} cvol_tiff_stack;

/* Reads an ImageDescription; known = 0 if text is NULL or of another program. `samples` of a pixel
 * are channels of one page. */
void cvol_tiff_read_description(cvol_tiff_stack *stack, const char *text, size_t samples);
/* Times and channels from the same text, with the caller's counts. 1, or 0 without memory; the
 * caller frees the list with free(). */
int cvol_tiff_read_labels(cvol_labels *labels, const char *text, size_t channels, size_t samples);

#endif
