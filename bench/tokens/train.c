/* Trains the built-in tables of tokens (src/codec/tables/token_defaults.c).
 *
 *     train_tokens OUT.c ROUNDS FILE[:NXxNYxNZ:TYPE] ...
 *
 * Every volume is encoded at a row of steps; what the tokens of each run count for is inverse to
 * its bits, so that low rates are as well served as high ones. Then tables are made of the counts,
 * and all is done again. ROUNDS 0 only prints the table of bits and decibels.
 * A background that compressing would keep apart is filled here too.
 * Environment: STRIDE (every n-th brick), LAPPED (0, 1, 2: both), SPLIT (cvol_split_choice), FIT
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
#include "codec/rate/background.h"
#include "cvol/volume.h"

enum { STEPS = 8 };
static const double steps[STEPS] = {0.35, 0.16, 0.08, 0.04, 0.02, 0.008, 0.003, 0.001};

typedef struct run_result {
    double bits, samples, error, chosen; /* chosen: the error that the encoder tells */
    double encode_seconds, decode_seconds;
} run_result;

static void fail(const char *what)
{
    fprintf(stderr, "train_tokens: %s\n", what);
    exit(1);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static cvol_volume *read_volume(cvol_context *context, char *argument)
{
    cvol_read_options options = cvol_read_options_defaults();
    char type[16], *colon = strchr(argument, ':');
    if (colon) {
        if (sscanf(colon, ":%zux%zux%zu:%15s", &options.dims[0], &options.dims[1], &options.dims[2],
                   type) != 4)
            fail("a file's dims and type are FILE:NXxNYxNZ:TYPE");
        options.type = strcmp(type, "float32") == 0 ? CVOL_FLOAT32 : CVOL_UINT8;
        *colon = 0;
    }
    cvol_volume *volume;
    if (cvol_volume_read(context, &volume, argument, colon ? &options : NULL))
        fail(cvol_context_message(context));
    return volume;
}

/* Samples of a background become what continues those beside them. */
static void fill_background(cvol_context *context, cvol_volume *volume)
{
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_fills fills;
    cvol_mask *mask;
    void *filled;
    double least_step;
    if (cvol_background_fills(context, &fills, &least_step, volume->data, &volume->grid, &options))
        fail(cvol_context_message(context));
    if (!fills.count)
        return;
    if (cvol_mask_make(context, &mask, &filled, volume->data, &volume->grid, &fills))
        fail(cvol_context_message(context));
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
    const cvol_brick_recipe recipe = {shape,  tables, &costs, {step, split, 0, shape->dependent, {0, 0}},
                                      counts, NULL};
    cvol_brick_maker *maker = cvol_brick_maker_create(shape);
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    cvol_bytes shells[CVOL_SHELLS] = {{0}};
    cvol_array *decoded;
    if (cvol_array_create(context, &decoded, &volume->grid, 16) || !maker || !coder)
        fail("no memory");
    decoded->step = step;
    decoded->dependent = shape->dependent;
    decoded->offset = shape->offset;
    for (size_t b = stride / 2; b < cvol_brick_count(shape); b += stride) {
        double start = now();
        double error;
        if (cvol_brick_make(maker, shells, &error, &recipe,
                            cvol_brick_cells(maker, shape, &slab, b), b))
            fail("a brick cannot be made");
        result.encode_seconds += now() - start;
        result.chosen += error * step * step;
        cvol_span spans[CVOL_SHELLS];
        for (int s = 0; s < CVOL_SHELLS; s++) {
            result.bits += 8 * (double)shells[s].size;
            spans[s] = (cvol_span){shells[s].data, shells[s].size};
        }
        const cvol_brick_box box = cvol_brick_box_of(shape, b);
        result.samples += (double)cvol_brick_box_blocks(&box) * 4096;
        cvol_brick_terms terms;
        start = now();
        if (cvol_brick_decode(coder, &terms, decoded, b, spans, CVOL_SHELLS))
            fail("a brick does not decode");
        result.decode_seconds += now() - start;
        if (!counts)
            result.error += brick_error(shape, &slab, b, &terms, decoded);
    }
    for (int s = 0; s < CVOL_SHELLS; s++)
        cvol_bytes_free(&shells[s]);
    cvol_brick_maker_free(maker);
    cvol_brick_coder_free(coder);
    for (size_t i = 0; i < decoded->block_count; i++)
        decoded->block_table[i].terms = NULL;
    cvol_array_free(decoded);
    return result;
}

static void write_tables(const char *path, const cvol_token_tables *tables)
{
    FILE *file = fopen(path, "w");
    if (!file)
        fail("cannot write the tables");
    fprintf(file, "/* Built-in codes of all rows (token_tables.h), written by "
                  "bench/tokens/train.c. */\n"
                  "#include \"codec/entropy/token_tables.h\"\n\n/* clang-format off */\n"
                  "const uint8_t cvol_token_defaults[CVOL_ROWS][CVOL_TOKEN_CODES] = {\n");
    for (int r = 0; r < CVOL_ROWS; r++) {
        fprintf(file, "    {");
        for (int t = 0; t < CVOL_TOKEN_CODES; t++)
            fprintf(file, "%s%d", t ? ", " : "", tables->codes[r][t]);
        fprintf(file, "},\n");
    }
    fprintf(file, "};\n");
    if (fclose(file))
        fail("cannot write the tables");
}

static int env_number(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text ? atoi(text) : otherwise;
}

int main(int argc, char **argv)
{
    if (argc < 4)
        fail("OUT.c ROUNDS FILE ...");
    cvol_context *context = cvol_context_create();
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_counts *counts = malloc(sizeof *counts), *sums = malloc(sizeof *sums);
    const int rounds = atoi(argv[2]);
    const size_t stride = (size_t)env_number("STRIDE", 1);
    const int lapped = env_number("LAPPED", 1), fit = env_number("FIT", 0),
              dependent = env_number("DEPENDENT", 0);
    const cvol_split_choice split = (cvol_split_choice)env_number("SPLIT", CVOL_SPLIT_BEST);
    cvol_token_tables *own = cvol_token_tables_create();
    if (!context || !tables || !counts || !sums || !own)
        fail("no memory");
    for (int round = 0; round < (rounds ? rounds : 1); round++) {
        memset(sums, 0, sizeof *sums);
        double all = 0;
        for (int f = 3; f < argc; f++) {
            char name[1024];
            snprintf(name, sizeof name, "%s", argv[f]);
            cvol_volume *volume = read_volume(context, name);
            cvol_array *shape;
            double min = 0, max = 0;
            if (cvol_array_create(context, &shape, &volume->grid, 16) ||
                cvol_survey_samples(context, &min, &max, volume->data, &volume->grid))
                fail(cvol_context_message(context));
            fill_background(context, volume);
            shape->offset = min;
            shape->lapped = lapped;
            shape->dependent = dependent;
            for (int k = 0; k < STEPS * (lapped > 1 ? 2 : 1); k++) {
                if (lapped > 1)
                    shape->lapped = k >= STEPS;
                memset(counts, 0, sizeof *counts);
                const double step = steps[k % STEPS] * (max - min) * (dependent ? 0.56 : 1);
                run_result result;
                memcpy(own, tables, sizeof *own);
                if (fit) {
                    run(context, volume, shape, step, tables, counts, stride, split);
                    cvol_token_tables_fit(own, counts);
                }
                result = run(context, volume, shape, step, own, rounds ? counts : NULL, stride,
                             split);
                cvol_bytes section = {0};
                cvol_token_tables_put(context, &section, own);
                all += log(result.bits + 8 * (double)section.size);
                if (!rounds)
                    printf("%-24.24s step %6g bits %8.4f + %.4f dB %6.2f (%+.4f)  encode %6.1f "
                           "decode %7.1f "
                           "Msamples/s\n",
                           strrchr(name, '/') ? strrchr(name, '/') + 1 : name, steps[k % STEPS],
                           result.bits / result.samples, 8 * (double)section.size / result.samples,
                           20 * log10(max - min) - 10 * log10(result.error / result.samples),
                           10 * log10(result.error / result.chosen),
                           result.samples / 1e6 / result.encode_seconds,
                           result.samples / 1e6 / result.decode_seconds);
                cvol_bytes_free(&section);
                const double weight = 1e9 / result.bits;
                for (int r = 0; r < CVOL_ROWS; r++)
                    for (int t = 0; t < CVOL_TOKENS; t++)
                        sums->of[r][t] += (uint64_t)((double)counts->of[r][t] * weight);
            }
            cvol_array_free(shape);
            cvol_volume_free(volume);
        }
        printf("round %d: mean of log2 bits %.4f\n", round, all / (argc - 3) / STEPS / log(2));
        fflush(stdout);
        if (rounds) {
            for (int r = 0; r < CVOL_ROWS; r++)
                for (int t = 0; t < CVOL_TOKENS; t++)
                    sums->of[r][t] /= 1000;
            cvol_token_tables_train(tables, sums);
            write_tables(argv[1], tables);
        }
    }
    return 0;
}
