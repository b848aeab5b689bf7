/* cvol/render.h - pictures of volumes, straight from their compressed form.
 *
 * World coordinates of the camera: sample (x, y, z) lies at (x, y, z) times the grid's spacing;
 * the grid's origin and axis directions are kept for files but do not turn the picture.
 */
#ifndef CVOL_RENDER_H
#define CVOL_RENDER_H

#include "cvol/array.h"
#include "cvol/image.h"
#include "cvol/picture.h"
#include "cvol/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- transfer functions ------------------------------------------------------------ */

/* From sample values to colour and opacity. */
typedef struct cvol_transfer cvol_transfer;

/* One control point: value in the data's own units, colour and opacity in 0..1. Opacity is
 * what one mean sample spacing of this value hides: along a length d (in mean spacings) it
 * becomes 1 - (1 - opacity)^d. */
typedef struct cvol_transfer_point {
    double value, r, g, b, opacity;
} cvol_transfer_point;

/* Linear between the points (sorted by value; two points of one value make a jump), constant
 * outside. At least one point. The caller frees *out. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create(cvol_context *context, cvol_transfer **out,
                                  const cvol_transfer_point *points, size_t count);
/* Reads {"points": [[value, r, g, b, opacity], ...]} or ParaView's colour-map JSON.
 * Errors: IO, FORMAT, MEMORY. */
CVOL_API int cvol_transfer_read(cvol_context *context, cvol_transfer **out, const char *path);
/* The same of such a file's text; `name` begins the message of an error. Errors: FORMAT, MEMORY. */
CVOL_API int cvol_transfer_parse(cvol_context *context, cvol_transfer **out, const char *text,
                                 size_t size, const char *name);
/* Frees a transfer function; NULL is allowed. */
CVOL_API void cvol_transfer_free(cvol_transfer *transfer);
/* How many points it has. */
CVOL_API size_t cvol_transfer_count(const cvol_transfer *transfer);
/* Point `index`, from 0, sorted by value. */
CVOL_API cvol_transfer_point cvol_transfer_get(const cvol_transfer *transfer, size_t index);

/* How the samples of a volume are distributed: `bins` equal intervals of min..max. A value that
 * lies a thousand times as far from all others as these are apart stands for no value: it is not
 * counted, and min and max are those of the others; nor are NaN and infinity counted. Counts are
 * rounded to quarters of octaves, and volumes of less than 2^20, 2^17, 2^14, 2^11 samples have 128,
 * 64, 32, 16 different counts: each is that of 2, 4, 8, 16 bins. So the histogram of the samples is
 * the one that their .cvol file carries, of a few bytes. */
#define CVOL_HISTOGRAM_BINS 256
typedef struct cvol_histogram {
    double min, max;
    uint64_t bins[CVOL_HISTOGRAM_BINS];
    double chord; /* the mean length of a ray through the volume, in mean spacings; 0: unknown */
    double mark;  /* the value that stands for none, if there is one */
    uint64_t mark_count; /* how many samples have it */
    int integers;        /* 1: all samples are integers */
    int distinct; /* how many different values the samples have; 0: more than 256, or unknown */
} cvol_histogram;
/* Of an array: that of the samples it was compressed from, at any ratio and of any level or part of
 * a file. An array without (a result of operations, a file of an early version): from a regular
 * subset of its blocks (at most 1,024 of them), decoded.
 * Of a volume: from all samples.
 * Errors: UNSUPPORTED (an array that is not of rank 3 in DCT blocks), ARGUMENT, MEMORY. */
CVOL_API int cvol_array_histogram(cvol_context *context, cvol_histogram *out,
                                  const cvol_array *array);
CVOL_API int cvol_volume_histogram(cvol_context *context, cvol_histogram *out,
                                   const cvol_volume *volume);

/* A named transfer function fitted to a histogram: "auto", "gray", "bone", "skin-bone", "mri",
 * "microscopy", "hot", "viridis", ... Errors: ARGUMENT (the message lists the names), MEMORY. */
CVOL_API int cvol_transfer_create_named(cvol_context *context, cvol_transfer **out,
                                        const char *name, const cvol_histogram *histogram);
