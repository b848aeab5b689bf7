/* NRRD, versions NRRD0001 to NRRD0005 (teem.sourceforge.net/nrrd/format.html): a text header of
 * "field: value" lines, an empty line, and the samples; or the samples in a file of their own.
 *
 * Read: raw, gzip and text encodings, one data file, three axes (two: one slice; four: one of
 * them of size 1). Per-axis fields are in the file's axis order; `kept` maps the grid's axes to
 * them. Written: NRRD0004, gzip attached (.nrrd) or raw detached (.nhdr). */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "volume/formats/nrrd.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/text.h"

/* The fields that are read; others are skipped. */
static const struct {
    const char *name;
    enum nrrd_field field;
} fields[] = {
    {"type", NRRD_TYPE},
    {"dimension", NRRD_DIMENSION},
    {"sizes", NRRD_SIZES},
    {"kinds", NRRD_KINDS},
    {"encoding", NRRD_ENCODING},
    {"endian", NRRD_ENDIAN},
    {"spacings", NRRD_SPACINGS},
    {"space", NRRD_SPACE},
    {"space dimension", NRRD_SPACE_DIMENSION},
    {"space directions", NRRD_SPACE_DIRECTIONS},
    {"space origin", NRRD_SPACE_ORIGIN},
    {"space units", NRRD_SPACE_UNITS},
    {"units", NRRD_UNITS},
    {"line skip", NRRD_LINE_SKIP},
    {"lineskip", NRRD_LINE_SKIP},
    {"byte skip", NRRD_BYTE_SKIP},
    {"byteskip", NRRD_BYTE_SKIP},
    {"data file", NRRD_DATA_FILE},
    {"datafile", NRRD_DATA_FILE},
};

typedef struct word_value {
    const char *word;
    int value;
} word_value;

#define TYPE_UNSUPPORTED (-1)

static const word_value type_words[] = {
    {"uchar", CVOL_UINT8},
    {"unsigned char", CVOL_UINT8},
    {"uint8", CVOL_UINT8},
    {"uint8_t", CVOL_UINT8},
    {"signed char", CVOL_INT8},
    {"char", CVOL_INT8},
    {"int8", CVOL_INT8},
    {"int8_t", CVOL_INT8},
    {"ushort", CVOL_UINT16},
    {"unsigned short", CVOL_UINT16},
    {"unsigned short int", CVOL_UINT16},
    {"uint16", CVOL_UINT16},
    {"uint16_t", CVOL_UINT16},
    {"short", CVOL_INT16},
    {"short int", CVOL_INT16},
    {"signed short", CVOL_INT16},
    {"signed short int", CVOL_INT16},
    {"int16", CVOL_INT16},
    {"int16_t", CVOL_INT16},
    {"uint", CVOL_UINT32},
    {"unsigned int", CVOL_UINT32},
    {"uint32", CVOL_UINT32},
    {"uint32_t", CVOL_UINT32},
    {"int", CVOL_INT32},
    {"signed int", CVOL_INT32},
    {"int32", CVOL_INT32},
    {"int32_t", CVOL_INT32},
    {"float", CVOL_FLOAT32},
    {"double", CVOL_FLOAT64},
    {"longlong", TYPE_UNSUPPORTED},
    {"long long", TYPE_UNSUPPORTED},
    {"long long int", TYPE_UNSUPPORTED},
    {"signed long long", TYPE_UNSUPPORTED},
    {"signed long long int", TYPE_UNSUPPORTED},
    {"int64", TYPE_UNSUPPORTED},
    {"int64_t", TYPE_UNSUPPORTED},
    {"ulonglong", TYPE_UNSUPPORTED},
    {"unsigned long long", TYPE_UNSUPPORTED},
    {"unsigned long long int", TYPE_UNSUPPORTED},
    {"uint64", TYPE_UNSUPPORTED},
    {"uint64_t", TYPE_UNSUPPORTED},
    {"block", TYPE_UNSUPPORTED},
};

