/* usage: make_field OUT KIND NXxNYxNZ SPACING DEGREES X,Y,Z [SPACE]
 *
 * Samples a field of the world, whose lengths are millimetres, on a grid with this centre, turned
 * about the axis (1, 2, 3), and writes a volume. KIND:
 *
 *     head    a ball of radius 80 about the origin, with a soft edge
 *     spots   three Gaussians: of 14 within the ball, of 8 near its surface, and of 10 outside
 *     labels  1, 2 and 3 in spheres around the middles of the spots
 *     atlas   cubes within the ball: 500, 513, 526, ...; 0 outside
 *
 * SPACE: RAS (default), LPS, or none. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/volume.h"

static const double spots[3][4] = {{20, -25, 10, 14}, {-40, -55, 25, 8}, {75, -20, 60, 10}};

static double field_at(const char *kind, const double p[3])
{
    const double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    double sum = 0;
    if (!strcmp(kind, "head"))
        return 100 * fmin(fmax((82 - r) / 4, 0), 1);
    if (!strcmp(kind, "atlas"))
        return r < 80 ? 500 + 13 * (floor(p[0] / 40 + 2) + 4 * floor(p[1] / 40 + 2) +
                                    16 * floor(p[2] / 40 + 2))
                      : 0;
    for (int k = 0; k < 3; k++) {
        double square = 0;
        for (int a = 0; a < 3; a++)
            square += (p[a] - spots[k][a]) * (p[a] - spots[k][a]);
        const double part = square / (spots[k][3] * spots[k][3]);
        if (!strcmp(kind, "labels") && part < 1)
            return k + 1;
        sum += strcmp(kind, "labels") ? (k + 8) * exp(-part / 2) : 0;
    }
    return sum;
}

/* Rodrigues' rotation about (1, 2, 3). */
static void turn(double out[3], const double v[3], double degrees)
{
    const double pi = 3.14159265358979323846, length = sqrt(14), c = cos(degrees * pi / 180),
                 s = sin(degrees * pi / 180);
    const double k[3] = {1 / length, 2 / length, 3 / length};
    const double along = k[0] * v[0] + k[1] * v[1] + k[2] * v[2];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, d = (a + 2) % 3;
        out[a] = v[a] * c + (k[b] * v[d] - k[d] * v[b]) * s + k[a] * along * (1 - c);
    }
}

static void set_geometry(cvol_grid *grid, double spacing, double degrees, const double centre[3])
{
    for (int a = 0; a < 3; a++) {
        double axis[3] = {0};
        axis[a] = 1;
        turn(grid->direction[a], axis, degrees);
        grid->spacing[a] = spacing;
        grid->origin[a] = centre[a];
    }
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            grid->origin[i] -= grid->direction[a][i] * spacing * (double)(grid->dims[a] - 1) / 2;
}

static void fill(cvol_volume *volume, const char *kind)
{
    const cvol_grid *g = &volume->grid;
    const size_t count = cvol_grid_samples(g);
    const double flip = g->space == CVOL_SPACE_LPS ? -1 : 1;
    for (size_t i = 0; i < count; i++) {
        const size_t at[3] = {i % g->dims[0], i / g->dims[0] % g->dims[1],
                              i / g->dims[0] / g->dims[1]};
        double p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = g->origin[k];
            for (int a = 0; a < 3; a++)
                p[k] += g->direction[a][k] * g->spacing[a] * (double)at[a];
            p[k] *= k < 2 ? flip : 1; /* the field is in RAS */
        }
        if (g->type == CVOL_UINT8)
            ((uint8_t *)volume->data)[i] = (uint8_t)(field_at(kind, p) + 0.5);
        else if (g->type == CVOL_INT16)
            ((int16_t *)volume->data)[i] = (int16_t)field_at(kind, p);
        else
            ((float *)volume->data)[i] = (float)field_at(kind, p);
    }
}

int main(int argc, char **argv)
{
    size_t n[3];
    double centre[3];
    if (argc < 7 || sscanf(argv[3], "%zux%zux%zu", &n[0], &n[1], &n[2]) != 3 ||
        sscanf(argv[6], "%lf,%lf,%lf", &centre[0], &centre[1], &centre[2]) != 3) {
        fprintf(stderr, "usage: make_field OUT KIND NXxNYxNZ SPACING DEGREES X,Y,Z [SPACE]\n");
        return 2;
    }
    const char *kind = argv[2], *space = argc > 7 ? argv[7] : "RAS";
    cvol_context *context = cvol_context_create();
    cvol_grid grid = cvol_grid_make(n[0], n[1], n[2],
                                    !strcmp(kind, "spots")   ? CVOL_FLOAT32
                                    : !strcmp(kind, "atlas") ? CVOL_INT16
                                                             : CVOL_UINT8);
    cvol_volume *volume = NULL;
    grid.space = !strcmp(space, "RAS")   ? CVOL_SPACE_RAS
                 : !strcmp(space, "LPS") ? CVOL_SPACE_LPS
                                         : CVOL_SPACE_UNKNOWN;
    set_geometry(&grid, atof(argv[4]), atof(argv[5]), centre);
    int code = cvol_volume_create(context, &volume, &grid);
    if (!code) {
        fill(volume, kind);
        code = cvol_volume_write(context, volume, argv[1]);
    }
    if (code)
        fprintf(stderr, "make_field: %s\n", cvol_context_message(context));
    cvol_volume_free(volume);
    cvol_context_free(context);
    return code != 0;
}
