/* The end of the background and the place of the object in a histogram. */
#ifndef CVOL_RENDER_TRANSFER_FIT_H
#define CVOL_RENDER_TRANSFER_FIT_H

#include "cvol/transfer.h"

/* A value is described by its depth: its distance beyond the background's edge, on the object's
 * side (on both, for signed data). Depth 0 is the edge, `top` the object's robust end. */
typedef struct cvol_fit {
    int has_background;            /* 0: values have no empty space; the brighter half counts */
    int above, below;              /* the object lies above the background, below it, or both */
    double edge_above, edge_below; /* values at depth 0 */
    double top;                    /* depth that 999/1000 of the object's samples stay below */
    double share;                  /* of all samples, the object's; 0: nothing to see */
    double divide;                 /* depth that divides the object in two (Otsu): soft and dense */
    double bin;                    /* depth of one bin */
    double chord;                  /* of the histogram */
    double beyond[CVOL_HISTOGRAM_BINS + 1]; /* share of the object's samples deeper than i bins */
} cvol_fit;

cvol_fit cvol_fit_make(const cvol_histogram *histogram);
/* The share of the object's samples that lie deeper, 1 at depth 0 and 0 at the end. */
double cvol_fit_share_deeper(const cvol_fit *fit, double depth);

#endif
