/* Trilinear interpolation along lines, one function for each sample type.
 *
 * The samples keep their own type, so a volume needs no second copy. With the cell (x0, y0, z0) =
 * floor(x, y, z) and the fractions f, g, h within it,
 *
 *     a = sum over the 8 corners of (f or 1 - f) (g or 1 - g) (h or 1 - h) sample
 *
 * computed as seven linear steps in double precision, which represent every 32-bit integer exactly.
 * If samples may have no value, the sum is over the corners with a value, divided by their
 * weights. */
#include "render/ray/sample.h"

#include <math.h>

#include "base/for_type.h"

cvol_ray_field cvol_ray_field_make(const cvol_volume *volume, double min, double max)
{
    const size_t *n = volume->grid.dims;
    cvol_ray_field field = {.data = volume->data, .row = n[0], .slice = n[0] * n[1]};
    const size_t steps[3] = {1, field.row, field.slice};
    for (int a = 0; a < 3; a++) {
        field.last[a] = (double)(n[a] - 1);
        field.cell_max[a] = n[a] > 1 ? n[a] - 2 : 0;
        field.next[a] = n[a] > 1 ? steps[a] : 0;
    }
    field.min = min;
    field.max = max;
    return field;
}

/* The cell of a coordinate, and the fraction within it. */
static inline size_t find_cell(double *fraction, double place, double last, size_t cell_max)
{
    place = place > 0 ? (place < last ? place : last) : 0;
    size_t cell = (size_t)place;
    cell = cell < cell_max ? cell : cell_max;
    *fraction = place - (double)cell;
    return cell;
}

static inline double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

/* NaN fails every comparison and becomes min. */
static inline double clamp_value(double value, const cvol_ray_field *field)
{
    return value >= field->min ? (value <= field->max ? value : field->max) : field->min;
}

#define PLAIN(value, field) ((double)(value))
#define CLAMPED(value, field) clamp_value((double)(value), field)

#define DEFINE_LINE(name, type, READ)                                                              \
    static inline double along_x_##name(const type *at, double f, const cvol_ray_field *field)     \
    {                                                                                              \
        return mix(READ(at[0], field), READ(at[field->next[0]], field), f);                        \
    }                                                                                              \
    static void line_##name(double *out, const cvol_ray_field *field, const double start[3],       \
                            const double delta[3], size_t count)                                   \
    {                                                                                              \
        const type *data = field->data;                                                            \
        size_t below = field->next[1], behind = field->next[2];                                    \
        for (size_t k = 0; k < count; k++) {                                                       \
            double t = (double)k, f, g, h;                                                         \
            size_t x = find_cell(&f, start[0] + t * delta[0], field->last[0], field->cell_max[0]); \
            size_t y = find_cell(&g, start[1] + t * delta[1], field->last[1], field->cell_max[1]); \
            size_t z = find_cell(&h, start[2] + t * delta[2], field->last[2], field->cell_max[2]); \
            const type *at = data + x + y * field->row + z * field->slice;                         \
            double front = mix(along_x_##name(at, f, field), along_x_##name(at + below, f, field), \
                               g);                                                                 \
            at += behind;                                                                          \
            double back = mix(along_x_##name(at, f, field), along_x_##name(at + below, f, field),  \
                              g);                                                                  \
            out[k] = mix(front, back, h);                                                          \
        }                                                                                          \
    }

DEFINE_LINE(uint8, uint8_t, PLAIN)
DEFINE_LINE(int8, int8_t, PLAIN)
DEFINE_LINE(uint16, uint16_t, PLAIN)
DEFINE_LINE(int16, int16_t, PLAIN)
DEFINE_LINE(uint32, uint32_t, PLAIN)
DEFINE_LINE(int32, int32_t, PLAIN)
DEFINE_LINE(float32, float, CLAMPED)
DEFINE_LINE(float64, double, CLAMPED)

