/* Trains the two networks of maximum effort and its rows of tokens (src/codec/tables/neural_*.inc,
 * neural_model.h).
 *
 *     train_neural IN.inc OUT_FOLDER STEPS SIGN_STEPS FILE.cvol ...
 *
 * IN.inc has the codes of tokens that the rows begin with (token_codes.inc). A negative number of
 * steps continues from the built-in networks, at a lower rate. The files are volumes that
 * `cvol compress --smallest --bricks 64` wrote; each of their coefficients is an example. The
 * examples of a file named -FILE.cvol are not trained on: the program prints the bits that they
 * take.
 *
 * Sums are made in one order, so that the result is the same on every processor.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "codec/brick/brick_internal.h"
#include "codec/brick/bricks.h"
#include "codec/neural/neural_internal.h"
#include "codec/neural/neural_model.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/trellis_states.h"
#include "cvol/array.h"
#include "cvol/codec.h"
#include "training.h"

enum {
    INPUTS = CVOL_NEURAL_INPUTS,
    FIRST = CVOL_NEURAL_FIRST,
    SECOND = CVOL_NEURAL_SECOND,
    OUTPUTS = CVOL_NEURAL_OUTPUTS,
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
static uint64_t random_state = TRAINING_SEED;

/* ---- examples --------------------------------------------------------------------------- */

/* Adds an example. Kind 0: the decisions from `first` on, whether a magnitude is above each value.
 * Kind 1: whether a sign agrees with the faces' prediction. Keeps MOST of a file, each with the
 * same probability. */
static void add_example(int kind, const int16_t *x, int first, uint32_t high)
{
    examples *set = &sets[kind][files];
    size_t to = set->count;
    set->seen++;
    if (to == MOST) {
        to = training_random(&random_state) % set->seen;
        if (to >= MOST)
            return;
    } else if (to == set->room) {
        set->room = set->room ? 2 * set->room : 4096;
        set->of = realloc(set->of, set->room * sizeof *set->of);
        if (!set->of)
            training_fail("no memory");
    }
    example *e = &set->of[to];
    set->count += to == set->count;
    memset(e, 0, sizeof *e);
    for (int i = 0; i < (kind ? CVOL_NEURAL_SIGN_INPUTS : INPUTS); i++) {
        if (x[i] < -128 || x[i] > 127)
            training_fail("an input is beyond its range");
        e->x[i] = (int8_t)x[i];
    }
    e->first = (int8_t)first;
    e->high = (int8_t)(high < OUTPUTS ? high : OUTPUTS);
}

/* The examples of a part's coefficients of one subband. */
static void add_part(cvol_neural_brick *b, cvol_neural_sub_block *p, int subband)
{
    cvol_neural_position q;
    cvol_neural_view view;
    int end = cvol_neural_begin_sub_block(&q, p, subband);
    if (!end)
        return;
    if (cvol_neural_has_last(p, subband)) {
        q.last = p->used - 1;
        end = p->used;
    }
    cvol_neural_view_sub_block(&view, b, p, cvol_neural_known_cube(p, subband));
    while (q.index < end) {
        const int32_t value = b->values[p->values + q.index];
        const uint32_t size = cvol_magnitude(value);
        cvol_neural_context l;
        cvol_neural_context_at(&l, b, &view, p, &q);
        add_example(0, l.x, q.index == q.last && !l.shift, size >> l.shift);
        if (size && cvol_neural_has_faces(p)) {
            int16_t x[CVOL_NEURAL_INPUTS] __attribute__((aligned(64)));
            cvol_neural_sign_inputs(x, b, p, &l, cvol_trellis_magnitude(q.state, size));
            add_example(1, x, 0, (value < 0) == (l.sum < 0));
        }
        cvol_neural_note_value(b, p, &view, &q, &l, size, value < 0);
    }
    cvol_neural_end_sub_block(b, p, &q, subband);
}

/* The examples of the brick that the coder encoded last. */
static void add_brick(cvol_brick_coder *coder)
{
    cvol_neural_brick *b = coder->neural;
    cvol_neural_start_coding(b);
    cvol_neural_find_neighbours(b);
    for (int i = 0; i < b->parts; i++)
        cvol_neural_note_head(b, &b->part[i], &coder->context);
    for (int subband = 0; subband < CVOL_SUBBANDS; subband++)
        for (int i = 0; i < b->parts; i++)
            if (b->part[i].scan && !b->part[i].finished)
                add_part(b, &b->part[i], subband);
}

