/* Slices of samples as floats, some together, from a compressed array or from dense samples.
 *
 * In memory, slices lie in the order in which rays meet them, lanes fastest, for any axes. The last
 * two slices of a slab stay for the next: gradients need a slice's neighbours. */
#include <math.h>
#include <string.h>

#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "render/splat/frame.h"

/* New samples per slab, but at least a layer of blocks. Layers next to a slab of a lapped array are
 * evaluated twice, so slabs are thick. */
#define SLAB_SAMPLES ((size_t)1 << 24)
#define SLAB_ALIGN 16

static size_t round_up(size_t n, size_t unit)
{
    return (n + unit - 1) / unit * unit;
}

int cvol_splat_slab_prepare(cvol_context *context, cvol_splat_slab *slab,
                            const cvol_splat_source *source, const cvol_splat_plan *plan)
{
    const size_t block = source->array && source->array->block ? (size_t)source->array->block
                                                               : SLAB_ALIGN;
    const size_t slices = round_up(plan->slices, block);
    size_t most = SLAB_SAMPLES / (plan->lanes * plan->rows) / block * block, floats = 0;
    most = most < block ? block : most < slices ? most : slices;
    slab->most = most;
    slab->first = slab->filled = 0;
    slab->row_stride = round_up(plan->lanes + 2 * CVOL_SPLAT_MARGIN, SLAB_ALIGN);
    const int fits = cvol_size_multiply(&slab->slice_stride, slab->row_stride, plan->rows) &&
                     cvol_size_multiply(&floats, slab->slice_stride, most + 2);
    if (fits && slab->samples && slab->room >= floats)
        return CVOL_OK;
    cvol_splat_slab_free(slab);
    if (fits) {
        slab->samples = cvol_allocate(floats, sizeof *slab->samples);
        /* no slab has more samples than this many floats, without margins */
        if (source->array)
            slab->scratch = cvol_allocate(floats, sizeof *slab->scratch);
        slab->room = floats;
    }
    if (slab->samples && (slab->scratch || !source->array))
        return CVOL_OK;
    cvol_splat_slab_free(slab);
    return cvol_fail_memory(context, floats * sizeof *slab->samples, "a slab of samples");
}

void cvol_splat_slab_free(cvol_splat_slab *slab)
{
    free(slab->samples);
    free(slab->scratch);
    slab->samples = slab->scratch = NULL;
    slab->room = 0;
}

/* A box of samples in memory: steps from lane to lane, row to row, slice to slice. */
typedef struct strides {
    size_t lane, row, slice;
} strides;

static strides strides_of(const cvol_splat_plan *plan, const size_t dims[3])
{
    const size_t step[3] = {1, dims[0], dims[0] * dims[1]};
    return (strides){step[plan->axis_lane], step[plan->axis_row], step[plan->axis_slice]};
}

/* NaN fails the comparison and becomes min. */
static inline double clamp_value(double value, double min, double max)
{
    return value >= min ? (value <= max ? value : max) : min;
}

/* A row of dense samples. */
static void load_row(float *out, const cvol_splat_source *source, size_t from, size_t step,
                     size_t count)
{
    const double min = source->min, max = source->max, offset = source->offset;
#define LOAD(type)                                                                  \
    do {                                                                            \
        const type *at = (const type *)source->volume->data + from;                 \
        for (size_t i = 0; i < count; i++)                                          \
            out[i] = (float)(clamp_value((double)at[i * step], min, max) - offset); \
    } while (0)
    CVOL_FOR_TYPE(source->volume->grid.type, LOAD)
#undef LOAD
}

/* Copies a row's end samples to both of its sides. */
static void extend_row(float *row, size_t count)
{
    for (int i = 0; i < CVOL_SPLAT_MARGIN; i++) {
        row[-1 - i] = row[0];
        row[count + (size_t)i] = row[count - 1];
    }
}

/* Sets the samples of a box that have no value to NaN, which has no colour. */
static int blank(cvol_context *context, float *samples, const cvol_array *array,
                 const size_t begin[3], const size_t end[3])
{
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    uint8_t *which = cvol_allocate(count, 1);
    if (!which)
        return cvol_fail_memory(context, count, "a mask");
    if (cvol_array_evaluate_mask(which, array, begin, end) > 0)
        for (size_t i = 0; i < count; i++)
            samples[i] = which[i] ? NAN : samples[i];
    free(which);
    return CVOL_OK;
}

/* Evaluates slices begin .. end - 1 into the scratch; the caller reports progress. */
static int evaluate(cvol_context *context, const cvol_splat_slab *slab,
                    const cvol_splat_source *source, const cvol_splat_plan *plan, size_t begin,
                    size_t end)
{
    const cvol_array *array = source->array;
    size_t lo[3] = {0, 0, 0}, hi[3];
    memcpy(hi, cvol_array_grid(array)->dims, sizeof hi);
    lo[plan->axis_slice] = begin;
    hi[plan->axis_slice] = end;
    cvol_context quiet = *context;
    quiet.progress = NULL;
    int code = cvol_array_evaluate_less_offset(&quiet, slab->scratch, array, lo, hi);
    if (code)
        return cvol_fail(context, code, "%s", quiet.message);
    return cvol_mask_is_void(array->mask) ? blank(context, slab->scratch, array, lo, hi) : CVOL_OK;
}

int cvol_splat_slab_next(cvol_context *context, cvol_splat_slab *slab,
                         const cvol_splat_source *source, const cvol_splat_plan *plan,
                         int ascending)
{
    const size_t stride = slab->slice_stride, total = plan->slices;
    if (slab->filled > 0) {
        /* the last two of the slab, if there are two */
        const size_t end = 2 + slab->filled, kept = slab->first + slab->filled < 2 ? 1 : 2;
        memmove(slab->samples + (2 - kept) * stride, slab->samples + (end - kept) * stride,
                kept * stride * sizeof *slab->samples);
    }
    slab->first += slab->filled;
    /* In falling order the first slab ends at the start of a layer of blocks. */
    size_t left = total - slab->first, count = left < slab->most ? left : slab->most;
    if (!ascending && left > slab->most && left % slab->most)
        count = left % slab->most;
    slab->filled = count;
    const size_t begin = ascending ? slab->first : left - count, end = begin + count;
    strides from = strides_of(plan, source->array ? cvol_array_grid(source->array)->dims
                                                  : source->volume->grid.dims);
    size_t base = begin * from.slice;
    if (source->array) {
        int code = evaluate(context, slab, source, plan, begin, end);
        if (code)
            return code;
        size_t dims[3];
        memcpy(dims, cvol_array_grid(source->array)->dims, sizeof dims);
        dims[plan->axis_slice] = count;
        from = strides_of(plan, dims);
        base = 0;
    }
    /* Rows of one number are adjacent in memory if slices lie along x. */
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t row = 0; row < plan->rows; row++)
        for (size_t k = 0; k < count; k++) {
            const size_t slot = 2 + (ascending ? k : count - 1 - k);
            float *out = slab->samples + slot * stride + row * slab->row_stride + CVOL_SPLAT_MARGIN;
            const size_t at = base + k * from.slice + row * from.row;
            if (source->volume)
                load_row(out, source, at, from.lane, plan->lanes);
            else
                for (size_t i = 0; i < plan->lanes; i++)
                    out[i] = slab->scratch[at + i * from.lane];
            extend_row(out, plan->lanes);
        }
    return CVOL_OK;
}
