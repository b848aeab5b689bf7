/* The builder: dense blocks from a producer, scanned, quantised and packed, in runs of blocks. Each
 * run is made by one thread into memory of its own, and runs are put together in order. */
#include "array/build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block_transform.h"
#include "array/build_pack.h"
#include "array/build_select.h"
#include "base/context.h"
#include "base/cpu.h"
#include "base/memory.h"

enum { RUN_TERMS = 1 << 17, RUNS_AT_ONCE = 64, FINE_BITS = 22, ALL_BITS = 29 };

/* A coefficient whose key lies in the critical bin: packed, and perhaps taken out again. */
typedef struct uncertain {
    uint32_t block, place; /* block: within the run */
    float key, value;
} uncertain;

typedef struct run {
    uint32_t *terms;
    size_t words;
    uint64_t coefficients;
    double lost, norm; /* sums of squares */
    double block_lost; /* at most, of the last block */
    double worst_lost; /* the largest of those */
    float max_abs;
    int code;
    uncertain *candidates;
    size_t candidate_count, candidate_capacity;
} run;

typedef struct builder {
    cvol_array *array;
    const cvol_producer *producer;
    size_t per_block, run_blocks, run_count;
    run *runs;
    uint8_t *forced;       /* of each place, whether it lies in the low box; NULL: none does */
    float least, critical; /* see cvol_selection */
    cvol_bins *counting;   /* the first pass of two; NULL: packing */
    double step;
} builder;

/* What one thread works with. */
typedef struct workplace {
    float *coefficients, *keys, *values;
    uint32_t *places, *words;
    int32_t *integers;
    size_t words_capacity;
    void *scratch;
    cvol_bins bins;
} workplace;

CVOL_SIMD_DECLARE(void, cvol_block_scan, (cvol_scan_task * task));

void cvol_block_scan(cvol_scan_task *task)
{
    CVOL_SIMD_CHOOSE(cvol_block_scan)(task);
}

CVOL_SIMD_DECLARE(void, cvol_block_quantise, (cvol_quantise_task * task));

void cvol_block_quantise(cvol_quantise_task *task)
{
    CVOL_SIMD_CHOOSE(cvol_block_quantise)(task);
}

/* ---- keys ---------------------------------------------------------------------------------------
 */

static int needs_keys(const builder *b)
{
    return b->forced || b->array->transform == CVOL_DFT;
}

/* Writes zeros beyond the box. */
static void complete(cvol_dense_block *block, const cvol_array *array)
{
    const int B = array->block, rows = array->rank > 1 ? B : 1, sheets = array->rank > 2 ? B : 1;
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < rows; y++) {
            const int known = z < block->box[2] && y < block->box[1] ? block->box[0] : 0;
            memset(block->coefficients + (z * B + y) * B + known, 0,
                   sizeof(float) * (size_t)(B - known));
        }
    for (int a = 0; a < 3; a++)
        block->box[a] = a < array->rank ? B : 1;
}

/* The other slot of a pair; the place itself if it is its own mirror. */
static uint32_t partner(const cvol_array *array, uint32_t place)
{
    uint32_t field = (UINT32_C(1) << array->block_log2) - 1, other = 0;
    for (int a = 0; a < array->rank; a++, field <<= array->block_log2)
        other |= cvol_block_mirror(place, field);
    return other;
}

/* A listed block as a dense one. */
static void spread(cvol_dense_block *block, const cvol_array *array)
{
    for (int a = 0; a < 3; a++)
        block->box[a] = 0;
    complete(block, array);
    for (int i = 0; i < block->count; i++)
        block->coefficients[block->places[i]] = block->values[i];
    block->count = -1;
}

static void make_keys(float *keys, const float *c, const builder *b)
{
    for (uint32_t p = 0; p < b->per_block; p++) {
        keys[p] = fabsf(c[p]);
        if (b->array->transform == CVOL_DFT) {
            const double first = (double)c[p], second = (double)c[partner(b->array, p)];
            keys[p] = (float)sqrt((first * first + second * second) / 2);
        }
        if (b->forced && b->forced[p])
            keys[p] = INFINITY;
    }
}

/* ---- counting -----------------------------------------------------------------------------------
 */

