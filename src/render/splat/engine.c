/* The splat engine: adds every sample's footprint to the picture, slice by slice.
 *
 * Westover's algorithm (L. Westover, "Footprint evaluation for volume rendering", 1990) takes
 * samples in the order of the volume, slice by slice along the axis most parallel to the view. It
 * classifies and lights each sample, and, unless the sample is transparent, adds it to the slice's
 * sheet buffer at its place in the picture through the table of footprints. Whole sheets are
 * composited, front to back or back to front. A sample's opacity is that of the distance of slices
 * along the view,
 *
 *     1 - (1 - opacity)^(distance / mean spacing),
 *
 * and weights add up to 1 within a slice (footprint.h). Cost: classification of all samples, and
 * the pixels of a footprint for each visible one.
 *
 * The picture is cut into bands of rows. Each band passes the samples of a slab that reach it, on
 * one thread, so a pixel's sums do not depend on the number of threads. */
#include "render/counters.h"
#include "render/splat/band.h"

#include <math.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/splat/object_order.h"
#include "render/splat/setup.h"

typedef struct splat_state {
    cvol_splat_input input; /* first: cvol_splat_state_create */
    /* State that the picture before leaves for the next. */
    cvol_footprint_table footprint;
    cvol_splat_slab slab;
    uint64_t multiply_adds; /* of it */
} splat_state;

/* ---- state ----------------------------------------------------------------------------- */

static void splat_free(void *opaque)
{
    splat_state *state = opaque;
    cvol_footprint_table_free(&state->footprint);
    cvol_splat_slab_free(&state->slab);
    cvol_splat_input_free(&state->input);
    free(state);
}

int cvol_splat_create(cvol_context *context, void **state, const cvol_array *array)
{
    return cvol_splat_state_create(context, state, sizeof(splat_state), array, NULL);
}

int cvol_splat_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    return cvol_splat_state_create(context, state, sizeof(splat_state), NULL, volume);
}

static int splat_set_transfer(cvol_context *context, void *opaque, const cvol_transfer *transfer)
{
    splat_state *state = opaque;
    return cvol_splat_input_set_transfer(context, &state->input, transfer);
}

/* ---- one picture's tables ---------------------------------------------------------------- */

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

/* `from`: colour times opacity, and transmittance. */
static void put_bytes(uint8_t *to, const float *from, const double background[3])
{
    for (int c = 0; c < 3; c++)
        to[c] = to_byte(from[c] + from[3] * (float)background[c]);
    to[3] = 255;
}

static void put_values(float *to, const float *from)
{
    for (int c = 0; c < 3; c++)
        to[c] = from[c];
    to[3] = 1 - from[3];
}

static void finish(cvol_image *image, const cvol_splat_job *job, const double background[3])
{
    for (int y = 0; y < job->height; y++) {
        const float *from = job->image + (size_t)y * job->row_stride +
                            CVOL_SPLAT_CHANNELS * (size_t)job->margin;
        const size_t first = 4 * (size_t)y * (size_t)job->width;
        for (size_t x = 0; x < (size_t)job->width; x++, from += CVOL_SPLAT_CHANNELS)
            if (image->values)
                put_values(image->values + first + 4 * x, from);
            else
                put_bytes(image->rgba + first + 4 * x, from, background);
    }
}

/* ---- drawing -------------------------------------------------------------------------------- */

/* From the lattice of slices to the picture. */
static int finish_grid(cvol_context *context, cvol_image *image, const cvol_splat_job *job,
                       const cvol_intermediate_grid *image_grid, const cvol_splat_plan *plan,
                       const double background[3])
{
    const size_t width = image_grid->dims[0], height = image_grid->dims[1];
    float *pixels = cvol_allocate(width * height * CVOL_SPLAT_CHANNELS, sizeof *pixels);
    if (!pixels)
        return cvol_fail_memory(context, width * height * CVOL_SPLAT_CHANNELS * sizeof *pixels,
                                "a picture");
    for (size_t y = 0; y < height; y++) {
        const float *from = job->image + y * job->row_stride +
                            CVOL_SPLAT_CHANNELS * (size_t)job->margin;
        float *to = pixels + y * width * CVOL_SPLAT_CHANNELS;
        for (size_t i = 0; i < width * CVOL_SPLAT_CHANNELS; i++)
            to[i] = i % CVOL_SPLAT_CHANNELS == 3 ? 1 - from[i] : from[i];
    }
    const int code = cvol_intermediate_grid_warp(context, image, pixels, image_grid, plan,
                                                 background);
    free(pixels);
    return code;
}

static int splat_draw(cvol_context *context, void *opaque, cvol_image *image, const cvol_view *view,
                      const cvol_render_options *options)
{
    splat_state *state = opaque;
    cvol_splat_setup setup;
    int code = cvol_splat_setup_picture(context, &setup, &state->input, view, options, "splat");
    if (code)
        return code;
    const int in_slices = options->splat.plane == CVOL_FOOTPRINT_IN_SLICES;
    cvol_splat_plan plan = setup.plan;
    cvol_footprint_shape shape = cvol_footprint_shape_make(&options->splat, plan.along);
    cvol_intermediate_grid image_grid = {0};
    int size[2] = {view->width, view->height};
    if (in_slices) {
        /* The lattice is the picture. */
        shape = cvol_intermediate_grid_shape(&options->splat);
        image_grid = cvol_intermediate_grid_make(&plan, &shape, 1);
        for (int a = 0; a < 2; a++) {
            size[a] = (int)image_grid.dims[a];
            plan.origin[a] = image_grid.base[a];
            for (int k = 0; k < 3; k++)
                plan.along[k][a] = k == 2 ? image_grid.shear[a] : k == a;
        }
    }
    code = cvol_footprint_table_make(context, &state->footprint, &shape);
    if (code)
        return code;
    cvol_footprint_gain gain;
    cvol_footprint_gain_make(&gain, &state->footprint, plan.along[0], plan.along[1],
                             cvol_context_threads(context));
    cvol_splat_input_tabulate(&state->input, plan.distance, gain.mean);
    cvol_splat_job job = {.plan = &plan,
                          .slab = &state->slab,
                          .footprint = &state->footprint,
                          .table = state->input.table,
                          .light = &setup.light,
                          .gain = &gain,
                          .ascending = setup.ascending,
                          .front = setup.front};
    code = cvol_splat_bands_make(context, &job, size[0], size[1]);
    if (!code)
        code = cvol_splat_slab_prepare(context, &state->slab, &state->input.source, &plan);
    if (!code)
        code = draw_slabs(context, &job, &state->slab, &state->input.source);
    if (!code)
        state->multiply_adds = cvol_splat_bands_count(&job);
    if (!code && in_slices)
        code = finish_grid(context, image, &job, &image_grid, &setup.plan, options->background);
    else if (!code)
        finish(image, &job, options->background);
    cvol_splat_bands_free(&job);
    return code;
}

int cvol_renderer_splat_multiply_adds(cvol_context *context, const cvol_renderer *renderer,
                                      uint64_t *out)
{
    if (renderer->engine != &cvol_splat_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this renderer is not of engine splat");
    *out = ((const splat_state *)renderer->state)->multiply_adds;
    return CVOL_OK;
}

const cvol_engine_table cvol_splat_engine = {
    .free = splat_free, .set_transfer = splat_set_transfer, .draw = splat_draw};
