/* Parts of a volume (parts.h): each box is divided across its longest axis, where the matter before
 * the plane is the share of the ranks that get it. Matter is counted in cells of 2 samples and
 * more: what the cell hides, and a little for its volume, so that empty parts are not too large. */
#include "mpi/parts.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/light/extinction.h"
#include "render/sheet/coarse_level.h"

/* The weight of an empty cell, as a share of the mean. */
#define EMPTY 0.1
/* Planes lie this much aside of the faces of cells, in cells. At the faces, middles between two
 * slices would lie on planes, and rounding would decide whose they are. */
#define ASIDE 0.00317

typedef struct division {
    cvol_mpi_parts *parts;
    const cvol_coarse *coarse;
    float *weights; /* of cells */
    double *sums;   /* room for one axis */
} division;

static void weigh_cells(float *weights, const cvol_coarse *coarse)
{
    const size_t count = cvol_coarse_count(coarse);
    const float length = (float)((coarse->length[0] + coarse->length[1] + coarse->length[2]) / 3);
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        weights[i] = 1 - expf(-length * weights[i]);
        sum += (double)weights[i];
    }
    const float empty = sum > 0 ? (float)(EMPTY * sum / (double)count) : 1;
    for (size_t i = 0; i < count; i++)
        weights[i] += empty;
}

/* Cells of a box: first[a] to end[a]. */
typedef struct cell_box {
    size_t first[3], end[3];
} cell_box;

/* Sums the weights of each layer of cells across an axis. */
static double sum_layers(const division *d, const cell_box *box, int axis)
{
    const size_t *n = d->coarse->dims;
    double all = 0;
    for (size_t k = 0; k < n[axis]; k++)
        d->sums[k] = 0;
    for (size_t z = box->first[2]; z < box->end[2]; z++)
        for (size_t y = box->first[1]; y < box->end[1]; y++)
            for (size_t x = box->first[0]; x < box->end[0]; x++) {
                const double w = (double)d->weights[x + n[0] * (y + n[1] * z)];
                d->sums[axis == 0 ? x : axis == 1 ? y : z] += w;
                all += w;
            }
    return all;
}

static int longest_axis(const division *d, const cell_box *box)
{
    int axis = 0;
    double most = 0;
    for (int a = 0; a < 3; a++) {
        const double length = (double)(box->end[a] - box->first[a]) * d->coarse->length[a];
        if (box->end[a] - box->first[a] > 1 && length > most) {
            most = length;
            axis = a;
        }
    }
    return most > 0 ? axis : -1;
}

/* The layer of cells before which a share of the weight lies: at least one on either side. */
static size_t find_layer(const division *d, const cell_box *box, int axis, double wanted)
{
    double sum = 0;
    for (size_t k = box->first[axis]; k + 1 < box->end[axis]; k++) {
        sum += d->sums[k];
        if (sum >= wanted)
            return k + 1;
    }
    return box->end[axis] - 1;
}

/* Divides a box between `count` ranks from `first` on. Returns the number of its node; -1: fewer
 * cells than ranks. */
static int divide(division *d, cell_box box, cvol_part part, int first, int count)
{
    cvol_mpi_parts *parts = d->parts;
    const int number = parts->count++;
    if (count == 1) {
        parts->boxes[first] = part;
        parts->nodes[number] = (cvol_mpi_node){.axis = -1, .below = first, .above = first};
        return number;
    }
    const int axis = longest_axis(d, &box), half = count / 2;
    if (axis < 0)
        return -1;
    const double all = sum_layers(d, &box, axis);
    const size_t layer = find_layer(d, &box, axis, all * half / count);
    const double at = d->coarse->first[axis] +
                      ((double)layer - 0.5 + ASIDE) * d->coarse->pitch[axis];
    cell_box boxes[2] = {box, box};
    cvol_part both[2] = {part, part};
    boxes[0].end[axis] = boxes[1].first[axis] = layer;
    both[0].to[axis] = both[1].from[axis] = at;
    const int below = divide(d, boxes[0], both[0], first, half),
              above = below < 0 ? -1 : divide(d, boxes[1], both[1], first + half, count - half);
    parts->nodes[number] = (cvol_mpi_node){axis, at, below, above};
    return above < 0 ? -1 : number;
}

