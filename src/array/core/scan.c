/* Scan of dense samples before compression: their range, and values that cannot be compressed. */
#include <math.h>
#include <stdlib.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

/* For one slice of samples. */
typedef struct sheet_survey {
    double min, max;
    size_t strange, first_strange; /* NaN or infinite: count, and the first one's index */
} sheet_survey;

#define SURVEY(type)                                   \
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

#define FIND_STRANGE(type)                             \
    do {                                               \
        const type *s = (const type *)samples + first; \
        for (size_t i = count; i > 0; i--)             \
            if (!isfinite((double)s[i - 1])) {         \
                out.strange++;                         \
                out.first_strange = first + i - 1;     \
            }                                          \
    } while (0)

static sheet_survey survey_sheet(const void *samples, cvol_type type, size_t first, size_t count)
{
    sheet_survey out = {0};
    CVOL_FOR_TYPE(type, SURVEY);
    if (!cvol_type_is_integer(type))
        CVOL_FOR_TYPE(type, FIND_STRANGE);
    return out;
}

static int fail_strange(cvol_context *context, const cvol_grid *grid, size_t count, size_t first)
{
    const size_t x = first % grid->dims[0], y = first / grid->dims[0] % grid->dims[1],
                 z = first / grid->dims[0] / grid->dims[1];
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "%zu %s NaN or infinite, the first at (x, y, z) = (%zu, %zu, %zu) (index "
                     "%zu); --fill VALUE replaces them",
                     count, count == 1 ? "sample is" : "samples are", x, y, z, first);
}

int cvol_scan_samples(cvol_context *context, double *min, double *max, const void *samples,
                      const cvol_grid *grid)
{
    return cvol_scan_slices(context, min, max, samples, grid, 0);
}

int cvol_scan_slices(cvol_context *context, double *min, double *max, const void *samples,
                     const cvol_grid *grid, size_t first_sheet)
{
    const size_t sheets = grid->dims[2], per_sheet = grid->dims[0] * grid->dims[1];
    sheet_survey *surveys = cvol_allocate(sheets, sizeof *surveys);
    if (!surveys)
        return cvol_fail_memory(context, sheets * sizeof *surveys, "a survey of the samples");
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = 0; z < sheets; z++)
        surveys[z] = survey_sheet(samples, grid->type, z * per_sheet, per_sheet);
    *min = surveys[0].min;
    *max = surveys[0].max;
    size_t strange = 0, first_strange = 0;
    for (size_t z = 0; z < sheets; z++) {
        *min = surveys[z].min < *min ? surveys[z].min : *min;
        *max = surveys[z].max > *max ? surveys[z].max : *max;
        if (surveys[z].strange && !strange)
            first_strange = surveys[z].first_strange;
        strange += surveys[z].strange;
    }
    free(surveys);
    return strange ? fail_strange(context, grid, strange, first_strange + first_sheet * per_sheet)
                   : CVOL_OK;
}
