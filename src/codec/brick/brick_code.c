/* Encodes and decodes one brick. */
#include "codec/brick/brick_code.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/brick/brick_internal.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/trellis_states.h"

/* Tokens of a cell's split. */
enum { SPLIT_NONE, SPLIT_OCTANTS, SPLIT_MIXED, SPLIT_FOURS };

/* ---- a coder ---------------------------------------------------------------------------- */

cvol_brick_coder *cvol_brick_coder_create(const cvol_token_tables *tables)
{
    cvol_brick_coder *coder = cvol_allocate_zero(1, sizeof *coder);
    if (coder)
        coder->tables = tables;
    return coder;
}

void cvol_brick_coder_free(cvol_brick_coder *coder)
{
    if (!coder)
        return;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_token_writer_free(&coder->writers[s]);
    cvol_true_length_scans_clear(&coder->context.scans);
    cvol_neural_free(coder->neural);
    cvol_neural_chooser_free(coder->neural_chooser);
    free(coder->words);
    free(coder);
}

/* ---- encoding --------------------------------------------------------------------------- */

/* Starts the neural coder too, if the array uses it; returns 0 when memory is short. */
static int start_neural(cvol_brick_coder *coder, const cvol_array *array, const cvol_brick_box *box)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    coder->is_neural = coding->neural;
    if (!coding->neural)
        return 1;
    if (!coder->neural)
        coder->neural = cvol_neural_create();
    if (coder->neural)
        cvol_neural_start(coder->neural, array, box);
    return coder->neural != NULL;
}

int cvol_brick_start(cvol_brick_coder *coder, const cvol_array *array, const cvol_brick_box *box)
{
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_token_writer_start(&coder->writers[s]);
    if (cvol_coding_of(array)->neural && !coder->neural_chooser &&
        !(coder->neural_chooser = cvol_neural_chooser_create()))
        return 0;
    return start_neural(coder, array, box) &&
           cvol_brick_context_start(&coder->context, array, box->first);
}

/* Writes tokens also for the neural coder: they are counted, and their costs serve the choice. */
void cvol_brick_put_sub_block(cvol_brick_coder *coder, const int at[3], const cvol_scan *scan,
                              const int32_t *values, int used, int trellis)
{
    const cvol_sub_block_context context = cvol_sub_block_context_of(&coder->context, at, scan);
    cvol_sub_block_encode(coder->writers, scan, &context, values, used, trellis, coder->scatter);
    cvol_sub_block_note(&coder->context, at, scan, values[0], cvol_sub_block_length(scan, used));
    if (coder->is_neural)
        coder->last_values = cvol_neural_put_sub_block(coder->neural, at, scan->size_class, scan,
                                                       values, used);
}

void cvol_brick_keep_scaled(cvol_brick_coder *coder, const float *scaled, int count)
{
    if (coder->is_neural)
        cvol_neural_chooser_keep(coder->neural_chooser, coder->last_values, scaled, count);
}

void cvol_brick_pass_sub_block(cvol_brick_coder *coder, const int at[3], int size_class)
{
    cvol_sub_block_note_unseen(&coder->context, at, size_class);
    if (coder->is_neural)
        cvol_neural_put_sub_block(coder->neural, at, size_class, NULL, NULL, 0);
}

void cvol_brick_put_split(cvol_brick_coder *coder, const size_t place[3], uint16_t split)
{
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    const int token = split == CVOL_CELL_WHOLE     ? SPLIT_NONE
                      : split == CVOL_CELL_OCTANTS ? SPLIT_OCTANTS
                      : split == CVOL_CELL_FOURS   ? SPLIT_FOURS
                                                   : SPLIT_MIXED;
    cvol_token_put(&coder->writers[0], cvol_split_row(&coder->context, cell), (uint32_t)token);
    if (token == SPLIT_MIXED)
        for (int half = 0; half < 2; half++)
            cvol_token_put(&coder->writers[0], CVOL_ROW_OCTANTS + half,
                           split >> (1 + 4 * half) & 15);
    cvol_split_note(&coder->context, cell, token);
    if (coder->is_neural)
        cvol_neural_put_split(coder->neural, place, split);
}

double cvol_brick_choose_again(cvol_brick_coder *coder, const cvol_token_costs *costs)
{
    return coder->is_neural ? cvol_neural_choose_again(coder->neural_chooser, coder->neural, costs,
                                                       &coder->context)
                            : 0;
}