/* "auto gray bone ..."; static storage. */
CVOL_API const char *cvol_transfer_names(void);

/* The same points, so that the first has the window's lower value and the last its upper one, those
 * between linearly (NULL: as they are), and opacities of matter that is so many times as dense:
 * 1 - (1 - opacity)^opacity_scale. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_adjusted(cvol_context *context, cvol_transfer **out,
                                           const cvol_transfer *from, const double *window,
                                           double opacity_scale);

/* Transfer functions in Hounsfield units, for computed tomography: "ct-bone", "ct-skin", "ct-lung",
 * "ct-vessels" (with contrast agent). A sample s means rescale[0] s + rescale[1] of them.
 * Errors: ARGUMENT (the message lists the names), MEMORY. */
CVOL_API int cvol_transfer_create_ct(cvol_context *context, cvol_transfer **out, const char *name,
                                     const double rescale[2]);
/* 1 if the name is one of those in Hounsfield units, else 0. */
CVOL_API int cvol_transfer_is_ct(const char *name);
/* "ct-bone ct-skin ..."; static storage. */
CVOL_API const char *cvol_transfer_ct_names(void);

/* Whether values look like Hounsfield units. */
typedef enum cvol_hounsfield {
    CVOL_HOUNSFIELD_NO = 0,
    CVOL_HOUNSFIELD_YES = 1,
    CVOL_HOUNSFIELD_SHIFTED = 2
} cvol_hounsfield;
/* Whether a volume's values look like Hounsfield units: by the grid's scale and offset, or by these
 * after 1024 is taken away, as some files leave it out (then air is near 0). The latter is claimed
 * only of integers with more than 256 different values that are distributed as those of a body are:
 * labels are not. Sets rescale. */
CVOL_API cvol_hounsfield cvol_hounsfield_guess(double rescale[2], const cvol_histogram *histogram,
                                               const cvol_grid *grid);

/* ---- rendering --------------------------------------------------------------------- */

/* The ways to a picture. */
typedef enum cvol_engine {
    CVOL_ENGINE_SHEET = 1,     /* from the compressed array, sheet by sheet */
    CVOL_ENGINE_RAY = 2,       /* from dense samples, ray by ray: the truth */
    CVOL_ENGINE_SPLAT = 3,     /* footprint by footprint: Westover's algorithm */
    CVOL_ENGINE_TRANSFORM = 4, /* the same on compressed transforms of slices: Chen and Reif's */
    CVOL_ENGINE_FOURIER = 5 /* mode xray alone: slices through the spectrum, O(N^2 log N) a view */
} cvol_engine;

/* What a picture shows of the samples along a ray. */
typedef enum cvol_mode {
    CVOL_MODE_COMPOSITE = 1, /* colour and opacity, front to back */
    CVOL_MODE_XRAY = 2, /* mean of the samples along the ray, over the window, white on black */
    CVOL_MODE_MIP = 3,  /* largest sample along the ray, over the window, white on black */
    CVOL_MODE_MIN = 4,  /* smallest sample along the ray, the same way */
    CVOL_MODE_ISO = 5   /* a surface, lit: see cvol_surface */
} cvol_mode;

/* The eye lies in direction (cos e sin a, -cos e cos a, sin e) of the centre of the box of sample
 * centres, for azimuth a and elevation e; +z is up; roll turns the camera counter-clockwise about
 * its viewing direction. Half the picture's height is half the diagonal of the box divided by zoom:
 * in parallel projection everywhere, in perspective as far away as the centre, from which the eye
 * is then so far that the picture's height spans fov_deg. The centre is that of the box, or what
 * the camera looks at, about which it then turns: look_at is the world's length from the box's
 * centre, at most 1000 diagonals. Or the eye is placed, which is told in the same way. In
 * perspective nothing is seen that is nearer to the eye, along
 * the viewing direction, than two mean spacings. Engines sheet and ray have perspective. */
