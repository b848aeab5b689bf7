/* The transform engine: from a view to slices, from slices to a lattice, from there to pixels. */
#include "render/transform.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "base/context.h"
#include "base/memory.h"

/* Shears and distances of two views along one direction differ by rounding. */
#define SAME 1e-9

typedef struct transform_state {
    cvol_splat_subject subject;
    cvol_baked baked;
    /* What `baked` is of. */
    int has_baked;
    int axis_slice;
    double distance;
    cvol_splat_light light;
    cvol_transform_options options;
    cvol_transform_report report;
    int has_report;
} transform_state;

/* ---- state ----------------------------------------------------------------------------- */

static void transform_free(void *opaque)
{
    transform_state *state = opaque;
    cvol_baked_free(&state->baked);
    cvol_splat_subject_free(&state->subject);
    free(state);
}

static int create(cvol_context *context, void **out, const cvol_array *array,
                  const cvol_volume *volume)
{
    *out = NULL;
    transform_state *state = calloc(1, sizeof *state);
    if (!state)
        return cvol_fail_memory(context, sizeof *state, "a renderer");
    const int code = cvol_splat_subject_make(context, &state->subject, array, volume);
    if (code)
        free(state);
    else
        *out = state;
    return code;
}

int cvol_transform_create(cvol_context *context, void **state, const cvol_array *array)
{
    return create(context, state, array, NULL);
}

int cvol_transform_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    return create(context, state, NULL, volume);
}

static int transform_set_transfer(cvol_context *context, void *opaque,
                                  const cvol_transfer *transfer)
{
    transform_state *state = opaque;
    state->has_baked = 0;
    return cvol_splat_subject_set_transfer(context, &state->subject, transfer);
}

int cvol_renderer_transform_report(cvol_context *context, const cvol_renderer *renderer,
                                   cvol_transform_report *out)
{
    const transform_state *state = renderer->state;
    if (renderer->engine != &cvol_transform_engine || !state->has_report)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this renderer has made no picture by transforms");
    *out = state->report;
    return CVOL_OK;
}

/* ---- what a picture needs ------------------------------------------------------------------- */

static int check_options(cvol_context *context, const cvol_render_options *options)
{
    const cvol_transform_options *own = &options->transform;
    if (options->mode != CVOL_MODE_COMPOSITE)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the transform engine has mode composite only");
    if (own->transform < CVOL_DCT || own->transform > CVOL_DFT)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is no transform", (int)own->transform);
    if (own->schedule != CVOL_SCHEDULE_DEFERRED && own->schedule != CVOL_SCHEDULE_LITERAL)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is no schedule", (int)own->schedule);
    if (!(own->rho > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rho is %g, must be above 0", own->rho);
    if (own->transform == CVOL_DCT && own->schedule == CVOL_SCHEDULE_LITERAL)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "a DCT has no phase to shift a slice by: take dft or dht, or the deferred "
                         "schedule, which evaluates it where it is wanted");
    if (options->splat.footprint == CVOL_FOOTPRINT_CONE)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "a cone is no product of lines: the transform engine has footprints "
                         "gaussian, sinc and box");
    return CVOL_OK;
}

/* The footprint at whole samples, as a kernel whose sum is 1. */
static int make_footprint(cvol_context *context, cvol_kernel *out, const cvol_splat_options *splat)
{
    const int radius = (splat->size - 1) / 2;
    const double sigma = splat->sigma > 0 ? splat->sigma : splat->size / 6.0;
    const double pi = acos(-1);
    double taps[2 * CVOL_KERNEL_RADIUS + 1], sum = 0;
    for (int i = -radius; i <= radius; i++) {
        double tap = 1;
        if (splat->footprint == CVOL_FOOTPRINT_GAUSSIAN)
            tap = exp(-0.5 * i * i / (sigma * sigma));
        else if (splat->footprint == CVOL_FOOTPRINT_SINC)
            tap = i ? sin(pi * i) / (pi * i) * pow(cos(pi * i / splat->size), 2) : 1;
        taps[i + radius] = tap;
        sum += tap;
    }
    for (int i = 0; i <= 2 * radius; i++)
        taps[i] /= sum;
    return cvol_kernel_taps(context, out, 2, taps, radius);
}

/* Slices are those of another axis, lattice, opacity, light or number of terms. The picture's size
 * and zoom do not matter: they are the warp's. */
static int is_stale(const transform_state *state, const cvol_splat_plan *plan,
                    const cvol_lattice *lattice, const cvol_splat_light *light,
                    const cvol_transform_options *options)
{
    const cvol_lattice *old = &state->baked.lattice;
    const cvol_transform_options *before = &state->options;
    int stale = !state->has_baked || state->axis_slice != plan->axis_slice ||
                fabs(state->distance - plan->distance) > SAME * plan->distance ||
                before->transform != options->transform || before->rho < options->rho ||
                before->rho > options->rho || old->reach != lattice->reach ||
                memcmp(&state->light, light, sizeof *light) != 0;
    for (int a = 0; a < 2; a++)
        stale |= old->dims[a] != lattice->dims[a] ||
                 fabs(old->shear[a] - lattice->shear[a]) > SAME ||
                 fabs(old->base[a] - lattice->base[a]) > SAME * (double)lattice->dims[a];
    return stale;
}

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int bake(cvol_context *context, transform_state *state, const cvol_splat_plan *plan,
                const cvol_lattice *lattice, const cvol_splat_light *light, int ascending,
                const cvol_transform_options *options)
{
    state->has_baked = 0;
    cvol_baked_free(&state->baked);
    cvol_splat_subject_tabulate(&state->subject, plan->distance, 1);
    const int code = cvol_bake(context, &state->baked, &state->subject.source, plan, lattice,
                               state->subject.table, light, ascending, options);
    if (code)
        return code;
    state->axis_slice = plan->axis_slice;
    state->distance = plan->distance;
    state->light = *light;
    state->options = *options;
    state->has_baked = 1;
    return CVOL_OK;
}

