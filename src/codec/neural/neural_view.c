/* Computes the context of a coefficient from its surroundings. */
#include "base/elementary.h"
#include "codec/neural/neural_internal.h"
#include "codec/quantize/trellis_states.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#define PI 3.14159265358979323846

/* From this scattered sum on, low bits are raw. */
enum { FINEST_SUM = 192 };

/* ---- tables ----------------------------------------------------------------------------- */

cvol_neural_basis cvol_neural_cosines;
cvol_neural_pairs cvol_neural_magnitude_pairs, cvol_neural_sign_pairs;
static uint8_t classes[CVOL_NEURAL_LIMIT + 1];
static uint16_t shares[9]; /* 2^16 / n */
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

CVOL_SIMD_DECLARE(void, cvol_neural_inverse,
                  (int32_t * samples, const int32_t *known, const int n[3], int cube,
                   const cvol_neural_basis *basis));
CVOL_SIMD_DECLARE(void, cvol_neural_face,
                  (int32_t * level, int32_t *slope, const int32_t *near, const int32_t *far,
                   const int stride[2], const int n[2], const cvol_neural_basis *basis));

static void pair_weights(cvol_neural_pairs *to, const cvol_neural_network *from)
{
    for (int j = 0; j < CVOL_NEURAL_FIRST; j++)
        for (int i = 0; i < CVOL_NEURAL_INPUTS; i++)
            to->first[i / 2][j][i % 2] = from->first[j][i];
    for (int k = 0; k < CVOL_NEURAL_SECOND; k++)
        for (int j = 0; j < CVOL_NEURAL_FIRST; j++)
            to->second[j / 2][k][j % 2] = from->second[k][j];
    for (int t = 0; t < CVOL_NEURAL_OUTPUTS; t++)
        for (int k = 0; k < CVOL_NEURAL_SECOND; k++)
            to->third[k / 2][t][k % 2] = from->third[t][k];
    memcpy(to->first_bias, from->first_bias, sizeof to->first_bias);
    memcpy(to->second_bias, from->second_bias, sizeof to->second_bias);
    memcpy(to->third_bias, from->third_bias, sizeof to->third_bias);
}

static void fill_tables(void)
{
    pair_weights(&cvol_neural_magnitude_pairs, &cvol_neural_magnitudes);
    pair_weights(&cvol_neural_sign_pairs, &cvol_neural_signs);
    for (int m = 0; m <= CVOL_NEURAL_LIMIT; m++)
        classes[m] = (uint8_t)floor(10 * cvol_log2(1.0 + m) + 0.5);
    cvol_logistic_fill();
    for (int n = 1; n <= 16; n++)
        for (int k = 0; k < n; k++)
            for (int x = 0; x < n; x++)
                cvol_neural_cosines.of[n][k][x] = (int32_t)floor(
                    1024 * sqrt((k ? 2.0 : 1.0) / n) * cvol_cos(PI * k * (2 * x + 1) / (2.0 * n)) +
                    0.5);
    for (int n = 1; n < 9; n++)
        shares[n] = (uint16_t)(65535 / n);
}

void cvol_neural_fill_tables(void)
{
    pthread_once(&tables_once, fill_tables);
}

int cvol_neural_class(uint32_t magnitude)
{
    return classes[magnitude < CVOL_NEURAL_LIMIT ? magnitude : CVOL_NEURAL_LIMIT];
}

int cvol_neural_face_class(int32_t z)
{
    return cvol_neural_class(cvol_magnitude(z) >> 2);
}

int cvol_neural_face_signed(int32_t z)
{
    return z < 0 ? -cvol_neural_face_class(z) : cvol_neural_face_class(z);
}

/* ---- around a sub-block ----------------------------------------------------------------- */