int cvol_brick_finish(cvol_brick_coder *coder, cvol_bytes subbands[CVOL_SUBBANDS])
{
    int done = 1;
    if (coder->is_neural)
        return cvol_neural_finish(coder->neural, subbands, &coder->context);
    for (int s = 0; s < CVOL_SUBBANDS; s++) {
        subbands[s].size = 0;
        done &= cvol_token_writer_finish(&coder->writers[s], coder->tables, &subbands[s]);
    }
    return done;
}

/* Writes a block's terms to their places. */
static void spread_terms(cvol_brick_coder *coder, const cvol_block *block, int block_log2)
{
    const uint32_t *words = block->terms, *end = words + block->words;
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        coder->values[place] = value;
    }
}

static void unspread_terms(cvol_brick_coder *coder, const cvol_block *block, int block_log2)
{
    const uint32_t *words = block->terms, *end = words + block->words;
    while (words < end) {
        uint32_t place;
        cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        coder->values[place] = 0;
    }
}

static int first_place(const cvol_sub_block *part)
{
    return part->first[0] + CVOL_CELL * (part->first[1] + CVOL_CELL * part->first[2]);
}

/* Copies a sub-block's values into scan order; returns one past the last nonzero value, at least
 * 1. */
static int scan_part(cvol_brick_coder *coder, const cvol_sub_block *part, const cvol_scan *scan,
                     int in_cell)
{
    const int first = first_place(part);
    int used = 1;
    for (int i = 0; i < scan->count; i++) {
        const int place = in_cell ? first + scan->entries[i].in_cell : scan->entries[i].place;
        coder->scanned[i] = coder->values[place];
        used = coder->scanned[i] ? i + 1 : used;
    }
    return used;
}

/* Replaces a sub-block's values, in scan order, by their trellis indices; returns 0 if there are
 * none. */
static int find_indices(int32_t *values, int used)
{
    int state = 0;
    if (values[0] & 1)
        return 0;
    values[0] /= 2;
    for (int i = 1; i < used; i++) {
        const int64_t index = cvol_trellis_index(state, cvol_magnitude(values[i]));
        if (index < 0)
            return 0;
        values[i] = values[i] < 0 ? -(int32_t)index : (int32_t)index;
        state = cvol_state_after[state][index & 1];
    }
    return 1;
}

/* Writes a block's coded values to their places; returns 0 if no coded values give its terms. */
static int spread_coded(cvol_brick_coder *coder, const cvol_array *array, const cvol_block *block,
                        const size_t place[3])
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    int inside[3];
    if (block->words)
        spread_terms(coder, block, array->block_log2);
    return !coding->true_length || !block->words ||
           cvol_true_length_put(coder->values,
                                cvol_brick_cell_inside(inside, &coder->context, place),
                                block->split, coding->true_length);
}

static void unspread_coded(cvol_brick_coder *coder, const cvol_array *array,
                           const cvol_block *block)
{
    if (cvol_coding_of(array)->true_length)
        memset(coder->values, 0, sizeof *coder->values * CVOL_CELL_SAMPLES);
    else
        unspread_terms(coder, block, array->block_log2);
}

static void encode_block(cvol_brick_coder *coder, const cvol_array *array, const cvol_block *block,
                         const size_t place[3])
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_block_sub_blocks(parts, array->block, block->split);
    const int in_cell = array->block == CVOL_CELL;
    if (in_cell)
        cvol_brick_put_split(coder, place, block->split);
    spread_coded(coder, array, block, place);
    for (int p = 0; p < count; p++) {
        const int size_class = cvol_size_class(parts[p].side);
        int at[3];
        cvol_sub_block_place(at, &parts[p], place, array->block);
        const cvol_scan *scan = cvol_brick_scan(&coder->context, at, size_class);
        if (!scan) {
            cvol_brick_pass_sub_block(coder, at, size_class);
            continue;
        }
        coder->scanned[0] = 0;
        const int used = block->words ? scan_part(coder, &parts[p], scan, in_cell) : 1;
        if (coding->trellis)
            find_indices(coder->scanned, used);
        cvol_brick_put_sub_block(coder, at, scan, coder->scanned, used, coding->trellis);
    }
    unspread_coded(coder, array, block);
}

/* True if the block can be coded with the array's options: with true length, and with indices for
 * all sub-blocks. */
static int block_fits(cvol_brick_coder *coder, const cvol_array *array, const cvol_block *block,
                      const size_t place[3])
{
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_block_sub_blocks(parts, array->block, block->split);
    if (!block->words)
        return 1;
    int found = spread_coded(coder, array, block, place);
    for (int p = 0; p < count && found && cvol_coding_of(array)->trellis; p++) {
        int at[3];
        cvol_sub_block_place(at, &parts[p], place, array->block);
        const cvol_scan *scan = cvol_brick_scan(&coder->context, at,
                                                cvol_size_class(parts[p].side));
        if (scan)
            found = find_indices(coder->scanned,
                                 scan_part(coder, &parts[p], scan, array->block == CVOL_CELL));
    }
    unspread_coded(coder, array, block);
    return found;
}

