/* A file format of volumes: one of these per format, listed in reader.c. */
#ifndef CVOL_VOLUME_IO_FORMAT_H
#define CVOL_VOLUME_IO_FORMAT_H

#include "cvol/series.h"
#include "volume/io/stored.h"

/* The number of leading bytes by which formats are recognised. */
#define CVOL_FORMAT_HEAD_BYTES 4096

/* The read options that a format uses, beyond those of raw samples. */
enum {
    CVOL_TAKES_SPACING = 1,
    CVOL_TAKES_CHANNEL = 2,
    CVOL_TAKES_INDEX = 4,
    CVOL_TAKES_SERIES = 8
};

typedef struct cvol_format {
    const char *name;
    /* Endings of names of files that are read and written in this format. */
    const char *endings[4];
    /* The library that it needs and this build lacks, for a message. NULL: none. */
    const char *lacks;
    /* 1 if a file that begins with these bytes has this format. NULL: the format has no
     * signature. */
    int (*recognise)(const uint8_t *head, size_t size);
    /* 1 if the folder as a whole has this format. NULL: no folder has. */
    int (*recognise_folder)(const char *path);
    /* Reads only the header; the grid need not be valid yet. `options` are for formats that do not
     * describe themselves. stored->data_path may be set after a failure too. */
    int (*find)(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                const cvol_read_options *options);
    /* NULL: not written. Plans a file for a checked grid; the path has one of `endings`. The plan
     * is zero before; the caller frees it, also after a failure. */
    int (*plan)(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                const char *path);
    /* The same for formats that write by themselves. `series` is valid; labels: the samples are
     * labels. The caller closes the sink, also after a failure. */
    int (*open_sink)(cvol_context *context, cvol_write_sink *sink, const cvol_grid *grid,
                     const char *path, const cvol_series_options *series, int labels);
    /* 1 if the written file of this name holds all volumes of a series. NULL: none does. */
    int (*holds_series)(const char *path);
    /* 1 if the reader needs dims and type from the options. */
    int needs_options;
    int takes;        /* CVOL_TAKES_... */
    int takes_folder; /* 1 if `find` accepts a folder of such files */
    int takes_name;   /* 1 if FILE:NAME names a volume in such a file */
    int writes_name;  /* 1 if FILE:NAME names the volume in a file that is written */
} cvol_format;

/* Chooses one of `count` channels, volumes, ...; `what` names one of them, `option` the command's
 * option. ARGUMENT error if it does not exist, or if there are several and none was chosen. */
int cvol_format_choose(cvol_context *context, size_t *out, const char *path, const char *what,
                       const char *option, size_t count, int has_choice, int choice);

/* Writing TIFF, which needs no library; OME-TIFF, by its name, holds a series. */
int cvol_tiff_plan(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                   const char *path);
int cvol_tiff_is_ome(const char *path);

/* A sample type by its VTK name. */
int cvol_vtk_type(cvol_type *out, const char *name, size_t length);

extern const cvol_format cvol_format_nrrd;
extern const cvol_format cvol_format_metaimage;
extern const cvol_format cvol_format_nifti;
extern const cvol_format cvol_format_analyze;
extern const cvol_format cvol_format_mgh;
extern const cvol_format cvol_format_tiff;
extern const cvol_format cvol_format_dicom;
extern const cvol_format cvol_format_npy;
extern const cvol_format cvol_format_mrc;
extern const cvol_format cvol_format_vtk;
extern const cvol_format cvol_format_vti;
extern const cvol_format cvol_format_hdf5;
extern const cvol_format cvol_format_zarr;
extern const cvol_format cvol_format_vdb;
extern const cvol_format cvol_format_matlab;
extern const cvol_format cvol_format_pictures;
extern const cvol_format cvol_format_raw;

#endif
