/* Encodes and decodes bricks of labels. */
#include "codec/labels/label_code.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "codec/entropy/logistic.h"
#include "codec/labels/label_rows.h"
#include "cvol/base.h"

enum {
    BORDER = CVOL_LABEL_BORDER,
    LISTED = 10, /* labels that are tried: the likely one, and those of nine neighbours */
    PATTERNS = 1 << 12,
    KINDS = 6,    /* contexts for the last of them, by their number */
    LENGTHS = 16, /* bit lengths of ranks */
    /* Weights of two logits, in units of 2^-WEIGHT_BITS. */
    LEVEL_WEIGHT = 45,
    PATTERN_WEIGHT = 26,
    WEIGHT_BITS = 6
};

/* Adaptive contexts, reset in each brick. */
typedef struct label_model {
    cvol_probability stretches[7];                   /* [bit length of the length, minus one] */
    cvol_probability likely[2][2][CVOL_MASK_LEVELS]; /* [above is it][left is it][level] */
    cvol_probability patterns[PATTERNS];             /* 0, 0: not used yet */
    cvol_probability others[CVOL_MASK_LEVELS];
    cvol_probability last[KINDS];
    cvol_probability is_new;
    cvol_probability lengths[LENGTHS];
} label_model;

struct cvol_label_coder {
    cvol_range_encoder to;
    cvol_range_decoder from;
    label_model model;
    cvol_label_row slices[3][CVOL_LABEL_ROWS];
    uint32_t labels[CVOL_LABELS_MAX];  /* the list */
    uint16_t recent[CVOL_LABELS_MAX];  /* positions in the list: the label of the last sample that
                                          was coded alone comes first */
    uint8_t is_tried[CVOL_LABELS_MAX]; /* [position]: for code_known */
    uint32_t count;
    uint32_t most;
    int bits; /* of a new label */
};

/* The labels that are tried for a sample, as positions in the list, and how many. */
typedef struct candidates {
    uint16_t at[LISTED];
    int count;
} candidates;

cvol_label_coder *cvol_label_coder_create(void)
{
    return cvol_allocate_zero(1, sizeof(cvol_label_coder));
}

void cvol_label_coder_free(cvol_label_coder *coder)
{
    if (!coder)
        return;
    cvol_range_encoder_free(&coder->to);
    free(coder);
}

static int bit_length(uint32_t value)
{
    return value ? 32 - __builtin_clz(value) : 0;
}

static cvol_probability probability(uint16_t of_zero)
{
    return (cvol_probability){of_zero, of_zero};
}

static void start_model(label_model *model)
{
    enum { EVEN = 1 << 15, SURE = 64225, LIKELY = 60000 };
    cvol_probability *all = (cvol_probability *)model;
    for (size_t i = 0; i < sizeof *model / sizeof *all; i++)
        all[i] = probability(EVEN);
    memset(model->patterns, 0, sizeof model->patterns);
    for (size_t i = 0; i < sizeof model->stretches / sizeof *all; i++)
        model->stretches[i] = probability(SURE);
    for (int i = 0; i < CVOL_MASK_LEVELS; i++)
        model->others[i] = probability(cvol_mask_probabilities[i]);
    for (int c = 0; c < 4; c++)
        memcpy(model->likely[c / 2][c % 2], model->others, sizeof model->others);
    for (int i = 0; i < KINDS; i++)
        model->last[i] = probability(LIKELY);
}

/* ---- bits and numbers; `encode` is a constant at compile time ------------------------------ */

CVOL_INLINE int code_bit(cvol_label_coder *coder, cvol_probability *p, int bit, int encode)
{
    if (!encode)
        return cvol_decode_bit(&coder->from, p);
    cvol_encode_bit(&coder->to, p, bit);
    return bit;
}

CVOL_INLINE uint32_t code_raw(cvol_label_coder *coder, uint32_t value, int count, int encode)
{
    if (!encode)
        return cvol_decode_raw(&coder->from, count);
    cvol_encode_raw(&coder->to, value, count);
    return value;
}

