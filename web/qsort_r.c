/* qsort_r as heapsort: equal elements may change their order. */
#include "qsort_r.h"

#include <stdint.h>

static void swap(uint8_t *a, uint8_t *b, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        const uint8_t kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

/* Moves element `at` down until no child of it in the first `count` elements is larger. */
static void sift(uint8_t *base, size_t at, size_t count, size_t size,
                 int (*compare)(const void *a, const void *b, void *user), void *user)
{
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        uint8_t *larger = base + child * size;
        if (child + 1 < count && compare(larger, larger + size, user) < 0) {
            child++;
            larger += size;
        }
        if (compare(base + at * size, larger, user) >= 0)
            return;
        swap(base + at * size, larger, size);
    }
}

void qsort_r(void *base, size_t count, size_t size,
             int (*compare)(const void *a, const void *b, void *user), void *user)
{
    for (size_t at = count / 2; at-- > 0;)
        sift(base, at, count, size, compare, user);
    for (size_t end = count; end > 1; end--) {
        swap(base, (uint8_t *)base + (end - 1) * size, size);
        sift(base, 0, end - 1, size, compare, user);
    }
}
