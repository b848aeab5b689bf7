/* Matrices of MATLAB 4 ("MAT-File Format", appendix A): five integers of 32 bits (the kind, rows,
 * columns, a flag of imaginary parts, the length of the name with its zero), the name, and the
 * elements by column.
 *
 * `mat` takes voxels, counted from 1, to millimetres of RAS. `M` is the same without the reflection
 * of x. */
#define _GNU_SOURCE
#include "volume/formats/analyze_mat.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/file.h"
#include "volume/io/geometry.h"

enum { FILE_BYTES_MAX = 1 << 24, SIDE = 4, BIG_ENDIAN_KIND = 1000 };

/* A matrix of doubles with four rows; NULL: unknown. */
typedef struct matrices {
    const uint8_t *mat, *m;
    int big_endian;
} matrices;

static uint32_t get_u32(cvol_cursor *cursor, int big_endian)
{
    uint32_t value = cvol_cursor_u32(cursor);
    if (big_endian)
        value = value >> 24 | (value >> 8 & 0xff00) | (value << 8 & 0xff0000) | value << 24;
    return value;
}

/* The next matrix; 0: there is none. */
static int read_matrix(matrices *out, cvol_cursor *cursor)
{
    static const size_t sizes[] = {8, 4, 4, 2, 2, 1};
    cvol_cursor peek = *cursor;
    const int big_endian = cvol_cursor_u32(&peek) > 0xffff;
    const uint32_t kind = get_u32(cursor, big_endian), type = kind / 10 % 10;
    const uint64_t rows = get_u32(cursor, big_endian), columns = get_u32(cursor, big_endian);
    const uint32_t has_imaginary = get_u32(cursor, big_endian);
    const uint32_t name_bytes = get_u32(cursor, big_endian);
    const char *name = (const char *)cvol_cursor_take(cursor, name_bytes);
    if (cursor->failed || kind / 1000 != (uint32_t)big_endian || kind / 100 % 10 || type > 5 ||
        kind % 10 > 1 || has_imaginary > 1 || !name_bytes || !name || name[name_bytes - 1])
        return 0;
    uint64_t bytes;
    if (__builtin_mul_overflow(rows * columns, sizes[type] << has_imaginary, &bytes) ||
        bytes > cvol_cursor_left(cursor))
        return 0;
    const uint8_t *elements = cvol_cursor_take(cursor, (size_t)bytes);
    if (type || rows != SIDE || columns < SIDE || has_imaginary)
        return 1;
    out->big_endian = big_endian;
    if (!strcmp(name, "mat"))
        out->mat = elements;
    if (!strcmp(name, "M"))
        out->m = elements;
    return 1;
}

static int set_geometry(cvol_context *context, cvol_grid *grid, const matrices *of,
                        const char *path)
{
    double a[SIDE][SIDE]; /* by column */
    memcpy(a, of->mat ? of->mat : of->m, sizeof a);
    if (of->big_endian != cvol_machine_is_big_endian())
        cvol_swap_bytes(a, SIDE * SIDE, sizeof(double));
    for (int k = 0; k < SIDE && !of->mat; k++)
        a[k][0] = -a[k][0];
    int is_right = 1;
    for (int axis = 0; axis < 3; axis++)
        is_right = is_right && cvol_geometry_set_axis(grid, axis, a[axis]);
    for (int i = 0; i < 3; i++) {
        grid->origin[i] = a[3][i] + a[0][i] + a[1][i] + a[2][i];
        is_right = is_right && isfinite(grid->origin[i]);
    }
    if (!is_right)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its matrix '%s' has columns that are no directions", path,
                         of->mat ? "mat" : "M");
    return cvol_geometry_check(context, grid, path);
}

int cvol_analyze_read_mat(cvol_context *context, cvol_grid *grid, const char *path)
{
    uint8_t *data;
    size_t size;
    if (access(path, F_OK))
        return CVOL_OK;
    int code = cvol_file_read(context, &data, &size, path, 0, FILE_BYTES_MAX);
    if (code)
        return code;
    cvol_cursor cursor = cvol_cursor_make(data, size);
    matrices found = {.mat = NULL};
    if (size >= 10 && !memcmp(data, "MATLAB 5.0", 10))
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: states the geometry of the image in a file of MATLAB 5, and only "
                         "those of version 4 are read (save -v4)",
                         path);
    while (!code && cvol_cursor_left(&cursor) && read_matrix(&found, &cursor))
        continue;
    if (!code && (found.mat || found.m))
        code = set_geometry(context, grid, &found, path);
    free(data);
    return code;
}
