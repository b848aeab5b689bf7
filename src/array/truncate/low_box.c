/* Chooses the low box of a truncation: a family of nested boxes, compared in one pass.
 *
 * A box of the family takes the same share of the frequencies of every axis. Box 0 is none. Subband
 * j lies in box j but not in box j - 1; the last subband lies in no box. One histogram of
 * magnitudes per subband (2048 classes, an eighth of an octave wide) gives, for each box, the
 * energy of the largest terms outside of it: the sums over the outer subbands. Within a class
 * magnitudes count as equal, so the choice may be off by a per cent; the terms to keep are then
 * selected exactly. */
#include "array/truncate/low_box.h"

#include <math.h>
#include <stdlib.h>

#include "array/core/level.h"
#include "array/truncate/candidates.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/whole.h"

enum { MAX_BOXES = 255 };

typedef struct family {
    cvol_transform transform;
    const size_t *dims;
    int boxes; /* including box 0 */
    size_t low[MAX_BOXES + 1][3];
    uint8_t *subbands[3]; /* by axis and place: the first box that contains it, or `boxes` */
} family;

static size_t most_low(cvol_transform transform, size_t n)
{
    return transform == CVOL_DCT ? n : n / 2 + 1;
}

size_t cvol_low_count(cvol_transform transform, const size_t dims[3], const size_t low[3])
{
    size_t count = low[0] || low[1] || low[2];
    for (int a = 0; a < 3; a++) {
        const size_t most = most_low(transform, dims[a]);
        const size_t k = low[a] < 1 ? 1 : low[a] < most ? low[a] : most;
        count *= transform == CVOL_DCT ? k : 2 * k - 1 < dims[a] ? 2 * k - 1 : dims[a];
    }
    return count;
}

/* ---- families ------------------------------------------------------------------------------- */

/* k is this share of `most` per axis. */
static void share_low(size_t low[3], const size_t most[3], double share)
{
    for (int a = 0; a < 3; a++) {
        low[a] = (size_t)(share * (double)most[a] + 1e-9);
        low[a] = low[a] < 1 ? 1 : low[a] < most[a] ? low[a] : most[a];
    }
}

/* Adds the largest box of at most `count` numbers if it is larger than the last one. */
static void add_box(family *f, double count)
{
    size_t most[3], low[3];
    double from = 0, to = 1;
    for (int a = 0; a < 3; a++)
        most[a] = most_low(f->transform, f->dims[a]);
    share_low(low, most, 1);
    if ((double)cvol_low_count(f->transform, f->dims, low) > count) {
        for (int i = 0; i < 40; i++) {
            const double share = (from + to) / 2;
            share_low(low, most, share);
            if ((double)cvol_low_count(f->transform, f->dims, low) <= count)
                from = share;
            else
                to = share;
        }
        share_low(low, most, from);
    }
    const size_t found = cvol_low_count(f->transform, f->dims, low);
    if ((double)found <= count &&
        found > cvol_low_count(f->transform, f->dims, f->low[f->boxes - 1]))
        memcpy(f->low[f->boxes++], low, sizeof low);
}

static void free_family(family *f)
{
    for (int a = 0; a < 3; a++)
        free(f->subbands[a]);
}

/* The tables of a family whose boxes are known. Errors: MEMORY. */
static int find_subbands(cvol_context *context, family *f)
{
    for (int a = 0; a < 3; a++) {
        const size_t n = f->dims[a];
        f->subbands[a] = cvol_allocate(n, 1);
        if (!f->subbands[a]) {
            free_family(f);
            return cvol_fail_memory(context, n, "a table of frequencies");
        }
        const size_t top = most_low(f->transform, n);
        int j = 1;
        for (size_t frequency = 0; frequency < top; frequency++) {
            while (j < f->boxes && f->low[j][a] <= frequency)
                j++;
            f->subbands[a][frequency] = (uint8_t)j;
            if (f->transform != CVOL_DCT)
                f->subbands[a][cvol_mirror_index(frequency, n)] = (uint8_t)j;
        }
    }
    return CVOL_OK;
}

static int largest(int a, int b)
{
    return a > b ? a : b;
}

/* Calls EACH(subband, key) for the candidates of a run. */
#define FOR_SUBBANDS(f, run, c, keys, dense, EACH)                                                 \
    do {                                                                                           \
        const uint32_t nx = (uint32_t)(f)->dims[0], ny = (uint32_t)(f)->dims[1];                   \
        const float *run_keys = (keys) + ((run)->listed ? (dense) : 0) + (run)->first;             \
        if ((run)->listed) {                                                                       \
            for (size_t i = 0; i < (run)->count; i++) {                                            \
                const uint32_t place = (c)->places[(run)->first + i], row = place / nx;            \
                const int outer = largest((f)->subbands[1][row % ny], (f)->subbands[2][row / ny]); \
                EACH(largest(outer, (f)->subbands[0][place % nx]), run_keys[i]);                   \
            }                                                                                      \
        } else {                                                                                   \
            const size_t row = (run)->place / nx, u = (run)->place % nx;                           \
            const int outer = largest((f)->subbands[1][row % ny], (f)->subbands[2][row / ny]);     \
            for (size_t i = 0; i < (run)->count; i++)                                              \
                EACH(largest(outer, (f)->subbands[0][u + i]), run_keys[i]);                        \
        }                                                                                          \
    } while (0)