/* Codes rank + 1, by its bit length. Returns UINT32_MAX if it is invalid. */
CVOL_INLINE uint32_t code_rank(cvol_label_coder *coder, uint32_t rank, int encode)
{
    const int wanted = encode ? bit_length(rank + 1) - 1 : 0;
    int length = 0;
    while (code_bit(coder, &coder->model.lengths[length], length < wanted, encode))
        if (++length == LENGTHS)
            return UINT32_MAX;
    const uint32_t low = code_raw(coder, (rank + 1) & ((1u << length) - 1), length, encode);
    return (1u << length | low) - 1;
}

/* Codes if a sample equals its likely label. The probability mixes those of two contexts: the
 * network's level, and the pattern of near neighbours. */
CVOL_INLINE int code_likely(cvol_label_coder *coder, cvol_probability *of_level,
                            const cvol_label_view *view, int bit, int encode)
{
    cvol_probability *of_pattern = &coder->model.patterns[view->pattern];
    if (!of_pattern->slow)
        *of_pattern = probability(cvol_mask_probabilities[view->level]);
    const int sum = LEVEL_WEIGHT * cvol_logistic_logit[cvol_probability_of_zero(of_level) >> 4] +
                    PATTERN_WEIGHT * cvol_logistic_logit[cvol_probability_of_zero(of_pattern) >> 4];
    const int most = CVOL_LOGITS / 2, at = (sum >> WEIGHT_BITS) + most;
    const uint32_t zero = cvol_logistic_probability[at < 0              ? 0
                                                    : at >= CVOL_LOGITS ? CVOL_LOGITS - 1
                                                                        : at];
    if (encode)
        cvol_encode_probable(&coder->to, zero, bit);
    else
        bit = cvol_decode_probable(&coder->from, zero);
    cvol_probability_pull(of_level, (uint32_t)bit);
    cvol_probability_pull(of_pattern, (uint32_t)bit);
    return bit;
}

/* ---- the list of labels ------------------------------------------------------------------ */

CVOL_INLINE int is_among(const candidates *tried, uint32_t position)
{
    int found = 0;
    for (int k = 0; k < tried->count; k++)
        found |= tried->at[k] == position;
    return found;
}

/* The place of a label among the recent ones; `count` if it is new. */
static uint32_t find_recent(const cvol_label_coder *coder, uint32_t label)
{
    uint32_t i = 0;
    while (i < coder->count && coder->labels[coder->recent[i]] != label)
        i++;
    return i;
}

static void move_to_front(cvol_label_coder *coder, uint32_t position)
{
    uint32_t i = 0;
    if (coder->recent[0] == position)
        return;
    while (coder->recent[i] != position)
        i++;
    memmove(coder->recent + 1, coder->recent, i * sizeof *coder->recent);
    coder->recent[0] = (uint16_t)position;
}

/* Codes a new label and appends it to the list. Returns its position, or -1 if it is invalid. */
CVOL_INLINE int code_new(cvol_label_coder *coder, uint32_t label, int encode)
{
    label = code_raw(coder, label, coder->bits, encode);
    if (label > coder->most || coder->count == CVOL_LABELS_MAX)
        return -1;
    coder->labels[coder->count] = label;
    coder->recent[coder->count] = (uint16_t)coder->count;
    return (int)coder->count++;
}

/* Codes a known label by its rank among the recent ones that were not tried. Returns its position,
 * or -1 if it is invalid. */
CVOL_INLINE int code_known(cvol_label_coder *coder, const candidates *tried, uint32_t position,
                           int encode)
{
    int found = encode ? (int)position : -1;
    uint32_t rank = 0, i = 0;
    for (int k = 0; k < tried->count; k++)
        coder->is_tried[tried->at[k]] = 1;
    for (; encode && coder->recent[i] != position; i++)
        rank += !coder->is_tried[coder->recent[i]];
    rank = code_rank(coder, rank, encode);
    for (; found < 0 && i < coder->count; i++)
        if (!coder->is_tried[coder->recent[i]] && rank-- == 0)
            found = coder->recent[i];
    for (int k = 0; k < tried->count; k++)
        coder->is_tried[tried->at[k]] = 0;
    return found;
}

