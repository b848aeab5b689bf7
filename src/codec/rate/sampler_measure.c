/* Measures the share of the coefficients' error that the samples of sampled bricks show.
 *
 * A brick's decoded cells minus its own cells are the error before the post-filter. The code
 * filters it as if the brick were a volume: n cells along an axis have n - 1 filtered faces,
 * whereas the volume has N - 1 for N cells, and the filter's reduction is scaled accordingly.
 * Samples are then rounded, if they are integers, and clamped to the volume's range, which reduces
 * the error more if many samples are at its ends. This effect is measured on samples whose
 * neighbours are all in the brick. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/quantize/coding.h"
#include "codec/rate/sampler.h"
#include "transform/lap.h"

enum { SIDE = CVOL_BRICK_SIDE, BLOCK = 32 * 32 * 32 };

typedef struct brick_error {
    double coefficients, samples, filtered; /* squares */
    double clamped, unclamped; /* squares of samples inside, in the stored type and before */
    double faces;              /* the share of filtered faces in the brick relative to the volume */
    int code;
} brick_error;

static double squares(const float *samples, const size_t size[3])
{
    double sum = 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++) {
                const double value = (double)samples[x + SIDE * (y + SIDE * z)];
                sum += value * value;
            }
    return sum;
}

/* Writes decoded cells minus original cells, and the original cells, as cubes of 64^3. block: room
 * for one block. */
static void subtract(float *errors, float *own, float *block, const cvol_array *decoded,
                     const float *cells)
{
    const size_t B = (size_t)decoded->block, *blocks = decoded->blocks;
    for (size_t i = 0; i < decoded->block_count; i++) {
        const size_t at[3] = {i % blocks[0] * B, i / blocks[0] % blocks[1] * B,
                              i / blocks[0] / blocks[1] * B};
        const float *from = cells + i * B * B * B;
        cvol_block_evaluate(block, decoded, i);
        for (size_t z = 0; z < B; z++)
            for (size_t y = 0; y < B; y++) {
                const size_t line = at[0] + SIDE * (at[1] + y + SIDE * (at[2] + z));
                for (size_t x = 0; x < B; x++) {
                    own[line + x] = from[x + B * (y + B * z)];
                    errors[line + x] = block[x + B * (y + B * z)] - own[line + x];
                }
            }
    }
}

/* Sums squared errors after samples are rounded (or not) and clamped to 0 .. most, for samples at
 * least two from the brick's ends. */
static void clamp(brick_error *to, const float *errors, const float *own, const size_t size[3],
                  int rounds, float most)
{
    double clamped = 0, unclamped = 0;
    for (size_t z = 2; z + 2 < size[2]; z++)
        for (size_t y = 2; y + 2 < size[1]; y++)
            for (size_t x = 2; x + 2 < size[0]; x++) {
                const size_t i = x + SIDE * (y + SIDE * z);
                const float real = own[i] + errors[i], value = rounds ? rintf(real) : real;
                const float stored = value < 0 ? 0 : value > most ? most : value;
                const double left = (double)stored - (double)own[i], all = (double)errors[i];
                clamped += left * left;
                unclamped += all * all;
            }
    to->clamped = clamped;
    to->unclamped = unclamped;
}

/* Post-filters a cube as if it were a volume. */
static void filter(float *cube, const size_t size[3])
{
    const cvol_lap_box box = {.shape = {(int64_t)size[0], (int64_t)size[1], (int64_t)size[2]},
                              .size = {(int64_t)size[0], (int64_t)size[1], (int64_t)size[2]},
                              .stride = {1, SIDE, SIDE * SIDE},
                              .grid = 16};
    for (int a = 0; a < 3; a++)
        cvol_lap_post(cube, &box, a);
}

/* Decodes a brick's subbands into a separate array. */
static int decode(cvol_context *context, cvol_array **out, const cvol_array *shape,
                  const size_t size[3], const cvol_token_tables *tables,
                  const cvol_bytes subbands[CVOL_SUBBANDS], double step)
{
    const cvol_grid grid = cvol_grid_make(size[0], size[1], size[2], CVOL_FLOAT32);
    cvol_span spans[CVOL_SUBBANDS];
    cvol_brick_terms terms;
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    int code = coder ? cvol_array_create(context, out, &grid, shape->block)
                     : cvol_fail_memory(context, sizeof terms, "a sample");
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        spans[s] = (cvol_span){subbands[s].data, subbands[s].size};
    if (!code)
        code = cvol_coding_need(context, *out);
    if (!code) {
        cvol_file_coding *coding = cvol_coding_own(*out);
        coding->true_length = cvol_coding_of(shape)->true_length;
        coding->trellis = cvol_coding_of(shape)->trellis;
        (*out)->step = ldexp(step, -coding->true_length);
        code = cvol_brick_decode(coder, &terms, *out, 0, spans, CVOL_SUBBANDS);
    }
    if (!code) {
        uint32_t *words = cvol_allocate(terms.word_count, sizeof *words);
        code = words ? cvol_array_adopt_pool(context, *out, words, terms.word_count)
                     : cvol_fail_memory(context, terms.word_count * sizeof *words, "a sample");
        if (code)
            free(words);
        if (!code && terms.word_count)
            memcpy(words, terms.words, terms.word_count * sizeof *words);
        for (size_t i = 0; i < (*out)->block_count && !code; i++) {
            cvol_block *block = &(*out)->block_table[i];
            block->terms = words;
            words += block->words;
            cvol_block_find_low(block, shape->block_log2);
        }
    }
    cvol_brick_coder_free(coder);
    return code;
}

