/* The intermediate image: see intermediate.h. */
#include "render/sheet/band/intermediate.h"

#include <math.h>

size_t cvol_sheet_block_index(const cvol_sheet_plan *plan, const cvol_array *array, size_t lane,
                              size_t row, size_t layer)
{
    size_t place[3];
    place[plan->axis_lane] = lane;
    place[plan->axis_row] = row;
    place[plan->axis_sheet] = layer;
    return place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]);
}

void cvol_tiles_update(const cvol_tiles *tiles, const cvol_intermediate *intermediate, int begin,
                       int end)
{
    const int down = intermediate->down, groups = intermediate->width * down / CVOL_GROUP;
    const size_t first = (size_t)(begin / CVOL_TILE), last = (size_t)((end - 1) / CVOL_TILE);
    memset(tiles->open + first * (size_t)tiles->across, 0,
           (last - first + 1) * (size_t)tiles->across);
    for (int j = begin; j < end; j += down) {
        const uint8_t *opaque = intermediate->opaque + (size_t)(j / down) * (size_t)groups;
        uint8_t *open = tiles->open + (size_t)(j / CVOL_TILE) * (size_t)tiles->across;
        if (down == 1)
            for (int g = 0; g < groups; g++)
                open[g] |= !opaque[g];
        else
            for (int g = 0; g < groups / CVOL_SQUARE; g++)
                open[g] |= !(opaque[4 * g] & opaque[4 * g + 1] & opaque[4 * g + 2] &
                             opaque[4 * g + 3]);
    }
}

/* First and last tile that samples lo .. hi of one axis reach, between two planes of samples. */
static void tile_span(int *first, int *last, double start, double delta, double lo, double hi,
                      const double shift[2], const double scale[2], int count)
{
    double from = INFINITY, to = -INFINITY;
    for (int k = 0; k < 2; k++) {
        const double begin = (lo - shift[k]) / scale[k], end = (hi - shift[k]) / scale[k];
        from = begin < from ? begin : from;
        to = end > to ? end : to;
    }
    from = floor((from - start) / delta) - 1;
    to = ceil((to - start) / delta) + 1;
    *first = from < 0 ? 0 : from >= (double)count * CVOL_TILE ? count : (int)from / CVOL_TILE;
    *last = to < 0 ? -1 : to >= (double)count * CVOL_TILE ? count - 1 : (int)to / CVOL_TILE;
}

/* The pixels that see a rectangle of a plane of samples lie within lo .. hi, around the pixel that
 * sees its middle. */
static void widen_pixels(double lo[2], double hi[2], const cvol_sheet_plan *plan, double z,
                         const double lanes[2], const double rows[2])
{
    const double *u = plan->place[0], *v = plan->place[1];
    const double inverse = 1 / (u[1] * v[2] - u[2] * v[1]), size = fabs(inverse);
    const double lane = (lanes[0] + lanes[1]) / 2, row = (rows[0] + rows[1]) / 2,
                 du = lane - plan->shear_lane * z - u[0], dv = row - plan->shear_row * z - v[0];
    const double at[2] = {(v[2] * du - u[2] * dv) * inverse, (u[1] * dv - v[1] * du) * inverse};
    const double half_lane = size * (lanes[1] - lane), half_row = size * (rows[1] - row);
    const double reach[2] = {fabs(v[2]) * half_lane + fabs(u[2]) * half_row,
                             fabs(v[1]) * half_lane + fabs(u[1]) * half_row};
    for (int k = 0; k < 2; k++) {
        const double from = at[k] - reach[k], to = at[k] + reach[k];
        lo[k] = from < lo[k] ? from : lo[k];
        hi[k] = to > hi[k] ? to : hi[k];
    }
}

/* Moves a plane next to the eye or behind it to just before it. */
static void keep_ahead(cvol_sheet_crossing *at, const cvol_sheet_plan *plan)
{
    const double least = 1e-3;
    if (at->scale < least)
        *at = (cvol_sheet_crossing){(1 - least) * plan->eye_lane, (1 - least) * plan->eye_row,
                                    least};
}

