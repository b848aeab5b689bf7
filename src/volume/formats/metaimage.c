/* MetaImage (.mha, .mhd; itk.org/Wiki/ITK/MetaIO/Documentation): a text header of "Key = Value"
 * lines whose last, ElementDataFile, says where the samples are: LOCAL, right behind it, or a
 * file of their own. Row i of TransformMatrix is the direction of axis i; the world is LPS.
 *
 * Read: raw, zlib and text samples, one data file, three axes or two, one channel. Written:
 * zlib attached (.mha) or raw detached (.mhd). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/text.h"

/* The keys that are read; others are skipped. */
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

static const char *const keys[KEYS] = {
    [OBJECT_TYPE] = "ObjectType",
    [N_DIMS] = "NDims",
    [DIM_SIZE] = "DimSize",
    [ELEMENT_TYPE] = "ElementType",
    [ELEMENT_SPACING] = "ElementSpacing",
    [ELEMENT_SIZE] = "ElementSize",
    [CHANNELS] = "ElementNumberOfChannels",
    [OFFSET] = "Offset",
    [ORIGIN] = "Origin",
    [POSITION] = "Position",
    [TRANSFORM_MATRIX] = "TransformMatrix",
    [ROTATION] = "Rotation",
    [ORIENTATION] = "Orientation",
    [ANATOMICAL_ORIENTATION] = "AnatomicalOrientation",
    [DISTANCE_UNITS] = "DistanceUnits",
    [VALUE_SLOPE] = "ElementToIntensityFunctionSlope",
    [VALUE_OFFSET] = "ElementToIntensityFunctionOffset",
    [BINARY_DATA] = "BinaryData",
    [BINARY_MSB] = "BinaryDataByteOrderMSB",
    [ELEMENT_MSB] = "ElementByteOrderMSB",
    [COMPRESSED] = "CompressedData",
    [COMPRESSED_SIZE] = "CompressedDataSize",
    [HEADER_SIZE] = "HeaderSize",
    [DATA_FILE] = "ElementDataFile",
};

static const struct {
    const char *name;
    cvol_type type;
} types[] = {
    {"MET_UCHAR", CVOL_UINT8},  {"MET_CHAR", CVOL_INT8},     {"MET_USHORT", CVOL_UINT16},
    {"MET_SHORT", CVOL_INT16},  {"MET_UINT", CVOL_UINT32},   {"MET_INT", CVOL_INT32},
    {"MET_ULONG", CVOL_UINT32}, /* four bytes in this format, whatever C says */
    {"MET_LONG", CVOL_INT32},   {"MET_FLOAT", CVOL_FLOAT32}, {"MET_DOUBLE", CVOL_FLOAT64},
};

#define TYPES (sizeof types / sizeof types[0])

typedef struct meta {
    cvol_context *context;
    const char *path;
    const char *value[KEYS]; /* NULL where the header has no such key */
    size_t data_offset;      /* behind the header */
    size_t dimensions;
    cvol_grid grid;
} meta;

static int fail(const meta *m, enum key key, const char *what)
{
    return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: %s '%.80s' %s", m->path, keys[key],
                     m->value[key], what);
}

static int unsupported(const meta *m, enum key key, const char *what)
{
    fail(m, key, what);
    return CVOL_ERROR_UNSUPPORTED;
}

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

static int read_line(meta *m, char *line, size_t line_number)
{
    if (!*cvol_text_trim(line))
        return CVOL_OK;
    char *equals = strchr(line, '=');
    if (!equals)
        return cvol_fail(m->context, CVOL_ERROR_FORMAT,
                         "%s: line %zu of its header is no 'Key = Value': '%.80s'", m->path,
                         line_number, line);
    *equals = '\0';
    const char *name = cvol_text_trim(line);
    for (int k = 0; k < KEYS; k++) {
        if (!cvol_text_equal(name, keys[k]))
            continue;
        if (m->value[k])
            return cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: has %s twice", m->path, keys[k]);
        m->value[k] = cvol_text_trim(equals + 1);
    }
    return CVOL_OK;
}

static int read_header(meta *m, cvol_header *header)
{
    char *line = "";
    int code = CVOL_OK;
    while (!code && line && !m->value[DATA_FILE]) {
        code = cvol_header_next(m->context, header, &line);
        if (!code && line)
            code = read_line(m, line, header->line_number);
    }
    m->data_offset = header->at;
    static const enum key needed[] = {N_DIMS, DIM_SIZE, ELEMENT_TYPE, DATA_FILE};
    for (size_t i = 0; !code && i < sizeof needed / sizeof needed[0]; i++)
        if (!m->value[needed[i]])
            code = cvol_fail(m->context, CVOL_ERROR_FORMAT, "%s: its header has no %s", m->path,
                             keys[needed[i]]);
    if (!code && m->value[OBJECT_TYPE] && !cvol_text_equal(m->value[OBJECT_TYPE], "Image"))
        code = unsupported(m, OBJECT_TYPE, "is no Image");
    return code;
}

