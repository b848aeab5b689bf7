/* VTK's legacy files of structured points (VTK file formats, kitware.com): five parts of text
 * lines, and the samples, as text or high byte first. The reader takes the first SCALARS array of
 * POINT_DATA, or else the first array of a FIELD; several components are channels. */
#define _GNU_SOURCE
#include <stdio.h>
#include <string.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/format.h"
#include "volume/io/strided.h"
#include "volume/io/text.h"

typedef struct vtk {
    cvol_context *context;
    const char *path;
    cvol_header header;
    int is_binary, has_dimensions, has_array;
    size_t points, components;
    cvol_grid grid;
} vtk;

static int recognise(const uint8_t *head, size_t size)
{
    return size >= 14 && !memcmp(head, "# vtk DataFile", 14);
}

static int fail(const vtk *v, const char *what, const char *line)
{
    return cvol_fail(v->context, CVOL_ERROR_FORMAT, "%s: %s '%.80s'", v->path, what, line);
}

int cvol_vtk_type(cvol_type *out, const char *name, size_t length)
{
    static const struct {
        const char *name;
        cvol_type type;
    } types[] = {
        {"unsigned_char", CVOL_UINT8}, {"char", CVOL_INT8},
        {"signed_char", CVOL_INT8},    {"unsigned_short", CVOL_UINT16},
        {"short", CVOL_INT16},         {"unsigned_int", CVOL_UINT32},
        {"int", CVOL_INT32},           {"float", CVOL_FLOAT32},
        {"double", CVOL_FLOAT64},      {"UInt8", CVOL_UINT8},
        {"Int8", CVOL_INT8},           {"UInt16", CVOL_UINT16},
        {"Int16", CVOL_INT16},         {"UInt32", CVOL_UINT32},
        {"Int32", CVOL_INT32},         {"Float32", CVOL_FLOAT32},
        {"Float64", CVOL_FLOAT64},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strlen(types[i].name) == length && !memcmp(types[i].name, name, length)) {
            *out = types[i].type;
            return 1;
        }
    return 0;
}

/* ---- lines --------------------------------------------------------------------------- */

/* The next line that is not empty, trimmed; its first word's length. */
static int next_line(vtk *v, char **line, size_t *word)
{
    int code;
    do {
        code = cvol_header_next(v->context, &v->header, line);
        if (!code && *line)
            *line = cvol_text_trim(*line);
    } while (!code && *line && !**line);
    if (!code && !*line)
        code = cvol_fail(v->context, CVOL_ERROR_FORMAT,
                         "%s: its header ends without an array of "
                         "point data",
                         v->path);
    *word = code ? 0 : strcspn(*line, " \t");
    return code;
}

static int is_word(const char *line, size_t length, const char *word)
{
    return strlen(word) == length && !strncasecmp(line, word, length);
}

/* "SCALARS name type [components]"; a line "LOOKUP_TABLE name" may follow. */
static int read_scalars(vtk *v, const char *line)
{
    const char *rest = line, *words[4] = {NULL, NULL, NULL, NULL};
    size_t lengths[4] = {0, 0, 0, 0};
    int64_t components = 1;
    for (int i = 0; i < 4; i++)
        words[i] = cvol_text_word(&rest, &lengths[i]);
    if (!words[2] || !cvol_vtk_type(&v->grid.type, words[2], lengths[2]))
        return fail(v, "SCALARS of a type that is not supported:", line);
    if (words[3] &&
        (!cvol_text_integer(words[3], lengths[3], &components) || components < 1 || components > 4))
        return fail(v, "SCALARS with an unsupported number of components:", line);
    v->components = (size_t)components;
    v->has_array = 1;
    const size_t begin = v->header.at;
    char *next;
    size_t length;
    if (next_line(v, &next, &length) || !is_word(next, length, "LOOKUP_TABLE"))
        v->header.at = begin; /* samples already */
    return CVOL_OK;
}

/* "COLOR_SCALARS name components": bytes; as text, numbers of 0 to 1, which are not supported. */
static int read_colours(vtk *v, const char *line)
{
    const char *rest = line, *word = NULL;
    size_t length = 0;
    int64_t components;
    for (int i = 0; i < 3; i++)
        word = cvol_text_word(&rest, &length);
    if (!v->is_binary || !word || !cvol_text_integer(word, length, &components) || components < 1 ||
        components > 4)
        return fail(v, "colours that are not supported:", line);
    v->grid.type = CVOL_UINT8;
    v->components = (size_t)components;
    v->has_array = 1;
    return CVOL_OK;
}

/* "FIELD name arrays", of which the first one is "name components tuples type". */
static int read_field(vtk *v)
{
    char *line;
    size_t length;
    int64_t components, tuples;
    int code = next_line(v, &line, &length);
    if (code)
        return code;
    const char *rest = line, *words[4];
    size_t lengths[4];
    for (int i = 0; i < 4; i++)
        words[i] = cvol_text_word(&rest, &lengths[i]);
    if (!words[3] || !cvol_text_integer(words[1], lengths[1], &components) ||
        !cvol_text_integer(words[2], lengths[2], &tuples) || components < 1 || components > 64 ||
        tuples != (int64_t)v->points || !cvol_vtk_type(&v->grid.type, words[3], lengths[3]))
        return fail(v, "the first array of a FIELD does not have one sample per point:", line);
    v->components = (size_t)components;
    v->has_array = 1;
    return CVOL_OK;
}

