/* The cells of a result's mask: mask_cells.h. */
#include "array/algebra/mask_cells.h"

#include "base/context.h"

static size_t cells_along(const size_t dims[3], int axis)
{
    return (dims[axis] - 1) / CVOL_MASK_CELL + 1;
}

size_t cvol_mask_place_count(const size_t dims[3])
{
    return cells_along(dims, 0) * cells_along(dims, 1) * cells_along(dims, 2);
}

cvol_mask_place cvol_mask_place_at(const size_t dims[3], size_t index)
{
    const size_t columns = cells_along(dims, 0), rows = cells_along(dims, 1);
    cvol_mask_place cell = {
        .at = {index % columns, index / columns % rows, index / columns / rows}};
    for (int a = 0; a < 3; a++) {
        cell.begin[a] = CVOL_MASK_CELL * cell.at[a];
        cell.end[a] = cell.begin[a] + CVOL_MASK_CELL;
        if (cell.end[a] > dims[a])
            cell.end[a] = dims[a];
    }
    return cell;
}

size_t cvol_mask_place_samples(const cvol_mask_place *cell)
{
    return (cell->end[0] - cell->begin[0]) * (cell->end[1] - cell->begin[1]) *
           (cell->end[2] - cell->begin[2]);
}

int cvol_mask_fail_memory(cvol_context *context)
{
    return cvol_fail_memory(context, CVOL_MASK_CELL_SAMPLES, "the mask of a result");
}

uint64_t cvol_mask_result_bits(double value)
{
    uint64_t bits;
    (void)cvol_fills_of_value(&bits, CVOL_FLOAT32, value);
    return bits;
}

cvol_fills cvol_mask_result_fills(const cvol_array *operand)
{
    const cvol_fills *own = cvol_mask_fills(operand->mask);
    cvol_fills fills = *own;
    for (int i = 0; i < fills.count; i++)
        fills.bits[i] = cvol_mask_result_bits(cvol_fills_value(own, i, operand->grid.type));
    return fills;
}
