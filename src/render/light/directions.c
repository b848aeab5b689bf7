/* Directions of light (directions.h): the i-th of n takes the numbers (i + 1/2) / n and the
 * fraction of i times the golden ratio, which spread evenly over a square, and maps it to the disc
 * or the sphere by equal areas or densities. */
#include "render/light/directions.h"

#include <math.h>

/* The cosine of 12 degrees. */
#define DISC_COSINE 0.97814760073
#define GOLDEN 0.61803398875
#define TURN 6.28318530718

cvol_directions cvol_directions_make(const cvol_view *view, const cvol_render_options *options)
{
    const double *given = options->shading.light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    const int samples = options->illumination.samples;
    cvol_directions out = {.disc = samples / 4 > 1 ? samples / 4 : 1};
    out.sky = samples - out.disc;
    for (int a = 0; a < 3; a++)
        out.towards[a] = length > 0 ? given[a] / length : view->eye[a];
    int least = 0; /* the axis that is least along the light */
    for (int a = 1; a < 3; a++)
        least = fabs(out.towards[a]) < fabs(out.towards[least]) ? a : least;
    const double along = out.towards[least], root = sqrt(1 - along * along);
    for (int a = 0; a < 3; a++)
        out.across[0][a] = ((a == least) - along * out.towards[a]) / root;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        out.across[1][a] = out.towards[b] * out.across[0][c] - out.towards[c] * out.across[0][b];
    }
    return out;
}

static double wrapped(double value)
{
    return value - floor(value);
}

static void place(double out[3], const cvol_directions *of, double cosine, double turn)
{
    const double sine = sqrt(fmax(1 - cosine * cosine, 0));
    for (int a = 0; a < 3; a++)
        out[a] = cosine * of->towards[a] +
                 sine * (cos(turn) * of->across[0][a] + sin(turn) * of->across[1][a]);
}

void cvol_direction_to_disc(double out[3], const cvol_directions *of, int i, const double shift[2])
{
    const double share = wrapped((i + 0.5) / of->disc + shift[0]);
    place(out, of, 1 - share * (1 - DISC_COSINE), TURN * wrapped(i * GOLDEN + shift[1]));
}

/* The share of the sky with cosines up to c is (1 + c)^2 / 4. */
void cvol_direction_to_sky(double out[3], const cvol_directions *of, int i, const double shift[2])
{
    const double share = wrapped((i + 0.5) / of->sky + shift[0]);
    place(out, of, 2 * sqrt(share) - 1, TURN * wrapped(i * GOLDEN + shift[1]));
}
