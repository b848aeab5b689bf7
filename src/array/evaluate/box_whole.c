/* A box of samples of a whole array: one inverse transform, or sums, whichever is cheaper.
 *
 * Sums run axis by axis through the terms in the order of their places
 * (array/evaluate/interpolant.h):
 *     line[x]     = sum_u g slot[u, v, w] phi_u(x)          for each row (v, w) that has terms
 *     plane[y, x] = sum_v phi_v(y) line[x]                  for each slice w that has terms
 *     a[x, y, z]  = Re sum_w phi_w(z) plane[y, x]
 * The low box and sparse terms are summed alike, in double precision, on one thread: sums are used
 * where they are cheap. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/box.h"
#include "array/evaluate/interpolant.h"
#include "array/truncate/candidates.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/fft.h"

/* The cost model, in multiply-adds: one value of phi, and per sample and octave a transform. */
#define WAVE_COST 60
#define TRANSFORM_COST 2.5
#define MAX_WAVES ((size_t)1 << 22)

/* phi_u at the box's coordinates along one axis. */
typedef struct axis_waves {
    cvol_transform transform;
    size_t n, begin, count;
    double *all; /* of every u; NULL: each is computed on demand, in `one` */
    double *one; /* count cosines, then count sines */
} axis_waves;

static void make_wave(double *out, const axis_waves *waves, size_t u)
{
    for (size_t i = 0; i < waves->count; i++) {
        double phi[2];
        cvol_axis_value(phi, waves->transform, u, (double)(waves->begin + i), waves->n);
        out[i] = phi[0];
        out[waves->count + i] = phi[1];
    }
}

static const double *wave_of(axis_waves *waves, size_t u)
{
    if (waves->all)
        return waves->all + 2 * waves->count * u;
    make_wave(waves->one, waves, u);
    return waves->one;
}

/* Returns 1 if a table of every u pays for `uses` of them. */
static int is_tabled(size_t n, size_t count, double uses)
{
    return uses >= (double)n && n <= MAX_WAVES / count;
}

static int start_waves(cvol_context *context, axis_waves *waves, const cvol_array *array, int axis,
                       size_t begin, size_t end, double uses)
{
    const size_t n = array->grid.dims[axis], count = end - begin;
    *waves = (axis_waves){.transform = array->transform, .n = n, .begin = begin, .count = count};
    waves->one = cvol_allocate(count, 2 * sizeof *waves->one);
    if (waves->one && is_tabled(n, count, uses)) {
        waves->all = cvol_allocate(n * count, 2 * sizeof *waves->all);
        for (size_t u = 0; waves->all && u < n; u++)
            make_wave(waves->all + 2 * count * u, waves, u);
    }
    if (!waves->one)
        return cvol_fail_memory(context, count * 2 * sizeof *waves->one, "waves along an axis");
    return CVOL_OK;
}

/* ---- sums ----------------------------------------------------------------------------------- */

/* to += (a + i b) from, arrays of `count` real parts, then `count` imaginary ones. */
static void add_line(double *to, const double *from, double a, double b, size_t count, int complex)
{
    if (!complex) {
        for (size_t x = 0; x < count; x++)
            to[x] += a * from[x];
        return;
    }
    for (size_t x = 0; x < count; x++) {
        to[x] += a * from[x] - b * from[count + x];
        to[count + x] += a * from[count + x] + b * from[x];
    }
}

typedef struct box_sum {
    const cvol_array *array;
    size_t size[3];
    axis_waves waves[3];
    int complex;
    double *line, *plane, *samples;
    size_t row, sheet; /* of the terms in line and plane; SIZE_MAX: none */
} box_sum;

static void finish_sheet(box_sum *sum)
{
    const size_t nx = sum->size[0], ny = sum->size[1], nz = sum->size[2];
    if (sum->sheet == SIZE_MAX)
        return;
    const double *wave = wave_of(&sum->waves[2], sum->sheet);
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++) {
            double *to = sum->samples + nx * (y + ny * z);
            const double *from = sum->plane + 2 * nx * y, a = wave[z], b = wave[nz + z];
            for (size_t x = 0; x < nx; x++)
                to[x] += sum->complex ? a * from[x] - b * from[nx + x] : a * from[x];
        }
    memset(sum->plane, 0, 2 * nx * ny * sizeof *sum->plane);
    sum->sheet = SIZE_MAX;
}

static void finish_row(box_sum *sum)
{
    const size_t nx = sum->size[0], ny = sum->size[1];
    if (sum->row == SIZE_MAX)
        return;
    const double *wave = wave_of(&sum->waves[1], sum->row % sum->array->grid.dims[1]);
    for (size_t y = 0; y < ny; y++)
        add_line(sum->plane + 2 * nx * y, sum->line, wave[y], wave[ny + y], nx, sum->complex);
    memset(sum->line, 0, 2 * nx * sizeof *sum->line);
    sum->row = SIZE_MAX;
}

static void add_term(box_sum *sum, const size_t place[3], float value)
{
    const size_t *dims = sum->array->grid.dims, row = place[1] + dims[1] * place[2];
    if (row != sum->row)
        finish_row(sum);
    if (place[2] != sum->sheet)
        finish_sheet(sum);
    sum->row = row;
    sum->sheet = place[2];
    double g[2];
    cvol_slot_factor(g, sum->array->transform, place, dims);
    add_line(sum->line, wave_of(&sum->waves[0], place[0]), g[0] * (double)value,
             g[1] * (double)value, sum->size[0], sum->complex);
}

