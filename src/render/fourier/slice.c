/* From a spectrum to sums along rays: the Fourier slice theorem.
 *
 * The integral of f along the eye's direction has the transform
 *
 *     P(x, y) = sum over the slice of F(xi right + eta up) exp(2 pi i (xi x + eta y)) d xi d eta,
 *
 * so a view is a plane of frequencies and one transform of rank 2, O(N^2 log N) (Dunne, Napel and
 * Rutt 1990; Malzbender 1993). f is linear between samples, as in engine ray, so frequencies of
 * axis a are multiplied by sinc^2. Only frequencies up to half a cycle per sample are used. The
 * lattice of the slice is periodic, with a period no shorter than the volume's shadow. A second
 * slice is that of the volume's box of ones, which needs no samples. It is the divisor of a ray's
 * sum, and is blurred like the sums, so the quotient is right up to the shadow's edge.
 *
 * The slice is made column by column (one xi, all eta), each transformed along eta while it is in
 * the cache; then rows along x. Each number is computed separately, so the bits do not depend on
 * the number of threads. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/fourier/spectrum.h"
#include "transform/fft.h"

#define PI 3.14159265358979323846
/* The highest frequency used, in cycles per sample. */
#define HIGHEST 0.5
/* Rows that are transformed together. */
#define BATCH ((size_t)8)

/* ---- memory ---------------------------------------------------------------------------------- */

static void free_planes(cvol_fourier_planes *planes)
{
    for (int k = 0; k < 2; k++) {
        free(planes->columns[k]);
        planes->columns[k] = NULL;
    }
    free(planes->sums);
    free(planes->weights);
    planes->sums = planes->weights = NULL;
    planes->room[0] = planes->room[1] = 0;
}

static int planes_prepare(cvol_context *context, cvol_fourier_planes *planes)
{
    const size_t *n = planes->slice_grid.dims;
    planes->column_stride = n[1] + BATCH; /* not a power of two */
    const size_t columns = 2 * (n[0] / 2 + 1) * planes->column_stride, points = n[0] * n[1];
    if (planes->room[0] < columns || planes->room[1] < points) {
        free_planes(planes);
        for (int k = 0; k < 2; k++)
            planes->columns[k] = cvol_fft_allocate(columns);
        planes->sums = cvol_fft_allocate(points);
        planes->weights = cvol_fft_allocate(points);
        if (!planes->columns[0] || !planes->columns[1] || !planes->sums || !planes->weights) {
            free_planes(planes);
            return cvol_fail_memory(context, 4 * (columns + points) * 2, "a slice");
        }
        planes->room[0] = columns;
        planes->room[1] = points;
    }
    return CVOL_OK;
}

void cvol_fourier_planes_free(cvol_fourier_planes *planes)
{
    free_planes(planes);
    cvol_fourier_pages_free(&planes->samples);
    cvol_fourier_pages_free(&planes->cover);
}

/* ---- one column of the slice ----------------------------------------------------------------- */

/* The common data of all columns. */
typedef struct slice_job {
    const cvol_fourier_volume *volume;
    const cvol_fourier_kernel *kernel;
    cvol_fourier_planes *planes;
    const cvol_grid *grid;
    double step[2][3];    /* cycles per sample of axis a for one step along xi and eta */
    double turn[2][2];    /* turns for one step along xi and eta: of sums, of the box */
    double scale;         /* of sums: a sample's volume over the lattice's area */
    float *table;         /* turns of eta: cosines and sines, of sums and of the box */
    float near, slope[3]; /* of cvol_fourier_line */
    int cued;
} slice_job;

/* Memory of one thread: six lines. */
typedef struct thread_lines {
    float *re, *im, *filter, *box, *cover_re, *cover_im;
} thread_lines;

static size_t line_room(const slice_job *job)
{
    return job->planes->slice_grid.dims[1] + 2 * CVOL_FOURIER_RUN;
}

