/* Section SPEC: k, s, and a frame of the low box's floats, the other terms' places and their
 * floats.
 *
 * A place is coded as its distance to the previous one, minus one, so that decoded places always
 * rise. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/container/terms.h"

/* No sample, and no intermediate value, exceeds a few times the sum of magnitudes. */
#define SUM_MAX ((double)FLT_MAX / 16)

static double sum_of_magnitudes(const cvol_spectrum *spectrum)
{
    double sum = 0;
    for (size_t i = 0; i < spectrum->low_count; i++)
        sum += fabs((double)spectrum->low_values[i]);
    for (size_t i = 0; i < spectrum->sparse_count; i++)
        sum += fabs((double)spectrum->values[i]);
    return sum;
}

int cvol_spectrum_put(cvol_context *context, cvol_bytes *out, const cvol_array *array)
{
    const cvol_spectrum *spectrum = &array->whole;
    const size_t sparse = spectrum->sparse_count;
    if (!(sum_of_magnitudes(spectrum) < SUM_MAX))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "the array's terms add up to more than float32 holds");
    cvol_bytes raw = {0};
    uint32_t *distances = cvol_allocate(sparse, sizeof *distances);
    if (!distances)
        return cvol_fail_memory(context, sparse * sizeof *distances, "the file's terms");
    for (size_t i = 0; i < sparse; i++)
        distances[i] = i ? spectrum->places[i] - spectrum->places[i - 1] - 1 : spectrum->places[0];
    cvol_planes_put(&raw, spectrum->low_values, spectrum->low_count, 4);
    cvol_planes_put(&raw, distances, sparse, 4);
    cvol_planes_put(&raw, spectrum->values, sparse, 4);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_u64(out, spectrum->low[a]);
    cvol_bytes_put_u64(out, sparse);
    int code = cvol_packed_put(context, out, &raw);
    free(distances);
    cvol_bytes_free(&raw);
    return code;
}

static int fail(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section SPEC: %s", name, what);
}

/* Reads k and s, and checks them against the shape. *terms: their total. */
static int take_counts(cvol_context *context, size_t low[3], uint64_t *sparse, uint64_t *terms,
                       const cvol_array *array, cvol_cursor *content, const char *name)
{
    const size_t *dims = array->grid.dims;
    const uint64_t samples = cvol_grid_samples(&array->grid);
    uint64_t k[3], box = 1;
    for (int a = 0; a < 3; a++)
        k[a] = cvol_cursor_u64(content);
    *sparse = cvol_cursor_u64(content);
    if (content->failed)
        return fail(context, name, "is too short");
    for (int a = 0; a < 3; a++) {
        const uint64_t most = array->transform == CVOL_DCT ? dims[a] : dims[a] / 2 + 1;
        if (k[a] > most || !k[a] != !k[0])
            return cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section SPEC: k along %c is %llu, must be 1 to %llu, or 0 along "
                             "all axes",
                             name, "xyz"[a], (unsigned long long)k[a], (unsigned long long)most);
        const uint64_t wide = array->transform == CVOL_DCT || 2 * k[a] <= dims[a] ? 2 * k[a] - 1
                                                                                  : dims[a];
        box *= !k[a] ? 0 : array->transform == CVOL_DCT ? k[a] : wide;
        low[a] = (size_t)k[a];
    }
    if (*sparse > samples - box)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section SPEC: s is %llu, there are %llu other places", name,
                         (unsigned long long)*sparse, (unsigned long long)(samples - box));
    *terms = box + *sparse;
    return CVOL_OK;
}

static int is_in_box(const cvol_spectrum *spectrum, const size_t dims[3], size_t place)
{
    if (!spectrum->low_count)
        return 0;
    for (int a = 0; a < 3; a++) {
        const size_t u = place % dims[a];
        place /= dims[a];
        if (cvol_box_index(u, spectrum->low[a], spectrum->box[a], dims[a]) == SIZE_MAX)
            return 0;
    }
    return 1;
}

static int take_places(cvol_context *context, const cvol_array *array, uint32_t *places,
                       size_t count, cvol_cursor *raw, const char *name)
{
    const uint64_t samples = cvol_grid_samples(&array->grid);
    uint64_t next = 0; /* the smallest possible next place */
    cvol_planes_take(places, count, 4, raw);
    for (size_t i = 0; i < count; i++) {
        const uint64_t place = next + places[i];
        if (place >= samples)
            return fail(context, name, "a place is beyond the array");
        if (is_in_box(&array->whole, array->grid.dims, (size_t)place))
            return fail(context, name, "a place is within the low box");
        places[i] = (uint32_t)place;
        next = place + 1;
    }
    return CVOL_OK;
}

static int take_floats(float *values, size_t count, cvol_cursor *raw)
{
    cvol_planes_take(values, count, 4, raw);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return 0;
    return 1;
}

static int fill(cvol_context *context, cvol_array *array, const size_t low[3], size_t sparse,
                cvol_cursor *raw, const char *name)
{
    cvol_spectrum *whole = &array->whole;
    int finite = 1,
        code = cvol_spectrum_start(context, whole, array->transform, array->grid.dims, low);
    if (!code)
        code = cvol_spectrum_reserve(context, whole, sparse);
    if (!code)
        finite = take_floats(whole->low_values, whole->low_count, raw);
    if (!code)
        code = take_places(context, array, whole->places, sparse, raw, name);
    if (code)
        return code;
    whole->sparse_count = sparse;
    finite &= take_floats(whole->values, sparse, raw);
    if (!finite || !(sum_of_magnitudes(whole) < SUM_MAX))
        return fail(context, name, "terms are not finite, or too large for float32");
    return CVOL_OK;
}

int cvol_spectrum_take(cvol_context *context, cvol_array *array, cvol_cursor *content,
                       const char *name)
{
    size_t low[3];
    uint64_t sparse = 0, terms = 0;
    uint8_t *raw;
    int code = take_counts(context, low, &sparse, &terms, array, content, name);
    if (code)
        return code;
    /* 4 bytes per float, 4 per place. terms is below 2^32. */
    const uint64_t size = 4 * (terms + sparse);
    code = cvol_packed_take(context, &raw, size, content, "SPEC", name);
    if (code)
        return code;
    cvol_cursor cursor = cvol_cursor_make(raw, (size_t)size);
    code = fill(context, array, low, (size_t)sparse, &cursor, name);
    free(raw);
    return code;
}
