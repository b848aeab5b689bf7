/* Geometry and values of images of MINC 2.
 *
 * A dimension has a start and a step along its direction cosines, in millimetres; x runs to the
 * right, y to the front, z up. Stored integers from valid[0] to valid[1] mean the real values from
 * `least` to `most`, which each slice may have by itself. Floats are values. */
#include "volume/formats/minc.h"

#include <math.h>
#include <stdio.h>

#include "base/context.h"
#include "base/for_type.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"

/* ---- geometry ------------------------------------------------------------------------- */

static int set_geometry(cvol_context *context, cvol_grid *grid, const cvol_hdf5_minc *minc,
                        const cvol_axes *axes, const char *name)
{
    cvol_grid in_space = *grid;
    for (int i = 0; i < 3; i++)
        in_space.origin[i] = 0;
    for (int a = 0; a < 3; a++) {
        const int axis = axes->of[a];
        if (axis < 0 || !minc->dimension[axis].is_spatial)
            return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: of its image in MINC the axis %d is not one of space", name,
                             axis);
        const cvol_hdf5_dimension *d = &minc->dimension[axis];
        const double step[3] = {d->step * d->cosines[0], d->step * d->cosines[1],
                                d->step * d->cosines[2]};
        if (d->is_irregular)
            return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: axis %d of its image in MINC has irregular spacing", name, axis);
        if (!cvol_geometry_set_axis(&in_space, a, step))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: axis %d of its image in MINC has the step %g", name, axis,
                             d->step);
        for (int i = 0; i < 3; i++)
            in_space.origin[i] += d->start * d->cosines[i];
    }
    *grid = in_space;
    grid->space = CVOL_SPACE_RAS;
    snprintf(grid->unit, sizeof grid->unit, "mm");
    return cvol_geometry_check(context, grid, name);
}

/* ---- values --------------------------------------------------------------------------- */

/* A sample s of the slice means slope s + offset. */
static void slope_of(double *slope, double *offset, const cvol_hdf5_minc *minc, size_t slice)
{
    const double range = minc->valid[1] - minc->valid[0];
    *slope = (minc->most[slice] - minc->least[slice]) / range;
    *offset = minc->least[slice] - minc->valid[0] * *slope;
}

static size_t count_slices(const cvol_hdf5_shape *shape)
{
    size_t count = 1;
    for (int i = 0; i < shape->minc.scaled; i++)
        count *= (size_t)shape->dims[i];
    return count;
}

static int has_one_scale(const cvol_hdf5_shape *shape)
{
    const cvol_hdf5_minc *minc = &shape->minc;
    const size_t slices = count_slices(shape);
    for (size_t i = 1; i < slices; i++)
        if (minc->least[i] != minc->least[0] || minc->most[i] != minc->most[0])
            return 0;
    return 1;
}

int cvol_minc_complete(cvol_context *context, cvol_grid *grid, cvol_minc_scale *scale,
                       const cvol_hdf5_shape *shape, const cvol_axes *axes, const char *name)
{
    const cvol_hdf5_minc *minc = &shape->minc;
    *scale = (cvol_minc_scale){.stored = grid->type};
    int code = set_geometry(context, grid, minc, axes, name);
    if (code || !minc->least || !cvol_type_is_integer(grid->type))
        return code;
    if (!(minc->valid[1] > minc->valid[0]) || !isfinite(minc->valid[1] - minc->valid[0]))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: valid_range of its image in MINC is %g to %g", name, minc->valid[0],
                         minc->valid[1]);
    const size_t slices = count_slices(shape);
    for (size_t i = 0; i < slices; i++)
        if (!isfinite(minc->least[i]) || !isfinite(minc->most[i]))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: slice %zu of its image in MINC has values from %g to %g", name, i,
                             minc->least[i], minc->most[i]);
    if (has_one_scale(shape)) {
        double slope, offset;
        slope_of(&slope, &offset, minc, 0);
        grid->value_scale = slope != 0 ? slope : 1; /* 0: an image of one value */
        grid->value_offset = offset;
        scale->is_by_slice = !(slope < 0) && !(slope > 0);
    } else if (minc->scaled > axes->of[2] + 1)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: rows of its image in MINC have different scales", name);
    else
        scale->is_by_slice = 1;
    if (scale->is_by_slice) {
        grid->type = cvol_type_size(grid->type) < 4 ? CVOL_FLOAT32 : CVOL_FLOAT64;
        grid->value_scale = 1;
        grid->value_offset = 0;
    }
    return CVOL_OK;
}

void cvol_minc_convert(void *out, cvol_type type, const void *samples, cvol_type stored,
                       size_t count, const cvol_hdf5_minc *minc, const cvol_axes *axes, size_t z)
{
    size_t slice = 0;
    double slope, offset;
    for (int i = 0; i < minc->scaled; i++)
        slice = slice * (size_t)axes->dims[i] + (i == axes->of[2] ? z : (size_t)axes->begin[i]);
    slope_of(&slope, &offset, minc, slice);
#define CONVERT(t)                                                                           \
    for (size_t i = 0; i < count; i++) {                                                     \
        const double s = (double)((const t *)samples)[i];                                    \
        const double value = offset + slope * fmin(fmax(s, minc->valid[0]), minc->valid[1]); \
        if (type == CVOL_FLOAT32)                                                            \
            ((float *)out)[i] = (float)value;                                                \
        else                                                                                 \
            ((double *)out)[i] = value;                                                      \
    }
    CVOL_FOR_TYPE(stored, CONVERT);
#undef CONVERT
}