/* Finds the steps of eta within the used frequencies: first .. last; 0 if there are none. */
static int find_range(ptrdiff_t *first, ptrdiff_t *last, const slice_job *job, size_t column)
{
    const double most = (double)job->planes->slice_grid.dims[1] / 2 - 1;
    double lo = -most, hi = most;
    for (int a = 0; a < 3; a++) {
        const double start = (double)column * job->step[0][a], step = job->step[1][a];
        if (fabs(step) < 1e-12) {
            if (fabs(start) > HIGHEST)
                return 0;
            continue;
        }
        const double p = (-HIGHEST - start) / step, q = (HIGHEST - start) / step;
        lo = fmax(lo, fmin(p, q));
        hi = fmin(hi, fmax(p, q));
    }
    *first = (ptrdiff_t)ceil(lo);
    *last = (ptrdiff_t)floor(hi);
    return *first <= *last;
}

static void gather(const slice_job *job, const cvol_fourier_spectrum *spectrum,
                   const cvol_fourier_pages *pages, float *re, float *im, size_t column,
                   ptrdiff_t first, size_t count, int cued)
{
    cvol_fourier_line line = {.spectrum = spectrum,
                              .pages = spectrum->bricks.all ? pages : NULL,
                              .kernel = job->kernel,
                              .near = job->near,
                              .cued = cued,
                              .count = count};
    for (int a = 0; a < 3; a++) {
        const double N = (double)spectrum->dims[a];
        line.step[a] = N * job->step[1][a];
        line.start[a] = N * ((double)column * job->step[0][a] + (double)first * job->step[1][a]);
        line.slope[a] = job->slope[a];
    }
    CVOL_SIMD_CHOOSE(cvol_fourier_gather)(re, im, &line);
}

static void weigh(const slice_job *job, const thread_lines *of, size_t column, ptrdiff_t first,
                  size_t count)
{
    cvol_fourier_filter filter = {.count = count};
    for (int a = 0; a < 3; a++) {
        const size_t n = job->grid->dims[a];
        filter.step[a] = job->step[1][a];
        filter.start[a] = (double)column * job->step[0][a] + (double)first * job->step[1][a];
        filter.power[a] = n > 1 ? 2 : 1;
        filter.intervals[a] = (double)(n - 1);
        filter.length[a] = n > 1 ? (double)(n - 1) : 1;
    }
    CVOL_SIMD_CHOOSE(cvol_fourier_weigh)(of->filter, of->box, &filter);
}

/* A column's own factor, times the table of rotations by eta. */
typedef struct phases {
    const float *c, *s; /* from eta 0 of the table on, negative ones before it */
    float column_c, column_s;
} phases;

static phases phases_of(const slice_job *job, int which, size_t column, double scale)
{
    const double angle = 2 * PI * fmod((double)column * job->turn[which][0], 1);
    const size_t rows = job->planes->slice_grid.dims[1];
    const float *table = job->table + 2 * (size_t)which * rows + rows / 2;
    return (phases){table, table + rows, (float)(scale * cos(angle)), (float)(scale * sin(angle))};
}

/* out = factor (re + i im) turned; im and factor may be NULL. */
static void put_run(float *restrict out, const float *restrict re, const float *restrict im,
                    const float *restrict factor, const float *restrict c, const float *restrict s,
                    const phases *by, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        const float scale = factor ? factor[k] : 1, i = im ? im[k] : 0;
        const float wc = scale * (c[k] * by->column_c - s[k] * by->column_s);
        const float ws = scale * (c[k] * by->column_s + s[k] * by->column_c);
        out[2 * k] = re[k] * wc - i * ws;
        out[2 * k + 1] = re[k] * ws + i * wc;
    }
}

/* Negative steps of eta lie at the column's end. */
static void put(float *column, size_t rows, const float *re, const float *im, const float *factor,
                ptrdiff_t first, size_t count, const phases *by)
{
    const size_t below = first >= 0 ? 0 : (size_t)-first < count ? (size_t)-first : count;
    if (below)
        put_run(column + 2 * ((ptrdiff_t)rows + first), re, im, factor, by->c + first,
                by->s + first, by, below);
    const ptrdiff_t from = first + (ptrdiff_t)below;
    if (below < count)
        put_run(column + 2 * from, re + below, im ? im + below : NULL,
                factor ? factor + below : NULL, by->c + from, by->s + from, by, count - below);
}