#define ENCODING_UNSUPPORTED (-1)

static const word_value encoding_words[] = {
    {"raw", CVOL_ENCODING_RAW},      {"gzip", CVOL_ENCODING_GZIP},  {"gz", CVOL_ENCODING_GZIP},
    {"ascii", CVOL_ENCODING_TEXT},   {"text", CVOL_ENCODING_TEXT},  {"txt", CVOL_ENCODING_TEXT},
    {"bzip2", ENCODING_UNSUPPORTED}, {"bz2", ENCODING_UNSUPPORTED}, {"hex", ENCODING_UNSUPPORTED},
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

int cvol_nrrd_fail(const nrrd *n, const char *field, const char *value, const char *what)
{
    return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: %s '%.80s' %s", n->path, field, value,
                     what);
}

int cvol_nrrd_unsupported(const nrrd *n, const char *field, const char *value, const char *what)
{
    cvol_nrrd_fail(n, field, value, what);
    return CVOL_ERROR_UNSUPPORTED;
}

/* ---- header -------------------------------------------------------------------------- */

static int recognise(const uint8_t *head, size_t size)
{
    return size >= 8 && !memcmp(head, "NRRD000", 7);
}

static int check_magic(const nrrd *n, const char *line)
{
    if (!line || strncmp(line, "NRRD", 4))
        return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: does not begin with 'NRRD'", n->path);
    if (strlen(line) == 8 && !strncmp(line, "NRRD000", 7) && line[7] >= '1' && line[7] <= '5')
        return CVOL_OK;
    return cvol_nrrd_unsupported(n, "version", line, "is none of NRRD0001 to NRRD0005");
}

/* "field: value"; comments and "key:=value" are for others. */
static int read_line(nrrd *n, char *line, size_t line_number)
{
    if (line[0] == '#')
        return CVOL_OK;
    char *colon = strchr(line, ':');
    if (!colon)
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: line %zu of its header is no field: '%.80s'", n->path, line_number,
                         line);
    if (colon[1] == '=')
        return CVOL_OK;
    *colon = '\0';
    const char *name = cvol_text_trim(line);
    for (size_t f = 0; f < COUNT(fields); f++) {
        if (!cvol_text_equal(name, fields[f].name))
            continue;
        const char **value = &n->value[fields[f].field];
        if (*value)
            return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: has the field '%s' twice", n->path,
                             fields[f].name);
        *value = cvol_text_trim(colon + 1);
    }
    return CVOL_OK;
}

static int read_header(nrrd *n, cvol_header *header)
{
    char *line;
    int code = cvol_header_next(n->context, header, &line);
    if (!code)
        code = check_magic(n, line);
    while (!code && !n->ended) {
        code = cvol_header_next(n->context, header, &line);
        if (code || !line)
            break;
        if (*line)
            code = read_line(n, line, header->line_number);
        else
            n->ended = 1;
        /* A list's names follow, up to the file's end. */
        const char *file = n->value[NRRD_DATA_FILE];
        if (!code && file && *file && cvol_text_names_many_files(file))
            return cvol_nrrd_unsupported(n, "data file", file,
                                         "is a list of files; one file can be read");
    }
    n->data_offset = header->at;
    static const enum nrrd_field needed[] = {NRRD_DIMENSION, NRRD_TYPE, NRRD_SIZES, NRRD_ENCODING};
    static const char *const names[] = {"dimension", "type", "sizes", "encoding"};
    for (size_t i = 0; !code && i < COUNT(needed); i++)
        if (!n->value[needed[i]])
            code = cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: its header has no '%s'", n->path,
                             names[i]);
    if (!code && !n->ended && !n->value[NRRD_DATA_FILE])
        code = cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: its header has neither an empty line at its end nor a 'data file'",
                         n->path);
    return code;
}

