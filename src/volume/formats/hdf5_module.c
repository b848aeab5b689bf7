/* HDF5's datasets, by libhdf5 (hdfgroup.org), one call at a time, since it is not thread-safe. Its
 * error messages become part of ours; its printing is off only during a call. */
#define _GNU_SOURCE
#include "volume/formats/hdf5_module.h"

#include <hdf5.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/base.h"
#include "volume/formats/hdf5_common_module.h"
#include "volume/formats/hdf5_minc_module.h"

struct cvol_hdf5_dataset {
    hid_t file, dataset, memory_type;
    int rank;
    hsize_t chunk[CVOL_HDF5_RANK]; /* chunk[0] 0: it has none */
    double *kept;                  /* of an image of MINC 2 */
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

/* ---- errors -------------------------------------------------------------------------- */

typedef struct failure {
    char *message;
    size_t room;
} failure;

/* The innermost reason: the walk upwards begins with it. */
static herr_t keep_reason(unsigned n, const H5E_error2_t *error, void *user)
{
    failure *t = user;
    if (n == 0 && error->desc)
        snprintf(t->message, t->room, "%s", error->desc);
    return 0;
}

static int fail(char *message, size_t room, const char *what)
{
    char reason[160] = "";
    failure t = {reason, sizeof reason};
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_reason, &t);
    for (char *c = reason; *c; c++)
        if (*c < ' ' || *c > '~')
            *c = '?';
    snprintf(message, room, "%s%s%s", what, reason[0] ? ": " : "", reason);
    return 0;
}

/* ---- finding datasets ------------------------------------------------------------------ */

typedef struct listing {
    hid_t file;
    size_t count;
    char first[512], names[400];
} listing;

static int rank_of(hid_t file, const char *name)
{
    hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = dataset >= 0 ? H5Dget_space(dataset) : -1;
    int rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
    if (space >= 0)
        H5Sclose(space);
    if (dataset >= 0)
        H5Dclose(dataset);
    return rank;
}

static void add_name(listing *l, const char *name)
{
    if (rank_of(l->file, name) < 3)
        return;
    if (l->count++ == 0)
        snprintf(l->first, sizeof l->first, "%s", name);
    const size_t at = strlen(l->names);
    if (l->count <= 8)
        snprintf(l->names + at, sizeof l->names - at, "%s/%s", l->count > 1 ? ", " : "", name);
}

#if H5_VERSION_GE(1, 12, 0)
static herr_t visit(hid_t object, const char *name, const H5O_info2_t *info, void *user)
#else
static herr_t visit(hid_t object, const char *name, const H5O_info_t *info, void *user)
#endif
{
    listing *l = user;
    (void)object;
    if (info->type == H5O_TYPE_DATASET)
        add_name(l, name);
    return l->count > 1000;
}

static int find_only(listing *l, hid_t file, char *message, size_t room)
{
    l->file = file;
#if H5_VERSION_GE(1, 12, 0)
    const herr_t done = H5Ovisit3(file, H5_INDEX_NAME, H5_ITER_INC, visit, l, H5O_INFO_BASIC);
#elif H5_VERSION_GE(1, 10, 3)
    /* Visits types only: sizes of trees in damaged files would loop. */
    const herr_t done = H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, l, H5O_INFO_BASIC);
#else
    const herr_t done = H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, visit, l);
#endif
    if (done < 0)
        return fail(message, room, "its objects cannot be listed");
    if (l->count == 1)
        return 1;
    if (l->count)
        snprintf(message, room,
                 "has %zu datasets of three axes or more: name one behind a colon, of %s%s",
                 l->count, l->names, l->count > 8 ? ", ..." : "");
    else
        snprintf(message, room, "has no dataset of three axes or more");
    return 0;
}

/* ---- datasets ------------------------------------------------------------------------- */

