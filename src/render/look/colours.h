/* Components of colours in bricks, and their shape (cvol/look.h). */
#ifndef CVOL_RENDER_LOOK_COLOURS_H
#define CVOL_RENDER_LOOK_COLOURS_H

#include <stdint.h>

#include "cvol/look.h"

enum {
    CVOL_COLOUR_SIDE = 32,                     /* samples of a brick along an axis */
    CVOL_COLOUR_STRIDE = CVOL_COLOUR_SIDE + 1, /* with the first ones of the next brick */
    CVOL_COLOUR_SAMPLES = CVOL_COLOUR_STRIDE * CVOL_COLOUR_STRIDE * CVOL_COLOUR_STRIDE
};

/* The shape is drawn in this grey, which light may make brighter; then the pixels are divided by
 * it. */
#define CVOL_COLOUR_GREY 0.4

struct cvol_colours {
    cvol_grid grid;
    size_t count;
    int has_alpha;
    const cvol_array *arrays[CVOL_COLOURS_MAX]; /* or NULL: volumes */
    const cvol_volume *volumes[CVOL_COLOURS_MAX];
    double range[2];
    float rgb[3 * CVOL_COLOURS_MAX];
    /* Sums are those of components, or, on a bright background, what they lack of `bright`; 0: no
     * bright background. */
    double bright;
    double ends[2]; /* sums, of which 0 is black and 1 all components at their full value, where the
                       shape is 0 and 255 */
    size_t bricks[3], brick_count, kept; /* bricks along the axes, of all, with samples */
    /* [brick_count]: [CVOL_COLOUR_SAMPLES] samples of CVOL_COLOURS_MAX bytes, of which the first
     * `count` are components, and 255 is the end of the range; NULL: not evaluated. */
    uint8_t **samples;
    uint8_t *needed; /* [brick_count]: 1 if the picture needs it */
    /* Cells, which divide bricks: bounds of the shape between their samples and the first ones of
     * the next cells, and 1 where the transfer function shows some. */
    size_t cell_side, cells[3], cell_count;
    float (*bounds)[2];
    uint8_t *visible;
};

/* Makes the shape, and sets its ends. Errors: MEMORY, CANCELLED. */
int cvol_colours_make_shape(cvol_context *context, cvol_array **array, cvol_volume **volume,
                            cvol_colours *colours, int by_range);
/* Samples of component c in a box, x fastest. Errors: MEMORY, CANCELLED. */
int cvol_colours_evaluate_box(cvol_context *context, float *out, const cvol_colours *colours,
                              size_t c, const size_t begin[3], const size_t end[3]);
/* Sets `visible`. */
void cvol_colours_find_visible(cvol_colours *colours, const cvol_transfer *transfer);
/* Evaluates the needed bricks that are not kept. Errors: MEMORY, CANCELLED. */
int cvol_colours_evaluate(cvol_context *context, cvol_colours *colours);

#endif
