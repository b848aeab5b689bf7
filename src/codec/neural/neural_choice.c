/* Viterbi's algorithm (1967) with the networks' costs. */
#include "codec/neural/neural_choice.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/elementary.h"
#include "base/memory.h"
#include "codec/neural/neural_internal.h"
#include "codec/quantize/trellis.h"
#include "codec/quantize/trellis_states.h"

enum { ROUNDS = 2, KINDS = CVOL_NEURAL_KINDS };
/* Coefficients below this fraction of twice the step become 0, without computing other costs. */
#define MIN_SHARE 0.2f
/* The weight of a bit, in squares of twice the step: the best of 0.06 to 0.105, by 0.01 dB. */
#define LAMBDA 0.085f

/* Bits of a coefficient's possible indices, by kind of state. */
typedef struct price {
    float zero[KINDS], even[KINDS], odd[KINDS], sign;
} price;

struct cvol_neural_chooser {
    price prices[CVOL_NEURAL_SAMPLES]; /* in the order of the brick's values */
    float scaled[CVOL_NEURAL_SAMPLES];
    /* For one sub-block: the best paths to the states after each coefficient. */
    float sums[CVOL_CELL_SAMPLES + 1][CVOL_STATES];
    int32_t index[CVOL_CELL_SAMPLES][CVOL_STATES];
    uint8_t from[CVOL_CELL_SAMPLES][CVOL_STATES];
};

cvol_neural_chooser *cvol_neural_chooser_create(void)
{
    return cvol_allocate(1, sizeof(cvol_neural_chooser));
}

void cvol_neural_chooser_free(cvol_neural_chooser *chooser)
{
    free(chooser);
}

void cvol_neural_chooser_keep(cvol_neural_chooser *chooser, int values, const float *scaled,
                              int count)
{
    memcpy(chooser->scaled + values, scaled, (size_t)count * sizeof *scaled);
}

/* ---- bits ----------------------------------------------------------------------------- */

static float bits_by_logit[2 * (CVOL_NEURAL_LOGIT_MAX + 1)]; /* of a 1, by logit + 2048 */
static pthread_once_t bits_once = PTHREAD_ONCE_INIT;

static void fill_bits(void)
{
    for (int i = 0; i < 2 * (CVOL_NEURAL_LOGIT_MAX + 1); i++)
        bits_by_logit[i] = (float)cvol_log2(1 + cvol_exp((2048 - i) / 256.0));
}

static float bits_of(int logit, int bit)
{
    return bits_by_logit[bit ? 2048 + logit : 2048 - logit];
}

/* Bits of an index's magnitude, without its sign. */
static float bits_of_size(const int16_t logits[CVOL_NEURAL_OUTPUTS], int shift, uint32_t size)
{
    const uint32_t high = size >> shift;
    float bits = (float)shift;
    for (uint32_t t = 0; t < CVOL_NEURAL_OUTPUTS && t < high; t++)
        bits += bits_of(logits[t], 1);
    if (high < CVOL_NEURAL_OUTPUTS)
        return bits + bits_of(logits[high], 0);
    return bits + 2 * (float)cvol_bit_length(high - (CVOL_NEURAL_OUTPUTS - 1)) - 1;
}

/* The nearest even and odd index, in states of even or odd values. */
static uint32_t nearest_even(float size, int odd_values)
{
    return 2 * (uint32_t)(0.5f * size + (odd_values ? 0.75f : 0.5f));
}
static uint32_t nearest_odd(float size, int odd_values)
{
    return 2 * (uint32_t)(0.5f * size + (odd_values ? 0.25f : 0)) + 1;
}

static float squared_error(float size, uint32_t index, int odd_values)
{
    const float error = size - (index ? (float)index - 0.5f * (float)odd_values : 0);
    return error * error;
}

