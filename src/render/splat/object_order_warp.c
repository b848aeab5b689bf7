/* From the lattice to the picture (object_order.h). */
#include "image/spline_warp.h"
#include "render/splat/object_order.h"

void cvol_lattice_matrix(double out[2][3], const cvol_lattice *lattice, const cvol_splat_plan *plan)
{
    const double(*along)[2] = plan->along;
    const double determinant = along[0][0] * along[1][1] - along[0][1] * along[1][0];
    const double scale = 1 / (determinant * lattice->step);
    const double rows[2][2] = {{along[1][1] * scale, -along[1][0] * scale},
                               {-along[0][1] * scale, along[0][0] * scale}};
    for (int a = 0; a < 2; a++) {
        out[a][0] = rows[a][0];
        out[a][1] = rows[a][1];
        out[a][2] = lattice->base[a] / lattice->step - plan->origin[0] * rows[a][0] -
                    plan->origin[1] * rows[a][1];
    }
}

int cvol_lattice_warp(cvol_context *context, cvol_image *image, float *pixels,
                      const cvol_lattice *lattice, const cvol_splat_plan *plan,
                      const double background[3])
{
    double to_lattice[2][3];
    cvol_lattice_matrix(to_lattice, lattice, plan);
    return cvol_spline_warp(context, image, pixels, lattice->dims, (const double(*)[3])to_lattice,
                            background);
}
