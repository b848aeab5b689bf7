/* The interpolant of a whole array at chirp points, axis by axis (transform/chirp.h).
 *
 * Terms become complex amplitudes of signed frequencies within the spectrum's extent (for the sum
 * in array/evaluate/interpolant.h: slot times g; a frequency n / 2 becomes half at each end, which
 * is a cosine). For each frequency of z that has terms: chirps along x for the rows that have
 * terms, then along y; after all planes, along z. The functions of a DCT are the real parts of such
 * sums over u >= 0 with the period 2 n, from x + 1/2: the real part is taken after each axis. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/evaluate/interpolant.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "transform/chirp.h"
#include "transform/fft.h"

typedef struct chirp_axis {
    size_t n, extent, frequencies, count;
    cvol_chirp *chirp; /* NULL: frequency 0 alone */
} chirp_axis;

typedef struct chirp_run {
    const cvol_array *array;
    chirp_axis axes[3];
    int threads, real; /* real: DCT */
    float *plane;      /* amplitudes of one frequency of z: x, then y; pairs */
    float *columns;    /* the same after x: y fastest */
    float *planes;     /* all of them after y: x, y, then frequencies of z */
    uint8_t *used;     /* 1 if a row of the plane has terms */
    float *work;       /* of each thread: a line, then a chirp's scratch */
    size_t work_floats;
} chirp_run;

/* ---- the shape ---------------------------------------------------------------------------- */

static int prepare_axis(cvol_context *context, chirp_axis *axis, cvol_transform transform,
                        double start, double step)
{
    const int real = transform == CVOL_DCT;
    axis->frequencies = real ? axis->extent + 1 : 2 * axis->extent + 1;
    if (!axis->extent)
        return CVOL_OK;
    const cvol_chirp_shape shape = {.first = real ? 0 : -(int64_t)axis->extent,
                                    .frequencies = axis->frequencies,
                                    .start = real ? start + 0.5 : start,
                                    .step = step,
                                    .points = axis->count,
                                    .n = (double)axis->n * (real ? 2 : 1)};
    return cvol_chirp_create(context, &axis->chirp, &shape, 0);
}

static int product(size_t *out, size_t a, size_t b, size_t c)
{
    return cvol_size_multiply(out, a, b) && cvol_size_multiply(out, *out, c);
}

static int prepare(cvol_context *context, chirp_run *run, const double start[3],
                   const double step[3])
{
    size_t longest = 0, work = 0, plane, columns, planes;
    chirp_axis *axes = run->axes;
    for (int a = 0; a < 3; a++) {
        int code = prepare_axis(context, &axes[a], run->array->transform, start[a], step[a]);
        if (code)
            return code;
        longest = axes[a].count > longest ? axes[a].count : longest;
        if (axes[a].chirp && cvol_chirp_work(axes[a].chirp) > work)
            work = cvol_chirp_work(axes[a].chirp);
    }
    run->work_floats = (2 * longest + work + 15) / 16 * 16;
    if (!product(&plane, axes[0].frequencies, axes[1].frequencies, 2) ||
        !product(&columns, axes[0].count, axes[1].frequencies, 2) ||
        !product(&planes, axes[0].count, axes[1].count, axes[2].frequencies) ||
        !product(&planes, planes, 2, 1))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%zu x %zu x %zu chirp points are too many",
                         axes[0].count, axes[1].count, axes[2].count);
    run->plane = cvol_fft_allocate(plane);
    run->columns = cvol_fft_allocate(columns);
    run->planes = cvol_fft_allocate(planes);
    run->used = cvol_allocate(axes[1].frequencies, 1);
    run->work = cvol_allocate(run->work_floats, (size_t)run->threads * sizeof *run->work);
    if (run->plane && run->columns && run->planes && run->used && run->work)
        return CVOL_OK;
    return cvol_fail_memory(context, (plane + columns + planes) * sizeof(float),
                            "chirp transforms");
}

