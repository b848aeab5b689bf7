/* Puts an overlay on a grid over the box of a volume. */
#include "tools/overlay/overlay.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"

/* Default depth, as a share of the diagonal of the volume. */
#define DEPTH_SHARE 0.25
/* An overlay that is interpolated to a finer grid is smooth: it needs few bits for this PSNR, while
 * a ratio would ask for no loss, which takes longer. */
#define OVERLAY_PSNR 50
/* Samples along each axis of the first test whether an overlay meets a volume. */
#define FEW 24

/* ---- sources ---- */

/* Puts the name of the file before the message of an error. */
static int name_error(cvol_context *context, int code, const char *path)
{
    char message[400];
    const char *text = cvol_context_message(context);
    if (!code || code == CVOL_ERROR_CANCELLED || !strncmp(text, path, strlen(path)))
        return code;
    snprintf(message, sizeof message, "%s", text);
    return cvol_fail(context, code, "%s: %s", path, message);
}

/* 1 if a sample is NaN. */
static int lacks_values(const cvol_volume *samples)
{
    const size_t count = cvol_grid_samples(&samples->grid);
    size_t i = 0;
    if (samples->grid.type == CVOL_FLOAT32)
        while (i < count && !isnan(((const float *)samples->data)[i]))
            i++;
    else if (samples->grid.type == CVOL_FLOAT64)
        while (i < count && !isnan(((const double *)samples->data)[i]))
            i++;
    else
        return 0;
    return i < count;
}

int overlay_measure(cvol_context *context, overlay_source *source)
{
    source->grid = source->samples->grid;
    const int code = source->is_numbered ? CVOL_OK
                                         : cvol_volume_compute_histogram(
                                               context, &source->histogram, source->samples);
    source->has_one_value = !code && !source->is_numbered &&
                            !(source->histogram.max > source->histogram.min) &&
                            !lacks_values(source->samples);
    return name_error(context, code, source->path);
}

static int fail_outside(cvol_context *context, const overlay_source *source, const char *name)
{
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "%s: lies outside of %s: they have no place in common", source->path, name);
}

/* *inside: how many samples of the overlay's grid over the volume lie in the overlay. */
static int resample(cvol_context *context, cvol_volume **out, uint64_t *inside,
                    const overlay_source *source, const cvol_volume *samples, const cvol_grid *grid)
{
    const int code = cvol_volume_resample(context, out, inside, samples, grid, source->is_labels);
    return name_error(context, code, source->path);
}

/* The same box with few samples. */
static cvol_grid thin_out(const cvol_grid *grid)
{
    cvol_grid few = *grid;
    for (int a = 0; a < 3; a++)
        if (few.dims[a] > FEW) {
            few.spacing[a] *= (double)(few.dims[a] - 1) / (FEW - 1);
            few.dims[a] = FEW;
        }
    return few;
}

int overlay_check(cvol_context *context, const overlay_source *source, const cvol_grid *grid,
                  const char *name)
{
    cvol_grid own, few;
    cvol_volume *out = NULL;
    uint64_t inside = 0;
    int code = cvol_grid_coarsen(context, &own, grid, &source->grid);
    few = code ? *grid : thin_out(&own);
    /* Equal dims may stand for equal places: other dims must not. */
    const int is_thin = memcmp(few.dims, own.dims, sizeof few.dims) != 0 &&
                        source->grid.space != CVOL_SPACE_UNKNOWN &&
                        grid->space != CVOL_SPACE_UNKNOWN;
    if (!code && is_thin)
        code = resample(context, &out, &inside, source, source->samples, &few);
    if (!code && !inside) {
        cvol_volume_free(out);
        out = NULL;
        code = resample(context, &out, &inside, source, source->samples, &own);
    }
    cvol_volume_free(out);
    if (!code && !inside)
        code = fail_outside(context, source, name);
    return name_error(context, code, source->path);
}

/* ---- fitting ---- */

/* Compresses the resampled volume for engine sheet, and frees it. */
static int compress(cvol_context *context, overlay *o)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.effort = CVOL_EFFORT_FAST;
    options.lossless = o->of->is_labels;
    options.has_fill = lacks_values(o->volume);
    options.fill = NAN;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = OVERLAY_PSNR;
    const int code = cvol_compress(context, &o->array, NULL, o->volume->data, &o->volume->grid,
                                   &options);
    cvol_volume_free(o->volume);
    o->volume = NULL;
    return code;
}

