/* OpenVDB (openvdb.org): one grid of a file, FILE.vdb:NAME, or the only one.
 *
 * Grids of floats, doubles, half floats, integers, truth values and masks are read by cvol's own
 * code: the box of active voxels, in which inactive ones have the values that the tree gives them,
 * mostly the background. Truth values become the labels 0 and 1. Voxels of OpenVDB have x, y, z in
 * the order of cvol's, and the grid's transform gives spacing, origin and directions. Vectors,
 * points, and transforms of cameras are not read. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "volume/formats/vdb/labels.h"
#include "volume/formats/vdb/tree.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"
#include "volume/io/input.h"

typedef struct vdb {
    char *name; /* for messages */
    cvol_map file;
    cvol_vdb_tree tree;
} vdb;

static void close_vdb(void *state)
{
    vdb *v = state;
    if (!v)
        return;
    cvol_vdb_tree_free(&v->tree);
    cvol_file_unmap(&v->file);
    free(v->name);
    free(v);
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    const vdb *v = state;
    const cvol_vdb_tree *tree = &v->tree;
    const int64_t z = tree->begin[2] + (int64_t)first;
    const int64_t begin[3] = {tree->begin[0], tree->begin[1], z};
    const int64_t end[3] = {tree->end[0], tree->end[1], z + (int64_t)count};
    return cvol_vdb_tree_fill(context, tree, out, begin, end, v->name);
}

static int set_geometry(cvol_context *context, cvol_grid *grid, const cvol_vdb_head *head,
                        const cvol_vdb_tree *tree, const char *name)
{
    for (int a = 0; a < 3; a++)
        if (!cvol_geometry_set_axis(grid, a, head->steps[a]))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: the transform of its grid has steps of length 0 or infinity",
                             name);
    for (int i = 0; i < 3; i++) {
        grid->origin[i] = head->steps[3][i];
        for (int a = 0; a < 3; a++)
            grid->origin[i] += head->steps[a][i] * (double)tree->begin[a];
    }
    return cvol_geometry_check(context, grid, name);
}

/* A grid may share the tree of another one. */
static int read_tree(cvol_context *context, vdb *v, const cvol_vdb_list *list,
                     const cvol_vdb_entry *entry, const cvol_vdb_head *head)
{
    const cvol_vdb_entry *parent = entry;
    cvol_vdb_head of_parent = *head;
    int code = CVOL_OK;
    if (entry->parent[0]) {
        code = cvol_vdb_list_choose(context, &parent, list, entry->parent, v->name);
        if (!code)
            code = cvol_vdb_head_read(context, &of_parent, parent, v->file.data, v->file.size,
                                      v->name);
    }
    return code ? code
                : cvol_vdb_tree_read(context, &v->tree, parent, &of_parent, v->file.data,
                                     v->file.size, v->name);
}

static int read_grid(cvol_context *context, vdb *v, cvol_grid *grid, cvol_stored *stored,
                     const char *inside)
{
    cvol_vdb_list list;
    cvol_vdb_head head;
    const cvol_vdb_entry *entry = NULL;
    int code = cvol_vdb_list_read(context, &list, v->file.data, v->file.size, v->name);
    if (!code)
        code = cvol_vdb_list_choose(context, &entry, &list, inside, v->name);
    if (!code)
        code = cvol_vdb_head_read(context, &head, entry, v->file.data, v->file.size, v->name);
    if (!code)
        code = read_tree(context, v, &list, entry, &head);
    free(list.entries);
    if (code)
        return code;
    const cvol_vdb_tree *tree = &v->tree;
    *grid = cvol_grid_make((size_t)(tree->end[0] - tree->begin[0]),
                           (size_t)(tree->end[1] - tree->begin[1]),
                           (size_t)(tree->end[2] - tree->begin[2]), tree->source.type->sample);
    if (!strcmp(tree->source.type->name, "int64"))
        stored->wide = CVOL_WIDE_INT64;
    return set_geometry(context, grid, &head, tree, v->name);
}

static int find_vdb(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                    const cvol_read_options *options)
{
    (void)options;
    vdb *v = calloc(1, sizeof *v);
    if (!v)
        return cvol_fail_memory(context, sizeof *v, path);
    stored->slices = (cvol_slices){.state = v, .read = read_slices, .close = close_vdb};
    const size_t length = cvol_input_file_length(path);
    const char *inside = path[length] ? path + length + 1 : NULL;
    char *file = strndup(path, length);
    v->name = strdup(path);
    int code = file && v->name ? CVOL_OK : cvol_fail_memory(context, length, path);
    if (!code)
        code = cvol_file_copy(context, &v->file, file);
    free(file);
    return code ? code : read_grid(context, v, grid, stored, inside);
}

int cvol_vdb_find_label_mark(cvol_context *context, int *out, cvol_type type, const char *path)
{
    uint8_t head[CVOL_FORMAT_HEAD_BYTES];
    size_t size;
    *out = 0;
    if (type != CVOL_UINT8) /* only truth values and masks become bytes */
        return CVOL_OK;
    char *file = strndup(path, cvol_input_file_length(path));
    if (!file)
        return cvol_fail_memory(context, strlen(path), path);
    *out = !cvol_file_peek(context, head, &size, sizeof head, file) &&
           cvol_vdb_recognise(head, size);
    free(file);
    return CVOL_OK;
}

const cvol_format cvol_format_vdb = {
    .name = "OpenVDB",
    .endings = {".vdb"},
    .recognise = cvol_vdb_recognise,
    .find = find_vdb,
    .takes_name = 1,
};
