/* Certified pictures (certify.h): for each pixel and channel an interval that contains the value
 * that engine ray has for the original samples, of which only |original - drawn| <= e is known.
 *
 * Theorem. Let v be the drawn volume and v' any volume of the same grid, type and mask, with
 * |v' - v| <= e at every sample, and v' within the given range. Then engine ray's picture of v',
 * with the same options, lies between the two pictures.
 *
 * Proof. Rays, their samples' places and weights, and the cover of the mask do not depend on the
 * samples, so the rays of v' have the same intervals (walk.h). bound.c bounds the effect of each
 * interval: the light in front of it, for all lights behind it. In the modes other than composite
 * the value of a ray is a mean, the largest or the smallest of its samples, so it moves by at most
 * e.
 *
 * Compositing. Engine ray goes from front to back; here bounds go from back to front, C = a c + (1
 * - a) C', beginning with the background. This is the same sum. Opacities that are uncertain in
 * front thus cancel where the light behind has the same colour, which intervals of transmittances
 * would not show. Engine ray ends a ray when its transmittance is below 1/1024, and the background
 * follows at once. Behind every interval where the product of the least transmittances is below
 * 1/1024, the light is therefore also allowed to be the background. If the product of the
 * largest ones is below it where engine ray tests it, the ray has ended in all cases.
 *
 * Window. Without a window in the options, black and white of the modes xray, mip and min are the
 * least and the largest sample of v', m' and M'. They are within e of those of v. The level
 * (x - m') / (M' - m') falls with m' and with M', for x between them.
 *
 * Slack. All levels get 2^-16, times the largest factor of light if that is more: 1/257 of a step
 * of bytes. It covers the rounding of floats in pictures and in the table's colours (2^-24 each),
 * of double precision in sums over n intervals (n 2^-52), and of values above 1. Values get 2^-44
 * of the largest sample, 256 times the rounding of one operation, and means 2^-50 per sample. The
 * test of the transmittance has a margin of 10^-6 of it. Windows narrower than the range of samples
 * magnify the rounding of floats: 2^-21 of range / width and of offset / width more. Bytes:
 * rounding is monotone. */
#include "render/ray/certify.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/ray/bound.h"
#include "render/ray/cast.h"
#include "render/view/shading.h"

#define SLACK 0x1p-16
#define VALUE_ROUNDING 0x1p-44
#define MEAN_ROUNDING 0x1p-50
#define FLOAT_ROUNDING 0x1p-21
#define THRESHOLD_MARGIN 1e-6

/* The table of engine ray has at least this many cells over the range of the samples. */
#define CELLS_MIN 16384.0
/* Cells of the original's table beyond its range, and one more. */
#define MARGIN_CELLS 4

/* The least and the most light of a pixel, in four channels. */
typedef struct pixel_bounds {
    double light[2][4];
    double slack;
} pixel_bounds;

/* All of a picture. */
typedef struct picture_doubt {
    cvol_ray_doubt doubt;
    cvol_ray_job job;
    cvol_image *images[2];
    int channels;         /* 3 over the background, or 4 over none */
    double background[4]; /* 0 for floats */
    double slack;
    double error;    /* as given */
    double known[2]; /* range of the original samples */
    int has_window;
    double window[2]; /* of grey modes */
    size_t most_steps;
} picture_doubt;

/* ---- composite ----------------------------------------------------------------------------- */

/* The visible intervals of a ray, from front to back. */
typedef struct ray_record {
    const cvol_ray_doubt *doubt;
    cvol_ray_bound *bounds; /* with room for all intervals of a ray */
    size_t count;
    double through[2]; /* the transmittance up to here: least, most */
} ray_record;

static int record_step(void *user, const cvol_ray_job *job, const cvol_ray_step *step)
{
    ray_record *record = user;
    cvol_ray_bound *bound = &record->bounds[record->count];
    (void)job;
    if (!cvol_ray_bound_step(bound, record->doubt, step, record->through[1]))
        return 0;
    record->count++;
    for (int k = 0; k < 2; k++)
        record->through[k] *= bound->through[k];
    bound->may_end = record->through[0] < CVOL_RAY_TRANSMITTANCE_MIN * (1 + THRESHOLD_MARGIN);
    return record->through[1] < CVOL_RAY_TRANSMITTANCE_MIN * (1 - THRESHOLD_MARGIN);
}

static void bound_composite(pixel_bounds *out, const picture_doubt *p, const cvol_ray_path *path,
                            cvol_ray_bound *room)
{
    ray_record record = {&p->doubt, room, 0, {1, 1}};
    cvol_ray_walk(&p->job, path, record_step, &record);
    for (size_t k = record.count; k-- > 0;) {
        const cvol_ray_bound *bound = &record.bounds[k];
        for (int c = 0; c < p->channels && bound->may_end; c++) {
            out->light[0][c] = fmin(out->light[0][c], p->background[c]);
            out->light[1][c] = fmax(out->light[1][c], p->background[c]);
        }
        cvol_ray_bound_apply(out->light, bound, p->channels);
    }
    /* Bytes stay the background's exactly where nothing is visible. */
    out->slack = record.count || p->channels > 3 ? p->slack : 0;
}

