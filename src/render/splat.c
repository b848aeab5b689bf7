/* The splat engine: every sample's footprint is added to the picture, slice by slice.
 *
 * Westover's algorithm (L. Westover, "Footprint evaluation for volume rendering", 1990): samples
 * are taken in the order of the volume, slice by slice along the axis most parallel to the view.
 * Each is classified and lit by itself, and, unless it is transparent, moved to the picture and
 * added there to the slice's sheet buffer through the table of footprints; whole sheets are
 * composited, front to back or back to front. A sample hides as much as the distance of slices
 * along the view does,
 *
 *     1 - (1 - opacity)^(distance / mean spacing),
 *
 * and weights add up to 1 within a slice (footprint.h). Cost: the samples, to be classified, and
 * for each visible one the pixels of a footprint.
 *
 * The picture is cut into bands of rows; each band goes through the samples of a slab that reach
 * it, on one thread, so that a pixel's sums do not depend on the number of threads.
 */
#include "render/splat_hidden.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"

#define FOOTPRINT_MOST 31
/* A band's sheet and picture, to fit into the second-level cache. */
#define BAND_BYTES (1 << 19)
#define BAND_ROWS_LEAST 16
/* Slices between two looks at what is hidden by now, and samples that are passed over together. */
#define HIDDEN_SLICES 8
#define HIDDEN_SAMPLES 32

typedef struct splat_state {
    cvol_splat_source source;
    cvol_grid grid;
    cvol_transfer *transfer;
    cvol_splat_table *table;
    /* What the picture before leaves for the next. */
    cvol_footprint_table footprint;
    cvol_splat_slab slab;
} splat_state;

/* What a thread works with. */
typedef struct splat_memory {
    float *sheet;
    int (*spans)[2];
    cvol_splat_list list;
} splat_memory;

/* What all bands of one picture share. */
typedef struct splat_job {
    const cvol_splat_plan *plan;
    const cvol_splat_slab *slab;
    const cvol_footprint_table *footprint;
    const cvol_splat_table *table;
    const cvol_splat_light *light;
    cvol_splat_gain gain;
    int ascending, front;
    int width, height, margin, band_rows;
    size_t row_stride;
    float *image;
    cvol_splat_hidden *hidden; /* of each band */
} splat_job;

/* ---- state ----------------------------------------------------------------------------- */

static void splat_free(void *opaque)
{
    splat_state *state = opaque;
    cvol_transfer_free(state->transfer);
    cvol_footprint_table_free(&state->footprint);
    cvol_splat_slab_free(&state->slab);
    free(state->table);
    free(state);
}

static int create(cvol_context *context, void **out, const cvol_splat_source *source,
                  const cvol_grid *grid)
{
    *out = NULL;
    splat_state *state = calloc(1, sizeof *state);
    if (!state)
        return cvol_fail_memory(context, sizeof *state, "a renderer");
    state->source = *source;
    state->grid = *grid;
    state->table = cvol_allocate(1, sizeof *state->table);
    if (!state->table) {
        splat_free(state);
        return cvol_fail_memory(context, sizeof *state->table, "a renderer");
    }
    *out = state;
    return CVOL_OK;
}

int cvol_splat_create(cvol_context *context, void **state, const cvol_array *array)
{
    cvol_splat_source source = {
        .array = array, .min = array->ledger.value_min, .max = array->ledger.value_max};
    return create(context, state, &source, cvol_array_grid(array));
}

int cvol_splat_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    *state = NULL;
    int code = cvol_grid_check(context, &volume->grid, "volume");
    cvol_sample_stats stats = {0};
    if (!code)
        code = cvol_volume_stats(context, &stats, volume);
    if (code)
        return code;
    cvol_splat_source source = {.volume = volume, .min = stats.min, .max = stats.max};
    return create(context, state, &source, &volume->grid);
}

static int splat_set_transfer(cvol_context *context, void *opaque, const cvol_transfer *transfer)
{
    splat_state *state = opaque;
    cvol_transfer *copy;
    int code = cvol_transfer_copy(context, &copy, transfer);
    if (code)
        return code;
    cvol_transfer_free(state->transfer);
    state->transfer = copy;
    return CVOL_OK;
}