typedef struct cvol_camera {
    double azimuth_deg, elevation_deg, roll_deg, zoom;
    double fov_deg; /* 0: parallel projection; else perspective, 1 to 150 */
    int placed;     /* in perspective: by eye and up instead of azimuth, elevation and zoom */
    double eye[3];
    double look_at[3]; /* what is in the picture's middle, of an eye without a place too */
    double up[3];      /* upwards in the picture; 0 0 0: +z, or +y of an eye that looks along z */
} cvol_camera;

/* What of the volume is drawn: the part of it that lies within the box and in front of all planes.
 * Cut faces are sharp: of a sample, or between two, what lies within counts. All zero is the whole
 * volume. Engines sheet and ray. */
#define CVOL_CLIP_PLANES 6
typedef struct cvol_clip {
    int axes; /* bit a: samples from[a] to to[a] of axis a, which may be fractions */
    double from[3], to[3];
    int planes;                        /* how many of these there are */
    double plane[CVOL_CLIP_PLANES][4]; /* what lies at least plane[k][3], in world length, in
                                          direction plane[k][0 .. 2] of the box's centre, is kept */
} cvol_clip;

/* "front back left right top bottom"; static storage. */
CVOL_API const char *cvol_view_names(void);
/* Sets the angles of a camera (not its zoom) to a named view, turned by turn_deg around the
 * vertical. If the grid says how it lies in a patient, the view is the patient's: from the front
 * with the patient's left on the right, from the top and the bottom with the front upwards.
 * *mirrored: the samples' axes are left-handed, so that the picture must be mirrored
 * (cvol_image_mirror) to show left and right as they are. In other grids front is at -y (azimuth
 * 0), right at +x (azimuth 90), back and left opposite, top at +z (elevation 90), bottom at -z.
 * Errors: ARGUMENT (no such view; the message lists them). */
CVOL_API int cvol_camera_named(cvol_context *context, cvol_camera *camera, int *mirrored,
                               const char *name, const cvol_grid *grid, double turn_deg);

/* A footprint is what one sample adds to the pixels around it: a function of the place in the
 * ellipse that a sample's kernel covers, (qx, qy) in samples, within |qx|, |qy| < size / 2. */
typedef enum cvol_footprint {
    CVOL_FOOTPRINT_GAUSSIAN = 1, /* exp(-(qx^2 + qy^2) / 2 sigma^2) */
    CVOL_FOOTPRINT_CONE = 2,     /* max(0, 1 - 2 |q| / size) */
    CVOL_FOOTPRINT_SINC = 3,     /* w(qx) w(qy), w(t) = sinc(pi t) cos^2(pi t / size) */
    CVOL_FOOTPRINT_BOX = 4       /* 1; its edges are soft over 1/8 of a sample */
} cvol_footprint;

/* Which ellipse that is. */
typedef enum cvol_footprint_plane {
    CVOL_FOOTPRINT_IN_VIEW = 1,  /* a round kernel's, as the view sees it */
    CVOL_FOOTPRINT_IN_SLICES = 2 /* round in the slices: they are composited on their own lattice,
                                    sheared, which one warp brings to the picture */
} cvol_footprint_plane;

/* In which order the splat engine composites sheets: the picture is the same, up to rounding. */
typedef enum cvol_order { CVOL_ORDER_FRONT = 1, CVOL_ORDER_BACK = 2 } cvol_order;

/* What the splat engine is asked for. */
typedef struct cvol_splat_options {
    cvol_footprint footprint;
    int size;                   /* samples that a footprint spans, 3 to 31 */
    double sigma;               /* of a Gaussian, in samples, 0.2 to 31; 0: size / 6 */
    cvol_footprint_plane plane; /* engine transform: always in slices */
    cvol_order order;
} cvol_splat_options;

/* Light, in mode composite of engines sheet, ray, splat and transform: Phong's model ("Illumination
 * for computer generated pictures", 1975). Of a colour F is seen
 *
 *     F (ambient + diffuse max(0, n l)) + specular max(0, r e)^shininess,   r = 2 (n l) n - l,
 *
 * n the direction of the gradient, turned towards the eye e (surfaces have two sides), and e itself
 * where there is no gradient; l is towards the light. The eye is as far away as in parallel
 * projection, in perspective too. The gradient is of central differences in the world, as long as
 * two samples, and interpolated as samples are; at the volume's faces, and beside samples without a
 * value, a difference is of those that there are. Engines splat and transform light samples, which
 * then are no brighter than 1.2. */