void cvol_neural_find_neighbours(cvol_neural_brick *b)
{
    static const int strides[3] = {1, CVOL_BRICK_UNITS, CVOL_BRICK_UNITS * CVOL_BRICK_UNITS};
    for (int i = 0; i < CVOL_BRICK_UNITS_ALL; i++)
        b->unit[i] = CVOL_NEURAL_NONE;
    for (int i = 0; i < b->parts; i++) {
        const cvol_neural_sub_block *p = &b->part[i];
        const int units = p->side / 4;
        for (int z = 0; z < units && p->scan; z++)
            for (int y = 0; y < units; y++)
                for (int x = 0; x < units; x++)
                    b->unit[p->at[0] + x +
                            CVOL_BRICK_UNITS * (p->at[1] + y + CVOL_BRICK_UNITS * (p->at[2] + z))] =
                        (int16_t)i;
    }
    for (int i = 0; i < b->parts; i++) {
        cvol_neural_sub_block *p = &b->part[i];
        const int units = p->side / 4;
        const int16_t *unit =
            &b->unit[p->at[0] * strides[0] + p->at[1] * strides[1] + p->at[2] * strides[2]];
        for (int a = 0; a < 3; a++) {
            const int e1 = a == 2 ? 1 : 0,
                      e2 = a == 0 ? 1 : 2; /* edges between x and y, x and z, y and z */
            p->across[a] = p->at[e1] && p->at[e2] ? unit[-strides[e1] - strides[e2]]
                                                  : CVOL_NEURAL_NONE;
            p->neighbours[a] = p->at[a] ? unit[-strides[a]] : CVOL_NEURAL_NONE;
            p->neighbours[3 + a] = p->at[a] + units < CVOL_BRICK_UNITS && p->n[a] == p->side
                                       ? unit[units * strides[a]]
                                       : CVOL_NEURAL_NONE;
        }
    }
}

/* Computes the samples of a sub-block's known values: frequencies below `cube`. */
static void put_samples(cvol_neural_brick *b, const cvol_neural_sub_block *p, int cube)
{
    const int n[3] = {p->n[0], p->n[1], p->n[2]};
    CVOL_SIMD_CHOOSE(cvol_neural_inverse)
    (b->samples + p->first, b->known + p->first, n, cube, &cvol_neural_cosines);
}

/* Averages magnitudes, in tens of log2, around each frequency below `cube`. */
static void put_blur(cvol_neural_brick *b, const cvol_neural_sub_block *p, int cube)
{
    uint8_t size[16][16][16];
    int n[3];
    for (int a = 0; a < 3; a++)
        n[a] = cube < p->n[a] ? cube : p->n[a];
    const int32_t *known = b->known + p->first;
    uint8_t *blur = b->blur + p->first;
    for (int w = 0; w < n[2]; w++)
        for (int v = 0; v < n[1]; v++)
            for (int u = 0; u < n[0]; u++)
                size[w][v][u] = (uint8_t)cvol_neural_class(
                    cvol_magnitude(known[u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w]));
    size[0][0][0] = 0;
    for (int w = 0; w < n[2]; w++)
        for (int v = 0; v < n[1]; v++)
            for (int u = 0; u < n[0]; u++) {
                uint32_t sum = 2u * size[w][v][u], count = 2;
#define ADD(there, value) \
    if (there) {          \
        sum += value;     \
        count++;          \
    }
                ADD(u > 0, size[w][v][u - 1])
                ADD(u < n[0] - 1, size[w][v][u + 1])
                ADD(v > 0, size[w][v - 1][u])
                ADD(v < n[1] - 1, size[w][v + 1][u])
                ADD(w > 0, size[w - 1][v][u])
                ADD(w < n[2] - 1, size[w + 1][v][u])
#undef ADD
                blur[u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w] =
                    (uint8_t)(sum * shares[count] >> 16);
            }
    blur[0] = 0;
}

void cvol_neural_average(cvol_neural_brick *b, const cvol_neural_sub_block *p, int subband)
{
    const int cube = p->side >> (CVOL_SUBBANDS - 1 - subband), from = cube > 2 ? cube / 2 : 1;
    uint8_t *seen_count = &b->seen_count[p->size_class][subband];
    int16_t *means = b->means[p->size_class];
    for (int w = 0; w < cube && w < p->n[2]; w++)
        for (int v = 0; v < cube && v < p->n[1]; v++)
            for (int u = w < from && v < from ? from : 0; u < cube && u < p->n[0]; u++) {
                int16_t *mean = &means[u + 16 * (v + 16 * w)];
                const int size = cvol_neural_class(cvol_magnitude(
                    b->known[p->first + u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w]));
                *mean = (int16_t)(*mean + ((16 * size - *mean) >> *seen_count));
            }
    *seen_count = (uint8_t)(*seen_count + (*seen_count < 3));
}

void cvol_neural_update_samples(cvol_neural_brick *b, const cvol_neural_sub_block *p, int cube)
{
    put_samples(b, p, cube);
    put_blur(b, p, cube);
}

