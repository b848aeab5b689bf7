/* VTK's XML image data, .vti (VTK file formats, kitware.com): one piece. The reader takes the point
 * data's array named by Scalars, or the first one: as text, base64, or appended raw or in base64,
 * compressed by zlib or not. Several components are channels. Written: appended, raw. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/formats/vtk/vti_data.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/strided.h"
#include "volume/io/text.h"
#include "volume/io/xml.h"

#define HEAD_BYTES ((size_t)1 << 20)

typedef struct vti {
    cvol_context *context;
    const char *path;
    uint8_t *text; /* the file's beginning, or the whole file, and a NUL */
    size_t size;
    cvol_grid grid;
    cvol_vti_coding coding;
    int is_image, pieces, in_points, has_array, array_matches;
    char scalars[64], format[16];
    size_t components;
    size_t inline_at, inline_size; /* an array's own text */
    uint64_t offset;               /* offset of an appended array */
    size_t appended_at;            /* offset behind the '_'; 0: there is no such part */
    int appended_base64;
} vti;

static int recognise(const uint8_t *head, size_t size)
{
    return memmem(head, size, "<VTKFile", 8) && memmem(head, size, "ImageData", 9);
}

/* ---- text ---------------------------------------------------------------------------- */

/* The offset behind the '_' of appended data; 0: there are none. */
static size_t begin_of_appended(const uint8_t *bytes, size_t size)
{
    const uint8_t *end = bytes + size, *at = memmem(bytes, size, "<AppendedData", 13);
    at = at ? memchr(at, '>', (size_t)(end - at)) : NULL;
    at = at ? memchr(at, '_', (size_t)(end - at)) : NULL;
    return at ? (size_t)(at - bytes) + 1 : 0;
}

/* Reads the file up to appended data, or else the whole file. */
static int read_text(vti *v)
{
    uint8_t *bytes;
    size_t size;
    int code = cvol_file_read(v->context, &bytes, &size, v->path, 0, HEAD_BYTES);
    if (code)
        return code;
    v->appended_at = begin_of_appended(bytes, size);
    if (!v->appended_at && size == HEAD_BYTES) {
        free(bytes);
        code = cvol_file_read(v->context, &bytes, &size, v->path, 0, SIZE_MAX);
        if (code)
            return code;
        v->appended_at = begin_of_appended(bytes, size);
    }
    if (v->appended_at)
        size = v->appended_at;
    v->text = realloc(bytes, size + 1);
    if (!v->text) {
        free(bytes);
        return cvol_fail_memory(v->context, size, v->path);
    }
    v->text[size] = '\0';
    v->size = size;
    if (strlen((char *)v->text) < size)
        return cvol_fail(v->context, CVOL_ERROR_FORMAT, "%s: has a NUL byte at byte %zu of its XML",
                         v->path, strlen((char *)v->text));
    return CVOL_OK;
}

/* ---- elements ------------------------------------------------------------------------ */

/* Copies an attribute as text with a NUL; "" if it is missing. */
static void get_text(char *out, size_t room, const cvol_xml_tag *tag, const char *name)
{
    size_t length = 0;
    const char *value = cvol_xml_attribute(tag, name, &length);
    length = length < room - 1 ? length : room - 1;
    for (size_t i = 0; i < length; i++)
        out[i] = value[i] >= ' ' && value[i] <= '~' ? value[i] : ' ';
    out[length] = '\0';
}

static int fail_attribute(const vti *v, const char *name, const char *value)
{
    return cvol_fail(v->context, CVOL_ERROR_FORMAT, "%s: %s is '%.80s'", v->path, name, value);
}

