/* Which rays a picture is drawn along. */
#ifndef CVOL_RENDER_SHEET_FRAME_POLICY_H
#define CVOL_RENDER_SHEET_FRAME_POLICY_H

#include "render/engine/engine.h"
#include "render/transfer/transfer.h"

/* Which rays an array is worth, as a transfer function shows it. */
typedef struct cvol_transfer_traits {
    int is_translucent; /* no opacity is high, and it bends slowly */
    int is_soft;        /* none is very high, and it bends no faster than some samples */
    int is_noisy;       /* the array's own error is more than what rays bring */
    int is_fine;        /* it is so small that a picture is as near as its rays are looked at */
    int is_exact;       /* even where it is clear */
    double curvature;   /* of what is clear: cvol_opacity_curvature; negative: not known yet */
} cvol_transfer_traits;

cvol_transfer_traits cvol_sheet_traits_of(const cvol_array *array, const cvol_transfer *transfer);

/* Whether `bend` has to be known for what is asked. */
int cvol_policy_needs_curvature(const cvol_transfer_traits *traits,
                                const cvol_render_options *options);

/* Those that a composite from this view is worth: never CVOL_SHEET_RAYS_AUTO. Whatever the angle it
 * is the same, so that nothing changes as a view turns. */
cvol_sheet_rays cvol_policy_suited(const cvol_transfer_traits *traits, const cvol_view *view,
                                   const cvol_render_options *options);

/* Whether light is looked at between sheets, too: where pixels are so fine that these would be
 * seen.
 */
int cvol_policy_turn(const cvol_view *view);

/* Sets how far apart rays and points of the lattice, and sheets, then lie: `apart`, `coarsest` and
 * `sheets_apart` of the view. */
void cvol_policy_space(cvol_view *view, const cvol_transfer_traits *traits,
                       const cvol_render_options *options);

#endif
