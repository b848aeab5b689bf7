/* NIfTI-1 and NIfTI-2 (nifti.nimh.nih.gov): a binary header of 348 or 540 bytes in either byte
 * order, and the samples in the same file (.nii, .nii.gz) or in a second one (.hdr, .img).
 *
 * The header is decoded here, field by field, and not by niftilib, which trusts headers: it
 * allocates the sizes they claim, and prints. The affine is the sform, else the qform, else the
 * spacings alone; the world is RAS. Written: NIfTI-1 if the shape and the affine fit into it, else
 * NIfTI-2. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/grid.h"
#include "volume/formats/analyze.h"
#include "volume/formats/nifti_affine.h"
#include "volume/formats/nifti_codes.h"
#include "volume/formats/nifti_fields.h"
#include "volume/formats/nifti_intent.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/interleaved.h"
#include "volume/io/packed.h"
#include "volume/io/text.h"

static const struct {
    int code;
    cvol_type type;
} datatypes[] = {
    {CVOL_NIFTI_UINT8, CVOL_UINT8},     {CVOL_NIFTI_INT8, CVOL_INT8},
    {CVOL_NIFTI_UINT16, CVOL_UINT16},   {CVOL_NIFTI_INT16, CVOL_INT16},
    {CVOL_NIFTI_UINT32, CVOL_UINT32},   {CVOL_NIFTI_INT32, CVOL_INT32},
    {CVOL_NIFTI_FLOAT32, CVOL_FLOAT32}, {CVOL_NIFTI_FLOAT64, CVOL_FLOAT64},
};

static const struct {
    int code;
    cvol_wide wide;
} wide_datatypes[] = {
    {CVOL_NIFTI_INT64, CVOL_WIDE_INT64},
    {CVOL_NIFTI_UINT64, CVOL_WIDE_UINT64},
    {CVOL_NIFTI_COMPLEX64, CVOL_WIDE_COMPLEX64},
};

/* The names, for messages, of the types that are not read, or only for one channel. */
static const struct {
    int code;
    const char *name;
} other_datatypes[] = {
    {1, "DT_BINARY"},
    {255, "DT_ALL"},
    {CVOL_NIFTI_RGB24, "NIFTI_TYPE_RGB24"},
    {CVOL_NIFTI_FLOAT128, "NIFTI_TYPE_FLOAT128"},
    {CVOL_NIFTI_COMPLEX128, "NIFTI_TYPE_COMPLEX128"},
    {CVOL_NIFTI_COMPLEX256, "NIFTI_TYPE_COMPLEX256"},
    {CVOL_NIFTI_RGBA32, "NIFTI_TYPE_RGBA32"},
};

#define DATATYPES (sizeof datatypes / sizeof datatypes[0])

static const struct {
    int code;
    const char *name;
} units[] = {{CVOL_NIFTI_METER, "m"}, {CVOL_NIFTI_MM, "mm"}, {CVOL_NIFTI_MICRON, "um"}};

#define UNITS (sizeof units / sizeof units[0])
/* The bits of xyzt_units for space, */
#define SPACE_UNITS 7
/* and for time, or another fourth axis. */
#define TIME_UNITS 0x38

typedef struct nifti {
    cvol_context *context;
    const char *path;
    cvol_nifti_header header;
    int is_gzip, is_pair;
    uint64_t vox_offset;
    size_t volumes;  /* for a time series; 1 otherwise */
    size_t channels; /* for vectors or colours; 1 otherwise */
    int has_colours; /* the bytes of a voxel are interleaved */
    cvol_wide wide;
    cvol_grid grid;
} nifti;

/* Short names for the readers of fields below. */
static int64_t get_integer(const nifti *n, size_t at, size_t width)
{
    return cvol_nifti_get_integer(&n->header, at, width);
}

static double get_real(const nifti *n, size_t at, size_t i)
{
    return cvol_nifti_get_real(&n->header, at, i);
}

/* ---- recognising --------------------------------------------------------------------- */

static int has_magic(const nifti *n, const char *magic)
{
    return !memcmp(n->header.bytes + n->header.at->magic_at, magic, 4);
}

