/* Transfer functions for computed tomography, in Hounsfield units (air -1000, water 0), and a test
 * if a volume's values are such units.
 *
 * Soft tissue lies between -100 and 100, lungs about -900 to -500, contrast agent in vessels 150 to
 * 450, spongy bone from 200, compact bone from 700 on. Opacities are for a sample spacing of about
 * a millimetre. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "cvol/transfer.h"

#define POINTS_MAX 9
#define OUTSIDE_MAX 0.05 /* of the samples: values outside of any body */

static const struct preset {
    const char *name;
    int count;
    cvol_transfer_point points[POINTS_MAX];
} presets[] = {
    /* A veil where air meets skin, and bone. */
    {"ct-body",
     9,
     {{-500, 0.80, 0.56, 0.46, 0},
      {-300, 0.86, 0.62, 0.52, 0.03},
      {-150, 0.90, 0.66, 0.56, 0.012},
      {20, 0.80, 0.42, 0.34, 0.006},
      {120, 0.78, 0.36, 0.28, 0.012},
      {220, 0.92, 0.76, 0.58, 0.1},
      {400, 0.97, 0.90, 0.76, 0.3},
      {1000, 1.00, 0.97, 0.90, 0.55},
      {3000, 1.00, 1.00, 0.98, 0.6}}},
    {"ct-bone",
     5,
     {{180, 0.45, 0.30, 0.18, 0},
      {320, 0.72, 0.55, 0.38, 0.06},
      {600, 0.93, 0.84, 0.70, 0.25},
      {1200, 1.00, 0.98, 0.93, 0.5},
      {2500, 1.00, 1.00, 1.00, 0.6}}},
    {"ct-skin",
     6,
     {{-500, 0.35, 0.20, 0.15, 0},
      {-350, 0.55, 0.34, 0.27, 0.015},
      {-200, 0.78, 0.55, 0.44, 0.06},
      {0, 0.95, 0.76, 0.64, 0.12},
      {200, 1.00, 0.88, 0.78, 0.15},
      {1000, 1.00, 0.97, 0.90, 0.4}}},
    {"ct-lung",
     7,
     {{-930, 0.20, 0.24, 0.38, 0},
      {-840, 0.35, 0.42, 0.62, 0.012},
      {-650, 0.78, 0.62, 0.66, 0.03},
      {-480, 0.92, 0.72, 0.66, 0.02},
      {-300, 0.95, 0.78, 0.70, 0},
      {180, 0.95, 0.86, 0.72, 0},
      {700, 1.00, 0.96, 0.88, 0.03}}},
    {"ct-vessels",
     6,
     {{120, 0.45, 0.04, 0.03, 0},
      {180, 0.70, 0.10, 0.07, 0.06},
      {280, 0.88, 0.20, 0.14, 0.3},
      {420, 0.93, 0.52, 0.36, 0.3},
      {650, 0.95, 0.86, 0.70, 0.3},
      {1500, 1.00, 0.98, 0.93, 0.5}}},
};

#define PRESETS (sizeof presets / sizeof *presets)

const char *cvol_transfer_ct_names(void)
{
    return "ct-body ct-bone ct-skin ct-lung ct-vessels";
}

static const struct preset *find(const char *name)
{
    for (size_t i = 0; i < PRESETS; i++)
        if (!strcmp(name, presets[i].name))
            return &presets[i];
    return NULL;
}

int cvol_transfer_is_ct(const char *name)
{
    return find(name) != NULL;
}

int cvol_transfer_create_ct(cvol_context *context, cvol_transfer **out, const char *name,
                            const double rescale[2])
{
    *out = NULL;
    const struct preset *preset = find(name);
    if (!preset)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "no transfer function of Hounsfield units is named %s; there are: %s",
                         name, cvol_transfer_ct_names());
    if (!isfinite(rescale[0]) || !isfinite(rescale[1]) || !(fabs(rescale[0]) > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "rescaling by %g and %g: must be finite, the first not 0", rescale[0],
                         rescale[1]);
    cvol_transfer_point points[POINTS_MAX];
    for (int i = 0; i < preset->count; i++) {
        points[i] = preset->points[i];
        points[i].value = (points[i].value - rescale[1]) / rescale[0];
    }
    return cvol_transfer_create(context, out, points, (size_t)preset->count);
}

/* ---- recognition ------------------------------------------------------------------------ */

/* The share of the samples with a value within from .. to. */
static double share_within(const cvol_histogram *histogram, const double rescale[2], double from,
                           double to)
{
    const double width = (histogram->max - histogram->min) / CVOL_HISTOGRAM_BINS;
    double inside = 0, all = 0;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++) {
        const double value = rescale[0] * (histogram->min + (i + 0.5) * width) + rescale[1];
        all += (double)histogram->bins[i];
        if (value >= from && value <= to)
            inside += (double)histogram->bins[i];
    }
    return all > 0 ? inside / all : 0;
}

/* The values reach from air to bone or at least to soft tissue, no further than scanners do, and
 * there is some soft tissue. Few values lie beyond bone, and below air only padding, which is one
 * value. */
static int looks_like(const cvol_histogram *histogram, const double rescale[2])
{
    const double a = rescale[0] * histogram->min + rescale[1];
    const double b = rescale[0] * histogram->max + rescale[1];
    const double least = fmin(a, b), most = fmax(a, b);
    const double padding = (most - least) / CVOL_HISTOGRAM_BINS;
    return least <= -900 && least >= -32768 && most >= 150 && most <= 32767 &&
           share_within(histogram, rescale, -200, 300) >= 0.02 &&
           share_within(histogram, rescale, least + padding, -1200) < OUTSIDE_MAX &&
           share_within(histogram, rescale, 4000, INFINITY) < OUTSIDE_MAX;
}

/* Tests if values without a unit in their file are Hounsfield units plus 1024: many integers, a
 * large part air; among the rest soft tissue is common, and values between it and air are rare.
 * Labels and most other integers differ from this. */
static int looks_shifted(const cvol_histogram *histogram, const double shifted[2],
                         const cvol_grid *grid)
{
    const double matter = share_within(histogram, shifted, -850, INFINITY);
    const double soft = share_within(histogram, shifted, -200, 300);
    return (histogram->integers || cvol_type_is_integer(grid->type)) && !histogram->distinct &&
           looks_like(histogram, shifted) &&
           share_within(histogram, shifted, -1100, -900) >= 0.02 && soft >= 0.25 * matter &&
           share_within(histogram, shifted, -700, -300) <= 0.5 * soft;
}

cvol_hounsfield cvol_hounsfield_guess(double rescale[2], const cvol_histogram *histogram,
                                      const cvol_grid *grid)
{
    rescale[0] = grid->value_scale;
    rescale[1] = grid->value_offset;
    if (looks_like(histogram, rescale))
        return CVOL_HOUNSFIELD_YES;
    const double shifted[2] = {rescale[0], rescale[1] - 1024};
    if (!looks_shifted(histogram, shifted, grid))
        return CVOL_HOUNSFIELD_NO;
    rescale[1] -= 1024;
    return CVOL_HOUNSFIELD_SHIFTED;
}
