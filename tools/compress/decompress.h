/* Pieces of cvol decompress. */
#ifndef CVOL_TOOLS_DECOMPRESS_H
#define CVOL_TOOLS_DECOMPRESS_H

#include "tools/base/cli.h"

/* The part of a file that is decompressed. */
typedef struct part {
    const char *path;
    size_t begin[3], end[3];
    int level, is_box;   /* --box was given */
    int time, channel;   /* of a series: the volume, or the first of several */
    int times, channels; /* of them that are decompressed */
    int zarr_format;     /* --zarr-format */
    int has_levels;      /* the output may have coarser levels */
    size_t brick[3];     /* of the file; 0: it has no bricks */
    int by_slab;         /* the file has bricks */
    int is_exact;        /* all samples come back to the bit */
    cvol_grid grid;      /* of the box */
} part;

/* Reads the part of the file with the slices first .. end - 1. */
int open_slab(cvol_context *context, cvol_array **array, const part *p, size_t first, size_t end);

/* ---- decompress_image.c: formats that hold several volumes ---- */

/* 1 if a file of this name gets all volumes of a series. */
int holds_series(const char *path);
/* Chooses all times and channels that no option chooses. Exit status. */
int choose_volumes(cvol_context *context, common_options *common, part *p);
/* Opens the output for them. *labels must live as long as the writer; the caller frees it. */
int open_image(cvol_context *context, cvol_volume_writer **out, volume_labels *labels,
               const part *p, common_options *common, const char *out_path);

/* ---- decompress_labels.c: segmentations of 3D Slicer, .seg.nrrd ---- */

/* Opens the output with a segment for each label among the samples, but the background: with the
 * names and colours that the file has, or those of pictures. Exit status. */
int open_segments(cvol_context *context, cvol_volume_writer **out, const part *p,
                  const char *out_path);

/* ---- decompress_lost.c: what the output's format cannot store ---- */

/* 1 if the volume has a scale and offset of values that the output's format cannot store. */
int loses_rescale(const part *p, const char *out_path);
/* Prints the properties of the geometry that it cannot store. */
void print_lost_places(const part *p, const char *out_path);
json_t *json_lost_places(const part *p, const char *out_path);

#endif
