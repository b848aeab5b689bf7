/* Fragments of an intermediate image: the pixels that show something, in runs. Pixels are numbered
 * group by group (cvol_sheet_lines): pixel i of group g has the number i + g count. */
#ifndef CVOL_MPI_FRAGMENT_H
#define CVOL_MPI_FRAGMENT_H

#include "render/sheet/combine.h"

/* The pixels first .. first + count - 1. */
typedef struct cvol_mpi_run {
    uint32_t first, count;
} cvol_mpi_run;

/* Runs are in ascending order, and two runs do not touch. */
typedef struct cvol_mpi_fragment {
    size_t run_count, pixel_count;
    cvol_mpi_run *runs;
    float *values; /* [pixel_count][depth of the blend] */
} cvol_mpi_fragment;

/* How the pixels of two parts become one. In the modes composite and iso a pixel has premultiplied
 * colour and transmittance; in the others a value and the length of its ray, 0 if the ray meets
 * nothing. */
typedef struct cvol_mpi_blend {
    size_t depth; /* number of values of a pixel; the last one tells whether it shows something */
    float empty;  /* the last value of a pixel that shows nothing */
    void (*put)(float *restrict front, const float *restrict back, size_t pixels);
} cvol_mpi_blend;

cvol_mpi_blend cvol_mpi_blend_of(cvol_mode mode);

/* What a group shows: the pixels begin .. end - 1 hold `pixels` pixels that show something, in
 * `runs` runs. */
typedef struct cvol_mpi_span {
    uint32_t begin, end, pixels, runs;
} cvol_mpi_span;

cvol_mpi_span cvol_mpi_span_of(const cvol_sheet_lines *lines, size_t group,
                               const cvol_mpi_blend *blend);

/* Copies the pixels that show something into *out, which has room for them, and back. spans: of all
 * groups. */
void cvol_mpi_fragment_read(cvol_mpi_fragment *out, const cvol_sheet_lines *lines,
                            const cvol_mpi_span *spans, const cvol_mpi_blend *blend);
void cvol_mpi_fragment_write(const cvol_sheet_lines *lines, const cvol_mpi_fragment *fragment,
                             const cvol_mpi_blend *blend);

/* ---- messages ------------------------------------------------------------------------------ */

/* A message is an array of cells of 8 bytes: the numbers of runs and pixels, the runs, the values.
 * The number of cells that suffice for a fragment: */
size_t cvol_mpi_message_cells(size_t runs, size_t pixels, const cvol_mpi_blend *blend);
/* ... and for any fragment of `pixels` pixels in a row, shown or not: */
size_t cvol_mpi_message_most(size_t pixels, const cvol_mpi_blend *blend);

/* The fragment in a message. */
cvol_mpi_fragment cvol_mpi_fragment_of_message(cvol_mpi_run *message);

/* A place in a fragment. */
typedef struct cvol_mpi_cursor {
    const cvol_mpi_run *run, *end;
    uint32_t done; /* pixels of *run that are before the place */
    const float *values;
} cvol_mpi_cursor;

/* Its start. */
cvol_mpi_cursor cvol_mpi_cursor_of(const cvol_mpi_fragment *fragment);

/* Copies the pixels from the cursor on, up to number `end`, into a message and moves the cursor
 * behind them. Returns the number of cells. */
size_t cvol_mpi_message_cut(cvol_mpi_run *message, cvol_mpi_cursor *cursor, size_t end,
                            const cvol_mpi_blend *blend);

/* Merges fragments, from front to back, into *out, which has room for them and overlaps none. Moves
 * the cursors to their ends. Cost: each pixel is read once; a pass over the cursors for each place
 * where a run of any of them begins or ends. */
void cvol_mpi_fragment_merge(cvol_mpi_fragment *out, cvol_mpi_cursor *cursors, size_t count,
                             const cvol_mpi_blend *blend);

#endif
