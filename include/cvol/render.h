/* cvol/render.h - pictures of volumes, from their compressed form.
 *
 * A renderer (cvol_renderer_create) draws one volume by one engine. cvol/engines.h describes the
 * engines, cvol/camera.h the camera and world coordinates, cvol/transfer.h transfer functions. */
#ifndef CVOL_RENDER_H
#define CVOL_RENDER_H

#include "cvol/array.h"
#include "cvol/camera.h"
#include "cvol/engines.h"
#include "cvol/image.h"
#include "cvol/picture.h"
#include "cvol/transfer.h"
#include "cvol/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Modes: how the samples along a ray give a pixel. */
typedef enum cvol_mode {
    CVOL_MODE_COMPOSITE = 1, /* colour and opacity, front to back */
    CVOL_MODE_XRAY = 2,      /* mean of the samples along the ray, in the window, white on black */
    CVOL_MODE_MIP = 3,       /* largest sample along the ray, in the window, white on black */
    CVOL_MODE_MIN = 4,       /* smallest sample along the ray, likewise */
    CVOL_MODE_ISO = 5        /* a lit surface, see cvol_surface */
} cvol_mode;

/* Light in mode composite of engines sheet, ray, splat and transform: Phong's model ("Illumination
 * for computer generated pictures", 1975). A sample of colour F gets the colour
 *
 *     F (ambient + diffuse max(0, n l)) + specular max(0, r e)^shininess,   r = 2 (n l) n - l,
 *
 * where l is the direction of the light, e that of the eye, and n that of the gradient, turned
 * towards e (surfaces have two sides). e is that of parallel projection, in perspective too. Where
 * a surface is seen edge-on, k = 16 |n e| < 1, n l becomes k n l + (1 - k) |n e| l e: light is the
 * same on both sides, and does not jump from one to the other.
 *
 * Where samples hardly change, noise and rounding decide the direction of the gradient g. There
 * n l and n e move towards l e and 1, by f^2 / (|g|^2 + f^2) of what lies between: matter without a
 * direction looks as if it faced the eye. f is the gradient that would take 512 mean spacings to
 * cross the values between which the transfer function's opacity is above 0, and at least 1/2048 of
 * the range of the samples (Kroes, Post and
 * Botha, "Exposure render", 2012, choose between a surface and a scatterer by |g| likewise). In
 * mode iso f is 0. The gradient is by central differences in the world, over two
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

/* What reaches a lit sample, and from where, beyond cvol_shading: engines sheet and ray. All zero:
 * nothing. A sample gets the colour
 *
 *     E L (F (ambient + diffuse max(0, n l) + fill |n e|) + gloss)
 *
 * where gloss is the last term of cvol_shading. L is what other parts of the volume leave of the
 * light, linear between cells of 2, 4 or 8 samples (more if the volume has 2048 or more along an
 * axis), from the volume's low frequencies: with occlusion, ambient light from six cones about the
 * axes, and with shadows, the transmittance towards the light. E is the exposure.
 *
 * With `samples`, light is scattered once, as in clouds and skin: with the shares A = (ambient +
 * fill) / (ambient + fill + diffuse) and K = 1 - A,
 *
 *     L = A (1 - occlusion + occlusion S) + K (1 - shadows + shadows D)
 *
 * S is the mean transmittance towards a sky around the volume, brighter on the side of the light
 * (its density is in proportion to 1 + cos of the angle to it), D that towards a disc around the
 * light with a radius of 12 degrees: means over `samples` directions, a quarter of them in the
 * disc. Engine sheet finds both in the cells, the same for all pixels; engine ray follows rays
 * through the samples from every lit place: the slow reference. */
typedef struct cvol_illumination {
    double fill;      /* 0 to 10: a second light, from the eye */
    double occlusion; /* 0 to 1: how much of the ambient light from hidden directions is missing */
    double shadows;   /* 0 to 1: how much of the light is missing in full shadow */
    /* 1: cvol_shading.light is a direction right, up, and towards the eye; -1: left, up, and
     * towards the eye, for a picture that is mirrored afterwards; 0: in the world. */
    int in_view;
    /* 1: the exposure is such that the picture is as bright as without light, estimated from the
     * cells that the eye sees; 0.5 to 3. 0: the exposure is 1. */
    int keeps_brightness;
    int samples; /* 0: none; 2 to 65536: directions */
} cvol_illumination;

