/* usage: mpirun -n N compositing_speed WIDTH HEIGHT REPEATS
 *
 * Times ways to put the pictures of N parts together: radix-k (mpi/radix_k.h), one MPI_Reduce of
 * whole images, and IceT where it is linked (BENCH_ICET). The parts are boxes that fill a box with
 * even extinction, seen at an angle, so the transmittance of the result is known. The repeats take
 * turns. Process 0 prints one JSON object: seconds are those of the slowest process, the least and
 * the median of the repeats. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/cvol.h"
#include "mpi/exchange.h"
#include "mpi/random_parts.h"

#ifdef BENCH_ICET
#include <IceT.h>
#include <IceTMPI.h>
#endif

#define MOST_REPEATS 99

typedef struct box {
    double from[3], to[3];
} box;

static const box whole = {{-1, -0.75, -0.5}, {1, 0.75, 0.5}};
/* An orthonormal system: right, up, and from the eye into the picture. */
static const double right[3] = {0.8, 0.6, 0}, up[3] = {-0.36, 0.48, 0.8},
                    ahead[3] = {0.48, -0.64, 0.6};
/* Extinction, by length. */
#define EXTINCTION 0.7

typedef struct bench {
    int size, rank, repeats;
    int *order; /* ranks from front to back */
    box own;
    double scale[2]; /* of the picture's half sides */
    cvol_context *context;
    cvol_mpi_parts parts;
    cvol_sheet_lines image, work;
    size_t shown; /* pixels */
} bench;

/* ---- parts --------------------------------------------------------------------------------- */

/* Halves a box across its longest side until each rank has one. */
static void divide(bench *b, box part, int first, int count, int *placed)
{
    if (count == 1) {
        b->order[(*placed)++] = first;
        if (first == b->rank)
            b->own = part;
        return;
    }
    int axis = 0;
    for (int a = 1; a < 3; a++)
        if (part.to[a] - part.from[a] > part.to[axis] - part.from[axis])
            axis = a;
    const int half = count / 2;
    box both[2] = {part, part};
    const double at = part.from[axis] + (part.to[axis] - part.from[axis]) * half / count;
    both[0].to[axis] = both[1].from[axis] = at;
    const int nearest = ahead[axis] < 0;
    for (int k = 0; k < 2; k++) {
        const int which = k ? !nearest : nearest;
        divide(b, both[which], which ? first + half : first, which ? count - half : half, placed);
    }
}

/* The length of a ray in a box, through the point x right + y up. */
static double length_in(const box *part, double x, double y)
{
    double from = -10, to = 10;
    for (int a = 0; a < 3; a++) {
        const double start = x * right[a] + y * up[a], one = (part->from[a] - start) / ahead[a],
                     other = (part->to[a] - start) / ahead[a];
        from = fmax(from, fmin(one, other));
        to = fmin(to, fmax(one, other));
    }
    return fmax(to - from, 0);
}

static double ray_length(const bench *b, const box *part, size_t g, size_t i)
{
    return length_in(part, b->scale[0] * (2 * ((double)i + 0.5) / (double)b->image.count - 1),
                     b->scale[1] * (2 * ((double)g + 0.5) / (double)b->image.groups - 1));
}

static void draw(bench *b)
{
    const size_t n = b->image.count;
    for (int a = 0; a < 3; a++) {
        b->scale[0] += fabs(right[a]) * whole.to[a];
        b->scale[1] += fabs(up[a]) * whole.to[a];
    }
    parts_clear(&b->image, CVOL_MODE_COMPOSITE);
    for (size_t g = 0; g < b->image.groups; g++)
        for (size_t i = 0; i < n; i++) {
            const double length = ray_length(b, &b->own, g, i);
            float *pixel = b->image.values + b->image.stride * g + i;
            if (!(length > 0))
                continue;
            pixel[3 * n] = (float)exp(-EXTINCTION * length);
            for (size_t k = 0; k < 3; k++)
                pixel[k * n] = (1 - pixel[3 * n]) * (float)(k + 1) / 3;
            b->shown += pixel[3 * n] < 1;
        }
}

/* The largest error of the transmittance in process 0. */
static double find_error(const bench *b, const cvol_sheet_lines *image)
{
    double most = 0;
    for (size_t g = 0; g < image->groups && !b->rank; g++)
        for (size_t i = 0; i < image->count; i++) {
            const double exact = exp(-EXTINCTION * ray_length(b, &whole, g, i)),
                         is = (double)image->values[image->stride * g + 3 * image->count + i];
            most = fmax(most, fabs(is - exact));
        }
    return most;
}

/* ---- ways ---------------------------------------------------------------------------------- */

typedef struct way {
    const char *name;
    double seconds[MOST_REPEATS], composite[MOST_REPEATS], gather[MOST_REPEATS];
    uint64_t messages, bytes, most_bytes;
    double error;
} way;

