/* libH5Zcvol.so, a filter that HDF5 loads when a dataset needs it (H5PL). Each chunk is a .cvol
 * file.
 *
 * A process may have several libhdf5: Python's wheels and ParaView bring their own. The plugin
 * links to none of them. It finds the calling library by the address of the caller, and calls its
 * functions. For a library whose functions have other names it reads and writes chunks, but does
 * not fill in parameters or report messages.
 */
#define _GNU_SOURCE
#include <H5PLextern.h>
#include <dlfcn.h>
#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "h5z_cvol.h"

#define MESSAGE_BYTES 400

/* ---- the calling library -------------------------------------------------------------- */

typedef struct hdf5_library {
    herr_t (*push)(hid_t, const char *, const char *, unsigned, hid_t, hid_t, hid_t, const char *,
                   ...);
    const hid_t *class, *major, *minor; /* identifiers of errors */
    int (*get_chunk)(hid_t, int, hsize_t[]);
    herr_t (*get_filter)(hid_t, H5Z_filter_t, unsigned *, size_t *, unsigned[], size_t, char[],
                         unsigned *);
    herr_t (*modify_filter)(hid_t, H5Z_filter_t, unsigned, size_t, const unsigned[]);
    H5T_class_t (*type_class)(hid_t);
    size_t (*type_size)(hid_t);
    H5T_sign_t (*type_sign)(hid_t);
    H5T_order_t (*type_order)(hid_t);
    void *(*allocate)(size_t, hbool_t);
    herr_t (*release)(void *);
} hdf5_library;

/* Set once, under the lock of HDF5, before any filter runs. */
static hdf5_library hdf5;

static void find(void *handle, void *function, const char *name)
{
    void *found = dlsym(handle, name);
    memcpy(function, &found, sizeof found);
}

static void find_library(const void *caller)
{
    Dl_info of_caller;
    void *handle = dladdr(caller, &of_caller) && of_caller.dli_fname
                       ? dlopen(of_caller.dli_fname, RTLD_LAZY | RTLD_NOLOAD)
                       : NULL;
    if (!handle) /* the library is linked into the program */
        handle = dlopen(NULL, RTLD_LAZY);
    if (!handle)
        return;
    find(handle, &hdf5.push, "H5Epush2");
    find(handle, &hdf5.class, "H5E_ERR_CLS_g");
    find(handle, &hdf5.major, "H5E_PLINE_g");
    find(handle, &hdf5.minor, "H5E_CANTFILTER_g");
    find(handle, &hdf5.get_chunk, "H5Pget_chunk");
    find(handle, &hdf5.get_filter, "H5Pget_filter_by_id2");
    find(handle, &hdf5.modify_filter, "H5Pmodify_filter");
    find(handle, &hdf5.type_class, "H5Tget_class");
    find(handle, &hdf5.type_size, "H5Tget_size");
    find(handle, &hdf5.type_sign, "H5Tget_sign");
    find(handle, &hdf5.type_order, "H5Tget_order");
    find(handle, &hdf5.allocate, "H5allocate_memory");
    find(handle, &hdf5.release, "H5free_memory");
}

/* Adds a message to the error stack of HDF5. */
static void push_error(const char *where, unsigned line, const char *message)
{
    if (hdf5.push && hdf5.class && hdf5.major && hdf5.minor)
        hdf5.push(H5E_DEFAULT, "h5z_cvol.c", where, line, *hdf5.class, *hdf5.major, *hdf5.minor,
                  "%s", message);
}

/* ---- parameters ------------------------------------------------------------------------ */

/* The sample type; 0: not supported. */
static cvol_type type_of(hid_t id)
{
    const H5T_class_t class = hdf5.type_class(id);
    const size_t size = hdf5.type_size(id);
    if (class == H5T_FLOAT)
        return size == 4 ? CVOL_FLOAT32 : size == 8 ? CVOL_FLOAT64 : (cvol_type)0;
    if (class != H5T_INTEGER)
        return (cvol_type)0;
    const int has_sign = hdf5.type_sign(id) == H5T_SGN_2;
    return size == 1   ? (has_sign ? CVOL_INT8 : CVOL_UINT8)
           : size == 2 ? (has_sign ? CVOL_INT16 : CVOL_UINT16)
           : size == 4 ? (has_sign ? CVOL_INT32 : CVOL_UINT32)
                       : (cvol_type)0;
}

static int is_supported(void)
{
    return hdf5.get_chunk && hdf5.get_filter && hdf5.modify_filter && hdf5.type_class &&
           hdf5.type_size && hdf5.type_sign && hdf5.type_order;
}

/* Sides x, y, z of a chunk: its last three axes. 0 if another axis has more than one place. */
static int read_chunk(unsigned words[CVOL_H5Z_WORDS], hid_t plan)
{
    hsize_t chunk[H5S_MAX_RANK];
    const int rank = hdf5.get_chunk(plan, H5S_MAX_RANK, chunk);
    for (int a = 0; a < 3; a++)
        words[CVOL_H5Z_NX + a] = a < rank ? (unsigned)chunk[rank - 1 - a] : 1;
    for (int i = 0; i < rank - 3; i++)
        if (chunk[i] != 1)
            return 0;
    return rank >= 1;
}