static void release(chirp_run *run)
{
    for (int a = 0; a < 3; a++)
        cvol_chirp_free(run->axes[a].chirp);
    free(run->plane);
    free(run->columns);
    free(run->planes);
    free(run->used);
    free(run->work);
}

/* ---- amplitudes of one plane ----------------------------------------------------------------- */

/* Finds the indices (one or two) of a place among the axis's frequencies. */
static int find_indices(size_t out[2], const chirp_axis *axis, size_t u, int real)
{
    if (real) {
        out[0] = u;
        return 1;
    }
    const size_t size = cvol_frequency(u, axis->n);
    out[0] = 2 * u <= axis->n ? axis->extent + size : axis->extent - size;
    out[1] = axis->extent - size;
    return u && 2 * u == axis->n ? 2 : 1;
}

static void add_term(chirp_run *run, float value, const size_t place[3])
{
    size_t x[2], y[2], z[2];
    double g[2];
    cvol_slot_factor(g, run->array->transform, place, run->array->grid.dims);
    const int nx = find_indices(x, &run->axes[0], place[0], run->real);
    const int ny = find_indices(y, &run->axes[1], place[1], run->real);
    const int nz = find_indices(z, &run->axes[2], place[2], run->real);
    const double share = (double)value / (nx * ny * nz);
    for (int j = 0; j < ny; j++) {
        run->used[y[j]] = 1;
        for (int i = 0; i < nx; i++) {
            float *at = run->plane + 2 * (x[i] + run->axes[0].frequencies * y[j]);
            at[0] += (float)(share * g[0]);
            at[1] += (float)(share * g[1]);
        }
    }
}

