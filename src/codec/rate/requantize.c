/* Requantizes terms brick by brick. */
#include "codec/rate/requantize.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_internal.h"
#include "codec/brick/brick_team.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/rd_choice.h"
#include "codec/quantize/trellis.h"
#include "codec/quantize/trellis_states.h"
#include "codec/quantize/true_length.h"

enum { BRICKS_PER_THREAD = 16 };

/* One thread's memory. */
typedef struct requantiser {
    cvol_brick_coder *coder;
    float *coefficients;   /* of a block, by place; zero between blocks */
    float *scaled;         /* of a sub-block, in scan order */
    int32_t *values;       /* of a cell that crosses the volume's end, by place; zero between
                              cells */
    cvol_trellis *trellis; /* for arrays with trellis quantization */
    cvol_token_counts counts;
} requantiser;

/* A coded brick. */
typedef struct coded_brick {
    cvol_bytes subbands[CVOL_SUBBANDS];
    double error; /* in steps squared */
    int code;
} coded_brick;

typedef struct requantising {
    const cvol_array *array;
    double step;
    cvol_token_costs costs;
    requantiser *threads;
    int thread_count;
    coded_brick *bricks;
    size_t room;
} requantising;

/* ---- coefficients --------------------------------------------------------------------------- */

/* Writes a block's coefficients to their places, in units of the new step; or clears them. */
static void spread(float *coefficients, const cvol_block *block, int block_log2, double share)
{
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        coefficients[place] = (float)(share * value);
    }
}

/* The factor from terms to coefficients. */
static double coefficient_share(const requantising *all)
{
    return all->array->step / all->step * (cvol_coding_of(all->array)->trellis ? 0.5 : 1);
}

/* Converts terms to the stored true-length coefficients of a cell that crosses the volume's end. */
static void to_true_length(float *coefficients, const int inside[3], uint16_t split)
{
    double cell[CVOL_CELL_SAMPLES];
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        cell[i] = (double)coefficients[i];
    cvol_true_length_from_terms(cell, inside, split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        coefficients[i] = (float)cell[i];
}

/* ---- cells that cross the volume's end ------------------------------------------------------- */

/* Writes the values of a sub-block's indices by place. */
static void note_values(int32_t *values, const cvol_scan *scan, const int32_t *indices, int used,
                        int trellis)
{
    int state = 0;
    for (int i = 0; i < used; i++) {
        const uint32_t size = cvol_magnitude(indices[i]);
        int32_t value = (int32_t)size;
        if (trellis && i == 0)
            value = (int32_t)(2 * size);
        else if (trellis)
            value = (int32_t)cvol_trellis_magnitude(state, size);
        values[scan->entries[i].in_cell] = indices[i] < 0 ? -value : value;
        if (i)
            state = cvol_state_after[state][size & 1];
    }
}

/* Readers round the stored values of such a cell to terms (true_length.h). Returns the increase of
 * the cell's squared error by this rounding, in steps squared. Reads the cell's coefficients in
 * r->coefficients and its values in r->values. */
static double rounding_of_ends(requantiser *r, const cvol_array *array, const int inside[3],
                               uint16_t split)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
    double cell[CVOL_CELL_SAMPLES], before = 0, after = 0;
    const double unit = coding->trellis ? 2 : 1, finer = 1.0 / (1 << coding->true_length);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++) {
        const double off = (double)r->values[i] - unit * (double)r->coefficients[i];
        before += off * off;
        found[i / 64] |= (uint64_t)(r->values[i] != 0) << i % 64;
    }
    cvol_true_length_take(r->values, found, inside, split, coding->true_length);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        cell[i] = r->values[i] * finer;
    cvol_true_length_from_terms(cell, inside, split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++) {
        const double off = cell[i] - unit * (double)r->coefficients[i];
        after += off * off;
    }
    memset(r->values, 0, sizeof *r->values * CVOL_CELL_SAMPLES);
    return after - before;
}

/* Does the same for all such cells of a brick of the neural coder, which chooses its values
 * last. */
static double rounding_of_neural(requantiser *r, const requantising *all, const cvol_brick_box *box)
{
    const cvol_array *array = all->array;
    double sum = 0;
    for (size_t i = 0; i < cvol_brick_box_blocks(box); i++) {
        const cvol_block *block = &array->block_table[cvol_brick_block_index(array, box, i)];
        uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
        size_t place[3];
        int inside[3];
        cvol_brick_box_place(place, box, i);
        if (!cvol_brick_cell_inside(inside, &r->coder->context, place))
            continue;
        spread(r->coefficients, block, array->block_log2, coefficient_share(all));
        to_true_length(r->coefficients, inside, block->split);
        cvol_neural_cell(r->coder->neural, place, r->values, found);
        sum += rounding_of_ends(r, array, inside, block->split);
        memset(r->coefficients, 0, sizeof *r->coefficients * CVOL_CELL_SAMPLES);
    }
    return sum;
}

