/* Sampled bricks. */
#include "codec/rate/sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/quantize/coding.h"

/* If bricks are smaller than 64^3, more are sampled, for the same number of samples. */
enum { MORE_MAX = 64, SAMPLED_BRICKS = 32, SAMPLED_LAYERS = 4, POINTS_MAX = 4096 };

struct cvol_sampler {
    size_t bricks[SAMPLED_BRICKS * MORE_MAX];
    size_t count, volume; /* volume: sample capacity of a brick */
    float *cells[2];      /* not lapped, lapped; NULL: not needed */
};

/* Point k of the sequence, on the grid of bricks. */
static size_t brick_at(int k, const size_t grid[3], int few_layers)
{
    static const double steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    size_t place[3];
    for (int a = 0; a < 3; a++) {
        const double turns = (k + 0.5) * steps[a];
        place[a] = (size_t)((turns - floor(turns)) * (double)grid[a]);
    }
    if (few_layers && grid[2] > SAMPLED_LAYERS)
        place[2] = (2 * ((size_t)k % SAMPLED_LAYERS) + 1) * grid[2] / (2 * SAMPLED_LAYERS);
    return place[0] + grid[0] * (place[1] + grid[1] * place[2]);
}

static int by_number(const void *a, const void *b)
{
    const size_t x = *(const size_t *)a, y = *(const size_t *)b;
    return (x > y) - (x < y);
}

/* Chooses different bricks, in order. */
static void choose_bricks(cvol_sampler *sampler, const cvol_array *shape, size_t most,
                          int few_layers)
{
    size_t grid[3];
    cvol_brick_grid(grid, shape);
    const size_t all = grid[0] * grid[1] * grid[2];
    const int points = POINTS_MAX * (int)(CVOL_BRICK_SAMPLES / cvol_brick_volume(shape));
    for (int k = 0; k < points && sampler->count < most && sampler->count < all; k++) {
        const size_t brick = all <= most ? (size_t)k : brick_at(k, grid, few_layers);
        size_t i = 0;
        while (i < sampler->count && sampler->bricks[i] != brick)
            i++;
        if (i == sampler->count)
            sampler->bricks[sampler->count++] = brick;
    }
    qsort(sampler->bricks, sampler->count, sizeof *sampler->bricks, by_number);
}

/* Transforms the bricks first .. end - 1, which lie in one strip, or anywhere if all samples are in
 * memory. */
static void gather(const cvol_sampler *sampler, const cvol_array *shape, const cvol_slab *slab,
                   size_t first, size_t end, float *scratch)
{
    cvol_array way = *shape;
    for (int lapped = 0; lapped < 2; lapped++) {
        way.lapped = lapped;
        for (size_t i = first; i < end && sampler->cells[lapped]; i++) {
            const cvol_brick_box box = cvol_brick_box_of(shape, sampler->bricks[i]);
            cvol_brick_gather(sampler->cells[lapped] + i * sampler->volume, scratch, slab, &way,
                              box.first, box.count);
        }
    }
}

static int read_bricks(cvol_context *context, const cvol_sampler *sampler, const cvol_array *shape,
                       const cvol_slab_source *source, float *scratch)
{
    const cvol_strips strips = cvol_strips_of(source, shape);
    int code = CVOL_OK;
    for (size_t i = 0, end; i < sampler->count && !code; i = end) {
        const size_t number = cvol_strip_of(&strips, sampler->bricks[i]);
        for (end = i + 1; end < sampler->count; end++)
            if (cvol_strip_of(&strips, sampler->bricks[end]) != number)
                break;
        const cvol_strip strip = cvol_strip_at(&strips, number);
        cvol_slab slab;
        code = cvol_slab_fetch_strip(context, &slab, source, shape, &strip);
        if (!code)
            gather(sampler, shape, &slab, i, end, scratch);
    }
    return code;
}

int cvol_sampler_make(cvol_context *context, cvol_sampler **out, const cvol_array *shape,
                      const cvol_slab_source *source, size_t most, int both)
{
    const size_t more = CVOL_BRICK_SAMPLES / cvol_brick_volume(shape);
    size_t all[3];
    cvol_sampler *sampler = cvol_allocate_zero(1, sizeof *sampler);
    cvol_array lapped = *shape;
    lapped.lapped = shape->lapped || both;
    cvol_brick_shape_blocks(all, shape);
    *out = sampler;
    if (!sampler)
        return cvol_fail_memory(context, sizeof *sampler, "the sampled bricks");
    sampler->volume = cvol_brick_volume(shape);
    choose_bricks(sampler, shape, more * (most < SAMPLED_BRICKS ? most : SAMPLED_BRICKS),
                  !source->whole);
    const size_t samples = sampler->count * sampler->volume;
    float *scratch = cvol_allocate(cvol_brick_scratch(&lapped, all), sizeof *scratch);
    int made = scratch != NULL;
    for (int way = 0; way < 2 && made; way++)
        if (both || way == (shape->lapped != 0))
            made = (sampler->cells[way] = cvol_allocate(samples, sizeof(float))) != NULL;
    const int code = made
                         ? read_bricks(context, sampler, shape, source, scratch)
                         : cvol_fail_memory(context, samples * sizeof(float), "the sampled bricks");
    free(scratch);
    if (code) {
        cvol_sampler_free(sampler);
        *out = NULL;
    }
    return code;
}

