/* Converts dense samples to a brick's bytes: gathers cells, chooses values cell by cell, codes
 * them. */
#include "codec/brick/brick_samples.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_internal.h"
#include "codec/quantize/split_extension.h"
#include "codec/quantize/split_fast.h"
#include "transform/block.h"

struct cvol_brick_maker {
    float *cells, *scratch, *coefficients;
    cvol_cell_chooser *chooser;
    cvol_split_fast *fast;
    cvol_brick_coder *coder;
    uint32_t *words; /* terms of the last brick, if the recipe has `kept` */
    size_t word_count, word_capacity, terms;
};

cvol_brick_maker *cvol_brick_maker_create(const cvol_array *shape)
{
    size_t all[3];
    cvol_brick_shape_blocks(all, shape);
    cvol_brick_maker *maker = cvol_allocate_zero(1, sizeof *maker);
    if (!maker)
        return NULL;
    maker->cells = cvol_allocate(cvol_brick_volume(shape), sizeof *maker->cells);
    maker->scratch = cvol_allocate(cvol_brick_scratch(shape, all), sizeof *maker->scratch);
    maker->coefficients = cvol_allocate(2 * CVOL_SUB_BLOCK_SAMPLES_MAX,
                                        sizeof *maker->coefficients);
    maker->chooser = cvol_cell_chooser_create();
    maker->fast = cvol_split_fast_create();
    maker->coder = cvol_brick_coder_create(NULL);
    if (maker->cells && maker->scratch && maker->coefficients && maker->chooser && maker->fast &&
        maker->coder)
        return maker;
    cvol_brick_maker_free(maker);
    return NULL;
}

void cvol_brick_maker_free(cvol_brick_maker *maker)
{
    if (!maker)
        return;
    free(maker->cells);
    free(maker->scratch);
    free(maker->coefficients);
    cvol_cell_chooser_free(maker->chooser);
    cvol_split_fast_free(maker->fast);
    free(maker->words);
    cvol_brick_coder_free(maker->coder);
    free(maker);
}

/* Keeps the fast choice's values as terms of a block; returns 0 when memory is short. */
static int keep_terms(cvol_brick_maker *maker, cvol_block *block, uint16_t split)
{
    const size_t need = maker->word_count + 2 * (size_t)CVOL_CELL_SAMPLES;
    if (need > maker->word_capacity) {
        uint32_t *words = realloc(maker->words, 2 * need * sizeof *words);
        if (!words)
            return 0;
        maker->words = words;
        maker->word_capacity = 2 * need;
    }
    block->split = split;
    block->words = cvol_split_fast_terms(maker->fast, maker->words + maker->word_count,
                                         &maker->terms);
    maker->word_count += block->words;
    return 1;
}

/* Codes a cell of 16^3. Returns CVOL_OK, CVOL_ERROR_MEMORY, or CVOL_ERROR_TARGET if a value exceeds
 * the limit. */
static int code_cell(cvol_brick_maker *maker, double *error, const cvol_brick_recipe *recipe,
                     const float *samples, const int inside[3], const size_t place[3],
                     cvol_block *block)
{
    cvol_cell_choice choice;
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const cvol_chooser_options *options = &recipe->options;
    if (options->split == CVOL_SPLIT_FAST) {
        cvol_split_fast_choose(maker->fast, &choice, samples, inside, options->step,
                               options->plain);
        if (block && !keep_terms(maker, block, choice.split))
            return CVOL_ERROR_MEMORY;
    } else {
        cvol_cell_choose(maker->chooser, &choice, samples, inside, &maker->coder->context, place,
                         recipe->costs, options);
    }
    *error += (double)choice.error;
    cvol_brick_put_split(maker->coder, place, choice.split);
    cvol_cell_list_sub_blocks(parts, choice.split);
    for (int p = 0; p < choice.parts; p++) {
        int at[3];
        if (!choice.used[p])
            return CVOL_ERROR_TARGET;
        cvol_sub_block_place(at, &parts[p], place, CVOL_CELL);
        const int size_class = cvol_size_class(parts[p].side);
        const cvol_scan *scan = cvol_brick_scan(&maker->coder->context, at, size_class);
        if (!scan) {
            cvol_brick_pass_sub_block(maker->coder, at, size_class);
            continue;
        }
        cvol_brick_put_sub_block(maker->coder, at, scan, choice.values[p], choice.used[p],
                                 options->trellis);
        if (options->trellis)
            cvol_brick_keep_scaled(maker->coder, choice.scaled[p], scan->count);
    }
    return CVOL_OK;
}

