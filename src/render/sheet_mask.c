/* Cover: 1 where a sample has a value, 0 where it has none; on fewer points than samples, straight
 * lines between the two samples around each point. Beyond the volume's faces the last sample is
 * repeated, as where blocks are made. */
#include "render/sheet_mask.h"

#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* The samples of a block: where it begins, and where it or the volume ends. */
static void find_box(size_t begin[3], size_t end[3], const cvol_array *array, size_t index)
{
    cvol_block_origin(begin, array, index);
    for (int a = 0; a < 3; a++) {
        end[a] = begin[a] + (size_t)array->block;
        end[a] = end[a] < array->grid.dims[a] ? end[a] : array->grid.dims[a];
    }
}

int cvol_sheet_mask_blocks(cvol_context *context, uint8_t **out, const cvol_array *array)
{
    *out = cvol_allocate(array->block_count, 1);
    if (!*out)
        return cvol_fail_memory(context, array->block_count, "a mask's blocks");
    for (size_t i = 0; i < array->block_count; i++) {
        uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
        size_t begin[3], end[3];
        find_box(begin, end, array, i);
        const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
        const size_t masked = cvol_mask_get(which, array->mask, begin, end);
        (*out)[i] = (uint8_t)(masked == 0       ? CVOL_MASK_NONE
                              : masked == count ? CVOL_MASK_ALL
                                                : CVOL_MASK_SOME);
    }
    return CVOL_OK;
}

/* The samples on both sides of each point of an axis, and the weight of the second. */
typedef struct axis_points {
    int near[CVOL_BLOCK_MAX], far[CVOL_BLOCK_MAX];
    float weight[CVOL_BLOCK_MAX];
} axis_points;

static void find_points(axis_points *p, int points, double first, double pitch, int inside)
{
    for (int i = 0; i < points; i++) {
        const double at = first + i * pitch;
        const int near = (int)at, last = inside - 1;
        p->near[i] = near < last ? near : last;
        p->far[i] = near + 1 < last ? near + 1 : last;
        p->weight[i] = (float)(at - near);
    }
}

static void fill(float *out, long row_stride, long sheet_stride, const cvol_sheet_plan *plan,
                 int sheets, float value)
{
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < plan->points_row; y++)
            for (int x = 0; x < plan->points_lane; x++)
                out[z * sheet_stride + y * row_stride + x] = value;
}

/* Whether points are the samples, as many as there are. */
static int are_samples(int points, double first, double pitch, int inside)
{
    return points == inside && first == 0 && pitch == 1;
}

/* The cover of a block whose points are its samples; steps: of lanes, rows, sheets in `which`. */
static void copy_cover(float *out, long row_stride, long sheet_stride, const uint8_t *which,
                       const int steps[3], const int size[3], int sheets)
{
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < size[1]; y++) {
            const uint8_t *from = which + (z < size[2] ? z : size[2] - 1) * steps[2] + y * steps[1];
            float *to = out + z * sheet_stride + y * row_stride;
            if (steps[0] == 1)
                for (int x = 0; x < size[0]; x++)
                    to[x] = (float)!from[x];
            else
                for (int x = 0; x < size[0]; x++)
                    to[x] = (float)!from[x * steps[0]];
        }
}

void cvol_sheet_mask_cover(float *out, long row_stride, long sheet_stride,
                           const cvol_sheet_plan *plan, const cvol_array *array,
                           const cvol_mask *mask, int state, size_t lane, size_t row, size_t layer)
{
    if (state != CVOL_MASK_SOME) {
        fill(out, row_stride, sheet_stride, plan, array->block, state == CVOL_MASK_NONE);
        return;
    }
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    size_t begin[3], end[3], place[3];
    place[plan->axis_lane] = lane;
    place[plan->axis_row] = row;
    place[plan->axis_sheet] = layer;
    find_box(begin, end, array,
             place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]));
    cvol_mask_get(which, mask, begin, end);
    int size[3];
    for (int a = 0; a < 3; a++)
        size[a] = (int)(end[a] - begin[a]);
    const int steps[3] = {1, size[0], size[0] * size[1]};
    const int along = steps[plan->axis_lane], down = steps[plan->axis_row];
    if (are_samples(plan->points_lane, plan->first_lane, plan->pitch_lane, size[plan->axis_lane]) &&
        are_samples(plan->points_row, plan->first_row, plan->pitch_row, size[plan->axis_row])) {
        copy_cover(out, row_stride, sheet_stride, which,
                   (int[3]){along, down, steps[plan->axis_sheet]},
                   (int[3]){size[plan->axis_lane], size[plan->axis_row], size[plan->axis_sheet]},
                   array->block);
        return;
    }
    axis_points lanes, rows;
    find_points(&lanes, plan->points_lane, plan->first_lane, plan->pitch_lane,
                size[plan->axis_lane]);
    find_points(&rows, plan->points_row, plan->first_row, plan->pitch_row, size[plan->axis_row]);
    for (int z = 0; z < array->block; z++) {
        const int last = size[plan->axis_sheet] - 1;
        const uint8_t *sheet = which + (z < last ? z : last) * steps[plan->axis_sheet];
        for (int y = 0; y < plan->points_row; y++)
            for (int x = 0; x < plan->points_lane; x++) {
                const uint8_t *near = sheet + rows.near[y] * down,
                              *far = sheet + rows.far[y] * down;
                const int left = lanes.near[x] * along, right = lanes.far[x] * along;
                const float f = lanes.weight[x], g = rows.weight[y];
                const float above = (1 - f) * !near[left] + f * !near[right];
                const float below = (1 - f) * !far[left] + f * !far[right];
                out[z * sheet_stride + y * row_stride + x] = (1 - g) * above + g * below;
            }
    }
}
