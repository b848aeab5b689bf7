/* Dense volumes: making and freeing them. */
#include "cvol/volume.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/io/dense.h"

int cvol_dense_create(cvol_context *context, cvol_volume **out, const cvol_grid *grid, int zero)
{
    *out = NULL;
    size_t bytes = cvol_grid_bytes(grid);
    cvol_volume *volume = malloc(sizeof *volume);
    if (!volume)
        return cvol_fail_memory(context, sizeof *volume, "a volume");
    volume->grid = *grid;
    volume->data = zero ? cvol_allocate_zero(bytes, 1) : cvol_allocate(bytes, 1);
    if (!volume->data) {
        free(volume);
        return cvol_fail_memory(context, bytes, "the samples of a volume");
    }
    *out = volume;
    return CVOL_OK;
}

int cvol_dense_check(cvol_context *context, const cvol_volume *volume, const char *name)
{
    if (!volume || !volume->data)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: no samples", name);
    return cvol_grid_check(context, &volume->grid, name);
}

int cvol_volume_create(cvol_context *context, cvol_volume **out, const cvol_grid *grid)
{
    *out = NULL;
    int code = cvol_grid_check(context, grid, "volume");
    if (code)
        return code;
    return cvol_dense_create(context, out, grid, 1);
}

void cvol_volume_free(cvol_volume *volume)
{
    if (!volume)
        return;
    free(volume->data);
    free(volume);
}