static int find_word(const word_value *words, size_t count, const char *word, int *value)
{
    for (size_t i = 0; i < count; i++)
        if (cvol_text_equal(word, words[i].word)) {
            *value = words[i].value;
            return 1;
        }
    return 0;
}

static int read_type(nrrd *n)
{
    int type;
    if (!find_word(type_words, COUNT(type_words), n->value[NRRD_TYPE], &type))
        return cvol_nrrd_fail(n, "type", n->value[NRRD_TYPE], "is unknown");
    if (type == TYPE_UNSUPPORTED)
        return cvol_nrrd_unsupported(n, "type", n->value[NRRD_TYPE], "is not supported");
    n->grid.type = (cvol_type)type;
    return CVOL_OK;
}

/* ---- data ---------------------------------------------------------------------------- */

static int read_encoding(const nrrd *n, cvol_stored *stored)
{
    int encoding;
    const char *word = n->value[NRRD_ENCODING];
    if (!find_word(encoding_words, COUNT(encoding_words), word, &encoding))
        return cvol_nrrd_fail(n, "encoding", word, "is unknown");
    if (encoding == ENCODING_UNSUPPORTED)
        return cvol_nrrd_unsupported(n, "encoding", word,
                                     "is not supported (raw, gzip and ascii are)");
    stored->encoding = (cvol_encoding)encoding;
    const char *endian = n->value[NRRD_ENDIAN];
    if (endian && !cvol_text_equal(endian, "little") && !cvol_text_equal(endian, "big"))
        return cvol_nrrd_fail(n, "endian", endian, "is neither little nor big");
    stored->big_endian = endian && cvol_text_equal(endian, "big");
    if (!endian && encoding != CVOL_ENCODING_TEXT && cvol_type_size(n->grid.type) > 1)
        return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                         "%s: its header has no 'endian', which type '%s' needs", n->path,
                         n->value[NRRD_TYPE]);
    return CVOL_OK;
}

static int read_skips(const nrrd *n, cvol_stored *stored)
{
    int64_t lines = 0, bytes = 0;
    int code = CVOL_OK;
    if (n->value[NRRD_LINE_SKIP])
        code = cvol_text_field_integer(n->context, n->path, "line skip", n->value[NRRD_LINE_SKIP],
                                       0, INT64_MAX, &lines);
    if (!code && n->value[NRRD_BYTE_SKIP])
        code = cvol_text_field_integer(n->context, n->path, "byte skip", n->value[NRRD_BYTE_SKIP],
                                       -1, INT64_MAX, &bytes);
    if (!code && bytes < 0 && stored->encoding != CVOL_ENCODING_RAW)
        code = cvol_nrrd_fail(n, "byte skip", n->value[NRRD_BYTE_SKIP],
                              "is for raw encoding alone");
    stored->line_skip = (uint64_t)lines;
    stored->byte_skip = bytes > 0 ? (uint64_t)bytes : 0;
    stored->at_end = bytes < 0;
    return code;
}

static int find_samples(const nrrd *n, cvol_stored *stored)
{
    stored->offset = n->data_offset;
    int code = read_encoding(n, stored);
    if (!code)
        code = read_skips(n, stored);
    const char *file = n->value[NRRD_DATA_FILE];
    if (code || !file)
        return code;
    if (!*file)
        return cvol_nrrd_fail(n, "data file", file, "names no file");
    stored->data_path = cvol_input_beside(n->path, file);
    stored->offset = 0;
    stored->may_go_on = 1;
    return stored->data_path
               ? CVOL_OK
               : cvol_fail_memory(n->context, strlen(n->path) + strlen(file), n->path);
}

