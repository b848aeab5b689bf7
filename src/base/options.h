/* Option structs of callers, whose headers may be of another version (cvol/base.h).
 *
 * A struct begins with `size_t size`. Later versions append fields, each at an offset of at least
 * the old sizeof: the padding at the end of an old struct has no defined value. A function
 * completes the struct of its caller like this, with the last field of version 0.1:
 *
 *     cvol_film_options full = defaults;
 *     code = cvol_options_copy(context, &full, sizeof full,
 *                              CVOL_SIZE_TO(cvol_film_options, quality), "cvol_film_options",
 *                              options); */
#ifndef CVOL_BASE_OPTIONS_H
#define CVOL_BASE_OPTIONS_H

#include "cvol/base.h"

/* Bytes of a struct from its start to the end of a field. */
#define CVOL_SIZE_TO(type, field) (offsetof(type, field) + sizeof(((type *)0)->field))

/* A struct that claims more bytes than this was not initialized. */
#define CVOL_OPTIONS_SIZE_MAX 65536

/* Copies the struct `given`, as far as its size says, over the defaults in `out`, which has `known`
 * bytes; then sets the size in `out` to `known`. Errors: ARGUMENT (a size below `least` or above
 * CVOL_OPTIONS_SIZE_MAX; a byte other than 0 beyond `known`); then `out` keeps the defaults. The
 * messages begin with `name`. */
int cvol_options_copy(cvol_context *context, void *out, size_t known, size_t least,
                      const char *name, const void *given);

/* Fills a struct of `size` bytes with the defaults, which have `known` bytes: sets its size, cuts
 * the defaults at `size`, and sets bytes beyond `known` to 0. Does nothing if `size` has no room
 * for a size_t. */
void cvol_options_fill(void *out, size_t size, const void *defaults, size_t known);

#endif
