/* The interface to fast transforms: checks of arguments, and the jobs of a backend (fft_backend.h).
 */
#include "transform/fft.h"

#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/fft_backend.h"

static int is_half(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_FORWARD || kind == CVOL_FFT_INVERSE;
}

/* 1 if the sizes of the buffers in bytes do not overflow. */
static int check_size(cvol_context *context, const size_t dims[3])
{
    size_t count, bytes;
    if (cvol_size_multiply(&count, dims[0] / 2 + 1, dims[1]) &&
        cvol_size_multiply(&count, count, dims[2]) &&
        cvol_size_multiply(&bytes, count, 4 * sizeof(float)) && bytes <= (size_t)PTRDIFF_MAX)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_LIMIT, "a transform of %zu x %zu x %zu is too large",
                     dims[0], dims[1], dims[2]);
}

int cvol_fft(cvol_context *context, cvol_fft_kind kind, const size_t dims[3], float *out, float *in)
{
    int code = check_size(context, dims);
    if (code)
        return code;
    if (!dims[0] || !dims[1] || !dims[2])
        return CVOL_OK;
    cvol_fft_job job;
    memset(&job, 0, sizeof job);
    job.kind = (int)kind;
    job.lines.n = 1;
    const size_t half = dims[0] / 2 + 1;
    const size_t in_row = kind == CVOL_FFT_INVERSE ? half : dims[0];
    const size_t out_row = kind == CVOL_FFT_FORWARD ? half : dims[0];
    const size_t in_stride[3] = {1, in_row, in_row * dims[1]};
    const size_t out_stride[3] = {1, out_row, out_row * dims[1]};
    for (int a = 0; a < 3; a++)
        if (dims[a] > 1 || (a == 0 && is_half(kind)))
            job.axes[job.rank++] = (cvol_fft_axis){dims[a], in_stride[a], out_stride[a]};
    if (!job.rank) { /* one number, or one pair of them */
        size_t numbers = kind >= CVOL_FFT_COMPLEX_FORWARD ? 2 : 1;
        memmove(out, in, numbers * sizeof *out);
        return CVOL_OK;
    }
    return cvol_fft_execute(context, &job, out, in);
}

int cvol_fft_along(cvol_context *context, cvol_fft_kind kind, const cvol_fft_lines *lines,
                   float *out, float *in)
{
    const size_t shape[3] = {lines->n, lines->count, 1};
    int code = check_size(context, shape);
    if (code || !lines->n || !lines->count)
        return code;
    cvol_fft_job job;
    memset(&job, 0, sizeof job);
    job.kind = (int)kind;
    job.rank = 1;
    job.axes[0] = (cvol_fft_axis){lines->n, lines->in_stride, lines->out_stride};
    job.lines = (cvol_fft_axis){lines->count, lines->in_distance, lines->out_distance};
    return cvol_fft_execute(context, &job, out, in);
}

static int is_good(size_t n)
{
    while (n % 2 == 0)
        n /= 2;
    while (n % 3 == 0)
        n /= 3;
    while (n % 5 == 0)
        n /= 5;
    return n == 1 || n == 7;
}

size_t cvol_fft_good_length(size_t n, int even)
{
    n = n ? n : 1;
    if (even)
        n += n % 2;
    while (!is_good(n))
        n += even ? 2 : 1;
    return n;
}

float *cvol_fft_allocate(size_t count)
{
    return cvol_allocate(count, sizeof(float));
}
