/* Colours of labels (labels.h).
 *
 * Engines interpolate samples, so between two regions values pass through the labels in between.
 * These have colours only near their own value: such a passage is thin, and hardly visible. */
#include "render/look/labels.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "cvol/look.h"

#define LABELS_MAX 32
#define OPACITY 0.5
/* Values this near to a label have its colour. */
#define REACH 0.04
/* Hue, saturation and brightness of label n are the fractions of n times three steps: any few
 * labels are far apart in at least one, also those that differ by a constant such as 100. The hue's
 * step is the golden ratio; the others are powers of 1/g with g^4 = g + 1 (Roberts, The
 * Unreasonable Effectiveness of Quasirandom Sequences, 2018). */
#define HUE_STEP 0.6180339887498949
#define SATURATION_STEP 0.6710436067037893
#define BRIGHTNESS_STEP 0.5497004779019703
#define HUE_START 0.08
#define SATURATION_LEAST 0.35
#define SATURATION_MOST 0.8
#define BRIGHTNESS_LEAST 0.68
#define BRIGHTNESS_MOST 1.0
/* Of a mask's only label. */
#define MASK_SATURATION 0.2
#define MASK_BRIGHTNESS 0.9

int cvol_labels_are_few(const cvol_histogram *histogram)
{
    return histogram->integers && histogram->distinct > 1 && histogram->distinct <= LABELS_MAX;
}

/* A colour of this hue, saturation and brightness, each 0 to 1. */
static void set_hue(double rgb[3], double hue, double saturation, double brightness)
{
    for (int c = 0; c < 3; c++) {
        const double part = hue + (3 - c) / 3.0, place = 6 * (part - floor(part));
        const double full = fmin(fmax(fabs(place - 3) - 1, 0), 1);
        rgb[c] = brightness * (1 - saturation + saturation * full);
    }
}

void cvol_label_get_colour(double rgb[3], double label)
{
    const double turn = HUE_START + HUE_STEP * label, second = 0.5 + SATURATION_STEP * label,
                 third = 0.5 + BRIGHTNESS_STEP * label;
    set_hue(rgb, turn - floor(turn),
            SATURATION_LEAST + (SATURATION_MOST - SATURATION_LEAST) * (second - floor(second)),
            BRIGHTNESS_LEAST + (BRIGHTNESS_MOST - BRIGHTNESS_LEAST) * (third - floor(third)));
}

/* The four points of a label: jumps at both ends. */
static size_t add_label(cvol_transfer_point *points, double value, double reach, int only)
{
    double rgb[3];
    if (only)
        set_hue(rgb, HUE_START, MASK_SATURATION, MASK_BRIGHTNESS);
    else
        cvol_label_get_colour(rgb, value);
    for (int k = 0; k < 4; k++)
        points[k] = (cvol_transfer_point){value + (k < 2 ? -reach : reach), rgb[0], rgb[1], rgb[2],
                                          k == 1 || k == 2 ? OPACITY : 0};
    return 4;
}

/* A mask: two values, of which 0 is the background, or else the more frequent one. Nothing lies
 * between them, so the label ends half way. */
static int create_mask(cvol_context *context, cvol_transfer **out, const cvol_histogram *histogram)
{
    const double min = histogram->min, max = histogram->max;
    uint64_t halves[2] = {0, 0};
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        halves[i >= CVOL_HISTOGRAM_BINS / 2] += histogram->bins[i];
    const int is_dark = fabs(min) < 1e-9 || (!(fabs(max) < 1e-9) && halves[0] >= halves[1]);
    cvol_transfer_point points[5] = {{.value = min - (max - min)}};
    add_label(points + 1, is_dark ? max : min, 0.5 * (max - min), 1);
    return cvol_transfer_create(context, out, points, 5);
}

int cvol_labels_create_transfer(cvol_context *context, cvol_transfer **out,
                                const cvol_histogram *histogram)
{
    if (histogram->distinct == 2)
        return create_mask(context, out, histogram);
    const double width = (histogram->max - histogram->min) / CVOL_HISTOGRAM_BINS;
    double values[LABELS_MAX + 1];
    int count = 0, background = 0, has_zero = 0;
    uint64_t most = 0;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS && count <= LABELS_MAX; i++) {
        if (!histogram->bins[i])
            continue;
        const double middle = histogram->min + (i + 0.5) * width;
        /* Bins below one unit have one integer; wider ones have several. */
        values[count] = i == CVOL_HISTOGRAM_BINS - 1 ? histogram->max
                        : width < 1                  ? ceil(middle - 0.5 * width - 1e-9)
                                                     : middle;
        const int is_zero = fabs(values[count]) <= fmax(0.5 * width, 1e-9);
        if (is_zero || (!has_zero && histogram->bins[i] > most)) {
            background = count;
            most = histogram->bins[i];
        }
        has_zero |= is_zero;
        count++;
    }
    cvol_transfer_point *points = cvol_allocate(4 * (size_t)count + 1, sizeof *points);
    if (!points)
        return cvol_fail_memory(context, (4 * (size_t)count + 1) * sizeof *points, "labels");
    size_t used = 0;
    points[used++] = (cvol_transfer_point){.value = histogram->min - 1};
    for (int k = 0; k < count; k++)
        if (k != background)
            used += add_label(points + used, values[k], fmax(REACH, width / 2), 0);
    const int code = cvol_transfer_create(context, out, points, used);
    free(points);
    return code;
}
