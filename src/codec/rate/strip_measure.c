/* Measures strip by strip. */
#include "codec/rate/strip_measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/subbands.h"
#include "codec/quantize/coding.h"

enum { LAP_REACH = 2 };

/* A brick's bytes, and later its terms. */
typedef struct kept_brick {
    cvol_bytes subbands[CVOL_SUBBANDS];
    uint32_t *words;
    uint64_t terms;
    double squares[CVOL_SUBBANDS]; /* of its values */
    int code;
} kept_brick;

/* A strip whose bricks are kept. */
typedef struct kept_strip {
    size_t number; /* SIZE_MAX: none */
    int is_decoded;
    kept_brick *bricks;
} kept_strip;

struct cvol_strip_measure {
    cvol_array *array; /* with the terms of the kept strips that are decoded */
    const cvol_token_tables *tables;
    cvol_brick_sink next;
    cvol_team *team;
    cvol_strips strips;
    kept_strip *kept; /* strip number n in slot n % slots */
    size_t slots;
    cvol_distance sum;             /* of squares */
    double squares[CVOL_SUBBANDS]; /* of all values */
};

static size_t bricks_per_strip(const cvol_strip_measure *measure)
{
    return measure->strips.grid[0] * measure->strips.rows;
}

void cvol_strip_measure_free(cvol_strip_measure *measure)
{
    if (!measure)
        return;
    cvol_array_free(measure->array);
    for (size_t i = 0; measure->kept && i < measure->slots; i++) {
        kept_brick *bricks = measure->kept[i].bricks;
        for (size_t k = 0; bricks && k < bricks_per_strip(measure); k++) {
            for (int s = 0; s < CVOL_SUBBANDS; s++)
                cvol_bytes_free(&bricks[k].subbands[s]);
            free(bricks[k].words);
        }
        free(bricks);
    }
    free(measure->kept);
    free(measure);
}

static int make_slots(cvol_context *context, cvol_strip_measure *measure)
{
    /* A strip depends on the one before and on those of the last layer; all strips of a turn of a
     * team arrive before one of them is measured. */
    const size_t turn = measure->team ? (size_t)measure->team->size : 1;
    const size_t back = measure->strips.per_layer + (measure->strips.per_layer > 1);
    const size_t bytes = bricks_per_strip(measure) * sizeof(kept_brick);
    measure->slots = back + turn;
    measure->kept = cvol_allocate_zero(measure->slots, sizeof *measure->kept);
    if (!measure->kept)
        return cvol_fail_memory(context, measure->slots * sizeof *measure->kept, "strips");
    for (size_t i = 0; i < measure->slots; i++) {
        measure->kept[i].number = SIZE_MAX;
        measure->kept[i].bricks = cvol_allocate_zero(bricks_per_strip(measure), sizeof(kept_brick));
        if (!measure->kept[i].bricks)
            return cvol_fail_memory(context, bytes, "a strip");
    }
    return CVOL_OK;
}

int cvol_strip_measure_make(cvol_context *context, cvol_strip_measure **out,
                            const cvol_array *shape, double step, const cvol_token_tables *tables,
                            const cvol_brick_sink *sink, const cvol_slab_source *source)
{
    cvol_strip_measure *measure = cvol_allocate_zero(1, sizeof *measure);
    *out = measure;
    if (!measure)
        return cvol_fail_memory(context, sizeof *measure, "the measure");
    measure->strips = cvol_strips_of(source, shape);
    measure->tables = tables;
    measure->next = *sink;
    measure->team = source->team;
    int code = cvol_array_create(context, &measure->array, &shape->grid, shape->block);
    if (!code)
        code = cvol_coding_copy(context, measure->array, shape);
    if (!code) {
        cvol_array *array = measure->array;
        array->step = ldexp(step, -cvol_coding_of(shape)->true_length);
        array->offset = shape->offset;
        array->lapped = shape->lapped;
        array->error_bound.value_min = shape->error_bound.value_min;
        array->error_bound.value_max = shape->error_bound.value_max;
        code = make_slots(context, measure);
    }
    if (code) {
        cvol_strip_measure_free(measure);
        *out = NULL;
    }
    return code;
}

/* ---- strips that are kept ------------------------------------------------------------------ */

/* The strips on which a strip's samples depend: number - back, and itself. Returns their count. */
static int find_before(size_t back[4], const cvol_strip_measure *measure, size_t number)
{
    const size_t per_layer = measure->strips.per_layer;
    const int has_row = number % per_layer > 0, has_layer = number >= per_layer;
    int count = 0;
    if (has_row && has_layer)
        back[count++] = per_layer + 1;
    if (has_layer)
        back[count++] = per_layer;
    if (has_row)
        back[count++] = 1;
    back[count++] = 0;
    return count;
}

