/* A brick of the neural coder, for its files: what is known so far, and what that tells. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H
#define CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H

#include "codec/entropy/range_coder.h"
#include "codec/neural/neural_kernels.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"
#include "codec/quantize/quantize.h"

enum {
    CVOL_NEURAL_SIDE = CVOL_BRICK_SIDE,
    CVOL_NEURAL_SHEET = CVOL_NEURAL_SIDE * CVOL_NEURAL_SIDE,
    CVOL_NEURAL_SAMPLES = CVOL_NEURAL_SIDE * CVOL_NEURAL_SHEET,
    CVOL_NEURAL_PLANES = 6, /* faces: before the part along x, y, z, and behind it */
    CVOL_NEURAL_PAD = 20,   /* a side of a part's magnitudes: three places before it, one behind */
    CVOL_NEURAL_ORIGIN = 3 * (1 + CVOL_NEURAL_PAD + CVOL_NEURAL_PAD * CVOL_NEURAL_PAD),
    CVOL_NEURAL_LIMIT = 4095, /* magnitudes count as this at most, where they only foretell */
    CVOL_NEURAL_BUCKET_BITS = 7,
    CVOL_NEURAL_BUCKETS = 33, /* of logits, apart by 2^7 */
    CVOL_NEURAL_ESCAPES = 31,
    CVOL_NEURAL_NONE = -1
};

typedef struct cvol_neural_sub_block {
    uint8_t at[3], n[3]; /* its first sample in fours; how many coefficients along each axis */
    uint8_t size_class, side, length, around, change;
    uint8_t finished;                   /* nothing more is coded of it */
    int16_t beside[CVOL_NEURAL_PLANES]; /* parts next to its first sample; CVOL_NEURAL_NONE */
    int16_t across[3];                  /* across the edge along z, y, x of its first sample */
    const cvol_scan *scan;              /* NULL: nobody sees it */
    int32_t dc;
    int first;  /* its place in the brick's arrays */
    int values; /* encoder: where its values are */
    int used;   /* encoder: how many */
    int state, next, length_row;
} cvol_neural_sub_block;

/* Likelihoods of 1, in 2^-16, by a logit. */
typedef struct cvol_neural_curve {
    uint16_t at[CVOL_NEURAL_BUCKETS];
} cvol_neural_curve;

/* What is learned in a brick, by size class (and whether cells are lapped). */
typedef struct cvol_neural_states {
    cvol_neural_curve above[CVOL_NEURAL_OUTPUTS][3], agrees[3][2];
    cvol_probability escape[CVOL_NEURAL_ESCAPES];
} cvol_neural_states;

typedef struct cvol_neural_brick cvol_neural_brick;
struct cvol_neural_brick {
    const cvol_array *array;
    cvol_brick_box box;
    uint16_t split[CVOL_BRICK_CELLS * CVOL_BRICK_CELLS * CVOL_BRICK_CELLS];
    int parts, value_count;
    cvol_neural_sub_block part[CVOL_BRICK_UNITS_ALL];
    int16_t unit[CVOL_BRICK_UNITS_ALL]; /* which part covers it */
    /* Encoder: indices of the parts, in scan order, one after the other. */
    int32_t values[CVOL_NEURAL_SAMPLES];
    /* Values so far: that at (u, v, w) lies so far beside the part's first sample. */
    int32_t known[CVOL_NEURAL_SAMPLES];
    int32_t samples[CVOL_NEURAL_SAMPLES]; /* what these decode to, in sixteenths */
    uint8_t blur[CVOL_NEURAL_SAMPLES];    /* their sizes' classes, averaged over nearby ones */
    /* Means of sizes' classes, in sixteenths, over the parts so far, by size class and frequency;
     * of how many parts, by subband. */
    int16_t means[3][16 * 16 * 16];
    uint8_t met[3][CVOL_SUBBANDS];
    cvol_neural_states states;
    cvol_range_encoder encoder;
    cvol_token_tables *tables; /* with its own rows */
    void (*evaluate)(int16_t *out, const cvol_neural_pairs *network, const int16_t *x, int inputs);
    void (*evaluate_kinds)(int16_t (*out)[CVOL_NEURAL_OUTPUTS], const cvol_neural_pairs *network,
                           int16_t *x);
};

/* ---- tables (filled by cvol_neural_create) ----------------------------------------------- */

extern uint16_t
    cvol_neural_likelihood[2 * (CVOL_NEURAL_LOGIT_MOST + 1)]; /* 2^16 p, by logit + 2048 */
