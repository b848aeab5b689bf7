/* cvol/render.h - pictures of volumes, from their compressed form.
 *
 * World coordinates of the camera: sample (x, y, z) is at (x, y, z) times the spacing of the grid.
 * Origin and axis directions of the grid are stored in files, but do not turn the picture. */
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

/* A transfer function: from sample values to colour and opacity. */
typedef struct cvol_transfer cvol_transfer;

/* One control point: a sample value, with colour and opacity in 0..1. Opacity is for a length of
 * one mean sample spacing; along a length of d mean spacings it becomes 1 - (1 - opacity)^d. */
typedef struct cvol_transfer_point {
    double value, r, g, b, opacity;
} cvol_transfer_point;

/* Makes a transfer function: linear between the points (sorted by value; two points with the same
 * value make a jump), constant outside. At least one point. The caller frees *out. Errors:
 * ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create(cvol_context *context, cvol_transfer **out,
                                  const cvol_transfer_point *points, size_t count);
/* Reads {"points": [[value, r, g, b, opacity], ...]} or the JSON of ParaView's colour maps. Errors:
 * IO, FORMAT, MEMORY. */
CVOL_API int cvol_transfer_read(cvol_context *context, cvol_transfer **out, const char *path);
/* Reads the text of such a file; `name` begins the message of an error. Errors: FORMAT, MEMORY. */
CVOL_API int cvol_transfer_parse(cvol_context *context, cvol_transfer **out, const char *text,
                                 size_t size, const char *name);
/* Frees a transfer function; NULL is allowed. */
CVOL_API void cvol_transfer_free(cvol_transfer *transfer);
/* The number of points. */
CVOL_API size_t cvol_transfer_count(const cvol_transfer *transfer);
/* Point `index`, from 0, sorted by value. */
CVOL_API cvol_transfer_point cvol_transfer_get(const cvol_transfer *transfer, size_t index);

/* Histogram of the samples of a volume: CVOL_HISTOGRAM_BINS equal intervals of min..max. A value
 * that is a thousand times as far from all others as these are apart marks missing samples: it does
 * not count, nor do NaN and infinity. Counts are rounded to quarters of octaves, and volumes of
 * fewer than 2^20, 2^17, 2^14, 2^11 samples have 128, 64, 32, 16 different counts, each for 2, 4,
 * 8, 16 bins. So a .cvol file stores the same histogram, in a few bytes. */
#define CVOL_HISTOGRAM_BINS 256
typedef struct cvol_histogram {
    double min, max;
    uint64_t bins[CVOL_HISTOGRAM_BINS];
    double chord;        /* mean length of a ray through the volume, in mean spacings; 0: unknown */
    double mark;         /* the value that marks missing samples, if mark_count > 0 */
    uint64_t mark_count; /* number of missing samples */
    int integers;        /* 1: all samples are integers */
    int distinct;        /* number of different values; 0: more than 256, or unknown */
} cvol_histogram;
/* Make a histogram. Of an array: that of the samples it was compressed from, for any ratio, level
 * or part of a file; if the array has none (a result of operations, a file of an early version),
 * from at most 1,024 of its blocks, decoded. Of a volume: from all samples. Errors: UNSUPPORTED
 * (not an array of rank 3 in DCT blocks), ARGUMENT, MEMORY. */
CVOL_API int cvol_array_histogram(cvol_context *context, cvol_histogram *out,
                                  const cvol_array *array);
CVOL_API int cvol_volume_histogram(cvol_context *context, cvol_histogram *out,
                                   const cvol_volume *volume);

/* Makes a named transfer function, fitted to a histogram: "auto", "gray", "bone", "skin-bone",
 * "mri", "microscopy", "hot", "viridis", ... Errors: ARGUMENT (the message lists the names),
 * MEMORY. */
CVOL_API int cvol_transfer_create_named(cvol_context *context, cvol_transfer **out,
                                        const char *name, const cvol_histogram *histogram);
/* "auto gray bone ..."; static storage. */
CVOL_API const char *cvol_transfer_names(void);

