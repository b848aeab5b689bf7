/* cvol/look.h - what a picture shows when nothing is chosen: the side of the volume, the frame, the
 * light, and colours by the kind of data. cvol render, cvol view and Python use these functions;
 * cvol_render_options_defaults() does not. */
#ifndef CVOL_LOOK_H
#define CVOL_LOOK_H

#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- camera ---- */

/* Sets the angles of a camera to a three-quarter view: from the front, 30 degrees to the side and
 * 20 from above. If the grid has a patient orientation, front and above are those of the patient.
 * A slab, less than 0.4 times as thick as wide, is seen across its thin axis; a single slice
 * exactly along it, upright as in radiology, or with rows downwards. turn_deg and *mirrored: see
 * cvol_camera_set_view. */
CVOL_API void cvol_camera_set_default(cvol_camera *camera, int *mirrored, const cvol_grid *grid,
                                      double turn_deg);
/* The part of a picture that an object fills, along the axis that it fills most. */
#define CVOL_FIT_SHARE 0.88
/* Sets zoom and look_at of options->camera so that what is visible fills CVOL_FIT_SHARE of the
 * picture's height or width, from the camera's angles and with its field of view. Visible is what
 * the transfer function shows in mode composite, the surface in mode iso, what is not black in
 * other modes; inside the clip. If nothing is, the whole volume counts. The source is an array or a
 * volume, with its mask; `transfer` may be NULL in other modes than composite. turns: 1, or the
 * number of pictures of a turn around z, which all fit. Cost: evaluates the low frequencies of the
 * blocks, 1/8 to 1/512 of the samples; where these show less than three cells in modes composite
 * and iso, all samples of volumes of up to 2^27. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_camera_fit(cvol_context *context, cvol_render_options *options,
                             const cvol_source *source, const cvol_transfer *transfer, int turns);
/* The same for one picture in parallel projection, and sets size to the width and the height of
 * what is visible in it, in units of the spacing, each at least 1/1000 of the volume's diagonal. A
 * picture that is wider than size[0] / size[1] is fitted to the height, others to the width;
 * look_at is the same. So pictures of all shapes need one call. Cost and errors: as
 * cvol_camera_fit. */
CVOL_API int cvol_camera_fit_extent(cvol_context *context, cvol_render_options *options,
                                    double size[2], const cvol_source *source,
                                    const cvol_transfer *transfer);

/* ---- colours ---- */

/* Kinds of data, with their own colours and opacities. */
typedef enum cvol_kind {
    CVOL_KIND_GENERAL = 0,    /* none of the others is recognised */
    CVOL_KIND_CT = 1,         /* Hounsfield units */
    CVOL_KIND_MEDICAL = 2,    /* a patient orientation, but no Hounsfield units: mostly MRI */
    CVOL_KIND_MICROSCOPY = 3, /* spacing in micrometres or nanometres */
    CVOL_KIND_FIELD = 4,      /* real numbers without a patient: simulations, maps */
    CVOL_KIND_SIGNED = 5,     /* values on both sides of zero, most of them near it */
    CVOL_KIND_DENSE = 6,      /* no empty space: electron microscopy */
    CVOL_KIND_LABELS = 7      /* integers of at most 32 different values: numbers of regions */
} cvol_kind;

/* Makes the transfer function for the kind of data: by the file's rescale, orientation and unit, by
 * the type, and by the histogram. exact: 1 if the samples that are drawn are those of the
 * histogram; labels are recognised only then. *kind: the kind, and rescale: from samples to
 * Hounsfield units for CT, else as in the grid. Both may be NULL. The caller frees *out. Errors:
 * MEMORY. */
CVOL_API int cvol_transfer_create_auto(cvol_context *context, cvol_transfer **out, cvol_kind *kind,
                                       double rescale[2], const cvol_histogram *histogram,
                                       const cvol_grid *grid, int exact);
/* "CT in Hounsfield units: skin and bone", ...; static storage. */
CVOL_API const char *cvol_kind_text(cvol_kind kind);

/* Sets rgb to the colour that pictures of labels give this one, each component 0 to 1: any
 * few labels have clearly different ones, also if their numbers differ by a constant. */
CVOL_API void cvol_label_get_colour(double rgb[3], double label);

/* ---- labels ---- */

/* A picture of labels is that of one shape, the union of the labels, in which each pixel then gets
 * the colour of the label at its depth. So labels keep their whole extent, and no colour of a third
 * label appears where two meet, as it would between interpolated numbers.
 *
 * Makes the shape: a volume of uint8, above 127 where `labels` (uint8, as large) is not 0, below
 * elsewhere. The caller frees *out. Errors: ARGUMENT, MEMORY. */
CVOL_API int cvol_labels_create_mask(cvol_context *context, cvol_volume **out,
                                     const cvol_volume *labels);
/* Makes the same shape as an array for engine sheet. The caller frees *out. Errors: ARGUMENT,
 * MEMORY.
 */
CVOL_API int cvol_labels_create_shape(cvol_context *context, cvol_array **out,
                                      const cvol_volume *labels);
/* Its transfer function: white above 127.5, nothing below. The caller frees *out. Errors: MEMORY.
 */
CVOL_API int cvol_labels_create_mask_transfer(cvol_context *context, cvol_transfer **out);
/* Multiplies the pixels of a picture of the shape, of floats with depths that a renderer has drawn
 * with these options in mode composite, by colours[3 (label - 1) + c], c = 0, 1, 2 for red, green,
 * blue; labels above `count` are white. A pixel has the colour of the label at its depth. If the
 * picture was drawn with a transfer function (NULL: that of cvol_labels_create_mask_transfer) that
 * makes the shape translucent, with an opacity below 0.9, it has the mean colour along its ray:
 *
 *     sum_i w_i colour_i / sum_i w_i,   w_i = a_i prod_{j < i} (1 - a_j)
 *
 * of places every half mean spacing, where colour_i is that of the label with the largest part, and
 * a_i the opacity times the part of all labels. A pixel whose ray meets no label becomes empty: the
 * shape is blurred, most at coarse levels. Cost: eight samples a pixel, more at edges;
 * translucent: eight for each place until little is seen. Errors: ARGUMENT. */