/* ---- one picture's tables ---------------------------------------------------------------- */

static int check_options(cvol_context *context, const cvol_render_options *options)
{
    const cvol_splat_options *splat = &options->splat;
    if (options->mode != CVOL_MODE_COMPOSITE)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the splat engine has mode composite only");
    if (splat->footprint < CVOL_FOOTPRINT_GAUSSIAN || splat->footprint > CVOL_FOOTPRINT_BOX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is no footprint", (int)splat->footprint);
    if (splat->size < 3 || splat->size > FOOTPRINT_MOST)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "footprint size %d: must be 3 to %d samples",
                         splat->size, FOOTPRINT_MOST);
    if (splat->sigma != 0 && !(splat->sigma >= 0.2 && splat->sigma <= FOOTPRINT_MOST))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "sigma %g: must be 0 (size / 6), or 0.2 to %d samples", splat->sigma,
                         FOOTPRINT_MOST);
    if (splat->order != CVOL_ORDER_FRONT && splat->order != CVOL_ORDER_BACK)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is no order of compositing",
                         (int)splat->order);
    for (int a = 0; a < 3; a++)
        if (!(fabs(splat->light[a]) <= 1e30))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "light: %c is %g, must be a number of at most 1e30", "xyz"[a],
                             splat -> light[a]);
    return CVOL_OK;
}

static int is_integer(cvol_type type)
{
    return type != CVOL_FLOAT32 && type != CVOL_FLOAT64;
}

/* Tabulates what samples add, over what of the transfer function they reach and one entry more on
 * both sides. Integers have entries of their own where there are enough. `share` is the sum of
 * weights that a slice would have. */
static void fill_table(cvol_splat_table *table, const splat_state *state, double distance,
                       double share)
{
    const cvol_transfer *transfer = state->transfer;
    const double min = state->source.min, max = state->source.max, cells = CVOL_SPLAT_ENTRIES - 4;
    double lo = fmin(fmax(transfer->points[0].value, min), max);
    double hi = fmin(fmax(transfer->points[transfer->count - 1].value, min), max);
    double unit = hi > lo ? (hi - lo) / cells : 1;
    if (is_integer(state->grid.type) && hi - lo + 2 <= cells) {
        lo = floor(lo);
        unit = 1 / floor(cells / (ceil(hi) - lo + 1));
    }
    table->from = (float)(lo - unit);
    table->scale = (float)(1 / unit);
    int first = CVOL_SPLAT_ENTRIES, last = -1;
    for (int t = 0; t < CVOL_SPLAT_ENTRIES; t++) {
        cvol_transfer_point p = cvol_transfer_at(transfer, lo + (t - 1) * unit);
        double opacity = cvol_opacity_over(p.opacity, distance) / share;
        const double channels[4] = {p.r * opacity, p.g * opacity, p.b * opacity, opacity};
        for (int c = 0; c < CVOL_SPLAT_CHANNELS; c++)
            table->entries[t][c] = (float)channels[c];
        if (p.opacity > 0) {
            first = t < first ? t : first;
            last = t;
        }
    }
    table->visible_from = first == 0 ? -INFINITY : (float)(lo + (first - 2) * unit);
    table->visible_to = last == CVOL_SPLAT_ENTRIES - 1 ? INFINITY : (float)(lo + last * unit);
    if (last < 0)
        table->visible_from = INFINITY;
}

static void set_light(cvol_splat_light *light, const cvol_splat_plan *plan, const cvol_grid *grid,
                      const cvol_view *view, const cvol_splat_options *options, int ascending)
{
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_slice};
    const double *given = options->light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    double towards[3], half[3], half_length = 0;
    light->shade = options->shade;
    for (int a = 0; a < 3; a++) {
        towards[a] = length > 0 ? given[a] / length : view->eye[a];
        half[a] = towards[a] + view->eye[a];
        half_length = hypot(half_length, half[a]);
    }
    double facing_light = 0, facing_halfway = 0;
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        const double turn = k == 2 && !ascending ? -1 : 1;
        /* light from behind has no highlight */
        const double halfway = half_length > 1e-6 ? half[a] / half_length : 0;
        light->eye[k] = (float)(turn * view->eye[a]);
        light->light[k] = (float)(turn * towards[a]);
        light->halfway[k] = (float)(turn * halfway);
        light->inverse_spacing[k] = (float)(view->mean_spacing / grid->spacing[a]);
        facing_light += view->eye[a] * towards[a];
        facing_halfway += view->eye[a] * halfway;
    }
    light->facing_light = (float)facing_light;
    light->facing_halfway = (float)facing_halfway;
}

