/* Counts samples.
 *
 * Samples of 8 and 16 bits are counted value by value, in one pass. Others need two: the first
 * finds the two smallest and the two largest values, the second counts within the range.
 *
 * A mark is a value for "no value": its distance from all others is at least CVOL_MARK_FAR times
 * their range, such as 1e35 where others are between -1 and 1. It is the smallest or the largest
 * value, so the two smallest and the two largest values reveal it. The range is that of the
 * others. */
#include "array/core/summary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

#define MARK_FAR 1000

enum {
    TABLE = 1 << 16,                /* values of 16 bits */
    CHUNK = 1 << 16,                /* samples that a thread takes at a time */
    SET_SLOTS = 1 << 10,            /* slots of the set of distinct values; a power of two */
    FEW = CVOL_SUMMARY_DISTINCT + 1 /* most values in the set: the last one may be the mark */
};

/* A set of at most FEW distinct values; open addressing. */
typedef struct value_set {
    uint32_t count; /* FEW + 1: there were more */
    uint8_t used[SET_SLOTS];
    double values[SET_SLOTS];
} value_set;

/* The two smallest, or two largest, distinct values. */
typedef struct ends {
    double first, second; /* infinite: none yet */
    uint64_t count;       /* samples with the first value */
} ends;

/* Results of one thread, or of all. */
typedef struct found {
    ends low, high;
    int fractions; /* some sample is not an integer */
    uint64_t bins[CVOL_SUMMARY_BINS];
    value_set set;
    uint64_t *table; /* TABLE counts; of samples of 8 and 16 bits */
} found;

struct cvol_tally {
    cvol_type type;
    int bins_log2, pass; /* the next or current pass */
    double fills[CVOL_FILLS_MAX];
    int fill_count;
    double min, max; /* range that is counted */
    double mark;
    uint64_t mark_count;
    found sum;
};

/* ---- levels ----------------------------------------------------------------------------- */

int cvol_summary_bins_log2(size_t samples)
{
    return samples >= (size_t)1 << 20   ? 8
           : samples >= (size_t)1 << 17 ? 7
           : samples >= (size_t)1 << 14 ? 6
           : samples >= (size_t)1 << 11 ? 5
                                        : 4;
}

uint8_t cvol_summary_level(uint64_t count)
{
    int octave = 0;
    if (!count)
        return 0;
    while (count >> octave > 1)
        octave++;
    const uint64_t quarter = (octave >= 2 ? count >> (octave - 2) : count << (2 - octave)) - 4;
    return (uint8_t)(1 + 4 * octave + (int)quarter);
}

uint64_t cvol_summary_count(uint8_t level)
{
    if (!level)
        return 0;
    const int octave = (level - 1) / 4, quarter = (level - 1) % 4;
    /* (4 + quarter + 1/2) 2^octave / 4 */
    const uint64_t eighths = 2 * (4 + (uint64_t)quarter) + 1;
    return octave >= 3 ? eighths << (octave - 3) : (4 + (uint64_t)quarter) << octave >> 2;
}

/* ---- results of the first pass ------------------------------------------------------------- */

static void set_add(value_set *set, double value)
{
    uint64_t bits;
    if (set->count > FEW)
        return;
    value += 0.0; /* -0 is 0 */
    memcpy(&bits, &value, sizeof bits);
    size_t slot = (size_t)(bits * UINT64_C(0x9E3779B97F4A7C15) >> 54) & (SET_SLOTS - 1);
    while (set->used[slot]) {
        if (set->values[slot] == value)
            return;
        slot = (slot + 1) & (SET_SLOTS - 1);
    }
    if (set->count++ == FEW)
        return;
    set->used[slot] = 1;
    set->values[slot] = value;
}

static void set_join(value_set *to, const value_set *from)
{
    if (from->count > FEW)
        to->count = FEW + 1;
    for (size_t i = 0; i < SET_SLOTS; i++)
        if (from->used[i])
            set_add(to, from->values[i]);
}

