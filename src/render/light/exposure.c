/* Exposure (exposure.h): over the cells that the eye sees, each with the weight of its opacity
 * behind what is before it. */
#include "render/light/exposure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/light/sweep.h"
#include "render/view/light.h"
#include "render/view/shading.h"

#define DIMMER 0.9
#define BURNT 0.01
#define DIMMEST 0.75
/* From this share of what is seen that would be white, the exposure goes down to DIMMEST times the
 * ratio; without any, to DIMMER; and between them in proportion. A step would be a flicker while a
 * volume turns, and a steep change another light while parts of a file are still to come. */
#define WHITE_MANY 0.3
/* Sweeps along axes that have this share of the longest count too. */
#define NEARLY 0.8
/* Levels of brightness that are counted, up to the last. */
#define LEVELS 256
#define LEVEL_MOST 4.0
#define EXPOSURE_MIN 0.5
#define EXPOSURE_MAX 3.0
/* Of more cells than this, one in five is looked at: those where x + 2 y + 3 z is a multiple of
 * five, one in five of each row of each axis. */
#define CELLS_MAX 65536
#define SPARSE 5

/* Sums over the rows of a slice, which add to them one after the other. */
typedef struct brightness_job {
    const cvol_lit_cells *cells;
    const cvol_transfer *transfer;
    const cvol_render_options *options;
    const cvol_view *view;
    double light[3], rise[3], flat;
    int fades;   /* gradients are shorter at cuts */
    size_t step; /* every step-th cell of a row: 1 or SPARSE */
    struct cell {
        float unlit, lit, seen; /* brightness, and the share of the cell in the picture */
    } * cells_seen;
} brightness_job;

static double brightness_of(const brightness_job *job, double value)
{
    if (job->options->mode == CVOL_MODE_ISO) {
        const double *c = job->options->surface.colour;
        return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    }
    const cvol_transfer_point p = cvol_transfer_at(job->transfer, value);
    return 0.2126 * p.r + 0.7152 * p.g + 0.0722 * p.b;
}

/* The factor of Phong's model in a cell, by its neighbours. */
static double phong_of(const brightness_job *job, size_t i)
{
    const cvol_coarse *coarse = job->cells->coarse;
    const size_t *n = coarse->dims, apart[3] = {1, n[0], n[0] * n[1]};
    const size_t cell[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
    const cvol_shading *shading = &job->options->shading;
    const double *eye = job->view->eye;
    double normal[3], place[3], facing = 0, lit = 0, seen = 0;
    for (int a = 0; a < 3; a++)
        place[a] = coarse->first[a] + (double)cell[a] * coarse->pitch[a];
    const double fade = job->fades ? cvol_view_fade(job->view, place) : 1;
    for (int a = 0; a < 3; a++) {
        const size_t behind = cell[a] + 1 < n[a] ? i + apart[a] : i,
                     before = cell[a] ? i - apart[a] : i;
        normal[a] = fade * job->rise[a] * (double)(coarse->values[behind] - coarse->values[before]);
    }
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] +
                               normal[2] * normal[2]);
    for (int a = 0; a < 3; a++) {
        const double part = length > 0 ? normal[a] / length : eye[a];
        lit += part * job->light[a];
        seen += part * eye[a];
        facing += eye[a] * job->light[a];
    }
    const double flat = job->flat * job->flat,
                 flatness = flat > 0 ? flat / (length * length + flat) : 0;
    lit = cvol_light_turn(lit, seen, facing) * (1 - flatness) + facing * flatness;
    seen = fabs(seen) * (1 - flatness) + flatness;
    return shading->ambient + shading->diffuse * fmax(lit, 0) +
           job->options->illumination.fill * seen;
}

/* The first cell of a row that is looked at. */
static size_t first_of_row(const brightness_job *job, size_t first, size_t stride)
{
    const size_t *n = job->cells->coarse->dims;
    const size_t weight = stride == 1 ? 1 : stride == n[0] ? 2 : 3;
    const size_t sum = first % n[0] + 2 * (first / n[0] % n[1]) + 3 * (first / n[0] / n[1]);
    size_t k = 0;
    while ((sum + k * weight) % job->step)
        k++;
    return k;
}

static void add_brightness(void *user, const float *depths, size_t first, size_t count,
                           size_t stride)
{
    const brightness_job *job = user;
    const cvol_lit_cells *cells = job->cells;
    double cell = 0;
    for (int a = 0; a < 3; a++)
        cell += cells->coarse->length[a] / 3;
    for (size_t k = first_of_row(job, first, stride); k < count; k += job->step) {
        const size_t i = first + k * stride;
        const double depth = cell * (double)cells->extinction[i];
        struct cell *to = &job->cells_seen[i];
        *to = (struct cell){0, 0, 0};
        if (!(depth > 1e-3) || depths[k] > 6)
            continue;
        const double seen = (1 - exp(-depth)) * (double)cvol_sweep_transmittance(depths[k]);
        const double unlit = seen * brightness_of(job, cvol_coarse_value(cells->coarse, i));
        to->seen = (float)seen;
        to->unlit = (float)unlit;
        to->lit = (float)(unlit * phong_of(job, i)) * cells->factors[i];
    }
}

