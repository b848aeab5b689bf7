/* Truncation: selects the terms of a whole array by a cvol_keep.
 *
 *   1. magnitudes of all candidates (candidates.c)
 *   2. the low box: given, or chosen (low_box.c); its terms are always kept
 *   3. of the others, the level from which they are kept (level.c); if only some of those at the
 *      level fit, the ones of the lowest places
 *   4. one pass counts; one writes the kept terms and sums the squares of the others
 *
 * O(n) time, one float per candidate. A term that is 0 is kept only in the low box, or with its
 * partner in a pair.
 *
 * PSNR and L2 subtract the loss of single precision (cvol_array_rounding of the norm), so the bound
 * of the result meets the target. */
#include "array/truncate/truncate.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "array/core/level.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/low_box.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"

typedef struct truncation {
    cvol_context *context;
    cvol_array *array;
    const cvol_candidates *from;
    const cvol_keep *keep;
    float *keys; /* the dense candidates', then the list's; negative: in the low box */
    size_t dense, total, parts;
    int at_least; /* if the limit splits a pair: keep it, or drop it */
    double limit; /* numbers (RHO, RATIO) or energy (PSNR, L2) */
    cvol_level level;
    size_t cut; /* of those at the level, the ones of a place below this are kept */
} truncation;

/* ---- targets -------------------------------------------------------------------------------- */

/* The energy that may be dropped under PSNR and L2. */
static int find_energy(truncation *t, double allowed)
{
    const double norm = sqrt(cvol_sum_squares(t->keys, t->total)),
                 rounding = cvol_array_rounding(t->array) * norm, left = allowed - rounding;
    if (left <= 0 && norm > 0)
        return t->keep->rule == CVOL_KEEP_PSNR
                   ? cvol_fail(
                         t->context, CVOL_ERROR_TARGET,
                         "a PSNR of %g allows an L2 error of %g; single precision holds "
                         "these samples (L2 norm %g) to %g: ask for a lower PSNR, or keep all",
                         t->keep->value, allowed, norm, rounding)
                   : cvol_fail(t->context, CVOL_ERROR_TARGET,
                               "an L2 error of %g is out of reach; single precision holds these "
                               "samples (L2 norm %g) to %g: allow more, or keep all",
                               allowed, norm, rounding);
    /* The margin covers the rounding of magnitudes to floats. */
    t->limit = left > 0 ? left * left * (1 - 1e-6) : 0;
    t->at_least = 1;
    return CVOL_OK;
}

/* The limit of the rule; rules that turn out to be ALL become ALL. */
static int find_limit(truncation *t, cvol_keep_rule *rule)
{
    const cvol_array *array = t->array;
    const double samples = (double)cvol_grid_samples(&array->grid), value = t->keep->value;
    const double range = array->error_bound.value_max - array->error_bound.value_min;
    switch (*rule) {
    case CVOL_KEEP_RHO:
        t->limit = floor(value * samples * (1 + 1e-12));
        return CVOL_OK;
    case CVOL_KEEP_RATIO:
        t->limit = floor((4 * samples / value - CVOL_ARRAY_BYTES) / 4);
        if (t->limit < 0)
            return cvol_fail(t->context, CVOL_ERROR_TARGET,
                             "a ratio of %g leaves %.0f bytes for an array of %.0f samples; its "
                             "description alone takes %d",
                             value, 4 * samples / value, samples, CVOL_ARRAY_BYTES);
        return CVOL_OK;
    case CVOL_KEEP_PSNR:
        if (range > 0)
            return find_energy(t, range * sqrt(samples) * cvol_pow(10, -value / 20));
        *rule = CVOL_KEEP_ALL;
        return CVOL_OK;
    case CVOL_KEEP_L2:
        return find_energy(t, value);
    default:
        return CVOL_OK;
    }
}

/* ---- the low box ---------------------------------------------------------------------------- */

static int choose_low(truncation *t, size_t low[3], cvol_keep_rule rule)
{
    const cvol_transform transform = t->array->transform;
    const size_t *dims = t->array->grid.dims, *asked = t->keep->low;
    memset(low, 0, 3 * sizeof *low);
    if (t->keep->rule != CVOL_KEEP_ALL && (asked[0] || asked[1] || asked[2])) {
        memcpy(low, asked, 3 * sizeof *low);
    } else if (rule == CVOL_KEEP_TERMS || rule == CVOL_KEEP_THRESHOLD) {
        return CVOL_OK;
    } else if (rule == CVOL_KEEP_ALL) {
        return cvol_low_box_for_all(t->context, low, transform, dims, t->from, t->keys);
    } else if (rule == CVOL_KEEP_PSNR || rule == CVOL_KEEP_L2) {
        return cvol_low_box_for_energy(t->context, low, transform, dims, t->from, t->keys,
                                       t->limit);
    } else {
        return cvol_low_box_for_count(t->context, low, transform, dims, t->from, t->keys, t->limit);
    }
    const double inside = (double)cvol_low_count(transform, dims, low);
    if ((rule == CVOL_KEEP_RHO || rule == CVOL_KEEP_RATIO) && inside > t->limit)
        return cvol_fail(t->context, CVOL_ERROR_TARGET,
                         "the low box %zu x %zu x %zu holds %.0f numbers, a %s of %g allows %.0f",
                         low[0], low[1], low[2], inside, rule == CVOL_KEEP_RHO ? "rho" : "ratio",
                         t->keep->value, t->limit);
    return CVOL_OK;
}

