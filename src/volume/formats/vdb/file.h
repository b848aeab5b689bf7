/* Files of OpenVDB (openvdb.org): the list of grids, and a grid's header. */
#ifndef CVOL_VOLUME_FORMATS_VDB_FILE_H
#define CVOL_VOLUME_FORMATS_VDB_FILE_H

#include "base/bytes.h"
#include "cvol/base.h"

/* Bits of a grid's compression. */
enum { CVOL_VDB_ZIP = 1, CVOL_VDB_ACTIVE_MASK = 2, CVOL_VDB_BLOSC = 4 };

/* The values of a grid: how the file has them, and the samples that they become. */
typedef struct cvol_vdb_type {
    const char *name; /* in the file */
    cvol_type sample; /* int64: CVOL_WIDE_TYPE */
    unsigned bytes;   /* of a value in the file */
} cvol_vdb_type;

#define CVOL_VDB_NAME_BYTES 256

/* One grid of the list. Names have no control characters, and long ones are cut. */
typedef struct cvol_vdb_entry {
    char name[CVOL_VDB_NAME_BYTES];   /* "density"; "density[1]" if another one has this name */
    char tree[64];                    /* the type of its tree */
    char parent[CVOL_VDB_NAME_BYTES]; /* the grid that has its tree; "": itself */
    const cvol_vdb_type *type;        /* NULL: none that is read */
    int is_half;                      /* floats are stored as half floats */
    uint64_t offset;                  /* in the file */
} cvol_vdb_entry;

typedef struct cvol_vdb_list {
    cvol_vdb_entry *entries; /* freed with free() */
    size_t count;
} cvol_vdb_list;

/* 1 if a file begins like one of OpenVDB. */
int cvol_vdb_recognise(const uint8_t *head, size_t size);
/* Lists the grids of a file. `name` begins messages. The caller frees the list, also after a
 * failure. Errors: FORMAT, UNSUPPORTED, MEMORY. */
int cvol_vdb_list_read(cvol_context *context, cvol_vdb_list *list, const uint8_t *data, size_t size,
                       const char *name);
/* Chooses a grid by its name; NULL: the only one that can be read. Errors: FORMAT, UNSUPPORTED. */
int cvol_vdb_list_choose(cvol_context *context, const cvol_vdb_entry **out,
                         const cvol_vdb_list *list, const char *inside, const char *name);

/* A grid's header. Voxel (x, y, z) lies at steps[3] + x steps[0] + y steps[1] + z steps[2]. */
typedef struct cvol_vdb_head {
    uint32_t compression;
    double steps[4][3];
    size_t tree; /* the place of its tree in the file */
} cvol_vdb_head;

/* Errors: FORMAT, UNSUPPORTED (a transform that is not affine). */
int cvol_vdb_head_read(cvol_context *context, cvol_vdb_head *head, const cvol_vdb_entry *entry,
                       const uint8_t *data, size_t size, const char *name);

#endif
