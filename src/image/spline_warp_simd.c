/* Cubic splines at the pixels of a row (spline_row.h). */
#include "image/spline_row.h"

#include "base/vector.h"

/* Four neighbours of four floats. */
#define WINDOW 16
#define PARTS (WINDOW / CVOL_LANES)

CVOL_INLINE void weigh(float w[4], float f)
{
    const float g = 1 - f;
    w[0] = g * g * g * (1 / 6.0f);
    w[1] = (4 - 3 * f * f * (2 - f)) * (1 / 6.0f);
    w[2] = (4 - 3 * g * g * (2 - g)) * (1 / 6.0f);
    w[3] = f * f * f * (1 / 6.0f);
}

/* Whether there is anything near place (x, y). */
CVOL_INLINE int is_near(const cvol_spline_row *row, long x, long y)
{
    for (long j = y < 1 ? 0 : y - 1; j <= y + 2 && j < row->dims[1]; j++)
        if (x + 2 >= row->spans[j][0] && x - 1 < row->spans[j][1])
            return 1;
    return 0;
}

/* The 4 x 4 places around (x, y), row by row; zeros lie around the lattice. */
static void copy_edge(float *out, const cvol_spline_row *row, long x, long y)
{
    for (long j = 0; j < 4; j++)
        for (long i = 0; i < 4; i++, out += 4) {
            const long at_x = x + i - 1, at_y = y + j - 1;
            const int there = at_x >= 0 && at_y >= 0 && at_x < row->dims[0] && at_y < row->dims[1];
            for (int c = 0; c < 4; c++)
                out[c] = there ? row->places[4 * (at_x + row->dims[0] * at_y) + c] : 0;
        }
}

CVOL_INLINE void sample(float out[4], const cvol_spline_row *row, long x, long y, float fx,
                        float fy)
{
    float wx[4], wy[4], edge[4 * WINDOW], sums[WINDOW];
    const float *from = edge;
    long stride = WINDOW;
    weigh(wx, fx);
    weigh(wy, fy);
    if (x >= 1 && y >= 1 && x + 2 < row->dims[0] && y + 2 < row->dims[1]) {
        stride = 4 * row->dims[0];
        from = row->places + (y - 1) * stride + 4 * (x - 1);
    } else {
        copy_edge(edge, row, x, y);
    }
    for (int part = 0; part < PARTS; part++) {
        cvol_vf sum = {0};
        for (int j = 0; j < 4; j++)
            sum += wy[j] * cvol_load(from + j * stride + part * CVOL_LANES);
        cvol_store(sums + part * CVOL_LANES, sum);
    }
    for (int c = 0; c < 4; c++)
        out[c] = wx[0] * sums[c] + wx[1] * sums[4 + c] + wx[2] * sums[8 + c] + wx[3] * sums[12 + c];
}

/* Colour, premultiplied, and opacity over the background, as bytes. */
CVOL_INLINE void store_pixel(uint8_t *out, const float value[4], const float ground[3])
{
    const float through = value[3] > 0 ? value[3] < 1 ? 1 - value[3] : 0 : 1;
    for (int c = 0; c < 3; c++) {
        const float level = (value[c] > 0 ? value[c] : 0) + through * ground[c];
        out[c] = (uint8_t)(int)((level < 1 ? level : 1) * 255 + 0.5f);
    }
    out[3] = 255;
}

void CVOL_SIMD(cvol_spline_sample)(const cvol_spline_row *row)
{
    const double right = (double)row->dims[0] + 1, below = (double)row->dims[1] + 1;
    const float nothing[4] = {0, 0, 0, 0};
    uint8_t empty[4];
    store_pixel(empty, nothing, row->ground);
    for (int i = 0; i < row->count; i++) {
        const double u = row->start[0] + i * row->step[0], v = row->start[1] + i * row->step[1];
        /* rounded towards zero, from above -2 on */
        const int inside = u > -2 && u < right && v > -2 && v < below;
        const long x = inside ? (long)(u + 2) - 2 : 0, y = inside ? (long)(v + 2) - 2 : 0;
        if (inside && is_near(row, x, y)) {
            float value[4];
            sample(value, row, x, y, (float)(u - (double)x), (float)(v - (double)y));
            if (row->values)
                memcpy(row->values + 4 * i, value, sizeof value);
            else
                store_pixel(row->out + 4 * i, value, row->ground);
        } else if (row->values) {
            memcpy(row->values + 4 * i, nothing, sizeof nothing);
        } else {
            memcpy(row->out + 4 * i, empty, sizeof empty);
        }
    }
}