/* ---- samples ----------------------------------------------------------------------------- */

CVOL_INLINE void find_candidates(candidates *out, const cvol_label_rows *rows, size_t x)
{
    const uint16_t *own = rows->own[2].at + x, *above = rows->own[1].at + x;
    const uint16_t *before = rows->before[2].at + x, *upper = rows->before[1].at + x;
    const uint16_t *lower = rows->before[3].at + x;
    const uint16_t near[] = {above[0], before[0], own[-1],  above[1], before[1],
                             lower[0], above[-1], upper[0], lower[1]};
    out->at[0] = own[-1] != above[0] && own[-1] != before[0] && above[0] == before[0] ? above[0]
                                                                                      : own[-1];
    out->count = 1;
    for (size_t i = 0; i < sizeof near / sizeof *near; i++)
        if (!is_among(out, near[i]))
            out->at[out->count++] = near[i];
}

/* Codes the label of a sample that is none of those tried. */
CVOL_INLINE int code_far(cvol_label_coder *coder, const candidates *tried, uint32_t label,
                         int encode)
{
    const uint32_t place = encode ? find_recent(coder, label) : 0;
    int is_new = place == coder->count;
    if (coder->count == (uint32_t)tried->count)
        is_new = 1; /* all labels were tried */
    else
        is_new = code_bit(coder, &coder->model.is_new, is_new, encode);
    return is_new ? code_new(coder, label, encode)
                  : code_known(coder, tried, encode ? coder->recent[place] : 0, encode);
}

/* Codes a sample; `differs`: it surely differs from the sample to the left. Returns its position in
 * the list, or -1 if it is invalid. */
CVOL_INLINE int code_sample(cvol_label_coder *coder, const cvol_mask_sums *table,
                            const cvol_label_rows *rows, size_t x, int differs, uint32_t label,
                            int encode)
{
    label_model *model = &coder->model;
    candidates tried;
    find_candidates(&tried, rows, x);
    if (!differs) {
        const uint16_t likely = tried.at[0];
        const cvol_label_view view = cvol_label_look(table, rows, x, likely);
        cvol_probability *p = &model->likely[rows->own[1].at[x] == likely]
                                            [rows->own[2].at[x - 1] == likely][view.level];
        if (code_likely(coder, p, &view, coder->labels[likely] == label, encode))
            return likely;
    }
    for (int k = 1; k < tried.count; k++) {
        const int same = coder->labels[tried.at[k]] == label;
        if (k + 1 < tried.count) {
            const int level = cvol_label_look(table, rows, x, tried.at[k]).level;
            if (code_bit(coder, &model->others[level], same, encode))
                return tried.at[k];
        } else {
            const int kind = tried.count < KINDS ? tried.count : KINDS - 1;
            if (!code_bit(coder, &model->last[kind], !same, encode))
                return tried.at[k];
        }
    }
    return code_far(coder, &tried, label, encode);
}

/* Codes samples one by one from column x on, up to the first that differs from its left one, but
 * not beyond `end`; in a stretch, one of them does. Returns the next column, or 0 if a label is
 * invalid. */
CVOL_INLINE size_t code_samples(cvol_label_coder *coder, const cvol_mask_sums *table,
                                const cvol_label_rows *rows, size_t x, size_t end, int is_stretch,
                                const uint32_t *labels, int encode)
{
    uint16_t *own = rows->own[2].at;
    int same = 1;
    for (; x < end && same; x++) {
        const int position = code_sample(coder, table, rows, x, is_stretch && x + 1 == end,
                                         encode ? labels[x - BORDER] : 0, encode);
        if (position < 0)
            return 0;
        same = position == own[x - 1];
        own[x] = (uint16_t)position;
        move_to_front(coder, (uint32_t)position);
    }
    return x;
}

/* ---- rows -------------------------------------------------------------------------------- */

