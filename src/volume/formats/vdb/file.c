/* Files of OpenVDB: the list of grids, and a grid's header.
 *
 * A file begins with a signature, its version (222 to 224 are read, those of OpenVDB 3 and later),
 * the version of the library, whether the list has the places of grids, an identifier, and
 * metadata. The list of grids follows; each entry states where the grid begins and where the next
 * entry does. A grid begins with its compression, metadata and transform. All numbers are
 * little-endian. */
#include "volume/formats/vdb/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/wide.h"

#define UUID_BYTES 36
#define OLDEST_VERSION 222
#define NEWEST_VERSION 224
#define HALF_SUFFIX "_HalfFloat"

static const cvol_vdb_type types[] = {
    {"float", CVOL_FLOAT32, 4}, {"double", CVOL_FLOAT64, 8},  {"half", CVOL_FLOAT32, 2},
    {"int32", CVOL_INT32, 4},   {"int64", CVOL_WIDE_TYPE, 8}, {"bool", CVOL_UINT8, 1},
    {"mask", CVOL_UINT8, 1},
};

#define TYPES (sizeof types / sizeof *types)

int cvol_vdb_recognise(const uint8_t *head, size_t size)
{
    return size >= 8 && !memcmp(head, " BDV\0\0\0\0", 8);
}

static int fail_cut(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off or damaged in %s", name, what);
}

/* ---- texts and metadata --------------------------------------------------------------- */

typedef struct text {
    const uint8_t *data;
    size_t size;
} text;

static text read_text(cvol_cursor *cursor)
{
    const uint32_t size = cvol_cursor_u32(cursor);
    text result = {cvol_cursor_take(cursor, size), size};
    if (!result.data)
        result.size = 0;
    return result;
}

static int equals(text t, const char *word)
{
    return t.size == strlen(word) && !memcmp(t.data, word, t.size);
}

/* A name that occurs several times ends with the byte 0x1e and a number, which becomes "[1]". */
static void copy_text(char *out, size_t room, text from)
{
    size_t at = 0;
    int is_numbered = 0;
    for (size_t i = 0; i < from.size && at + 2 < room; i++) {
        const uint8_t c = from.data[i];
        const int begins_number = c == 0x1e && !is_numbered;
        is_numbered = is_numbered || begins_number;
        out[at++] = begins_number ? '[' : c < ' ' || c == 0x7f ? '?' : (char)c;
    }
    if (is_numbered)
        out[at++] = ']';
    out[at] = '\0';
}

static void skip_metadata(cvol_cursor *cursor)
{
    const uint32_t count = cvol_cursor_u32(cursor);
    for (uint32_t i = 0; i < count && !cursor->failed; i++) {
        read_text(cursor); /* its name, */
        read_text(cursor); /* type */
        read_text(cursor); /* and value */
    }
}

/* ---- the list ------------------------------------------------------------------------- */

/* The type of "Tree_float_5_4_3": other shapes of trees are not in use. */
static const cvol_vdb_type *type_of(const char *tree)
{
    char name[64];
    for (size_t i = 0; i < TYPES; i++) {
        snprintf(name, sizeof name, "Tree_%s_5_4_3", types[i].name);
        if (!strcmp(name, tree))
            return &types[i];
    }
    return NULL;
}

static int read_entry(cvol_context *context, cvol_vdb_entry *entry, cvol_cursor *cursor,
                      const char *name)
{
    const text own = read_text(cursor);
    text tree = read_text(cursor);
    const text parent = read_text(cursor);
    const size_t suffix = strlen(HALF_SUFFIX);
    *entry = (cvol_vdb_entry){.offset = cvol_cursor_u64(cursor)};
    cvol_cursor_u64(cursor); /* the place of its values */
    const uint64_t end = cvol_cursor_u64(cursor);
    if (cursor->failed || end < cursor->at || end > cursor->size || entry->offset < cursor->at ||
        entry->offset > end)
        return fail_cut(context, name, "its list of grids");
    cursor->at = (size_t)end;
    entry->is_half = tree.size > suffix &&
                     !memcmp(tree.data + tree.size - suffix, HALF_SUFFIX, suffix);
    if (entry->is_half)
        tree.size -= suffix;
    copy_text(entry->name, sizeof entry->name, own);
    copy_text(entry->tree, sizeof entry->tree, tree);
    copy_text(entry->parent, sizeof entry->parent, parent);
    entry->type = type_of(entry->tree);
    return CVOL_OK;
}

static int add_entry(cvol_context *context, cvol_vdb_list *list, const cvol_vdb_entry *entry,
                     const char *name)
{
    if (!(list->count & (list->count - 1))) { /* room for the next power of two */
        const size_t room = list->count ? 2 * list->count : 1;
        cvol_vdb_entry *entries = realloc(list->entries, room * sizeof *entries);
        if (!entries)
            return cvol_fail_memory(context, room * sizeof *entries, name);
        list->entries = entries;
    }
    list->entries[list->count++] = *entry;
    return CVOL_OK;
}

