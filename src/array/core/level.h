/* The magnitude from which terms are kept: selection without sorting.
 *
 * Keys are magnitudes; a negative key is no candidate. The bits of non-negative floats rise with
 * their values, so three histograms over 11, 10 and 10 bits find any quantile exactly, in O(n): a
 * radix selection. Their sums do not depend on the number of threads. */
#ifndef CVOL_ARRAY_CORE_LEVEL_H
#define CVOL_ARRAY_CORE_LEVEL_H

#include <stdint.h>
#include <string.h>

#include "cvol/base.h"

/* Kept: the keys above `level`, and `ties` of the `equal` ones at it. */
typedef struct cvol_level {
    float level;
    uint64_t ties, equal;
} cvol_level;

/* The `count` largest of the keys that are not 0 (all of them if there are fewer). */
int cvol_level_of_count(cvol_context *context, cvol_level *out, const float *keys, size_t n,
                        uint64_t count);
/* The fewest keys such that the others have at most `energy` as sum of squares. Errors of both:
 * MEMORY. */
int cvol_level_of_energy(cvol_context *context, cvol_level *out, const float *keys, size_t n,
                         double energy);

/* ---- the histograms ------------------------------------------------------------------------- */

enum { CVOL_LEVEL_BUCKETS = 2048 };

typedef struct cvol_level_bucket {
    uint64_t count;
    double energy;
} cvol_level_bucket;

static inline uint32_t cvol_key_bits(float key)
{
    uint32_t bits;
    memcpy(&bits, &key, sizeof bits);
    return bits;
}

/* The first of the histograms: by exponent and three bits more. */
static inline uint32_t cvol_key_bucket(float key)
{
    return cvol_key_bits(key) >> 20;
}

/* The number of parts that work on n terms is divided into. It does not depend on the number of
 * threads, so sums over parts always have the same bits. */
static inline size_t cvol_parts_of(size_t n)
{
    const size_t parts = n >> 18;
    return parts < 1 ? 1 : parts < 16 ? parts : 16;
}

/* The start of part `part` of `parts`; part = parts: n. */
static inline size_t cvol_part_begin(size_t n, size_t part, size_t parts)
{
    return n / parts * part + (part < n % parts ? part : n % parts);
}

#endif