/* The share of what is seen that is white at an exposure. Levels count in part: see WHITE_MANY. */
static double white_share(const double seen[LEVELS], double all, double exposure)
{
    const double from = LEVELS / (LEVEL_MOST * exposure); /* the lowest white level */
    double white = 0;
    for (int k = LEVELS - 1; k >= 0 && k + 1 > from; k--)
        white += seen[k] * fmin(k + 1 - from, 1);
    return all > 0 ? white / all : 0;
}

/* The largest exposure at which all but BURNT of what is seen stays below white. */
static double unburnt_exposure(const double seen[LEVELS], double all)
{
    double left = BURNT * all, level = LEVELS;
    for (int k = LEVELS - 1; k > 0; k--) {
        if (seen[k] > left) {
            level = k + 1 - left / seen[k];
            break;
        }
        left -= seen[k];
        level = k;
    }
    return LEVELS / (level * LEVEL_MOST);
}

/* The ratio of both sums, or down to DIMMER of it so that all but BURNT of what is seen stays below
 * white; down to DIMMEST if much would be white even so, as on white objects, and with light that
 * is scattered once, whose contrast is larger. */
static double choose_exposure(const brightness_job *job, size_t count)
{
    const size_t width = job->cells->coarse->dims[0];
    double unlit = 0, lit = 0, all = 0, seen[LEVELS] = {0};
    for (size_t row = 0; row < count; row += width)
        for (size_t k = first_of_row(job, row, 1); k < width; k += job->step) {
            const struct cell *cell = &job->cells_seen[row + k];
            if (!(cell->unlit > 0))
                continue;
            unlit += (double)cell->unlit;
            lit += (double)cell->lit;
            all += (double)cell->seen;
            const double at = (double)(cell->lit / cell->seen) * LEVELS / LEVEL_MOST;
            seen[at < LEVELS ? (int)at : LEVELS - 1] += (double)cell->seen;
        }
    if (!(lit > 0))
        return 1;
    const double wanted = unlit / lit, white = unburnt_exposure(seen, all);
    const double many = white_share(seen, all, DIMMER * wanted) / WHITE_MANY;
    const double share = job->options->illumination.samples ? 1 : fmin(fmax(many, 0), 1);
    const double least = DIMMER + share * (DIMMEST - DIMMER);
    return fmin(fmax(fmax(fmin(wanted, white), least * wanted), EXPOSURE_MIN), EXPOSURE_MAX);
}

static double range_of(const cvol_coarse *coarse)
{
    const size_t count = cvol_coarse_count(coarse);
    float least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        const float value = coarse->values[i];
        least = value < least ? value : least;
        most = value > most ? value : most;
    }
    return (double)(most - least);
}

/* A sweep along each axis that is nearly the longest of the way to the eye, and its weight. A
 * single sweep would change its axis, and with it the exposure, at one angle of a turn. */
static void find_sweeps(double directions[3][3], double share[3], const double eye[3],
                        const cvol_coarse *coarse)
{
    double most = 0;
    for (int a = 0; a < 3; a++)
        most = fmax(most, fabs(eye[a]) / coarse->length[a]);
    for (int a = 0; a < 3; a++) {
        const double along = fabs(eye[a]) / coarse->length[a] / most;
        share[a] = fmax((along - NEARLY) / (1 - NEARLY), 0);
        memcpy(directions[a], eye, sizeof directions[a]);
        if (along < 1) /* the sweep goes along this axis, at the next direction where it does */
            directions[a][a] *= 1.0001 / fmax(along, NEARLY);
    }
}

int cvol_exposure_find(cvol_context *context, double *exposure, const cvol_lit_cells *cells,
                       const cvol_grid *grid, const cvol_transfer *transfer, const cvol_view *view,
                       const cvol_render_options *options)
{
    const size_t count = cvol_coarse_count(cells->coarse);
    const double *given = options->shading.light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    brightness_job job = {
        .cells = cells, .transfer = transfer, .options = options, .view = view, .step = 1};
    cvol_sweep sweep = {.keep = 1};
    for (int a = 0; a < 3; a++) {
        job.light[a] = length > 0 ? given[a] / length : view->eye[a];
        job.rise[a] = 0.5 * view->mean_spacing / (cells->coarse->pitch[a] * grid->spacing[a]);
    }
    if (options->mode != CVOL_MODE_ISO)
        job.flat = cvol_flat_gradient(cvol_transfer_width(transfer), range_of(cells->coarse));
    job.fades = view->cuts && options->mode != CVOL_MODE_ISO &&
                !(options->shading.gradient_opacity > 0);
    if (count > CELLS_MAX)
        job.step = SPARSE;
    job.cells_seen = cvol_allocate(count, sizeof *job.cells_seen);
    if (!job.cells_seen)
        return cvol_fail_memory(context, count * sizeof *job.cells_seen, "the light in a volume");
    double sum = 0, weights = 0, directions[3][3], share[3];
    find_sweeps(directions, share, view->eye, cells->coarse);
    int code = CVOL_OK;
    for (int a = 0; a < 3 && !code; a++) {
        if (!(share[a] > 0))
            continue;
        memcpy(sweep.way, directions[a], sizeof sweep.way);
        code = cvol_sweep_run(context, cells->coarse, cells->extinction, &sweep, add_brightness,
                              &job);
        sum += code ? 0 : share[a] * choose_exposure(&job, count);
        weights += share[a];
    }
    if (!code)
        *exposure = sum / weights;
    free(job.cells_seen);
    return code;
}
