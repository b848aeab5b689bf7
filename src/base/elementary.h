/* Elementary functions with the same results on every processor and with every C library.
 *
 * C libraries differ in the last bit of sin, exp, log and pow, and so does one library by
 * processor. What decides the bytes of a file or the samples that it decodes to uses these instead.
 * They need IEEE 754's operations and rint, ldexp and frexp only, which are exact. Their errors are
 * below 0.5001 units of the last place: they round as exact results do, except rarely
 * (tests/base/test_elementary.c). Special values are those of C11. */
#ifndef CVOL_BASE_ELEMENTARY_H
#define CVOL_BASE_ELEMENTARY_H

/* |x| up to 2^20; beyond, the nearest multiple of pi / 2 is known less well. */
double cvol_sin(double x);
double cvol_cos(double x);

/* out: cos x and sin x, several times faster; within 3.5 units of the last place: both subtractions
 * of the reduction round, and next to a power of 2 their units are twice those of the result. */
void cvol_sincos(double out[2], double x);

double cvol_exp(double x);
double cvol_log(double x);
double cvol_log2(double x);
double cvol_log10(double x);

/* x >= 0 */
double cvol_pow(double x, double y);

/* (a^2 + b^2)^1/2 */
double cvol_hypot(double a, double b);

/* Faster, from doubles. */
float cvol_exp2f(float x);
float cvol_log2f(float x);

#endif