/* The lattice of slice 0 as the pixels see it: (u, v) of a pixel (x, y) solve
 * origin + u along[0] + v along[1] = (x, y). */
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

/* Cuts *from .. *to, numbers of samples, to those for which start + number step lies within
 * lo .. hi. */
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

static cvol_splat_row row_at(const splat_job *job, size_t place, size_t row)
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

static void add_run(const splat_job *job, const cvol_splat_band *band, splat_memory *memory,
                    const row_run *row, int begin, int end)
{
    CVOL_SIMD_CHOOSE(cvol_splat_list_make)
    (&memory->list, &row->samples, begin, end, job->table, job->light);
    if (memory->list.count > 0)
        CVOL_SIMD_CHOOSE(cvol_splat_add)
    (band, job->footprint, &memory->list, row->start, row->step);
}

/* Samples begin .. end - 1 of a row, without what is hidden. */
static void add_row(const splat_job *job, const cvol_splat_band *band,
                    const cvol_splat_hidden *hidden, splat_memory *memory, const row_run *row,
                    int begin, int end)
{
    int seen = begin; /* what is from here on has not been added */
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
static void add_slice(const splat_job *job, const cvol_splat_band *band,
                      const cvol_splat_hidden *hidden, splat_memory *memory, size_t place,
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
        /* rows of which some sample may lie within */
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

/* Places begin .. end - 1 in the order of slices, for one band. */
static void draw_band(const splat_job *job, splat_memory *memory, int number, size_t begin,
                      size_t end)
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
        cvol_splat_gain gain;
        set_gain(&gain, job->gain.gain, job->plan, slice);
        CVOL_SIMD_CHOOSE(cvol_splat_composite)
        (&band, gain.gain->size ? &gain : NULL, job->front);
        if (job->front && place % HIDDEN_SLICES == HIDDEN_SLICES - 1)
            cvol_splat_hidden_update(hidden, &band);
    }
}

static int count_bands(const splat_job *job)
{
    return (job->height + job->band_rows - 1) / job->band_rows;
}

static int draw_slabs(cvol_context *context, splat_job *job, cvol_splat_slab *slab,
                      const cvol_splat_source *source, splat_memory *memory)
{
    const int bands = count_bands(job);
    const int threads = cvol_context_threads(context);
    const size_t slices = job->plan->slices;
    int code = CVOL_OK;
    for (size_t done = 0; done < slices && !code;) {
        code = cvol_splat_slab_next(context, slab, source, job->plan, job->ascending);
        if (code)
            break;
        /* The last slice of a slab waits for its neighbour. */
        const size_t loaded = slab->first + slab->filled;
        const size_t end = loaded < slices ? loaded - 1 : slices;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (int band = 0; band < bands; band++)
            draw_band(job, &memory[cvol_thread_index()], band, done, end);
        done = end;
        code = cvol_report_progress(context, "rendering", (double)done / (double)slices);
    }
    return code;
}

/* ---- memory -------------------------------------------------------------------------------- */

static void free_memory(splat_memory *memory, int threads)
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

