/* Sources of the sheet engine: made at their first use, and kept. */
#include "render/sheet/source.h"

/* The volume itself: with ranges of its blocks, and their masks. */
static int make_whole(cvol_context *context, cvol_sheet_source *out, const cvol_array *array)
{
    int code = array->mask ? cvol_sheet_mask_make(context, &out->mask, array) : CVOL_OK;
    out->array = array;
    if (code || array->has_ranges)
        return code;
    code = cvol_array_share(context, &out->ranged, array);
    if (!code) {
        out->ranged->mask = array->mask; /* borrowed, for the bounds */
        code = cvol_array_ensure_ranges(context, out->ranged);
        out->ranged->mask = NULL;
    }
    out->array = out->ranged;
    return code;
}

int cvol_sheet_source_make(cvol_context *context, cvol_sheet_source *out, const cvol_array *array,
                           int level)
{
    *out = (cvol_sheet_source){0};
    int code;
    if (level) {
        code = cvol_sheet_level_make(context, &out->level, array, level);
        out->array = out->level.shape;
    } else {
        code = make_whole(context, out, array);
    }
    if (code)
        cvol_sheet_source_free(out);
    else
        cvol_visibility_make(&out->everything, out->array, NULL);
    return code;
}

void cvol_sheet_source_find_visible(cvol_sheet_source *source, const cvol_transfer *transfer)
{
    if (source->array)
        cvol_visibility_make(&source->by_transfer, source->array, transfer);
}

int cvol_sheet_source_widen(cvol_context *context, cvol_sheet_source *source, const double range[2],
                            const cvol_transfer *transfer)
{
    if (range[0] >= source->array->range_min && range[1] <= source->array->range_max)
        return CVOL_OK;
    cvol_array *own = source->level.samples ? source->level.shape : source->ranged;
    if (!own) {
        const int code = cvol_array_share(context, &source->ranged, source->array);
        if (code)
            return code;
        source->array = own = source->ranged;
    }
    cvol_array_widen_range(own, range[0], range[1]);
    cvol_visibility_make(&source->everything, source->array, NULL);
    if (transfer)
        cvol_sheet_source_find_visible(source, transfer);
    return CVOL_OK;
}

void cvol_sheet_source_free(cvol_sheet_source *source)
{
    cvol_array_free(source->ranged);
    cvol_sheet_mask_free(&source->mask);
    cvol_sheet_level_free(&source->level);
    *source = (cvol_sheet_source){0};
}

const cvol_sheet_mask *cvol_sheet_source_mask(const cvol_sheet_source *source)
{
    return source->mask.states         ? &source->mask
           : source->level.mask.states ? &source->level.mask
                                       : NULL;
}

cvol_sheet_masked cvol_sheet_source_masked(const cvol_sheet_source *source, const cvol_mask *mask)
{
    if (cvol_mask_is_void(mask))
        return CVOL_SHEET_SOME_VOID;
    /* A level's samples already include it. */
    return cvol_mask_is_background(mask) && !source->level.samples ? CVOL_SHEET_SOME_BACKGROUND
                                                                   : CVOL_SHEET_ALL_PLAIN;
}
