/* Trees of OpenVDB.
 *
 * The file has the topology first: the root's background, tiles and nodes; of each node the masks,
 * its values, and its nodes; of each leaf the mask of active voxels. The values of all leaves
 * follow in the same order. Sizes are not stated, so that all must be walked through to find a
 * place. */
#include "volume/formats/vdb/tree.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/formats/vdb/values.h"

#define ROOT_LOG2 12 /* of the edge of the root's nodes and tiles */

/* Edges of nodes of a level, and of their children, as powers of two. */
static const int node_log2[3] = {3, 7, 12}, child_log2[3] = {0, 3, 7};

static size_t values_of(int level)
{
    return (size_t)1 << 3 * (node_log2[level] - child_log2[level]);
}

static int fail_cut(cvol_context *context, const char *name)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: is cut off or damaged in the tree of its grid", name);
}

/* The first voxel of child i of a node; z runs fastest. */
static void child_origin(int64_t out[3], const cvol_vdb_node *node, size_t i)
{
    const int step = child_log2[node->level], bits = node_log2[node->level] - step;
    const size_t mask = ((size_t)1 << bits) - 1;
    for (int a = 0; a < 3; a++)
        out[a] = node->origin[a] + (int64_t)((i >> (2 - a) * bits & mask) << step);
}

/* ---- finding nodes -------------------------------------------------------------------- */

typedef struct finder {
    cvol_cursor cursor;
    cvol_vdb_tree *tree;
    int lacks_memory;
} finder;

/* The new node; NULL without memory. */
static cvol_vdb_node *add_node(finder *f)
{
    cvol_vdb_tree *tree = f->tree;
    if (!(tree->node_count & (tree->node_count - 1))) { /* room for the next power of two */
        const size_t room = tree->node_count ? 2 * tree->node_count : 1;
        cvol_vdb_node *nodes = realloc(tree->nodes, room * sizeof *nodes);
        if (!nodes) {
            f->lacks_memory = 1;
            return NULL;
        }
        tree->nodes = nodes;
    }
    return &tree->nodes[tree->node_count++];
}

static void find_node(finder *f, const int64_t origin[3], int level)
{
    cvol_vdb_node *added = add_node(f);
    if (!added)
        return;
    for (int a = 0; a < 3; a++)
        added->origin[a] = (int32_t)origin[a];
    added->level = level;
    added->masks = f->cursor.at;
    const cvol_vdb_node node = *added; /* the list may move */
    const size_t count = values_of(level), mask_bytes = count / 8;
    const uint8_t *children = cvol_cursor_take(&f->cursor, mask_bytes);
    if (level == 0 || !children)
        return;
    const uint8_t *active = cvol_cursor_take(&f->cursor, mask_bytes);
    added->values = f->cursor.at;
    if (active)
        cvol_vdb_values_skip(&f->cursor, &f->tree->source, count, active);
    for (size_t i = 0; i < count && !f->cursor.failed && !f->lacks_memory; i++)
        if (cvol_vdb_is_set(children, i)) {
            int64_t place[3];
            child_origin(place, &node, i);
            find_node(f, place, level - 1);
        }
}

static void read_origin(int32_t origin[3], cvol_cursor *cursor)
{
    for (int a = 0; a < 3; a++) {
        origin[a] = (int32_t)cvol_cursor_u32(cursor);
        if (origin[a] & ((1 << ROOT_LOG2) - 1))
            cursor->failed = 1;
    }
}

static void read_sample(uint8_t sample[8], cvol_cursor *cursor, const cvol_vdb_type *type)
{
    const uint8_t *value = cvol_cursor_take(cursor, type->bytes);
    if (value)
        cvol_vdb_to_samples(sample, value, 1, type, 0);
}

