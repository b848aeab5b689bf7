/* Trains the built-in codes of tokens (src/codec/tables/token_codes.inc), except those of the
 * residual.
 *
 *     train_tokens IN.inc OUT.inc ROUNDS FILE[:NXxNYxNZ:TYPE] ...
 *
 * Each round encodes all volumes at a row of steps with the codes so far, and then makes codes of
 * the tokens that it counted. The tokens of a run are weighted by the inverse of its bits, so that
 * low rates count as much as high ones. ROUNDS 0 only prints bits and decibels of the codes in
 * IN.inc. A constant background is filled as the encoder fills it. Environment: STRIDE (every n-th
 * brick), LAPPED and DEPENDENT (trellis; 0: no, 1: yes, 2: both), SPLIT (cvol_split_choice), FIT
 * (1: with tables fitted to each run).
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "array/block/brick.h"
#include "array/core/array.h"
#include "array/core/mask.h"
#include "codec/brick/brick_code.h"
#include "codec/brick/brick_samples.h"
#include "codec/mask/mask_make.h"
#include "codec/quantize/coding.h"
#include "codec/rate/background.h"
#include "training.h"

enum { STEPS = 8 };
static const double steps[STEPS] = {0.35, 0.16, 0.08, 0.04, 0.02, 0.008, 0.003, 0.001};

typedef struct run_result {
    double bits, samples, error, chosen; /* chosen: the error that the encoder reports */
    double encode_seconds, decode_seconds;
} run_result;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Replaces the samples of a constant background by a continuation of the others. */
static void fill_background(cvol_context *context, cvol_volume *volume)
{
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_fills fills;
    cvol_mask *mask;
    void *filled;
    double least_step;
    if (cvol_background_fills(context, &fills, &least_step, volume->data, &volume->grid, &options))
        training_fail(cvol_context_message(context));
    if (!fills.count)
        return;
    if (cvol_mask_make(context, &mask, &filled, volume->data, &volume->grid, &fills))
        training_fail(cvol_context_message(context));
    if (filled)
        memcpy(volume->data, filled, cvol_grid_bytes(&volume->grid));
    free(filled);
    cvol_mask_free(mask);
}

/* The error of one brick, in the domain of the transform. */
static double brick_error(const cvol_array *array, const cvol_slab *slab, size_t brick,
                          const cvol_brick_terms *terms, cvol_array *decoded)
{
    static float cells[64 * 64 * 64] __attribute__((aligned(64)));
    static float out[4096] __attribute__((aligned(64)));
    static float *scratch;
    const size_t all[3] = {4, 4, 4};
    cvol_array lapped = *array; /* which needs more */
    lapped.lapped = 1;
    if (!scratch)
        scratch = aligned_alloc(64, (cvol_brick_scratch(&lapped, all) * 4 + 63) & ~(size_t)63);
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    cvol_brick_gather(cells, scratch, slab, array, box.first, box.count);
    const uint32_t *words = terms->words;
    double sum = 0;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        const size_t index = cvol_brick_block_index(array, &box, i);
        decoded->block_table[index].terms = words;
        words += decoded->block_table[index].words;
        cvol_block_find_low(&decoded->block_table[index], 4);
        cvol_block_evaluate(out, decoded, index);
        for (int k = 0; k < 4096; k++)
            sum += pow(out[k] - cells[4096 * i + (size_t)k], 2);
    }
    return sum;
}

static run_result run(cvol_context *context, const cvol_volume *volume, const cvol_array *shape,
                      double step, const cvol_token_tables *tables, cvol_token_counts *counts,
                      size_t stride, cvol_split_choice split)
{
    static cvol_token_costs costs;
    run_result result = {0};
    cvol_token_costs_set(&costs, tables);
    const cvol_slab slab = {volume->data, 0, volume->grid.dims[2]};
    const cvol_brick_recipe recipe = {
        shape,  tables, &costs, {step, split, 0, cvol_coding_of(shape)->trellis, {0, 0}},
        counts, NULL};
    cvol_brick_maker *maker = cvol_brick_maker_create(shape);
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
    cvol_array *decoded;
    if (cvol_array_create(context, &decoded, &volume->grid, 16) ||
        cvol_coding_need(context, decoded) || !maker || !coder)
        training_fail("no memory");
    decoded->step = step;
    cvol_coding_own(decoded)->trellis = cvol_coding_of(shape)->trellis;
    decoded->offset = shape->offset;
    const size_t count = cvol_brick_count(shape);
    for (size_t b = stride / 2 < count ? stride / 2 : 0; b < count; b += stride) {
        double start = now();
        double error;
        if (cvol_brick_make(maker, subbands, &error, &recipe,
                            cvol_brick_cells(maker, shape, &slab, b), b))
            training_fail("a brick cannot be made");
        result.encode_seconds += now() - start;
        result.chosen += error * step * step;
        cvol_span spans[CVOL_SUBBANDS];
        for (int s = 0; s < CVOL_SUBBANDS; s++) {
            result.bits += 8 * (double)subbands[s].size;
            spans[s] = (cvol_span){subbands[s].data, subbands[s].size};
        }
        const cvol_brick_box box = cvol_brick_box_of(shape, b);
        result.samples += (double)cvol_brick_box_blocks(&box) * 4096;
        cvol_brick_terms terms;
        start = now();
        if (cvol_brick_decode(coder, &terms, decoded, b, spans, CVOL_SUBBANDS))
            training_fail("a brick does not decode");
        result.decode_seconds += now() - start;
        if (!counts)
            result.error += brick_error(shape, &slab, b, &terms, decoded);
    }
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_free(&subbands[s]);
    cvol_brick_maker_free(maker);
    cvol_brick_coder_free(coder);
    for (size_t i = 0; i < decoded->block_count; i++)
        decoded->block_table[i].terms = NULL;
    cvol_array_free(decoded);
    return result;
}

