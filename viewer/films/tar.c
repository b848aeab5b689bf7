/* TAR archives: for each file a header of 512 bytes, then its bytes, padded to 512. */
#include "viewer/films/tar.h"

#include <string.h>

enum { BLOCK = 512 };

static const unsigned char zeros[2 * BLOCK];

static int put(FILE *out, const void *bytes, size_t size)
{
    return fwrite(bytes, 1, size, out) == size ? 0 : -1;
}

int tar_add(FILE *out, const char *name, const void *bytes, size_t size)
{
    unsigned char head[BLOCK] = {0};
    char *text = (char *)head;
    unsigned sum = 0;
    if (strlen(name) > 99 || size >= 1ull << 33)
        return -1;
    snprintf(text, 100, "%s", name);
    snprintf(text + 100, 8, "%07o", 0644u);
    snprintf(text + 108, 8, "%07o", 0u);
    snprintf(text + 116, 8, "%07o", 0u);
    snprintf(text + 124, 12, "%011llo", (unsigned long long)size);
    snprintf(text + 136, 12, "%011o", 0u);
    memset(text + 148, ' ', 8); /* the checksum is that of a header with spaces here */
    text[156] = '0';
    memcpy(text + 257, "ustar", 6);
    memcpy(text + 263, "00", 2);
    for (int i = 0; i < BLOCK; i++)
        sum += head[i];
    snprintf(text + 148, 8, "%06o", sum);
    const size_t rest = size % BLOCK;
    if (put(out, head, BLOCK) || put(out, bytes, size))
        return -1;
    return rest ? put(out, zeros, BLOCK - rest) : 0;
}

int tar_end(FILE *out)
{
    return put(out, zeros, 2 * BLOCK);
}