typedef struct cvol_shading {
    int on;          /* 0: colours as they are, and nothing else here matters */
    double light[3]; /* towards the light, in the world; 0 0 0: where the eye is */
    double ambient, diffuse, specular; /* 0 to 10 */
    int shininess;                     /* 1 to 256 */
    /* Above 0: where the gradient is shorter than this, in the samples' units a mean spacing,
     * matter is thinner in proportion: opacities are of so much of the length. 0: no matter. */
    double gradient_opacity;
} cvol_shading;

/* What mode iso shows: the first place of a ray at which the interpolated samples have the value or
 * more, opaque. It is lit by the shading of the options, whether that is on or not. */
typedef struct cvol_surface {
    double value;
    double colour[3]; /* R G B in 0..1 */
} cvol_surface;

/* How engine sheet reconstructs samples where a ray crosses a sheet of them: along both of its
 * axes, over the samples around; between two sheets by straight lines. Values stay within those of
 * the 4 x 4 samples around. Beside samples without a value, cubic ones lean on linear. */
typedef enum cvol_sheet_footprint {
    CVOL_SHEET_LINEAR = 0,      /* 2 x 2 samples */
    CVOL_SHEET_CATMULL_ROM = 1, /* 4 x 4: cubic, through the samples */
    CVOL_SHEET_B_SPLINE = 2,    /* 8 x 8: the smooth cubic B-spline, prefiltered, so that it goes
                                   through samples that vary slowly; it takes 22 % of the finest
                                   detail, less than 1 % of what is twice as coarse */
    CVOL_SHEET_GAUSSIAN = 3     /* 6 x 6: exp(-q^2 / 2 sigma^2), over its sum: it blurs */
} cvol_sheet_footprint;

/* Which rays pictures are drawn along. In mode composite, in parallel projection, at level
 * 0, with linear footprints, where all samples have a value and oversample is 1, they can be those
 * of the picture's own pixels: nothing is resampled then. (Lit, where the processor has AVX-512,
 * and no axis has one sample.)
 * All else is drawn along a lattice that lies along the samples, from which the picture is
 * interpolated: up to twice as fast. What is opaque, or thin, comes out 2 to 14 dB further from its
 * truth so; what is clear 0 to 3 dB, at 40 dB and more, where it is not seen. CVOL_SHEET_RAYS_AUTO
 * takes the lattice if that is so: if the transfer function stays below an opacity of 0.45, and as
 * good as straight (0.05) over every 7 % of its span, unless there is light and opacity changes
 * from sample to sample by a third of what it is; or if the samples' own error, of compression,
 * changes opacity by a tenth; but not if a pixel spans more than 1.45 samples, or step_voxels is
 * given. Angles do not change it. What is clear, and means and extremes along rays, are then drawn
 * from rays that lie 1.5 pixels apart, though not further than samples do, if oversample is 1 and
 * no plane cuts them. Where a pixel spans less than 0.55 samples, light is found twice a slice.
 * Unlit and along pixels, opaque matter (0.45 or more) is looked at more closely along rays where
 * that error changes opacity by 0.005 or less: up to 6 dB nearer; and what is clear but rough goes
 * along pixels where it changes opacity by 0.001 or less. */
typedef enum cvol_sheet_rays {
    CVOL_SHEET_RAYS_AUTO = 0,   /* as said above */
    CVOL_SHEET_RAYS_PIXELS = 1, /* those of the picture's pixels, where that is possible */
    CVOL_SHEET_RAYS_LATTICE = 2 /* those of a lattice along the samples */
} cvol_sheet_rays;

/* What the sheet engine is asked for. */
typedef struct cvol_sheet_options {
    cvol_sheet_footprint footprint;
    double sigma;         /* of a Gaussian, in samples, 0.5 to 1; 0: 5/6 */
    cvol_sheet_rays rays; /* along which they are drawn */
} cvol_sheet_options;

