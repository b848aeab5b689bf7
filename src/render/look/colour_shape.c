/* The shape of RGB samples, and its transfer function (cvol/look.h). */
#include "render/look/colours.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/options.h"
#include "cvol/algebra.h"

/* Of the largest values of a sum: transparent below the first, opaque above the second. At a hard
 * edge, interpolated values take all levels from black to those of the object: with a short rise
 * the surface would lie near the outer samples and show their steps. */
#define CLEAR_PART 0.02
#define OPAQUE_PART 0.35
#define OPACITY 0.3
/* A background ends at most here. */
#define BACKGROUND_MOST 0.3
/* Of the shape, along each axis. */
#define BLUR_RADIUS 2
static const double blur[2 * BLUR_RADIUS + 1] = {1 / 16., 4 / 16., 6 / 16., 4 / 16., 1 / 16.};
/* ---- sources ------------------------------------------------------------------------------- */

int cvol_colour_source_complete(cvol_context *context, cvol_colour_source *out,
                                const cvol_colour_source *source)
{
    *out = (cvol_colour_source){.size = sizeof *out};
    const int code = cvol_options_copy(context, out, sizeof *out,
                                       CVOL_SIZE_TO(cvol_colour_source, range),
                                       "cvol_colour_source", source);
    if (code)
        return code;
    if ((out->arrays != NULL) + (out->volumes != NULL) != 1)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "colours have components of one kind: arrays or volumes");
    if (out->count < 1 + (out->has_alpha != 0) || out->count > CVOL_COLOURS_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "colours have 1 to %d components, besides alpha at least one; %zu are "
                         "given",
                         CVOL_COLOURS_MAX, out->count);
    if (!isfinite(out->range[0]) || !(out->range[1] > out->range[0]) || !isfinite(out->range[1]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a range of components from %g to %g: must be finite, the second larger",
                         out->range[0], out->range[1]);
    const cvol_grid *first = cvol_colour_source_grid(out);
    for (size_t c = 1; c < out->count; c++) {
        const cvol_grid *grid = out->arrays ? cvol_array_grid(out->arrays[c])
                                            : &out->volumes[c]->grid;
        if (memcmp(grid->dims, first->dims, sizeof grid->dims))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "component %zu has %zu x %zu x %zu samples, component 0 has %zu x %zu "
                             "x %zu",
                             c, grid->dims[0], grid->dims[1], grid->dims[2], first->dims[0],
                             first->dims[1], first->dims[2]);
    }
    return CVOL_OK;
}

const cvol_grid *cvol_colour_source_grid(const cvol_colour_source *source)
{
    return source->arrays ? cvol_array_grid(source->arrays[0]) : &source->volumes[0]->grid;
}

/* ---- the shape ----------------------------------------------------------------------------- */

/* Replaces *array by `next`, the result of an operation on it. */
static int replace(cvol_array **array, cvol_array *next, int code)
{
    cvol_array_free(*array);
    *array = code ? NULL : next;
    return code;
}

/* Blurs by BLUR along each axis. Steps at hard edges, and noise, would make light uneven; colours
 * come from the components, and stay sharp. */
static int blur_array(cvol_context *context, cvol_array **array)
{
    cvol_kernel kernel;
    cvol_array *blurred = NULL;
    int code = cvol_kernel_taps(context, &kernel, 3, blur, BLUR_RADIUS);
    if (!code)
        code = cvol_array_convolve_kernel(context, &blurred, *array, &kernel, NULL);
    return replace(array, blurred, code);
}

/* out = the blurred sum of arrays. */
static int add_arrays(cvol_context *context, cvol_array **out, const cvol_array *const *arrays,
                      size_t count)
{
    cvol_array *sum = NULL;
    int code = cvol_array_scale(context, &sum, 1, arrays[0], 0);
    for (size_t c = 1; c < count && !code; c++) {
        cvol_array *next = NULL;
        code = cvol_array_add(context, &next, 1, sum, 1, arrays[c], NULL);
        replace(&sum, next, code);
    }
    if (!code)
        code = blur_array(context, &sum);
    if (!code)
        code = cvol_array_ensure_ranges(context, sum);
    if (code) {
        cvol_array_free(sum);
        sum = NULL;
    }
    *out = sum;
    return code;
}

/* Blurs rows of `width` samples along an axis; the face repeats. */
static void blur_along(cvol_context *context, float *to, const float *from, const size_t n[3],
                       int axis)
{
    const size_t step = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t row = 0; row < n[1] * n[2]; row++)
        for (size_t x = 0; x < n[0]; x++) {
            const size_t at[3] = {x, row % n[1], row / n[1]}, here = x + n[0] * row;
            float sum = 0;
            for (int k = -BLUR_RADIUS; k <= BLUR_RADIUS; k++) {
                const ptrdiff_t last = (ptrdiff_t)n[axis] - 1, place = (ptrdiff_t)at[axis] + k,
                                inside = place < 0      ? 0
                                         : place > last ? last
                                                        : place;
                sum += (float)blur[k + BLUR_RADIUS] *
                       from[(ptrdiff_t)here + (inside - (ptrdiff_t)at[axis]) * (ptrdiff_t)step];
            }
            to[here] = sum;
        }
}

