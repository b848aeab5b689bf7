/* The mark of labels in images of OME-Zarr. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_LABELS_H
#define CVOL_VOLUME_FORMATS_ZARR_LABELS_H

/* 1 for an image, or an array of one, whose group has the attribute image-label. */
int cvol_zarr_is_labels(const char *path);

#endif
