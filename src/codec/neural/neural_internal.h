/* A brick of the small coder, for its files: what is known so far, and what that tells. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H
#define CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H

#include "codec/entropy/range_coder.h"
#include "codec/neural/neural_kernels.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"
#include "codec/quantize/quantize.h"

enum {
    CVOL_SMALL_SIDE = CVOL_BRICK_SIDE,
    CVOL_SMALL_SHEET = CVOL_SMALL_SIDE * CVOL_SMALL_SIDE,
    CVOL_SMALL_SAMPLES = CVOL_SMALL_SIDE * CVOL_SMALL_SHEET,
    CVOL_SMALL_PLANES = 6, /* faces: before the part along x, y, z, and behind it */
    CVOL_SMALL_PAD = 20,   /* a side of a part's magnitudes: three places before it, one behind */
    CVOL_SMALL_ORIGIN = 3 * (1 + CVOL_SMALL_PAD + CVOL_SMALL_PAD * CVOL_SMALL_PAD),
    CVOL_SMALL_LIMIT = 4095, /* magnitudes count as this at most, where they only foretell */
    CVOL_SMALL_BUCKET_BITS = 7,
    CVOL_SMALL_BUCKETS = 33, /* of logits, apart by 2^7 */
    CVOL_SMALL_ESCAPES = 31,
    CVOL_SMALL_NONE = -1
};

typedef struct cvol_small_part {
    uint8_t at[3], n[3]; /* its first sample in fours; how many coefficients along each axis */
    uint8_t size_class, side, length, around, change;
    uint8_t finished;                  /* nothing more is coded of it */
    int16_t beside[CVOL_SMALL_PLANES]; /* parts next to its first sample; CVOL_SMALL_NONE */
    int16_t across[3];                 /* across the edge along z, y, x of its first sample */
    const cvol_scan *scan;             /* NULL: nobody sees it */
    int32_t dc;
    int first;  /* its place in the brick's arrays */
    int values; /* encoder: where its values are */
    int used;   /* encoder: how many */
    int state, next, length_row;
} cvol_small_part;

/* Likelihoods of 1, in 2^-16, by a logit. */
typedef struct cvol_small_curve {
    uint16_t at[CVOL_SMALL_BUCKETS];
} cvol_small_curve;

/* What is learned in a brick, by size class (and whether cells are lapped). */
typedef struct cvol_small_states {
    cvol_small_curve above[CVOL_SMALL_OUTPUTS][3], agrees[3][2];
    cvol_probability escape[CVOL_SMALL_ESCAPES];
} cvol_small_states;

typedef struct cvol_small_brick cvol_small_brick;
struct cvol_small_brick {
    const cvol_array *array;
    cvol_brick_box box;
    uint16_t split[CVOL_BRICK_CELLS * CVOL_BRICK_CELLS * CVOL_BRICK_CELLS];
    int parts, value_count;
    cvol_small_part part[CVOL_BRICK_UNITS_ALL];
    int16_t unit[CVOL_BRICK_UNITS_ALL]; /* which part covers it */
    /* Encoder: indices of the parts, in scan order, one after the other. */
    int32_t values[CVOL_SMALL_SAMPLES];
    /* Values so far: that at (u, v, w) lies so far beside the part's first sample. */
    int32_t known[CVOL_SMALL_SAMPLES];
    int32_t samples[CVOL_SMALL_SAMPLES]; /* what these decode to, in sixteenths */
    uint8_t blur[CVOL_SMALL_SAMPLES];    /* their sizes' classes, averaged over nearby ones */
    /* Means of sizes' classes, in sixteenths, over the parts so far, by size class and frequency;
     * of how many parts, by shell. */
    int16_t means[3][16 * 16 * 16];
    uint8_t met[3][CVOL_SHELLS];
    cvol_small_states states;
    cvol_range_encoder encoder;
    cvol_token_tables *tables; /* with its own rows */
    void (*evaluate)(int16_t *out, const cvol_small_pairs *network, const int16_t *x, int inputs);
    void (*evaluate_kinds)(int16_t (*out)[CVOL_SMALL_OUTPUTS], const cvol_small_pairs *network,
                           int16_t *x);
};

/* ---- tables (filled by cvol_small_create) ----------------------------------------------- */

extern uint16_t
    cvol_small_likelihood[2 * (CVOL_SMALL_LOGIT_MOST + 1)]; /* 2^16 p, by logit + 2048 */
