/* cvol/engines.h - engines: methods of drawing volumes. Their options and reports. The functions
 * are in cvol/render.h.
 *
 * CVOL_ENGINE_SHEET draws straight from the compressed array. When it is created, it finds which
 * blocks are visible under which values; it evaluates samples when it draws a picture.
 *
 * CVOL_ENGINE_RAY casts rays through dense samples. The pictures of the other engines are compared
 * with its. In mode composite it integrates the transfer function within each step, as if the
 * volume were linear between the ends and the middle of the step: it misses no thin peak and no
 * jump.
 *
 * CVOL_ENGINE_SPLAT splats (Westover, "Footprint evaluation for volume rendering", 1990), mode
 * composite only. It classifies and lights samples, adds up their footprints slice by slice along
 * the axis most parallel to the view, and composites the slices,
 *
 *     I += (1 - A) sum w F D,  A += (1 - A) sum w D,   D = 1 - (1 - opacity)^distance,
 *
 * where w are the weights of the footprints at a pixel, which sum to 1 within the volume. It
 * evaluates samples of an array slab by slab, about 130 MB at a time. Cost of a picture: one
 * evaluation of all samples, and size^2 pixels (of the size of samples) for each sample that is not
 * transparent.
 *
 * CVOL_ENGINE_TRANSFORM splats on compressed transforms (Chen and Reif, "Fast and compact volume
 * rendering in the compressed transform domain", 2003), mode composite only. It classifies and
 * lights samples like engine splat. Intensity C (times opacity; red, green, blue) and opacity D of
 * each slice become compressed arrays of rank 2, in tiles or whole. The engine spreads these by the
 * footprint, shifts them to their places in the view, and composites them on one lattice,
 *
 *     front to back   I += (1 - A) C,  A += (1 - A) D
 *     back to front   I = (1 - D) I + C,  A = (1 - D) A + D
 *
 * by products of arrays (literal) or of samples (deferred); one warp makes the picture. With wide
 * Gaussians it evaluates tiles at every second or every fourth place. It keeps the planes of slices
 * as long as transfer function, direction and light stay the same and no picture needs more terms.
 * Cost: N log N for the slices whenever they change; then, for n places and n' terms, O(n') per
 * slice and operation (literal), or n log n per slice (deferred).
 *
 * Over a baked file (cvol/baked.h) engine transform draws all directions along which a ray crosses
 * the slices of the axis of the file: from both ends, sheared, with opacities for the distance of
 * slices along the view, from the strongest rho of the stored terms. Options must agree with the
 * file. Another transfer function, light or transform, more terms, a direction of another axis, and
 * a footprint larger than a slice are ARGUMENT.
 *
 * CVOL_ENGINE_FOURIER uses the Fourier slice theorem (Malzbender, "Fourier volume rendering",
 * 1993), mode xray only: a picture is the inverse transform of a plane through the spectrum of the
 * volume. It differs from that of engine ray in detail finer than pixels and samples. The renderer
 * holds the spectrum of all samples, padded to 3/2 of each axis, as half floats: 7 bytes per
 * sample, twice as much with a mask, and three times as much while it is made. With
 * cvol_source.rho above 0 only the strongest frequencies stay: rho / 2 per sample (one of each
 * conjugate pair), at 4 bytes each and 0.24 bytes per sample; a picture unpacks those near its
 * plane. Cost: N log N once; O(P log P + 216 P) per picture, for any depth of the volume, where P
 * is the number of points of its shadow.
 *
 * The option structs in this file are embedded in cvol_render_options. They have no size of their
 * own and are frozen: later versions append new options to cvol_render_options. */
#ifndef CVOL_ENGINES_H
#define CVOL_ENGINES_H

