/* Samples of any type as words of their size, to compare and copy bit patterns. */
#ifndef CVOL_ARRAY_CORE_WORDS_H
#define CVOL_ARRAY_CORE_WORDS_H

#include <stdint.h>

typedef uint8_t __attribute__((may_alias)) cvol_word8;
typedef uint16_t __attribute__((may_alias)) cvol_word16;
typedef uint32_t __attribute__((may_alias)) cvol_word32;
typedef uint64_t __attribute__((may_alias)) cvol_word64;

/* Runs CASE(word) with the type of words of `size` bytes: 1, 2, 4 or 8. */
#define CVOL_FOR_BYTES(size, CASE) \
    switch (size) {                \
    case 1:                        \
        CASE(cvol_word8);          \
        break;                     \
    case 2:                        \
        CASE(cvol_word16);         \
        break;                     \
    case 4:                        \
        CASE(cvol_word32);         \
        break;                     \
    default:                       \
        CASE(cvol_word64);         \
        break;                     \
    }

#endif