/* The surface of mode iso: the first place of a ray where the interpolated samples reach the value;
 * opaque, and lit by the shading of the options even if that is off. Where a clip, or a face of the
 * volume, cuts through samples beyond the value, the cut shows them: with the surface's colour
 * times their brightness in the window, without light (volumes with a mask: like the rest). */
typedef struct cvol_surface {
    double value;
    double colour[3]; /* R G B in 0..1 */
} cvol_surface;

/* A box of the volume, in samples, that a picture is limited to: from[a] to to[a] on the axes whose
 * bit 1 << a is set in `axes`. Pictures of the parts of a volume, each over those behind it, are
 * the picture of the whole (cvol/mpi.h): unlike cvol_clip, a part changes neither the light, which
 * passes through all parts, nor the values of black and white. In modes composite and iso, engine
 * sheet draws the intervals of rays whose middle is in the part, whole. */
typedef struct cvol_part {
    int axes;              /* bit a: axis a is limited */
    double from[3], to[3]; /* in samples, which may be fractions */
} cvol_part;

/* The rows of a larger picture that an image holds, so that several programs or threads can draw a
 * picture in strips: rows first to first + height - 1 of a picture that has `of` rows and is as
 * wide as the image. Its pixels are those of the whole picture up to rounding; in perspective,
 * engine sheet chooses its rays by the strip, and they differ more. */
typedef struct cvol_rows {
    int first, of; /* of 0: the image is the whole picture */
} cvol_rows;

/* Options of a picture; start with cvol_render_options_defaults(). The structs in it are frozen. */
typedef struct cvol_render_options {
    size_t size;       /* sizeof(cvol_render_options) */
    int width, height; /* pixels */
    cvol_mode mode;
    cvol_camera camera;
    int level; /* engine sheet: 0: full resolution; 1, 2, 3: every 2nd, 4th, 8th sample, from the
                  lowest frequencies, for fast pictures. Engine transform: places of the lattice
                  that many samples apart, with footprints as wide as their distance asks (whole
                  planes under DFT and DHT: always all places) */
    double step_voxels; /* distance of samples along the ray in mean spacings; 0: the default of the
                           engine (ray: 0.5; sheet: one per slice, linear between slices). Engine
                           sheet, modes composite and iso: at most this distance, and at most four
                           samples per slice; from two slices on one sample every other slice, in
                           all modes */
    double oversample; /* engine sheet: rays per pixel along each axis, 0.25 to 4; 0: 1. Less than 1
                          is faster and softer. Mode iso, at level 0, if this is 0:
                          each pixel is the mean of 2 x 2 rays */
    double keep_mb; /* engine sheet: block cache size in MB; 0: off. Changes speed, never pixels */
    double background[3]; /* R G B in 0..1 */
    double window[2]; /* modes xray, mip and min: the values of black and white, the second larger;
                         0 0: the smallest and the largest sample. Mode iso: those of cut faces */
    cvol_shading shading;
    cvol_surface surface;
    cvol_sheet_options sheet; /* options of engine sheet */
    cvol_splat_options splat;
    cvol_transform_options transform;
    cvol_fourier_options fourier;
    cvol_clip clip;
    cvol_illumination illumination;
    cvol_part part; /* engines sheet and ray */
    cvol_rows rows; /* engines sheet and ray */
} cvol_render_options;

/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_render_options_set_defaults(cvol_render_options *options, size_t size);
/* 512 x 512, composite, azimuth 0, elevation 0, zoom 1, black. Engine sheet: linear filter. Engine
 * splat: Gaussian, 5 samples wide, in the view, front to back. No light; with light: ambient 0.1,
 * diffuse 0.7, specular 0.2, shininess 10, direction of the eye. Engine transform: DCT in tiles of
 * 16, a tenth of the terms, deferred. */
