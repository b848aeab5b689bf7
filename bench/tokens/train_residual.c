/* Trains the built-in codes of the residual (rows CVOL_ROW_RESIDUAL to CVOL_ROW_INDEX of
 * src/codec/tables/token_codes.inc); writes the other rows as they are. Run it after train_tokens.
 *
 *     train_residual IN.inc OUT.inc FILE[:NXxNYxNZ:TYPE] ...
 *
 * Encodes each volume at a row of steps, and codes the residual for a row of bounds. Samples above
 * 1e30 are masked; if many samples have the lowest value, these are masked in a second run.
 * Environment: BOUNDS (how many bounds; 0: exact residual only), STRIDE (every n-th brick).
 */
#define _POSIX_C_SOURCE 200809L
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/brick.h"
#include "array/block/exact.h"
#include "base/memory.h"
#include "codec/brick/brick_samples.h"
#include "codec/mask/mask_fill.h"
#include "codec/residual/residual_code.h"
#include "training.h"

enum { BRICK = 64 * 64 * 64 };

/* A volume, filled, and its base at one step. */
typedef struct operand {
    cvol_context *context;
    cvol_volume *volume;
    void *filled;
    cvol_mask *mask;
    cvol_array *base;
    double min, max, bits; /* bits: of the base, of the examined bricks */
    double samples;        /* in these bricks */
    int grain;
    double largest;
} operand;

static double sample_of(const cvol_volume *volume, size_t i)
{
    double value = 0;
    switch (volume->grid.type) {
    case CVOL_UINT8:
        return ((const uint8_t *)volume->data)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)volume->data)[i];
    case CVOL_INT16:
        return ((const int16_t *)volume->data)[i];
    case CVOL_FLOAT32:
        return (double)((const float *)volume->data)[i];
    default:
        training_fail("a type that is not trained on");
    }
    return value;
}

static void find_mask(operand *s, int lowest)
{
    const cvol_grid *grid = &s->volume->grid;
    const size_t count = cvol_grid_samples(grid), zero[3] = {0, 0, 0};
    cvol_fills fills = {0};
    uint8_t *which = malloc(count);
    uint64_t bits;
    size_t low = 0, most = 0;
    s->min = INFINITY;
    s->max = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        const double value = sample_of(s->volume, i);
        most += value > 1e30;
        if (value > 1e30)
            continue;
        low = value < s->min ? 1 : low + (value == s->min);
        s->min = fmin(s->min, value);
        s->max = fmax(s->max, value);
    }
    if (most && cvol_fills_of_value(&bits, grid->type, 1e35))
        cvol_fills_add(&fills, bits);
    if (lowest && low > count / 20 && cvol_fills_of_value(&bits, grid->type, s->min))
        cvol_fills_add(&fills, bits);
    cvol_fills_match(which, &fills, grid->type, s->volume->data, count);
    if (cvol_mask_create(s->context, &s->mask, grid->dims, &fills) ||
        !cvol_mask_set(s->mask, which, zero, grid->dims))
        training_fail("no memory");
    s->filled = malloc(count * cvol_type_size(grid->type));
    if (cvol_mask_fill(s->context, s->filled, s->volume->data, grid, s->mask, 0, grid->dims[2],
                       s->min))
        training_fail("cannot fill");
    s->grain = INT_MAX;
    s->largest = 0;
    cvol_residual_scan(&s->grain, &s->largest, grid->type, s->volume->data, which, count);
    free(which);
}

/* The first examined brick. */
static size_t first_brick(size_t stride, size_t bricks)
{
    return stride / 2 < bricks ? stride / 2 : 0;
}