/* ---- grey modes ------------------------------------------------------------------------------ */

/* Bounds of (x - m') / (M' - m') for a value within x[0] .. x[1], which has this rounding. If M'
 * may be next to m', the rounding of a mean of n samples, n 2^-53 of the largest, may be 2 n times
 * their distance. */
static void level_of_range(double out[2], double *slack, const picture_doubt *p, const double x[2],
                           double rounding, double samples)
{
    const cvol_ray_field *field = &p->job.state->field;
    const double e = p->doubt.known.error;
    const double black[2] = {fmax(field->min - e, p->known[0]), field->min + e},
                 white[2] = {field->max - e, fmin(field->max + e, p->known[1])};
    out[0] = 0;
    out[1] = 1;
    if (!(white[0] > black[1])) {
        *slack += 4 * samples;
        return;
    }
    *slack += rounding / (white[0] - black[1]);
    if (x[0] > black[1])
        out[0] = (x[0] - black[1]) / (white[1] - black[1]);
    if (x[1] < white[0])
        out[1] = (x[1] - black[0]) / (white[0] - black[0]);
}

static void level_of_window(double out[2], double *slack, const picture_doubt *p, const double x[2])
{
    const cvol_ray_known *known = &p->doubt.known;
    const double width = p->window[1] - p->window[0];
    for (int k = 0; k < 2; k++)
        out[k] = (x[k] - p->window[0]) / width;
    *slack += FLOAT_ROUNDING *
              ((known->max - known->min) / width +
               fmax(fabs(known->min - p->window[0]), fabs(known->max - p->window[0])) / width);
}

static void bound_grey(pixel_bounds *out, const picture_doubt *p, const cvol_ray_path *path, int i,
                       int j)
{
    const cvol_ray_field *field = &p->job.state->field;
    const cvol_ray_known *known = &p->doubt.known;
    const cvol_ray_seen seen = cvol_ray_cast(&p->job, i, j);
    if (seen.through > 0)
        return;
    const double value = field->min + seen.rgb[0] * (field->max - field->min);
    const double largest = fmax(fabs(known->min), fabs(known->max));
    const double samples = (double)path->steps + 4, rounding = MEAN_ROUNDING * samples * largest;
    const double error = known->error + rounding;
    const double x[2] = {fmin(fmax(value - error, known->min), known->max),
                         fmax(fmin(value + error, known->max), known->min)};
    double level[2];
    out->slack = SLACK;
    if (p->has_window)
        level_of_window(level, &out->slack, p, x);
    else
        level_of_range(level, &out->slack, p, x, rounding, samples);
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++)
            out->light[k][c] = level[k];
        out->light[k][3] = 1;
    }
}

/* ---- pictures -------------------------------------------------------------------------------- */

static void put_pixel(const picture_doubt *p, const pixel_bounds *bounds, int i, int j)
{
    for (int k = 0; k < 2; k++) {
        const cvol_image *image = p->images[k];
        const size_t at = 4 * ((size_t)image->width * (size_t)j + (size_t)i);
        const double slack = k ? bounds->slack : -bounds->slack;
        for (int c = 0; c < 4; c++) {
            const double level = bounds->light[k][c] + slack;
            if (image->values)
                image->values[at + (size_t)c] = (float)level;
            else
                image->rgba[at + (size_t)c] = c < 3 ? cvol_ray_to_byte(level) : 255;
        }
    }
}

static void bound_row(const picture_doubt *p, cvol_ray_bound *room, int j)
{
    for (int i = 0; i < p->images[0]->width; i++) {
        pixel_bounds bounds = {.slack = 0};
        cvol_ray_path path;
        for (int c = 0; c < 4; c++)
            bounds.light[0][c] = bounds.light[1][c] = p->background[c];
        if (cvol_ray_path_make(&path, &p->job, i, j)) {
            if (p->job.mode == CVOL_MODE_COMPOSITE)
                bound_composite(&bounds, p, &path, room);
            else
                bound_grey(&bounds, p, &path, i, j);
        }
        put_pixel(p, &bounds, i, j);
    }
}

/* In bands; between them it reports progress and checks for cancellation. Each thread has room for
 * the intervals of a ray. */
