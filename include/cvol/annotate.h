/* cvol/annotate.h - draws a scale bar, axes, and a bar of colours and opacities over a picture. */
#ifndef CVOL_ANNOTATE_H
#define CVOL_ANNOTATE_H

#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Facts about a picture that is annotated; zero what is not set. */
typedef struct cvol_annotation {
    size_t size;                        /* sizeof(cvol_annotation) */
    const cvol_grid *grid;              /* of the volume */
    const cvol_render_options *options; /* of the picture */
    int mirrored;                       /* 1: the picture is mirrored */
    int transparent;                    /* 1: the picture has no background */
    const cvol_transfer *transfer;      /* of mode composite; NULL: draw no colour bar */
    double range[2];                    /* other modes: the values of black and white */
    double rescale[2];                  /* a sample s is labelled rescale[0] s + rescale[1] */
    const char *value_unit;             /* printed above the values; "": none */
} cvol_annotation;

/* Draws over a picture of floats. Lower left: a scale bar of a round length (1, 2 or 5 times a
 * power of ten, at most a quarter of the width of the picture) in the unit of the grid; among nm,
 * um, mm, cm and m it uses the one with the shortest number. Without a unit, but with a patient's
 * orientation, it assumes mm and says "(assumed)". Lower right: the axes x, y, z of the
 * samples, or, with a patient orientation, the patient's left or right, front or back, and top.
 * Right: the transfer function from its first to its last point, with opacities from 0 to the
 * largest; or the grey levels. Text is light with a dark halo, and the reverse on bright
 * backgrounds. Errors: ARGUMENT (not a picture of floats, or not of the size in the options). */
CVOL_API int cvol_image_annotate(cvol_context *context, cvol_image *image,
                                 const cvol_annotation *annotation);

/* The longest round length (1, 2 or 5 times a power of ten) that is at most `most` (above 0). */
CVOL_API double cvol_length_round(double most);
/* Writes a length with its unit, "20 mm", as in annotations. */
CVOL_API void cvol_length_format(char *text, size_t size, double length, const char *unit);

#ifdef __cplusplus
}
#endif
#endif