extern cvol_neural_basis cvol_neural_cosines;
extern cvol_neural_pairs cvol_neural_of_magnitudes, cvol_neural_of_signs;
void cvol_neural_fill_tables(void);

/* 10 log2(1 + magnitude), rounded. */
int cvol_neural_class(uint32_t magnitude);
/* The same of what a face foretells, in quarters; and with its sign. */
int cvol_neural_face_class(int32_t foretold);
int cvol_neural_face_signed(int32_t foretold);

/* ---- around a part ---------------------------------------------------------------------- */

/* Finds which parts are beside which. */
void cvol_neural_find_neighbours(cvol_neural_brick *brick);
/* Adds what is known of a part in a subband to the means. */
void cvol_neural_average(cvol_neural_brick *brick, const cvol_neural_sub_block *part, int subband);
/* Brings samples and blur up to date with what is known of a part: frequencies below `cube`. */
void cvol_neural_show(cvol_neural_brick *brick, const cvol_neural_sub_block *part, int cube);

/* Everything about a part of which coefficients of a subband are coded. */
typedef struct cvol_neural_view {
    uint16_t sizes[CVOL_NEURAL_PAD * CVOL_NEURAL_PAD * CVOL_NEURAL_PAD];  /* magnitudes */
    uint8_t classes[CVOL_NEURAL_PAD * CVOL_NEURAL_PAD * CVOL_NEURAL_PAD]; /* of these */
    int there[CVOL_NEURAL_PLANES];
    /* What the faces foretell, less what is known: by the other two frequencies. */
    int32_t level[CVOL_NEURAL_PLANES][16 * 16], slope[CVOL_NEURAL_PLANES][16 * 16];
} cvol_neural_view;

/* Where frequencies below `cube` are known. */
void cvol_neural_view_sub_block(cvol_neural_view *view, const cvol_neural_brick *brick,
                                const cvol_neural_sub_block *part, int cube);

/* What is asked about a coefficient. */
typedef struct cvol_neural_question {
    int subband, index, last,
        state; /* last: index of the part's last one; scan's count: not known */
    int run;   /* 16 times a mean of classes before it */
    int slow;  /* the same over more of them */
} cvol_neural_question;

/* What is seen of it. */
typedef struct cvol_neural_look {
    int16_t x[CVOL_NEURAL_INPUTS] __attribute__((aligned(64)));
    int at[3];
    int32_t level[CVOL_NEURAL_PLANES], slope[CVOL_NEURAL_PLANES], sum; /* foretold, in sixteenths */
    int shift;                                                         /* low bits that are raw */
} cvol_neural_look;

void cvol_neural_look_at(cvol_neural_look *look, const cvol_neural_brick *brick,
                         const cvol_neural_view *view, const cvol_neural_sub_block *part,
                         const cvol_neural_question *question);
/* The inputs of the signs' network; magnitude: of the coefficient's value. */
void cvol_neural_look_for_sign(int16_t x[CVOL_NEURAL_INPUTS], const cvol_neural_brick *brick,
                               const cvol_neural_sub_block *part, const cvol_neural_look *look,
                               uint32_t magnitude);

/* ---- on the way (neural_walk.c) ---------------------------------------------------------- */

/* Makes everything new but the parts. */
void cvol_neural_start_coding(cvol_neural_brick *brick);
int cvol_neural_has_faces(const cvol_neural_sub_block *part);
/* A part's DC is known, and the bit length of its last index. */
void cvol_neural_note_head(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                           cvol_brick_context *context);

/* The first question about a part in a subband. One past the last index that it has there, if the
 * part goes on so far; 0: none. */
int cvol_neural_begin_sub_block(cvol_neural_question *question, const cvol_neural_sub_block *part,
                                int subband);
/* Whether the part's last index is in this subband or before it. */
int cvol_neural_has_last(const cvol_neural_sub_block *part, int subband);
/* Frequencies below this were known before the subband. */
int cvol_neural_known_cube(const cvol_neural_sub_block *part, int subband);
/* The index' magnitude of what was asked is known, and its sign; goes on to the next. */
void cvol_neural_note_value(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                            cvol_neural_view *view, cvol_neural_question *question,
                            const cvol_neural_look *look, uint32_t size, int negative);
/* All that was asked about is known: up to the question's index. */
void cvol_neural_end_sub_block(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                               const cvol_neural_question *question, int subband);

#endif
