/* Raw samples: a file of nothing else, x fastest; the caller gives dims, type, byte order and
 * spacing. Written little-endian. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/context.h"
#include "volume/io/format.h"

/* The options that a name such as field_128x128x41_float32.raw implies, if the file's size agrees;
 * else "". */
static const char *guess_options(char out[96], const char *path)
{
    static const char *const types[] = {"uint8", "uint16", "uint32",  "int8",
                                        "int16", "int32",  "float32", "float64"};
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path, *type = NULL;
    const char *const digits = "0123456789";
    struct stat status;
    out[0] = '\0';
    for (size_t i = 0; i < sizeof types / sizeof *types && !type; i++)
        if (strstr(name, types[i]))
            type = types[i];
    if (!type || stat(path, &status))
        return out;
    for (const char *p = strpbrk(name, digits); p; p = strpbrk(p + strspn(p, digits), digits)) {
        unsigned n[3];
        if (sscanf(p, "%6ux%6ux%6u", &n[0], &n[1], &n[2]) != 3)
            continue;
        const double bytes = (double)n[0] * n[1] * n[2] *
                             (double)cvol_type_size(cvol_type_from_name(type));
        if (bytes > 0 && fabs(bytes - (double)status.st_size) < 0.5)
            snprintf(out, 96, "; its name and size fit --dims %ux%ux%u --type %s", n[0], n[1], n[2],
                     type);
    }
    return out;
}

static int check_options(cvol_context *context, const char *path, const cvol_read_options *o)
{
    int has_dims = o->dims[0] && o->dims[1] && o->dims[2], has_type = cvol_type_size(o->type) > 0;
    if (has_dims && has_type)
        return CVOL_OK;
    char fits[96];
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: raw samples need %s%s%s%s", path,
                     has_dims ? "" : "--dims NXxNYxNZ", has_dims || has_type ? "" : " and ",
                     has_type ? "" : "--type", guess_options(fits, path));
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