static void restore(const bench *b)
{
    memcpy(b->work.values, b->image.values,
           b->image.groups * b->image.stride * sizeof *b->image.values);
}

static void run_radix_k(bench *b, way *w, int repeat)
{
    cvol_mpi_exchange exchange;
    cvol_mpi_render_report report;
    restore(b);
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    cvol_mpi_exchange_begin(&exchange, &b->parts, b->order, 0);
    if (exchange.combine.combine(exchange.combine.data, b->context, CVOL_OK, &b->work,
                                 CVOL_MODE_COMPOSITE))
        MPI_Abort(MPI_COMM_WORLD, 1);
    w->seconds[repeat] = MPI_Wtime() - start;
    cvol_mpi_exchange_end(&exchange, &report);
    w->composite[repeat] = report.composite_s;
    w->gather[repeat] = report.gather_s;
    w->messages = report.messages;
    w->bytes = report.bytes;
    w->most_bytes = report.most_bytes;
    if (!repeat)
        w->error = find_error(b, &b->work);
}

static void run_reduce(const bench *b, way *w, int repeat)
{
    int place = 0, root = 0;
    MPI_Comm ordered;
    while (b->order[place] != b->rank)
        place++;
    while (b->order[root])
        root++;
    restore(b);
    MPI_Comm_split(MPI_COMM_WORLD, 0, place, &ordered);
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    parts_reduce(&b->work, CVOL_MODE_COMPOSITE, root, ordered);
    w->seconds[repeat] = MPI_Wtime() - start;
    MPI_Comm_free(&ordered);
    if (!repeat)
        w->error = find_error(b, &b->work);
}

#ifdef BENCH_ICET
static float *pixels; /* RGBA */

static void begin_icet(const bench *b)
{
    const size_t n = b->image.count;
    const IceTCommunicator communicator = icetCreateMPICommunicator(MPI_COMM_WORLD);
    pixels = malloc(4 * n * b->image.groups * sizeof *pixels);
    if (!pixels)
        MPI_Abort(MPI_COMM_WORLD, 1);
    for (size_t g = 0; g < b->image.groups; g++)
        for (size_t i = 0; i < n; i++)
            for (size_t k = 0; k < 4; k++) {
                const float value = b->image.values[b->image.stride * g + k * n + i];
                pixels[4 * (g * n + i) + k] = k < 3 ? value : 1 - value;
            }
    icetCreateContext(communicator);
    icetDestroyMPICommunicator(communicator);
    icetResetTiles();
    icetAddTile(0, 0, (IceTSizeType)n, (IceTSizeType)b->image.groups, 0);
    icetStrategy(ICET_STRATEGY_SEQUENTIAL);
    icetSingleImageStrategy(ICET_SINGLE_IMAGE_STRATEGY_RADIXK);
    icetCompositeMode(ICET_COMPOSITE_MODE_BLEND);
    icetSetColorFormat(ICET_IMAGE_COLOR_RGBA_FLOAT);
    icetSetDepthFormat(ICET_IMAGE_DEPTH_NONE);
    icetEnable(ICET_ORDERED_COMPOSITE);
    icetDisable(ICET_CORRECT_COLORED_BACKGROUND);
    icetCompositeOrder(b->order);
}

/* The rectangle that holds the part. */
static void find_rectangle(const bench *b, IceTInt rectangle[4])
{
    const double side[2] = {(double)b->image.count, (double)b->image.groups};
    const double *axes[2] = {right, up};
    for (int k = 0; k < 2; k++) {
        double least = 0, most = 0;
        for (int a = 0; a < 3; a++) {
            least += fmin(axes[k][a] * b->own.from[a], axes[k][a] * b->own.to[a]);
            most += fmax(axes[k][a] * b->own.from[a], axes[k][a] * b->own.to[a]);
        }
        const double begin = fmax(floor((least / b->scale[k] + 1) / 2 * side[k]), 0),
                     end = fmin(ceil((most / b->scale[k] + 1) / 2 * side[k]), side[k]);
        rectangle[k] = (IceTInt)begin;
        rectangle[2 + k] = (IceTInt)(end - begin);
    }
}

