/* The source of splats, for every engine that uses them. */
#include "base/context.h"
#include "base/memory.h"
#include "render/splat/frame.h"

int cvol_splat_input_make(cvol_context *context, cvol_splat_input *out, const cvol_array *array,
                          const cvol_volume *volume)
{
    *out = (cvol_splat_input){.source = {.array = array, .volume = volume}};
    if (array) {
        out->grid = *cvol_array_grid(array);
        out->source.min = array->error_bound.value_min;
        out->source.max = array->error_bound.value_max;
        out->source.offset = array->offset;
    } else {
        cvol_volume_statistics stats = {0};
        int code = cvol_grid_check(context, &volume->grid, "volume");
        if (!code)
            code = cvol_volume_compute_statistics(context, &stats, volume);
        if (code)
            return code;
        out->grid = volume->grid;
        out->source.min = stats.min;
        out->source.max = stats.max;
        out->source.offset = stats.min;
    }
    out->table = cvol_allocate(1, sizeof *out->table);
    return out->table ? CVOL_OK
                      : cvol_fail_memory(context, sizeof *out->table, "a table of samples");
}

void cvol_splat_input_free(cvol_splat_input *input)
{
    cvol_transfer_free(input->transfer);
    free(input->table);
    *input = (cvol_splat_input){0};
}

int cvol_splat_input_set_transfer(cvol_context *context, cvol_splat_input *input,
                                  const cvol_transfer *transfer)
{
    cvol_transfer *copy;
    const int code = cvol_transfer_copy(context, &copy, transfer);
    if (code)
        return code;
    cvol_transfer_free(input->transfer);
    input->transfer = copy;
    return CVOL_OK;
}

void cvol_splat_input_tabulate(cvol_splat_input *input, double distance, double share)
{
    cvol_splat_table_fill(input->table, input->transfer, &input->source, input->grid.type, distance,
                          share);
}