/* ---- a block --------------------------------------------------------------------------------- */

static void code_block(requantiser *r, coded_brick *out, const requantising *all,
                       const cvol_block *block, const size_t place[3])
{
    const cvol_array *array = all->array;
    const cvol_file_coding *coding = cvol_coding_of(array);
    cvol_brick_coder *coder = r->coder;
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_block_sub_blocks(parts, array->block, block->split);
    const int in_cell = array->block == CVOL_CELL;
    int inside[3];
    if (in_cell)
        cvol_brick_put_split(coder, place, block->split);
    spread(r->coefficients, block, array->block_log2, coefficient_share(all));
    const int ended = cvol_brick_cell_inside(inside, &coder->context, place) != NULL;
    if (ended)
        to_true_length(r->coefficients, inside, block->split);
    for (int p = 0; p < count; p++) {
        const cvol_sub_block *part = &parts[p];
        const int size_class = cvol_size_class(part->side);
        int at[3];
        cvol_sub_block_place(at, part, place, array->block);
        const cvol_scan *scan = cvol_brick_scan(&coder->context, at, size_class);
        if (!scan) {
            cvol_brick_pass_sub_block(coder, at, size_class);
            continue;
        }
        const int first = part->first[0] +
                          CVOL_CELL * (part->first[1] + CVOL_CELL * part->first[2]);
        for (int i = 0; i < scan->count; i++)
            r->scaled[i] = r->coefficients[in_cell ? first + scan->entries[i].in_cell
                                                   : scan->entries[i].place];
        const cvol_sub_block_context context = cvol_sub_block_context_of(&coder->context, at, scan);
        const cvol_sub_block_choice choice =
            coding->trellis ? cvol_trellis_choose(r->trellis, coder->scanned, r->scaled, scan,
                                                  &all->costs, &context, coder->scatter)
                            : cvol_sub_block_choose(coder->scanned, r->scaled, scan, &all->costs,
                                                    &context, 0, coder->scatter);
        if (!choice.used) { /* terms are within the limit already, so a coarser step's are too */
            out->code = CVOL_ERROR_TARGET;
            break;
        }
        out->error += (double)choice.error * (coding->trellis ? 4 : 1);
        cvol_brick_put_sub_block(coder, at, scan, coder->scanned, choice.used, coding->trellis);
        if (coding->trellis)
            cvol_brick_keep_scaled(coder, r->scaled, scan->count);
        if (ended && !coding->neural)
            note_values(r->values + first, scan, coder->scanned, choice.used, coding->trellis);
    }
    if (ended && !coding->neural)
        out->error += rounding_of_ends(r, array, inside, block->split);
    if (coding->true_length)
        memset(r->coefficients, 0, sizeof *r->coefficients * CVOL_CELL_SAMPLES);
    else
        spread(r->coefficients, block, array->block_log2, 0);
}

static void code_brick(requantiser *r, coded_brick *out, const requantising *all, size_t brick)
{
    const cvol_brick_box box = cvol_brick_box_of(all->array, brick);
    out->error = 0;
    out->code = CVOL_OK;
    if (!cvol_brick_start(r->coder, all->array, &box))
        out->code = CVOL_ERROR_MEMORY;
    for (size_t i = 0; i < cvol_brick_box_blocks(&box) && !out->code; i++) {
        size_t place[3];
        cvol_brick_box_place(place, &box, i);
        code_block(r, out, all,
                   &all->array->block_table[cvol_brick_block_index(all->array, &box, i)], place);
    }
    if (!out->code)
        out->error += cvol_brick_choose_again(r->coder, &all->costs);
    if (!out->code && !cvol_brick_finish(r->coder, out->subbands))
        out->code = CVOL_ERROR_MEMORY;
    if (!out->code && cvol_coding_of(all->array)->neural && cvol_coding_of(all->array)->true_length)
        out->error += rounding_of_neural(r, all, &box);
    cvol_brick_coder_count(r->coder, &r->counts);
}

/* ---- all bricks ------------------------------------------------------------------------------ */

static void free_all(requantising *all)
{
    for (int t = 0; all->threads && t < all->thread_count; t++) {
        cvol_brick_coder_free(all->threads[t].coder);
        free(all->threads[t].coefficients);
        free(all->threads[t].scaled);
        free(all->threads[t].values);
        cvol_trellis_free(all->threads[t].trellis);
    }
    for (size_t i = 0; all->bricks && i < all->room; i++)
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&all->bricks[i].subbands[s]);
    free(all->threads);
    free(all->bricks);
    free(all);
}

