/* Palettes (palette.h).
 *
 * Colours are counted in 32^3 cells. The set of all cells is repeatedly cut in two: always the part
 * with the largest squared distance from its mean, across its widest axis, at the mean (Wan, Wong,
 * Prusinkiewicz 1988); some rounds of Lloyd's algorithm follow. Pixels are dithered by Bayer's 8 x
 * 8 matrix, which does not move between the pictures of a film, as error diffusion would. Colours
 * of the palette are not dithered. */
#include "image/palette.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BITS 5
#define CELLS (1 << (3 * BITS))
#define ROUNDS 4
#define FINE_BITS 6 /* of the cache of nearest colours */
#define FINE (1 << (3 * FINE_BITS))
#define UNKNOWN 255
#define EXACT 3 /* squared distance up to which a pixel is not dithered */

typedef struct cell {
    double count, sum[3];
} cell;

/* Cells order[first] .. order[end - 1]. */
typedef struct part {
    int first, end, axis;
    double count, mean[3], error; /* error: the sum of squares along `axis` */
} part;

struct cvol_palette {
    cell *cells;
    int size;
    uint8_t colours[CVOL_PALETTE_MAX][3];
    float spread;     /* of dithering */
    uint8_t *nearest; /* of fine cells; UNKNOWN: not searched yet */
};

cvol_palette *cvol_palette_create(void)
{
    cvol_palette *palette = calloc(1, sizeof *palette);
    if (!palette)
        return NULL;
    palette->cells = calloc(CELLS, sizeof *palette->cells);
    palette->nearest = malloc(FINE);
    if (!palette->cells || !palette->nearest) {
        cvol_palette_free(palette);
        return NULL;
    }
    memset(palette->nearest, UNKNOWN, FINE);
    return palette;
}

void cvol_palette_free(cvol_palette *palette)
{
    if (!palette)
        return;
    free(palette->cells);
    free(palette->nearest);
    free(palette);
}

void cvol_palette_count(cvol_palette *palette, const uint8_t *rgba, size_t pixels)
{
    for (size_t i = 0; i < pixels; i++, rgba += 4) {
        const int shift = 8 - BITS;
        cell *c = &palette->cells[(rgba[0] >> shift) << 2 * BITS | (rgba[1] >> shift) << BITS |
                                  rgba[2] >> shift];
        c->count++;
        for (int k = 0; k < 3; k++)
            c->sum[k] += rgba[k];
    }
}

/* ---- choosing --------------------------------------------------------------------------- */

static double level(const cell *c, int axis)
{
    return c->sum[axis] / c->count;
}

static void measure(part *p, const cell *cells, const int *order)
{
    double squares[3] = {0}, sum[3] = {0};
    p->count = p->error = 0;
    for (int i = p->first; i < p->end; i++) {
        const cell *c = &cells[order[i]];
        p->count += c->count;
        for (int k = 0; k < 3; k++) {
            sum[k] += c->sum[k];
            squares[k] += c->sum[k] * level(c, k);
        }
    }
    for (int k = 0; k < 3; k++) {
        p->mean[k] = sum[k] / p->count;
        const double error = squares[k] - sum[k] * p->mean[k];
        if (k == 0 || error > p->error) {
            p->error = error;
            p->axis = k;
        }
    }
    if (p->end - p->first < 2)
        p->error = 0;
}

/* Puts the cells below the mean first; returns the place of the first other one. */
static int divide(const part *p, const cell *cells, int *order)
{
    int at = p->first;
    for (int i = p->first; i < p->end; i++)
        if (level(&cells[order[i]], p->axis) < p->mean[p->axis]) {
            const int kept = order[at];
            order[at++] = order[i];
            order[i] = kept;
        }
    return at;
}

static int cut(part *parts, const cell *cells, int *order, int cell_count)
{
    int count = 1;
    parts[0] = (part){.end = cell_count};
    measure(&parts[0], cells, order);
    while (count < CVOL_PALETTE_MAX) {
        int widest = 0;
        for (int i = 1; i < count; i++)
            if (parts[i].error > parts[widest].error)
                widest = i;
        part *p = &parts[widest], *q = &parts[count];
        if (!(p->error > 1e-6 * p->count))
            break;
        const int middle = divide(p, cells, order);
        if (middle == p->first || middle == p->end)
            break;
        *q = (part){.first = middle, .end = p->end};
        p->end = middle;
        measure(p, cells, order);
        measure(q, cells, order);
        count++;
    }
    return count;
}

static int nearest_mean(const double (*means)[3], int count, const double colour[3])
{
    int best = 0;
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        const double r = means[i][0] - colour[0], g = means[i][1] - colour[1],
                     b = means[i][2] - colour[2], far = r * r + g * g + b * b;
        if (far < least) {
            least = far;
            best = i;
        }
    }
    return best;
}

