/* Section BAKE: a record, and the points of the transfer function. */
#include "codec/container/baked_head.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"

enum { POINTS_MAX = 65536, DIMS_MAX = 65536 };

void cvol_baked_head_put(cvol_bytes *out, const cvol_baked_file *file)
{
    const cvol_splat_options *splat = &file->splat;
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_u32(out, (uint32_t)file->grid.dims[a]);
    cvol_bytes_put_u32(out, (uint32_t)file->grid.type);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, file->grid.spacing[a]);
    cvol_bytes_put_u32(out, (uint32_t)file->axis);
    cvol_bytes_put_u32(out, (uint32_t)file->transform);
    cvol_bytes_put_u32(out, (uint32_t)file->tile);
    cvol_bytes_put_u32(out, (uint32_t)file->channels);
    cvol_bytes_put_u32(out, (uint32_t)file->shading.on);
    cvol_bytes_put_u32(out, (uint32_t)splat->footprint);
    cvol_bytes_put_u32(out, (uint32_t)splat->size);
    cvol_bytes_put_u32(out, (uint32_t)file->point_count);
    cvol_bytes_put_f64(out, file->distance);
    cvol_bytes_put_f64(out, file->rho);
    cvol_bytes_put_f64(out, file->step);
    cvol_bytes_put_f64(out, splat->sigma);
    for (int a = 0; a < 3; a++)
        cvol_bytes_put_f64(out, file->shading.light[a]);
    cvol_bytes_append(out, file->transfer_name, sizeof file->transfer_name);
    for (size_t i = 0; i < file->point_count; i++) {
        const cvol_transfer_point *p = &file->points[i];
        const double fields[] = {p->value, p->r, p->g, p->b, p->opacity};
        for (int k = 0; k < 5; k++)
            cvol_bytes_put_f64(out, fields[k]);
    }
}

static int fail(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section BAKE: %s", name, what);
}

/* Reads the volume's shape; returns an error text, or NULL. */
static const char *take_grid(cvol_baked_file *out, cvol_cursor *content)
{
    uint32_t dims[3];
    int sound = 1;
    for (int a = 0; a < 3; a++) {
        dims[a] = cvol_cursor_u32(content);
        sound &= dims[a] > 0 && dims[a] <= DIMS_MAX;
    }
    const uint32_t type = cvol_cursor_u32(content);
    if (content->failed)
        return "is too short";
    if (!sound)
        return "a dimension is 0, or beyond 65536";
    if (type < CVOL_UINT8 || type > CVOL_FLOAT64)
        return "the sample type is unknown";
    out->grid = cvol_grid_make(dims[0], dims[1], dims[2], (cvol_type)type);
    for (int a = 0; a < 3; a++) {
        out->grid.spacing[a] = cvol_cursor_f64(content);
        sound &= out->grid.spacing[a] > 1e-30 && out->grid.spacing[a] < 1e30;
    }
    return content->failed ? "is too short" : sound ? NULL : "a spacing is invalid";
}

static const char *take_choices(cvol_baked_file *out, uint32_t *points, cvol_cursor *content)
{
    uint32_t fields[8];
    for (int i = 0; i < 8; i++)
        fields[i] = cvol_cursor_u32(content);
    if (content->failed)
        return "is too short";
    if (fields[0] > 2)
        return "the axis must be 0, 1 or 2";
    if (fields[1] != CVOL_DCT)
        return "the transform must be 1, a DCT";
    if (fields[2] != 0 && fields[2] != 8 && fields[2] != 16 && fields[2] != 32)
        return "the side of tiles must be 0, 8, 16 or 32";
    if (fields[3] != 1 && fields[3] != 3)
        return "there must be one or three channels";
    if (fields[4] > 1)
        return "lit must be 0 or 1";
    if (fields[5] < CVOL_FOOTPRINT_GAUSSIAN || fields[5] > CVOL_FOOTPRINT_BOX ||
        fields[5] == CVOL_FOOTPRINT_CONE)
        return "the footprint must be a Gaussian, a sinc or a box";
    if (fields[6] < 3 || fields[6] > 31)
        return "the footprint's size must be 3 to 31";
    if (!fields[7] || fields[7] > POINTS_MAX)
        return "there must be 1 to 65536 points of the transfer function";
    out->axis = (int)fields[0];
    out->transform = CVOL_DCT;
    out->tile = (int)fields[2];
    out->channels = (int)fields[3];
    out->splat.order = CVOL_ORDER_FRONT;
    out->splat.plane = CVOL_FOOTPRINT_IN_SLICES;
    out->shading.on = (int)fields[4];
    out->splat.footprint = (cvol_footprint)fields[5];
    out->splat.size = (int)fields[6];
    *points = fields[7];
    return NULL;
}

static const char *take_numbers(cvol_baked_file *out, cvol_cursor *content)
{
    out->distance = cvol_cursor_f64(content);
    out->rho = cvol_cursor_f64(content);
    out->step = cvol_cursor_f64(content);
    out->splat.sigma = cvol_cursor_f64(content);
    int sound = out->distance > 1e-6 && out->distance < 1e6 && out->rho > 0 && out->rho <= 1 &&
                out->step > 0 && out->step <= 1e30 &&
                (out->splat.sigma == 0 || (out->splat.sigma >= 0.2 && out->splat.sigma <= 31));
    for (int a = 0; a < 3; a++) {
        out->shading.light[a] = cvol_cursor_f64(content);
        sound &= fabs(out->shading.light[a]) <= 1e30;
    }
    const uint8_t *name = cvol_cursor_take(content, sizeof out->transfer_name);
    if (!name)
        return "is too short";
    memcpy(out->transfer_name, name, sizeof out->transfer_name);
    for (size_t i = 0; i < sizeof out->transfer_name && name[i]; i++)
        sound &= name[i] > ' ' && name[i] <= '~';
    sound &= !name[sizeof out->transfer_name - 1];
    return sound ? NULL : "has a number or name that is invalid or out of range";
}

static int take_points(cvol_context *context, cvol_baked_file *out, uint32_t count,
                       cvol_cursor *content, const char *name)
{
    if (cvol_cursor_left(content) < 40 * (size_t)count)
        return fail(context, name, "is too short");
    out->points = cvol_allocate(count, sizeof *out->points);
    if (!out->points)
        return cvol_fail_memory(context, count * sizeof *out->points, "a transfer function");
    out->point_count = count;
    double before = -(double)INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        double fields[5];
        int sound = 1;
        for (int k = 0; k < 5; k++)
            fields[k] = cvol_cursor_f64(content);
        for (int k = 1; k < 5; k++)
            sound &= fields[k] >= 0 && fields[k] <= 1;
        if (!sound || !isfinite(fields[0]) || fields[0] < before)
            return fail(context, name, "a point of the transfer function is invalid");
        out->points[i] = (cvol_transfer_point){fields[0], fields[1], fields[2], fields[3],
                                               fields[4]};
        before = fields[0];
    }
    return CVOL_OK;
}

int cvol_baked_head_take(cvol_context *context, cvol_baked_file *out, cvol_cursor *content,
                         const char *name)
{
    uint32_t points = 0;
    const char *wrong = take_grid(out, content);
    if (!wrong)
        wrong = take_choices(out, &points, content);
    if (!wrong)
        wrong = take_numbers(out, content);
    if (wrong)
        return fail(context, name, wrong);
    out->slices = out->grid.dims[out->axis];
    int code = cvol_grid_check_file(context, &out->grid, name);
    return code ? code : take_points(context, out, points, content, name);
}