/* The first sparse term whose place is at least `place`. */
static size_t lower_bound(const cvol_spectrum *spectrum, uint64_t place)
{
    size_t begin = 0, end = spectrum->sparse_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (spectrum->places[middle] < place)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* Fills the plane of place w; 0 if it has no terms. */
static int fill_plane(chirp_run *run, size_t w)
{
    const cvol_spectrum *whole = &run->array->whole;
    const size_t *dims = run->array->grid.dims, *low = whole->low, *box = whole->box;
    const size_t begin = lower_bound(whole, (uint64_t)w * dims[0] * dims[1]);
    const size_t end = lower_bound(whole, (uint64_t)(w + 1) * dims[0] * dims[1]);
    const size_t k = whole->low_count ? cvol_box_index(w, low[2], box[2], dims[2]) : SIZE_MAX;
    if (begin == end && k == SIZE_MAX)
        return 0;
    memset(run->plane, 0,
           2 * run->axes[0].frequencies * run->axes[1].frequencies * sizeof *run->plane);
    memset(run->used, 0, run->axes[1].frequencies);
    if (k != SIZE_MAX) {
        const float *values = whole->low_values + box[0] * box[1] * k;
        for (size_t j = 0; j < box[1]; j++)
            for (size_t i = 0; i < box[0]; i++, values++) {
                const size_t place[3] = {cvol_box_place(i, low[0], box[0], dims[0]),
                                         cvol_box_place(j, low[1], box[1], dims[1]), w};
                if (*values != 0)
                    add_term(run, *values, place);
            }
    }
    for (size_t i = begin; i < end; i++) {
        size_t place[3];
        cvol_place_split(place, whole->places[i], dims);
        add_term(run, whole->values[i], place);
    }
    return 1;
}

/* ---- lines ---------------------------------------------------------------------------------- */

static int transform_line(const chirp_run *run, const chirp_axis *axis, float *out,
                          size_t out_stride, const float *in, size_t in_stride, float *work)
{
    int code = CVOL_OK;
    if (axis->chirp) {
        cvol_context own = {
            .threads = 1}; /* otherwise several threads would report errors to one context */
        code = cvol_chirp_apply(&own, axis->chirp, out, out_stride, in, in_stride, work);
    } else {
        const float re = in[0], im = in[1];
        for (size_t i = 0; i < axis->count; i++) {
            out[2 * out_stride * i] = re;
            out[2 * out_stride * i + 1] = im;
        }
    }
    if (run->real)
        for (size_t i = 0; i < axis->count; i++)
            out[2 * out_stride * i + 1] = 0;
    return code;
}

/* Transforms the plane along x and y, into plane `index` of run->planes. */
static int transform_plane(const chirp_run *run, size_t index)
{
    const chirp_axis *x = &run->axes[0], *y = &run->axes[1];
    const size_t rows = y->frequencies;
    float *planes = run->planes + 2 * x->count * y->count * index;
    int failures = 0;
    memset(run->columns, 0, 2 * x->count * rows * sizeof *run->columns);
#pragma omp parallel num_threads(run->threads) reduction(+ : failures)
    {
        float *work = run->work + run->work_floats * (size_t)cvol_thread_index();
#pragma omp for schedule(static)
        for (size_t j = 0; j < rows; j++)
            if (run->used[j])
                failures += 0 != transform_line(run, x, run->columns + 2 * j, rows,
                                                run->plane + 2 * x->frequencies * j, 1, work);
#pragma omp for schedule(static)
        for (size_t i = 0; i < x->count; i++)
            failures += 0 != transform_line(run, y, planes + 2 * i, x->count,
                                            run->columns + 2 * rows * i, 1, work);
    }
    return failures;
}

static int transform_z(const chirp_run *run, float *out)
{
    const chirp_axis *z = &run->axes[2];
    const size_t area = run->axes[0].count * run->axes[1].count;
    int failures = 0;
#pragma omp parallel num_threads(run->threads) reduction(+ : failures)
    {
        float *work = run->work + run->work_floats * (size_t)cvol_thread_index();
        float *line = work + run->work_floats - 2 * z->count;
#pragma omp for schedule(static)
        for (size_t i = 0; i < area; i++) {
            failures += 0 != transform_line(run, z, line, 1, run->planes + 2 * i, area, work);
            for (size_t k = 0; k < z->count; k++)
                out[i + area * k] = line[2 * k];
        }
    }
    return failures;
}

static int transform_all(cvol_context *context, chirp_run *run, float *out)
{
    const chirp_axis *z = &run->axes[2];
    const size_t area = run->axes[0].count * run->axes[1].count;
    memset(run->planes, 0, 2 * area * z->frequencies * sizeof *run->planes);
    int failures = 0;
    for (size_t i = 0; i < z->frequencies; i++) {
        /* index i is frequency i - extent; both ends of n / 2 are place n / 2 */
        const size_t w = run->real || i >= z->extent ? i - (run->real ? 0 : z->extent)
                                                     : z->n - (z->extent - i);
        if (fill_plane(run, w))
            failures += transform_plane(run, i);
        int code = cvol_report_progress(context, "evaluating",
                                        0.9 * (double)(i + 1) / (double)z->frequencies);
        if (code)
            return code;
    }
    failures += transform_z(run, out);
    return failures ? cvol_fail(context, CVOL_ERROR_MEMORY, "no memory for chirp transforms")
                    : CVOL_OK;
}

int cvol_array_evaluate_chirp(cvol_context *context, float *out, const cvol_array *array,
                              const double start[3], const double step[3], const size_t count[3])
{
    if (array->block)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "an array in blocks of %d cannot be evaluated at chirp points; that takes "
                         "a whole array (block 0), or evaluate points",
                         array->block);
    size_t extent[3];
    chirp_run run = {.array = array,
                     .threads = cvol_context_threads(context),
                     .real = array->transform == CVOL_DCT};
    cvol_spectrum_extent(extent, &array->whole, array->transform, array->grid.dims);
    for (int a = 0; a < 3; a++) {
        if (!count[a] || !isfinite(start[a]) || !isfinite(step[a]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "axis %c has %zu chirp points from %g by %g; there must be at least "
                             "one, and the numbers finite",
                             "xyz"[a], count[a], start[a], step[a]);
        run.axes[a] = (chirp_axis){
            .n = array->grid.dims[a], .extent = extent[a], .count = count[a]};
    }
    int code = prepare(context, &run, start, step);
    if (!code)
        code = transform_all(context, &run, out);
    release(&run);
    return code;
}
