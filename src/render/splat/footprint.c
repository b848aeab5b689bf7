/* Footprint functions, their tables and their sums over lattices (footprint.h). */
#include "render/splat/footprint.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

#define PI 3.14159265358979323846

/* Pixels that a footprint may span along one axis. */
#define SPAN_MAX 2048
/* Places per sample that the tables distinguish, if memory allows. */
#define PRODUCT_PHASES 256.0
#define CONE_PHASES 64.0
#define TABLE_FLOATS (1 << 18)
/* The width of a box's edges, in samples. */
#define EDGE 0.125
/* Sums over a lattice count as equal within this. */
#define FLAT 1e-3
/* A lattice with a shorter vector, in pixels, is summed over some of its points. */
#define LATTICE_STEP (1.0 / 64)

cvol_footprint_shape cvol_footprint_shape_make(const cvol_splat_options *options,
                                               double pixels[3][2])
{
    double xx = 0, xy = 0, yy = 0;
    for (int a = 0; a < 3; a++) {
        xx += pixels[a][0] * pixels[a][0];
        xy += pixels[a][0] * pixels[a][1];
        yy += pixels[a][1] * pixels[a][1];
    }
    cvol_footprint_shape shape = {options->footprint, options->size, options->sigma, 0, 0, 0};
    if (!(shape.sigma > 0))
        shape.sigma = options->size / 6.0;
    /* A footprint between the centres of pixels would be lost: at least a pixel wide. */
    const double least = 1.0 / options->size;
    shape.uy = fmax(sqrt(yy), least);
    shape.s = xy / shape.uy;
    /* The slant of round footprints is 0 up to rounding. */
    if (fabs(shape.s) < 1e-12 * shape.uy)
        shape.s = 0;
    shape.ux = fmax(sqrt(fmax(xx - shape.s * shape.s, 0)), least);
    return shape;
}

static double windowed_sinc(double t, double size)
{
    double window = cos(PI * t / size), x = PI * t;
    return (fabs(x) < 1e-9 ? 1 : sin(x) / x) * window * window;
}

double cvol_footprint_reach(const cvol_footprint_shape *shape)
{
    return shape->size / 2.0 + (shape->kind == CVOL_FOOTPRINT_BOX ? EDGE / 2 : 0);
}

double cvol_footprint_factor(const cvol_footprint_shape *shape, double q)
{
    const double half = shape->size / 2.0;
    if (shape->kind == CVOL_FOOTPRINT_BOX)
        return fmin(fmax((half - fabs(q)) / EDGE + 0.5, 0), 1);
    if (!(q >= -half && q < half))
        return 0;
    if (shape->kind == CVOL_FOOTPRINT_SINC)
        return windowed_sinc(q, shape->size);
    return exp(-q * q / (2 * shape->sigma * shape->sigma));
}

static double cone(const cvol_footprint_shape *shape, double qx, double qy)
{
    return fmax(0, 1 - 2 * hypot(qx, qy) / shape->size);
}

/* ---- the table ------------------------------------------------------------------------- */

void cvol_footprint_table_free(cvol_footprint_table *table)
{
    free(table->first_x);
    free(table->first_y);
    free(table->rows);
    free(table->columns);
    *table = (cvol_footprint_table){0};
}

static int same_shape(const cvol_footprint_shape *a, const cvol_footprint_shape *b)
{
    /* Views of one zoom differ by rounding. */
    return a->kind == b->kind && a->size == b->size && a->sigma == b->sigma &&
           fabs(a->ux - b->ux) < 1e-9 * a->ux && fabs(a->uy - b->uy) < 1e-9 * a->uy &&
           fabs(a->s - b->s) < 1e-9 * a->ux;
}

/* The number of phases for the scale, within the available memory. */
static void choose_phases(cvol_footprint_table *table)
{
    const cvol_footprint_shape *shape = &table->shape;
    const int is_cone = shape->kind == CVOL_FOOTPRINT_CONE;
    const double most = is_cone ? CONE_PHASES : PRODUCT_PHASES;
    double x = fmin(fmax(most / shape->ux, 1), most), y = fmin(fmax(most / shape->uy, 1), most);
    const double floats = is_cone ? x * y * table->height * table->stride
                                  : fmax(x * table->stride, y * table->height);
    const double less = floats > TABLE_FLOATS ? TABLE_FLOATS / floats : 1;
    table->log2_x = (int)lround(log2(fmax(1, x * (is_cone ? sqrt(less) : less))));
    table->log2_y = (int)lround(log2(fmax(1, y * (is_cone ? sqrt(less) : less))));
    table->phases_x = 1 << table->log2_x;
    table->phases_y = 1 << table->log2_y;
}