static int recognise(const uint8_t *head, size_t size)
{
    nifti n = {.context = NULL};
    size_t count;
    if (cvol_packed_is(head, size))
        count = cvol_inflate_head(n.header.bytes, sizeof n.header.bytes, head, size);
    else {
        count = size < sizeof n.header.bytes ? size : sizeof n.header.bytes;
        memcpy(n.header.bytes, head, count);
    }
    return cvol_nifti_find_layout(&n.header, count) && count >= n.header.at->size &&
           (has_magic(&n, n.header.at->magic) || has_magic(&n, n.header.at->pair_magic));
}

/* ---- header -------------------------------------------------------------------------- */

static int check_header(nifti *n, size_t size)
{
    if (!cvol_nifti_find_layout(&n->header, size)) {
        n->header.big_endian = 0;
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: is not a NIfTI file: sizeof_hdr is %lld, must be 348 or 540", n->path,
                         (long long)get_integer(n, 0, 4));
    }
    if (size < n->header.at->size)
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: holds %zu of the %zu bytes of a header", n->path, size,
                         n->header.at->size);
    n->is_pair = has_magic(n, n->header.at->pair_magic);
    if (n->is_pair || has_magic(n, n->header.at->magic))
        return CVOL_OK;
    char magic[4];
    for (size_t i = 0; i < 4; i++) {
        uint8_t c = n->header.bytes[n->header.at->magic_at + i];
        magic[i] = c >= ' ' && c <= '~' ? (char)c : '.';
    }
    return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: magic is '%.4s', must be '%s' or '%s'",
                     n->path, magic, n->header.at->magic, n->header.at->pair_magic);
}

static int read_header(nifti *n)
{
    cvol_packed file;
    uint64_t size = 0;
    int code = cvol_packed_open(n->context, &file, n->path);
    if (!code)
        code = cvol_packed_read(n->context, &file, n->header.bytes, sizeof n->header.bytes, &size);
    n->is_gzip = file.inflater != NULL;
    cvol_packed_close(&file);
    return code ? code : check_header(n, (size_t)size);
}

static int find_label_intent(cvol_context *context, int *out, const char *path)
{
    nifti n = {.context = context, .path = path};
    const int code = read_header(&n);
    *out = 0;
    if (code)
        return code == CVOL_ERROR_MEMORY ||
                       (code == CVOL_ERROR_IO && cvol_file_may_be_regular(path))
                   ? code
                   : CVOL_OK;
    const int first = n.header.at->version == 1;
    *out = get_integer(&n, first ? 68 : 504, first ? 2 : 4) == CVOL_NIFTI_LABEL;
    return CVOL_OK;
}

int cvol_nifti_find_label_intent(cvol_context *context, int *out, const char *path)
{
    char *header = cvol_analyze_has_header(path) ? cvol_analyze_header_of(path) : NULL;
    const int code = find_label_intent(context, out, header ? header : path);
    free(header);
    return code;
}

static int64_t get_dim(const nifti *n, size_t i)
{
    return get_integer(n, n->header.at->dim + i * n->header.at->dim_width, n->header.at->dim_width);
}

static int read_dims(nifti *n)
{
    int64_t count = get_dim(n, 0);
    if (count < 1 || count > 7)
        return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: dim[0] is %lld, must be 1 to 7",
                         n->path, (long long)count);
    for (size_t i = 1; i <= (size_t)count; i++) {
        int64_t dim = get_dim(n, i);
        if (dim < 0 || (dim == 0 && i <= 3))
            return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                             "%s: dim[%zu] is %lld, must be positive", n->path, i, (long long)dim);
        char field[16];
        snprintf(field, sizeof field, "dim[%zu]", i);
        const int code = cvol_check_size(n->context, n->path, field, (uint64_t)dim);
        if (code)
            return code;
        if (i <= 3)
            n->grid.dims[i - 1] = (size_t)dim;
        else if (i <= 5 && dim > 1)
            *(i == 4 ? &n->volumes : &n->channels) = (size_t)dim;
        else if (dim > 1)
            return cvol_fail(n->context, CVOL_ERROR_UNSUPPORTED,
                             "%s: dim[%zu] is %lld: a file of more than five axes, which are not "
                             "supported",
                             n->path, i, (long long)dim);
    }
    return CVOL_OK;
}

