/* Files of MATLAB 5 ("MAT-File Format", MathWorks): the arrays of numbers in them. */
#ifndef CVOL_VOLUME_FORMATS_MATLAB_VARIABLES_H
#define CVOL_VOLUME_FORMATS_MATLAB_VARIABLES_H

#include "volume/io/axes.h"
#include "volume/io/wide.h"

#define CVOL_MATLAB_NAME_BYTES 64

/* An array of numbers. MATLAB may store them in a smaller type than the array's: samples have the
 * stored type. */
typedef struct cvol_matlab_variable {
    char name[CVOL_MATLAB_NAME_BYTES]; /* printable */
    int rank;
    uint64_t dims[CVOL_AXES_MAX]; /* the first index runs fastest; all are positive */
    int is_complex;
    int is_known; /* the type is that of samples */
    cvol_type type;
    cvol_wide wide;
    int is_packed;       /* by zlib */
    uint64_t offset;     /* packed: of the stream in the file */
    uint64_t size;       /* packed: of the stream */
    uint64_t at;         /* of the first number: in the file, or in the unpacked bytes */
    uint64_t real_bytes; /* of the real parts */
} cvol_matlab_variable;

typedef struct cvol_matlab_list {
    cvol_matlab_variable *variables; /* freed with free() */
    size_t count;
    int big_endian;
} cvol_matlab_list;

/* 1 if a file begins like one of MATLAB 5. */
int cvol_matlab_recognise(const uint8_t *head, size_t size);
/* Lists the arrays of a file that have elements and at most CVOL_AXES_MAX axes. `name` begins
 * messages. The caller frees the list, also after a failure. Errors: IO, FORMAT, MEMORY. */
int cvol_matlab_list_read(cvol_context *context, cvol_matlab_list *list, const char *path,
                          const char *name);
/* Chooses a variable by its name; NULL: the only one of three axes or more. Errors: ARGUMENT,
 * FORMAT, UNSUPPORTED (complex numbers). */
int cvol_matlab_list_choose(cvol_context *context, const cvol_matlab_variable **out,
                            const cvol_matlab_list *list, const char *inside, const char *name);

#endif
