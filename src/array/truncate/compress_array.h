/* The two halves of compressing samples: to a whole array, and to blocks. */
#ifndef CVOL_ARRAY_TRUNCATE_COMPRESS_ARRAY_H
#define CVOL_ARRAY_TRUNCATE_COMPRESS_ARRAY_H

#include "array/truncate/account.h"
#include "array/truncate/producer.h"

int cvol_whole_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const void *samples, const cvol_keep *keep);
int cvol_blocks_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const void *samples, const cvol_keep *keep);

#endif
