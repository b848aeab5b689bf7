/* MetaImage (.mha, .mhd; itk.org/Wiki/ITK/MetaIO/Documentation): a text header of "Key = Value"
 * lines whose last, ElementDataFile, locates the samples: LOCAL, right behind it, or the name of a
 * separate file. Row i of TransformMatrix is the direction of axis i; the world is LPS.
 *
 * Read: raw, zlib and text samples, one data file, three axes or two, one channel. Written: zlib
 * attached (.mha) or raw detached (.mhd). */
#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/text_header.h"

/* The keys that the reader uses. */
enum key {
    OBJECT_TYPE,
    N_DIMS,
    DIM_SIZE,
    ELEMENT_TYPE,
    ELEMENT_SPACING,
    ELEMENT_SIZE,
    CHANNELS,
    OFFSET,
    ORIGIN,
    POSITION,
    TRANSFORM_MATRIX,
    ROTATION,
    ORIENTATION,
    ANATOMICAL_ORIENTATION,
    DISTANCE_UNITS,
    VALUE_SLOPE,
    VALUE_OFFSET,
    BINARY_DATA,
    BINARY_MSB,
    ELEMENT_MSB,
    COMPRESSED,
    COMPRESSED_SIZE,
    HEADER_SIZE,
    DATA_FILE,
    KEYS
};

static const cvol_keyword keys[] = {
    [OBJECT_TYPE] = {"ObjectType", OBJECT_TYPE},
    [N_DIMS] = {"NDims", N_DIMS},
    [DIM_SIZE] = {"DimSize", DIM_SIZE},
    [ELEMENT_TYPE] = {"ElementType", ELEMENT_TYPE},
    [ELEMENT_SPACING] = {"ElementSpacing", ELEMENT_SPACING},
    [ELEMENT_SIZE] = {"ElementSize", ELEMENT_SIZE},
    [CHANNELS] = {"ElementNumberOfChannels", CHANNELS},
    [OFFSET] = {"Offset", OFFSET},
    [ORIGIN] = {"Origin", ORIGIN},
    [POSITION] = {"Position", POSITION},
    [TRANSFORM_MATRIX] = {"TransformMatrix", TRANSFORM_MATRIX},
    [ROTATION] = {"Rotation", ROTATION},
    [ORIENTATION] = {"Orientation", ORIENTATION},
    [ANATOMICAL_ORIENTATION] = {"AnatomicalOrientation", ANATOMICAL_ORIENTATION},
    [DISTANCE_UNITS] = {"DistanceUnits", DISTANCE_UNITS},
    [VALUE_SLOPE] = {"ElementToIntensityFunctionSlope", VALUE_SLOPE},
    [VALUE_OFFSET] = {"ElementToIntensityFunctionOffset", VALUE_OFFSET},
    [BINARY_DATA] = {"BinaryData", BINARY_DATA},
    [BINARY_MSB] = {"BinaryDataByteOrderMSB", BINARY_MSB},
    [ELEMENT_MSB] = {"ElementByteOrderMSB", ELEMENT_MSB},
    [COMPRESSED] = {"CompressedData", COMPRESSED},
    [COMPRESSED_SIZE] = {"CompressedDataSize", COMPRESSED_SIZE},
    [HEADER_SIZE] = {"HeaderSize", HEADER_SIZE},
    [DATA_FILE] = {"ElementDataFile", DATA_FILE},
};

_Static_assert(KEYS <= CVOL_TEXT_FIELDS_MAX, "a header has room for all keys");

static const cvol_text_layout layout = {"Key = Value", '=', keys, CVOL_COUNT(keys)};

static const cvol_keyword types[] = {
    {"MET_UCHAR", CVOL_UINT8},  {"MET_CHAR", CVOL_INT8},     {"MET_USHORT", CVOL_UINT16},
    {"MET_SHORT", CVOL_INT16},  {"MET_UINT", CVOL_UINT32},   {"MET_INT", CVOL_INT32},
    {"MET_ULONG", CVOL_UINT32}, /* four bytes in this format, unlike C's long */
    {"MET_LONG", CVOL_INT32},   {"MET_FLOAT", CVOL_FLOAT32}, {"MET_DOUBLE", CVOL_FLOAT64},
};

