/* Catmull-Rom interpolation (Catmull and Rom 1974) of pixels of four floats: 4 x 4 taps, the four
 * of a line adjacent in the fewest vectors. */
#include "base/vector_pixel.h"
#include "render/sheet/warp/row.h"

/* Four neighbours of four floats. */
#define WINDOW 16
#define PARTS (WINDOW / CVOL_LANES)

/* Weights of the pixels at -1, 0, 1, 2 for a point at t in 0..1: for neighbour i, cubic[0][i] + t
 * cubic[1][i] + ... . Four floats each, for the four channels. */
#define FOUR(a) a, a, a, a
static const float cubic[4][WINDOW]
    __attribute__((aligned(64))) = {{FOUR(0), FOUR(1), FOUR(0), FOUR(0)},
                                    {FOUR(-0.5f), FOUR(0), FOUR(0.5f), FOUR(0)},
                                    {FOUR(1), FOUR(-2.5f), FOUR(2), FOUR(-0.5f)},
                                    {FOUR(-0.5f), FOUR(1.5f), FOUR(-1.5f), FOUR(0.5f)}};
static const float cubic_v[4][4] __attribute__((aligned(16))) = {
    {0, 1, 0, 0}, {-0.5f, 0, 0.5f, 0}, {1, -2.5f, 2, -0.5f}, {-0.5f, 1.5f, -1.5f, 0.5f}};

/* Returns 1 if any of the taps of pixel (x, y) is not empty. */
CVOL_INLINE int is_near(const cvol_warp_source *source, int x, int y)
{
    const int j = y < 0 ? 0 : y < source->height ? y : source->height - 1;
    return x + 2 >= source->reach[2 * j] && x - 1 < source->reach[2 * j + 1];
}

/* The 4 x 4 pixels around (x, y), line by line; some of them lie outside. */
static __attribute__((noinline)) void copy_edge(float *out, const cvol_warp_source *source, int x,
                                                int y)
{
    for (int j = y - 1; j <= y + 2; j++)
        for (int i = x - 1; i <= x + 2; i++, out += 4) {
            const int there = i >= 0 && j >= 0 && i < source->width && j < source->height;
            memcpy(out, there ? source->pixels + j * source->stride + 4L * i : source->empty,
                   sizeof(cvol_pixel_f));
        }
}

CVOL_INLINE cvol_pixel_f sample(const cvol_warp_source *source, int x, int y, float s, float t)
{
    /* In image order all places are pixels. */
    if (s == 0 && t == 0 && x >= 0 && y >= 0 && x < source->width && y < source->height)
        return cvol_pixel_load(source->pixels + y * source->stride + 4L * x);
    float down[4], edge[4 * WINDOW];
    const float *from = edge;
    ptrdiff_t stride = WINDOW;
    if (x >= 1 && y >= 1 && x + 2 < source->width && y + 2 < source->height) {
        stride = source->stride;
        from = source->pixels + (y - 1) * stride + 4L * (x - 1);
    } else {
        copy_edge(edge, source, x, y);
    }
    const cvol_pixel_f weights = cvol_pixel_load(cubic_v[0]) +
                                 t * (cvol_pixel_load(cubic_v[1]) +
                                      t * (cvol_pixel_load(cubic_v[2]) +
                                           t * cvol_pixel_load(cubic_v[3])));
    memcpy(down, &weights, sizeof down);
    cvol_pixel_f all = {0};
    for (int part = 0; part < PARTS; part++) {
        const int lane = part * CVOL_LANES;
        const cvol_vf across = cvol_load(cubic[0] + lane) +
                               s * (cvol_load(cubic[1] + lane) +
                                    s * (cvol_load(cubic[2] + lane) +
                                         s * cvol_load(cubic[3] + lane)));
        cvol_vf sum = {0};
        for (int j = 0; j < 4; j++)
            sum += down[j] * cvol_load(from + j * stride + lane);
        all += cvol_pixels_add(sum * across);
    }
    return all;
}

