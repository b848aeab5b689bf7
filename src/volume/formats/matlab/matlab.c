/* MATLAB 5 to 7.2, .mat ("MAT-File Format", MathWorks): an array of numbers, FILE.mat:NAME, or the
 * only one of three axes or more. Files of MATLAB 7.3 are HDF5.
 *
 * The first index runs fastest, and is x: A(x, y, z). That is the order in which HDF5 has the axes
 * of such an array too, so that a variable is the same volume in files of all versions. More than
 * three axes are chosen from (axes.h). Sparse and complex arrays, cells and structures are not
 * read. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/formats/matlab/variables.h"
#include "volume/io/format.h"
#include "volume/io/interleaved.h"

/* The axes, slowest first. */
static void set_axes(cvol_axes *axes, const cvol_matlab_variable *v)
{
    axes->rank = v->rank;
    for (int i = 0; i < v->rank; i++)
        axes->dims[i] = v->dims[v->rank - 1 - i];
}

/* The distance of an axis' neighbours; 0: there is no such axis. All elements are known to fit. */
static size_t stride_of(const cvol_axes *axes, int axis)
{
    size_t stride = 1;
    for (int i = axis + 1; i < axes->rank; i++)
        stride *= (size_t)axes->dims[i];
    return axis < 0 ? 0 : stride;
}

static int check_size(cvol_context *context, const cvol_matlab_variable *v, const char *name)
{
    uint64_t bytes = cvol_type_size(v->type);
    int fits = 1;
    for (int i = 0; i < v->rank && fits; i++)
        fits = !__builtin_mul_overflow(bytes, v->dims[i], &bytes);
    if (fits && bytes == v->real_bytes)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: its array %s has %llu bytes of numbers, but the lengths of its axes are "
                     "those of another number",
                     name, v->name, (unsigned long long)v->real_bytes);
}

/* Describes the elements of the chosen volume in the file `path`. */
static int find_elements(cvol_context *context, cvol_stored *stored, const cvol_grid *grid,
                         const cvol_matlab_variable *v, const cvol_axes *axes, const char *path)
{
    const size_t each = cvol_type_size(v->type);
    cvol_strided strided = {.big_endian = stored->big_endian};
    uint64_t skip = 0;
    const int outer = axes->of[2] < 0 ? 0 : axes->of[2];
    for (int i = 0; i < axes->rank; i++)
        if (i < outer)
            skip += axes->begin[i] * stride_of(axes, i);
        else
            strided.first += (size_t)axes->begin[i] * stride_of(axes, i);
    const size_t elements = outer ? stride_of(axes, outer - 1) : (size_t)(v->real_bytes / each);
    for (int a = 0; a < 3; a++)
        strided.stride[a] = stride_of(axes, axes->of[a]);
    skip *= each;
    if (strided.stride[0] != 1)
        return v->is_packed ? cvol_strided_inflate(context, stored, &strided, grid, path, v->offset,
                                                   v->at + skip, elements)
                            : cvol_strided_read(context, stored, &strided, grid, path, v->at + skip,
                                                elements);
    stored->offset = v->is_packed ? v->offset : v->at + skip;
    stored->may_go_on = 1; /* with other variables */
    if (v->is_packed) {
        stored->encoding = CVOL_ENCODING_GZIP;
        stored->stored_size = v->size;
        stored->byte_skip = v->at + skip;
        stored->has_remarks = 1; /* padding */
        stored->has_more_volumes = skip + elements * each < v->real_bytes;
    }
    return CVOL_OK;
}

static int find_in(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *file,
                   const char *path, const cvol_read_options *options)
{
    cvol_matlab_list list;
    cvol_axes axes;
    const cvol_matlab_variable *v = NULL;
    const char *inside = strlen(path) > strlen(file) ? path + strlen(file) + 1 : NULL;
    int code = cvol_matlab_list_read(context, &list, file, path);
    if (!code)
        code = cvol_matlab_list_choose(context, &v, &list, inside, path);
    if (!code)
        code = check_size(context, v, path);
    if (!code) {
        set_axes(&axes, v);
        *grid = cvol_grid_make(1, 1, 1, v->type);
        code = cvol_axes_choose(context, &axes, grid, path, options);
        const int was_asked = code == CVOL_ERROR_ARGUMENT;
        if ((!code || was_asked) && !cvol_axes_label(&stored->labels, &axes, v->type))
            code = cvol_fail_memory(context, sizeof(cvol_channel_label), path);
    }
    if (!code)
        code = cvol_grid_check_within(context, grid, path, UINT64_MAX);
    if (!code) {
        stored->big_endian = list.big_endian;
        stored->wide = v->wide;
        code = find_elements(context, stored, grid, v, &axes, file);
    }
    free(list.variables);
    return code;
}

static int find_matlab(cvol_context *context, cvol_grid *grid, cvol_stored *stored,
                       const char *path, const cvol_read_options *options)
{
    stored->data_path = strndup(path, cvol_input_file_length(path));
    if (!stored->data_path)
        return cvol_fail_memory(context, strlen(path), path);
    return find_in(context, grid, stored, stored->data_path, path, options);
}

const cvol_format cvol_format_matlab = {
    .name = "MATLAB",
    .recognise = cvol_matlab_recognise,
    .find = find_matlab,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
    .takes_name = 1,
};
