/* Conversion between slots and lines of coefficients. The two slots of a pair, as in
 * transform/whole.h:
 *     DFT  slot[p] = sqrt 2 Re F[p], slot[-p] = sqrt 2 Im F[p]   p the first of the pair
 *     DHT  slot[p] = Re F[p] - Im F[p] */
#include "array/multiply/lines.h"

#include <math.h>
#include <string.h>

#include "transform/whole.h"

cvol_slot_box cvol_slot_box_of(cvol_transform transform, const size_t n[3], const size_t low[3])
{
    cvol_slot_box out = {.transform = transform};
    for (int a = 0; a < 3; a++) {
        const size_t most = transform == CVOL_DCT ? n[a] : n[a] / 2 + 1;
        out.n[a] = n[a];
        out.low[a] = low[a] < 1 ? 1 : low[a] < most ? low[a] : most;
        out.box[a] = out.low[a];
        if (transform != CVOL_DCT)
            out.box[a] = 2 * out.low[a] - 1 < n[a] ? 2 * out.low[a] - 1 : n[a];
    }
    return out;
}

/* +1, -1, 0 as cvol_place_order, of a place whose u is its own mirror; v and w are box indices. */
static int order_beyond_u(const cvol_slot_box *box, size_t v, size_t w)
{
    const size_t place[3] = {0, cvol_box_place(v, box->low[1], box->box[1], box->n[1]),
                             cvol_box_place(w, box->low[2], box->box[2], box->n[2])};
    return cvol_place_order(place, box->n);
}

static size_t row_of(const cvol_slot_box *box, size_t v, size_t w)
{
    return box->box[0] * (v + box->box[1] * w);
}

static size_t mirror_row_of(const cvol_slot_box *box, size_t v, size_t w)
{
    return row_of(box, cvol_mirror_index(v, box->box[1]), cvol_mirror_index(w, box->box[2]));
}

/* ---- DFT and DHT ----------------------------------------------------------------------------- */

static void load_own_mirror(float *out, cvol_transform transform, float here, float there,
                            int order, float scale)
{
    const float half = scale * (float)sqrt(0.5);
    if (transform == CVOL_DHT) {
        out[0] = 0.5F * scale * (here + there);
        out[1] = 0.5F * scale * (there - here);
    } else {
        out[0] = order > 0 ? half * here : order < 0 ? half * there : scale * here;
        out[1] = order > 0 ? half * there : order < 0 ? -half * here : 0;
    }
}

static void load_complex_row(float *out, const float *row, const float *mirror,
                             const cvol_slot_box *box, int order, size_t begin, size_t count,
                             float scale)
{
    const size_t n = box->n[0], width = box->box[0];
    size_t u = begin;
    if (u == 0)
        load_own_mirror(out, box->transform, row[0], mirror[0], order, scale);
    u += u == 0;
    size_t end = begin + count;
    const int nyquist = end > begin && 2 * (end - 1) == n && end - 1 > 0;
    end -= nyquist ? 1 : 0;
    const float half = scale * (float)sqrt(0.5), quarter = 0.5F * scale;
    if (box->transform == CVOL_DFT)
        for (; u < end; u++) {
            out[2 * (u - begin)] = half * row[u];
            out[2 * (u - begin) + 1] = half * mirror[width - u];
        }
    else
        for (; u < end; u++) {
            out[2 * (u - begin)] = quarter * (row[u] + mirror[width - u]);
            out[2 * (u - begin) + 1] = quarter * (mirror[width - u] - row[u]);
        }
    if (nyquist)
        load_own_mirror(out + 2 * (end - begin), box->transform, row[end], mirror[end], order,
                        scale);
}

static void store_own_mirror(float *here, float *there, cvol_transform transform, const float *in,
                             int order)
{
    const float root = (float)sqrt(2.0);
    if (order < 0)
        return;
    if (order == 0) {
        *here = in[0];
    } else if (transform == CVOL_DFT) {
        *here = root * in[0];
        *there = root * in[1];
    } else {
        *here = in[0] - in[1];
        *there = in[0] + in[1];
    }
}

static void store_complex_row(float *row, float *mirror, const cvol_slot_box *box, int order,
                              const float *in, size_t begin, size_t count)
{
    const size_t n = box->n[0], width = box->box[0];
    const float root = (float)sqrt(2.0);
    for (size_t u = begin; u < begin + count; u++, in += 2) {
        if (u == 0 || 2 * u == n) {
            store_own_mirror(row + u, mirror + u, box->transform, in, order);
        } else if (box->transform == CVOL_DFT) {
            row[u] = root * in[0];
            mirror[width - u] = root * in[1];
        } else {
            row[u] = in[0] - in[1];
            mirror[width - u] = in[0] + in[1];
        }
    }
}

/* ---- all three ------------------------------------------------------------------------------- */

void cvol_lines_load(float *lines, size_t points, const float *slots, const cvol_slot_box *box,
                     size_t v, size_t begin, size_t count, double scale)
{
    const size_t numbers = box->transform == CVOL_DCT ? count : 2 * count;
    /* the gap between the frequencies from 0 upwards and the negative ones */
    const size_t negative = box->box[2] - box->low[2];
    memset(lines + box->low[2] * numbers, 0,
           (points - box->low[2] - negative) * numbers * sizeof *lines);
    for (size_t w = 0; w < box->box[2]; w++) {
        float *out = lines + numbers * cvol_box_place(w, box->low[2], box->box[2], points);
        const float *row = slots + row_of(box, v, w);
        if (box->transform != CVOL_DCT) {
            load_complex_row(out, row, slots + mirror_row_of(box, v, w), box,
                             order_beyond_u(box, v, w), begin, count, (float)scale);
            continue;
        }
        const float factor = (float)(scale * (v ? 1 : sqrt(2.0)) * (w ? 1 : sqrt(2.0)));
        for (size_t i = 0; i < count; i++)
            out[i] = factor * row[begin + i];
        if (begin == 0)
            out[0] *= (float)sqrt(2.0);
    }
}

void cvol_lines_store(float *slots, const cvol_slot_box *box, const float *line, size_t v, size_t w,
                      size_t begin, size_t count)
{
    float *row = slots + row_of(box, v, w);
    if (box->transform != CVOL_DCT) {
        store_complex_row(row, slots + mirror_row_of(box, v, w), box, order_beyond_u(box, v, w),
                          line, begin, count);
        return;
    }
    const float factor = (float)((v ? 1 : sqrt(0.5)) * (w ? 1 : sqrt(0.5)));
    for (size_t i = 0; i < count; i++)
        row[begin + i] = factor * line[i];
    if (begin == 0)
        row[0] *= (float)sqrt(0.5);
}
