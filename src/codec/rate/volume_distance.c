/* The distance of two volumes, slab by slab. */
#include "codec/rate/volume_distance.h"

#include <math.h>
#include <stdlib.h>

#include "array/core/share.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

/* Slices per evaluation. */
enum { SLICES = 64 };

typedef struct slices {
    void *stored[2];
    float *real[2];
} slices;

#define ADD_STORED(type)                                                                   \
    do {                                                                                   \
        const type *a = (const type *)from->stored[0], *b = (const type *)from->stored[1]; \
        for (size_t i = first; i < first + count; i++) {                                   \
            const double error = fabs((double)a[i] - (double)b[i]);                        \
            /* Fills match, also NaN. */                                                   \
            const double known = isnan(error) ? 0 : error;                                 \
            sum->stored_l2 += known * known;                                               \
            sum->most = known > sum->most ? known : sum->most;                             \
        }                                                                                  \
    } while (0)

/* Adds the squared differences of one slice. */
static void add_slice(cvol_volume_distance *sum, const slices *from, cvol_type type, size_t first,
                      size_t count)
{
    CVOL_FOR_TYPE(type, ADD_STORED);
    for (size_t i = first; i < first + count; i++) {
        const double error = (double)from->real[0][i] - (double)from->real[1][i];
        sum->real_l2 += isnan(error) ? 0 : error * error;
        sum->real_most = fmax(sum->real_most, fabs(error)); /* fmax passes over NaN */
    }
}

static int add_slab(cvol_context *context, cvol_volume_distance *of_slices, slices *s,
                    const cvol_array *arrays[2], size_t first, size_t end)
{
    const size_t *dims = arrays[0]->grid.dims, slice = dims[0] * dims[1];
    const size_t from[3] = {0, 0, first}, to[3] = {dims[0], dims[1], end};
    for (int i = 0; i < 2; i++) {
        int code = cvol_array_evaluate_box(context, s->stored[i], arrays[i], from, to);
        if (!code)
            code = cvol_array_evaluate_unmasked(context, s->real[i], arrays[i], from, to);
        if (code)
            return code;
    }
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = 0; z < end - first; z++)
        add_slice(&of_slices[first + z], s, arrays[0]->grid.type, z * slice, slice);
    return CVOL_OK;
}

int cvol_volume_distance_between(cvol_context *context, cvol_volume_distance *out,
                                 const cvol_array *a, const cvol_array *b)
{
    const cvol_array *arrays[2] = {a, b};
    const size_t *dims = a->grid.dims, size = cvol_type_size(a->grid.type);
    const size_t most = dims[2] < SLICES ? dims[2] : SLICES, count = dims[0] * dims[1] * most;
    const cvol_share share = cvol_share_of(context, a);
    cvol_volume_distance *of_slices = cvol_allocate_zero(dims[2], sizeof *of_slices);
    slices s = {{0}, {0}};
    int code = of_slices ? CVOL_OK : cvol_fail_memory(context, dims[2] * sizeof *out, "sums");
    *out = (cvol_volume_distance){0};
    for (int i = 0; i < 2; i++) {
        s.stored[i] = cvol_allocate(count, size);
        s.real[i] = cvol_allocate(count, sizeof(float));
        if (!s.stored[i] || !s.real[i])
            code = cvol_fail_memory(context, count * (size + sizeof(float)), "decoded slices");
    }
    for (size_t z = share.slices[0], end; z < share.slices[1] && !code; z = end) {
        end = share.slices[1] - z < SLICES ? share.slices[1] : z + SLICES;
        code = add_slab(context, of_slices, &s, arrays, z, end);
    }
    code = cvol_team_complete(context, share.team, code, of_slices, sizeof *of_slices,
                              share.slices[0], share.slices[1]);
    for (size_t z = 0; z < dims[2] && !code; z++) {
        out->real_l2 += of_slices[z].real_l2;
        out->stored_l2 += of_slices[z].stored_l2;
        out->real_most = fmax(out->real_most, of_slices[z].real_most);
        out->most = fmax(out->most, of_slices[z].most);
    }
    free(of_slices);
    for (int i = 0; i < 2; i++) {
        free(s.stored[i]);
        free(s.real[i]);
    }
    out->real_l2 = sqrt(out->real_l2);
    out->stored_l2 = sqrt(out->stored_l2);
    return code;
}
