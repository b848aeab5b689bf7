/* The components of colours: their bricks, and cells of their shape (colours.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/options.h"
#include "render/look/colours.h"
#include "render/transfer/transfer.h"

/* More bytes than this are not kept from one picture to the next. */
#define KEPT_MOST ((size_t)512 << 20)
/* Samples of a cell of a volume along an axis. */
#define CELL_SIDE 8

/* ---- sources ------------------------------------------------------------------------------- */

static const cvol_grid *grid_of(const cvol_colour_source *source, size_t c)
{
    return source->arrays ? cvol_array_grid(source->arrays[c]) : &source->volumes[c]->grid;
}

/* Checks and completes a source. */
static int complete(cvol_context *context, cvol_colour_source *out,
                    const cvol_colour_source *source)
{
    *out = (cvol_colour_source){.size = sizeof *out};
    int code = cvol_options_copy(context, out, sizeof *out,
                                 CVOL_SIZE_TO(cvol_colour_source, by_range), "cvol_colour_source",
                                 source);
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
    const cvol_grid *first = grid_of(out, 0);
    for (size_t c = 0; c < out->count && !code; c++) {
        const cvol_grid *grid = grid_of(out, c);
        if (out->arrays)
            code = cvol_array_need_volume(context, out->arrays[c], "a picture of colours");
        if (!code && memcmp(grid->dims, first->dims, sizeof grid->dims))
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "component %zu has %zu x %zu x %zu samples, component 0 has %zu x "
                             "%zu x %zu",
                             c, grid->dims[0], grid->dims[1], grid->dims[2], first->dims[0],
                             first->dims[1], first->dims[2]);
    }
    return code;
}

/* ---- cells --------------------------------------------------------------------------------- */

/* The least and the largest sample of a cell of the shape. */
static void find_bounds(float out[2], const cvol_colours *colours, const cvol_array *array,
                        const cvol_volume *volume, size_t index)
{
    double lo, hi;
    if (array) {
        cvol_array_range(array, index, &lo, &hi);
        out[0] = (float)(lo + array->offset);
        out[1] = (float)(hi + array->offset);
        return;
    }
    const size_t *n = colours->grid.dims, *cells = colours->cells;
    const uint8_t *samples = volume->data;
    const size_t at[3] = {index % cells[0], index / cells[0] % cells[1],
                          index / cells[0] / cells[1]};
    size_t end[3];
    int least = UINT8_MAX, most = 0;
    for (int a = 0; a < 3; a++)
        end[a] = (at[a] + 1) * CELL_SIDE < n[a] ? (at[a] + 1) * CELL_SIDE : n[a];
    for (size_t z = at[2] * CELL_SIDE; z < end[2]; z++)
        for (size_t y = at[1] * CELL_SIDE; y < end[1]; y++)
            for (size_t x = at[0] * CELL_SIDE; x < end[0]; x++) {
                const int value = samples[x + n[0] * (y + n[1] * z)];
                least = value < least ? value : least;
                most = value > most ? value : most;
            }
    out[0] = (float)least;
    out[1] = (float)most;
}

/* Between the last samples of a cell and the first of the next, both count: joins the bounds of
 * cells with those of their upper neighbours along an axis. */
static void join_bounds(cvol_colours *colours, int axis)
{
    const size_t *n = colours->cells;
    const size_t step = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
    for (size_t i = 0; i < colours->cell_count; i++)
        if (i / step % n[axis] + 1 < n[axis]) {
            float *own = colours->bounds[i];
            const float *next = colours->bounds[i + step];
            own[0] = fminf(own[0], next[0]);
            own[1] = fmaxf(own[1], next[1]);
        }
}

static int make_cells(cvol_context *context, cvol_colours *colours, const cvol_array *array,
                      const cvol_volume *volume)
{
    colours->cell_side = array ? (size_t)array->block : CELL_SIDE;
    colours->cell_count = 1;
    for (int a = 0; a < 3; a++) {
        colours->cells[a] = (colours->grid.dims[a] - 1) / colours->cell_side + 1;
        colours->cell_count *= colours->cells[a];
    }
    colours->bounds = cvol_allocate(colours->cell_count, sizeof *colours->bounds);
    colours->visible = cvol_allocate(colours->cell_count, 1);
    if (!colours->bounds || !colours->visible)
        return cvol_fail_memory(context, colours->cell_count * (sizeof *colours->bounds + 1),
                                "cells of colours");
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < colours->cell_count; i++)
        find_bounds(colours->bounds[i], colours, array, volume, i);
    for (int a = 0; a < 3; a++)
        join_bounds(colours, a);
    return CVOL_OK;
}

void cvol_colours_find_visible(cvol_colours *colours, const cvol_transfer *transfer)
{
    for (size_t i = 0; i < colours->cell_count; i++)
        colours->visible[i] = cvol_transfer_max_opacity(transfer, (double)colours->bounds[i][0],
                                                        (double)colours->bounds[i][1]) > 0;
}

/* ---- bricks -------------------------------------------------------------------------------- */

static int make_bricks(cvol_context *context, cvol_colours *colours)
{
    colours->brick_count = 1;
    for (int a = 0; a < 3; a++) {
        colours->bricks[a] = (colours->grid.dims[a] - 1) / CVOL_COLOUR_SIDE + 1;
        colours->brick_count *= colours->bricks[a];
    }
    colours->samples = calloc(colours->brick_count, sizeof *colours->samples);
    colours->needed = calloc(colours->brick_count, 1);
    return colours->samples && colours->needed
               ? CVOL_OK
               : cvol_fail_memory(context, colours->brick_count * (sizeof(void *) + 1), "colours");
}

