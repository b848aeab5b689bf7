/* MRC, and CCP4 maps (MRC2014: Cheng et al., J. Struct. Biol. 192, 2015;
 * www.ccpem.ac.uk/mrc_format): a header of 1024 bytes in either byte order, an extended one, and
 * the samples, columns first.
 *
 * Read: modes 0, 1, 2, 6 and 12 (half floats, which become floats). Axes are brought into the order
 * x, y, z by MAPC, MAPR and MAPS. Spacing is the cell's size divided by its intervals, in angstrom;
 * the origin is ORIGIN, or else the start of columns, rows and sections.
 *
 * Written: modes 0, 1, 2 and 6, low byte first, without statistics. Unsigned bytes become mode 6:
 * programs do not agree on the sign of mode 0. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/strided.h"
#include "volume/io/unit.h"

#define HEADER_BYTES 1024

/* Words of the header, counted from 0. */
enum {
    SIZES = 0,
    MODE = 3,
    STARTS = 4,
    INTERVALS = 7,
    CELL = 10,
    ANGLES = 13,
    AXES = 16,
    LEAST = 19, /* DMIN, DMAX, DMEAN */
    SPACE_GROUP = 22,
    EXTENDED = 23,
    VERSION = 27,
    IMOD_STAMP = 38,
    IMOD_FLAGS = 39,
    ORIGIN = 49,
    DEVIATION = 54,
    LABEL_COUNT = 55,
    /* bytes */
    MAP_AT = 208,
    STAMP_AT = 212,
    LABELS_AT = 224
};
#define IMOD_STAMPED 1146047817

typedef struct mrc {
    cvol_context *context;
    const char *path;
    uint8_t header[HEADER_BYTES];
    uint64_t file_size;
    int big_endian, is_half;
    size_t sizes[3]; /* of columns, rows, sections */
    int axes[3];     /* x, y or z: 0, 1, 2 */
    cvol_type type;
} mrc;

static int32_t get_integer(const mrc *m, int word)
{
    const uint8_t *p = m->header + 4 * word;
    uint32_t v = m->big_endian
                     ? (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]
                     : (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
    int32_t out;
    memcpy(&out, &v, 4);
    return out;
}

static double get_real(const mrc *m, int word)
{
    int32_t v = get_integer(m, word);
    float out;
    memcpy(&out, &v, 4);
    return (double)out;
}

static int recognise(const uint8_t *head, size_t size)
{
    return size >= HEADER_BYTES && !memcmp(head + MAP_AT, "MAP", 3) &&
           (head[STAMP_AT] == 0x44 || head[STAMP_AT] == 0x11);
}

/* ---- header -------------------------------------------------------------------------- */

static int read_header(mrc *m)
{
    cvol_input input;
    size_t got = 0;
    int code = cvol_input_open(m->context, &input, m->path);
    if (!code)
        code = cvol_input_read(m->context, &input, 0, m->header, HEADER_BYTES, &got);
    m->file_size = input.size;
    cvol_input_close(&input);
    if (!code && got < HEADER_BYTES)
        code = cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: holds %zu of the %d bytes of a header",
                         m->path, got, HEADER_BYTES);
    /* Old files have no stamp: then the byte order in which MODE is small. */
    if (m->header[STAMP_AT] == 0x11)
        m->big_endian = 1;
    else if (m->header[STAMP_AT] != 0x44)
        m->big_endian = m->header[4 * MODE] == 0 && m->header[4 * MODE + 3] != 0;
    return code;
}