#include "cvol/array.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The engines. */
typedef enum cvol_engine {
    CVOL_ENGINE_SHEET = 1,     /* from the compressed array, slice by slice */
    CVOL_ENGINE_RAY = 2,       /* from dense samples, ray by ray: the reference */
    CVOL_ENGINE_SPLAT = 3,     /* footprint by footprint: Westover's algorithm */
    CVOL_ENGINE_TRANSFORM = 4, /* the same on compressed transforms of slices: Chen and Reif */
    CVOL_ENGINE_FOURIER = 5 /* mode xray only: slices through the spectrum, O(N^2 log N) per view */
} cvol_engine;

/* ---- engine sheet ---- */

/* Reconstruction filters of engine sheet: how it interpolates within a slice of samples, along both
 * axes. Between two slices it interpolates linearly. Results stay within the range of the 4 x 4
 * samples around. Next to samples without a value, cubic filters fall back to linear. */
typedef enum cvol_sheet_footprint {
    CVOL_SHEET_LINEAR = 0,      /* 2 x 2 samples */
    CVOL_SHEET_CATMULL_ROM = 1, /* 4 x 4: cubic, passes through the samples */
    CVOL_SHEET_B_SPLINE =
        2, /* 8 x 8: cubic B-spline with prefilter. It passes through slowly varying samples; it
              removes 22 % of the finest detail, less than 1 % of detail twice as coarse */
    CVOL_SHEET_GAUSSIAN = 3 /* 6 x 6: exp(-q^2 / 2 sigma^2), normalized: it blurs */
} cvol_sheet_footprint;

/* Ray orders of engine sheet.
 *
 * Image order: rays go through the pixels of the picture, which needs no resampling. It is possible
 * in mode composite, parallel projection, level 0, with linear filters, oversample 1, and a value
 * for all samples; with light also AVX-512 and no axis of one sample.
 *
 * Object order: rays lie along rows of samples, and a warp makes the picture. It is up to twice as
 * fast. For opaque or thin objects it is 2 to 14 dB further from the reference picture; for
 * translucent ones 0 to 3 dB, at 40 dB and more, which is not visible.
 *
 * AUTO selects object order if the opacity of the transfer function stays below 0.45 and its
 * curvature is low (a deviation from a straight line of at most 0.05 over every 7 % of its span),
 * except with light if opacity changes by a third of its value from sample to sample; and if the
 * compression error of the samples changes opacity by a tenth. It selects image order if a pixel
 * spans more than 1.45 samples, or step_voxels is given. Angles have no influence. Translucent
 * pictures, means and extremes are then drawn with rays 1.5 pixels apart, at most the distance of
 * samples, if oversample is 1 and no plane cuts the volume. If a pixel spans less than 0.55
 * samples, light is evaluated twice per slice. Without light, in image order, opaque objects
 * (opacity 0.45 or more) get more samples along the ray if the compression error changes opacity by
 * at most 0.005: up to 6 dB better; and translucent transfer functions of high curvature are drawn
 * in image order if it changes opacity by at most 0.001. */
typedef enum cvol_ray_order {
    CVOL_RAY_ORDER_AUTO = 0,  /* chosen as described above */
    CVOL_RAY_ORDER_IMAGE = 1, /* image order where it is possible, else object order */
    CVOL_RAY_ORDER_OBJECT = 2 /* object order */
} cvol_ray_order;

/* Options of engine sheet. */
typedef struct cvol_sheet_options {
    cvol_sheet_footprint footprint;
    double sigma;             /* standard deviation of a Gaussian in samples, 0.5 to 1; 0: 5/6 */
    cvol_ray_order ray_order; /* order of the rays */
} cvol_sheet_options;

/* ---- engine splat ---- */

/* A footprint: the contribution of one sample to the pixels around it, as a function of the place
 * (qx, qy) in the ellipse that the kernel of the sample covers, in samples, |qx|, |qy| < size / 2.
 */
