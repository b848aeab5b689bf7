/* Terms of whole arrays. */
#include "array/core/spectrum.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

int cvol_spectrum_start(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                        const size_t dims[3], const size_t low[3])
{
    memset(out, 0, sizeof *out);
    if (!low[0] && !low[1] && !low[2])
        return CVOL_OK;
    out->low_count = 1;
    for (int a = 0; a < 3; a++) {
        size_t most = transform == CVOL_DCT ? dims[a] : dims[a] / 2 + 1;
        out->low[a] = low[a] < 1 ? 1 : low[a] < most ? low[a] : most;
        out->box[a] = out->low[a];
        if (transform != CVOL_DCT)
            out->box[a] = 2 * out->low[a] - 1 < dims[a] ? 2 * out->low[a] - 1 : dims[a];
        out->low_count *= out->box[a];
    }
    out->low_values = cvol_allocate_zero(out->low_count, sizeof *out->low_values);
    if (out->low_values)
        return CVOL_OK;
    size_t bytes = out->low_count * sizeof *out->low_values;
    memset(out, 0, sizeof *out);
    return cvol_fail_memory(context, bytes, "a low box");
}

int cvol_spectrum_reserve(cvol_context *context, cvol_spectrum *spectrum, size_t count)
{
    if (count <= spectrum->sparse_capacity)
        return CVOL_OK;
    uint32_t *places = cvol_allocate(count, sizeof *places);
    float *values = cvol_allocate(count, sizeof *values);
    if (!places || !values) {
        free(places);
        free(values);
        return cvol_fail_memory(context, count * (sizeof *places + sizeof *values), "sparse terms");
    }
    if (spectrum->sparse_count) {
        memcpy(places, spectrum->places, spectrum->sparse_count * sizeof *places);
        memcpy(values, spectrum->values, spectrum->sparse_count * sizeof *values);
    }
    free(spectrum->places);
    free(spectrum->values);
    spectrum->places = places;
    spectrum->values = values;
    spectrum->sparse_capacity = count;
    return CVOL_OK;
}

void cvol_spectrum_free(cvol_spectrum *spectrum)
{
    free(spectrum->low_values);
    free(spectrum->places);
    free(spectrum->values);
    memset(spectrum, 0, sizeof *spectrum);
}

void cvol_spectrum_scatter(float *slots, const cvol_spectrum *spectrum, const size_t dims[3])
{
    const size_t *low = spectrum->low, *box = spectrum->box;
    memset(slots, 0, dims[0] * dims[1] * dims[2] * sizeof *slots);
    const float *from = spectrum->low_values;
    for (size_t w = 0; w < box[2]; w++)
        for (size_t v = 0; v < box[1]; v++, from += box[0]) {
            float *row = slots + dims[0] * (cvol_box_place(v, low[1], box[1], dims[1]) +
                                            dims[1] * cvol_box_place(w, low[2], box[2], dims[2]));
            memcpy(row, from, low[0] * sizeof *row);
            size_t rest = box[0] - low[0];
            if (rest)
                memcpy(row + dims[0] - rest, from + low[0], rest * sizeof *row);
        }
    for (size_t i = 0; i < spectrum->sparse_count; i++)
        slots[spectrum->places[i]] = spectrum->values[i];
}

double cvol_sum_squares(const float *values, size_t count)
{
    double sums[16] = {0};
    size_t i = 0;
    for (; i + 16 <= count; i += 16)
        for (size_t l = 0; l < 16; l++)
            sums[l] += (double)values[i + l] * (double)values[i + l];
    for (; i < count; i++)
        sums[0] += (double)values[i] * (double)values[i];
    for (size_t half = 8; half > 0; half /= 2)
        for (size_t l = 0; l < half; l++)
            sums[l] += sums[l + half];
    return sums[0];
}

double cvol_spectrum_energy(const cvol_spectrum *spectrum)
{
    return cvol_sum_squares(spectrum->low_values, spectrum->low_count) +
           cvol_sum_squares(spectrum->values, spectrum->sparse_count);
}

void cvol_spectrum_extent(size_t extent[3], const cvol_spectrum *spectrum, cvol_transform transform,
                          const size_t dims[3])
{
    for (int a = 0; a < 3; a++)
        extent[a] = spectrum->low_count ? spectrum->low[a] - 1 : 0;
    for (size_t i = 0; i < spectrum->sparse_count; i++) {
        size_t rest = spectrum->places[i];
        for (int a = 0; a < 3; a++) {
            size_t u = rest % dims[a];
            rest /= dims[a];
            if (transform != CVOL_DCT)
                u = cvol_frequency(u, dims[a]);
            extent[a] = u > extent[a] ? u : extent[a];
        }
    }
}
