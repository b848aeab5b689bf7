/* The length of the gradient by central differences: each block is evaluated with one sample around
 * it. */
#include <math.h>

#include "array/algebra/operations.h"
#include "array/block/halo.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "array/truncate/result_block.h"
#include "array/truncate/result_lap.h"

typedef struct gradient {
    const cvol_array *a, *shape;
    double weight[3];
} gradient;

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const gradient *g = user;
    const int rank = g->a->rank;
    size_t side[3], size[3], stride[3];
    ptrdiff_t begin[3];
    (void)cvol_result_box(begin, side, g->shape, index);
    for (int a = 0; a < 3; a++) {
        size[a] = side[a] + (a < rank ? 2 : 0);
        begin[a] -= a < rank ? 1 : 0;
    }
    stride[0] = 1;
    stride[1] = size[0];
    stride[2] = size[0] * size[1];
    float *samples = (float *)((char *)scratch + cvol_halo_bytes(g->a));
    float *work = samples + cvol_result_box_room(g->shape);
    float *around = work + cvol_result_scratch(g->shape);
    cvol_halo_read(around, scratch, g->a, begin, size);
    for (size_t z = 0; z < side[2]; z++)
        for (size_t y = 0; y < side[1]; y++)
            for (size_t x = 0; x < side[0]; x++) {
                const float *here = around + (x + 1) + stride[1] * (y + (rank > 1)) +
                                    stride[2] * (z + (rank > 2));
                double sum = 0; /* squares may exceed the float range */
                for (int a = 0; a < rank; a++) {
                    const double d = g->weight[a] / 2 *
                                     ((double)here[stride[a]] - (double)*(here - stride[a]));
                    sum += d * d;
                }
                samples[x + side[0] * (y + side[1] * z)] = (float)sqrt(sum);
            }
    cvol_result_put(block, samples, work, g->shape, index);
    return CVOL_OK;
}

int cvol_blocks_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const double weight[3], const cvol_keep *keep)
{
    gradient g = {.a = a, .shape = out};
    out->lapped = a->lapped || cvol_result_may_lap(out);
    double squares = 0;
    size_t around = 1;
    for (int i = 0; i < a->rank; i++) {
        g.weight[i] = weight[i];
        squares += weight[i] * weight[i];
        around *= (size_t)a->block + 2 + (out->lapped ? 4 : 0);
    }
    /* A central difference is at most the largest magnitude. */
    const double gain = sqrt(squares), most = gain * cvol_error_bound_largest(&a->error_bound);
    cvol_blocks_set_expected_bound(
        out, (cvol_error_bound){.l2_error = gain * a->error_bound.l2_error,
                                .point_error = gain * cvol_error_bound_point(&a->error_bound),
                                .default_loss = gain * a->error_bound.default_loss,
                                .max_abs = gain * cvol_error_bound_tighten(&a->error_bound),
                                .value_min = 0,
                                .value_max = most});
    const cvol_keep resolved = cvol_blocks_keep_for_filter(out, keep, gain / sqrt(2), a);
    const cvol_producer producer = {
        .produce = produce,
        .user = &g,
        .scratch_bytes = cvol_halo_bytes(a) +
                         (cvol_result_box_room(out) + cvol_result_scratch(out) + around) *
                             sizeof(float),
        .what = "gradient"};
    const int code = cvol_result_choose_lap(context, out, &producer, &resolved, a->lapped);
    return code ? code : cvol_build_blocks(context, out, result, &producer, &resolved);
}
