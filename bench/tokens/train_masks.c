/* Trains the network that predicts masked samples (src/codec/tables/mask_network.inc,
 * mask_predict.h).
 *
 *     train_masks OUT.inc STEPS FILE[:NXxNYxNZ:TYPE]=VALUE | FILE[...]/VALUE ...
 *
 * Masks the samples of a volume that are equal to VALUE (=) or less than it (/). Takes examples
 * from each volume in four orders and directions of its axes, brick by brick: the samples that the
 * coder does not pass over as part of a stretch of equal ones. STEPS steps of Adam minimise the
 * bits that the examples take; 150000 are enough.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "codec/mask/mask_predict.h"
#include "training.h"

enum { SIDE = 64, HIDDEN = CVOL_MASK_HIDDEN, INPUTS = CVOL_MASK_NEIGHBOURS, BATCH = 64 };
enum { OF_VIEW = 300000, VIEWS = 4 };
#define UNIT_SCALE 128.0 /* one of a hidden unit's natural units */
#define OUT_SCALE 64.0

/* A sample's neighbours, one bit each, and the sample itself. */
typedef struct example {
    uint64_t neighbours;
    float masked;
} example;

typedef struct network {
    float weights[HIDDEN][INPUTS + 1]; /* of -1 and 1; the last one is the bias */
    float outs[HIDDEN + 1];
} network;

typedef struct view {
    size_t dims[3];
    uint8_t *masked;
} view;

static example *examples;
static size_t example_count, example_room;
static uint64_t random_state = TRAINING_SEED;

/* ---- examples --------------------------------------------------------------------------- */

/* A brick's samples. */
typedef struct brick {
    size_t size[3];
    int outside;
    uint8_t masked[SIDE][SIDE][SIDE];
} brick;

static int cut(int at, size_t size)
{
    return at < 0 ? 0 : at >= (int)size ? (int)size - 1 : at;
}

/* The known part of (x, y, z) when (at, y0, z0) is decoded (mask_code.h). */
static int known(const brick *b, int x, int y, int z, int y0, int z0)
{
    if (z == z0 && y == y0 && x < 0) {
        x = 0;
        y--;
    }
    if (z == z0 && y < 0) {
        z--;
        y = 0;
    }
    return z < 0 ? b->outside : b->masked[z][cut(y, b->size[1])][cut(x, b->size[0])];
}

static void add_example(const brick *b, int x, int y, int z)
{
    uint64_t bits = 0;
    int n = 0;
    for (int w = 0; w < CVOL_MASK_WINDOWS; w++) {
        const cvol_mask_window *window = &cvol_mask_windows[w];
        for (int k = 0; k < window->width; k++)
            bits |= (uint64_t)known(b, x + window->dx + k, y + window->dy, z + window->dz, y, z)
                    << n++;
    }
    if (example_count == example_room) {
        example_room = example_room ? 2 * example_room : 1 << 20;
        examples = realloc(examples, example_room * sizeof *examples);
        if (!examples)
            training_fail("no memory");
    }
    examples[example_count++] = (example){bits, b->masked[z][y][x]};
}

/* Tests if all samples near x in the rows before equal `left`. */
static int is_like(const brick *b, int x, int y, int z, int left)
{
    for (int i = x - 1; i <= x + 1; i++)
        for (int dy = -1; dy <= 1; dy++)
            if (known(b, i, y + dy, z - 1, y, z) != left ||
                (!dy && known(b, i, y - 1, z, y, z) != left))
                return 0;
    return 1;
}

/* A cell's row, as mask_code.c takes it. */
static void add_row(const brick *b, int begin, int end, int y, int z)
{
    for (int x = begin; x < end;) {
        const int left = known(b, x - 1, y, z, y, z);
        int stretch = 0, same = 1;
        while (x + stretch < end && is_like(b, x + stretch, y, z, left)) {
            same &= b->masked[z][y][x + stretch] == left;
            stretch++;
        }
        if (stretch < 2) {
            add_example(b, x++, y, z);
        } else if (same) {
            x += stretch;
        } else {
            for (; b->masked[z][y][x] == left; x++)
                add_example(b, x, y, z);
            add_example(b, x++, y, z);
        }
    }
}

static int is_mixed(const brick *b, const size_t cell[3])
{
    int found[2] = {0, 0};
    for (size_t z = cell[2]; z < cell[2] + 16 && z < b->size[2]; z++)
        for (size_t y = cell[1]; y < cell[1] + 16 && y < b->size[1]; y++)
            for (size_t x = cell[0]; x < cell[0] + 16 && x < b->size[0]; x++)
                found[b->masked[z][y][x]] = 1;
    return found[0] && found[1];
}

