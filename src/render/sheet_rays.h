/* Which rays a picture is drawn along. */
#ifndef CVOL_RENDER_SHEET_RAYS_H
#define CVOL_RENDER_SHEET_RAYS_H

#include "render/engine.h"
#include "render/transfer.h"

/* Those that a composite of `array` as `transfer` shows it is worth, from this view: never
 * CVOL_SHEET_RAYS_AUTO. Whatever the angle it is the same, so that nothing changes as a view turns.
 */
cvol_sheet_rays cvol_sheet_rays_suited(const cvol_array *array, const cvol_transfer *transfer,
                                       const cvol_view *view, const cvol_render_options *options);

#endif
