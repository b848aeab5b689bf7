/* cvol/base.h - contexts, errors, sample types, grids, threads and progress.
 *
 * Every function that can fail takes a cvol_context first and returns CVOL_OK (0) or one of the
 * negative codes below. After a failure the context holds a message for the user
 * (cvol_context_message). The library never prints, exits or aborts.
 *
 * One thread at a time may use a context. Different contexts are independent.
 *
 * An option struct, such as cvol_read_options, begins with its size: the sizeof in the headers of
 * the caller, because later versions may append fields. Its function of defaults sets it. Fields
 * beyond the size of the caller have their defaults. Functions refuse (ARGUMENT) a struct that is
 * smaller than in version 0.1, for example of size 0; and a struct that is larger than the library
 * knows, if a byte beyond the known fields is not 0. Structs inside an option struct (cvol_camera,
 * ...) and structs that functions fill in (infos, reports) have no size, and are frozen: later
 * versions do not append fields to them.
 *
 * Names: a function that makes an object is called _create, _read or _open, or by a verb
 * (cvol_array_compress); _free frees the object. A file that is being written ends with _commit or
 * _abandon instead, which free the object too. A property has no verb (cvol_array_grid), or _is_ or
 * _has_ if it is true or false (cvol_series_has_colours); _set_ changes it. _get_ copies facts to
 * memory of the caller (cvol_array_get_info). _compute_ computes them from terms or samples, and
 * _count_ and _read_ find them in a file (cvol_file_read_grid). */
#ifndef CVOL_BASE_H
#define CVOL_BASE_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__) && !defined(CVOL_API)
#define CVOL_API __attribute__((visibility("default")))
#elif !defined(CVOL_API)
#define CVOL_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of these headers; cvol_version() returns that of the library. */
#define CVOL_VERSION_MAJOR 0
#define CVOL_VERSION_MINOR 1
#define CVOL_VERSION_PATCH 0

/* "0.1.0"; static storage. */
CVOL_API const char *cvol_version(void);

/* Status codes. Their numbers are frozen. */
enum {
    CVOL_OK = 0,
    CVOL_ERROR_ARGUMENT = -1,    /* an argument is invalid */
    CVOL_ERROR_MEMORY = -2,      /* an allocation failed */
    CVOL_ERROR_IO = -3,          /* the operating system refused a read or a write */
    CVOL_ERROR_FORMAT = -4,      /* a file violates its format */
    CVOL_ERROR_CORRUPT = -5,     /* a .cvol file is damaged: a checksum or an invariant is wrong */
    CVOL_ERROR_UNSUPPORTED = -6, /* valid, but not supported by this build */
    CVOL_ERROR_LIMIT = -7,       /* larger than the context's limits allow */
    CVOL_ERROR_DATA = -8,        /* samples cannot be compressed (NaN, infinity) */
    CVOL_ERROR_TARGET = -9,      /* the ratio, PSNR or error cannot be reached */
    CVOL_ERROR_CANCELLED = -10   /* the progress function returned nonzero */
};

/* Settings shared by calls: threads, limits, progress; and the message of the last failure. */
typedef struct cvol_context cvol_context;

/* Returns a new context, or NULL without memory. The caller frees it. */
CVOL_API cvol_context *cvol_context_create(void);
/* Frees a context; NULL is allowed. Objects that were made with it stay valid. */
CVOL_API void cvol_context_free(cvol_context *context);
/* The message of the last failure, "" if there was none. The context owns it; it is valid until the
 * next failure. */
CVOL_API const char *cvol_context_message(const cvol_context *context);

/* Sets the number of worker threads; 0 (default): all cores. */
CVOL_API void cvol_context_set_threads(cvol_context *context, int threads);
/* The number of threads that calls use, at least 1. */
CVOL_API int cvol_context_threads(const cvol_context *context);

/* Files that belong together, such as the pictures of a turn: after cvol_context_hold_outputs,
 * files that calls with this context write wait under hidden names (.cvol-XXXXXX in the same
 * folder). cvol_context_release_outputs gives all of them their names if `code` is CVOL_OK, and
 * removes them otherwise. If one cannot get its name, all older files stay or come back. Returns
 * the outcome. Errors: `code`, IO. */
CVOL_API void cvol_context_hold_outputs(cvol_context *context);
CVOL_API int cvol_context_release_outputs(cvol_context *context, int code);

/* Long calls call this function from the calling thread, with a description of the step and the
 * finished share of it (0 to 1). If it returns nonzero, the call stops, frees everything it made,
 * and returns CVOL_ERROR_CANCELLED. */