CVOL_API int cvol_image_colour_labels(cvol_context *context, cvol_image *image,
                                      const cvol_volume *labels, const double *colours,
                                      size_t count, const cvol_transfer *transfer,
                                      const cvol_render_options *options);

/* ---- components of colours ---- */

/* The largest number of components: red, green, blue and alpha. */
#define CVOL_COLOURS_MAX 4

/* A picture of RGB or RGBA samples is that of one shape: the sum of the components, or alpha. Each
 * pixel then gets the mean colour of the samples that its ray sees. So an opaque object hides what
 * is behind it in all components, also where one of them is 0.
 *
 * The components, of one grid: red, green and blue, then alpha if there is one. Arrays for engine
 * sheet, or volumes for engine ray. Fewer colours than three are allowed. */
typedef struct cvol_colour_source {
    size_t size;                       /* sizeof(cvol_colour_source) */
    const cvol_array *const *arrays;   /* [count]; NULL: volumes */
    const cvol_volume *const *volumes; /* [count]; NULL: arrays */
    const double *rgb; /* [3 count]: the colour of a component at its full value; of alpha unused */
    size_t count;      /* components: 1 to CVOL_COLOURS_MAX */
    int has_alpha;     /* 1: the last component is the opacity */
    double range[2];   /* values of black and of the full colour (cvol_component_get_range) */
    int by_range; /* 1: the range alone decides what is transparent and what is opaque, the same
                     for all times of a series; 0: the samples decide, too */
} cvol_colour_source;

/* The colours of samples, and their shape. The shape has values from 0, where a sum of components
 * is that of black, or of a dark background, to 255, at half of the largest sums, or alpha. If most
 * samples on the faces of the volume are nearly white, and the components are three, what sums lack
 * of the brightest counts instead, but not by range alone. The shape is blurred over five samples
 * along each axis, unless an axis has fewer: so light shows the noise of photographs less, no steps
 * where an object was cut out, and faces of a clip as even as they are. Colours are kept for
 * several pictures: bricks of 32 samples a side near what these show, four bytes a sample. */
typedef struct cvol_colours cvol_colours;
/* Makes colours, and their shape: *array of arrays, for engine sheet, or *volume of volumes, of
 * uint8, for engine ray; the other one is NULL. The components must outlive *out. The caller frees
 * all three. Cost: evaluates all components, and compresses the shape of arrays; memory for 3 bytes
 * a sample meanwhile, and 8 a sample of up to 32 slices. Errors: ARGUMENT, UNSUPPORTED (an array
 * that is no volume in blocks), MEMORY, CANCELLED. */
CVOL_API int cvol_colours_create(cvol_context *context, cvol_colours **out, cvol_array **array,
                                 cvol_volume **volume, const cvol_colour_source *source);
/* Frees colours, but not the components; NULL is allowed. */
CVOL_API void cvol_colours_free(cvol_colours *colours);
/* Makes the transfer function of the shape, in grey, which light may make brighter. The caller
 * frees *out. Errors: MEMORY. */
CVOL_API int cvol_colours_create_transfer(cvol_context *context, cvol_transfer **out,
                                          const cvol_colours *colours);
/* Gives the pixels of a picture of the shape, of floats with depths that a renderer has drawn with
 * such a transfer function and these options in mode composite, the mean colours along their rays,
 *
 *     sum_i w_i colour_i / sum_i w_i,   w_i = a_i prod_{j < i} (1 - a_j),
 *
 * of samples every half mean spacing. a_i is the opacity of the sample's own sum or alpha, which is
 * not blurred. For sums, w_i has the further factor min(1, s / 1.5)^2, where 255 s is the shape
 * without its upper end: at edges the background is mixed into the samples, so these count less.
 * Where nothing is opaque, the sample with the largest sum or alpha counts. Light above 1 makes
 * colours a fifth brighter at most. Cost: the evaluation of bricks that are not kept yet, and some
 * 20 samples a pixel, more in translucent matter. Errors: ARGUMENT, MEMORY, CANCELLED. */
CVOL_API int cvol_image_colour_components(cvol_context *context, cvol_image *image,
                                          cvol_colours *colours, const cvol_transfer *transfer,
                                          const cvol_render_options *options);

/* ---- light ---- */

/* Sets shading and illumination to studio light: a key light from the upper left that casts soft
 * shadows, a fill light from the eye, ambient occlusion, and the brightness of the picture without
 * light. Engines sheet and ray. */
CVOL_API void cvol_render_options_set_studio(cvol_render_options *options);
/* The same with light that is scattered once (cvol_illumination.samples): a sky and a soft key
 * light, which shine through translucent matter. samples: 0 for 64; more are more exact and take
 * longer. */
CVOL_API void cvol_render_options_set_cinematic(cvol_render_options *options, int samples);

/* All of this for one picture: the default view, its frame, and studio light (none if
 * cvol_transfer_is_opaque). The size, the mode and the clip of the options count. *mirrored,
 * source, transfer, errors: see above. */
CVOL_API int cvol_render_options_set_look(cvol_context *context, cvol_render_options *options,
                                          int *mirrored, const cvol_source *source,
                                          const cvol_transfer *transfer);

#ifdef __cplusplus
}
#endif
#endif
