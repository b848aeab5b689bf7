/* The fourier engine: pictures like X-rays, by the Fourier slice theorem.
 *
 * Sums along rays come from a slice (slice.c). A pixel's mean is
 *
 *     base + sum / weight,       weight: the length within the volume, blurred like the sum,
 *
 * if the pixel's ray meets the volume. With depth cueing (Totsuka and Levoy, "Frequency domain
 * volume rendering", 1993) a sample counts 1 - strength depth. The depth is 0 at the near end of
 * the volume's diagonal, turned into the ray, and 1 at the far end. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include "render/fourier/pixels.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/view/options.h"

/* In smallest spacings: shorter lengths are ignored. */
#define FLOOR 0.05

typedef struct fourier_state {
    cvol_grid grid;
    cvol_fourier_source source;
    double range[2]; /* of samples with a value */
    cvol_fourier_kernel kernel;
    cvol_fourier_volume volume;
    cvol_fourier_planes *planes; /* one for each thread that makes whole views */
    int planes_count;
    cvol_fourier_report report;
} fourier_state;

/* ---- state ----------------------------------------------------------------------------- */

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void fourier_free(void *opaque)
{
    fourier_state *state = opaque;
    for (int i = 0; i < state->planes_count; i++)
        cvol_fourier_planes_free(&state->planes[i]);
    free(state->planes);
    cvol_fourier_volume_free(&state->volume);
    free(state);
}

static int find_window(cvol_context *context, fourier_state *state)
{
    const cvol_array *array = state->source.array;
    cvol_volume_statistics stats = {0};
    int code = CVOL_OK;
    if (array) {
        stats.min = array->error_bound.value_min;
        stats.max = array->error_bound.value_max;
        state->source.offset = array->offset;
    } else {
        code = cvol_grid_check(context, &state->grid, "volume");
        if (!code)
            code = cvol_volume_compute_statistics(context, &stats, state->source.volume);
        state->source.offset = stats.min;
    }
    state->range[0] = stats.min;
    state->range[1] = stats.max;
    state->source.min = stats.min - state->source.offset;
    state->source.max = stats.max - state->source.offset;
    return code;
}