/* Makes a transfer function from another one: moves the points linearly so that the first is at
 * window[0] and the last at window[1] (NULL: not), and multiplies the density: opacities become 1 -
 * (1 - opacity)^opacity_scale. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_adjusted(cvol_context *context, cvol_transfer **out,
                                           const cvol_transfer *from, const double *window,
                                           double opacity_scale);

/* Makes a transfer function in Hounsfield units, for computed tomography: "ct-bone", "ct-skin",
 * "ct-lung", "ct-vessels" (with contrast agent). A sample s means rescale[0] s + rescale[1] of
 * them. Errors: ARGUMENT (the message lists the names), MEMORY. */
CVOL_API int cvol_transfer_create_ct(cvol_context *context, cvol_transfer **out, const char *name,
                                     const double rescale[2]);
/* 1 if the name is that of a transfer function in Hounsfield units. */
CVOL_API int cvol_transfer_is_ct(const char *name);
/* "ct-bone ct-skin ..."; static storage. */
CVOL_API const char *cvol_transfer_ct_names(void);

/* Results of cvol_hounsfield_guess. */
typedef enum cvol_hounsfield {
    CVOL_HOUNSFIELD_NO = 0,
    CVOL_HOUNSFIELD_YES = 1,
    CVOL_HOUNSFIELD_SHIFTED = 2
} cvol_hounsfield;
/* Guesses whether the values of a volume are Hounsfield units. YES: by the scale and offset of the
 * grid. SHIFTED: after subtraction of 1024, which some files omit (air is then near 0); only for
 * integers with more than 256 different values whose distribution is like that of a body, so not
 * for labels. Sets rescale. */
CVOL_API cvol_hounsfield cvol_hounsfield_guess(double rescale[2], const cvol_histogram *histogram,
                                               const cvol_grid *grid);

/* ---- rendering --------------------------------------------------------------------- */

/* Engines: methods of drawing. */
typedef enum cvol_engine {
    CVOL_ENGINE_SHEET = 1,     /* from the compressed array, slice by slice */
    CVOL_ENGINE_RAY = 2,       /* from dense samples, ray by ray: the reference */
    CVOL_ENGINE_SPLAT = 3,     /* footprint by footprint: Westover's algorithm */
    CVOL_ENGINE_TRANSFORM = 4, /* the same on compressed transforms of slices: Chen and Reif */
    CVOL_ENGINE_FOURIER = 5 /* mode xray only: slices through the spectrum, O(N^2 log N) per view */
} cvol_engine;

/* Modes: how the samples along a ray give a pixel. */
typedef enum cvol_mode {
    CVOL_MODE_COMPOSITE = 1, /* colour and opacity, front to back */
    CVOL_MODE_XRAY = 2,      /* mean of the samples along the ray, in the window, white on black */
    CVOL_MODE_MIP = 3,       /* largest sample along the ray, in the window, white on black */
    CVOL_MODE_MIN = 4,       /* smallest sample along the ray, likewise */
    CVOL_MODE_ISO = 5        /* a lit surface, see cvol_surface */
} cvol_mode;

/* The camera. For azimuth a and elevation e the eye is in direction (cos e sin a, -cos e cos a, sin
 * e) of the centre; +z is up; roll turns the camera counter-clockwise about its viewing direction.
 * The centre is that of the box of sample centres, plus look_at (world length, at most 1000
 * diagonals of the box).
 *
 * In parallel projection, half the height of the picture is half the diagonal of the box divided by
 * zoom. In perspective this holds at the distance of the centre; the eye is so far away that the
 * height of the picture spans fov_deg. Points nearer to the eye than two mean spacings, along the
 * viewing direction, are not drawn. With `placed`, eye and up replace azimuth, elevation and zoom.
 * Engines sheet and ray have perspective. */
typedef struct cvol_camera {
    double azimuth_deg, elevation_deg, roll_deg, zoom;
    double fov_deg; /* 0: parallel projection; else perspective, 1 to 150 degrees */
    int placed;     /* 1, in perspective: use eye and up instead of azimuth, elevation and zoom */
    double eye[3];
    double look_at[3]; /* the point at the centre of the picture, from the centre of the box */
    double up[3]; /* direction that is up in the picture; 0 0 0: +z, or +y for an eye that looks
                     along z */
} cvol_camera;

