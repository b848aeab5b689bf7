/* Sample types and grids: names, sizes and checks. */
#include "cvol/base.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"

static const struct {
    const char *name;
    size_t size;
    int is_integer;
} types[] = {
    [CVOL_UINT8] = {"uint8", 1, 1},     [CVOL_INT8] = {"int8", 1, 1},
    [CVOL_UINT16] = {"uint16", 2, 1},   [CVOL_INT16] = {"int16", 2, 1},
    [CVOL_UINT32] = {"uint32", 4, 1},   [CVOL_INT32] = {"int32", 4, 1},
    [CVOL_FLOAT32] = {"float32", 4, 0}, [CVOL_FLOAT64] = {"float64", 8, 0},
};

static int is_type(cvol_type type)
{
    return (int)type >= CVOL_UINT8 && (int)type <= CVOL_FLOAT64;
}

size_t cvol_type_size(cvol_type type)
{
    return is_type(type) ? types[type].size : 0;
}

const char *cvol_type_name(cvol_type type)
{
    return is_type(type) ? types[type].name : NULL;
}

cvol_type cvol_type_from_name(const char *name)
{
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++)
        if (!strcmp(name, types[type].name))
            return (cvol_type)type;
    return (cvol_type)0;
}

int cvol_type_is_integer(cvol_type type)
{
    return is_type(type) && types[type].is_integer;
}

void cvol_type_get_range(double *least, double *largest, cvol_type type)
{
    static const double ranges[][2] = {
        [CVOL_UINT8] = {0, UINT8_MAX},
        [CVOL_INT8] = {INT8_MIN, INT8_MAX},
        [CVOL_UINT16] = {0, UINT16_MAX},
        [CVOL_INT16] = {INT16_MIN, INT16_MAX},
        [CVOL_UINT32] = {0, UINT32_MAX},
        [CVOL_INT32] = {INT32_MIN, INT32_MAX},
        [CVOL_FLOAT32] = {-(double)FLT_MAX, (double)FLT_MAX},
        [CVOL_FLOAT64] = {-DBL_MAX, DBL_MAX},
    };
    *least = ranges[type][0];
    *largest = ranges[type][1];
}

cvol_grid cvol_grid_make(size_t nx, size_t ny, size_t nz, cvol_type type)
{
    cvol_grid grid = {
        .dims = {nx, ny, nz},
        .type = type,
        .spacing = {1, 1, 1},
        .direction = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
        .value_scale = 1,
    };
    return grid;
}

int cvol_grid_check(cvol_context *context, const cvol_grid *grid, const char *name)
{
    const int code = cvol_grid_check_file(context, grid, name);
    return code == CVOL_ERROR_FORMAT ? CVOL_ERROR_ARGUMENT : code;
}

int cvol_grid_check_file(cvol_context *context, const cvol_grid *grid, const char *name)
{
    return cvol_grid_check_within(context, grid, name, context->limit_bytes);
}

int cvol_grid_check_within(cvol_context *context, const cvol_grid *grid, const char *name,
                           uint64_t limit_bytes)
{
    if (!is_type(grid->type))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %d is not a sample type", name,
                         (int)grid->type);
    size_t bytes = cvol_type_size(grid->type);
    int fits = 1;
    for (int a = 0; a < 3; a++) {
        if (grid->dims[a] == 0)
            return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: axis %c has 0 samples", name,
                             "xyz"[a]);
        fits = fits && cvol_size_multiply(&bytes, bytes, grid->dims[a]);
    }
    if (!fits || bytes > limit_bytes)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: %zu x %zu x %zu samples of %s are more than the limit of %llu bytes",
                         name, grid->dims[0], grid->dims[1], grid->dims[2],
                         cvol_type_name(grid->type),
                         (unsigned long long)(limit_bytes < SIZE_MAX ? limit_bytes : SIZE_MAX));
    for (int a = 0; a < 3; a++) {
        if (!(grid->spacing[a] > 0) || !isfinite(grid->spacing[a]))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: spacing of axis %c is %g, must be positive", name, "xyz"[a],
                             grid -> spacing[a]);
        if (!isfinite(grid->origin[a]))
            return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: origin has the value %g", name,
                             grid->origin[a]);
        for (int i = 0; i < 3; i++)
            if (!isfinite(grid->direction[a][i]))
                return cvol_fail(context, CVOL_ERROR_FORMAT,
                                 "%s: direction of axis %c has the value %g", name, "xyz"[a],
                                 grid -> direction[a][i]);
    }
    if (!isfinite(grid->value_scale) || !isfinite(grid->value_offset))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: value scale %g or offset %g is not finite", name, grid->value_scale,
                         grid->value_offset);
    if (!(fabs(grid->value_scale) > 0))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: value scale is 0, must be positive or negative", name);
    if ((int)grid->space < CVOL_SPACE_UNKNOWN || (int)grid->space > CVOL_SPACE_RAS)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: space is %d, must be 0, 1 or 2", name,
                         (int)grid->space);
    if (!memchr(grid->unit, '\0', sizeof grid->unit))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: unit '%.16s' has 16 bytes without an end, at most 15 are possible",
                         name, grid->unit);
    return CVOL_OK;
}

cvol_grid cvol_grid_box(const cvol_grid *grid, const size_t begin[3], const size_t end[3])
{
    cvol_grid box = *grid;
    for (int a = 0; a < 3; a++) {
        box.dims[a] = end[a] - begin[a];
        for (int i = 0; i < 3; i++)
            box.origin[i] += grid->direction[a][i] * grid->spacing[a] * (double)begin[a];
    }
    return box;
}

size_t cvol_grid_samples(const cvol_grid *grid)
{
    return grid->dims[0] * grid->dims[1] * grid->dims[2];
}

size_t cvol_grid_bytes(const cvol_grid *grid)
{
    return cvol_grid_samples(grid) * cvol_type_size(grid->type);
}