static const cvol_keyword wide_types[] = {{"MET_LONG_LONG", CVOL_WIDE_INT64},
                                          {"MET_ULONG_LONG", CVOL_WIDE_UINT64}};

static const cvol_keyword flags[] = {{"True", 1}, {"1", 1}, {"False", 0}, {"0", 0}};

typedef struct meta {
    cvol_text_header header;
    size_t dimensions;
    cvol_grid grid;
    int wide; /* cvol_wide */
} meta;

/* ---- header -------------------------------------------------------------------------- */

static int recognise(const uint8_t *head, size_t size)
{
    const char *text = (const char *)head;
    size_t at = 0;
    while (at < size && (text[at] == ' ' || (text[at] >= '\t' && text[at] <= '\r')))
        at++;
    size_t key = 0;
    if (size - at > 10 && !memcmp(text + at, "ObjectType", 10))
        key = 10;
    else if (size - at > 5 && !memcmp(text + at, "NDims", 5))
        key = 5;
    at += key;
    while (at < size && (text[at] == ' ' || text[at] == '\t'))
        at++;
    return key && at < size && text[at] == '=';
}

static int read_header(meta *m)
{
    cvol_text_header *header = &m->header;
    char *line = "";
    int code = CVOL_OK;
    while (!code && line && !header->value[DATA_FILE]) {
        code = cvol_header_next(header->context, &header->lines, &line);
        if (!code && line && *cvol_text_trim(line))
            code = cvol_text_header_put(header, line);
    }
    static const int needed[] = {N_DIMS, DIM_SIZE, ELEMENT_TYPE, DATA_FILE};
    if (!code)
        code = cvol_text_header_need(header, needed, CVOL_COUNT(needed));
    const char *object = header->value[OBJECT_TYPE];
    if (!code && object && !cvol_text_equal(object, "Image"))
        code = cvol_text_header_unsupported(header, OBJECT_TYPE, "is not Image");
    return code;
}

static int read_flag(const meta *m, enum key key, int *flag)
{
    const char *value = m->header.value[key];
    if (!value || cvol_keyword_find(flags, CVOL_COUNT(flags), value, flag))
        return CVOL_OK;
    return cvol_text_header_fail(&m->header, (int)key, "is neither True nor False");
}

/* The first of three equivalent keys; KEYS if the header has none of them. */
static enum key first_of(const meta *m, enum key a, enum key b, enum key c)
{
    return m->header.value[a] ? a : m->header.value[b] ? b : m->header.value[c] ? c : KEYS;
}

/* ---- grid ---------------------------------------------------------------------------- */

static int read_shape(meta *m)
{
    int64_t dimensions = 0, channels = 1;
    int code = cvol_text_header_integer(&m->header, N_DIMS, 1, 16, &dimensions);
    if (!code && (dimensions < 2 || dimensions > 3))
        code = cvol_text_header_unsupported(&m->header, N_DIMS,
                                            "is not supported: volumes have three axes");
    m->dimensions = (size_t)dimensions;
    if (!code)
        code = cvol_text_header_sizes(&m->header, DIM_SIZE, m->grid.dims, m->dimensions, "NDims");
    if (!code)
        code = cvol_text_header_integer(&m->header, CHANNELS, 1, 1 << 20, &channels);
    if (!code && channels != 1)
        code = cvol_text_header_unsupported(
            &m->header, CHANNELS, "is not supported: write each channel into a file of its own");
    return code;
}

static int read_type(meta *m)
{
    const char *name = m->header.value[ELEMENT_TYPE];
    int type;
    if (cvol_keyword_find(types, CVOL_COUNT(types), name, &type)) {
        m->grid.type = (cvol_type)type;
        return CVOL_OK;
    }
    if (cvol_keyword_find(wide_types, CVOL_COUNT(wide_types), name, &m->wide)) {
        m->grid.type = CVOL_WIDE_TYPE;
        return CVOL_OK;
    }
    if (!strncmp(name, "MET_", 4))
        return cvol_text_header_unsupported(&m->header, ELEMENT_TYPE, "is not supported");
    return cvol_text_header_fail(&m->header, ELEMENT_TYPE, "is unknown");
}

