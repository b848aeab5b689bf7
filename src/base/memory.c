/* Aligned allocation. */
#if defined(__linux__)
#define _DEFAULT_SOURCE /* madvise */
#endif
#include "base/memory.h"

#include <stdint.h>
#include <string.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

/* Memory of at least LARGE bytes uses pages of HUGE_PAGE: volumes are read in columns of short
 * rows, and each row would need a separate address translation. */
enum { LARGE = 8 << 20, HUGE_PAGE = 2 << 20 };

static void prefer_huge_pages(void *memory, size_t bytes)
{
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    const uintptr_t begin = ((uintptr_t)memory + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
    const uintptr_t end = ((uintptr_t)memory + bytes) / HUGE_PAGE * HUGE_PAGE;
    if (bytes >= LARGE && begin < end)
        (void)!madvise((char *)memory + (begin - (uintptr_t)memory), end - begin, MADV_HUGEPAGE);
#else
    (void)memory;
    (void)bytes;
#endif
}

void *cvol_allocate(size_t count, size_t size)
{
    size_t bytes;
    if (!cvol_size_multiply(&bytes, count, size) || bytes > (size_t)PTRDIFF_MAX - CVOL_ALIGNMENT)
        return NULL;
    bytes = (bytes + CVOL_ALIGNMENT - 1) / CVOL_ALIGNMENT * CVOL_ALIGNMENT;
    void *memory = aligned_alloc(CVOL_ALIGNMENT, bytes ? bytes : CVOL_ALIGNMENT);
    if (memory)
        prefer_huge_pages(memory, bytes);
    return memory;
}

void *cvol_allocate_zero(size_t count, size_t size)
{
    void *memory = cvol_allocate(count, size);
    if (memory)
        memset(memory, 0, count * size);
    return memory;
}

/* New memory is zero, so that samples that are loaded with weight 0 are valid numbers. */
int cvol_ensure(void *memory_pointer, size_t *capacity, size_t count, size_t size)
{
    void **memory = memory_pointer;
    if (count <= *capacity)
        return 1;
    free(*memory);
    *capacity = 0;
    *memory = cvol_allocate_zero(count, size);
    if (!*memory)
        return 0;
    *capacity = count;
    return 1;
}
