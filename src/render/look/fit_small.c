/* The box of a small object (fit_small.h).
 *
 * The mean of a cell that holds one bright sample may be transparent. So the samples are searched,
 * some slices at a time, for those that the transfer function or the surface shows. The box reaches
 * to the samples around these, as interpolated values do. */
#include "render/look/fit_small.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"

#define SAMPLES_MOST ((size_t)1 << 27) /* decoding more takes longer than a picture */
#define SLICES 16                      /* searched at a time */
#define OPACITY_LEAST 0.01             /* of a visible sample */

/* The samples of a box as numbers, NaN without a value. The caller frees *out. */
static int read_box(cvol_context *context, double **out, const cvol_source *of,
                    const size_t begin[3], const size_t end[3])
{
    const cvol_grid *grid = of->array ? cvol_array_grid(of->array) : &of->volume->grid;
    const size_t n[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]},
                 count = n[0] * n[1] * n[2];
    void *own = of->array ? cvol_allocate(count, cvol_type_size(grid->type)) : NULL;
    uint8_t *which = of->array ? cvol_allocate_zero(count, 1) : NULL;
    double *values = cvol_allocate(count, sizeof *values);
    int code = values && (!of->array || (own && which))
                   ? CVOL_OK
                   : cvol_fail_memory(context, count * sizeof *values, "a frame");
    if (!code && of->array) {
        code = cvol_array_evaluate_box(context, own, of->array, begin, end);
        cvol_array_evaluate_mask(which, of->array, begin, end);
    }
    for (size_t i = 0; i < count && !code; i++) {
        const size_t x = begin[0] + i % n[0], y = begin[1] + i / n[0] % n[1],
                     z = begin[2] + i / n[0] / n[1],
                     at = own ? i : x + grid->dims[0] * (y + grid->dims[1] * z);
        const uint8_t *mask = own ? which : of->mask;
#define TAKE(t) values[i] = (double)((const t *)(own ? own : of->volume->data))[at]
        CVOL_FOR_TYPE(grid->type, TAKE);
#undef TAKE
        if (mask && mask[at])
            values[i] = NAN;
    }
    free(own);
    free(which);
    if (code)
        free(values);
    *out = code ? NULL : values;
    return code;
}

static int is_visible(double value, const cvol_transfer *transfer,
                      const cvol_render_options *options)
{
    return options->mode == CVOL_MODE_ISO
               ? value >= options->surface.value
               : !isnan(value) && cvol_transfer_at(transfer, value).opacity >= OPACITY_LEAST;
}

/* box: first samples and ends along the axes. */
static int find_box(cvol_context *context, size_t box[2][3], const cvol_source *of,
                    const cvol_grid *grid, const cvol_transfer *transfer,
                    const cvol_render_options *options)
{
    const size_t *n = grid->dims;
    int code = CVOL_OK;
    for (int a = 0; a < 3; a++) {
        box[0][a] = n[a];
        box[1][a] = 0;
    }
    for (size_t z = 0; z < n[2] && !code; z += SLICES) {
        const size_t begin[3] = {0, 0, z},
                     end[3] = {n[0], n[1], z + SLICES < n[2] ? z + SLICES : n[2]};
        double *values, last = NAN;
        int shows = 0;
        code = read_box(context, &values, of, begin, end);
        for (size_t i = 0; i < n[0] * n[1] * (end[2] - z) && !code; i++) {
            if (!(values[i] <= last && values[i] >= last)) /* mostly the same value */
                shows = is_visible(last = values[i], transfer, options);
            const size_t at[3] = {i % n[0], i / n[0] % n[1], z + i / n[0] / n[1]};
            const double place[3] = {(double)at[0], (double)at[1], (double)at[2]};
            if (!shows || !cvol_clip_shows(&options->clip, grid, place))
                continue;
            for (int a = 0; a < 3; a++) {
                box[0][a] = at[a] < box[0][a] ? at[a] : box[0][a];
                box[1][a] = at[a] + 1 > box[1][a] ? at[a] + 1 : box[1][a];
            }
        }
        free(values);
    }
    return code;
}

int cvol_small_box_find(cvol_context *context, cvol_small_box *out, int *found,
                        const cvol_source *of, const cvol_transfer *transfer,
                        const cvol_render_options *options)
{
    const cvol_grid *grid = of->array ? cvol_array_grid(of->array) : &of->volume->grid;
    size_t box[2][3];
    *found = 0;
    if (cvol_mode_is_grey(options->mode) || cvol_grid_samples(grid) > SAMPLES_MOST)
        return CVOL_OK;
    const int code = find_box(context, box, of, grid, transfer, options);
    if (code || box[0][0] >= box[1][0])
        return code;
    for (int a = 0; a < 3; a++) {
        const double last = (double)grid->dims[a] - 1, margin = last > 0 ? 0 : 0.5,
                     from = fmax((double)box[0][a] - 1, -margin),
                     to = fmin((double)box[1][a], last + margin);
        out->middle[a] = ((from + to) / 2 - last / 2) * grid->spacing[a];
        out->half[a] = (to - from) / 2 * grid->spacing[a];
    }
    *found = 1;
    return CVOL_OK;
}
