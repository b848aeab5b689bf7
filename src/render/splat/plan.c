/* The positions of samples in the picture, and the order of slices. */
#include <math.h>

#include "render/splat/frame.h"

void cvol_splat_plan_make(cvol_splat_plan *plan, const cvol_grid *grid, const cvol_view *view)
{
    int c = 0;
    for (int a = 1; a < 3; a++)
        if (fabs(view->eye[a]) / grid->spacing[a] > fabs(view->eye[c]) / grid->spacing[c])
            c = a;
    plan->axis_slice = c;
    plan->axis_lane = c == 0 ? 1 : 0;
    plan->axis_row = c == 2 ? 1 : 2;
    plan->lanes = grid->dims[plan->axis_lane];
    plan->rows = grid->dims[plan->axis_row];
    plan->slices = grid->dims[c];
    plan->rising = view->eye[c] < 0;
    plan->distance = grid->spacing[c] / fabs(view->eye[c]) / view->mean_spacing;
    plan->origin[0] = view->width / 2.0 - 0.5;
    plan->origin[1] = view->height / 2.0 - 0.5;
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_slice};
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        plan->along[k][0] = grid->spacing[a] * view->right[a] / view->pixel;
        plan->along[k][1] = -grid->spacing[a] * view->up[a] / view->pixel;
        plan->origin[0] -= view->centre[a] * view->right[a] / view->pixel;
        plan->origin[1] += view->centre[a] * view->up[a] / view->pixel;
    }
}