static int read_type(nifti *n)
{
    int code = (int)get_integer(n, n->header.at->datatype, 2);
    for (size_t i = 0; i < DATATYPES; i++)
        if (datatypes[i].code == code) {
            n->grid.type = datatypes[i].type;
            return CVOL_OK;
        }
    for (size_t i = 0; i < sizeof wide_datatypes / sizeof *wide_datatypes; i++)
        if (wide_datatypes[i].code == code) {
            n->grid.type = CVOL_WIDE_TYPE;
            n->wide = wide_datatypes[i].wide;
            return CVOL_OK;
        }
    if ((code == CVOL_NIFTI_RGB24 || code == CVOL_NIFTI_RGBA32) && n->channels == 1) {
        n->channels = code == CVOL_NIFTI_RGB24 ? 3 : 4;
        n->has_colours = 1;
        return CVOL_OK;
    }
    const char *name = NULL;
    for (size_t i = 0; i < sizeof other_datatypes / sizeof *other_datatypes; i++)
        if (other_datatypes[i].code == code)
            name = other_datatypes[i].name;
    if (!name)
        return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: datatype is %d, which is unknown",
                         n->path, code);
    return cvol_fail(n->context, CVOL_ERROR_UNSUPPORTED, "%s: datatype %d (%s) is not supported",
                     n->path, code, name);
}

/* 0 means "right behind the header" in single files. */
static int read_vox_offset(nifti *n)
{
    double offset = n->header.at->version == 1
                        ? get_real(n, n->header.at->vox_offset, 0)
                        : (double)get_integer(n, n->header.at->vox_offset, 8);
    double least = n->is_pair ? 0 : (double)n->header.at->size;
    if (offset == 0)
        offset = n->is_pair ? 0 : (double)(n->header.at->size + 4);
    if (!(offset >= least) || offset >= 0x1p62 || offset != floor(offset))
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: vox_offset is %g, must be an integer from %g on", n->path, offset,
                         least);
    n->vox_offset = (uint64_t)offset;
    return CVOL_OK;
}

static void read_values(nifti *n)
{
    double slope = get_real(n, n->header.at->scl_slope, 0),
           offset = get_real(n, n->header.at->scl_inter, 0);
    if (slope != 0 && isfinite(slope)) { /* else samples need no scaling */
        n->grid.value_scale = slope;
        n->grid.value_offset = offset;
    }
    int64_t unit = get_integer(n, n->header.at->xyzt_units, n->header.at->units_width) &
                   SPACE_UNITS;
    for (size_t i = 0; i < UNITS; i++)
        if (units[i].code == unit)
            snprintf(n->grid.unit, sizeof n->grid.unit, "%s", units[i].name);
}

/* ---- affine -------------------------------------------------------------------------- */

/* |pixdim|, with 1 in place of the zeros that many writers leave. */
static double get_spacing(const nifti *n, size_t axis)
{
    double spacing = fabs(get_real(n, n->header.at->pixdim, axis + 1));
    return spacing == 0 ? 1 : spacing;
}

static cvol_nifti_affine qform_affine(const nifti *n)
{
    cvol_nifti_rotation rotation = {.handedness = get_real(n, n->header.at->pixdim, 0) < 0 ? -1
                                                                                           : 1};
    double origin[3], spacing[3];
    for (size_t i = 0; i < 3; i++) {
        rotation.quaternion[i] = get_real(n, n->header.at->quatern, i);
        origin[i] = get_real(n, n->header.at->qoffset, i);
        spacing[i] = get_spacing(n, i);
    }
    return cvol_nifti_affine_of(&rotation, spacing, origin);
}

static cvol_nifti_affine sform_affine(const nifti *n)
{
    cvol_nifti_affine affine;
    for (size_t i = 0; i < 3; i++) {
        for (size_t a = 0; a < 3; a++)
            affine.step[i][a] = get_real(n, n->header.at->srow, 4 * i + a);
        affine.origin[i] = get_real(n, n->header.at->srow, 4 * i + 3);
    }
    return affine;
}