/* The pixel before each place, and the distance behind it. */
typedef struct chunk_places {
    int32_t x[CVOL_WARP_CHUNK], y[CVOL_WARP_CHUNK];
    float s[CVOL_WARP_CHUNK], t[CVOL_WARP_CHUNK];
} chunk_places;

CVOL_INLINE void split_places(int32_t *whole, float *fraction, const double *at, int count,
                              int limit)
{
    const double most = limit + 1.0;
    for (int i = 0; i < count; i++) {
        double u = at[i] > -2 ? at[i] : -2;
        u = u < most ? u : most;
        whole[i] = (int32_t)(u + 2) - 2; /* rounded towards zero, from -2 on */
        fraction[i] = (float)(u - whole[i]);
    }
}

/* Returns 1 if any of a chunk's pixels, which lie on a line, may be near a pixel that is not
 * empty. */
CVOL_INLINE int is_chunk_near(const cvol_warp_source *source, const chunk_places *at, int count)
{
    const int x0 = at->x[0], x1 = at->x[count - 1], y0 = at->y[0], y1 = at->y[count - 1];
    const int left = x0 < x1 ? x0 : x1, right = x0 < x1 ? x1 : x0;
    int from = y0 < y1 ? y0 : y1, to = y0 < y1 ? y1 : y0;
    from = from < 0 ? 0 : from < source->height ? from : source->height - 1;
    to = to < 0 ? 0 : to < source->height ? to : source->height - 1;
    for (int j = from; j <= to; j++)
        if (right + 2 >= source->reach[2 * j] && left - 1 < source->reach[2 * j + 1])
            return 1;
    return 0;
}

int CVOL_SIMD(cvol_warp_sample)(float *values, const cvol_warp_source *source,
                                const cvol_warp_places *places)
{
    const int count = places->count;
    const cvol_pixel_f empty = cvol_pixel_load(source->empty);
    chunk_places at;
    split_places(at.x, at.s, places->u, count, source->width);
    split_places(at.y, at.t, places->v, count, source->height);
    if (!is_chunk_near(source, &at, count))
        return 0;
    for (int i = 0; i < count; i++) {
        cvol_pixel_f value = empty;
        if (is_near(source, at.x[i], at.y[i]))
            value = sample(source, at.x[i], at.y[i], at.s[i], at.t[i]);
        memcpy(values + 4 * i, &value, sizeof value);
    }
    return 1;
}

typedef uint8_t bytes __attribute__((vector_size(CVOL_LANES)));

void CVOL_SIMD(cvol_warp_bytes)(uint8_t *rgba, const float *values, int count,
                                const float background[3])
{
    const cvol_vf zero = {0}, one = cvol_splat(1);
    cvol_vf ground, base;
    cvol_vi transmittance;
    /* Channel 3 is 1 - T + T = 1, for any T. */
    for (int i = 0; i < CVOL_LANES; i++) {
        ground[i] = i % 4 < 3 ? background[i % 4] : 0;
        base[i] = i % 4 < 3 ? 0 : 1;
        transmittance[i] = i | 3;
    }
    for (int i = 0; i < 4 * count; i += CVOL_LANES) {
        const int left = 4 * count - i;
        cvol_vf value = zero;
        if (left < CVOL_LANES)
            memcpy(&value, values + i, (size_t)left * sizeof *values);
        else
            value = cvol_load(values + i);
        const cvol_vf seen = cvol_shuffle(value, value, transmittance);
        const cvol_vf level = value + cvol_min(cvol_max(seen, zero), one) * ground;
        const bytes now = __builtin_convertvector(
            cvol_to_int(cvol_min(cvol_max(cvol_max(level, base), zero), one) * 255 + 0.5f), bytes);
        memcpy(rgba + i, &now, left < CVOL_LANES ? (size_t)left : sizeof now);
    }
}
