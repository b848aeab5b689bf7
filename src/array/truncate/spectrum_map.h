/* Builds a spectrum term by term from others: filters, shifts, convolutions, other grids.
 *
 * Under DFT and DHT the two slots of a pair (p, -p) hold one complex coefficient F[p] = conj F[-p]:
 *     DFT   slot[p] = sqrt 2 Re F[p], slot[-p] = sqrt 2 Im F[p]     (p the first of its pair)
 *     DHT   slot[p] = Re F[p] - Im F[p]                             (any p)
 * and slot[p] = F[p] if p = -p. So each slot of a result follows from F at its own place, for any
 * storage of the array, and results can be filled in any order. */
#ifndef CVOL_ARRAY_TRUNCATE_SPECTRUM_MAP_H
#define CVOL_ARRAY_TRUNCATE_SPECTRUM_MAP_H

#include <complex.h>

#include "array/core/array.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "transform/whole.h"

/* The value stored at a place; 0 if there is none. */
float cvol_spectrum_value(const cvol_spectrum *spectrum, const size_t dims[3],
                          const size_t place[3]);
/* Returns 1 if the place is in the support (its value may be 0). */
int cvol_spectrum_holds(const cvol_spectrum *spectrum, const size_t dims[3], const size_t place[3]);

/* F at a place (DFT, DHT). */
double complex cvol_spectrum_coefficient(const cvol_spectrum *spectrum, cvol_transform transform,
                                         const size_t dims[3], const size_t place[3]);
/* The slot at `place` for the coefficient F. */
double cvol_slot_of(cvol_transform transform, const size_t dims[3], const size_t place[3],
                    double complex F);

/* The same for one row of the low box, of box indices (v, w): re[i], im[i] for i < box[0]. */
void cvol_spectrum_row(double *re, double *im, const cvol_spectrum *spectrum,
                       cvol_transform transform, const size_t dims[3], size_t v, size_t w);
/* The inverse: sets that row from its coefficients. */
void cvol_spectrum_set_row(cvol_spectrum *spectrum, cvol_transform transform, const size_t dims[3],
                           size_t v, size_t w, const double *re, const double *im);

static inline void cvol_place_split(size_t place[3], size_t index, const size_t dims[3])
{
    place[0] = index % dims[0];
    place[1] = index / dims[0] % dims[1];
    place[2] = index / dims[0] / dims[1];
}
static inline size_t cvol_place_join(const size_t place[3], const size_t dims[3])
{
    return place[0] + dims[0] * (place[1] + dims[1] * place[2]);
}
static inline size_t cvol_place_mirror(const size_t place[3], const size_t dims[3])
{
    const size_t mirror[3] = {cvol_mirror_index(place[0], dims[0]),
                              cvol_mirror_index(place[1], dims[1]),
                              cvol_mirror_index(place[2], dims[2])};
    return cvol_place_join(mirror, dims);
}

/* A spectrum with this low box (all 0: none) and zeros at the places outside of it. `places` may
 * repeat and be in any order; it is sorted here. Errors: MEMORY. */
int cvol_spectrum_start_places(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                               const size_t dims[3], const size_t low[3], uint32_t *places,
                               size_t count);
/* The same with the support of `like`, and (pairs 1) the other places of its pairs. */
int cvol_spectrum_start_like(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                             const size_t dims[3], const cvol_spectrum *like, int pairs);

/* Sets every term of the support to term(user, place), on all threads; removes sparse terms that
 * are 0. */
void cvol_spectrum_fill(cvol_context *context, cvol_spectrum *spectrum, const size_t dims[3],
                        double (*term)(const void *user, const size_t place[3]), const void *user);

/* The same for the sparse ones alone. */
void cvol_spectrum_fill_sparse(cvol_context *context, cvol_spectrum *spectrum, const size_t dims[3],
                               double (*term)(const void *user, const size_t place[3]),
                               const void *user);

/* Moves the terms to `out`: all of them (keep ALL or LIKE_INPUTS, *spectrum is then empty), or
 * those that `keep` selects. Sets result. Errors: as cvol_truncate. */
int cvol_spectrum_move(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       cvol_spectrum *spectrum, const cvol_keep *keep);

#endif