/* Does the same for a block of 8^3 or 32^3. */
static int code_block(cvol_brick_maker *maker, double *error, const cvol_brick_recipe *recipe,
                      const float *samples, const size_t place[3])
{
    const int B = recipe->shape->block, size_class = cvol_size_class(B);
    const cvol_scan *scan = cvol_sub_block_scan_of(size_class);
    const cvol_sub_block part = {.side = B};
    cvol_brick_coder *coder = maker->coder;
    float *scaled = maker->coefficients + CVOL_SUB_BLOCK_SAMPLES_MAX;
    int at[3];
    cvol_sub_block_place(at, &part, place, B);
    cvol_block_forward(maker->coefficients, samples, B);
    for (int i = 0; i < scan->count; i++)
        scaled[i] = maker->coefficients[scan->entries[i].place] * (float)(1 / recipe->options.step);
    const cvol_sub_block_context context = cvol_sub_block_context_of(&coder->context, at, scan);
    const cvol_sub_block_choice choice = cvol_sub_block_choose(
        coder->scanned, scaled, scan, recipe->costs, &context, recipe->options.plain,
        coder->scatter);
    if (!choice.used)
        return CVOL_ERROR_TARGET;
    *error += (double)choice.error;
    cvol_brick_put_sub_block(coder, at, scan, coder->scanned, choice.used, 0);
    return CVOL_OK;
}

const float *cvol_brick_cells(cvol_brick_maker *maker, const cvol_array *shape,
                              const cvol_slab *slab, size_t brick)
{
    const cvol_brick_box box = cvol_brick_box_of(shape, brick);
    cvol_brick_gather(maker->cells, maker->scratch, slab, shape, box.first, box.count);
    return maker->cells;
}

cvol_brick_terms cvol_brick_maker_terms(const cvol_brick_maker *maker)
{
    return (cvol_brick_terms){maker->words, maker->word_count, maker->terms};
}

void cvol_brick_maker_count(const cvol_brick_maker *maker, cvol_token_counts *counts)
{
    cvol_brick_coder_count(maker->coder, counts);
}

int cvol_brick_make(cvol_brick_maker *maker, cvol_bytes subbands[CVOL_SUBBANDS], double *error,
                    const cvol_brick_recipe *recipe, const float *cells, size_t brick)
{
    const cvol_array *shape = recipe->shape;
    const cvol_brick_box box = cvol_brick_box_of(shape, brick);
    const size_t samples = cvol_array_block_terms(shape);
    maker->coder->tables = recipe->tables;
    if (!cvol_brick_start(maker->coder, shape, &box))
        return CVOL_ERROR_MEMORY;
    *error = 0;
    maker->word_count = maker->terms = 0;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        size_t place[3];
        cvol_brick_box_place(place, &box, i);
        const float *block = cells + i * samples;
        cvol_block *kept = recipe->kept
                               ? &recipe->kept->block_table[cvol_brick_block_index(shape, &box, i)]
                               : NULL;
        int code, inside[3];
        if (shape->block == CVOL_CELL) {
            cvol_cell_find_inside(inside, shape->grid.dims,
                                  (const size_t[3]){box.first[0] + place[0],
                                                    box.first[1] + place[1],
                                                    box.first[2] + place[2]});
            code = code_cell(maker, error, recipe, block, inside, place, kept);
        } else {
            code = code_block(maker, error, recipe, block, place);
        }
        if (code)
            return code;
    }
    if (recipe->counts)
        cvol_brick_maker_count(maker, recipe->counts);
    *error += cvol_brick_choose_again(maker->coder, recipe->costs);
    return cvol_brick_finish(maker->coder, subbands) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

int cvol_brick_check(cvol_context *context, int code)
{
    if (code == CVOL_ERROR_TARGET)
        return cvol_fail(context, code,
                         "coefficients are too large for so fine a step: ask for less quality, or "
                         "for lossless compression");
    return code == CVOL_ERROR_MEMORY ? cvol_fail_memory(context, (size_t)4 << 20, "a brick") : code;
}