/* ---- from the lattice to pixels ---------------------------------------------------------------
 */

/* Cubic weights (Catmull and Rom 1974) of the four places around. */
static void weigh(double w[4], double f)
{
    w[0] = f * (-0.5 + f * (1 - 0.5 * f));
    w[1] = 1 + f * f * (-2.5 + 1.5 * f);
    w[2] = f * (0.5 + f * (2 - 1.5 * f));
    w[3] = f * f * (-0.5 + 0.5 * f);
}

/* A plane at (u, v); 0 beyond it. */
static double sample(const float *plane, const size_t dims[2], const ptrdiff_t at[2],
                     double w[2][4])
{
    double sum = 0;
    for (ptrdiff_t j = 0; j < 4; j++) {
        const ptrdiff_t y = at[1] + j - 1;
        if (y < 0 || y >= (ptrdiff_t)dims[1])
            continue;
        double line = 0;
        for (ptrdiff_t i = 0; i < 4; i++) {
            const ptrdiff_t x = at[0] + i - 1;
            if (x >= 0 && x < (ptrdiff_t)dims[0])
                line += w[0][i] * (double)plane[x + (ptrdiff_t)dims[0] * y];
        }
        sum += w[1][j] * line;
    }
    return sum;
}

static uint8_t to_byte(double level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5) : 255;
}

static void warp(cvol_context *context, cvol_image *image, const cvol_composed *composed,
                 const cvol_lattice *lattice, const cvol_splat_plan *plan,
                 const double background[3])
{
    const double(*along)[2] = plan->along;
    const double determinant = along[0][0] * along[1][1] - along[0][1] * along[1][0];
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            const double dx = x - plan->origin[0], dy = y - plan->origin[1];
            const double place[2] = {
                lattice->base[0] + (dx * along[1][1] - dy * along[1][0]) / determinant,
                lattice->base[1] + (along[0][0] * dy - along[0][1] * dx) / determinant};
            uint8_t *out = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            ptrdiff_t at[2];
            double w[2][4], through = 1;
            int inside = 1;
            for (int a = 0; a < 2; a++) {
                inside &= place[a] > -2 && place[a] < (double)lattice->dims[a] + 2;
                at[a] = inside ? (ptrdiff_t)floor(place[a]) : 0;
                weigh(w[a], place[a] - (double)at[a]);
            }
            if (inside)
                through = 1 - fmin(fmax(sample(composed->planes[CVOL_PLANE_OPACITY], lattice->dims,
                                               at, w),
                                        0),
                                   1);
            for (int c = 0; c < 3; c++) {
                const double light = inside ? sample(composed->planes[c], lattice->dims, at, w) : 0;
                out[c] = to_byte(fmax(light, 0) + through * background[c]);
            }
            out[3] = 255;
        }
}

/* ---- drawing -------------------------------------------------------------------------------- */

static void fill_report(transform_state *state, const cvol_composed *composed, double bake_ms,
                        double compose_ms)
{
    const cvol_baked *baked = &state->baked;
    const double places = (double)baked->lattice.dims[0] * (double)baked->lattice.dims[1];
    cvol_transform_report *report = &state->report;
    *report = (cvol_transform_report){.lattice = {baked->lattice.dims[0], baked->lattice.dims[1]},
                                      .terms = baked->terms,
                                      .bytes = baked->bytes,
                                      .bound = composed->bound / sqrt(3 * places),
                                      .bake_ms = bake_ms,
                                      .compose_ms = compose_ms};
    for (size_t k = 0; k < baked->slices; k++)
        report->slices += baked->planes[k][0] != NULL;
    if (report->slices)
        report->rho = (double)baked->terms /
                      ((double)report->slices * CVOL_PLANES * (double)baked->lattice.samples);
    state->has_report = 1;
}

static int transform_draw(cvol_context *context, void *opaque, cvol_image *image,
                          const cvol_view *view, const cvol_render_options *options)
{
    transform_state *state = opaque;
    const cvol_splat_options *splat = &options->splat;
    const int front = splat->order == CVOL_ORDER_FRONT;
    cvol_splat_plan plan;
    cvol_splat_light light;
    cvol_kernel footprint;
    int code = check_options(context, options);
    if (!code)
        code = cvol_splat_options_check(context, splat);
    if (!code)
        code = make_footprint(context, &footprint, splat);
    if (code)
        return code;
    memset(&light, 0, sizeof light);
    cvol_splat_plan_make(&plan, &state->subject.grid, view);
    const int ascending = plan.rising == front;
    cvol_splat_light_set(&light, &plan, &state->subject.grid, view, splat, ascending);
    const cvol_lattice lattice = cvol_lattice_make(&plan, (splat->size - 1) / 2 + 1);
    const double start = now_ms();
    const int stale = is_stale(state, &plan, &lattice, &light, &options->transform);
    if (stale)
        code = bake(context, state, &plan, &lattice, &light, ascending, &options->transform);
    if (code)
        return code;
    const double baked = now_ms();
    cvol_composed composed;
    code = cvol_compose(context, &composed, &state->baked, &footprint, plan.rising, front,
                        &options->transform);
    if (!code) {
        warp(context, image, &composed, &state->baked.lattice, &plan, options->background);
        fill_report(state, &composed, stale ? baked - start : 0, now_ms() - baked);
    }
    cvol_composed_free(&composed);
    return code;
}

const cvol_engine_table cvol_transform_engine = {transform_free, transform_set_transfer,
                                                 transform_draw};
