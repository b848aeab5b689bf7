/* The file is a header of 128 bytes and elements: a tag of a type and a number of bytes, and the
 * bytes. A variable is an element of parts, which are elements themselves: flags, lengths of axes,
 * name, real parts and imaginary parts. It may be packed as a whole. */
#define _GNU_SOURCE
#include "volume/formats/matlab/variables.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/bytes.h"
#include "base/context.h"
#include "volume/io/inflate.h"
#include "volume/io/input.h"

enum { HEADER_BYTES = 128, ENDING_AT = 126, TAG_BYTES = 8 };
/* More than tags, flags, axes and name take. */
enum { HEAD_BYTES = 512 };
/* Types of elements, and the first and last class of arrays of numbers (double, uint64). */
enum { TYPE_INT8 = 1, TYPE_INT32 = 5, TYPE_UINT32 = 6, TYPE_MATRIX = 14, TYPE_COMPRESSED = 15 };
enum { CLASS_FIRST = 6, CLASS_LAST = 15, FLAG_COMPLEX = 0x800 };

static const struct {
    int number;
    cvol_type type;
    cvol_wide wide;
} types[] = {
    {1, CVOL_INT8, CVOL_WIDE_NONE},        {2, CVOL_UINT8, CVOL_WIDE_NONE},
    {3, CVOL_INT16, CVOL_WIDE_NONE},       {4, CVOL_UINT16, CVOL_WIDE_NONE},
    {5, CVOL_INT32, CVOL_WIDE_NONE},       {6, CVOL_UINT32, CVOL_WIDE_NONE},
    {7, CVOL_FLOAT32, CVOL_WIDE_NONE},     {9, CVOL_FLOAT64, CVOL_WIDE_NONE},
    {12, CVOL_WIDE_TYPE, CVOL_WIDE_INT64}, {13, CVOL_WIDE_TYPE, CVOL_WIDE_UINT64},
};

int cvol_matlab_recognise(const uint8_t *head, size_t size)
{
    return size >= HEADER_BYTES && !memcmp(head, "MATLAB 5.0", 10) &&
           (!memcmp(head + ENDING_AT, "IM", 2) || !memcmp(head + ENDING_AT, "MI", 2));
}

/* ---- elements ------------------------------------------------------------------------- */

static uint32_t read_word(cvol_cursor *cursor, int big_endian)
{
    const uint8_t *bytes = cvol_cursor_take(cursor, 4);
    if (!bytes)
        return 0;
    return big_endian ? cvol_high_first(bytes)
                      : bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                            (uint32_t)bytes[3] << 24;
}

typedef struct element {
    uint32_t type, bytes;
    size_t at;
    size_t room; /* of the bytes, with padding */
} element;

/* Reads a tag. Up to four bytes share the second half of the tag. */
static element read_tag(cvol_cursor *cursor, int big_endian)
{
    element e = {.type = read_word(cursor, big_endian)};
    if (e.type >> 16) {
        e.bytes = e.type >> 16;
        e.type &= 0xffff;
        e.room = 4;
        cursor->failed |= e.bytes > 4;
    } else {
        e.bytes = read_word(cursor, big_endian);
        e.room = ((size_t)e.bytes + 7) / 8 * 8;
    }
    e.at = cursor->at;
    return e;
}

/* ---- variables ------------------------------------------------------------------------ */

/* Axes of length 1 at the end, which MATLAB leaves out too, are no axes. 0: the array has no
 * elements, or too many axes. */
static int read_axes(cvol_matlab_variable *v, cvol_cursor *cursor, int big_endian)
{
    const element e = read_tag(cursor, big_endian);
    const uint32_t rank = e.bytes / 4;
    cvol_cursor words = cvol_cursor_make(cvol_cursor_take(cursor, e.room), e.room);
    if (e.type != TYPE_INT32 || rank < 2 || rank > CVOL_AXES_MAX || cursor->failed)
        return 0;
    for (uint32_t i = 0; i < rank; i++) {
        v->dims[i] = read_word(&words, big_endian);
        if (!v->dims[i] || v->dims[i] > INT32_MAX)
            return 0;
        v->rank = v->dims[i] > 1 || i < 2 ? (int)i + 1 : v->rank;
    }
    return 1;
}