static int env_number(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text ? atoi(text) : otherwise;
}

/* One volume at all steps, with one way to lap and to quantize. */
typedef struct series {
    cvol_context *context;
    const char *name;
    cvol_volume *volume;
    double min, max;
    cvol_token_tables *tables, *own;
    cvol_token_counts *counts, *sums; /* sums: weighted, of all runs */
    size_t stride;
    int fit, print, runs;
    cvol_split_choice split;
    double log_bits; /* sum over runs */
} series;

static void add_counts(series *s, double bits)
{
    const double weight = 1e9 / bits;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            s->sums->of[r][t] += (uint64_t)((double)s->counts->of[r][t] * weight);
}

static void print_run(const series *s, double step, const run_result *result, double table_bits)
{
    printf("%-24.24s step %6g bits %8.4f + %.4f dB %6.2f (%+.4f)  encode %6.1f decode %7.1f "
           "Msamples/s\n",
           s->name, step, result->bits / result->samples, table_bits / result->samples,
           20 * log10(s->max - s->min) - 10 * log10(result->error / result->samples),
           10 * log10(result->error / result->chosen),
           result->samples / 1e6 / result->encode_seconds,
           result->samples / 1e6 / result->decode_seconds);
}

static void run_steps(series *s, const cvol_array *shape)
{
    for (int k = 0; k < STEPS; k++) {
        const double step = steps[k] * (s->max - s->min) *
                            (cvol_coding_of(shape)->trellis ? 0.56 : 1);
        cvol_bytes section = {0};
        memset(s->counts, 0, sizeof *s->counts);
        memcpy(s->own, s->tables, sizeof *s->own);
        if (s->fit) {
            run(s->context, s->volume, shape, step, s->tables, s->counts, s->stride, s->split);
            cvol_token_tables_fit(s->own, s->counts);
            memset(s->counts, 0, sizeof *s->counts);
        }
        const run_result result = run(s->context, s->volume, shape, step, s->own,
                                      s->print ? NULL : s->counts, s->stride, s->split);
        if (s->fit && cvol_token_tables_put(s->context, &section, s->own))
            training_fail(cvol_context_message(s->context));
        const double table_bits = 8 * (double)section.size;
        s->log_bits += log(result.bits + table_bits);
        s->runs++;
        if (s->print)
            print_run(s, steps[k], &result, table_bits);
        cvol_bytes_free(&section);
        add_counts(s, result.bits);
    }
}

static void run_volume(series *s, const char *argument, int lapped, int trellis)
{
    char name[1024];
    cvol_array *shape;
    snprintf(name, sizeof name, "%s", argument);
    s->volume = training_read(s->context, name);
    s->name = strrchr(name, '/') ? strrchr(name, '/') + 1 : name;
    s->min = s->max = 0;
    if (cvol_array_create(s->context, &shape, &s->volume->grid, 16) ||
        cvol_coding_need(s->context, shape) ||
        cvol_scan_samples(s->context, &s->min, &s->max, s->volume->data, &s->volume->grid))
        training_fail(cvol_context_message(s->context));
    fill_background(s->context, s->volume);
    shape->offset = s->min;
    for (int way = 0; way < 4; way++) {
        shape->lapped = way & 1;
        cvol_coding_own(shape)->trellis = way >> 1;
        if ((lapped == 2 || lapped == shape->lapped) &&
            (trellis == 2 || trellis == cvol_coding_of(shape)->trellis))
            run_steps(s, shape);
    }
    cvol_array_free(shape);
    cvol_volume_free(s->volume);
}

int main(int argc, char **argv)
{
    if (argc < 5)
        training_fail("usage: train_tokens IN.inc OUT.inc ROUNDS FILE ...");
    const int rounds = atoi(argv[3]);
    const int lapped = env_number("LAPPED", 2), trellis = env_number("DEPENDENT", 2);
    series s = {.context = cvol_context_create(),
                .tables = cvol_token_tables_create(),
                .own = cvol_token_tables_create(),
                .counts = malloc(sizeof *s.counts),
                .sums = malloc(sizeof *s.sums),
                .stride = (size_t)env_number("STRIDE", 1),
                .fit = env_number("FIT", 0),
                .split = (cvol_split_choice)env_number("SPLIT", CVOL_SPLIT_BEST),
                .print = !rounds};
    if (!s.context || !s.tables || !s.counts || !s.sums || !s.own)
        training_fail("no memory");
    training_read_codes(s.tables, argv[1]);
    for (int round = 0; round < (rounds ? rounds : 1); round++) {
        memset(s.sums, 0, sizeof *s.sums);
        s.log_bits = s.runs = 0;
        for (int f = 4; f < argc; f++)
            run_volume(&s, argv[f], lapped, trellis);
        printf("round %d: mean of log2 bits %.4f\n", round, s.log_bits / s.runs / log(2));
        fflush(stdout);
        if (!rounds)
            break;
        for (int r = 0; r < CVOL_ROWS; r++)
            for (int t = 0; t < CVOL_TOKENS; t++)
                s.sums->of[r][t] /= 1000;
        training_fit_rows(s.tables, s.sums);
    }
    if (rounds)
        training_write_codes(argv[2], "The codes of a row of tokens on each line.", s.tables, 0,
                             CVOL_ROWS);
    return 0;
}