static void price_value(price *to, const cvol_neural_brick *b, const cvol_neural_sub_block *p,
                        cvol_neural_context *l, float scaled)
{
    const float size = fabsf(scaled);
    int16_t logits[KINDS][CVOL_NEURAL_OUTPUTS];
    b->evaluate_kinds(logits, &cvol_neural_magnitude_pairs, l->x);
    for (int kind = 0; kind < KINDS; kind++) {
        const uint32_t even = nearest_even(size, kind & 1), odd = nearest_odd(size, kind & 1);
        to->zero[kind] = bits_of_size(logits[kind], l->shift, 0);
        to->even[kind] = even ? bits_of_size(logits[kind], l->shift, even) : INFINITY;
        to->odd[kind] = bits_of_size(logits[kind], l->shift, odd);
    }
    to->sign = 1;
    if (cvol_neural_has_faces(p) && size > MIN_SHARE) {
        int16_t x[CVOL_NEURAL_INPUTS] __attribute__((aligned(64))), out[CVOL_NEURAL_OUTPUTS];
        const uint32_t magnitude = (uint32_t)(2 * size + 0.5f);
        cvol_neural_sign_inputs(x, b, p, l, magnitude ? magnitude : 1);
        b->evaluate(out, &cvol_neural_sign_pairs, x, CVOL_NEURAL_SIGN_INPUTS);
        to->sign = bits_of(out[0], (scaled < 0) == (l->sum < 0));
    }
}

static void price_part(cvol_neural_chooser *c, cvol_neural_brick *b, cvol_neural_sub_block *p,
                       int subband)
{
    cvol_neural_position q;
    cvol_neural_view view;
    int end = cvol_neural_begin_sub_block(&q, p, subband);
    if (!end)
        return;
    if (cvol_neural_has_last(p, subband)) {
        q.last = p->used - 1;
        end = p->used;
    }
    cvol_neural_view_sub_block(&view, b, p, cvol_neural_known_cube(p, subband));
    while (q.index < end) {
        const int at = p->values + q.index;
        cvol_neural_context l;
        cvol_neural_context_at(&l, b, &view, p, &q);
        price_value(&c->prices[at], b, p, &l, c->scaled[at]);
        cvol_neural_note_value(b, p, &view, &q, &l, cvol_magnitude(b->values[at]),
                               b->values[at] < 0);
    }
    cvol_neural_end_sub_block(b, p, &q, subband);
}

/* Prices all coefficients of a brick. */
static void price_brick(cvol_neural_chooser *c, cvol_neural_brick *b, cvol_brick_context *context)
{
    cvol_neural_start_coding(b);
    cvol_neural_find_neighbours(b);
    for (int i = 0; i < b->parts; i++)
        cvol_neural_note_head(b, &b->part[i], context);
    for (int subband = 0; subband < CVOL_SUBBANDS; subband++)
        for (int i = 0; i < b->parts; i++)
            if (b->part[i].scan && !b->part[i].finished)
                price_part(c, b, &b->part[i], subband);
}

/* ---- paths ------------------------------------------------------------------------------ */

static int kind_of(int state)
{
    return (state & 1) + (state >= CVOL_STATES / 2 ? 2 : 0);
}

/* Extends a path from a state by an index, if it is the best path to the next state so far. */
CVOL_INLINE void go_on(cvol_neural_chooser *c, int i, int state, uint32_t index, float cost)
{
    const int to = cvol_state_after[state][index & 1];
    const float sum = c->sums[i][state] + cost;
    if (sum < c->sums[i + 1][to]) {
        c->sums[i + 1][to] = sum;
        c->index[i][to] = (int32_t)index;
        c->from[i][to] = (uint8_t)state;
    }
}

/* Extends all paths by coefficient i of a sub-block. */
static void step_on(cvol_neural_chooser *c, const price *w, float size, float lambda, int i)
{
    for (int s = 0; s < CVOL_STATES; s++)
        c->sums[i + 1][s] = INFINITY;
    for (int s = 0; s < CVOL_STATES; s++) {
        const int odd_values = s & 1, kind = kind_of(s);
        const uint32_t even = nearest_even(size, odd_values), odd = nearest_odd(size, odd_values);
        go_on(c, i, s, 0, size * size + lambda * w->zero[kind]);
        if (even)
            go_on(c, i, s, even,
                  squared_error(size, even, odd_values) + lambda * (w->even[kind] + w->sign));
        go_on(c, i, s, odd,
              squared_error(size, odd, odd_values) + lambda * (w->odd[kind] + w->sign));
    }
}

/* A possible end of a sub-block. */
typedef struct ending {
    double cost;
    int last, state; /* index of the last coefficient, and the state before it */
    uint32_t index;
} ending;

/* Tries the cheapest way to end with coefficient i; `more`: the fixed costs. The last index is
 * never 0, so its cost excludes the bit for that. */
