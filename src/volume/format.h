/* A file format of volumes: one of these per format, listed in reader.c. */
#ifndef CVOL_VOLUME_FORMAT_H
#define CVOL_VOLUME_FORMAT_H

#include "cvol/volume.h"

/* Bytes of a file's beginning that the formats are recognised by. */
#define CVOL_FORMAT_HEAD_BYTES 4096

typedef struct cvol_format {
    const char *name;
    /* Names of files that are read and written in this format end so. */
    const char *endings[4];
    /* 1 if a file that begins with these bytes is of this format. NULL: no way to tell. */
    int (*recognise)(const uint8_t *head, size_t size);
    /* Reads the volume; `options` matter to formats that do not describe themselves. */
    int (*read)(cvol_context *context, cvol_volume **out, const char *path,
                const cvol_read_options *options);
    /* Writes a volume that has been checked; the path ends in one of `endings`. */
    int (*write)(cvol_context *context, const cvol_volume *volume, const char *path);
    /* 1 if the reader needs dims and type from the options. */
    int needs_options;
} cvol_format;

extern const cvol_format cvol_format_nrrd;
extern const cvol_format cvol_format_metaimage;
extern const cvol_format cvol_format_nifti;
extern const cvol_format cvol_format_raw;

#endif
