/* Internals of the neural coder: a brick's known values, and the predictions from them. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H
#define CVOL_CODEC_NEURAL_NEURAL_INTERNAL_H

#include "codec/entropy/logistic.h"
#include "codec/entropy/range_coder.h"
#include "codec/neural/neural_kernels.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"
#include "codec/quantize/quantize.h"

enum {
    CVOL_NEURAL_SIDE = CVOL_BRICK_SIDE,
    CVOL_NEURAL_SLICE = CVOL_NEURAL_SIDE * CVOL_NEURAL_SIDE,
    CVOL_NEURAL_SAMPLES = CVOL_NEURAL_SIDE * CVOL_NEURAL_SLICE,
    CVOL_NEURAL_PLANES = 6, /* faces: before the sub-block along x, y, z, and after it */
    CVOL_NEURAL_PAD = 20,   /* side of a sub-block's magnitudes: three places before it, one
                               after */
    CVOL_NEURAL_ORIGIN = 3 * (1 + CVOL_NEURAL_PAD + CVOL_NEURAL_PAD * CVOL_NEURAL_PAD),
    CVOL_NEURAL_LIMIT = 4095, /* larger magnitudes count as this in predictions */
    CVOL_NEURAL_BUCKET_BITS = 7,
    CVOL_NEURAL_BUCKETS = 33, /* of logits, at distances of 2^7 */
    CVOL_NEURAL_ESCAPES = 31,
    CVOL_NEURAL_NONE = -1
};

typedef struct cvol_neural_sub_block {
    uint8_t at[3], n[3]; /* its first sample in units of four; number of coefficients along each
                            axis */
    uint8_t size_class, side, length, around, change;
    uint8_t finished; /* it has no more coefficients to code */
    int16_t
        neighbours[CVOL_NEURAL_PLANES]; /* sub-blocks next to its first sample; CVOL_NEURAL_NONE */
    int16_t across[3];                  /* across the edge along z, y, x of its first sample */
    const cvol_scan *scan;              /* NULL: in padding */
    int32_t dc;
    int first;  /* its place in the brick's arrays */
    int values; /* encoder: place of its values */
    int used;   /* encoder: number of values */
    int state, next, length_row;
} cvol_neural_sub_block;

/* Probabilities of 1, in 2^-16, by a logit. */
typedef struct cvol_neural_curve {
    uint16_t at[CVOL_NEURAL_BUCKETS];
} cvol_neural_curve;

/* Adaptive state within a brick, by size class (and by lapping of cells). */
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
    int16_t unit[CVOL_BRICK_UNITS_ALL]; /* number of the sub-block that covers it */
    /* Encoder: indices of the sub-blocks, in scan order, one after the other. */
    int32_t values[CVOL_NEURAL_SAMPLES];
    /* Known values: the value at (u, v, w) has this offset from the sub-block's first sample. */
    int32_t known[CVOL_NEURAL_SAMPLES];
    int32_t samples[CVOL_NEURAL_SAMPLES]; /* their samples, in sixteenths */
    uint8_t blur[CVOL_NEURAL_SAMPLES];    /* classes of their magnitudes, averaged over
                                             neighbours */
    /* Mean classes of magnitudes, in sixteenths, over the sub-blocks so far, by size class and
     * frequency; and the number of these sub-blocks, by subband. */
    int16_t means[3][16 * 16 * 16];
    uint8_t seen_count[3][CVOL_SUBBANDS];
    cvol_neural_states states;
    cvol_range_encoder encoder;
    cvol_token_tables *tables; /* with its own rows */
    void (*evaluate)(int16_t *out, const cvol_neural_pairs *network, const int16_t *x, int inputs);
    void (*evaluate_kinds)(int16_t (*out)[CVOL_NEURAL_OUTPUTS], const cvol_neural_pairs *network,
                           int16_t *x);
};

/* ---- tables (filled by cvol_neural_create) ----------------------------------------------- */

extern cvol_neural_basis cvol_neural_cosines;
extern cvol_neural_pairs cvol_neural_magnitude_pairs, cvol_neural_sign_pairs;
void cvol_neural_fill_tables(void);

/* 10 log2(1 + magnitude), rounded. */
int cvol_neural_class(uint32_t magnitude);
/* The same for a face's prediction, in quarters; and with its sign. */
int cvol_neural_face_class(int32_t predicted);
int cvol_neural_face_signed(int32_t predicted);