int cvol_brick_fits(cvol_brick_coder *coder, const cvol_array *array, size_t brick)
{
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    if (!cvol_brick_context_start(&coder->context, array, box.first))
        return CVOL_ERROR_MEMORY;
    int found = 1;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box) && found; i++) {
        size_t place[3];
        cvol_brick_box_place(place, &box, i);
        found = block_fits(coder, array,
                           &array->block_table[cvol_brick_block_index(array, &box, i)], place);
    }
    return found;
}

int cvol_brick_encode(cvol_brick_coder *coder, cvol_bytes subbands[CVOL_SUBBANDS],
                      const cvol_array *array, size_t brick)
{
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    if (!cvol_brick_start(coder, array, &box))
        return 0;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        size_t place[3];
        cvol_brick_box_place(place, &box, i);
        encode_block(coder, array, &array->block_table[cvol_brick_block_index(array, &box, i)],
                     place);
    }
    return cvol_brick_finish(coder, subbands);
}

void cvol_brick_coder_count(const cvol_brick_coder *coder, cvol_token_counts *counts)
{
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_token_writer_count(&coder->writers[s], counts);
}

/* ---- decoding --------------------------------------------------------------------------- */

/* Decodes a cell's split; returns 0 if it is invalid. */
static int take_split(cvol_brick_coder *coder, cvol_token_reader *in, const size_t place[3],
                      uint16_t *split)
{
    const int cell[3] = {(int)place[0], (int)place[1], (int)place[2]};
    const uint32_t token = cvol_token_take(in, cvol_split_row(&coder->context, cell));
    *split = token == SPLIT_OCTANTS ? CVOL_CELL_OCTANTS
             : token == SPLIT_FOURS ? CVOL_CELL_FOURS
                                    : CVOL_CELL_WHOLE;
    if (token > SPLIT_FOURS)
        return 0;
    if (token == SPLIT_MIXED) {
        *split = CVOL_CELL_OCTANTS;
        for (int half = 0; half < 2; half++)
            *split |= (uint16_t)(cvol_token_take(in, CVOL_ROW_OCTANTS + half) << (1 + 4 * half));
    }
    cvol_split_note(&coder->context, cell, (int)token);
    return 1;
}

/* Appends the values, times 2^shift, as words in order of place, and clears them. *sum: of their
 * magnitudes; adds to the counts of words and terms. Returns 0 if a value is too large. */
static int take_terms(cvol_brick_coder *coder, int block_log2, int shift, uint64_t *sum,
                      uint32_t *words, size_t *terms)
{
    const int place_bits = cvol_place_bits(block_log2);
    const uint32_t most = (uint32_t)CVOL_VALUE_LIMIT >> shift;
    uint32_t *to = coder->words + coder->word_count;
    *sum = 0;
    for (int i = 0; i < 1 << (3 * block_log2 - 6); i++) {
        for (uint64_t bits = coder->found[i]; bits; bits &= bits - 1) {
            const uint32_t place = (uint32_t)(64 * i + __builtin_ctzll(bits));
            int32_t value = coder->values[place];
            if (__builtin_expect(cvol_magnitude(value) > most, 0))
                return 0;
            value *= 1 << shift;
            to += cvol_term_pack(to, place, value, place_bits);
            *sum += cvol_magnitude(value);
            (*terms)++;
            coder->values[place] = 0;
        }
        coder->found[i] = 0;
    }
    *words = (uint32_t)(to - (coder->words + coder->word_count));
    coder->word_count += *words;
    return 1;
}

static int reserve_words(cvol_brick_coder *coder, size_t more)
{
    if (coder->word_capacity - coder->word_count >= more)
        return 1;
    const size_t capacity = 2 * coder->word_capacity + more;
    uint32_t *words = realloc(coder->words, capacity * sizeof *words);
    if (!words)
        return 0;
    coder->words = words;
    coder->word_capacity = capacity;
    return 1;
}

static void put_value(cvol_brick_coder *coder, int place, int32_t value)
{
    coder->values[place] = value;
    if (value)
        coder->found[place / 64] |= UINT64_C(1) << place % 64;
}

