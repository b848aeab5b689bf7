/* Analyze 7.5 (Mayo Clinic), and what SPM added to it: a header NAME.hdr of 348 bytes, and samples
 * in NAME.img or, packed, in NAME.img.gz. NIfTI took over the places of most fields; a header
 * with NIfTI's magic is one of NIfTI. NAME.img opens the pair, too.
 *
 * The header has no directions. As SPM and nibabel do: x runs to the left, y to the front, z up;
 * the origin is that of SPM, or the centre of the volume, unless SPM's NAME.mat states all. Units
 * are not stated. */
#include "volume/formats/analyze.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/grid.h"
#include "volume/formats/analyze_mat.h"
#include "volume/formats/nifti_codes.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/text.h"

enum { HEADER_BYTES = 348, DIM = 40, DATATYPE = 70, PIXDIM = 76, VOX_OFFSET = 108, SCALE = 112 };
enum { ORIGIN = 253, MAGIC = 344 };

typedef struct analyze {
    cvol_context *context;
    const char *path;
    uint8_t header[HEADER_BYTES];
    int big_endian;
    cvol_wide wide;
    size_t volumes;
} analyze;

static uint32_t get_bits(const uint8_t *p, int bytes, int big_endian)
{
    uint32_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint32_t)p[big_endian ? bytes - 1 - i : i] << 8 * i;
    return value;
}

static int get_integer(const analyze *a, int at)
{
    return (int16_t)get_bits(a->header + at, 2, a->big_endian);
}

static double get_real(const analyze *a, int at)
{
    const uint32_t bits = get_bits(a->header + at, 4, a->big_endian);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static int has_magic(const uint8_t *header)
{
    return !memcmp(header + MAGIC, "ni1", 4) || !memcmp(header + MAGIC, "n+1", 4);
}

/* There is no signature: the size of the header in one byte order, and one to seven axes. */
static int find_order(int *big_endian, const uint8_t *header)
{
    for (*big_endian = 0; *big_endian < 2; ++*big_endian) {
        const int axes = (int16_t)get_bits(header + DIM, 2, *big_endian);
        if (get_bits(header, 4, *big_endian) == HEADER_BYTES && axes >= 1 && axes <= 7)
            return 1;
    }
    return 0;
}

static int recognise(const uint8_t *head, size_t size)
{
    int big_endian;
    return size == HEADER_BYTES && !has_magic(head) && find_order(&big_endian, head);
}

/* ---- the pair ------------------------------------------------------------------------ */

/* The other file of a pair: the name with another ending. NULL: the name does not end so, or no
 * memory. */
static char *other_of(const char *path, const char *ending, const char *other)
{
    if (!cvol_text_ends(path, ending))
        return NULL;
    const size_t stem = strlen(path) - strlen(ending), room = stem + strlen(other) + 1;
    char *name = malloc(room);
    if (name) {
        memcpy(name, path, stem);
        memcpy(name + stem, other, room - stem);
    }
    return name;
}

static int exists(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file)
        fclose(file);
    return file != NULL;
}

char *cvol_analyze_header_of(const char *path)
{
    char *name = other_of(path, ".img", ".hdr");
    if (name)
        return name;
    name = other_of(path, ".img.gz", ".hdr");
    char *packed = name && !exists(name) ? other_of(path, ".img.gz", ".hdr.gz") : NULL;
    if (packed && exists(packed)) {
        free(name);
        return packed;
    }
    free(packed);
    return name;
}

static int is_nifti(const char *path)
{
    uint8_t head[CVOL_FORMAT_HEAD_BYTES];
    size_t size;
    cvol_context context = {.limit_bytes = 0}; /* for discarded messages */
    return !cvol_file_peek(&context, head, &size, sizeof head, path) &&
           cvol_format_nifti.recognise(head, size);
}