static requantising *make_all(cvol_context *context, const cvol_array *array,
                              cvol_coarseness coarseness, const cvol_token_tables *tables)
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    requantising *all = cvol_allocate_zero(1, sizeof *all);
    if (!all)
        return NULL;
    all->array = array;
    all->step = coarseness.step;
    all->thread_count = cvol_context_threads(context);
    all->room = (size_t)all->thread_count * BRICKS_PER_THREAD;
    cvol_token_costs_set(&all->costs, tables);
    cvol_token_costs_weigh(&all->costs, coarseness.weight);
    all->threads = cvol_allocate_zero((size_t)all->thread_count, sizeof *all->threads);
    all->bricks = cvol_allocate_zero(all->room, sizeof *all->bricks);
    int made = all->threads && all->bricks;
    for (int t = 0; made && t < all->thread_count; t++) {
        requantiser *r = &all->threads[t];
        r->coder = cvol_brick_coder_create(tables);
        r->coefficients = cvol_allocate_zero(CVOL_SUB_BLOCK_SAMPLES_MAX, sizeof *r->coefficients);
        r->scaled = cvol_allocate(CVOL_SUB_BLOCK_SAMPLES_MAX, sizeof *r->scaled);
        r->values = cvol_allocate_zero(CVOL_CELL_SAMPLES, sizeof *r->values);
        if (coding->trellis)
            r->trellis = cvol_trellis_create();
        made = r->coder && r->coefficients && r->scaled && r->values &&
               (r->trellis || !coding->trellis);
    }
    if (made)
        return all;
    free_all(all);
    return NULL;
}

static void code_bricks(requantising *all, size_t first, size_t count)
{
#pragma omp parallel num_threads(all->thread_count)
    {
        requantiser *r = NULL;
#pragma omp for schedule(static, 1)
        for (int t = 0; t < all->thread_count; t++)
            r = &all->threads[t];
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++)
            code_brick(r, &all->bricks[i], all, first + i);
    }
}

/* The receiver of the bricks of all processes. */
typedef struct taking {
    const cvol_brick_sink *sink;
    double step, *error;
} taking;

static int take_brick(cvol_context *context, void *user, size_t brick, double error,
                      const cvol_span subbands[CVOL_SUBBANDS])
{
    const taking *to = user;
    *to->error += error * to->step * to->step;
    return to->sink->take(context, to->sink->user, brick, subbands);
}

static int put_packet(cvol_context *context, void *user, size_t brick, double error,
                      const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)context;
    cvol_packet_put(user, brick, error, subbands);
    return CVOL_OK;
}

static int pass_bricks(cvol_context *context, const requantising *all, size_t first, size_t count,
                       cvol_packet_brick *take, void *user)
{
    int code = CVOL_OK;
    for (size_t i = 0; i < count && !code; i++) {
        const coded_brick *brick = &all->bricks[i];
        cvol_span spans[CVOL_SUBBANDS];
        if (brick->code == CVOL_ERROR_MEMORY)
            return cvol_fail_memory(context, (size_t)1 << 20, "a brick");
        if (brick->code)
            return cvol_fail(context, brick->code, "a step of %g is too fine for brick %zu",
                             all->step, first + i);
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            spans[s] = (cvol_span){brick->subbands[s].data, brick->subbands[s].size};
        code = take(context, user, first + i, brick->error, spans);
    }
    return code;
}

/* Codes bricks range[0] .. range[1] - 1. */
static int code_range(cvol_context *context, requantising *all, const size_t range[2],
                      cvol_packet_brick *take, void *user)
{
    int code = CVOL_OK;
    for (size_t first = range[0]; first < range[1] && !code; first += all->room) {
        const size_t left = range[1] - first, count = left < all->room ? left : all->room;
        code_bricks(all, first, count);
        code = pass_bricks(context, all, first, count, take, user);
        if (!code)
            code = cvol_report_progress(context, "requantising",
                                        (double)(first + count - range[0]) /
                                            (double)(range[1] - range[0]));
    }
    return code;
}

int cvol_requantise(cvol_context *context, double *error, cvol_token_counts *counts,
                    const cvol_array *array, cvol_coarseness coarseness,
                    const cvol_token_tables *tables, const cvol_brick_sink *sink)
{
    const cvol_share share = cvol_share_of(context, array);
    requantising *all = make_all(context, array, coarseness, tables);
    taking to = {sink, coarseness.step, error};
    cvol_bytes packet = {0};
    size_t range[2];
    *error = 0;
    if (!all)
        return cvol_fail_memory(context, (size_t)4 << 20, "the coder");
    cvol_share_bricks(range, &share, array);
    int code;
    if (share.team) {
        code = code_range(context, all, range, put_packet, &packet);
        code = cvol_team_pass_bricks(context, share.team, code, &packet, take_brick, &to);
    } else {
        code = code_range(context, all, range, take_brick, &to);
    }
    memset(counts, 0, sizeof *counts);
    for (int t = 0; t < all->thread_count; t++)
        for (int r = 0; r < CVOL_ROWS; r++)
            for (int k = 0; k < CVOL_TOKENS; k++)
                counts->of[r][k] += all->threads[t].counts.of[r][k];
    free_all(all);
    return cvol_team_add_counts(context, share.team, code, counts);
}