static int make_mask(cvol_context *context, overlay *o)
{
    const size_t count = cvol_grid_samples(&o->volume->grid);
    if (!lacks_values(o->volume))
        return CVOL_OK;
    o->mask = malloc(count);
    for (size_t i = 0; i < count && o->mask; i++)
        o->mask[i] = (uint8_t)(isnan(((const float *)o->volume->data)[i]) != 0);
    return o->mask ? CVOL_OK : cvol_fail_memory(context, count, "the mask of an overlay");
}

/* Makes what the engine draws from the resampled volume. */
static int prepare(cvol_context *context, overlay *o, cvol_engine engine)
{
    const int is_sheet = engine == CVOL_ENGINE_SHEET;
    if (!o->of->is_numbered)
        return is_sheet ? compress(context, o) : make_mask(context, o);
    o->numbers = o->volume;
    o->volume = NULL;
    return is_sheet ? cvol_labels_create_shape(context, &o->array, o->numbers)
                    : cvol_labels_create_mask(context, &o->volume, o->numbers);
}

/* The numbers of a source without those that are not chosen. */
static int choose(cvol_context *context, cvol_volume **out, const overlay_source *source,
                  const uint8_t *chosen)
{
    uint8_t keeps[OVERLAY_LABELS_MAX + 1] = {0};
    const size_t count = cvol_grid_samples(&source->grid);
    const int code = cvol_volume_create(context, out, &source->grid);
    if (code)
        return code;
    for (size_t k = 0; k < source->count; k++)
        keeps[k + 1] = chosen[k] ? (uint8_t)(k + 1) : 0;
    for (size_t i = 0; i < count; i++)
        ((uint8_t *)(*out)->data)[i] = keeps[((const uint8_t *)source->samples->data)[i]];
    return CVOL_OK;
}

static double mean_spacing(const cvol_grid *grid)
{
    return (grid->spacing[0] + grid->spacing[1] + grid->spacing[2]) / 3;
}

static void compare_grids(overlay *o, const cvol_grid *own, const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++)
        o->share[a] = grid->dims[a] > 1 ? (double)(own->dims[a] - 1) / (double)(grid->dims[a] - 1)
                                        : 1;
    o->density = mean_spacing(own) / mean_spacing(grid);
}

int overlay_fit(cvol_context *context, overlay *out, const overlay_source *source,
                const cvol_grid *grid, const char *name, cvol_engine engine, const uint8_t *chosen)
{
    cvol_grid own;
    cvol_volume *few = NULL;
    uint64_t inside = 0;
    *out = (overlay){.of = source};
    int code = cvol_grid_coarsen(context, &own, grid, &source->grid);
    if (!code && chosen && source->is_numbered)
        code = choose(context, &few, source, chosen);
    if (!code)
        code = resample(context, &out->volume, &inside, source, few ? few : source->samples, &own);
    cvol_volume_free(few);
    if (!code && !inside)
        code = fail_outside(context, source, name);
    if (!code) {
        compare_grids(out, &own, grid);
        out->overlap = (double)inside / (double)cvol_grid_samples(&own);
        code = prepare(context, out, engine);
    }
    return name_error(context, code, source->path);
}

void overlay_free(overlay *o)
{
    cvol_array_free(o->array);
    cvol_volume_free(o->volume);
    cvol_volume_free(o->numbers);
    free(o->mask);
    *o = (overlay){.of = NULL};
}

int overlay_create_renderer(cvol_context *context, cvol_renderer **out, const overlay *o,
                            cvol_engine engine)
{
    const cvol_source source = {.size = sizeof source,
                                .array = o->array,
                                .volume = o->array ? NULL : o->volume,
                                .mask = o->mask};
    return name_error(context, cvol_renderer_create(context, out, engine, &source), o->of->path);
}

double overlay_default_depth(const cvol_grid *grid)
{
    double sum = 0;
    for (int k = 0; k < 3; k++)
        sum = hypot(sum, (double)grid->dims[k] * grid->spacing[k]);
    return DEPTH_SHARE * sum;
}
