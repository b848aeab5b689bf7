/* cvol/picture.h - compressed pictures: coefficients of the planes of a picture. Their files are
 * .cvi (doc/format.md).
 *
 * A compressed picture has three or four planes on a lattice: quantized arrays of rank 2. The first
 * three are an orthonormal mix of red, green and blue (0 .. 1),
 *
 *     (R + G + B) / sqrt 3,   (R - B) / sqrt 2,   (R - 2 G + B) / sqrt 6
 *
 * so squared errors of planes equal squared errors of colours, and grey pictures need one plane.
 * The fourth, if there is one, is opacity. For a picture from a PNG the lattice is that of the
 * pixels. For one from engine transform it is that of the engine: planes are premultiplied, pixels
 * are interpolated from them (cubic splines, as in other pictures of that engine) and put over a
 * background. */
#ifndef CVOL_PICTURE_H
#define CVOL_PICTURE_H

#include "cvol/array.h"
#include "cvol/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A compressed picture. */
typedef struct cvol_picture cvol_picture;

/* Options of compression; start with cvol_picture_options_defaults(). */
typedef struct cvol_picture_options {
    size_t size; /* sizeof(cvol_picture_options) */
    cvol_transform transform;
    int block;      /* side of the tiles: 8, 16 or 32; 0: whole planes */
    double ratio;   /* raw bytes (three or four per pixel) / file bytes, at least; 0: use psnr_db */
    double psnr_db; /* dB over 255, at least; if ratio is 0 */
} cvol_picture_options;
/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_picture_options_set_defaults(cvol_picture_options *options, size_t size);
/* DCT in tiles of 16 x 16, 45 dB. */
static inline cvol_picture_options cvol_picture_options_defaults(void)
{
    cvol_picture_options options;
    cvol_picture_options_set_defaults(&options, sizeof options);
    return options;
}

/* Compresses a picture. It searches for one step for all planes, by decoding, until the target
 * holds; a ratio is met within 2 % if possible. The caller frees *out. Errors: ARGUMENT, TARGET (a
 * PSNR or ratio out of reach), MEMORY, CANCELLED. */
CVOL_API int cvol_picture_compress(cvol_context *context, cvol_picture **out,
                                   const cvol_image *image, const cvol_picture_options *options);
/* Frees a picture; NULL is allowed. */
CVOL_API void cvol_picture_free(cvol_picture *picture);

/* Decodes a picture to pixels. Same bits for any number of threads. The caller frees *out. Cost:
 * one inverse transform per plane, and the warp. Errors: MEMORY, LIMIT, CANCELLED. */
CVOL_API int cvol_picture_evaluate(cvol_context *context, cvol_image **out,
                                   const cvol_picture *picture);

/* Properties of a compressed picture. */
typedef struct cvol_picture_info {
    int width, height; /* pixels */
    size_t lattice[2];
    int planes;  /* 3, or 4 with opacity */
    int is_over; /* 1: colours are premultiplied, and put over the background; 0: the picture has
                    its own opacity */
    double background[3];
    cvol_transform transform;
    int block;               /* side of the tiles; 0: whole planes */
    double step;             /* step of the colour planes */
    uint64_t terms;          /* terms of all planes */
    double rho;              /* terms divided by places of all planes */
    uint64_t resident_bytes; /* bytes in memory */
    uint64_t file_bytes;     /* bytes as a file */
    double ratio;            /* raw bytes / file bytes */
    double psnr_db;          /* measured on the pixels, against the original */
    double
        l2_error; /* certified bound for the three colours together, against the original planes */
    double rms_bound; /* l2_error as root mean square over places and colours */
} cvol_picture_info;
/* Fills in *out; encodes the picture to count file_bytes. Errors: MEMORY. */
CVOL_API int cvol_picture_get_info(cvol_context *context, cvol_picture_info *out,
                                   const cvol_picture *picture);
/* Plane 0 .. 3, or NULL. The picture owns it. */
CVOL_API const cvol_array *cvol_picture_plane(const cvol_picture *picture, int plane);

/* Writes a .cvi file: a temporary name, sync, rename. The bytes depend only on the picture.
 * file_bytes may be NULL. Errors: IO, MEMORY. */
CVOL_API int cvol_picture_write(cvol_context *context, const cvol_picture *picture,
                                const char *path, uint64_t *file_bytes);
/* Reads a .cvi file. The caller frees *out. Errors: IO, FORMAT, CORRUPT, LIMIT, UNSUPPORTED,
 * MEMORY. */
CVOL_API int cvol_picture_read(cvol_context *context, cvol_picture **out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
