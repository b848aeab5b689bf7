/* Raw samples: a file of nothing else, x fastest; dims, type, byte order and spacing come from
 * whoever reads it. Written little-endian. */
#include <stdio.h>

#include "base/context.h"
#include "base/file.h"
#include "volume/dense.h"
#include "volume/format.h"
#include "volume/input.h"
#include "volume/stored.h"

static int check_options(cvol_context *context, const char *path, const cvol_read_options *o)
{
    int has_dims = o->dims[0] && o->dims[1] && o->dims[2], has_type = cvol_type_size(o->type) > 0;
    if (has_dims && has_type)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: raw samples need %s%s%s", path,
                     has_dims ? "" : "--dims NXxNYxNZ", has_dims || has_type ? "" : " and ",
                     has_type ? "" : "--type");
}

static int check_size(cvol_context *context, const char *path, const cvol_grid *grid)
{
    cvol_input input;
    int code = cvol_input_open(context, &input, path);
    cvol_input_close(&input);
    size_t bytes = cvol_grid_bytes(grid);
    if (!code && input.size != bytes)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: has %llu bytes, but %zu x %zu x %zu samples of %s are %zu bytes",
                         path, (unsigned long long)input.size, grid->dims[0], grid->dims[1],
                         grid->dims[2], cvol_type_name(grid->type), bytes);
    return code;
}

static int read_raw(cvol_context *context, cvol_volume **out, const char *path,
                    const cvol_read_options *options)
{
    int code = check_options(context, path, options);
    if (code)
        return code;
    cvol_grid grid = cvol_grid_make(options->dims[0], options->dims[1], options->dims[2],
                                    options->type);
    for (int a = 0; a < 3; a++)
        if (options->spacing[a] != 0)
            grid.spacing[a] = options->spacing[a];
    code = cvol_grid_check(context, &grid, path);
    if (code == CVOL_ERROR_FORMAT) /* here the grid is the caller's */
        code = CVOL_ERROR_ARGUMENT;
    if (!code)
        code = check_size(context, path, &grid);
    cvol_stored stored = {
        .path = path, .encoding = CVOL_ENCODING_RAW, .big_endian = options->big_endian != 0};
    return code ? code : cvol_stored_read(context, out, &grid, path, &stored);
}

static int write_raw(cvol_context *context, const cvol_volume *volume, const char *path)
{
    return cvol_stored_write_file(context, volume, path, NULL, 0, CVOL_ENCODING_RAW);
}

const cvol_format cvol_format_raw = {
    .name = "raw",
    .endings = {".raw"},
    .read = read_raw,
    .write = write_raw,
    .needs_options = 1,
};