static cvol_candidates terms_of(const cvol_spectrum *s)
{
    return (cvol_candidates){.slots = s->low_values,
                             .low = {s->low[0], s->low[1], s->low[2]},
                             .box = {s->box[0], s->box[1], s->box[2]},
                             .places = s->places,
                             .values = s->values,
                             .count = s->sparse_count};
}

/* Counts the rows and slices that have terms. */
static void count_rows(double counts[3], const cvol_array *array)
{
    const cvol_candidates c = terms_of(&array->whole);
    const size_t *dims = array->grid.dims;
    size_t last_row = SIZE_MAX, last_sheet = SIZE_MAX;
    cvol_run_cursor cursor = cvol_runs_start(&c, dims, 0, 1);
    cvol_run run;
    counts[0] = counts[1] = counts[2] = 0;
    while (cvol_runs_next(&cursor, &run, &c, dims)) {
        counts[0] += (double)run.count;
        for (size_t i = 0; i < (run.listed ? run.count : 1); i++) {
            const size_t row = (run.listed ? c.places[run.first + i] : run.place) / dims[0];
            counts[1] += row != last_row;
            counts[2] += row / dims[1] != last_sheet;
            last_row = row;
            last_sheet = row / dims[1];
        }
    }
}

static int sum_box(cvol_context *context, float *out, const cvol_array *array,
                   const size_t begin[3], const size_t end[3], const double counts[3])
{
    const cvol_candidates c = terms_of(&array->whole);
    const size_t *dims = array->grid.dims;
    box_sum sum = {.array = array,
                   .complex = array->transform != CVOL_DCT,
                   .row = SIZE_MAX,
                   .sheet = SIZE_MAX};
    size_t total = 1, done = 0;
    int code = CVOL_OK;
    for (int a = 0; a < 3; a++) {
        sum.size[a] = end[a] - begin[a];
        total *= sum.size[a];
    }
    for (int a = 0; a < 3 && !code; a++)
        code = start_waves(context, &sum.waves[a], array, a, begin[a], end[a], counts[a]);
    sum.line = cvol_allocate_zero(sum.size[0], 2 * sizeof(double));
    sum.plane = cvol_allocate_zero(sum.size[0] * sum.size[1], 2 * sizeof(double));
    sum.samples = cvol_allocate_zero(total, sizeof(double));
    if (!code && (!sum.line || !sum.plane || !sum.samples))
        code = cvol_fail_memory(context, total * sizeof(double), "a box of samples");
    cvol_run_cursor cursor = cvol_runs_start(&c, dims, 0, 1);
    cvol_run run;
    while (!code && cvol_runs_next(&cursor, &run, &c, dims)) {
        const float *values = (run.listed ? c.values : c.slots) + run.first;
        for (size_t i = 0; i < run.count; i++) {
            size_t place[3];
            cvol_place_split(place, run.listed ? c.places[run.first + i] : run.place + i, dims);
            add_term(&sum, place, values[i]);
        }
        done += run.count;
        code = cvol_report_progress(context, "evaluating", (double)done / counts[0]);
    }
    if (!code) {
        finish_row(&sum);
        finish_sheet(&sum);
        for (size_t i = 0; i < total; i++)
            out[i] = (float)sum.samples[i];
    }
    for (int a = 0; a < 3; a++) {
        free(sum.waves[a].all);
        free(sum.waves[a].one);
    }
    free(sum.line);
    free(sum.plane);
    free(sum.samples);
    return code;
}

/* ---- the transform -------------------------------------------------------------------------- */

static int transform_all(cvol_context *context, float *out, const cvol_array *array,
                         const size_t begin[3], const size_t end[3])
{
    const size_t *dims = array->grid.dims, samples = cvol_grid_samples(&array->grid);
    const size_t width = end[0] - begin[0], height = end[1] - begin[1];
    float *all = cvol_fft_allocate(samples);
    if (!all)
        return cvol_fail_memory(context, samples * sizeof *all, "all samples");
    int code = cvol_report_progress(context, "evaluating", 0);
    if (!code) {
        cvol_spectrum_scatter(all, &array->whole, dims);
        code = cvol_whole_inverse(context, array->transform, all, all, dims);
    }
    for (size_t z = begin[2]; z < end[2] && !code; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            memcpy(out + width * (y - begin[1] + height * (z - begin[2])),
                   all + begin[0] + dims[0] * (y + dims[1] * z), width * sizeof *out);
    free(all);
    return code ? code : cvol_report_progress(context, "evaluating", 1);
}

/* Multiply-adds of the sums. */
static double cost_of_sums(const cvol_array *array, const size_t begin[3], const size_t end[3],
                           const double counts[3])
{
    double cost = 0, inner = 1;
    for (int a = 0; a < 3; a++) {
        const size_t n = array->grid.dims[a], size = end[a] - begin[a];
        const double waves = is_tabled(n, size, counts[a]) ? (double)n : counts[a];
        inner *= (double)size;
        cost += (array->transform == CVOL_DCT ? 1 : 4) * counts[a] * inner +
                WAVE_COST * waves * (double)size;
    }
    return cost;
}

int cvol_whole_evaluate(cvol_context *context, float *out, const cvol_array *array,
                        const size_t begin[3], const size_t end[3])
{
    const double samples = (double)cvol_grid_samples(&array->grid);
    double counts[3];
    count_rows(counts, array);
    if (cost_of_sums(array, begin, end, counts) <
        TRANSFORM_COST * samples * (1 + cvol_log2(samples)))
        return sum_box(context, out, array, begin, end, counts);
    return transform_all(context, out, array, begin, end);
}