static void count_block(workplace *w, const cvol_dense_block *block, const builder *b)
{
    const float escape = (float)((double)-cvol_term_escape(cvol_place_bits(b->array->block_log2)) *
                                 b->step * 0.999);
    const float *c = block->coefficients, *keys = needs_keys(b) ? w->keys : NULL;
    for (int z = 0; z < block->box[2]; z++)
        for (int y = 0; y < block->box[1]; y++)
            for (int x = 0; x < block->box[0]; x++) {
                const size_t p = (size_t)((z << b->array->block_log2 | y) << b->array->block_log2 |
                                          x);
                const float magnitude = fabsf(c[p]), key = keys ? keys[p] : magnitude;
                w->bins.escapes += magnitude >= escape;
                if (isinf(key) && !isinf(magnitude))
                    w->bins.forced += (double)magnitude >= b->step / 2;
                else if (key > 0) {
                    uint32_t bits;
                    memcpy(&bits, &key, sizeof bits);
                    cvol_bins_add(w->bins.bins, bits);
                }
            }
}

/* ---- packing ------------------------------------------------------------------------------------
 */

static int note_candidate(run *r, size_t block, uint32_t place, float key, float value)
{
    if (r->candidate_count == r->candidate_capacity) {
        const size_t capacity = 2 * r->candidate_capacity + 64;
        uncertain *more = realloc(r->candidates, capacity * sizeof *more);
        if (!more)
            return 0;
        r->candidates = more;
        r->candidate_capacity = capacity;
    }
    r->candidates[r->candidate_count++] = (uncertain){(uint32_t)block, place, key, value};
    return 1;
}

/* Packs the coefficients that the scan found, or that were listed, at w->words + r->words. */
static int pack_terms(run *r, cvol_block *out, const workplace *w, const cvol_scan_task *task,
                      size_t in_run, const builder *b)
{
    const int bits = cvol_place_bits(b->array->block_log2), log2 = b->array->block_log2;
    const uint32_t mask = (1u << log2) - 1;
    const int careful = b->critical > b->least;
    uint32_t *words = w->words + r->words, *begin = words, last_u = 0, last_v = 0, last = 0;
    uint32_t kept = 0;
    double doubtful = 0;
    cvol_quantise_task whole = {.values = task->values,
                                .count = task->count,
                                .step = b->step,
                                .least = task->keys ? 0 : b->least,
                                .integers = w->integers};
    cvol_block_quantise(&whole);
    for (uint32_t i = 0; i < task->count; i++) {
        const int32_t value = w->integers[i];
        if (value == 0)
            continue;
        const uint32_t place = task->places[i];
        if (careful) {
            const float key = task->keys ? task->keys[place] : fabsf(task->values[i]);
            if (key < b->critical) {
                if (!note_candidate(r, in_run, place, key, task->values[i]))
                    return CVOL_ERROR_MEMORY;
                doubtful += (double)task->values[i] * (double)task->values[i];
            }
        }
        const uint32_t u = place & mask, v = place >> log2 & mask;
        last_u = u > last_u ? u : last_u;
        last_v = v > last_v ? v : last_v;
        last = place;
        words += cvol_term_pack(words, place, value, bits);
        kept++;
    }
    r->coefficients += kept;
    out->words = (uint32_t)(words - begin);
    const int any = words > begin;
    out->low[0] = (uint8_t)(any ? last_u + 1 : 0);
    out->low[1] = (uint8_t)(any ? last_v + 1 : 0);
    out->low[2] = (uint8_t)(any ? (last >> 2 * log2) + 1 : 0);
    r->words += out->words;
    const double lost = whole.lost + task->lost;
    r->block_lost = lost + doubtful;
    r->lost += lost;
    r->norm += whole.norm + task->lost;
    const double most = (double)(1 << CVOL_MOST_BITS) - 1;
    return whole.largest < most * b->step && isfinite(lost) ? CVOL_OK : CVOL_ERROR_DATA;
}

/* What the producer itself left out. */
static void count_left_out(run *r, double before, double energy)
{
    const double left = energy - (r->norm - before);
    if (energy >= 0 && left > 0) {
        r->lost += left;
        r->block_lost += left;
        r->norm += left;
    }
}

