/* The default backend of fft.h: lists the lines of an array along each axis, and decides if they
 * are transformed in batches of 16 or one after the other (fft_own.h). */
#include "transform/fft_own.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"
#include "transform/fft_backend.h"
#include "transform/fft_cache.h"

/* Fewer lines than these are transformed one after the other, and also lines so long that a batch
 * of them exceeds the cache. The limit is higher if the elements of a line are not adjacent. */
enum { MIN_LINES = 4, MAX_ROW = 4096, MAX_COLUMN = 65536 };

/* ---- plans ---------------------------------------------------------------------------------- */

/* Compared as bytes: to be zeroed before it is filled. */
typedef struct plan_key {
    size_t n;
    int real, cosine, line;
} plan_key;

typedef struct plan {
    size_t n;
    cvol_fft_passes *passes; /* of batches */
    cvol_fft_line *line;     /* of single lines, else */
    float *cosines;
    size_t scratch; /* floats */
} plan;

static void destroy_plan(void *user)
{
    plan *of = user;
    cvol_fft_passes_free(of->passes);
    cvol_fft_line_free(of->line);
    free(of->cosines);
    free(of);
}

static void *create_plan(const void *key_bytes, void *user)
{
    (void)user;
    const plan_key *key = key_bytes;
    plan *of = calloc(1, sizeof *of);
    if (!of)
        return NULL;
    of->n = key->n;
    if (key->line)
        of->line = cvol_fft_line_create(key->n, key->real);
    else
        of->passes = cvol_fft_passes_create(key->n);
    if (key->cosine)
        of->cosines = cvol_fft_allocate(2 * (key->n / 2 + 1));
    for (size_t k = 0; of->cosines && 2 * k <= key->n; k++)
        cvol_fft_root(of->cosines + 2 * k, k, 4 * key->n);
    if ((!of->line && !of->passes) || (!of->cosines && key->cosine)) {
        destroy_plan(of);
        return NULL;
    }
    of->scratch = of->passes    ? cvol_fft_passes_scratch(of->passes)
                  : key->cosine ? cvol_fft_cosine_line_scratch(of->line, of->n)
                                : cvol_fft_line_scratch(of->line);
    return of;
}

static size_t plan_bytes(const void *user)
{
    const plan *of = user;
    return sizeof *of + (of->cosines ? 2 * (of->n / 2 + 1) * sizeof(float) : 0) +
           (of->line ? cvol_fft_line_bytes(of->line) : cvol_fft_passes_bytes(of->passes));
}

/* ---- lines of an array ---------------------------------------------------------------------- */

/* Lines along one axis: count[0] count[1] count[2] of them, with these distances, in floats. */
typedef struct line_set {
    cvol_fft_kind kind;
    cvol_fft_axis axis;
    size_t count[3], in_distance[3], out_distance[3];
    size_t in_width, out_width; /* floats of an element */
} line_set;

static int is_real(cvol_fft_kind kind)
{
    return kind < CVOL_FFT_COMPLEX_FORWARD;
}

static int is_cosine(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_DCT || kind == CVOL_FFT_IDCT || kind == CVOL_FFT_IDST;
}

static size_t in_width(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_FORWARD || is_cosine(kind) ? 1 : 2;
}

static size_t out_width(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_INVERSE || is_cosine(kind) ? 1 : 2;
}

static size_t line_count(const line_set *set)
{
    return set->count[0] * set->count[1] * set->count[2];
}

/* The place of line i. */
static size_t place_of(const line_set *set, const size_t distance[3], size_t i)
{
    const size_t first = i % set->count[0], rest = i / set->count[0];
    return first * distance[0] + rest % set->count[1] * distance[1] +
           rest / set->count[1] * distance[2];
}

/* Adds the lines at `count` places; joins them with the last ones if these end there. */
static void add_lines(line_set *set, int *dimensions, size_t count, size_t in_stride,
                      size_t out_stride)
{
    const int last = *dimensions - 1;
    if (count == 1)
        return;
    if (last >= 0 && in_stride == set->count[last] * set->in_distance[last] &&
        out_stride == set->count[last] * set->out_distance[last]) {
        set->count[last] *= count;
        return;
    }
    set->count[*dimensions] = count;
    set->in_distance[*dimensions] = in_stride;
    set->out_distance[*dimensions] = out_stride;
    (*dimensions)++;
}

/* 1 if lines begin at adjacent elements on both sides. */
static int are_columns(const line_set *set)
{
    return set->count[0] >= CVOL_FFT_LINES && set->in_distance[0] == set->in_width &&
           set->out_distance[0] == set->out_width;
}

static int are_single(const line_set *set)
{
    const size_t n = set->axis.n;
    return n >= CVOL_FFT_MIN_LINE &&
           (line_count(set) < MIN_LINES || n > MAX_COLUMN || (n > MAX_ROW && !are_columns(set)));
}