static void add_brick(const view *v, const size_t begin[3])
{
    static brick b;
    size_t first = 0;
    for (int a = 0; a < 3; a++)
        b.size[a] = v->dims[a] - begin[a] < SIDE ? v->dims[a] - begin[a] : SIDE;
    for (size_t z = 0; z < b.size[2]; z++)
        for (size_t y = 0; y < b.size[1]; y++)
            for (size_t x = 0; x < b.size[0]; x++) {
                const size_t line = begin[1] + y + v->dims[1] * (begin[2] + z);
                b.masked[z][y][x] = v->masked[begin[0] + x + v->dims[0] * line];
                first += !z && b.masked[z][y][x];
            }
    b.outside = 2 * first > b.size[0] * b.size[1];
    for (size_t z = 0; z < b.size[2]; z += 16)
        for (size_t y = 0; y < b.size[1]; y += 16)
            for (size_t x = 0; x < b.size[0]; x += 16) {
                const size_t cell[3] = {x, y, z};
                const size_t end = x + 16 < b.size[0] ? x + 16 : b.size[0];
                if (!is_mixed(&b, cell))
                    continue;
                for (size_t l = z; l < z + 16 && l < b.size[2]; l++)
                    for (size_t j = y; j < y + 16 && j < b.size[1]; j++)
                        add_row(&b, (int)x, (int)end, (int)j, (int)l);
            }
}

/* At most OF_VIEW examples of a view. */
static void add_view(const view *v)
{
    const size_t before = example_count;
    for (size_t z = 0; z < v->dims[2]; z += SIDE)
        for (size_t y = 0; y < v->dims[1]; y += SIDE)
            for (size_t x = 0; x < v->dims[0]; x += SIDE)
                add_brick(v, (size_t[3]){x, y, z});
    const size_t found = example_count - before;
    example *own = examples + before;
    for (size_t i = 0; i < OF_VIEW && found > OF_VIEW; i++) {
        const size_t j = i + training_random(&random_state) % (found - i);
        const example other = own[j];
        own[j] = own[i];
        own[i] = other;
    }
    example_count = before + (found < OF_VIEW ? found : OF_VIEW);
}

/* The axes in another order, some of them reversed. */
static void turn(view *to, const view *from, int number)
{
    static const int orders[VIEWS][3] = {{0, 1, 2}, {1, 2, 0}, {2, 1, 0}, {0, 2, 1}};
    const int *order = orders[number];
    for (int a = 0; a < 3; a++)
        to->dims[a] = from->dims[order[a]];
    size_t i = 0, at[3], place[3];
    for (at[2] = 0; at[2] < to->dims[2]; at[2]++)
        for (at[1] = 0; at[1] < to->dims[1]; at[1]++)
            for (at[0] = 0; at[0] < to->dims[0]; at[0]++, i++) {
                for (int a = 0; a < 3; a++)
                    place[order[a]] = number >> (a % 2) & 1 ? to->dims[a] - 1 - at[a] : at[a];
                to->masked[i] =
                    from->masked[place[0] + from->dims[0] * (place[1] + from->dims[1] * place[2])];
            }
}

static void add_volume(cvol_context *context, char *argument)
{
    char *value = strrchr(argument, '='), *slash = strrchr(argument, '/');
    const int below = !value;
    if (below)
        value = slash;
    if (!value)
        training_fail("a volume is FILE[:NXxNYxNZ:TYPE]=VALUE or FILE[...]/VALUE");
    *value = 0;
    cvol_volume *volume = training_read(context, argument);
    const double limit = volume->grid.type == CVOL_FLOAT32 ? (double)strtof(value + 1, NULL)
                                                           : strtod(value + 1, NULL);
    const size_t count = cvol_grid_samples(&volume->grid);
    view own = {{0}, malloc(count)}, turned = {{0}, malloc(count)};
    if (!own.masked || !turned.masked)
        training_fail("no memory");
    memcpy(own.dims, volume->grid.dims, sizeof own.dims);
#define LOOK(name, type)                                                                     \
    case name:                                                                               \
        for (size_t i = 0; i < count; i++) {                                                 \
            const double sample = (double)((const type *)volume->data)[i];                   \
            own.masked[i] = below ? sample < limit : !(sample < limit) && !(sample > limit); \
        }                                                                                    \
        break
    switch (volume->grid.type) {
        LOOK(CVOL_UINT8, uint8_t);
        LOOK(CVOL_UINT16, uint16_t);
        LOOK(CVOL_INT16, int16_t);
        LOOK(CVOL_FLOAT32, float);
    default:
        training_fail("a type that is not trained on");
    }
#undef LOOK
    for (int number = 0; number < VIEWS; number++) {
        turn(&turned, &own, number);
        add_view(&turned);
    }
    printf("%s: %zu examples so far\n", argument, example_count);
    free(own.masked);
    free(turned.masked);
    cvol_volume_free(volume);
}

/* ---- training --------------------------------------------------------------------------- */

