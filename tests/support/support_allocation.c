/* malloc() and its relatives, in front of those of the C library. */
#define _GNU_SOURCE /* posix_memalign */
#include "support_allocation.h"

#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#include <errno.h>
#include <execinfo.h>
#include <malloc.h>

#define SEEN __attribute__((visibility("default"))) /* by the libraries that the program loads */

enum { FRAMES = 5, OWN_FRAMES = 2, STACKS_MAX = 1 << 14 };

static atomic_int failing; /* allocation_failure; 0: nothing fails */
static atomic_long left;   /* allocations until then */
static atomic_long live;   /* not freed */
static atomic_int is_recording;
static _Thread_local int is_inside; /* backtrace() may allocate */
static struct {
    uint64_t stacks[STACKS_MAX];
    long numbers[STACKS_MAX];
    size_t count;
    long calls;
} record;

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *memory, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void *memory);

static void record_stack(void)
{
    void *frames[FRAMES];
    uint64_t stack = 1469598103934665603u; /* FNV-1a */
    is_inside = 1;
    const int count = backtrace(frames, FRAMES);
    is_inside = 0;
    for (int i = OWN_FRAMES; i < count; i++)
        stack = (stack ^ (uint64_t)(uintptr_t)frames[i]) * 1099511628211u;
    record.calls++;
    for (size_t i = 0; i < record.count; i++)
        if (record.stacks[i] == stack)
            return;
    if (record.count == STACKS_MAX)
        abort();
    record.stacks[record.count] = stack;
    record.numbers[record.count++] = record.calls;
}

static int fails(void)
{
    const int how = atomic_load(&failing);
    if (is_inside)
        return 0;
    if (atomic_load(&is_recording))
        record_stack();
    if (!how)
        return 0;
    const long now = atomic_fetch_sub(&left, 1);
    return how == ALLOCATION_ONE ? now == 1 : now <= 1;
}

static void *counted(void *memory)
{
    if (memory)
        atomic_fetch_add(&live, 1);
    return memory;
}

SEEN void *malloc(size_t bytes)
{
    return fails() ? NULL : counted(__libc_malloc(bytes));
}

SEEN void *calloc(size_t items, size_t bytes)
{
    return fails() ? NULL : counted(__libc_calloc(items, bytes));
}

SEEN void *aligned_alloc(size_t alignment, size_t bytes)
{
    return fails() ? NULL : counted(__libc_memalign(alignment, bytes));
}

/* Only OpenMP calls these two, and ends the process if they fail. */
SEEN void *memalign(size_t alignment, size_t bytes)
{
    return counted(__libc_memalign(alignment, bytes));
}

SEEN int posix_memalign(void **memory, size_t alignment, size_t bytes)
{
    *memory = counted(__libc_memalign(alignment, bytes));
    return *memory ? 0 : ENOMEM;
}

SEEN void free(void *memory)
{
    if (memory)
        atomic_fetch_sub(&live, 1);
    __libc_free(memory);
}

SEEN void *realloc(void *memory, size_t bytes)
{
    if (memory && !bytes) {
        free(memory);
        return NULL;
    }
    if (fails())
        return NULL;
    return memory ? __libc_realloc(memory, bytes) : counted(__libc_malloc(bytes));
}

int allocation_is_replaced(void)
{
    return 1;
}

void allocation_fail(long n, allocation_failure how)
{
    atomic_store(&left, n);
    atomic_store(&failing, how);
}

int allocation_stop(void)
{
    atomic_store(&failing, 0);
    return atomic_load(&left) > 0;
}

void allocation_record(void)
{
    void *frame[1];
    (void)backtrace(frame, 1); /* loads a library at its first call */
    record.count = 0;
    record.calls = 0;
    atomic_store(&is_recording, 1);
}

size_t allocation_recorded(const long **numbers)
{
    atomic_store(&is_recording, 0);
    *numbers = record.numbers;
    return record.count;
}

long allocation_count(void)
{
    return atomic_load(&live);
}
#else
int allocation_is_replaced(void)
{
    return 0;
}

void allocation_fail(long n, allocation_failure how)
{
    (void)n;
    (void)how;
}

int allocation_stop(void)
{
    return 1;
}

void allocation_record(void)
{
}

size_t allocation_recorded(const long **numbers)
{
    *numbers = NULL;
    return 0;
}

long allocation_count(void)
{
    return 0;
}
#endif
