/* NumPy's .npy, versions 1 to 3 (numpy.org, NEP 1 and numpy.lib.format): a magic, a header that is
 * a Python dictionary, and an array's elements.
 *
 * The array's last axis is x, so that v[z, y, x] is the same sample in either order of storage; C
 * order is that of grids. More than three axes are chosen from (axes.h). Booleans are bytes, and
 * half floats become floats. Written: version 1, little-endian, C order. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/axes.h"
#include "volume/io/format.h"
#include "volume/io/strided.h"
#include "volume/io/text.h"

#define HEADER_MAX 65536

typedef struct npy {
    cvol_context *context;
    const char *path;
    char header[HEADER_MAX + 1];
    uint64_t data_at;
    uint64_t file_size;
    cvol_type type;
    int is_half, big_endian, is_fortran;
    cvol_wide wide;
    cvol_axes axes;
} npy;

static int recognise(const uint8_t *head, size_t size)
{
    return size >= 10 && !memcmp(head, "\x93NUMPY", 6);
}

/* ---- header -------------------------------------------------------------------------- */

static int read_header(npy *n)
{
    cvol_input input;
    uint8_t b[12] = {0};
    size_t got = 0, size = 0;
    int code = cvol_input_open(n->context, &input, n->path);
    if (!code)
        code = cvol_input_read(n->context, &input, 0, b, sizeof b, &got);
    if (!code && !recognise(b, got))
        code = cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: does not begin with '\\x93NUMPY'",
                         n->path);
    if (!code && (b[6] < 1 || b[6] > 3))
        code = cvol_fail(n->context, CVOL_ERROR_UNSUPPORTED, "%s: version %d.%d is not 1, 2 or 3",
                         n->path, b[6], b[7]);
    if (!code) {
        const uint64_t at = b[6] == 1 ? 10 : 12;
        size = (size_t)b[8] | (size_t)b[9] << 8;
        if (b[6] > 1)
            size |= (size_t)b[10] << 16 | (size_t)b[11] << 24;
        if (size > HEADER_MAX)
            code = cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: its header has %zu bytes", n->path,
                             size);
        else
            code = cvol_input_read(n->context, &input, at, n->header, size, &got);
        n->data_at = at + size;
    }
    for (size_t i = 0; i < got && got <= HEADER_MAX; i++) /* fit for messages */
        if (n->header[i] && (n->header[i] < ' ' || n->header[i] > '~'))
            n->header[i] = n->header[i] == '\n' ? ' ' : '?';
    n->file_size = input.size;
    cvol_input_close(&input);
    if (!code && (got < size || memchr(n->header, '\0', size)))
        code = cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: its header is cut off or no text",
                         n->path);
    return code;
}

/* The text that follows 'key': in the dictionary. */
static const char *find_value(const npy *n, const char *key)
{
    char quoted[32];
    for (const char *quote = "'\""; *quote; quote++) {
        snprintf(quoted, sizeof quoted, "%c%s%c", *quote, key, *quote);
        const char *at = strstr(n->header, quoted);
        if (!at)
            continue;
        at += strlen(quoted);
        at += strspn(at, " ");
        if (*at == ':')
            return at + 1 + strspn(at + 1, " ");
    }
    return NULL;
}

/* The number of characters of a value: text in quotes, a tuple, or a word. */
static size_t value_length(const char *value)
{
    const char end[2] = {*value == '(' ? ')' : *value, '\0'};
    if (*value != '(' && *value != '\'' && *value != '"')
        return strcspn(value, ",} ");
    const size_t length = 1 + strcspn(value + 1, end);
    return length + (value[length] != '\0');
}

static int fail_value(const npy *n, const char *key, const char *what)
{
    const char *value = find_value(n, key);
    if (!value)
        value = "missing";
    const size_t length = value_length(value);
    return cvol_fail(n->context, CVOL_ERROR_FORMAT, "%s: '%s' is %.*s, %s", n->path, key,
                     length < 60 ? (int)length : 60, value, what);
}