static int divide_all(cvol_context *context, division *d)
{
    cvol_mpi_parts *parts = d->parts;
    cell_box box = {.first = {0, 0, 0}};
    cvol_part part = {.axes = 7};
    for (int a = 0; a < 3; a++) {
        box.end[a] = d->coarse->dims[a];
        part.from[a] = -1;
        part.to[a] = (double)parts->grid.dims[a];
    }
    if (divide(d, box, part, 0, parts->size) < 0)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%d processes are more than a volume of %zu x %zu x %zu samples has parts",
                         parts->size, parts->grid.dims[0], parts->grid.dims[1],
                         parts->grid.dims[2]);
    return CVOL_OK;
}

static int find_parts(cvol_context *context, cvol_mpi_parts *parts, const cvol_array *array,
                      const cvol_transfer *transfer, const cvol_render_options *options)
{
    cvol_coarse coarse = {.values = NULL};
    division d = {parts, &coarse, NULL, NULL};
    int code = cvol_coarse_of_array(context, &coarse, array);
    if (code)
        return code;
    const size_t count = cvol_coarse_count(&coarse),
                 most = coarse.dims[0] + coarse.dims[1] + coarse.dims[2];
    d.weights = cvol_allocate(count, sizeof *d.weights);
    d.sums = cvol_allocate(most, sizeof *d.sums);
    if (!d.weights || !d.sums)
        code = cvol_fail_memory(context, count * sizeof *d.weights, "the parts of a volume");
    if (!code)
        code = cvol_extinction_find(context, d.weights, &coarse, &parts->grid, transfer, options);
    if (!code) {
        weigh_cells(d.weights, &coarse);
        code = divide_all(context, &d);
    }
    free(d.weights);
    free(d.sums);
    cvol_coarse_free(&coarse);
    return code;
}

static int make(cvol_context *context, cvol_mpi_parts **out, const cvol_array *array,
                const cvol_transfer *transfer, const cvol_render_options *options, MPI_Comm comm)
{
    cvol_mpi_parts *parts = calloc(1, sizeof *parts);
    if (!parts)
        return cvol_fail_memory(context, sizeof *parts, "the parts of a volume");
    *out = parts;
    parts->comm = MPI_COMM_NULL;
    parts->grid = *cvol_array_grid(array);
    MPI_Comm_size(comm, &parts->size);
    MPI_Comm_rank(comm, &parts->rank);
    parts->nodes = cvol_allocate(2 * (size_t)parts->size, sizeof *parts->nodes);
    parts->boxes = cvol_allocate((size_t)parts->size, sizeof *parts->boxes);
    if (!parts->nodes || !parts->boxes)
        return cvol_fail_memory(context, 2 * (size_t)parts->size * sizeof *parts->nodes,
                                "the parts of a volume");
    return find_parts(context, parts, array, transfer, options);
}

int cvol_mpi_parts_create(cvol_context *context, cvol_mpi_parts **out, const cvol_array *array,
                          const cvol_transfer *transfer, const cvol_render_options *options,
                          MPI_Comm comm)
{
    int rank;
    *out = NULL;
    const int code = cvol_mpi_agree(context, make(context, out, array, transfer, options, comm),
                                    &rank, comm);
    if (code) {
        cvol_mpi_parts_free(*out);
        *out = NULL;
    } else {
        MPI_Comm_dup(comm, &(*out)->comm);
    }
    return code;
}

int cvol_mpi_level(const cvol_grid *grid)
{
    /* The means of cells, also next to faces of blocks. Files have levels up to 3. */
    const int level = cvol_coarse_level(grid) - 1;
    return level < 3 ? level : 3;
}

void cvol_mpi_parts_free_memory(cvol_mpi_parts *parts)
{
    free(parts->memory.runs.bytes);
    free(parts->memory.values.bytes);
    free(parts->memory.sent.bytes);
    free(parts->memory.received.bytes);
}

void cvol_mpi_parts_free(cvol_mpi_parts *parts)
{
    if (!parts)
        return;
    if (parts->comm != MPI_COMM_NULL)
        MPI_Comm_free(&parts->comm);
    free(parts->nodes);
    free(parts->boxes);
    cvol_mpi_parts_free_memory(parts);
    free(parts);
}

cvol_part cvol_mpi_part(const cvol_mpi_parts *parts, int rank)
{
    return rank >= 0 && rank < parts->size ? parts->boxes[rank] : (cvol_part){.axes = 0};
}
