/* One encoding pass: strip after strip of bricks. */
#include "codec/brick/encode_pass.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_team.h"
#include "transform/cell.h"

/* Minimum number of bricks per thread between progress reports, for a volume in memory; with more
 * bricks threads wait less. */
enum { BRICKS_PER_THREAD = 16 };

/* One brick of the current strip. */
typedef struct strip_brick {
    size_t brick;
    cvol_bytes subbands[CVOL_SUBBANDS];
    double error;
    uint32_t *words; /* of the terms to keep, or NULL */
    size_t word_count, terms;
    int code;
} strip_brick;

typedef struct encoding {
    const cvol_encode_pass *pass;
    cvol_token_costs costs;
    int threads;
    cvol_brick_maker **makers; /* one per thread */
    cvol_token_counts *counts; /* one per thread, or NULL */
    strip_brick *bricks;       /* room for `room` */
    size_t room, bricks_per_layer;
    size_t at_once; /* layers per slab, if all samples are in memory */
    cvol_strips strips;
} encoding;

static void encoding_free(encoding *e)
{
    for (int t = 0; e->makers && t < e->threads; t++)
        cvol_brick_maker_free(e->makers[t]);
    for (size_t i = 0; e->bricks && i < e->room; i++)
        free(e->bricks[i].words);
    for (size_t i = 0; e->bricks && i < e->room; i++)
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&e->bricks[i].subbands[s]);
    free(e->makers);
    free(e->counts);
    free(e->bricks);
    free(e);
}

static int encoding_make(cvol_context *context, encoding **out, const cvol_encode_pass *pass)
{
    encoding *e = cvol_allocate_zero(1, sizeof *e);
    *out = e;
    if (!e)
        return cvol_fail_memory(context, sizeof *e, "the encoder");
    e->pass = pass;
    e->threads = cvol_context_threads(context);
    e->strips = cvol_strips_of(pass->source, pass->shape);
    const size_t *grid = e->strips.grid;
    e->bricks_per_layer = grid[0] * grid[1];
    e->at_once = pass->source->whole && pass->every <= 1
                     ? (size_t)e->threads * BRICKS_PER_THREAD / e->bricks_per_layer + 1
                     : 1;
    e->at_once = e->at_once < grid[2] ? e->at_once : grid[2];
    e->room = grid[0] * e->strips.rows * e->at_once;
    if (!pass->source->whole && e->room > (size_t)e->threads * BRICKS_PER_THREAD)
        e->room = (size_t)e->threads * BRICKS_PER_THREAD;
    cvol_token_costs_set(&e->costs, pass->tables);
    if (pass->weight > 0)
        cvol_token_costs_weigh(&e->costs, pass->weight);
    e->makers = cvol_allocate_zero((size_t)e->threads, sizeof(void *));
    e->bricks = cvol_allocate_zero(e->room, sizeof *e->bricks);
    int made = e->makers && e->bricks;
    if (pass->counts) {
        e->counts = cvol_allocate_zero((size_t)e->threads, sizeof *e->counts);
        made = made && e->counts;
    }
    for (int t = 0; t < e->threads && made; t++)
        made = (e->makers[t] = cvol_brick_maker_create(pass->shape)) != NULL;
    if (made)
        return CVOL_OK;
    encoding_free(e);
    *out = NULL;
    return cvol_fail_memory(context, (size_t)4 << 20, "the encoder");
}

/* The stride over layers of a pass over some bricks. */
static size_t layers_apart(const encoding *e)
{
    return e->pass->every > 1 && e->strips.grid[2] > 8 ? 2 : 1;
}

/* True if the pass encodes a brick: bricks on a lattice, in every layers_apart-th layer. */
static int is_wanted(const encoding *e, size_t brick)
{
    const size_t apart = layers_apart(e), every = e->pass->every / apart;
    const size_t *grid = e->strips.grid;
    const size_t x = brick % grid[0], y = brick / grid[0] % grid[1];
    return every <= 1 || (x + 5 * y + 3 * (brick / e->bricks_per_layer / apart)) % every == 0;
}

/* Lists bricks from *next on that the pass encodes, up to the available room; returns their
 * number. */
static size_t list_bricks(encoding *e, size_t *next, size_t end)
{
    size_t count = 0;
    for (; *next < end && count < e->room; ++*next)
        if (is_wanted(e, *next))
            e->bricks[count++].brick = *next;
    return count;
}

/* Copies a finished brick's terms, for the array that keeps them. */
static int copy_terms(strip_brick *to, const cvol_brick_maker *maker, cvol_array *kept)
{
    const cvol_brick_terms terms = cvol_brick_maker_terms(maker);
    const cvol_brick_box box = cvol_brick_box_of(kept, to->brick);
    to->word_count = terms.word_count;
    to->terms = terms.terms;
    to->words = terms.word_count ? malloc(terms.word_count * sizeof *to->words) : NULL;
    if (terms.word_count && !to->words)
        return CVOL_ERROR_MEMORY;
    if (terms.word_count)
        memcpy(to->words, terms.words, terms.word_count * sizeof *to->words);
    const uint32_t *words = to->words;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        cvol_block *block = &kept->block_table[cvol_brick_block_index(kept, &box, i)];
        block->terms = words;
        if (block->words)
            words += block->words;
        cvol_block_find_low(block, kept->block_log2);
    }
    return CVOL_OK;
}

