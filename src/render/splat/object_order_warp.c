/* From the lattice to the picture (object_order.h). */
#include "image/spline_warp.h"
#include "render/splat/object_order.h"

void cvol_intermediate_grid_matrix(double out[2][3], const cvol_intermediate_grid *image_grid,
                                   const cvol_splat_plan *plan)
{
    const double(*along)[2] = plan->along;
    const double determinant = along[0][0] * along[1][1] - along[0][1] * along[1][0];
    const double scale = 1 / (determinant * image_grid->step);
    const double rows[2][2] = {{along[1][1] * scale, -along[1][0] * scale},
                               {-along[0][1] * scale, along[0][0] * scale}};
    for (int a = 0; a < 2; a++) {
        out[a][0] = rows[a][0];
        out[a][1] = rows[a][1];
        out[a][2] = image_grid->base[a] / image_grid->step - plan->origin[0] * rows[a][0] -
                    plan->origin[1] * rows[a][1];
    }
}

int cvol_intermediate_grid_warp(cvol_context *context, cvol_image *image, float *pixels,
                                const cvol_intermediate_grid *image_grid,
                                const cvol_splat_plan *plan, const double background[3])
{
    double to_intermediate[2][3];
    cvol_intermediate_grid_matrix(to_intermediate, image_grid, plan);
    return cvol_spline_warp(context, image, pixels, image_grid->dims,
                            (const double(*)[3])to_intermediate, background);
}
