/* Bands of a picture (band.h): the samples that reach them, and their working memory. */
#include "render/splat/band.h"

#include <limits.h>
#include <math.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"

/* A band's sheet and picture fit into the second-level cache. */
#define BAND_BYTES (1 << 19)
#define BAND_ROWS_MIN 16
#define BANDS_MIN 16 /* for up to 8 threads, two each */
/* Slices between two checks for hidden cells, and samples that are skipped together. */
#define HIDDEN_SLICES 8
#define HIDDEN_SAMPLES 32

/* The lattice of slice 0 in pixels: (u, v) of a pixel (x, y) solve origin + u along[0] + v along[1]
 * = (x, y). */
static void set_gain(cvol_splat_gain *out, const cvol_footprint_gain *gain,
                     const cvol_splat_plan *plan, size_t slice)
{
    const double *a = plan->along[0], *b = plan->along[1];
    const double determinant = a[0] * b[1] - a[1] * b[0];
    const double x = -plan->origin[0] - (double)slice * plan->along[2][0];
    const double y = -plan->origin[1] - (double)slice * plan->along[2][1];
    out->gain = gain;
    out->step_x[0] = b[1] / determinant;
    out->step_y[0] = -b[0] / determinant;
    out->step_x[1] = -a[1] / determinant;
    out->step_y[1] = a[0] / determinant;
    for (int k = 0; k < 2; k++)
        out->at[k] = x * out->step_x[k] + y * out->step_y[k];
}

/* ---- bands ------------------------------------------------------------------------------- */

/* Cuts *from .. *to, numbers of samples, to those for which start + number step lies within lo ..
 * hi. */
static void cut(double *from, double *to, double start, double step, double lo, double hi)
{
    if (fabs(step) < 1e-9) {
        if (start < lo - 1 || start > hi + 1)
            *to = *from - 1;
        return;
    }
    double p = (lo - start) / step, q = (hi - start) / step;
    *from = fmax(*from, floor(fmin(p, q)));
    *to = fmin(*to, ceil(fmax(p, q)));
}

static cvol_splat_row row_at(const cvol_splat_job *job, size_t place, size_t row)
{
    const size_t stride = job->slab->row_stride;
    const float *samples = cvol_splat_slab_at(job->slab, place) + row * stride;
    const size_t slice = job->slab->slice_stride;
    return (cvol_splat_row){samples, row > 0 ? samples - stride : samples,
                            row + 1 < job->plan->rows ? samples + stride : samples,
                            place > 0 ? samples - slice : samples,
                            place + 1 < job->plan->slices ? samples + slice : samples};
}

/* One row of a slice: sample 0 at `start`, the next ones at steps from it. */
typedef struct row_run {
    cvol_splat_row samples;
    double start[2];
    const double *step;
} row_run;

static void add_run(const cvol_splat_job *job, const cvol_splat_band *band,
                    cvol_splat_memory *memory, const row_run *row, int begin, int end)
{
    CVOL_SIMD_CHOOSE(cvol_splat_list_make)
    (&memory->list, &row->samples, begin, end, job->table, job->light);
    if (memory->list.count <= 0)
        return;
    const uint64_t rows = CVOL_SIMD_CHOOSE(cvol_splat_add)(band, job->footprint, &memory->list,
                                                           row->start, row->step);
    memory->multiply_adds += rows * CVOL_SPLAT_CHANNELS * (uint64_t)(job->footprint->width + 1);
}

/* Adds samples begin .. end - 1 of a row, without the hidden ones. */
static void add_row(const cvol_splat_job *job, const cvol_splat_band *band,
                    const cvol_splat_hidden *hidden, cvol_splat_memory *memory, const row_run *row,
                    int begin, int end)
{
    int seen = begin; /* samples from here on have not been added */
    for (int at = begin; hidden->some && at < end; at += HIDDEN_SAMPLES) {
        const int next = at + HIDDEN_SAMPLES < end ? at + HIDDEN_SAMPLES : end;
        const double *start = row->start, *step = row->step;
        if (!cvol_splat_is_hidden(hidden, band, start[0] + at * step[0], start[1] + at * step[1],
                                  start[0] + (next - 1) * step[0], start[1] + (next - 1) * step[1]))
            continue;
        if (seen < at)
            add_run(job, band, memory, row, seen, at);
        seen = next;
    }
    if (seen < end)
        add_run(job, band, memory, row, seen, end);
}