int cvol_block_tiles(cvol_tile_span *out, const cvol_tiles *tiles, const cvol_sheet_plan *plan,
                     size_t lane, size_t row, size_t z_begin, size_t z_end)
{
    /* Points beyond the block's own. */
    const double beyond = (plan->lapped ? 2 : 0) + cvol_sheet_reach(plan);
    cvol_sheet_crossing from = cvol_sheet_cross(plan, cvol_sheet_place(plan, z_begin)),
                        to = cvol_sheet_cross(plan, cvol_sheet_place(plan, z_end - 1));
    if (from.scale <= 0 && to.scale <= 0) /* behind the eye */
        return 0;
    keep_ahead(&from, plan);
    keep_ahead(&to, plan);
    const double around = fmax(2, 2 * plan->pitch_sheet);
    const double still = plan->image_order ? 0 : 1;
    const double lanes[2] = {still * from.lane, still * to.lane},
                 rows[2] = {still * from.row, still * to.row}, scales[2] = {from.scale, to.scale},
                 reach_lane = fmax(around, plan->pitch_lane) + beyond * plan->pitch_lane,
                 reach_row = fmax(around, plan->pitch_row) + beyond * plan->pitch_row;
    const double lane_lo = (double)(lane * (size_t)plan->block_lane) - reach_lane,
                 row_lo = (double)(row * (size_t)plan->block_row) - reach_row;
    double lane_reach[2] = {lane_lo, lane_lo + plan->block_lane - 1 + 2 * reach_lane},
           row_reach[2] = {row_lo, row_lo + plan->block_row - 1 + 2 * reach_row};
    if (plan->image_order) {
        double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
        widen_pixels(lo, hi, plan, cvol_sheet_place(plan, z_begin), lane_reach, row_reach);
        widen_pixels(lo, hi, plan, cvol_sheet_place(plan, z_end - 1), lane_reach, row_reach);
        for (int k = 0; k < 2; k++) {
            lane_reach[k] = k ? hi[0] : lo[0];
            row_reach[k] = k ? hi[1] : lo[1];
        }
    }
    const double first_line = plan->image_order ? 0 : plan->v0;
    tile_span(&out->left, &out->right, plan->u0, plan->du, lane_reach[0], lane_reach[1], lanes,
              scales, tiles->across);
    tile_span(&out->top, &out->bottom, first_line, plan->dv, row_reach[0], row_reach[1], rows,
              scales, tiles->down);
    return 1;
}

cvol_block_visibility cvol_block_test_visibility(const cvol_tiles *tiles,
                                                 const cvol_sheet_plan *plan, size_t lane,
                                                 size_t row, size_t z_begin, size_t z_end,
                                                 int tile_begin, int tile_end)
{
    cvol_tile_span span;
    if (!cvol_block_tiles(&span, tiles, plan, lane, row, z_begin, z_end))
        return CVOL_BLOCK_HIDDEN;
    const int is_shared = span.top < tile_begin || span.bottom >= tile_end;
    const int top = span.top < tile_begin ? tile_begin : span.top,
              bottom = span.bottom >= tile_end ? tile_end - 1 : span.bottom;
    for (int y = top; y <= bottom; y++)
        for (int x = span.left; x <= span.right; x++)
            if (tiles->open[(size_t)y * (size_t)tiles->across + (size_t)x])
                return is_shared ? CVOL_BLOCK_SHARED : CVOL_BLOCK_VISIBLE;
    return CVOL_BLOCK_HIDDEN;
}

void cvol_layer_sheets(size_t *begin, size_t *end, const cvol_sheet_plan *plan, size_t layer)
{
    const size_t points = (size_t)plan->points_sheet;
    *begin = layer * points;
    *end = *begin + points < plan->sheet_count ? *begin + points : plan->sheet_count;
}

cvol_line cvol_band_line(const cvol_intermediate *image, int j)
{
    const size_t width = (size_t)image->width, groups = width / CVOL_GROUP, at = (size_t)j;
    return (cvol_line){
        .values = image->lines + at * CVOL_LINES * width,
        .opaque = image->opaque + at * groups,
        .intersected = image->intersected + at * groups,
        .pending = image->pending ? image->pending + at * (size_t)image->pending_lines * width
                                  : NULL,
        .edges = image->edges ? image->edges + at * groups : NULL,
        .depth = image->depth ? image->depth + at * width : NULL,
        .between = image->between ? image->between + at * 2 * (CVOL_PARTS - 1) * width : NULL,
        .number = j,
        .width = image->width * image->down};
}
