/* Processes bricks in parallel, one chunk at a time. Between chunks it reports progress, passes
 * bytes on in order, and gives terms to the array. */
#include "codec/brick/bricks.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/team.h"
#include "base/thread.h"
#include "codec/brick/brick_team.h"
#include "codec/quantize/coding.h"
#include "transform/cell.h"

/* Bricks between two calls of the progress function: whole runs, because runs have 1, 2, 4, 8 or 16
 * bricks. */
enum { CHUNK_BRICKS = 8 * CVOL_RUN_BRICKS };

/* Distance from which the filter across faces of lapped volumes mixes samples into a box. */
enum { LAP_REACH = 2 };

/* One coder per thread, for all chunks. */
typedef struct coders {
    cvol_brick_coder **coder;
    int count;
} coders;

static void coders_free(coders *all)
{
    for (int i = 0; i < all->count; i++)
        cvol_brick_coder_free(all->coder[i]);
    free(all->coder);
    *all = (coders){0};
}

static int coders_make(cvol_context *context, coders *all, const cvol_token_tables *tables)
{
    const int count = cvol_context_threads(context);
    *all = (coders){.coder = calloc((size_t)count, sizeof *all->coder)};
    for (; all->coder && all->count < count; all->count++)
        if (!(all->coder[all->count] = cvol_brick_coder_create(tables)))
            break;
    if (all->count == count)
        return CVOL_OK;
    coders_free(all);
    return cvol_fail_memory(context, (size_t)count << 20, "the coder");
}

/* ---- encoding --------------------------------------------------------------------------- */

typedef struct subband_bytes {
    cvol_bytes subbands[CVOL_SUBBANDS];
} subband_bytes;

/* Encodes bricks first .. first + count - 1; returns 0 when memory is short. counts: one per
 * thread, or NULL. */
static int encode_chunk(subband_bytes *out, const cvol_array *array, const coders *all,
                        cvol_token_counts *counts, size_t first, size_t count)
{
    int done = 1;
#pragma omp parallel num_threads(all->count)
    {
        int own = 0;
#pragma omp for schedule(static, 1)
        for (int i = 0; i < all->count; i++)
            own = i;
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++) {
            if (!cvol_brick_encode(all->coder[own], out[i].subbands, array, first + i)) {
#pragma omp atomic write
                done = 0;
            }
            if (counts)
                cvol_brick_coder_count(all->coder[own], &counts[own]);
        }
    }
    return done;
}

static int hand_over(cvol_context *context, const subband_bytes *chunk, size_t first, size_t count,
                     const cvol_brick_sink *sink)
{
    int code = CVOL_OK;
    for (size_t i = 0; i < count && !code; i++) {
        cvol_span spans[CVOL_SUBBANDS];
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            spans[s] = (cvol_span){chunk[i].subbands[s].data, chunk[i].subbands[s].size};
        code = sink->take(context, sink->user, first + i, spans);
    }
    return code;
}

/* Encodes bricks begin .. end - 1, and passes their bytes to the sink if it is not NULL. */
static int encode_range(cvol_context *context, const cvol_array *array, const coders *all,
                        cvol_token_counts *counts, const cvol_brick_sink *sink,
                        const size_t range[2])
{
    const size_t bricks = range[1] - range[0];
    int code = CVOL_OK;
    subband_bytes *chunk = calloc(CHUNK_BRICKS, sizeof *chunk);
    if (!chunk)
        return cvol_fail_memory(context, CHUNK_BRICKS * sizeof *chunk, "the bricks");
    for (size_t first = 0; first < bricks && !code; first += CHUNK_BRICKS) {
        const size_t left = bricks - first, count = left < CHUNK_BRICKS ? left : CHUNK_BRICKS;
        if (!encode_chunk(chunk, array, all, counts, range[0] + first, count))
            code = cvol_fail_memory(context, sizeof *chunk, "a brick");
        if (!code && sink)
            code = hand_over(context, chunk, range[0] + first, count, sink);
        if (!code)
            code = cvol_report_progress(context, "coding",
                                        (double)(first + count) / (double)bricks);
    }
    for (size_t i = 0; i < CHUNK_BRICKS; i++)
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&chunk[i].subbands[s]);
    free(chunk);
    return code;
}

static int put_packet(cvol_context *context, void *user, size_t brick,
                      const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)context;
    cvol_packet_put(user, brick, 0, subbands);
    return CVOL_OK;
}

static int take_packet(cvol_context *context, void *user, size_t brick, double error,
                       const cvol_span subbands[CVOL_SUBBANDS])
{
    const cvol_brick_sink *sink = user;
    (void)error;
    return sink->take(context, sink->user, brick, subbands);
}

/* Encodes all bricks; each process of a team encodes those of its share, and all of them go to the
 * sinks of all. */
