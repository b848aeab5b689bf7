/* The metadata of an image of OME-Zarr that is written: 0.4 in format 2 of Zarr, 0.5 in format 3.
 */
#ifndef CVOL_VOLUME_FORMATS_ZARR_DESCRIBE_H
#define CVOL_VOLUME_FORMATS_ZARR_DESCRIBE_H

#include "base/bytes.h"
#include "cvol/series.h"

typedef struct cvol_zarr_written {
    const char *path;
    int format;     /* of Zarr: 2 or 3 */
    cvol_grid grid; /* of level 0 */
    int levels, labels;
    int has_times, has_channels; /* axes t and c */
    int times, channels;
    const cvol_series_options *series;
    const double *least, *most; /* of each channel's samples; least > most: it has none */
    cvol_bytes label_list;      /* names and colours of labels (cvol_zarr_describe_labels) */
} cvol_zarr_written;

/* The unit of time as the specification names it; NULL: it has no name. */
const char *cvol_zarr_time_unit(const char *unit);

/* Describes the labels of the series for image-label, each list behind a comma: nothing if it has
 * none. */
void cvol_zarr_describe_labels(cvol_bytes *out, const cvol_series_options *series);
/* .zattrs of the group, or its zarr.json. */
void cvol_zarr_describe_group(cvol_bytes *out, const cvol_zarr_written *written);
/* .zarray of a level, or its zarr.json. */
void cvol_zarr_describe_array(cvol_bytes *out, const cvol_zarr_written *written,
                              const size_t dims[3], const size_t chunk[3]);

#endif