/* The faces' predictions minus the contribution of the sub-block's known coefficients. */
static void view_faces(cvol_neural_view *f, const cvol_neural_brick *b,
                       const cvol_neural_sub_block *p, int cube)
{
    static const int strides[3] = {1, CVOL_NEURAL_SIDE, CVOL_NEURAL_SLICE};
    for (int i = 0; i < CVOL_NEURAL_PLANES; i++) {
        const int a = i % 3, behind = i / 3, o1 = a == 0, o2 = a == 2 ? 1 : 2;
        f->there[i] = p->neighbours[i] != CVOL_NEURAL_NONE;
        if (!f->there[i])
            continue;
        const cvol_neural_sub_block *other = &b->part[p->neighbours[i]];
        const int thin = behind && other->n[a] == 1, step = behind ? strides[a] : -strides[a];
        const int32_t *near = b->samples + p->first + (behind ? p->side * strides[a] : -strides[a]);
        CVOL_SIMD_CHOOSE(cvol_neural_face)
        (f->level[i], f->slope[i], near, thin ? near : near + step,
         (const int[2]){strides[o1], strides[o2]}, (const int[2]){p->n[o1], p->n[o2]},
         &cvol_neural_cosines);
    }
    int n[3];
    for (int a = 0; a < 3; a++)
        n[a] = cube < p->n[a] ? cube : p->n[a];
    for (int w = 0; w < n[2]; w++)
        for (int v = 0; v < n[1]; v++)
            for (int u = 0; u < n[0]; u++) {
                const int32_t value =
                    b->known[p->first + u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w];
                if (value) {
                    const int at[3] = {u, v, w};
                    cvol_neural_subtract_known(f->level, f->slope, p->n, at, value,
                                               &cvol_neural_cosines);
                }
            }
}

static void view_sizes(cvol_neural_view *f, const cvol_neural_brick *b,
                       const cvol_neural_sub_block *p, int cube)
{
    const int size = CVOL_NEURAL_PAD * CVOL_NEURAL_PAD * (p->side + 4);
    memset(f->sizes, 0, (size_t)size * sizeof *f->sizes);
    memset(f->classes, 0, (size_t)size);
    for (int w = 0; w < cube && w < p->n[2]; w++)
        for (int v = 0; v < cube && v < p->n[1]; v++)
            for (int u = 0; u < cube && u < p->n[0]; u++) {
                const uint32_t m = cvol_magnitude(
                    b->known[p->first + u + CVOL_NEURAL_SIDE * v + CVOL_NEURAL_SLICE * w]);
                const int at = CVOL_NEURAL_ORIGIN + u + CVOL_NEURAL_PAD * (v + CVOL_NEURAL_PAD * w);
                f->sizes[at] = (uint16_t)(m < CVOL_NEURAL_LIMIT ? m : CVOL_NEURAL_LIMIT);
                f->classes[at] = (uint8_t)cvol_neural_class(m);
            }
    f->sizes[CVOL_NEURAL_ORIGIN] = f->sizes[CVOL_NEURAL_ORIGIN] < 2 ? f->sizes[CVOL_NEURAL_ORIGIN]
                                                                    : 2;
    f->classes[CVOL_NEURAL_ORIGIN] = (uint8_t)cvol_neural_class(f->sizes[CVOL_NEURAL_ORIGIN]);
}

void cvol_neural_view_sub_block(cvol_neural_view *view, const cvol_neural_brick *brick,
                                const cvol_neural_sub_block *part, int cube)
{
    view_faces(view, brick, part, cube);
    view_sizes(view, brick, part, cube);
}

/* ---- looks ------------------------------------------------------------------------------ */

/* The place of a frequency of a sub-block of side `side` among another sub-block's values. */
static int place_in(const cvol_neural_sub_block *other, int side, int u, int v, int w)
{
    int at[3] = {u, v, w};
    for (int a = 0; a < 3; a++) {
        if (other->side < side)
            at[a] /= side / other->side;
        else if (other->side > side)
            at[a] = at[a] * (other->side / side) + other->side / side / 2;
        at[a] = at[a] < other->n[a] ? at[a] : other->n[a] - 1;
    }
    return at[0] + CVOL_NEURAL_SIDE * at[1] + CVOL_NEURAL_SLICE * at[2];
}

