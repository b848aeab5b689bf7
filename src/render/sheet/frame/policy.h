/* How a frame is drawn: one pure function from a case to a policy. */
#ifndef CVOL_RENDER_SHEET_FRAME_POLICY_H
#define CVOL_RENDER_SHEET_FRAME_POLICY_H

#include "base/cpu.h"
#include "render/engine/engine.h"
#include "render/sheet/frame/frame.h"
#include "render/transfer/transfer.h"

/* What decides about a transfer function on an array. */
typedef struct cvol_transfer_traits {
    int is_translucent; /* no opacity is high, and it is smooth */
    int is_soft;        /* no opacity is very high, and it is smooth over some samples */
    int is_noisy;       /* the array's own error is more than what image-order rays bring */
    int is_fine;        /* that error is so small that the sampling along rays decides */
    int is_exact;       /* even where the function is translucent */
    double curvature;   /* of translucent functions: cvol_opacity_curvature; negative: not known */
} cvol_transfer_traits;

cvol_transfer_traits cvol_transfer_traits_of(const cvol_array *array,
                                             const cvol_transfer *transfer);

/* Everything that the decisions depend on. */
typedef struct cvol_policy_case {
    /* The view and the options. */
    cvol_mode mode;
    cvol_sheet_rays asked; /* the ray order that the options ask for */
    double pixel;          /* side of a pixel, in mean sample spacings */
    double rays;           /* lines of rays for one of the picture */
    double step;           /* options: largest sample distance along a ray; 0: the engine's own */
    int lit;               /* shading is on */
    int planes;            /* clip planes */
    int perspective, level;
    int is_oblique; /* the view is too oblique for image-order kernels (cvol_sheet_plan_image_order)
                     */
    int is_wide;    /* the footprint is wider than linear */
    int has_depth;  /* the picture wants depths */
    int counts;     /* multiply-adds are counted */
    /* The transfer function. */
    cvol_transfer_traits traits;
    int fits_lit_int16; /* int16 samples tell its slopes apart; only lit frames ask */
    /* The array. */
    cvol_sheet_masked masked;
    int is_thin;   /* one sample along some axis */
    int has_range; /* its samples are not all of one value */
    cvol_cpu cpu;
} cvol_policy_case;

typedef enum cvol_sample_type { CVOL_SAMPLES_FLOAT, CVOL_SAMPLES_INT16 } cvol_sample_type;

/* How closely intervals between two slices are looked at. */
typedef enum cvol_interval_rule {
    CVOL_INTERVALS_FINE,                  /* as CVOL_FLAT_TOLERANCE says */
    CVOL_INTERVALS_COARSE_IF_TRANSLUCENT, /* as ..._COARSE says where the frame's table is */
    CVOL_INTERVALS_COARSE
} cvol_interval_rule;

typedef struct cvol_policy {
    cvol_sheet_rays order; /* the ray order: image or object, never AUTO */
    /* Sample spacing. In object order, pixels between two rays and the coarsest points that means
     * may have; in image order, mean spacings between two slices along a ray (0: as the samples).
     */
    double rays_apart, coarsest, slices_apart;
    cvol_interval_rule intervals;
    /* The midpoint rule: soft functions look at fewer midpoints, fine arrays at all of them. */
    int soft_midpoints, all_midpoints;
    int gradient_interpolation; /* lit: light is computed between slices, too */
    /* The sample type. The frame keeps floats where its table or its geometry does not suit int16.
     */
    cvol_sample_type samples;
} cvol_policy;

cvol_policy cvol_policy_choose(const cvol_policy_case *in);

/* Whether cvol_policy_choose needs to know the curvature, which costs time. */
int cvol_policy_needs_curvature(const cvol_policy_case *in);

#endif