static int decode_parts(cvol_brick_coder *coder, cvol_token_reader streams[CVOL_SUBBANDS],
                        int subbands, const cvol_array *array, uint16_t split,
                        const size_t place[3])
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    const int B = array->block;
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_block_sub_blocks(parts, B, split);
    for (int p = 0; p < count; p++) {
        const int size_class = cvol_size_class(parts[p].side);
        const cvol_sub_block_target target = {coder->values, coder->found, first_place(&parts[p]),
                                              B == CVOL_CELL, coding->trellis};
        int at[3], length;
        int32_t dc;
        cvol_sub_block_place(at, &parts[p], place, B);
        const cvol_scan *scan = cvol_brick_scan(&coder->context, at, size_class);
        if (!scan) {
            dc = cvol_sub_block_note_unseen(&coder->context, at, size_class);
            put_value(coder, target.first, dc * (1 + coding->trellis));
            continue;
        }
        const cvol_sub_block_context context = cvol_sub_block_context_of(&coder->context, at, scan);
        if (!cvol_sub_block_decode(streams, subbands, scan, &context, &target, &dc, &length,
                                   coder->scatter))
            return 0;
        cvol_sub_block_note(&coder->context, at, scan, dc, length);
    }
    return 1;
}

/* streams: unused if the neural coder has decoded the brick. */
static int decode_block(cvol_brick_coder *coder, cvol_brick_terms *out, cvol_array *array,
                        cvol_block *block, cvol_token_reader streams[CVOL_SUBBANDS], int subbands,
                        const size_t place[3])
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    const int B = array->block;
    uint64_t sum;
    int ended[3];
    block->split = CVOL_CELL_WHOLE;
    if (!reserve_words(coder, 2 * (size_t)B * (size_t)B * (size_t)B))
        return CVOL_ERROR_MEMORY;
    if (coding->neural)
        block->split = cvol_neural_cell(coder->neural, place, coder->values, coder->found);
    else if (B == CVOL_CELL && !take_split(coder, &streams[0], place, &block->split))
        return CVOL_ERROR_CORRUPT;
    if (!coding->neural && !decode_parts(coder, streams, subbands, array, block->split, place))
        return CVOL_ERROR_CORRUPT;
    const int *inside = coding->true_length ? cvol_brick_cell_inside(ended, &coder->context, place)
                                            : NULL;
    if (inside && !cvol_true_length_take(coder->values, coder->found, inside, block->split,
                                         coding->true_length))
        return CVOL_ERROR_CORRUPT;
    if (!take_terms(coder, array->block_log2, inside ? 0 : coding->true_length, &sum, &block->words,
                    &out->terms))
        return CVOL_ERROR_CORRUPT;
    /* No sample, and no intermediate value, exceeds this sum: it must fit into float. */
    return (double)sum * array->step < (double)FLT_MAX ? CVOL_OK : CVOL_ERROR_CORRUPT;
}

/* A damaged brick may leave any values behind. */
static void clear_scratch(cvol_brick_coder *coder)
{
    memset(coder->values, 0, sizeof coder->values);
    memset(coder->found, 0, sizeof coder->found);
    memset(coder->scatter, 0, sizeof coder->scatter);
}

static int all_ended(const cvol_token_reader streams[CVOL_SUBBANDS], int count)
{
    for (int s = 0; s < count; s++)
        if (!cvol_token_reader_ended(&streams[s]))
            return 0;
    return 1;
}

int cvol_brick_decode(cvol_brick_coder *coder, cvol_brick_terms *out, cvol_array *array,
                      size_t brick, const cvol_span subbands[CVOL_SUBBANDS], int count)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    cvol_token_reader streams[CVOL_SUBBANDS];
    int code = CVOL_OK;
    *out = (cvol_brick_terms){0};
    coder->word_count = 0;
    if (!cvol_brick_context_start(&coder->context, array, box.first))
        return CVOL_ERROR_MEMORY;
    if (coding->neural)
        code = start_neural(coder, array, &box)
                   ? cvol_neural_decode(coder->neural, &coder->context, subbands, count)
                   : CVOL_ERROR_MEMORY;
    for (int s = 0; s < count && !coding->neural; s++)
        cvol_token_reader_start(&streams[s], coder->tables, subbands[s].data, subbands[s].size);
    for (size_t i = 0; i < cvol_brick_box_blocks(&box) && !code; i++) {
        size_t place[3];
        cvol_brick_box_place(place, &box, i);
        code = decode_block(coder, out, array,
                            &array->block_table[cvol_brick_block_index(array, &box, i)], streams,
                            count, place);
    }
    if (!code && !coding->neural && !all_ended(streams, count))
        code = CVOL_ERROR_CORRUPT;
    if (code)
        clear_scratch(coder);
    out->words = coder->words;
    out->word_count = coder->word_count;
    return code;
}