static int reserve_words(workplace *w, size_t words)
{
    if (words <= w->words_capacity)
        return 1;
    const size_t capacity = words + words / 2;
    uint32_t *more = realloc(w->words, capacity * sizeof *more);
    if (!more)
        return 0;
    w->words = more;
    w->words_capacity = capacity;
    return 1;
}

static int do_block(run *r, workplace *w, size_t index, size_t in_run, const builder *b)
{
    const cvol_array *array = b->array;
    cvol_dense_block block = {.coefficients = w->coefficients,
                              .box = {array->block, array->rank > 1 ? array->block : 1,
                                      array->rank > 2 ? array->block : 1},
                              .energy = -1,
                              .max_abs = -1,
                              .places = w->places,
                              .values = w->values,
                              .count = -1};
    int code = b->producer->produce(b->producer->user, &block, index, w->scratch);
    if (code)
        return code;
    for (int a = array->rank; a < 3; a++)
        block.box[a] = 1;
    if (block.count >= 0 && (needs_keys(b) || b->counting))
        spread(&block, array);
    if (needs_keys(b)) {
        complete(&block, array);
        make_keys(w->keys, block.coefficients, b);
    }
    if (b->counting) {
        count_block(w, &block, b);
        return CVOL_OK;
    }
    cvol_scan_task task = {.coefficients = block.coefficients,
                           .keys = needs_keys(b) ? w->keys : NULL,
                           .box = {block.box[0], block.box[1], block.box[2]},
                           .rank = array->rank,
                           .block_log2 = array->block_log2,
                           .least = b->least,
                           .places = w->places,
                           .values = w->values,
                           .count = (uint32_t)block.count};
    if (block.count < 0)
        cvol_block_scan(&task);
    if (!reserve_words(w, r->words + 2 * (size_t)task.count))
        return CVOL_ERROR_MEMORY;
    if (block.max_abs < 0 || r->max_abs < 0)
        r->max_abs = -1;
    else
        r->max_abs = block.max_abs > r->max_abs ? block.max_abs : r->max_abs;
    const double before = r->norm;
    code = pack_terms(r, &array->block_table[index], w, &task, in_run, b);
    count_left_out(r, before, block.energy);
    r->worst_lost = fmax(r->worst_lost, r->block_lost);
    return code;
}

/* ---- runs ---------------------------------------------------------------------------------------
 */

static size_t run_begin(const builder *b, size_t run_index)
{
    const size_t begin = run_index * b->run_blocks;
    return begin < b->array->block_count ? begin : b->array->block_count;
}

/* Points the run's blocks to their terms, which lie one after the other. */
static void place_terms(const builder *b, size_t run_index)
{
    const uint32_t *at = b->runs[run_index].terms;
    for (size_t i = run_begin(b, run_index); i < run_begin(b, run_index + 1); i++) {
        cvol_block *block = &b->array->block_table[i];
        block->terms = block->words ? at : NULL;
        at += block->words;
    }
}

static void do_run(size_t run_index, workplace *w, const builder *b)
{
    run *r = &b->runs[run_index];
    const size_t begin = run_begin(b, run_index), end = run_begin(b, run_index + 1);
    for (size_t i = begin; i < end && !r->code; i++)
        r->code = do_block(r, w, i, i - begin, b);
    if (r->code || !r->words)
        return;
    r->terms = malloc(r->words * sizeof *r->terms);
    if (!r->terms) {
        r->code = CVOL_ERROR_MEMORY;
        return;
    }
    memcpy(r->terms, w->words, r->words * sizeof *r->terms);
    place_terms(b, run_index);
}

static int make_workplace(workplace *w, const builder *b)
{
    const size_t count = b->per_block + CVOL_SCAN_MARGIN;
    memset(w, 0, sizeof *w);
    w->coefficients = cvol_allocate_zero(count, sizeof(float));
    w->keys = cvol_allocate_zero(count, sizeof(float));
    w->values = cvol_allocate(count, sizeof(float));
    w->places = cvol_allocate(count, sizeof(uint32_t));
    w->integers = cvol_allocate(count, sizeof(int32_t));
    w->scratch = cvol_allocate_zero(b->producer->scratch_bytes, 1);
    return w->coefficients && w->keys && w->values && w->places && w->integers && w->scratch &&
           reserve_words(w, 2 * count) && (!b->counting || cvol_bins_make(&w->bins));
}