extern cvol_small_basis cvol_small_cosines;
extern cvol_small_pairs cvol_small_of_magnitudes, cvol_small_of_signs;
void cvol_small_fill_tables(void);

/* 10 log2(1 + magnitude), rounded. */
int cvol_small_class(uint32_t magnitude);
/* The same of what a face foretells, in quarters; and with its sign. */
int cvol_small_face_class(int32_t foretold);
int cvol_small_face_signed(int32_t foretold);

/* ---- around a part ---------------------------------------------------------------------- */

/* Finds which parts are beside which. */
void cvol_small_find_neighbours(cvol_small_brick *brick);
/* Adds what is known of a part in a shell to the means. */
void cvol_small_average(cvol_small_brick *brick, const cvol_small_part *part, int shell);
/* Brings samples and blur up to date with what is known of a part: frequencies below `cube`. */
void cvol_small_show(cvol_small_brick *brick, const cvol_small_part *part, int cube);

/* Everything about a part of which coefficients of a shell are coded. */
typedef struct cvol_small_view {
    uint16_t sizes[CVOL_SMALL_PAD * CVOL_SMALL_PAD * CVOL_SMALL_PAD];  /* magnitudes */
    uint8_t classes[CVOL_SMALL_PAD * CVOL_SMALL_PAD * CVOL_SMALL_PAD]; /* of these */
    int there[CVOL_SMALL_PLANES];
    /* What the faces foretell, less what is known: by the other two frequencies. */
    int32_t level[CVOL_SMALL_PLANES][16 * 16], slope[CVOL_SMALL_PLANES][16 * 16];
} cvol_small_view;

/* Where frequencies below `cube` are known. */
void cvol_small_view_part(cvol_small_view *view, const cvol_small_brick *brick,
                          const cvol_small_part *part, int cube);

/* What is asked about a coefficient. */
typedef struct cvol_small_question {
    int shell, index, last, state; /* last: index of the part's last one; scan's count: not known */
    int run;                       /* 16 times a mean of classes before it */
    int slow;                      /* the same over more of them */
} cvol_small_question;

/* What is seen of it. */
typedef struct cvol_small_look {
    int16_t x[CVOL_SMALL_INPUTS] __attribute__((aligned(64)));
    int at[3];
    int32_t level[CVOL_SMALL_PLANES], slope[CVOL_SMALL_PLANES], sum; /* foretold, in sixteenths */
    int shift;                                                       /* low bits that are raw */
} cvol_small_look;

void cvol_small_look_at(cvol_small_look *look, const cvol_small_brick *brick,
                        const cvol_small_view *view, const cvol_small_part *part,
                        const cvol_small_question *question);
/* The inputs of the signs' network; magnitude: of the coefficient's value. */
void cvol_small_look_for_sign(int16_t x[CVOL_SMALL_INPUTS], const cvol_small_brick *brick,
                              const cvol_small_part *part, const cvol_small_look *look,
                              uint32_t magnitude);

/* ---- on the way (neural_walk.c) ---------------------------------------------------------- */

/* Makes everything new but the parts. */
void cvol_small_start_coding(cvol_small_brick *brick);
int cvol_small_has_faces(const cvol_small_part *part);
/* A part's DC is known, and the bit length of its last index. */
void cvol_small_note_head(cvol_small_brick *brick, cvol_small_part *part,
                          cvol_brick_context *context);

/* The first question about a part in a shell. One past the last index that it has there, if the
 * part goes on so far; 0: none. */
int cvol_small_begin_part(cvol_small_question *question, const cvol_small_part *part, int shell);
/* Whether the part's last index is in this shell or before it. */
int cvol_small_has_last(const cvol_small_part *part, int shell);
/* Frequencies below this were known before the shell. */
int cvol_small_known_cube(const cvol_small_part *part, int shell);
/* The index' magnitude of what was asked is known, and its sign; goes on to the next. */
void cvol_small_note_value(cvol_small_brick *brick, cvol_small_part *part, cvol_small_view *view,
                           cvol_small_question *question, const cvol_small_look *look,
                           uint32_t size, int negative);
/* All that was asked about is known: up to the question's index. */
void cvol_small_end_part(cvol_small_brick *brick, cvol_small_part *part,
                         const cvol_small_question *question, int shell);

#endif
