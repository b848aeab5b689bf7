/* Push and pull, brick by brick. */
#include "codec/mask/mask_fill.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "codec/brick/brick_code.h"

enum { SIDE = CVOL_BRICK_SIDE, LEVELS = 7, SWEEPS = 3 };

/* One grid of the pyramid. */
typedef struct level {
    size_t size[3];
    double *values, *next;
    uint8_t *known;
} level;

/* One thread's memory. */
typedef struct pyramid {
    level levels[LEVELS];
    uint8_t *which;
} pyramid;

static void pyramid_free(pyramid *p)
{
    for (int l = 0; l < LEVELS; l++) {
        free(p->levels[l].values);
        free(p->levels[l].next);
        free(p->levels[l].known);
    }
    free(p->which);
}

static int pyramid_make(pyramid *p)
{
    int done = 1;
    memset(p, 0, sizeof *p);
    for (int l = 0; l < LEVELS; l++) {
        const size_t side = SIDE >> l, count = side * side * side;
        p->levels[l].values = cvol_allocate(count, sizeof(double));
        p->levels[l].next = cvol_allocate(count, sizeof(double));
        p->levels[l].known = cvol_allocate(count, 1);
        done = done && p->levels[l].values && p->levels[l].next && p->levels[l].known;
    }
    p->which = cvol_allocate((size_t)SIDE * SIDE * SIDE, 1);
    return done && p->which;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Averages the known points among the (up to) eight fine points under each coarse one. */
static void push(level *coarse, const level *fine)
{
    const size_t *n = coarse->size, *m = fine->size;
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        const size_t at[3] = {2 * (i % n[0]), 2 * (i / n[0] % n[1]), 2 * (i / n[0] / n[1])};
        double sum = 0;
        int count = 0;
        for (size_t z = at[2]; z < least(at[2] + 2, m[2]); z++)
            for (size_t y = at[1]; y < least(at[1] + 2, m[1]); y++)
                for (size_t x = at[0]; x < least(at[0] + 2, m[0]); x++) {
                    const size_t j = x + m[0] * (y + m[1] * z);
                    if (fine->known[j]) {
                        sum += fine->values[j];
                        count++;
                    }
                }
        coarse->known[i] = count > 0;
        coarse->values[i] = count ? sum / count : 0;
    }
}

/* The two coarse points next to a fine one: the nearer weighs 3/4. */
typedef struct between {
    size_t near, far;
} between;

static between find_between(size_t at, size_t points)
{
    const size_t near = at / 2;
    return (between){near, at & 1 ? least(near + 1, points - 1) : near ? near - 1 : 0};
}

/* Sets unknown points by trilinear interpolation. */
static void interpolate(level *fine, const level *coarse)
{
    const size_t *n = fine->size, *m = coarse->size;
    for (size_t z = 0; z < n[2]; z++) {
        const between bz = find_between(z, m[2]);
        for (size_t y = 0; y < n[1]; y++) {
            const between by = find_between(y, m[1]);
            const double *lines[4] = {coarse->values + m[0] * (by.near + m[1] * bz.near),
                                      coarse->values + m[0] * (by.far + m[1] * bz.near),
                                      coarse->values + m[0] * (by.near + m[1] * bz.far),
                                      coarse->values + m[0] * (by.far + m[1] * bz.far)};
            const size_t line = n[0] * (y + n[1] * z);
            const uint8_t *known = fine->known + line;
            double *to = fine->values + line, mixed[SIDE / 2];
            if (!memchr(known, 0, n[0]))
                continue;
            for (size_t x = 0; x < m[0]; x++)
                mixed[x] = 0.5625 * lines[0][x] + 0.1875 * (lines[1][x] + lines[2][x]) +
                           0.0625 * lines[3][x];
            for (size_t x = 0; x < n[0]; x++) {
                const between bx = find_between(x, m[0]);
                if (!known[x])
                    to[x] = 0.75 * mixed[bx.near] + 0.25 * mixed[bx.far];
            }
        }
    }
}

/* Sets every unknown point of a line to the mean of its neighbours; `others`: the four adjacent
 * lines, zeros at the brick's ends, and their number. */
static void smooth_line(double *to, const double *at, const uint8_t *known,
                        const double *const others[4], int neighbours, size_t count)
{
    const double *a = others[0], *b = others[1], *c = others[2], *d = others[3];
    const double inside = neighbours + 2, end = neighbours + (count > 1);
    for (size_t x = 1; x + 1 < count; x++) {
        const double mean = (a[x] + b[x] + c[x] + d[x] + at[x - 1] + at[x + 1]) / inside;
        to[x] = known[x] ? at[x] : mean;
    }
    for (size_t x = 0; x<count; x += count> 1 ? count - 1 : 1) {
        const double beyond = count > 1 ? at[x ? x - 1 : 1] : 0;
        const double sum = a[x] + b[x] + c[x] + d[x] + beyond;
        to[x] = known[x] || end <= 0 ? at[x] : sum / end;
    }
}

