/* Attributes and storage of HDF5's objects. */
#include "volume/formats/hdf5_common_module.h"

#include <stdint.h>
#include <string.h>

int cvol_hdf5_read_doubles(hid_t object, const char *name, double *out, int count)
{
    if (H5Aexists(object, name) <= 0)
        return 0;
    double values[8];
    hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    hid_t space = attribute >= 0 ? H5Aget_space(attribute) : -1;
    const int done = count <= 8 && space >= 0 && H5Sget_simple_extent_npoints(space) == count &&
                     H5Aread(attribute, H5T_NATIVE_DOUBLE, values) >= 0;
    if (space >= 0)
        H5Sclose(space);
    if (attribute >= 0)
        H5Aclose(attribute);
    if (done)
        memcpy(out, values, (size_t)count * sizeof *out);
    return done;
}

/* The bytes of all stored samples; 0 if they cannot be counted. */
static uint64_t samples_bytes(hid_t dataset)
{
    hsize_t dims[H5S_MAX_RANK];
    hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    uint64_t bytes = type >= 0 ? H5Tget_size(type) : 0;
    const int rank = space >= 0 ? H5Sget_simple_extent_dims(space, dims, NULL) : -1;
    int overflows = rank < 0;
    if (type >= 0)
        H5Tclose(type);
    if (space >= 0)
        H5Sclose(space);
    for (int i = 0; i < rank; i++)
        overflows |= __builtin_mul_overflow(bytes, (uint64_t)dims[i], &bytes);
    return overflows ? 0 : bytes;
}

int cvol_hdf5_check_storage(hid_t file, hid_t dataset)
{
    const uint64_t bytes = samples_bytes(dataset), stored = H5Dget_storage_size(dataset);
    hsize_t size = 0;
    hid_t plan = H5Dget_create_plist(dataset);
    const H5D_layout_t layout = plan >= 0 ? H5Pget_layout(plan) : H5D_LAYOUT_ERROR;
    const int elsewhere = plan >= 0 && H5Pget_external_count(plan) != 0;
    if (plan >= 0)
        H5Pclose(plan);
    if (layout == H5D_COMPACT)
        return bytes && stored >= bytes;
    if (layout != H5D_CONTIGUOUS || elsewhere)
        return 1;
    return H5Fget_filesize(file, &size) >= 0 && stored <= size &&
           (!stored || (bytes && stored >= bytes));
}