static int blur_volume(cvol_context *context, cvol_volume *volume)
{
    const size_t *n = volume->grid.dims, count = n[0] * n[1] * n[2];
    float *samples = volume->data, *work = cvol_allocate(count, sizeof *work);
    if (!work)
        return cvol_fail_memory(context, count * sizeof *work, "a blurred volume");
    blur_along(context, work, samples, n, 0);
    blur_along(context, samples, work, n, 1);
    blur_along(context, work, samples, n, 2);
    memcpy(samples, work, count * sizeof *work);
    free(work);
    return CVOL_OK;
}

static int add_volumes(cvol_context *context, cvol_volume **out, const cvol_volume *const *volumes,
                       size_t count)
{
    cvol_grid grid = volumes[0]->grid;
    grid.type = CVOL_FLOAT32;
    const int code = cvol_volume_create(context, out, &grid);
    if (code)
        return code;
    float *to = (*out)->data;
    const size_t rows = grid.dims[1] * grid.dims[2], width = grid.dims[0];
    float *row = cvol_allocate(width, sizeof *row);
    if (!row) {
        cvol_volume_free(*out);
        *out = NULL;
        return cvol_fail_memory(context, width * sizeof *row, "a row of samples");
    }
    for (size_t r = 0; r < rows; r++) {
        cvol_samples_load(to + r * width, volumes[0]->data, volumes[0]->grid.type, r * width, width,
                          0);
        for (size_t c = 1; c < count; c++) {
            cvol_samples_load(row, volumes[c]->data, volumes[c]->grid.type, r * width, width, 0);
            for (size_t i = 0; i < width; i++)
                to[r * width + i] += row[i];
        }
    }
    free(row);
    const int blurred = blur_volume(context, *out);
    if (blurred) {
        cvol_volume_free(*out);
        *out = NULL;
    }
    return blurred;
}

int cvol_colours_create_shape(cvol_context *context, cvol_array **array, cvol_volume **volume,
                              const cvol_colour_source *source)
{
    cvol_colour_source full;
    *array = NULL;
    *volume = NULL;
    const int code = cvol_colour_source_complete(context, &full, source);
    if (code)
        return code;
    const size_t first = full.has_alpha ? full.count - 1 : 0, count = full.count - first;
    return full.arrays ? add_arrays(context, array, full.arrays + first, count)
                       : add_volumes(context, volume, full.volumes + first, count);
}

/* The value of a sum where its dark background ends. */
static double background_end(cvol_context *context, const cvol_histogram *histogram, double low,
                             double width)
{
    cvol_transfer *fitted = NULL;
    double end = low + CLEAR_PART * width;
    if (!histogram || cvol_transfer_create_named(context, &fitted, "auto", histogram))
        return end;
    const size_t count = cvol_transfer_count(fitted);
    for (size_t i = 1; i < count && !(cvol_transfer_point_at(fitted, 0).opacity > 0); i++)
        if (cvol_transfer_point_at(fitted, i).opacity > 0) {
            end = fmax(end, fmin(cvol_transfer_point_at(fitted, i - 1).value,
                                 low + BACKGROUND_MOST * width));
            break;
        }
    cvol_transfer_free(fitted);
    return end;
}

int cvol_colours_create_transfer(cvol_context *context, cvol_transfer **out,
                                 const cvol_histogram *histogram, const cvol_colour_source *source)
{
    cvol_colour_source full;
    *out = NULL;
    const int code = cvol_colour_source_complete(context, &full, source);
    if (code)
        return code;
    const double count = full.has_alpha ? 1 : (double)full.count;
    double low = count * full.range[0], high = count * full.range[1], window[2];
    double ends[2] = {low, high};
    if (!full.has_alpha) {
        if (histogram) {
            cvol_histogram_get_window(window, histogram);
            high = fmin(high, window[1]);
        }
        high = fmax(high, low + 1e-3 * count * (full.range[1] - full.range[0]));
        ends[0] = background_end(context, histogram, low, high - low);
        ends[1] = ends[0] + (OPAQUE_PART - CLEAR_PART) * (high - low);
    }
    const double grey = CVOL_COLOUR_GREY;
    const cvol_transfer_point points[] = {{ends[0], grey, grey, grey, 0},
                                          {ends[1], grey, grey, grey, OPACITY}};
    return cvol_transfer_create(context, out, points, 2);
}
