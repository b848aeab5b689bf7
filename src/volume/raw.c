/* Raw samples: a file of nothing else, x fastest; dims, type, byte order and spacing come from
 * whoever reads it. Written little-endian. */
#include "base/context.h"
#include "volume/format.h"

static int check_options(cvol_context *context, const char *path, const cvol_read_options *o)
{
    int has_dims = o->dims[0] && o->dims[1] && o->dims[2], has_type = cvol_type_size(o->type) > 0;
    if (has_dims && has_type)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: raw samples need %s%s%s", path,
                     has_dims ? "" : "--dims NXxNYxNZ", has_dims || has_type ? "" : " and ",
                     has_type ? "" : "--type");
}

static int find_raw(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    int code = check_options(context, path, options);
    if (code)
        return code;
    *grid = cvol_grid_make(options->dims[0], options->dims[1], options->dims[2], options->type);
    stored->big_endian = options->big_endian != 0;
    stored->undescribed = 1;
    return CVOL_OK;
}

static int plan_raw(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                    const char *path)
{
    (void)context, (void)grid, (void)path;
    plan->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}

const cvol_format cvol_format_raw = {
    .name = "raw",
    .endings = {".raw"},
    .find = find_raw,
    .plan = plan_raw,
    .needs_options = 1,
};
