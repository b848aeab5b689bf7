/* cvol/annotate.h - what a reader needs to know, drawn over a picture: scale bar, axes, and a bar
 * of colours and opacities. */
#ifndef CVOL_ANNOTATE_H
#define CVOL_ANNOTATE_H

#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is told about a picture. */
typedef struct cvol_annotation {
    const cvol_grid *grid;              /* of the volume */
    const cvol_render_options *options; /* of the picture */
    int mirrored;                       /* the picture was turned left and right */
    int transparent;                    /* it will have no background */
    const cvol_transfer *transfer;      /* of mode composite; NULL: no bar of it */
    double range[2];                    /* of other modes: the samples that are black and white */
    double rescale[2];                  /* a sample s is told as rescale[0] s + rescale[1] */
    const char *value_unit;             /* above the values; "": nothing */
} cvol_annotation;

/* Draws over a picture of floats. Below on the left a bar of a round length (1, 2 or 5 times a
 * power of ten, at most a quarter of the picture's width) in the grid's unit; nm, um, mm, cm and m
 * are told as what makes the shortest number. Below on the right the axes: x, y, z of the samples,
 * or, if the grid says how it lies in a patient, the patient's left or right, front or back, and
 * top. On the right the transfer function from its first to its last point, colours and, beside
 * them, opacities from 0 to the largest; or the grey levels. Letters are light within a dark halo,
 * on bright backgrounds the other way round. Errors: ARGUMENT (no picture of floats, or not of the
 * options' size). */
CVOL_API int cvol_image_annotate(cvol_context *context, cvol_image *image,
                                 const cvol_annotation *annotation);

/* The longest round length (1, 2 or 5 times a power of ten) that is at most `most` (above 0). */
CVOL_API double cvol_round_length(double most);
/* "20 mm": a length in a unit, as annotations tell it. */
CVOL_API void cvol_length_text(char *text, size_t size, double length, const char *unit);

#ifdef __cplusplus
}
#endif
#endif
