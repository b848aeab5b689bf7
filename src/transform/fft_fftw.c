/* FFTW 3 (Frigo and Johnson 2005), single precision, as the backend of fft.h: -DCVOL_FFT=fftw.
 *
 * FFTW is under the GNU General Public License, and so is a program that is linked with it.
 *
 * The key of a plan is its job, the alignment of its buffers, and whether they are the same buffer.
 * FFTW estimates plans, so that results have the same bits in every run. A plan can run on all
 * buffers with the key's alignment.
 */
#include <fftw3.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "transform/fft.h"
#include "transform/fft_backend.h"
#include "transform/fft_cache.h"

/* Compared as bytes: to be zeroed before it is filled. */
typedef struct plan_key {
    cvol_fft_job job;
    int in_place, in_alignment, out_alignment;
} plan_key;

typedef struct buffers {
    float *out, *in;
} buffers;

/* ---- plans ---------------------------------------------------------------------------------- */

/* FFTW's number of a real to real kind. */
static fftwf_r2r_kind real_kind(int kind)
{
    return kind == CVOL_FFT_DCT    ? FFTW_REDFT10
           : kind == CVOL_FFT_IDCT ? FFTW_REDFT01
                                   : FFTW_RODFT01;
}

static fftwf_iodim64 axis_of(const cvol_fft_axis *axis)
{
    return (fftwf_iodim64){.n = (ptrdiff_t)axis->n,
                           .is = (ptrdiff_t)axis->in_stride,
                           .os = (ptrdiff_t)axis->out_stride};
}

/* Plans by estimate: buffers are not touched. */
static fftwf_plan make_plan(const cvol_fft_job *job, float *out, float *in)
{
    fftwf_complex *complex_in = (fftwf_complex *)in, *complex_out = (fftwf_complex *)out;
    const fftwf_r2r_kind real = real_kind(job->kind);
    const fftwf_r2r_kind kinds[3] = {real, real, real};
    const fftwf_iodim64 lines = axis_of(&job->lines);
    const int many = job->lines.n > 1;
    fftwf_iodim64 axes[3]; /* slowest first, as FFTW wants them */
    for (int a = 0; a < job->rank; a++)
        axes[a] = axis_of(&job->axes[job->rank - 1 - a]);
    switch ((cvol_fft_kind)job->kind) {
    case CVOL_FFT_FORWARD:
        return fftwf_plan_guru64_dft_r2c(job->rank, axes, many, &lines, in, complex_out,
                                         FFTW_ESTIMATE);
    case CVOL_FFT_INVERSE:
        return fftwf_plan_guru64_dft_c2r(job->rank, axes, many, &lines, complex_in, out,
                                         FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
    case CVOL_FFT_COMPLEX_FORWARD:
    case CVOL_FFT_COMPLEX_BACKWARD:
        return fftwf_plan_guru64_dft(
            job->rank, axes, many, &lines, complex_in, complex_out,
            job->kind == CVOL_FFT_COMPLEX_FORWARD ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
    default:
        return fftwf_plan_guru64_r2r(job->rank, axes, many, &lines, in, out, kinds, FFTW_ESTIMATE);
    }
}

/* FFTW ends the process without memory: a plan's memory is allocated and freed before, as a
 * test. */
enum { PLAN_BYTES = 4 << 20, PLAN_BYTES_PER_POINT = 64 };

static int has_memory_for_plan(const cvol_fft_job *job)
{
    size_t points = job->lines.n;
    for (int a = 0; a < job->rank; a++)
        points += job->axes[a].n;
    void *memory = malloc(PLAN_BYTES + PLAN_BYTES_PER_POINT * points);
    const int has = memory != NULL;
    free(memory);
    return has;
}

static void *create_plan(const void *bytes, void *user)
{
    const plan_key *key = bytes;
    const buffers *of = user;
    return has_memory_for_plan(&key->job) ? make_plan(&key->job, of->out, of->in) : NULL;
}

static void destroy_plan(void *plan)
{
    fftwf_destroy_plan(plan);
}

/* FFTW has no number for it. */
static size_t plan_bytes(const void *plan)
{
    (void)plan;
    return 0;
}

static void execute_plan(fftwf_plan plan, int kind, float *out, float *in)
{
    switch ((cvol_fft_kind)kind) {
    case CVOL_FFT_FORWARD:
        fftwf_execute_dft_r2c(plan, in, (fftwf_complex *)out);
        break;
    case CVOL_FFT_INVERSE:
        fftwf_execute_dft_c2r(plan, (fftwf_complex *)in, out);
        break;
    case CVOL_FFT_COMPLEX_FORWARD:
    case CVOL_FFT_COMPLEX_BACKWARD:
        fftwf_execute_dft(plan, (fftwf_complex *)in, (fftwf_complex *)out);
        break;
    default:
        fftwf_execute_r2r(plan, in, out);
    }
}

/* ---- the backend ---------------------------------------------------------------------------- */

int cvol_fft_execute(cvol_context *context, const cvol_fft_job *job, float *out, float *in)
{
    static const cvol_fft_maker maker = {sizeof(plan_key), create_plan, destroy_plan, plan_bytes};
    plan_key key;
    memset(&key, 0, sizeof key);
    memcpy(&key.job, job, sizeof *job);
    key.in_place = in == out;
    key.in_alignment = fftwf_alignment_of(in);
    key.out_alignment = fftwf_alignment_of(out);
    buffers of = {out, in};
    const cvol_fft_lease lease = cvol_fft_cache_acquire(&maker, &key, &of);
    if (!lease.entry)
        return cvol_fail(context, CVOL_ERROR_MEMORY, "no plan for a transform of %zu x %zu x %zu",
                         job->axes[0].n, job->axes[1].n, job->axes[2].n);
    execute_plan(lease.plan, job->kind, out, in);
    cvol_fft_cache_release(&lease, 0);
    return CVOL_OK;
}

const char *cvol_fft_backend_name(void)
{
    return "fftw";
}