/* Weighted counts of all files' tokens before coefficients. */
static double tokens[CVOL_ROWS][CVOL_TOKENS];

/* Adds a file's; a large file's tokens weigh less. */
static void add_tokens(const cvol_token_counts *counts)
{
    double all = 0;
    for (int r = CVOL_NEURAL_ROWS; r < CVOL_NEURAL_ROWS_END; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            all += (double)counts->of[r][t];
    for (int r = CVOL_NEURAL_ROWS; r < CVOL_NEURAL_ROWS_END && all > 0; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            tokens[r][t] += (double)counts->of[r][t] * sqrt(fmin(1, 40000 / all));
}

static void add_file(cvol_context *context, const char *path)
{
    static cvol_token_counts counts;
    cvol_array *array;
    cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    const int left_out = *path == '-';
    if (files == FILES)
        training_fail("too many files");
    if (!tables || !coder)
        training_fail("no memory");
    sets[0][files].left_out = sets[1][files].left_out = left_out;
    if (cvol_array_read(context, &array, path + left_out, 0))
        training_fail(cvol_context_message(context));
    if (!cvol_coding_of(array)->trellis)
        training_fail("a file without dependent coefficients");
    cvol_coding_own(array)->neural = 1;
    memset(&counts, 0, sizeof counts);
    for (size_t b = 0; b < cvol_brick_count(array); b++) {
        if (!cvol_brick_encode(coder, subbands, array, b))
            training_fail("no memory");
        cvol_brick_coder_count(coder, &counts);
        add_brick(coder);
    }
    if (!left_out)
        add_tokens(&counts);
    printf("%s: %zu magnitudes, %zu signs\n", path, sets[0][files].seen, sets[1][files].seen);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_free(&subbands[s]);
    cvol_brick_coder_free(coder);
    free(tables);
    cvol_array_free(array);
    files++;
}

/* ---- training --------------------------------------------------------------------------- */

#define CLIP (255 / 64.0f)

/* The same instructions for each lane, whatever the processor's width. */
#if defined(__x86_64__) && defined(__linux__) && !defined(TRAINING_ONE_SET)
#define EACH_SET __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define EACH_SET
#endif
enum { LANES = 16, GROUPS = BATCH / LANES };
typedef float lanes __attribute__((vector_size(4 * LANES)));

static lanes inputs[INPUTS][GROUPS], first[FIRST][GROUPS], second[SECOND][GROUPS],
    outs[OUTPUTS][GROUPS];

/* Computes a layer for all examples of a batch. */
EACH_SET static void forward(lanes (*restrict out)[GROUPS], lanes (*restrict in)[GROUPS],
                             const float *restrict weights, const float *restrict biases, int units,
                             int count, int cut)
{
    for (int j = 0; j < units; j++)
        for (int k = 0; k < GROUPS; k++) {
            lanes sum = biases[j] + (lanes){0};
            for (int i = 0; i < count; i++)
                sum += weights[j * count + i] * in[i][k];
            if (cut)
                for (int l = 0; l < LANES; l++)
                    sum[l] = sum[l] < 0 ? 0 : sum[l] > CLIP ? CLIP : sum[l];
            out[j][k] = sum;
        }
}

static float sum_of(lanes l)
{
    float sum = 0;
    for (int i = 0; i < LANES; i++)
        sum += l[i];
    return sum;
}

/* Adds to a layer's gradients. off_in: the gradient of its inputs, which were clamped, or NULL. */
EACH_SET static void backward(lanes (*restrict off_in)[GROUPS], float *restrict weights_off,
                              float *restrict biases_off, lanes (*restrict off)[GROUPS],
                              lanes (*restrict in)[GROUPS], const float *restrict weights,
                              int units, int count)
{
    for (int j = 0; j < units; j++) {
        lanes bias = {0};
        for (int k = 0; k < GROUPS; k++)
            bias += off[j][k];
        biases_off[j] += sum_of(bias);
        for (int i = 0; i < count; i++) {
            lanes sum = {0};
            for (int k = 0; k < GROUPS; k++)
                sum += off[j][k] * in[i][k];
            weights_off[j * count + i] += sum_of(sum);
        }
    }
    for (int i = 0; off_in && i < count; i++)
        for (int k = 0; k < GROUPS; k++) {
            lanes sum = {0};
            for (int j = 0; j < units; j++)
                sum += weights[j * count + i] * off[j][k];
            for (int l = 0; l < LANES; l++)
                sum[l] = in[i][k][l] <= 0 || in[i][k][l] >= CLIP ? 0 : sum[l];
            off_in[i][k] = sum;
        }
}

/* The bits of a batch; adds to the gradient, if it is not NULL. */
static double learn(network *gradient, const network *n, const example *const batch[BATCH],
                    int kind)
{
    static lanes outs_off[OUTPUTS][GROUPS], second_off[SECOND][GROUPS], first_off[FIRST][GROUPS];
    const int outputs = kind ? 1 : OUTPUTS;
    double bits = 0;
    for (int k = 0; k < BATCH; k++)
        for (int i = 0; i < INPUTS; i++)
            inputs[i][k / LANES][k % LANES] = (float)batch[k]->x[i] / 32;
    forward(first, inputs, n->first[0], n->first_bias, FIRST, INPUTS, 1);
    forward(second, first, n->second[0], n->second_bias, SECOND, FIRST, 1);
    forward(outs, second, n->third[0], n->third_bias, outputs, SECOND, 0);
    memset(outs_off, 0, sizeof outs_off);
    for (int k = 0; k < BATCH; k++) {
        const example *e = batch[k];
        const int end = kind ? 0 : e->high < OUTPUTS ? e->high : OUTPUTS - 1;
        for (int t = e->first; t <= end; t++) {
            const int bit = t < e->high;
            const float p = training_logistic(outs[t][k / LANES][k % LANES]);
            outs_off[t][k / LANES][k % LANES] = p - (float)bit;
            bits -= log2((double)(bit ? p : 1 - p) + 1e-9);
        }
    }
    if (!gradient)
        return bits;
    backward(second_off, gradient->third[0], gradient->third_bias, outs_off, second, n->third[0],
             outputs, SECOND);
    backward(first_off, gradient->second[0], gradient->second_bias, second_off, first, n->second[0],
             SECOND, FIRST);
    backward(NULL, gradient->first[0], gradient->first_bias, first_off, inputs, n->first[0], FIRST,
             INPUTS);
    return bits;
}

static void begin_layer(float *weights, float *biases, int units, int count)
{
    for (int i = 0; i < units * count; i++)
        weights[i] = ((float)(training_random(&random_state) % 65536) / 65536 - 0.5f) * 2 *
                     sqrtf(1.5f / (float)count);
    for (int j = 0; j < units; j++)
        biases[j] = 0.2f;
}

/* Takes the built-in numbers; a unit without any starts with random ones. */
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

static void take_network(network *n, const cvol_neural_network *from)
{
    take_layer(n->first[0], n->first_bias, from->first[0], from->first_bias, FIRST, INPUTS,
               32 * 4096);
    take_layer(n->second[0], n->second_bias, from->second[0], from->second_bias, SECOND, FIRST,
               64 * 4096);
    take_layer(n->third[0], n->third_bias, from->third[0], from->third_bias, OUTPUTS, SECOND,
               64 * 4096);
}

/* The weight of a file: less than proportional to its examples if it is large. */
static double share_of(const examples *set)
{
    const double count = (double)set->count;
    return set->left_out ? 0 : fmin(count, 300 * sqrt(count));
}

/* Falls from 1 to 0, smoothly, as x goes from 0 to 1. */
static double fall(double x)
{
    return 1 - x * x * (3 - 2 * x);
}

static void train(network *n, long steps, int kind, int continues)
{
    enum { WEIGHTS = sizeof *n / sizeof(float) };
    static network gradient, means, squares;
    float *of = (float *)n, *g = (float *)&gradient;
    training_adam adam = {(float *)&means, (float *)&squares, 1, 1};
    double until[FILES], all = 0, bits = 0;
    memset(&means, 0, sizeof means);
    memset(&squares, 0, sizeof squares);
    begin_layer(n->first[0], n->first_bias, FIRST, INPUTS);
    begin_layer(n->second[0], n->second_bias, SECOND, FIRST);
    begin_layer(n->third[0], n->third_bias, OUTPUTS, SECOND);
    if (continues)
        take_network(n, kind ? &cvol_neural_signs : &cvol_neural_magnitudes);
    for (int f = 0; f < files; f++)
        until[f] = all += share_of(&sets[kind][f]);
    if (steps && all <= 0)
        training_fail("no examples");
    for (long step = 1; step <= steps; step++) {
        const example *batch[BATCH];
        for (int k = 0; k < BATCH; k++) {
            const double at = (double)(training_random(&random_state) >> 11) * 0x1p-53 * all;
            int f = 0;
            while (f < files - 1 && until[f] <= at)
                f++;
            batch[k] = &sets[kind][f].of[training_random(&random_state) % sets[kind][f].count];
        }
        memset(&gradient, 0, sizeof gradient);
        bits += learn(&gradient, n, batch, kind);
        for (int i = 0; i < WEIGHTS; i++)
            g[i] /= BATCH;
        const double rate = (continues ? 0.0012 : 0.004) * fall((double)step / (double)steps) *
                            fmin(1, (double)step / 200);
        training_adam_step(&adam, of, g, WEIGHTS, (float)rate);
        for (int i = 0; i < WEIGHTS; i++) /* 16 bits hold it */
            of[i] = of[i] < -7.9f ? -7.9f : of[i] > 7.9f ? 7.9f : of[i];
        if (step % 5000 == 0) {
            printf("%ld: %.4f bits an example\n", step, bits / BATCH / 5000);
            fflush(stdout);
            bits = 0;
        }
    }
}

/* Prints the bits of the examples that are not used for training. */
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

static FILE *open_file(const char *folder, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (!file)
        training_fail("cannot write the numbers");
    return file;
}

static void put_network(const char *folder, const char *name, const network *n)
{
    FILE *file = open_file(folder, name);
    fprintf(file, "/* Of each layer the weights of a unit on each line, then the biases. */\n");
    put_layer(file, n->first[0], n->first_bias, FIRST, INPUTS, 32 * 4096, ",");
    put_layer(file, n->second[0], n->second_bias, SECOND, FIRST, 64 * 4096, ",");
    put_layer(file, n->third[0], n->third_bias, OUTPUTS, SECOND, 64 * 4096, "");
    if (fclose(file))
        training_fail("cannot write the numbers");
}

/* Writes the best rows for the tokens that were counted. */
static void put_rows(const char *folder, const char *start)
{
    static cvol_token_counts counts;
    char path[1024];
    cvol_token_tables *tables = cvol_token_tables_create();
    if (!tables)
        training_fail("no memory");
    training_read_codes(tables, start);
    for (int r = CVOL_NEURAL_ROWS; r < CVOL_NEURAL_ROWS_END; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            counts.of[r][t] = (uint64_t)(tokens[r][t] + 0.5);
    training_fit_rows(tables, &counts);
    snprintf(path, sizeof path, "%s/neural_rows.inc", folder);
    training_write_codes(path, "The codes of a row of tokens on each line.", tables,
                         CVOL_NEURAL_ROWS, CVOL_NEURAL_ROWS_END);
    free(tables);
}

int main(int argc, char **argv)
{
    static network magnitudes, signs;
    if (argc < 6)
        training_fail("usage: train_neural IN.inc OUT_FOLDER STEPS SIGN_STEPS FILE.cvol ...");
    const long steps = atol(argv[3]), sign_steps = atol(argv[4]);
    cvol_context *context = cvol_context_create();
    if (!context)
        training_fail("no memory");
    for (int f = 5; f < argc; f++)
        add_file(context, argv[f]);
    cvol_context_free(context);
    train(&magnitudes, labs(steps), 0, steps < 0);
    test(&magnitudes, 0);
    train(&signs, labs(sign_steps), 1, sign_steps < 0);
    test(&signs, 1);
    put_network(argv[2], "neural_magnitudes.inc", &magnitudes);
    put_network(argv[2], "neural_signs.inc", &signs);
    put_rows(argv[2], argv[1]);
    return 0;
}
