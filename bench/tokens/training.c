/* Common code of the programs that train the codec's tables. */
#include "training.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void training_fail(const char *what)
{
    fprintf(stderr, "training: %s\n", what);
    exit(1);
}

cvol_volume *training_read(cvol_context *context, char *argument)
{
    cvol_read_options options = cvol_read_options_defaults();
    char type[16], *colon = strchr(argument, ':');
    if (colon) {
        if (sscanf(colon, ":%zux%zux%zu:%15s", &options.dims[0], &options.dims[1], &options.dims[2],
                   type) != 4)
            training_fail("give the size and type of a raw file as FILE:NXxNYxNZ:TYPE");
        options.type = cvol_type_from_name(type);
        *colon = 0;
    }
    cvol_volume *volume;
    if (cvol_volume_read(context, &volume, argument, colon ? &options : NULL))
        training_fail(cvol_context_message(context));
    return volume;
}

uint64_t training_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* exp(-|x|) = 2^-n exp(-r) with 0 <= r < log(2); exp(-r) by its Taylor polynomial. */
float training_logistic(float x)
{
    const double size = fmin(fabs((double)x), 60), n = floor(size * 1.4426950408889634);
    const double r = size - n * 0.6931471805599453;
    double sum = 1, term = 1;
    for (int k = 1; k <= 14; k++) {
        term *= -r / k;
        sum += term;
    }
    const double e = ldexp(sum, -(int)n);
    return (float)(x < 0 ? e / (1 + e) : 1 / (1 + e));
}

void training_adam_step(training_adam *adam, float *weights, const float *gradient, int count,
                        float rate)
{
    adam->mean_decay *= 0.9;
    adam->square_decay *= 0.999;
    const float c1 = (float)(1 - adam->mean_decay), c2 = (float)(1 - adam->square_decay);
    float *means = adam->means, *squares = adam->squares;
    for (int i = 0; i < count; i++) {
        const float g = gradient[i];
        means[i] = 0.9f * means[i] + 0.1f * g;
        squares[i] = 0.999f * squares[i] + 0.001f * g * g;
        weights[i] -= rate * (means[i] / c1) / (sqrtf(squares[i] / c2) + 1e-8f);
    }
}

/* ---- rows of tokens --------------------------------------------------------------------- */

/* The code (token_tables.h) of the probability that these counts give. Half a token of the prior's
 * probability is added, so that few counts change little. */
static int best_code(double here, double beyond, int prior)
{
    const double before = 1 / (1 + exp((127.5 - prior) / 12.75));
    const double p = (here + 0.5 * before) / (here + beyond + 0.5);
    const long code = lrint(127.5 + 12.75 * log(p / (1 - p)));
    return code < 0 ? 0 : code > 255 ? 255 : (int)code;
}

void training_fit_rows(cvol_token_tables *tables, const cvol_token_counts *counts)
{
    for (int r = 0; r < CVOL_ROWS; r++) {
        double beyond = 0;
        for (int t = 0; t < CVOL_TOKENS; t++)
            beyond += (double)counts->of[r][t];
        for (int t = 0; t < CVOL_TOKEN_CODES; t++) {
            const double here = (double)counts->of[r][t];
            beyond -= here;
            if (here + beyond > 0)
                tables->codes[r][t] = (uint8_t)best_code(here, beyond, tables->codes[r][t]);
        }
    }
    cvol_token_tables_commit(tables);
}

void training_read_codes(cvol_token_tables *tables, const char *path)
{
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "/*%*[^*]*/") < 0)
        training_fail("cannot read the codes to begin with");
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKEN_CODES; t++) {
            int code;
            if (fscanf(file, t ? ", %d" : " {%d", &code) != 1 || code < 0 || code > 255)
                training_fail("the codes to begin with are damaged");
            tables->codes[r][t] = (uint8_t)code;
            if (t == CVOL_TOKEN_CODES - 1)
                (void)!fscanf(file, "},");
        }
    fclose(file);
    cvol_token_tables_commit(tables);
}

void training_write_codes(const char *path, const char *comment, const cvol_token_tables *tables,
                          int first, int end)
{
    FILE *file = fopen(path, "w");
    if (!file)
        training_fail("cannot write the codes");
    fprintf(file, "/* %s */\n", comment);
    for (int r = first; r < end; r++)
        for (int t = 0; t < CVOL_TOKEN_CODES; t++)
            fprintf(file, "%s%d%s", t ? ", " : "{", tables->codes[r][t],
                    t < CVOL_TOKEN_CODES - 1 ? "" : "},\n");
    if (fclose(file))
        training_fail("cannot write the codes");
}
