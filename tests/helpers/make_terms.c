/* make_terms OUT.cvol NXxNYxNZ BLOCK SPLIT LAPPED SMALL SEED: a file of a volume of random terms
 * (support_terms.h). */
#include <stdio.h>
#include <stdlib.h>

#include "cvol/codec.h"
#include "support_terms.h"

int main(int argc, char **argv)
{
    support_terms how = {.dims = {0}};
    cvol_array *array;
    cvol_context *context = cvol_context_create();
    if (argc != 8 ||
        sscanf(argv[2], "%zux%zux%zu", &how.dims[0], &how.dims[1], &how.dims[2]) != 3) {
        fputs("usage: make_terms OUT.cvol NXxNYxNZ BLOCK SPLIT LAPPED SMALL SEED\n", stderr);
        return 2;
    }
    how.block = atoi(argv[3]);
    how.split = atoi(argv[4]);
    how.lapped = atoi(argv[5]);
    how.small_values = atoi(argv[6]);
    how.seed = strtoull(argv[7], NULL, 10);
    array = support_terms_make(context, &how);
    const int code = cvol_array_write(context, array, argv[1], NULL);
    if (code)
        fprintf(stderr, "make_terms: %s\n", cvol_context_message(context));
    cvol_array_free(array);
    cvol_context_free(context);
    return code ? 1 : 0;
}