static void find_tiles(finder *f, uint32_t count)
{
    cvol_vdb_tree *tree = f->tree;
    const size_t each = 3 * sizeof(int32_t) + tree->source.type->bytes + 1;
    if (count > cvol_cursor_left(&f->cursor) / each) {
        f->cursor.failed = 1;
        return;
    }
    tree->tiles = calloc(count ? count : 1, sizeof *tree->tiles);
    f->lacks_memory = !tree->tiles;
    for (uint32_t i = 0; i < count && tree->tiles; i++) {
        cvol_vdb_tile *tile = &tree->tiles[tree->tile_count++];
        read_origin(tile->origin, &f->cursor);
        read_sample(tile->sample, &f->cursor, tree->source.type);
        tile->is_active = cvol_cursor_u8(&f->cursor) != 0;
    }
}

static void find_topology(finder *f)
{
    cvol_cursor_u32(&f->cursor); /* the number of buffers, which is 1 */
    read_sample(f->tree->source.background, &f->cursor, f->tree->source.type);
    const uint32_t tiles = cvol_cursor_u32(&f->cursor), nodes = cvol_cursor_u32(&f->cursor);
    find_tiles(f, tiles);
    for (uint32_t i = 0; i < nodes && !f->cursor.failed && !f->lacks_memory; i++) {
        int32_t origin[3];
        read_origin(origin, &f->cursor);
        if (!f->cursor.failed)
            find_node(f, (int64_t[]){origin[0], origin[1], origin[2]}, 2);
    }
}

/* Leaves of truth values have their origin once more, and values are a mask; those of the type
 * `mask` have only that of active voxels. */
static void find_leaf(finder *f, cvol_vdb_node *leaf)
{
    const size_t count = values_of(0);
    const char *type = f->tree->source.type->name;
    leaf->masks = f->cursor.at;
    const uint8_t *active = cvol_cursor_take(&f->cursor, count / 8);
    const int is_mask = !strcmp(type, "mask"), is_bool = !strcmp(type, "bool");
    if (is_mask || is_bool)
        cvol_cursor_take(&f->cursor, 3 * sizeof(int32_t));
    leaf->values = is_mask ? leaf->masks : f->cursor.at;
    if (is_bool)
        cvol_cursor_take(&f->cursor, count / 8);
    else if (active && !is_mask)
        cvol_vdb_values_skip(&f->cursor, &f->tree->source, count, active);
}