static inline cvol_render_options cvol_render_options_defaults(void)
{
    cvol_render_options options;
    cvol_render_options_set_defaults(&options, sizeof options);
    return options;
}

/* A renderer. It keeps data that pictures of one volume share. One thread at a time may use it.
 *
 * Samples without a value (arrays with a mask) are transparent in all modes. Interpolation uses
 * only the samples around that have a value, and weights the result by their share: opacities and
 * means are weighted, and largest samples count where the share is at least one half. Rays that
 * meet no sample with a value show the background. Engine splat omits missing samples. */
typedef struct cvol_renderer cvol_renderer;

/* The source of a renderer: one of `array`, `volume` and `baked_path`; the others are NULL. */
typedef struct cvol_source {
    size_t size;               /* sizeof(cvol_source) */
    const cvol_array *array;   /* a compressed volume in DCT blocks */
    const cvol_volume *volume; /* dense samples; NaN counts as the smallest sample */
    const char *baked_path;    /* a file of cvol_renderer_bake */
    const uint8_t *mask;     /* engine ray: one byte a sample, x fastest; samples whose byte is not
                                0 have no value (cvol_array_evaluate_mask). NULL: all have one */
    double rho;              /* engine fourier: the share of frequencies to keep; 0: all */
    const cvol_array *whole; /* engine sheet: if `array` has only a box of its file, another array
                                of the same file, which may be of a level from 1 to 3: occlusion,
                                shadows and exposure are found from it. NULL: from `array` */
} cvol_source;
/* A source in a call, in C: CVOL_SOURCE(.array = array). */
#define CVOL_SOURCE(...) (&(const cvol_source){.size = sizeof(cvol_source), __VA_ARGS__})

/* Creates a renderer. The arrays, the volume and the mask must outlive it; the caller frees *out.
 * Sources by engine: sheet: array; ray: volume; splat and fourier: array or volume; transform:
 * array, volume or baked_path. Errors: ARGUMENT (an engine or a source that is none, a source that
 * the engine does not draw, a size that this library does not know), UNSUPPORTED (an array that is
 * no volume in DCT blocks; engine sheet: samples with a range below 1e-30 or above 1e34), LIMIT,
 * MEMORY, CANCELLED; of baked_path also IO, FORMAT, CORRUPT. Cost: by engine (cvol/engines.h). */
CVOL_API int cvol_renderer_create(cvol_context *context, cvol_renderer **out, cvol_engine engine,
                                  const cvol_source *source);
/* Frees a renderer, but not the array or volume that it draws; NULL is allowed. */
CVOL_API void cvol_renderer_free(cvol_renderer *renderer);
/* Sets the transfer function of mode composite; the renderer keeps a copy. Errors: ARGUMENT (a
 * baked volume has another one), MEMORY. */
CVOL_API int cvol_renderer_set_transfer(cvol_context *context, cvol_renderer *renderer,
                                        const cvol_transfer *transfer);
/* Renders one picture into `image`, which the caller created with the size in the options. Bytes:
 * every pixel opaque over the background. Floats: not rounded, over no background. Also depths, if
 * the image has room for them (cvol_image_add_depth; engines sheet and ray, modes composite and
 * iso). Same bits for any number of threads. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_render(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options);
/* Renders bounds of the picture of the original samples, which the caller does not need to have:
 * `lower` and `upper`, two images of one kind and of the size in the options. The renderer is one
 * of engine ray over decoded samples. Let any volume have the same grid, type and mask, and samples
 * that differ from the decoded ones by at most `error` each and lie within range[0] .. range[1]
 * (NULL: unknown); NaN and infinite samples, if any, are the same. Then the picture that
 * cvol_renderer_render makes of that volume by engine ray, with these options and this transfer
 * function, lies between the two images:
 *
 *     lower <= picture <= upper    for every pixel and channel
 *
 * in all modes but iso. For a compressed volume in DCT blocks, error is cvol_array_info.max_error,
 * and range its value_min and value_max. Floats: also the opacity. Depths are not bounded. An
 * error of 0 gives the picture itself twice, also in mode iso. Same bits for any number of threads.
 * Errors: ARGUMENT (another engine, an error that is not 0 to 1e300, an invalid range, images of
 * two kinds; those of cvol_renderer_render), UNSUPPORTED (mode iso with an error), MEMORY,
 * CANCELLED. Cost: 5 to 30 pictures by engine ray; 8 MB, and 2 kB per thread and step of a ray. */
