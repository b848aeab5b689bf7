/* Images of OME-Zarr (ngff.openmicroscopy.org, 0.4 and 0.5): the description of an array's axes,
 * geometry and channels in the attributes of a group. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_IMAGE_H
#define CVOL_VOLUME_FORMATS_ZARR_IMAGE_H

#include "volume/formats/zarr/json.h"
#include "volume/io/stored.h"

/* A group's attributes: those of .zattrs (format 2), or "ome" of zarr.json (format 3). */
typedef struct cvol_zarr_group {
    cvol_zarr_json json;
    const json_t *attributes; /* NULL: it has none */
} cvol_zarr_group;

/* Loads the attributes of a folder. *is_group: it is a folder of Zarr, and not an array. The caller
 * closes it, also after a failure. */
int cvol_zarr_group_open(cvol_context *context, cvol_zarr_group *group, int *is_group,
                         const char *folder);
void cvol_zarr_group_close(cvol_zarr_group *group);

/* The group's array of a level; NULL: there is none. The text is the path of the array inside of
 * the group. FORMAT error for a path that leaves the folder. */
int cvol_zarr_group_level(const cvol_zarr_group *group, size_t level, const char **path);
/* The level whose array has this path inside of the group; -1: none. */
int cvol_zarr_group_find(const cvol_zarr_group *group, const char *path);

typedef struct cvol_zarr_image {
    int rank;
    char axis[CVOL_ZARR_AXES]; /* t, c, z, y, x */
    double scale[CVOL_ZARR_AXES], translation[CVOL_ZARR_AXES];
    char unit[CVOL_ZARR_AXES][16]; /* of an axis, as the file names it; "": unknown */
} cvol_zarr_image;

/* The axes of a level. */
int cvol_zarr_image_read(cvol_zarr_image *image, const cvol_zarr_group *group, size_t level);
/* The image of an array without description: the last axes of t, c, z, y, x. 0: it has more. */
int cvol_zarr_image_guess(cvol_zarr_image *image, int rank);
/* Sets spacing, origin and unit; axes without one keep theirs. */
void cvol_zarr_image_place(cvol_grid *grid, const cvol_zarr_image *image);
/* The step of times, and names and colours of `channels` channels. 1, or 0 without memory. */
int cvol_zarr_image_label(cvol_labels *labels, const cvol_zarr_image *image,
                          const cvol_zarr_group *group, size_t channels);

#endif
