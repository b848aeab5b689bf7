/* Plans whose rays are those of the picture's pixels: nothing is resampled between the sheets and
 * the picture.
 *
 * Lacroute and Levoy's intermediate image has lines along rows of samples, which is what makes them
 * cheap; the warp that follows interpolates between its pixels. Where opacity is high, a picture
 * has detail as fine as its pixels, which no interpolation gives: so here lines are those of the
 * picture, or its columns, whichever run more along the rows of samples, and cross these at a slant
 * (line_slanted.h). The warp that is left copies, and turns where it has to. Kernels draw
 * CVOL_SQUARE lines at once, square by square.
 */
#include <math.h>

#include "render/sheet/frame/plan.h"

/* Kernels count places along a group in 16 bits; and so far apart all rays are alike. */
#define MOST_SAMPLES 64
/* With light, a group's samples of a row, and one beside them, lie within 64: so far apart are its
 * pixels, and those of a line and the next one together. */
#define MOST_LIT_SAMPLES 3.9
#define MOST_LIT_REACH 19

/* How many rows of samples a line along one axis of the picture crosses from sample to sample. */
static double image_order_of(const cvol_sheet_plan *plan, int axis)
{
    const double lane = fabs(plan->warp[0][1 + axis]) / plan->pitch_lane,
                 row = fabs(plan->warp[1][1 + axis]) / plan->pitch_row;
    return lane > 1e-6 * row ? row / lane : INFINITY;
}

int cvol_sheet_plan_image_order(cvol_sheet_plan *plan, const cvol_view *view)
{
    const int along = image_order_of(plan, 0) <= image_order_of(plan, 1) ? 0 : 1,
              across = 1 - along;
    const int sizes[2] = {view->width, view->height};
    const int axes[2] = {along, across};
    if (isinf(image_order_of(plan, along)))
        return 0;
    for (int k = 0; k < 4; k++)
        if (!(fabs(plan->warp[k & 1][1 + k / 2]) < MOST_SAMPLES))
            return 0;
    cvol_sheet_refine(plan);
    double warp[2][3] = {{0}};
    for (int k = 0; k < 2; k++) {
        plan->place[k][0] = plan->warp[k][0];
        plan->place[k][1] = plan->warp[k][1 + along];
        plan->place[k][2] = plan->warp[k][1 + across];
    }
    /* Lanes rise along lines, rows from line to line. */
    for (int a = 0; a < 2; a++) {
        const int last = sizes[axes[a]] - 1, turns = plan->place[a][1 + a] < 0;
        for (int k = 0; k < 2 && turns; k++) {
            plan->place[k][0] += last * plan->place[k][1 + a];
            plan->place[k][1 + a] *= -1;
        }
        warp[a][0] = turns ? last : 0;
        warp[a][1 + axes[a]] = turns ? -1 : 1;
    }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++)
            plan->warp[k][i] = warp[k][i];
    if (plan->lit &&
        (plan->place[0][1] + fabs(plan->place[0][2]) > MOST_LIT_REACH * plan->pitch_lane ||
         plan->place[0][1] > MOST_LIT_SAMPLES * plan->pitch_lane ||
         fabs(plan->place[1][1]) > MOST_LIT_SAMPLES * plan->pitch_row))
        return 0;
    plan->image_order = 1;
    plan->u0 = plan->v0 = 0;
    plan->du = plan->dv = 1;
    plan->width = (sizes[along] + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    plan->height = (sizes[across] + CVOL_SQUARE - 1) / CVOL_SQUARE * CVOL_SQUARE;
    return 1;
}