typedef int (*cvol_progress_fn)(void *user, const char *what, double fraction);
/* Sets the progress function and its `user` argument; NULL: none. */
CVOL_API void cvol_context_set_progress(cvol_context *context, cvol_progress_fn progress,
                                        void *user);

/* Sets the largest dense volume, in bytes, that a reader or a decoder may allocate because a file
 * says so. Default: 64 GiB. Programs of 32 bits cannot have more than 4 GiB - 1. */
CVOL_API void cvol_context_set_limit_bytes(cvol_context *context, uint64_t limit_bytes);
/* Returns that limit. */
CVOL_API uint64_t cvol_context_limit_bytes(const cvol_context *context);

/* allowed 0: readers open no files but those that the caller names, and the files of a folder that
 * the caller names. A header of NRRD or MetaImage whose samples are in another file then fails with
 * UNSUPPORTED: a stranger's header could name any file that the process may read. Default: 1. */
CVOL_API void cvol_context_set_external(cvol_context *context, int allowed);

/* Sample types. Their numbers are part of the file format. */
typedef enum cvol_type {
    CVOL_UINT8 = 1,
    CVOL_INT8 = 2,
    CVOL_UINT16 = 3,
    CVOL_INT16 = 4,
    CVOL_UINT32 = 5,
    CVOL_INT32 = 6,
    CVOL_FLOAT32 = 7,
    CVOL_FLOAT64 = 8
} cvol_type;

/* Bytes of one sample; 0 for an invalid type. */
CVOL_API size_t cvol_type_size(cvol_type type);
/* "uint8", "int8", ..., as in the command and in file headers; NULL for an invalid type. */
CVOL_API const char *cvol_type_name(cvol_type type);
/* The type with this name, or 0. */
CVOL_API cvol_type cvol_type_from_name(const char *name);
/* 1 for the six integer types. */
CVOL_API int cvol_type_is_integer(cvol_type type);
/* Sets *least and *largest to the least and the largest value of a valid type. */
CVOL_API void cvol_type_get_range(double *least, double *largest, cvol_type type);

/* Direction of the world axes of a grid. */
typedef enum cvol_space {
    CVOL_SPACE_UNKNOWN = 0,
    CVOL_SPACE_LPS = 1, /* +x left, +y posterior, +z superior (DICOM, ITK) */
    CVOL_SPACE_RAS = 2  /* +x right, +y anterior, +z superior (NIfTI) */
} cvol_space;

/* Shape, sample type and geometry of a volume.
 *
 * Sample (x, y, z), 0 <= x < dims[0] and so on, is element x + dims[0] (y + dims[1] z): x runs
 * fastest. Its position in the world is
 *
 *     world[i] = origin[i] + sum_a direction[a][i] spacing[a] (x, y, z)[a]
 *
 * where direction[a] is the unit vector along axis a. */
typedef struct cvol_grid {
    size_t dims[3];
    cvol_type type;
    double spacing[3];      /* distance of neighbours along each axis, > 0, in `unit` */
    double origin[3];       /* world position of sample (0, 0, 0), in `unit` */
    double direction[3][3]; /* unit vectors, one row per axis */
    cvol_space space;
    char unit[16];      /* "mm", "um", ...; "": unknown */
    double value_scale; /* not 0: a stored sample s means the value value_scale s + value_offset. */
    double value_offset; /* Functions work on s; for results of operations see cvol/algebra.h */
} cvol_grid;

/* A grid of this shape and type with spacing 1, origin 0, axis-aligned, scale 1. */
CVOL_API cvol_grid cvol_grid_make(size_t nx, size_t ny, size_t nz, cvol_type type);
/* Checks a grid: dims > 0, a valid type, positive finite spacing, finite numbers, a value scale
 * other than 0, a space of cvol_space, a unit that ends; the product of dims and the bytes fit into
 * size_t and the limit of the context. `name`, for example the name of a file, begins the message.
 * Errors: ARGUMENT, LIMIT. */
CVOL_API int cvol_grid_check(cvol_context *context, const cvol_grid *grid, const char *name);
/* The grid of the box of samples [begin, end), which must lie within `grid`. Sample `begin` becomes
 * its first one; positions in the world stay the same. */
CVOL_API cvol_grid cvol_grid_box(const cvol_grid *grid, const size_t begin[3], const size_t end[3]);
/* nx ny nz. The grid must have passed cvol_grid_check. */
CVOL_API size_t cvol_grid_samples(const cvol_grid *grid);
/* Number of samples times bytes per sample. */
CVOL_API size_t cvol_grid_bytes(const cvol_grid *grid);

#ifdef __cplusplus
}
#endif
#endif
