/* Footprints: the distribution of one sample over the pixels around it.
 *
 * A sample has a kernel that is round if the distance of samples is 1 on each axis: an ellipsoid in
 * the world. In parallel projection it covers an ellipse of the picture, the same for all samples.
 * Its footprint is a function of the place in this ellipse,
 *
 *     q = U^-1 (x, y),   U = [ux s; 0 uy],   U U^T = P P^T,
 *
 * with (x, y) in pixels, and P's columns the movement in pixels per sample along each axis
 * (Westover, "Footprint evaluation for volume rendering", 1990). ux and uy are at least 1 / size,
 * so that a footprint is at least a pixel wide. Within the square |qx|, |qy| < size / 2:
 *
 *     gaussian   exp(-|q|^2 / 2 sigma^2): exactly a Gaussian kernel's integral along the view
 *     cone       max(0, 1 - 2 |q| / size)
 *     sinc       w(qx) w(qy),  w(t) = sin(pi t) / (pi t) cos^2(pi t / size)
 *     box        e(qx) e(qy),  e(t) = size / 2 - |t| over 1/8, from 0 to 1 around 1/2: soft edges,
 *                since tables and gains have a limited resolution
 *
 * The samples of one slice lie on a lattice, over which footprints sum to almost the same
 * everywhere. The gain divides by this sum, so that a slice of one value is flat. */
#ifndef CVOL_RENDER_SPLAT_FOOTPRINT_H
#define CVOL_RENDER_SPLAT_FOOTPRINT_H

#include "cvol/engines.h"

/* The function and its ellipse. */
typedef struct cvol_footprint_shape {
    cvol_footprint kind;
    int size;
    double sigma;
    double ux, uy, s;
} cvol_footprint_shape;

/* The shape for pixels[axis]: the movement per sample along an axis in x (to the right) and y
 * (down). sigma 0: size / 6. */
cvol_footprint_shape cvol_footprint_shape_make(const cvol_splat_options *options,
                                               double pixels[3][2]);

/* The reach of a footprint, in samples. */
double cvol_footprint_reach(const cvol_footprint_shape *shape);
/* The factor of one coordinate, in samples; the cone has none. */
double cvol_footprint_factor(const cvol_footprint_shape *shape, double q);

/* Zeros before the weights of a row of the table, and at least this many behind. */
#define CVOL_FOOTPRINT_PAD 8

/* Weights by the position of a sample within a pixel. In y it lies at (py + 1/2) / phases_y of the
 * pixel floor(y), and reaches the rows of pixels first_y[py] .. first_y[py] + height - 1, counted
 * from that pixel. A row at y' sees the sample at x + s (y' - y) / uy, which lies at (px + 1/2) /
 * phases_x of a pixel: `width` weights begin first_x[px] from it.
 *
 * All except the cone are products, of columns[py height + row] and of
 *
 *     rows[px stride + CVOL_FOOTPRINT_PAD + column],
 *
 * which take little memory and have a fine resolution. The cone has a weight for each place,
 *
 *     rows[((py height + row) phases_x + px) stride + CVOL_FOOTPRINT_PAD + column]. */
typedef struct cvol_footprint_table {
    cvol_footprint_shape shape;
    int log2_x, log2_y, phases_x, phases_y; /* phases are powers of two */
    int width, height, stride;
    int *first_x, *first_y;
    float *rows, *columns; /* columns NULL: a cone */
} cvol_footprint_table;

/* The one of `count` equal parts of 0 .. 1 that contains a fraction; rounding may have made it
 * 1. */
static inline int cvol_footprint_part(double fraction, int count)
{
    int part = (int)(fraction * count);
    return part < count ? part : count - 1;
}

/* The weights of a row for places px in x, py in y. */
static inline const float *cvol_footprint_row(const cvol_footprint_table *table, int px, int py,
                                              int row)
{
    size_t at = (size_t)px;
    if (!table->columns)
        at += ((size_t)py * (size_t)table->height + (size_t)row) * (size_t)table->phases_x;
    return table->rows + at * (size_t)table->stride + CVOL_FOOTPRINT_PAD;
}

/* The distance, in pixels, of a footprint's first and last row from the middle one, to the
 * sides. */
static inline double cvol_footprint_slant(const cvol_footprint_table *table)
{
    const double s = table->shape.s;
    return (s < 0 ? -s : s) * (table->shape.size / 2.0 + 1);
}

/* Makes the table, unless it already has this shape; zero at first. Errors: MEMORY, LIMIT (a
 * footprint of more than 2,048 pixels). */
int cvol_footprint_table_make(cvol_context *context, cvol_footprint_table *table,
                              const cvol_footprint_shape *shape);
void cvol_footprint_table_free(cvol_footprint_table *table);

/* The gain of a lattice: gain[v size + u] is for the places (u + 1/2) / size, (v + 1/2) / size of
 * its cell, along its first and its second vector; the mean weight of all places, times it, makes
 * the sum of weights 1. */
#define CVOL_GAIN_MAX 64
typedef struct cvol_footprint_gain {
    double mean; /* of the sum of weights */
    int size;    /* 0: the sum is the same everywhere, to 1/1000 */
    float gain[CVOL_GAIN_MAX * CVOL_GAIN_MAX];
} cvol_footprint_gain;

/* The gain of the lattice i first + j second, in pixels. */
void cvol_footprint_gain_make(cvol_footprint_gain *gain, const cvol_footprint_table *table,
                              const double first[2], const double second[2], int threads);

#endif