int cvol_colours_create(cvol_context *context, cvol_colours **out, cvol_array **array,
                        cvol_volume **volume, const cvol_colour_source *source)
{
    cvol_colour_source full;
    *out = NULL;
    *array = NULL;
    *volume = NULL;
    int code = complete(context, &full, source);
    if (code)
        return code;
    cvol_colours *colours = calloc(1, sizeof *colours);
    if (!colours)
        return cvol_fail_memory(context, sizeof *colours, "colours");
    colours->grid = *grid_of(&full, 0);
    colours->count = full.count;
    colours->has_alpha = full.has_alpha != 0;
    memcpy(colours->range, full.range, sizeof colours->range);
    for (size_t c = 0; c < full.count; c++) {
        colours->arrays[c] = full.arrays ? full.arrays[c] : NULL;
        colours->volumes[c] = full.volumes ? full.volumes[c] : NULL;
        for (size_t k = 0; k < 3 && !(full.has_alpha && c + 1 == full.count); k++)
            colours->rgb[3 * c + k] = (float)full.rgb[3 * c + k];
    }
    code = make_bricks(context, colours);
    if (!code)
        code = cvol_colours_make_shape(context, array, volume, colours, full.by_range);
    if (!code)
        code = make_cells(context, colours, *array, *volume);
    if (code) {
        cvol_colours_free(colours);
        cvol_array_free(*array);
        cvol_volume_free(*volume);
        *array = NULL;
        *volume = NULL;
        return code;
    }
    *out = colours;
    return CVOL_OK;
}

static void drop_bricks(cvol_colours *colours)
{
    for (size_t i = 0; i < colours->brick_count; i++) {
        free(colours->samples[i]);
        colours->samples[i] = NULL;
    }
    colours->kept = 0;
}

void cvol_colours_free(cvol_colours *colours)
{
    if (!colours)
        return;
    if (colours->samples)
        drop_bricks(colours);
    free(colours->samples);
    free(colours->needed);
    free(colours->bounds);
    free(colours->visible);
    free(colours);
}

int cvol_colours_evaluate_box(cvol_context *context, float *out, const cvol_colours *colours,
                              size_t c, const size_t begin[3], const size_t end[3])
{
    if (colours->arrays[c])
        return cvol_array_evaluate_unmasked(context, out, colours->arrays[c], begin, end);
    const cvol_volume *volume = colours->volumes[c];
    const size_t *n = volume->grid.dims, width = end[0] - begin[0];
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++, out += width)
            cvol_samples_load(out, volume->data, volume->grid.type,
                              begin[0] + n[0] * (y + n[1] * z), width, 0);
    return CVOL_OK;
}

/* Puts the samples of a component into a brick. */
static void store(uint8_t *brick, const cvol_colours *colours, size_t c, const float *samples,
                  const size_t size[3])
{
    const float low = (float)colours->range[0],
                scale = (float)(255 / (colours->range[1] - colours->range[0]));
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++) {
                const float value = (*samples++ - low) * scale;
                const size_t at = x + CVOL_COLOUR_STRIDE * (y + CVOL_COLOUR_STRIDE * z);
                brick[CVOL_COLOURS_MAX * at + c] = value > 0 ? (uint8_t)fminf(value + 0.5F, 255)
                                                             : 0;
            }
}

/* Evaluates brick `index` into colours->samples. */
static int evaluate_brick(cvol_context *context, cvol_colours *colours, size_t index, float *work)
{
    size_t begin[3], end[3], size[3], rest = index;
    for (int a = 0; a < 3; a++) {
        begin[a] = rest % colours->bricks[a] * CVOL_COLOUR_SIDE;
        rest /= colours->bricks[a];
        end[a] = begin[a] + CVOL_COLOUR_STRIDE;
        if (end[a] > colours->grid.dims[a])
            end[a] = colours->grid.dims[a];
        size[a] = end[a] - begin[a];
    }
    uint8_t *brick = cvol_allocate_zero(CVOL_COLOUR_SAMPLES, CVOL_COLOURS_MAX);
    if (!brick)
        return cvol_fail_memory(context, CVOL_COLOUR_SAMPLES * CVOL_COLOURS_MAX, "colours");
    int code = CVOL_OK;
    for (size_t c = 0; c < colours->count && !code; c++) {
        code = cvol_colours_evaluate_box(context, work, colours, c, begin, end);
        if (!code)
            store(brick, colours, c, work, size);
    }
    if (code) {
        free(brick);
        return code;
    }
    colours->samples[index] = brick;
    colours->kept++;
    return CVOL_OK;
}

int cvol_colours_evaluate(cvol_context *context, cvol_colours *colours)
{
    float *work = cvol_allocate(CVOL_COLOUR_SAMPLES, sizeof *work);
    if (!work)
        return cvol_fail_memory(context, CVOL_COLOUR_SAMPLES * sizeof *work, "colours");
    if (colours->kept * CVOL_COLOUR_SAMPLES * CVOL_COLOURS_MAX > KEPT_MOST)
        drop_bricks(colours);
    int code = CVOL_OK;
    for (size_t i = 0; i < colours->brick_count && !code; i++)
        if (colours->needed[i] && !colours->samples[i])
            code = evaluate_brick(context, colours, i, work);
    free(work);
    return code;
}