/* Adds a slice to a band's sheet. */
static void add_slice(const cvol_splat_job *job, const cvol_splat_band *band,
                      const cvol_splat_hidden *hidden, cvol_splat_memory *memory, size_t place,
                      size_t slice)
{
    const cvol_splat_plan *plan = job->plan;
    const double(*along)[2] = plan->along;
    const double reach[2] = {job->footprint->width / 2.0 + 2 + cvol_footprint_slant(job->footprint),
                             job->footprint->height / 2.0 + 2};
    const double lo[2] = {-reach[0], band->begin - reach[1]};
    const double hi[2] = {job->width + reach[0], band->end + reach[1]};
    double origin[2], row_from = 0, row_to = (double)plan->rows - 1;
    for (int k = 0; k < 2; k++) {
        origin[k] = plan->origin[k] + (double)slice * along[2][k];
        /* rows with samples that may lie within */
        const double drift = along[0][k] * (double)(plan->lanes - 1);
        cut(&row_from, &row_to, origin[k], along[1][k], lo[k] - fmax(drift, 0),
            hi[k] - fmin(drift, 0));
    }
    for (double row = row_from; row <= row_to; row++) {
        double from = 0, to = (double)plan->lanes - 1;
        row_run run = {.step = along[0]};
        for (int k = 0; k < 2; k++) {
            run.start[k] = origin[k] + row * along[1][k];
            cut(&from, &to, run.start[k], along[0][k], lo[k], hi[k]);
        }
        if (!(from <= to))
            continue;
        run.samples = row_at(job, place, (size_t)row);
        add_row(job, band, hidden, memory, &run, (int)from, (int)to + 1);
    }
}

/* The number of composited pixels of a sheet. */
static uint64_t count_pixels(const cvol_splat_band *band)
{
    uint64_t pixels = 0;
    for (int y = 0; y < band->end - band->begin; y++) {
        const int *span = band->spans[y];
        pixels += span[0] < span[1] ? (uint64_t)(span[1] - span[0]) : 0;
    }
    return pixels;
}

/* Draws places begin .. end - 1 in the order of slices, for one band. */
static void draw_band(const cvol_splat_job *job, cvol_splat_memory *memory, int number,
                      size_t begin, size_t end)
{
    const int first = number * job->band_rows;
    const int last = first + job->band_rows < job->height ? first + job->band_rows : job->height;
    const cvol_splat_band band = {.begin = first,
                                  .end = last,
                                  .width = job->width,
                                  .margin = job->margin,
                                  .row_stride = job->row_stride,
                                  .sheet = memory->sheet,
                                  .image = job->image + (size_t)first * job->row_stride,
                                  .spans = memory->spans};
    cvol_splat_hidden *hidden = &job->hidden[number];
    for (size_t place = begin; place < end && !hidden->all; place++) {
        const size_t slice = job->ascending ? place : job->plan->slices - 1 - place;
        add_slice(job, &band, hidden, memory, place, slice);
        memory->multiply_adds += CVOL_SPLAT_CHANNELS * count_pixels(&band);
        cvol_splat_gain gain;
        set_gain(&gain, job->gain, job->plan, slice);
        CVOL_SIMD_CHOOSE(cvol_splat_composite)
        (&band, gain.gain->size ? &gain : NULL, job->front);
        if (job->front && place % HIDDEN_SLICES == HIDDEN_SLICES - 1)
            cvol_splat_hidden_update(hidden, &band);
    }
}

static int count_bands(const cvol_splat_job *job)
{
    return (job->height + job->band_rows - 1) / job->band_rows;
}

void cvol_splat_bands_draw(const cvol_splat_job *job, size_t begin, size_t end)
{
    const int bands = count_bands(job);
#pragma omp parallel for schedule(dynamic) num_threads(job->threads)
    for (int band = 0; band < bands; band++)
        draw_band(job, &job->memory[cvol_thread_index()], band, begin, end);
}

uint64_t cvol_splat_bands_count(const cvol_splat_job *job)
{
    uint64_t sum = 0;
    for (int t = 0; t < job->threads; t++)
        sum += job->memory[t].multiply_adds;
    return sum;
}

/* ---- memory -------------------------------------------------------------------------------- */

static void free_memory(cvol_splat_memory *memory, int threads)
{
    for (int t = 0; memory && t < threads; t++) {
        free(memory[t].sheet);
        free(memory[t].spans);
        free(memory[t].list.numbers);
        free(memory[t].list.entries);
        free(memory[t].list.channels);
    }
    free(memory);
}

