/* poke FILE [OFFSET KIND VALUE]...: overwrites bytes of a file. KIND is u8, i16, i32, i64, f32, f64
 * (low byte first), or xor, which flips the bits of VALUE in one byte. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t encode(unsigned char bytes[8], const char *kind, const char *value)
{
    uint64_t bits = (uint64_t)strtoll(value, NULL, 10);
    const double real = strtod(value, NULL);
    const float single = (float)real;
    uint32_t single_bits;
    size_t size = 0;
    if (!strcmp(kind, "f64")) {
        memcpy(&bits, &real, 8);
        size = 8;
    } else if (!strcmp(kind, "f32")) {
        memcpy(&single_bits, &single, 4);
        bits = single_bits;
        size = 4;
    } else if (!strcmp(kind, "u8") || !strcmp(kind, "i16") || !strcmp(kind, "i32") ||
               !strcmp(kind, "i64"))
        size = strtoul(kind + 1, NULL, 10) / 8;
    for (size_t i = 0; i < size; i++)
        bytes[i] = (unsigned char)(bits >> 8 * i);
    return size;
}

static int poke(FILE *file, long offset, const char *kind, const char *value)
{
    unsigned char bytes[8];
    size_t size = encode(bytes, kind, value);
    if (fseek(file, offset, SEEK_SET))
        return 0;
    if (!strcmp(kind, "xor")) {
        int old = fgetc(file);
        if (old == EOF || fseek(file, offset, SEEK_SET))
            return 0;
        bytes[0] = (unsigned char)(old ^ atoi(value));
        size = 1;
    }
    return size > 0 && fwrite(bytes, size, 1, file) == 1;
}

int main(int argc, char **argv)
{
    if (argc < 5 || argc % 3 != 2) {
        fputs("usage: poke FILE OFFSET KIND VALUE ...\n", stderr);
        return 2;
    }
    FILE *file = fopen(argv[1], "r+b");
    int done = file != NULL;
    for (int i = 2; done && i < argc; i += 3)
        done = poke(file, strtol(argv[i], NULL, 10), argv[i + 1], argv[i + 2]);
    if (file && fclose(file))
        done = 0;
    if (!done)
        fprintf(stderr, "poke: %s cannot be changed so\n", argv[1]);
    return !done;
}