static int create(cvol_context *context, void **out, const cvol_array *array,
                  const cvol_volume *volume, double rho)
{
    *out = NULL;
    if (!(rho >= 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rho is %g, must be above 0, or 0 for all",
                         rho);
    const double start = now_ms();
    fourier_state *state = calloc(1, sizeof *state);
    if (!state)
        return cvol_fail_memory(context, sizeof *state, "a renderer");
    state->grid = array ? *cvol_array_grid(array) : volume->grid;
    state->source = (cvol_fourier_source){.array = array, .volume = volume};
    cvol_fourier_kernel_make(&state->kernel);
    int code = find_window(context, state);
    if (!code)
        code = cvol_fourier_volume_make(context, &state->volume, &state->source, rho);
    if (code) {
        fourier_free(state);
        return code;
    }
    for (int a = 0; a < 3; a++)
        state->report.padded[a] = state->volume.samples.dims[a];
    const cvol_fourier_spectrum *spectra[] = {&state->volume.samples, &state->volume.cover};
    for (int k = 0; k < 2; k++) {
        state->report.places += cvol_fourier_spectrum_places(spectra[k]);
        state->report.bytes += cvol_fourier_spectrum_bytes(spectra[k]);
    }
    state->report.build_ms = now_ms() - start;
    *out = state;
    return CVOL_OK;
}

int cvol_fourier_create(cvol_context *context, void **state, const cvol_array *array, double rho)
{
    return create(context, state, array, NULL, rho);
}

int cvol_fourier_create_dense(cvol_context *context, void **state, const cvol_volume *volume,
                              double rho)
{
    return create(context, state, NULL, volume, rho);
}

/* A mean does not depend on the transfer function. */
static int fourier_set_transfer(cvol_context *context, void *opaque, const cvol_transfer *transfer)
{
    (void)context;
    (void)opaque;
    (void)transfer;
    return CVOL_OK;
}

int cvol_renderer_get_fourier_report(cvol_context *context, cvol_fourier_report *out,
                                     const cvol_renderer *renderer)
{
    if (renderer->engine != &cvol_fourier_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this renderer is not of engine fourier");
    *out = ((const fourier_state *)renderer->state)->report;
    return CVOL_OK;
}

/* Allocates views for `count` threads. */
static int prepare_planes(cvol_context *context, fourier_state *state, int count)
{
    if (count <= state->planes_count)
        return CVOL_OK;
    const size_t bytes = (size_t)count * sizeof *state->planes;
    cvol_fourier_planes *grown = realloc(state->planes, bytes);
    if (!grown)
        return cvol_fail_memory(context, bytes, "threads' views");
    state->planes = grown;
    for (; state->planes_count < count; state->planes_count++)
        state->planes[state->planes_count] = (cvol_fourier_planes){0};
    return CVOL_OK;
}

static int check_options(cvol_context *context, const cvol_render_options *options)
{
    const double strength = options->fourier.depth_cue;
    return strength >= 0 && strength <= 1
               ? CVOL_OK
               : cvol_fail(context, CVOL_ERROR_ARGUMENT, "depth cue %g: must be 0 to 1", strength);
}

/* Smaller weights are ignored. The places left out of a spectrum are noise of `lost` of the samples
 * in padded space; along a ray it grows with the square root of the number of samples. */
static double find_floor(const fourier_state *state)
{
    const double lost = fmax(state->volume.samples.bricks.lost, state->volume.cover.bricks.lost);
    double spacing = INFINITY, places = 1;
    for (int a = 0; a < 3; a++) {
        spacing = fmin(spacing, state->grid.spacing[a]);
        places = fmax(places, (double)state->volume.samples.dims[a]);
    }
    return spacing * fmax(FLOOR, lost * sqrt(places));
}

/* Computes sums and weights of a view, and prepares its pixels. */
static int start_view(cvol_context *context, const fourier_state *state,
                      cvol_fourier_planes *planes, cvol_fourier_pixels *job, const cvol_view *view,
                      const cvol_render_options *options)
{
    const double strength = options->fourier.depth_cue;
    const double diagonal = view->pixel * options->camera.zoom * view->height;
    *job = (cvol_fourier_pixels){.volume = &state->volume,
                                 .kernel = &state->kernel,
                                 .source = state->source,
                                 .planes = planes,
                                 .view = view,
                                 .cue = {1 - strength / 2, strength / diagonal},
                                 .rays = cvol_fourier_rays_make(&state->grid, view),
                                 .integrals = options->fourier.integrals};
    job->floor = find_floor(state);
    int code = cvol_fourier_project(context, planes, &state->volume, &state->grid, view, &job->cue,
                                    &state->kernel);
    return code ? code : cvol_fourier_pixels_prepare(context, job);
}

/* ---- pictures -------------------------------------------------------------------------------- */

static uint8_t to_byte(double level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5) : 255;
}

static void paint_row(uint8_t *rgba, const float *values, const cvol_fourier_pixels *job,
                      const double background[3])
{
    const double min = job->source.min, range = job->source.max - min;
    for (int i = 0; i < job->view->width; i++, rgba += 4) {
        const double level = range > 0 ? ((double)values[i] - min) / range : 0;
        const uint8_t grey = to_byte(level);
        for (int c = 0; c < 3; c++)
            rgba[c] = isnan(values[i]) ? to_byte(background[c]) : grey;
        rgba[3] = 255;
    }
}

static void paint_values(float *out, const float *values, const cvol_fourier_pixels *job)
{
    const double min = job->source.min, range = job->source.max - min;
    for (int i = 0; i < job->view->width; i++, out += 4) {
        const int hit = !isnan(values[i]);
        const double level = hit && range > 0 ? ((double)values[i] - min) / range : 0;
        for (int c = 0; c < 3; c++)
            out[c] = (float)level;
        out[3] = (float)hit;
    }
}

/* Rows of pixels, in an image's format or as floats. */
static int make_rows(cvol_context *context, const cvol_fourier_pixels *job, cvol_image *image,
                     float *out, const double background[3])
{
    const size_t width = (size_t)job->view->width;
    const float lowest = (float)job->source.min;
    const double offset = job->integrals ? 0 : job->source.offset; /* integrals have it */
    int code = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        float *scratch = cvol_allocate(cvol_fourier_pixels_scratch(job), sizeof *scratch);
        if (!scratch) {
#pragma omp atomic write
            code = CVOL_ERROR_MEMORY;
        }
#pragma omp for schedule(static, 16)
        for (int j = 0; j < job->view->height; j++) {
            if (!scratch)
                continue;
            float *values = image ? scratch : out + width * (size_t)j;
            cvol_fourier_pixels_row(values, image ? scratch + width : scratch, job, j);
            if (image && image->values)
                paint_values(image->values + 4 * width * (size_t)j, values, job);
            else if (image)
                paint_row(image->rgba + 4 * width * (size_t)j, values, job, background);
            else
                for (size_t i = 0; i < width; i++)
                    values[i] = (float)((double)(isnan(values[i]) ? lowest : values[i]) + offset);
        }
        free(scratch);
    }
    return code ? cvol_fail_memory(context, cvol_fourier_pixels_scratch(job) * sizeof(float),
                                   "rows of pixels")
                : CVOL_OK;
}

