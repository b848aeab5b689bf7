/* Radix selection of magnitudes, by count or by energy. */
#include "array/core/level.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

/* Counts the keys whose bits above `shift` + `width` equal `prefix`, by the `width` bits above
 * `shift`. 0 is no candidate. */
static void count_keys(cvol_level_bucket *buckets, const float *keys, size_t n, uint32_t prefix,
                       int shift, int width)
{
    const uint32_t mask = (UINT32_C(1) << width) - 1;
    for (size_t i = 0; i < n; i++) {
        const uint32_t bits = cvol_key_bits(keys[i]);
        if (keys[i] > 0 && bits >> (shift + width) == prefix) {
            cvol_level_bucket *bucket = &buckets[bits >> shift & mask];
            bucket->count++;
            bucket->energy += (double)keys[i] * (double)keys[i];
        }
    }
}

/* Adds the sums of all parts to part 0. */
static void count_all(cvol_context *context, cvol_level_bucket *buckets, const float *keys,
                      size_t n, uint32_t prefix, int shift, int width)
{
    const size_t parts = cvol_parts_of(n);
    memset(buckets, 0, parts * CVOL_LEVEL_BUCKETS * sizeof *buckets);
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(context))
    for (size_t p = 0; p < parts; p++) {
        const size_t begin = cvol_part_begin(n, p, parts), end = cvol_part_begin(n, p + 1, parts);
        count_keys(buckets + p * CVOL_LEVEL_BUCKETS, keys + begin, end - begin, prefix, shift,
                   width);
    }
    for (size_t p = 1; p < parts; p++)
        for (size_t b = 0; b < CVOL_LEVEL_BUCKETS; b++) {
            buckets[b].count += buckets[p * CVOL_LEVEL_BUCKETS + b].count;
            buckets[b].energy += buckets[p * CVOL_LEVEL_BUCKETS + b].energy;
        }
}

/* Finds the bucket with the limit: from above, where *count may still be kept, or from below, where
 * *energy may still be left out. Returns -1 if the limit is not reached. */
static int find_bucket(const cvol_level_bucket *buckets, uint64_t *count, double *energy)
{
    if (energy) {
        for (int b = 0; b < CVOL_LEVEL_BUCKETS; b++) {
            if (buckets[b].count && buckets[b].energy > *energy)
                return b;
            *energy -= buckets[b].energy;
        }
        return -1;
    }
    for (int b = CVOL_LEVEL_BUCKETS - 1; b >= 0; b--) {
        if (buckets[b].count > *count)
            return b;
        *count -= buckets[b].count;
    }
    return -1;
}

static int find_level(cvol_context *context, cvol_level *out, const float *keys, size_t n,
                      uint64_t count, double *energy)
{
    static const int shifts[3] = {20, 10, 0}, widths[3] = {11, 10, 10};
    const size_t all = cvol_parts_of(n) * CVOL_LEVEL_BUCKETS;
    cvol_level_bucket *buckets = cvol_allocate(all, sizeof *buckets);
    if (!buckets)
        return cvol_fail_memory(context, all * sizeof *buckets, "histograms of magnitudes");
    uint32_t prefix = 0;
    *out = (cvol_level){.level = energy ? INFINITY : 0};
    for (int pass = 0; pass < 3; pass++) {
        count_all(context, buckets, keys, n, prefix, shifts[pass], widths[pass]);
        int b = find_bucket(buckets, &count, energy);
        if (b < 0 && pass == 0)
            goto done;
        /* Sums of energies are rounded: if the bucket below was full, take its fullest. */
        for (int i = 0; b < 0 && i < CVOL_LEVEL_BUCKETS; i++)
            if (buckets[CVOL_LEVEL_BUCKETS - 1 - i].count)
                b = CVOL_LEVEL_BUCKETS - 1 - i;
        prefix = prefix << widths[pass] | (uint32_t)b;
        out->equal = buckets[b].count;
    }
    memcpy(&out->level, &prefix, sizeof prefix);
    out->ties = count;
    if (energy) {
        const double one = (double)out->level * (double)out->level;
        const double left_out = one > 0 ? floor(*energy / one) : 0;
        out->ties = left_out < (double)out->equal ? out->equal - (uint64_t)left_out : 0;
    }
done:
    free(buckets);
    return CVOL_OK;
}

int cvol_level_of_count(cvol_context *context, cvol_level *out, const float *keys, size_t n,
                        uint64_t count)
{
    return find_level(context, out, keys, n, count, NULL);
}

int cvol_level_of_energy(cvol_context *context, cvol_level *out, const float *keys, size_t n,
                         double energy)
{
    return find_level(context, out, keys, n, 0, &energy);
}
