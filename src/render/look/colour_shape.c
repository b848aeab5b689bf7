/* The shape of RGB samples, and its transfer function (cvol/look.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/look/colours.h"

/* Sums are scaled so that black is 0 and all components at their full value are this. */
#define FULL 65535
/* Of the largest sums: the shape is 0 below the first, and 255 above the second. Matter that is
 * opaque has an even shape, so that light does not show changes of colour as if they were relief;
 * with a shorter rise a hard edge would lie near the outer samples and show their steps. */
#define CLEAR_PART 0.02
#define SOLID_PART 0.5
/* A dark background ends at most here. */
#define BACKGROUND_MOST 0.3
/* A background is bright if this part of the samples on the faces of the volume is above this part
 * of the largest sums, which are at least this part of white. */
#define BRIGHT_SHARE 0.6
#define BRIGHT_PART 0.85
#define WHITE_PART 0.75
#define WHITE_COUNT 3 /* fewer components are not white */
/* The opacity per mean spacing rises from 0 at the first value of the shape to OPACITY at the
 * second. */
#define FAINT 6
#define OPAQUE 170
#define OPACITY 0.3
#define THICK 10
/* Slices whose components are evaluated together: at most so many, and so many samples. */
#define SLAB 32
#define SLAB_SAMPLES ((size_t)1 << 24)
/* The least term of the shape. */
#define TERM_LEAST 0.5

/* Of the shape, along each axis. */
#define BLUR_RADIUS 2
static const float blurred[2 * BLUR_RADIUS + 1] = {1 / 16.F, 4 / 16.F, 6 / 16.F, 4 / 16.F,
                                                   1 / 16.F};
/* Of a few slices, whose outlines would look like slopes. */
static const float plain[2 * BLUR_RADIUS + 1] = {0, 0, 1, 0, 0};

/* ---- sums ---------------------------------------------------------------------------------- */

/* Adds component c of slices, within its range, to `sums`. */
static int add_component(cvol_context *context, float *sums, float *work,
                         const cvol_colours *colours, size_t c, const size_t begin[3],
                         const size_t end[3])
{
    const size_t count = end[0] * end[1] * (end[2] - begin[2]);
    const float low = (float)colours->range[0], high = (float)colours->range[1];
    const int code = cvol_colours_evaluate_box(context, work, colours, c, begin, end);
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < (code ? 0 : count); i++)
        sums[i] += fminf(fmaxf(work[i], low), high);
    return code;
}

/* Scales the sums of `parts` components into uint16. */
static void store_sums(cvol_context *context, uint16_t *out, const float *sums, size_t count,
                       const cvol_colours *colours, size_t parts)
{
    const float low = (float)((double)parts * colours->range[0]),
                scale = (float)(FULL / ((double)parts * (colours->range[1] - colours->range[0])));
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < count; i++) {
        const float value = (sums[i] - low) * scale;
        out[i] = value > 0 ? (uint16_t)fminf(value + 0.5F, FULL) : 0;
    }
}

/* The slices of a slab. */
static size_t slab_of(const size_t n[3])
{
    const size_t fit = SLAB_SAMPLES / (n[0] * n[1]), most = n[2] < SLAB ? n[2] : SLAB;
    return fit < 1 ? 1 : fit < most ? fit : most;
}

/* Sums of components first .. count - 1, slab by slab. */
static int find_sums(cvol_context *context, uint16_t *out, const cvol_colours *colours,
                     size_t first)
{
    const size_t *n = colours->grid.dims, slice = n[0] * n[1], slab = slab_of(n);
    float *sums = cvol_allocate(slab * slice, sizeof *sums),
          *work = cvol_allocate(slab * slice, sizeof *work);
    int code = sums && work ? CVOL_OK
                            : cvol_fail_memory(context, 2 * slab * slice * sizeof *sums, "colours");
    for (size_t z = 0; z < n[2] && !code; z += slab) {
        const size_t begin[3] = {0, 0, z}, end[3] = {n[0], n[1], z + slab < n[2] ? z + slab : n[2]};
        const size_t count = slice * (end[2] - z);
        memset(sums, 0, count * sizeof *sums);
        for (size_t c = first; c < colours->count && !code; c++)
            code = add_component(context, sums, work, colours, c, begin, end);
        if (!code)
            store_sums(context, out + slice * z, sums, count, colours, colours->count - first);
    }
    free(sums);
    free(work);
    return code;
}

/* ---- ends ---------------------------------------------------------------------------------- */

