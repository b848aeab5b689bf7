/* Passes over two spectra and their product.
 *
 * The outer axis is transformed only for lines with coefficients, in batches of neighbouring lines.
 * Then follow, slab by slab of a size that stays within the cache, the middle and the inner axis,
 * both operands, the product and its inverse; then the outer axis of the lines that are kept.
 * Dropped energy is summed where a line stops, by Parseval over the remaining axes, so it is never
 * a difference of large sums. */
#include "array/multiply/passes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"

/* Floats of a batch of lines and of a slab of samples: a few of them fit into 1 MiB of cache. */
#define LINES_FLOATS 16384
#define SLAB_FLOATS 32768
#define SMALL_POINTS 32768

/* ---- units of work --------------------------------------------------------------------------- */

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Starting threads takes longer than a small product. */
static int threads_for(const cvol_context *context, const cvol_passes *work)
{
    return work->m[0] * work->m[1] * work->m[2] < SMALL_POINTS ? 1 : cvol_context_threads(context);
}

/* Columns of a batch along the outer axis; a multiple of a cache line if there are more. */
static size_t batch_columns(const cvol_passes *work, const cvol_slot_box *box)
{
    const size_t fit = LINES_FLOATS / (work->m[2] * work->numbers) / 8 * 8;
    return least(box->low[0], fit > 8 ? fit : 8);
}

static size_t batches_of(const cvol_passes *work, const cvol_slot_box *box)
{
    return (box->low[0] - 1) / batch_columns(work, box) + 1;
}

/* Transforms `count` neighbouring columns of m points, `stride` coefficients apart. An axis of one
 * point is its own transform (prescale_of and parseval handle that). */
static int columns(cvol_context *context, const cvol_passes *work, int forward, size_t m,
                   size_t stride, size_t count, float *data)
{
    const cvol_fft_lines lines = {m, count, stride, 1, stride, 1};
    cvol_fft_kind kind = forward ? CVOL_FFT_COMPLEX_FORWARD : CVOL_FFT_COMPLEX_BACKWARD;
    if (work->transform == CVOL_DCT)
        kind = forward ? CVOL_FFT_DCT : CVOL_FFT_IDCT;
    return m == 1 ? CVOL_OK : cvol_fft_along(context, kind, &lines, data, data);
}

static double sum_squares(const float *values, size_t count)
{
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; i++)
        sum += (double)values[i] * (double)values[i];
    return sum;
}

/* Energy of coefficients of `count` inner frequencies from `begin`. Coefficients of a half complex
 * row count twice unless they are their own mirror; a DCT's frequency 0 counts one half. */
static double row_energy(const cvol_passes *work, const float *row, size_t begin, size_t count)
{
    if (!count)
        return 0;
    const size_t last = begin + count - 1;
    const double first_energy = sum_squares(row, begin == 0 ? work->numbers : 0);
    const double sum = sum_squares(row, work->numbers * count);
    if (work->transform == CVOL_DCT)
        return sum - 0.5 * first_energy;
    return 2 * sum - first_energy -
           sum_squares(row + 2 * (count - 1), last && 2 * last == work->m[0] ? 2 : 0);
}

/* Sum of squares of the coefficients along an axis over that of the points. */
static double parseval(const cvol_passes *work, int axis)
{
    if (work->transform != CVOL_DCT)
        return (double)work->m[axis];
    return work->m[axis] == 1 ? 0.5 : 2 * (double)work->m[axis];
}

/* ---- one operand: slots to points along the outer axis --------------------------------------- */

static double load_scale(const cvol_passes *work)
{
    double scale = 1;
    for (int a = 0; a < 3; a++)
        scale /= sqrt((work->transform == CVOL_DCT ? 2.0 : 1.0) * (double)work->n[a]);
    return scale;
}

