/* cvol/transfer.h - transfer functions, the histograms that they are fitted to, Hounsfield units.
 */
#ifndef CVOL_TRANSFER_H
#define CVOL_TRANSFER_H

#include "cvol/array.h"
#include "cvol/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

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
/* The number of control points. */
CVOL_API size_t cvol_transfer_count(const cvol_transfer *transfer);
/* Control point `index`, 0 <= index < cvol_transfer_count, in the order of values. */
CVOL_API cvol_transfer_point cvol_transfer_point_at(const cvol_transfer *transfer, size_t index);
/* 1 if all values have an opacity of at least 0.3, and not all one colour: then only faces of the
 * volume, and of cuts, are visible. Their gradients are those of noise and texture, so the default
 * picture has no light. */
CVOL_API int cvol_transfer_is_opaque(const cvol_transfer *transfer);

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
/* Computes the histogram of an array: that of the samples it was compressed from, for any ratio,
 * level or part of a file, at no cost. If the array has none (a result of operations, a file of an
 * early version), it evaluates at most 1,024 blocks. Errors: UNSUPPORTED (not an array of rank 3 in
 * DCT blocks), ARGUMENT, MEMORY. */
CVOL_API int cvol_array_compute_histogram(cvol_context *context, cvol_histogram *out,
                                          const cvol_array *array);
/* Computes the histogram of all samples of a volume. Cost: two passes over them. Errors: ARGUMENT,
 * MEMORY. */
CVOL_API int cvol_volume_compute_histogram(cvol_context *context, cvol_histogram *out,
                                           const cvol_volume *volume);

/* Sets *out to the histogram of the samples of several volumes together, such as the times of a
 * series, from their `count` histograms. Chord and mark are unknown in it. The count of a bin goes
 * to the bin of its middle. */
CVOL_API void cvol_histogram_join(cvol_histogram *out, const cvol_histogram *histograms,
                                  size_t count);

/* Sets window to the range of a histogram without the 0.1 % least and largest samples, in whole
 * bins: values of black and white for cvol_render_options.window. 0 0 if all samples are equal. */
CVOL_API void cvol_histogram_get_window(double window[2], const cvol_histogram *histogram);

/* Makes a named transfer function, fitted to a histogram: "auto", "gray", "bone", "skin-bone",
 * "mri", "microscopy", "hot", "viridis", ... Errors: ARGUMENT (the message lists the names),
 * MEMORY. */
CVOL_API int cvol_transfer_create_named(cvol_context *context, cvol_transfer **out,
                                        const char *name, const cvol_histogram *histogram);
/* "auto gray bone ..."; static storage. */
CVOL_API const char *cvol_transfer_names(void);

/* Makes a transfer function with the opacities of one and the colours of another, by value. The
 * caller frees *out. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_recoloured(cvol_context *context, cvol_transfer **out,
                                             const cvol_transfer *opacities,
                                             const cvol_transfer *colours);
/* Makes a transfer function with the opacities and the brightness of another one, in one colour, as
 * a channel that is added to others has (cvol_image_add_light). The caller frees *out. Errors:
 * ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_tinted(cvol_context *context, cvol_transfer **out,
                                         const cvol_transfer *from, const double rgb[3]);
/* Sets range to the values of black and white of the components of RGB samples of a type. */
CVOL_API void cvol_component_get_range(double range[2], cvol_type type);
/* Makes the transfer function of a component of RGB samples, whose colour is rgb: values within
 * range are its brightness. A dark background, by the histogram (NULL: none), is transparent. The
 * caller frees *out. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_component(cvol_context *context, cvol_transfer **out,
                                            const cvol_histogram *histogram, const double range[2],
                                            const double rgb[3]);
/* Makes a transfer function from another one: moves the points linearly so that the first is at
 * window[0] and the last at window[1] (NULL: not), and multiplies the density: opacities become 1 -
 * (1 - opacity)^opacity_scale. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_transfer_create_adjusted(cvol_context *context, cvol_transfer **out,
                                           const cvol_transfer *from, const double *window,
                                           double opacity_scale);

/* Makes a transfer function of samples from one of the values that they mean, such as one from a
 * file: a sample s means rescale[0] s + rescale[1]. Errors: ARGUMENT (a rescale that is not finite,
 * or with a factor of 0), MEMORY. */
CVOL_API int cvol_transfer_create_rescaled(cvol_context *context, cvol_transfer **out,
                                           const cvol_transfer *from, const double rescale[2]);

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

#ifdef __cplusplus
}
#endif
#endif
