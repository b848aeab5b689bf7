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
#include "render/splat_band.h"

#include <math.h>

#include "base/context.h"
#include "base/memory.h"

#define FOOTPRINT_MOST 31

typedef struct splat_state {
    cvol_splat_source source;
    cvol_grid grid;
    cvol_transfer *transfer;
    cvol_splat_table *table;
    /* What the picture before leaves for the next. */
    cvol_footprint_table footprint;
    cvol_splat_slab slab;
} splat_state;

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

static int draw_slabs(cvol_context *context, const cvol_splat_job *job, cvol_splat_slab *slab,
                      const cvol_splat_source *source)
{
    const size_t slices = job->plan->slices;
    int code = CVOL_OK;
    for (size_t done = 0; done < slices && !code;) {
        code = cvol_splat_slab_next(context, slab, source, job->plan, job->ascending);
        if (code)
            break;
        /* The last slice of a slab waits for its neighbour. */
        const size_t loaded = slab->first + slab->filled;
        const size_t end = loaded < slices ? loaded - 1 : slices;
        cvol_splat_bands_draw(job, done, end);
        done = end;
        code = cvol_report_progress(context, "rendering", (double)done / (double)slices);
    }
    return code;
}

static uint8_t to_byte(float level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5f) : 255;
}

static void finish(cvol_image *image, const cvol_splat_job *job, const double background[3])
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
    cvol_footprint_gain_make(&gain, &state->footprint, plan.along[0], plan.along[1],
                             cvol_context_threads(context));
    fill_table(state->table, state, plan.distance, gain.mean);
    const int front = options->splat.order == CVOL_ORDER_FRONT;
    const int ascending = plan.rising == front;
    cvol_splat_light light;
    set_light(&light, &plan, &state->grid, view, &options->splat, ascending);
    cvol_splat_job job = {.plan = &plan,
                          .slab = &state->slab,
                          .footprint = &state->footprint,
                          .table = state->table,
                          .light = &light,
                          .gain = &gain,
                          .ascending = ascending,
                          .front = front};
    code = cvol_splat_bands_make(context, &job, view);
    if (!code)
        code = cvol_splat_slab_prepare(context, &state->slab, &state->source, &plan);
    if (!code)
        code = draw_slabs(context, &job, &state->slab, &state->source);
    if (!code)
        finish(image, &job, options->background);
    cvol_splat_bands_free(&job);
    return code;
}

const cvol_engine_table cvol_splat_engine = {splat_free, splat_set_transfer, splat_draw};
