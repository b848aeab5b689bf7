/* Memory and bases of a frame of the sheet engine. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "render/sheet/state.h"
#include "transform/cell_points.h"

int cvol_sheet_prepare_image(cvol_sheet_state *state, const cvol_sheet_plan *plan, int has_depth,
                             int threads)
{
    cvol_intermediate *image = &state->intermediate;
    const size_t width = (size_t)plan->width, height = (size_t)plan->height;
    image->width = plan->width;
    image->height = plan->height;
    image->down = cvol_lines_interleaved(plan);
    state->tiles.across = plan->width / CVOL_TILE;
    state->tiles.down = (plan->height + CVOL_TILE - 1) / CVOL_TILE;
    const size_t tiles = (size_t)state->tiles.across * (size_t)state->tiles.down;
    const size_t lit = (size_t)plan->lit;
    image->pending_lines = plan->masked == CVOL_SHEET_SOME_VOID ? CVOL_PENDING_LINES
                                                                : CVOL_PENDING_LINES_PLAIN;
    if (!cvol_ensure(&state->depth, &state->depth_capacity, (size_t)has_depth * width * height,
                     sizeof(float)))
        return 0;
    image->depth = has_depth ? state->depth : NULL;
    const size_t between = plan->parts > 1 ? 2 * (CVOL_PARTS - 1) : 0;
    if (!cvol_ensure(&state->between, &state->between_capacity, between * width * height,
                     sizeof(float)))
        return 0;
    image->between = between ? state->between : NULL;
    return cvol_ensure(&image->pending, &state->pending_capacity,
                       lit * (size_t)image->pending_lines * width * height, sizeof(float)) &&
           cvol_ensure(&image->edges, &state->edge_capacity, lit * width / CVOL_GROUP * height,
                       1) &&
           cvol_ensure(&image->lines, &state->line_capacity, CVOL_LINES * width * height,
                       sizeof(float)) &&
           cvol_ensure(&image->scratch, &state->scratch_capacity,
                       4 * width * (size_t)image->down * (size_t)threads, sizeof(float)) &&
           cvol_ensure(&image->spans, &state->span_capacity, 4 * height, sizeof(int)) &&
           cvol_ensure(&image->opaque, &state->opaque_capacity, width / CVOL_GROUP * height, 1) &&
           cvol_ensure(&image->intersected, &state->intersected_capacity,
                       width / CVOL_GROUP * height, sizeof *image->intersected) &&
           cvol_ensure(&state->held, &state->held_capacity, tiles, sizeof(float)) &&
           cvol_ensure(&state->tiles.open, &state->tile_capacity, tiles, 1);
}

int cvol_sheet_prepare_bands(cvol_sheet_state *state, const cvol_sheet_plan *plan, int threads,
                             int lines)
{
    if (state->band_count < threads) {
        cvol_band_memory *bands = realloc(state->bands, (size_t)threads * sizeof *bands);
        if (!bands)
            return 0;
        state->bands = bands;
        while (state->band_count < threads)
            memset(&bands[state->band_count++], 0, sizeof *bands);
    }
    for (int i = 0; i < threads; i++)
        if (!cvol_band_memory_prepare(&state->bands[i], plan, lines))
            return 0;
    return 1;
}

void cvol_sheet_basis(float *basis, int B, int points, int width)
{
    const double pi = 3.14159265358979323846;
    memset(basis, 0, sizeof(float) * (size_t)(B * width));
    for (int u = 0; u < B; u++)
        for (int i = 0; i < points; i++)
            basis[u * width + i] = (float)(sqrt((u ? 2.0 : 1.0) / B) *
                                           cos(pi * u * (i + 0.5) / points));
}

cvol_block_axes cvol_sheet_prepare_axes(cvol_sheet_state *state, const cvol_sheet_plan *plan)
{
    const int B = state->array->block;
    float *lane = state->bases, *row = lane + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX,
          *sheet = row + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
    cvol_block_axes axes = {.lane = plan->axis_lane,
                            .row = plan->axis_row,
                            .sheet = plan->axis_sheet,
                            .lane_points = plan->points_lane,
                            .row_points = plan->points_row,
                            .sheet_points = plan->points_sheet,
                            .lane_basis = lane,
                            .row_basis = row,
                            .sheet_basis = sheet,
                            .fewer = plan->image_order && plan->points_sheet < B};
    cvol_sheet_basis(lane, B, axes.lane_points, (B < 16 ? 16 : B));
    cvol_sheet_basis(row, B, axes.row_points, axes.row_points);
    cvol_sheet_basis(sheet, B, axes.sheet_points, axes.sheet_points);
    for (int i = 0; i < 2 && B == 16; i++) {
        const int side = i ? 4 : 8;
        float *parts = state->bases + (3 + 3 * i) * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
        float *rows = parts + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX,
              *sheets = rows + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
        cvol_cell_points_basis(parts, side, axes.lane_points, B);
        cvol_cell_points_basis(rows, side, axes.row_points, axes.row_points);
        axes.lane_parts[i] = parts;
        axes.row_parts[i] = rows;
        cvol_cell_points_basis(sheets, side, axes.sheet_points, axes.sheet_points);
        axes.sheet_parts[i] = sheets;
    }
    return axes;
}
