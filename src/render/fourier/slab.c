/* Samples for a spectrum, some slices at a time: evaluated from an array, or converted from a
 * volume, as floats. */
#include "render/fourier/slab.h"

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

#define SLAB_SAMPLES ((size_t)1 << 24)

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

int cvol_fourier_slab_make(cvol_context *context, cvol_fourier_slab *out,
                           const cvol_fourier_source *source, const size_t n[3])
{
    const size_t block = !source->array || !source->array->block ? 16
                                                                 : (size_t)source->array->block;
    size_t most = SLAB_SAMPLES / (n[0] * n[1]) / block * block;
    most = least(most < block ? block : most, n[2]);
    /* whole arrays are always evaluated whole */
    if (source->array && !source->array->block)
        most = n[2];
    *out = (cvol_fourier_slab){.most = most};
    out->samples = cvol_allocate(n[0] * n[1] * most, sizeof(float));
    if (source->array && cvol_mask_is_void(source->array->mask))
        out->mask = cvol_allocate(n[0] * n[1] * most, 1);
    if (out->samples && (out->mask || !source->array || !cvol_mask_is_void(source->array->mask)))
        return CVOL_OK;
    return cvol_fail_memory(context, n[0] * n[1] * most * sizeof(float), "a slab of samples");
}

void cvol_fourier_slab_free(cvol_fourier_slab *of)
{
    free(of->samples);
    free(of->mask);
}

/* NaN fails the comparison and becomes min. */
static inline double clamp_value(double value, double min, double max)
{
    return value >= min ? (value <= max ? value : max) : min;
}

static void convert(float *out, const cvol_fourier_source *source, size_t from, size_t count,
                    int threads)
{
    const double min = source->min, max = source->max, offset = source->offset;
#define CONVERT(type)                                                      \
    do {                                                                   \
        const type *at = (const type *)source->volume->data + from;        \
        for (size_t i = begin; i < end; i++)                               \
            out[i] = (float)clamp_value((double)at[i] - offset, min, max); \
    } while (0)
#pragma omp parallel for num_threads(threads) schedule(static)
    for (size_t part = 0; part < 64; part++) {
        const size_t begin = count * part / 64, end = count * (part + 1) / 64;
        CVOL_FOR_TYPE(source->volume->grid.type, CONVERT)
    }
#undef CONVERT
}

/* Loads the next slices. */
int cvol_fourier_slab_next(cvol_context *context, cvol_fourier_slab *of,
                           const cvol_fourier_source *source, const size_t n[3])
{
    of->first += of->count;
    of->count = least(of->most, n[2] - of->first);
    if (source->volume) {
        convert(of->samples, source, of->first * n[0] * n[1], of->count * n[0] * n[1],
                cvol_context_threads(context));
        return CVOL_OK;
    }
    const size_t begin[3] = {0, 0, of->first}, end[3] = {n[0], n[1], of->first + of->count};
    cvol_context quiet = *context;
    quiet.progress = NULL;
    const int code = cvol_array_evaluate_less_offset(&quiet, of->samples, source->array, begin,
                                                     end);
    if (code)
        return cvol_fail(context, code, "%s", quiet.message);
    if (of->mask)
        cvol_array_evaluate_mask(of->mask, source->array, begin, end);
    return CVOL_OK;
}

double cvol_fourier_slab_base(const cvol_fourier_slab *of, const size_t n[3], double otherwise)
{
    double sum = 0;
    size_t count = 0;
    for (size_t z = 0; z < of->count; z++)
        for (size_t y = 0; y < n[1]; y++) {
            const size_t row = (z * n[1] + y) * n[0];
            const int inner = y > 0 && y + 1 < n[1] && n[0] > 1;
            for (size_t x = 0; x < n[0]; x += inner ? n[0] - 1 : 1)
                if (!of->mask || !of->mask[row + x]) {
                    sum += of->samples[row + x];
                    count++;
                }
        }
    return count ? sum / (double)count : otherwise;
}
