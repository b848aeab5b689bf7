/* Internals of the transfer function: sorted control points and their evaluation. */
#ifndef CVOL_RENDER_TRANSFER_TRANSFER_H
#define CVOL_RENDER_TRANSFER_TRANSFER_H

#include "cvol/transfer.h"

struct cvol_transfer {
    size_t count;
    cvol_transfer_point points[]; /* by value, not decreasing */
};

#define CVOL_TRANSFER_POINTS_MAX 65536

/* cvol_transfer_create for points from any input: `name` begins the message of a bad point, and
 * `code` is the error that it returns. */
int cvol_transfer_make(cvol_context *context, cvol_transfer **out,
                       const cvol_transfer_point *points, size_t count, int code, const char *name);
int cvol_transfer_copy(cvol_context *context, cvol_transfer **out, const cvol_transfer *transfer);

/* Colour and opacity at a value: linear between points, constant outside. At a jump, the later
 * point's; NaN has the first point's. */
cvol_transfer_point cvol_transfer_at(const cvol_transfer *transfer, double value);
/* The same, but at a jump the earlier point's: the limit from below. */
cvol_transfer_point cvol_transfer_before(const cvol_transfer *transfer, double value);

/* The opacity over a length of `distance` mean spacings: 1 - (1 - opacity)^distance. */
double cvol_opacity_over(double opacity, double distance);

/* The distance of the values between which the opacity is above 0, as far as control points lie;
 * 0 if transfer is NULL. */
double cvol_transfer_width(const cvol_transfer *transfer);

/* The largest opacity of any value within [lo, hi]. */
double cvol_transfer_max_opacity(const cvol_transfer *transfer, double lo, double hi);

#endif