static int encode_all(cvol_context *context, const cvol_array *array, const coders *all,
                      cvol_token_counts *counts, const cvol_brick_sink *sink)
{
    const cvol_share share = cvol_share_of(context, array);
    cvol_bytes packet = {0};
    cvol_brick_sink own = {put_packet, &packet};
    size_t range[2];
    cvol_share_bricks(range, &share, array);
    if (!share.team || !sink)
        return encode_range(context, array, all, counts, sink, range);
    const int code = encode_range(context, array, all, counts, &own, range);
    cvol_brick_sink to = *sink;
    return cvol_team_pass_bricks(context, share.team, code, &packet, take_packet, &to);
}

int cvol_bricks_fit(cvol_context *context, const cvol_array *array)
{
    const cvol_share share = cvol_share_of(context, array);
    coders all;
    size_t range[2];
    int code = coders_make(context, &all, NULL);
    int fits = 1; /* the least of all bricks */
    if (code)
        return code;
    cvol_share_bricks(range, &share, array);
#pragma omp parallel for schedule(dynamic) num_threads(all.count) reduction(min : fits)
    for (size_t b = range[0]; b < range[1]; b++)
        if (fits > 0)
            fits = cvol_brick_fits(all.coder[cvol_thread_index()], array, b);
    coders_free(&all);
    if (fits < 0)
        code = cvol_fail_memory(context, sizeof all, "the coder of bricks");
    uint64_t unfit = fits == 0;
    code = cvol_team_add(context, share.team, code, &unfit);
    return code ? code : !unfit;
}

int cvol_bricks_encode(cvol_context *context, const cvol_array *array,
                       const cvol_token_tables *tables, const cvol_brick_sink *sink)
{
    coders all;
    int code = coders_make(context, &all, tables);
    if (code)
        return code;
    code = encode_all(context, array, &all, NULL, sink);
    coders_free(&all);
    return code;
}

int cvol_bricks_count(cvol_context *context, cvol_token_counts *counts, const cvol_array *array)
{
    const size_t threads = (size_t)cvol_context_threads(context);
    cvol_token_tables *tables = cvol_token_tables_create(); /* any tables will do */
    cvol_token_counts *parts = calloc(threads, sizeof *parts);
    coders all = {0};
    int code = tables && parts ? coders_make(context, &all, tables)
                               : cvol_fail_memory(context, threads * sizeof *parts, "the coder");
    if (!code)
        code = encode_all(context, array, &all, parts, NULL);
    for (int i = 0; i < all.count; i++)
        for (int r = 0; r < CVOL_ROWS; r++)
            for (int t = 0; t < CVOL_TOKENS; t++)
                counts->of[r][t] += parts[i].of[r][t];
    coders_free(&all);
    free(parts);
    free(tables);
    return cvol_team_add_counts(context, cvol_share_of(context, array).team, code, counts);
}

/* ---- decoding --------------------------------------------------------------------------- */

typedef struct decoding {
    cvol_array *array;
    const cvol_brick_source *source;
    const cvol_box *box;
    cvol_team *team; /* whose processes check different bricks, or NULL */
    coders all;
} decoding;

/* A decoded brick: its terms in an allocation of their exact size. */
typedef struct decoded {
    uint32_t *words;
    size_t count;
    uint64_t terms;
    int code;
} decoded;

/* True if samples of the box depend on the brick. */
static int is_needed(const decoding *d, size_t brick)
{
    if (!d->box)
        return 1;
    const cvol_brick_box place = cvol_brick_box_of(d->array, brick);
    const size_t reach = d->array->lapped ? LAP_REACH : 0, side = (size_t)d->array->block;
    for (int a = 0; a < 3; a++) {
        const size_t begin = place.first[a] * side, end = begin + place.count[a] * side;
        if (end + reach <= d->box->begin[a] || (begin > reach && begin - reach >= d->box->end[a]))
            return 0;
    }
    return 1;
}

/* The number of the brick's subbands to read. */
static int subbands_of(const decoding *d, size_t brick)
{
    const int available = d->source->count;
    const int wanted = d->source->levels ? CVOL_SUBBANDS - d->source->levels[brick] : available;
    return wanted < available ? wanted : available;
}

/* True if a brick among first .. end - 1 is needed, and this subband of it. */
static int is_run_needed(const decoding *d, int subband, size_t first, size_t end)
{
    for (size_t b = first; b < end; b++)
        if (is_needed(d, b) && subband < subbands_of(d, b))
            return 1;
    return 0;
}

/* Verifies the checksums of runs that contain a needed brick among first .. end - 1. Returns the
 * first damaged one, subband by subband, or SIZE_MAX. */
static size_t find_damage(const decoding *d, size_t first, size_t end)
{
    const cvol_brick_index *index = d->source->index;
    const size_t run = first / index->run;
    const size_t runs = (end - 1) / index->run + 1 - run;
    size_t found = SIZE_MAX;
#pragma omp parallel for schedule(dynamic) num_threads(d->all.count) reduction(min : found)
    for (size_t i = 0; i < runs * (size_t)d->source->count; i++) {
        const int subband = (int)(i / runs);
        const size_t r = run + i % runs, from = r * index->run;
        const size_t to = from + index->run < end ? from + index->run : end;
        const cvol_span bytes = cvol_brick_index_run(index, subband, r,
                                                     d->source->subbands[subband]);
        if (is_run_needed(d, subband, from, to) &&
            cvol_crc32c(bytes.data, bytes.size) !=
                index->checksums[(size_t)subband * index->runs + r]) {
            const size_t place = (size_t)subband * index->runs + r;
            found = place < found ? place : found;
        }
    }
    return found;
}