static int find_nrrd(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    (void)options;
    nrrd n = {.context = context, .path = path, .grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    cvol_input input;
    cvol_header header = {.data = NULL};
    int code = cvol_input_open(context, &input, path);
    if (!code)
        code = cvol_header_open(context, &header, &input);
    cvol_input_close(&input);
    if (!code)
        code = read_header(&n, &header);
    if (!code)
        code = read_type(&n);
    if (!code)
        code = cvol_nrrd_read_axes(&n);
    if (!code)
        code = find_samples(&n, stored);
    cvol_header_close(&header);
    *grid = n.grid;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_vector(cvol_bytes *bytes, const double v[3], double factor)
{
    for (int i = 0; i < 3; i++) {
        char number[CVOL_TEXT_NUMBER_BYTES];
        cvol_text_format(number, v[i] * factor);
        cvol_bytes_put_text(bytes, i ? "," : " (");
        cvol_bytes_put_text(bytes, number);
    }
    cvol_bytes_put_text(bytes, ")");
}

/* Units are quoted: what would end the quotes, or the line, is left out. */
static int unit_is_plain(const char *unit)
{
    for (const char *c = unit; *c; c++)
        if (*c == '"' || *c == '\\' || (unsigned char)*c < ' ')
            return 0;
    return *unit != '\0';
}

static void put_space(cvol_bytes *bytes, const cvol_grid *grid)
{
    if (grid->space == CVOL_SPACE_LPS)
        cvol_bytes_put_text(bytes, "space: left-posterior-superior\n");
    else if (grid->space == CVOL_SPACE_RAS)
        cvol_bytes_put_text(bytes, "space: right-anterior-superior\n");
    else
        cvol_bytes_put_text(bytes, "space dimension: 3\n");
    cvol_bytes_put_text(bytes, "space directions:");
    for (int a = 0; a < 3; a++)
        put_vector(bytes, grid->direction[a], grid->spacing[a]);
    cvol_bytes_put_text(bytes, "\nspace origin:");
    put_vector(bytes, grid->origin, 1);
    cvol_bytes_put_text(bytes, "\n");
    if (unit_is_plain(grid->unit)) {
        char line[80];
        snprintf(line, sizeof line, "space units: \"%.15s\" \"%.15s\" \"%.15s\"\n", grid->unit,
                 grid->unit, grid->unit);
        cvol_bytes_put_text(bytes, line);
    }
}

static void put_header(cvol_bytes *bytes, const cvol_grid *grid, const char *data_name)
{
    const char *type = cvol_type_name(grid->type);
    if (grid->type == CVOL_FLOAT32 || grid->type == CVOL_FLOAT64)
        type = grid->type == CVOL_FLOAT32 ? "float" : "double";
    char line[160];
    snprintf(line, sizeof line, "NRRD0004\ntype: %s\ndimension: 3\nsizes: %zu %zu %zu\n", type,
             grid->dims[0], grid->dims[1], grid->dims[2]);
    cvol_bytes_put_text(bytes, line);
    put_space(bytes, grid);
    cvol_bytes_put_text(bytes, "kinds: domain domain domain\nendian: little\n");
    cvol_bytes_put_text(bytes, data_name ? "encoding: raw\ndata file: " : "encoding: gzip\n");
    if (data_name) {
        cvol_bytes_put_text(bytes, data_name);
        cvol_bytes_put_text(bytes, "\n");
    } else
        cvol_bytes_put_text(bytes, "\n");
}

static int plan_nrrd(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                     const char *path)
{
    if (!cvol_text_ends(path, ".nhdr")) {
        plan->encoding = CVOL_ENCODING_GZIP;
        put_header(&plan->header, grid, NULL);
        return CVOL_OK;
    }
    int code = cvol_write_plan_detach(context, plan, path, ".raw");
    if (!code)
        put_header(&plan->header, grid, cvol_input_name(plan->data_path));
    return code;
}

const cvol_format cvol_format_nrrd = {
    .name = "NRRD",
    .endings = {".nrrd", ".nhdr"},
    .recognise = recognise,
    .find = find_nrrd,
    .plan = plan_nrrd,
};
