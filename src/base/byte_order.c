/* The machine's byte order, and conversion to the other one. */
#include "base/byte_order.h"

#include <string.h>

int cvol_machine_is_big_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 0;
}

void cvol_swap_bytes(void *data, size_t count, size_t size)
{
    uint8_t *bytes = data;
    for (size_t i = 0; i < count && size == 2; i++) {
        uint16_t v;
        memcpy(&v, bytes + 2 * i, 2);
        v = __builtin_bswap16(v);
        memcpy(bytes + 2 * i, &v, 2);
    }
    for (size_t i = 0; i < count && size == 4; i++) {
        uint32_t v;
        memcpy(&v, bytes + 4 * i, 4);
        v = __builtin_bswap32(v);
        memcpy(bytes + 4 * i, &v, 4);
    }
    for (size_t i = 0; i < count && size == 8; i++) {
        uint64_t v;
        memcpy(&v, bytes + 8 * i, 8);
        v = __builtin_bswap64(v);
        memcpy(bytes + 8 * i, &v, 8);
    }
}

uint32_t cvol_high_first(const uint8_t bytes[4])
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}