int cvol_analyze_has_header(const char *path)
{
    char *name = cvol_analyze_header_of(path);
    FILE *file = name ? fopen(name, "rb") : NULL;
    uint8_t head[4] = {0};
    int is_header = 0;
    if (file) { /* other programs have text in NAME.hdr */
        is_header = fread(head, 1, sizeof head, file) == sizeof head &&
                    (get_bits(head, 4, 0) == HEADER_BYTES || get_bits(head, 4, 1) == HEADER_BYTES ||
                     get_bits(head, 4, 0) == 540 || get_bits(head, 4, 1) == 540);
        fclose(file);
    }
    is_header = is_header || (name && is_nifti(name)); /* a packed one */
    free(name);
    return is_header;
}

static int find_samples(const analyze *a, cvol_stored *stored)
{
    char *plain = other_of(a->path, ".hdr", ".img"), *packed = other_of(a->path, ".hdr", ".img.gz");
    if (!plain || !packed) {
        free(plain);
        free(packed);
        return cvol_text_ends(a->path, ".hdr")
                   ? cvol_fail_memory(a->context, strlen(a->path), a->path)
                   : cvol_fail(a->context, CVOL_ERROR_FORMAT,
                               "%s: is the header of a pair, whose name must end in .hdr", a->path);
    }
    const int is_packed = exists(packed);
    stored->encoding = is_packed ? CVOL_ENCODING_GZIP : CVOL_ENCODING_RAW;
    stored->data_path = is_packed ? packed : plain;
    free(is_packed ? plain : packed);
    return CVOL_OK;
}

/* ---- header -------------------------------------------------------------------------- */

static int read_header(analyze *a)
{
    size_t size;
    int code = cvol_file_peek(a->context, a->header, &size, HEADER_BYTES, a->path);
    if (!code && (size < HEADER_BYTES || !find_order(&a->big_endian, a->header)))
        code = cvol_fail(
            a->context, CVOL_ERROR_FORMAT,
            "%s: is not a header of Analyze or NIfTI: it does not begin with its size, "
            "348",
            a->path);
    return code;
}