/* Adds the gradient of one example's bits; returns the bits. */
static double learn(network *gradient, const network *n, const example *e)
{
    float hidden[HIDDEN], sum = n->outs[HIDDEN];
    for (int i = 0; i < HIDDEN; i++) {
        float unit = n->weights[i][INPUTS];
        for (int k = 0; k < INPUTS; k++)
            unit += e->neighbours >> k & 1 ? n->weights[i][k] : -n->weights[i][k];
        hidden[i] = unit > 0 ? unit : 0;
        sum += n->outs[i] * hidden[i];
    }
    const float p = training_logistic(sum), off = p - e->masked;
    gradient->outs[HIDDEN] += off;
    for (int i = 0; i < HIDDEN; i++) {
        const float own = hidden[i] > 0 ? off * n->outs[i] : 0;
        gradient->outs[i] += off * hidden[i];
        gradient->weights[i][INPUTS] += own;
        for (int k = 0; k < INPUTS; k++)
            gradient->weights[i][k] += e->neighbours >> k & 1 ? own : -own;
    }
    return -log2((double)(e->masked > 0.5f ? p : 1 - p) + 1e-9);
}

static void train(network *n, long steps)
{
    enum { WEIGHTS = sizeof *n / sizeof(float) };
    static network gradient, means, squares;
    float *of = (float *)n, *g = (float *)&gradient;
    training_adam adam = {(float *)&means, (float *)&squares, 1, 1};
    double bits = 0;
    for (size_t i = 0; i < WEIGHTS; i++)
        of[i] = ((float)(training_random(&random_state) % 65536) / 65536 - 0.5f) *
                (i < HIDDEN * (INPUTS + 1) ? 0.3f : 1);
    for (long step = 1; step <= steps; step++) {
        memset(&gradient, 0, sizeof gradient);
        for (int i = 0; i < BATCH; i++)
            bits += learn(&gradient, n, &examples[training_random(&random_state) % example_count]);
        for (size_t i = 0; i < WEIGHTS; i++)
            g[i] /= BATCH;
        training_adam_step(&adam, of, g, WEIGHTS,
                           0.004f * (1 - (float)step / (float)steps) + 2e-5f);
        if (step % 10000 == 0) {
            printf("%ld: %.4f bits an example\n", step, bits / BATCH / 10000);
            fflush(stdout);
            bits = 0;
        }
    }
}

/* ---- writing ---------------------------------------------------------------------------- */

static void put_row(FILE *file, const long values[HIDDEN], const char *end)
{
    for (int i = 0; i < HIDDEN; i++)
        fprintf(file, "%s%ld", i ? ", " : "{", values[i]);
    fprintf(file, "}%s\n", end);
}

/* Writes integers, for inputs of 0 and 1 in place of -1 and 1. */
static void write_weights(const char *path, const network *n)
{
    FILE *file = fopen(path, "w");
    long row[HIDDEN], biases[HIDDEN], least[HIDDEN], most[HIDDEN];
    if (!file)
        training_fail("cannot write the weights");
    for (int i = 0; i < HIDDEN; i++) {
        double bias = (double)n->weights[i][INPUTS];
        for (int k = 0; k < INPUTS; k++)
            bias -= (double)n->weights[i][k];
        least[i] = most[i] = biases[i] = lrint(UNIT_SCALE * bias);
    }
    fprintf(file, "/* The weights of a neighbour on each line, biases, weights of units, their "
                  "bias. */\n{\n");
    for (int k = 0; k < INPUTS; k++) {
        for (int i = 0; i < HIDDEN; i++) {
            row[i] = lrint(2 * UNIT_SCALE * (double)n->weights[i][k]);
            least[i] += row[i] < 0 ? row[i] : 0;
            most[i] += row[i] > 0 ? row[i] : 0;
            if (least[i] < INT16_MIN || most[i] > INT16_MAX)
                training_fail("weights are too large");
        }
        put_row(file, row, ",");
    }
    fprintf(file, "},\n");
    put_row(file, biases, ",");
    for (int i = 0; i < HIDDEN; i++)
        row[i] = lrint(OUT_SCALE * (double)n->outs[i]);
    put_row(file, row, ",");
    fprintf(file, "%ld\n", lrint(UNIT_SCALE * OUT_SCALE * (double)n->outs[HIDDEN]));
    if (fclose(file))
        training_fail("cannot write the weights");
}

int main(int argc, char **argv)
{
    if (argc < 4)
        training_fail("usage: train_masks OUT.inc STEPS VOLUME ...");
    static network trained;
    cvol_context *context = cvol_context_create();
    if (!context)
        training_fail("no memory");
    for (int f = 3; f < argc; f++)
        add_volume(context, argv[f]);
    train(&trained, atol(argv[2]));
    write_weights(argv[1], &trained);
    free(examples);
    cvol_context_free(context);
    return 0;
}
