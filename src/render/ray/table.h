/* A transfer function as a fine table, with opacity corrected for the ray's step. */
#ifndef CVOL_RENDER_RAY_TABLE_H
#define CVOL_RENDER_RAY_TABLE_H

#include <math.h>

#include "render/transfer/transfer.h"

/* An interval is smooth up to this variation ... */
#define CVOL_RAY_VARIATION 0.125
/* ... and this product of its bend and its difference of values: its mean then differs by at most
 * 2^-12 from the middle. */
#define CVOL_RAY_BEND 0x1p-9

/* A cell of the table, from its entry to the next. */
typedef struct cvol_ray_cell {
    double variation, bend; /* of the cells before this one; see table.c */
    uint32_t visible;       /* cells before this one that are not transparent everywhere */
    uint32_t segment;       /* points of the function with at most its first value: the index of the
                               linear segment that begins there */
} cvol_ray_cell;

typedef struct cvol_ray_table {
    const cvol_transfer *transfer;
    double step;          /* in mean spacings */
    double lo, scale;     /* entry i is for the value lo + i / scale */
    size_t last;          /* index of the last entry, at least 1 */
    float (*entries)[4];  /* r, g, b, opacity over one step */
    cvol_ray_cell *cells; /* last + 1 of them; the last has no entry behind it */
} cvol_ray_table;

/* The table for samples that range over min..max, for steps of `step` mean spacings. It refers to
 * the transfer function. The caller frees it, also after an error. */
int cvol_ray_table_make(cvol_context *context, cvol_ray_table *table, const cvol_transfer *transfer,
                        double min, double max, double step);
void cvol_ray_table_free(cvol_ray_table *table);

/* The index of a value's cell. */
static inline size_t cvol_ray_table_cell(const cvol_ray_table *table, double value)
{
    const double place = (value - table->lo) * table->scale;
    if (!(place > 0))
        return 0;
    return place < (double)table->last ? (size_t)place : table->last - 1;
}

/* 1 if all values of cells a to b are transparent; a <= b. */
static inline int cvol_ray_table_hides(const cvol_ray_table *table, size_t a, size_t b)
{
    return table->cells[a].visible == table->cells[b + 1].visible;
}

/* 1 if one part in the middle is enough for an interval of values in cells a to b, a <= b, whose
 * ends differ by `change`. */
static inline int cvol_ray_table_is_smooth(const cvol_ray_table *table, size_t a, size_t b,
                                           double change)
{
    const cvol_ray_cell *begin = &table->cells[a], *end = &table->cells[b + 1];
    return end->variation - begin->variation <= CVOL_RAY_VARIATION &&
           (end->bend - begin->bend) * fabs(change) <= CVOL_RAY_BEND;
}

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