/* ---- by histograms -------------------------------------------------------------------------- */

static void count_part(cvol_level_bucket *buckets, const family *f, const cvol_candidates *c,
                       const float *keys, size_t part, size_t parts)
{
    const size_t dense = cvol_candidates_dense(c);
    cvol_run_cursor cursor = cvol_runs_start(c, f->dims, part, parts);
    cvol_run run;
#define COUNT(subband, key)                                                                  \
    do {                                                                                     \
        const float magnitude = (key);                                                       \
        if (magnitude > 0) {                                                                 \
            cvol_level_bucket *bucket =                                                      \
                &buckets[(size_t)(subband)*CVOL_LEVEL_BUCKETS + cvol_key_bucket(magnitude)]; \
            bucket->count++;                                                                 \
            bucket->energy += (double)magnitude * (double)magnitude;                         \
        }                                                                                    \
    } while (0)
    while (cvol_runs_next(&cursor, &run, c, f->dims))
        FOR_SUBBANDS(f, &run, c, keys, dense, COUNT);
#undef COUNT
}

/* The cost of a box: numbers, and the energy left out. */
typedef struct box_cost {
    double numbers, energy;
} box_cost;

/* With at most `count` terms outside of the box. */
static box_cost cost_of_count(const cvol_level_bucket *outside, double count)
{
    box_cost cost = {0};
    for (int b = CVOL_LEVEL_BUCKETS - 1; b >= 0; b--) {
        if (!outside[b].count)
            continue;
        const double kept = fmin((double)outside[b].count, count);
        count -= kept;
        cost.numbers += 2 * kept;
        cost.energy += outside[b].energy * (1 - kept / (double)outside[b].count);
    }
    return cost;
}

/* With at most `energy` left out. */
static box_cost cost_of_energy(const cvol_level_bucket *outside, double energy)
{
    box_cost cost = {0};
    for (int b = 0; b < CVOL_LEVEL_BUCKETS; b++) {
        if (!outside[b].count)
            continue;
        const double dropped = fmin(outside[b].energy, energy);
        energy -= dropped;
        cost.numbers += 2 * (double)outside[b].count * (1 - dropped / outside[b].energy);
    }
    return cost;
}

/* The best box; numbers < 0: by energy. */
static int choose(cvol_context *context, size_t low[3], family *f, const cvol_candidates *c,
                  const float *keys, double numbers, double energy)
{
    const size_t dense = cvol_candidates_dense(c);
    const size_t parts = cvol_parts_of(dense ? dense : c->count);
    const size_t each = (size_t)(f->boxes + 1) * CVOL_LEVEL_BUCKETS;
    cvol_level_bucket *buckets = cvol_allocate_zero(parts * each, sizeof *buckets);
    int code = buckets ? find_subbands(context, f)
                       : cvol_fail_memory(context, parts * each * sizeof *buckets,
                                          "histograms of magnitudes");
    if (code)
        goto done;
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(context))
    for (size_t p = 0; p < parts; p++)
        count_part(buckets + p * each, f, c, keys, p, parts);
    for (size_t i = each; i < parts * each; i++) {
        buckets[i % each].count += buckets[i].count;
        buckets[i % each].energy += buckets[i].energy;
    }
    /* From the largest box inwards, so that the last subband's histogram collects all outside
     * terms. */
    cvol_level_bucket *outside = buckets + (size_t)f->boxes * CVOL_LEVEL_BUCKETS;
    int best = 0;
    box_cost least = {INFINITY, INFINITY};
    for (int j = f->boxes - 1; j >= 0; j--) {
        const double inside = (double)cvol_low_count(f->transform, f->dims, f->low[j]);
        box_cost cost = numbers < 0 ? cost_of_energy(outside, energy)
                                    : cost_of_count(outside, floor((numbers - inside) / 2));
        cost.numbers += inside;
        if (cost.energy < least.energy ||
            (cost.energy <= least.energy && cost.numbers < least.numbers)) {
            least = cost;
            best = j;
        }
        for (size_t b = 0; b < CVOL_LEVEL_BUCKETS; b++) {
            outside[b].count += buckets[(size_t)j * CVOL_LEVEL_BUCKETS + b].count;
            outside[b].energy += buckets[(size_t)j * CVOL_LEVEL_BUCKETS + b].energy;
        }
    }
    memcpy(low, f->low[best], sizeof f->low[best]);
    free_family(f);
