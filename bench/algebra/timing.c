/* Clock, random numbers, rounds of times. */
#define _POSIX_C_SOURCE 200809L
#include "timing.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double BATCH_SECONDS = 2e-3;
enum { MAX_BATCH = 1 << 16 };

double bench_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double bench_random(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return (double)(int64_t)(z ^ z >> 31) / 9223372036854775808.0;
}

void bench_fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    exit(1);
}

void bench_check(const cvol_context *context, int status, const char *what)
{
    if (status)
        bench_fail("%s: %s", what, cvol_context_message(context));
}

void *bench_allocate(size_t bytes)
{
    const size_t rounded = (bytes / 64 + 1) * 64;
    void *memory = aligned_alloc(64, rounded);
    if (!memory)
        bench_fail("no memory for %zu bytes", bytes);
    return memset(memory, 0, rounded);
}

void bench_time(bench_times *times, void (*call)(void *user, int turn), void *user)
{
    if (!times->batch) {
        times->batch = 1;
        for (;;) {
            const double start = bench_seconds();
            for (int i = 0; i < times->batch; i++)
                call(user, i);
            if (bench_seconds() - start >= BATCH_SECONDS || times->batch >= MAX_BATCH)
                return;
            times->batch *= 2;
        }
    }
    if (times->count == BENCH_ROUNDS)
        bench_fail("more than %d rounds", BENCH_ROUNDS);
    const int first = times->count * times->batch;
    const double start = bench_seconds();
    for (int i = 0; i < times->batch; i++)
        call(user, first + i);
    times->ms[times->count++] = 1e3 * (bench_seconds() - start) / times->batch;
}

void bench_print_times(const char *name, const bench_times *times)
{
    printf(",\"%s\":[", name);
    for (int i = 0; i < times->count; i++)
        printf("%s%.6g", i ? "," : "", times->ms[i]);
    printf("]");
}