/* Where the dark background ends. */
static double background_end(cvol_context *context, const cvol_histogram *histogram, double high)
{
    cvol_transfer *fitted = NULL;
    double end = CLEAR_PART * high;
    if (cvol_transfer_create_named(context, &fitted, "auto", histogram))
        return end;
    const size_t count = cvol_transfer_count(fitted);
    for (size_t i = 1; i < count && !(cvol_transfer_point_at(fitted, 0).opacity > 0); i++)
        if (cvol_transfer_point_at(fitted, i).opacity > 0) {
            const double value = cvol_transfer_point_at(fitted, i - 1).value;
            end = fmax(end, fmin(value, BACKGROUND_MOST * high));
            break;
        }
    cvol_transfer_free(fitted);
    return end;
}

/* 1 if the background is bright, as around a section on glass: then it must not hide the object. */
static int has_bright_background(const cvol_volume *sums, double high)
{
    const size_t *n = sums->grid.dims;
    const uint16_t *samples = sums->data;
    size_t faces = 0, bright = 0;
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++) {
            const int is_row = z == 0 || y == 0 || z + 1 == n[2] || y + 1 == n[1];
            const uint16_t *row = samples + n[0] * (y + n[1] * z);
            for (size_t x = 0; x < n[0]; x += is_row || n[0] == 1 ? 1 : n[0] - 1) {
                faces++;
                bright += row[x] > BRIGHT_PART * high;
            }
        }
    return high > WHITE_PART * FULL && (double)bright > BRIGHT_SHARE * (double)faces;
}

/* Replaces sums by what they lack of the brightest ones. */
static void invert(cvol_context *context, cvol_volume *sums, int most)
{
    const size_t count = cvol_grid_samples(&sums->grid);
    uint16_t *samples = sums->data;
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < count; i++)
        samples[i] = (uint16_t)(samples[i] < most ? most - samples[i] : 0);
}

static int find_ends(cvol_context *context, cvol_colours *colours, cvol_volume *sums, int by_range)
{
    cvol_histogram histogram;
    double window[2], high = FULL, clear = CLEAR_PART * FULL;
    colours->ends[0] = 0;
    colours->ends[1] = 1;
    if (colours->has_alpha)
        return CVOL_OK;
    if (!by_range) {
        int code = cvol_volume_compute_histogram(context, &histogram, sums);
        cvol_histogram_get_window(window, &histogram);
        if (!code && colours->count == WHITE_COUNT && has_bright_background(sums, window[1])) {
            colours->bright = window[1] / FULL;
            invert(context, sums, (int)window[1]);
            code = cvol_volume_compute_histogram(context, &histogram, sums);
            cvol_histogram_get_window(window, &histogram);
        }
        if (code)
            return code;
        if (window[1] > 0)
            high = fmin(high, window[1]);
        clear = background_end(context, &histogram, high);
    }
    colours->ends[0] = clear / FULL;
    colours->ends[1] = (clear + (SOLID_PART - CLEAR_PART) * high) / FULL;
    return CVOL_OK;
}

/* ---- blur ---------------------------------------------------------------------------------- */

static size_t clamped(size_t at, int off, size_t count)
{
    const ptrdiff_t place = (ptrdiff_t)at + off, last = (ptrdiff_t)count - 1;
    return (size_t)(place < 0 ? 0 : place > last ? last : place);
}

/* Sums of a row with its neighbours across, weighted; `level` has the shape of a sum. */
static void blur_across(float *row, const uint16_t *sums, const size_t n[3], size_t y, size_t z,
                        const uint8_t *level, const float *blur)
{
    for (size_t x = 0; x < n[0]; x++)
        row[x] = 0;
    for (int k = -BLUR_RADIUS; k <= BLUR_RADIUS; k++)
        for (int j = -BLUR_RADIUS; j <= BLUR_RADIUS; j++) {
            const float weight = blur[j + BLUR_RADIUS] * blur[k + BLUR_RADIUS];
            const uint16_t *from = sums + n[0] * (clamped(y, j, n[1]) + n[1] * clamped(z, k, n[2]));
            for (size_t x = 0; x < n[0]; x++)
                row[x] += weight * (float)level[from[x]];
        }
}

static void blur_row(uint8_t *out, const float *row, size_t count, const float *blur)
{
    for (size_t x = 0; x < count; x++) {
        float sum = 0.5F;
        for (int i = -BLUR_RADIUS; i <= BLUR_RADIUS; i++)
            sum += blur[i + BLUR_RADIUS] * row[clamped(x, i, count)];
        out[x] = (uint8_t)sum;
    }
}