static int read_type(analyze *a, cvol_grid *grid)
{
    const int code = get_integer(a, DATATYPE);
    switch (code) {
    case CVOL_NIFTI_UINT8:
        grid->type = CVOL_UINT8;
        return CVOL_OK;
    case CVOL_NIFTI_INT16:
        grid->type = CVOL_INT16;
        return CVOL_OK;
    case CVOL_NIFTI_INT32:
        grid->type = CVOL_INT32;
        return CVOL_OK;
    case CVOL_NIFTI_FLOAT32:
        grid->type = CVOL_FLOAT32;
        return CVOL_OK;
    case CVOL_NIFTI_FLOAT64:
        grid->type = CVOL_FLOAT64;
        return CVOL_OK;
    case CVOL_NIFTI_COMPLEX64:
        grid->type = CVOL_WIDE_TYPE;
        a->wide = CVOL_WIDE_COMPLEX64;
        return CVOL_OK;
    default:
        return cvol_fail(a->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: datatype is %d; 2, 4, 8, 16, 32 and 64 are supported", a->path, code);
    }
}

static int read_shape(analyze *a, cvol_grid *grid)
{
    const int axes = get_integer(a, DIM);
    for (int i = 1; i <= axes; i++) {
        const int size = get_integer(a, DIM + 2 * i);
        if (size < (i <= 3))
            return cvol_fail(a->context, CVOL_ERROR_FORMAT, "%s: dim[%d] is %d, must be positive",
                             a->path, i, size);
        if (i <= 3)
            grid->dims[i - 1] = (size_t)size;
        else if (i == 4 && size)
            a->volumes = (size_t)size;
        else if (size > 1)
            return cvol_fail(a->context, CVOL_ERROR_UNSUPPORTED,
                             "%s: dim[%d] is %d: a file of more than four axes, which are not "
                             "supported",
                             a->path, i, size);
    }
    return CVOL_OK;
}

/* SPM's origin counts from 1, and is left out if it is far outside. */
static void find_origin(const analyze *a, const cvol_grid *grid, double origin[3])
{
    int is_given = 0, is_near = 1;
    for (int i = 0; i < 3; i++) {
        const int at = get_integer(a, ORIGIN + 2 * i), size = (int)grid->dims[i];
        is_given = is_given || at != 0;
        is_near = is_near && at > -size && at < 2 * size;
        origin[i] = at - 1;
    }
    for (int i = 0; i < 3 && !(is_given && is_near); i++)
        origin[i] = ((double)grid->dims[i] - 1) / 2;
}

static int read_geometry(const analyze *a, cvol_grid *grid)
{
    double origin[3];
    find_origin(a, grid, origin);
    grid->space = CVOL_SPACE_RAS;
    grid->direction[0][0] = -1;
    for (int i = 0; i < 3; i++) {
        const double spacing = fabs(get_real(a, PIXDIM + 4 * (i + 1)));
        if (!isfinite(spacing))
            return cvol_fail(a->context, CVOL_ERROR_FORMAT, "%s: pixdim[%d] is %g", a->path, i + 1,
                             spacing);
        grid->spacing[i] = spacing > 0 ? spacing : 1;
        grid->origin[i] = -origin[i] * grid->spacing[i] * grid->direction[i][i] + 0.0;
    }
    char *mat = other_of(a->path, ".hdr", ".mat");
    const int code = mat ? cvol_analyze_read_mat(a->context, grid, mat) : CVOL_OK;
    free(mat);
    return code ? code : cvol_geometry_check(a->context, grid, a->path);
}

static int choose_volume(const analyze *a, const cvol_grid *grid, cvol_stored *stored,
                         const cvol_read_options *options)
{
    size_t index, channel;
    const double offset = get_real(a, VOX_OFFSET), scale = get_real(a, SCALE);
    int code = cvol_format_choose(a->context, &index, a->path, "volume", "--time", a->volumes,
                                  options->has_index, options->index);
    if (!code)
        code = cvol_format_choose(a->context, &channel, a->path, "channel", "--channel", 1,
                                  options->has_channel, options->channel);
    if (!code)
        code = cvol_grid_check_within(a->context, grid, a->path, UINT64_MAX);
    if (!code && (!(fabs(offset) < 0x1p53) || !isfinite(scale)))
        code = cvol_fail(a->context, CVOL_ERROR_FORMAT,
                         "%s: vox_offset is %g and the scale %g, which must be finite", a->path,
                         offset, scale);
    if (code)
        return code;
    uint64_t skip; /* a negative offset is one in each volume */
    if (__builtin_mul_overflow((uint64_t)index, (uint64_t)cvol_grid_bytes(grid), &skip) ||
        __builtin_add_overflow(skip, (uint64_t)fabs(offset), &skip))
        skip = UINT64_MAX;
    stored->byte_skip = skip;
    stored->may_go_on = stored->has_more_volumes = a->volumes > 1;
    stored->big_endian = a->big_endian;
    stored->wide = a->wide;
    return CVOL_OK;
}

static int find_pair(analyze *a, cvol_grid *grid, cvol_stored *stored,
                     const cvol_read_options *options)
{
    if (is_nifti(a->path))
        return cvol_format_nifti.find(a->context, grid, stored, a->path, options);
    int code = read_header(a);
    *grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    if (!code)
        code = read_type(a, grid);
    if (!code)
        code = read_shape(a, grid);
    if (!code)
        code = read_geometry(a, grid);
    if (!code)
        code = find_samples(a, stored);
    if (!code)
        code = choose_volume(a, grid, stored, options);
    const double scale = code ? 0 : get_real(a, SCALE);
    if (scale < 0 || scale > 0)
        grid->value_scale = scale;
    return code;
}

static int find_analyze(cvol_context *context, cvol_grid *grid, cvol_stored *stored,
                        const char *path, const cvol_read_options *options)
{
    char *name = cvol_analyze_header_of(path);
    analyze a = {.context = context, .path = name ? name : path, .volumes = 1};
    const int code = find_pair(&a, grid, stored, options);
    free(name);
    return code;
}

const cvol_format cvol_format_analyze = {
    .name = "Analyze",
    .recognise = recognise,
    .find = find_analyze,
    .takes = CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
};