/* The part of a volume that is drawn: inside the box, and in front of all planes. Cut faces are
 * sharp, also between two samples. All zero: the whole volume. Engines sheet and ray. */
#define CVOL_CLIP_PLANES 6
typedef struct cvol_clip {
    int axes; /* bit a: only samples from[a] to to[a] of axis a, which may be fractions */
    double from[3], to[3];
    int planes;                        /* number of planes */
    double plane[CVOL_CLIP_PLANES][4]; /* draw only points at least plane[k][3] (world length) from
                                          the centre of the box in direction plane[k][0 .. 2] */
} cvol_clip;

/* "front back left right top bottom"; static storage. */
CVOL_API const char *cvol_view_names(void);
/* Sets the angles of a camera (not its zoom) to a named view, turned by turn_deg around the
 * vertical. If the grid has a patient orientation, the view is that of the patient, as in
 * radiology: from the front the patient's left is on the right, from top and bottom the front is
 * up. *mirrored: the axes of the samples are left-handed, so the picture must be mirrored
 * (cvol_image_mirror). In other grids front is at -y (azimuth 0), right at +x (azimuth 90), back
 * and left opposite, top at +z (elevation 90), bottom at -z. Errors: ARGUMENT (unknown view; the
 * message lists them). */
CVOL_API int cvol_camera_named(cvol_context *context, cvol_camera *camera, int *mirrored,
                               const char *name, const cvol_grid *grid, double turn_deg);

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

/* Light in mode composite of engines sheet, ray, splat and transform: Phong's model ("Illumination
 * for computer generated pictures", 1975). A sample of colour F gets the colour
 *
 *     F (ambient + diffuse max(0, n l)) + specular max(0, r e)^shininess,   r = 2 (n l) n - l,
 *
 * where l is the direction of the light, e that of the eye, and n that of the gradient, turned
 * towards e (surfaces have two sides); n = e where there is no gradient. e is that of parallel
 * projection, in perspective too. The gradient is by central differences in the world, over two
 * samples, and interpolated like samples; at faces of the volume, and next to samples without a
 * value, by one-sided differences. Engines splat and transform light samples, and limit the result
 * to 1.2. */
typedef struct cvol_shading {
    int on;          /* 0: no light; the other fields do not matter */
    double light[3]; /* direction of the light in the world; 0 0 0: that of the eye */
    double ambient, diffuse, specular; /* 0 to 10 */
    int shininess;                     /* 1 to 256 */
    /* Above 0: density falls in proportion where the gradient is shorter than this, in units of
     * samples per mean spacing; it is 0 where the gradient is 0. */
    double gradient_opacity;
} cvol_shading;

/* The surface of mode iso: the first place of a ray where the interpolated samples reach the value;
 * opaque, and lit by the shading of the options even if that is off. */
typedef struct cvol_surface {
    double value;
    double colour[3]; /* R G B in 0..1 */
} cvol_surface;

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
                   planes); 1 or more: all nonzero terms */
    cvol_schedule schedule;
    double
        stored_rho; /* if larger than rho: planes keep this share of terms, and pictures use rho */
} cvol_transform_options;

/* Options of engine fourier. */
typedef struct cvol_fourier_options {
    double depth_cue; /* 0..1: how much darker the far end of the diagonal is */
    int integrals;    /* 1: cvol_renderer_project computes integrals along rays, in world length,
                         instead of means */
} cvol_fourier_options;

