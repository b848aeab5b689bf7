/* The fields of a NRRD header, shared by its reader (nrrd.c) and that of its axes (nrrd_axes.c). */
#ifndef CVOL_VOLUME_FORMATS_NRRD_H
#define CVOL_VOLUME_FORMATS_NRRD_H

#include "volume/io/stored.h"
#include "volume/io/text_header.h"

#define CVOL_NRRD_AXES 4

/* The fields that the reader uses. */
enum nrrd_field {
    NRRD_TYPE,
    NRRD_DIMENSION,
    NRRD_SIZES,
    NRRD_KINDS,
    NRRD_ENCODING,
    NRRD_ENDIAN,
    NRRD_SPACINGS,
    NRRD_AXIS_MINS,
    NRRD_AXIS_MAXS,
    NRRD_CENTERS,
    NRRD_SPACE,
    NRRD_SPACE_DIMENSION,
    NRRD_SPACE_DIRECTIONS,
    NRRD_SPACE_ORIGIN,
    NRRD_SPACE_UNITS,
    NRRD_UNITS,
    NRRD_LINE_SKIP,
    NRRD_BYTE_SKIP,
    NRRD_DATA_FILE,
    NRRD_FIELDS
};

typedef struct nrrd {
    cvol_text_header header;
    size_t dimension;
    size_t kept[3]; /* the file's axes that become the grid's */
    cvol_grid grid;
    size_t sizes[CVOL_NRRD_AXES];
    /* The axis of a series of volumes; extra_size 1: there is none. */
    size_t extra, extra_size;
    int has_channels, has_colours; /* they are channels, of a colour; else times */
} nrrd;

_Static_assert(NRRD_FIELDS <= CVOL_TEXT_FIELDS_MAX, "a header has room for all fields");

/* The axes: their number, sizes, spacings and directions, and the space. */
int cvol_nrrd_read_axes(nrrd *n);

/* Copies word `index` of a field to `out`; "" if it has fewer, or `size` bytes are too few. */
void cvol_nrrd_get_word(char *out, size_t size, const char *text, size_t index);

/* nrrd_volumes.c: a fourth axis, of times or channels. find_stated_extra returns the axis that the
 * header states, or -1; find_extra sets the axis and its meaning; known[a]: axis a has a direction
 * in space. choose finds the samples of the chosen volume, after those of the whole file were
 * found. */
int cvol_nrrd_find_stated_extra(const nrrd *n, const int *known);
void cvol_nrrd_find_extra(nrrd *n, const int *known);
int cvol_nrrd_choose(nrrd *n, cvol_stored *stored, const cvol_read_options *options);

#endif