static int bound_rows(cvol_context *context, const picture_doubt *p)
{
    const int threads = cvol_context_threads(context), height = p->images[0]->height;
    const size_t intervals = p->job.mode == CVOL_MODE_COMPOSITE ? p->most_steps + 1 : 1;
    int code = CVOL_OK, failed = 0;
    for (int first = 0; first < height && !code; first += CVOL_RAY_BAND) {
        const int end = height - first < CVOL_RAY_BAND ? height : first + CVOL_RAY_BAND;
#pragma omp parallel num_threads(threads)
        {
            cvol_ray_bound *room = cvol_allocate(intervals, sizeof *room);
            if (!room) {
#pragma omp atomic write
                failed = 1;
            }
#pragma omp for schedule(dynamic)
            for (int j = first; j < end; j++)
                if (room)
                    bound_row(p, room, j);
            free(room);
        }
        code = failed ? cvol_fail_memory(context, intervals * sizeof(cvol_ray_bound),
                                         "the intervals of a ray")
                      : cvol_report_progress(context, "certifying", (double)end / height);
    }
    return code;
}

static void find_most_steps(picture_doubt *p)
{
    cvol_ray_path path;
    for (int j = 0; j < p->images[0]->height; j++)
        for (int i = 0; i < p->images[0]->width; i++)
            if (cvol_ray_path_make(&path, &p->job, i, j) && path.steps > p->most_steps)
                p->most_steps = path.steps;
}

/* ---- preparation ----------------------------------------------------------------------------- */

/* Finds the error and the range of the original samples. */
static int find_known(cvol_context *context, picture_doubt *p, const double range[2])
{
    const cvol_ray_field *field = &p->job.state->field;
    cvol_ray_known *known = &p->doubt.known;
    const double least = field->min - p->error, most = field->max + p->error;
    p->known[0] = range ? fmax(least, range[0]) : least;
    p->known[1] = range ? fmin(most, range[1]) : most;
    if (!(p->known[0] <= p->known[1]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "no sample that is within %g of %g to %g is within %g to %g", p->error,
                         field->min, field->max, range ? range[0] : least, range ? range[1] : most);
    const double rounding = VALUE_ROUNDING * fmax(fabs(least), fabs(most));
    known->rounding = rounding;
    known->error = p->error * (1 + VALUE_ROUNDING) + rounding;
    known->min = p->known[0] - rounding;
    known->max = p->known[1] + rounding;
    known->cell = (known->max - known->min) * (1.01 / CELLS_MIN) + 4 * rounding + 1e-300;
    if (!isfinite((known->max - known->min) * 2))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "samples from %g to %g: certified pictures need a smaller range",
                         field->min, field->max);
    p->known[0] = known->min;
    p->known[1] = known->max;
    return CVOL_OK;
}

/* Bounds of the gradient of flat matter, which depends on the range of the original samples. */
static void find_flats(cvol_ray_light *light, const picture_doubt *p)
{
    const cvol_ray_state *state = p->job.state;
    const double width = cvol_transfer_width(state->transfer),
                 known = p->doubt.known.max - p->doubt.known.min,
                 decoded = state->field.max - state->field.min,
                 least = fmax(decoded * (1 - VALUE_ROUNDING) - 2 * p->doubt.known.error, 0);
    if (p->job.mode == CVOL_MODE_ISO)
        return;
    light->flats[0] = fmin(light->flat, cvol_flat_gradient(width, least));
    light->flats[1] = fmax(light->flat, cvol_flat_gradient(width, known));
}

static int make_tables(cvol_context *context, picture_doubt *p)
{
    const cvol_ray_known *known = &p->doubt.known;
    const double margin = MARGIN_CELLS * known->cell;
    if (p->job.mode != CVOL_MODE_COMPOSITE)
        return CVOL_OK;
    const int code = cvol_ray_table_make(context, &p->job.table, p->job.state->transfer,
                                         known->min - margin, known->max + margin,
                                         p->job.table.step);
    return code ? code
                : cvol_ray_envelope_make(context, &p->doubt.envelope, p->job.state->transfer,
                                         known->min - margin, known->max + margin);
}

int cvol_ray_certify(cvol_context *context, void *state, cvol_image *lower, cvol_image *upper,
                     const cvol_view *view, const cvol_render_options *options, double error,
                     const double range[2])
{
    const int floats = lower->values != NULL;
    const cvol_shading *shading = &options->shading;
    cvol_ray_light light;
    picture_doubt p = {.images = {lower, upper},
                       .channels = floats ? 4 : 3,
                       .error = error,
                       .has_window = options->window[1] > options->window[0],
                       .window = {options->window[0], options->window[1]},
                       .slack = SLACK};
    p.job = cvol_ray_job_make(state, &light, view, options);
    p.doubt.job = &p.job;
    for (int c = 0; c < 3 && !floats; c++)
        p.background[c] = options->background[c];
    if (shading->on)
        p.slack *= fmax(1, shading->ambient + shading->diffuse + shading->specular +
                               options->illumination.fill);
    find_most_steps(&p);
    int code = find_known(context, &p, range);
    if (!code)
        find_flats(&light, &p);
    if (!code)
        code = make_tables(context, &p);
    if (!code)
        code = bound_rows(context, &p);
    cvol_ray_table_free(&p.job.table);
    cvol_ray_envelope_free(&p.doubt.envelope);
    return code;
}