static int fourier_draw(cvol_context *context, void *opaque, cvol_image *image,
                        const cvol_view *view, const cvol_render_options *options)
{
    fourier_state *state = opaque;
    if (options->mode != CVOL_MODE_XRAY)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the fourier engine has mode xray only");
    cvol_fourier_pixels job = {0};
    int code = check_options(context, options);
    if (!code)
        code = prepare_planes(context, state, 1);
    if (!code)
        code = start_view(context, state, state->planes, &job, view, options);
    if (!code)
        code = make_rows(context, &job, image, NULL, options->background);
    cvol_fourier_pixels_free(&job);
    return code ? code : cvol_report_progress(context, "rendering", 1);
}

/* ---- projections ----------------------------------------------------------------------------- */

/* The axes of a rotation of the camera, from a quaternion of any length. */
static int turn(cvol_context *context, cvol_view *view, const double q[4])
{
    const double largest = fmax(fmax(fabs(q[0]), fabs(q[1])), fmax(fabs(q[2]), fabs(q[3])));
    if (!(largest > 0) || !isfinite(q[0]) || !isfinite(q[1]) || !isfinite(q[2]) || !isfinite(q[3]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%g %g %g %g is not a rotation", q[0], q[1],
                         q[2], q[3]);
    double u[4], square = 0;
    for (int k = 0; k < 4; k++) {
        u[k] = q[k] / largest;
        square += u[k] * u[k];
    }
    for (int k = 0; k < 4; k++)
        u[k] /= sqrt(square);
    const double w = u[0], x = u[1], y = u[2], z = u[3];
    const double right[3] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
    const double up[3] = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
    const double eye[3] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
    memcpy(view->right, right, sizeof right);
    memcpy(view->up, up, sizeof up);
    memcpy(view->eye, eye, sizeof eye);
    return CVOL_OK;
}

static int project_one(cvol_context *context, const fourier_state *state,
                       cvol_fourier_planes *planes, float *out, cvol_view view,
                       const cvol_render_options *options, const double rotation[4])
{
    cvol_fourier_pixels job = {0};
    int code = turn(context, &view, rotation);
    if (!code)
        code = start_view(context, state, planes, &job, &view, options);
    if (!code)
        code = make_rows(context, &job, NULL, out, NULL);
    cvol_fourier_pixels_free(&job);
    return code;
}

static int project_all(cvol_context *context, fourier_state *state, float *out,
                       const cvol_view *view, const cvol_render_options *options,
                       const double (*rotations)[4], size_t count)
{
    const size_t pixels = (size_t)view->width * (size_t)view->height;
    /* all threads share a single view */
    const int threads = count > 1 ? cvol_context_threads(context) : 1;
    int code = prepare_planes(context, state, threads);
    if (code)
        return code;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t i = 0; i < count; i++) {
        cvol_context quiet = *context;
        quiet.progress = NULL;
        if (count > 1)
            quiet.threads = 1;
        const int failed = project_one(&quiet, state, state->planes + cvol_thread_index(),
                                       out + pixels * i, *view, options, rotations[i]);
        if (failed) {
#pragma omp atomic write
            code = failed;
        }
    }
    return code ? cvol_fail_memory(context, pixels * sizeof *out, "projections") : CVOL_OK;
}

int cvol_renderer_project(cvol_context *context, cvol_renderer *renderer, float *out,
                          const cvol_render_options *options, const double (*rotations)[4],
                          size_t count)
{
    if (renderer->engine != &cvol_fourier_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this renderer is not of engine fourier, which alone has projections");
    cvol_render_options full;
    cvol_view view, turned;
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = cvol_view_make(context, &view, &renderer->grid, &full);
    if (!code && (view.perspective || view.clipped))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "projections are parallel, of whole volumes");
    if (!code)
        code = check_options(context, &full);
    for (size_t i = 0; i < count && !code; i++) {
        turned = view;
        code = turn(context, &turned, rotations[i]);
    }
    if (!code)
        code = project_all(context, renderer->state, out, &view, &full, rotations, count);
    return code ? code : cvol_report_progress(context, "projecting", 1);
}

void cvol_fourier_range(const void *opaque, double range[2])
{
    const fourier_state *state = opaque;
    range[0] = state->range[0];
    range[1] = state->range[1];
}

const cvol_engine_table cvol_fourier_engine = {
    .free = fourier_free, .set_transfer = fourier_set_transfer, .draw = fourier_draw};