/* ---- batches -------------------------------------------------------------------------------- */

/* The side of `lines` lines from line `first`: most batches have lines at equal distances. */
static cvol_fft_side side_of(const line_set *set, int written, size_t first, int lines)
{
    const size_t *distance = written ? set->out_distance : set->in_distance;
    const size_t width = written ? set->out_width : set->in_width;
    const int even = first % set->count[0] + (size_t)lines <= set->count[0];
    cvol_fft_side side = {.stride = written ? set->axis.out_stride : set->axis.in_stride};
    side.at[0] = place_of(set, distance, first);
    for (int l = 1; l < lines; l++)
        side.at[l] = even ? side.at[l - 1] + distance[0]
                          : place_of(set, distance, first + (size_t)l);
    side.access = even && lines > 1 && distance[0] == width ? CVOL_FFT_COLUMNS
                  : side.stride == width                    ? CVOL_FFT_ROWS
                                                            : CVOL_FFT_SCATTERED;
    return side;
}

/* The number of lines of the batch that begins with line i: in rows of many adjacent lines, a batch
 * ends with its row. */
static int lines_from(const line_set *set, size_t i)
{
    size_t left = line_count(set) - i;
    if (set->count[0] >= CVOL_FFT_LINES && set->count[0] - i % set->count[0] < left)
        left = set->count[0] - i % set->count[0];
    return (int)(left < CVOL_FFT_LINES ? left : CVOL_FFT_LINES);
}

static void run_batches(const plan *of, const line_set *set, float *out, const float *in,
                        float *scratch)
{
    const size_t count = line_count(set);
    for (size_t i = 0; i < count;) {
        cvol_fft_batch batch = {.passes = of->passes,
                                .cosines = of->cosines,
                                .kind = set->kind,
                                .lines = lines_from(set, i),
                                .in = in,
                                .out = out};
        batch.from = side_of(set, 0, i, batch.lines);
        batch.to = side_of(set, 1, i, batch.lines);
        CVOL_SIMD_CHOOSE(cvol_fft_run_batch)(&batch, scratch);
        i += (size_t)batch.lines;
    }
}

/* ---- single lines --------------------------------------------------------------------------- */

static void copy_line(float *out, size_t out_stride, const float *in, size_t in_stride, size_t n,
                      size_t width)
{
    for (size_t i = 0; i < n; i++)
        for (size_t p = 0; p < width; p++)
            out[i * out_stride + p] = in[i * in_stride + p];
}

static size_t in_elements(const line_set *set)
{
    return set->kind == CVOL_FFT_INVERSE ? set->axis.n / 2 + 1 : set->axis.n;
}

static size_t out_elements(const line_set *set)
{
    return set->kind == CVOL_FFT_FORWARD ? set->axis.n / 2 + 1 : set->axis.n;
}

/* Tests if elements are not adjacent, so that a line is copied. */
static int is_spread(const line_set *set, int written)
{
    return written ? set->axis.out_stride != set->out_width : set->axis.in_stride != set->in_width;
}

/* Floats of a copy of a line. */
static size_t copy_floats(const line_set *set)
{
    return 2 * set->axis.n + 2;
}

/* Copies are stored behind the scratch of the plan. */
static void run_single(const plan *of, const line_set *set, float *out, const float *in,
                       float *scratch)
{
    float *read = scratch + of->scratch, *written = read + copy_floats(set);
    const int copy_in = is_spread(set, 0), copy_out = is_spread(set, 1);
    const float *from = copy_in ? read : in;
    float *to = copy_out ? written : out;
    if (copy_in)
        copy_line(read, set->in_width, in, set->axis.in_stride, in_elements(set), set->in_width);
    if (is_cosine(set->kind))
        cvol_fft_cosine_line_run(of->line, of->cosines, set->kind, of->n, to, from, scratch);
    else
        cvol_fft_line_run(of->line, set->kind, to, from, scratch);
    if (copy_out)
        copy_line(out, set->axis.out_stride, written, set->out_width, out_elements(set),
                  set->out_width);
}

static void run_singles(const plan *of, const line_set *set, float *out, const float *in,
                        float *scratch)
{
    for (size_t i = 0; i < line_count(set); i++)
        run_single(of, set, out + place_of(set, set->out_distance, i),
                   in + place_of(set, set->in_distance, i), scratch);
}

/* ---- sets of lines -------------------------------------------------------------------------- */

static plan_key key_of(const line_set *set)
{
    plan_key key;
    memset(&key, 0, sizeof key);
    key.n = set->axis.n;
    key.line = are_single(set);
    key.cosine = is_cosine(set->kind);
    key.real = key.line && is_real(set->kind);
    return key;
}

