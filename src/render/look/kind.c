/* Colours by the kind of data (cvol_transfer_create_auto). */
#include <string.h>

#include "cvol/look.h"
#include "render/look/labels.h"
#include "render/transfer/fit.h"

/* The transfer function of each kind, and the factor of its density: lit surfaces are read more
 * easily than lit haze. */
static const struct kind {
    const char *text, *transfer;
    double density;
} kinds[] = {
    [CVOL_KIND_GENERAL] = {"no known kind of data: dark to bright", "auto", 1},
    [CVOL_KIND_CT] = {"CT in Hounsfield units: skin and bone", "ct-body", 1},
    [CVOL_KIND_MEDICAL] = {"medical, no Hounsfield units: MRI", "mri", 1},
    [CVOL_KIND_MICROSCOPY] = {"microscopy, by its unit of length", "microscopy", 1.5},
    [CVOL_KIND_FIELD] = {"a field of real numbers: low to high", "field", 2},
    [CVOL_KIND_SIGNED] = {"values on both sides of zero: cool and warm", "cool-warm", 2},
    [CVOL_KIND_DENSE] = {"no empty space: grey levels", "dense", 1},
    [CVOL_KIND_LABELS] = {"labels: a colour for each", NULL, 1},
};

const char *cvol_kind_text(cvol_kind kind)
{
    const int i = (int)kind, count = sizeof kinds / sizeof *kinds;
    return i >= 0 && i < count ? kinds[i].text : "not a kind of data";
}

static int is_float(const cvol_grid *grid)
{
    return grid->type == CVOL_FLOAT32 || grid->type == CVOL_FLOAT64;
}

static int is_microscopic(const char *unit)
{
    static const char *const units[] = {"um", "\xc2\xb5m", "\xce\xbcm", "micron", "nm"};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (!strcmp(unit, units[i]))
            return 1;
    return 0;
}

/* Returns 1 if the median lies in the middle of the values: matter everywhere, not bright matter in
 * dim surroundings. */
static int is_symmetric(const cvol_histogram *histogram, double median)
{
    double window[2];
    cvol_histogram_get_window(window, histogram);
    const double place = (median - window[0]) / (window[1] - window[0]);
    return window[1] > window[0] && place > 0.25 && place < 0.75;
}

static cvol_kind find_kind(double rescale[2], const cvol_histogram *histogram,
                           const cvol_grid *grid, int exact)
{
    if (cvol_hounsfield_guess(rescale, histogram, grid) != CVOL_HOUNSFIELD_NO)
        return CVOL_KIND_CT;
    rescale[0] = grid->value_scale;
    rescale[1] = grid->value_offset;
    if (exact && cvol_labels_are_few(histogram))
        return CVOL_KIND_LABELS;
    const cvol_fit fit = cvol_fit_make(histogram);
    if (fit.above && fit.below)
        return CVOL_KIND_SIGNED;
    if (!fit.has_background && fit.share > 0 && is_symmetric(histogram, fit.edge_above))
        return CVOL_KIND_DENSE;
    if (grid->space != CVOL_SPACE_UNKNOWN)
        return CVOL_KIND_MEDICAL;
    if (is_microscopic(grid->unit))
        return CVOL_KIND_MICROSCOPY;
    return is_float(grid) ? CVOL_KIND_FIELD : CVOL_KIND_GENERAL;
}

int cvol_transfer_create_auto(cvol_context *context, cvol_transfer **out, cvol_kind *kind,
                              double rescale[2], const cvol_histogram *histogram,
                              const cvol_grid *grid, int exact)
{
    double means[2];
    cvol_transfer *plain = NULL;
    const cvol_kind found = find_kind(means, histogram, grid, exact);
    const struct kind *of = &kinds[found];
    *out = NULL;
    int code = found == CVOL_KIND_CT ? cvol_transfer_create_ct(context, &plain, of->transfer, means)
               : found == CVOL_KIND_LABELS
                   ? cvol_labels_create_transfer(context, &plain, histogram)
                   : cvol_transfer_create_named(context, &plain, of->transfer, histogram);
    if (!code)
        code = cvol_transfer_create_adjusted(context, out, plain, NULL, of->density);
    cvol_transfer_free(plain);
    if (kind)
        *kind = found;
    if (rescale)
        memcpy(rescale, means, sizeof means);
    return code;
}