static void free_workplace(workplace *w)
{
    free(w->coefficients);
    free(w->keys);
    free(w->values);
    free(w->places);
    free(w->integers);
    free(w->words);
    free(w->scratch);
    cvol_bins_free(&w->bins);
}

static int fail(cvol_context *context, const builder *b, int code)
{
    const char *what = b->producer->what;
    if (code == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, b->producer->scratch_bytes + 32 * b->per_block, what);
    if (code == CVOL_ERROR_DATA)
        return cvol_fail(context, code,
                         "%s: a coefficient is not finite, or larger than 2^%d steps of %g", what,
                         CVOL_MOST_BITS, b->step);
    return cvol_fail(context, code, "%s: a block could not be computed", what);
}

/* All blocks once. */
static int pass(cvol_context *context, builder *b, double from, double to)
{
    int failed = CVOL_OK;
    for (size_t first = 0; first < b->run_count && !failed; first += RUNS_AT_ONCE) {
        const size_t last = first + RUNS_AT_ONCE < b->run_count ? first + RUNS_AT_ONCE
                                                                : b->run_count;
        const double done = (double)first / (double)b->run_count;
        int code = cvol_report_progress(context, b->producer->what, from + (to - from) * done);
        if (code)
            return code;
#pragma omp parallel num_threads(cvol_context_threads(context))
        {
            workplace w;
            const int ready = make_workplace(&w, b);
#pragma omp for schedule(dynamic)
            for (size_t r = first; r < last; r++)
                if (ready)
                    do_run(r, &w, b);
                else
                    b->runs[r].code = CVOL_ERROR_MEMORY;
            if (ready && b->counting) {
#pragma omp critical(cvol_build_bins)
                cvol_bins_merge(b->counting, &w.bins);
            }
            free_workplace(&w);
        }
        for (size_t r = first; r < last && !failed; r++)
            failed = b->runs[r].code;
    }
    return failed ? fail(context, b, failed) : CVOL_OK;
}

/* ---- the critical bin
 * ---------------------------------------------------------------------------- */

static cvol_candidate candidate_of(const builder *b, size_t run_index, const uncertain *u)
{
    uint32_t group = u->place;
    if (b->array->transform == CVOL_DFT) {
        const uint32_t other = partner(b->array, u->place);
        group = other < group ? other : group;
    }
    return (cvol_candidate){run_begin(b, run_index) + u->block, group, u->key};
}

/* Takes a run's candidates behind the last that is kept (NULL: all) out of its blocks. */
static void settle_run(const builder *b, size_t run_index, const cvol_candidate *last)
{
    run *r = &b->runs[run_index];
    const int bits = cvol_place_bits(b->array->block_log2);
    const size_t begin = run_begin(b, run_index);
    uint32_t *to = r->terms;
    const uint32_t *from = r->terms;
    size_t next = 0;
    for (size_t i = begin; i < run_begin(b, run_index + 1); i++) {
        cvol_block *block = &b->array->block_table[i];
        const uint32_t *end = from + block->words, *first = to;
        while (from < end) {
            uint32_t place;
            const uint32_t *at = from;
            const int32_t value = cvol_term_unpack(&from, &place, bits);
            const uncertain *u = &r->candidates[next];
            int keep = 1;
            if (next < r->candidate_count && u->block == i - begin && u->place == place) {
                const cvol_candidate c = candidate_of(b, run_index, u);
                const double whole = (double)u->value, rest = whole - b->step * (double)value;
                keep = last && cvol_candidate_order(&c, last) <= 0;
                r->lost += keep ? 0 : whole * whole - rest * rest;
                r->coefficients -= !keep;
                next++;
            }
            for (; keep && at < from; at++)
                *to++ = *at;
        }
        block->words = (uint32_t)(to - first);
        block->terms = first;
        cvol_block_find_low(block, b->array->block_log2);
    }
    r->words = (size_t)(to - r->terms);
    uint32_t *shorter = r->words ? realloc(r->terms, r->words * sizeof *shorter) : NULL;
    if (r->words == 0) {
        free(r->terms);
        r->terms = NULL;
    } else if (shorter) {
        r->terms = shorter;
    }
    place_terms(b, run_index);
}

