/* Selection by a histogram of magnitudes. */
#include "array/truncate/build_select.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"

int cvol_bins_make(cvol_bins *out)
{
    memset(out, 0, sizeof *out);
    out->bins = cvol_allocate_zero(CVOL_BINS, sizeof *out->bins);
    return out->bins != NULL;
}

void cvol_bins_free(cvol_bins *bins)
{
    free(bins->bins);
    bins->bins = NULL;
}

void cvol_bins_merge(cvol_bins *to, const cvol_bins *from)
{
    for (size_t b = 0; b < CVOL_BINS; b++) {
        to->bins[b].count += from->bins[b].count;
        to->bins[b].sum += from->bins[b].sum;
        to->bins[b].squares += from->bins[b].squares;
    }
    to->forced += from->forced;
    to->escapes += from->escapes;
}

static float key_of(uint32_t bits)
{
    float key;
    memcpy(&key, &bits, sizeof key);
    return key;
}

/* The least key of a bin; behind the last bin infinity, the key of forced terms. */
static float edge(uint32_t bin)
{
    const uint32_t infinity = UINT32_C(0x7F800000) >> CVOL_BIN_SHIFT;
    return key_of((bin < infinity ? bin : infinity) << CVOL_BIN_SHIFT);
}

/* Sum of the squares of the keys in a bin; within a bin they count as evenly spaced. */
static double bin_energy(const cvol_bins *bins, uint32_t b)
{
    const cvol_bin *bin = &bins->bins[b];
    if (!bin->count)
        return 0;
    const double base = (double)edge(b), ulp = (double)key_of((b << CVOL_BIN_SHIFT) + 1) - base;
    return (double)bin->count * base * base + 2 * base * ulp * (double)bin->sum +
           ulp * ulp * (double)bin->squares;
}

static uint32_t bin_of(float key)
{
    uint32_t bits;
    memcpy(&bits, &key, sizeof bits);
    return bits >> CVOL_BIN_SHIFT;
}

double cvol_select_allowed(const cvol_array *array, const cvol_keep *keep)
{
    if (keep->rule == CVOL_KEEP_L2)
        return keep->value;
    const cvol_error_bound *error_bound = &array->error_bound;
    return (error_bound->value_max - error_bound->value_min) *
           sqrt((double)cvol_grid_samples(&array->grid)) * cvol_pow(10, -keep->value / 20);
}

/* ---- rules that limit the number of terms ---------------------------------------------------- */

/* The number of terms, forced ones included, that the array may have. */
static double terms_allowed(const cvol_array *array, const cvol_keep *keep, const cvol_bins *bins,
                            uint64_t base_bytes)
{
    const double samples = (double)cvol_grid_samples(&array->grid);
    if (keep->rule == CVOL_KEEP_TERMS)
        return (double)keep->sparse + (double)bins->forced;
    if (keep->rule == CVOL_KEEP_RHO)
        return floor(keep->value * samples);
    const double words = floor((4 * samples / keep->value - (double)base_bytes) / 4);
    const double escapes = (double)bins->escapes;
    /* The largest terms are the ones that take two words. */
    return words >= 2 * escapes ? words - escapes : floor(words / 2);
}

static int select_count(cvol_context *context, cvol_selection *out, const cvol_array *array,
                        const cvol_keep *keep, const cvol_bins *bins, uint64_t base_bytes,
                        uint32_t floor_bin)
{
    double left = terms_allowed(array, keep, bins, base_bytes) - (double)bins->forced;
    if (left < 0 && keep->rule == CVOL_KEEP_RATIO && bins->forced == 0)
        return cvol_fail(
            context, CVOL_ERROR_TARGET,
            "ratio %g cannot be met: %llu samples take %llu bytes without any term, of "
            "ratio %.3g",
            keep->value, (unsigned long long)cvol_grid_samples(&array->grid),
            (unsigned long long)base_bytes,
            4 * (double)cvol_grid_samples(&array->grid) / (double)base_bytes);
    if (left < 0)
        return cvol_fail(context, CVOL_ERROR_TARGET,
                         "%s %g is out of reach: the array takes %llu bytes without terms, and the "
                         "low boxes have %llu terms",
                         keep->rule == CVOL_KEEP_RHO ? "rho" : "ratio", keep->value,
                         (unsigned long long)base_bytes, (unsigned long long)bins->forced);
    uint32_t b = CVOL_BINS;
    while (b > floor_bin && (double)bins->bins[b - 1].count <= left)
        left -= (double)bins->bins[--b].count;
    out->least = out->critical = edge(b);
    if (b > floor_bin && left > 0) {
        out->least = edge(b - 1);
        out->most = (uint64_t)left;
    }
    return CVOL_OK;
}

/* ---- rules that limit the loss --------------------------------------------------------------- */