/* Tabulates the rotation of sums and the box per step of eta, and the attenuation by interpolation
 * of pixels. */
static int tabulate(cvol_context *context, slice_job *job)
{
    const size_t rows = job->planes->slice_grid.dims[1];
    job->table = cvol_allocate(4 * rows, sizeof *job->table);
    if (!job->table)
        return cvol_fail_memory(context, 4 * rows * sizeof *job->table, "a table of phases");
    for (int which = 0; which < 2; which++)
        for (size_t k = 0; k < rows; k++) {
            const double eta = (double)k - (double)(rows / 2);
            const double angle = 2 * PI * fmod(eta * job->turn[which][1], 1);
            const double gain = job->planes->slice_grid.aligned
                                    ? 1
                                    : cvol_fourier_kernel_gain(eta / (double)rows);
            job->table[2 * (size_t)which * rows + k] = (float)(cos(angle) / gain);
            job->table[(2 * (size_t)which + 1) * rows + k] = (float)(sin(angle) / gain);
        }
    return CVOL_OK;
}

static int make_column(cvol_context *context, const slice_job *job, const thread_lines *of,
                       size_t column)
{
    cvol_fourier_planes *planes = job->planes;
    const size_t rows = planes->slice_grid.dims[1];
    float *out[2];
    ptrdiff_t first, last;
    for (int k = 0; k < 2; k++) {
        out[k] = planes->columns[k] + 2 * column * planes->column_stride;
        memset(out[k], 0, 2 * rows * sizeof(float));
    }
    /* the highest frequency of even lengths has no phase */
    if (2 * column == planes->slice_grid.dims[0] || !find_range(&first, &last, job, column))
        return CVOL_OK;
    const size_t count = (size_t)(last - first + 1);
    gather(job, &job->volume->samples, &planes->samples, of->re, of->im, column, first, count,
           job->cued);
    weigh(job, of, column, first, count);
    double scale = job->scale;
    if (!planes->slice_grid.aligned)
        scale /= cvol_fourier_kernel_gain((double)column / (double)planes->slice_grid.dims[0]);
    const phases of_sums = phases_of(job, 0, column, scale),
                 of_box = phases_of(job, 1, column, scale);
    put(out[0], rows, of->re, of->im, of->filter, first, count, &of_sums);
    if (job->volume->masked) {
        gather(job, &job->volume->cover, &planes->cover, of->cover_re, of->cover_im, column, first,
               count, 0);
        put(out[1], rows, of->cover_re, of->cover_im, of->filter, first, count, &of_sums);
    } else {
        put(out[1], rows, of->box, NULL, NULL, first, count, &of_box);
    }
    const cvol_fft_lines lines = {rows, 1, 1, rows, 1, rows};
    int code = CVOL_OK;
    for (int k = 0; k < 2 && !code; k++)
        code = cvol_fft_along(context, CVOL_FFT_COMPLEX_BACKWARD, &lines, out[k], out[k]);
    return code;
}

static int make_columns(cvol_context *context, const slice_job *job)
{
    const size_t columns = job->planes->slice_grid.dims[0] / 2 + 1;
    const size_t room = (line_room(job) + 15) / 16 * 16;
    int code = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_context quiet = *context;
        float *all = cvol_allocate(6 * room, sizeof *all);
        const thread_lines of = {
            all, all + room, all + 2 * room, all + 3 * room, all + 4 * room, all + 5 * room};
#pragma omp for schedule(dynamic, 4)
        for (size_t column = 0; column < columns; column++) {
            const int failed = all ? make_column(&quiet, job, &of, column) : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        free(all);
    }
    return code ? cvol_fail_memory(context, 6 * room * sizeof(float), "a line of a slice")
                : CVOL_OK;
}

