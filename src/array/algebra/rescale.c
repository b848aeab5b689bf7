/* What the samples of results mean: operations.h. */
#include "array/algebra/operations.h"

void cvol_rescale_set(cvol_array *out, double scale, double offset)
{
    out->grid.value_scale = scale;
    out->grid.value_offset = offset;
}

int cvol_rescale_is_same(const cvol_array *a, const cvol_array *b)
{
    return !(a->grid.value_scale < b->grid.value_scale) &&
           !(a->grid.value_scale > b->grid.value_scale);
}