/* direction 1: the largest values, -1: the smallest. */
static inline void ends_add(ends *e, double value, uint64_t count, int direction)
{
    if (value == e->first) {
        e->count += count;
    } else if (direction > 0 ? value > e->first : value < e->first) {
        e->second = e->first;
        e->first = value;
        e->count = count;
    } else if (direction > 0 ? value > e->second : value < e->second) {
        e->second = value;
    }
}

static void extremes_join(ends *to, const ends *from, int direction)
{
    if (from->count)
        ends_add(to, from->first, from->count, direction);
    if (isfinite(from->second))
        ends_add(to, from->second, 0, direction);
}

static void found_start(found *f)
{
    f->low = (ends){INFINITY, INFINITY, 0};
    f->high = (ends){-INFINITY, -INFINITY, 0};
}

static size_t bin_of(const cvol_tally *tally, double value)
{
    const int bins = 1 << tally->bins_log2;
    /* Halves, since max - min may overflow. */
    const double span = tally->max / 2 - tally->min / 2;
    const double place = span > 0 ? (value / 2 - tally->min / 2) / span * bins : 0;
    return !(place > 0) ? 0 : place < bins ? (size_t)place : (size_t)bins - 1;
}

static int is_fill(const cvol_tally *tally, double value)
{
    for (int i = 0; i < tally->fill_count; i++)
        if (value == tally->fills[i] && !signbit(value) == !signbit(tally->fills[i]))
            return 1;
    return 0;
}

static inline void take_ends(const cvol_tally *tally, found *f, double value)
{
    if (!isfinite(value) || is_fill(tally, value))
        return;
    ends_add(&f->low, value, 1, -1);
    ends_add(&f->high, value, 1, 1);
}

static inline void take_count(const cvol_tally *tally, found *f, double value)
{
    if (!isfinite(value) || is_fill(tally, value) || (tally->mark_count && value == tally->mark))
        return;
    f->bins[bin_of(tally, value)]++;
    f->fractions |= floor(value) < value;
    if (f->set.count <= FEW)
        set_add(&f->set, value);
}

/* ---- passes ----------------------------------------------------------------------------- */

#define FILL_TABLE(type)                                   \
    do {                                                   \
        const type *s = (const type *)samples + first;     \
        for (size_t i = 0; i < count; i++)                 \
            f->table[(uint16_t)(uint64_t)(int64_t)s[i]]++; \
    } while (0)

#define TAKE_EXTREMES(type)                            \
    do {                                               \
        const type *s = (const type *)samples + first; \
        for (size_t i = 0; i < count; i++)             \
            take_ends(tally, f, (double)s[i]);         \
    } while (0)

#define TAKE_COUNT(type)                               \
    do {                                               \
        const type *s = (const type *)samples + first; \
        for (size_t i = 0; i < count; i++)             \
            take_count(tally, f, (double)s[i]);        \
    } while (0)

static void take(const cvol_tally *tally, found *f, const void *samples, size_t first, size_t count)
{
    if (f->table)
        CVOL_FOR_TYPE(tally->type, FILL_TABLE)
    else if (tally->pass == 0)
        CVOL_FOR_TYPE(tally->type, TAKE_EXTREMES)
    else
        CVOL_FOR_TYPE(tally->type, TAKE_COUNT)
}

static void found_join(found *to, const found *from)
{
    extremes_join(&to->low, &from->low, -1);
    extremes_join(&to->high, &from->high, 1);
    to->fractions |= from->fractions;
    for (int i = 0; i < CVOL_SUMMARY_BINS; i++)
        to->bins[i] += from->bins[i];
    set_join(&to->set, &from->set);
    for (size_t i = 0; to->table && i < TABLE; i++)
        to->table[i] += from->table[i];
}

static found *found_create(int has_table)
{
    found *f = cvol_allocate_zero(1, sizeof *f);
    if (f && has_table && !(f->table = cvol_allocate_zero(TABLE, sizeof *f->table))) {
        free(f);
        return NULL;
    }
    if (f)
        found_start(f);
    return f;
}

static void found_free(found *f)
{
    if (f)
        free(f->table);
    free(f);
}

