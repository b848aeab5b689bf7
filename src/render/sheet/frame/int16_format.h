/* Classification of int16 samples: the segments of a table (table.h) as integers, for kernels that
 * process 32 pixels together (render/sheet/kernels/composite/int16.h).
 *
 * A sample q is clamped to from .. to. segment_of[(q - from) bins / 2^16] is the first segment to
 * test, and at most `steps` steps lead to its segment i, the first with q < end[i]. Its values are
 *     start[k][i] + ((q - begin[i]) 2^up[i]) rise[k][i] / 2^15,
 * colour times opacity (k 0 to 2) and opacity (3), over the distance of two slices, times 2^(14 +
 * shift + fine). Shares of these are added up times 2^(15 + shift). */
#ifndef CVOL_RENDER_SHEET_FRAME_INT16_FORMAT_H
#define CVOL_RENDER_SHEET_FRAME_INT16_FORMAT_H

#include <stdint.h>

#define CVOL_INT16_SEGMENTS 32
#define CVOL_INT16_BINS 64
/* The most steps. */
#define CVOL_INT16_STEPS 3

typedef struct cvol_int16_table {
    int usable;
    int steps, shift, fine;
    int16_t from, to, visible_from, visible_to;
    int16_t flat; /* colour and opacity are nearly linear over this interval */
    /* See cvol_sheet_table; the weight of a midpoint is ((rise - midpoint) 2^up rate) / 2^31. */
    int16_t steep, integrated, midpoint, midpoint_ramp, midpoint_up;
    uint16_t midpoint_rate;
    uint16_t bins;
    int16_t end[CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t begin[CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t up[CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t start[4][CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t rise[4][CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t segment_of[CVOL_INT16_BINS] __attribute__((aligned(64)));
    /* 1 / (1 + sqrt(1 - A)) times 2^15, the share of an opacity A that belongs to half of the
     * length: from A = i / 32 on, and its rise until the next. */
    int16_t half_start[CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
    int16_t half_rise[CVOL_INT16_SEGMENTS] __attribute__((aligned(64)));
} cvol_int16_table;

struct cvol_sheet_table;

/* For samples in the format `scale` and `offset`. Not usable if the table has no segments, or if
 * samples are too coarse for it. */
void cvol_int16_table_fill(cvol_int16_table *int16, const struct cvol_sheet_table *table,
                           float scale, float offset);

#endif
