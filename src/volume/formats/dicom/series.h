/* Slices of a DICOM series: the files that belong together, their order and their positions. */
#ifndef CVOL_VOLUME_FORMATS_DICOM_SERIES_H
#define CVOL_VOLUME_FORMATS_DICOM_SERIES_H

#include "cvol/volume.h"
#include "volume/formats/dicom/head.h"

typedef struct cvol_dicom_slice {
    size_t head; /* of `heads` */
    uint64_t frame;
    double along; /* the slices' normal, from the world's origin */
} cvol_dicom_slice;

typedef struct cvol_dicom_series {
    cvol_dicom_head *heads;
    size_t head_count;
    cvol_dicom_slice *slices; /* of the chosen series, in order */
    size_t count;
    int varies; /* slices have different scales: their values become floats */
} cvol_dicom_series;

/* What a folder says about one of its series. The texts belong to the heads. */
typedef struct cvol_dicom_summary {
    const char *key; /* as `series` of cvol_read_options it chooses this one */
    const char *description;
    uint64_t frames;
} cvol_dicom_summary;

void cvol_dicom_series_close(cvol_dicom_series *series);
/* Reads the heads of a folder's files, or of the folder of a file. *first is the file's own head,
 * or SIZE_MAX. */
int cvol_dicom_series_list(cvol_context *context, cvol_dicom_series *series, const char *path,
                           size_t *first);
/* The next series from head *at on, which moves behind its first one; 0: there are no more. */
int cvol_dicom_series_next(const cvol_dicom_series *series, size_t *at, cvol_dicom_summary *out);
/* Chooses a series, and one volume of it, and sorts its slices. */
int cvol_dicom_series_choose(cvol_context *context, cvol_dicom_series *series, const char *path,
                             size_t first, const cvol_read_options *options);
/* Sets positions of slices and the meaning of values; dims and type are set before. Uneven slices
 * are an error unless the caller gives the spacing. */
int cvol_dicom_series_place(cvol_context *context, cvol_dicom_series *series, cvol_grid *grid,
                            const char *path, const cvol_read_options *options);

#endif
