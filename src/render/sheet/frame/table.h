/* Classification of one frame, tabulated. */
#ifndef CVOL_RENDER_SHEET_FRAME_TABLE_H
#define CVOL_RENDER_SHEET_FRAME_TABLE_H

#include "render/sheet/frame/frame.h"
#include "render/transfer/transfer.h"

/* Tabulates the transfer function over what of it the data reach, with opacities for the distance
 * between sheets. */
void cvol_sheet_table_fill(cvol_sheet_table *table, const cvol_array *array,
                           const cvol_transfer *transfer, double distance);

/* The scale that cvol_sheet_table_fill gives a table: entries for a unit of value. */
double cvol_sheet_table_scale(const cvol_array *array, const cvol_transfer *transfer);
/* What is soft (cvol_transfer_traits) is looked at midpoint no more than what is clear: it has no
 * thin subbands between two ends that are alike. Before cvol_sheet_table_slant. */
void cvol_sheet_table_soften(cvol_sheet_table *table);

/* What it says about samples midpoint between sheets (midpoint) becomes that for rays that move by
 * `shear` samples from sheet to sheet, along lanes or rows, whichever is more; `is_fine`: see
 * cvol_transfer_traits. */
void cvol_sheet_table_image_order(cvol_sheet_table *table, double shear, int is_fine);

#endif
