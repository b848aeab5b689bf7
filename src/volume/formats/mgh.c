/* MGH and MGZ, the volumes of FreeSurfer (surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/MghFormat):
 * a header of 284 bytes, high byte first, then the samples, frame after frame, then remarks; MGZ
 * is the same, packed by gzip.
 *
 * Directions are those of x, y and z in RAS, in millimetres; the header has the place of the
 * centre, sample (nx/2, ny/2, nz/2). Without directions slices are coronal: x to the left, y to
 * the feet, z to the nose. Frames are times. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/grid.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/packed.h"
#include "volume/io/text.h"
#include "volume/io/unit.h"

#define HEADER_BYTES 284
#define VERSION 1

/* Bytes of the header. */
enum { SIZES = 4, FRAMES = 16, TYPE = 20, IS_RAS = 28, SPACING = 30, DIRECTIONS = 42, CENTRE = 78 };

typedef struct mgh {
    cvol_context *context;
    const char *path;
    uint8_t header[HEADER_BYTES];
    uint64_t file_size;
    int is_gzip;
} mgh;

static int32_t get_integer(const uint8_t *header, int at)
{
    const uint32_t v = cvol_high_first(header + at);
    int32_t out;
    memcpy(&out, &v, 4);
    return out;
}

static double get_real(const uint8_t *header, int at)
{
    const int32_t v = get_integer(header, at);
    float out;
    memcpy(&out, &v, 4);
    return (double)out;
}

static const struct {
    int code;
    cvol_type type;
} types[] = {
    {0, CVOL_UINT8}, {1, CVOL_INT32}, {3, CVOL_FLOAT32}, {4, CVOL_INT16}, {10, CVOL_UINT16}};

static int find_type(cvol_type *out, int code)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].code == code) {
            *out = types[i].type;
            return 1;
        }
    return 0;
}

/* There is no signature: the version, four positive sizes, a known type, and a flag of 0 or 1. */
static int recognise(const uint8_t *head, size_t size)
{
    uint8_t header[IS_RAS + 2];
    cvol_type type;
    if (cvol_packed_is(head, size)) {
        if (cvol_inflate_head(header, sizeof header, head, size) < sizeof header)
            return 0;
    } else if (size >= sizeof header) {
        memcpy(header, head, sizeof header);
    } else {
        return 0;
    }
    for (int i = 0; i < 4; i++)
        if (get_integer(header, SIZES + 4 * i) < 1)
            return 0;
    return get_integer(header, 0) == VERSION && find_type(&type, get_integer(header, TYPE)) &&
           header[IS_RAS] == 0 && header[IS_RAS + 1] <= 1;
}

/* ---- header -------------------------------------------------------------------------- */

static int read_header(mgh *m)
{
    cvol_packed file;
    uint64_t size = 0;
    int code = cvol_packed_open(m->context, &file, m->path);
    if (!code)
        code = cvol_packed_read(m->context, &file, m->header, HEADER_BYTES, &size);
    m->file_size = file.input.size;
    m->is_gzip = file.inflater != NULL;
    cvol_packed_close(&file);
    if (!code && size < HEADER_BYTES)
        code = cvol_fail(m->context, CVOL_ERROR_FORMAT,
                         "%s: holds %llu of the %d bytes of a header", m->path,
                         (unsigned long long)size, HEADER_BYTES);
    if (!code && get_integer(m->header, 0) != VERSION)
        code = cvol_fail(m->context, CVOL_ERROR_FORMAT,
                         "%s: is not an MGH file: its version is %d, must be %d", m->path,
                         get_integer(m->header, 0), VERSION);
    return code;
}

static int read_shape(const mgh *m, cvol_grid *grid, size_t *frames)
{
    static const char *const names[] = {"width", "height", "depth", "nframes"};
    size_t sizes[4];
    cvol_type type;
    for (int i = 0; i < 4; i++) {
        const int32_t size = get_integer(m->header, SIZES + 4 * i);
        if (size < 1)
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: %s is %d, must be positive",
                             m->path, names[i], size);
        sizes[i] = (size_t)size;
    }
    if (!find_type(&type, get_integer(m->header, TYPE)))
        return cvol_fail(m->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: type is %d; 0, 1, 3, 4 and 10 are supported", m->path,
                         get_integer(m->header, TYPE));
    *grid = cvol_grid_make(sizes[0], sizes[1], sizes[2], type);
    *frames = sizes[3];
    return CVOL_OK;
}

static int read_geometry(const mgh *m, cvol_grid *grid)
{
    static const double coronal[3][3] = {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
    const int is_given = m->header[IS_RAS + 1] == 1;
    double centre[3];
    grid->space = CVOL_SPACE_RAS;
    snprintf(grid->unit, sizeof grid->unit, "mm");
    for (int a = 0; a < 3; a++) {
        const double spacing = is_given ? get_real(m->header, SPACING + 4 * a) : 1;
        if (!isfinite(spacing) || spacing <= 0)
            return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                             "%s: %csize is %g, must be positive and finite", m->path, "xyz"[a],
                             spacing);
        double direction[3];
        for (int w = 0; w < 3; w++)
            direction[w] = is_given ? get_real(m->header, DIRECTIONS + 12 * a + 4 * w)
                                    : coronal[a][w];
        grid->spacing[a] = spacing;
        if (!cvol_geometry_set_direction(grid, a, direction))
            return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                             "%s: the direction of %c is (%g, %g, %g)", m->path, "xyz"[a],
                             direction[0], direction[1], direction[2]);
    }
    for (int w = 0; w < 3; w++) {
        centre[w] = is_given ? get_real(m->header, CENTRE + 4 * w) : 0;
        if (!isfinite(centre[w]))
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: c_%c is %g", m->path, "ras"[w],
                             centre[w]);
        grid->origin[w] = centre[w];
        for (int a = 0; a < 3; a++)
            grid->origin[w] -= grid->direction[a][w] * grid->spacing[a] * (double)grid->dims[a] / 2;
    }
    return cvol_geometry_check(m->context, grid, m->path);
}