static int set_affine(nifti *n, const cvol_nifti_affine *affine, const char *name)
{
    int known[3] = {1, 1, 1};
    n->grid.space = CVOL_SPACE_RAS;
    for (int i = 0; i < 3; i++)
        n->grid.origin[i] = affine->origin[i];
    for (int a = 0; a < 3; a++) {
        double step[3] = {affine->step[0][a], affine->step[1][a], affine->step[2][a]};
        known[a] = cvol_geometry_set_axis(&n->grid, a, step);
        if (!known[a] && n->grid.dims[a] > 1)
            return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                             "%s: the %s gives axis %c the step (%g, %g, %g)", n->path, name,
                             "xyz"[a], step[0], step[1], step[2]);
    }
    cvol_geometry_complete(&n->grid, known);
    return cvol_geometry_check(n->context, &n->grid, n->path);
}

static int read_affine(nifti *n)
{
    for (size_t a = 0; a < 3; a++)
        n->grid.spacing[a] = get_spacing(n, a);
    n->grid.space = CVOL_SPACE_RAS;
    if (get_integer(n, n->header.at->sform_code, n->header.at->code_width) > 0) {
        cvol_nifti_affine affine = sform_affine(n);
        return set_affine(n, &affine, "sform");
    }
    if (get_integer(n, n->header.at->qform_code, n->header.at->code_width) > 0) {
        cvol_nifti_affine affine = qform_affine(n);
        return set_affine(n, &affine, "qform");
    }
    return CVOL_OK;
}

/* ---- reading ------------------------------------------------------------------------- */

/* The .img or .img.gz that belongs to a .hdr. The caller frees it. */
static int find_pair(const nifti *n, char **image, int *image_is_gzip)
{
    size_t length = strlen(n->path);
    if (cvol_text_ends(n->path, ".gz"))
        length -= 3;
    *image = malloc(length + sizeof ".img.gz");
    if (!*image)
        return cvol_fail_memory(n->context, length, n->path);
    memcpy(*image, n->path, length);
    (*image)[length] = '\0';
    if (!cvol_text_ends(*image, ".hdr"))
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: is the header of a pair, whose name must end in .hdr", n->path);
    memcpy(*image + length - 4, ".img.gz", sizeof ".img.gz");
    FILE *packed = fopen(*image, "rb");
    *image_is_gzip = packed != NULL;
    if (packed)
        fclose(packed);
    else
        (*image)[length] = '\0';
    return CVOL_OK;
}

/* Bytes in front of volume `place` of a contiguous series. */
static uint64_t place_of(const nifti *n, uint64_t place, uint64_t bytes)
{
    uint64_t skip;
    return __builtin_mul_overflow(place, bytes, &skip) ||
                   __builtin_add_overflow(skip, n->vox_offset, &skip)
               ? UINT64_MAX
               : skip;
}

/* Locates the chosen volume: in a time series; among components of vectors, each a whole series; or
 * among the bytes of colours. */
static int choose_volume(nifti *n, cvol_stored *stored, const cvol_read_options *options)
{
    size_t index, channel;
    uint64_t place;
    int code = cvol_format_choose(n->context, &channel, n->path, "channel", "--channel",
                                  n->channels, options->has_channel, options->channel);
    if (!code)
        code = cvol_format_choose(n->context, &index, n->path, "volume", "--time", n->volumes,
                                  options->has_index, options->index);
    if (!code) /* otherwise products below might overflow */
        code = cvol_grid_check_within(n->context, &n->grid, n->path, UINT64_MAX);
    if (code)
        return code;
    const uint64_t bytes = cvol_grid_bytes(&n->grid);
    if (n->has_colours && !cvol_labels_set_colours(&stored->labels, n->channels))
        return cvol_fail_memory(n->context, n->channels * sizeof(cvol_channel_label), n->path);
    if (n->has_colours)
        return bytes > SIZE_MAX / 4
                   ? cvol_fail_memory(n->context, SIZE_MAX, n->path)
                   : cvol_interleaved_read(n->context, stored, &n->grid,
                                           stored->data_path ? stored->data_path : n->path, n->path,
                                           n->is_gzip, place_of(n, index, bytes * n->channels),
                                           n->channels, channel);
    if (__builtin_mul_overflow((uint64_t)channel, (uint64_t)n->volumes, &place) ||
        __builtin_add_overflow(place, (uint64_t)index, &place))
        place = UINT64_MAX;
    stored->byte_skip = place_of(n, place, bytes);
    stored->may_go_on = stored->has_more_volumes = n->volumes > 1 || n->channels > 1;
    return CVOL_OK;
}