static int outer_inverse_batch(const cvol_passes *work, int operand, size_t v, size_t begin,
                               float *batch)
{
    cvol_context quiet = {.threads = 1}; /* a private context: threads share no messages */
    const cvol_slot_box *box = &work->in[operand];
    const size_t count = least(batch_columns(work, box), box->low[0] - begin), e = work->numbers;
    cvol_lines_load(batch, work->m[2], work->slots[operand], box, v, begin, count,
                    load_scale(work));
    int code = columns(&quiet, work, 0, work->m[2], count, count, batch);
    for (size_t z = 0; z < work->m[2] && !code; z++)
        memcpy(work->lines[operand] + e * ((v * work->m[2] + z) * box->low[0] + begin),
               batch + e * z * count, e * count * sizeof *batch);
    return code;
}

static int outer_inverse(cvol_context *context, cvol_passes *work, int operand)
{
    const int threads = threads_for(context, work);
    const cvol_slot_box *box = &work->in[operand];
    const size_t batches = batches_of(work, box), items = box->box[1] * batches;
    const size_t floats = work->numbers * work->m[2] * batch_columns(work, box);
    int code = CVOL_OK;
#pragma omp parallel num_threads(threads)
    {
        float *batch = cvol_fft_allocate(floats);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < items; i++) {
            int failed = batch ? outer_inverse_batch(work, operand, i / batches,
                                                     i % batches * batch_columns(work, box), batch)
                               : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        free(batch);
    }
    return code ? cvol_fail_memory(context, floats * sizeof(float), "a batch of lines") : CVOL_OK;
}

/* ---- a slab: the middle and the inner axis, forward and back --------------------------------- */

/* Evaluates outer places [begin, begin + depth) of an operand, prepared in `half`. */
static int slab_evaluate(cvol_context *context, const cvol_passes *work, int operand, size_t begin,
                         size_t depth, float *samples, float *half)
{
    const cvol_slot_box *box = &work->in[operand];
    const size_t e = work->numbers, plane = work->width * work->m[1], count = box->low[0];
    memset(half, 0, e * depth * plane * sizeof *half);
    int code = CVOL_OK;
    for (size_t z = 0; z < depth && !code; z++) {
        for (size_t v = 0; v < box->box[1]; v++) {
            size_t place = cvol_box_place(v, box->low[1], box->box[1], work->m[1]);
            memcpy(half + e * (z * plane + place * work->width),
                   work->lines[operand] + e * (v * work->m[2] + begin + z) * count,
                   e * count * sizeof *half);
        }
        code = columns(context, work, 0, work->m[1], work->width, count, half + e * z * plane);
    }
    const cvol_fft_lines rows = {work->m[0], depth * work->m[1], 1, work->width, 1, work->row};
    cvol_fft_kind kind = work->transform == CVOL_DCT ? CVOL_FFT_IDCT : CVOL_FFT_INVERSE;
    return code ? code : cvol_fft_along(context, kind, &rows, samples, half);
}

/* a *= b times prescale; returns the largest |a b|. */
static double slab_multiply(const cvol_passes *work, size_t rows, float *a, const float *b)
{
    const float scale = (float)work->prescale;
    double largest = 0;
    for (size_t r = 0; r < rows; r++) {
        float *p = a + r * work->row, most = 0;
        const float *q = b + r * work->row;
#pragma omp simd reduction(max : most)
        for (size_t i = 0; i < work->m[0]; i++) {
            const float product = p[i] * q[i], size = fabsf(product);
            most = size > most ? size : most;
            p[i] = scale * product;
        }
        largest = fmax(largest, (double)most);
    }
    return largest;
}

/* Transforms a slab of products. The kept part goes to lines[2]; *energy is the energy of the
 * rest. */
