/* Closed and hidden cells of a picture (occlusion.h). */
#include "render/splat/occlusion.h"

#define MIN_LIGHT 0x1p-14f

static int is_closed(const cvol_splat_band *band, int cell_x, int cell_y)
{
    const int left = cell_x * CVOL_HIDDEN_WIDTH, top = cell_y * CVOL_HIDDEN_HEIGHT;
    const int right = left + CVOL_HIDDEN_WIDTH < band->width ? left + CVOL_HIDDEN_WIDTH
                                                             : band->width;
    const int rows = band->end - band->begin;
    const int bottom = top + CVOL_HIDDEN_HEIGHT < rows ? top + CVOL_HIDDEN_HEIGHT : rows;
    for (int y = top; y < bottom; y++) {
        const float *row = band->image + (size_t)y * band->row_stride;
        for (int x = left; x < right; x++)
            if (row[CVOL_SPLAT_CHANNELS * (x + band->margin) + 3] >= MIN_LIGHT)
                return 0;
    }
    return 1;
}

static int clamp(int value, int least, int most)
{
    return value < least ? least : value > most ? most : value;
}

/* Returns 1 if `cells` is set from x0 to x1 and y0 to y1. */
static int is_set(const cvol_splat_hidden *hidden, const uint8_t *cells, int x0, int y0, int x1,
                  int y1)
{
    for (int y = clamp(y0, 0, hidden->down - 1); y <= clamp(y1, 0, hidden->down - 1); y++)
        for (int x = clamp(x0, 0, hidden->across - 1); x <= clamp(x1, 0, hidden->across - 1); x++)
            if (!cells[y * hidden->across + x])
                return 0;
    return 1;
}

void cvol_splat_hidden_update(cvol_splat_hidden *hidden, const cvol_splat_band *band)
{
    int changed = 0;
    for (int y = 0; y < hidden->down; y++)
        for (int x = 0; x < hidden->across; x++) {
            uint8_t *cell = &hidden->closed[y * hidden->across + x];
            if (*cell || !is_closed(band, x, y))
                continue;
            *cell = 1;
            changed = 1;
        }
    if (!changed)
        return;
    hidden->all = 1;
    for (int y = 0; y < hidden->down; y++)
        for (int x = 0; x < hidden->across; x++) {
            int set = is_set(hidden, hidden->closed, x - hidden->reach[0], y - hidden->reach[1],
                             x + hidden->reach[0], y + hidden->reach[1]);
            hidden->hidden[y * hidden->across + x] = (uint8_t)set;
            hidden->some |= set;
            hidden->all &= set;
        }
}

/* Samples outside of the band count as in its outermost cells, which reach the same pixels. */
static int cell_of(double at, int size, int count)
{
    return at > 0 ? at < (double)size * count ? (int)at / size : count - 1 : 0;
}

int cvol_splat_is_hidden(const cvol_splat_hidden *hidden, const cvol_splat_band *band, double x0,
                         double y0, double x1, double y1)
{
    const double left = x0 < x1 ? x0 : x1, right = x0 < x1 ? x1 : x0;
    const double top = (y0 < y1 ? y0 : y1) - band->begin;
    const double bottom = (y0 < y1 ? y1 : y0) - band->begin;
    return is_set(hidden, hidden->hidden, cell_of(left, CVOL_HIDDEN_WIDTH, hidden->across),
                  cell_of(top, CVOL_HIDDEN_HEIGHT, hidden->down),
                  cell_of(right, CVOL_HIDDEN_WIDTH, hidden->across),
                  cell_of(bottom, CVOL_HIDDEN_HEIGHT, hidden->down));
}