/* When the transform engine goes back to coefficients. */
typedef enum cvol_schedule {
    CVOL_SCHEDULE_DEFERRED = 1, /* never: slices are evaluated, and composited as samples */
    CVOL_SCHEDULE_LITERAL = 2   /* after every operation, truncating each time: as published */
} cvol_schedule;

/* What the transform engine is asked for; footprint (Gaussian, sinc or box) and order are those of
 * splat. */
typedef struct cvol_transform_options {
    cvol_transform transform; /* of planes: DCT; whole ones also DFT and DHT */
    int tile;                 /* planes are in tiles of 8, 16 or 32 samples a side; 0: whole */
    double rho;               /* terms kept over samples: of all planes together (tiles), or places
                                 of each (whole); 1 or more: all that are not 0 */
    cvol_schedule schedule;
    double stored_rho; /* planes are made with so many terms, if that is more; pictures use rho */
} cvol_transform_options;

/* What the fourier engine is asked for. */
typedef struct cvol_fourier_options {
    double depth_cue; /* 0..1: how much darker the far end of the volume's diagonal is */
    int integrals;    /* of cvol_renderer_project: along rays, in world length, not means */
} cvol_fourier_options;

/* What a picture shall be; begin with cvol_render_options_defaults(). */
typedef struct cvol_render_options {
    int width, height; /* pixels */
    cvol_mode mode;
    cvol_camera camera;
    int level;            /* engine sheet: 0: the volume as it is; 1, 2, 3: every 2nd, 4th, 8th
                             sample of it, from the lowest frequencies, for quick pictures */
    double step_voxels;   /* sample distance along the ray in mean spacings; 0: the engine's
                             own (ray: 0.5; sheet: one a slice, by straight lines between). Engine
                             sheet, modes composite and iso: at most that, but no more than four
                             samples a slice; where it is two slices or more, one every other slice,
                             in all modes */
    double oversample;    /* engine sheet: as many lines and columns of rays for one of the picture,
                             0.25 to 4; 0 is 1. Fewer than 1 is quicker and softer */
    double keep_mb;       /* engine sheet: what is evaluated for a picture is kept by the renderer,
                             up to so many MB, for the next ones, which are the same as without
                             and take less time; 0: nothing is */
    double background[3]; /* R G B in 0..1 */
    double window[2]; /* modes xray, mip and min: the values that are black and white, the second
                         larger; 0 0: the smallest and the largest sample */
    cvol_shading shading;
    cvol_surface surface;
    cvol_sheet_options sheet; /* of engine sheet */
    cvol_splat_options splat;
    cvol_transform_options transform;
    cvol_fourier_options fourier;
    cvol_clip clip;
} cvol_render_options;

/* 512 x 512, composite, azimuth 0, elevation 0, zoom 1, black; sheets: linear; splats: Gaussian, 5
 * samples wide, in the view, front to back; unlit, and when lit 0.1 ambient, 0.7 diffuse, 0.2
 * specular, shininess 10, by a light where the eye is; transforms: DCT in tiles of 16, a tenth of
 * the terms, deferred.
 */
CVOL_API cvol_render_options cvol_render_options_defaults(void);

/* Samples without a value (arrays with a mask) are transparent, in all modes: what lies between
 * samples is interpolated from those around it that have a value, and counts by their weight:
 * opacities are of so much of the length, means weighted so, and largest samples sought where that
 * is at least half. Rays that meet none are background. Splats of them are left out.
 *
 * A renderer keeps what frames of one volume share. One thread at a time. */
typedef struct cvol_renderer cvol_renderer;

/* What a renderer draws: one of `array`, `volume` and `baked_path`; the others are NULL. */
typedef struct cvol_source {
    size_t size;               /* sizeof(cvol_source) */
    const cvol_array *array;   /* a compressed volume in DCT blocks */
    const cvol_volume *volume; /* dense samples; NaN counts as the smallest sample */
    const char *baked_path;    /* a file of cvol_renderer_bake */
    const uint8_t *mask; /* engine ray: one byte a sample, x fastest; samples whose byte is not
                            0 have no value (cvol_array_evaluate_mask). NULL: all have one */
    double rho;          /* engine fourier: the share of frequencies to keep; 0: all */
} cvol_source;
/* A source in a call, in C: CVOL_SOURCE(.array = array). */
#define CVOL_SOURCE(...) (&(const cvol_source){.size = sizeof(cvol_source), __VA_ARGS__})

