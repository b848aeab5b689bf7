/* A volume at a low resolution: one sample for each cell of a few samples. Light that reaches a
 * place, and the part of a volume that is visible, vary slowly and are computed from it. */
#ifndef CVOL_RENDER_LIGHT_COARSE_H
#define CVOL_RENDER_LIGHT_COARSE_H

#include "cvol/volume.h"

typedef struct cvol_coarse {
    size_t dims[3];
    /* Along axis a, cell i is centred at sample first[a] + i pitch[a], and is length[a] mean
     * spacings long. */
    double first[3], pitch[3], length[3];
    double offset; /* so that single precision suffices for values far from 0 */
    float *values; /* the mean of each cell less the offset, x fastest */
    float *cover;  /* the share of each cell that has values; NULL: all have */
} cvol_coarse;

/* The level of the cells, 2^level samples long: the longest axis has 48 to 96 cells or, with cells
 * of 8 samples and more, at most 255. */
int cvol_coarse_level(const cvol_grid *grid);
/* Sets all but the values, and allocates these, and the covers if has_cover. Errors: MEMORY. */
int cvol_coarse_allocate(cvol_context *context, cvol_coarse *out, const cvol_grid *grid, int level,
                         int has_cover);
/* The means of a dense volume; mask: see cvol_source. Errors: MEMORY. */
int cvol_coarse_of_volume(cvol_context *context, cvol_coarse *out, const cvol_volume *volume,
                          const uint8_t *mask);
/* Surrounds the cells with one layer of cells without matter, whose covers are 0: light that falls
 * onto the faces of the volume comes through them. Errors: MEMORY; the cells are
 * then freed. */
int cvol_coarse_surround(cvol_context *context, cvol_coarse *coarse);
void cvol_coarse_free(cvol_coarse *coarse);

/* The mean of cell i. */
static inline double cvol_coarse_value(const cvol_coarse *coarse, size_t i)
{
    return coarse->offset + (double)coarse->values[i];
}

static inline size_t cvol_coarse_count(const cvol_coarse *coarse)
{
    return coarse->dims[0] * coarse->dims[1] * coarse->dims[2];
}

#endif
