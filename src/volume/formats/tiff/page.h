/* Pages of TIFF files, by libtiff: their properties and samples. */
#ifndef CVOL_VOLUME_FORMATS_TIFF_PAGE_H
#define CVOL_VOLUME_FORMATS_TIFF_PAGE_H

#include "cvol/base.h"

typedef struct cvol_tiff_file cvol_tiff_file;

/* Samples that are stored in another form than their type. */
typedef enum cvol_tiff_form {
    CVOL_TIFF_PLAIN,
    CVOL_TIFF_HALVES, /* floats of 16 bits */
    CVOL_TIFF_BITS    /* eight samples a byte, the first one in its highest bit */
} cvol_tiff_form;

typedef struct cvol_tiff_page {
    size_t width, height;
    size_t samples; /* of a pixel */
    size_t bytes;   /* of all its samples */
    cvol_type type;
    cvol_tiff_form form;
    double resolution[2]; /* samples per unit; 0: unknown, or a printer's inches */
    uint64_t offset;      /* of its directory */
    uint64_t raw_offset;  /* of its samples, if they are contiguous and raw, else 0 */
    int big_endian;
    int is_extra;    /* a reduced image, or a mask */
    int are_colours; /* the first three samples of a pixel are red, green and blue */
} cvol_tiff_page;

/* Opens a file at its first page. */
int cvol_tiff_open(cvol_context *context, cvol_tiff_file **out, const char *path);
void cvol_tiff_close(cvol_tiff_file *file);
/* Goes to the next page; *more is 0 when there is none. */
int cvol_tiff_next(cvol_context *context, cvol_tiff_file *file, int *more);
/* Properties of the current page, checked against the file's size and the context's limit. */
int cvol_tiff_read_page(cvol_context *context, cvol_tiff_file *file, cvol_tiff_page *page);
/* The first page's description, or NULL; the caller frees it. Call it before the next pages are
 * read. */
int cvol_tiff_description(cvol_context *context, cvol_tiff_file *file, char **out);
/* FORMAT error if `page`, of the file of this name, has another shape or type. */
int cvol_tiff_check_same(cvol_context *context, const cvol_tiff_page *first,
                         const cvol_tiff_page *page, const char *path);
/* Reads one sample of each pixel of the page at `offset`, which must match `page`. */
int cvol_tiff_decode(cvol_context *context, cvol_tiff_file *file, uint64_t offset,
                     const cvol_tiff_page *page, size_t sample, void *out);

#endif