CVOL_API int cvol_renderer_certify(cvol_context *context, cvol_renderer *renderer,
                                   cvol_image *lower, cvol_image *upper,
                                   const cvol_render_options *options, double error,
                                   const double *range);
/* Sets range to the values of black and white in modes xray, mip and min without a window: the
 * least and the largest sample. Errors: ARGUMENT (an engine that has only mode composite). */
CVOL_API int cvol_renderer_get_range(cvol_context *context, double range[2],
                                     const cvol_renderer *renderer);

/* Sets *out to the coarsest level of a file (cvol_file_part.level) from which engine sheet draws
 * this picture, at options->level 0, almost without loss: 1 for volumes of 2^27 samples and more if
 * pixels span 2.86 samples along every axis, except in mode iso; else 0. Errors: ARGUMENT (invalid
 * camera). */
CVOL_API int cvol_render_choose_file_level(cvol_context *context, int *out, const cvol_grid *grid,
                                           const cvol_render_options *options);

/* ---- time budgets ---- */

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
 * the budget. It abandons a picture that takes longer, and the one before stays; it draws at least
 * one. The renderer remembers the times of levels: without `drawn` (which may be NULL, like report)
 * it starts with the finest level that fits. The first picture of a level includes the time to make
 * its samples. Progress is reported for each picture. Errors: those of cvol_renderer_render. */
CVOL_API int cvol_renderer_refine(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                                  const cvol_render_options *options, double budget_ms,
                                  cvol_picture_fn drawn, void *user, cvol_refine_report *report);

/* ---- functions of one engine ---- */

/* Bytes in the block cache (keep_mb of the last picture); 0 for engines other than sheet. */
CVOL_API uint64_t cvol_renderer_kept_bytes(const cvol_renderer *renderer);

/* Copies the report on the last picture of engine transform to *out. Errors: ARGUMENT (another
 * engine, or no picture yet). */
CVOL_API int cvol_renderer_get_transform_report(cvol_context *context, cvol_transform_report *out,
                                                const cvol_renderer *renderer);
/* Renders a picture by engine transform into a compressed picture. Its planes are on the lattice on
 * which slices were composited: in the tiles of `picture`, or, with the literal schedule, in the
 * transform of compositing. The target of `picture` refers to the rendered pixels. The caller frees
 * *out. Errors: those of cvol_renderer_render and of cvol_picture_compress; ARGUMENT (another
 * engine). */
CVOL_API int cvol_renderer_render_compressed(cvol_context *context, cvol_renderer *renderer,
                                             cvol_picture **out, const cvol_render_options *options,
                                             const cvol_picture_options *picture);

/* Copies the size of the spectrum of engine fourier to *out. Errors: ARGUMENT (another engine). */
CVOL_API int cvol_renderer_get_fourier_report(cvol_context *context, cvol_fourier_report *out,
                                              const cvol_renderer *renderer);
/* Projects the volume by engine fourier, in units of the samples. out[x + width (y + height i)], y
 * = 0 on top, is the mean of the samples along a ray of view i, and the least sample where the ray
 * misses the volume. With options->fourier.integrals it is the integral along the ray, and 0. A
 * rotation is a quaternion (w, x, y, z) of any length: it turns a camera that looks along -z with y
 * up, so the columns of its matrix are right, up and the direction of the eye. Zoom and size are
 * those of the options. Each thread makes whole views. Same bits for any number of threads. Errors:
 * ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_project(cvol_context *context, cvol_renderer *renderer, float *out,
                                   const cvol_render_options *options, const double (*rotations)[4],
                                   size_t count);

#ifdef __cplusplus
}
#endif
#endif