static cvol_splat_memory *make_memory(const cvol_splat_job *job, int threads)
{
    cvol_splat_memory *memory = calloc((size_t)threads, sizeof *memory);
    const size_t rows = (size_t)job->band_rows, lanes = job->plan->lanes;
    int whole = memory != NULL;
    for (int t = 0; whole && t < threads; t++) {
        memory[t].sheet = cvol_allocate_zero(rows * job->row_stride, sizeof *memory[t].sheet);
        memory[t].spans = cvol_allocate(rows, sizeof *memory[t].spans);
        memory[t].list.numbers = cvol_allocate_zero(lanes + CVOL_SPLAT_MARGIN,
                                                    sizeof *memory[t].list.numbers);
        memory[t].list.entries = cvol_allocate_zero(lanes + CVOL_SPLAT_MARGIN,
                                                    sizeof *memory[t].list.entries);
        memory[t].list.channels = cvol_allocate(CVOL_SPLAT_CHANNELS * lanes,
                                                sizeof *memory[t].list.channels);
        whole = memory[t].sheet && memory[t].spans && memory[t].list.numbers &&
                memory[t].list.entries && memory[t].list.channels;
        for (size_t row = 0; whole && row < rows; row++) {
            memory[t].spans[row][0] = INT_MAX;
            memory[t].spans[row][1] = 0;
        }
    }
    if (whole)
        return memory;
    free_memory(memory, threads);
    return NULL;
}

/* The picture's rows, and the number of them per band. */
static void choose_bands(cvol_splat_job *job, int width, int height)
{
    job->width = width;
    job->height = height;
    const int slant = (int)ceil(cvol_footprint_slant(job->footprint));
    job->margin = (job->footprint->width + 2 * slant + 2 * CVOL_FOOTPRINT_PAD + 3) / 4 * 4;
    job->row_stride = CVOL_SPLAT_CHANNELS *
                      (((size_t)job->width + 2 * (size_t)job->margin + 7) / 4 * 4);
    const size_t row_bytes = 2 * sizeof(float) * job->row_stride;
    /* Bands do not depend on the number of threads: a sample that is hidden in a band is left out
     * there, and adds up to 2^-12 elsewhere. */
    int rows = (int)(BAND_BYTES / row_bytes), share = height / BANDS_MIN + 1;
    /* Samples near a border between bands are classified for both. */
    int least = job->footprint->height > BAND_ROWS_MIN ? job->footprint->height : BAND_ROWS_MIN;
    rows = rows < share ? rows : share;
    rows = rows < least ? least : rows;
    job->band_rows = (rows + CVOL_HIDDEN_HEIGHT - 1) / CVOL_HIDDEN_HEIGHT * CVOL_HIDDEN_HEIGHT;
}

static void free_hidden(cvol_splat_hidden *hidden)
{
    if (hidden)
        free(hidden->closed);
    free(hidden);
}

/* All bands' cells, all of them visible, in one allocation. */
static cvol_splat_hidden *make_hidden(const cvol_splat_job *job)
{
    const int bands = count_bands(job), down = job->band_rows / CVOL_HIDDEN_HEIGHT;
    const int across = (job->width + CVOL_HIDDEN_WIDTH - 1) / CVOL_HIDDEN_WIDTH;
    const size_t cells = (size_t)across * (size_t)down;
    const double slant = cvol_footprint_slant(job->footprint);
    cvol_splat_hidden *hidden = calloc((size_t)bands, sizeof *hidden);
    uint8_t *map = calloc(2 * cells, (size_t)bands);
    if (!hidden || !map) {
        free(hidden);
        free(map);
        return NULL;
    }
    for (int band = 0; band < bands; band++) {
        const int rows = job->height - band * job->band_rows;
        cvol_splat_hidden *own = &hidden[band];
        own->across = across;
        own->down = rows < job->band_rows ? (rows + CVOL_HIDDEN_HEIGHT - 1) / CVOL_HIDDEN_HEIGHT
                                          : down;
        own->reach[0] = (int)(job->footprint->width / 2.0 + slant + 1) / CVOL_HIDDEN_WIDTH + 1;
        own->reach[1] = (int)(job->footprint->height / 2.0 + 1) / CVOL_HIDDEN_HEIGHT + 1;
        own->closed = map + 2 * cells * (size_t)band;
        own->hidden = own->closed + cells;
    }
    return hidden;
}

void cvol_splat_bands_free(cvol_splat_job *job)
{
    free(job->image);
    free_hidden(job->hidden);
    free_memory(job->memory, job->threads);
}

int cvol_splat_bands_make(cvol_context *context, cvol_splat_job *job, int width, int height)
{
    job->threads = cvol_context_threads(context);
    choose_bands(job, width, height);
    const size_t floats = (size_t)job->height * job->row_stride;
    job->memory = make_memory(job, job->threads);
    job->hidden = make_hidden(job);
    job->image = cvol_allocate_zero(floats, sizeof *job->image);
    if (!job->memory || !job->hidden || !job->image)
        return cvol_fail_memory(context, floats * sizeof *job->image, "a picture");
    for (size_t at = 3; at < floats; at += CVOL_SPLAT_CHANNELS)
        job->image[at] = 1;
    return CVOL_OK;
}
