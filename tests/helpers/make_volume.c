/* make_volume OUT TYPE NXxNYxNZ: writes raw samples, smooth with a little noise, low byte first.
 * The same arguments give the same bytes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/base.h"
#include "random.h"

enum { NOISE = 200 }; /* the smooth part has 1.5 times the amplitude of 1, the noise 1 / NOISE */

/* The range of samples of a type, as scanners and simulations have it. */
static void range_of(cvol_type type, double *low, double *high)
{
    static const double ranges[][2] = {
        [CVOL_UINT8] = {0, 255},       [CVOL_INT8] = {-128, 127},  [CVOL_UINT16] = {0, 4000},
        [CVOL_INT16] = {-1000, 3000},  [CVOL_UINT32] = {0, 1e5},   [CVOL_INT32] = {-5e4, 5e4},
        [CVOL_FLOAT32] = {-2.5, 10.5}, [CVOL_FLOAT64] = {0, 1e-3},
    };
    *low = ranges[type][0];
    *high = ranges[type][1];
}

/* At (x, y, z) in 0..1: waves and a ball with an edge; 0..1. */
static double smooth(double x, double y, double z)
{
    const double wave = sin(5 * x + 2 * z) * cos(4 * y) + sin(7 * z);
    const double dx = x - 0.45, dy = y - 0.5, dz = z - 0.55;
    const double ball = dx * dx + dy * dy + dz * dz < 0.09;
    return 0.1 + 0.1 * (2 + wave) + 0.4 * ball;
}

static void store(unsigned char *out, cvol_type type, double value)
{
    const size_t size = cvol_type_size(type);
    if (type == CVOL_FLOAT32) {
        const float f = (float)value;
        memcpy(out, &f, size);
    } else if (type == CVOL_FLOAT64)
        memcpy(out, &value, size);
    else {
        const int64_t whole = (int64_t)floor(value + 0.5);
        for (size_t i = 0; i < size; i++)
            out[i] = (unsigned char)((uint64_t)whole >> 8 * i);
    }
}

static int write_samples(FILE *file, cvol_type type, const size_t n[3])
{
    random_state r = {7};
    double low, high;
    range_of(type, &low, &high);
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++) {
                double v = smooth((double)x / (double)n[0], (double)y / (double)n[1],
                                  (double)z / (double)n[2]) +
                           random_signed(&r) / NOISE;
                unsigned char bytes[8];
                store(bytes, type, low + (high - low) * v);
                if (fwrite(bytes, cvol_type_size(type), 1, file) != 1)
                    return 0;
            }
    return 1;
}

int main(int argc, char **argv)
{
    size_t n[3];
    cvol_type type = argc == 4 ? cvol_type_from_name(argv[2]) : (cvol_type)0;
    if (!type || sscanf(argv[3], "%zux%zux%zu", &n[0], &n[1], &n[2]) != 3) {
        fputs("usage: make_volume OUT TYPE NXxNYxNZ\n", stderr);
        return 2;
    }
    FILE *file = fopen(argv[1], "wb");
    int done = file && write_samples(file, type, n);
    if (file && fclose(file))
        done = 0;
    if (!done)
        perror(argv[1]);
    return !done;
}
