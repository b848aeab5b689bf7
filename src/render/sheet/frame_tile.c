/* Tiles of a frame: see frame_tile.h. */
#include "render/sheet/frame_tile.h"

#include <math.h>

#include "render/sheet/band/band.h"
#include "render/sheet/band/work_stealing.h"

/* The limit for lines, samples and a mask: a part of the 16 MB, and of the 24 bytes per pixel of
 * the picture, that a frame needs at most. The rest is for windows of blocks and for tables. The
 * estimate assumes two threads, each with its own copy of shared samples. */
#define FRAME_BYTES 14e6
#define PIXEL_BYTES 22
#define THREADS 2

/* Tiles of fewer lines share too many of their blocks with others. */
#define MIN_LINES 48

/* Lines before and behind a pixel that the warp reads, and one more line for rounding. */
#define LINES_BEFORE 2
#define LINES_BEHIND 3

/* A multiple of the lines that are interleaved. */
static int whole_lines(const cvol_sheet_plan *plan, int lines)
{
    const int once = cvol_lines_interleaved(plan);
    return (lines + once - 1) / once * once;
}

static int tile_lines(const cvol_sheet_plan *plan, int count)
{
    return whole_lines(plan, (plan->height + count - 1) / count);
}

cvol_sheet_plan cvol_frame_tile_make(const cvol_sheet_plan *plan, int index, int count)
{
    cvol_sheet_plan out = *plan;
    const int lines = tile_lines(plan, count), begin = index * lines, end = begin + lines,
              before = whole_lines(plan, LINES_BEFORE), behind = whole_lines(plan, LINES_BEHIND);
    if (count == 1)
        return out;
    const int first = begin > before ? begin - before : 0,
              last = end + behind < plan->height ? end + behind : plan->height;
    out.v0 = plan->v0 + first * plan->dv;
    for (int k = 0; k < 2; k++)
        out.place[k][0] += first * out.place[k][2];
    out.height = last > first ? last - first : cvol_lines_interleaved(plan);
    out.own[0] = index ? plan->v0 + begin * plan->dv : -INFINITY;
    out.own[1] = index + 1 < count ? plan->v0 + end * plan->dv : INFINITY;
    return out;
}

/* The most bytes that a tile takes, for this number of tiles. */
static double find_bytes(const cvol_sheet_plan *plan, int line_floats, int count)
{
    double most = 0;
    for (int i = 0; i < count; i++) {
        const cvol_sheet_plan tile = cvol_frame_tile_make(plan, i, count);
        const int lines = cvol_work_stealing_lines(&tile, THREADS);
        most = fmax(most, (double)line_floats * sizeof(float) * tile.width * tile.height +
                              THREADS * (double)cvol_band_sample_bytes(&tile, lines));
    }
    return most;
}

cvol_frame_tiles cvol_frame_tiles_choose(const cvol_sheet_plan *plan, size_t pixels,
                                         int line_floats, size_t mask_bytes)
{
    const double most = FRAME_BYTES + PIXEL_BYTES * (double)pixels - (double)mask_bytes;
    int count = 1;
    double bytes = find_bytes(plan, line_floats, count);
    while (tile_lines(plan, count + 1) >= MIN_LINES && bytes > most)
        bytes = find_bytes(plan, line_floats, ++count);
    return (cvol_frame_tiles){count, bytes < most ? (size_t)(most - bytes) : 0};
}