static float *low_slot(const cvol_spectrum *s, const size_t dims[3], size_t place)
{
    const size_t i = cvol_box_index(place % dims[0], s->low[0], s->box[0], dims[0]);
    const size_t v = cvol_box_index(place / dims[0] % dims[1], s->low[1], s->box[1], dims[1]);
    const size_t w = cvol_box_index(place / dims[0] / dims[1], s->low[2], s->box[2], dims[2]);
    if (i == SIZE_MAX || v == SIZE_MAX || w == SIZE_MAX)
        return NULL;
    return s->low_values + i + s->box[0] * (v + s->box[1] * w);
}

/* The dense part of fill_low, row by row of the candidates. */
static void fill_low_row(truncation *t, size_t row)
{
    const cvol_candidates *c = t->from;
    const cvol_spectrum *s = &t->array->whole;
    const size_t *dims = t->array->grid.dims;
    const size_t v = cvol_box_place(row % c->box[1], c->low[1], c->box[1], dims[1]);
    const size_t w = cvol_box_place(row / c->box[1], c->low[2], c->box[2], dims[2]);
    const size_t j = cvol_box_index(v, s->low[1], s->box[1], dims[1]);
    const size_t l = cvol_box_index(w, s->low[2], s->box[2], dims[2]);
    if (j == SIZE_MAX || l == SIZE_MAX)
        return;
    float *to = s->low_values + s->box[0] * (j + s->box[1] * l);
    for (size_t u = 0; u < c->box[0]; u++) {
        const size_t place = cvol_box_place(u, c->low[0], c->box[0], dims[0]);
        const size_t i = cvol_box_index(place, s->low[0], s->box[0], dims[0]);
        if (i != SIZE_MAX) {
            to[i] = c->slots[row * c->box[0] + u];
            t->keys[row * c->box[0] + u] = -1;
        }
    }
}

/* Moves the candidates within the low box into it: they are no longer candidates. */
static void fill_low(truncation *t)
{
    const cvol_candidates *c = t->from;
    if (!t->array->whole.low_count)
        return;
    const size_t rows = t->dense ? c->box[1] * c->box[2] : 0;
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(t->context))
    for (size_t row = 0; row < rows; row++)
        fill_low_row(t, row);
    for (size_t i = 0; i < c->count; i++) {
        float *slot = low_slot(&t->array->whole, t->array->grid.dims, c->places[i]);
        if (slot) {
            *slot = c->values[i];
            t->keys[t->dense + i] = -1;
        }
    }
}

/* ---- the level ------------------------------------------------------------------------------ */

/* The place from which terms at the level are dropped. */
static void find_cut(truncation *t)
{
    const size_t *dims = t->array->grid.dims;
    uint64_t left = t->level.ties;
    t->cut = left >= t->level.equal ? SIZE_MAX : 0;
    if (t->cut || !left)
        return;
    cvol_run_cursor cursor = cvol_runs_start(t->from, dims, 0, 1);
    cvol_run run;
    while (cvol_runs_next(&cursor, &run, t->from, dims)) {
        const float *keys = t->keys + (run.listed ? t->dense : 0) + run.first;
        for (size_t i = 0; i < run.count; i++) {
            if (keys[i] < t->level.level || keys[i] > t->level.level)
                continue;
            const size_t place = run.listed ? t->from->places[run.first + i] : run.place + i;
            const size_t mirror = cvol_mirror_place(t->array->transform, place, dims);
            if (mirror < place)
                continue; /* counted with its partner */
            const uint64_t both = mirror == place ? 1 : 2;
            if (t->at_least ? left == 0 : left < both) {
                t->cut = place;
                return;
            }
            left -= left < both ? left : both;
        }
    }
    t->cut = SIZE_MAX;
}

static int find_level(truncation *t, cvol_keep_rule rule)
{
    const double inside = (double)t->array->whole.low_count;
    int code = CVOL_OK;
    t->level = (cvol_level){0};
    switch (rule) {
    case CVOL_KEEP_TERMS:
        code = cvol_level_of_count(t->context, &t->level, t->keys, t->total, t->keep->sparse);
        break;
    case CVOL_KEEP_RHO:
    case CVOL_KEEP_RATIO:
        code = cvol_level_of_count(t->context, &t->level, t->keys, t->total,
                                   (uint64_t)fmax(0, floor((t->limit - inside) / 2)));
        break;
    case CVOL_KEEP_PSNR:
    case CVOL_KEEP_L2:
        code = cvol_level_of_energy(t->context, &t->level, t->keys, t->total, t->limit);
        break;
    case CVOL_KEEP_THRESHOLD:
        if (t->keep->value > (double)FLT_MAX) {
            t->level.level = INFINITY;
        } else {
            t->level.level = (float)t->keep->value;
            if ((double)t->level.level < t->keep->value)
                t->level.level = nextafterf(t->level.level, INFINITY);
        }
        break;
    default:
        break;
    }
    if (!code)
        find_cut(t);
    return code;
}

