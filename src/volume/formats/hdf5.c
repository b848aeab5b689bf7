/* HDF5 (hdfgroup.org): a dataset of up to five axes, FILE.h5:/path/to/it, or the only one of three
 * or more.
 *
 * Or the image of MINC 2 (minc.c). The last axis is x, as in NumPy; more than three are chosen from
 * (axes.h). libhdf5 is used by a separate module. Voxel sizes are Fiji's attribute element_size_um.
 */
#define _GNU_SOURCE
#include "volume/formats/hdf5.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/formats/hdf5_module.h"
#include "volume/formats/minc.h"
#include "volume/io/axes.h"
#include "volume/io/format.h"
#include "volume/io/input.h"
#include "volume/io/module.h"

typedef struct hdf5 {
    char *name; /* for messages */
    cvol_hdf5_dataset *dataset;
    cvol_hdf5_shape shape;
    cvol_axes axes;
    cvol_minc_scale scale; /* of an image of MINC 2 */
    cvol_type type;        /* of the samples that are read */
} hdf5;

/* ---- the module ----------------------------------------------------------------------- */

#ifdef CVOL_HDF5_LINKED

static const cvol_hdf5_functions *functions(void)
{
    return &cvol_hdf5_module;
}

#else

static const cvol_hdf5_functions *found;

static void load(void)
{
    found = cvol_module_find(CVOL_HDF5_MODULE, "cvol_hdf5_module");
}

static const cvol_hdf5_functions *functions(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, load);
    return found;
}

#endif

static int recognise(const uint8_t *head, size_t size)
{
    for (size_t at = 0; at + 8 <= size; at = at ? 2 * at : 512) /* behind a user block */
        if (!memcmp(head + at, "\x89HDF\r\n\x1a\n", 8))
            return 1;
    return 0;
}

/* ---- reading -------------------------------------------------------------------------- */

static void close_hdf5(void *state)
{
    hdf5 *h = state;
    if (!h)
        return;
    if (h->dataset)
        functions()->close(h->dataset);
    free(h->name);
    free(h);
}

static int read_stored(cvol_context *context, hdf5 *h, void *out, size_t first, size_t count,
                       size_t first_row, size_t rows)
{
    const cvol_axes *axes = &h->axes;
    uint64_t begin[CVOL_HDF5_RANK] = {0}, box[CVOL_HDF5_RANK];
    char message[300];
    for (int i = 0; i < axes->rank; i++) {
        begin[i] = axes->begin[i];
        box[i] = i == axes->of[0] ? axes->dims[i] : 1;
    }
    if (axes->of[1] >= 0) {
        begin[axes->of[1]] = first_row;
        box[axes->of[1]] = rows;
    }
    if (axes->of[2] >= 0) {
        begin[axes->of[2]] = first;
        box[axes->of[2]] = count;
    }
    if (functions()->read(h->dataset, out, begin, box, message, sizeof message))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s", h->name, message);
}

/* Slices of MINC 2 may have scales of their own. */
static int read_rows(cvol_context *context, void *state, void *out, size_t first, size_t count,
                     size_t first_row, size_t rows)
{
    hdf5 *h = state;
    if (!h->scale.is_by_slice)
        return read_stored(context, h, out, first, count, first_row, rows);
    const size_t samples = (size_t)h->axes.dims[h->axes.of[0]] * rows;
    const size_t bytes = samples * cvol_type_size(h->type);
    void *part = malloc(samples * cvol_type_size(h->scale.stored));
    int code = part ? CVOL_OK : cvol_fail_memory(context, samples, h->name);
    for (size_t z = 0; z < count && !code; z++) {
        code = read_stored(context, h, part, first + z, 1, first_row, rows);
        if (!code)
            cvol_minc_convert((uint8_t *)out + z * bytes, h->type, part, h->scale.stored, samples,
                              &h->shape.minc, &h->axes, first + z);
    }
    free(part);
    return code;
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    const cvol_axes *axes = &((const hdf5 *)state)->axes;
    return read_rows(context, state, out, first, count, 0,
                     axes->of[1] >= 0 ? (size_t)axes->dims[axes->of[1]] : 1);
}

static int read_shape(cvol_context *context, hdf5 *h, cvol_grid *grid,
                      const cvol_read_options *options)
{
    *grid = cvol_grid_make(1, 1, 1, (cvol_type)h->shape.type);
    h->axes.rank = h->shape.rank;
    for (int i = 0; i < h->shape.rank; i++)
        h->axes.dims[i] = h->shape.dims[i];
    for (int a = 0; a < 3 && a < h->shape.rank; a++) {
        const double size = h->shape.size_um[2 - a];
        if (size < 0 || size > 0 || size != size) {
            grid->spacing[a] = size;
            snprintf(grid->unit, sizeof grid->unit, "um");
        }
    }
    int code = cvol_axes_choose(context, &h->axes, grid, h->name, options);
    if (!code && h->shape.minc.is_image)
        code = cvol_minc_complete(context, grid, &h->scale, &h->shape, &h->axes, h->name);
    h->type = grid->type;
    return code;
}

static int find_hdf5(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    char message[700];
    if (!functions())
        return cvol_fail(
            context, CVOL_ERROR_UNSUPPORTED,
            "%s: is an HDF5 file, and this cvol was built without libhdf5, or its " CVOL_HDF5_MODULE
            " is missing",
            path);
    hdf5 *h = calloc(1, sizeof *h);
    if (!h)
        return cvol_fail_memory(context, sizeof *h, path);
    stored->slices = (cvol_slices){
        .state = h, .read = read_slices, .read_rows = read_rows, .close = close_hdf5};
    const size_t length = cvol_input_file_length(path);
    const char *inside = path[length] ? path + length + 1 : NULL;
    char *file = strndup(path, length);
    h->name = strdup(path);
    int code = file && h->name ? CVOL_OK : cvol_fail_memory(context, length, path);
    if (!code && !functions()->open(&h->dataset, &h->shape, file, inside, message, sizeof message))
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s", path, message);
    free(file);
    if (!code)
        code = read_shape(context, h, grid, options);
    stored->wide = h->shape.is_int64    ? CVOL_WIDE_INT64
                   : h->shape.is_uint64 ? CVOL_WIDE_UINT64
                                        : CVOL_WIDE_NONE;
    if (!code && !cvol_axes_label(&stored->labels, &h->axes, grid->type))
        code = cvol_fail_memory(context, sizeof(cvol_channel_label), path);
    return code;
}

const cvol_format cvol_format_hdf5 = {
    .name = "HDF5",
    .endings = {".h5", ".hdf5"},
    .recognise = recognise,
    .find = find_hdf5,
    .plan = cvol_hdf5_plan,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
    .takes_name = 1,
    .writes_name = 1,
};
