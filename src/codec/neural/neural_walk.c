/* A brick on its way: what is known of it as one coefficient after the other is. */
#include <string.h>

#include "codec/neural/neural_internal.h"
#include "codec/quantize/trellis_states.h"

/* Makes everything new but the parts. */
void cvol_small_start_coding(cvol_small_brick *b)
{
    const uint16_t half = 1 << 15;
    cvol_small_curve fresh;
    memset(b->known, 0, sizeof b->known);
    memset(b->blur, 0, sizeof b->blur);
    memset(b->means, 0, sizeof b->means);
    memset(b->met, 0, sizeof b->met);
    for (int k = 0; k < CVOL_SMALL_BUCKETS; k++)
        fresh.at[k] =
            cvol_small_likelihood[k == CVOL_SMALL_BUCKETS - 1 ? 4095 : k << CVOL_SMALL_BUCKET_BITS];
    for (int k = 0; k < 3; k++) {
        for (int t = 0; t < CVOL_SMALL_OUTPUTS; t++)
            b->states.above[t][k] = fresh;
        b->states.agrees[k][0] = b->states.agrees[k][1] = fresh;
    }
    for (int i = 0; i < CVOL_SMALL_ESCAPES; i++)
        b->states.escape[i] = (cvol_probability){half, half};
}

int cvol_small_has_faces(const cvol_small_part *p)
{
    for (int k = 0; k < CVOL_SMALL_PLANES; k++)
        if (p->beside[k] != CVOL_SMALL_NONE)
            return 1;
    return 0;
}

void cvol_small_note_head(cvol_small_brick *b, cvol_small_part *p, cvol_brick_context *context)
{
    const int at[3] = {p->at[0], p->at[1], p->at[2]};
    if (!p->scan) {
        p->dc = cvol_part_note_unseen(context, at, p->size_class);
        b->known[p->first] = 2 * p->dc;
        return;
    }
    const cvol_part_context around = cvol_part_context_of(context, at, p->scan);
    const int64_t difference = p->dc - around.prediction;
    const uint64_t number = (uint64_t)(difference < 0 ? -difference : difference);
    p->length_row = cvol_length_row(&around, p->size_class, number);
    p->around = (uint8_t)around.around;
    p->change = (uint8_t)cvol_small_class((uint32_t)number);
    p->next = 1;
    p->state = 0;
    p->finished = !p->length;
    b->known[p->first] = 2 * p->dc;
    cvol_part_note(context, at, p->scan, p->dc, p->length);
    cvol_small_show(b, p, 1);
}

/* ---- a part's coefficients of a shell ----------------------------------------------------- */

int cvol_small_begin_part(cvol_small_question *q, const cvol_small_part *p, int shell)
{
    const int end = p->scan->shell_end[shell];
    *q = (cvol_small_question){
        .shell = shell, .index = p->next, .last = p->scan->count, .state = p->state};
    return end > p->next ? end : 0;
}

int cvol_small_has_last(const cvol_small_part *p, int shell)
{
    return 1 << (p->length - 1) < cvol_shell_end(p->size_class, shell);
}

static int cube_of(const cvol_small_part *p, int shell)
{
    return p->side >> (CVOL_SHELLS - 1 - shell);
}

int cvol_small_known_cube(const cvol_small_part *p, int shell)
{
    const int cube = cube_of(p, shell);
    return cube > 2 ? cube / 2 : 1;
}

void cvol_small_note_value(cvol_small_brick *b, cvol_small_part *p, cvol_small_view *view,
                           cvol_small_question *q, const cvol_small_look *l, uint32_t size,
                           int negative)
{
    const uint32_t magnitude = cvol_dependent_magnitude(q->state, size);
    const int class = cvol_small_class(magnitude);
    q->index++;
    q->state = cvol_state_after[q->state][size & 1];
    q->run += (16 * class - q->run) / 8;
    q->slow += (64 * class - q->slow) / 32;
    if (!size)
        return;
    const int32_t value = negative ? -(int32_t)magnitude : (int32_t)magnitude;
    const int *at = l->at;
    const int local = CVOL_SMALL_ORIGIN + at[0] + CVOL_SMALL_PAD * (at[1] + CVOL_SMALL_PAD * at[2]);
    b->known[p->first + at[0] + CVOL_SMALL_SIDE * at[1] + CVOL_SMALL_SHEET * at[2]] = value;
    view->sizes[local] = (uint16_t)(magnitude < CVOL_SMALL_LIMIT ? magnitude : CVOL_SMALL_LIMIT);
    view->classes[local] = (uint8_t) class;
    cvol_small_take_off(view->level, view->slope, p->n, at, value, &cvol_small_cosines);
}

void cvol_small_end_part(cvol_small_brick *b, cvol_small_part *p, const cvol_small_question *q,
                         int shell)
{
    p->next = q->index;
    p->state = q->state;
    p->finished = q->index == q->last + 1;
    cvol_small_show(b, p, cube_of(p, shell));
    cvol_small_average(b, p, shell);
}