/* Creates a renderer. The array, the volume and the mask must outlive it; the caller frees *out.
 * Sources by engine: sheet: array; ray: volume; splat and fourier: array or volume; transform:
 * array, volume or baked_path. Errors: ARGUMENT (an engine or a source that is none, a source that
 * the engine does not draw, a size that this library does not know), UNSUPPORTED (an array that is
 * no volume in DCT blocks), LIMIT, MEMORY, CANCELLED; of baked_path also IO, FORMAT, CORRUPT.
 *
 * CVOL_ENGINE_SHEET draws straight from the compressed array. Cost: it finds once what can be seen
 * where; it evaluates samples when it draws a picture.
 *
 * CVOL_ENGINE_RAY casts rays through dense samples, and is the reference of the others.
 *
 * CVOL_ENGINE_SPLAT splats (Westover, "Footprint evaluation for volume rendering", 1990), mode
 * composite only: it classifies and lights samples, adds up their footprints slice by slice of the
 * axis most parallel to the view, and composites the slices,
 *
 *     I += (1 - A) sum w F D,  A += (1 - A) sum w D,   D = 1 - (1 - opacity)^distance,
 *
 * w being the footprints' weights at a pixel, which sum to 1 within the volume. It evaluates
 * samples of an array slab by slab, about 130 MB at a time. Cost of a picture: one evaluation of
 * all samples, and for each that is not transparent size^2 pixels (of samples' size).
 *
 * CVOL_ENGINE_TRANSFORM splats on compressed transforms (Chen and Reif, "Fast and compact volume
 * rendering in the compressed transform domain", 2003), mode composite only. It classifies and
 * lights samples as engine splat does. Intensity C (times opacity; red, green, blue) and opacity D
 * of each slice become compressed arrays of rank 2, in tiles or whole. The engine spreads these by
 * the footprint, shifts them to where the view has them, and composites them on one grid,
 *
 *     front to back   I += (1 - A) C,  A += (1 - A) D
 *     back to front   I = (1 - D) I + C,  A = (1 - D) A + D
 *
 * by products of arrays (literal) or of samples (deferred); one warp makes the picture. Under wide
 * Gaussians it evaluates tiles at every other or every fourth place. It keeps what it made of
 * slices as long as transfer function, direction and light stay, and fewer terms are asked for.
 * Cost: N log N for the slices, as often as they change; then O(n') a slice and operation
 * (literal), or n log n a slice (deferred), n places and n' terms. Over a baked file it draws all
 * directions along which a ray crosses the slices of the file's axis (both ends, sheared; opacities
 * are changed to the distance of slices along the view), with the strongest rho of the stored
 * terms. Options must agree with the file: another transfer function, light, transform, more terms,
 * a direction of another axis, a footprint larger than a slice are refused by ARGUMENT.
 *
 * CVOL_ENGINE_FOURIER uses the Fourier slice theorem (Malzbender, "Fourier volume rendering",
 * 1993), mode xray only: a picture is a plane through the volume's spectrum, transformed back. It
 * differs from engine ray's by what is finer than pixels and samples. The renderer holds the
 * spectrum of all samples, padded to 3/2 of each axis, as half floats: 7 bytes a sample, twice as
 * much with a mask, and three times as much while it is made. With rho above 0 only the strongest
 * frequencies stay, rho / 2 for each sample (of conjugate pairs one), in 4 bytes each and 0.24 a
 * sample, and a picture unpacks what its plane passes through. Cost: N log N once, and for a
 * picture O(P log P + 216 P), P the points of the volume's shadow, whatever the volume's depth. */
CVOL_API int cvol_renderer_create(cvol_context *context, cvol_renderer **out, cvol_engine engine,
                                  const cvol_source *source);
