/* The components of RGB files in the viewer, drawn as one shape with colours (cvol/look.h). The
 * shape and the colours of the last volumes stay, for the next picture. */
#ifndef CVOL_VIEWER_VOLUMES_COLOURS_H
#define CVOL_VIEWER_VOLUMES_COLOURS_H

#include "viewer/volumes/shown_volume.h"

typedef struct shown_colours shown_colours;

/* What a picture shows. */
typedef struct colour_choice {
    shown_volume *components[CVOL_COLOURS_MAX]; /* ready, of the same time; alpha is the last one */
    size_t count;
    double rgb[3 * CVOL_COLOURS_MAX];
    double range[2]; /* values of black and of the full colour */
    double opacity_scale;
} colour_choice;

/* Without anything kept; NULL: no memory. */
shown_colours *colours_open(void);
/* Releases the volumes; NULL is allowed. */
void colours_close(shown_colours *shown);
/* Draws into a picture of floats without depths. One picture at a time is drawn. A code of the
 * library. */
int colours_draw(cvol_context *context, shown_colours *shown, const colour_choice *choice,
                 cvol_image *image, const cvol_render_options *options);

#endif
