/* Images of MINC 2: /minc-2.0/image/0/image with image-min and image-max next to it, and
 * /minc-2.0/dimensions/NAME for each name of the attribute dimorder. */
#include "volume/formats/hdf5_minc_module.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volume/formats/hdf5_common_module.h"

/* Slices that may have values of their own. */
#define SLICES_MAX (1 << 24)
enum { TEXT_BYTES = 256 };

/* ---- attributes ----------------------------------------------------------------------- */

/* A text of constant length; "" if there is none. */
static void read_text(char out[TEXT_BYTES], hid_t object, const char *name)
{
    memset(out, 0, TEXT_BYTES);
    if (H5Aexists(object, name) <= 0)
        return;
    hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    hid_t type = attribute >= 0 ? H5Aget_type(attribute) : -1;
    hid_t space = attribute >= 0 ? H5Aget_space(attribute) : -1;
    if (type >= 0 && space >= 0 && H5Tget_class(type) == H5T_STRING &&
        H5Tis_variable_str(type) == 0 && H5Tget_size(type) < TEXT_BYTES &&
        H5Sget_simple_extent_npoints(space) == 1 && H5Aread(attribute, type, out) < 0)
        memset(out, 0, TEXT_BYTES);
    if (space >= 0)
        H5Sclose(space);
    if (type >= 0)
        H5Tclose(type);
    if (attribute >= 0)
        H5Aclose(attribute);
}

/* ---- dimensions ----------------------------------------------------------------------- */

/* Opens an object of a name that may not exist; negative: it does not, or is no dataset. */
static hid_t open_dataset(hid_t file, const char *name)
{
    return H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1;
}

static void read_dimension(cvol_hdf5_dimension *out, hid_t file, const char *name, size_t length)
{
    char path[TEXT_BYTES + 32], spacing[TEXT_BYTES];
    const int axis = length == 6 && !memcmp(name + 1, "space", 5) ? name[0] - 'x' : -1;
    *out = (cvol_hdf5_dimension){.step = 1};
    out->is_spatial = axis >= 0 && axis < 3;
    out->is_time = length == 4 && !memcmp(name, "time", 4);
    if (out->is_spatial)
        out->cosines[axis] = 1;
    snprintf(path, sizeof path, "/minc-2.0/dimensions/%.*s", (int)length, name);
    hid_t dimension = open_dataset(file, path);
    if (dimension < 0)
        return;
    cvol_hdf5_read_doubles(dimension, "start", &out->start, 1);
    cvol_hdf5_read_doubles(dimension, "step", &out->step, 1);
    cvol_hdf5_read_doubles(dimension, "direction_cosines", out->cosines, 3);
    read_text(spacing, dimension, "spacing");
    out->is_irregular = !strncmp(spacing, "irregular", 9);
    H5Dclose(dimension);
}

/* ---- values --------------------------------------------------------------------------- */

/* The values of all slices, one for each place along the leading axes; NULL if it is no such
 * dataset, or has none. */
static double *read_slices(int *axes, hid_t file, const char *name, const cvol_hdf5_shape *shape)
{
    hsize_t dims[H5S_MAX_RANK];
    double *values = NULL;
    hid_t dataset = open_dataset(file, name);
    hid_t space = dataset >= 0 ? H5Dget_space(dataset) : -1;
    int rank = space >= 0 ? H5Sget_simple_extent_dims(space, dims, NULL) : -1;
    const hssize_t count = space >= 0 ? H5Sget_simple_extent_npoints(space) : 0;
    if (count == 1)
        rank = 0;
    int fits = rank >= 0 && rank < shape->rank && count > 0 && count <= SLICES_MAX &&
               cvol_hdf5_check_storage(file, dataset);
    for (int i = 0; fits && i < rank; i++)
        fits = dims[i] == shape->dims[i];
    if (fits && (values = calloc((size_t)count, sizeof *values)) &&
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        free(values);
        values = NULL;
    }
    if (space >= 0)
        H5Sclose(space);
    if (dataset >= 0)
        H5Dclose(dataset);
    *axes = rank;
    return values;
}

/* The attribute valid_range, or the range of the type. */
static void read_valid(cvol_hdf5_minc *minc, hid_t dataset)
{
    hid_t type = H5Dget_type(dataset);
    const int bits = 8 * (int)H5Tget_size(type);
    const int is_signed = H5Tget_sign(type) == H5T_SGN_2;
    H5Tclose(type);
    minc->valid[0] = is_signed ? -ldexp(1, bits - 1) : 0;
    minc->valid[1] = ldexp(1, bits - is_signed) - 1;
    cvol_hdf5_read_doubles(dataset, "valid_range", minc->valid, 2);
}

static int read_values(hid_t file, cvol_hdf5_shape *shape, double **kept)
{
    cvol_hdf5_minc *minc = &shape->minc;
    static const char least[] = CVOL_HDF5_MINC_IMAGE "-min", most[] = CVOL_HDF5_MINC_IMAGE "-max";
    int axes[2];
    if (H5Lexists(file, least, H5P_DEFAULT) <= 0 && H5Lexists(file, most, H5P_DEFAULT) <= 0)
        return 1;
    double *low = read_slices(&axes[0], file, least, shape);
    double *high = read_slices(&axes[1], file, most, shape);
    size_t count = 1;
    for (int i = 0; i < axes[0]; i++)
        count *= (size_t)shape->dims[i];
    double *both = low && high && axes[0] == axes[1] ? realloc(low, 2 * count * sizeof *low) : NULL;
    if (both) {
        low = NULL;
        memcpy(both + count, high, count * sizeof *both);
        minc->scaled = axes[0];
        minc->least = both;
        minc->most = both + count;
        *kept = both;
    }
    free(low);
    free(high);
    return both != NULL;
}

/* ---- images --------------------------------------------------------------------------- */

int cvol_hdf5_read_minc(hid_t file, hid_t dataset, cvol_hdf5_shape *shape, double **kept,
                        char *message, size_t room)
{
    char name[sizeof CVOL_HDF5_MINC_IMAGE + 1], order[TEXT_BYTES];
    cvol_hdf5_minc *minc = &shape->minc;
    if (H5Iget_name(dataset, name, sizeof name) < 0 || strcmp(name, CVOL_HDF5_MINC_IMAGE))
        return 1;
    read_text(order, dataset, "dimorder");
    const char *next = order;
    for (int i = 0; i < shape->rank; i++) {
        const size_t length = strcspn(next, ",");
        read_dimension(&minc->dimension[i], file, next, length);
        next += length + (next[length] == ',');
    }
    minc->is_image = 1;
    read_valid(minc, dataset);
    if (read_values(file, shape, kept))
        return 1;
    snprintf(message, room, "image-min and image-max of its image in MINC do not fit the image");
    return 0;
}