static int read_type(cvol_hdf5_dataset *d, cvol_hdf5_shape *shape)
{
    hid_t type = H5Dget_type(d->dataset);
    const H5T_class_t class = type >= 0 ? H5Tget_class(type) : H5T_NO_CLASS;
    const size_t size = type >= 0 ? H5Tget_size(type) : 0;
    const int is_signed = class == H5T_INTEGER && H5Tget_sign(type) == H5T_SGN_2;
    if (type >= 0)
        H5Tclose(type);
    shape->type = shape->is_int64 = shape->is_uint64 = 0;
    if (class == H5T_INTEGER && size == 1) {
        shape->type = is_signed ? CVOL_INT8 : CVOL_UINT8;
        d->memory_type = is_signed ? H5T_NATIVE_INT8 : H5T_NATIVE_UINT8;
    } else if (class == H5T_INTEGER && size == 2) {
        shape->type = is_signed ? CVOL_INT16 : CVOL_UINT16;
        d->memory_type = is_signed ? H5T_NATIVE_INT16 : H5T_NATIVE_UINT16;
    } else if (class == H5T_INTEGER && size == 4) {
        shape->type = is_signed ? CVOL_INT32 : CVOL_UINT32;
        d->memory_type = is_signed ? H5T_NATIVE_INT32 : H5T_NATIVE_UINT32;
    } else if (class == H5T_INTEGER && size == 8) {
        shape->type = CVOL_FLOAT64;
        shape->is_int64 = is_signed;
        shape->is_uint64 = !is_signed;
        d->memory_type = is_signed ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64;
    } else if (class == H5T_FLOAT && (size == 2 || size == 4)) {
        shape->type = CVOL_FLOAT32;
        d->memory_type = H5T_NATIVE_FLOAT;
    } else if (class == H5T_FLOAT && size == 8) {
        shape->type = CVOL_FLOAT64;
        d->memory_type = H5T_NATIVE_DOUBLE;
    }
    return shape->type != 0;
}

static int read_shape(cvol_hdf5_dataset *d, cvol_hdf5_shape *shape)
{
    hsize_t dims[H5S_MAX_RANK];
    hid_t space = H5Dget_space(d->dataset);
    shape->rank = space >= 0 && H5Sis_simple(space) > 0 ? H5Sget_simple_extent_ndims(space) : -1;
    const int fits = shape->rank >= 1 && shape->rank <= CVOL_HDF5_RANK &&
                     H5Sget_simple_extent_dims(space, dims, NULL) == shape->rank;
    if (space >= 0)
        H5Sclose(space);
    for (int i = 0; fits && i < shape->rank; i++)
        shape->dims[i] = dims[i];
    d->rank = shape->rank;
    return fits;
}

/* Reopens with a cache for all chunks that a slice touches: otherwise each chunk is unpacked once
 * per slice. */
static void make_room(cvol_hdf5_dataset *d, const char *name, const cvol_hdf5_shape *shape)
{
    hsize_t chunk[CVOL_HDF5_RANK];
    hid_t plan = H5Dget_create_plist(d->dataset);
    const int chunked = plan >= 0 && H5Pget_layout(plan) == H5D_CHUNKED &&
                        H5Pget_chunk(plan, shape->rank, chunk) == shape->rank;
    if (plan >= 0)
        H5Pclose(plan);
    if (!chunked)
        return;
    memcpy(d->chunk, chunk, sizeof *chunk * (size_t)shape->rank);
    double bytes = 8;
    const int colours = shape->rank > 3 && shape->dims[shape->rank - 1] <= 4; /* after a slice */
    for (int i = 0; i < shape->rank; i++)
        bytes *= (double)chunk[i] * (i < shape->rank - 2 - colours
                                         ? 1
                                         : 1 + (double)(shape->dims[i] / (chunk[i] + !chunk[i])));
    hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
    if (bytes <= 0x1p28 && access >= 0 &&
        H5Pset_chunk_cache(access, 10007, (size_t)bytes + (1 << 20), 1) >= 0) {
        hid_t again = H5Dopen2(d->file, name, access);
        if (again >= 0) {
            H5Dclose(d->dataset);
            d->dataset = again;
        }
    }
    if (access >= 0)
        H5Pclose(access);
}