static int read_file_tag(vti *v, const cvol_xml_tag *tag)
{
    char text[64];
    get_text(text, sizeof text, tag, "type");
    if (strcmp(text, "ImageData"))
        return cvol_fail(v->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is a VTK file of type '%s'; ImageData can be read", v->path, text);
    get_text(text, sizeof text, tag, "byte_order");
    v->coding.big_endian = !strcmp(text, "BigEndian");
    get_text(text, sizeof text, tag, "header_type");
    v->coding.word = !strcmp(text, "UInt64") ? 8 : 4;
    get_text(text, sizeof text, tag, "compressor");
    v->coding.is_zlib = !strcmp(text, "vtkZLibDataCompressor");
    if (text[0] && !v->coding.is_zlib)
        return cvol_fail(v->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: compressor '%s' is not supported; vtkZLibDataCompressor is", v->path,
                         text);
    return CVOL_OK;
}

static int read_numbers(const vti *v, const cvol_xml_tag *tag, const char *name, double *out,
                        size_t count)
{
    char text[512];
    get_text(text, sizeof text, tag, name);
    return text[0] ? cvol_text_numbers(v->context, v->path, name, text, out, count, "the volume")
                   : CVOL_OK;
}

/* The origin is that of index 0, not of the extent's first indices. */
static int read_image_tag(vti *v, const cvol_xml_tag *tag)
{
    double extent[6] = {0, -1, 0, -1, 0, -1}, m[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    cvol_grid *g = &v->grid;
    int code = read_numbers(v, tag, "WholeExtent", extent, 6);
    if (!code)
        code = read_numbers(v, tag, "Origin", g->origin, 3);
    if (!code)
        code = read_numbers(v, tag, "Spacing", g->spacing, 3);
    if (!code)
        code = read_numbers(v, tag, "Direction", m, 9);
    for (int a = 0; a < 3 && !code; a++) {
        const double count = extent[2 * a + 1] - extent[2 * a] + 1;
        const double column[3] = {m[a], m[3 + a], m[6 + a]};
        char text[80];
        if (!(count >= 1) || count > 0x1p40 || count != (double)(size_t)count) {
            get_text(text, sizeof text, tag, "WholeExtent");
            return fail_attribute(v, "WholeExtent", text);
        }
        g->dims[a] = (size_t)count;
        if (!cvol_geometry_set_direction(g, a, column)) {
            get_text(text, sizeof text, tag, "Direction");
            return fail_attribute(v, "Direction", text);
        }
        for (int i = 0; i < 3; i++)
            g->origin[i] += extent[2 * a] * g->spacing[a] * g->direction[a][i];
    }
    v->is_image = !code;
    return code ? code : cvol_geometry_check(v->context, g, v->path);
}

static int read_array_tag(vti *v, const cvol_xml_tag *tag)
{
    char name[64], text[64];
    get_text(name, sizeof name, tag, "Name");
    const int matches = v->scalars[0] && !strcmp(name, v->scalars);
    if (v->array_matches || (v->has_array && !matches))
        return CVOL_OK;
    v->array_matches = matches;
    v->has_array = 1;
    get_text(text, sizeof text, tag, "type");
    if (!cvol_vtk_type(&v->grid.type, text, strlen(text))) {
        fail_attribute(v, "type of its array, which is not supported,", text);
        return CVOL_ERROR_UNSUPPORTED;
    }
    int64_t components = 1, offset = 0;
    get_text(text, sizeof text, tag, "NumberOfComponents");
    if (text[0] && (!cvol_text_integer(text, strlen(text), &components) || components < 1 ||
                    components > 1000))
        return fail_attribute(v, "NumberOfComponents", text);
    v->components = (size_t)components;
    get_text(text, sizeof text, tag, "offset");
    if (text[0] && (!cvol_text_integer(text, strlen(text), &offset) || offset < 0))
        return fail_attribute(v, "offset", text);
    v->offset = (uint64_t)offset;
    get_text(v->format, sizeof v->format, tag, "format");
    v->inline_at = (size_t)(tag->end + 1 - (const char *)v->text);
    v->inline_size = strcspn(tag->end + 1, "<");
    return CVOL_OK;
}

static int read_tag(vti *v, const cvol_xml_tag *tag)
{
    char text[64];
    if (cvol_xml_is(tag, "PointData")) {
        v->in_points = !tag->closes && !tag->is_empty;
        if (!tag->closes)
            get_text(v->scalars, sizeof v->scalars, tag, "Scalars");
        return CVOL_OK;
    }
    if (tag->closes)
        return CVOL_OK;
    if (cvol_xml_is(tag, "VTKFile"))
        return read_file_tag(v, tag);
    if (cvol_xml_is(tag, "ImageData"))
        return read_image_tag(v, tag);
    if (cvol_xml_is(tag, "Piece") && ++v->pieces > 1)
        return cvol_fail(v->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: has several pieces; one can be read", v->path);
    if (cvol_xml_is(tag, "AppendedData")) {
        get_text(text, sizeof text, tag, "encoding");
        v->appended_base64 = !strcmp(text, "base64");
    }
    return cvol_xml_is(tag, "DataArray") && v->in_points ? read_array_tag(v, tag) : CVOL_OK;
}

static int read_tags(vti *v)
{
    cvol_xml_tag tag;
    int code = CVOL_OK;
    for (const char *at = (const char *)v->text; !code && cvol_xml_next(&tag, at); at = tag.end + 1)
        code = read_tag(v, &tag);
    if (!code && (!v->is_image || !v->has_array))
        code = cvol_fail(v->context, CVOL_ERROR_FORMAT, "%s: has no %s", v->path,
                         v->is_image ? "array of point data" : "ImageData element");
    return code ? code : cvol_grid_check_within(v->context, &v->grid, v->path, UINT64_MAX);
}

/* ---- arrays -------------------------------------------------------------------------- */

static int take_bytes(vti *v, cvol_stored *stored, const uint8_t *bytes, size_t size,
                      size_t channel)
{
    uint8_t *data = NULL;
    size_t wanted;
    if (!cvol_size_multiply(&wanted, cvol_grid_bytes(&v->grid), v->components))
        wanted = SIZE_MAX;
    int code = cvol_vti_unpack(v->context, &data, &v->coding, bytes, size, wanted, v->path);
    if (code)
        return code;
    const size_t *d = v->grid.dims, c = v->components;
    const cvol_strided strided = {.data = data,
                                  .size = wanted,
                                  .first = channel,
                                  .stride = {c, c * d[0], c * d[0] * d[1]},
                                  .big_endian = v->coding.big_endian};
    return cvol_strided_take(v->context, stored, &strided, &v->grid, v->path);
}

/* Raw samples of one component are read in place. */
static int find_raw(vti *v, cvol_stored *stored, uint64_t at)
{
    cvol_input input;
    uint8_t head[8] = {0};
    size_t got = 0;
    int code = cvol_input_open(v->context, &input, v->path);
    if (!code)
        code = cvol_input_read(v->context, &input, at, head, v->coding.word, &got);
    cvol_input_close(&input);
    const uint64_t bytes = cvol_vti_integer(&v->coding, head);
    if (!code && (got < v->coding.word || bytes != cvol_grid_bytes(&v->grid)))
        code = cvol_fail(v->context, CVOL_ERROR_FORMAT,
                         "%s: its array has %llu bytes, but WholeExtent has %zu", v->path,
                         (unsigned long long)bytes, cvol_grid_bytes(&v->grid));
    stored->offset = at + v->coding.word;
    stored->big_endian = v->coding.big_endian;
    stored->may_go_on = 1;
    return code;
}

static int find_appended(vti *v, cvol_stored *stored, size_t channel)
{
    uint64_t at;
    if (!v->appended_at || __builtin_add_overflow(v->offset, (uint64_t)v->appended_at, &at))
        return cvol_fail(v->context, CVOL_ERROR_FORMAT,
                         "%s: has no appended data, to which its array refers", v->path);
    if (!v->appended_base64 && !v->coding.is_zlib && v->components == 1)
        return find_raw(v, stored, at);
    uint8_t *bytes;
    size_t size;
    int code = cvol_file_read(v->context, &bytes, &size, v->path, at, SIZE_MAX);
    if (code)
        return code;
    if (v->appended_base64)
        size = cvol_vti_base64(bytes, size);
    code = take_bytes(v, stored, bytes, size, channel);
    free(bytes);
    return code;
}

static int find_array(vti *v, cvol_stored *stored, const cvol_read_options *options)
{
    size_t channel;
    int code = cvol_format_choose(v->context, &channel, v->path, "channel", "--channel",
                                  v->components, options->has_channel, options->channel);
    if (code)
        return code;
    if (v->grid.type == CVOL_UINT8 && !cvol_labels_set_colours(&stored->labels, v->components))
        return cvol_fail_memory(v->context, v->components * sizeof(cvol_channel_label), v->path);
    if (!strcmp(v->format, "appended"))
        return find_appended(v, stored, channel);
    if (!strcmp(v->format, "binary")) {
        uint8_t *bytes = v->text + v->inline_at;
        return take_bytes(v, stored, bytes, cvol_vti_base64(bytes, v->inline_size), channel);
    }
    if (strcmp(v->format, "ascii"))
        return fail_attribute(v, "format of its array", v->format);
    if (v->components > 1)
        return cvol_fail(v->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: %zu components as text are not supported", v->path, v->components);
    stored->encoding = CVOL_ENCODING_TEXT;
    stored->offset = v->inline_at;
    stored->stored_size = v->inline_size ? v->inline_size : 1;
    return CVOL_OK;
}

static int find_vti(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    vti v = {.context = context,
             .path = path,
             .grid = cvol_grid_make(1, 1, 1, CVOL_UINT8),
             .coding.word = 4};
    int code = read_text(&v);
    if (!code)
        code = read_tags(&v);
    if (!code)
        code = find_array(&v, stored, options);
    free(v.text);
    *grid = v.grid;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static void put_numbers(cvol_bytes *bytes, const char *name, const double *values, size_t count)
{
    cvol_bytes_put_text(bytes, name);
    for (size_t i = 0; i < count; i++) {
        char number[CVOL_TEXT_NUMBER_BYTES];
        cvol_text_format(number, values[i]);
        cvol_bytes_put_text(bytes, i ? " " : "=\"");
        cvol_bytes_put_text(bytes, number);
    }
    cvol_bytes_put_text(bytes, "\"");
}

static int plan_vti(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                    const char *path)
{
    static const char *const types[] = {
        [CVOL_UINT8] = "UInt8",     [CVOL_INT8] = "Int8",       [CVOL_UINT16] = "UInt16",
        [CVOL_INT16] = "Int16",     [CVOL_UINT32] = "UInt32",   [CVOL_INT32] = "Int32",
        [CVOL_FLOAT32] = "Float32", [CVOL_FLOAT64] = "Float64",
    };
    (void)context, (void)path;
    cvol_bytes *b = &plan->header;
    char line[240], extent[100];
    double m[9];
    for (int i = 0; i < 9; i++)
        m[i] = grid->direction[i % 3][i / 3];
    snprintf(extent, sizeof extent, "0 %zu 0 %zu 0 %zu", grid->dims[0] - 1, grid->dims[1] - 1,
             grid->dims[2] - 1);
    cvol_bytes_put_text(b, "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
                           "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n");
    snprintf(line, sizeof line, "  <ImageData WholeExtent=\"%s\"", extent);
    cvol_bytes_put_text(b, line);
    put_numbers(b, " Origin", grid->origin, 3);
    put_numbers(b, " Spacing", grid->spacing, 3);
    put_numbers(b, " Direction", m, 9);
    snprintf(line, sizeof line,
             ">\n    <Piece Extent=\"%s\">\n      <PointData Scalars=\"values\">\n", extent);
    cvol_bytes_put_text(b, line);
    snprintf(line, sizeof line,
             "        <DataArray type=\"%s\" Name=\"values\" format=\"appended\" offset=\"0\"/>\n"
             "      </PointData>\n    </Piece>\n  </ImageData>\n"
             "  <AppendedData encoding=\"raw\">\n_",
             types[grid->type]);
    cvol_bytes_put_text(b, line);
    cvol_bytes_put_u64(b, cvol_grid_bytes(grid));
    cvol_bytes_put_text(&plan->trailer, "\n  </AppendedData>\n</VTKFile>\n");
    plan->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}

const cvol_format cvol_format_vti = {
    .name = "VTK XML",
    .endings = {".vti"},
    .recognise = recognise,
    .find = find_vti,
    .plan = plan_vti,
    .takes = CVOL_TAKES_CHANNEL,
};
