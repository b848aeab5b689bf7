/* The speed of the codec itself: compressing samples in memory, reading a file's terms, and
 * evaluating samples. Reading the volume's own format and writing samples is not counted.
 *
 * usage: codec_speed VOLUME THREADS ROUNDS
 *
 * Prints a JSON object: Mvoxel/s of the best round, by processor time with one thread, by the clock
 * with more. Before they are timed the volume is compressed to each number of bits a sample.
 */
#define _POSIX_C_SOURCE 200809L /* clock_gettime, mkstemp */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "cvol/codec.h"
#include "cvol/volume.h"

typedef struct bench {
    cvol_context *context;
    cvol_volume *volume;
    void *decoded;
    size_t samples;
    int rounds;
    clockid_t clock;
    char path[32];
} bench;

static double seconds(const bench *b)
{
    struct timespec now;
    clock_gettime(b->clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void check(const bench *b, int code)
{
    if (!code)
        return;
    fprintf(stderr, "codec_speed: %s\n", cvol_context_message(b->context));
    exit(1);
}

static double rate(const bench *b, double best)
{
    return 1e-6 * (double)b->samples / best;
}

static void compress(const bench *b, const char *name, cvol_target target, double value, int fast)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_compress_report report;
    double best = DBL_MAX;
    options.target = target;
    options.target_value = value;
    options.effort = fast ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
    options.background = fast ? CVOL_BACKGROUND_NONE : CVOL_BACKGROUND_FIND; /* as the command */
    for (int round = 0; round < b->rounds; round++) {
        cvol_array *array;
        const double begin = seconds(b);
        check(b, cvol_compress(b->context, &array, &report, b->volume->data, &b->volume->grid,
                               &options));
        const double took = seconds(b) - begin;
        best = took < best ? took : best;
        if (round + 1 == b->rounds)
            check(b, cvol_array_write(b->context, array, b->path, NULL));
        cvol_array_free(array);
    }
    printf(",\n \"%s\": {\"compress\": %.2f, \"psnr_db\": %.3f, \"bits\": %.4f", name,
           rate(b, best), report.psnr_db, 8.0 * (double)report.file_bytes / (double)b->samples);
}

static void decode(const bench *b)
{
    static const size_t begin[3] = {0, 0, 0};
    double best = DBL_MAX, best_read = DBL_MAX;
    for (int round = 0; round < 2 * b->rounds; round++) {
        cvol_array *array;
        const double start = seconds(b);
        check(b, cvol_array_read(b->context, &array, b->path, NULL));
        const double read = seconds(b) - start;
        check(b,
              cvol_array_evaluate_box(b->context, b->decoded, array, begin, b->volume->grid.dims));
        const double took = seconds(b) - start;
        cvol_array_free(array);
        best = took < best ? took : best;
        best_read = read < best_read ? read : best_read;
    }
    printf(", \"decode\": %.1f, \"of_that_terms\": %.1f}", rate(b, best), rate(b, best_read));
}

int main(int argc, char **argv)
{
    bench b = {.context = cvol_context_create(), .path = "codec_speed_XXXXXX"};
    const int threads = argc > 2 ? atoi(argv[2]) : 0;
    b.rounds = argc > 3 ? atoi(argv[3]) : 0;
    if (argc != 4 || threads < 1 || b.rounds < 1) {
        fprintf(stderr, "usage: codec_speed VOLUME THREADS ROUNDS\n");
        return 2;
    }
    b.clock = threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
    cvol_context_set_threads(b.context, threads);
    check(&b, cvol_volume_read(b.context, &b.volume, argv[1], NULL));
    b.samples = cvol_grid_samples(&b.volume->grid);
    b.decoded = malloc(cvol_grid_bytes(&b.volume->grid));
    const int file = mkstemp(b.path);
    if (!b.decoded || file < 0) {
        fprintf(stderr, "codec_speed: no memory, or no temporary file in this folder\n");
        return 1;
    }
    close(file);
    printf("{\"voxels\": %zu, \"threads\": %d", b.samples, threads);
    compress(&b, "42 dB", CVOL_TARGET_PSNR, 42, 0);
    decode(&b);
    compress(&b, "42 dB, in haste", CVOL_TARGET_PSNR, 42, 1);
    decode(&b);
    b.rounds = b.rounds > 3 ? 3 : b.rounds;
    compress(&b, "0.3 bits", CVOL_TARGET_BITS, 0.3, 0);
    decode(&b);
    printf("}\n");
    unlink(b.path);
    free(b.decoded);
    cvol_volume_free(b.volume);
    cvol_context_free(b.context);
    return 0;
}