/* ---- keeping -------------------------------------------------------------------------------- */

typedef struct part_result {
    size_t kept;
    double dropped;                 /* energy */
    float least_kept, most_dropped; /* magnitudes */
} part_result;

static int is_kept(const truncation *t, float key, size_t place)
{
    if (key > t->level.level)
        return 1;
    if (!(key > 0) || key < t->level.level || !t->cut)
        return 0;
    if (t->cut == SIZE_MAX)
        return 1;
    const size_t mirror = cvol_mirror_place(t->array->transform, place, t->array->grid.dims);
    return (mirror < place ? mirror : place) < t->cut;
}

/* places NULL: only counts. */
static part_result keep_part(const truncation *t, uint32_t *places, float *values, size_t part)
{
    const cvol_candidates *c = t->from;
    part_result out = {.least_kept = INFINITY};
    cvol_run_cursor cursor = cvol_runs_start(c, t->array->grid.dims, part, t->parts);
    cvol_run run;
    while (cvol_runs_next(&cursor, &run, c, t->array->grid.dims)) {
        const float *keys = t->keys + (run.listed ? t->dense : 0) + run.first;
        const float *from = (run.listed ? c->values : c->slots) + run.first;
        for (size_t i = 0; i < run.count; i++) {
            if (!(keys[i] > 0))
                continue;
            const size_t place = run.listed ? c->places[run.first + i] : run.place + i;
            if (!is_kept(t, keys[i], place)) {
                out.dropped += (double)from[i] * (double)from[i];
                out.most_dropped = keys[i] > out.most_dropped ? keys[i] : out.most_dropped;
                continue;
            }
            if (places) {
                places[out.kept] = (uint32_t)place;
                values[out.kept] = from[i];
            }
            out.least_kept = keys[i] < out.least_kept ? keys[i] : out.least_kept;
            out.kept++;
        }
    }
    return out;
}

static int keep_all_parts(truncation *t, double *dropped)
{
    cvol_spectrum *whole = &t->array->whole;
    part_result results[16], sum = {.least_kept = INFINITY};
    size_t starts[16];
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(t->context))
    for (size_t p = 0; p < t->parts; p++)
        results[p] = keep_part(t, NULL, NULL, p);
    for (size_t p = 0; p < t->parts; p++) {
        starts[p] = sum.kept;
        sum.kept += results[p].kept;
        sum.dropped += results[p].dropped;
        sum.least_kept = fminf(sum.least_kept, results[p].least_kept);
        sum.most_dropped = fmaxf(sum.most_dropped, results[p].most_dropped);
    }
    int code = cvol_spectrum_reserve(t->context, whole, sum.kept);
    if (code)
        return code;
    if (sum.kept) {
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(t->context))
        for (size_t p = 0; p < t->parts; p++)
            keep_part(t, whole->places + starts[p], whole->values + starts[p], p);
    }
    whole->sparse_count = sum.kept;
    *dropped = sqrt(sum.dropped);
    t->array->threshold = 0;
    if (sum.dropped > 0)
        t->array->threshold = (double)(sum.kept ? sum.least_kept : sum.most_dropped);
    return CVOL_OK;
}

int cvol_truncate(cvol_context *context, cvol_array *array, double *dropped,
                  const cvol_candidates *candidates, const cvol_keep *keep)
{
    const size_t dense = cvol_candidates_dense(candidates);
    truncation t = {.context = context,
                    .array = array,
                    .from = candidates,
                    .keep = keep,
                    .dense = dense,
                    .total = dense + candidates->count,
                    .parts = cvol_parts_of(dense ? dense : candidates->count)};
    cvol_keep_rule rule = keep->rule;
    size_t low[3];
    *dropped = 0;
    int code = cvol_keep_check(context, keep, array);
    if (code)
        return code;
    t.keys = cvol_allocate(t.total, sizeof *t.keys);
    if (!t.keys)
        return cvol_fail_memory(context, t.total * sizeof *t.keys, "magnitudes");
    cvol_candidates_keys(context, t.keys, candidates, array->transform, array->grid.dims);
    code = find_limit(&t, &rule);
    if (!code)
        code = choose_low(&t, low, rule);
    if (!code)
        code = cvol_spectrum_start(context, &array->whole, array->transform, array->grid.dims, low);
    if (!code) {
        fill_low(&t);
        code = find_level(&t, rule);
    }
    if (!code)
        code = keep_all_parts(&t, dropped);
    if (code)
        cvol_spectrum_free(&array->whole);
    free(t.keys);
    return code;
}
