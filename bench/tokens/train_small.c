/* Trains the two networks of the small coder (src/codec/neural/neural_model.h), and its rows of tokens, and
 * writes their numbers.
 *
 *     train_small OUT.c STEPS SIGN_STEPS FILE.cvol ...
 *
 * Steps below 0 go on from the numbers that are built in, more slowly; the rows of what stands
 * before coefficients are made anew.
 *
 * Files are volumes that `cvol compress --bricks 64` wrote, with or without --smallest: their
 * coefficients are coded again, and what the coder sees of each is an example. A file behind a '-'
 * is left out of training, and the bits that its examples take are told. The numbers in
 * src/codec/tables/neural_weights.c are from thirteen volumes at ratios 14, 29 and 58, 1,000,000
 * and 400,000 steps of smaller networks, and 1,450,000 and 250,000 from
 * there on.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void watch(int kind, const int16_t *x, int first, uint32_t high);
static void watch_token(int row, uint32_t token);
#define CVOL_SMALL_WATCH watch
#define CVOL_SMALL_WATCH_TOKEN watch_token
#include "codec/neural/neural_code.c"

#include "codec/brick/bricks.h"
#include "cvol/array.h"
#include "cvol/codec.h"

enum {
    INPUTS = CVOL_SMALL_INPUTS,
    FIRST = CVOL_SMALL_FIRST,
    SECOND = CVOL_SMALL_SECOND,
    OUTPUTS = CVOL_SMALL_OUTPUTS,
    BATCH = 512,
    MOST = 3000000, /* examples of a file */
    FILES = 256
};

typedef struct example {
    int8_t x[INPUTS];
    int8_t first, high;
} example;

/* One file's examples of one network. */
typedef struct examples {
    example *of;
    size_t count, room, seen;
    int left_out;
} examples;

typedef struct network {
    float first[FIRST][INPUTS], first_bias[FIRST];
    float second[SECOND][FIRST], second_bias[SECOND];
    float third[OUTPUTS][SECOND], third_bias[OUTPUTS];
} network;

static examples sets[2][FILES];
static int files;
static uint64_t random_state = 88172645463325252u;

static void fail(const char *what)
{
    fprintf(stderr, "train_small: %s\n", what);
    exit(1);
}

