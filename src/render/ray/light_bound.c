/* Bounds of light (light_bound.h).
 *
 * Each component of the gradient is a sum of samples whose weights have absolute values that add up
 * to `reach` (cvol_ray_gradient). So the other volume's gradient g' differs from g by a vector d
 * with |d_a| <= reach_a error, |d| <= D. If D < |g|, the angle between g' and g is at most
 *
 *     t = asin(D / |g|)
 *
 * because g' lies in the ball of radius D about g. An angle p to a fixed direction becomes p - t to
 * p + t, and cosines fall from 0 to pi. The normal n is g' or -g', the one whose angle to the eye
 * is at most pi / 2: both, if the angles p - t to p + t to the eye have pi / 2 between them.
 *
 * Where seen = n e may be below CVOL_EDGE_ON, n l lies between that and seen l e (cvol_light_turn).
 *
 * With lit = n l and seen >= 0, the factor rises with lit. So does 2 lit seen - l e, and with
 * seen where lit > 0; the gloss rises with it, and is 0 where lit <= 0. If D >= |g|, every normal
 * with seen >= 0 is possible. The density rises with |g'|, from |g| - D to |g| + D.
 *
 * Both cosines move towards those of a normal to the eye, by the flatness q / (|g'|^2 + q) of what
 * lies between them. q, the square of cvol_flat_gradient, depends on the range of the other
 * volume's samples, so it has bounds; the flatness rises with it. c + f (flat - c) rises with c, as
 * f <= 1; its ends are those of c with the least or the largest f, by the sign of flat - c.
 *
 * Rounding: acos and asin have errors of up to 2^-25 near 1, so t is 2^-24 larger; cosines get a
 * slack of 2^-30. */
#include "render/ray/light_bound.h"

#include <math.h>

#include "render/view/light.h"

#define ANGLE_ROUNDING 0x1p-24
#define ROUNDING 0x1p-30

typedef struct span {
    double lo, hi;
} span;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The angle of two vectors, one of length 1 and one of length `length`. */
static double angle_of(const double a[3], const double b[3], double length)
{
    return acos(fmax(-1, fmin(1, dot(a, b) / length)));
}

/* Bounds of the cosine of an angle at most `turn` from this one. */
static span cosine(double angle, double turn)
{
    const double least = fmax(angle - turn, 0), most = fmin(angle + turn, acos(-1));
    return (span){fmax(cos(most) - ROUNDING, -1), fmin(cos(least) + ROUNDING, 1)};
}

static span negated(span a)
{
    return (span){-a.hi, -a.lo};
}

static span hull(span a, span b)
{
    return (span){fmin(a.lo, b.lo), fmax(a.hi, b.hi)};
}

/* Normals that are the gradient, and those that are its opposite, as far as they exist. */
static void find_cosines(span *lit, span *seen, const cvol_ray_light *light, const double g[3],
                         double steepness, double turn)
{
    const span to_light = cosine(angle_of(light->shading.light, g, steepness), turn);
    const span to_eye = cosine(angle_of(light->eye, g, steepness), turn);
    const int may_stay = to_eye.hi >= 0, may_turn = to_eye.lo <= 0;
    const span turned = negated(to_light);
    *lit = may_stay && may_turn ? hull(to_light, turned) : may_stay ? to_light : turned;
    *seen = may_stay && may_turn ? hull(to_eye, negated(to_eye))
            : may_stay           ? to_eye
                                 : negated(to_eye);
    seen->lo = fmax(seen->lo, 0);
    if (seen->lo < CVOL_EDGE_ON + ROUNDING) {
        const double facing = dot(light->shading.light, light->eye),
                     edge = fmin(seen->hi, CVOL_EDGE_ON + ROUNDING);
        *lit = hull(*lit, (span){fmin(seen->lo * facing, edge * facing) - ROUNDING,
                                 fmax(seen->lo * facing, edge * facing) + ROUNDING});
    }
}

/* Bounds of c + f (flat - c) for a cosine c and a flatness f within these bounds. */
static span moved_to(span cosine, double flat, span flatness)
{
    const double lo = flat - cosine.lo, hi = flat - cosine.hi;
    return (span){cosine.lo + (lo > 0 ? flatness.lo : flatness.hi) * lo - ROUNDING,
                  cosine.hi + (hi > 0 ? flatness.hi : flatness.lo) * hi + ROUNDING};
}

/* The gloss for one pair of cosines, with lit > 0. */
static double gloss_of(const cvol_shading *shading, double lit, double seen, double between)
{
    return shading->specular * pow(fmin(fmax(2 * lit * seen - between, 0), 1), shading->shininess);
}

cvol_ray_lit_range cvol_ray_light_bound(const cvol_ray_light *light, const cvol_ray_reader *reader,
                                        const double place[3], double value, double error)
{
    const cvol_shading *shading = &light->shading;
    double g[3], reach[3];
    cvol_ray_gradient(g, reach, light, reader, place, value);
    const double steepness = sqrt(dot(g, g)), moved = error * sqrt(dot(reach, reach)) * (1 + 1e-9);
    const double least = fmax(steepness * (1 - 1e-9) - moved, 0),
                 most = steepness * (1 + 1e-9) + moved;
    span lit = {-1, 1}, seen = {0, 1};
    if (least > 0)
        find_cosines(&lit, &seen, light, g, steepness,
                     asin(fmin(moved / steepness, 1)) + ANGLE_ROUNDING);
    const double between = dot(shading->light, light->eye);
    const double flats[2] = {light->flats[0] * light->flats[0], light->flats[1] * light->flats[1]};
    const span flatness = {(flats[0] > 0 ? flats[0] / (most * most + flats[0]) : 0) - ROUNDING,
                           (flats[1] > 0 ? flats[1] / (least * least + flats[1]) : 0) + ROUNDING};
    lit = moved_to(lit, between, flatness);
    seen = moved_to(seen, 1, flatness);
    const double limit = shading->gradient_opacity;
    return (cvol_ray_lit_range){
        .lo = {shading->ambient + shading->diffuse * fmax(lit.lo, 0) + light->fill * seen.lo,
               lit.lo > 0 ? gloss_of(shading, lit.lo, seen.lo, between + ROUNDING) : 0,
               limit > 0 ? fmin(least / limit, 1) : 1},
        .hi = {shading->ambient + shading->diffuse * fmax(lit.hi, 0) +
                   light->fill * fmin(seen.hi, 1),
               lit.hi >= 0 ? gloss_of(shading, lit.hi, seen.hi, between - ROUNDING) : 0,
               limit > 0 ? fmin(most / limit * (1 + 1e-12), 1) : 1}};
}