static int read_flag(const meta *m, enum key key, int *flag)
{
    const char *value = m->value[key];
    if (!value)
        return CVOL_OK;
    *flag = cvol_text_equal(value, "True") || !strcmp(value, "1");
    if (*flag || cvol_text_equal(value, "False") || !strcmp(value, "0"))
        return CVOL_OK;
    return fail(m, key, "is neither True nor False");
}

/* The first of three keys that mean the same; KEYS if the header has none of them. */
static enum key first_of(const meta *m, enum key a, enum key b, enum key c)
{
    return m->value[a] ? a : m->value[b] ? b : m->value[c] ? c : KEYS;
}

/* ---- grid ---------------------------------------------------------------------------- */

static int read_shape(meta *m)
{
    int64_t dimensions = 0, channels = 1;
    int code = cvol_text_field_integer(m->context, m->path, keys[N_DIMS], m->value[N_DIMS], 1, 16,
                                       &dimensions);
    if (!code && (dimensions < 2 || dimensions > 3))
        code = unsupported(m, N_DIMS, "is not supported: volumes have three axes");
    m->dimensions = (size_t)dimensions;
    if (!code)
        code = cvol_text_sizes(m->context, m->path, keys[DIM_SIZE], m->value[DIM_SIZE],
                               m->grid.dims, m->dimensions, keys[N_DIMS]);
    if (!code && m->value[CHANNELS])
        code = cvol_text_field_integer(m->context, m->path, keys[CHANNELS], m->value[CHANNELS], 1,
                                       1 << 20, &channels);
    if (!code && channels != 1)
        code = unsupported(m, CHANNELS,
                           "is not supported: write each channel into a file of its own");
    return code;
}

static int read_type(meta *m)
{
    const char *name = m->value[ELEMENT_TYPE];
    for (size_t i = 0; i < TYPES; i++)
        if (cvol_text_equal(name, types[i].name)) {
            m->grid.type = types[i].type;
            return CVOL_OK;
        }
    if (!strncmp(name, "MET_", 4))
        return unsupported(m, ELEMENT_TYPE, "is not supported");
    return fail(m, ELEMENT_TYPE, "is unknown");
}

static int read_vector(const meta *m, enum key key, double *out)
{
    if (key == KEYS || !m->value[key])
        return CVOL_OK;
    return cvol_text_numbers(m->context, m->path, keys[key], m->value[key], out, m->dimensions,
                             keys[N_DIMS]);
}

static int read_directions(meta *m)
{
    enum key key = first_of(m, TRANSFORM_MATRIX, ROTATION, ORIENTATION);
    const char *anatomy = m->value[ANATOMICAL_ORIENTATION];
    if (key != KEYS || (anatomy && *anatomy != '?'))
        m->grid.space = CVOL_SPACE_LPS;
    if (key == KEYS)
        return CVOL_OK;
    double matrix[9];
    size_t n = m->dimensions;
    int code = cvol_text_numbers(m->context, m->path, keys[key], m->value[key], matrix, n * n,
                                 "NDims squared");
    for (size_t a = 0; !code && a < n; a++) {
        double row[3] = {0, 0, 0};
        memcpy(row, matrix + n * a, n * sizeof *row);
        if (!cvol_geometry_set_direction(&m->grid, (int)a, row))
            code = fail(m, key, "has a row without a length");
    }
    return code ? code : cvol_geometry_check(m->context, &m->grid, m->path);
}

static int read_value_scale(meta *m)
{
    static const enum key both[] = {VALUE_SLOPE, VALUE_OFFSET};
    double *const out[] = {&m->grid.value_scale, &m->grid.value_offset};
    int code = CVOL_OK;
    for (int i = 0; !code && i < 2; i++)
        if (m->value[both[i]])
            code = cvol_text_numbers(m->context, m->path, keys[both[i]], m->value[both[i]], out[i],
                                     1, "the needed number");
    return code;
}

static int read_grid(meta *m)
{
    int code = read_shape(m);
    if (!code)
        code = read_type(m);
    if (!code)
        code = read_vector(m, m->value[ELEMENT_SPACING] ? ELEMENT_SPACING : ELEMENT_SIZE,
                           m->grid.spacing);
    if (!code)
        code = read_vector(m, first_of(m, OFFSET, ORIGIN, POSITION), m->grid.origin);
    if (!code)
        code = read_directions(m);
    if (!code)
        code = read_value_scale(m);
    const char *unit = m->value[DISTANCE_UNITS];
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
        code = read_flag(m, m->value[BINARY_MSB] ? BINARY_MSB : ELEMENT_MSB, &stored->big_endian);
    stored->encoding = compressed ? CVOL_ENCODING_ZLIB
                       : binary   ? CVOL_ENCODING_RAW
                                  : CVOL_ENCODING_TEXT;
    int64_t size = 0;
    if (!code && compressed && m->value[COMPRESSED_SIZE])
        code = cvol_text_field_integer(m->context, m->path, keys[COMPRESSED_SIZE],
                                       m->value[COMPRESSED_SIZE], 0, INT64_MAX, &size);
    stored->stored_size = (uint64_t)size;
    return code;
}