static int read_vector(const meta *m, enum key key, double *out)
{
    return key == KEYS
               ? CVOL_OK
               : cvol_text_header_numbers(&m->header, (int)key, out, m->dimensions, "NDims");
}

static int read_directions(meta *m)
{
    enum key key = first_of(m, TRANSFORM_MATRIX, ROTATION, ORIENTATION);
    const char *anatomy = m->header.value[ANATOMICAL_ORIENTATION];
    if (key != KEYS || (anatomy && *anatomy != '?'))
        m->grid.space = CVOL_SPACE_LPS;
    if (key == KEYS)
        return CVOL_OK;
    double matrix[9];
    size_t n = m->dimensions;
    int code = cvol_text_header_numbers(&m->header, (int)key, matrix, n * n, "NDims squared");
    for (size_t a = 0; !code && a < n; a++) {
        double row[3] = {0, 0, 0};
        memcpy(row, matrix + n * a, n * sizeof *row);
        if (!cvol_geometry_set_direction(&m->grid, (int)a, row))
            code = cvol_text_header_fail(&m->header, (int)key, "has a row without a length");
    }
    return code ? code : cvol_geometry_check(m->header.context, &m->grid, m->header.path);
}

static int read_value_scale(meta *m)
{
    static const char one[] = "the needed number";
    double slope = 1, offset = 0;
    int code = cvol_text_header_numbers(&m->header, VALUE_SLOPE, &slope, 1, one);
    if (!code)
        code = cvol_text_header_numbers(&m->header, VALUE_OFFSET, &offset, 1, one);
    if (!code && slope != 0) { /* else samples need no scaling */
        m->grid.value_scale = slope;
        m->grid.value_offset = offset;
    }
    return code;
}

static int read_grid(meta *m)
{
    int code = read_shape(m);
    if (!code)
        code = read_type(m);
    if (!code)
        code = read_vector(m, m->header.value[ELEMENT_SPACING] ? ELEMENT_SPACING : ELEMENT_SIZE,
                           m->grid.spacing);
    if (!code)
        code = read_vector(m, first_of(m, OFFSET, ORIGIN, POSITION), m->grid.origin);
    if (!code)
        code = read_directions(m);
    if (!code)
        code = read_value_scale(m);
    const char *unit = m->header.value[DISTANCE_UNITS];
    if (unit && *unit != '?')
        snprintf(m->grid.unit, sizeof m->grid.unit, "%s", unit);
    return code;
}

/* ---- data ---------------------------------------------------------------------------- */

static int read_encoding(const meta *m, cvol_stored *stored)
{
    int binary = 1, compressed = 0;
    int code = read_flag(m, BINARY_DATA, &binary);
    if (!code)
        code = read_flag(m, COMPRESSED, &compressed);
    if (!code)
        code = read_flag(m, m->header.value[BINARY_MSB] ? BINARY_MSB : ELEMENT_MSB,
                         &stored->big_endian);
    stored->encoding = compressed ? CVOL_ENCODING_ZLIB
                       : binary   ? CVOL_ENCODING_RAW
                                  : CVOL_ENCODING_TEXT;
    stored->wide = (cvol_wide)m->wide;
    if (!code && stored->wide == CVOL_WIDE_COMPLEX64 && stored->encoding == CVOL_ENCODING_TEXT)
        return cvol_text_header_unsupported(&m->header, ELEMENT_TYPE, "is not supported as text");
    int64_t size = 0;
    if (!code && compressed)
        code = cvol_text_header_integer(&m->header, COMPRESSED_SIZE, 0, INT64_MAX, &size);
    stored->stored_size = (uint64_t)size;
    return code;
}

/* HeaderSize counts from the data file's beginning; -1: the samples are the file's last bytes. */
static int read_header_size(const meta *m, cvol_stored *stored)
{
    uint64_t size;
    const int code = cvol_text_header_skip(&m->header, HEADER_SIZE, stored, &size);
    if (code || size == 0)
        return code;
    if (size < stored->offset)
        return cvol_text_header_fail(&m->header, HEADER_SIZE, "is less than the header's size");
    stored->offset = size;
    return CVOL_OK;
}