void cvol_sampler_free(cvol_sampler *sampler)
{
    if (!sampler)
        return;
    free(sampler->cells[0]);
    free(sampler->cells[1]);
    free(sampler);
}

double cvol_sampler_share(const cvol_sampler *sampler, const cvol_array *shape)
{
    double covered = 0;
    for (size_t i = 0; i < sampler->count; i++) {
        const cvol_brick_box box = cvol_brick_box_of(shape, sampler->bricks[i]);
        covered += (double)cvol_brick_box_blocks(&box);
    }
    return covered / (double)shape->block_count;
}

uint64_t cvol_sampler_inside(const cvol_sampler *sampler, const cvol_array *shape)
{
    uint64_t inside = 0;
    for (size_t i = 0; i < sampler->count; i++) {
        size_t size[3];
        cvol_brick_inside(size, shape, sampler->bricks[i]);
        inside += (uint64_t)size[0] * size[1] * size[2];
    }
    return inside;
}

const float *cvol_sampler_brick(const cvol_sampler *sampler, size_t i, int lapped, size_t *brick)
{
    *brick = sampler->bricks[i];
    return sampler->cells[lapped != 0] + i * sampler->volume;
}

size_t cvol_sampler_count(const cvol_sampler *sampler)
{
    return sampler->count;
}

/* The result of one brick. */
typedef struct sampled {
    uint64_t bytes;
    double error;
    int code;
} sampled;

/* The stride over bricks that takes about `most` of them. */
static size_t stride_of(const cvol_sampler *sampler, size_t most)
{
    return most && sampler->count > most ? sampler->count / most : 1;
}

/* Encodes bricks with dynamic scheduling. One thread at a time adds its tokens to the counts,
 * because counts are large; the order of sums does not matter. */
static void run(const cvol_sampler *sampler, sampled *results, cvol_token_counts *counts,
                const cvol_brick_recipe *recipe, size_t stride, int threads)
{
#pragma omp parallel num_threads(threads)
    {
        cvol_brick_maker *maker = cvol_brick_maker_create(recipe->shape);
        cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < sampler->count; i += stride) {
            const float *cells = sampler->cells[recipe->shape->lapped != 0] + i * sampler->volume;
            results[i].code = maker ? cvol_brick_make(maker, subbands, &results[i].error, recipe,
                                                      cells, sampler->bricks[i])
                                    : CVOL_ERROR_MEMORY;
            if (counts && !results[i].code) {
#pragma omp critical
                cvol_brick_maker_count(maker, counts);
            }
            for (int s = 0; s < CVOL_SUBBANDS; s++)
                results[i].bytes += subbands[s].size;
        }
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&subbands[s]);
        cvol_brick_maker_free(maker);
    }
}

int cvol_sampler_run(cvol_context *context, cvol_encode_result *out, cvol_token_counts *counts,
                     const cvol_sampler *sampler, const cvol_array *shape,
                     const cvol_token_tables *tables, const cvol_chooser_options *options,
                     size_t most)
{
    const size_t stride = stride_of(sampler, most);
    cvol_token_costs *costs = malloc(sizeof *costs);
    sampled *results = calloc(sampler->count + 1, sizeof *results);
    int code = CVOL_OK;
    *out = (cvol_encode_result){0};
    if (!costs || !results) {
        free(costs);
        free(results);
        return cvol_fail_memory(context, sizeof *costs, "the coder's tables");
    }
    if (counts)
        memset(counts, 0, sizeof *counts);
    cvol_token_costs_set(costs, tables);
    const cvol_brick_recipe recipe = {shape, tables, costs, *options, NULL, NULL};
    run(sampler, results, counts, &recipe, stride, cvol_context_threads(context));
    free(costs);
    for (size_t i = 0; i < sampler->count && !code; i += stride) {
        code = cvol_brick_check(context, results[i].code);
        const cvol_brick_box box = cvol_brick_box_of(shape, sampler->bricks[i]);
        out->bytes += results[i].bytes;
        out->samples += cvol_brick_box_blocks(&box) * cvol_array_block_terms(shape);
        out->error += results[i].error * options->step * options->step;
    }
    free(results);
    return code;
}
