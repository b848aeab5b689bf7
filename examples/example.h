/* Shared by the examples: error exits, and a line of numbers about an array. */
#ifndef CVOL_EXAMPLES_EXAMPLE_H
#define CVOL_EXAMPLES_EXAMPLE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cvol/cvol.h"

/* After a failed call: prints the message of the context and ends the program. */
static inline void must(const cvol_context *context, int code)
{
    if (!code)
        return;
    fprintf(stderr, "%s\n", cvol_context_message(context));
    exit(1);
}

static inline void *need_memory(void *memory)
{
    if (memory)
        return memory;
    fprintf(stderr, "not enough memory\n");
    exit(1);
}

/* Compares an array with the exact samples: prints its terms, its bound and the real error. Ends
 * the program if the error exceeds the bound. */
static inline void report(cvol_context *context, const char *what, const cvol_array *array,
                          const float *exact)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t count = cvol_grid_samples(grid), begin[3] = {0, 0, 0};
    float *samples = need_memory(malloc(count * sizeof *samples));
    must(context, cvol_array_evaluate_real(context, samples, array, begin, grid->dims));
    double error = 0, energy = 0;
    for (size_t i = 0; i < count; i++) {
        double difference = (double)samples[i] - (double)exact[i];
        error += difference * difference;
        energy += (double)exact[i] * (double)exact[i];
    }
    free(samples);
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    printf("%-28s %8llu terms of %zu (rho 1/%.0f), RMS error %.4g, certified at most %.4g (signal "
           "%.4g)\n",
           what, (unsigned long long)info.coefficients, count, 1 / info.rho,
           sqrt(error / (double)count), info.l2_error / sqrt((double)count),
           sqrt(energy / (double)count));
    if (sqrt(error) > info.l2_error) {
        fprintf(stderr, "the error exceeds the bound\n");
        exit(1);
    }
}

#endif