static int read_name(cvol_matlab_variable *v, cvol_cursor *cursor, int big_endian)
{
    const element e = read_tag(cursor, big_endian);
    const uint8_t *text = cvol_cursor_take(cursor, e.room);
    if (e.type != TYPE_INT8 || !e.bytes || e.bytes >= sizeof v->name || !text)
        return 0;
    for (uint32_t i = 0; i < e.bytes; i++)
        v->name[i] = text[i] < ' ' || text[i] > '~' ? '?' : (char)text[i];
    return 1;
}

static void read_type(cvol_matlab_variable *v, uint32_t number)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].number == (int)number) {
            v->is_known = 1;
            v->type = types[i].type;
            v->wide = types[i].wide;
        }
}

/* Reads a variable from its first bytes, which begin with its tag; v->at is then the place of its
 * numbers in them. 0: it is no array of numbers. */
static int read_variable(cvol_matlab_variable *v, const uint8_t *head, size_t size, int big_endian)
{
    cvol_cursor cursor = cvol_cursor_make(head, size);
    const element whole = read_tag(&cursor, big_endian), flags = read_tag(&cursor, big_endian);
    if (whole.type != TYPE_MATRIX || flags.type != TYPE_UINT32 || flags.bytes != 8)
        return 0;
    const uint32_t flag = read_word(&cursor, big_endian), class = flag & 0xff;
    read_word(&cursor, big_endian);
    v->is_complex = (flag & FLAG_COMPLEX) != 0;
    if (class < CLASS_FIRST || class > CLASS_LAST || !read_axes(v, &cursor, big_endian) ||
        !read_name(v, &cursor, big_endian))
        return 0;
    const element real = read_tag(&cursor, big_endian);
    read_type(v, real.type);
    v->at = real.at;
    v->real_bytes = real.bytes;
    return !cursor.failed;
}

/* The first bytes of an element at `offset` of the file: of `bytes` that are packed, or of all. */
static int read_head(cvol_context *context, uint8_t head[HEAD_BYTES], size_t *got,
                     const cvol_input *input, int is_packed, uint64_t offset, uint64_t bytes)
{
    cvol_inflater *inflater = NULL;
    uint64_t unpacked = 0;
    if (!is_packed)
        return cvol_input_read(context, input, offset, head, HEAD_BYTES, got);
    int code = cvol_inflater_open(context, &inflater, input, offset, bytes);
    if (!code)
        code = cvol_inflater_read(context, inflater, head, HEAD_BYTES, &unpacked);
    cvol_inflater_close(inflater);
    *got = (size_t)unpacked;
    return code;
}

static int add(cvol_context *context, cvol_matlab_list *list, const cvol_matlab_variable *variable,
               const char *name)
{
    if (!(list->count & (list->count - 1))) { /* full: 0 or a power of two */
        const size_t room = list->count ? 2 * list->count : 1;
        cvol_matlab_variable *more = realloc(list->variables, room * sizeof *more);
        if (!more)
            return cvol_fail_memory(context, room * sizeof *more, name);
        list->variables = more;
    }
    list->variables[list->count++] = *variable;
    return CVOL_OK;
}

