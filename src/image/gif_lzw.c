/* Lempel, Ziv and Welch's compression, as GIF 89a has it: codes of 9 to 12 bits, the lowest bit
 * first, in blocks of at most 255 bytes; when all codes are taken, a code that clears them. */
#include "image/gif_lzw.h"

#include <string.h>

#define BITS 8
#define CLEAR (1 << BITS)
#define END (CLEAR + 1)
#define CODES 4096
#define SLOTS 8192 /* of the hash table of strings: a prefix' code and a byte */

typedef struct lzw {
    cvol_bytes *out;
    uint8_t block[255];
    size_t filled;
    uint32_t bits;
    int bit_count, width, last;
    uint32_t keys[SLOTS]; /* (prefix << 8 | byte) + 1; 0: free */
    uint16_t codes[SLOTS];
} lzw;

static void flush_block(lzw *z)
{
    cvol_bytes_put_u8(z->out, (uint8_t)z->filled);
    cvol_bytes_append(z->out, z->block, z->filled);
    z->filled = 0;
}

static void put_byte(lzw *z)
{
    z->block[z->filled++] = (uint8_t)z->bits;
    z->bits >>= 8;
    z->bit_count -= 8;
    if (z->filled == sizeof z->block)
        flush_block(z);
}

static void put_code(lzw *z, int code)
{
    z->bits |= (uint32_t)code << z->bit_count;
    z->bit_count += z->width;
    while (z->bit_count >= 8)
        put_byte(z);
}

static void clear(lzw *z)
{
    put_code(z, CLEAR);
    memset(z->keys, 0, sizeof z->keys);
    z->width = BITS + 1;
    z->last = END;
}

/* The slot of a string, or where it would be. */
static size_t slot_of(const lzw *z, uint32_t key)
{
    size_t slot = key * UINT32_C(2654435761) >> 19;
    while (z->keys[slot] && z->keys[slot] != key)
        slot = (slot + 1) % SLOTS;
    return slot;
}

void cvol_gif_lzw(cvol_bytes *out, const uint8_t *indices, size_t count)
{
    lzw z = {.out = out, .width = BITS + 1};
    cvol_bytes_put_u8(out, BITS);
    clear(&z);
    int prefix = indices[0];
    for (size_t i = 1; i < count; i++) {
        const uint32_t key = ((uint32_t)prefix << 8 | indices[i]) + 1;
        const size_t slot = slot_of(&z, key);
        if (z.keys[slot]) {
            prefix = z.codes[slot];
            continue;
        }
        put_code(&z, prefix);
        z.keys[slot] = key;
        z.codes[slot] = (uint16_t)++z.last;
        if (z.last >= 1 << z.width)
            z.width++;
        if (z.last == CODES - 1)
            clear(&z);
        prefix = indices[i];
    }
    put_code(&z, prefix);
    put_code(&z, END);
    while (z.bit_count > 0)
        put_byte(&z);
    if (z.filled)
        flush_block(&z);
    cvol_bytes_put_u8(out, 0);
}
