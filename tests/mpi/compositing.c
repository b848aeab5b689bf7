/* usage: mpirun -n N compositing [SEED]
 *
 * Pictures of several processes put together (mpi/exchange.h) equal those of one MPI_Reduce
 * (random_parts.h): random sparse images in every mode, in random orders. Messages and, of full
 * images, bytes are those of the theory of radix-k. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cvol/cvol.h"
#include "mpi/exchange.h"
#include "mpi/random_parts.h"

#define ROUNDS 30
/* The value of floats behind the lines, which stay. */
#define BEHIND 12345.0F

static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_ISO, CVOL_MODE_MIP, CVOL_MODE_MIN,
                                  CVOL_MODE_XRAY};

/* The same in all processes, but for `rank` and the content of the images. */
typedef struct test {
    int size, rank, *order; /* ranks from front to back */
    int place, root;        /* in the order: of this process, and of process 0 */
    cvol_context *context;
    cvol_mpi_parts parts;
    cvol_mode mode;
    cvol_sheet_lines own, expected;
} test;

static float *allocate(const cvol_sheet_lines *lines)
{
    float *values = malloc(lines->groups * lines->stride * sizeof *values);
    if (!values)
        MPI_Abort(MPI_COMM_WORLD, 1);
    for (size_t i = 0; i < lines->groups * lines->stride; i++)
        values[i] = BEHIND;
    return values;
}

/* The largest difference of two images, also of the floats behind the lines. */
static double difference(const cvol_sheet_lines *a, const cvol_sheet_lines *b)
{
    double most = 0;
    for (size_t i = 0; i < a->groups * a->stride; i++) {
        const double d = fabs((double)a->values[i] - (double)b->values[i]);
        if (!(d <= most))
            most = d;
    }
    return most;
}

/* A random order from front to back. */
static void shuffle(test *t, random_state *r)
{
    for (int i = 0; i < t->size; i++)
        t->order[i] = i;
    for (int i = t->size - 1; i > 0; i--) {
        const int j = (int)random_below(r, (uint32_t)i + 1), kept = t->order[i];
        t->order[i] = t->order[j];
        t->order[j] = kept;
    }
    for (int i = 0; i < t->size; i++) {
        t->place = t->order[i] == t->rank ? i : t->place;
        t->root = t->order[i] == 0 ? i : t->root;
    }
}

/* A rectangle; sometimes all of the image, or nothing. */
static void draw(const test *t, random_state *r)
{
    const size_t size[2] = {t->own.count, t->own.groups};
    size_t begin[2] = {0, 0}, end[2] = {size[0], size[1]};
    const uint32_t kind = random_below(r, 8);
    for (int a = 0; a < 2 && kind; a++) {
        begin[a] = random_below(r, (uint32_t)size[a]);
        end[a] = begin[a] + random_below(r, (uint32_t)(size[a] - begin[a]) + 1);
    }
    parts_clear(&t->own, t->mode);
    if (kind != 1)
        parts_fill(&t->own, begin, end, kind % 2 ? 1 : random_below(r, 1001) / 1000.0, t->mode, r);
}

/* Puts the images together in both ways. *traffic: what all processes sent. */
static double combine_both(test *t, cvol_mpi_traffic *traffic)
{
    MPI_Comm ordered;
    cvol_mpi_exchange exchange;
    memcpy(t->expected.values, t->own.values,
           t->own.groups * t->own.stride * sizeof *t->own.values);
    MPI_Comm_split(MPI_COMM_WORLD, 0, t->place, &ordered);
    parts_reduce(&t->expected, t->mode, t->root, ordered);
    MPI_Comm_free(&ordered);
    cvol_mpi_exchange_begin(&exchange, &t->parts, t->order, 0);
    const int code = exchange.combine.combine(exchange.combine.data, t->context, CVOL_OK, &t->own,
                                              t->mode);
    cvol_mpi_render_report report;
    cvol_mpi_exchange_end(&exchange);
    cvol_mpi_exchange_report(&report, &exchange);
    *traffic = (cvol_mpi_traffic){report.messages, report.bytes};
    if (code)
        return INFINITY;
    return t->rank ? 0 : difference(&t->own, &t->expected);
}

/* The theory: in each round all members send k - 1 messages. Together they have a number of copies
 * of the image, and send (k - 1)/k of each; then there are 1/k as many copies. */
static cvol_mpi_traffic theory(const test *t, size_t pixels, size_t own_piece, int has_own)
{
    const cvol_mpi_rounds rounds = cvol_mpi_rounds_of(t->size);
    const uint64_t members = (uint64_t)rounds.members, folded = (uint64_t)t->size - members,
                   bytes = t->mode == CVOL_MODE_COMPOSITE || t->mode == CVOL_MODE_ISO ? 16 : 8;
    uint64_t copies = members, messages = folded + members - (uint64_t)has_own,
             sent = pixels * folded + pixels - own_piece;
    for (int i = 0; i < rounds.count; i++) {
        const uint64_t k = (uint64_t)rounds.factors[i];
        messages += members * (k - 1);
        sent += copies / k * (k - 1) * pixels;
        copies /= k;
    }
    return (cvol_mpi_traffic){messages, sent * bytes + 16 * messages};
}

