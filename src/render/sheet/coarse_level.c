/* Low-resolution volumes from levels (coarse_level.h). */
#include "render/sheet/coarse_level.h"

#include <string.h>

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"

static int copy_level(cvol_context *context, cvol_coarse *out, const cvol_grid *grid,
                      const cvol_sheet_level *level, int number)
{
    const size_t side = CVOL_LEVEL_BLOCK, *blocks = level->shape->blocks;
    const int code = cvol_coarse_allocate(context, out, grid, number, level->cover != NULL);
    if (code)
        return code;
    const size_t *n = out->dims;
    const float offset = (float)level->shape->offset;
    for (size_t i = 0; i < n[1] * n[2]; i++) {
        const size_t y = i % n[1], z = i / n[1], row = side * (y % side + side * (z % side)),
                     line = blocks[0] * (y / side + blocks[1] * (z / side));
        for (size_t x = 0; x < n[0]; x += side) {
            const size_t from = (line + x / side) * CVOL_LEVEL_BLOCK_SAMPLES + row,
                         count = n[0] - x < side ? n[0] - x : side;
            for (size_t k = 0; k < count; k++)
                out->values[n[0] * i + x + k] = level->samples[from + k] + offset;
            if (out->cover)
                memcpy(out->cover + n[0] * i + x, level->cover + from, count * sizeof *out->cover);
        }
    }
    return CVOL_OK;
}

int cvol_coarse_of_array(cvol_context *context, cvol_coarse *out, const cvol_array *array)
{
    const int number = cvol_coarse_level(cvol_array_grid(array));
    const cvol_array *decoded = array;
    cvol_sheet_level level = {.samples = NULL};
    int code = cvol_array_need_volume(context, array, "a view of its visible part");
    if (!code)
        code = cvol_array_decoded_terms(context, &decoded, array);
    if (!code)
        code = cvol_sheet_level_make_means(context, &level, decoded, number);
    if (!code)
        code = copy_level(context, out, cvol_array_grid(array), &level, number);
    cvol_sheet_level_free(&level);
    return code;
}