/* 0: an optional filter then stores the samples unchanged. */
static htri_t can_apply(hid_t plan, hid_t type, hid_t space)
{
    unsigned words[CVOL_H5Z_WORDS];
    (void)space;
    if (!is_supported()) {
        push_error("can_apply", __LINE__, "cvol: this HDF5 library can only read with the filter");
        return 0;
    }
    if (!type_of(type)) {
        push_error("can_apply", __LINE__,
                   "cvol: samples must be integers of 8, 16 or 32 bits or floats of 32 or 64");
        return 0;
    }
    if (!read_chunk(words, plan)) {
        push_error("can_apply", __LINE__,
                   "cvol: a chunk must have size 1 along all axes but the last three");
        return 0;
    }
    return 1;
}

/* Stores type and shape of the chunks in the parameters. */
static herr_t set_local(hid_t plan, hid_t type, hid_t space)
{
    unsigned given[CVOL_H5Z_WORDS] = {0}, words[CVOL_H5Z_WORDS] = {0}, flags, config;
    size_t count = CVOL_H5Z_WORDS;
    char message[MESSAGE_BYTES];
    cvol_compress_options options;
    (void)space;
    if (!is_supported() ||
        hdf5.get_filter(plan, CVOL_H5Z_ID, &flags, &count, given, 0, NULL, &config) < 0)
        return -1;
    if (count > CVOL_H5Z_LAYOUT) /* copied from another dataset */
        count = CVOL_H5Z_LAYOUT;
    if (!cvol_h5z_read_options(&options, given, count, message, sizeof message)) {
        push_error("set_local", __LINE__, message);
        return -1;
    }
    words[CVOL_H5Z_MODE] = options.lossless ? CVOL_H5Z_LOSSLESS : (unsigned)options.target;
    cvol_h5z_put_value(words, options.lossless ? 0 : options.target_value);
    words[CVOL_H5Z_LAYOUT] = CVOL_H5Z_LAYOUT_1;
    words[CVOL_H5Z_TYPE] = (unsigned)type_of(type);
    words[CVOL_H5Z_ORDER] = hdf5.type_order(type) == H5T_ORDER_BE;
    if (!read_chunk(words, plan))
        return -1;
    return hdf5.modify_filter(plan, CVOL_H5Z_ID, flags, CVOL_H5Z_WORDS, words);
}

/* ---- chunks ---------------------------------------------------------------------------- */

/* Replaces the buffer of the caller, in memory of its library; frees `bytes`. */
static size_t replace_buffer(void **buffer, size_t *capacity, void *bytes, size_t size)
{
    void *out = bytes;
    if (hdf5.allocate && hdf5.release) {
        out = hdf5.allocate(size, 0);
        if (out)
            memcpy(out, bytes, size);
        free(bytes);
        if (!out) {
            push_error("filter", __LINE__, "cvol: not enough memory for a chunk");
            return 0;
        }
        hdf5.release(*buffer);
    } else {
        free(*buffer);
    }
    *buffer = out;
    *capacity = size;
    return size;
}

static size_t encode(unsigned flags, const cvol_h5z_plan *plan, size_t size, size_t *capacity,
                     void **buffer)
{
    char message[MESSAGE_BYTES];
    void *bytes;
    size_t count;
    if (size != plan->bytes) {
        snprintf(message, sizeof message, "cvol: a chunk has %zu bytes, must have %zu", size,
                 plan->bytes);
        push_error("encode", __LINE__, message);
        return 0;
    }
    if (!cvol_h5z_encode(&bytes, &count, plan, *buffer, message, sizeof message)) {
        push_error("encode", __LINE__, message);
        return 0;
    }
    if (count >= size && (flags & H5Z_FLAG_OPTIONAL)) { /* the raw chunk is smaller, and exact */
        free(bytes);
        return 0;
    }
    return replace_buffer(buffer, capacity, bytes, count);
}

static size_t decode(const cvol_h5z_plan *plan, size_t size, size_t *capacity, void **buffer)
{
    char message[MESSAGE_BYTES];
    void *samples;
    if (!cvol_h5z_decode(&samples, plan, *buffer, size, message, sizeof message)) {
        push_error("decode", __LINE__, message);
        return 0;
    }
    return replace_buffer(buffer, capacity, samples, plan->bytes);
}

static size_t filter(unsigned flags, size_t count, const unsigned words[], size_t size,
                     size_t *capacity, void **buffer)
{
    char message[MESSAGE_BYTES];
    cvol_h5z_plan plan;
    if (!cvol_h5z_read_plan(&plan, words, count, message, sizeof message)) {
        push_error("filter", __LINE__, message);
        return 0;
    }
    return flags & H5Z_FLAG_REVERSE ? decode(&plan, size, capacity, buffer)
                                    : encode(flags, &plan, size, capacity, buffer);
}

static const H5Z_class2_t description = {
    .version = H5Z_CLASS_T_VERS,
    .id = CVOL_H5Z_ID,
    .encoder_present = 1,
    .decoder_present = 1,
    .name = "cvol: volumes as transform coefficients",
    .can_apply = can_apply,
    .set_local = set_local,
    .filter = filter,
};

/* ---- entry points of HDF5 plugins -------------------------------------------------------- */

H5PL_type_t H5PLget_plugin_type(void)
{
    return H5PL_TYPE_FILTER;
}

const void *H5PLget_plugin_info(void)
{
    if (!hdf5.get_filter)
        find_library(__builtin_return_address(0));
    return &description;
}
