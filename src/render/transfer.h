/* The transfer function's inside: sorted control points and their evaluation. */
#ifndef CVOL_RENDER_TRANSFER_H
#define CVOL_RENDER_TRANSFER_H

#include "cvol/render.h"

struct cvol_transfer {
    size_t count;
    cvol_transfer_point points[]; /* by value, not decreasing */
};

/* Colour and opacity at a value: linear between points, constant outside. */
cvol_transfer_point cvol_transfer_at(const cvol_transfer *transfer, double value);

/* The opacity that a length of `distance` mean spacings has: 1 - (1 - opacity)^distance. */
double cvol_opacity_over(double opacity, double distance);

/* The largest opacity that any value within [lo, hi] is given. */
double cvol_transfer_max_opacity(const cvol_transfer *transfer, double lo, double hi);

#endif