static void refine_means(double (*means)[3], int count, const cell *cells, const int *order,
                         int cell_count)
{
    cell sums[CVOL_PALETTE_MAX];
    for (int round = 0; round < ROUNDS; round++) {
        memset(sums, 0, sizeof sums);
        for (int i = 0; i < cell_count; i++) {
            const cell *c = &cells[order[i]];
            const double colour[3] = {level(c, 0), level(c, 1), level(c, 2)};
            cell *to = &sums[nearest_mean((const double(*)[3])means, count, colour)];
            to->count += c->count;
            for (int k = 0; k < 3; k++)
                to->sum[k] += c->sum[k];
        }
        for (int i = 0; i < count; i++)
            for (int k = 0; k < 3 && sums[i].count > 0; k++)
                means[i][k] = level(&sums[i], k);
    }
}

static int distance(const uint8_t a[3], const int b[3])
{
    const int r = a[0] - b[0], g = a[1] - b[1], c = a[2] - b[2];
    return r * r + g * g + c * c;
}

/* Half the mean distance of neighbours. */
static float find_spread(const cvol_palette *palette)
{
    double sum = 0;
    for (int i = 0; i < palette->size; i++) {
        const uint8_t *colour = palette->colours[i];
        const int at[3] = {colour[0], colour[1], colour[2]};
        int least = 255 * 255;
        for (int j = 0; j < palette->size; j++)
            if (j != i && distance(palette->colours[j], at) < least)
                least = distance(palette->colours[j], at);
        sum += sqrt(least);
    }
    return palette->size > 1 ? (float)(sum / palette->size / sqrt(3)) : 0;
}

int cvol_palette_choose(cvol_palette *palette)
{
    part parts[CVOL_PALETTE_MAX];
    double means[CVOL_PALETTE_MAX][3];
    int cell_count = 0;
    int *order = malloc(CELLS * sizeof *order);
    if (!order)
        return 0;
    for (int i = 0; i < CELLS; i++)
        if (palette->cells[i].count > 0)
            order[cell_count++] = i;
    palette->size = cell_count ? cut(parts, palette->cells, order, cell_count) : 0;
    for (int i = 0; i < palette->size; i++)
        memcpy(means[i], parts[i].mean, sizeof means[i]);
    refine_means(means, palette->size, palette->cells, order, cell_count);
    for (int i = 0; i < palette->size; i++)
        for (int k = 0; k < 3; k++)
            palette->colours[i][k] = (uint8_t)(means[i][k] + 0.5);
    palette->spread = find_spread(palette);
    free(order);
    return 1;
}

int cvol_palette_size(const cvol_palette *palette)
{
    return palette->size;
}

const uint8_t *cvol_palette_colour(const cvol_palette *palette, int index)
{
    return palette->colours[index];
}

/* ---- using ------------------------------------------------------------------------------ */

static uint8_t find(cvol_palette *palette, const int colour[3])
{
    const int shift = 8 - FINE_BITS;
    uint8_t *known = &palette->nearest[(colour[0] >> shift) << 2 * FINE_BITS |
                                       (colour[1] >> shift) << FINE_BITS | colour[2] >> shift];
    if (*known != UNKNOWN)
        return *known;
    int least = 3 * 255 * 255 + 1;
    for (int i = 0; i < palette->size; i++) {
        const int far = distance(palette->colours[i], colour);
        if (far < least) {
            least = far;
            *known = (uint8_t)i;
        }
    }
    return *known;
}

/* Bayer's matrix: the bits of x ^ y and y, interleaved from the lowest up. */
static float threshold(int x, int y)
{
    int value = 0;
    for (int bit = 0; bit < 3; bit++)
        value = value << 2 | (((x ^ y) >> bit & 1) << 1) | (y >> bit & 1);
    return ((float)value + 0.5f) / 64 - 0.5f;
}

void cvol_palette_map(cvol_palette *palette, uint8_t *indices, const uint8_t *rgba, int width,
                      int y)
{
    for (int x = 0; x < width; x++, rgba += 4) {
        const int colour[3] = {rgba[0], rgba[1], rgba[2]};
        indices[x] = find(palette, colour);
        if (distance(palette->colours[indices[x]], colour) <= EXACT)
            continue;
        int moved[3];
        for (int k = 0; k < 3; k++) {
            const float to = (float)colour[k] + palette->spread * threshold(x & 7, y & 7);
            moved[k] = to < 0 ? 0 : to > 255 ? 255 : (int)(to + 0.5f);
        }
        indices[x] = find(palette, moved);
    }
}
