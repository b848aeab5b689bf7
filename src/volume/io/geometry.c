/* The directions of axes in the world. */
#include "volume/io/geometry.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/unit.h"

/* |v| without overflow, and exact for vectors along one axis. */
static double length_of(const double v[3])
{
    double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0) || !isfinite(largest))
        return largest;
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += (v[i] / largest) * (v[i] / largest);
    return largest * sqrt(sum);
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

int cvol_geometry_set_axis(cvol_grid *grid, int axis, const double step[3])
{
    double length = length_of(step);
    if (!(length > 0) || !isfinite(length) || !isfinite(step[0] + step[1] + step[2]))
        return 0;
    grid->spacing[axis] = length;
    for (int i = 0; i < 3; i++)
        grid->direction[axis][i] = step[i] / length;
    return 1;
}

int cvol_geometry_set_direction(cvol_grid *grid, int axis, const double vector[3])
{
    double spacing = grid->spacing[axis];
    if (!cvol_geometry_set_axis(grid, axis, vector))
        return 0;
    grid->spacing[axis] = spacing;
    return 1;
}

void cvol_geometry_complete(cvol_grid *grid, const int known[3])
{
    int count = known[0] + known[1] + known[2];
    if (count == 0 || count == 3)
        return;
    int first = known[0] ? 0 : known[1] ? 1 : 2; /* the first known axis */
    int missing = !known[2] ? 2 : !known[1] ? 1 : 0;
    double vector[3];
    if (count == 1) {
        /* Any perpendicular is valid for one of the two: start from the least aligned world
         * axis. */
        const double *d = grid->direction[first];
        int least = 0;
        for (int i = 1; i < 3; i++)
            if (fabs(d[i]) < fabs(d[least]))
                least = i;
        double unit[3] = {least == 0, least == 1, least == 2};
        cross(vector, d, unit);
        cvol_geometry_set_direction(grid, 3 - first - missing, vector);
    }
    cross(vector, grid->direction[(missing + 1) % 3], grid->direction[(missing + 2) % 3]);
    cvol_geometry_set_direction(grid, missing, vector);
}

int cvol_geometry_check(cvol_context *context, const cvol_grid *grid, const char *name)
{
    double normal[3], volume = 0;
    cross(normal, grid->direction[0], grid->direction[1]);
    for (int i = 0; i < 3; i++)
        volume += normal[i] * grid->direction[2][i];
    if (fabs(volume) > 1e-6)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: the directions of its axes do not span the space (determinant %g)", name,
                     volume);
}

void cvol_geometry_mirror(cvol_grid *grid, int world_axis)
{
    /* 0 - x rather than -x: no negative zeros in headers. */
    grid->origin[world_axis] = 0 - grid->origin[world_axis];
    for (int a = 0; a < 3; a++)
        grid->direction[a][world_axis] = 0 - grid->direction[a][world_axis];
}

cvol_grid cvol_geometry_in_space(const cvol_grid *grid, cvol_space space)
{
    cvol_grid result = *grid;
    result.space = space;
    if (grid->space != space && grid->space != CVOL_SPACE_UNKNOWN && space != CVOL_SPACE_UNKNOWN) {
        cvol_geometry_mirror(&result, 0);
        cvol_geometry_mirror(&result, 1);
    }
    return result;
}

cvol_grid cvol_geometry_in_unit(const cvol_grid *grid, const char *const *kept, size_t count)
{
    const double metres = cvol_unit_metres(grid->unit);
    const char *const to = metres < 1e-3 ? "um" : "mm";
    const char *const units[3] = {to, grid->unit, grid->unit};
    cvol_grid out = *grid;
    double factor[3];
    for (size_t i = 0; i < count; i++)
        if (!strcmp(kept[i], grid->unit))
            return out;
    if (!(metres > 0) || !cvol_unit_factors(factor, out.unit, units))
        return out;
    for (int i = 0; i < 3; i++) {
        out.spacing[i] *= factor[1];
        out.origin[i] *= factor[1];
    }
    return out;
}
