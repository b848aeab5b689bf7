/* The door to FFTW 3 (Frigo and Johnson 2005), single precision, and the plans behind it.
 *
 * A plan belongs to a kind, a shape, strides, the alignment of its buffers and whether they are
 * one: the key. Plans are made and destroyed behind one lock, as FFTW demands, and executed outside
 * it on whatever buffers have the key's alignment. A plan in use is never destroyed: where the
 * cache is full of them, a plan lives for one execution alone.
 */
#include "transform/fft.h"

#include <fftw3.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

#define MOST_PLANS 256

/* Compared as bytes: to be zeroed before it is filled. */
typedef struct plan_key {
    fftwf_iodim64 axes[3], lines; /* axes slowest first, as FFTW wants them */
    int rank, many;               /* many: whether there are lines */
    int kind, in_place, in_alignment, out_alignment;
} plan_key;

typedef struct plan_entry {
    plan_key key;
    fftwf_plan plan;
    size_t users;       /* executions under way */
    uint64_t last_used; /* when, counted in calls */
} plan_entry;

static pthread_mutex_t cache_lock = PTHREAD_MUTEX_INITIALIZER;
static plan_entry *cache[MOST_PLANS];
static size_t cache_count;
static uint64_t cache_calls;
static pthread_once_t fork_once = PTHREAD_ONCE_INIT;

static void lock_cache(void)
{
    pthread_mutex_lock(&cache_lock);
}

static void unlock_cache(void)
{
    pthread_mutex_unlock(&cache_lock);
}

/* A child of fork must not find the lock taken, by a thread that it does not have. */
static void register_locks(void)
{
    (void)pthread_atfork(lock_cache, unlock_cache, unlock_cache);
}

/* ---- plans ------------------------------------------------------------------------------- */

/* The number that FFTW gives a real to real kind. */
static fftwf_r2r_kind real_kind(int kind)
{
    return kind == CVOL_FFT_DCT    ? FFTW_REDFT10
           : kind == CVOL_FFT_IDCT ? FFTW_REDFT01
                                   : FFTW_RODFT01;
}