static int compare_origins(const void *a, const void *b)
{
    const int32_t *p = a, *q = b;
    for (int i = 0; i < 3; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

/* 1 if two nodes or tiles of the root have the same place: each is written once when samples are
 * read, so that the time does not grow beyond that of the box. */
static int has_repeated_places(const cvol_vdb_tree *tree, int *lacks_memory)
{
    size_t count = 0;
    int repeated = 0;
    int32_t(*places)[3] = malloc((tree->tile_count + tree->node_count + 1) * sizeof *places);
    *lacks_memory = !places;
    if (!places)
        return 0;
    for (size_t i = 0; i < tree->tile_count; i++)
        memcpy(places[count++], tree->tiles[i].origin, sizeof *places);
    for (size_t i = 0; i < tree->node_count; i++)
        if (tree->nodes[i].level == 2)
            memcpy(places[count++], tree->nodes[i].origin, sizeof *places);
    qsort(places, count, sizeof *places, compare_origins);
    for (size_t i = 1; i < count; i++)
        repeated = repeated || !compare_origins(places[i - 1], places[i]);
    free(places);
    return repeated;
}

/* ---- the box of active voxels --------------------------------------------------------- */

static void include_box(cvol_vdb_tree *tree, const int64_t begin[3], const int64_t end[3])
{
    const int is_first = tree->begin[0] >= tree->end[0];
    for (int a = 0; a < 3; a++) {
        if (is_first || begin[a] < tree->begin[a])
            tree->begin[a] = begin[a];
        if (is_first || end[a] > tree->end[a])
            tree->end[a] = end[a];
    }
}

static void include_cube(cvol_vdb_tree *tree, const int64_t begin[3], int log2)
{
    const int64_t size = (int64_t)1 << log2;
    include_box(tree, begin, (int64_t[]){begin[0] + size, begin[1] + size, begin[2] + size});
}

/* Active tiles of a node, or active voxels of a leaf. */
static void include_node(cvol_vdb_tree *tree, const cvol_vdb_node *node)
{
    const size_t count = values_of(node->level);
    const uint8_t *masks = tree->source.data + node->masks;
    const uint8_t *active = node->level ? masks + count / 8 : masks;
    for (size_t i = 0; i < count; i++)
        if (cvol_vdb_is_set(active, i) && !(node->level && cvol_vdb_is_set(masks, i))) {
            int64_t begin[3];
            child_origin(begin, node, i);
            include_cube(tree, begin, child_log2[node->level]);
        }
}

static void find_box(cvol_vdb_tree *tree)
{
    for (size_t i = 0; i < tree->tile_count; i++)
        if (tree->tiles[i].is_active) {
            const int32_t *origin = tree->tiles[i].origin;
            include_cube(tree, (int64_t[]){origin[0], origin[1], origin[2]}, ROOT_LOG2);
        }
    for (size_t i = 0; i < tree->node_count; i++)
        include_node(tree, &tree->nodes[i]);
}

int cvol_vdb_tree_read(cvol_context *context, cvol_vdb_tree *tree, const cvol_vdb_entry *entry,
                       const cvol_vdb_head *head, const uint8_t *data, size_t size,
                       const char *name)
{
    finder f = {.cursor = cvol_cursor_make(data, size), .tree = tree};
    *tree = (cvol_vdb_tree){.source = {.data = data,
                                       .size = size,
                                       .type = entry->type,
                                       .is_half = entry->is_half,
                                       .compression = head->compression}};
    f.cursor.at = head->tree;
    find_topology(&f);
    for (size_t i = 0; i < tree->node_count && !f.cursor.failed && !f.lacks_memory; i++)
        if (tree->nodes[i].level == 0)
            find_leaf(&f, &tree->nodes[i]);
    const int repeated = !f.lacks_memory && has_repeated_places(tree, &f.lacks_memory);
    if (f.lacks_memory)
        return cvol_fail_memory(context, tree->node_count * sizeof *tree->nodes, name);
    if (f.cursor.failed || repeated)
        return fail_cut(context, name);
    find_box(tree);
    if (tree->begin[0] >= tree->end[0])
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its grid has no active voxels", name);
    return CVOL_OK;
}

void cvol_vdb_tree_free(cvol_vdb_tree *tree)
{
    free(tree->nodes);
    free(tree->tiles);
}

/* ---- samples -------------------------------------------------------------------------- */

/* The box that is filled. */
typedef struct target {
    uint8_t *out;
    size_t bytes; /* of a sample */
    int64_t begin[3], end[3];
} target;

/* The part of a cube in the box; 0 if there is none. */
static int clip(int64_t from[3], int64_t to[3], const target *t, const int64_t begin[3], int log2)
{
    for (int a = 0; a < 3; a++) {
        const int64_t end = begin[a] + ((int64_t)1 << log2);
        from[a] = begin[a] > t->begin[a] ? begin[a] : t->begin[a];
        to[a] = end < t->end[a] ? end : t->end[a];
        if (from[a] >= to[a])
            return 0;
    }
    return 1;
}

static uint8_t *row_at(const target *t, int64_t x, int64_t y, int64_t z)
{
    const int64_t nx = t->end[0] - t->begin[0], ny = t->end[1] - t->begin[1];
    return t->out +
           t->bytes * (size_t)(x - t->begin[0] + nx * (y - t->begin[1] + ny * (z - t->begin[2])));
}

static void fill_cube(const target *t, const int64_t begin[3], int log2, const uint8_t *sample)
{
    int64_t from[3], to[3];
    if (!clip(from, to, t, begin, log2))
        return;
    for (int64_t z = from[2]; z < to[2]; z++)
        for (int64_t y = from[1]; y < to[1]; y++) {
            uint8_t *row = row_at(t, from[0], y, z);
            for (int64_t x = from[0]; x < to[0]; x++, row += t->bytes)
                memcpy(row, sample, t->bytes);
        }
}

static void copy_leaf(const target *t, const int64_t begin[3], const uint8_t *samples)
{
    int64_t from[3], to[3];
    if (!clip(from, to, t, begin, node_log2[0]))
        return;
    for (int64_t z = from[2]; z < to[2]; z++)
        for (int64_t y = from[1]; y < to[1]; y++) {
            uint8_t *row = row_at(t, from[0], y, z);
            for (int64_t x = from[0]; x < to[0]; x++, row += t->bytes) {
                const int64_t i = (x - begin[0]) << 6 | (y - begin[1]) << 3 | (z - begin[2]);
                memcpy(row, samples + (size_t)i * t->bytes, t->bytes);
            }
        }
}

static int read_node(cvol_context *context, uint8_t *samples, uint8_t *room,
                     const cvol_vdb_tree *tree, const cvol_vdb_node *node, const char *name)
{
    const size_t count = values_of(node->level);
    const uint8_t *masks = tree->source.data + node->masks;
    if (node->level)
        return cvol_vdb_values_read(context, samples, room, &tree->source, node->values, count,
                                    masks + count / 8, name);
    if (tree->source.type->sample != CVOL_UINT8)
        return cvol_vdb_values_read(context, samples, room, &tree->source, node->values, count,
                                    masks, name);
    for (size_t i = 0; i < count; i++)
        samples[i] = (uint8_t)cvol_vdb_is_set(tree->source.data + node->values, i);
    return CVOL_OK;
}

static int fill_node(cvol_context *context, const target *t, uint8_t *samples, uint8_t *room,
                     const cvol_vdb_tree *tree, const cvol_vdb_node *node, const char *name)
{
    const int64_t origin[3] = {node->origin[0], node->origin[1], node->origin[2]};
    int64_t from[3], to[3];
    if (!clip(from, to, t, origin, node_log2[node->level]))
        return CVOL_OK;
    const int code = read_node(context, samples, room, tree, node, name);
    if (code)
        return code;
    if (node->level == 0) {
        copy_leaf(t, origin, samples);
        return CVOL_OK;
    }
    for (size_t i = 0; i < values_of(node->level); i++)
        if (!cvol_vdb_is_set(tree->source.data + node->masks, i)) {
            int64_t begin[3];
            child_origin(begin, node, i);
            fill_cube(t, begin, child_log2[node->level], samples + i * t->bytes);
        }
    return CVOL_OK;
}

static void fill_background(const target *t, const uint8_t *sample)
{
    size_t count = 1;
    for (int a = 0; a < 3; a++)
        count *= (size_t)(t->end[a] - t->begin[a]);
    for (size_t i = 0; i < count; i++)
        memcpy(t->out + i * t->bytes, sample, t->bytes);
}

int cvol_vdb_tree_fill(cvol_context *context, const cvol_vdb_tree *tree, void *out,
                       const int64_t begin[3], const int64_t end[3], const char *name)
{
    target t = {.out = out, .bytes = cvol_type_size(tree->source.type->sample)};
    memcpy(t.begin, begin, sizeof t.begin);
    memcpy(t.end, end, sizeof t.end);
    const size_t bytes = CVOL_VDB_MOST_VALUES * t.bytes;
    uint8_t *samples = malloc(2 * bytes);
    if (!samples)
        return cvol_fail_memory(context, 2 * bytes, name);
    fill_background(&t, tree->source.background);
    for (size_t i = 0; i < tree->tile_count; i++) {
        const int32_t *origin = tree->tiles[i].origin;
        fill_cube(&t, (int64_t[]){origin[0], origin[1], origin[2]}, ROOT_LOG2,
                  tree->tiles[i].sample);
    }
    int code = CVOL_OK;
    for (size_t i = 0; i < tree->node_count && !code; i++)
        code = fill_node(context, &t, samples, samples + bytes, tree, &tree->nodes[i], name);
    free(samples);
    return code;
}
