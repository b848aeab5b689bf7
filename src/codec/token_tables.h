/* The coder's probabilities: a table of token frequencies for each context.
 *
 * Every number of a brick is coded as a token of 0 .. 15, in a context (a *row*), followed by raw
 * bits where the token stands for several numbers. A row says how likely each token is, by 15
 * codes: code t is that of the probability that the token is t, given that it is not less. Rows are
 * built in (token_defaults.c), and a file says where its own differ.
 */
#ifndef CVOL_CODEC_TOKEN_TABLES_H
#define CVOL_CODEC_TOKEN_TABLES_H

#include <stdint.h>

#include "base/bytes.h"
#include "cvol/base.h"

typedef struct cvol_token_tables cvol_token_tables;

/* The built-in tables. NULL when memory is short. Freed by free(). */
cvol_token_tables *cvol_token_tables_create(void);

/* Appends the content of section TABL: what differs from the built-in tables. Errors: MEMORY. */
int cvol_token_tables_put(cvol_context *context, cvol_bytes *out, const cvol_token_tables *tables);
/* Reads it. `name` begins the message. Errors: CORRUPT. */
int cvol_token_tables_take(cvol_context *context, cvol_token_tables *tables, cvol_cursor *content,
                           const char *name);

#endif