static int select_energy(cvol_context *context, cvol_selection *out, const cvol_array *array,
                         const cvol_keep *keep, const cvol_bins *bins, uint32_t floor_bin)
{
    const double allowed = cvol_select_allowed(array, keep), budget = allowed * allowed;
    double lost = 0, kept = (double)bins->forced;
    for (uint32_t b = floor_bin; b < CVOL_BINS; b++)
        kept += (double)bins->bins[b].count;
    uint32_t b = 0;
    for (; b < CVOL_BINS; b++) {
        const double energy = bin_energy(bins, b);
        const double still = b < floor_bin ? kept : kept - (double)bins->bins[b].count;
        if (lost + energy + still * out->rounded > budget && bins->bins[b].count)
            break;
        lost += energy;
        kept = still;
    }
    if (b < floor_bin || lost + kept * out->rounded > budget)
        return cvol_fail(
            context, CVOL_ERROR_TARGET,
            "an L2 error of %g is less than single precision can hold of these samples", allowed);
    out->least = edge(b);
    out->critical = b == CVOL_BINS ? edge(b) : edge(b + 1);
    if (b < CVOL_BINS) {
        kept -= (double)bins->bins[b].count;
        out->budget = fmax(0, budget - lost - kept * out->rounded);
    }
    return CVOL_OK;
}

int cvol_select(cvol_context *context, cvol_selection *out, const cvol_array *array,
                const cvol_keep *keep, const cvol_bins *bins, uint64_t base_bytes)
{
    /* Smaller ones would be rounded to 0. The step is a power of two, so this is the edge of a
     * bin. */
    const uint32_t floor_bin = bin_of((float)(array->step / 2));
    memset(out, 0, sizeof *out);
    out->budget = -1;
    out->rounded = array->step * array->step / 4;
    if (keep->rule == CVOL_KEEP_L2 || keep->rule == CVOL_KEEP_PSNR)
        return select_energy(context, out, array, keep, bins, floor_bin);
    return select_count(context, out, array, keep, bins, base_bytes, floor_bin);
}

/* ---- the step within a loss ------------------------------------------------------------------ */

/* The loss of keys that are rounded to a step: of those below 1.5 steps, which become 1, bin by
 * bin; the others are spread evenly. `above`: how many keys lie in the bins from `first` on. */
static double rounding_loss(const cvol_bins *bins, uint32_t first, double above, double step)
{
    const uint32_t end = bin_of((float)(1.5 * step));
    double loss = 0;
    for (uint32_t b = first; b < end && b < CVOL_BINS; b++) {
        const double count = (double)bins->bins[b].count;
        const double off = ((double)edge(b) + (double)edge(b + 1)) / 2 - step;
        loss += count * off * off;
        above -= count;
    }
    return loss + above * step * step / 12;
}

double cvol_select_step(const cvol_bins *bins, double allowed, double dead_zone)
{
    const double budget = allowed * allowed;
    double zeroed = 0, kept = 0, best = 0;
    for (uint32_t b = 0; b < CVOL_BINS; b++)
        kept += (double)bins->bins[b].count;
    uint32_t next = 0; /* the first bin from b on that has keys */
    for (uint32_t b = 0; b < CVOL_BINS && kept > 0 && zeroed <= budget; b++) {
        const double step = (double)edge(b) / dead_zone;
        next = next < b ? b : next;
        while (next < CVOL_BINS && !bins->bins[next].count)
            next++;
        if (isfinite(step) && zeroed + rounding_loss(bins, next, kept, step) <= budget)
            best = step;
        zeroed += bin_energy(bins, b);
        kept -= (double)bins->bins[b].count;
    }
    return best;
}

/* ---- among the candidates -------------------------------------------------------------------- */

int cvol_candidate_order(const cvol_candidate *a, const cvol_candidate *b)
{
    if (a->key != b->key)
        return a->key > b->key ? -1 : 1;
    if (a->block != b->block)
        return a->block < b->block ? -1 : 1;
    return a->group < b->group ? -1 : a->group > b->group;
}

static int compare(const void *a, const void *b)
{
    return cvol_candidate_order(a, b);
}

size_t cvol_select_candidates(cvol_candidate *candidates, size_t count,
                              const cvol_selection *selection)
{
    qsort(candidates, count, sizeof *candidates, compare);
    if (selection->budget < 0) {
        size_t kept = selection->most < count ? (size_t)selection->most : count;
        while (kept > 0 && kept < count &&
               !cvol_candidate_order(&candidates[kept - 1], &candidates[kept]))
            kept--;
        return kept;
    }
    size_t kept = count;
    double lost = 0;
    while (kept > 0) {
        size_t before = kept - 1;
        while (before > 0 && !cvol_candidate_order(&candidates[before - 1], &candidates[before]))
            before--;
        const double key = (double)candidates[before].key;
        lost += (double)(kept - before) * key * key;
        if (lost + (double)before * selection->rounded > selection->budget)
            break;
        kept = before;
    }
    return kept;
}
