/* Block ranges where they are needed: files and the renderer want them, operations do not find
 * them, as that means evaluating every block. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/array.h"
#include "base/context.h"
#include "base/memory.h"

int cvol_array_know_ranges(cvol_context *context, cvol_array *array)
{
    int code = cvol_array_find_ranges(context, array);
    if (code)
        return code;
    const double largest = fmax(fabs(array->range_min), fabs(array->range_max));
    array->ledger.max_abs = fmin(array->ledger.max_abs, largest * (1 + CVOL_ROUNDING));
    array->has_ranges = 1;
    return CVOL_OK;
}

int cvol_array_share(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    const size_t bytes = array->block_count * sizeof *array->block_table;
    *out = malloc(sizeof **out);
    cvol_block *table = cvol_allocate(array->block_count, sizeof *table);
    if (!*out || !table) {
        free(*out);
        free(table);
        *out = NULL;
        return cvol_fail_memory(context, bytes, "the block table");
    }
    **out = *array;
    memcpy(table, array->block_table, bytes);
    (*out)->block_table = table;
    (*out)->pools = NULL;
    (*out)->pool_count = (*out)->pool_capacity = 0;
    return CVOL_OK;
}
