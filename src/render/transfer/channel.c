/* Transfer functions of channels, whose pictures are added like the light of dyes.
 *
 * A dye has one colour, whose brightness is that of another transfer function. The components of an
 * RGB file share one range of values. The opacity of a component rises from 0 at CLEAR_PART of the
 * range to COMPONENT_OPACITY at OPAQUE_PART and stays there. So dark and bright components are
 * visible at about the same depth, and a pixel has the colour of the samples. At a hard edge,
 * interpolated values take all levels from black to those of the object: with a short rise the
 * surface lay near the outer samples and showed their steps. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/transfer/transfer.h"

#define CLEAR_PART 0.02
#define OPAQUE_PART 0.2
#define COMPONENT_OPACITY 0.2
/* A background ends at most here. */
#define BACKGROUND_MOST 0.5

int cvol_transfer_create_tinted(cvol_context *context, cvol_transfer **out,
                                const cvol_transfer *from, const double rgb[3])
{
    cvol_transfer_point *points = cvol_allocate(from->count, sizeof *points);
    *out = NULL;
    if (!points)
        return cvol_fail_memory(context, from->count * sizeof *points, "a transfer function");
    for (size_t i = 0; i < from->count; i++) {
        points[i] = from->points[i];
        const double light = fmax(points[i].r, fmax(points[i].g, points[i].b));
        points[i].r = light * rgb[0];
        points[i].g = light * rgb[1];
        points[i].b = light * rgb[2];
    }
    const int code = cvol_transfer_create(context, out, points, from->count);
    free(points);
    return code;
}

void cvol_component_get_range(double range[2], cvol_type type)
{
    range[0] = 0;
    switch (type) {
    case CVOL_UINT8:
        range[1] = UINT8_MAX;
        break;
    case CVOL_INT8:
        range[1] = INT8_MAX;
        break;
    case CVOL_UINT16:
        range[1] = UINT16_MAX;
        break;
    case CVOL_INT16:
        range[1] = INT16_MAX;
        break;
    case CVOL_UINT32:
        range[1] = UINT32_MAX;
        break;
    case CVOL_INT32:
        range[1] = INT32_MAX;
        break;
    default:
        range[1] = 1;
    }
}

/* The part of the range where the background of a component ends: a dark one, as around a
 * photographed section, is left out. */
static double clear_part(cvol_context *context, const cvol_histogram *histogram,
                         const double range[2])
{
    cvol_transfer *fitted = NULL;
    double part = CLEAR_PART;
    if (!histogram || cvol_transfer_create_named(context, &fitted, "auto", histogram))
        return part;
    for (size_t i = 1; i < fitted->count; i++) {
        if (!(fitted->points[i].opacity > 0) || fitted->points[0].opacity > 0)
            continue;
        const double edge = fitted->points[i - 1].value;
        part = fmax(part, fmin((edge - range[0]) / (range[1] - range[0]), BACKGROUND_MOST));
        break;
    }
    cvol_transfer_free(fitted);
    return part;
}

int cvol_transfer_create_component(cvol_context *context, cvol_transfer **out,
                                   const cvol_histogram *histogram, const double range[2],
                                   const double rgb[3])
{
    const double clear = clear_part(context, histogram, range),
                 parts[] = {0, clear, clear + OPAQUE_PART - CLEAR_PART, 1};
    cvol_transfer_point points[4];
    for (int i = 0; i < 4; i++)
        points[i] = (cvol_transfer_point){.value = range[0] + parts[i] * (range[1] - range[0]),
                                          .r = parts[i] * rgb[0],
                                          .g = parts[i] * rgb[1],
                                          .b = parts[i] * rgb[2],
                                          .opacity = i < 2 ? 0 : COMPONENT_OPACITY};
    return cvol_transfer_create(context, out, points, 4);
}