int cvol_vdb_list_read(cvol_context *context, cvol_vdb_list *list, const uint8_t *data, size_t size,
                       const char *name)
{
    cvol_cursor cursor = cvol_cursor_make(data, size);
    *list = (cvol_vdb_list){0};
    cvol_cursor_u64(&cursor); /* the signature */
    const uint32_t version = cvol_cursor_u32(&cursor);
    if (!cursor.failed && (version < OLDEST_VERSION || version > NEWEST_VERSION))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is a file of OpenVDB of version %u; %d to %d can be read", name,
                         version, OLDEST_VERSION, NEWEST_VERSION);
    cvol_cursor_u64(&cursor); /* the library's version */
    const int has_places = cvol_cursor_u8(&cursor) != 0;
    cvol_cursor_take(&cursor, UUID_BYTES);
    skip_metadata(&cursor);
    const uint32_t count = cvol_cursor_u32(&cursor);
    if (cursor.failed)
        return fail_cut(context, name, "its header");
    if (!has_places)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: was written as a stream of OpenVDB, without the places of its grids: "
                         "write it as a file",
                         name);
    int code = CVOL_OK;
    for (uint32_t i = 0; i < count && !code; i++) {
        cvol_vdb_entry entry;
        code = read_entry(context, &entry, &cursor, name);
        if (!code)
            code = add_entry(context, list, &entry, name);
    }
    return code;
}

/* ---- choosing ------------------------------------------------------------------------- */

/* "density, temperature"; up to eight. */
static void list_names(char *out, size_t room, const cvol_vdb_list *list, int readable)
{
    size_t shown = 0;
    out[0] = '\0';
    for (size_t i = 0; i < list->count; i++) {
        if (readable && !list->entries[i].type)
            continue;
        const size_t at = strlen(out);
        if (shown++ == 8) {
            snprintf(out + at, room - at, ", ...");
            return;
        }
        snprintf(out + at, room - at, "%s%.60s", at ? ", " : "", list->entries[i].name);
    }
}

static const cvol_vdb_entry *find_named(const cvol_vdb_list *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++)
        if (!strcmp(list->entries[i].name, name))
            return &list->entries[i];
    return NULL;
}

static int choose_only(cvol_context *context, const cvol_vdb_entry **out, const cvol_vdb_list *list,
                       const char *name)
{
    char names[600];
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++)
        if (list->entries[i].type) {
            *out = &list->entries[i];
            count++;
        }
    if (count == 1)
        return CVOL_OK;
    list_names(names, sizeof names, list, count > 1);
    if (count)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: has %zu grids: name one behind a colon, of %s", name, count, names);
    if (list->count)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: has no grid of numbers that can be read; its first one, %.60s, is of "
                         "type %s",
                         name, list->entries[0].name, list->entries[0].tree);
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no grids", name);
}

int cvol_vdb_list_choose(cvol_context *context, const cvol_vdb_entry **out,
                         const cvol_vdb_list *list, const char *inside, const char *name)
{
    char names[600];
    if (!inside)
        return choose_only(context, out, list, name);
    *out = find_named(list, inside);
    list_names(names, sizeof names, list, 0);
    if (!*out)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no such grid; it has %s", name,
                         names[0] ? names : "none");
    if (!(*out)->type)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: its grid is of type %s, which is not read (float, double, half, "
                         "int32, int64, bool and mask are)",
                         name, (*out)->tree);
    return CVOL_OK;
}

/* ---- a grid's header ------------------------------------------------------------------ */

static void read_vector(double out[3], cvol_cursor *cursor)
{
    for (int i = 0; i < 3; i++)
        out[i] = cvol_cursor_f64(cursor);
}

/* Four rows of four; voxels are row vectors. */
static int read_matrix(double steps[4][3], cvol_cursor *cursor)
{
    int is_affine = 1;
    for (int a = 0; a < 4; a++) {
        read_vector(steps[a], cursor);
        const double last = cvol_cursor_f64(cursor), affine = a == 3;
        is_affine = is_affine && !(last < affine) && !(last > affine);
    }
    return is_affine;
}

/* 0: the transform is of no known kind. */
static int read_transform(double steps[4][3], cvol_cursor *cursor)
{
    double scale[3] = {1, 1, 1}, unused[3];
    const text kind = read_text(cursor);
    const int is_scale = equals(kind, "ScaleMap") || equals(kind, "UniformScaleMap");
    const int is_both = equals(kind, "ScaleTranslateMap") ||
                        equals(kind, "UniformScaleTranslateMap");
    if (equals(kind, "AffineMap") || equals(kind, "UnitaryMap"))
        return read_matrix(steps, cursor);
    if (!is_scale && !is_both && !equals(kind, "TranslationMap"))
        return 0;
    memset(steps, 0, 4 * sizeof *steps);
    if (!is_scale)
        read_vector(steps[3], cursor);
    if (is_scale || is_both) {
        read_vector(scale, cursor);
        for (int i = 0; i < 4; i++) /* numbers that follow from the scale */
            read_vector(unused, cursor);
    }
    for (int a = 0; a < 3; a++)
        steps[a][a] = scale[a];
    return 1;
}

int cvol_vdb_head_read(cvol_context *context, cvol_vdb_head *head, const cvol_vdb_entry *entry,
                       const uint8_t *data, size_t size, const char *name)
{
    cvol_cursor cursor = cvol_cursor_make(data, size);
    cursor.at = (size_t)entry->offset;
    head->compression = cvol_cursor_u32(&cursor);
    skip_metadata(&cursor);
    const int is_known = read_transform(head->steps, &cursor);
    head->tree = cursor.at;
    if (cursor.failed)
        return fail_cut(context, name, "the header of its grid");
    if (!is_known)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: the transform of its grid is not affine", name);
    return CVOL_OK;
}
