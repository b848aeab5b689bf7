/* A whole array on a grid of half or twice the samples: the same function of place. Coefficients
 * only change by the norm, sqrt(N' / N).
 *
 * DFT and DHT: an even axis of n samples has one term at its Nyquist frequency n / 2, a cosine.
 * Twice the samples separate n / 2 from -n / 2: each takes half of the term. Half the samples do
 * not separate n'/2 from -n'/2: the new Nyquist term is their sum (the cosine's share; the sine
 * vanishes at all samples). So one operation undoes the other. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/spectrum_map.h"
#include "base/context.h"
#include "base/memory.h"

typedef struct resampling {
    const cvol_array *a;
    const size_t *from, *to; /* dims */
    double scale;
} resampling;

/* Finds the indices on an axis of n samples that become index u of n_new; returns their number (0
 * to 2). */
static int sources(size_t out[2], double *weight, size_t u, size_t n, size_t n_new)
{
    const size_t frequency = cvol_frequency(u, n_new);
    *weight = 1;
    out[0] = 2 * u <= n_new ? frequency : n - frequency;
    out[1] = 0;
    if (n_new > n) {
        if (2 * frequency == n) {
            out[0] = frequency;
            *weight = 0.5;
        }
        return 2 * frequency <= n;
    }
    if (n_new < n && 2 * frequency == n_new) {
        out[1] = n - frequency;
        return 2;
    }
    return 1;
}

static double resampled_term(const void *user, const size_t place[3])
{
    const resampling *r = user;
    const cvol_spectrum *terms = &r->a->whole;
    if (r->a->transform == CVOL_DCT) {
        for (int a = 0; a < 3; a++)
            if (place[a] >= r->from[a])
                return 0;
        return r->scale * (double)cvol_spectrum_value(terms, r->from, place);
    }
    size_t index[3][2];
    int count[3];
    double scale = r->scale, weight;
    for (int a = 0; a < 3; a++) {
        count[a] = sources(index[a], &weight, place[a], r->from[a], r->to[a]);
        scale *= weight;
    }
    double complex sum = 0;
    for (int l = 0; l < count[2]; l++)
        for (int j = 0; j < count[1]; j++)
            for (int i = 0; i < count[0]; i++) {
                const size_t at[3] = {index[0][i], index[1][j], index[2][l]};
                sum += cvol_spectrum_coefficient(terms, r->a->transform, r->from, at);
            }
    return cvol_slot_of(r->a->transform, r->to, place, scale * sum);
}

/* Finds the new indices that index u of an axis goes to; returns their number (0 to 2). */
static int targets(size_t out[2], size_t u, size_t n, size_t n_new, cvol_transform transform)
{
    out[0] = u;
    out[1] = 0;
    if (transform == CVOL_DCT)
        return u < n_new;
    const size_t frequency = cvol_frequency(u, n);
    if (2 * frequency > n_new)
        return 0;
    out[0] = 2 * u <= n ? frequency : (n_new - frequency) % n_new;
    if (n_new > n && 2 * frequency == n && n > 1) {
        out[1] = n_new - frequency;
        return 2;
    }
    return 1;
}

static int start_terms(cvol_context *context, cvol_spectrum *out, const resampling *r)
{
    const cvol_spectrum *from = &r->a->whole;
    const size_t room = 16 * from->sparse_count; /* 2^3 targets and their mirrors */
    uint32_t *places = cvol_allocate(from->sparse_count, 16 * sizeof *places);
    if (!places)
        return cvol_fail_memory(context, room * sizeof *places, "places");
    size_t count = 0;
    for (size_t s = 0; s < from->sparse_count; s++) {
        size_t place[3], index[3][2];
        int many[3];
        cvol_place_split(place, from->places[s], r->from);
        for (int a = 0; a < 3; a++)
            many[a] = targets(index[a], place[a], r->from[a], r->to[a], r->a->transform);
        for (int l = 0; l < many[2]; l++)
            for (int j = 0; j < many[1]; j++)
                for (int i = 0; i < many[0]; i++) {
                    const size_t at[3] = {index[0][i], index[1][j], index[2][l]};
                    places[count++] = (uint32_t)cvol_place_join(at, r->to);
                    if (r->a->transform != CVOL_DCT)
                        places[count++] = (uint32_t)cvol_place_mirror(at, r->to);
                }
    }
    int code = cvol_spectrum_start_places(context, out, r->a->transform, r->to, from->low, places,
                                          count);
    free(places);
    return code;
}

int cvol_whole_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep)
{
    const resampling r = {
        .a = a,
        .from = a->grid.dims,
        .to = out->grid.dims,
        .scale = sqrt((double)cvol_grid_samples(&out->grid) / (double)cvol_grid_samples(&a->grid))};
    cvol_spectrum terms;
    int code = start_terms(context, &terms, &r);
    if (code)
        return code;
    cvol_spectrum_fill(context, &terms, r.to, resampled_term, &r);
    code = cvol_spectrum_move(context, out, result, &terms, keep);
    cvol_spectrum_free(&terms);
    return code;
}
