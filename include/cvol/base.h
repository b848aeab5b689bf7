/* cvol/base.h - contexts, errors, sample types, grids, threads and progress.
 *
 * Every function that can fail takes a cvol_context first and returns CVOL_OK (0)
 * or one of the negative codes below; the context then holds one sentence for
 * people (cvol_context_message). The library never prints, exits or aborts.
 *
 * A context is used by one thread at a time; two contexts are independent.
 */
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

/* The version of these headers; cvol_version() tells that of the library. */
#define CVOL_VERSION_MAJOR 0
#define CVOL_VERSION_MINOR 1
#define CVOL_VERSION_PATCH 0

/* "0.1.0"; static storage. */
CVOL_API const char *cvol_version(void);

/* Status codes. Their numbers are frozen. */
enum {
    CVOL_OK = 0,
    CVOL_ERROR_ARGUMENT = -1,    /* the caller asked for something that has no meaning */
    CVOL_ERROR_MEMORY = -2,      /* an allocation failed */
    CVOL_ERROR_IO = -3,          /* the operating system refused a read or a write */
    CVOL_ERROR_FORMAT = -4,      /* a file is not what its format demands */
    CVOL_ERROR_CORRUPT = -5,     /* a checksum or an invariant of a .cvol does not hold */
    CVOL_ERROR_UNSUPPORTED = -6, /* well formed, but outside what this build can do */
    CVOL_ERROR_LIMIT = -7,       /* larger than the context's limits allow */
    CVOL_ERROR_DATA = -8,        /* samples that cannot be compressed (NaN, infinity) */
    CVOL_ERROR_TARGET = -9,      /* the asked ratio, PSNR or error cannot be met */
    CVOL_ERROR_CANCELLED = -10   /* the progress callback asked to stop */
};

/* What calls share: threads, limits, progress, and the sentence of the last failure. */
typedef struct cvol_context cvol_context;

/* A new context, or NULL when there is no memory. The caller destroys it. */
CVOL_API cvol_context *cvol_context_create(void);
/* Frees the context; NULL is allowed. Objects made with it stay valid. */
CVOL_API void cvol_context_destroy(cvol_context *context);
/* The sentence that belongs to the last failure, "" if there was none.
 * Owned by the context, valid until its next failing call. */
CVOL_API const char *cvol_context_message(const cvol_context *context);

/* Worker threads for the calls made with this context; 0 (default): all cores. */
CVOL_API void cvol_context_set_threads(cvol_context *context, int threads);
/* The number of threads that calls will use, at least 1. */
CVOL_API int cvol_context_threads(const cvol_context *context);

/* Called now and then by long work, from the calling thread, with what is being done
 * and how much of it is (0..1). A result other than 0 cancels: the call returns
 * CVOL_ERROR_CANCELLED and leaves nothing behind. */
typedef int (*cvol_progress_fn)(void *user, const char *what, double fraction);
/* Sets the function that is called, and what it is handed; NULL: none is. */
CVOL_API void cvol_context_set_progress(cvol_context *context, cvol_progress_fn progress,
                                        void *user);

/* The largest dense volume (bytes) that a reader or a decoder may be made to allocate
 * by what a file claims. Default: 64 GiB. */
CVOL_API void cvol_context_set_limit_bytes(cvol_context *context, uint64_t limit_bytes);
/* That limit. */
CVOL_API uint64_t cvol_context_limit_bytes(const cvol_context *context);

/* Types of samples. Their numbers are part of the file format. */
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

/* Bytes of one sample; 0 for a number that is no type. */
CVOL_API size_t cvol_type_size(cvol_type type);
/* "uint8", "int8", ... as the command and the file headers write it; NULL for no type. */
CVOL_API const char *cvol_type_name(cvol_type type);
/* The type with this name, or 0. */
CVOL_API cvol_type cvol_type_from_name(const char *name);
/* 1 for the six integer types. */
CVOL_API int cvol_type_is_integer(cvol_type type);
/* The least and the largest value of a type (which must be one). */
CVOL_API void cvol_type_range(cvol_type type, double *least, double *largest);

/* Which way the world axes of a grid point. */
typedef enum cvol_space {
    CVOL_SPACE_UNKNOWN = 0,
    CVOL_SPACE_LPS = 1, /* +x left, +y posterior, +z superior (DICOM, ITK) */
    CVOL_SPACE_RAS = 2  /* +x right, +y anterior, +z superior (NIfTI) */
} cvol_space;

/* What the samples of a volume are and where they lie in the world.
 *
 * Sample (x, y, z), 0 <= x < dims[0] and so on, is element x + dims[0] (y + dims[1] z):
 * x runs fastest. It lies at
 *     world[i] = origin[i] + sum_a direction[a][i] spacing[a] (x, y, z)[a]
 * where direction[a] is the unit vector along which axis a runs. */
typedef struct cvol_grid {
    size_t dims[3];
    cvol_type type;
    double spacing[3];      /* distance of neighbours along each axis, > 0, in `unit` */
    double origin[3];       /* world position of sample (0, 0, 0), in `unit` */
    double direction[3][3]; /* unit vectors, one row per axis */
    cvol_space space;
    char unit[16];       /* "mm", "um", ...; "" when unknown */
    double value_scale;  /* a stored sample s means value_scale s + value_offset; */
    double value_offset; /* kept for the file's sake: all else works on s itself */
} cvol_grid;

/* A grid of this shape and type with spacing 1, origin 0, axis-aligned, scale 1. */
CVOL_API cvol_grid cvol_grid_make(size_t nx, size_t ny, size_t nz, cvol_type type);
/* Checks a grid: dims > 0, a known type, finite positive spacing, finite numbers,
 * dims product and bytes within size_t and the context's limit. `name` (a file's name,
 * say) begins the message. Errors: ARGUMENT, LIMIT. */
CVOL_API int cvol_grid_check(cvol_context *context, const cvol_grid *grid, const char *name);
/* The grid of the box of samples [begin, end), which must lie within `grid`: sample `begin` becomes
 * its first, and stays where it is in the world. */
CVOL_API cvol_grid cvol_grid_box(const cvol_grid *grid, const size_t begin[3], const size_t end[3]);
/* nx ny nz. The grid must have passed cvol_grid_check. */
CVOL_API size_t cvol_grid_samples(const cvol_grid *grid);
/* samples times the bytes of one. */
CVOL_API size_t cvol_grid_bytes(const cvol_grid *grid);

#ifdef __cplusplus
}
#endif
#endif
