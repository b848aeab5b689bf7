/* Programs that try one random case for each seed: FIRST_SEED, COUNT and SECONDS of their command
 * line. */
#ifndef CVOL_FUZZ_SEEDS_H
#define CVOL_FUZZ_SEEDS_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "cvol/cvol.h"

/* Tries one case, and counts what it finds. */
typedef void try_seed(uint64_t seed, cvol_context *context);

/* Tries seeds from argv[1] (1) on: argv[2] of them (count), for at most argv[3] seconds (0: no
 * limit). Returns the number of the last seed. */
static inline uint64_t try_seeds(int argc, char **argv, uint64_t count, try_seed *try)
{
    const uint64_t first = argc > 1 ? strtoull(argv[1], NULL, 10) : 1;
    const double seconds = argc > 3 ? strtod(argv[3], NULL) : 0;
    const time_t begin = time(NULL);
    cvol_context *context = cvol_context_create();
    uint64_t seed = first;
    if (!context)
        abort();
    count = argc > 2 ? strtoull(argv[2], NULL, 10) : count;
    setvbuf(stdout, NULL, _IOLBF, 0);
    for (; seed < first + count; seed++) {
        if (seconds > 0 && difftime(time(NULL), begin) >= seconds)
            break;
        try(seed, context);
    }
    cvol_context_free(context);
    return seed - 1;
}

#endif