static void make_base(operand *s, double step, const cvol_token_tables *tables, size_t stride)
{
    static cvol_token_costs costs;
    const cvol_grid *grid = &s->volume->grid;
    cvol_array *array;
    cvol_token_costs_set(&costs, tables);
    if (cvol_array_create(s->context, &array, grid, 16))
        training_fail(cvol_context_message(s->context));
    array->lapped = 1;
    array->offset = array->error_bound.value_min = s->min;
    array->error_bound.value_max = s->max;
    array->step = step;
    const cvol_slab slab = {s->filled, 0, grid->dims[2]};
    const cvol_brick_recipe recipe = {array, tables, &costs, {step, CVOL_SPLIT_BEST, 0, 0, {0, 0}},
                                      NULL,  NULL};
    cvol_brick_maker *maker = cvol_brick_maker_create(array);
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
    s->bits = 0;
    const size_t bricks = cvol_brick_count(array), first = first_brick(stride, bricks);
    for (size_t b = 0; b < bricks; b++) {
        double error;
        cvol_span spans[CVOL_SUBBANDS];
        cvol_brick_terms terms;
        if (cvol_brick_make(maker, subbands, &error, &recipe,
                            cvol_brick_cells(maker, array, &slab, b), b))
            training_fail("a brick cannot be made");
        for (int k = 0; k < CVOL_SUBBANDS; k++) {
            spans[k] = (cvol_span){subbands[k].data, subbands[k].size};
            s->bits += b % stride == first ? 8 * (double)subbands[k].size : 0;
        }
        if (cvol_brick_decode(coder, &terms, array, b, spans, CVOL_SUBBANDS))
            training_fail("a brick does not decode");
        const cvol_brick_box box = cvol_brick_box_of(array, b);
        uint32_t *words = malloc(4 * terms.word_count + 4), *at = words;
        memcpy(words, terms.words, 4 * terms.word_count);
        for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
            cvol_block *block = &array->block_table[cvol_brick_block_index(array, &box, i)];
            block->terms = at;
            at += block->words;
            cvol_block_find_low(block, 4);
        }
        if (cvol_array_adopt_pool(s->context, array, words, terms.word_count))
            training_fail("no memory");
    }
    for (int k = 0; k < CVOL_SUBBANDS; k++)
        cvol_bytes_free(&subbands[k]);
    cvol_brick_maker_free(maker);
    cvol_brick_coder_free(coder);
    s->base = array;
}

/* Bits of the whole residual. */
static double correct(operand *s, double bound, const cvol_token_tables *tables,
                      cvol_token_counts *counts, size_t stride)
{
    static uint8_t which[BRICK];
    static double base[BRICK];
    static double gathered[BRICK];
    const cvol_grid *grid = &s->volume->grid;
    const size_t *dims = grid->dims, size = cvol_type_size(grid->type);
    cvol_residual_coder *coder = cvol_residual_coder_create();
    cvol_bytes out = {0};
    double bits = 0;
    const int fraction = cvol_exact_fraction(cvol_exact_largest_sum(s->base));
    const double step = s->base->step;
    const cvol_residual_rule rule = cvol_residual_rule_for(grid->type, bound, step, s->min, s->max,
                                                           s->grain, s->largest);
    size_t bricks[3], total = 1;
    for (int a = 0; a < 3; a++)
        total *= bricks[a] = (dims[a] - 1) / 64 + 1;
    s->samples = 0;
    for (size_t b = first_brick(stride, total); b < total; b += stride) {
        const size_t begin[3] = {b % bricks[0] * 64, b / bricks[0] % bricks[1] * 64,
                                 b / bricks[0] / bricks[1] * 64};
        size_t end[3];
        cvol_residual_brick brick = {.base = base, .which = which};
        for (int a = 0; a < 3; a++) {
            end[a] = begin[a] + 64 < dims[a] ? begin[a] + 64 : dims[a];
            brick.size[a] = end[a] - begin[a];
        }
        s->samples += (double)(brick.size[0] * brick.size[1] * brick.size[2]);
        cvol_mask_get(which, s->mask, begin, end);
        for (size_t z = 0; z < brick.size[2]; z++)
            for (size_t y = 0; y < brick.size[1]; y++)
                memcpy((uint8_t *)gathered + size * brick.size[0] * (y + brick.size[1] * z),
                       (const uint8_t *)s->volume->data +
                           size * (begin[0] + dims[0] * (begin[1] + y + dims[1] * (begin[2] + z))),
                       size * brick.size[0]);
        double *scratch = cvol_allocate(cvol_exact_scratch(s->base, begin, end), sizeof *scratch);
        cvol_exact_box(base, scratch, s->base, fraction, begin, end);
        free(scratch);
        if (cvol_residual_encode(coder, &out, &rule, bound, tables, gathered, &brick, counts))
            training_fail("a brick cannot be corrected");
        bits += 8 * (double)out.size;
    }
    cvol_bytes_free(&out);
    cvol_residual_coder_free(coder);
    return bits;
}

