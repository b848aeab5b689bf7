/* The two halves of convolutions: on whole arrays and on blocks (array/algebra/operations.h). */
#ifndef CVOL_ARRAY_CONVOLVE_CONVOLVE_H
#define CVOL_ARRAY_CONVOLVE_CONVOLVE_H

#include "array/truncate/account.h"
#include "array/truncate/producer.h"

int cvol_whole_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                               const cvol_array *a, const cvol_kernel *kernel,
                               const cvol_keep *keep);
int cvol_blocks_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                                const cvol_array *a, const cvol_kernel *kernel,
                                const cvol_keep *keep);

/* Array by array, circular; DFT and DHT. */
int cvol_whole_convolve(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_array *b, const cvol_keep *keep);
/* The largest |F| of a DFT's or DHT's coefficients as complex numbers: at places where b also has
 * both slots, and at others. Errors: MEMORY. */
typedef struct cvol_largest {
    double common, alone;
} cvol_largest;
int cvol_whole_largest_coefficients(cvol_context *context, cvol_largest *out, const cvol_array *a,
                                    const cvol_array *b);

#endif
