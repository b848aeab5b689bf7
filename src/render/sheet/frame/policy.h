/* The policy of a frame: one pure function of a case. */
#ifndef CVOL_RENDER_SHEET_FRAME_POLICY_H
#define CVOL_RENDER_SHEET_FRAME_POLICY_H

#include "base/cpu.h"
#include "render/engine/engine.h"
#include "render/sheet/frame/frame.h"
#include "render/transfer/transfer.h"

/* The properties of a transfer function on an array that the policy uses. */
typedef struct cvol_transfer_traits {
    int is_translucent; /* no opacity is high, and it is smooth */
    double noise;       /* the mean error of opacity that the array's own error makes */
} cvol_transfer_traits;

cvol_transfer_traits cvol_transfer_traits_of(const cvol_array *array,
                                             const cvol_transfer *transfer);

/* All inputs of the decisions. */
typedef struct cvol_policy_case {
    /* The view and the options. */
    cvol_mode mode;
    cvol_ray_order asked; /* the requested ray order */
    double pixel;         /* side of a pixel, in mean sample spacings */
    double rays;          /* lines of rays per line of the picture */
    double step; /* options: largest sample distance along a ray; 0: the engine's default */
    int lit;     /* shading is on */
    int planes;  /* clip planes */
    int perspective, level;
    int is_oblique; /* the view is too oblique for image-order kernels (cvol_sheet_plan_image_order)
                     */
    int is_wide;    /* the reconstruction filter is wider than linear */
    int has_depth;  /* the picture has depths */
    int counts;     /* multiply-adds are counted */
    /* The transfer function. */
    cvol_transfer_traits traits;
    /* The array. */
    cvol_sheet_masked masked;
    int is_thin;        /* one sample along some axis */
    int has_range;      /* its samples do not all have one value */
    int fits_lit_int16; /* its error covers the rounding of int16, with light, too */
    cvol_cpu cpu;
} cvol_policy_case;

typedef enum cvol_sample_type { CVOL_SAMPLES_FLOAT, CVOL_SAMPLES_INT16 } cvol_sample_type;

/* The sampling of intervals between two slices. */
typedef enum cvol_interval_rule {
    CVOL_INTERVALS_FINE,                  /* by CVOL_FLAT_TOLERANCE */
    CVOL_INTERVALS_COARSE_IF_TRANSLUCENT, /* by ..._COARSE if the frame's table is translucent */
    CVOL_INTERVALS_COARSE
} cvol_interval_rule;

typedef struct cvol_policy {
    cvol_ray_order order; /* the ray order: image or object, never AUTO */
    /* In object order: pixels between two rays, and the coarsest points of means. */
    double rays_apart, coarsest;
    cvol_interval_rule intervals;
    int gradient_interpolation; /* lit: light is computed between slices, too */
    /* The sample type. The frame keeps floats if its table or its geometry does not suit int16. */
    cvol_sample_type samples;
} cvol_policy;

cvol_policy cvol_policy_choose(const cvol_policy_case *in);

#endif
