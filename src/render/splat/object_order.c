/* Lattices of views (object_order.h): their size, and footprints on them. */
#include "render/splat/object_order.h"

#include <math.h>

/* Slices begin in the middle between places that tables of footprints distinguish (footprint.c). */
#define OFFSET (1.0 / 512)
/* Shears of two views along one direction differ by rounding. */
#define SAME 1e-9
/* A Gaussian's sigma, in places, that is still visible. */
#define SHARPEST 1.2

cvol_footprint_shape cvol_intermediate_grid_shape(const cvol_splat_options *splat)
{
    double round[3][2] = {{1, 0}, {0, 1}, {0, 0}};
    return cvol_footprint_shape_make(splat, round);
}

double cvol_intermediate_grid_step(const cvol_footprint_shape *shape)
{
    double step = 1;
    while (shape->kind == CVOL_FOOTPRINT_GAUSSIAN && step < 4 &&
           shape->sigma >= SHARPEST * 2 * step)
        step *= 2;
    return step;
}

cvol_footprint_shape cvol_intermediate_grid_stretch(const cvol_footprint_shape *shape,
                                                    double factor)
{
    cvol_footprint_shape out = *shape;
    out.ux = out.uy = factor;
    return out;
}

/* The next length with a fast transform: 2^a 3^b 5^c, even. */
static size_t fast_length(size_t n)
{
    for (n += n & 1;; n += 2) {
        size_t rest = n;
        for (size_t p = 2; p <= 5; p += p == 2 ? 1 : 2)
            while (rest % p == 0)
                rest /= p;
        if (rest == 1)
            return n;
    }
}

cvol_intermediate_grid cvol_intermediate_grid_make(const cvol_splat_plan *plan,
                                                   const cvol_footprint_shape *shape, double step)
{
    const double(*along)[2] = plan->along;
    const double determinant = along[0][0] * along[1][1] - along[0][1] * along[1][0];
    const double reach = ceil(shape->ux * shape->size / 2.0) + 1;
    cvol_intermediate_grid out = {.reach = (size_t)reach, .step = step};
    out.shear[0] = (along[2][0] * along[1][1] - along[2][1] * along[1][0]) / determinant;
    out.shear[1] = (along[0][0] * along[2][1] - along[0][1] * along[2][0]) / determinant;
    const size_t samples[2] = {plan->lanes, plan->rows};
    for (int a = 0; a < 2; a++) {
        const double drift = out.shear[a] * (double)(plan->slices - 1);
        out.base[a] = reach + fmax(-drift, 0) + OFFSET;
        out.dims[a] = fast_length(
            (size_t)ceil(((double)samples[a] + fabs(drift) + 2 * reach) / step) + 2);
    }
    return out;
}

int cvol_intermediate_grid_same(const cvol_intermediate_grid *a, const cvol_intermediate_grid *b)
{
    int same = a->reach == b->reach && fabs(a->step - b->step) < SAME;
    for (int k = 0; k < 2; k++)
        same = same && a->dims[k] == b->dims[k] && fabs(a->shear[k] - b->shear[k]) <= SAME &&
               fabs(a->base[k] - b->base[k]) <= SAME * (double)a->dims[k];
    return same;
}

static cvol_intermediate_line line_at(const cvol_footprint_shape *shape, double start)
{
    const double reach = shape->ux * cvol_footprint_reach(shape), fraction = start - floor(start);
    cvol_intermediate_line out = {.place = (ptrdiff_t)floor(start),
                                  .low = (int)ceil(fraction - reach),
                                  .high = (int)floor(fraction + reach)};
    double sum = 0;
    for (int q = out.low; q <= out.high; q++)
        sum += out.weights[q - out.low] = cvol_footprint_factor(shape, (q - fraction) / shape->ux);
    for (int q = out.low; q <= out.high; q++)
        out.weights[q - out.low] /= sum;
    return out;
}

cvol_intermediate_line cvol_intermediate_line_make(const cvol_intermediate_grid *image_grid,
                                                   const cvol_footprint_shape *shape, int axis,
                                                   size_t k)
{
    return line_at(shape, image_grid->base[axis] + (double)k * image_grid->shear[axis]);
}

/* The norm of the weights' matrix along one axis: sqrt(largest sum of a row, largest sum of a
 * column), for some fractions, and a little more for the fractions between. */
double cvol_intermediate_grid_norm(const cvol_intermediate_grid *image_grid,
                                   const cvol_footprint_shape *shape)
{
    const int step = (int)image_grid->step, fractions = 64;
    double most = 0;
    for (int n = 0; n < fractions; n++) {
        const cvol_intermediate_line line = line_at(shape, (double)n / fractions);
        double row = 0, column = 0;
        for (int first = line.low; first < line.low + step; first++) {
            double sum = 0;
            for (int q = first; q <= line.high; q += step)
                sum += fabs(line.weights[q - line.low]);
            row += sum;
            column = fmax(column, sum);
        }
        most = fmax(most, row * column);
    }
    return 1.01 * most; /* sqrt(row column) per axis, two axes */
}
