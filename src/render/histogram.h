/* What histograms of volumes and of arrays share. */
#ifndef CVOL_RENDER_HISTOGRAM_H
#define CVOL_RENDER_HISTOGRAM_H

#include "cvol/render.h"

/* The values of some samples, one after the other: calls `visit` for each. */
typedef struct cvol_sample_source {
    const void *of;
    void (*each)(const struct cvol_sample_source *source, void (*visit)(void *user, double value),
                 void *user);
} cvol_sample_source;

/* Counts them within out->min .. out->max, or within less, if what lies at one end is a mark that
 * stands for no value (cvol/render.h). */
void cvol_histogram_count(cvol_histogram *out, const cvol_sample_source *source);
/* The mean length of a ray through the volume, in mean spacings. */
double cvol_histogram_chord(const cvol_grid *grid);

#endif