/* Bakes what a renderer of engine transform draws into a file: its planes of all slices across
 * `axis` (0 x, 1 y, 2 z), with the transfer function that was set, light, footprint, transform
 * (DCT) and rho of the options; opacities are for the axis' own direction. Light is that of an eye
 * in this direction, of the default material (else UNSUPPORTED). Planes are rounded, by which a
 * quarter is added to the energy that truncation lost. transfer_name (or NULL) is kept for people.
 * file_bytes may be NULL. Errors: ARGUMENT (also a footprint larger than a slice, rho 0 or above
 * 1), UNSUPPORTED (DFT and DHT, whose planes serve one direction), LIMIT, IO, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_bake(cvol_context *context, cvol_renderer *renderer, const char *path,
                                int axis, const char *transfer_name,
                                const cvol_render_options *options, uint64_t *file_bytes);
/* What a baked file holds. */
typedef struct cvol_baked_info {
    cvol_grid grid; /* shape, type and spacing of the volume */
    int axis;
    size_t slices, visible; /* all; those with anything to be seen */
    int channels;           /* of colour: 3, or 1: grey */
    cvol_transform transform;
    int tile;
    double rho, kept, step; /* asked for; terms over samples; what they are multiples of */
    uint64_t terms, resident_bytes;
    cvol_splat_options splat; /* footprint */
    cvol_shading shading;     /* whether lit and from where; the rest is as by default */
    char transfer_name[32];   /* "": none was given */
    const cvol_transfer_point *transfer_points; /* the renderer's */
    size_t transfer_count;
} cvol_baked_info;
/* What the renderer's file holds. Errors: ARGUMENT (not over a baked volume). */
CVOL_API int cvol_renderer_baked_info(cvol_context *context, const cvol_renderer *renderer,
                                      cvol_baked_info *out);
/* What the last picture of a transform renderer took. */
typedef struct cvol_transform_report {
    size_t lattice[2], slices; /* slices: those with anything to be seen */
    double step;               /* samples from place to place of the lattice */
    uint64_t terms, bytes;     /* of all slices' planes, and in memory */
    double rho;                /* terms over samples of these planes */
    uint64_t multiply_adds;    /* of spreading and compositing: tiles, deferred, as they were done;
                                  else by formula, a transform of n samples as n log2 n */
    double bound;  /* on the root mean square over the lattice of the error of intensity (all
                      channels) that truncation makes */
    int certified; /* whether it is proved: for footprints without negative weights */
    double bake_ms, compose_ms; /* bake_ms is 0 if slices were kept from a picture before */
} cvol_transform_report;
/* Multiply-adds of a splat renderer's last picture: of pixels of footprints, and of sheets onto the
 * picture. Errors: ARGUMENT (another engine). */
CVOL_API int cvol_renderer_splat_multiply_adds(cvol_context *context, const cvol_renderer *renderer,
                                               uint64_t *out);
/* Draws a picture by engine sheet and counts its multiply-adds, by kernels that are told to: those
 * of evaluating blocks, by the boxes of their frequencies, four for each interpolated sample and
 * eight for each part of an interval that is composited; not those of faces of lapped arrays and of
 * the warp. In mode composite, unlit, level 0. Errors: those of cvol_renderer_render, ARGUMENT
 * (another engine, mode or level). */
CVOL_API int cvol_renderer_sheet_multiply_adds(cvol_context *context, cvol_renderer *renderer,
                                               cvol_image *image,
                                               const cvol_render_options *options, uint64_t *out);
/* What the last picture took. Errors: ARGUMENT (another engine, or no picture yet). */
CVOL_API int cvol_renderer_transform_report(cvol_context *context, const cvol_renderer *renderer,
                                            cvol_transform_report *out);