static void encode_bricks(encoding *e, const cvol_slab *slab, size_t count)
{
    const cvol_encode_pass *pass = e->pass;
#pragma omp parallel num_threads(e->threads)
    {
        /* Each thread takes the next free maker, because OpenMP may start fewer threads than
         * requested. */
        cvol_brick_maker *maker = NULL;
        cvol_brick_recipe recipe = {pass->shape,   pass->tables, &e->costs,
                                    pass->options, NULL,         pass->kept};
#pragma omp for schedule(static, 1)
        for (int t = 0; t < e->threads; t++) {
            maker = e->makers[t];
            recipe.counts = e->counts ? &e->counts[t] : NULL;
        }
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++) {
            strip_brick *to = &e->bricks[i];
            to->code = cvol_brick_make(maker, to->subbands, &to->error, &recipe,
                                       cvol_brick_cells(maker, pass->shape, slab, to->brick),
                                       to->brick);
            if (!to->code && pass->kept)
                to->code = copy_terms(to, maker, pass->kept);
        }
    }
}

/* Adds up the results of a brick, and passes its bytes on. */
static int take_brick(cvol_context *context, cvol_encode_result *out, const cvol_encode_pass *pass,
                      size_t brick, const cvol_span spans[CVOL_SUBBANDS], double error)
{
    const cvol_brick_box box = cvol_brick_box_of(pass->shape, brick);
    const size_t B = (size_t)pass->shape->block;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        out->bytes += spans[s].size;
    out->samples += cvol_brick_box_blocks(&box) * B * B * B;
    out->error += error * pass->options.step * pass->options.step;
    return pass->sink ? pass->sink->take(context, pass->sink->user, brick, spans) : CVOL_OK;
}

static int check_brick(cvol_context *context, const strip_brick *brick)
{
    return cvol_brick_check(context, brick->code);
}

/* Adds up the results of bricks, and passes their bytes on. */
static int take_bricks(cvol_context *context, cvol_encode_result *out, encoding *e, size_t count)
{
    const cvol_encode_pass *pass = e->pass;
    for (size_t i = 0; i < count; i++) {
        strip_brick *from = &e->bricks[i];
        cvol_span spans[CVOL_SUBBANDS];
        int code = check_brick(context, from);
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            spans[s] = (cvol_span){from->subbands[s].data, from->subbands[s].size};
        if (!code)
            code = take_brick(context, out, pass, from->brick, spans, from->error);
        if (!code && from->words)
            code = cvol_array_adopt_pool(context, pass->kept, from->words, from->word_count);
        if (!code) {
            from->words = NULL;
            if (pass->kept)
                pass->kept->coefficients += from->terms;
        }
        if (code)
            return code;
    }
    return CVOL_OK;
}

static void add_counts(cvol_token_counts *to, const encoding *e)
{
    memset(to, 0, sizeof *to);
    for (int t = 0; t < e->threads; t++)
        for (int r = 0; r < CVOL_ROWS; r++)
            for (int k = 0; k < CVOL_TOKENS; k++)
                to->of[r][k] += e->counts[t].of[r][k];
}

/* Reports that the bricks before `next` are encoded. */
static int report(cvol_context *context, const encoding *e, size_t next)
{
    const cvol_encode_pass *pass = e->pass;
    const double span = pass->progress_to - pass->progress_from;
    const size_t all = e->strips.grid[2] * e->bricks_per_layer;
    return cvol_report_progress(context, "compressing",
                                pass->progress_from + span * (double)next / (double)all);
}

/* Encodes a strip whose samples are available. */
static int encode_strip(cvol_context *context, cvol_encode_result *out, encoding *e,
                        const cvol_slab *slab, const cvol_strip *strip)
{
    size_t bricks[2];
    int code = CVOL_OK;
    cvol_strip_bricks(bricks, &e->strips, strip);
    for (size_t next = bricks[0]; next < bricks[1] && !code;) {
        const size_t count = list_bricks(e, &next, bricks[1]);
        encode_bricks(e, slab, count);
        code = take_bricks(context, out, e, count);
        if (!code)
            code = report(context, e, next);
    }
    return code;
}

/* ---- teams ------------------------------------------------------------------------------ */

static int pack_brick(cvol_context *context, cvol_bytes *out, const strip_brick *from)
{
    const int code = check_brick(context, from);
    cvol_span spans[CVOL_SUBBANDS];
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        spans[s] = (cvol_span){from->subbands[s].data, from->subbands[s].size};
    cvol_packet_put(out, from->brick, from->error, spans);
    return !code && out->failed ? cvol_fail_memory(context, out->size, "a strip of bricks") : code;
}