static void close_unlocked(cvol_hdf5_dataset *d)
{
    if (d->dataset >= 0)
        H5Dclose(d->dataset);
    if (d->file >= 0)
        H5Fclose(d->file);
    free(d->kept);
    free(d);
}

static hid_t open_file(const char *path)
{
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(access, 0, 1); /* folders may be read-only */
#endif
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

static int open_unlocked(cvol_hdf5_dataset *d, cvol_hdf5_shape *shape, const char *file,
                         const char *path, char *message, size_t room)
{
    listing l = {.count = 0};
    d->file = open_file(file);
    if (d->file < 0)
        return fail(message, room, "cannot be opened as HDF5");
    if (!path && H5Lexists(d->file, "/minc-2.0", H5P_DEFAULT) > 0)
        path = CVOL_HDF5_MINC_IMAGE;
    if (!path && !find_only(&l, d->file, message, room))
        return 0;
    const char *name = path ? path : l.first;
    d->dataset = H5Dopen2(d->file, name, H5P_DEFAULT);
    if (d->dataset < 0)
        return fail(message, room, "has no such dataset");
    if (!read_shape(d, shape))
        return fail(message, room, "its dataset has none, or more than 8, axes");
    if (!read_type(d, shape)) {
        snprintf(message, room, "its dataset's type is not supported (integers and floats are)");
        return 0;
    }
    if (!cvol_hdf5_check_storage(d->file, d->dataset)) {
        snprintf(message, room, "its dataset needs more bytes than the file has");
        return 0;
    }
    cvol_hdf5_read_doubles(d->dataset, "element_size_um", shape->size_um, 3); /* Fiji, ilastik */
    if (!cvol_hdf5_read_minc(d->file, d->dataset, shape, &d->kept, message, room))
        return 0;
    make_room(d, name, shape);
    return 1;
}

/* ---- functions ------------------------------------------------------------------------ */

static int open_dataset(cvol_hdf5_dataset **out, cvol_hdf5_shape *shape, const char *file,
                        const char *path, char *message, size_t room)
{
    cvol_hdf5_dataset *d = calloc(1, sizeof *d);
    memset(shape, 0, sizeof *shape);
    *out = NULL;
    if (!d) {
        snprintf(message, room, "not enough memory");
        return 0;
    }
    d->file = d->dataset = -1;
    int done;
    pthread_mutex_lock(&mutex);
    H5E_BEGIN_TRY
    {
        done = open_unlocked(d, shape, file, path, message, room);
        if (!done)
            close_unlocked(d);
    }
    H5E_END_TRY
    pthread_mutex_unlock(&mutex);
    *out = done ? d : NULL;
    return done;
}

/* The first filter of the dataset's chunks that this libhdf5 lacks, and its name; 0: there is
 * none. */
static int missing_filter(hid_t dataset, char *name, size_t room)
{
    hid_t plan = H5Dget_create_plist(dataset);
    const int count = plan >= 0 ? H5Pget_nfilters(plan) : 0;
    int missing = 0;
    for (int i = 0; i < count && !missing; i++) {
        unsigned flags;
        size_t values = 0;
        const H5Z_filter_t id = H5Pget_filter2(plan, (unsigned)i, &flags, &values, NULL, room, name,
                                               NULL);
        missing = id > 0 && H5Zfilter_avail(id) <= 0 ? id : 0;
    }
    if (plan >= 0)
        H5Pclose(plan);
    return missing;
}

/* The reason why samples could not be read: libhdf5 gives only the innermost one. */
static void explain_read(hid_t dataset, char *message, size_t room)
{
    char name[48] = "";
    fail(message, room, "its samples cannot be read");
    const int filter = missing_filter(dataset, name, sizeof name - 1); /* longer ones have no end */
    for (char *c = name; *c; c++)
        if (*c < ' ' || *c > '~')
            *c = '?';
    if (filter)
        snprintf(message, room,
                 "its samples need filter %d (%s), which is not found; HDF5_PLUGIN_PATH names "
                 "folders with such",
                 filter, name);
}

static int read_unlocked(cvol_hdf5_dataset *d, void *out, const hsize_t *begin,
                         const hsize_t *count, char *message, size_t room)
{
    hid_t space = H5Dget_space(d->dataset), memory = H5Screate_simple(d->rank, count, NULL);
    const int done = space >= 0 && memory >= 0 &&
                     H5Sselect_hyperslab(space, H5S_SELECT_SET, begin, NULL, count, NULL) >= 0 &&
                     H5Dread(d->dataset, d->memory_type, memory, space, H5P_DEFAULT, out) >= 0;
    if (!done)
        explain_read(d->dataset, message, room);
    if (space >= 0)
        H5Sclose(space);
    if (memory >= 0)
        H5Sclose(memory);
    return done;
}

/* libhdf5 keeps some kilobytes for each chunk of a request. */
#define MAX_CHUNKS 4096

/* The approximate number of chunks that a box touches. */
static double count_chunks(const cvol_hdf5_dataset *d, const hsize_t *count)
{
    double chunks = 1;
    for (int i = 0; i < d->rank; i++)
        chunks *= d->chunk[i] ? 1 + (double)(count[i] / d->chunk[i]) : 1;
    return chunks;
}

/* Reads a box of several chunks in halves along its slowest axis, which are contiguous in `out`; an
 * axis of several chunks is cut at the beginning of a chunk. begin and count are restored. */
static int read_parts(cvol_hdf5_dataset *d, char *out, hsize_t *begin, hsize_t *count,
                      char *message, size_t room)
{
    int axis = 0;
    while (axis < d->rank && count[axis] <= 1)
        axis++;
    if (!d->chunk[0] || axis == d->rank || count_chunks(d, count) <= MAX_CHUNKS)
        return read_unlocked(d, out, begin, count, message, room);
    const hsize_t from = begin[axis], all = count[axis], middle = from + all / 2;
    const hsize_t aligned = middle - middle % d->chunk[axis];
    const hsize_t first = (aligned > from ? aligned : middle) - from;
    size_t bytes = H5Tget_size(d->memory_type);
    for (int i = axis + 1; i < d->rank; i++)
        bytes *= (size_t)count[i];
    count[axis] = first;
    int done = read_parts(d, out, begin, count, message, room);
    begin[axis] = from + first;
    count[axis] = all - first;
    done = done && read_parts(d, out + first * bytes, begin, count, message, room);
    begin[axis] = from;
    count[axis] = all;
    return done;
}

static int read_box(cvol_hdf5_dataset *dataset, void *out, const uint64_t *begin,
                    const uint64_t *count, char *message, size_t room)
{
    hsize_t b[CVOL_HDF5_RANK], c[CVOL_HDF5_RANK];
    for (int i = 0; i < dataset->rank; i++) {
        b[i] = begin[i];
        c[i] = count[i];
    }
    int done;
    pthread_mutex_lock(&mutex);
    H5E_BEGIN_TRY
    {
        done = read_parts(dataset, out, b, c, message, room);
    }
    H5E_END_TRY
    pthread_mutex_unlock(&mutex);
    return done;
}

static void close_dataset(cvol_hdf5_dataset *dataset)
{
    if (!dataset)
        return;
    pthread_mutex_lock(&mutex);
    H5E_BEGIN_TRY
    {
        close_unlocked(dataset);
    }
    H5E_END_TRY
    pthread_mutex_unlock(&mutex);
}

const cvol_hdf5_functions cvol_hdf5_module = {open_dataset, read_box, close_dataset};
