/* Kernels on volumes: the matrices of each part and axis, and a producer that applies them. */
#include "array/convolve/blocks_convolve_dct.h"

#include <stdlib.h>

#include "array/convolve/block_convolve.h"
#include "array/convolve/face_matrices.h"
#include "array/convolve/kernel.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "base/cpu.h"

CVOL_SIMD_DECLARE(void, cvol_block_convolve,
                  (float *out, const cvol_block *const near[27], const cvol_convolve_part *parts,
                   int part_count, int block_log2, cvol_convolve_work *work));

void cvol_block_convolve(float *out, const cvol_block *const near[27],
                         const cvol_convolve_part *parts, int part_count, int block_log2,
                         cvol_convolve_work *work)
{
    CVOL_SIMD_CHOOSE(cvol_block_convolve)(out, near, parts, part_count, block_log2, work);
}

typedef struct convolution {
    const cvol_array *a;
    const cvol_kernel *kernel;
    cvol_axis_matrices axes[CVOL_KERNEL_PARTS][3];
} convolution;

/* Finds the block at `place` and its neighbours; 1 if any of them has terms. */
static int find_neighbours(const cvol_block *near[27], const cvol_array *a, const size_t place[3])
{
    int any = 0;
    for (size_t i = 0; i < 27; i++) {
        const size_t d[3] = {i % 3, i / 3 % 3, i / 9};
        size_t index = 0;
        near[i] = NULL;
        int inside = 1;
        for (int axis = 2; axis >= 0; axis--) {
            const size_t at = place[axis] + d[axis] - 1;
            inside &= at < a->blocks[axis];
            index = index * a->blocks[axis] + at;
        }
        if (inside && a->block_table[index].words) {
            near[i] = &a->block_table[index];
            any = 1;
        }
    }
    return any;
}

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const convolution *c = user;
    const cvol_array *a = c->a;
    const size_t place[3] = {index % a->blocks[0], index / a->blocks[0] % a->blocks[1],
                             index / a->blocks[0] / a->blocks[1]};
    const cvol_block *near[27];
    const int any = find_neighbours(near, a, place);
    block->max_abs = -1;
    for (int axis = 0; axis < 3; axis++)
        block->box[axis] = any ? a->block : 0;
    if (!any)
        return CVOL_OK;
    cvol_convolve_part parts[CVOL_KERNEL_PARTS];
    for (int p = 0; p < c->kernel->parts; p++) {
        cvol_face_matrices of[3];
        for (int axis = 0; axis < 3; axis++)
            of[axis] = cvol_axis_matrices_at(&c->axes[p][axis], place[axis], a->block,
                                             c->kernel->line[p][axis].radius);
        parts[p] = (cvol_convolve_part){
            .weight = (float)(c->kernel->weight[p] * a->step), .x = of[0], .y = of[1], .z = of[2]};
    }
    cvol_block_convolve(block->coefficients, near, parts, c->kernel->parts, a->block_log2, scratch);
    return CVOL_OK;
}

int cvol_blocks_convolve_dct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                             const cvol_array *a, const cvol_kernel *kernel, const cvol_keep *keep)
{
    convolution c = {.a = a, .kernel = kernel};
    int code = CVOL_OK;
    for (int p = 0; p < kernel->parts && !code; p++)
        for (int axis = 0; axis < 3 && !code; axis++)
            code = cvol_axis_matrices_make(context, &c.axes[p][axis], &kernel->line[p][axis],
                                           a->grid.dims[axis], a->block, axis == 0);
    const cvol_producer producer = {.produce = produce,
                                    .user = &c,
                                    .scratch_bytes = sizeof(cvol_convolve_work),
                                    .what = "convolving"};
    double norm, sum;
    cvol_kernel_bounds(kernel, &norm, &sum);
    out->offset = a->offset * cvol_kernel_total(kernel);
    cvol_blocks_set_expected_bound(out, cvol_error_bound_convolve(&a->error_bound, norm, sum));
    const cvol_keep resolved = cvol_blocks_keep_for_filter(out, keep,
                                                           cvol_kernel_noise_gain(kernel), a);
    if (!code)
        code = cvol_build_blocks(context, out, result, &producer, &resolved);
    for (int p = 0; p < CVOL_KERNEL_PARTS; p++)
        for (int axis = 0; axis < 3; axis++)
            cvol_axis_matrices_free(&c.axes[p][axis]);
    return code;
}