static uint64_t random_next(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

/* ---- examples --------------------------------------------------------------------------- */

/* No more than MOST of a file, each as likely as any. */
static void watch(int kind, const int16_t *x, int first, uint32_t high)
{
    examples *set = &sets[kind][files];
    size_t to = set->count;
    set->seen++;
    if (to == MOST) {
        to = random_next() % set->seen;
        if (to >= MOST)
            return;
    } else if (to == set->room) {
        set->room = set->room ? 2 * set->room : 4096;
        set->of = realloc(set->of, set->room * sizeof *set->of);
        if (!set->of)
            fail("no memory");
    }
    example *e = &set->of[to];
    set->count += to == set->count;
    memset(e, 0, sizeof *e);
    for (int i = 0; i < (kind ? CVOL_SMALL_SIGN_INPUTS : INPUTS); i++) {
        if (x[i] < -128 || x[i] > 127)
            fail("an input is beyond its range");
        e->x[i] = (int8_t)x[i];
    }
    e->first = (int8_t)first;
    e->high = (int8_t)(high < OUTPUTS ? high : OUTPUTS);
}

/* Tokens of the file that is looked at, and weighted ones of all. */
static double tokens[CVOL_ROWS][CVOL_TOKENS], all_tokens[CVOL_ROWS][CVOL_TOKENS];

static void watch_token(int row, uint32_t token)
{
    tokens[row][token]++;
}

/* Those of large files count less. */
static void add_tokens(void)
{
    double all = 0;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            all += tokens[r][t];
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            all_tokens[r][t] += tokens[r][t] * sqrt(fmin(1, 40000 / all));
}

static void add_file(cvol_context *context, const char *path)
{
    cvol_array *array;
    cvol_bytes shells[CVOL_SHELLS] = {{0}};
    cvol_brick_coder *coder = cvol_brick_coder_create(NULL);
    if (files == FILES)
        fail("too many files");
    sets[0][files].left_out = sets[1][files].left_out = *path == '-';
    if (cvol_array_read(context, &array, path + (*path == '-'), 0))
        fail(cvol_context_message(context));
    if (!array->dependent)
        fail("a file without dependent coefficients");
    array->small = 1;
    memset(tokens, 0, sizeof tokens); /* of reading it */
    for (size_t b = 0; b < cvol_brick_count(array); b++)
        if (!coder || !cvol_brick_encode(coder, shells, array, b))
            fail("no memory");
    if (!sets[0][files].left_out)
        add_tokens();
    printf("%s: %zu magnitudes, %zu signs\n", path, sets[0][files].seen, sets[1][files].seen);
    for (int s = 0; s < CVOL_SHELLS; s++)
        cvol_bytes_free(&shells[s]);
    cvol_brick_coder_free(coder);
    cvol_array_free(array);
    files++;
}

/* ---- training --------------------------------------------------------------------------- */

#define CLIP (255 / 64.0f)

static float inputs[INPUTS][BATCH], first[FIRST][BATCH], second[SECOND][BATCH],
    outs[OUTPUTS][BATCH];

/* A layer of all examples of a batch. */
static void forward(float *restrict out, const float *restrict in, const float *restrict weights,
                    const float *restrict biases, int units, int count, int cut)
{
    for (int j = 0; j < units; j++) {
        float *to = out + j * BATCH;
        for (int k = 0; k < BATCH; k++)
            to[k] = biases[j];
        for (int i = 0; i < count; i++)
            for (int k = 0; k < BATCH; k++)
                to[k] += weights[j * count + i] * in[i * BATCH + k];
        for (int k = 0; k < BATCH && cut; k++)
            to[k] = to[k] < 0 ? 0 : to[k] > CLIP ? CLIP : to[k];
    }
}

/* Adds to a layer's gradients; off_in: that of its inputs, which were cut, or NULL. */
static void backward(float *restrict off_in, float *restrict weights_off,
                     float *restrict biases_off, const float *restrict off,
                     const float *restrict in, const float *restrict weights, int units, int count)
{
    if (off_in)
        memset(off_in, 0, sizeof *off_in * (size_t)count * BATCH);
    for (int j = 0; j < units; j++) {
        const float *own = off + j * BATCH;
        for (int k = 0; k < BATCH; k++)
            biases_off[j] += own[k];
        for (int i = 0; i < count; i++) {
            float sum = 0;
            for (int k = 0; k < BATCH; k++)
                sum += own[k] * in[i * BATCH + k];
            weights_off[j * count + i] += sum;
        }
        for (int i = 0; off_in && i < count; i++)
            for (int k = 0; k < BATCH; k++)
                off_in[i * BATCH + k] += weights[j * count + i] * own[k];
    }
    for (int i = 0; off_in && i < count * BATCH; i++)
        if (in[i] <= 0 || in[i] >= CLIP)
            off_in[i] = 0;
}

/* The bits of a batch; adds to the gradient, if it is not NULL. */
static double learn(network *gradient, const network *n, const example *const batch[BATCH],
                    int kind)
{
    static float outs_off[OUTPUTS][BATCH], second_off[SECOND][BATCH], first_off[FIRST][BATCH];
    double bits = 0;
    for (int k = 0; k < BATCH; k++)
        for (int i = 0; i < INPUTS; i++)
            inputs[i][k] = (float)batch[k]->x[i] / 32;
    forward(first[0], inputs[0], n->first[0], n->first_bias, FIRST, INPUTS, 1);
    forward(second[0], first[0], n->second[0], n->second_bias, SECOND, FIRST, 1);
    forward(outs[0], second[0], n->third[0], n->third_bias, kind ? 1 : OUTPUTS, SECOND, 0);
    memset(outs_off, 0, sizeof outs_off);
    for (int k = 0; k < BATCH; k++) {
        const example *e = batch[k];
        const int end = kind ? 0 : e->high < OUTPUTS ? e->high : OUTPUTS - 1;
        for (int t = e->first; t <= end; t++) {
            const int bit = t < e->high;
            const float p = 1 / (1 + expf(-outs[t][k]));
            outs_off[t][k] = p - (float)bit;
            bits -= log2((double)(bit ? p : 1 - p) + 1e-9);
        }
    }
    if (!gradient)
        return bits;
    backward(second_off[0], gradient->third[0], gradient->third_bias, outs_off[0], second[0],
             n->third[0], kind ? 1 : OUTPUTS, SECOND);
    backward(first_off[0], gradient->second[0], gradient->second_bias, second_off[0], first[0],
             n->second[0], SECOND, FIRST);
    backward(NULL, gradient->first[0], gradient->first_bias, first_off[0], inputs[0], n->first[0],
             FIRST, INPUTS);
    return bits;
}

static void begin_layer(float *weights, float *biases, int units, int count)
{
    for (int i = 0; i < units * count; i++)
        weights[i] = ((float)(random_next() % 65536) / 65536 - 0.5f) * 2 *
                     sqrtf(1.5f / (float)count);
    for (int j = 0; j < units; j++)
        biases[j] = 0.2f;
}

/* Goes on from the numbers that are built in; a unit of which none are begins anew, unheard. */
static void take_layer(float *weights, float *biases, const int16_t *from,
                       const int32_t *from_biases, int units, int count, float scale)
{
    begin_layer(weights, biases, units, count);
    for (int j = 0; j < units; j++) {
        int any = 0;
        for (int i = 0; i < count; i++)
            any |= from[j * count + i];
        for (int i = 0; i < count && any; i++)
            weights[j * count + i] = (float)from[j * count + i] / 4096;
        if (any)
            biases[j] = (float)from_biases[j] / scale;
    }
}

static void take_network(network *n, const cvol_small_network *from)
{
    take_layer(n->first[0], n->first_bias, from->first[0], from->first_bias, FIRST, INPUTS,
               32 * 4096);
    take_layer(n->second[0], n->second_bias, from->second[0], from->second_bias, SECOND, FIRST,
               64 * 4096);
    take_layer(n->third[0], n->third_bias, from->third[0], from->third_bias, OUTPUTS, SECOND,
               64 * 4096);
}

/* Large files count less than their examples, small ones are not lost. */
static double share_of(const examples *set)
{
    const double count = (double)set->count;
    return set->left_out ? 0 : fmin(count, 300 * sqrt(count));
}

static void train(network *n, long steps, int kind, int goes_on)
{
    static network gradient, means, squares;
    float *of = (float *)n, *g = (float *)&gradient, *m = (float *)&means, *s = (float *)&squares;
    double until[FILES], all = 0, bits = 0;
    memset(&means, 0, sizeof means);
    memset(&squares, 0, sizeof squares);
    begin_layer(n->first[0], n->first_bias, FIRST, INPUTS);
    begin_layer(n->second[0], n->second_bias, SECOND, FIRST);
    begin_layer(n->third[0], n->third_bias, OUTPUTS, SECOND);
    if (goes_on)
        take_network(n, kind ? &cvol_small_signs : &cvol_small_magnitudes);
    for (int f = 0; f < files; f++)
        until[f] = all += share_of(&sets[kind][f]);
    for (long step = 1; step <= steps; step++) {
        const example *batch[BATCH];
        for (int k = 0; k < BATCH; k++) {
            const double at = (double)(random_next() >> 11) * 0x1p-53 * all;
            int f = 0;
            while (f < files - 1 && until[f] <= at)
                f++;
            batch[k] = &sets[kind][f].of[random_next() % sets[kind][f].count];
        }
        memset(&gradient, 0, sizeof gradient);
        bits += learn(&gradient, n, batch, kind);
        const double way = (double)step / (double)steps;
        const float rate = (float)((goes_on ? 0.0006 : 0.002) * (1 + cos(3.14159265 * way)) *
                                   fmin(1, (double)step / 200));
        const float c1 = 1 - powf(0.9f, (float)step), c2 = 1 - powf(0.999f, (float)step);
        for (size_t i = 0; i < sizeof *n / sizeof *of; i++) {
            const float own = g[i] / BATCH;
            m[i] = 0.9f * m[i] + 0.1f * own;
            s[i] = 0.999f * s[i] + 0.001f * own * own;
            of[i] -= rate * (m[i] / c1) / (sqrtf(s[i] / c2) + 1e-8f);
            of[i] = of[i] < -7.9f ? -7.9f : of[i] > 7.9f ? 7.9f : of[i]; /* 16 bits hold it */
        }
        if (step % 5000 == 0) {
            printf("%ld: %.4f bits an example\n", step, bits / BATCH / 5000);
            fflush(stdout);
            bits = 0;
        }
    }
}

/* What examples that were left out take. */
static void test(const network *n, int kind)
{
    double bits = 0, count = 0;
    for (int f = 0; f < files; f++)
        for (size_t i = 0; sets[kind][f].left_out && i + BATCH <= sets[kind][f].count; i += BATCH) {
            const example *batch[BATCH];
            for (int k = 0; k < BATCH; k++)
                batch[k] = &sets[kind][f].of[i + (size_t)k];
            bits += learn(NULL, n, batch, kind);
            count += BATCH;
        }
    if (count > 0)
        printf("left out: %.4f bits an example\n", bits / count);
}

/* ---- writing ---------------------------------------------------------------------------- */

static void put_row(FILE *file, const float *values, int count, double scale, const char *end)
{
    for (int i = 0; i < count; i++)
        fprintf(file, "%s%ld", i ? ", " : "{", lrint((double)values[i] * scale));
    fprintf(file, "}%s\n", end);
}

static void put_layer(FILE *file, const float *weights, const float *biases, int units, int count,
                      double scale, const char *end)
{
    fprintf(file, "{\n");
    for (int j = 0; j < units; j++)
        put_row(file, weights + j * count, count, 4096, j < units - 1 ? "," : "},");
    put_row(file, biases, units, scale, end);
}

static void put_network(FILE *file, const char *name, const network *n)
{
    fprintf(file, "const cvol_small_network %s = {\n", name);
    put_layer(file, n->first[0], n->first_bias, FIRST, INPUTS, 32 * 4096, ",");
    put_layer(file, n->second[0], n->second_bias, SECOND, FIRST, 64 * 4096, ",");
    put_layer(file, n->third[0], n->third_bias, OUTPUTS, SECOND, 64 * 4096, "};");
}

/* The rows that make what was counted shortest. */
static void put_rows(FILE *file)
{
    static cvol_token_counts counts;
    cvol_token_tables *tables = cvol_token_tables_create();
    if (!tables)
        fail("no memory");
    for (int r = CVOL_SMALL_ROWS; r < CVOL_SMALL_ROWS_END; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            counts.of[r][t] = (uint64_t)(all_tokens[r][t] + 0.5);
    cvol_token_tables_train(tables, &counts);
    fprintf(file, "\nconst uint8_t cvol_small_rows[CVOL_SMALL_ROWS_END - CVOL_SMALL_ROWS]"
                  "[CVOL_TOKEN_CODES] = {\n");
    for (int r = CVOL_SMALL_ROWS; r < CVOL_SMALL_ROWS_END; r++) {
        for (int t = 0; t < CVOL_TOKEN_CODES; t++)
            fprintf(file, "%s%d", t ? ", " : "{", tables->codes[r][t]);
        fprintf(file, "}%s\n", r < CVOL_SMALL_ROWS_END - 1 ? "," : "};");
    }
    free(tables);
}

int main(int argc, char **argv)
{
    static network magnitudes, signs;
    if (argc < 5)
        fail("OUT.c STEPS SIGN_STEPS FILE.cvol ...");
    cvol_context *context = cvol_context_create();
    if (!context)
        fail("no memory");
    for (int f = 4; f < argc; f++)
        add_file(context, argv[f]);
    cvol_context_destroy(context);
    train(&magnitudes, labs(atol(argv[2])), 0, atol(argv[2]) < 0);
    test(&magnitudes, 0);
    train(&signs, labs(atol(argv[3])), 1, atol(argv[3]) < 0);
    test(&signs, 1);
    FILE *file = fopen(argv[1], "w");
    if (!file)
        fail("cannot write the numbers");
    fprintf(file, "/* The numbers of small_model.h, written by bench/tokens/train_small.c. */\n"
                  "#include \"codec/neural/neural_model.h\"\n\n/* clang-format off */\n");
    put_network(file, "cvol_small_magnitudes", &magnitudes);
    put_network(file, "cvol_small_signs", &signs);
    put_rows(file);
    if (fclose(file))
        fail("cannot write the numbers");
    return 0;
}