static int read_line(vtk *v, char *line, size_t length)
{
    const char *rest = line + length;
    double s[3];
    if (is_word(line, length, "DATASET")) {
        size_t name_length;
        const char *name = cvol_text_word(&rest, &name_length);
        if (name && is_word(name, name_length, "STRUCTURED_POINTS"))
            return CVOL_OK;
        fail(v, "only STRUCTURED_POINTS can be read, not", line);
        return CVOL_ERROR_UNSUPPORTED;
    }
    if (is_word(line, length, "DIMENSIONS")) {
        v->has_dimensions = 1;
        return cvol_text_sizes(v->context, v->path, "DIMENSIONS", rest, v->grid.dims, 3,
                               "the volume");
    }
    if (is_word(line, length, "SPACING") || is_word(line, length, "ASPECT_RATIO"))
        return cvol_text_numbers(v->context, v->path, "SPACING", rest, v->grid.spacing, 3,
                                 "the volume");
    if (is_word(line, length, "ORIGIN")) {
        int code = cvol_text_numbers(v->context, v->path, "ORIGIN", rest, s, 3, "the volume");
        if (!code)
            memcpy(v->grid.origin, s, sizeof s);
        return code;
    }
    if (is_word(line, length, "POINT_DATA")) {
        int64_t points;
        int code = cvol_text_field_integer(v->context, v->path, "POINT_DATA",
                                           rest + strspn(rest, " \t"), 1, INT64_MAX, &points);
        if (!code && (!v->has_dimensions || cvol_grid_samples(&v->grid) != (uint64_t)points))
            code = fail(v, "DIMENSIONS do not match the points of", line);
        v->points = code ? 0 : (size_t)points;
        return code;
    }
    if (is_word(line, length, "SCALARS") && v->points)
        return read_scalars(v, line);
    if (is_word(line, length, "COLOR_SCALARS") && v->points)
        return read_colours(v, line);
    if (is_word(line, length, "FIELD") && v->points)
        return read_field(v);
    if (is_word(line, length, "METADATA")) /* up to an empty line, which next_line skips */
        return CVOL_OK;
    if (v->points || is_word(line, length, "CELL_DATA") || is_word(line, length, "FIELD")) {
        fail(v, "only SCALARS of POINT_DATA can be read, not", line);
        return CVOL_ERROR_UNSUPPORTED;
    }
    return fail(v, "an unknown line in its header:", line);
}

static int read_header(vtk *v)
{
    char *line;
    size_t length;
    int code = cvol_header_next(v->context, &v->header, &line);
    if (!code && (!line || strncmp(line, "# vtk DataFile", 14)))
        return cvol_fail(v->context, CVOL_ERROR_FORMAT, "%s: does not begin with '# vtk DataFile'",
                         v->path);
    if (!code)
        code = cvol_header_next(v->context, &v->header, &line); /* a title */
    if (!code)
        code = next_line(v, &line, &length);
    if (code)
        return code;
    v->is_binary = cvol_text_equal(line, "BINARY");
    if (!v->is_binary && !cvol_text_equal(line, "ASCII"))
        return fail(v, "its third line is neither BINARY nor ASCII:", line);
    while (!code && !v->has_array) {
        code = next_line(v, &line, &length);
        if (!code)
            code = read_line(v, line, length);
        /* So a product of three cannot overflow before the check. */
        if (!code && v->has_dimensions)
            code = cvol_grid_check_within(v->context, &v->grid, v->path, UINT64_MAX);
    }
    return code;
}

/* ---- samples ------------------------------------------------------------------------- */

static int find_samples(vtk *v, cvol_stored *stored, const cvol_read_options *options)
{
    size_t channel, elements;
    int code = cvol_format_choose(v->context, &channel, v->path, "channel", "--channel",
                                  v->components, options->has_channel, options->channel);
    if (code)
        return code;
    if (v->grid.type == CVOL_UINT8 && !cvol_labels_set_colours(&stored->labels, v->components))
        return cvol_fail_memory(v->context, v->components * sizeof(cvol_channel_label), v->path);
    stored->offset = v->header.at;
    stored->may_go_on = 1; /* with other arrays */
    stored->big_endian = 1;
    stored->encoding = v->is_binary ? CVOL_ENCODING_RAW : CVOL_ENCODING_TEXT;
    if (v->components == 1)
        return CVOL_OK;
    if (!v->is_binary)
        return cvol_fail(v->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: %zu components as text are not supported", v->path, v->components);
    if (!cvol_size_multiply(&elements, v->points, v->components))
        elements = SIZE_MAX;
    const size_t *d = v->grid.dims, c = v->components;
    cvol_strided strided = {
        .first = channel, .stride = {c, c * d[0], c * d[0] * d[1]}, .big_endian = 1};
    return cvol_strided_read(v->context, stored, &strided, &v->grid, v->path, v->header.at,
                             elements);
}

static int find_vtk(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    vtk v = {.context = context, .path = path, .grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    int code = cvol_header_open(context, &v.header, path);
    if (!code)
        code = read_header(&v);
    if (!code)
        code = find_samples(&v, stored, options);
    cvol_header_close(&v.header);
    *grid = v.grid;
    return code;
}

const cvol_format cvol_format_vtk = {
    .name = "VTK",
    .endings = {".vtk"},
    .recognise = recognise,
    .find = find_vtk,
    .takes = CVOL_TAKES_CHANNEL,
};
