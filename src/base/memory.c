/* Aligned allocation. */
#include "base/memory.h"

#include <stdint.h>
#include <string.h>

void *cvol_allocate(size_t count, size_t size)
{
    size_t bytes;
    if (!cvol_size_multiply(&bytes, count, size) || bytes > (size_t)PTRDIFF_MAX - CVOL_ALIGNMENT)
        return NULL;
    bytes = (bytes + CVOL_ALIGNMENT - 1) / CVOL_ALIGNMENT * CVOL_ALIGNMENT;
    return aligned_alloc(CVOL_ALIGNMENT, bytes ? bytes : CVOL_ALIGNMENT);
}

void *cvol_allocate_zero(size_t count, size_t size)
{
    void *memory = cvol_allocate(count, size);
    if (memory)
        memset(memory, 0, count * size);
    return memory;
}