cvol_ray_line_fn cvol_ray_line_of(cvol_type type)
{
    static const cvol_ray_line_fn lines[] = {
        [CVOL_UINT8] = line_uint8,     [CVOL_INT8] = line_int8,       [CVOL_UINT16] = line_uint16,
        [CVOL_INT16] = line_int16,     [CVOL_UINT32] = line_uint32,   [CVOL_INT32] = line_int32,
        [CVOL_FLOAT32] = line_float32, [CVOL_FLOAT64] = line_float64,
    };
    return lines[type];
}

/* ---- samples without a value ----------------------------------------------------------------- */

#define DEFINE_MASKED(name, type, READ)                                                       \
    static void masked_##name(double *out, double *cover, const cvol_ray_field *field,        \
                              const double start[3], const double delta[3], size_t count)     \
    {                                                                                         \
        const type *data = field->data;                                                       \
        for (size_t k = 0; k < count; k++) {                                                  \
            double w[3][2], sum = 0, weight = 0;                                              \
            size_t at[3];                                                                     \
            for (int a = 0; a < 3; a++) {                                                     \
                at[a] = find_cell(&w[a][1], start[a] + (double)k * delta[a], field->last[a],  \
                                  field->cell_max[a]);                                        \
                w[a][0] = 1 - w[a][1];                                                        \
            }                                                                                 \
            const size_t base = at[0] + at[1] * field->row + at[2] * field->slice;            \
            for (int c = 0; c < 8; c++) {                                                     \
                const size_t i = base + (c & 1 ? field->next[0] : 0) +                        \
                                 (c & 2 ? field->next[1] : 0) + (c & 4 ? field->next[2] : 0); \
                const double of = w[0][c & 1] * w[1][c >> 1 & 1] * w[2][c >> 2];              \
                if (field->mask[i] || of == 0)                                                \
                    continue;                                                                 \
                sum += of * READ(data[i], field);                                             \
                weight += of;                                                                 \
            }                                                                                 \
            out[k] = weight > 0 ? sum / weight : 0;                                           \
            cover[k] = weight;                                                                \
        }                                                                                     \
    }

DEFINE_MASKED(uint8, uint8_t, PLAIN)
DEFINE_MASKED(int8, int8_t, PLAIN)
DEFINE_MASKED(uint16, uint16_t, PLAIN)
DEFINE_MASKED(int16, int16_t, PLAIN)
DEFINE_MASKED(uint32, uint32_t, PLAIN)
DEFINE_MASKED(int32, int32_t, PLAIN)
DEFINE_MASKED(float32, float, CLAMPED)
DEFINE_MASKED(float64, double, CLAMPED)

cvol_ray_masked_fn cvol_ray_masked_of(cvol_type type)
{
    static const cvol_ray_masked_fn lines[] = {
        [CVOL_UINT8] = masked_uint8,     [CVOL_INT8] = masked_int8,
        [CVOL_UINT16] = masked_uint16,   [CVOL_INT16] = masked_int16,
        [CVOL_UINT32] = masked_uint32,   [CVOL_INT32] = masked_int32,
        [CVOL_FLOAT32] = masked_float32, [CVOL_FLOAT64] = masked_float64,
    };
    return lines[type];
}

int cvol_ray_field_bound(double *min, double *max, const cvol_volume *volume, const uint8_t *mask)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    double lo = INFINITY, hi = -INFINITY;
#define BOUND(type)                                             \
    for (size_t i = 0; i < count; i++) {                        \
        const double value = (double)((type *)volume->data)[i]; \
        if (mask[i] || !isfinite(value))                        \
            continue;                                           \
        lo = fmin(lo, value);                                   \
        hi = fmax(hi, value);                                   \
    }
    CVOL_FOR_TYPE(volume->grid.type, BOUND)
#undef BOUND
    *min = lo <= hi ? lo : 0;
    *max = lo <= hi ? hi : 0;
    return lo <= hi;
}
