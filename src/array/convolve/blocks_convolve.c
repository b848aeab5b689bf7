/* A small filter on blocks of any rank and transform: evaluates a block and the samples that the
 * filter reaches around it, sums taps axis by axis, and transforms. Volumes in DCT blocks, neither
 * split nor lapped nor with a separate background, take a shorter way. */
#include <string.h>

#include "array/block/halo.h"
#include "array/convolve/blocks_convolve_dct.h"
#include "array/convolve/convolve.h"
#include "array/convolve/kernel.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "array/truncate/result_block.h"
#include "array/truncate/result_lap.h"
#include "base/context.h"

typedef struct filter {
    const cvol_array *a, *shape;
    const cvol_kernel *kernel;
    size_t radius[3];
} filter;

/* Filters an axis whose neighbours lie `stride` apart: `count` results from `count + 2 radius`
 * values of each line. The line's own radius may be smaller. */
static void along(float *out, const float *in, size_t outer, size_t stride, size_t count,
                  size_t radius, const cvol_kernel_line *line)
{
    const float sign = line->antisymmetric ? -1.0f : 1.0f;
    for (size_t o = 0; o < outer; o++)
        for (size_t x = 0; x < count; x++) {
            const float *here = in + (o * (count + 2 * radius) + x + radius) * stride;
            float *to = out + (o * count + x) * stride;
            const float middle = (float)line->taps[0];
            for (size_t i = 0; i < stride; i++)
                to[i] = middle * here[i];
            for (size_t t = 1; t <= (size_t)line->radius; t++) {
                const float tap = (float)line->taps[t];
                const float *before = here - t * stride, *after = here + t * stride;
                for (size_t i = 0; i < stride; i++)
                    to[i] += tap * (before[i] + sign * after[i]);
            }
        }
}

static size_t around_of(const filter *f)
{
    size_t count = 1;
    for (int a = 0; a < f->a->rank; a++)
        count *= (size_t)f->a->block + 2 * f->radius[a] + (f->shape->lapped ? 4 : 0);
    return (count + 15) & ~(size_t)15;
}

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const filter *f = user;
    const int rank = f->a->rank;
    const size_t around = around_of(f);
    size_t size[3], side[3];
    ptrdiff_t begin[3];
    const size_t count = cvol_result_box(begin, side, f->shape, index);
    for (int a = 0; a < 3; a++) {
        size[a] = side[a] + 2 * f->radius[a];
        begin[a] -= (ptrdiff_t)f->radius[a];
    }
    float *samples = (float *)((char *)scratch + cvol_halo_bytes(f->a));
    float *work = samples + cvol_result_box_room(f->shape);
    float *read = work + cvol_result_scratch(f->shape), *one = read + around, *other = one + around;
    cvol_halo_read(read, scratch, f->a, begin, size);
    memset(samples, 0, count * sizeof *samples);
    for (int p = 0; p < f->kernel->parts; p++) {
        size_t now[3] = {size[0], size[1], size[2]};
        double weight = f->kernel->weight[p];
        const float *from = read;
        for (int a = 0; a < rank; a++) {
            const size_t stride = a == 0 ? 1 : a == 1 ? now[0] : now[0] * now[1];
            const size_t outer = now[0] * now[1] * now[2] / (stride * now[a]);
            float *to = from == one ? other : one;
            along(to, from, outer, stride, side[a], f->radius[a], &f->kernel->line[p][a]);
            now[a] = side[a];
            from = to;
        }
        for (int a = rank; a < 3; a++)
            weight *= f->kernel->line[p][a].taps[0];
        for (size_t i = 0; i < count; i++)
            samples[i] += (float)weight * from[i];
    }
    cvol_result_put(block, samples, work, f->shape, index);
    return CVOL_OK;
}

int cvol_blocks_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                                const cvol_array *a, const cvol_kernel *kernel,
                                const cvol_keep *keep)
{
    filter f = {.a = a, .shape = out, .kernel = kernel};
    double norm, sum;
    for (int i = 0; i < a->rank; i++)
        f.radius[i] = (size_t)cvol_kernel_radius(kernel, i);
    if (a->rank == 3 && a->transform == CVOL_DCT && !a->lapped && !cvol_array_has_splits(a) &&
        !cvol_mask_is_background(a->mask))
        return cvol_blocks_convolve_dct(context, out, result, a, kernel, keep);
    out->lapped = a->lapped || cvol_result_may_lap(out);
    cvol_kernel_bounds(kernel, &norm, &sum);
    cvol_blocks_set_expected_bound(out, cvol_error_bound_convolve(&a->error_bound, norm, sum));
    const cvol_keep resolved = cvol_blocks_keep_for_filter(out, keep,
                                                           cvol_kernel_noise_gain(kernel), a);
    const cvol_producer producer = {
        .produce = produce,
        .user = &f,
        .scratch_bytes = cvol_halo_bytes(a) + (cvol_result_box_room(out) +
                                               cvol_result_scratch(out) + 3 * around_of(&f)) *
                                                  sizeof(float),
        .what = "filtering"};
    const int code = cvol_result_choose_lap(context, out, &producer, &resolved, a->lapped);
    return code ? code : cvol_build_blocks(context, out, result, &producer, &resolved);
}
