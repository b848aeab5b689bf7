/* Common code of the algebra's bench programs: the clock, random numbers, rounds of times, JSON. */
#ifndef BENCH_ALGEBRA_TIMING_H
#define BENCH_ALGEBRA_TIMING_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Processor time of this process, which uses one thread: other work on the machine does not count,
 * except by its use of caches and memory bandwidth. */
double bench_seconds(void);

/* -1 .. 1 from splitmix64 (Steele, Lea and Flood 2014); *state is the seed. */
double bench_random(uint64_t *state);

/* Prints the message and exits with 1. */
void bench_fail(const char *format, ...) __attribute__((format(printf, 1, 2), noreturn));
/* The same with the context's message unless status is 0. */
void bench_check(const cvol_context *context, int status, const char *what);
/* Zeroed memory, 64-byte aligned, every page of it touched; exits if there is none. */
void *bench_allocate(size_t bytes);

/* Times of one function, in milliseconds, one per round. */
enum { BENCH_ROUNDS = 64 };
typedef struct bench_times {
    double ms[BENCH_ROUNDS];
    int count;
    int batch; /* number of calls averaged in one time; 0: not chosen yet */
} bench_times;

/* Runs call(user, turn) `batch` times with increasing turns and adds the mean to `times`. The first
 * call chooses the batch, so that it takes 2 ms or more, and adds nothing. */
void bench_time(bench_times *times, void (*call)(void *user, int turn), void *user);

/* ,"name":[...] on standard output. */
void bench_print_times(const char *name, const bench_times *times);

#ifdef __cplusplus
}
#endif
#endif