/* True if `count` labels from column x on equal the sample to the left. */
static int is_constant(const cvol_label_coder *coder, const uint16_t *own, size_t x, size_t count,
                       const uint32_t *labels)
{
    const uint32_t left = coder->labels[own[x - 1]];
    for (size_t i = 0; i < count; i++)
        if (labels[x - BORDER + i] != left)
            return 0;
    return 1;
}

/* Codes a row; returns 0 if a label is invalid. */
CVOL_INLINE int code_row(cvol_label_coder *coder, const cvol_mask_sums *table,
                         const cvol_label_rows *rows, size_t width, uint32_t *labels, int encode)
{
    uint16_t *own = rows->own[2].at;
    const uint16_t *above = rows->own[1].at;
    for (size_t x = 0; x < BORDER; x++)
        own[x] = above[BORDER];
    const uint64_t uniform = cvol_label_uniform(rows);
    for (size_t x = BORDER; x < BORDER + width;) {
        const uint64_t rest = ~(uniform >> (x - BORDER));
        size_t stretch = rest ? (size_t)__builtin_ctzll(rest) : CVOL_BRICK_SIDE;
        stretch = stretch < BORDER + width - x ? stretch : BORDER + width - x;
        if (stretch < 2 || above[x] != own[x - 1]) {
            x = code_samples(coder, table, rows, x, x + 1, 0, labels, encode);
        } else if (!code_bit(coder, &coder->model.stretches[bit_length((uint32_t)stretch) - 1],
                             encode && !is_constant(coder, own, x, stretch, labels), encode)) {
            for (const size_t end = x + stretch; x < end; x++)
                own[x] = own[x - 1];
        } else {
            x = code_samples(coder, table, rows, x, x + stretch, 1, labels, encode);
        }
        if (!x)
            return 0;
    }
    for (size_t x = 0; !encode && x < width; x++)
        labels[x] = coder->labels[own[BORDER + x]];
    for (size_t x = 0; x < BORDER; x++) {
        own[x] = own[BORDER];
        own[BORDER + width + x] = own[BORDER + width - 1];
    }
    return 1;
}

/* Codes a brick; returns 0 if a label is invalid. */
CVOL_INLINE int code_brick(cvol_label_coder *coder, const cvol_label_brick *brick, int encode)
{
    const cvol_mask_sums *table = cvol_mask_predictor();
    const size_t end = brick->size[1] + 2;
    uint32_t *labels = brick->labels;
    cvol_logistic_fill();
    start_model(&coder->model);
    memset(coder->slices, 0, sizeof coder->slices); /* the first label of the list */
    coder->count = 0;
    coder->most = brick->most;
    coder->bits = bit_length(brick->most);
    if (code_new(coder, encode ? labels[0] : 0, encode) < 0)
        return 0;
    for (size_t z = 0; z < brick->size[2]; z++) {
        cvol_label_row *own = coder->slices[z % 3];
        const cvol_label_row *before = coder->slices[(z + 2) % 3];
        const cvol_label_row *second = coder->slices[(z + 1) % 3];
        own[0] = own[1] = before[2];
        for (size_t y = 0; y < brick->size[1]; y++, labels += brick->size[0]) {
            const cvol_label_rows rows = {own + y, before + y, second + y};
            if (!code_row(coder, table, &rows, brick->size[0], labels, encode))
                return 0;
        }
        own[0] = own[1] = own[2];
        own[end] = own[end + 1] = own[end - 1];
    }
    return 1;
}

/* ---- bricks ------------------------------------------------------------------------------ */

int cvol_label_encode(cvol_label_coder *coder, cvol_bytes *out, const cvol_label_brick *brick)
{
    out->size = 0;
    cvol_range_encoder_start(&coder->to);
    if (!code_brick(coder, brick, 1))
        return CVOL_ERROR_TARGET;
    return cvol_range_encoder_finish(&coder->to, out) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

int cvol_label_decode(cvol_label_coder *coder, const cvol_label_brick *brick, cvol_span data)
{
    cvol_range_decoder_start(&coder->from, data.data, data.size);
    return code_brick(coder, brick, 0) && !cvol_range_decoder_overrun(&coder->from)
               ? CVOL_OK
               : CVOL_ERROR_CORRUPT;
}