static splat_memory *make_memory(const splat_job *job, int threads)
{
    splat_memory *memory = calloc((size_t)threads, sizeof *memory);
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

/* The picture's rows, and how many make a band. */
static void choose_bands(splat_job *job, const cvol_view *view, int threads)
{
    job->width = view->width;
    job->height = view->height;
    const int slant = (int)ceil(cvol_footprint_slant(job->footprint));
    job->margin = (job->footprint->width + 2 * slant + 2 * CVOL_FOOTPRINT_PAD + 3) / 4 * 4;
    job->row_stride = CVOL_SPLAT_CHANNELS *
                      (((size_t)job->width + 2 * (size_t)job->margin + 7) / 4 * 4);
    const size_t row_bytes = 2 * sizeof(float) * job->row_stride;
    int rows = (int)(BAND_BYTES / row_bytes), share = view->height / (4 * threads) + 1;
    /* Samples near a border between bands are classified for both. */
    int least = job->footprint->height > BAND_ROWS_LEAST ? job->footprint->height : BAND_ROWS_LEAST;
    rows = rows < share || threads == 1 ? rows : share;
    rows = rows < least ? least : rows;
    job->band_rows = (rows + CVOL_HIDDEN_HEIGHT - 1) / CVOL_HIDDEN_HEIGHT * CVOL_HIDDEN_HEIGHT;
}

static void free_hidden(cvol_splat_hidden *hidden)
{
    if (hidden)
        free(hidden->closed);
    free(hidden);
}

/* All bands' cells, none of them hidden; one piece of memory is for all. */
static cvol_splat_hidden *make_hidden(const splat_job *job)
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

static uint8_t to_byte(float level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5f) : 255;
}

static void finish(cvol_image *image, const splat_job *job, const double background[3])
{
    for (int y = 0; y < job->height; y++) {
        const float *from = job->image + (size_t)y * job->row_stride +
                            CVOL_SPLAT_CHANNELS * (size_t)job->margin;
        uint8_t *to = image->rgba + 4 * (size_t)y * (size_t)job->width;
        for (int x = 0; x < job->width; x++, from += CVOL_SPLAT_CHANNELS, to += 4) {
            for (int c = 0; c < 3; c++)
                to[c] = to_byte(from[c] + from[3] * (float)background[c]);
            to[3] = 255;
        }
    }
}

/* ---- drawing -------------------------------------------------------------------------------- */

static int splat_draw(cvol_context *context, void *opaque, cvol_image *image, const cvol_view *view,
                      const cvol_render_options *options)
{
    splat_state *state = opaque;
    const int threads = cvol_context_threads(context);
    int code = check_options(context, options);
    if (code)
        return code;
    cvol_splat_plan plan;
    cvol_splat_plan_make(&plan, &state->grid, view);
    const cvol_footprint_shape shape = cvol_footprint_shape_make(&options->splat, plan.along);
    code = cvol_footprint_table_make(context, &state->footprint, &shape);
    if (code)
        return code;
    cvol_footprint_gain gain;
    cvol_footprint_gain_make(&gain, &state->footprint, plan.along[0], plan.along[1], threads);
    fill_table(state->table, state, plan.distance, gain.mean);
    const int front = options->splat.order == CVOL_ORDER_FRONT;
    const int ascending = plan.rising == front;
    cvol_splat_light light;
    set_light(&light, &plan, &state->grid, view, &options->splat, ascending);
    splat_job job = {.plan = &plan,

                     .slab = &state->slab,
                     .footprint = &state->footprint,
                     .table = state->table,
                     .light = &light,
                     .gain.gain = &gain,
                     .ascending = ascending,
                     .front = front};
    choose_bands(&job, view, threads);
    code = cvol_splat_slab_prepare(context, &state->slab, &state->source, &plan);
    splat_memory *memory = make_memory(&job, threads);
    const size_t floats = (size_t)job.height * job.row_stride;
    job.image = cvol_allocate_zero(floats, sizeof *job.image);
    job.hidden = make_hidden(&job);
    if (!code && (!memory || !job.image || !job.hidden))
        code = cvol_fail_memory(context, floats * sizeof *job.image, "a picture");
    if (!code) {
        for (size_t at = 3; at < floats; at += CVOL_SPLAT_CHANNELS)
            job.image[at] = 1;
        code = draw_slabs(context, &job, &state->slab, &state->source, memory);
    }
    if (!code)
        finish(image, &job, options->background);
    free(job.image);
    free_hidden(job.hidden);
    free_memory(memory, threads);
    return code;
}

const cvol_engine_table cvol_splat_engine = {splat_free, splat_set_transfer, splat_draw};