/* The blurred magnitude there. */
static int blur_at(const cvol_neural_brick *b, int number, int side, int u, int v, int w)
{
    if (number == CVOL_NEURAL_NONE)
        return 0;
    const cvol_neural_sub_block *other = &b->part[number];
    return b->blur[other->first + place_in(other, side, u, v, w)];
}

/* The class of the magnitude there; 0 for a DC. */
static int size_at(const cvol_neural_brick *b, int number, int side, int u, int v, int w)
{
    if (number == CVOL_NEURAL_NONE)
        return 0;
    const cvol_neural_sub_block *other = &b->part[number];
    const int place = place_in(other, side, u, v, w);
    return place ? cvol_neural_class(cvol_magnitude(b->known[other->first + place])) : 0;
}

/* Multiplies with wrap-around. */
CVOL_INLINE int32_t product(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a * (uint32_t)b);
}

/* Computes the faces' predictions of the coefficient. */
static void look_at_faces(cvol_neural_context *l, const cvol_neural_view *f,
                          const cvol_neural_sub_block *p)
{
    const int u = l->at[0], v = l->at[1], w = l->at[2];
    uint32_t sum = 0;
    for (int k = 0; k < CVOL_NEURAL_PLANES; k++) {
        const int a = k % 3, n = p->n[a], own = l->at[a];
        const int others = a == 0 ? v + 16 * w : a == 1 ? u + 16 * w : u + 16 * v;
        const int turn = k >= 3 && own & 1 ? -1 : 1;
        const int32_t *wave = cvol_neural_cosines.of[n][own];
        l->level[k] = l->slope[k] = 0;
        if (!f->there[k])
            continue;
        l->level[k] = product(f->level[k][others] >> 8, turn * wave[0]) >> 10;
        if (n > 1)
            l->slope[k] = product(f->slope[k][others] >> 8, turn * (wave[1] - wave[0])) >> 10;
        sum += (uint32_t)l->level[k];
    }
    l->sum = (int32_t)sum;
}

/* Sets inputs 0 to 26 from magnitudes near the coefficient in its sub-block; returns their
 * scattered sum. */
static uint32_t look_near(int16_t *x, const cvol_neural_view *f, int local)
{
    enum { X = 1, Y = CVOL_NEURAL_PAD, Z = CVOL_NEURAL_PAD * CVOL_NEURAL_PAD };
    static const int near[25] = {-X,         -Y,         -Z,         -2 * X,     -2 * Y,
                                 -2 * Z,     -X - Y,     -X - Z,     -Y - Z,     -X - Y - Z,
                                 -3 * X,     -3 * Y,     -3 * Z,     -2 * X - Y, -X - 2 * Y,
                                 -2 * X - Z, -X - 2 * Z, -2 * Y - Z, -Y - 2 * Z, X - Y,
                                 X - Z,      Y - Z,      X - Y - Z,  -X + Y - Z, -X - Y + Z};
    const uint8_t *c = f->classes + local;
    const uint16_t *m = f->sizes + local;
    for (int i = 0; i < 25; i++)
        x[i] = c[near[i]];
    const int turned = (c[X - 2 * Y] + c[-2 * X + Y] + c[X - 2 * Z] + c[-2 * X + Z] + c[Y - 2 * Z] +
                        c[-2 * Y + Z]) /
                       3;
    const int far = (c[-2 * X - Y - Z] + c[-X - 2 * Y - Z] + c[-X - Y - 2 * Z]) / 2;
    x[25] = (int16_t)(turned < 127 ? turned : 127);
    x[26] = (int16_t)(far < 127 ? far : 127);
    return (uint32_t)(2 * (m[-X] + m[-Y] + m[-Z]) + m[-2 * X] + m[-2 * Y] + m[-2 * Z] + m[-X - Y] +
                      m[-X - Z] + m[-Y - Z]);
}

