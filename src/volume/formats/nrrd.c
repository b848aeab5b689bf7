/* NRRD, versions NRRD0001 to NRRD0005 (teem.sourceforge.net/nrrd/format.html): a text header of
 * "field: value" lines, an empty line, and the samples; or the samples in a separate file.
 *
 * Read: raw, gzip and text encodings, one data file, three axes (two: one slice; four: a series of
 * volumes, nrrd_volumes.c). Per-axis fields are in the file's axis order; `kept` maps the grid's
 * axes to them. Written: NRRD0004, gzip attached (.nrrd) or raw detached (.nhdr). */
#define _GNU_SOURCE
#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "volume/formats/nrrd.h"
#include "volume/io/format.h"

static const cvol_keyword field_names[] = {
    {"type", NRRD_TYPE},
    {"dimension", NRRD_DIMENSION},
    {"sizes", NRRD_SIZES},
    {"kinds", NRRD_KINDS},
    {"encoding", NRRD_ENCODING},
    {"endian", NRRD_ENDIAN},
    {"spacings", NRRD_SPACINGS},
    {"axis mins", NRRD_AXIS_MINS},
    {"axismins", NRRD_AXIS_MINS},
    {"axis maxs", NRRD_AXIS_MAXS},
    {"axismaxs", NRRD_AXIS_MAXS},
    {"centers", NRRD_CENTERS},
    {"centerings", NRRD_CENTERS},
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

static const cvol_text_layout layout = {"field: value", ':', field_names, CVOL_COUNT(field_names)};

enum { TYPE_UNSUPPORTED = -1, TYPE_INT64 = -2, TYPE_UINT64 = -3 };

static const cvol_keyword type_words[] = {
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
    {"longlong", TYPE_INT64},
    {"long long", TYPE_INT64},
    {"long long int", TYPE_INT64},
    {"signed long long", TYPE_INT64},
    {"signed long long int", TYPE_INT64},
    {"int64", TYPE_INT64},
    {"int64_t", TYPE_INT64},
    {"ulonglong", TYPE_UINT64},
    {"unsigned long long", TYPE_UINT64},
    {"unsigned long long int", TYPE_UINT64},
    {"uint64", TYPE_UINT64},
    {"uint64_t", TYPE_UINT64},
    {"block", TYPE_UNSUPPORTED},
};

#define ENCODING_UNSUPPORTED (-1)

static const cvol_keyword encoding_words[] = {
    {"raw", CVOL_ENCODING_RAW},      {"gzip", CVOL_ENCODING_GZIP},  {"gz", CVOL_ENCODING_GZIP},
    {"ascii", CVOL_ENCODING_TEXT},   {"text", CVOL_ENCODING_TEXT},  {"txt", CVOL_ENCODING_TEXT},
    {"bzip2", ENCODING_UNSUPPORTED}, {"bz2", ENCODING_UNSUPPORTED}, {"hex", ENCODING_UNSUPPORTED},
};

static const cvol_keyword endian_words[] = {{"little", 0}, {"big", 1}};

/* ---- header -------------------------------------------------------------------------- */

static int recognise(const uint8_t *head, size_t size)
{
    return size >= 8 && !memcmp(head, "NRRD000", 7);
}

static int check_magic(const nrrd *n, const char *line)
{
    const cvol_text_header *header = &n->header;
    if (!line || strncmp(line, "NRRD", 4))
        return cvol_fail(header->context, CVOL_ERROR_FORMAT, "%s: does not begin with 'NRRD'",
                         header->path);
    if (strlen(line) == 8 && !strncmp(line, "NRRD000", 7) && line[7] >= '1' && line[7] <= '5')
        return CVOL_OK;
    return cvol_fail(header->context, CVOL_ERROR_UNSUPPORTED,
                     "%s: version '%.80s' is not NRRD0001 to NRRD0005", header->path, line);
}

/* Skips comments and pairs "key:=value", which are for other programs. */
static int read_line(nrrd *n, char *line)
{
    const char *colon = strchr(line, ':');
    if (line[0] == '#' || (colon && colon[1] == '='))
        return CVOL_OK;
    return cvol_text_header_put(&n->header, line);
}

static int read_header(nrrd *n)
{
    cvol_text_header *header = &n->header;
    char *line;
    int ended = 0; /* by an empty line */
    int code = cvol_header_next(header->context, &header->lines, &line);
    if (!code)
        code = check_magic(n, line);
    while (!code && !ended) {
        code = cvol_header_next(header->context, &header->lines, &line);
        if (code || !line)
            break;
        ended = !*line;
        if (!ended)
            code = read_line(n, line);
        /* The names of a list would follow, which are not fields. */
        if (!code)
            code = cvol_text_header_one_file(header, NRRD_DATA_FILE);
    }
    static const int needed[] = {NRRD_DIMENSION, NRRD_TYPE, NRRD_SIZES, NRRD_ENCODING};
    if (!code)
        code = cvol_text_header_need(header, needed, CVOL_COUNT(needed));
    if (!code && !ended && !header->value[NRRD_DATA_FILE])
        code = cvol_fail(header->context, CVOL_ERROR_FORMAT,
                         "%s: its header has neither an empty line at its end nor a 'data file'",
                         header->path);
    return code;
}

static int read_type(nrrd *n, cvol_stored *stored)
{
    int type;
    if (!cvol_keyword_find(type_words, CVOL_COUNT(type_words), n->header.value[NRRD_TYPE], &type))
        return cvol_text_header_fail(&n->header, NRRD_TYPE, "is unknown");
    if (type == TYPE_UNSUPPORTED)
        return cvol_text_header_unsupported(&n->header, NRRD_TYPE, "is not supported");
    const int is_wide = type == TYPE_INT64 || type == TYPE_UINT64;
    n->grid.type = is_wide ? CVOL_WIDE_TYPE : (cvol_type)type;
    stored->wide = type == TYPE_INT64    ? CVOL_WIDE_INT64
                   : type == TYPE_UINT64 ? CVOL_WIDE_UINT64
                                         : CVOL_WIDE_NONE;
    return CVOL_OK;
}

/* ---- data ---------------------------------------------------------------------------- */

static int read_encoding(const nrrd *n, cvol_stored *stored)
{
    const cvol_text_header *header = &n->header;
    int encoding;
    if (!cvol_keyword_find(encoding_words, CVOL_COUNT(encoding_words), header->value[NRRD_ENCODING],
                           &encoding))
        return cvol_text_header_fail(header, NRRD_ENCODING, "is unknown");
    if (encoding == ENCODING_UNSUPPORTED)
        return cvol_text_header_unsupported(header, NRRD_ENCODING,
                                            "is not supported (raw, gzip and ascii are)");
    stored->encoding = (cvol_encoding)encoding;
    const char *endian = header->value[NRRD_ENDIAN];
    if (endian &&
        !cvol_keyword_find(endian_words, CVOL_COUNT(endian_words), endian, &stored->big_endian))
        return cvol_text_header_fail(header, NRRD_ENDIAN, "is neither little nor big");
    if (!endian && encoding != CVOL_ENCODING_TEXT && cvol_type_size(n->grid.type) > 1)
        return cvol_fail(header->context, CVOL_ERROR_FORMAT,
                         "%s: its header has no 'endian', which type '%s' needs", header->path,
                         header->value[NRRD_TYPE]);
    return CVOL_OK;
}

static int find_samples(const nrrd *n, cvol_stored *stored)
{
    int64_t lines = 0;
    stored->offset = n->header.lines.at;
    int code = read_encoding(n, stored);
    if (!code)
        code = cvol_text_header_integer(&n->header, NRRD_LINE_SKIP, 0, INT64_MAX, &lines);
    stored->line_skip = (uint64_t)lines;
    if (!code)
        code = cvol_text_header_skip(&n->header, NRRD_BYTE_SKIP, stored, &stored->byte_skip);
    if (!code && n->header.value[NRRD_DATA_FILE])
        code = cvol_text_header_detach(&n->header, NRRD_DATA_FILE, stored);
    return code;
}

static int find_nrrd(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    nrrd n = {.grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    int code = cvol_text_header_open(context, &n.header, &layout, path);
    if (!code)
        code = read_header(&n);
    if (!code)
        code = read_type(&n, stored);
    if (!code)
        code = cvol_nrrd_read_axes(&n);
    if (!code)
        code = find_samples(&n, stored);
    if (!code)
        code = cvol_nrrd_choose(&n, stored, options);
    cvol_text_header_close(&n.header);
    *grid = n.grid;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_vector(cvol_bytes *bytes, const double v[3], double factor)
{
    for (int i = 0; i < 3; i++)
        cvol_text_put_number(bytes, i ? "," : " (", v[i] * factor);
    cvol_bytes_put_text(bytes, ")");
}

/* Units are quoted: a unit that contains a quote or a line end is omitted. */
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

/* A key of a segment, and the beginning of its line. */
static void put_key(cvol_bytes *bytes, size_t segment, const char *key)
{
    char line[64];
    snprintf(line, sizeof line, "Segment%zu_%s:=", segment, key);
    cvol_bytes_put_text(bytes, line);
}

/* Line ends and backslashes are escaped in values of keys. */
static void put_value(cvol_bytes *bytes, const char *text)
{
    for (const char *c = text; *c; c++) {
        const char one[2] = {*c, '\0'};
        cvol_bytes_put_text(bytes, *c == '\n' ? "\\n" : *c == '\\' ? "\\\\" : one);
    }
    cvol_bytes_put_text(bytes, "\n");
}

/* The keys that 3D Slicer writes. */
static void put_segments(cvol_bytes *bytes, const cvol_grid *grid, const cvol_label *labels,
                         size_t count)
{
    char line[128];
    cvol_bytes_put_text(bytes, "Segmentation_ContainedRepresentationNames:=Binary labelmap|\n"
                               "Segmentation_MasterRepresentation:=Binary labelmap\n"
                               "Segmentation_ReferenceImageExtentOffset:=0 0 0\n");
    for (size_t i = 0; i < count; i++) {
        const cvol_label *label = &labels[i];
        put_key(bytes, i, "ID");
        snprintf(line, sizeof line, "Segment_%d\n", label->value);
        cvol_bytes_put_text(bytes, line);
        put_key(bytes, i, "Name");
        put_value(bytes, label->name);
        put_key(bytes, i, "Color");
        snprintf(line, sizeof line, "%.6g %.6g %.6g\n", label->rgb[0], label->rgb[1],
                 label->rgb[2]);
        cvol_bytes_put_text(bytes, line);
        put_key(bytes, i, "LabelValue");
        snprintf(line, sizeof line, "%d\n", label->value);
        cvol_bytes_put_text(bytes, line);
        put_key(bytes, i, "Layer");
        cvol_bytes_put_text(bytes, "0\n");
        put_key(bytes, i, "Extent");
        snprintf(line, sizeof line, "0 %zu 0 %zu 0 %zu\n", grid->dims[0] - 1, grid->dims[1] - 1,
                 grid->dims[2] - 1);
        cvol_bytes_put_text(bytes, line);
    }
}

static void put_header(cvol_bytes *bytes, const cvol_grid *grid, const char *data_name,
                       const cvol_write_plan *plan)
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
    cvol_bytes_put_text(bytes, data_name ? "encoding: raw\n" : "encoding: gzip\n");
    if (plan->series->labels)
        put_segments(bytes, grid, plan->series->labels, plan->series->label_count);
    if (data_name) {
        cvol_bytes_put_text(bytes, "data file: ");
        cvol_bytes_put_text(bytes, data_name);
    }
    cvol_bytes_put_text(bytes, "\n");
}

static int plan_nrrd(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                     const char *path)
{
    const char *data_name;
    const int code = cvol_write_plan_text(context, plan, path, ".nhdr", CVOL_ENCODING_GZIP,
                                          &data_name);
    if (!code)
        put_header(&plan->header, grid, data_name, plan);
    return code;
}

const cvol_format cvol_format_nrrd = {
    .name = "NRRD",
    .endings = {".nrrd", ".nhdr"},
    .recognise = recognise,
    .find = find_nrrd,
    .plan = plan_nrrd,
    .takes = CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
};