static int read_type(mrc *m)
{
    const int mode = get_integer(m, MODE);
    const int bytes_are_unsigned = get_integer(m, IMOD_STAMP) == IMOD_STAMPED &&
                                   !(get_integer(m, IMOD_FLAGS) & 1);
    m->is_half = mode == 12;
    switch (mode) {
    case 0:
        m->type = bytes_are_unsigned ? CVOL_UINT8 : CVOL_INT8;
        return CVOL_OK;
    case 1:
        m->type = CVOL_INT16;
        return CVOL_OK;
    case 6:
        m->type = CVOL_UINT16;
        return CVOL_OK;
    case 2:
    case 12:
        m->type = CVOL_FLOAT32;
        return CVOL_OK;
    default:
        return cvol_fail(m->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: MODE is %d; 0, 1, 2, 6 and 12 are supported", m->path, mode);
    }
}

static int read_shape(mrc *m)
{
    int sum = 0;
    for (int i = 0; i < 3; i++) {
        const int32_t size = get_integer(m, SIZES + i), axis = get_integer(m, AXES + i);
        if (size < 1)
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: %s is %d, must be positive",
                             m->path,
                             i == 0   ? "NC"
                             : i == 1 ? "NR"
                                      : "NS",
                             size);
        m->sizes[i] = (size_t)size;
        m->axes[i] = axis >= 1 && axis <= 3 ? axis - 1 : i; /* 0: unknown in old files */
        sum |= axis == 0 ? 1 << i : axis >= 1 && axis <= 3 ? 1 << (axis - 1) : 8;
    }
    if (sum == 7)
        return CVOL_OK;
    return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                     "%s: MAPC, MAPR, MAPS are %d, %d, %d, which is not an order of 1, 2, 3",
                     m->path, get_integer(m, AXES), get_integer(m, AXES + 1),
                     get_integer(m, AXES + 2));
}

/* ---- geometry ------------------------------------------------------------------------ */

/* The cell's edges: a along x, b in the plane of x and y. Missing angles are right angles. */
static void edges_of(const mrc *m, double out[3][3])
{
    double c[3];
    for (int i = 0; i < 3; i++) {
        double angle = get_real(m, ANGLES + i);
        const int odd = angle > 0 && angle < 180 && fabs(angle - 90) > 1e-4;
        c[i] = odd ? cvol_cos(angle * 3.14159265358979323846 / 180) : 0;
    }
    const double s = sqrt(1 - c[2] * c[2]), u = (c[0] - c[1] * c[2]) / s;
    const double rest = 1 - c[1] * c[1] - u * u;
    const double edges[3][3] = {{1, 0, 0}, {c[2], s, 0}, {c[1], u, rest > 0 ? sqrt(rest) : 0}};
    memcpy(out, edges, sizeof edges);
}

static int read_geometry(const mrc *m, cvol_grid *grid)
{
    double edges[3][3], origin[3];
    edges_of(m, edges);
    int placed = 0;
    for (int a = 0; a < 3; a++) {
        const double cell = get_real(m, CELL + a);
        const int32_t intervals = get_integer(m, INTERVALS + a);
        if (!isfinite(cell) || cell < 0)
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: CELLA %c is %g", m->path, "XYZ"[a],
                             cell);
        if (cell > 0 && intervals > 0) {
            grid->spacing[a] = cell / intervals;
            snprintf(grid->unit, sizeof grid->unit, "A");
        }
        cvol_geometry_set_direction(grid, a, edges[a]);
        origin[a] = get_real(m, ORIGIN + a);
        if (!isfinite(origin[a]))
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: ORIGIN %c is %g", m->path,
                             "XYZ"[a], origin[a]);
        placed = placed || origin[a] != 0;
    }
    for (int i = 0; i < 3 && !placed; i++) {
        const int a = m->axes[i];
        for (int w = 0; w < 3; w++)
            origin[w] += get_integer(m, STARTS + i) * grid->spacing[a] * grid->direction[a][w];
    }
    for (int w = 0; w < 3; w++)
        grid->origin[w] = origin[w] + 0.0;
    return cvol_geometry_check(m->context, grid, m->path);
}

/* ---- reading ------------------------------------------------------------------------- */

static int find_samples(const mrc *m, cvol_grid *grid, cvol_stored *stored)
{
    const int32_t extended = get_integer(m, EXTENDED);
    const uint64_t begin = HEADER_BYTES + (uint64_t)(extended > 0 ? extended : 0);
    const size_t samples = cvol_grid_samples(grid), each = m->is_half ? 2 : cvol_type_size(m->type);
    if (extended < 0 || m->file_size < begin || (m->file_size - begin) / each < samples)
        return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                         "%s: has %llu bytes, but %d of an extended header and %zu x %zu x %zu "
                         "samples of %zu bytes are announced",
                         m->path, (unsigned long long)m->file_size, extended, m->sizes[0],
                         m->sizes[1], m->sizes[2], each);
    if (!m->is_half && m->axes[0] == 0 && m->axes[1] == 1) {
        stored->offset = begin;
        stored->big_endian = m->big_endian;
        stored->may_go_on = 1;
        return CVOL_OK;
    }
    cvol_strided strided = {.big_endian = m->big_endian, .is_half = m->is_half};
    strided.stride[m->axes[0]] = 1;
    strided.stride[m->axes[1]] = m->sizes[0];
    strided.stride[m->axes[2]] = m->sizes[0] * m->sizes[1];
    return cvol_strided_read(m->context, stored, &strided, grid, m->path, begin, samples);
}