done:
    free(buckets);
    return code;
}

int cvol_low_box_for_count(cvol_context *context, size_t low[3], cvol_transform transform,
                           const size_t dims[3], const cvol_candidates *c, const float *keys,
                           double numbers)
{
    static const double shares[] = {0.005, 0.02, 0.06, 0.125, 0.25, 0.35, 0.5, 0.7, 0.85, 1};
    family f = {.transform = transform, .dims = dims, .boxes = 1};
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
        add_box(&f, shares[i] * numbers);
    return choose(context, low, &f, c, keys, numbers, 0);
}

int cvol_low_box_for_energy(cvol_context *context, size_t low[3], cvol_transform transform,
                            const size_t dims[3], const cvol_candidates *c, const float *keys,
                            double energy)
{
    family f = {.transform = transform, .dims = dims, .boxes = 1};
    for (int i = 11; i >= 0; i--)
        add_box(&f, ldexp((double)dims[0] * (double)dims[1] * (double)dims[2], -i));
    return choose(context, low, &f, c, keys, -1, energy);
}

/* ---- by counts ------------------------------------------------------------------------------ */

/* One past the highest nonzero frequency per axis. */
static void find_extent(size_t extent[3], const family *f, const cvol_candidates *c,
                        const float *keys)
{
    const size_t dense = cvol_candidates_dense(c), *dims = f->dims;
    cvol_run_cursor cursor = cvol_runs_start(c, dims, 0, 1);
    cvol_run run;
    memset(extent, 0, 3 * sizeof *extent);
    while (cvol_runs_next(&cursor, &run, c, dims)) {
        const float *run_keys = keys + (run.listed ? dense : 0) + run.first;
        for (size_t i = 0; i < run.count; i++) {
            if (!(run_keys[i] > 0))
                continue;
            size_t rest = run.listed ? c->places[run.first + i] : run.place + i;
            for (int a = 0; a < 3; a++, rest /= dims[a - 1]) {
                const size_t u = rest % dims[a];
                const size_t k = 1 + (f->transform == CVOL_DCT ? u : cvol_frequency(u, dims[a]));
                extent[a] = k > extent[a] ? k : extent[a];
            }
        }
    }
}

static void count_subbands(uint64_t *counts, const family *f, const cvol_candidates *c,
                           const float *keys)
{
    const size_t dense = cvol_candidates_dense(c);
    cvol_run_cursor cursor = cvol_runs_start(c, f->dims, 0, 1);
    cvol_run run;
#define COUNT(subband, key) counts[subband] += (key) > 0
    while (cvol_runs_next(&cursor, &run, c, f->dims))
        FOR_SUBBANDS(f, &run, c, keys, dense, COUNT);
#undef COUNT
}

/* Lowers *least to the fewest numbers of any box of the family; `low` is that box. */
static int count_family(cvol_context *context, size_t low[3], uint64_t *least, family *f,
                        const cvol_candidates *c, const float *keys)
{
    uint64_t counts[MAX_BOXES + 1] = {0}, outside = 0;
    int code = find_subbands(context, f);
    if (code)
        return code;
    count_subbands(counts, f, c, keys);
    outside = counts[f->boxes];
    for (int j = f->boxes - 1; j >= 0; j--) {
        const uint64_t numbers = 2 * outside + cvol_low_count(f->transform, f->dims, f->low[j]);
        if (numbers < *least) {
            *least = numbers;
            memcpy(low, f->low[j], sizeof f->low[j]);
        }
        outside += counts[j];
    }
    free_family(f);
    return CVOL_OK;
}

/* Two families: the same share of every axis's extent, and the same k (the form that TERMS
 * uses). */
int cvol_low_box_for_all(cvol_context *context, size_t low[3], cvol_transform transform,
                         const size_t dims[3], const cvol_candidates *c, const float *keys)
{
    family shared = {.transform = transform, .dims = dims, .boxes = 1}, cubic = shared;
    size_t extent[3], longest = 0;
    uint64_t least = UINT64_MAX;
    memset(low, 0, 3 * sizeof *low);
    find_extent(extent, &shared, c, keys);
    for (int a = 0; a < 3; a++)
        longest = extent[a] > longest ? extent[a] : longest;
    if (!longest)
        return CVOL_OK;
    const size_t boxes = longest < MAX_BOXES - 1 ? longest : MAX_BOXES - 1;
    for (size_t j = 1; j <= boxes; j++) {
        share_low(shared.low[shared.boxes++], extent, (double)j / (double)boxes);
        for (int a = 0; a < 3; a++)
            cubic.low[cubic.boxes][a] = j < extent[a] ? j : extent[a];
        cubic.boxes++;
    }
    int code = count_family(context, low, &least, &shared, c, keys);
    if (!code)
        code = count_family(context, low, &least, &cubic, c, keys);
    return code;
}