typedef enum cvol_footprint {
    CVOL_FOOTPRINT_GAUSSIAN = 1, /* exp(-(qx^2 + qy^2) / 2 sigma^2) */
    CVOL_FOOTPRINT_CONE = 2,     /* max(0, 1 - 2 |q| / size) */
    CVOL_FOOTPRINT_SINC = 3,     /* w(qx) w(qy), w(t) = sinc(pi t) cos^2(pi t / size) */
    CVOL_FOOTPRINT_BOX = 4       /* 1; its edges are soft over 1/8 of a sample */
} cvol_footprint;

/* The ellipse of a footprint. */
typedef enum cvol_footprint_plane {
    CVOL_FOOTPRINT_IN_VIEW = 1,  /* the projection of a round kernel in this view */
    CVOL_FOOTPRINT_IN_SLICES = 2 /* round in the slices, which are composited on their own lattice;
                                    one warp makes the picture */
} cvol_footprint_plane;

/* The order in which engines splat and transform composite slices. The pictures are equal up to
 * rounding. */
typedef enum cvol_order { CVOL_ORDER_FRONT = 1, CVOL_ORDER_BACK = 2 } cvol_order;

/* Options of engine splat. */
typedef struct cvol_splat_options {
    cvol_footprint footprint;
    int size;     /* width of a footprint in samples, 3 to 31 */
    double sigma; /* standard deviation of a Gaussian in samples, 0.2 to 31; 0: size / 6 */
    cvol_footprint_plane plane; /* engine transform: always in slices */
    cvol_order order;
} cvol_splat_options;

/* ---- engine transform ---- */

/* When engine transform returns to coefficients. */
typedef enum cvol_schedule {
    CVOL_SCHEDULE_DEFERRED = 1, /* never: composites evaluated samples of slices */
    CVOL_SCHEDULE_LITERAL = 2   /* after every operation, with truncation: as in the paper */
} cvol_schedule;

/* Options of engine transform. Footprint (Gaussian, sinc or box) and order are those of engine
 * splat. */
typedef struct cvol_transform_options {
    cvol_transform transform; /* transform of planes: DCT; for whole planes also DFT and DHT */
    int tile;                 /* planes have tiles of 8, 16 or 32 samples a side; 0: whole planes */
    double rho; /* terms kept divided by samples: of all planes together (tiles), or of each (whole
                   planes), above 0; 1, the largest: all nonzero terms */
    cvol_schedule schedule;
    double
        stored_rho; /* if larger than rho: planes keep this share of terms, and pictures use rho */
} cvol_transform_options;

/* Counts and times of the last picture of engine transform. */
typedef struct cvol_transform_report {
    size_t lattice[2], slices; /* places of the lattice; number of slices that are not empty */
    double step;               /* distance of places of the lattice, in samples */
    uint64_t terms, bytes;     /* terms of the planes of all slices; their bytes in memory */
    double rho;                /* terms divided by samples of these planes */
    uint64_t multiply_adds;    /* multiply-adds of footprints and compositing: counted (tiles,
                                  deferred), else by formula, n log2 n for a transform of n samples */
    double bound;  /* bound of the root mean square error, over the lattice, of intensity (all
                      channels) by truncation; 0 if it is not certified */
    int certified; /* 1: the bound is proven, and less than what the range of intensities says. 0:
                      footprints with negative weights, or too much was dropped */
    double bake_ms,
        compose_ms; /* milliseconds; bake_ms is 0 if the slices were kept from an earlier picture */
} cvol_transform_report;

/* ---- engine fourier ---- */

/* Options of engine fourier. */
typedef struct cvol_fourier_options {
    double depth_cue; /* 0..1: how much darker the far end of the diagonal is */
    int integrals;    /* 1: cvol_renderer_project computes integrals along rays, in world length,
                         instead of means */
} cvol_fourier_options;

/* Size of the spectrum of engine fourier. */
typedef struct cvol_fourier_report {
    size_t padded[3];
    uint64_t places, bytes; /* complex numbers of the spectrum; bytes in memory */
    double build_ms;
} cvol_fourier_report;

#ifdef __cplusplus
}
#endif
#endif