/* Sets every unknown point to the mean of its neighbours. */
static void smooth(level *l)
{
    static const double zeros[SIDE] = {0};
    const size_t *n = l->size, slice = n[0] * n[1];
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++) {
            const size_t line = n[0] * y + slice * z;
            const double *at = l->values + line;
            const double *others[4] = {y ? at - n[0] : zeros, y + 1 < n[1] ? at + n[0] : zeros,
                                       z ? at - slice : zeros, z + 1 < n[2] ? at + slice : zeros};
            const int neighbours = (y > 0) + (y + 1 < n[1]) + (z > 0) + (z + 1 < n[2]);
            if (memchr(l->known + line, 0, n[0]))
                smooth_line(l->next + line, at, l->known + line, others, neighbours, n[0]);
            else
                memcpy(l->next + line, at, n[0] * sizeof *at);
        }
    double *swap = l->values;
    l->values = l->next;
    l->next = swap;
}

static void pull(level *fine, const level *coarse)
{
    interpolate(fine, coarse);
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        smooth(fine);
}

/* Fills a brick; values and known of level 0 are set, and some sample is known. */
static void fill_brick(pyramid *p)
{
    for (int l = 1; l < LEVELS; l++) {
        for (int a = 0; a < 3; a++)
            p->levels[l].size[a] = (p->levels[l - 1].size[a] + 1) / 2;
        push(&p->levels[l], &p->levels[l - 1]);
    }
    for (int l = LEVELS - 1; l > 0; l--)
        pull(&p->levels[l - 1], &p->levels[l]);
}

typedef struct fill_job {
    void *out;
    const void *samples;
    const cvol_grid *grid;
    const cvol_mask *mask;
    size_t first;
    double otherwise;
} fill_job;

/* Reads a brick's line into doubles, or writes its masked samples back. */
static void move_line(const fill_job *job, double *line, const uint8_t *which, size_t at,
                      size_t count, int back)
{
    const int is_integer = cvol_type_is_integer(job->grid->type);
#define MOVE(type)                                                                 \
    for (size_t x = 0; x < count; x++)                                             \
        if (!back)                                                                 \
            line[x] = which[x] ? 0 : (double)((const type *)job->samples)[at + x]; \
        else if (which[x])                                                         \
    ((type *)job->out)[at + x] = (type)(is_integer ? floor(line[x] + 0.5) : line[x])
    CVOL_FOR_TYPE(job->grid->type, MOVE);
#undef MOVE
}

static void do_brick(pyramid *p, const fill_job *job, const size_t begin[3], const size_t end[3])
{
    const size_t size[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]};
    const size_t *dims = job->grid->dims;
    const size_t masked = cvol_mask_get(p->which, job->mask, begin, end);
    const int all = masked == size[0] * size[1] * size[2];
    if (!masked)
        return;
    memcpy(p->levels[0].size, size, sizeof size);
    for (int back = 0; back < 2; back++) {
        for (size_t z = 0; z < size[2]; z++)
            for (size_t y = 0; y < size[1]; y++) {
                const size_t line = size[0] * (y + size[1] * z);
                move_line(job, p->levels[0].values + line, p->which + line,
                          begin[0] +
                              dims[0] * (begin[1] + y + dims[1] * (begin[2] + z - job->first)),
                          size[0], back);
            }
        for (size_t i = 0; i < size[0] * size[1] * size[2] && !back && all; i++)
            p->levels[0].values[i] = job->otherwise;
        for (size_t i = 0; i < size[0] * size[1] * size[2] && !back && !all; i++)
            p->levels[0].known[i] = !p->which[i];
        if (!back && !all)
            fill_brick(p);
    }
}

int cvol_mask_fill(cvol_context *context, void *out, const void *samples, const cvol_grid *grid,
                   const cvol_mask *mask, size_t first, size_t end, double otherwise)
{
    const size_t *dims = grid->dims, slice = dims[0] * dims[1] * cvol_type_size(grid->type);
    const fill_job job = {out, samples, grid, mask, first, otherwise};
    const size_t across[2] = {(dims[0] - 1) / SIDE + 1, (dims[1] - 1) / SIDE + 1};
    const size_t bricks = across[0] * across[1] * ((end - first - 1) / SIDE + 1);
    int failed = 0, code = cvol_report_progress(context, "filling", 0);
    if (code)
        return code;
    memcpy(out, samples, slice * (end - first));
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        pyramid p;
        const int made = pyramid_make(&p);
        if (!made) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic)
        for (size_t b = 0; b < bricks; b++) {
            const size_t begin[3] = {b % across[0] * SIDE, b / across[0] % across[1] * SIDE,
                                     first + b / across[0] / across[1] * SIDE};
            const size_t stop[3] = {least(begin[0] + SIDE, dims[0]),
                                    least(begin[1] + SIDE, dims[1]), least(begin[2] + SIDE, end)};
            if (made)
                do_brick(&p, &job, begin, stop);
        }
        pyramid_free(&p);
    }
    return failed
               ? cvol_fail_memory(context, (size_t)SIDE * SIDE * SIDE * sizeof(double), "a brick")
               : CVOL_OK;
}