/* Views in the data's own units: out[x + width (y + height i)], y = 0 on top, is the mean of the
 * samples along a ray of view i, and the least sample where it misses the volume; or, with
 * options->fourier.integrals, the integral, and 0. A rotation (w, x, y, z), a quaternion of any
 * length, turns a camera that looks along -z with y up: its columns are right, up and the direction
 * of the eye. Zoom and size are options'. Engine fourier only; each thread makes whole views, which
 * have the same bits for any number of threads. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_project(cvol_context *context, cvol_renderer *renderer, float *out,
                                   const cvol_render_options *options, const double (*rotations)[4],
                                   size_t count);
/* The rotation of a camera of these angles. */
CVOL_API void cvol_camera_rotation(double rotation[4], const cvol_camera *camera);
/* What a fourier renderer holds. */
typedef struct cvol_fourier_report {
    size_t padded[3];
    uint64_t places, bytes; /* of the spectrum: complex numbers, and in memory */
    double build_ms;
} cvol_fourier_report;
/* What it holds. Errors: ARGUMENT (another engine). */
CVOL_API int cvol_renderer_fourier_report(cvol_context *context, const cvol_renderer *renderer,
                                          cvol_fourier_report *out);
/* Bytes that it keeps of what it evaluated (keep_mb of its last picture); 0 of engines other than
 * sheet. */
CVOL_API uint64_t cvol_renderer_kept_bytes(const cvol_renderer *renderer);
/* Frees a renderer; NULL is allowed. What it draws stays. */
CVOL_API void cvol_renderer_free(cvol_renderer *renderer);
/* The values that are black and white in modes xray, mip and min when no window is given. Errors:
 * ARGUMENT (an engine that has only mode composite). */
CVOL_API int cvol_renderer_range(cvol_context *context, const cvol_renderer *renderer,
                                 double range[2]);
/* *out is the coarsest level of a volume's file (cvol_file_part.level) from which engine sheet
 * makes the picture that options ask for, at options->level 0, with next to no loss: 1 for volumes
 * of 2^27 samples and more where pixels span 2.86 samples along every axis, but in mode iso;
 * otherwise 0. Errors: ARGUMENT (a camera that is none). */
CVOL_API int cvol_render_file_level(cvol_context *context, int *out, const cvol_grid *grid,
                                    const cvol_render_options *options);
/* Sets the transfer function of mode composite; it is copied. Errors: ARGUMENT (a baked volume has
 * another one), MEMORY. */
CVOL_API int cvol_renderer_set_transfer(cvol_context *context, cvol_renderer *renderer,
                                        const cvol_transfer *transfer);
/* Renders one picture into `image`, which is created by the caller with the options' size: bytes,
 * every pixel opaque over the background; or floats, as they were computed, over none; and its
 * depths, if it has room for them (cvol_image_add_depth: engines sheet and ray, modes composite and
 * iso). Bit-identical for any number of threads. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_render(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options);
/* Called after each picture that is drawn, coarse ones first; not 0: that will do. */
typedef int (*cvol_picture_fn)(void *user, const cvol_image *image, int level);
/* What came of it. */
typedef struct cvol_refine_report {
    int level;         /* of the picture */
    double picture_ms; /* it alone took */
    double total_ms;   /* all took, callbacks included */
} cvol_refine_report;
/* The same by engine sheet, at the finest level (options->level or coarser) that a budget of
 * milliseconds allows: level 3, then finer ones as long as what they are foretold to take fits into
 * what is left; one that takes longer is given up, and the picture before it stays. At least one
 * is drawn, however long it takes. A renderer remembers what levels took: without `drawn` (which,
 * and report, may be NULL) it begins with the finest that fits. A level's samples are made when it
 * is first drawn, which counts. Progress is told of each picture. Errors: those of rendering. */
CVOL_API int cvol_renderer_refine(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options, double budget_ms,
                                  cvol_picture_fn drawn, void *user, cvol_refine_report *report);
/* The same picture of a transform renderer, kept compressed: planes on the lattice on which slices
 * were composited. They are in tiles as `picture` says, or, of the literal schedule, in the
 * transform in which they came to be. The target is held against the picture as it is rendered.
 * The caller frees *out. Errors: those of rendering and of cvol_picture_compress; ARGUMENT (another
 * engine). */
CVOL_API int cvol_renderer_picture(cvol_context *context, cvol_renderer *renderer,
                                   cvol_picture **out, const cvol_render_options *options,
                                   const cvol_picture_options *picture);

#ifdef __cplusplus
}
#endif
#endif
