/* What an array adds to its evaluated samples so that they are within a bound of the original, or
 * equal to it: of whatever kind, made by whoever reads or makes such arrays. Evaluating samples
 * uses them; rendering and operations are on the terms of decoded samples
 * (array/evaluate/decoded_terms.h), and what operations give has no residual.
 */
#ifndef CVOL_ARRAY_CORE_RESIDUAL_H
#define CVOL_ARRAY_CORE_RESIDUAL_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/array.h"

typedef struct cvol_residual cvol_residual;
struct cvol_residual {
    /* As cvol_array_evaluate_box; masked samples are left as they are. */
    int (*evaluate)(cvol_context *context, void *out, const cvol_array *array,
                    const size_t begin[3], const size_t end[3]);
    void (*free)(cvol_residual *residual);
    uint64_t (*bytes)(const cvol_residual *residual); /* of memory */
    cvol_array *decoded; /* array/evaluate/decoded_terms.h; NULL until it is asked for */
};

#endif
