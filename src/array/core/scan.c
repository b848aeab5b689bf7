/* Scan of dense samples before compression: their range, and values that cannot be compressed. */
#include <math.h>
#include <stdlib.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

/* For one slice of samples. */
typedef struct slice_scan {
    double min, max;
    size_t nonfinite, first_nonfinite; /* NaN or infinite: count, and the first one's index */
} slice_scan;

#define FIND_EXTREMES(type)                            \
    do {                                               \
        const type *s = (const type *)samples + first; \
        type lo = s[0], hi = s[0];                     \
        for (size_t i = 0; i < count; i++) {           \
            lo = s[i] < lo ? s[i] : lo;                \
            hi = s[i] > hi ? s[i] : hi;                \
        }                                              \
        out.min = (double)lo;                          \
        out.max = (double)hi;                          \
    } while (0)

#define FIND_NONFINITE(type)                           \
    do {                                               \
        const type *s = (const type *)samples + first; \
        for (size_t i = count; i > 0; i--)             \
            if (!isfinite((double)s[i - 1])) {         \
                out.nonfinite++;                       \
                out.first_nonfinite = first + i - 1;   \
            }                                          \
    } while (0)

static slice_scan scan_slice(const void *samples, cvol_type type, size_t first, size_t count)
{
    slice_scan out = {0};
    CVOL_FOR_TYPE(type, FIND_EXTREMES);
    if (!cvol_type_is_integer(type))
        CVOL_FOR_TYPE(type, FIND_NONFINITE);
    return out;
}

/* `in_slab`: the samples are some slices of a volume that is compressed slab by slab. */
static int fail_nonfinite(cvol_context *context, const cvol_grid *grid, size_t count, size_t first,
                          int in_slab)
{
    const size_t x = first % grid->dims[0], y = first / grid->dims[0] % grid->dims[1],
                 z = first / grid->dims[0] / grid->dims[1];
    return cvol_fail(
        context, CVOL_ERROR_DATA,
        "%s%zu %s NaN or infinite, the first at (x, y, z) = (%zu, %zu, %zu) (index "
        "%zu); %s",
        in_slab ? "in one slab " : "", count, count == 1 ? "sample is" : "samples are", x, y, z,
        first,
        in_slab
            ? "slab by slab they cannot be stored: use cvol compress --fill nan, without --stream"
            : "--fill VALUE replaces them");
}

static int scan_slices(cvol_context *context, double *min, double *max, const void *samples,
                       const cvol_grid *grid, size_t first_slice, int in_slab)
{
    const size_t slices = grid->dims[2], per_slice = grid->dims[0] * grid->dims[1];
    slice_scan *scans = cvol_allocate(slices, sizeof *scans);
    if (!scans)
        return cvol_fail_memory(context, slices * sizeof *scans, "a scan of the samples");
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = 0; z < slices; z++)
        scans[z] = scan_slice(samples, grid->type, z * per_slice, per_slice);
    *min = scans[0].min;
    *max = scans[0].max;
    size_t nonfinite = 0, first_nonfinite = 0;
    for (size_t z = 0; z < slices; z++) {
        *min = scans[z].min < *min ? scans[z].min : *min;
        *max = scans[z].max > *max ? scans[z].max : *max;
        if (scans[z].nonfinite && !nonfinite)
            first_nonfinite = scans[z].first_nonfinite;
        nonfinite += scans[z].nonfinite;
    }
    free(scans);
    return nonfinite ? fail_nonfinite(context, grid, nonfinite,
                                      first_nonfinite + first_slice * per_slice, in_slab)
                     : CVOL_OK;
}

int cvol_scan_samples(cvol_context *context, double *min, double *max, const void *samples,
                      const cvol_grid *grid)
{
    return scan_slices(context, min, max, samples, grid, 0, 0);
}

int cvol_scan_slices(cvol_context *context, double *min, double *max, const void *samples,
                     const cvol_grid *grid, size_t first_slice)
{
    return scan_slices(context, min, max, samples, grid, first_slice, 1);
}
