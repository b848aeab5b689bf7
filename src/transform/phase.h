/* Phases: fractions of a turn as two words, in units of 2^-128. Arithmetic modulo 2^128 is
 * arithmetic modulo one turn, so that the phase of a product of large integers keeps its precision.
 */
#ifndef CVOL_TRANSFORM_PHASE_H
#define CVOL_TRANSFORM_PHASE_H

#include <math.h>
#include <stdint.h>

typedef struct cvol_phase {
    uint64_t high, low;
} cvol_phase;

static inline cvol_phase cvol_phase_negate(cvol_phase p)
{
    return (cvol_phase){~p.high + !p.low, ~p.low + 1};
}

static inline cvol_phase cvol_phase_add(cvol_phase a, cvol_phase b)
{
    const uint64_t low = a.low + b.low;
    return (cvol_phase){a.high + b.high + (low < a.low), low};
}

static inline cvol_phase cvol_phase_multiply(cvol_phase p, int64_t factor)
{
    if (factor < 0)
        p = cvol_phase_negate(p);
    const uint64_t times = factor < 0 ? -(uint64_t)factor : (uint64_t)factor;
    const uint64_t a = p.low >> 32, b = p.low & 0xffffffff;
    const uint64_t c = times >> 32, d = times & 0xffffffff;
    const uint64_t middle = a * d + (b * d >> 32), more = b * c + (middle & 0xffffffff);
    const uint64_t high = a * c + (middle >> 32) + (more >> 32);
    return (cvol_phase){p.high * times + high, p.low * times};
}

/* a / n of a turn, n > 0, rounded towards 0: one bit after the other. Every operation is exact. */
static inline cvol_phase cvol_phase_of(double a, double n)
{
    double rest = fmod(fabs(a), n);
    uint64_t words[2] = {0};
    for (int i = 0; i < 128; i++) {
        rest *= 2;
        const int bit = rest >= n;
        rest -= bit ? n : 0;
        words[i / 64] = words[i / 64] << 1 | (uint64_t)bit;
    }
    const cvol_phase phase = {words[0], words[1]};
    return a < 0 ? cvol_phase_negate(phase) : phase;
}

/* In turns, -1/2 to 1/2. */
static inline double cvol_phase_turns(cvol_phase p)
{
    return ldexp((double)(int64_t)p.high, -64);
}

#endif