static void gather_counts(cvol_token_counts *sums, cvol_token_counts *counts, double bits)
{
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            sums->of[r][t] += (uint64_t)((double)counts->of[r][t] * 1e7 / (bits + 1000));
    memset(counts, 0, sizeof *counts);
}

static void note(operand *s, const char *name, double bound, double step, double bits)
{
    const double all = (double)cvol_grid_samples(&s->volume->grid), samples = s->samples;
    printf("%-22.22s bound %9.3g step %9.3g: base %8.4f corrections %8.4f bits a sample, together "
           "%.0f bytes\n",
           name, bound, step, s->bits / s->samples, bits / s->samples,
           (s->bits + bits) / samples * all / 8);
    fflush(stdout);
}

static void try_steps(operand *s, const char *name, const cvol_token_tables *tables,
                      cvol_token_counts *sums, cvol_token_counts *counts, size_t stride)
{
    const double range = s->max - s->min;
    const int is_integer = cvol_type_is_integer(s->volume->grid.type);
    const int bounds = getenv("BOUNDS") ? atoi(getenv("BOUNDS")) : 5;
    for (int k = 0; k < 8; k++) {
        const double step = is_integer ? ldexp(1, k) : range * ldexp(0.0625, -2 * k);
        if (is_integer && step > range / 4)
            break;
        make_base(s, step, tables, stride);
        const double bits = correct(s, 0, tables, counts, stride);
        note(s, name, 0, step, bits);
        if (k > 0 && k < 6)
            gather_counts(sums, counts, bits);
        memset(counts, 0, sizeof *counts);
        cvol_array_free(s->base);
    }
    for (int k = 0; k < bounds; k++) {
        const double bound = range * pow(10, -1 - k);
        if (is_integer && bound < 1)
            break;
        for (int j = 0; j < 3; j++) {
            const double step = (is_integer ? 2 * floor(bound) + 1 : 2 * bound) * (1 + 0.5 * j);
            make_base(s, step, tables, stride);
            const double bits = correct(s, bound, tables, counts, stride);
            note(s, name, bound, step, bits);
            gather_counts(sums, counts, bits);
            cvol_array_free(s->base);
        }
    }
}

int main(int argc, char **argv)
{
    if (argc < 4)
        training_fail("usage: train_residual IN.inc OUT.inc FILE ...");
    operand s = {.context = cvol_context_create()};
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_counts *counts = calloc(1, sizeof *counts), *sums = calloc(1, sizeof *sums);
    const size_t stride = (size_t)(getenv("STRIDE") ? atoi(getenv("STRIDE")) : 1);
    if (!s.context || !tables || !counts || !sums)
        training_fail("no memory");
    training_read_codes(tables, argv[1]);
    for (int f = 3; f < argc; f++)
        for (int lowest = 0; lowest < 2; lowest++) {
            char name[1024];
            snprintf(name, sizeof name, "%s", argv[f]);
            s.volume = training_read(s.context, name);
            find_mask(&s, lowest);
            if (!lowest || cvol_mask_samples(s.mask))
                try_steps(&s, strrchr(name, '/') ? strrchr(name, '/') + 1 : name, tables, sums,
                          counts, stride);
            cvol_mask_free(s.mask);
            free(s.filled);
            cvol_volume_free(s.volume);
        }
    for (int r = 0; r < CVOL_ROWS; r++)
        if (r < CVOL_ROW_RESIDUAL || r >= CVOL_ROW_INDEX)
            memset(sums->of[r], 0, sizeof sums->of[r]);
    training_fit_rows(tables, sums);
    training_write_codes(argv[2], "The codes of a row of tokens on each line.", tables, 0,
                         CVOL_ROWS);
    free(tables);
    free(counts);
    free(sums);
    cvol_context_free(s.context);
    return 0;
}
