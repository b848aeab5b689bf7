/* Opacity curvature between neighbouring samples of the visible part: detail that rays miss if they
 * lie one sample apart. */
#ifndef CVOL_RENDER_SHEET_OPACITY_CURVATURE_H
#define CVOL_RENDER_SHEET_OPACITY_CURVATURE_H

#include "render/sheet/band/skip.h"

/* The root mean square of the difference between the opacity of a sample and that of the mean of
 * its two neighbours along an axis, divided by the mean opacity; for visible samples of some
 * visible blocks. 0 if there are none, -1 without memory. Cost: the evaluation of 160 blocks and
 * 0.2 million steps, 2 ms. */
double cvol_opacity_curvature(const cvol_array *array, const cvol_transfer *transfer,
                              const cvol_visibility *visibility);

#endif
