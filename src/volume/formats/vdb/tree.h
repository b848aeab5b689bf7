/* Trees of OpenVDB: where the values of voxels are in the file, and reading a box of them.
 *
 * The root has nodes and tiles of 4096^3 voxels. A node of them has 32^3 nodes and tiles of 128^3
 * voxels; one of these has 16^3 leaves and tiles of 8^3 voxels. A tile has one value. Voxels
 * outside of all nodes and tiles have the background value. Voxels and tiles are active or not. */
#ifndef CVOL_VOLUME_FORMATS_VDB_TREE_H
#define CVOL_VOLUME_FORMATS_VDB_TREE_H

#include "volume/formats/vdb/values.h"

/* A node; level 2 and 1, or 0: a leaf. */
typedef struct cvol_vdb_node {
    int32_t origin[3]; /* its first voxel */
    int level;
    size_t masks;  /* the place of its masks in the file: of children, of active values. A leaf has
                      the second one. */
    size_t values; /* of its values */
} cvol_vdb_node;

/* A tile of the root. */
typedef struct cvol_vdb_tile {
    int32_t origin[3];
    uint8_t sample[8];
    int is_active;
} cvol_vdb_tile;

typedef struct cvol_vdb_tree {
    cvol_vdb_source source;
    cvol_vdb_node *nodes;
    size_t node_count;
    cvol_vdb_tile *tiles;
    size_t tile_count;
    int64_t begin[3], end[3]; /* the box of active voxels */
} cvol_vdb_tree;

/* Finds the nodes of a tree of the file `data`, which must live as long as the tree. `name` begins
 * messages. The caller frees the tree, also after a failure. Errors: FORMAT (also without active
 * voxels), MEMORY. */
int cvol_vdb_tree_read(cvol_context *context, cvol_vdb_tree *tree, const cvol_vdb_entry *entry,
                       const cvol_vdb_head *head, const uint8_t *data, size_t size,
                       const char *name);
void cvol_vdb_tree_free(cvol_vdb_tree *tree);

/* Samples of the box [begin, end) of voxels, x fastest. Errors: FORMAT, UNSUPPORTED, MEMORY. */
int cvol_vdb_tree_fill(cvol_context *context, const cvol_vdb_tree *tree, void *out,
                       const int64_t begin[3], const int64_t end[3], const char *name);

#endif