static double face_share(const cvol_array *shape, const size_t size[3])
{
    double share = 0, all = 0;
    for (int a = 0; a < 3; a++) {
        const double cells = (double)((size[a] - 1) / 16 + 1), N = (double)shape->blocks[a];
        share += (cells - 1) / cells;
        all += (N - 1) / N;
    }
    return all > 0 ? share / all : 0;
}

/* errors: room for two cubes and a block. */
static brick_error measure(cvol_context *context, cvol_brick_maker *maker, float *errors,
                           const cvol_brick_recipe *recipe, const float *cells, size_t brick)
{
    brick_error result = {0};
    cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
    cvol_array *decoded = NULL;
    float *own = errors + CVOL_BRICK_SAMPLES;
    size_t size[3];
    cvol_array shape = *recipe->shape; /* terms do not depend on the coder */
    cvol_file_coding coding = *cvol_coding_of(recipe->shape);
    cvol_brick_recipe fast = *recipe;
    coding.neural = 0;
    shape.coding = &coding.base;
    fast.shape = &shape;
    cvol_brick_inside(size, recipe->shape, brick);
    result.code = cvol_brick_make(maker, subbands, &result.coefficients, &fast, cells, brick);
    result.coefficients *= recipe->options.step * recipe->options.step;
    if (!result.code)
        result.code = decode(context, &decoded, recipe->shape, size, recipe->tables, subbands,
                             recipe->options.step);
    if (!result.code) {
        subtract(errors, own, own + CVOL_BRICK_SAMPLES, decoded, cells);
        result.samples = result.filtered = squares(errors, size);
        if (recipe->shape->lapped) {
            filter(errors, size);
            filter(own, size);
            result.filtered = squares(errors, size);
            result.faces = face_share(recipe->shape, size);
        }
        const cvol_error_bound *error_bound = &recipe->shape->error_bound;
        clamp(&result, errors, own, size, cvol_type_is_integer(recipe->shape->grid.type),
              (float)(error_bound->value_max - error_bound->value_min));
    }
    cvol_array_free(decoded);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_free(&subbands[s]);
    return result;
}

int cvol_sampler_measure(cvol_context *context, double *share, const cvol_sampler *sampler,
                         const cvol_array *shape, const cvol_token_tables *tables,
                         const cvol_chooser_options *options, cvol_token_counts *counts,
                         size_t most)
{
    cvol_token_costs *costs = malloc(sizeof *costs);
    cvol_brick_maker *maker = cvol_brick_maker_create(shape);
    float *errors = cvol_allocate(2 * CVOL_BRICK_SAMPLES + BLOCK, sizeof *errors);
    const size_t count = cvol_sampler_count(sampler);
    const size_t stride = count / most ? count / most : 1;
    double coefficients = 0, samples = 0, clamped = 0, unclamped = 0;
    int code = costs && maker && errors
                   ? CVOL_OK
                   : cvol_fail_memory(context, CVOL_BRICK_SAMPLES * sizeof *errors, "a brick");
    if (!code)
        cvol_token_costs_set(costs, tables);
    if (counts)
        memset(counts, 0, sizeof *counts);
    for (size_t i = 0; i < count && !code; i += stride) {
        const cvol_brick_recipe recipe = {shape, tables, costs, *options, counts, NULL};
        size_t brick;
        const float *cells = cvol_sampler_brick(sampler, i, shape->lapped, &brick);
        const brick_error found = measure(context, maker, errors, &recipe, cells, brick);
        code = found.code;
        coefficients += found.coefficients;
        clamped += found.clamped;
        unclamped += found.unclamped;
        samples += found.faces > 0 ? found.samples - (found.samples - found.filtered) / found.faces
                                   : found.filtered;
    }
    code = cvol_brick_check(context, code);
    *share = coefficients > 0 && samples > 0 ? samples / coefficients : 1;
    if (unclamped > 0)
        *share *= clamped / unclamped;
    free(costs);
    free(errors);
    cvol_brick_maker_free(maker);
    return code;
}