static int settle(cvol_context *context, builder *b, const cvol_selection *selection)
{
    size_t count = 0;
    for (size_t r = 0; r < b->run_count; r++)
        count += b->runs[r].candidate_count;
    if (!count)
        return CVOL_OK;
    cvol_candidate *all = cvol_allocate(count, sizeof *all);
    if (!all)
        return cvol_fail_memory(context, count * sizeof *all, b->producer->what);
    size_t n = 0;
    for (size_t r = 0; r < b->run_count; r++)
        for (size_t i = 0; i < b->runs[r].candidate_count; i++)
            all[n++] = candidate_of(b, r, &b->runs[r].candidates[i]);
    const size_t kept = cvol_select_candidates(all, count, selection);
    if (kept)
        b->array->threshold = (double)all[kept - 1].key;
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
    for (size_t r = 0; r < b->run_count; r++)
        if (b->runs[r].candidate_count)
            settle_run(b, r, kept ? &all[kept - 1] : NULL);
    free(all);
    return CVOL_OK;
}

/* ---- what a keep asks for
 * ------------------------------------------------------------------------ */

/* A power of two: see build.h. */
static double fine_step(const cvol_array *array, const cvol_keep *keep)
{
    const double terms = (double)cvol_array_block_terms(array);
    const double bound = (array->ledger.max_abs + fabs(array->offset)) * sqrt(terms);
    if (!(bound > 0) || !isfinite(bound))
        return 1;
    int exponent;
    (void)frexp(bound, &exponent);
    double step = ldexp(1, exponent - FINE_BITS);
    if (keep->rule == CVOL_KEEP_L2 || keep->rule == CVOL_KEEP_PSNR) {
        const double all = sqrt(terms * (double)array->block_count);
        const double finest = ldexp(1, exponent - CVOL_MOST_BITS + 1);
        while (step > finest && step * all > cvol_select_allowed(array, keep))
            step /= 2;
    }
    return step;
}

/* The step for all that there is: by the largest coefficient itself, which may be far below any
 * bound. */
static double step_for_all(const cvol_bins *bins, double otherwise)
{
    size_t top = CVOL_BINS;
    while (top && !bins->bins[top - 1].count)
        top--;
    const uint32_t bits = (uint32_t)(top << CVOL_BIN_SHIFT); /* above all keys */
    float largest;
    memcpy(&largest, &bits, sizeof largest);
    if (!top || !isfinite(largest))
        return otherwise;
    int exponent;
    (void)frexp(1.5 * (double)largest, &exponent); /* DFT: a slot is at most sqrt(2) keys */
    return ldexp(1, exponent - ALL_BITS);
}

/* The least float that is not below `value`, and positive. */
static float float_above(double value)
{
    float f = (float)value;
    if ((double)f < value)
        f = nextafterf(f, INFINITY);
    return f > 0 ? f : 1e-45f;
}

static int make_forced(cvol_context *context, builder *b, const cvol_keep *keep)
{
    const cvol_array *array = b->array;
    if (keep->rule == CVOL_KEEP_ALL || (!keep->low[0] && !keep->low[1] && !keep->low[2]))
        return CVOL_OK;
    b->forced = cvol_allocate_zero(b->per_block, 1);
    if (!b->forced)
        return cvol_fail_memory(context, b->per_block, "the low box");
    const size_t mask = (size_t)array->block - 1;
    for (size_t p = 0; p < b->per_block; p++) {
        b->forced[p] = 1;
        for (int a = 0; a < array->rank; a++) {
            size_t u = p >> a * array->block_log2 & mask;
            if (array->transform != CVOL_DCT && 2 * u > mask + 1)
                u = mask + 1 - u;
            b->forced[p] = b->forced[p] && u < (keep->low[a] ? keep->low[a] : 1);
        }
    }
    return CVOL_OK;
}

/* What the array takes without terms, all of its pools counted. */
static uint64_t base_bytes(const builder *b)
{
    cvol_array_info info;
    cvol_array_get_info(b->array, &info);
    size_t capacity = b->array->pool_capacity;
    while (capacity < b->run_count)
        capacity = 2 * capacity + 16;
    return info.resident_bytes + (capacity - b->array->pool_capacity) * sizeof(uint32_t *);
}

