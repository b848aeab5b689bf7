/* The classification of one frame, as a table. */
#ifndef CVOL_RENDER_SHEET_FRAME_TABLE_H
#define CVOL_RENDER_SHEET_FRAME_TABLE_H

#include "render/sheet/frame/frame.h"
#include "render/transfer/transfer.h"

/* Tabulates the transfer function over the range of the data, with opacities for the distance
 * between slices. noise: see cvol_transfer_traits. */
void cvol_sheet_table_fill(cvol_sheet_table *table, const cvol_array *array,
                           const cvol_transfer *transfer, double distance, double noise);

/* Sets the table's rules for parts and midpoints of unlit intervals in image order, of rays that
 * move by `shear` samples per slice, along lanes and rows together. `noise`: see
 * cvol_transfer_traits. */
void cvol_sheet_table_image_order(cvol_sheet_table *table, double shear, double noise, int lit);

#endif
