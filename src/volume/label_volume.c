/* Decides if a volume's samples are labels, by its file or by the samples themselves.
 *
 * Regions of one label are wide, so nearly all neighbours are equal; across the face of two regions
 * they differ by any amount. Scanned samples have noise, and computed ones change by small amounts.
 * Pairs of two background samples (the commonest value) do not count. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/doubles.h"
#include "cvol/codec.h"
#include "volume/formats/nifti_intent.h"
#include "volume/formats/vdb/labels.h"
#include "volume/formats/zarr/labels.h"
#include "volume/io/format.h"

enum { VALUES_MAX = 4096, OFFSETS = 1 << 16, PLACE_BITS = 14, PLACES = 1 << PLACE_BITS };
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

/* The samples, read line by line along x. */
typedef struct lines {
    const cvol_volume *volume;
    double *line;
    size_t width, count;
} lines;

static void load_line(const lines *of, size_t number)
{
    cvol_doubles_load(of->line, of->volume->grid.type, of->volume->data, number * of->width,
                      of->width);
}

static void find_range(double *least, double *most, const lines *of)
{
    load_line(of, 0);
    *least = *most = of->line[0];
    for (size_t l = 0; l < of->count && *most - *least < OFFSETS; l++) {
        load_line(of, l);
        for (size_t i = 0; i < of->width; i++) {
            *least = of->line[i] < *least ? of->line[i] : *least;
            *most = of->line[i] > *most ? of->line[i] : *most;
        }
    }
}

/* Numbers of samples by value, for any range: a hash table with open addressing. */
typedef struct counter {
    double values[PLACES];
    size_t counts[PLACES]; /* 0: a free place */
    size_t used;
} counter;

/* 0: more than VALUES_MAX values. */
static int count_value(counter *c, double value)
{
    size_t at = (size_t)((uint64_t)(int64_t)value * 0x9e3779b97f4a7c15 >> (64 - PLACE_BITS));
    while (c->counts[at] && (c->values[at] < value || c->values[at] > value))
        at = (at + 1) % PLACES;
    if (!c->counts[at] && ++c->used > VALUES_MAX)
        return 0;
    c->values[at] = value;
    c->counts[at]++;
    return 1;
}

static int find_commonest_far(cvol_context *context, size_t *found, double *commonest,
                              const lines *of)
{
    counter *c = calloc(1, sizeof *c);
    int few = 1;
    if (!c)
        return cvol_fail_memory(context, sizeof *c, "counts of values");
    for (size_t l = 0; l < of->count && few; l++) {
        load_line(of, l);
        for (size_t i = 0; i < of->width && few; i++)
            few = count_value(c, of->line[i]);
    }
    size_t best = 0;
    for (size_t i = 0; i < PLACES; i++)
        if (c->counts[i] > c->counts[best] ||
            (c->counts[i] == c->counts[best] && c->values[i] < c->values[best]))
            best = i;
    *commonest = c->values[best];
    *found = few ? c->used : 0;
    free(c);
    return CVOL_OK;
}

/* The most frequent value, and the number of values; 0: more than VALUES_MAX values. Labels of
 * atlases may be far apart. */
static int find_commonest(cvol_context *context, size_t *found, double *commonest, const lines *of)
{
    double least, most;
    *found = 0;
    find_range(&least, &most, of);
    if (most - least >= OFFSETS)
        return find_commonest_far(context, found, commonest, of);
    const size_t bins = (size_t)(most - least) + 1;
    size_t *counts = calloc(bins, sizeof *counts), best = 0, values = 0;
    if (!counts)
        return cvol_fail_memory(context, bins * sizeof *counts, "counts of values");
    for (size_t l = 0; l < of->count; l++) {
        load_line(of, l);
        for (size_t i = 0; i < of->width; i++)
            counts[(size_t)(of->line[i] - least)]++;
    }
    for (size_t i = 0; i < bins; i++) {
        values += counts[i] > 0;
        best = counts[i] > counts[best] ? i : best;
    }
    *commonest = least + (double)best;
    *found = values <= VALUES_MAX ? values : 0;
    free(counts);
    return CVOL_OK;
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

static int look_like_labels(cvol_context *context, int *out, const cvol_volume *volume)
{
    const size_t width = volume->grid.dims[0];
    double commonest = 0;
    size_t values;
    pairs of = {0};
    *out = 0;
    if (!cvol_type_is_integer(volume->grid.type) || width < 2)
        return CVOL_OK;
    const lines all_lines = {volume, malloc(width * sizeof(double)), width,
                             cvol_grid_samples(&volume->grid) / width};
    if (!all_lines.line)
        return cvol_fail_memory(context, width * sizeof(double), "a line of samples");
    const int code = find_commonest(context, &values, &commonest, &all_lines);
    for (size_t l = 0; l < all_lines.count && !code && values > 1; l++) {
        load_line(&all_lines, l);
        add_pairs(&of, all_lines.line, width, commonest);
    }
    free(all_lines.line);
    const double all = (double)of.equal + (double)of.apart;
    *out = !code && values > 1 && of.equal && (double)of.equal >= EQUAL_SHARE * all &&
           (values <= 2 || (double)of.jumps >= JUMP_SHARE * (double)of.apart);
    return code;
}

int cvol_volume_compute_is_labels(cvol_context *context, int *out, const cvol_volume *volume,
                                  const char *path)
{
    int code = CVOL_OK;
    *out = 0;
    if (path && cvol_type_is_integer(volume->grid.type)) {
        if (ends_in(path, ".seg.nrrd"))
            *out = 1;
        else
            code = cvol_zarr_find_label_mark(context, out, path);
        if (!code && !*out)
            code = cvol_nifti_find_label_intent(context, out, path);
        if (!code && !*out)
            code = cvol_vdb_find_label_mark(context, out, volume->grid.type, path);
    }
    return code || *out ? code : look_like_labels(context, out, volume);
}

int cvol_volume_is_labels(const cvol_volume *volume, const char *path)
{
    cvol_context context = {.limit_bytes = UINT64_MAX}; /* for discarded messages */
    int is;
    return !cvol_volume_compute_is_labels(&context, &is, volume, path) && is;
}