static int find_samples(const meta *m, cvol_stored *stored)
{
    int code = CVOL_OK;
    stored->offset = m->header.lines.at;
    if (!cvol_text_equal(m->header.value[DATA_FILE], "LOCAL"))
        code = cvol_text_header_detach(&m->header, DATA_FILE, stored);
    if (!code)
        code = read_encoding(m, stored);
    return code ? code : read_header_size(m, stored);
}

static int find_meta(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    (void)options;
    meta m = {.grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    int code = cvol_text_header_open(context, &m.header, &layout, path);
    if (!code)
        code = read_header(&m);
    if (!code)
        code = read_grid(&m);
    if (!code)
        code = find_samples(&m, stored);
    cvol_text_header_close(&m.header);
    *grid = m.grid;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_line(cvol_bytes *bytes, enum key key, const char *value)
{
    cvol_bytes_put_text(bytes, keys[key].word);
    cvol_bytes_put_text(bytes, " = ");
    cvol_bytes_put_text(bytes, value);
    cvol_bytes_put_text(bytes, "\n");
}

static void put_numbers(cvol_bytes *bytes, enum key key, const double *values, size_t count)
{
    cvol_bytes_put_text(bytes, keys[key].word);
    cvol_bytes_put_text(bytes, " =");
    for (size_t i = 0; i < count; i++)
        cvol_text_put_number(bytes, " ", values[i]);
    cvol_bytes_put_text(bytes, "\n");
}

/* Writes all lines except the last one. The size of compressed samples is not known yet: the header
 * leaves blanks for it, and the result is their offset. */
static size_t put_header(cvol_bytes *bytes, const cvol_grid *grid, int packed)
{
    static const char *const units[] = {"um", "mm", "cm"};
    const cvol_grid known = cvol_geometry_in_unit(grid, units, CVOL_COUNT(units));
    const cvol_grid lps = cvol_geometry_in_space(&known, CVOL_SPACE_LPS);
    char number[80];
    cvol_bytes_put_text(
        bytes,
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n");
    put_line(bytes, COMPRESSED, packed ? "True" : "False");
    size_t size_at = 0;
    if (packed) {
        snprintf(number, sizeof number, "%*s", CVOL_PLAN_SIZE_BYTES, "");
        put_line(bytes, COMPRESSED_SIZE, number);
        size_at = bytes->size - CVOL_PLAN_SIZE_BYTES - 1;
    }
    put_numbers(bytes, TRANSFORM_MATRIX, lps.direction[0], 9);
    put_numbers(bytes, OFFSET, lps.origin, 3);
    cvol_bytes_put_text(bytes, "CenterOfRotation = 0 0 0\n");
    for (size_t i = 0; i < CVOL_COUNT(units); i++)
        if (!strcmp(lps.unit, units[i]))
            put_line(bytes, DISTANCE_UNITS, lps.unit);
    put_numbers(bytes, ELEMENT_SPACING, lps.spacing, 3);
    if (lps.value_scale != 1 || lps.value_offset != 0) {
        put_numbers(bytes, VALUE_SLOPE, &lps.value_scale, 1);
        put_numbers(bytes, VALUE_OFFSET, &lps.value_offset, 1);
    }
    snprintf(number, sizeof number, "%zu %zu %zu", lps.dims[0], lps.dims[1], lps.dims[2]);
    put_line(bytes, DIM_SIZE, number);
    for (size_t i = 0; i < CVOL_COUNT(types); i++)
        if (types[i].value == (int)lps.type) {
            put_line(bytes, ELEMENT_TYPE, types[i].word);
            break;
        }
    return size_at;
}

static int plan_meta(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                     const char *path)
{
    const char *data_name;
    const int code = cvol_write_plan_text(context, plan, path, ".mhd", CVOL_ENCODING_ZLIB,
                                          &data_name);
    if (code)
        return code;
    plan->size_at = put_header(&plan->header, grid, !data_name);
    put_line(&plan->header, DATA_FILE, data_name ? data_name : "LOCAL");
    return CVOL_OK;
}

const cvol_format cvol_format_metaimage = {
    .name = "MetaImage",
    .endings = {".mha", ".mhd"},
    .recognise = recognise,
    .find = find_meta,
    .plan = plan_meta,
};
