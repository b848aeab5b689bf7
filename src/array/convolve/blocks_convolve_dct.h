/* A kernel on volumes in DCT blocks, without evaluating them (block_convolve.h). */
#ifndef CVOL_ARRAY_CONVOLVE_BLOCKS_CONVOLVE_DCT_H
#define CVOL_ARRAY_CONVOLVE_BLOCKS_CONVOLVE_DCT_H

#include "array/truncate/account.h"
#include "array/truncate/producer.h"

/* cvol_blocks_convolve_kernel for rank 3 under DCT. */
int cvol_blocks_convolve_dct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                             const cvol_array *a, const cvol_kernel *kernel, const cvol_keep *keep);

#endif
