/* Coding of a brick of labels: integers that name regions, so that neighbours are equal or differ
 * by any amount.
 *
 * Samples are coded in order, x fastest, as bits in adaptive contexts (range_coder.h). The coder
 * keeps a list of the labels of the brick, in the order in which they occur. A *stretch* is a
 * sequence of samples of a row whose neighbours in the rows above and before all equal the sample
 * to the left. One bit states that a sample of the stretch differs; it costs almost nothing if none
 * does, which is the common case away from faces of regions. Samples up to the differing one, and
 * samples outside stretches, are coded one by one:
 *
 * - A bit states whether the sample equals the most likely label of its neighbours. One context is
 *   the probability from the network of masks (mask_predict.h), whose 50 inputs are the neighbours
 *   that equal this label; another is the pattern of twelve near neighbours. Their logits are added
 *   with fixed weights.
 * - If not, one bit follows for each other label among nine near neighbours.
 * - If it equals none of them, a bit states that the label is new. A new label is stored as it is.
 * A known one is coded by its rank in the list of labels, those of the last samples first.
 *
 * doc/format.md states all contexts. */
#ifndef CVOL_CODEC_LABELS_LABEL_CODE_H
#define CVOL_CODEC_LABELS_LABEL_CODE_H

#include "base/bytes.h"
#include "codec/entropy/range_coder.h"
#include "codec/quantize/brick_box.h"

/* The most different labels of a brick: ranks in longer lists take too much time. */
enum { CVOL_LABELS_MAX = 4096 };

/* One thread's memory for coding in either direction. NULL when memory is short. */
typedef struct cvol_label_coder cvol_label_coder;
cvol_label_coder *cvol_label_coder_create(void);
void cvol_label_coder_free(cvol_label_coder *coder);

/* A brick's size, at most 64 along each axis, and its labels, 0 .. most, x fastest. */
typedef struct cvol_label_brick {
    size_t size[3];
    uint32_t most;
    uint32_t *labels;
} cvol_label_brick;

/* Encodes a brick; the bytes replace the content of *out. Does not change the brick. Returns
 * CVOL_OK, CVOL_ERROR_MEMORY, or CVOL_ERROR_TARGET if it has more than CVOL_LABELS_MAX labels. */
int cvol_label_encode(cvol_label_coder *coder, cvol_bytes *out, const cvol_label_brick *brick);
/* Decodes a brick whose size and `most` are set. Returns CVOL_OK or CVOL_ERROR_CORRUPT. */
int cvol_label_decode(cvol_label_coder *coder, const cvol_label_brick *brick, cvol_span data);

#endif
