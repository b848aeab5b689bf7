/* Blocks of coefficients: produced, scanned, quantized and packed, run by run. */
#include "array/truncate/build_runs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/core/share.h"
#include "array/truncate/producer.h"
#include "array/truncate/visible.h"
#include "base/context.h"
#include "base/cpu.h"
#include "base/memory.h"
#include "transform/cell.h"

enum { RUNS_AT_ONCE = 64 };

/* The working memory of one thread. */
typedef struct workplace {
    float *coefficients, *keys, *values;
    float *errors, *error_samples; /* of one block; with b->hides */
    uint8_t *visible;
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

CVOL_SIMD_DECLARE(void, cvol_block_pack, (cvol_pack_task * task));

void cvol_block_pack(cvol_pack_task *task)
{
    CVOL_SIMD_CHOOSE(cvol_block_pack)(task);
}

/* ---- keys ------------------------------------------------------------------------------------ */

static int needs_keys(const cvol_builder *b)
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

uint32_t cvol_block_partner(const cvol_array *array, uint32_t place)
{
    uint32_t field = (UINT32_C(1) << array->block_log2) - 1, other = 0;
    for (int a = 0; a < array->rank; a++, field <<= array->block_log2)
        other |= cvol_block_mirror(place, field);
    return other;
}

/* Converts a listed block to a dense one. */
static void spread(cvol_dense_block *block, const cvol_array *array)
{
    for (int a = 0; a < 3; a++)
        block->box[a] = 0;
    complete(block, array);
    for (int i = 0; i < block->count; i++)
        block->coefficients[block->places[i]] = block->values[i];
    block->count = -1;
}

static void make_keys(float *keys, const float *c, const cvol_builder *b)
{
    for (uint32_t p = 0; p < b->per_block; p++) {
        keys[p] = fabsf(c[p]);
        if (b->array->transform == CVOL_DFT) {
            const double first = (double)c[p], second = (double)c[cvol_block_partner(b->array, p)];
            keys[p] = (float)sqrt((first * first + second * second) / 2);
        }
        if (b->forced && b->forced[p])
            keys[p] = INFINITY;
    }
}

/* ---- counting -------------------------------------------------------------------------------- */

/* The magnitude from which a term takes two words. */
static float least_escape(const cvol_builder *b)
{
    return (float)((double)-cvol_term_escape(cvol_place_bits(b->array->block_log2)) * b->step *
                   0.999);
}

/* Returns 1 for a share of the calls, evenly spread. */
static int is_shared(double *carry, double share)
{
    *carry += share;
    if (*carry < 1)
        return 0;
    *carry -= 1;
    return 1;
}

/* Counts a share of listed coefficients. */
static void count_list(workplace *w, const cvol_dense_block *block, const cvol_builder *b,
                       double share)
{
    const float escape = least_escape(b);
    double carry = 0.5;
    for (int i = 0; i < block->count; i++) {
        const float key = fabsf(block->values[i]);
        uint32_t bits;
        memcpy(&bits, &key, sizeof bits);
        w->bins.escapes += key >= escape;
        if (key > 0 && is_shared(&carry, share))
            cvol_bins_add(w->bins.bins, bits);
    }
}

static void count_block(workplace *w, const cvol_dense_block *block, const cvol_builder *b,
                        double share)
{
    double carry = 0.5;
    const float escape = least_escape(b);
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
                else if (key > 0 && is_shared(&carry, share)) {
                    uint32_t bits;
                    memcpy(&bits, &key, sizeof bits);
                    cvol_bins_add(w->bins.bins, bits);
                }
            }
}

/* ---- packing --------------------------------------------------------------------------------- */

static int note_candidate(cvol_build_run *r, size_t block, uint32_t place, float key, float value)
{
    if (r->candidate_count == r->candidate_capacity) {
        const size_t capacity = 2 * r->candidate_capacity + 64;
        cvol_critical_candidate *more = realloc(r->candidates, capacity * sizeof *more);
        if (!more)
            return 0;
        r->candidates = more;
        r->candidate_capacity = capacity;
    }
    r->candidates[r->candidate_count++] = (cvol_critical_candidate){(uint32_t)block, place, key,
                                                                    value};
    return 1;
}

/* Records the terms whose keys lie in the critical bin; *doubtful is their sum of squares. */
static int note_candidates(cvol_build_run *r, const workplace *w, const cvol_scan_task *task,
                           size_t in_run, float critical, double *doubtful)
{
    for (uint32_t i = 0; i < task->count; i++) {
        const uint32_t place = task->places[i];
        const float key = task->keys ? task->keys[place] : fabsf(task->values[i]);
        if (!w->integers[i] || key >= critical)
            continue;
        if (!note_candidate(r, in_run, place, key, task->values[i]))
            return CVOL_ERROR_MEMORY;
        *doubtful += (double)task->values[i] * (double)task->values[i];
    }
    return CVOL_OK;
}