/* ---- around a sub-block ------------------------------------------------------------------ */

/* Finds the neighbours of all sub-blocks. */
void cvol_neural_find_neighbours(cvol_neural_brick *brick);
/* Adds a sub-block's known values in a subband to the means. */
void cvol_neural_average(cvol_neural_brick *brick, const cvol_neural_sub_block *part, int subband);
/* Updates samples and blur from a sub-block's known values: frequencies below `cube`. */
void cvol_neural_update_samples(cvol_neural_brick *brick, const cvol_neural_sub_block *part,
                                int cube);

/* The surroundings of a sub-block while a subband of it is coded. */
typedef struct cvol_neural_view {
    uint16_t sizes[CVOL_NEURAL_PAD * CVOL_NEURAL_PAD * CVOL_NEURAL_PAD];  /* magnitudes */
    uint8_t classes[CVOL_NEURAL_PAD * CVOL_NEURAL_PAD * CVOL_NEURAL_PAD]; /* of these magnitudes */
    int there[CVOL_NEURAL_PLANES];
    /* The faces' predictions minus the known values, by the other two frequencies. */
    int32_t level[CVOL_NEURAL_PLANES][16 * 16], slope[CVOL_NEURAL_PLANES][16 * 16];
} cvol_neural_view;

/* Fills the view if frequencies below `cube` are known. */
void cvol_neural_view_sub_block(cvol_neural_view *view, const cvol_neural_brick *brick,
                                const cvol_neural_sub_block *part, int cube);

/* The coefficient to code. */
typedef struct cvol_neural_position {
    int subband, index, last, state; /* last: the sub-block's last index; scan's count: not known */
    int run;                         /* 16 times a mean of the classes before it */
    int slow;                        /* the same over more classes */
} cvol_neural_position;

/* The context of the coefficient. */
typedef struct cvol_neural_context {
    int16_t x[CVOL_NEURAL_INPUTS] __attribute__((aligned(64)));
    int at[3];
    int32_t level[CVOL_NEURAL_PLANES], slope[CVOL_NEURAL_PLANES], sum; /* predictions, in
                                                                          sixteenths */
    int shift;                                                         /* number of raw low bits */
} cvol_neural_context;

void cvol_neural_context_at(cvol_neural_context *coefficient, const cvol_neural_brick *brick,
                            const cvol_neural_view *view, const cvol_neural_sub_block *part,
                            const cvol_neural_position *position);
/* The inputs of the signs' network; magnitude: of the coefficient's value. */
void cvol_neural_sign_inputs(int16_t x[CVOL_NEURAL_INPUTS], const cvol_neural_brick *brick,
                             const cvol_neural_sub_block *part,
                             const cvol_neural_context *coefficient, uint32_t magnitude);

/* ---- walk (neural_walk.c) ---------------------------------------------------------------- */

/* Resets all members except the sub-blocks. */
void cvol_neural_start_coding(cvol_neural_brick *brick);
int cvol_neural_has_faces(const cvol_neural_sub_block *part);
/* Records a sub-block's DC and the bit length of its last index. */
void cvol_neural_note_head(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                           cvol_brick_context *context);

/* Starts at a sub-block's first coefficient in a subband. Returns one past its last possible index
 * there; 0: it has none. */
int cvol_neural_begin_sub_block(cvol_neural_position *position, const cvol_neural_sub_block *part,
                                int subband);
/* True if the sub-block's last index is in this subband or an earlier one. */
int cvol_neural_has_last(const cvol_neural_sub_block *part, int subband);
/* Frequencies below this were known before the subband. */
int cvol_neural_known_cube(const cvol_neural_sub_block *part, int subband);
/* Records the index's magnitude and sign, and goes on to the next coefficient. */
void cvol_neural_note_value(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                            cvol_neural_view *view, cvol_neural_position *position,
                            const cvol_neural_context *coefficient, uint32_t size, int negative);
/* Ends a sub-block's subband: all coefficients up to the position's index are known. */
void cvol_neural_end_sub_block(cvol_neural_brick *brick, cvol_neural_sub_block *part,
                               const cvol_neural_position *position, int subband);

#endif