/* Options of a picture; start with cvol_render_options_defaults(). */
typedef struct cvol_render_options {
    int width, height; /* pixels */
    cvol_mode mode;
    cvol_camera camera;
    int level; /* engine sheet: 0: full resolution; 1, 2, 3: every 2nd, 4th, 8th sample, from the
                  lowest frequencies, for fast pictures */
    double step_voxels; /* distance of samples along the ray in mean spacings; 0: the default of the
                           engine (ray: 0.5; sheet: one per slice, linear between slices). Engine
                           sheet, modes composite and iso: at most this distance, and at most four
                           samples per slice; from two slices on one sample every other slice, in
                           all modes */
    double oversample; /* engine sheet: rays per pixel along each axis, 0.25 to 4; 0: 1. Less than 1
                          is faster and softer */
    double keep_mb; /* engine sheet: block cache size in MB; 0: off. Changes speed, never pixels */
    double background[3]; /* R G B in 0..1 */
    double window[2]; /* modes xray, mip and min: the values of black and white, the second larger;
                         0 0: the smallest and the largest sample */
    cvol_shading shading;
    cvol_surface surface;
    cvol_sheet_options sheet; /* options of engine sheet */
    cvol_splat_options splat;
    cvol_transform_options transform;
    cvol_fourier_options fourier;
    cvol_clip clip;
} cvol_render_options;

/* 512 x 512, composite, azimuth 0, elevation 0, zoom 1, black. Engine sheet: linear filter. Engine
 * splat: Gaussian, 5 samples wide, in the view, front to back. No light; with light: ambient 0.1,
 * diffuse 0.7, specular 0.2, shininess 10, direction of the eye. Engine transform: DCT in tiles of
 * 16, a tenth of the terms, deferred. */
CVOL_API cvol_render_options cvol_render_options_defaults(void);

/* A renderer. It keeps data that pictures of one volume share. One thread at a time may use it.
 *
 * Samples without a value (arrays with a mask) are transparent in all modes. Interpolation uses
 * only the samples around that have a value, and weights the result by their share: opacities and
 * means are weighted, and largest samples count where the share is at least one half. Rays that
 * meet no sample with a value show the background. Engine splat omits missing samples. */
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
    cvol_grid grid; /* shape, type and spacing of the original volume */
    int axis;
    size_t slices, visible; /* all slices; slices that are not empty */
    int channels;           /* colour channels: 3, or 1 (grey) */
    cvol_transform transform;
    int tile;
    double rho, kept, step; /* the option; terms divided by samples; quantizer step of the terms */
    uint64_t terms, resident_bytes;
    cvol_splat_options splat; /* footprint */
    cvol_shading shading;     /* on and light; the other fields have default values */
    char transfer_name[32];   /* "": no name */
    const cvol_transfer_point *transfer_points; /* owned by the renderer */
    size_t transfer_count;
} cvol_baked_info;
/* Describes the baked volume of a renderer. Errors: ARGUMENT (not over a baked volume). */
CVOL_API int cvol_renderer_baked_info(cvol_context *context, const cvol_renderer *renderer,
                                      cvol_baked_info *out);
/* Counts and times of the last picture of engine transform. */
typedef struct cvol_transform_report {
    size_t lattice[2], slices; /* places of the lattice; number of slices that are not empty */
    double step;               /* distance of places of the lattice, in samples */
    uint64_t terms, bytes;     /* terms of the planes of all slices; their bytes in memory */
    double rho;                /* terms divided by samples of these planes */
    uint64_t multiply_adds;    /* multiply-adds of footprints and compositing: counted (tiles,
                                  deferred), else by formula, n log2 n for a transform of n samples */
    double bound;  /* bound of the root mean square error, over the lattice, of intensity (all
                      channels) by truncation */
    int certified; /* 1: the bound is proven: for footprints without negative weights */
    double bake_ms,
        compose_ms; /* milliseconds; bake_ms is 0 if the slices were kept from an earlier picture */
} cvol_transform_report;
/* Counts the multiply-adds of the last picture of engine splat: of the pixels of footprints, and of
 * compositing slices. Errors: ARGUMENT (another engine). */
CVOL_API int cvol_renderer_splat_multiply_adds(cvol_context *context, const cvol_renderer *renderer,
                                               uint64_t *out);
/* Draws a picture by engine sheet with counting kernels, and counts multiply-adds: of evaluating
 * blocks, by the boxes of their frequencies; four per interpolated sample; eight per segment of a
 * ray interval that is composited. It does not count the filters of lapped arrays and the warp.
 * Mode composite, no light, level 0. Errors: those of cvol_renderer_render, ARGUMENT (another
 * engine, mode or level). */
CVOL_API int cvol_renderer_sheet_multiply_adds(cvol_context *context, cvol_renderer *renderer,
                                               cvol_image *image,
                                               const cvol_render_options *options, uint64_t *out);