/* ---- isolated coefficients ------------------------------------------------------------------- */

/* The magnitude of the coefficient `apart` places before `place` along an axis, in steps; 1 if
 * there is none. */
static double before(const float *dense, uint32_t place, int axis, uint32_t apart, double inverse)
{
    const int log2 = 4 * axis;
    if ((place >> log2 & (CVOL_CELL - 1)) < apart)
        return 1;
    return inverse * fabs((double)dense[place - (apart << log2)]);
}

/* Drops listed coefficients that cost more bits than they save error, as the fast encoder does
 * (codec/quantize/split_kernels.h): the smaller ones of magnitude 1, if the coefficients of the
 * next lower frequencies, which are the context of their code, are small. */
static void drop_isolated(cvol_scan_task *task, const float *dense, uint16_t split,
                          const cvol_builder *b)
{
    const double inverse = 1 / b->step;
    const uint32_t apart = split == CVOL_CELL_WHOLE ? 1 : split == CVOL_CELL_FOURS ? 4 : 2;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < task->count; i++) {
        const uint32_t place = task->places[i];
        const double value = (double)task->values[i], size = inverse * fabs(value);
        if (size < CVOL_LEAST_ONE + b->isolated) {
            double near = 1;
            for (int axis = 0; axis < 3; axis++)
                near += before(dense, place, axis, apart, inverse);
            if (size < CVOL_LEAST_ONE + b->isolated / near) {
                task->lost += value * value;
                continue;
            }
        }
        task->places[kept] = place;
        task->values[kept++] = task->values[i];
    }
    task->count = kept;
}

/* The loss of visible samples, at most: of the coefficients less the packed terms. `dense`: those
 * of the block, or NULL if all are listed; are_all: all samples are visible. */
static cvol_visible_error visible_loss(const workplace *w, const cvol_scan_task *task,
                                       const cvol_dense_block *dense, int are_all, size_t index,
                                       const cvol_builder *b)
{
    const int B = b->array->block;
    memset(w->errors, 0, b->per_block * sizeof *w->errors);
    for (int z = 0; dense && z < dense->box[2]; z++)
        for (int y = 0; y < dense->box[1]; y++)
            memcpy(w->errors + B * (y + B * z), dense->coefficients + B * (y + B * z),
                   (size_t)dense->box[0] * sizeof *w->errors);
    for (uint32_t i = 0; i < task->count; i++)
        w->errors[task->places[i]] = (float)((double)task->values[i] -
                                             b->step * (double)w->integers[i]);
    return cvol_visible_loss(w->error_samples, w->errors, are_all ? NULL : w->visible, b->array,
                             index);
}

/* Packs the coefficients that the scan found, or that were listed, at w->words + r->words. */
static int pack_terms(cvol_build_run *r, cvol_block *out, const workplace *w,
                      const cvol_scan_task *task, size_t in_run, const cvol_builder *b)
{
    double doubtful = 0;
    cvol_pack_task pack = {.values = task->values,
                           .places = task->places,
                           .count = task->count,
                           .block_log2 = b->array->block_log2,
                           .step = b->step,
                           .least = task->keys ? 0 : b->least,
                           .integers = w->integers,
                           .words = w->words + r->words};
    cvol_block_pack(&pack);
    if (b->critical > b->least) {
        int code = note_candidates(r, w, task, in_run, b->critical, &doubtful);
        if (code)
            return code;
    }
    out->words = pack.word_count;
    memcpy(out->low, pack.low, sizeof out->low);
    r->coefficients += pack.terms;
    r->words += pack.word_count;
    const double lost = pack.lost + task->lost;
    r->block_lost = lost + doubtful;
    r->lost += lost;
    r->norm += pack.norm + task->lost;
    const double most = (double)(1 << CVOL_MAX_BITS) - 1;
    return pack.largest < most * b->step && isfinite(lost) ? CVOL_OK : CVOL_ERROR_DATA;
}

/* Counts the coefficients that the producer itself left out. */
static void count_left_out(cvol_build_run *r, double before, double energy)
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

