/* Fits codes to counts.
 *
 * A code is one probability: of token t against the tokens after it. The cost of a code is that of
 * a binary choice; the search covers all 256 codes. */
#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/elementary.h"
#include "codec/entropy/token_tables.h"

/* The approximate cost in bits of a changed code, and of a row with such codes. */
#define BITS_OF_CODE 7.0
#define BITS_OF_ROW 6.0

/* By code: the probability, and the logarithms for its token and for the tokens after it. */
static double probabilities[256], log_here[256], log_beyond[256];
static pthread_once_t codes_once = PTHREAD_ONCE_INIT;

static void fill_codes(void)
{
    for (int code = 0; code < 256; code++) {
        probabilities[code] = 1 / (1 + cvol_exp((127.5 - code) / 12.75));
        log_here[code] = cvol_log2(probabilities[code]);
        log_beyond[code] = cvol_log2(1 - probabilities[code]);
    }
}

static double bits_of(int code, double here, double beyond)
{
    return -(here * log_here[code] + beyond * log_beyond[code]);
}

/* The best code for these counts. Half a token of `prior` is added, so that few counts give a code
 * near `prior`. */
static int best_code(double here, double beyond, int prior)
{
    const double p = (here + 0.5 * probabilities[prior]) / (here + beyond + 0.5);
    const double code = 127.5 + 12.75 * cvol_log(p / (1 - p));
    int change = (int)lrint((code - prior) / CVOL_CODE_STEP) * CVOL_CODE_STEP;
    while (prior + change < 0)
        change += CVOL_CODE_STEP;
    while (prior + change > 255)
        change -= CVOL_CODE_STEP;
    return prior + change;
}

/* Fits the codes of one row; returns the bits that they save. */
static double fit_row(uint8_t codes[CVOL_TOKEN_CODES], const uint8_t *priors,
                      const uint64_t counts[CVOL_TOKENS])
{
    double beyond = 0, saved = 0;
    for (int t = 0; t < CVOL_TOKENS; t++)
        beyond += (double)counts[t];
    memcpy(codes, priors, CVOL_TOKEN_CODES);
    /* Tokens that are never used, nor tokens after them, keep their codes. */
    for (int t = 0; t < CVOL_TOKEN_CODES && beyond > 0; t++) {
        const double here = (double)counts[t];
        beyond -= here;
        const int code = best_code(here, beyond, priors[t]);
        const double gain = bits_of(priors[t], here, beyond) - bits_of(code, here, beyond) -
                            BITS_OF_CODE;
        if (gain > 0) {
            codes[t] = (uint8_t)code;
            saved += gain;
        }
    }
    return saved;
}

void cvol_token_tables_fit(cvol_token_tables *tables, const cvol_token_counts *counts)
{
    pthread_once(&codes_once, fill_codes);
    for (int r = 0; r < CVOL_ROWS; r++) {
        const uint8_t *defaults = cvol_token_defaults[r];
        const double saved = fit_row(tables->codes[r], defaults, counts->of[r]);
        if (saved < BITS_OF_ROW)
            memcpy(tables->codes[r], defaults, CVOL_TOKEN_CODES);
    }
    cvol_token_tables_commit(tables);
}