/* True if this process measures the strip, or one that depends on it. */
static int is_needed(const cvol_strip_measure *measure, size_t number)
{
    const size_t per_layer = measure->strips.per_layer;
    const int has_next = number % per_layer + 1 < per_layer;
    return cvol_team_does(measure->team, number) ||
           cvol_team_does(measure->team, number + per_layer) ||
           (has_next && (cvol_team_does(measure->team, number + 1) ||
                         cvol_team_does(measure->team, number + per_layer + 1)));
}

static kept_strip *kept_at(const cvol_strip_measure *measure, size_t number)
{
    return &measure->kept[number % measure->slots];
}

static int take(cvol_context *context, void *user, size_t brick,
                const cvol_span subbands[CVOL_SUBBANDS])
{
    cvol_strip_measure *measure = user;
    const size_t number = cvol_strip_of(&measure->strips, brick);
    if (is_needed(measure, number)) {
        kept_strip *strip = kept_at(measure, number);
        const cvol_strip place = cvol_strip_at(&measure->strips, number);
        size_t bricks[2];
        strip->is_decoded = strip->is_decoded && strip->number == number;
        strip->number = number;
        cvol_strip_bricks(bricks, &measure->strips, &place);
        kept_brick *to = &strip->bricks[brick - bricks[0]];
        for (int s = 0; s < CVOL_SUBBANDS; s++) {
            to->subbands[s].size = 0;
            cvol_bytes_append(&to->subbands[s], subbands[s].data, subbands[s].size);
            if (to->subbands[s].failed)
                return cvol_fail_memory(context, subbands[s].size, "a brick");
        }
    }
    return measure->next.take(context, measure->next.user, brick, subbands);
}

cvol_brick_sink cvol_strip_measure_sink(cvol_strip_measure *measure)
{
    return (cvol_brick_sink){take, measure};
}

/* Decodes a brick, and gives its terms to its blocks. */
static int decode_brick(cvol_strip_measure *measure, cvol_brick_coder *coder, kept_brick *kept,
                        size_t brick)
{
    cvol_array *array = measure->array;
    cvol_span spans[CVOL_SUBBANDS];
    cvol_brick_terms terms;
    free(kept->words);
    kept->words = NULL;
    if (!coder)
        return CVOL_ERROR_MEMORY;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        spans[s] = (cvol_span){kept->subbands[s].data, kept->subbands[s].size};
    const int code = cvol_brick_decode(coder, &terms, array, brick, spans, CVOL_SUBBANDS);
    if (code)
        return code;
    kept->words = malloc((terms.word_count + 1) * sizeof *kept->words);
    if (!kept->words)
        return CVOL_ERROR_MEMORY;
    memcpy(kept->words, terms.words, terms.word_count * sizeof *kept->words);
    kept->terms = terms.terms;
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    const uint32_t *words = kept->words;
    memset(kept->squares, 0, sizeof kept->squares);
    for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
        cvol_block *block = &array->block_table[cvol_brick_block_index(array, &box, i)];
        block->terms = words;
        words += block->words;
        cvol_block_find_low(block, array->block_log2);
        cvol_subband_squares(kept->squares, array, cvol_brick_block_index(array, &box, i));
    }
    return CVOL_OK;
}

static int decode_strip(cvol_context *context, cvol_strip_measure *measure, size_t number)
{
    kept_strip *strip = kept_at(measure, number);
    const cvol_strip place = cvol_strip_at(&measure->strips, number);
    size_t range[2];
    cvol_strip_bricks(range, &measure->strips, &place);
    const size_t count = range[1] - range[0];
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_brick_coder *coder = cvol_brick_coder_create(measure->tables);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++)
            strip->bricks[i].code = decode_brick(measure, coder, &strip->bricks[i], range[0] + i);
        cvol_brick_coder_free(coder);
    }
    for (size_t i = 0; i < count; i++) {
        if (strip->bricks[i].code == CVOL_ERROR_MEMORY)
            return cvol_fail_memory(context, (size_t)1 << 20, "a brick");
        if (strip->bricks[i].code)
            return cvol_fail(context, CVOL_ERROR_CORRUPT, "brick %zu does not decode again",
                             range[0] + i);
    }
    strip->is_decoded = 1;
    return CVOL_OK;
}

/* Decodes a strip, and those on which its first rows and slices depend. */
static int decode_needed(cvol_context *context, cvol_strip_measure *measure, size_t number)
{
    size_t back[4];
    const int count = find_before(back, measure, number);
    int code = CVOL_OK;
    for (int i = 0; i < count && !code; i++)
        if (!kept_at(measure, number - back[i])->is_decoded)
            code = decode_strip(context, measure, number - back[i]);
    return code;
}

static void add_brick(cvol_strip_measure *measure, uint64_t terms,
                      const double squares[CVOL_SUBBANDS])
{
    measure->array->coefficients += terms;
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        measure->squares[s] += squares[s];
}