static int decode_brick(decoded *out, const decoding *d, cvol_brick_coder *coder, size_t brick)
{
    cvol_array *array = d->array;
    cvol_span subbands[CVOL_SUBBANDS] = {{0}};
    cvol_brick_terms terms;
    const int count = subbands_of(d, brick);
    for (int s = 0; s < count; s++)
        subbands[s] = cvol_brick_index_brick(d->source->index, s, brick, d->source->subbands[s]);
    int code = cvol_brick_decode(coder, &terms, array, brick, subbands, count);
    if (code)
        return code;
    const int is_kept = !d->source->is_checked;
    if (terms.word_count && is_kept) {
        out->words = malloc(terms.word_count * sizeof *out->words);
        if (!out->words)
            return CVOL_ERROR_MEMORY;
        memcpy(out->words, terms.words, terms.word_count * sizeof *out->words);
    }
    out->count = terms.word_count;
    out->terms = terms.terms;
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    const uint32_t *words = out->words;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        cvol_block *block = &array->block_table[cvol_brick_block_index(array, &box, i)];
        if (!is_kept)
            block->words = 0;
        block->terms = words;
        if (block->words)
            words += block->words;
        cvol_block_find_low(block, array->block_log2);
    }
    return CVOL_OK;
}

static void decode_chunk(decoded *out, const decoding *d, size_t first, size_t end)
{
#pragma omp parallel num_threads(d->all.count)
    {
        cvol_brick_coder *coder = NULL;
#pragma omp for schedule(static, 1)
        for (int i = 0; i < d->all.count; i++)
            coder = d->all.coder[i];
#pragma omp for schedule(dynamic)
        for (size_t b = first; b < end; b++)
            if (is_needed(d, b))
                out[b - first].code = decode_brick(&out[b - first], d, coder, b);
    }
}

/* Gives the terms of a chunk to the array; fails if one brick failed. */
static int adopt(cvol_context *context, cvol_array *array, decoded *bricks, size_t first,
                 size_t count, size_t total, const char *name)
{
    int code = CVOL_OK;
    for (size_t i = 0; i < count && !code; i++) {
        if (bricks[i].code == CVOL_ERROR_CORRUPT)
            code = cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: brick %zu of %zu is damaged", name,
                             first + i, total);
        else if (bricks[i].code)
            code = cvol_fail_memory(context, sizeof *bricks, "a brick");
        else if (bricks[i].words)
            code = cvol_array_adopt_pool(context, array, bricks[i].words, bricks[i].count);
        if (!code) {
            bricks[i].words = NULL;
            array->coefficients += bricks[i].terms;
        }
    }
    for (size_t i = 0; i < count; i++)
        free(bricks[i].words);
    return code;
}

/* Decodes bricks first .. end - 1, which begin a run. */
static int decode_bricks(cvol_context *context, const decoding *d, size_t first, size_t end,
                         const char *name)
{
    const cvol_brick_index *index = d->source->index;
    const size_t bricks = index->bricks;
    decoded chunk[CHUNK_BRICKS] = {{0}};
    if (!is_run_needed(d, 0, first, end))
        return CVOL_OK;
    const size_t damage = find_damage(d, first, end);
    if (damage != SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section SHL%zu: the run of bricks from brick %zu of %zu is "
                         "damaged",
                         name, damage / index->runs, damage % index->runs * index->run, bricks);
    decode_chunk(chunk, d, first, end);
    const int code = adopt(context, d->array, chunk, first, end - first, bricks, name);
    return code ? code : cvol_report_progress(context, "loading", (double)end / (double)bricks);
}

static int decode_all(cvol_context *context, const decoding *d, const char *name)
{
    const size_t bricks = d->source->index->bricks;
    const size_t at_once = d->team ? CVOL_RUN_BRICKS : CHUNK_BRICKS;
    size_t chunk = 0;
    int code = CVOL_OK;
    for (; chunk * at_once < bricks && !code; chunk += !code) {
        const size_t first = chunk * at_once, left = bricks - first;
        if (cvol_team_does(d->team, chunk))
            code = decode_bricks(context, d, first, first + (left < at_once ? left : at_once),
                                 name);
    }
    code = cvol_team_first_failure(context, d->team, code, chunk);
    return cvol_team_add(context, d->team, code, &d->array->coefficients);
}

int cvol_bricks_decode(cvol_context *context, cvol_array *array, const cvol_token_tables *tables,
                       const cvol_brick_source *source, const cvol_box *box, const char *name)
{
    decoding d = {.array = array,
                  .source = source,
                  .box = box,
                  .team = source->is_checked ? context->team : NULL};
    int code = coders_make(context, &d.all, tables);
    if (code)
        return code;
    code = decode_all(context, &d, name);
    coders_free(&d.all);
    return code;
}
