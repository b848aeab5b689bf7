/* Operands: samples are synthesised (or noise), cvol compresses them, and the classical way keeps
 * the same terms of the same samples. */
#define _DEFAULT_SOURCE /* M_PI */
#include "operands.h"

#include <math.h>
#include <stdlib.h>

#include "timing.h"

void operand_low(size_t low[3], const operand_shape *shape)
{
    for (int a = 0; a < 3; a++)
        low[a] = a < shape->rank ? shape->count : 1;
}

static int by_start(const void *a, const void *b)
{
    const uint32_t x = ((const dense_run *)a)->start, y = ((const dense_run *)b)->start;
    return (x > y) - (x < y);
}

static void band(dense_terms *out, const dense *d, size_t width, uint64_t *state)
{
    const double place = (1 + bench_random(state)) / 2;
    dense_run *runs = bench_allocate(sizeof *runs);
    runs[0].start = 1 + (uint32_t)(place * (double)(d->coefficients - 2 - width));
    runs[0].length = (uint32_t)width;
    dense_terms_make(out, d, runs, 1);
}

static void harmonics(dense_terms *out, const dense *d, size_t count, size_t fundamental)
{
    enum { HARMONICS = 8 };
    dense_run *runs = bench_allocate(sizeof *runs * HARMONICS);
    for (size_t h = 0; h < HARMONICS; h++)
        runs[h] = (dense_run){(uint32_t)((h + 1) * fundamental), (uint32_t)(count / HARMONICS)};
    dense_terms_make(out, d, runs, HARMONICS);
}

static void progression(dense_terms *out, const dense *d, size_t count, size_t step)
{
    const size_t n = d->dims[0];
    dense_run *runs = bench_allocate(sizeof *runs * count);
    for (size_t i = 0; i < count; i++) {
        const size_t u = step * (i + 1) % n;
        runs[i] = (dense_run){(uint32_t)(2 * u < n ? u : n - u), 1};
    }
    qsort(runs, count, sizeof *runs, by_start);
    dense_terms_make(out, d, runs, count);
}

void operand_make(cvol_context *context, operand *out, const operand_shape *shape, dense *d,
                  uint64_t *state)
{
    const cvol_grid grid = cvol_grid_make(shape->dims[0], shape->dims[1], shape->dims[2],
                                          CVOL_FLOAT32);
    cvol_keep keep = cvol_keep_terms(0, shape->count);
    if (shape->kind == OPERAND_LOW_BOX) {
        size_t low[3];
        operand_low(low, shape);
        dense_low_box(&out->terms, d, low);
        for (size_t i = 0; i < d->samples; i++)
            d->a[i] = (float)bench_random(state);
        keep = cvol_keep_terms(shape->count, 0);
    } else {
        if (shape->kind == OPERAND_BANDS)
            band(&out->terms, d, shape->count / 2, state);
        else if (shape->kind == OPERAND_HARMONICS)
            harmonics(&out->terms, d, shape->count / 2, shape->step);
        else
            progression(&out->terms, d, shape->count / 2, shape->step);
        /* Magnitudes from 1 to 2, so that no rounding error comes near them. */
        for (size_t i = 0; i < out->terms.value_count; i += 2) {
            const double length = 1.5 + bench_random(state) / 2, angle = M_PI * bench_random(state);
            out->terms.values[i] = (float)(length * cos(angle));
            out->terms.values[i + 1] = (float)(length * sin(angle));
        }
        dense_synthesise(d, &out->terms);
    }
    bench_check(context,
                cvol_array_compress(context, &out->array, d->a, &grid, shape->rank,
                                    shape->transform, 0, &keep),
                "compressing an operand");
    dense_analyse(d, &out->terms);
}

void operand_free(operand *o)
{
    cvol_array_free(o->array);
    dense_terms_free(&o->terms);
}
