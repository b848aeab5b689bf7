/* Internals of the fourier engine: padded spectra, slices through them, and pictures of slices.
 *
 * A spectrum belongs to samples i of each axis at the positions i - n / 2 (truncated to an integer)
 * in space, and represents
 *
 *     F(g) = sum_i f[i] exp(-2 pi i sum_a g_a (i_a - n_a / 2) / N_a)
 *
 * at real g: g_a / N_a is a frequency in cycles per sample. N is at least 3/2 n. Values at integer
 * g are stored; the kernel interpolates between neighbours (kernel.h; samples were divided by the
 * kernel's gain before). */
#ifndef CVOL_RENDER_FOURIER_SPECTRUM_H
#define CVOL_RENDER_FOURIER_SPECTRUM_H

#include "base/cpu.h"
#include "render/engine/engine.h"
#include "render/fourier/kernel.h"
#include "render/fourier/source.h"

/* ---- spectra: spectrum.c --------------------------------------------------------------------- */

/* Places stored before the first of each axis and behind the last, for the kernel. A row of
 * neighbours is read as CVOL_FOURIER_ROW places; the last ones have weight 0. */
#define CVOL_FOURIER_BEFORE 2
#define CVOL_FOURIER_BEHIND 4
#define CVOL_FOURIER_ROW 8

/* Only the strongest places, in bricks of SIDE along each axis, of u + 2, v and w: brick b's values
 * are first[b] .. first[b + 1] - 1, for the places whose bits are set in words[8 b + w % 8], bit 8
 * (v % 8) + (u + 2) % 8. */
#define CVOL_FOURIER_BRICK 8
typedef struct cvol_fourier_bricks {
    size_t count[3], all;
    size_t *first;
    uint64_t *words;
    uint16_t *values; /* pairs */
    double lost;      /* energy left out over all energy, as L2 norms */
} cvol_fourier_bricks;

/* Place (u, v, w), 0 <= u <= N_x / 2, 0 <= v < N_y, 0 <= w < N_z, is the pair of half floats at
 *     2 ((u + 2) + stride_v (v + 2) + stride_w (w + 2)),
 * times `unit`; the places around them are stored as well. Or there are bricks, and no values. */
typedef struct cvol_fourier_spectrum {
    size_t dims[3]; /* N, even */
    size_t stride_v, stride_w, places;
    uint16_t *values;
    cvol_fourier_bricks bricks;
    float unit;
} cvol_fourier_spectrum;

/* A renderer's spectra of its samples: f - base, times 1/2 for each of the volume's faces that a
 * sample lies on (integrals end there), 0 without a value; and, if some samples have no value, the
 * same of 1 for samples with a value. */
typedef struct cvol_fourier_volume {
    cvol_fourier_spectrum samples, cover;
    int masked;
    double base;
} cvol_fourier_volume;

/* rho: kept places, twice, over the samples; 0: all. */
int cvol_fourier_volume_make(cvol_context *context, cvol_fourier_volume *out,
                             const cvol_fourier_source *source, double rho);
void cvol_fourier_volume_free(cvol_fourier_volume *volume);
/* Bytes of the stored values, and places. */
uint64_t cvol_fourier_spectrum_bytes(const cvol_fourier_spectrum *spectrum);
uint64_t cvol_fourier_spectrum_places(const cvol_fourier_spectrum *spectrum);

/* ---- bricks: bricks.c ------------------------------------------------------------------------ */

/* Keeps the strongest places, no more than `most`, and those next to the first and the last of
 * x. */
int cvol_fourier_keep_strongest(cvol_context *context, cvol_fourier_spectrum *of, double most);
void cvol_fourier_bricks_free(cvol_fourier_bricks *bricks);

/* Bricks of a slice, unpacked: brick b is page table[b], rows of 16 places for each v and w, the
 * last of them from the next brick. Page 0 is empty. */
#define CVOL_FOURIER_PAGE_ROW 16
typedef struct cvol_fourier_pages {
    uint32_t *table;
    uint16_t *values;
    size_t room; /* pages */
} cvol_fourier_pages;

