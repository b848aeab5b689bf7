/* Cubic splines at the pixels of a row (spline_row.h). */
#include "image/spline_row.h"

#include "base/vector_pixel.h"

/* Four neighbours of four floats. */
#define WINDOW 16
#define PARTS (WINDOW / CVOL_LANES)

/* The number of pixels that are converted to bytes together. */
#define CHUNK 16

/* Weights of four neighbours at fraction f: of neighbour i, cubic[0][i] + f cubic[1][i] + .. . Four
 * floats each, for four channels. */
#define FOUR(a) a, a, a, a
static const float cubic[4][WINDOW]
    __attribute__((aligned(64))) = {{FOUR(1 / 6.0f), FOUR(4 / 6.0f), FOUR(1 / 6.0f), FOUR(0)},
                                    {FOUR(-0.5f), FOUR(0), FOUR(0.5f), FOUR(0)},
                                    {FOUR(0.5f), FOUR(-1), FOUR(0.5f), FOUR(0)},
                                    {FOUR(-1 / 6.0f), FOUR(0.5f), FOUR(-0.5f), FOUR(1 / 6.0f)}};
static const float cubic_y[4][4]
    __attribute__((aligned(16))) = {{1 / 6.0f, 4 / 6.0f, 1 / 6.0f, 0},
                                    {-0.5f, 0, 0.5f, 0},
                                    {0.5f, -1, 0.5f, 0},
                                    {-1 / 6.0f, 0.5f, -0.5f, 1 / 6.0f}};

/* Tests if there is anything near place (x, y). */
CVOL_INLINE int is_near(const cvol_spline_row *row, ptrdiff_t x, ptrdiff_t y)
{
    const ptrdiff_t j = y < 0 ? 0 : y < row->dims[1] ? y : row->dims[1] - 1;
    return x + 2 >= row->spans[j][0] && x - 1 < row->spans[j][1];
}

/* The 4 x 4 places around (x, y), row by row; zeros lie around the lattice. */
static void copy_edge(float *out, const cvol_spline_row *row, ptrdiff_t x, ptrdiff_t y)
{
    for (ptrdiff_t j = 0; j < 4; j++)
        for (ptrdiff_t i = 0; i < 4; i++, out += 4) {
            const ptrdiff_t at_x = x + i - 1, at_y = y + j - 1;
            const int there = at_x >= 0 && at_y >= 0 && at_x < row->dims[0] && at_y < row->dims[1];
            for (int c = 0; c < 4; c++)
                out[c] = there ? row->places[4 * (at_x + row->dims[0] * at_y) + c] : 0;
        }
}

CVOL_INLINE cvol_pixel_f sample(const cvol_spline_row *row, ptrdiff_t x, ptrdiff_t y, float fx,
                                float fy)
{
    float wy[4], edge[4 * WINDOW];
    const float *from = edge;
    ptrdiff_t stride = WINDOW;
    if (x >= 1 && y >= 1 && x + 2 < row->dims[0] && y + 2 < row->dims[1]) {
        stride = 4 * row->dims[0];
        from = row->places + (y - 1) * stride + 4 * (x - 1);
    } else {
        copy_edge(edge, row, x, y);
    }
    const cvol_pixel_f down = cvol_pixel_load(cubic_y[0]) +
                              fy * (cvol_pixel_load(cubic_y[1]) +
                                    fy * (cvol_pixel_load(cubic_y[2]) +
                                          fy * cvol_pixel_load(cubic_y[3])));
    memcpy(wy, &down, sizeof wy);
    cvol_pixel_f all = {0};
    for (int part = 0; part < PARTS; part++) {
        const int lane = part * CVOL_LANES;
        const cvol_vf across = cvol_load(cubic[0] + lane) +
                               fx * (cvol_load(cubic[1] + lane) +
                                     fx * (cvol_load(cubic[2] + lane) +
                                           fx * cvol_load(cubic[3] + lane)));
        cvol_vf sum = {0};
        for (int j = 0; j < 4; j++)
            sum += wy[j] * cvol_load(from + j * stride + lane);
        all += cvol_pixels_add(sum * across);
    }
    return all;
}

/* Colour, premultiplied, and opacity over the background, as bytes. ground[3] is 1, so that opacity
 * becomes 255. */
CVOL_INLINE void store_chunk(uint8_t *out, const float *values, const float *ground)
{
    const cvol_vf zero = {0}, one = cvol_splat(1);
    float levels[4 * CHUNK];
    cvol_vi opacity;
    for (int i = 0; i < CVOL_LANES; i++)
        opacity[i] = i | 3;
    for (int i = 0; i < 4 * CHUNK; i += CVOL_LANES) {
        const cvol_vf value = cvol_load(values + i);
        const cvol_vf seen = cvol_shuffle(value, value, opacity);
        const cvol_vf through = one - cvol_min(cvol_max(seen, zero), one);
        const cvol_vf level = cvol_max(value, zero) + through * cvol_load(ground);
        cvol_store(levels + i, cvol_min(level, one) * 255 + 0.5f);
    }
    for (int i = 0; i < 4 * CHUNK; i++)
        out[i] = (uint8_t)(int)levels[i];
}

/* The positions of a chunk's pixels: the place before, and the fraction; far away if nothing is
 * near. */
typedef struct chunk_places {
    int32_t x[CHUNK], y[CHUNK];
    float fx[CHUNK], fy[CHUNK];
} chunk_places;

CVOL_INLINE void find_places(chunk_places *out, const cvol_spline_row *row, int first)
{
    const double right = (double)row->dims[0] + 1, below = (double)row->dims[1] + 1;
    for (int i = 0; i < CHUNK; i++) {
        double u = row->start[0] + (first + i) * row->step[0];
        double v = row->start[1] + (first + i) * row->step[1];
        u = u > -2 ? u : -2;
        v = v > -2 ? v : -2;
        u = u < right ? u : right;
        v = v < below ? v : below;
        /* rounded towards zero, from -2 on */
        out->x[i] = (int32_t)(u + 2) - 2;
        out->y[i] = (int32_t)(v + 2) - 2;
        out->fx[i] = (float)(u - out->x[i]);
        out->fy[i] = (float)(v - out->y[i]);
    }
}

void CVOL_SIMD(cvol_spline_sample)(const cvol_spline_row *row)
{
    float ground[WINDOW];
    for (int i = 0; i < WINDOW; i++)
        ground[i] = i % 4 < 3 ? row->ground[i % 4] : 1;
    for (int first = 0; first < row->count; first += CHUNK) {
        const int count = row->count - first < CHUNK ? row->count - first : CHUNK;
        float values[4 * CHUNK] __attribute__((aligned(64)));
        uint8_t bytes[4 * CHUNK];
        chunk_places at;
        find_places(&at, row, first);
        for (int i = 0; i < CHUNK; i++) {
            cvol_pixel_f value = {0};
            if (is_near(row, at.x[i], at.y[i]))
                value = sample(row, at.x[i], at.y[i], at.fx[i], at.fy[i]);
            memcpy(values + 4 * i, &value, sizeof value);
        }
        if (row->values) {
            memcpy(row->values + 4 * (size_t)first, values, (size_t)count * sizeof(cvol_pixel_f));
        } else {
            store_chunk(bytes, values, ground);
            memcpy(row->out + 4 * (size_t)first, bytes, 4 * (size_t)count);
        }
    }
}