/* HeaderSize counts from the data file's beginning; -1: the samples are the file's last bytes. */
static int read_header_size(const meta *m, cvol_stored *stored)
{
    if (!m->value[HEADER_SIZE])
        return CVOL_OK;
    int64_t size;
    int code = cvol_text_field_integer(m->context, m->path, keys[HEADER_SIZE],
                                       m->value[HEADER_SIZE], -1, INT64_MAX, &size);
    if (code)
        return code;
    if (size < 0 && stored->encoding != CVOL_ENCODING_RAW)
        return fail(m, HEADER_SIZE, "is for raw samples alone");
    if (size > 0 && (uint64_t)size < stored->offset)
        return fail(m, HEADER_SIZE, "is less than the header's size");
    stored->at_end = size < 0;
    if (size > 0)
        stored->offset = (uint64_t)size;
    return CVOL_OK;
}

static int find_samples(const meta *m, cvol_stored *stored)
{
    const char *file = m->value[DATA_FILE];
    if (!*file)
        return fail(m, DATA_FILE, "names no file");
    if (cvol_text_names_many_files(file))
        return unsupported(m, DATA_FILE, "is a list of files; one file can be read");
    stored->offset = m->data_offset;
    if (!cvol_text_equal(file, "LOCAL")) {
        stored->data_path = cvol_input_beside(m->path, file);
        if (!stored->data_path)
            return cvol_fail_memory(m->context, strlen(m->path) + strlen(file), m->path);
        stored->offset = 0;
        stored->may_go_on = 1;
    }
    int code = read_encoding(m, stored);
    return code ? code : read_header_size(m, stored);
}

static int find_meta(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    (void)options;
    meta m = {.context = context, .path = path, .grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    cvol_input input;
    cvol_header header = {.data = NULL};
    int code = cvol_input_open(context, &input, path);
    if (!code)
        code = cvol_header_open(context, &header, &input);
    cvol_input_close(&input);
    if (!code)
        code = read_header(&m, &header);
    if (!code)
        code = read_grid(&m);
    if (!code)
        code = find_samples(&m, stored);
    cvol_header_close(&header);
    *grid = m.grid;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_line(cvol_bytes *bytes, enum key key, const char *value)
{
    cvol_bytes_put_text(bytes, keys[key]);
    cvol_bytes_put_text(bytes, " = ");
    cvol_bytes_put_text(bytes, value);
    cvol_bytes_put_text(bytes, "\n");
}

static void put_numbers(cvol_bytes *bytes, enum key key, const double *values, size_t count)
{
    cvol_bytes_put_text(bytes, keys[key]);
    cvol_bytes_put_text(bytes, " =");
    for (size_t i = 0; i < count; i++) {
        char number[CVOL_TEXT_NUMBER_BYTES];
        cvol_text_format(number, values[i]);
        cvol_bytes_put_text(bytes, " ");
        cvol_bytes_put_text(bytes, number);
    }
    cvol_bytes_put_text(bytes, "\n");
}

/* Everything but the last line. Of compressed samples the size is not known yet: its place is left
 * blank, and is the result. */
static size_t put_header(cvol_bytes *bytes, const cvol_grid *grid, int packed)
{
    cvol_grid lps = cvol_geometry_in_space(grid, CVOL_SPACE_LPS);
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
    if (!strcmp(lps.unit, "mm") || !strcmp(lps.unit, "um") || !strcmp(lps.unit, "cm"))
        put_line(bytes, DISTANCE_UNITS, lps.unit);
    put_numbers(bytes, ELEMENT_SPACING, lps.spacing, 3);
    if (lps.value_scale != 1 || lps.value_offset != 0) {
        put_numbers(bytes, VALUE_SLOPE, &lps.value_scale, 1);
        put_numbers(bytes, VALUE_OFFSET, &lps.value_offset, 1);
    }
    snprintf(number, sizeof number, "%zu %zu %zu", lps.dims[0], lps.dims[1], lps.dims[2]);
    put_line(bytes, DIM_SIZE, number);
    for (size_t i = 0; i < TYPES; i++)
        if (types[i].type == lps.type) {
            put_line(bytes, ELEMENT_TYPE, types[i].name);
            break;
        }
    return size_at;
}

static int plan_meta(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                     const char *path)
{
    if (!cvol_text_ends(path, ".mhd")) {
        plan->encoding = CVOL_ENCODING_ZLIB;
        plan->size_at = put_header(&plan->header, grid, 1);
        put_line(&plan->header, DATA_FILE, "LOCAL");
        return CVOL_OK;
    }
    int code = cvol_write_plan_detach(context, plan, path, ".raw");
    if (!code) {
        put_header(&plan->header, grid, 0);
        put_line(&plan->header, DATA_FILE, cvol_input_name(plan->data_path));
    }
    return code;
}

const cvol_format cvol_format_metaimage = {
    .name = "MetaImage",
    .endings = {".mha", ".mhd"},
    .recognise = recognise,
    .find = find_meta,
    .plan = plan_meta,
};