/* Plans by estimate: buffers are not touched. */
static fftwf_plan make_plan(const plan_key *key, float *out, float *in)
{
    fftwf_complex *complex_in = (fftwf_complex *)in, *complex_out = (fftwf_complex *)out;
    const fftwf_r2r_kind real = real_kind(key->kind);
    const fftwf_r2r_kind kinds[3] = {real, real, real};
    switch ((cvol_fft_kind)key->kind) {
    case CVOL_FFT_FORWARD:
        return fftwf_plan_guru64_dft_r2c(key->rank, key->axes, key->many, &key->lines, in,
                                         complex_out, FFTW_ESTIMATE);
    case CVOL_FFT_INVERSE:
        return fftwf_plan_guru64_dft_c2r(key->rank, key->axes, key->many, &key->lines, complex_in,
                                         out, FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
    case CVOL_FFT_COMPLEX_FORWARD:
    case CVOL_FFT_COMPLEX_BACKWARD:
        return fftwf_plan_guru64_dft(
            key->rank, key->axes, key->many, &key->lines, complex_in, complex_out,
            key->kind == CVOL_FFT_COMPLEX_FORWARD ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
    default:
        return fftwf_plan_guru64_r2r(key->rank, key->axes, key->many, &key->lines, in, out, kinds,
                                     FFTW_ESTIMATE);
    }
}

static void execute_plan(const plan_entry *entry, float *out, float *in)
{
    switch ((cvol_fft_kind)entry->key.kind) {
    case CVOL_FFT_FORWARD:
        fftwf_execute_dft_r2c(entry->plan, in, (fftwf_complex *)out);
        break;
    case CVOL_FFT_INVERSE:
        fftwf_execute_dft_c2r(entry->plan, (fftwf_complex *)in, out);
        break;
    case CVOL_FFT_COMPLEX_FORWARD:
    case CVOL_FFT_COMPLEX_BACKWARD:
        fftwf_execute_dft(entry->plan, (fftwf_complex *)in, (fftwf_complex *)out);
        break;
    default:
        fftwf_execute_r2r(entry->plan, in, out);
    }
}

/* ---- the cache, all under the lock --------------------------------------------------------- */

static plan_entry *find_plan(const plan_key *key)
{
    for (size_t i = 0; i < cache_count; i++)
        if (!memcmp(&cache[i]->key, key, sizeof *key))
            return cache[i];
    return NULL;
}

static void destroy_entry(plan_entry *entry)
{
    fftwf_destroy_plan(entry->plan);
    free(entry);
}

/* Puts an entry into the cache, in the place of the one that rested longest if there is no other;
 * 0 if all are in use. */
static int keep_plan(plan_entry *entry)
{
    size_t at = cache_count;
    if (cache_count < MOST_PLANS) {
        cache_count++;
    } else {
        for (size_t i = 0; i < cache_count; i++)
            if (!cache[i]->users &&
                (at == cache_count || cache[i]->last_used < cache[at]->last_used))
                at = i;
        if (at == cache_count)
            return 0;
        destroy_entry(cache[at]);
    }
    cache[at] = entry;
    return 1;
}

/* FFTW ends the process where it has no memory: what a plan takes is asked for before. */
enum { PLAN_BYTES = 4 << 20, PLAN_BYTES_A_POINT = 64 };

static int has_memory_for_plan(const plan_key *key)
{
    size_t points = (size_t)key->lines.n;
    for (int a = 0; a < key->rank; a++)
        points += (size_t)key->axes[a].n;
    void *memory = malloc(PLAN_BYTES + PLAN_BYTES_A_POINT * points);
    const int has = memory != NULL;
    free(memory);
    return has;
}

/* The key's entry, counted as in use; NULL without memory or where FFTW has no plan. */
static plan_entry *acquire_plan(const plan_key *key, float *out, float *in, int *cached)
{
    *cached = 1;
    plan_entry *entry = find_plan(key);
    if (!entry) {
        entry = has_memory_for_plan(key) ? calloc(1, sizeof *entry) : NULL;
        if (!entry)
            return NULL;
        memcpy(&entry->key, key, sizeof *key);
        entry->plan = make_plan(key, out, in);
        if (!entry->plan) {
            free(entry);
            return NULL;
        }
        *cached = keep_plan(entry);
    }
    entry->users++;
    entry->last_used = ++cache_calls;
    return entry;
}

static int run(cvol_context *context, plan_key *key, cvol_fft_kind kind, float *out, float *in)
{
    key->kind = (int)kind;
    key->in_place = in == out;
    key->in_alignment = fftwf_alignment_of(in);
    key->out_alignment = fftwf_alignment_of(out);
    int cached;
    pthread_once(&fork_once, register_locks);
    lock_cache();
    plan_entry *entry = acquire_plan(key, out, in, &cached);
    unlock_cache();
    if (!entry)
        return cvol_fail(context, CVOL_ERROR_MEMORY, "no plan for a transform of %td x %td x %td",
                         key->axes[0].n, key->axes[1].n, key->axes[2].n);
    execute_plan(entry, out, in);
    lock_cache();
    entry->users--;
    if (!cached)
        destroy_entry(entry);
    unlock_cache();
    return CVOL_OK;
}

/* ---- the door -------------------------------------------------------------------------- */

static int is_half(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_FORWARD || kind == CVOL_FFT_INVERSE;
}

/* Whether the buffers' bytes can be counted at all. */
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
    plan_key key;
    memset(&key, 0, sizeof key);
    const size_t half = dims[0] / 2 + 1;
    const size_t in_row = kind == CVOL_FFT_INVERSE ? half : dims[0];
    const size_t out_row = kind == CVOL_FFT_FORWARD ? half : dims[0];
    const size_t in_stride[3] = {1, in_row, in_row * dims[1]};
    const size_t out_stride[3] = {1, out_row, out_row * dims[1]};
    for (int a = 2; a >= 0; a--)
        if (dims[a] > 1 || (a == 0 && is_half(kind)))
            key.axes[key.rank++] = (fftwf_iodim64){.n = (ptrdiff_t)dims[a],
                                                   .is = (ptrdiff_t)in_stride[a],
                                                   .os = (ptrdiff_t)out_stride[a]};
    if (!dims[0] || !dims[1] || !dims[2])
        return CVOL_OK;
    if (!key.rank) { /* one number, or one pair of them */
        size_t numbers = kind >= CVOL_FFT_COMPLEX_FORWARD ? 2 : 1;
        memmove(out, in, numbers * sizeof *out);
        return CVOL_OK;
    }
    return run(context, &key, kind, out, in);
}

int cvol_fft_along(cvol_context *context, cvol_fft_kind kind, const cvol_fft_lines *lines,
                   float *out, float *in)
{
    const size_t shape[3] = {lines->n, lines->count, 1};
    int code = check_size(context, shape);
    if (code || !lines->n || !lines->count)
        return code;
    plan_key key;
    memset(&key, 0, sizeof key);
    key.rank = key.many = 1;
    key.axes[0] = (fftwf_iodim64){.n = (ptrdiff_t)lines->n,
                                  .is = (ptrdiff_t)lines->in_stride,
                                  .os = (ptrdiff_t)lines->out_stride};
    key.lines = (fftwf_iodim64){.n = (ptrdiff_t)lines->count,
                                .is = (ptrdiff_t)lines->in_distance,
                                .os = (ptrdiff_t)lines->out_distance};
    return run(context, &key, kind, out, in);
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
