/* Makes masks of samples in memory. */
#include "codec/mask/mask_make.h"

#include <stdlib.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "codec/mask/mask_fill.h"

/* Sets the mask slab by slab; *otherwise becomes a value of an unmasked sample. */
static int set_mask(cvol_context *context, cvol_mask *mask, const void *samples,
                    const cvol_grid *grid, double *otherwise, size_t *masked)
{
    const size_t *dims = grid->dims, slice = dims[0] * dims[1];
    const size_t size = cvol_type_size(grid->type);
    uint8_t *which = cvol_allocate(slice, CVOL_MASK_CELL);
    int code = which ? CVOL_OK : cvol_fail_memory(context, slice * CVOL_MASK_CELL, "a mask");
    int found = 0;
    *otherwise = 0;
    *masked = 0;
    for (size_t z = 0; z < dims[2] && !code; z += CVOL_MASK_CELL) {
        const size_t begin[3] = {0, 0, z};
        const size_t end[3] = {dims[0], dims[1],
                               dims[2] - z < CVOL_MASK_CELL ? dims[2] : z + CVOL_MASK_CELL};
        const size_t count = slice * (end[2] - z);
        const uint8_t *from = (const uint8_t *)samples + size * slice * z;
        *masked += cvol_fills_match(which, cvol_mask_fills(mask), grid->type, from, count);
        if (!cvol_mask_set(mask, which, begin, end))
            code = cvol_fail_memory(context, count, "a mask");
        for (size_t i = 0; i < count && !found; i++)
            if (!which[i]) {
                float value;
                cvol_samples_load(&value, from, grid->type, i, 1, 0);
                *otherwise = (double)value;
                found = 1;
            }
    }
    free(which);
    return code;
}

int cvol_mask_make(cvol_context *context, cvol_mask **mask, void **filled, const void *samples,
                   const cvol_grid *grid, const cvol_fills *fills)
{
    double otherwise;
    size_t masked = 0;
    *filled = NULL;
    int code = cvol_mask_create(context, mask, grid->dims, fills);
    if (!code)
        code = set_mask(context, *mask, samples, grid, &otherwise, &masked);
    if (!code && masked && !(*filled = cvol_allocate(cvol_grid_bytes(grid), 1)))
        code = cvol_fail_memory(context, cvol_grid_bytes(grid), "the filled samples");
    if (!code && masked)
        code = cvol_mask_fill(context, *filled, samples, grid, *mask, 0, grid->dims[2],
                              fills->background ? cvol_fills_value(fills, 0, grid->type)
                                                : otherwise);
    if (code || !masked) {
        cvol_mask_free(*mask);
        free(*filled);
        *mask = NULL;
        *filled = NULL;
    }
    return code;
}
