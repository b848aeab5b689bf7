/* The residual of an array's evaluated samples, which brings them within a bound of the original,
 * or makes them equal to it. The reader or encoder provides it, in any form. Evaluation applies it.
 * Rendering and operations use the terms of decoded samples (array/evaluate/decoded_terms.h), and
 * results of operations have no residual. */
#ifndef CVOL_ARRAY_CORE_RESIDUAL_H
#define CVOL_ARRAY_CORE_RESIDUAL_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/array.h"

typedef struct cvol_residual cvol_residual;
struct cvol_residual {
    /* As cvol_array_evaluate_box; it does not change masked samples. */
    int (*evaluate)(cvol_context *context, void *out, const cvol_array *array,
                    const size_t begin[3], const size_t end[3]);
    void (*free)(cvol_residual *residual);
    uint64_t (*bytes)(const cvol_residual *residual); /* of memory */
    cvol_array *decoded; /* array/evaluate/decoded_terms.h; NULL until the first use */
};

#endif