/* Unpacks the part that the plane through 0 across `normal` (by g) needs. */
int cvol_fourier_pages_load(cvol_context *context, cvol_fourier_pages *pages,
                            const cvol_fourier_spectrum *of, const double normal[3]);
void cvol_fourier_pages_free(cvol_fourier_pages *pages);

/* ---- slices: slice.c ------------------------------------------------------------------------- */

/* The lattice on which a view's slice is transformed: point (a, b) lies at ((a - shift[0]) right +
 * (b - shift[1]) up) space from the volume's middle. */
typedef struct cvol_fourier_slice_grid {
    size_t dims[2];
    double shift[2], space;
    double middle[2]; /* the picture's, from the volume's, along right and up */
    int aligned;      /* every pixel is a point: pixel (0, 0) is point (first[0], first[1]) */
    ptrdiff_t first[2];
} cvol_fourier_slice_grid;
void cvol_fourier_slice_grid_make(cvol_fourier_slice_grid *out, const cvol_grid *grid,
                                  const cvol_view *view); /* slice_grid.c */

/* Depth cueing: a sample at t along the eye's direction from the middle counts near + slope t. */
typedef struct cvol_fourier_depth_cue {
    double near, slope;
} cvol_fourier_depth_cue;

/* Sums along rays at the lattice's points, in world length: of samples (minus base, cued), and of
 * their weights; rows of dims[0], from the lowest on. */
typedef struct cvol_fourier_planes {
    cvol_fourier_slice_grid slice_grid;
    float *sums, *weights;
    /* Scratch: columns of frequencies. */
    float *columns[2];
    size_t column_stride, room[2];
    cvol_fourier_pages samples, cover; /* for spectra in bricks */
} cvol_fourier_planes;

int cvol_fourier_project(cvol_context *context, cvol_fourier_planes *planes,
                         const cvol_fourier_volume *volume, const cvol_grid *grid,
                         const cvol_view *view, const cvol_fourier_depth_cue *cue,
                         const cvol_fourier_kernel *kernel);
void cvol_fourier_planes_free(cvol_fourier_planes *planes);

/* ---- kernels: slice_simd.c ------------------------------------------------------------------- */

/* `count` points of a slice, g_a = start[a] + k step[a]. */
typedef struct cvol_fourier_line {
    const cvol_fourier_spectrum *spectrum;
    const cvol_fourier_pages *pages; /* for a spectrum in bricks */
    const cvol_fourier_kernel *kernel;
    double start[3], step[3];
    /* The result is near F + i sum_a slope[a] dF / dg_a; all slopes 0: F alone. */
    float near, slope[3];
    int cued;
    size_t count;
} cvol_fourier_line;

/* Writes F at the points of a line to re[] and im[], which have room for CVOL_FOURIER_RUN more. */
#define CVOL_FOURIER_RUN 16
CVOL_SIMD_DECLARE(void, cvol_fourier_gather, (float *re, float *im, const cvol_fourier_line *line));

/* The factors of a line's points: sum[k] = product over axes of sinc(g_a / N_a)^power[a], and
 * box[k], the transform of 1 within the volume: product of length[a] sinc(intervals[a] g_a / N_a)
 * sinc(2 g_a / N_a) (power 2), or of length[a] sinc(g_a / N_a) (power 1); sinc(t) = sin(pi t) / (pi
 * t). */
typedef struct cvol_fourier_filter {
    double start[3], step[3]; /* of g_a / N_a */
    int power[3];             /* 1: an axis of one sample, with the thickness of its spacing */
    double intervals[3], length[3];
    size_t count;
} cvol_fourier_filter;
CVOL_SIMD_DECLARE(void, cvol_fourier_weigh,
                  (float *sum, float *box, const cvol_fourier_filter *filter));

/* Converts floats to half floats, rounded to the nearest. */
CVOL_SIMD_DECLARE(void, cvol_fourier_pack,
                  (uint16_t * out, const float *in, size_t count, float scale));

#endif