/* ---- along x --------------------------------------------------------------------------------- */

static int make_rows(cvol_context *context, cvol_fourier_planes *planes)
{
    const size_t *n = planes->slice_grid.dims, batches = (n[1] + BATCH - 1) / BATCH;
    int code = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_context quiet = *context;
#pragma omp for schedule(static)
        for (size_t i = 0; i < 2 * batches; i++) {
            const size_t row = i / 2 * BATCH;
            const cvol_fft_lines lines = {.n = n[0],
                                          .count = n[1] - row < BATCH ? n[1] - row : BATCH,
                                          .in_stride = planes->column_stride,
                                          .in_distance = 1,
                                          .out_stride = 1,
                                          .out_distance = n[0]};
            const int failed = cvol_fft_along(&quiet, CVOL_FFT_INVERSE, &lines,
                                              (i % 2 ? planes->weights : planes->sums) + row * n[0],
                                              planes->columns[i % 2] + 2 * row);
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
    }
    return code ? cvol_fail_memory(context, n[0] * sizeof(float), "a row of a slice") : CVOL_OK;
}

/* Loads the bricks that a slice passes through, for spectra in bricks. */
static int load_pages(cvol_context *context, const slice_job *job, const cvol_view *view)
{
    double normal[3];
    for (int a = 0; a < 3; a++)
        normal[a] = view->eye[a] / (job->grid->spacing[a] * (double)job->volume->samples.dims[a]);
    int code = CVOL_OK;
    if (job->volume->samples.bricks.all)
        code = cvol_fourier_pages_load(context, &job->planes->samples, &job->volume->samples,
                                       normal);
    if (!code && job->volume->cover.bricks.all)
        code = cvol_fourier_pages_load(context, &job->planes->cover, &job->volume->cover, normal);
    return code;
}

int cvol_fourier_project(cvol_context *context, cvol_fourier_planes *planes,
                         const cvol_fourier_volume *volume, const cvol_grid *grid,
                         const cvol_view *view, const cvol_fourier_depth_cue *cue,
                         const cvol_fourier_kernel *kernel)
{
    cvol_fourier_slice_grid_make(&planes->slice_grid, grid, view);
    int code = planes_prepare(context, planes);
    if (code)
        return code;
    const cvol_fourier_slice_grid *slice_grid = &planes->slice_grid;
    slice_job job = {.volume = volume, .kernel = kernel, .planes = planes, .grid = grid};
    job.scale = 1;
    double middle = 0; /* of samples, in front of index n / 2 */
    for (int a = 0; a < 3; a++)
        job.scale *= grid->spacing[a];
    for (int d = 0; d < 2; d++) {
        const double *along = d ? view->up : view->right, length = (double)slice_grid->dims[d];
        const double period = length * slice_grid->space;
        job.scale /= period;
        job.turn[1][d] = -slice_grid->shift[d] / length;
        job.turn[0][d] = job.turn[1][d];
        for (int a = 0; a < 3; a++) {
            const double off = (double)(grid->dims[a] - 1) / 2 - (double)(grid->dims[a] / 2);
            job.step[d][a] = along[a] * grid->spacing[a] / period;
            job.turn[0][d] += off * job.step[d][a];
        }
    }
    for (int a = 0; a < 3; a++) {
        const double off = (double)(grid->dims[a] - 1) / 2 - (double)(grid->dims[a] / 2);
        middle += off * view->eye[a] * grid->spacing[a];
        /* multiplication by a place is i / 2 pi times the derivative */
        job.slope[a] = (float)(cue->slope / (2 * PI) * view->eye[a] * grid->spacing[a] *
                               (double)volume->samples.dims[a]);
    }
    job.near = (float)(cue->near - cue->slope * middle);
    job.cued = cue->slope > 0 || cue->slope < 0;
    code = load_pages(context, &job, view);
    if (!code)
        code = tabulate(context, &job);
    if (!code)
        code = make_columns(context, &job);
    free(job.table);
    return code ? code : make_rows(context, planes);
}