void cvol_neural_context_at(cvol_neural_context *l, const cvol_neural_brick *b,
                            const cvol_neural_view *f, const cvol_neural_sub_block *p,
                            const cvol_neural_position *q)
{
    const int place = p->scan->entries[q->index].place, log2 = 2 + p->size_class;
    const int u = place & (p->side - 1), v = place >> log2 & (p->side - 1), w = place >> 2 * log2;
    int16_t *x = l->x;
    l->at[0] = u, l->at[1] = v, l->at[2] = w;
    const uint32_t scattered = look_near(
        x, f, CVOL_NEURAL_ORIGIN + u + CVOL_NEURAL_PAD * (v + CVOL_NEURAL_PAD * w));
    l->shift = 0;
    while (scattered >> l->shift >= FINEST_SUM)
        l->shift++;
    look_at_faces(l, f, p);
    x[27] = (int16_t)(q->run / 16);
    x[28] = (int16_t)cvol_neural_class(scattered / 4);
    for (int a = 0; a < 3; a++) {
        const int other = p->neighbours[a];
        x[29 + a] = (int16_t)blur_at(b, other, p->side, u, v, w);
        x[32 + a] = (int16_t)blur_at(b, p->neighbours[3 + a], p->side, u / 2, v / 2, w / 2);
        x[43 + a] = (int16_t)(128 * l->at[a] / p->n[a]);
        x[46 + a] = l->at[a] ? 0 : 64;
        x[56 + a] = (int16_t)(other == CVOL_NEURAL_NONE
                                  ? 127
                                  : 32 * (b->part[other].size_class - p->size_class));
    }
    x[35] = (int16_t)(10 * l->shift);
    x[36] = (int16_t)(q->last == p->scan->count
                          ? 127
                          : cvol_neural_class((uint32_t)(q->last - q->index)));
    x[37] = (int16_t)(8 * p->length);
    x[38] = q->index == q->last ? 64 : 0;
    x[CVOL_NEURAL_ODD] = cvol_state_is_odd(q->state) ? 64 : 0;
    x[CVOL_NEURAL_LATE] = q->state >= 4 ? 64 : 0;
    x[41] = p->size_class == 0 ? 64 : 0;
    x[42] = p->size_class == 1 ? 64 : 0;
    for (int k = 0; k < CVOL_NEURAL_PLANES; k++)
        x[49 + k] = (int16_t)cvol_neural_face_class(l->level[k]);
    x[55] = (int16_t)cvol_neural_face_class(l->sum);
    x[59] = (int16_t)(7 * p->around);
    x[60] = b->array->lapped ? 64 : 0;
    x[61] = (int16_t)(32 * q->subband);
    x[62] = p->change;
    x[63] = (int16_t)((x[29] + x[30] + x[31]) / 3);
    int32_t slopes = 0;
    for (int k = 0; k < CVOL_NEURAL_PLANES; k++) {
        x[64 + k] = (int16_t)cvol_neural_face_class(l->slope[k]);
        slopes = (int32_t)((uint32_t)slopes + (uint32_t)l->slope[k]);
    }
    for (int a = 0; a < 3; a++) {
        x[70 + a] = (int16_t)(u | v | w ? size_at(b, p->neighbours[a], p->side, u, v, w) : 0);
        x[73 + a] = (int16_t)blur_at(b, p->across[a], p->side, u, v, w);
    }
    x[76] = f->classes[CVOL_NEURAL_ORIGIN + u / 2 +
                       CVOL_NEURAL_PAD * (v / 2 + CVOL_NEURAL_PAD * (w / 2))];
    x[77] = (int16_t)(b->means[p->size_class][u + 16 * (v + 16 * w)] / 16);
    x[78] = (int16_t)cvol_neural_face_class(slopes);
    x[79] = (int16_t)(q->slow / 64);
}

void cvol_neural_sign_inputs(int16_t x[CVOL_NEURAL_INPUTS], const cvol_neural_brick *b,
                             const cvol_neural_sub_block *p, const cvol_neural_context *l,
                             uint32_t magnitude)
{
    for (int k = 0; k < CVOL_NEURAL_PLANES; k++) {
        const int turn = l->sum < 0 ? -1 : 1;
        x[2 * k] = (int16_t)(turn * cvol_neural_face_signed(l->level[k]));
        x[2 * k + 1] = (int16_t)(turn * cvol_neural_face_signed(l->slope[k]));
    }
    x[12] = (int16_t)cvol_neural_class(magnitude);
    x[13] = l->x[28];
    for (int a = 0; a < 3; a++) {
        x[14 + a] = l->x[43 + a];
        x[17 + a] = l->x[46 + a];
        x[25 + a] = b->array->lapped && p->at[a] % 4 == 0 ? 64 : 0;
        x[28 + a] = b->array->lapped && (p->at[a] + p->side / 4) % 4 == 0 ? 64 : 0;
    }
    x[20] = l->x[41];
    x[21] = l->x[42];
    x[22] = l->x[60];
    x[23] = l->x[61];
    x[24] = l->x[55];
    x[31] = l->x[63];
}
