/* cvol/picture.h - compressed pictures: coefficients of a picture's planes, and the way from them
 * to pixels. Files of them end in .cvi (doc/format.md).
 *
 * A compressed picture is a few planes on a lattice: arrays of rank 2, quantized. The first three
 * are an orthonormal mix of red, green and blue (0 .. 1),
 *
 *     (R + G + B) / sqrt 3,   (R - B) / sqrt 2,   (R - 2 G + B) / sqrt 6
 *
 * so that squared errors of planes are squared errors of colours, and grey pictures take one plane.
 * The fourth, where there is one, is opacity. Of a picture that was a PNG the lattice is the
 * pixels. Of one that the transform engine composed it is the engine's: planes are premultiplied
 * and put over a background, and pixels lie between its places (cubic splines, as that engine's own
 * pictures).
 */
#ifndef CVOL_PICTURE_H
#define CVOL_PICTURE_H

#include "cvol/array.h"
#include "cvol/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A compressed picture. */
typedef struct cvol_picture cvol_picture;

/* How to compress one. */
typedef struct cvol_picture_options {
    cvol_transform transform;
    int block;      /* side of the tiles: 8, 16 or 32; 0: planes as a whole */
    double ratio;   /* raw bytes (three or four a pixel) / file bytes, at least; 0: not asked for */
    double psnr_db; /* at least, over 255; if no ratio is asked for */
} cvol_picture_options;
/* DCT in tiles of 16 x 16, 45 dB. */
CVOL_API cvol_picture_options cvol_picture_options_defaults(void);

/* Compresses a picture. One step for all planes is searched, by decoding, until the target holds; a
 * ratio is met to within 2 % where that can be. The caller frees *out. Errors: ARGUMENT, TARGET (a
 * PSNR or a ratio that cannot be had), MEMORY, CANCELLED. */
CVOL_API int cvol_picture_compress(cvol_context *context, cvol_picture **out,
                                   const cvol_image *image, const cvol_picture_options *options);
/* Frees a picture; NULL is allowed. */
CVOL_API void cvol_picture_free(cvol_picture *picture);

/* The picture in pixels: one inverse transform a plane, and the warp. Bit-identical for any number
 * of threads. The caller frees *out. Errors: MEMORY, LIMIT, CANCELLED. */
CVOL_API int cvol_picture_evaluate(cvol_context *context, cvol_image **out,
                                   const cvol_picture *picture);

/* What a picture is, and what is known of it. */
typedef struct cvol_picture_info {
    int width, height; /* pixels */
    size_t lattice[2];
    int planes;  /* 3, or 4 with opacity */
    int is_over; /* colours are light already, which is put over the background; else opacity
                    is the picture's own */
    double background[3];
    cvol_transform transform;
    int block;               /* side of the tiles; 0: whole */
    double step;             /* of the colours */
    uint64_t terms;          /* of all planes */
    double rho;              /* terms over places of all planes */
    uint64_t resident_bytes; /* in memory */
    uint64_t file_bytes;     /* as a file */
    double ratio;            /* raw bytes / file bytes */
    double psnr_db;          /* measured: of the pixels, against those that it was made from */
    double l2_error;         /* of the three colours together, certified: against the planes that
                                it was made from */
    double rms_bound;        /* that, as a root mean square over places and colours */
} cvol_picture_info;
/* Fills in all of it; file_bytes is counted by coding it. Errors: MEMORY. */
CVOL_API int cvol_picture_get_info(cvol_context *context, cvol_picture_info *out,
                                   const cvol_picture *picture);
/* Plane 0 .. 3, owned by the picture; NULL if there is none. */
CVOL_API const cvol_array *cvol_picture_plane(const cvol_picture *picture, int plane);

/* Writes a .cvi file: temporary name, sync, rename. Deterministic bytes. file_bytes may be NULL.
 * Errors: IO, MEMORY. */
CVOL_API int cvol_picture_write(cvol_context *context, const cvol_picture *picture,
                                const char *path, uint64_t *file_bytes);
/* Reads one. The caller frees *out. Errors: IO, FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY. */
CVOL_API int cvol_picture_read(cvol_context *context, cvol_picture **out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