static double place_x(const cvol_footprint_table *table, int px, int column)
{
    return (table->first_x[px] + column - (px + 0.5) / table->phases_x) / table->shape.ux;
}

static double place_y(const cvol_footprint_table *table, int py, int row)
{
    return (table->first_y[py] + row - (py + 0.5) / table->phases_y) / table->shape.uy;
}

static void fill_products(cvol_footprint_table *table)
{
    for (int px = 0; px < table->phases_x; px++)
        for (int column = 0; column < table->width; column++)
            table->rows[px * table->stride + CVOL_FOOTPRINT_PAD + column] = (float)
                cvol_footprint_factor(&table->shape, place_x(table, px, column));
    for (int py = 0; py < table->phases_y; py++)
        for (int row = 0; row < table->height; row++)
            table->columns[py * table->height + row] = (float)cvol_footprint_factor(
                &table->shape, place_y(table, py, row));
}

static void fill_cone(cvol_footprint_table *table, int threads)
{
#pragma omp parallel for num_threads(threads)
    for (int py = 0; py < table->phases_y; py++)
        for (int row = 0; row < table->height; row++)
            for (int px = 0; px < table->phases_x; px++) {
                size_t line = ((size_t)py * (size_t)table->height + (size_t)row) *
                                  (size_t)table->phases_x +
                              (size_t)px;
                float *weights = table->rows + line * (size_t)table->stride + CVOL_FOOTPRINT_PAD;
                for (int column = 0; column < table->width; column++)
                    weights[column] = (float)cone(&table->shape, place_x(table, px, column),
                                                  place_y(table, py, row));
            }
}

static void fill_first(int *first, int phases, double reach)
{
    for (int p = 0; p < phases; p++)
        first[p] = (int)ceil((p + 0.5) / phases - reach - 1e-9);
}

/* Memory for a table whose sizes are set; 0 without. */
static int allocate_table(cvol_footprint_table *table)
{
    const size_t nx = (size_t)table->phases_x, ny = (size_t)table->phases_y;
    const size_t height = (size_t)table->height, stride = (size_t)table->stride;
    const int is_cone = table->shape.kind == CVOL_FOOTPRINT_CONE;
    table->first_x = cvol_allocate(nx, sizeof *table->first_x);
    table->first_y = cvol_allocate(ny, sizeof *table->first_y);
    table->rows = cvol_allocate_zero(nx * stride * (is_cone ? ny * height : 1),
                                     sizeof *table->rows);
    table->columns = is_cone ? NULL : cvol_allocate(ny * height, sizeof *table->columns);
    return table->first_x && table->first_y && table->rows && (is_cone || table->columns);
}

int cvol_footprint_table_make(cvol_context *context, cvol_footprint_table *table,
                              const cvol_footprint_shape *shape)
{
    if (table->rows && same_shape(&table->shape, shape))
        return CVOL_OK;
    cvol_footprint_table_free(table);
    const double reach_x = cvol_footprint_reach(shape) * shape->ux,
                 reach_y = cvol_footprint_reach(shape) * shape->uy;
    if (!(2 * fmax(reach_x, reach_y) <= SPAN_MAX))
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "a footprint of %d samples would span %.0f pixels of this picture, "
                         "at most %d are possible",
                         shape->size, 2 * fmax(reach_x, reach_y), SPAN_MAX);
    table->shape = *shape;
    table->width = (int)fmax(1, ceil(2 * reach_x - 1e-9));
    table->height = (int)fmax(1, ceil(2 * reach_y - 1e-9));
    table->stride = (table->width + 2 * CVOL_FOOTPRINT_PAD + 3) / 4 * 4;
    choose_phases(table);
    if (!allocate_table(table)) {
        cvol_footprint_table_free(table);
        return cvol_fail(context, CVOL_ERROR_MEMORY, "not enough memory for a table of footprints");
    }
    fill_first(table->first_x, table->phases_x, reach_x);
    fill_first(table->first_y, table->phases_y, reach_y);
    if (table->columns)
        fill_products(table);
    else
        fill_cone(table, cvol_context_threads(context));
    return CVOL_OK;
}

/* ---- sums over a lattice --------------------------------------------------------------- */