/* Runs the passes; the runs then hold the terms. */
static int run_passes(cvol_context *context, builder *b, const cvol_keep *keep)
{
    cvol_array *array = b->array;
    array->threshold = 0;
    b->step = keep->rule == CVOL_KEEP_STEP ? keep->value : fine_step(array, keep);
    array->step = b->step;
    switch (keep->rule) {
    case CVOL_KEEP_STEP:
        b->least = float_above(0.6 * b->step);
        break;
    case CVOL_KEEP_THRESHOLD:
        b->least = float_above(fmax(keep->value, b->step / 2));
        array->threshold = keep->value;
        break;
    default: {
        cvol_bins bins;
        cvol_selection selection;
        if (!cvol_bins_make(&bins))
            return cvol_fail_memory(context, CVOL_BINS * sizeof(cvol_bin), "a histogram");
        b->counting = &bins;
        int code = pass(context, b, 0, 0.4);
        b->counting = NULL;
        if (!code && keep->rule == CVOL_KEEP_ALL) {
            array->step = b->step = step_for_all(&bins, b->step);
            b->least = float_above(b->step / 2);
            cvol_bins_free(&bins);
            return pass(context, b, 0.4, 1);
        }
        if (!code)
            code = cvol_select(context, &selection, array, keep, &bins, base_bytes(b));
        cvol_bins_free(&bins);
        if (code)
            return code;
        b->least = selection.least;
        b->critical = selection.critical;
        array->threshold = isinf(selection.critical) ? 0 : (double)selection.critical;
        code = pass(context, b, 0.4, 1);
        return code ? code : settle(context, b, &selection);
    }
    }
    return pass(context, b, 0, 1);
}

/* The runs' terms and sums to the array and the result. */
static int hand_over(cvol_context *context, builder *b, cvol_build_result *result)
{
    cvol_array *array = b->array;
    double lost = 0, norm = 0, worst = 0;
    array->coefficients = 0;
    for (size_t r = 0; r < b->run_count; r++) {
        run *one = &b->runs[r];
        lost += one->lost;
        norm += one->norm;
        worst = fmax(worst, one->worst_lost);
        result->max_abs = one->max_abs < 0 || result->max_abs < 0
                              ? -1
                              : fmax(result->max_abs, (double)one->max_abs);
        array->coefficients += one->coefficients;
        if (!one->terms)
            continue;
        int code = cvol_array_adopt_pool(context, array, one->terms, one->words);
        if (code)
            return code;
        one->terms = NULL;
    }
    result->dropped = sqrt(lost);
    result->norm = sqrt(norm);
    result->sample = sqrt(worst);
    return CVOL_OK;
}

int cvol_build_blocks(cvol_context *context, cvol_array *array, cvol_build_result *result,
                      const cvol_producer *producer, const cvol_keep *keep)
{
    builder b = {.array = array, .producer = producer, .per_block = cvol_array_block_terms(array)};
    memset(result, 0, sizeof *result);
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS ||
        (keep->rule == CVOL_KEEP_STEP && !(keep->value > 0 && isfinite(keep->value))))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: rule %d of what to keep cannot be used here, or its value %g",
                         producer->what, (int)keep->rule, keep->value);
    b.run_blocks = RUN_TERMS / b.per_block ? RUN_TERMS / b.per_block : 1;
    b.run_count = (array->block_count - 1) / b.run_blocks + 1;
    b.runs = cvol_allocate_zero(b.run_count, sizeof *b.runs);
    if (!b.runs)
        return cvol_fail_memory(context, b.run_count * sizeof *b.runs, producer->what);
    int code = make_forced(context, &b, keep);
    if (!code)
        code = run_passes(context, &b, keep);
    if (!code)
        code = hand_over(context, &b, result);
    for (size_t r = 0; r < b.run_count; r++) {
        free(b.runs[r].terms);
        free(b.runs[r].candidates);
    }
    free(b.runs);
    free(b.forced);
    return code ? code : cvol_report_progress(context, producer->what, 1);
}
