/* The shape of labels (cvol/look.h): above one half where a sample has a label, smooth between the
 * samples.
 *
 * A mask of 0 and 1 alone would be lit in steps. The same mask blurred by weights 1 2 1 on each
 * axis, twice, is even along a surface, but puts some samples on the wrong side of one half: at
 * corners, and where a part is thin. These alone are moved, no further than they must be for
 * corners, and up to LEAST for thin parts: a part of one sample is drawn about 0.6 samples thick.
 */
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "cvol/look.h"

/* The blur is repeated so often; then its weights on an axis are 1 4 6 4 1. */
#define REPEATED 2
#define WEIGHTS 4096
#define LEAST 184 /* of 255 */
/* Nearest to one half, with a label and without. */
#define ABOVE 134
#define BELOW 121
/* A path of a small part of a sample hides what is behind it. */
#define OPACITY 0.999
/* The least term of the shape, whose samples are 0 to 255: with less noise its interior is flat. */
#define TERM_LEAST 0.25

/* Sums of a row: each sample twice, and its neighbours. Beyond the faces of the volume there are no
 * labels, so a face that cuts one is lit like another surface. */
static void sum_along(uint16_t *to, const uint16_t *from, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] = (uint16_t)((i ? from[i - 1] : 0) + 2 * from[i] + (i + 1 < count ? from[i + 1] : 0));
}

/* Sums of a row with the rows before and behind it; NULL: there is none. */
static void sum_across(uint16_t *to, const uint16_t *before, const uint16_t *here,
                       const uint16_t *behind, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] = (uint16_t)((before ? before[i] : 0) + 2 * here[i] + (behind ? behind[i] : 0));
}

/* Blurs along one axis. */
static void blur(cvol_context *context, uint16_t *to, const uint16_t *from, const size_t n[3],
                 int axis)
{
    const size_t width = n[0], away = axis == 1 ? width : width * n[1];
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t row = 0; row < n[1] * n[2]; row++) {
        const size_t at = axis == 1 ? row % n[1] : row / n[1];
        const uint16_t *here = from + row * width;
        if (axis == 0)
            sum_along(to + row * width, here, width);
        else
            sum_across(to + row * width, at ? here - away : NULL, here,
                       at + 1 < n[axis] ? here + away : NULL, width);
    }
}

/* The shape, of 255, at a sample with or without a label, from the blurred mask. */
static uint8_t level_of(uint32_t sum, int is_label)
{
    const int level = (int)((255 * sum + WEIGHTS / 2) / WEIGHTS);
    if (!is_label)
        return (uint8_t)(level < BELOW ? level : BELOW);
    if (level >= ABOVE)
        return (uint8_t)level;
    const int raised = ABOVE + 2 * (ABOVE - level);
    return (uint8_t)(raised < LEAST ? raised : LEAST);
}

/* `sums` has room for two volumes. */
static void find_mask(cvol_context *context, uint8_t *out, uint16_t *sums, const uint8_t *labels,
                      const size_t n[3])
{
    const size_t count = n[0] * n[1] * n[2];
    uint16_t *now = sums, *next = sums + count;
    for (size_t i = 0; i < count; i++)
        now[i] = labels[i] != 0;
    for (int pass = 0; pass < 3 * REPEATED; pass++) {
        blur(context, next, now, n, pass % 3);
        uint16_t *const last = now;
        now = next;
        next = last;
    }
    for (size_t i = 0; i < count; i++)
        out[i] = level_of(now[i], labels[i] != 0);
}

int cvol_labels_create_mask(cvol_context *context, cvol_volume **out, const cvol_volume *labels)
{
    cvol_grid grid = labels->grid;
    *out = NULL;
    if (grid.type != CVOL_UINT8)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "labels are of another type than uint8");
    grid.value_scale = 1;
    grid.value_offset = 0;
    const size_t count = cvol_grid_samples(&grid);
    uint16_t *sums = cvol_allocate(2 * count, sizeof *sums);
    if (!sums)
        return cvol_fail_memory(context, 2 * count * sizeof *sums, "the shape of labels");
    const int code = cvol_volume_create(context, out, &grid);
    if (!code)
        find_mask(context, (*out)->data, sums, labels->data, grid.dims);
    free(sums);
    return code;
}

int cvol_labels_create_shape(cvol_context *context, cvol_array **out, const cvol_volume *labels)
{
    const cvol_keep keep = cvol_keep_threshold(TERM_LEAST);
    cvol_volume *mask;
    *out = NULL;
    int code = cvol_labels_create_mask(context, &mask, labels);
    if (!code)
        code = cvol_array_compress(context, out, mask->data, &mask->grid, 3, CVOL_DCT, 8, &keep);
    cvol_volume_free(mask);
    return code;
}

int cvol_labels_create_mask_transfer(cvol_context *context, cvol_transfer **out)
{
    static const cvol_transfer_point points[] = {
        {0, 1, 1, 1, 0}, {127.5, 1, 1, 1, 0}, {127.5, 1, 1, 1, OPACITY}, {255, 1, 1, 1, OPACITY}};
    return cvol_transfer_create(context, out, points, sizeof points / sizeof *points);
}
