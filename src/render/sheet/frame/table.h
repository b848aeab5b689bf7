/* The classification of one frame, as a table. */
#ifndef CVOL_RENDER_SHEET_FRAME_TABLE_H
#define CVOL_RENDER_SHEET_FRAME_TABLE_H

#include "render/sheet/frame/frame.h"
#include "render/transfer/transfer.h"

/* Tabulates the transfer function over the range of the data, with opacities for the distance
 * between slices. */
void cvol_sheet_table_fill(cvol_sheet_table *table, const cvol_array *array,
                           const cvol_transfer *transfer, double distance);

/* Soft functions (cvol_transfer_traits) get no more midpoints than translucent ones: they have no
 * thin bands between two equal ends. Before cvol_sheet_table_image_order. */
void cvol_sheet_table_soften(cvol_sheet_table *table);

/* Adapts the table's rule for midpoints to rays that move by `shear` samples per slice, along lanes
 * or rows, whichever is more; `is_fine`: see cvol_transfer_traits. */
void cvol_sheet_table_image_order(cvol_sheet_table *table, double shear, int is_fine);

#endif