/* Encodes a strip whose samples are available. */
static int pack_strip(cvol_context *context, cvol_bytes *out, encoding *e, const cvol_slab *slab,
                      const cvol_strip *strip)
{
    size_t bricks[2];
    int code = CVOL_OK;
    cvol_strip_bricks(bricks, &e->strips, strip);
    for (size_t next = bricks[0]; next < bricks[1] && !code;) {
        const size_t count = list_bricks(e, &next, bricks[1]);
        encode_bricks(e, slab, count);
        for (size_t i = 0; i < count && !code; i++)
            code = pack_brick(context, out, &e->bricks[i]);
        if (!code)
            code = report(context, e, next);
    }
    return code;
}

typedef struct taking {
    cvol_encode_result *out;
    const cvol_encode_pass *pass;
} taking;

static int take_packed(cvol_context *context, void *user, size_t brick, double error,
                       const cvol_span subbands[CVOL_SUBBANDS])
{
    const taking *to = user;
    return take_brick(context, to->out, to->pass, brick, subbands, error);
}

/* The strips of the pass, and one of them. */
static size_t strip_count(const encoding *e)
{
    return (e->strips.grid[2] + layers_apart(e) - 1) / layers_apart(e) * e->strips.per_layer;
}

static cvol_strip strip_at(const encoding *e, size_t i)
{
    const size_t in_layer = i % e->strips.per_layer;
    return cvol_strip_at(&e->strips, (i - in_layer) * layers_apart(e) + in_layer);
}

/* Encodes the strips of one turn, from number `first` on: one by each process. */
static int run_turn(cvol_context *context, cvol_encode_result *out, encoding *e, size_t first)
{
    const cvol_encode_pass *pass = e->pass;
    cvol_team *team = pass->source->team;
    const size_t own_number = first + (size_t)team->rank;
    const int has_strip = own_number < strip_count(e);
    const cvol_strip strip = strip_at(e, has_strip ? own_number : 0);
    cvol_slab slab = {0};
    cvol_bytes own = {0};
    cvol_gathered all;
    int code = CVOL_OK;
    if (has_strip)
        code = cvol_slab_fetch_strip(context, &slab, pass->source, pass->shape, &strip);
    if (has_strip && !code)
        code = pack_strip(context, &own, e, &slab, &strip);
    code = cvol_team_gather(context, &all, team, code, own.data, own.size);
    cvol_bytes_free(&own);
    if (!code) /* their strips follow each other */
        code = cvol_packet_open(context, all.all, all.offsets[team->size], take_packed,
                                &(taking){out, pass});
    cvol_gathered_free(&all);
    code = cvol_team_agree(context, team, code);
    if (!code && pass->after)
        code = pass->after(context, pass->user, &slab, has_strip ? &strip : NULL);
    return code;
}

static int run_by_team(cvol_context *context, cvol_encode_result *out, encoding *e)
{
    cvol_team *team = e->pass->source->team;
    int code = CVOL_OK;
    for (size_t first = 0; first < strip_count(e) && !code; first += (size_t)team->size)
        code = run_turn(context, out, e, first);
    if (!code && e->pass->counts) {
        add_counts(e->pass->counts, e);
        code = cvol_team_add_counts(context, team, CVOL_OK, e->pass->counts);
    }
    return code;
}

static int run_alone(cvol_context *context, cvol_encode_result *out, encoding *e)
{
    const cvol_encode_pass *pass = e->pass;
    const size_t strips = strip_count(e);
    int code = CVOL_OK;
    for (size_t i = 0; i < strips && !code; i += e->at_once) {
        cvol_slab slab;
        cvol_strip strip = strip_at(e, i);
        if (e->at_once > 1) /* layers, all of whose rows are in one strip */
            strip.layers[1] =
                strip_at(e, i + e->at_once < strips ? i + e->at_once - 1 : strips - 1).layers[1];
        code = cvol_slab_fetch_strip(context, &slab, pass->source, pass->shape, &strip);
        if (!code)
            code = encode_strip(context, out, e, &slab, &strip);
        if (!code && pass->after)
            code = pass->after(context, pass->user, &slab, &strip);
    }
    if (!code && pass->counts)
        add_counts(pass->counts, e);
    return code;
}

int cvol_encode_pass_run(cvol_context *context, cvol_encode_result *out,
                         const cvol_encode_pass *pass)
{
    encoding *e;
    *out = (cvol_encode_result){0};
    int code = cvol_team_agree(context, pass->source->team, encoding_make(context, &e, pass));
    if (!code)
        code = pass->source->team ? run_by_team(context, out, e) : run_alone(context, out, e);
    if (e)
        encoding_free(e);
    return code;
}