/* The fourth axis's step, if there is one; some are of frequencies. */
static void read_labels(const nifti *n, cvol_labels *labels)
{
    static const struct {
        int code;
        const char *name;
    } names[] = {{CVOL_NIFTI_SEC, "s"}, {CVOL_NIFTI_MSEC, "ms"}, {CVOL_NIFTI_USEC, "us"},
                 {CVOL_NIFTI_HZ, "Hz"}, {CVOL_NIFTI_PPM, "ppm"}, {CVOL_NIFTI_RADS, "rad/s"}};
    const double step = get_real(n, n->header.at->pixdim, 4);
    const int code = (int)get_integer(n, n->header.at->xyzt_units, n->header.at->units_width) &
                     TIME_UNITS;
    if (n->volumes < 2 || !(step > 0) || !isfinite(step))
        return;
    labels->time_step = step;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].code == code)
            snprintf(labels->time_unit, sizeof labels->time_unit, "%s", names[i].name);
}

static int find_nifti(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                      const cvol_read_options *options)
{
    nifti n = {.context = context,
               .path = path,
               .volumes = 1,
               .channels = 1,
               .grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    int code = read_header(&n);
    if (!code)
        code = read_dims(&n);
    if (!code)
        code = read_type(&n);
    if (!code)
        code = read_vox_offset(&n);
    if (!code)
        code = read_affine(&n);
    if (code)
        return code;
    read_values(&n);
    read_labels(&n, &stored->labels);
    if (n.is_pair)
        code = find_pair(&n, &stored->data_path, &n.is_gzip);
    stored->encoding = n.is_gzip ? CVOL_ENCODING_GZIP : CVOL_ENCODING_RAW;
    stored->big_endian = n.header.big_endian;
    stored->wide = n.wide;
    *grid = n.grid;
    return code ? code : choose_volume(&n, stored, options);
}

/* ---- writing ------------------------------------------------------------------------- */

/* The affine in RAS. */
static cvol_nifti_affine affine_of(const cvol_grid *grid)
{
    cvol_grid ras = cvol_geometry_in_space(grid, CVOL_SPACE_RAS);
    cvol_nifti_affine affine;
    for (int i = 0; i < 3; i++) {
        for (int a = 0; a < 3; a++)
            affine.step[i][a] = ras.direction[a][i] * ras.spacing[a];
        affine.origin[i] = ras.origin[i];
    }
    return affine;
}

/* 1 if the directions are a rotation, mirrored or not: a qform can hold nothing else. */
static int is_rotation(const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++)
        for (int b = 0; b <= a; b++) {
            double product = 0;
            for (int i = 0; i < 3; i++)
                product += grid->direction[a][i] * grid->direction[b][i];
            if (!(fabs(product - (a == b)) < 1e-6))
                return 0;
        }
    return 1;
}

/* NIfTI-1 has 16 bits for sizes and 32 for reals. */
static const cvol_nifti_layout *layout_for(const cvol_grid *grid)
{
    double largest = fmax(fabs(grid->value_scale), fabs(grid->value_offset));
    for (int a = 0; a < 3; a++) {
        if (grid->dims[a] > INT16_MAX || grid->spacing[a] < FLT_MIN)
            return &cvol_nifti_layouts[1];
        largest = fmax(largest, fmax(grid->spacing[a], fabs(grid->origin[a])));
    }
    return largest > FLT_MAX / 4 ? &cvol_nifti_layouts[1] : &cvol_nifti_layouts[0];
}