/* Reads the element at *offset, adds it if it is an array of numbers, and goes to the next. */
static int list_element(cvol_context *context, cvol_matlab_list *list, const cvol_input *input,
                        uint64_t *offset, const char *name)
{
    uint8_t head[HEAD_BYTES];
    size_t got = 0;
    cvol_matlab_variable v = {.rank = 0};
    int code = cvol_input_read(context, input, *offset, head, TAG_BYTES, &got);
    cvol_cursor cursor = cvol_cursor_make(head, got);
    const element e = read_tag(&cursor, list->big_endian);
    const uint64_t begin = *offset + TAG_BYTES;
    if (!code && (cursor.failed || e.room == 4 || e.bytes > input->size - begin))
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: is cut off or damaged in the variable at byte %llu", name,
                         (unsigned long long)*offset);
    v.is_packed = e.type == TYPE_COMPRESSED;
    if (!code && (v.is_packed || e.type == TYPE_MATRIX)) {
        code = read_head(context, head, &got, input, v.is_packed, v.is_packed ? begin : *offset,
                         e.bytes);
        if (!code && read_variable(&v, head, got, list->big_endian)) {
            v.offset = begin;
            v.size = e.bytes;
            v.at += v.is_packed ? 0 : *offset;
            code = add(context, list, &v, name);
        }
    }
    *offset = begin + (v.is_packed ? e.bytes : e.room);
    return code;
}

int cvol_matlab_list_read(cvol_context *context, cvol_matlab_list *list, const char *path,
                          const char *name)
{
    cvol_input input;
    uint8_t head[HEADER_BYTES];
    size_t got = 0;
    *list = (cvol_matlab_list){0};
    int code = cvol_input_open(context, &input, path);
    if (!code)
        code = cvol_input_read(context, &input, 0, head, sizeof head, &got);
    if (!code && !cvol_matlab_recognise(head, got))
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: does not begin as a file of MATLAB 5",
                         name);
    if (!code)
        list->big_endian = head[ENDING_AT] == 'M';
    for (uint64_t offset = HEADER_BYTES; !code && offset < input.size;)
        code = list_element(context, list, &input, &offset, name);
    cvol_input_close(&input);
    return code;
}

/* ---- choosing ------------------------------------------------------------------------- */

/* "a, b"; up to eight of at least so many axes. */
static void list_names(char *out, size_t room, const cvol_matlab_list *list, int rank)
{
    size_t shown = 0;
    out[0] = '\0';
    for (size_t i = 0; i < list->count; i++) {
        const size_t at = strlen(out);
        if (list->variables[i].rank < rank)
            continue;
        if (shown++ == 8) {
            snprintf(out + at, room - at, ", ...");
            return;
        }
        snprintf(out + at, room - at, "%s%s", at ? ", " : "", list->variables[i].name);
    }
}

static int find(cvol_context *context, const cvol_matlab_variable **out,
                const cvol_matlab_list *list, const char *inside, const char *name)
{
    char names[8 * CVOL_MATLAB_NAME_BYTES + 32];
    size_t count = 0;
    *out = NULL;
    for (size_t i = 0; i < list->count; i++)
        if (inside ? !strcmp(list->variables[i].name, inside) : list->variables[i].rank > 2) {
            *out = &list->variables[i];
            count++;
        }
    list_names(names, sizeof names, list, inside ? 0 : 3);
    if (count == 1 || (count && inside)) /* of several with one name the last counts */
        return CVOL_OK;
    if (inside)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no such array of numbers; it has %s",
                         name, names[0] ? names : "none");
    if (count)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: has %zu arrays of three axes or more: name one behind a colon, of "
                         "%s",
                         name, count, names);
    list_names(names, sizeof names, list, 0);
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: has no array of numbers of three axes or more; it has %s", name,
                     names[0] ? names : "none");
}

int cvol_matlab_list_choose(cvol_context *context, const cvol_matlab_variable **out,
                            const cvol_matlab_list *list, const char *inside, const char *name)
{
    const int code = find(context, out, list, inside, name);
    if (code)
        return code;
    if ((*out)->is_complex)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: its array %s has complex numbers, which are not read: save its "
                         "magnitude",
                         name, (*out)->name);
    if (!(*out)->is_known)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its array %s has numbers of an unknown type", name, (*out)->name);
    return CVOL_OK;
}