static int report(const test *t, const char *what, double a, double b, uint64_t seed)
{
    if (a <= b)
        return 0;
    printf("%d processes, mode %d, %zu x %zu, seed %llu: %s: %.17g, not %.17g\n", t->size,
           (int)t->mode, t->own.count, t->own.groups, (unsigned long long)seed, what, a, b);
    return 1;
}

/* Random images. Returns the number of failures. */
static int test_random(test *t, uint64_t seed)
{
    random_state common = {seed}, own = {seed + 1000003 * (uint64_t)(t->rank + 1)};
    int failures = 0;
    cvol_mpi_traffic traffic;
    t->own = (cvol_sheet_lines){.groups = 1 + random_below(&common, 40),
                                .count = 1 + random_below(&common, 90)};
    t->own.stride = (4 + PARTS_BEHIND) * t->own.count;
    t->expected = t->own;
    t->own.values = allocate(&t->own);
    t->expected.values = allocate(&t->own);
    shuffle(t, &common);
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m++) {
        t->mode = modes[m];
        draw(t, &own);
        const double d = combine_both(t, &traffic),
                     rounding = t->mode == CVOL_MODE_MIP || t->mode == CVOL_MODE_MIN ? 0
                                : t->mode == CVOL_MODE_XRAY ? 2e-6 * t->size
                                                            : 1e-6;
        failures += report(t, "difference", d, rounding, seed);
    }
    free(t->own.values);
    free(t->expected.values);
    return failures;
}

/* Full images: all messages have one run. */
static int test_traffic(test *t, uint64_t seed)
{
    random_state common = {seed}, own = {seed + 1000003 * (uint64_t)(t->rank + 1)};
    const size_t whole[2] = {96, 70}, zero[2] = {0, 0};
    int failures = 0;
    t->own = (cvol_sheet_lines){
        .groups = whole[1], .count = whole[0], .stride = (4 + PARTS_BEHIND) * whole[0]};
    t->expected = t->own;
    t->own.values = allocate(&t->own);
    t->expected.values = allocate(&t->own);
    shuffle(t, &common);
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m++) {
        cvol_mpi_traffic traffic;
        t->mode = modes[m];
        parts_clear(&t->own, t->mode);
        parts_fill(&t->own, zero, whole, 1, t->mode, &own);
        const double d = combine_both(t, &traffic);
        failures += report(t, "difference", d, 2e-6 * t->size, seed);
        /* the piece of process 0 is not sent to itself: all pieces have the same size within 1 */
        const cvol_mpi_rounds rounds = cvol_mpi_rounds_of(t->size);
        const int pairs = t->size - rounds.members,
                  has_own = t->root >= 2 * pairs || t->root % 2 == 0;
        const size_t pixels = whole[0] * whole[1], piece = pixels / (size_t)rounds.members;
        const cvol_mpi_traffic least = theory(t, pixels, has_own ? piece + (t->size > 1) : 0,
                                              has_own),
                               most = theory(t, pixels, has_own ? piece : 0, has_own);
        if (t->rank)
            continue;
        failures += report(t, "messages", (double)traffic.messages, (double)most.messages, seed);
        failures += report(t, "fewer messages", (double)least.messages, (double)traffic.messages,
                           seed);
        failures += report(t, "bytes", (double)traffic.bytes, (double)most.bytes, seed);
        failures += report(t, "fewer bytes", (double)least.bytes, (double)traffic.bytes, seed);
    }
    free(t->own.values);
    free(t->expected.values);
    return failures;
}

int main(int argc, char **argv)
{
    test t = {.context = cvol_context_create()};
    int failures = 0;
    MPI_Init(&argc, &argv);
    MPI_Comm_size(MPI_COMM_WORLD, &t.size);
    MPI_Comm_rank(MPI_COMM_WORLD, &t.rank);
    t.parts = (cvol_mpi_parts){.comm = MPI_COMM_WORLD, .size = t.size, .rank = t.rank};
    t.order = malloc((size_t)t.size * sizeof *t.order);
    uint64_t seed = argc > 1 ? strtoull(argv[1], NULL, 10) : (uint64_t)time(NULL);
    MPI_Bcast(&seed, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    if (!t.context || !t.order)
        MPI_Abort(MPI_COMM_WORLD, 1);
    for (uint64_t i = 0; i < ROUNDS; i++)
        failures += test_random(&t, seed + i);
    failures += test_traffic(&t, seed);
    MPI_Allreduce(MPI_IN_PLACE, &failures, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    if (!t.rank)
        printf("%d processes, seed %llu: %d failures\n", t.size, (unsigned long long)seed,
               failures);
    free(t.order);
    cvol_mpi_parts_free_memory(&t.parts);
    cvol_context_free(t.context);
    MPI_Finalize();
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