static void put_affine(uint8_t *header, const cvol_nifti_layout *l, const cvol_grid *grid)
{
    const cvol_nifti_affine affine = affine_of(grid);
    for (size_t i = 0; i < 3; i++) {
        for (size_t a = 0; a < 3; a++)
            cvol_nifti_put_real(header, l, l->srow, 4 * i + a, affine.step[i][a]);
        cvol_nifti_put_real(header, l, l->srow, 4 * i + 3, affine.origin[i]);
    }
    cvol_nifti_put_integer(header, l->sform_code, l->code_width, CVOL_NIFTI_SCANNER_ANAT);
    double handedness = 1;
    if (is_rotation(grid)) {
        const cvol_nifti_rotation rotation = cvol_nifti_rotation_of(&affine);
        for (size_t i = 0; i < 3; i++) {
            cvol_nifti_put_real(header, l, l->quatern, i, rotation.quaternion[i]);
            cvol_nifti_put_real(header, l, l->qoffset, i, affine.origin[i]);
        }
        cvol_nifti_put_integer(header, l->qform_code, l->code_width, CVOL_NIFTI_SCANNER_ANAT);
        handedness = rotation.handedness;
    }
    cvol_nifti_put_real(header, l, l->pixdim, 0, handedness);
    for (size_t a = 0; a < 3; a++)
        cvol_nifti_put_real(header, l, l->pixdim, a + 1, grid->spacing[a]);
}

/* Puts the header and four zeros (no extension follows); returns their size. */
static size_t make_header(uint8_t *header, const cvol_grid *grid)
{
    const cvol_nifti_layout *l = layout_for(grid);
    cvol_nifti_put_integer(header, 0, 4, (int64_t)l->size);
    memcpy(header + l->magic_at, l->magic, 3);
    if (l->version == 2)
        memcpy(header + l->magic_at + 4, "\r\n\032\n", 4);
    cvol_nifti_put_integer(header, l->dim, l->dim_width, 3);
    for (size_t i = 1; i < 8; i++)
        cvol_nifti_put_integer(header, l->dim + i * l->dim_width, l->dim_width,
                               i <= 3 ? (int64_t)grid->dims[i - 1] : 1);
    for (size_t i = 0; i < DATATYPES; i++)
        if (datatypes[i].type == grid->type)
            cvol_nifti_put_integer(header, l->datatype, 2, datatypes[i].code);
    cvol_nifti_put_integer(header, l->bitpix, 2, (int64_t)(8 * cvol_type_size(grid->type)));
    put_affine(header, l, grid);
    size_t offset = l->size + 4;
    if (l->version == 1)
        cvol_nifti_put_real(header, l, l->vox_offset, 0, (double)offset);
    else
        cvol_nifti_put_integer(header, l->vox_offset, 8, (int64_t)offset);
    cvol_nifti_put_real(header, l, l->scl_slope, 0, grid->value_scale);
    cvol_nifti_put_real(header, l, l->scl_inter, 0, grid->value_offset);
    for (size_t i = 0; i < UNITS; i++)
        if (!strcmp(units[i].name, grid->unit))
            cvol_nifti_put_integer(header, l->xyzt_units, l->units_width, units[i].code);
    return offset;
}

static int plan_nifti(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                      const char *path)
{
    (void)context;
    const char *kept[UNITS];
    for (size_t i = 0; i < UNITS; i++)
        kept[i] = units[i].name;
    const cvol_grid known = cvol_geometry_in_unit(grid, kept, UNITS);
    uint8_t header[CVOL_NIFTI_LONGEST_HEADER + 4] = {0};
    cvol_bytes_append(&plan->header, header, make_header(header, &known));
    plan->packs_header = cvol_text_ends(path, ".gz");
    plan->encoding = plan->packs_header ? CVOL_ENCODING_GZIP : CVOL_ENCODING_RAW;
    return CVOL_OK;
}

const cvol_format cvol_format_nifti = {
    .name = "NIfTI",
    .endings = {".nii", ".nii.gz"},
    .recognise = recognise,
    .find = find_nifti,
    .plan = plan_nifti,
    .takes = CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
};