static int slab_interpolate(cvol_context *context, const cvol_passes *work, size_t begin,
                            size_t depth, float *samples, float *half, double *energy)
{
    const cvol_slot_box *box = &work->out;
    const size_t e = work->numbers, plane = work->width * work->m[1], count = box->low[0];
    const cvol_fft_lines rows = {work->m[0], depth * work->m[1], 1, work->row, 1, work->width};
    int code = cvol_fft_along(context,
                              work->transform == CVOL_DCT ? CVOL_FFT_DCT : CVOL_FFT_FORWARD, &rows,
                              half, samples);
    double beyond_u = 0, beyond_v = 0;
    for (size_t y = 0; y < depth * work->m[1] && !code; y++)
        beyond_u += row_energy(work, half + e * (y * work->width + count), count,
                               work->width - count);
    for (size_t z = 0; z < depth && !code; z++) {
        code = columns(context, work, 1, work->m[1], work->width, count, half + e * z * plane);
        for (size_t place = 0; place < work->m[1] && !code; place++) {
            const float *row = half + e * (z * plane + place * work->width);
            size_t v = cvol_box_index(place, box->low[1], box->box[1], work->m[1]);
            if (v == SIZE_MAX)
                beyond_v += row_energy(work, row, 0, count);
            else
                memcpy(work->lines[2] + e * (v * work->m[2] + begin + z) * count, row,
                       e * count * sizeof *row);
        }
    }
    *energy = parseval(work, 2) * (parseval(work, 1) * beyond_u + beyond_v);
    return code;
}

static int slab_run(const cvol_passes *work, size_t index, float *buffers[3])
{
    cvol_context quiet = {.threads = 1};
    const size_t begin = index * work->depth, depth = least(work->depth, work->m[2] - begin);
    int code = slab_evaluate(&quiet, work, 0, begin, depth, buffers[0], buffers[2]);
    if (!code)
        code = slab_evaluate(&quiet, work, 1, begin, depth, buffers[1], buffers[2]);
    if (code)
        return code;
    work->largest[index] = slab_multiply(work, depth * work->m[1], buffers[0], buffers[1]);
    return slab_interpolate(&quiet, work, begin, depth, buffers[0], buffers[2],
                            &work->energy[index]);
}