int cvol_tally_add(cvol_context *context, cvol_tally *tally, const void *samples, size_t count)
{
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context)) if (count > CHUNK)
    {
        found *own = found_create(tally->sum.table != NULL);
#pragma omp for schedule(dynamic)
        for (size_t first = 0; first < count; first += CHUNK)
            if (own)
                take(tally, own, samples, first, count - first < CHUNK ? count - first : CHUNK);
#pragma omp critical(cvol_tally_join)
        {
            if (own)
                found_join(&tally->sum, own);
            else
                failed = 1;
        }
        found_free(own);
    }
    return failed ? cvol_fail_memory(context, sizeof(found), "a histogram") : CVOL_OK;
}

int cvol_tally_share(cvol_context *context, cvol_tally *tally, cvol_team *team)
{
    const size_t table = tally->sum.table ? TABLE * sizeof *tally->sum.table : 0,
                 bytes = sizeof(found) + table;
    cvol_gathered all;
    if (!team)
        return CVOL_OK;
    uint8_t *own = cvol_allocate(bytes, 1);
    int code = own ? CVOL_OK : cvol_fail_memory(context, bytes, "a histogram");
    if (!code)
        memcpy(own, &tally->sum, sizeof(found));
    if (!code && table)
        memcpy(own + sizeof(found), tally->sum.table, table);
    code = cvol_team_gather(context, &all, team, code, own, bytes);
    free(own);
    found *sum = code ? NULL : found_create(table != 0);
    for (int rank = 0; rank < team->size && sum; rank++) {
        found one;
        memcpy(&one, all.all + all.offsets[rank], sizeof one);
        one.table = table ? (uint64_t *)(void *)(all.all + all.offsets[rank] + sizeof one) : NULL;
        found_join(sum, &one);
    }
    if (sum) {
        free(tally->sum.table);
        tally->sum = *sum;
        free(sum);
    } else if (!code) {
        code = cvol_fail_memory(context, bytes, "a histogram");
    }
    cvol_gathered_free(&all);
    return cvol_team_agree(context, team, code);
}

/* ---- after the first pass --------------------------------------------------------------- */

static double table_value(const cvol_tally *tally, size_t i)
{
    return tally->type == CVOL_INT8 || tally->type == CVOL_INT16 ? (double)(int16_t)(uint16_t)i
                                                                 : (double)i;
}

/* Finds a mark, a value far from all others, and sets the range of the others. */
static void find_mark(cvol_tally *tally)
{
    const ends low = tally->sum.low, high = tally->sum.high;
    if (!(high.first > low.first))
        return;
    const double gap_above = high.first / 2 - high.second / 2;
    const double gap_below = low.second / 2 - low.first / 2;
    if (high.second > low.first && gap_above > MARK_FAR * (high.second / 2 - low.first / 2)) {
        tally->mark = high.first;
        tally->mark_count = high.count;
        tally->max = high.second;
    } else if (low.second < high.first &&
               gap_below > MARK_FAR * (high.first / 2 - low.second / 2)) {
        tally->mark = low.first;
        tally->mark_count = low.count;
        tally->min = low.second;
    }
}

static void read_table(cvol_tally *tally)
{
    found *f = &tally->sum;
    for (size_t i = 0; i < TABLE; i++) {
        const double value = table_value(tally, i);
        if (is_fill(tally, value))
            f->table[i] = 0;
        if (!f->table[i])
            continue;
        ends_add(&f->low, value, f->table[i], -1);
        ends_add(&f->high, value, f->table[i], 1);
    }
}

static void count_table(cvol_tally *tally)
{
    found *f = &tally->sum;
    for (size_t i = 0; i < TABLE; i++) {
        const double value = table_value(tally, i);
        if (!f->table[i] || (tally->mark_count && value == tally->mark))
            continue;
        f->bins[bin_of(tally, value)] += f->table[i];
        set_add(&f->set, value);
    }
}