static int run_set(const line_set *set, float *out, const float *in)
{
    static const cvol_fft_maker maker = {sizeof(plan_key), create_plan, destroy_plan, plan_bytes};
    const plan_key key = key_of(set);
    cvol_fft_lease lease = cvol_fft_cache_acquire(&maker, &key, NULL);
    if (!lease.entry)
        return CVOL_ERROR_MEMORY;
    const plan *of = lease.plan;
    const int copies = key.line && (is_spread(set, 0) || is_spread(set, 1));
    const size_t floats = of->scratch + (copies ? 2 * copy_floats(set) : 0);
    if (!lease.scratch || copies) { /* the kept scratch has no room for copies */
        free(lease.scratch);
        lease.scratch = cvol_fft_allocate(floats);
    }
    const int code = lease.scratch ? CVOL_OK : CVOL_ERROR_MEMORY;
    if (!code && key.line)
        run_singles(of, set, out, in, lease.scratch);
    else if (!code)
        run_batches(of, set, out, in, lease.scratch);
    cvol_fft_cache_release(&lease, floats * sizeof(float));
    return code;
}

/* ---- axes ----------------------------------------------------------------------------------- */

/* Points along an axis; a half complex array has fewer along its first one. */
static size_t points_along(const cvol_fft_job *job, int axis)
{
    const int half = job->kind == CVOL_FFT_FORWARD || job->kind == CVOL_FFT_INVERSE;
    return half && axis == 0 ? job->axes[0].n / 2 + 1 : job->axes[axis].n;
}

/* The work along one axis. Strides: 1 those of the input (read and written in place), 2 those of
 * the output, 3 both. */
typedef enum sides { IN_PLACE_IN = 1, IN_PLACE_OUT = 2, IN_TO_OUT = 3 } sides;

static line_set lines_along(const cvol_fft_job *job, int axis, cvol_fft_kind kind, sides side)
{
    line_set set = {.kind = kind, .count = {1, 1, 1}};
    set.in_width = in_width(kind);
    set.out_width = out_width(kind);
    const cvol_fft_axis *of[4] = {NULL, NULL, NULL, &job->lines};
    size_t count[4] = {1, 1, 1, job->lines.n};
    for (int a = 0; a < job->rank; a++) {
        of[a] = a == axis ? NULL : &job->axes[a];
        count[a] = points_along(job, a);
    }
    int dimensions = 0;
    for (int a = 0; a < 4; a++)
        if (of[a])
            add_lines(&set, &dimensions, count[a],
                      set.in_width * (side == IN_PLACE_OUT ? of[a]->out_stride : of[a]->in_stride),
                      set.out_width * (side == IN_PLACE_IN ? of[a]->in_stride : of[a]->out_stride));
    set.axis = job->axes[axis];
    set.axis.in_stride = set.in_width *
                         (side == IN_PLACE_OUT ? set.axis.out_stride : set.axis.in_stride);
    set.axis.out_stride = set.out_width *
                          (side == IN_PLACE_IN ? job->axes[axis].in_stride : set.axis.out_stride);
    return set;
}

static int run_axis(const cvol_fft_job *job, int axis, cvol_fft_kind kind, sides side, float *out,
                    float *in)
{
    const line_set set = lines_along(job, axis, kind, side);
    return run_set(&set, side == IN_PLACE_IN ? in : out, side == IN_PLACE_OUT ? out : in);
}

/* The real axis of half complex arrays is the first of FORWARD and the last of INVERSE, which
 * overwrites its input. */
int cvol_fft_execute(cvol_context *context, const cvol_fft_job *job, float *out, float *in)
{
    const cvol_fft_kind kind = (cvol_fft_kind)job->kind;
    int code = CVOL_OK;
    if (kind == CVOL_FFT_INVERSE) {
        for (int a = job->rank - 1; a > 0 && !code; a--)
            code = run_axis(job, a, CVOL_FFT_COMPLEX_BACKWARD, IN_PLACE_IN, out, in);
        code = code ? code : run_axis(job, 0, kind, IN_TO_OUT, out, in);
    } else {
        code = run_axis(job, 0, kind, IN_TO_OUT, out, in);
        for (int a = 1; a < job->rank && !code; a++)
            code = run_axis(job, a, kind == CVOL_FFT_FORWARD ? CVOL_FFT_COMPLEX_FORWARD : kind,
                            IN_PLACE_OUT, out, in);
    }
    if (code)
        return cvol_fail(context, code, "no memory for a transform of %zu x %zu x %zu",
                         job->axes[0].n, job->axes[1].n, job->axes[2].n);
    return CVOL_OK;
}

const char *cvol_fft_backend_name(void)
{
    return "own";
}
