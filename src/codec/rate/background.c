/* Searches for a background. */
#include "codec/rate/background.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

/* The number of samples in the first test, and the limits that make a mask pay. */
enum { LOOKED_AT = 1 << 14, ROWS_BETWEEN = 8 };
#define SHARE_MIN 0.05
#define STEP_MIN 3.0
#define FACES_MAX 0.1
#define FINEST_SHARE (1.0 / 16)

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Finds the most frequent value among samples from all over the volume. *share: its share of
 * them. */
static double find_most(double *values, double *share, const void *samples, const cvol_grid *grid)
{
    const size_t all = cvol_grid_samples(grid), count = all < LOOKED_AT ? all : LOOKED_AT;
    /* An odd stride visits every column. */
    const size_t stride = all / count | 1;
    size_t found = 0, most = 0, run = 0;
#define LOOK(type)                                                  \
    for (size_t i = 0; i < count && i * stride < all; i++, found++) \
    values[found] = (double)((const type *)samples)[i * stride]
    CVOL_FOR_TYPE(grid->type, LOOK);
#undef LOOK
    qsort(values, found, sizeof *values, by_value);
    double best = values[0];
    for (size_t i = 0; i < found; i++) {
        run = i && values[i] <= values[i - 1] ? run + 1 : 1;
        if (run > most) {
            most = run;
            best = values[i];
        }
    }
    *share = (double)most / (double)found;
    return best;
}

/* Steps between neighbours: in edges exactly one of the two is background, in others neither is. */
typedef struct steps {
    double edge_squares, other_squares;
    uint64_t edges, others, apart, samples; /* apart: number of background samples */
} steps;

static void add_pair(steps *to, double a, double b, double background)
{
    const int of = (a == background) + (b == background);
    const double square = (a - b) * (a - b);
    to->edges += of == 1;
    to->edge_squares += of == 1 ? square : 0;
    to->others += of == 0;
    to->other_squares += of == 0 ? square : 0;
}

/* Adds one row of slice z: pairs within the row, with the next row and with the next slice. */
static void look_at_row(steps *to, const void *samples, const cvol_grid *grid, double background,
                        size_t y, size_t z)
{
    const size_t *dims = grid->dims, first = dims[0] * (y + dims[1] * z);
    const size_t down = y + 1 < dims[1] ? dims[0] : 0;
    const size_t behind = z + 1 < dims[2] ? dims[0] * dims[1] : 0;
#define LOOK(type)                                                        \
    {                                                                     \
        const type *row = (const type *)samples + first;                  \
        for (size_t x = 0; x < dims[0]; x++) {                            \
            const double value = (double)row[x];                          \
            to->apart += value == background;                             \
            if (x + 1 < dims[0])                                          \
                add_pair(to, value, (double)row[x + 1], background);      \
            if (down)                                                     \
                add_pair(to, value, (double)row[x + down], background);   \
            if (behind)                                                   \
                add_pair(to, value, (double)row[x + behind], background); \
        }                                                                 \
    }
    CVOL_FOR_TYPE(grid->type, LOOK)
#undef LOOK
    to->samples += dims[0];
}

static int is_worth_it(const steps *s)
{
    if (!s->edges || !s->others || (double)s->apart < SHARE_MIN * (double)s->samples)
        return 0;
    const double edge = s->edge_squares / (double)s->edges;
    const double other = s->other_squares / (double)s->others;
    return edge >= STEP_MIN * STEP_MIN * other &&
           (double)s->edges <= FACES_MAX * (double)s->samples;
}

static int find(cvol_context *context, double *value, double *least_step, int *found,
                const void *samples, const cvol_grid *grid)
{
    double *values = cvol_allocate(LOOKED_AT, sizeof *values), share;
    *found = 0;
    if (!values)
        return cvol_fail_memory(context, LOOKED_AT * sizeof *values, "the examined samples");
    *value = find_most(values, &share, samples, grid);
    free(values);
    if (!isfinite(*value) || share < SHARE_MIN / 2)
        return CVOL_OK;
    steps *of = cvol_allocate_zero(grid->dims[2], sizeof *of), all = {0};
    if (!of)
        return cvol_fail_memory(context, grid->dims[2] * sizeof *of, "the examined samples");
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = 0; z < grid->dims[2]; z++)
        for (size_t y = z % ROWS_BETWEEN; y < grid->dims[1]; y += ROWS_BETWEEN)
            look_at_row(&of[z], samples, grid, *value, y, z);
    for (size_t z = 0; z < grid->dims[2]; z++) {
        all.edge_squares += of[z].edge_squares;
        all.other_squares += of[z].other_squares;
        all.edges += of[z].edges;
        all.others += of[z].others;
        all.apart += of[z].apart;
        all.samples += of[z].samples;
    }
    free(of);
    *found = is_worth_it(&all);
    if (*found)
        *least_step = FINEST_SHARE * sqrt(all.other_squares / (double)all.others);
    return CVOL_OK;
}

int cvol_background_fills(cvol_context *context, cvol_fills *fills, double *least_step,
                          const void *samples, const cvol_grid *grid,
                          const cvol_compress_options *options)
{
    double value = options->background_value;
    int found = options->background == CVOL_BACKGROUND_VALUE, code = CVOL_OK;
    uint64_t bits;
    *least_step = 0;
    *fills = (cvol_fills){.background = 1};
    if (options->background == CVOL_BACKGROUND_FIND)
        code = find(context, &value, least_step, &found, samples, grid);
    if (code || !found)
        return code;
    if (!cvol_fills_of_value(&bits, grid->type, value))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s cannot hold the background %g",
                         cvol_type_name(grid->type), value);
    cvol_fills_add(fills, bits);
    return CVOL_OK;
}
