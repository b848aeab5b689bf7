/* Plans in image order: rays go through the picture's pixels, so nothing is resampled between the
 * slices and the picture.
 *
 * In Lacroute and Levoy's intermediate image, lines run along rows of samples, which makes them
 * cheap; the warp that follows interpolates between its pixels. At high opacity, a picture has
 * detail as fine as its pixels, which interpolation loses. Here lines are the rows or the columns
 * of the picture, whichever run more along the rows of samples, and cross these obliquely
 * (line_slanted.h). The warp only copies, and transposes if necessary. Kernels draw CVOL_SQUARE
 * lines together, square by square. */
#include <math.h>

#include "render/sheet/frame/plan.h"

/* Kernels count places along a group in 16 bits; at this distance all rays look the same. */
#define MAX_SAMPLES 64
/* From int16 samples and with light, the samples of a group in a row, and one more on each side,
 * lie within 64. This limits the distance of its pixels, and the sum of the distances along a line
 * and between lines. */
#define MAX_LIT_SAMPLES 3.9
#define MAX_LIT_REACH 19

/* The rows of samples that a line along one axis of the picture crosses per sample. */
static double image_order_of(const cvol_sheet_plan *plan, int axis)
{
    const double lane = fabs(plan->warp[0][1 + axis]) / plan->pitch_lane,
                 row = fabs(plan->warp[1][1 + axis]) / plan->pitch_row;
    return lane > 1e-6 * row ? row / lane : INFINITY;
}

int cvol_sheet_plan_image_order(cvol_sheet_plan *plan, const cvol_view *view, double coarsest)
{
    const int along = image_order_of(plan, 0) <= image_order_of(plan, 1) ? 0 : 1,
              across = 1 - along;
    const int sizes[2] = {view->width, view->height};
    const int axes[2] = {along, across};
    if (isinf(image_order_of(plan, along)))
        return 0;
    for (int k = 0; k < 4; k++)
        if (!(fabs(plan->warp[k & 1][1 + k / 2]) < MAX_SAMPLES))
            return 0;
    cvol_sheet_refine(plan, coarsest);
    double warp[2][3] = {{0}};
    int before[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        plan->place[k][0] = plan->warp[k][0];
        plan->place[k][1] = plan->warp[k][1 + along];
        plan->place[k][2] = plan->warp[k][1 + across];
    }
    /* Lanes rise along lines, rows from line to line. */
    for (int a = 0; a < 2; a++) {
        const int last = sizes[axes[a]] - 1, is_reversed = plan->place[a][1 + a] < 0;
        for (int k = 0; k < 2 && is_reversed; k++) {
            plan->place[k][0] += last * plan->place[k][1 + a];
            plan->place[k][1 + a] *= -1;
        }
        /* Groups of pixels begin where those of the whole picture do. */
        if (axes[a] == 1)
            before[a] = (is_reversed ? view->all_rows - view->first_row - view->height
                                     : view->first_row) %
                        CVOL_GROUP;
        for (int k = 0; k < 2; k++)
            plan->place[k][0] -= before[a] * plan->place[k][1 + a];
        warp[a][0] = (is_reversed ? last : 0) + before[a];
        warp[a][1 + axes[a]] = is_reversed ? -1 : 1;
    }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++)
            plan->warp[k][i] = warp[k][i];
    plan->image_order = 1;
    plan->u0 = plan->v0 = 0;
    plan->du = plan->dv = 1;
    plan->width = (sizes[along] + before[0] + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    plan->height = (sizes[across] + before[1] + CVOL_SQUARE - 1) / CVOL_SQUARE * CVOL_SQUARE;
    return 1;
}

int cvol_sheet_plan_fits_lit_int16(const cvol_sheet_plan *plan)
{
    return plan->place[0][1] + fabs(plan->place[0][2]) <= MAX_LIT_REACH * plan->pitch_lane &&
           plan->place[0][1] <= MAX_LIT_SAMPLES * plan->pitch_lane &&
           fabs(plan->place[1][1]) <= MAX_LIT_SAMPLES * plan->pitch_row;
}
