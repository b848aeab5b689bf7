/* The state of a brick while its coefficients are coded one after the other. */
#include <string.h>

#include "codec/neural/neural_internal.h"
#include "codec/quantize/trellis_states.h"

void cvol_neural_start_coding(cvol_neural_brick *b)
{
    const uint16_t half = 1 << 15;
    cvol_neural_curve fresh;
    memset(b->known, 0, sizeof b->known);
    memset(b->blur, 0, sizeof b->blur);
    memset(b->means, 0, sizeof b->means);
    memset(b->seen_count, 0, sizeof b->seen_count);
    for (int k = 0; k < CVOL_NEURAL_BUCKETS; k++)
        fresh.at[k] =
            cvol_logistic_probability[k == CVOL_NEURAL_BUCKETS - 1 ? 4095
                                                                   : k << CVOL_NEURAL_BUCKET_BITS];
    for (int k = 0; k < 3; k++) {
        for (int t = 0; t < CVOL_NEURAL_OUTPUTS; t++)
            b->states.above[t][k] = fresh;
        b->states.agrees[k][0] = b->states.agrees[k][1] = fresh;
    }
    for (int i = 0; i < CVOL_NEURAL_ESCAPES; i++)
        b->states.escape[i] = (cvol_probability){half, half};
}

int cvol_neural_has_faces(const cvol_neural_sub_block *p)
{
    for (int k = 0; k < CVOL_NEURAL_PLANES; k++)
        if (p->neighbours[k] != CVOL_NEURAL_NONE)
            return 1;
    return 0;
}

void cvol_neural_note_head(cvol_neural_brick *b, cvol_neural_sub_block *p,
                           cvol_brick_context *context)
{
    const int at[3] = {p->at[0], p->at[1], p->at[2]};
    if (!p->scan) {
        p->dc = cvol_sub_block_note_unseen(context, at, p->size_class);
        b->known[p->first] = 2 * p->dc;
        return;
    }
    const cvol_sub_block_context around = cvol_sub_block_context_of(context, at, p->scan);
    const int64_t difference = p->dc - around.prediction;
    const uint64_t number = (uint64_t)(difference < 0 ? -difference : difference);
    p->length_row = cvol_length_row(&around, p->size_class, number);
    p->around = (uint8_t)around.around;
    p->change = (uint8_t)cvol_neural_class((uint32_t)number);
    p->next = 1;
    p->state = 0;
    p->finished = !p->length;
    b->known[p->first] = 2 * p->dc;
    cvol_sub_block_note(context, at, p->scan, p->dc, p->length);
    cvol_neural_update_samples(b, p, 1);
}

/* ---- a sub-block's coefficients of a subband ------------------------------------------------- */

int cvol_neural_begin_sub_block(cvol_neural_position *q, const cvol_neural_sub_block *p,
                                int subband)
{
    const int end = p->scan->subband_end[subband];
    *q = (cvol_neural_position){
        .subband = subband, .index = p->next, .last = p->scan->count, .state = p->state};
    return end > p->next ? end : 0;
}

int cvol_neural_has_last(const cvol_neural_sub_block *p, int subband)
{
    return 1 << (p->length - 1) < cvol_subband_end(p->size_class, subband);
}

static int cube_of(const cvol_neural_sub_block *p, int subband)
{
    return p->side >> (CVOL_SUBBANDS - 1 - subband);
}

int cvol_neural_known_cube(const cvol_neural_sub_block *p, int subband)
{
    const int cube = cube_of(p, subband);
    return cube > 2 ? cube / 2 : 1;
}

void cvol_neural_note_value(cvol_neural_brick *b, cvol_neural_sub_block *p, cvol_neural_view *view,
                            cvol_neural_position *q, const cvol_neural_context *l, uint32_t size,
                            int negative)
{
    const uint32_t magnitude = cvol_trellis_magnitude(q->state, size);
    const int class = cvol_neural_class(magnitude);
    q->index++;
    q->state = cvol_state_after[q->state][size & 1];
    q->run += (16 * class - q->run) / 8;
    q->slow += (64 * class - q->slow) / 32;
    if (!size)
        return;
    const int32_t value = negative ? -(int32_t)magnitude : (int32_t)magnitude;
    const int *at = l->at;
    const int local = CVOL_NEURAL_ORIGIN + at[0] +
                      CVOL_NEURAL_PAD * (at[1] + CVOL_NEURAL_PAD * at[2]);
    b->known[p->first + at[0] + CVOL_NEURAL_SIDE * at[1] + CVOL_NEURAL_SLICE * at[2]] = value;
    view->sizes[local] = (uint16_t)(magnitude < CVOL_NEURAL_LIMIT ? magnitude : CVOL_NEURAL_LIMIT);
    view->classes[local] = (uint8_t) class;
    cvol_neural_subtract_known(view->level, view->slope, p->n, at, value, &cvol_neural_cosines);
}

void cvol_neural_end_sub_block(cvol_neural_brick *b, cvol_neural_sub_block *p,
                               const cvol_neural_position *q, int subband)
{
    p->next = q->index;
    p->state = q->state;
    p->finished = q->index == q->last + 1;
    cvol_neural_update_samples(b, p, cube_of(p, subband));
    cvol_neural_average(b, p, subband);
}