static void try_ending(ending *best, const cvol_neural_chooser *c, const price *w, float size,
                       float lambda, int i, double more)
{
    for (int s = 0; s < CVOL_STATES; s++) {
        const int odd_values = s & 1, kind = kind_of(s);
        const float more_bits = cvol_log2f(1 - cvol_exp2f(-w->zero[kind]) + 1e-6f);
        for (int is_odd = 0; is_odd < 2; is_odd++) {
            const uint32_t index = is_odd ? nearest_odd(size, odd_values)
                                          : nearest_even(size, odd_values);
            const float bits = (is_odd ? w->odd[kind] : w->even[kind]) + more_bits + w->sign;
            const double cost = more +
                                (double)(c->sums[i][s] + squared_error(size, index, odd_values) +
                                         lambda * bits);
            if (index && cost < best->cost)
                *best = (ending){cost, i, s, index};
        }
    }
}

/* Finds the best end, at most the current one. */
static ending find_end(const cvol_neural_chooser *c, const cvol_neural_sub_block *p,
                       const cvol_token_costs *costs, float lambda)
{
    const float *length_row = costs->of[p->length_row], *scaled = c->scaled + p->values;
    const double all = cvol_sub_block_squares(scaled, 1, p->used);
    double tail = 0;
    ending best = {all + (double)(CVOL_LAMBDA_TRELLIS * length_row[0]), 0, 0, 0};
    for (int i = p->used - 1; i >= 1; i--) {
        const float size = fabsf(scaled[i]);
        const int last = p->scan->index[i];
        if (size > MIN_SHARE)
            try_ending(&best, c, &c->prices[p->values + i], size, lambda, i,
                       tail + (double)(CVOL_LAMBDA_TRELLIS *
                                       (length_row[cvol_bit_length((uint32_t)last)] +
                                        cvol_bits_of_last(costs, p->size_class, (uint32_t)last))));
        tail += (double)(size * size);
    }
    return best;
}

/* The squared error of a sub-block's variable coefficients, without the DC, in squares of twice the
 * step. */
static double error_of(const float *scaled, const int32_t *values, int count)
{
    double sum = 0;
    int state = 0;
    for (int i = 1; i < count; i++) {
        const uint32_t index = cvol_magnitude(values[i]);
        sum += (double)squared_error(fabsf(scaled[i]), index, cvol_state_is_odd(state));
        state = cvol_state_after[state][index & 1];
    }
    return sum;
}

/* Chooses for a sub-block; returns the increase of its error. */
static double choose_part(cvol_neural_chooser *c, cvol_neural_brick *b, cvol_neural_sub_block *p,
                          const cvol_token_costs *costs)
{
    const float lambda = LAMBDA * costs->weight;
    const float *scaled = c->scaled + p->values;
    int32_t *values = b->values + p->values;
    const int count = p->used;
    const double before = error_of(scaled, values, count);
    for (int s = 0; s < CVOL_STATES; s++)
        c->sums[1][s] = s ? INFINITY : 0;
    for (int i = 1; i < count; i++)
        step_on(c, &c->prices[p->values + i], fabsf(scaled[i]), lambda, i);
    const ending end = find_end(c, p, costs, lambda);
    int state = end.state;
    uint32_t index = end.index;
    memset(values + 1, 0, (size_t)(count - 1) * sizeof *values);
    for (int i = end.last; i >= 1; i--) {
        if (i < end.last) {
            const int behind = state;
            index = (uint32_t)c->index[i][behind];
            state = c->from[i][behind];
        }
        values[i] = scaled[i] < 0 ? -(int32_t)index : (int32_t)index;
    }
    p->used = end.last + 1;
    p->length = (uint8_t)cvol_sub_block_length(p->scan, p->used);
    return 4 * (error_of(scaled, values, count) - before);
}

double cvol_neural_choose_again(cvol_neural_chooser *c, cvol_neural_brick *b,
                                const cvol_token_costs *costs, cvol_brick_context *context)
{
    double error = 0;
    pthread_once(&bits_once, fill_bits);
    for (int round = 0; round < ROUNDS; round++) {
        price_brick(c, b, context);
        for (int i = 0; i < b->parts; i++)
            if (b->part[i].scan && b->part[i].used > 1)
                error += choose_part(c, b, &b->part[i], costs);
    }
    return error;
}
