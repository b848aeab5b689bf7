/* CRC-32C, eight bytes at a time through eight tables (Kounavis and Berry, "slicing by 8"). */
#include <pthread.h>

#include "base/bytes.h"

#define POLYNOMIAL UINT32_C(0x82F63B78)

/* table[t][b]: the CRC of byte b followed by t zero bytes. Filled once, then read only. */
static uint32_t table[8][256];
static pthread_once_t table_once = PTHREAD_ONCE_INIT;

static void fill_table(void)
{
    for (uint32_t b = 0; b < 256; b++) {
        uint32_t crc = b;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? POLYNOMIAL : 0);
        table[0][b] = crc;
    }
    for (int t = 1; t < 8; t++)
        for (int b = 0; b < 256; b++)
            table[t][b] = table[t - 1][b] >> 8 ^ table[0][table[t - 1][b] & 255];
}

uint32_t cvol_crc32c(const void *data, size_t size)
{
    return cvol_crc32c_more(0, data, size);
}

uint32_t cvol_crc32c_more(uint32_t crc, const void *data, size_t size)
{
    pthread_once(&table_once, fill_table);
    const uint8_t *p = data;
    crc = ~crc;
    for (; size >= 8; size -= 8, p += 8)
        crc = table[7][(crc ^ p[0]) & 255] ^ table[6][(crc >> 8 ^ p[1]) & 255] ^
              table[5][(crc >> 16 ^ p[2]) & 255] ^ table[4][(crc >> 24 ^ p[3]) & 255] ^
              table[3][p[4]] ^ table[2][p[5]] ^ table[1][p[6]] ^ table[0][p[7]];
    for (; size > 0; size--, p++)
        crc = crc >> 8 ^ table[0][(crc ^ *p) & 255];
    return ~crc;
}