int cvol_tally_needs_another_pass(cvol_tally *tally)
{
    if (tally->pass++)
        return 0;
    if (tally->sum.table)
        read_table(tally);
    const found *f = &tally->sum;
    tally->min = f->low.count ? f->low.first : 0;
    tally->max = f->low.count ? f->high.first : 0;
    find_mark(tally);
    if (tally->sum.table)
        count_table(tally);
    return !tally->sum.table;
}

int cvol_tally_has_mark(const cvol_tally *tally)
{
    return tally->mark_count > 0;
}

void cvol_tally_set_range(cvol_tally *tally, double min, double max)
{
    tally->min = min;
    tally->max = max;
}

void cvol_tally_finish(const cvol_tally *tally, cvol_summary *out)
{
    const found *f = &tally->sum;
    *out = (cvol_summary){.state = CVOL_SUMMARY_KNOWN,
                          .integers = !f->fractions,
                          .distinct = f->set.count <= CVOL_SUMMARY_DISTINCT ? f->set.count : 0,
                          .min = tally->min,
                          .max = tally->max,
                          .mark = tally->mark_count ? tally->mark : 0,
                          .mark_count = tally->mark_count,
                          .bins_log2 = tally->bins_log2};
    for (int i = 0; i < 1 << tally->bins_log2; i++)
        out->levels[i] = cvol_summary_level(f->bins[i]);
}

int cvol_tally_create(cvol_context *context, cvol_tally **out, const cvol_grid *grid,
                      const cvol_fills *fills)
{
    cvol_tally *tally = *out = cvol_allocate_zero(1, sizeof *tally);
    if (!tally)
        return cvol_fail_memory(context, sizeof *tally, "a histogram");
    tally->type = grid->type;
    tally->bins_log2 = cvol_summary_bins_log2(cvol_grid_samples(grid));
    found_start(&tally->sum);
    for (int i = 0; fills && i < fills->count; i++)
        tally->fills[tally->fill_count++] = cvol_fills_value(fills, i, grid->type);
    if (cvol_type_is_integer(grid->type) && cvol_type_size(grid->type) <= 2 &&
        !(tally->sum.table = cvol_allocate_zero(TABLE, sizeof *tally->sum.table))) {
        cvol_tally_free(tally);
        *out = NULL;
        return cvol_fail_memory(context, TABLE * sizeof(uint64_t), "a histogram");
    }
    return CVOL_OK;
}

void cvol_tally_free(cvol_tally *tally)
{
    if (tally)
        free(tally->sum.table);
    free(tally);
}

int cvol_summarise_samples(cvol_context *context, cvol_summary *out, const void *samples,
                           const cvol_grid *grid, const cvol_fills *fills)
{
    const size_t count = cvol_grid_samples(grid);
    cvol_tally *tally;
    *out = (cvol_summary){0};
    int code = cvol_tally_create(context, &tally, grid, fills);
    if (!code)
        code = cvol_tally_add(context, tally, samples, count);
    if (!code && cvol_tally_needs_another_pass(tally))
        code = cvol_tally_add(context, tally, samples, count);
    if (!code)
        cvol_tally_finish(tally, out);
    cvol_tally_free(tally);
    return code;
}

/* ---- scaling ---------------------------------------------------------------------------- */

cvol_summary cvol_summary_scale(const cvol_summary *of, double alpha, double beta)
{
    cvol_summary out = *of;
    const double a = alpha * of->min + beta, b = alpha * of->max + beta;
    const int bins = 1 << of->bins_log2;
    if (of->state != CVOL_SUMMARY_KNOWN || !(fabs(alpha) > 0) || !isfinite(a) || !isfinite(b) ||
        !(a < b || b < a || !(of->max > of->min)))
        return (cvol_summary){.state = of->state == CVOL_SUMMARY_LEFT_OUT ? of->state
                                                                          : CVOL_SUMMARY_NONE};
    out.integers = of->integers && floor(alpha) == alpha && floor(beta) == beta;
    out.min = fmin(a, b);
    out.max = fmax(a, b);
    out.mark = 0; /* now a value like all others */
    out.mark_count = 0;
    for (int i = 0; i < bins && alpha < 0; i++)
        out.levels[i] = of->levels[bins - 1 - i];
    return out;
}
