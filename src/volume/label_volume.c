/* Decides if a volume's samples are labels, by its file or by the samples themselves.
 *
 * Regions of one label are wide, so nearly all neighbours are equal; across the face of two regions
 * they differ by any amount. Scanned samples have noise, and computed ones change by small amounts.
 * Pairs of two background samples (the commonest value) do not count. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/for_type.h"
#include "cvol/codec.h"
#include "volume/formats/nifti_intent.h"
#include "volume/formats/zarr/labels.h"
#include "volume/io/format.h"

enum { VALUES_MAX = 4096, OFFSETS = 1 << 16 };
/* The share of neighbours that must be equal, and the share of unequal ones that must differ by 2
 * or more. */
#define EQUAL_SHARE 0.85
#define JUMP_SHARE 0.3

static int ends_in(const char *path, const char *ending)
{
    const size_t size = strlen(path), most = strlen(ending);
    return size >= most && !strcmp(path + size - most, ending);
}

/* Pairs of neighbours along x. */
typedef struct pairs {
    size_t equal, apart, jumps;
} pairs;

/* Samples as doubles, `width` of them from `line` on. */
static void load_line(double *out, const cvol_volume *volume, size_t line, size_t width)
{
#define LOAD(t)                        \
    for (size_t i = 0; i < width; i++) \
    out[i] = (double)((const t *)volume->data)[line * width + i]
    CVOL_FOR_TYPE(volume->grid.type, LOAD);
#undef LOAD
}

/* The samples, read line by line along x. */
typedef struct lines {
    const cvol_volume *volume;
    double *line;
    size_t width, count;
} lines;

static void find_range(double *least, double *most, const lines *of)
{
    load_line(of->line, of->volume, 0, of->width);
    *least = *most = of->line[0];
    for (size_t l = 0; l < of->count && *most - *least < OFFSETS; l++) {
        load_line(of->line, of->volume, l, of->width);
        for (size_t i = 0; i < of->width; i++) {
            *least = of->line[i] < *least ? of->line[i] : *least;
            *most = of->line[i] > *most ? of->line[i] : *most;
        }
    }
}

/* The most frequent value, and its count; 0: more than VALUES_MAX values, or too far apart. */
static size_t find_commonest(double *commonest, const lines *of)
{
    double least, most;
    find_range(&least, &most, of);
    if (most - least >= OFFSETS)
        return 0;
    const size_t bins = (size_t)(most - least) + 1;
    size_t *counts = calloc(bins, sizeof *counts), best = 0, values = 0;
    for (size_t l = 0; l < of->count && counts; l++) {
        load_line(of->line, of->volume, l, of->width);
        for (size_t i = 0; i < of->width; i++)
            counts[(size_t)(of->line[i] - least)]++;
    }
    for (size_t i = 0; i < bins && counts; i++) {
        values += counts[i] > 0;
        best = counts[i] > counts[best] ? i : best;
    }
    *commonest = least + (double)best;
    const int found = counts != NULL && values <= VALUES_MAX;
    free(counts);
    return found ? values : 0;
}

static void add_pairs(pairs *out, const double *line, size_t width, double commonest)
{
    for (size_t i = 1; i < width; i++) {
        const double a = line[i - 1], b = line[i];
        if (!(a > commonest) && !(a < commonest) && !(b > commonest) && !(b < commonest))
            continue;
        const double apart = a < b ? b - a : a - b;
        out->equal += apart < 0.5;
        out->apart += apart >= 0.5;
        out->jumps += apart >= 1.5;
    }
}

static int look_like_labels(const cvol_volume *volume)
{
    const size_t width = volume->grid.dims[0];
    double commonest = 0;
    pairs of = {0};
    if (!cvol_type_is_integer(volume->grid.type) || width < 2)
        return 0;
    const lines all_lines = {volume, malloc(width * sizeof(double)), width,
                             cvol_grid_samples(&volume->grid) / width};
    const size_t values = all_lines.line ? find_commonest(&commonest, &all_lines) : 0;
    for (size_t l = 0; l < all_lines.count && values > 1; l++) {
        load_line(all_lines.line, volume, l, width);
        add_pairs(&of, all_lines.line, width, commonest);
    }
    free(all_lines.line);
    if (values < 2 || !of.equal)
        return 0;
    const double all = (double)of.equal + (double)of.apart;
    if ((double)of.equal < EQUAL_SHARE * all)
        return 0;
    return values <= 2 || (double)of.jumps >= JUMP_SHARE * (double)of.apart;
}

int cvol_volume_is_labels(const cvol_volume *volume, const char *path)
{
    if (path && cvol_type_is_integer(volume->grid.type) &&
        (ends_in(path, ".seg.nrrd") || cvol_nifti_has_label_intent(path) ||
         cvol_zarr_is_labels(path)))
        return 1;
    return look_like_labels(volume);
}