static void run_icet(const bench *b, way *w, int repeat)
{
    static const IceTFloat black[4] = {0, 0, 0, 0};
    static const IceTDouble identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    IceTInt rectangle[4], sent;
    IceTDouble composite, collect;
    find_rectangle(b, rectangle);
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    const IceTImage image = icetCompositeImage(pixels, NULL, rectangle, identity, identity, black);
    w->seconds[repeat] = MPI_Wtime() - start;
    icetGetIntegerv(ICET_BYTES_SENT, &sent);
    icetGetDoublev(ICET_COMPOSITE_TIME, &composite);
    icetGetDoublev(ICET_COLLECT_TIME, &collect);
    double most[2] = {composite, collect};
    const uint64_t bytes = (uint64_t)sent;
    MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    MPI_Allreduce(&bytes, &w->bytes, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(&bytes, &w->most_bytes, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
    w->composite[repeat] = most[0];
    w->gather[repeat] = most[1];
    if (repeat || b->rank)
        return;
    const IceTFloat *from = icetImageGetColorcf(image);
    const size_t n = b->image.count;
    for (size_t g = 0; g < b->image.groups; g++)
        for (size_t i = 0; i < n; i++)
            b->work.values[b->work.stride * g + 3 * n + i] = 1 - from[4 * (g * n + i) + 3];
    w->error = find_error(b, &b->work);
}
#endif

/* ---- reporting ----------------------------------------------------------------------------- */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_seconds(const char *name, double *seconds, int repeats, int rank)
{
    MPI_Allreduce(MPI_IN_PLACE, seconds, repeats, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    qsort(seconds, (size_t)repeats, sizeof *seconds, compare);
    if (!rank)
        printf(", \"%s\": {\"min\": %.9f, \"median\": %.9f}", name, seconds[0],
               seconds[repeats / 2]);
}

static void print_way(const bench *b, way *w)
{
    if (!b->rank)
        printf(", \"%s\": {\"messages\": %llu, \"bytes\": %llu, \"most_bytes\": %llu, "
               "\"error\": %.3g",
               w->name, (unsigned long long)w->messages, (unsigned long long)w->bytes,
               (unsigned long long)w->most_bytes, w->error);
    print_seconds("total_s", w->seconds, b->repeats, b->rank);
    print_seconds("composite_s", w->composite, b->repeats, b->rank);
    print_seconds("gather_s", w->gather, b->repeats, b->rank);
    if (!b->rank)
        printf("}");
}

static void measure(bench *b)
{
    static way radix_k = {.name = "radix_k"}, reduce = {.name = "reduce"};
    uint64_t shown = b->shown, most = b->shown;
    const cvol_mpi_rounds rounds = cvol_mpi_rounds_of(b->size);
#ifdef BENCH_ICET
    static way icet = {.name = "icet"};
    begin_icet(b);
#endif
    for (int i = 0; i < b->repeats; i++) {
        run_radix_k(b, &radix_k, i);
        run_reduce(b, &reduce, i);
#ifdef BENCH_ICET
        run_icet(b, &icet, i);
#endif
    }
    MPI_Allreduce(MPI_IN_PLACE, &shown, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
    if (!b->rank) {
        printf("{\"processes\": %d, \"width\": %zu, \"height\": %zu, \"shown\": %llu, "
               "\"most_shown\": %llu, \"members\": %d, \"factors\": [",
               b->size, b->image.count, b->image.groups, (unsigned long long)shown,
               (unsigned long long)most, rounds.members);
        for (int i = 0; i < rounds.count; i++)
            printf("%s%d", i ? ", " : "", rounds.factors[i]);
        printf("]");
    }
    print_way(b, &radix_k);
    print_way(b, &reduce);
#ifdef BENCH_ICET
    print_way(b, &icet);
#endif
    if (!b->rank)
        puts("}");
}

int main(int argc, char **argv)
{
    bench b = {.context = cvol_context_create()};
    int placed = 0;
    MPI_Init(&argc, &argv);
    MPI_Comm_size(MPI_COMM_WORLD, &b.size);
    MPI_Comm_rank(MPI_COMM_WORLD, &b.rank);
    const long width = argc == 4 ? atol(argv[1]) : 0, height = argc == 4 ? atol(argv[2]) : 0;
    b.repeats = argc == 4 ? atoi(argv[3]) : 0;
    if (width < 1 || height < 1 || b.repeats < 1 || b.repeats > MOST_REPEATS) {
        if (!b.rank)
            fputs("usage: mpirun -n N compositing_speed WIDTH HEIGHT REPEATS (1 to 99)\n", stderr);
        MPI_Finalize();
        return 2;
    }
    b.image = (cvol_sheet_lines){
        .groups = (size_t)height, .count = (size_t)width, .stride = 4 * (size_t)width};
    b.work = b.image;
    b.parts = (cvol_mpi_parts){.comm = MPI_COMM_WORLD, .size = b.size, .rank = b.rank};
    b.order = malloc((size_t)b.size * sizeof *b.order);
    b.image.values = malloc(b.image.groups * b.image.stride * sizeof *b.image.values);
    b.work.values = malloc(b.image.groups * b.image.stride * sizeof *b.image.values);
    if (!b.order || !b.image.values || !b.work.values || !b.context)
        MPI_Abort(MPI_COMM_WORLD, 1);
    divide(&b, whole, 0, b.size, &placed);
    draw(&b);
    measure(&b);
    free(b.order);
    cvol_mpi_parts_free_memory(&b.parts);
    free(b.image.values);
    free(b.work.values);
    cvol_context_free(b.context);
    MPI_Finalize();
    return 0;
}