/* The shape of a scaled sum. */
static uint8_t level_of(const cvol_colours *colours, int sum)
{
    const double share = ((double)sum / FULL - colours->ends[0]) /
                         (colours->ends[1] - colours->ends[0]);
    return (uint8_t)(255 * fmin(fmax(share, 0), 1) + 0.5);
}

static int blur_sums(cvol_context *context, uint8_t *out, const uint16_t *sums,
                     const cvol_colours *colours)
{
    const size_t *n = colours->grid.dims;
    const int threads = cvol_threads_possible(cvol_context_threads(context));
    const int is_thin = n[0] <= 2 * BLUR_RADIUS || n[1] <= 2 * BLUR_RADIUS ||
                        n[2] <= 2 * BLUR_RADIUS;
    const float *blur = is_thin ? plain : blurred;
    float *rows = cvol_allocate((size_t)threads * n[0], sizeof *rows);
    uint8_t *level = malloc(FULL + 1);
    if (rows && level) {
        for (int sum = 0; sum <= FULL; sum++)
            level[sum] = level_of(colours, sum);
#pragma omp parallel for num_threads(threads) schedule(static)
        for (size_t r = 0; r < n[1] * n[2]; r++) {
            float *row = rows + (size_t)cvol_thread_index() * n[0];
            blur_across(row, sums, n, r % n[1], r / n[1], level, blur);
            blur_row(out + r * n[0], row, n[0], blur);
        }
    }
    const int code = rows && level
                         ? CVOL_OK
                         : cvol_fail_memory(context, (size_t)threads * n[0] * sizeof *rows + FULL,
                                            "colours");
    free(rows);
    free(level);
    return code;
}

/* ---- the shape ----------------------------------------------------------------------------- */

/* Makes the shape as a volume of uint8. */
static int make_volume(cvol_context *context, cvol_volume **out, cvol_colours *colours,
                       int by_range)
{
    cvol_grid grid = colours->grid;
    cvol_volume *sums = NULL;
    grid.value_scale = 1;
    grid.value_offset = 0;
    grid.type = CVOL_UINT16;
    *out = NULL;
    int code = cvol_volume_create(context, &sums, &grid);
    if (!code)
        code = find_sums(context, sums->data, colours, colours->has_alpha ? colours->count - 1 : 0);
    if (!code)
        code = find_ends(context, colours, sums, by_range);
    grid.type = CVOL_UINT8;
    if (!code)
        code = cvol_volume_create(context, out, &grid);
    if (!code)
        code = blur_sums(context, (*out)->data, sums->data, colours);
    cvol_volume_free(sums);
    return code;
}

int cvol_colours_make_shape(cvol_context *context, cvol_array **array, cvol_volume **volume,
                            cvol_colours *colours, int by_range)
{
    const cvol_keep keep = cvol_keep_threshold(TERM_LEAST);
    cvol_volume *samples;
    int code = make_volume(context, &samples, colours, by_range);
    if (!code && !colours->arrays[0]) {
        *volume = samples;
        return code;
    }
    if (!code)
        code = cvol_array_compress(context, array, samples->data, &samples->grid, 3, CVOL_DCT, 8,
                                   &keep);
    if (!code)
        code = cvol_array_ensure_ranges(context, *array);
    cvol_volume_free(samples);
    return code;
}

/* Of a volume of few slices, so that it hides as much as THICK mean spacings do. */
static double density_of(const cvol_grid *grid)
{
    double thickness = INFINITY, mean = 0;
    for (int a = 0; a < 3; a++) {
        thickness = fmin(thickness, (double)grid->dims[a] * grid->spacing[a]);
        mean += grid->spacing[a] / 3;
    }
    return fmax(1, THICK * mean / thickness);
}

int cvol_colours_create_transfer(cvol_context *context, cvol_transfer **out,
                                 const cvol_colours *colours)
{
    const double grey = CVOL_COLOUR_GREY,
                 opacity = 1 - pow(1 - OPACITY, density_of(&colours->grid));
    const cvol_transfer_point points[] = {
        {colours->has_alpha ? 0 : FAINT, grey, grey, grey, 0},
        {colours->has_alpha ? 255 : OPAQUE, grey, grey, grey, opacity}};
    return cvol_transfer_create(context, out, points, 2);
}