static int read_type(npy *n)
{
    static const struct {
        const char *name;
        cvol_type type;
    } types[] = {{"u1", CVOL_UINT8},    {"b1", CVOL_UINT8},     {"i1", CVOL_INT8},
                 {"u2", CVOL_UINT16},   {"i2", CVOL_INT16},     {"u4", CVOL_UINT32},
                 {"i4", CVOL_INT32},    {"f4", CVOL_FLOAT32},   {"f8", CVOL_FLOAT64},
                 {"f2", CVOL_FLOAT32},  {"i8", CVOL_WIDE_TYPE}, {"u8", CVOL_WIDE_TYPE},
                 {"c8", CVOL_WIDE_TYPE}};
    const char *value = find_value(n, "descr");
    if (!value || (*value != '\'' && *value != '"') || !strchr("<>|=", value[1]) || !value[1])
        return fail_value(n, "descr", "must be a type as in '<f4'");
    n->big_endian = value[1] == '>';
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strncmp(value + 2, types[i].name, 2) && value[4] == value[0]) {
            n->type = types[i].type;
            n->is_half = !strcmp(types[i].name, "f2");
            n->wide = !strcmp(types[i].name, "i8")   ? CVOL_WIDE_INT64
                      : !strcmp(types[i].name, "u8") ? CVOL_WIDE_UINT64
                      : !strcmp(types[i].name, "c8") ? CVOL_WIDE_COMPLEX64
                                                     : CVOL_WIDE_NONE;
            return CVOL_OK;
        }
    fail_value(n, "descr", "which is not supported (integers, floats and '<c8' are)");
    return CVOL_ERROR_UNSUPPORTED;
}

static int read_shape(npy *n)
{
    const char *at = find_value(n, "shape"), *order = find_value(n, "fortran_order");
    int count = 0;
    if (!order || (strncmp(order, "True", 4) && strncmp(order, "False", 5)))
        return fail_value(n, "fortran_order", "must be True or False");
    n->is_fortran = order[0] == 'T';
    if (!at || *at != '(')
        return fail_value(n, "shape", "must be numbers in brackets");
    for (at++; *at && *at != ')' && count < CVOL_AXES_MAX;) {
        size_t length = strspn(at, "0123456789");
        int64_t axis;
        if (!cvol_text_integer(at, length, &axis))
            return fail_value(n, "shape", "must be numbers in brackets");
        if (axis == 0)
            return fail_value(n, "shape", "which holds no samples");
        n->axes.dims[count++] = (uint64_t)axis;
        at += length + strspn(at + length, "L");
        at += strspn(at, " ");
        at += *at == ',';
        at += strspn(at, " ");
    }
    if (*at != ')' || count < 1)
        return fail_value(n, "shape", "must have one to five axes");
    n->axes.rank = count;
    return CVOL_OK;
}

/* ---- reading ------------------------------------------------------------------------- */

/* The distance, in elements, of an axis' neighbours. */
static size_t stride_of(const npy *n, int axis)
{
    size_t stride = 1;
    for (int i = n->is_fortran ? 0 : axis + 1; i < (n->is_fortran ? axis : n->axes.rank); i++)
        stride *= (size_t)n->axes.dims[i];
    return axis < 0 ? 0 : stride;
}

/* The product of all axes is known to fit. In C order only the axes behind the chosen leading ones
 * are read. */
static int find_elements(const npy *n, cvol_stored *stored, const cvol_grid *grid, size_t elements)
{
    const cvol_axes *axes = &n->axes;
    const size_t each = n->is_half ? 2 : cvol_type_size(n->type);
    cvol_strided strided = {.big_endian = n->big_endian, .is_half = n->is_half};
    uint64_t skip = 0;
    for (int i = 0; i < axes->rank; i++)
        if (!n->is_fortran && i < axes->of[2]) {
            skip += axes->begin[i] * stride_of(n, i);
            elements = stride_of(n, i);
        } else {
            strided.first += (size_t)axes->begin[i] * stride_of(n, i);
        }
    for (int a = 0; a < 3; a++)
        strided.stride[a] = stride_of(n, axes->of[a]);
    const uint64_t at = n->data_at + skip * each;
    stored->wide = n->wide;
    if (n->is_fortran || n->is_half || strided.stride[0] != 1)
        return cvol_strided_read(n->context, stored, &strided, grid, n->path, at, elements);
    stored->offset = at;
    stored->big_endian = n->big_endian;
    stored->may_go_on = axes->rank > 3;
    return CVOL_OK;
}

