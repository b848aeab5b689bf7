/* Common code of the programs that train the codec's tables. All results have the same bits on
 * every processor. */
#ifndef TRAINING_H
#define TRAINING_H

#include <stdint.h>

#include "codec/entropy/token_tables.h"
#include "cvol/volume.h"

/* Prints the message and ends the program. */
_Noreturn void training_fail(const char *what);

/* Reads FILE or FILE:NXxNYxNZ:TYPE; changes the argument. */
cvol_volume *training_read(cvol_context *context, char *argument);

/* Seed of training_random(). */
#define TRAINING_SEED UINT64_C(88172645463325252)
/* The next number of a generator (Marsaglia 2003, xorshift). */
uint64_t training_random(uint64_t *state);

/* 1 / (1 + exp(-x)), within 2e-7. Uses no function of the C library, whose last bits differ. */
float training_logistic(float x);

/* One step of Adam (Kingma and Ba 2015). */
typedef struct training_adam {
    float *means, *squares; /* one for each weight, zero before the first step */
    double mean_decay,
        square_decay; /* 0.9 and 0.999 to the power of the steps so far; 1 at first */
} training_adam;
void training_adam_step(training_adam *adam, float *weights, const float *gradient, int count,
                        float rate);

/* Sets all codes to the best ones for these counts; rows without counts stay. */
void training_fit_rows(cvol_token_tables *tables, const cvol_token_counts *counts);

/* Reads tables/token_codes.inc, or a file like it. */
void training_read_codes(cvol_token_tables *tables, const char *path);
/* Writes the codes of rows first .. end - 1. comment: the file's first line. */
void training_write_codes(const char *path, const char *comment, const cvol_token_tables *tables,
                          int first, int end);

#endif