static int do_block(cvol_build_run *r, workplace *w, size_t index, size_t in_run,
                    const cvol_builder *b)
{
    const cvol_array *array = b->array;
    cvol_dense_block block = {.coefficients = w->coefficients,
                              .box = {array->block, array->rank > 1 ? array->block : 1,
                                      array->rank > 2 ? array->block : 1},
                              .energy = -1,
                              .max_abs = -1,
                              .places = w->places,
                              .values = w->values,
                              .count = -1,
                              .expected_step = (float)b->expected_step};
    const size_t visible = b->hides ? cvol_visible_find(w->visible, array, index) : b->per_block;
    const double share = (double)visible / (double)b->per_block;
    if (!visible) { /* it needs no terms */
        const cvol_block empty = {.terms = NULL};
        array->block_table[index] = empty;
        return CVOL_OK;
    }
    int code = b->producer->produce(b->producer->user, &block, index, w->scratch);
    if (code)
        return code;
    for (int a = array->rank; a < 3; a++)
        block.box[a] = 1;
    if (b->counting && block.count >= 0 && !needs_keys(b)) {
        count_list(w, &block, b, share);
        return CVOL_OK;
    }
    if (block.count >= 0 && (needs_keys(b) || (b->drops_isolated && !b->counting)))
        spread(&block, array);
    if (needs_keys(b)) {
        complete(&block, array);
        make_keys(w->keys, block.coefficients, b);
    }
    if (b->counting) {
        count_block(w, &block, b, share);
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
    const int listed = block.count >= 0;
    if (!listed)
        cvol_block_scan(&task);
    if (b->drops_isolated) {
        complete(&block, array);
        drop_isolated(&task, block.coefficients, block.split, b);
    }
    if (!reserve_words(w, r->words + 2 * (size_t)task.count + CVOL_SCAN_MARGIN))
        return CVOL_ERROR_MEMORY;
    if (block.max_abs < 0 || r->max_abs < 0)
        r->max_abs = -1;
    else
        r->max_abs = block.max_abs > r->max_abs ? block.max_abs : r->max_abs;
    array->block_table[index].split = block.split;
    const double norm = r->norm, lost = r->lost;
    code = pack_terms(r, &array->block_table[index], w, &task, in_run, b);
    count_left_out(r, norm, block.energy);
    double point = sqrt(r->block_lost);
    const int are_all = visible == b->per_block;
    if (!code && b->hides && block.energy < 0 && (!are_all || point > r->worst_point)) {
        const cvol_visible_error at_most = visible_loss(w, &task, listed ? NULL : &block, are_all,
                                                        index, b);
        r->block_lost = fmin(r->block_lost, at_most.squares);
        r->lost = are_all ? r->lost : fmin(r->lost, lost + at_most.squares);
        point = fmin(sqrt(r->block_lost), at_most.most);
    }
    r->worst_point = fmax(r->worst_point, point);
    return code;
}

/* ---- runs ------------------------------------------------------------------------------------ */

size_t cvol_run_begin(const cvol_builder *b, size_t run_index)
{
    const size_t begin = run_index * b->run_blocks;
    return begin < b->array->block_count ? begin : b->array->block_count;
}

void cvol_run_place_terms(const cvol_builder *b, size_t run_index)
{
    const uint32_t *at = b->runs[run_index].terms;
    for (size_t i = cvol_run_begin(b, run_index); i < cvol_run_begin(b, run_index + 1); i++) {
        cvol_block *block = &b->array->block_table[i];
        block->terms = block->words ? at : NULL;
        at += block->words;
    }
}

static void do_run(size_t run_index, workplace *w, const cvol_builder *b)
{
    cvol_build_run *r = &b->runs[run_index];
    const size_t begin = cvol_run_begin(b, run_index), end = cvol_run_begin(b, run_index + 1);
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
    cvol_run_place_terms(b, run_index);
}

static int make_scratch(workplace *w, const cvol_builder *b)
{
    const size_t count = b->per_block + CVOL_SCAN_MARGIN;
    memset(w, 0, sizeof *w);
    w->coefficients = cvol_allocate_zero(count, sizeof(float));
    w->keys = cvol_allocate_zero(count, sizeof(float));
    w->values = cvol_allocate(count, sizeof(float));
    w->places = cvol_allocate(count, sizeof(uint32_t));
    w->integers = cvol_allocate(count, sizeof(int32_t));
    w->scratch = cvol_allocate_zero(b->producer->scratch_bytes, 1);
    if (b->hides) {
        w->errors = cvol_allocate(b->per_block, sizeof(float));
        w->error_samples = cvol_allocate(b->per_block, sizeof(float));
        w->visible = cvol_allocate(b->per_block, 1);
        if (!w->errors || !w->error_samples || !w->visible)
            return 0;
    }
    return w->coefficients && w->keys && w->values && w->places && w->integers && w->scratch &&
           reserve_words(w, 2 * count) && (!b->counting || cvol_bins_make(&w->bins));
}

static void free_workplace(workplace *w)
{
    free(w->coefficients);
    free(w->keys);
    free(w->values);
    free(w->errors);
    free(w->error_samples);
    free(w->visible);
    free(w->places);
    free(w->integers);
    free(w->words);
    free(w->scratch);
    cvol_bins_free(&w->bins);
}

static int fail(cvol_context *context, const cvol_builder *b, int code)
{
    const char *what = b->producer->what;
    if (code == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, b->producer->scratch_bytes + 32 * b->per_block, what);
    if (code == CVOL_ERROR_DATA)
        return cvol_fail(context, code,
                         "%s: a coefficient is not finite, or larger than 2^%d steps of %g", what,
                         CVOL_MAX_BITS, b->step);
    return cvol_fail(context, code, "%s: a block could not be computed", what);
}

/* Chooses one of b->counted neighbouring runs, an irregular one: rows and slices of blocks are
 * regular. */
static int is_counted(size_t run_index, const cvol_builder *b)
{
    const uint32_t mixed = (uint32_t)(run_index / b->counted) * UINT32_C(2654435761);
    return run_index % b->counted == (mixed >> 16) % b->counted;
}

/* What the processes of a team exchange about a packed run, without its terms. */
typedef struct run_sums {
    double lost, norm, worst_point;
    uint64_t coefficients;
    float max_abs;
} run_sums;

/* Completes the runs' sums: those of begin .. end - 1 are this process's own. */
static int share_runs(cvol_context *context, cvol_builder *b, cvol_team *team, int code,
                      size_t begin, size_t end)
{
    run_sums *sums = cvol_allocate_zero(b->run_count, sizeof *sums);
    if (!code && !sums)
        code = cvol_fail_memory(context, b->run_count * sizeof *sums, b->producer->what);
    for (size_t r = begin; r < end && sums; r++) {
        const cvol_build_run *one = &b->runs[r];
        sums[r] = (run_sums){one->lost, one->norm, one->worst_point, one->coefficients,
                             one->max_abs};
    }
    code = cvol_team_complete(context, team, code, sums, sizeof *sums, begin, end);
    for (size_t r = 0; r < b->run_count && !code; r++) {
        cvol_build_run *one = &b->runs[r];
        one->lost = sums[r].lost;
        one->norm = sums[r].norm;
        one->worst_point = sums[r].worst_point;
        one->coefficients = sums[r].coefficients;
        one->max_abs = sums[r].max_abs;
    }
    free(sums);
    return code;
}

/* Adds up the counts of all processes. */
static int share_bins(cvol_context *context, cvol_bins *bins, cvol_team *team, int code)
{
    const size_t bytes = CVOL_BINS * sizeof *bins->bins;
    const cvol_bins own = *bins;
    cvol_gathered all;
    code = cvol_team_add(context, team, code, &bins->forced);
    code = cvol_team_add(context, team, code, &bins->escapes);
    code = cvol_team_gather(context, &all, team, code, own.bins, bytes);
    if (!code)
        memset(own.bins, 0, bytes);
    for (int rank = 0; rank < team->size && !code; rank++) {
        const cvol_bins one = {.bins = (cvol_bin *)(void *)(all.all + all.offsets[rank])};
        cvol_bins_merge(bins, &one);
    }
    cvol_gathered_free(&all);
    return code;
}

/* Makes runs begin .. end - 1; stops after a failure. */
static int do_runs(cvol_context *context, cvol_builder *b, size_t begin, size_t end, double from,
                   double to)
{
    int failed = CVOL_OK;
    for (size_t first = begin; first < end && !failed; first += RUNS_AT_ONCE) {
        const size_t last = first + RUNS_AT_ONCE < end ? first + RUNS_AT_ONCE : end;
        const double done = (double)(first - begin) / (double)(end - begin);
        int code = cvol_report_progress(context, b->producer->what, from + (to - from) * done);
        if (code)
            return code;
#pragma omp parallel num_threads(cvol_context_threads(context))
        {
            workplace w;
            const int ready = make_scratch(&w, b);
#pragma omp for schedule(dynamic)
            for (size_t r = first; r < last; r++)
                if (b->counting && !is_counted(r, b))
                    continue;
                else if (ready)
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

int cvol_build_pass(cvol_context *context, cvol_builder *b, double from, double to)
{
    const cvol_share share = cvol_share_of(context, b->array);
    const size_t begin = cvol_share_group(&share, 0, b->run_blocks),
                 end = cvol_share_group(&share, 1, b->run_blocks);
    size_t blocks[2];
    if (!share.team)
        return do_runs(context, b, 0, b->run_count, from, to);
    if (b->counting)
        return share_bins(context, b->counting, share.team,
                          do_runs(context, b, begin, end, from, to));
    int code = CVOL_OK;
    cvol_share_computed(blocks, &share, b->array);
    if (blocks[0] < blocks[1])
        code = do_runs(context, b, blocks[0] / b->run_blocks,
                       (blocks[1] + b->run_blocks - 1) / b->run_blocks, from, to);
    return share_runs(context, b, share.team, code, begin, end);
}