/* The weight of a pixel at an offset from a sample. */
static double weight_at(const cvol_footprint_table *table, double x, double y)
{
    x -= table->shape.s * y / table->shape.uy;
    const double pixel_x = ceil(x), pixel_y = ceil(y);
    const int px = cvol_footprint_part(pixel_x - x, table->phases_x);
    const int py = cvol_footprint_part(pixel_y - y, table->phases_y);
    const int column = (int)pixel_x - table->first_x[px], row = (int)pixel_y - table->first_y[py];
    if (column < 0 || column >= table->width || row < 0 || row >= table->height)
        return 0;
    const double weight = (double)cvol_footprint_row(table, px, py, row)[column];
    return table->columns ? weight * (double)table->columns[py * table->height + row] : weight;
}

/* The sum of the weights of all of the lattice at u a + v b. */
static double sum_at(const cvol_footprint_table *table, const double a[2], const double b[2],
                     double u, double v)
{
    const double determinant = a[0] * b[1] - a[1] * b[0];
    const double reach[2] = {table->width / 2.0 + 1 + cvol_footprint_slant(table),
                             table->height / 2.0 + 1};
    /* The box -reach .. reach in lattice coordinates. */
    double reach_v = (fabs(a[1]) * reach[0] + fabs(a[0]) * reach[1]) / fabs(determinant);
    double sum = 0;
    for (double j = ceil(v - reach_v); j <= v + reach_v; j++) {
        /* the part of this line of the lattice within the box in x and in y */
        double from = -1e9, to = 1e9;
        for (int k = 0; k < 2; k++) {
            double at = (v - j) * b[k];
            if (fabs(a[k]) * 1e9 < reach[k])
                continue;
            double p = (at - reach[k]) / a[k], q = (at + reach[k]) / a[k];
            from = fmax(from, fmin(p, q));
            to = fmin(to, fmax(p, q));
        }
        for (double i = ceil(u + from); i <= u + to; i++)
            sum += weight_at(table, (u - i) * a[0] + (v - j) * b[0],
                             (u - i) * a[1] + (v - j) * b[1]);
    }
    return sum;
}

/* The mean of the sums over a lattice, at all places: the footprint's integral over the area of a
 * cell. */
static double mean_sum(const cvol_footprint_table *table, double area)
{
    double sum = 0;
    for (int py = 0; py < table->phases_y; py++)
        for (int row = 0; row < table->height; row++) {
            double line = 0;
            for (int px = 0; px < table->phases_x; px++)
                for (int column = 0; column < table->width; column++)
                    line += (double)cvol_footprint_row(table, px, py, row)[column];
            sum += table->columns ? line * (double)table->columns[py * table->height + row] : line;
        }
    return sum / table->phases_x / table->phases_y / area;
}

/* The multiple of a lattice's vector that is about LATTICE_STEP long, if the vector is shorter;
 * returns the factor. */
static double thin(double longer[2], const double vector[2])
{
    const double factor = fmax(1, floor(LATTICE_STEP / hypot(vector[0], vector[1])));
    longer[0] = factor * vector[0];
    longer[1] = factor * vector[1];
    return factor;
}

void cvol_footprint_gain_make(cvol_footprint_gain *gain, const cvol_footprint_table *table,
                              const double first[2], const double second[2], int threads)
{
    double a[2], b[2];
    const double thin_a = thin(a, first), thin_b = thin(b, second);
    if (thin_a > 1 && thin_b > 1) {
        /* thousands of samples a pixel */
        gain->mean = mean_sum(table, fabs(first[0] * second[1] - first[1] * second[0]));
        gain->size = 0;
        return;
    }
    /* Wider footprints give smoother sums. */
    const int footprint = table->shape.size;
    const int size = footprint <= 7 ? CVOL_GAIN_MAX : footprint <= 15 ? 32 : 16;
    double sums[CVOL_GAIN_MAX * CVOL_GAIN_MAX];
#pragma omp parallel for num_threads(threads)
    for (int at = 0; at < size * size; at++)
        sums[at] = thin_a * thin_b *
                   sum_at(table, a, b, (at % size + 0.5) / size / thin_a,
                          (at / size + 0.5) / size / thin_b);
    double mean = 0, worst = 0;
    for (int at = 0; at < size * size; at++)
        mean += sums[at] / (size * size);
    for (int at = 0; at < size * size; at++)
        worst = fmax(worst, fabs(sums[at] / mean - 1));
    gain->mean = mean;
    gain->size = worst < FLAT ? 0 : size;
    for (int at = 0; at < size * size; at++)
        gain->gain[at] = (float)(mean / fmax(sums[at], mean / 1024));
}