/* Exactly all elements follow the header. */
static int check_size(const npy *n, size_t *elements)
{
    const size_t each = n->is_half ? 2 : cvol_type_size(n->type);
    const uint64_t held = n->file_size > n->data_at ? n->file_size - n->data_at : 0;
    size_t bytes;
    *elements = 1;
    int fits = n->file_size >= n->data_at;
    for (int i = 0; i < n->axes.rank && fits; i++)
        fits = n->axes.dims[i] <= SIZE_MAX &&
               cvol_size_multiply(elements, *elements, (size_t)n->axes.dims[i]);
    if (fits && cvol_size_multiply(&bytes, *elements, each) && bytes == held)
        return CVOL_OK;
    const char *shape = find_value(n, "shape");
    const size_t length = value_length(shape);
    return cvol_fail(n->context, CVOL_ERROR_FORMAT,
                     "%s: holds %llu bytes of samples, but its shape %.*s of %zu bytes each is "
                     "another number",
                     n->path, (unsigned long long)held, length < 99 ? (int)length : 99, shape,
                     each);
}

static int find_in(npy *n, cvol_grid *grid, cvol_stored *stored, const cvol_read_options *options)
{
    size_t elements;
    int code = read_header(n);
    if (!code)
        code = read_type(n);
    if (!code)
        code = read_shape(n);
    if (code)
        return code;
    *grid = cvol_grid_make(1, 1, 1, n->type);
    code = cvol_axes_choose(n->context, &n->axes, grid, n->path, options);
    if (!code && !cvol_axes_label(&stored->labels, &n->axes, n->type))
        code = cvol_fail_memory(n->context, sizeof(cvol_channel_label), n->path);
    if (!code)
        code = check_size(n, &elements);
    if (!code)
        code = cvol_grid_check_within(n->context, grid, n->path, UINT64_MAX);
    return code ? code : find_elements(n, stored, grid, elements);
}

static int find_npy(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    npy *n = calloc(1, sizeof *n);
    if (!n)
        return cvol_fail_memory(context, sizeof *n, path);
    n->context = context;
    n->path = path;
    int code = find_in(n, grid, stored, options);
    free(n);
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static int plan_npy(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                    const char *path)
{
    static const char *const types[] = {
        [CVOL_UINT8] = "|u1",  [CVOL_INT8] = "|i1",  [CVOL_UINT16] = "<u2",  [CVOL_INT16] = "<i2",
        [CVOL_UINT32] = "<u4", [CVOL_INT32] = "<i4", [CVOL_FLOAT32] = "<f4", [CVOL_FLOAT64] = "<f8",
    };
    char header[256];
    (void)context, (void)path;
    int length = snprintf(header, sizeof header,
                          "{'descr': '%s', 'fortran_order': False, 'shape': (%zu, %zu, %zu), }",
                          types[grid->type], grid->dims[2], grid->dims[1], grid->dims[0]);
    /* Samples begin at a multiple of 64. */
    const size_t size = ((size_t)length + 1 + 10 + 63) / 64 * 64 - 10;
    cvol_bytes_append(&plan->header, "\x93NUMPY\1\0", 8);
    cvol_bytes_put_u16(&plan->header, (uint16_t)size);
    cvol_bytes_put_text(&plan->header, header);
    for (size_t i = (size_t)length; i + 1 < size; i++)
        cvol_bytes_put_u8(&plan->header, ' ');
    cvol_bytes_put_u8(&plan->header, '\n');
    plan->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}

const cvol_format cvol_format_npy = {
    .name = "NumPy",
    .endings = {".npy"},
    .recognise = recognise,
    .find = find_npy,
    .plan = plan_npy,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
};
