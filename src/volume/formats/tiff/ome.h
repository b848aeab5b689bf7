/* The description of an OME-TIFF that is written. */
#ifndef CVOL_VOLUME_FORMATS_TIFF_OME_H
#define CVOL_VOLUME_FORMATS_TIFF_OME_H

#include "base/bytes.h"
#include "cvol/series.h"

/* The number of components of a colour that share a page; 1: a page has one channel. */
unsigned cvol_tiff_ome_components(const cvol_grid *grid, const cvol_series_options *series);
/* The OME-XML of all volumes of a series, whose pages run along z, then channels, then times. */
void cvol_tiff_put_ome(cvol_bytes *bytes, const cvol_grid *grid, const cvol_series_options *series);

#endif