static int run_slabs(cvol_context *context, cvol_passes *work, size_t first, size_t end)
{
    const int threads = threads_for(context, work);
    const size_t rows = work->depth * work->m[1];
    const size_t floats[3] = {rows * work->row, rows * work->row,
                              rows * work->width * work->numbers};
    int code = CVOL_OK;
#pragma omp parallel num_threads(threads)
    {
        float *buffers[3];
        for (int i = 0; i < 3; i++)
            buffers[i] = cvol_fft_allocate(floats[i]);
#pragma omp for schedule(dynamic)
        for (size_t i = first; i < end; i++) {
            int failed = buffers[0] && buffers[1] && buffers[2] ? slab_run(work, i, buffers)
                                                                : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        for (int i = 0; i < 3; i++)
            free(buffers[i]);
    }
    return code ? cvol_fail_memory(context, 3 * floats[0] * sizeof(float), "a slab of samples")
                : CVOL_OK;
}

/* ---- the product: points to slots along the outer axis --------------------------------------- */

static int outer_forward_batch(const cvol_passes *work, size_t v, size_t begin, float *batch,
                               double *energy)
{
    cvol_context quiet = {.threads = 1};
    const cvol_slot_box *box = &work->out;
    const size_t count = least(batch_columns(work, box), box->low[0] - begin), e = work->numbers;
    for (size_t z = 0; z < work->m[2]; z++)
        memcpy(batch + e * z * count,
               work->lines[2] + e * ((v * work->m[2] + z) * box->low[0] + begin),
               e * count * sizeof *batch);
    int code = columns(&quiet, work, 1, work->m[2], count, count, batch);
    double sum = 0;
    for (size_t place = 0; place < work->m[2] && !code; place++) {
        const float *line = batch + e * place * count;
        size_t w = cvol_box_index(place, box->low[2], box->box[2], work->m[2]);
        if (w == SIZE_MAX)
            sum += row_energy(work, line, begin, count);
        else
            cvol_lines_store(work->kept, box, line, v, w, begin, count);
    }
    *energy = work->transform == CVOL_DCT && v == 0 ? 0.5 * sum : sum;
    return code;
}

static int outer_forward(cvol_context *context, cvol_passes *work)
{
    const int threads = threads_for(context, work);
    const cvol_slot_box *box = &work->out;
    const size_t batches = batches_of(work, box), items = box->box[1] * batches;
    const size_t floats = work->numbers * work->m[2] * batch_columns(work, box);
    int code = CVOL_OK;
#pragma omp parallel num_threads(threads)
    {
        float *batch = cvol_fft_allocate(floats);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < items; i++) {
            int failed = batch ? outer_forward_batch(work, i / batches,
                                                     i % batches * batch_columns(work, box), batch,
                                                     &work->energy[work->slabs + i])
                               : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        free(batch);
    }
    return code ? cvol_fail_memory(context, floats * sizeof(float), "a batch of lines") : CVOL_OK;
}

/* ---- all of it ---------------------------------------------------------------------------- */

static double prescale_of(const cvol_passes *work)
{
    double scale = 1;
    for (int a = 0; a < 3; a++) {
        const double n = (double)work->n[a], m = (double)work->m[a];
        if (work->transform != CVOL_DCT)
            scale *= sqrt(n) / m;
        else
            scale *= a && work->m[a] == 1 ? sqrt(2 * n) : sqrt(n / 2) / m;
    }
    return scale;
}

int cvol_passes_start(cvol_context *context, cvol_passes *work)
{
    work->numbers = work->transform == CVOL_DCT ? 1 : 2;
    work->width = work->numbers == 2 ? work->m[0] / 2 + 1 : work->m[0];
    work->row = work->numbers * work->width;
    const size_t plane = work->row * work->m[1];
    work->depth = least(work->m[2], SLAB_FLOATS / plane > 1 ? SLAB_FLOATS / plane : 1);
    work->slabs = (work->m[2] - 1) / work->depth + 1;
    work->prescale = prescale_of(work);
    work->all_points = !memcmp(work->n, work->m, sizeof work->n);
    work->energies = work->slabs + work->out.box[1] * batches_of(work, &work->out);
    const cvol_slot_box *boxes[3] = {&work->in[0], &work->in[1], &work->out};
    size_t bytes = 0;
    for (int i = 0; i < 3; i++) {
        size_t count = boxes[i]->box[1] * work->m[2] * boxes[i]->low[0] * work->numbers;
        bytes += count * sizeof(float);
        work->lines[i] = cvol_fft_allocate(count);
    }
    work->kept = cvol_fft_allocate(cvol_slot_box_count(&work->out));
    work->energy = cvol_allocate_zero(work->energies, sizeof *work->energy);
    work->largest = cvol_allocate_zero(work->slabs, sizeof *work->largest);
    if (!work->lines[0] || !work->lines[1] || !work->lines[2] || !work->kept || !work->energy ||
        !work->largest)
        return cvol_fail_memory(context, bytes, "the lines of a product");
    return CVOL_OK;
}

int cvol_passes_run(cvol_context *context, cvol_passes *work)
{
    int code = outer_inverse(context, work, 0);
    if (!code)
        code = outer_inverse(context, work, 1);
    const size_t stride = work->slabs / 8 + 1;
    for (size_t i = 0; i < work->slabs && !code; i += stride) {
        code = cvol_report_progress(context, "multiplying",
                                    0.2 + 0.6 * (double)i / (double)work->slabs);
        if (!code)
            code = run_slabs(context, work, i, least(i + stride, work->slabs));
    }
    return code ? code : outer_forward(context, work);
}

void cvol_passes_free(cvol_passes *work)
{
    for (int i = 0; i < 3; i++)
        free(work->lines[i]);
    free(work->owned[0]);
    free(work->owned[1]);
    free(work->kept);
    free(work->energy);
    free(work->largest);
}