static int find_mrc(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    (void)options;
    mrc m = {.context = context, .path = path};
    int code = read_header(&m);
    if (!code)
        code = read_type(&m);
    if (!code)
        code = read_shape(&m);
    if (code)
        return code;
    *grid = cvol_grid_make(1, 1, 1, m.type);
    for (int i = 0; i < 3; i++)
        grid->dims[m.axes[i]] = m.sizes[i];
    code = read_geometry(&m, grid);
    if (!code)
        code = cvol_grid_check_within(context, grid, path, UINT64_MAX);
    return code ? code : find_samples(&m, grid, stored);
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_integer(uint8_t *header, int word, int32_t value)
{
    for (int i = 0; i < 4; i++)
        header[4 * word + i] = (uint8_t)((uint32_t)value >> 8 * i);
}

static void put_real(uint8_t *header, int word, double value)
{
    const float v = (float)value;
    int32_t bits;
    memcpy(&bits, &v, 4);
    put_integer(header, word, bits);
}

/* MODE; -1: none. */
static int mode_of(cvol_type type)
{
    switch (type) {
    case CVOL_INT8:
        return 0;
    case CVOL_INT16:
        return 1;
    case CVOL_FLOAT32:
        return 2;
    case CVOL_UINT8:
    case CVOL_UINT16:
        return 6;
    default:
        return -1;
    }
}

static int plan_mrc(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                    const char *path)
{
    static const char label[] = "cvol";
    uint8_t header[HEADER_BYTES] = {0};
    const int mode = mode_of(grid->type);
    const double metres = cvol_unit_metres(grid->unit), scale = metres > 0 ? metres / 1e-10 : 1;
    if (mode < 0)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: MRC has no samples of type %s: write NRRD, NIfTI or NumPy", path,
                         cvol_type_name(grid->type));
    for (int a = 0; a < 3; a++) {
        if (grid->dims[a] > INT32_MAX)
            return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: MRC has no room for %zu samples", path,
                             grid->dims[a]);
        put_integer(header, SIZES + a, (int32_t)grid->dims[a]);
        put_integer(header, INTERVALS + a, (int32_t)grid->dims[a]);
        put_real(header, CELL + a, scale * grid->spacing[a] * (double)grid->dims[a]);
        put_real(header, ANGLES + a, 90);
        put_integer(header, AXES + a, a + 1);
        put_real(header, LEAST + a, -a); /* the largest below the least: unknown */
        put_real(header, ORIGIN + a, scale * grid->origin[a]);
    }
    put_integer(header, MODE, mode);
    put_integer(header, SPACE_GROUP, 1);
    put_integer(header, VERSION, 20140);
    put_real(header, DEVIATION, -1);
    put_integer(header, LABEL_COUNT, 1);
    memcpy(header + MAP_AT, "MAP ", 4);
    header[STAMP_AT] = header[STAMP_AT + 1] = 0x44;
    memset(header + LABELS_AT, ' ', HEADER_BYTES - LABELS_AT);
    memcpy(header + LABELS_AT, label, sizeof label - 1);
    cvol_bytes_append(&plan->header, header, sizeof header);
    plan->encoding = CVOL_ENCODING_RAW;
    plan->widens = grid->type == CVOL_UINT8;
    return CVOL_OK;
}

const cvol_format cvol_format_mrc = {
    .name = "MRC",
    .endings = {".mrc", ".map", ".ccp4", ".rec"},
    .recognise = recognise,
    .find = find_mrc,
    .plan = plan_mrc,
    .takes = CVOL_TAKES_SPACING,
};