/* The samples that can be compared after a strip. */
static cvol_box find_box(const cvol_strip_measure *measure, const cvol_strip *strip)
{
    const cvol_array *array = measure->array;
    const size_t reach = array->lapped ? LAP_REACH : 0;
    cvol_box box = cvol_strip_samples(array, strip);
    for (int a = 1; a < 3; a++) {
        box.begin[a] -= box.begin[a] ? reach : 0;
        box.end[a] -= box.end[a] < array->grid.dims[a] ? reach : 0;
    }
    return box;
}

static int is_empty(const cvol_box *box)
{
    return box->begin[1] >= box->end[1] || box->begin[2] >= box->end[2];
}

static size_t number_of(const cvol_strip_measure *measure, const cvol_strip *strip)
{
    return strip->layers[0] * measure->strips.per_layer + strip->rows[0] / measure->strips.rows;
}

/* ---- teams ------------------------------------------------------------------------------ */

/* What one process tells the others about a strip: this for each brick, then distances. */
typedef struct packed_brick {
    uint64_t terms;
    double squares[CVOL_SUBBANDS];
} packed_brick;

/* In front of them. */
typedef struct packed_strip {
    uint64_t bricks;
} packed_strip;

static int pack_strip(cvol_context *context, cvol_bytes *out, cvol_strip_measure *measure,
                      const cvol_slab *slab, const cvol_strip *strip)
{
    const size_t number = number_of(measure, strip);
    const kept_brick *bricks = kept_at(measure, number)->bricks;
    const cvol_box box = find_box(measure, strip);
    cvol_piece_distances pieces = {NULL, 0};
    size_t range[2];
    cvol_strip_bricks(range, &measure->strips, strip);
    const packed_strip head = {range[1] - range[0]};
    int code = decode_needed(context, measure, number);
    if (!code && !is_empty(&box))
        code = cvol_measure_pieces(context, &pieces, measure->array, slab, &box, NULL);
    cvol_bytes_append(out, &head, sizeof head);
    for (size_t i = 0; i < range[1] - range[0] && !code; i++) {
        packed_brick one = {.terms = bricks[i].terms};
        memcpy(one.squares, bricks[i].squares, sizeof one.squares);
        cvol_bytes_append(out, &one, sizeof one);
    }
    if (!code)
        cvol_bytes_append(out, pieces.of, pieces.count * sizeof *pieces.of);
    free(pieces.of);
    return !code && out->failed ? cvol_fail_memory(context, out->size, "a strip") : code;
}

/* Adds what a process has measured. */
static void add_strip(cvol_strip_measure *measure, const uint8_t *at, const uint8_t *end)
{
    packed_strip head;
    memcpy(&head, at, sizeof head);
    at += sizeof head;
    for (uint64_t i = 0; i < head.bricks; i++) {
        packed_brick one;
        memcpy(&one, at, sizeof one);
        at += sizeof one;
        add_brick(measure, one.terms, one.squares);
    }
    for (; at < end; at += sizeof(cvol_distance)) {
        cvol_distance one;
        memcpy(&one, at, sizeof one);
        cvol_distances_add(&measure->sum, &one, 1);
    }
}

static int measure_by_team(cvol_context *context, cvol_strip_measure *measure,
                           const cvol_slab *slab, const cvol_strip *strip)
{
    cvol_bytes own = {0};
    cvol_gathered all;
    int code = strip ? pack_strip(context, &own, measure, slab, strip) : CVOL_OK;
    code = cvol_team_gather(context, &all, measure->team, code, own.data, own.size);
    for (int rank = 0; rank < measure->team->size && !code; rank++) /* strip after strip */
        if (all.offsets[rank + 1] > all.offsets[rank])
            add_strip(measure, all.all + all.offsets[rank], all.all + all.offsets[rank + 1]);
    cvol_gathered_free(&all);
    cvol_bytes_free(&own);
    return code;
}

int cvol_strip_measure_after(cvol_context *context, void *user, const cvol_slab *slab,
                             const cvol_strip *strip)
{
    cvol_strip_measure *measure = user;
    if (measure->team)
        return measure_by_team(context, measure, slab, strip);
    const size_t number = number_of(measure, strip);
    const kept_brick *bricks = kept_at(measure, number)->bricks;
    const cvol_box box = find_box(measure, strip);
    size_t range[2];
    int code = decode_needed(context, measure, number);
    cvol_strip_bricks(range, &measure->strips, strip);
    for (size_t i = 0; i < range[1] - range[0] && !code; i++)
        add_brick(measure, bricks[i].terms, bricks[i].squares);
    if (!code && !is_empty(&box))
        code = cvol_measure_box(context, &measure->sum, measure->array, slab, &box, NULL);
    return code;
}

void cvol_strip_measure_report(const cvol_strip_measure *measure, cvol_array *array,
                               double subband_norm[CVOL_SUBBANDS])
{
    cvol_subband_norms_of(subband_norm, measure->squares, measure->array->step);
    cvol_distance distance = measure->sum;
    cvol_distance_finish(&distance, cvol_grid_samples(&array->grid));
    cvol_array_set_measured(array, &distance);
    cvol_array_set_bounds(array, &distance);
    array->coefficients = measure->array->coefficients;
}
