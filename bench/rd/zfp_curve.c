/* zfp's rate-distortion curve in accuracy mode: float32 samples (x fastest) from a file, tolerances
 * of the range times 2^-1 .. 2^-STEPS.
 *
 * usage: zfp_curve NX NY NZ FILE.raw STEPS
 *
 * Prints a JSON array of {"tolerance", "bytes", "psnr_db", "compress_s", "decompress_s"}; PSNR over
 * the range of the samples, of the decoded samples. One thread, processor time.
 */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zfp.h>

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void stop(const char *what)
{
    fprintf(stderr, "zfp_curve: %s\n", what);
    exit(1);
}

enum { COARSEST = 8 };

typedef struct curve {
    float *samples, *decoded;
    size_t count;
    double range;
    void *buffer;
    size_t capacity;
} curve;

static void measure(const curve *c, const size_t n[3], double tolerance, int first)
{
    zfp_stream *stream = zfp_stream_open(NULL);
    bitstream *bits = stream_open(c->buffer, c->capacity);
    zfp_stream_set_bit_stream(stream, bits);
    zfp_stream_set_accuracy(stream, tolerance);
    zfp_field *field = zfp_field_3d(c->samples, zfp_type_float, n[0], n[1], n[2]);
    const double begin = seconds();
    zfp_stream_rewind(stream);
    const size_t bytes = zfp_compress(stream, field);
    const double middle = seconds();
    zfp_field_set_pointer(field, c->decoded);
    zfp_stream_rewind(stream);
    if (!bytes || !zfp_decompress(stream, field))
        stop("zfp failed");
    const double end = seconds();
    double squares = 0;
    for (size_t i = 0; i < c->count; i++) {
        const double error = (double)c->samples[i] - (double)c->decoded[i];
        squares += error * error;
    }
    printf("%s{\"tolerance\": %.9g, \"bytes\": %zu, ", first ? "" : ", ", tolerance, bytes);
    if (squares > 0)
        printf("\"psnr_db\": %.6f, ", 10 * log10(c->range * c->range * (double)c->count / squares));
    else
        printf("\"psnr_db\": null, ");
    printf("\"compress_s\": %.6f, \"decompress_s\": %.6f}", middle - begin, end - middle);
    zfp_field_free(field);
    zfp_stream_close(stream);
    stream_close(bits);
}

int main(int count, char **texts)
{
    if (count != 6)
        stop("usage: zfp_curve NX NY NZ FILE.raw STEPS");
    size_t n[3];
    curve c = {.count = 1};
    for (int a = 0; a < 3; a++) {
        n[a] = strtoul(texts[1 + a], NULL, 10);
        c.count *= n[a];
    }
    c.samples = malloc(c.count * sizeof *c.samples);
    c.decoded = malloc(c.count * sizeof *c.decoded);
    FILE *file = fopen(texts[4], "rb");
    if (!c.count || !c.samples || !c.decoded || !file ||
        fread(c.samples, sizeof *c.samples, c.count, file) != c.count)
        stop("cannot read the samples");
    fclose(file);
    float low = c.samples[0], high = low;
    for (size_t i = 0; i < c.count; i++) {
        low = fminf(low, c.samples[i]);
        high = fmaxf(high, c.samples[i]);
    }
    c.range = (double)high - (double)low;
    c.capacity = 2 * c.count * sizeof *c.samples + 4096;
    c.buffer = malloc(c.capacity);
    if (!c.buffer)
        stop("no memory");
    printf("[");
    const int steps = atoi(texts[5]);
    for (int k = -COARSEST; k <= steps; k++)
        measure(&c, n, ldexp(c.range, -k), k == -COARSEST);
    printf("]\n");
    free(c.samples);
    free(c.decoded);
    free(c.buffer);
    return 0;
}
