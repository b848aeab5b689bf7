/* A transfer function as a fine table, with opacity corrected for the ray's step. */
#ifndef CVOL_RENDER_RAY_TABLE_H
#define CVOL_RENDER_RAY_TABLE_H

#include "render/transfer/transfer.h"

typedef struct cvol_ray_table {
    double lo, scale;    /* entry i is for the value lo + i / scale */
    size_t last;         /* index of the last entry, at least 1 */
    float (*entries)[4]; /* r, g, b, opacity over one step */
} cvol_ray_table;

/* The table for samples that range over min..max, for steps of `step` mean spacings. The caller
 * frees table->entries. */
int cvol_ray_table_make(cvol_context *context, cvol_ray_table *table, const cvol_transfer *transfer,
                        double min, double max, double step);

/* Colour and opacity at a value, linear between entries. */
static inline void cvol_ray_table_at(double out[4], const cvol_ray_table *table, double value)
{
    double place = (value - table->lo) * table->scale;
    place = place > 0 ? place : 0;
    size_t i = place < (double)table->last ? (size_t)place : table->last - 1;
    double t = place < (double)table->last ? place - (double)i : 1;
    const float *p = table->entries[i], *q = table->entries[i + 1];
    for (int c = 0; c < 4; c++)
        out[c] = (double)p[c] + ((double)q[c] - (double)p[c]) * t;
}

#endif
