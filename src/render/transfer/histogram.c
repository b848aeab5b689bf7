/* Histograms of arrays and of volumes, both from a summary of the samples (array/core/summary.h).
 *
 * A summary may have fewer bins than a histogram. Each of its counts is then the count of every
 * histogram bin within its interval: fits to a histogram only use shares.
 *
 * Mean length of chords of a convex body: 4 V / S (Cauchy). */
#include <math.h>

#include "array/core/array.h"
#include "array/core/summary.h"
#include "base/context.h"
#include "cvol/transfer.h"

static double chord_of(const cvol_grid *grid)
{
    double inverse = 0, mean = 0;
    for (int a = 0; a < 3; a++) {
        inverse += 1 / ((double)grid->dims[a] * grid->spacing[a]);
        mean += grid->spacing[a] / 3;
    }
    return 2 / inverse / mean;
}

static void expand(cvol_histogram *out, const cvol_summary *summary, const cvol_grid *grid)
{
    const int each = CVOL_HISTOGRAM_BINS >> summary->bins_log2;
    *out = (cvol_histogram){.min = summary->min,
                            .max = summary->max,
                            .chord = chord_of(grid),
                            .mark = summary->mark,
                            .mark_count = summary->mark_count,
                            .integers = summary->integers,
                            .distinct = (int)summary->distinct};
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        out->bins[i] = cvol_summary_count(summary->levels[i / each]);
}

int cvol_array_compute_histogram(cvol_context *context, cvol_histogram *out,
                                 const cvol_array *array)
{
    cvol_summary summary;
    int code = cvol_array_need_volume(context, array, "a histogram");
    if (!code)
        code = cvol_summarise_array(context, &summary, array);
    if (!code)
        expand(out, &summary, &array->grid);
    return code;
}

int cvol_volume_compute_histogram(cvol_context *context, cvol_histogram *out,
                                  const cvol_volume *volume)
{
    cvol_summary summary;
    *out = (cvol_histogram){0};
    int code = cvol_grid_check(context, &volume->grid, "volume");
    if (!code)
        code = cvol_summarise_samples(context, &summary, volume->data, &volume->grid, NULL);
    if (!code)
        expand(out, &summary, &volume->grid);
    return code;
}

/* Adds the counts of `of` to the bins of a wider range. */
static void add_counts(cvol_histogram *sum, const cvol_histogram *of)
{
    const double width = (sum->max - sum->min) / CVOL_HISTOGRAM_BINS;
    const double step = (of->max - of->min) / CVOL_HISTOGRAM_BINS;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++) {
        const double place = width > 0 ? (of->min + (i + 0.5) * step - sum->min) / width : 0;
        const int bin = (int)fmin(fmax(place, 0), CVOL_HISTOGRAM_BINS - 1);
        sum->bins[bin] += of->bins[i];
    }
}

void cvol_histogram_join(cvol_histogram *out, const cvol_histogram *histograms, size_t count)
{
    *out = (cvol_histogram){0};
    for (size_t k = 0; k < count; k++) {
        out->min = k ? fmin(out->min, histograms[k].min) : histograms[k].min;
        out->max = k ? fmax(out->max, histograms[k].max) : histograms[k].max;
        out->integers = histograms[k].integers && (k == 0 || out->integers);
        out->distinct = k == 0 ? histograms[k].distinct
                        : histograms[k].distinct > 0 && out->distinct > 0
                            ? (int)fmax(out->distinct, histograms[k].distinct)
                            : 0;
    }
    for (size_t k = 0; k < count; k++)
        add_counts(out, &histograms[k]);
}

void cvol_histogram_get_window(double window[2], const cvol_histogram *histogram)
{
    const double bin = (histogram->max - histogram->min) / CVOL_HISTOGRAM_BINS;
    double total = 0, sum = 0;
    int first = -1, last = CVOL_HISTOGRAM_BINS - 1;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        total += (double)histogram->bins[i];
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++) {
        sum += (double)histogram->bins[i];
        if (first < 0 && sum > 0.001 * total)
            first = i;
        if (sum >= 0.999 * total) {
            last = i;
            break;
        }
    }
    window[0] = window[1] = 0;
    if (!(bin > 0) || first < 0)
        return;
    window[0] = histogram->min + first * bin;
    window[1] = histogram->min + (last + 1) * bin;
}