/* Returns these for the last picture. Errors: ARGUMENT (another engine, or no picture yet). */
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
/* Sets the rotation of a camera with these angles. */
CVOL_API void cvol_camera_rotation(double rotation[4], const cvol_camera *camera);
/* Size of the spectrum of engine fourier. */
typedef struct cvol_fourier_report {
    size_t padded[3];
    uint64_t places, bytes; /* complex numbers of the spectrum; bytes in memory */
    double build_ms;
} cvol_fourier_report;
/* Returns it. Errors: ARGUMENT (another engine). */
CVOL_API int cvol_renderer_fourier_report(cvol_context *context, const cvol_renderer *renderer,
                                          cvol_fourier_report *out);
/* Bytes in the block cache (keep_mb of the last picture); 0 for engines other than sheet. */
CVOL_API uint64_t cvol_renderer_kept_bytes(const cvol_renderer *renderer);
/* Frees a renderer, but not the array or volume that it draws; NULL is allowed. */
CVOL_API void cvol_renderer_free(cvol_renderer *renderer);
/* Sets range to the values of black and white in modes xray, mip and min without a window. Errors:
 * ARGUMENT (an engine that has only mode composite). */
CVOL_API int cvol_renderer_range(cvol_context *context, const cvol_renderer *renderer,
                                 double range[2]);
/* Sets *out to the coarsest level of a file (cvol_file_part.level) from which engine sheet draws
 * this picture, at options->level 0, almost without loss: 1 for volumes of 2^27 samples and more if
 * pixels span 2.86 samples along every axis, except in mode iso; else 0. Errors: ARGUMENT (invalid
 * camera). */
CVOL_API int cvol_render_file_level(cvol_context *context, int *out, const cvol_grid *grid,
                                    const cvol_render_options *options);
/* Sets the transfer function of mode composite, and copies it. Errors: ARGUMENT (a baked volume has
 * another one), MEMORY. */
CVOL_API int cvol_renderer_set_transfer(cvol_context *context, cvol_renderer *renderer,
                                        const cvol_transfer *transfer);
/* Renders one picture into `image`, which the caller created with the size in the options. Bytes:
 * every pixel opaque over the background. Floats: not rounded, over no background. Also depths, if
 * the image has room for them (cvol_image_add_depth; engines sheet and ray, modes composite and
 * iso). Same bits for any number of threads. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_render(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options);
/* Receives each picture, from coarse to fine; a nonzero result ends the refinement. */
typedef int (*cvol_picture_fn)(void *user, const cvol_image *image, int level);
/* Results of cvol_renderer_refine. */
typedef struct cvol_refine_report {
    int level;         /* level of the picture */
    double picture_ms; /* milliseconds for this picture */
    double total_ms;   /* milliseconds in all, with callbacks */
} cvol_refine_report;
/* Renders by engine sheet at the finest level (options->level or coarser) that a time budget
 * allows. It draws level 3, then finer ones as long as their predicted time fits into the rest of
 * the budget; a picture that takes longer is abandoned, and the one before stays. It draws at least
 * one. The renderer remembers the times of levels: without `drawn` (which may be NULL, like report)
 * it starts with the finest level that fits. The first picture of a level includes the time to make
 * its samples. Progress is reported for each picture. Errors: those of cvol_renderer_render. */
CVOL_API int cvol_renderer_refine(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options, double budget_ms,
                                  cvol_picture_fn drawn, void *user, cvol_refine_report *report);
/* Renders a picture by engine transform and keeps it compressed: planes on the lattice on which
 * slices were composited, in tiles as `picture` says, or, with the literal schedule, in the
 * transform that compositing used. The target refers to the rendered picture. The caller frees
 * *out. Errors: those of cvol_renderer_render and of cvol_picture_compress; ARGUMENT (another
 * engine). */
CVOL_API int cvol_renderer_picture(cvol_context *context, cvol_renderer *renderer,
                                   cvol_picture **out, const cvol_render_options *options,
                                   const cvol_picture_options *picture);

#ifdef __cplusplus
}
#endif
#endif