/* ---- reading ------------------------------------------------------------------------- */

static int find_frame(const mgh *m, const cvol_grid *grid, cvol_stored *stored, size_t frames,
                      const cvol_read_options *options)
{
    size_t frame;
    uint64_t begin = HEADER_BYTES;
    int code = cvol_format_choose(m->context, &frame, m->path, "volume", "--time", frames,
                                  options->has_index, options->index);
    if (!code)
        code = cvol_grid_check_within(m->context, grid, m->path, UINT64_MAX);
    if (code)
        return code;
    const uint64_t bytes = cvol_grid_bytes(grid);
    if (__builtin_mul_overflow((uint64_t)frame, bytes, &begin) ||
        __builtin_add_overflow(begin, HEADER_BYTES, &begin))
        begin = UINT64_MAX;
    if (!m->is_gzip && (begin > m->file_size || m->file_size - begin < bytes))
        return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                         "%s: has %llu bytes, but volume %zu of %zu x %zu x %zu samples of %zu "
                         "bytes is announced",
                         m->path, (unsigned long long)m->file_size, frame, grid->dims[0],
                         grid->dims[1], grid->dims[2], cvol_type_size(grid->type));
    stored->encoding = m->is_gzip ? CVOL_ENCODING_GZIP : CVOL_ENCODING_RAW;
    stored->big_endian = 1;
    stored->byte_skip = begin;
    stored->may_go_on = stored->has_remarks = 1;
    stored->has_more_volumes = frame + 1 < frames;
    return CVOL_OK;
}

static int find_mgh(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    mgh m = {.context = context, .path = path};
    size_t frames = 1;
    int code = read_header(&m);
    if (!code)
        code = read_shape(&m, grid, &frames);
    if (!code)
        code = read_geometry(&m, grid);
    return code ? code : find_frame(&m, grid, stored, frames, options);
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_integer(uint8_t *header, int at, int32_t value)
{
    for (int i = 0; i < 4; i++)
        header[at + i] = (uint8_t)((uint32_t)value >> (24 - 8 * i));
}

static void put_real(uint8_t *header, int at, double value)
{
    const float v = (float)value;
    int32_t bits;
    memcpy(&bits, &v, 4);
    put_integer(header, at, bits);
}

static int find_code(cvol_context *context, int *out, cvol_type type, const char *path)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].type == type) {
            *out = types[i].code;
            return CVOL_OK;
        }
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: MGH has no samples of type %s: write NRRD, NIfTI or NumPy", path,
                     cvol_type_name(type));
}

static int plan_mgh(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                    const char *path)
{
    uint8_t header[HEADER_BYTES] = {0};
    const cvol_grid ras = cvol_geometry_in_space(grid, CVOL_SPACE_RAS);
    const double metres = cvol_unit_metres(grid->unit), scale = metres > 0 ? metres / 1e-3 : 1;
    int type = 0;
    const int code = find_code(context, &type, grid->type, path);
    if (code)
        return code;
    for (int a = 0; a < 3; a++) {
        double centre = ras.origin[a];
        if (grid->dims[a] > INT32_MAX)
            return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: MGH has no room for %zu samples", path,
                             grid->dims[a]);
        put_integer(header, SIZES + 4 * a, (int32_t)grid->dims[a]);
        put_real(header, SPACING + 4 * a, scale * ras.spacing[a]);
        for (int w = 0; w < 3; w++) {
            put_real(header, DIRECTIONS + 12 * a + 4 * w, ras.direction[a][w]);
            centre += ras.direction[w][a] * ras.spacing[w] * (double)ras.dims[w] / 2;
        }
        put_real(header, CENTRE + 4 * a, scale * centre);
    }
    put_integer(header, 0, VERSION);
    put_integer(header, FRAMES, 1);
    put_integer(header, TYPE, type);
    header[IS_RAS + 1] = 1;
    cvol_bytes_append(&plan->header, header, sizeof header);
    plan->big_endian = 1;
    plan->packs_header = !cvol_text_ends(path, ".mgh");
    plan->encoding = plan->packs_header ? CVOL_ENCODING_GZIP : CVOL_ENCODING_RAW;
    return CVOL_OK;
}

const cvol_format cvol_format_mgh = {
    .name = "MGH",
    .endings = {".mgz", ".mgh", ".mgh.gz"},
    .recognise = recognise,
    .find = find_mgh,
    .plan = plan_mgh,
    .takes = CVOL_TAKES_INDEX,
};
